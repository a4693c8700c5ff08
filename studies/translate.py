#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Study of doc/materials.md: `nqm translate` against the published translation graphs of MaterialX, judged by rendering.

usage: studies/translate.py MATERIALS OUT.csv [--only-table]

MATERIALS is the folder of the examples: `definitions` with the *_to_*.mtlx graphs, and folders with .mtlx files. Every file with an
accepted material of the models open-pbr or standard-surface is translated to the three other models, by fits and by
graphs, and both are compared with the source by `nqm label` (full renderer, standard scenes). OUT.csv gets a row for each translation as it is
finished, in a random order of the materials; a second run continues it. The table is printed at the end: mean JOD of both, and the mean difference with a 95 % interval
by a bootstrap over materials (2000 draws). The tool is NQM_TOOL, default build/nqm. Python's standard library only."""
import csv
import glob
import json
import os
import random
import subprocess
import sys

TOOL = os.environ.get("NQM_TOOL", "build/nqm")
TARGETS = ("open-pbr", "standard-surface", "gltf", "usd-preview")
SOURCES = ("open-pbr", "standard-surface")
COLUMNS = ("material", "from", "to", "jod_fit", "jod_graph", "seconds")


def run(*arguments):
    """Standard output, or None when the command failed."""
    done = subprocess.run(arguments, capture_output=True, text=True, check=False)
    return done.stdout if done.returncode == 0 else None


def model_of(path):
    """Shading model of a file with one accepted material, or None."""
    text = run(TOOL, "info", path, "--json")
    return json.loads(text).get("format") if text else None


def name_of(path):
    """Folder and name: two folders have files of the same name."""
    return "/".join(path.split("/")[-2:])


def translate(definitions, path, model, target):
    text = run(TOOL, "translate", path, "--to", target, "--json")
    graph = run(sys.executable, os.path.join(os.path.dirname(__file__), "translation_graphs.py"), definitions, path, target)
    if not text or not graph:
        return None
    fit = json.loads(text)["results"][0]
    jods = run(TOOL, "label", path, fit["spec"], graph.strip(), "-q")
    if not jods:
        return None
    by_fit, by_graph = map(float, jods.split())
    return {"material": name_of(path), "from": model, "to": target, "jod_fit": by_fit, "jod_graph": by_graph,
            "seconds": round(fit["seconds"], 2)}


def make_rows(materials, out):
    done = set()
    if os.path.exists(out):
        done = {(r["material"], r["to"]) for r in csv.DictReader(open(out, encoding="utf-8"))}
    with open(out, "a", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, COLUMNS)
        if not done:
            writer.writeheader()
        paths = sorted(glob.glob(os.path.join(materials, "*", "*.mtlx")))
        random.Random(1).shuffle(paths)
        for path in paths:
            model = model_of(path)
            if model not in SOURCES:
                continue
            for target in TARGETS:
                if target == model or (name_of(path), target) in done:
                    continue
                row = translate(os.path.join(materials, "definitions"), path, model, target)
                if row:
                    writer.writerow(row)
                    stream.flush()
                else:
                    print(f"{path} to {target}: no result", file=sys.stderr)


def interval(groups):
    """95 % interval of the mean of all values, by draws of groups with replacement."""
    rng, means = random.Random(1), []
    for _ in range(2000):
        values = [v for g in rng.choices(groups, k=len(groups)) for v in g]
        means.append(sum(values) / len(values))
    means.sort()
    return means[50], means[1949]


def print_row(name, rows):
    fit = sum(float(r["jod_fit"]) for r in rows) / len(rows)
    graph = sum(float(r["jod_graph"]) for r in rows) / len(rows)
    by_material = {}
    for r in rows:
        by_material.setdefault(r["material"], []).append(float(r["jod_fit"]) - float(r["jod_graph"]))
    low, high = interval(list(by_material.values()))
    worse = sum(float(r["jod_fit"]) < float(r["jod_graph"]) - 0.005 for r in rows)
    worst_fit, worst_graph = min(float(r["jod_fit"]) for r in rows), min(float(r["jod_graph"]) for r in rows)
    print(f"| {name} | {len(rows)} | {fit:.2f} | {graph:.2f} | {fit - graph:+.2f} [{low:+.2f}, {high:+.2f}] | {worse} | "
          f"{worst_fit:.2f} | {worst_graph:.2f} |")


def print_table(out):
    rows = list(csv.DictReader(open(out, encoding="utf-8")))
    print("| translation | n | JOD, nqm | JOD, graph | difference | graph better | worst, nqm | worst, graph |")
    print("|---|---|---|---|---|---|---|---|")
    for source in SOURCES:
        for target in TARGETS:
            some = [r for r in rows if r["from"] == source and r["to"] == target]
            if some:
                print_row(f"`{source}` to `{target}`", some)
    print_row("all", rows)
    seconds = sorted(float(r["seconds"]) for r in rows)
    print(f"\nmedian time of a translation: {seconds[len(seconds) // 2]:.1f} s, longest {seconds[-1]:.1f} s")


def main():
    arguments = [a for a in sys.argv[1:] if not a.startswith("--")]
    if len(arguments) != 2:
        sys.exit(__doc__)
    if "--only-table" not in sys.argv:
        make_rows(*arguments)
    print_table(arguments[1])


if __name__ == "__main__":
    main()
