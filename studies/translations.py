#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Make the tables of doc/translations.md: what translations of materials between renderers cost, and what approximations cost.

usage: studies/translations.py MATERIALS OUT.csv [--only-page]

MATERIALS is the folder of the examples: `definitions` with MaterialX's graphs, `openpbr` and `materialx` with .mtlx files, and
`physicallybased` with the published exports of physicallybased.info. OUT.csv gets a row for each pair as it is judged; a second run
continues it. Kinds of rows: `export` (a published file beside the published OpenPBR file), `nqm` (nqm translate), `graph` (MaterialX's
translation graphs), and approximations. All pairs are judged by `nqm score`; exports, translations that score below 9 and a tenth of the
others, by a hash of their names, also by `nqm label` (standard scenes). The tables are written at the end, and doc/gallery/translations.png.
The tool is NQM_TOOL, default build/nqm. Python's standard library only."""
import collections
import csv
import glob
import itertools
import json
import os
import statistics
import subprocess
import sys
import zlib

from translate import TOOL, interval, name_of, run

GRAPHS = {"open-pbr": ("gltf", "standard-surface", "usd-preview"), "standard-surface": ("open-pbr", "gltf", "usd-preview")}
ALL = ("open-pbr", "standard-surface", "gltf", "usd-preview", "disney", "principled", "blender")
METALS, PLASTICS = ("rough-conductor", "pbrt-conductor"), ("rough-plastic",)
METALNESS = {"open-pbr": "base_metalness", "standard-surface": "metalness"}  # "metallic" in the others
FOLDER = os.path.dirname(os.path.abspath(__file__))
PAGE = os.path.join(FOLDER, "../doc/translations.md")
PICTURE = os.path.join(FOLDER, "../doc/gallery/translations.png")
IGNORED = "--ignore=transmission,subsurface,emission,opacity"
CHUNK = 12  # pairs judged together: what an interrupted run makes again

Pair = collections.namedtuple("Pair", "material kind source target reference make")

# ---- specs ----------------------------------------------------------------------------------------------------------


def spec_of(argument):
    text = run(TOOL, "info", argument, "--json", IGNORED)
    return json.loads(text).get("spec") if text else None


def settings_of(spec):
    return dict(s.split("=") for s in spec.split(":", 1)[1].split(";"))


def keys_of(spec):
    """Values of the keys, the first one of a colour."""
    return {k: float(v.split(",")[0]) for k, v in settings_of(spec).items()}


def changed(spec, changes):
    return spec.split(":", 1)[0] + ":" + ";".join(f"{k}={changes.get(k, v)}" for k, v in settings_of(spec).items())


def by_graph(definitions, spec, target):
    text = run(sys.executable, os.path.join(FOLDER, "translation_graphs.py"), definitions, spec, target)
    return text.strip() if text else None


def metalness(spec):
    return keys_of(spec)[METALNESS.get(spec.split(":")[0], "metallic")]


# ---- what renderers leave out ---------------------------------------------------------------------------------------


def keys(matters, added, removed):
    """An approximation of OpenPBR by its keys: which materials, what they are given to have it, and what leaves it out."""
    return lambda spec: (changed(spec, added), changed(spec, added | removed)) if matters(keys_of(spec)) else None


def compensation(roughness, blender=False):
    """A metal of this roughness, with Schlick's curve. OpenPBR's and glTF's differ in the compensation only, as Blender's do by a key."""
    def pair(spec):
        color = ",".join(str(min(float(v), 1)) for v in settings_of(spec)["base_color"].split(","))
        metal = f"base_color={color};metallic=1;roughness={roughness}"
        if keys_of(spec)["base_metalness"] != 1:
            return None
        if blender:
            return f"blender-principled:{metal}", f"blender-principled:{metal};multiscatter=0"
        return f"open-pbr:base_color={color};base_metalness=1;specular_color=1;specular_roughness={roughness}", f"gltf:{metal}"
    return pair


