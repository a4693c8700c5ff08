#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Study of doc/batch.md: how many of the ten best of an exact search does `nqm nearest` find in a large library?

usage: studies/nearest.py FOLDER [N] [QUERIES]

FOLDER receives a library of N materials (default 100000), drawn by a seed over nine shading models, as files of glTF, MaterialX, Mitsuba
and pbrt. QUERIES (default 20) are presets of physicallybased.info and specs that are drawn alike, in turn. The exact search is `nqm batch`
over all N pairs. A result counts as found if its score is that of the tenth best or better. Processor time and memory are of the first
search, which makes the index, and of the others. The tool is NQM_TOOL, default build/nqm. Python's standard library only."""
import csv
import json
import os
import random
import resource
import subprocess
import sys
import time

from translate import TOOL

PER_FILE = 2500
COLOR, SMALL, ROUGH, METAL, WEIGHT = "color", "small", "roughness", "metal", "weight"
# model: (format, name in the file, {key: kind}, name of the keys in the file where they differ)
MODELS = {
    "gltf": ("gltf", None, {"base_color": COLOR, "metallic": METAL, "roughness": ROUGH, "clearcoat": WEIGHT}),
    "open-pbr": ("mtlx", "open_pbr_surface", {"base_color": COLOR, "base_metalness": METAL, "specular_roughness": ROUGH,
                                              "specular_ior": "ior", "coat_weight": WEIGHT, "fuzz_weight": WEIGHT}),
    "standard-surface": ("mtlx", "standard_surface", {"base": SMALL, "base_color": COLOR, "metalness": METAL, "specular_roughness": ROUGH,
                                                      "coat": WEIGHT, "sheen": WEIGHT}),
    "usd-preview": ("mtlx", "UsdPreviewSurface", {"diffuseColor": COLOR, "metallic": METAL, "roughness": ROUGH, "clearcoat": WEIGHT}),
    "disney": ("mtlx", "disney_principled", {"baseColor": COLOR, "metallic": METAL, "roughness": ROUGH, "sheen": WEIGHT,
                                             "clearcoat": WEIGHT}),
    "principled": ("xml", "principled", {"base_color": COLOR, "metallic": METAL, "roughness": ROUGH, "sheen": WEIGHT,
                                         "clearcoat": WEIGHT}),
    "rough-conductor": ("xml", "roughconductor", {"alpha": ROUGH, "eta": "eta", "k": "k"}),
    "rough-plastic": ("xml", "roughplastic", {"alpha": ROUGH, "diffuse_reflectance": COLOR}),
    "pbrt-conductor": ("pbrt", "conductor", {"roughness": ROUGH, "eta": "eta", "k": "k"}),
}


def draw(rng, kind):
    """A value, as the text that specs and files share."""
    ranges = {COLOR: (0, 1), SMALL: (0.2, 1), ROUGH: (0.02, 1), "ior": (1.2, 2.4), "eta": (0.1, 4), "k": (0.5, 6)}
    if kind == METAL:
        values = [rng.choice((0, 1))]
    elif kind == WEIGHT:
        values = [rng.choice((0, 0, 0, rng.random()))]
    else:
        values = [rng.uniform(*ranges[kind]) ** (2.2 if kind == COLOR else 1) for _ in range(3 if kind in (COLOR, "eta", "k") else 1)]
    return ",".join(f"{v:.4g}" for v in values)


def draw_material(rng):
    model = rng.choice(list(MODELS))
    return model, {key: draw(rng, kind) for key, kind in MODELS[model][2].items()}


def spec_of(material):
    model, values = material
    return model + ":" + ";".join(f"{k}={v}" for k, v in values.items())


# ---- files ----------------------------------------------------------------------------------------------------------


def gltf(name, _, values):
    core = {"baseColorFactor": [*map(float, values["base_color"].split(",")), 1], "metallicFactor": float(values["metallic"]),
            "roughnessFactor": float(values["roughness"])}
    return json.dumps({"name": name, "pbrMetallicRoughness": core,
                       "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": float(values["clearcoat"])}}})


def mtlx(name, node, values):
    inputs = "".join(f'<input name="{k}" type="{"color3" if "," in v else "float"}" value="{v}"/>' for k, v in values.items())
    return f'<{node} name="{name}" type="surfaceshader">{inputs}</{node}>'


