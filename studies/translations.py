#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Make doc/translations.md: what translations of materials between renderers cost, and what approximations cost, judged by rendering.

usage: studies/translations.py MATERIALS OUT.csv [--only-page]

MATERIALS is the folder of the examples: `definitions` with MaterialX's graphs, `openpbr` and `materialx` with .mtlx files, and
`physicallybased` with the published exports of physicallybased.info. OUT.csv gets a row for each pair as it is judged, by `nqm label` (standard
scenes), approximations by `nqm score`; a second run continues it. Kinds of rows: `nqm` (nqm translate), `graph` (MaterialX's translation graphs), `export` (a published file
beside the published OpenPBR file), and approximations, which change keys of OpenPBR. The page is written at the end. The tool is
NQM_TOOL, default build/nqm. Python's standard library only."""
import csv
import glob
import json
import os
import statistics
import subprocess
import sys

from translate import TOOL, interval, name_of, run

TARGETS = ("gltf", "standard-surface", "usd-preview", "principled")
GRAPHS = ("gltf", "standard-surface", "usd-preview")
PAGE = os.path.join(os.path.dirname(__file__), "../doc/translations.md")
IGNORED = "--ignore=transmission,subsurface,emission,opacity"

# What renderers leave out: what a material is given to have it, the keys of OpenPBR that leave it out, and of which materials.
APPROXIMATIONS = {
    "the thin film, where there is one": ({}, {"thin_film_weight": "0"}, lambda v: v["thin_film_weight"] > 0),
    "the colour of metals at grazing angles (edge tint)": ({}, {"specular_color": "1"}, lambda v: v["base_metalness"] > 0),
    "the index of refraction (1.5 instead)": ({}, {"specular_ior": "1.5"}, lambda v: v["base_metalness"] < 1),
    "Oren and Nayar's roughness of 1 (Lambert)": ({"base_diffuse_roughness": "1"}, {"base_diffuse_roughness": "0"},
                                                  lambda v: v["base_metalness"] < 1 and v["base_weight"] > 0),
    "a fuzz of weight .5": ({"fuzz_weight": "0.5"}, {"fuzz_weight": "0"}, lambda v: True),
    "the darkening below a clear coat": ({"coat_weight": "1"}, {"coat_darkening": "0"}, lambda v: True),
    "a clear coat": ({"coat_weight": "1"}, {"coat_weight": "0"}, lambda v: True),
    "an anisotropy of .5": ({"specular_roughness_anisotropy": "0.5"}, {"specular_roughness_anisotropy": "0"},
                            lambda v: v["specular_roughness"] >= 0.2),
}


# ---- pairs ----------------------------------------------------------------------------------------------------------


def spec_of(argument):
    text = run(TOOL, "info", argument, "--json", IGNORED)
    return json.loads(text).get("spec") if text else None


def keys_of(spec):
    """Values of the keys, the first one of a colour."""
    return {k: float(v.split(",")[0]) for k, v in (s.split("=") for s in spec.split(":", 1)[1].split(";"))}


def changed(spec, changes):
    name, settings = spec.split(":", 1)
    keys = dict(s.split("=") for s in settings.split(";"))
    return name + ":" + ";".join(f"{k}={changes.get(k, v)}" for k, v in keys.items())


def translated(spec, target):
    text = run(TOOL, "translate", spec, "--to", target, "--json")
    return json.loads(text)["results"][0]["spec"] if text else None


def by_graph(definitions, spec, target):
    text = run(sys.executable, os.path.join(os.path.dirname(__file__), "translation_graphs.py"), definitions, spec, target)
    return text.strip() if text else None


def sources(materials):
    """{name: canonical spec} of presets and examples that are OpenPBR."""
    names = [(p, p) for p in run(TOOL, "info", "list", "physical:").split()]
    names += [(name_of(p), p) for p in sorted(glob.glob(os.path.join(materials, "openpbr", "*.mtlx")))]
    specs = {name: spec_of(argument) for name, argument in names}
    return {name: spec for name, spec in specs.items() if spec and spec.startswith("open-pbr:")}