APPROXIMATIONS = {
    "the thin film, where there is one": keys(lambda v: v["thin_film_weight"] > 0, {}, {"thin_film_weight": "0"}),
    "the colour of metals at grazing angles (edge tint)": keys(lambda v: v["base_metalness"] > 0, {}, {"specular_color": "1"}),
    "the index of refraction (1.5 instead)": keys(lambda v: v["base_metalness"] < 1, {}, {"specular_ior": "1.5"}),
    "Oren and Nayar's roughness of 1 (Lambert)": keys(lambda v: v["base_metalness"] < 1 and v["base_weight"] > 0,
                                                      {"base_diffuse_roughness": "1"}, {"base_diffuse_roughness": "0"}),
    "a fuzz of weight .5": keys(lambda v: True, {"fuzz_weight": "0.5"}, {"fuzz_weight": "0"}),
    "the darkening below a clear coat": keys(lambda v: True, {"coat_weight": "1"}, {"coat_darkening": "0"}),
    "a clear coat": keys(lambda v: True, {"coat_weight": "1"}, {"coat_weight": "0"}),
    "an anisotropy of .5": keys(lambda v: v["specular_roughness"] >= 0.2, {"specular_roughness_anisotropy": "0.5"},
                                {"specular_roughness_anisotropy": "0"}),
    "the energy compensation of metals, roughness .3": compensation(0.3),
    "the energy compensation of metals, roughness .6": compensation(0.6),
    "the energy compensation of metals, roughness 1": compensation(1),
    "the energy compensation of metals in Blender, roughness .6": compensation(0.6, blender=True),
}

# ---- pairs ----------------------------------------------------------------------------------------------------------


def sources(materials):
    """{name: canonical spec}: presets, examples, and each sixth of the published exports. Of equal specs the first."""
    names = [(p, p) for p in run(TOOL, "info", "list", "physical:").split()]
    for pattern, step in (("materialx/*", 1), ("openpbr/*", 1), ("physicallybased/PB_GLTF_*", 6), ("physicallybased/PB_SS_*", 6)):
        names += [(name_of(p).removesuffix(".mtlx"), p) for p in sorted(glob.glob(os.path.join(materials, pattern + ".mtlx")))[::step]]
    specs = {}
    for name, argument in names:
        spec = spec_of(argument)
        if spec and spec not in specs:
            specs[spec] = name
    return {name: spec for spec, name in specs.items()}


def exports(materials):
    for target, letters in (("gltf", "GLTF"), ("standard-surface", "SS")):
        for reference in sorted(glob.glob(os.path.join(materials, "physicallybased", "PB_OPBR_*.mtlx"))):
            name, spec = os.path.basename(reference)[len("PB_OPBR_"):-len(".mtlx")], spec_of(reference)
            yield Pair(name, "export", "open-pbr", target, spec, lambda t=reference.replace("OPBR", letters): spec_of(t))


def approximations(specs):
    for what, pair in APPROXIMATIONS.items():
        for name, spec in specs.items():
            specs_of_pair = pair(spec) if name.startswith("physical:") else None
            if specs_of_pair:
                yield Pair(name, what, "open-pbr", "open-pbr", specs_of_pair[0], lambda t=specs_of_pair[1]: t)


def translations(specs, definitions):
    """Examples of OpenPBR, most of which are older versions of the presets, have the targets that a graph has."""
    for source in (*GRAPHS, "gltf", "usd-preview", "disney"):
        some = [(name, spec) for name, spec in specs.items() if spec.startswith(source + ":")]
        for target in ALL + METALS + PLASTICS:
            has_graph = target in GRAPHS.get(source, ())
            for name, spec in some:
                suits = metalness(spec) == 1 if target in METALS else metalness(spec) == 0 if target in PLASTICS else target != source
                if suits and (has_graph or not name.startswith("openpbr/")):
                    yield Pair(name, "nqm", source, target, spec, None)
            for name, spec in some if has_graph else ():
                yield Pair(name, "graph", source, target, spec, lambda s=spec, t=target: by_graph(definitions, s, t))


def pairs(materials):
    specs = sources(materials)
    yield from exports(materials)
    yield from approximations(specs)
    yield from translations(specs, os.path.join(materials, "definitions"))


# ---- judgements -----------------------------------------------------------------------------------------------------

COLUMNS = ("material", "kind", "source", "target", "score", "low", "high", "jod", "delta_e", "words", "reference", "test")


def results_of(*arguments):
    """Of one command, also where some of them failed."""
    done = subprocess.run([TOOL, *arguments, "--json"], capture_output=True, text=True, check=False)
    return json.loads(done.stdout)["results"] if done.stdout else []


def make_tests(chunk):
    """The tests of pairs of the same kind and target."""
    if chunk[0].kind != "nqm":
        return [p.make() if p.reference else None for p in chunk]
    found = {r["input"]: r.get("spec") for r in results_of("translate", *(p.reference for p in chunk), "--to", chunk[0].target)}
    return [found.get(p.reference) for p in chunk]