def xml(name, plugin, values):
    def entry(key, value):
        return f'<rgb name="{key}" value="{value.replace(",", " ")}"/>' if "," in value else f'<float name="{key}" value="{value}"/>'
    outside = '<float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/>' if plugin == "roughplastic" else ""
    return f'<bsdf type="{plugin}" id="{name}">{"".join(entry(k, v) for k, v in values.items())}{outside}</bsdf>'


def pbrt(name, kind, values):
    numbers = "".join(f' "{"rgb" if "," in v else "float"} {k}" [ {v.replace(",", " ")} ]' for k, v in values.items())
    return f'MakeNamedMaterial "{name}" "string type" "{kind}"{numbers}'


FILES = {"gltf": (gltf, '{"asset": {"version": "2.0"}, "materials": [\n', ",\n", "]}"),
         "mtlx": (mtlx, '<?xml version="1.0"?>\n<materialx version="1.39">\n', "\n", "</materialx>"),
         "xml": (xml, '<scene version="3.0.0">\n', "\n", "</scene>"), "pbrt": (pbrt, "", "\n", "\n")}


def write_library(folder, materials):
    """{argument as `nqm nearest` names it: spec}"""
    specs, groups = {}, {}
    for i, material in enumerate(materials):
        groups.setdefault(MODELS[material[0]][0], []).append((f"m{i}", material))
    for ending, group in groups.items():
        write, head, between, tail = FILES[ending]
        for at in range(0, len(group), PER_FILE):
            some, path = group[at:at + PER_FILE], os.path.join(folder, f"{at // PER_FILE}.{ending}")
            with open(path, "w", encoding="utf-8") as stream:
                stream.write(head + between.join(write(name, MODELS[m[0]][1], m[1]) for name, m in some) + tail)
            specs.update({f"{path}:{name}": spec_of(m) + (";eta=1.5" if m[0] == "rough-plastic" else "") for name, m in some})
    return specs


# ---- searches -------------------------------------------------------------------------------------------------------


def timed(*arguments):
    """(standard output, seconds of processor time, seconds)"""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    text = subprocess.run([TOOL, *arguments], stdout=subprocess.PIPE, text=True, check=True).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return text, after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime, time.monotonic() - start


def exact(folder, query, specs):
    """Scores in the order of specs."""
    path, out = os.path.join(folder, "pairs.csv"), os.path.join(folder, "scores.csv")
    with open(path, "w", encoding="utf-8") as stream:
        csv.writer(stream).writerows([("reference", "test"), *((query, s) for s in specs)])
    subprocess.run([TOOL, "batch", path, "-o", out], stderr=subprocess.DEVNULL, check=True)
    with open(out, encoding="utf-8") as stream:
        return [float(r["jod"]) for r in csv.DictReader(stream)]


def main():
    if not 2 <= len(sys.argv) <= 4:
        sys.exit(__doc__)
    folder, n, n_queries = os.path.abspath(sys.argv[1]), *(int(a) for a in (sys.argv[2:] + ["100000", "20"][len(sys.argv) - 2:]))
    library, index = os.path.join(folder, "library"), os.path.join(folder, "library.index")
    os.makedirs(library, exist_ok=True)
    specs = write_library(library, [draw_material(random.Random(i)) for i in range(n)])
    presets = subprocess.run([TOOL, "info", "list", "physical:"], capture_output=True, text=True, check=True).stdout.split()
    rng = random.Random(-1)
    queries = [spec_of(draw_material(rng)) if i % 2 else rng.choice(presets) for i in range(n_queries)]
    found = wanted = 0
    for query in queries:
        text, cpu, seconds = timed("nearest", query, "--among", library, "-n", "10", "--index", index, "-q")
        if query == queries[0]:
            peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
        names = text.split()
        jods = dict(zip(specs, exact(folder, query, specs.values())))
        tenth = sorted(jods.values())[-10]
        hits = sum(jods[name] >= tenth for name in names)
        found, wanted = found + hits, wanted + 10
        print(f"{hits}/10 best {max(jods.values()):.3f} tenth {tenth:.3f} worst found {min(jods[name] for name in names):.3f} "
              f"{cpu:.1f} s of processor, {seconds:.1f} s  {query[:70]}", flush=True)
    print(f"{found} of {wanted} found among {n}; index {os.path.getsize(index) / 1e6:.0f} MB; memory of the first search {peak:.0f} MB")


if __name__ == "__main__":
    main()