def pairs(materials):
    """(material, kind, target, reference, function that makes the test)"""
    definitions, folder = os.path.join(materials, "definitions"), os.path.join(materials, "physicallybased")
    specs = sources(materials)
    for reference in sorted(glob.glob(os.path.join(folder, "PB_OPBR_*.mtlx"))):
        for target, letters in (("gltf", "GLTF"), ("standard-surface", "SS")):
            test = reference.replace("PB_OPBR_", f"PB_{letters}_")
            name = os.path.basename(reference)[len("PB_OPBR_"):-len(".mtlx")]
            yield name, "export", target, spec_of(reference), lambda t=test: spec_of(t)
    for name, spec in specs.items():
        for what, (added, removed, matters) in APPROXIMATIONS.items():
            if name.startswith("physical:") and matters(keys_of(spec)):
                reference = changed(spec, added)
                yield name, what, "open-pbr", reference, lambda s=reference, c=removed: changed(s, c)
    for target in TARGETS:
        for name, spec in specs.items():
            yield name, "nqm", target, spec, lambda s=spec, t=target: translated(s, t)
            if target in GRAPHS:
                yield name, "graph", target, spec, lambda s=spec, t=target: by_graph(definitions, s, t)


COLUMNS = ("material", "kind", "target", "jod", "delta_e", "words", "reference", "test")


def judge(kind, reference, test):
    if reference == test:
        return {"jod": 10, "delta_e": 0, "words": ""}
    text = run(TOOL, "score" if kind in APPROXIMATIONS else "label", reference, test, "--json")
    if not text:
        return None
    result = json.loads(text)["results"][0]
    return {"jod": round(result["jod"], 3), "delta_e": round(result["delta_e_itp"], 3), "words": result["parts"]["words"]}


def make_rows(materials, out):
    done = set()
    if os.path.exists(out):
        done = {(r["material"], r["kind"], r["target"]) for r in csv.DictReader(open(out, encoding="utf-8"))}
    with open(out, "a", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, COLUMNS)
        if not done:
            writer.writeheader()
        for material, kind, target, reference, make in pairs(materials):
            if (material, kind, target) in done:
                continue
            test = make() if reference else None
            row = judge(kind, reference, test) if test else None
            if row:
                writer.writerow({"material": material, "kind": kind, "target": target, **row, "reference": reference, "test": test})
                stream.flush()
            else:
                print(f"{material} {kind} {target}: no result", file=sys.stderr)


# ---- page -----------------------------------------------------------------------------------------------------------


def summary(rows):
    """n, median, mean with its interval over materials, share below 9, and the worst three."""
    jods = sorted((r["jod"], r["material"]) for r in rows)
    values = [j for j, _ in jods]
    low, high = interval([[v] for v in values])
    worst = ", ".join(f"{name} {jod:.2f}" for jod, name in jods[:3] if jod < 9.95)
    below = 100 * sum(v < 9 for v in values) / len(values)
    return (f"{len(values)} | {statistics.median(values):.2f} | {statistics.mean(values):.2f} [{low:.2f}, {high:.2f}] | {below:.0f} % | "
            f"{worst or '-'}")


HEAD = "| n | median | mean [95 %] | below 9 | worst |\n"
RULE = "|---|---|---|---|---|---|\n"


def table(title, groups):
    return title + HEAD + RULE + "".join(f"| {name} | {summary(rows)} |\n" for name, rows in groups if rows)


def page(rows):
    def some(kind, target=None):
        return [r for r in rows if r["kind"] == kind and target in (None, r["target"])]

    exports = [(f"to `{t}`", some("export", t)) for t in GRAPHS[:2]]
    translations = [(f"to `{t}`, {'`nqm translate`' if k == 'nqm' else 'graph'}", some(k, t)) for t in TARGETS for k in ("nqm", "graph")]
    approximations = sorted(((name, some(name)) for name in APPROXIMATIONS), key=lambda g: statistics.mean([r["jod"] for r in g[1]] or [10]))
    wrong = sorted((r for r in rows if r["kind"] == "export" and r["jod"] < 9), key=lambda r: r["jod"])
    text = open(PAGE, encoding="utf-8").read() if os.path.exists(PAGE) else ""
    parts = {"translations": table("| from OpenPBR ", translations), "exports": table("| published export ", exports),
             "approximations": table("| left out ", approximations),
             "wrong": "| export | JOD | it looks |\n|---|---|---|\n" +
                      "".join(f"| {r['material']} to `{r['target']}` | {r['jod']:.2f} | {r['words']} |\n" for r in wrong)}
    for name, part in parts.items():
        begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
        before, _, rest = text.partition(begin)
        _, _, after = rest.partition(end)
        text = before + begin + part + end + after
    return text


def main():
    arguments = [a for a in sys.argv[1:] if not a.startswith("--")]
    if len(arguments) != 2:
        sys.exit(__doc__)
    if "--only-page" not in sys.argv:
        make_rows(*arguments)
    rows = [{**r, "jod": float(r["jod"])} for r in csv.DictReader(open(arguments[1], encoding="utf-8"))]
    with open(PAGE + ".new", "w", encoding="utf-8") as stream:
        stream.write(page(rows))
    os.replace(PAGE + ".new", PAGE)


if __name__ == "__main__":
    main()