def score(row):
    if row["reference"] == row["test"]:
        return {"score": 10, "low": 10, "high": 10}
    result = (results_of("score", row["reference"], row["test"]) or [{}])[0]
    return {k: round(result[j], 4) for k, j in (("score", "jod"), ("low", "jod_low"), ("high", "jod_high"))} if result.get("jod") else {}


def label(rows):
    """Of many pairs at once; equal specs need no pictures."""
    arguments = []
    for row in rows:
        arguments += ["+"] * bool(arguments) + [row["reference"], row["test"]]
    only = rows[0]["reference"] if rows else None  # the results of one reference do not name it
    results = {(r.get("reference", only), r["test"]): r for r in results_of("label", *arguments)} if rows else {}
    for row in rows:
        r = results.get((row["reference"], row["test"]), {})
        if r.get("jod") is not None:
            row.update(jod=round(r["jod"], 4), delta_e=round(r["delta_e_itp"], 3), words=r["parts"]["words"])


def is_labelled(row):
    drawn = zlib.crc32("/".join((row["material"], row["kind"], row["target"])).encode()) % 10 == 0
    is_bad = row["kind"] not in APPROXIMATIONS and row["score"] < 9
    return row["reference"] != row["test"] and (row["kind"] == "export" or is_bad or drawn)


def judge(chunk):
    rows = [{**p._asdict(), "test": test} for p, test in zip(chunk, make_tests(chunk))]
    for row in rows:
        del row["make"]
        row.update(score(row) if row["test"] else {})
        if "score" not in row:
            print(f"{row['material']} {row['kind']} {row['target']}: no result", file=sys.stderr)
    rows = [row for row in rows if "score" in row]
    label([row for row in rows if is_labelled(row)])
    return rows


def make_rows(materials, out):
    done = set()
    if os.path.exists(out):
        done = {(r["material"], r["kind"], r["target"]) for r in csv.DictReader(open(out, encoding="utf-8"))}
    todo = (p for p in pairs(materials) if (p.material, p.kind, p.target) not in done)
    with open(out, "a", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, COLUMNS)
        if not done:
            writer.writeheader()
        for _, group in itertools.groupby(todo, key=lambda p: (p.kind, p.source, p.target)):
            while chunk := list(itertools.islice(group, CHUNK)):
                writer.writerows(judge(chunk))
                stream.flush()


# ---- page -----------------------------------------------------------------------------------------------------------


def short(name):
    return name.split(":")[-1].split("/")[-1].removeprefix("open_pbr_").removeprefix("standard_surface_")


def worst_of(rows, n=1, key="score"):
    """By the label where there is one."""
    some = sorted(rows, key=lambda r: r["jod"] if r["jod"] is not None else r["score"])[:n]
    return ", ".join(f"{short(r['material'])} {r['score'] if r['jod'] is None else r['jod']:.2f}" for r in some if r["score"] < 9.95) or "-"


def below(rows, key):
    return f"{100 * sum(r[key] < 9 for r in rows) / len(rows):.0f} %"


def table(*rows):
    """Of tuples; the first one has the titles."""
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in rows]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:]]) + "\n"


def matrix(some):
    """Medians and worst cases of nqm translate, between all models."""
    targets = ALL + METALS + PLASTICS
    lines = []
    for source in (*GRAPHS, "gltf", "usd-preview", "disney"):
        cells = [some("nqm", t, source) for t in targets]
        n = max(map(len, cells))
        lines.append((f"`{source}` ({n})", *(f"{statistics.median(r['score'] for r in c):.2f}, {min(r['score'] for r in c):.1f}"
                                             if c else "" for c in cells)))
    return table(("from, to", *(f"`{t}`" for t in targets)), *lines)


def against_graphs(some):
    lines = []
    for source, targets in GRAPHS.items():
        for target in targets:
            rows = {k: {r["material"]: r for r in some(k, target, source)} for k in ("nqm", "graph")}
            both = sorted(set(rows["nqm"]) & set(rows["graph"]))
            fits, graphs = ([rows[k][m] for m in both] for k in ("nqm", "graph"))
            if not both:
                continue
            low, high = interval([[f["score"] - g["score"]] for f, g in zip(fits, graphs)])
            lines.append((f"`{source}` to `{target}`", len(both), *(f"{statistics.median(r['score'] for r in k):.2f}" for k in (fits, graphs)),
                          f"{statistics.mean(f['score'] - g['score'] for f, g in zip(fits, graphs)):+.2f} [{low:+.2f}, {high:+.2f}]",
                          below(fits, "score"), below(graphs, "score"), worst_of(fits), worst_of(graphs)))
    return table(("from OpenPBR or Standard Surface", "n", "median: nqm", "graph", "mean difference [95 %]", "below 9: nqm", "graph",
                  "worst: nqm", "graph"), *lines)


