#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Make the tables of doc/translations.md: what translations of materials between renderers cost, and what approximations cost.

usage: studies/translations.py MATERIALS OUT.csv [--only-page]

MATERIALS is the folder of the examples: `definitions` with MaterialX's graphs, `openpbr` and `materialx` with .mtlx files, and
`physicallybased` with the published exports of physicallybased.info. OUT.csv gets a row for each pair as it is judged; a second run
continues it. Kinds of rows: `export` (a published file beside the published OpenPBR file), `nqm` (nqm translate), `graph` (MaterialX's
translation graphs), and approximations. All pairs are judged by `nqm score`; exports, translations that score below 9 and a tenth of the
others, by a hash of their names, also by `nqm label` (standard scenes). The tables are written at the end, and doc/gallery/translations.png with
--pictures. The tool is NQM_TOOL, default build/nqm. Python's standard library only."""
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
    """{name: canonical spec}: presets and examples. Of equal specs the first; the published exports are sources, too."""
    names = [(p, p) for p in run(TOOL, "info", "list", "physical:").split()]
    for pattern in ("materialx/*", "openpbr/*", "physicallybased/PB_GLTF_*", "physicallybased/PB_SS_*"):
        names += [(name_of(p).removesuffix(".mtlx"), p) for p in sorted(glob.glob(os.path.join(materials, pattern + ".mtlx")))]
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