def summaries(title, groups, key):
    lines = []
    for name, rows in groups:
        values = [r[key] for r in rows]
        low, high = interval([[v] for v in values])
        lines.append((name, len(rows), f"{statistics.median(values):.2f}", f"{statistics.mean(values):.2f} [{low:.2f}, {high:.2f}]",
                      below(rows, key), worst_of(rows, 2)))
    return table((title, "n", "median", "mean [95 %]", "below 9", "worst"), *lines)


def check(rows):
    """How far the scores are from the labels, where both are known."""
    lines = []
    for name, kinds in (("`nqm translate`", ("nqm",)), ("graphs", ("graph",)), ("exports", ("export",)), ("approximations", APPROXIMATIONS)):
        errors = [r["score"] - r["jod"] for r in rows if r["kind"] in kinds and r["jod"] is not None]
        inside = [r["low"] <= r["jod"] <= r["high"] for r in rows if r["kind"] in kinds and r["jod"] is not None]
        if errors:
            lines.append((name, len(errors), f"{statistics.mean(map(abs, errors)):.3f}", f"{statistics.mean(errors):+.3f}",
                          f"{100 * statistics.mean(inside):.0f} %"))
    return table(("labelled pairs", "n", "mean error of the score", "mean difference", "labels inside the interval"), *lines)


def page(rows):
    def some(kind, target=None, source=None):
        return [r for r in rows if r["kind"] == kind and target in (None, r["target"]) and source in (None, r["source"])]

    approximated = sorted(((name, some(name)) for name in APPROXIMATIONS if some(name)),
                          key=lambda g: statistics.mean(r["score"] for r in g[1]))
    labelled = [r for r in some("export") if r["jod"] is not None]
    equal = [{**r, "jod": r["score"]} for r in some("export") if r["jod"] is None]
    wrong = sorted((r for r in labelled if r["jod"] < 9), key=lambda r: r["jod"])
    parts = {"matrix": matrix(some), "graphs": against_graphs(some), "check": check(rows),
             "exports": summaries("published export", [(f"to `{t}`", [r for r in labelled + equal if r["target"] == t])
                                                       for t in ("gltf", "standard-surface")], "jod"),
             "wrong": table(("export", "JOD", "it looks"), *((f"{r['material']} to `{r['target']}`", f"{r['jod']:.2f}", r["words"])
                                                             for r in wrong)),
             "approximations": summaries("left out", approximated, "score")}
    text = open(PAGE, encoding="utf-8").read()
    for name, part in parts.items():
        begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
        before, _, rest = text.partition(begin)
        _, _, after = rest.partition(end)
        text = before + begin + part + end + after
    return text


def draw(rows):
    """The worst labelled pairs of each kind, one of a material, on a sphere: the reference on the left."""
    arguments, titles = [], []
    for kinds, n in (("export", 2), ("nqm", 2), ("graph", 2)):
        seen = set()
        for r in sorted((r for r in rows if r["kind"] == kinds and r["jod"] is not None), key=lambda r: r["jod"]):
            if len(seen) < n and short(r["material"]) not in seen:
                seen.add(short(r["material"]))
                arguments += ["+"] * bool(arguments) + [r["reference"], r["test"]]
                titles.append(f"{short(r['material'])} ({kinds})")
    subprocess.run([TOOL, "label", *arguments, "--grid", PICTURE, "--shape", "sphere", "--light", "interior", "--size", "128"], check=True)
    print("%s: rows %s" % (PICTURE, ", ".join(titles)))


def main():
    arguments = [a for a in sys.argv[1:] if not a.startswith("--")]
    if len(arguments) != 2:
        sys.exit(__doc__)
    if "--only-page" not in sys.argv:
        make_rows(*arguments)
    numbers = ("score", "low", "high", "jod")
    rows = [{**r, **{k: float(r[k]) if r[k] else None for k in numbers}} for r in csv.DictReader(open(arguments[1], encoding="utf-8"))]
    text = page(rows)
    with open(PAGE, "w", encoding="utf-8") as stream:
        stream.write(text)
    draw(rows)


if __name__ == "__main__":
    main()
