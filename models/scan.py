#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Write the material list of a data folder, the input of models/plan.py, to standard output.

usage: models/scan.py DATA [--seed 1] > materials.csv

The list contains DATA/rgl/*.bsdf, the networks in DATA/nbrdf/*.zip, the materials of DATA/nps/nps_latents.csv and the
presets `sgd:` of nqm (NQM_TOOL, default build/nqm); one file of each material in DATA/materials that nqm accepts; and specs
that are generated from the seed: coated and velvet materials of renderers, mirrors and smooth coats, analytic models. Columns:
name, group, brdf (relative to DATA), source, split. All forms of one material are in one group. The materials of
DATA/labels/labels_real.csv are the test split; a hash of the group's name and the seed assigns 15 % of the other groups to
validation, and of the sources renderer, mirror and analytic 15 % to the test split. Needs only Python's standard library."""
import argparse
import csv
import os
import re
import subprocess
import sys
import zipfile
from glob import escape, glob

VALIDATION_FRACTION = TEST_FRACTION = 0.15
MASK = 2**64 - 1
GOLDEN = 0x9E3779B97F4A7C15  # 2^64 / golden ratio


def mix(z):
    """The finaliser of splitmix64, as nqm_hash_mix() in src/base/base.h."""
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
    return z ^ (z >> 31)


def uniform_of(seed, name):
    """A uniform random value in [0, 1) for a seed and a name: splitmix64 with the FNV-1a hash of the name as its
    counter."""
    counter = 0xCBF29CE484222325
    for byte in name.encode():
        counter = ((counter ^ byte) * 0x100000001B3) & MASK
    return (mix((mix((seed + GOLDEN) & MASK) + (counter + 1) * GOLDEN) & MASK) >> 11) * 2.0**-53


def materials_of(path):
    with open(path, newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        if "material" not in (reader.fieldnames or []):
            sys.exit(f"scan.py: {path}: has no column 'material'")
        return [row["material"] for row in reader]


def scan(data, nqm):
    """(source, material, brdf) of every reference, in the order of the list."""
    def files(pattern):
        return sorted(glob(os.path.join(escape(data), pattern)))

    for path in files("rgl/*.bsdf"):
        name = os.path.basename(path)
        yield "rgl", name[: -len(".bsdf")], "rgl/" + name
    for path in files("nbrdf/*.zip"):
        with zipfile.ZipFile(path) as archive:
            members = [os.path.basename(name) for name in archive.namelist()]
        for material in sorted(name[: -len(".h5")] for name in members if name.endswith(".h5")):
            yield "nbrdf", material, f"nbrdf/{os.path.basename(path)}:{material}"
    for path in files("nps/nps_latents.csv"):
        for material in materials_of(path):
            yield "nps", material, f"nps/nps_decoder_f32le.bin:{material}"
    for preset in subprocess.run([nqm, "info", "list"], check=True, capture_output=True, text=True).stdout.split():
        if preset.startswith("sgd:"):
            yield "sgd", preset[len("sgd:") :], preset


# ---- renderer materials and specs -------------------------------------------------------------------------------------

SURFACES = r"(open_pbr|standard_surface|usd_preview_surface|gltf_pbr|disney_principled|PB_OPBR|PB_GLTF|PB_SS)_"


def renderer_files(data, nqm, seed):
    """(material, brdf): of the files of each material, the first that nqm accepts in the order of a hash."""
    files = {}
    for path in sorted(glob(os.path.join(escape(data), "materials", "*", "*.mtlx"))):
        material = re.sub("^" + SURFACES, "", os.path.basename(path)[: -len(".mtlx")]).lower().replace("_", "")
        if "definitions" not in os.path.dirname(path):
            files.setdefault(re.sub(r"[^a-z0-9]", "-", material).strip("-"), []).append(os.path.relpath(path, data))
    for material in sorted(files):
        for brdf in sorted(files[material], key=lambda path: uniform_of(seed, path)):
            info = subprocess.run([nqm, "info", os.path.join(data, brdf)], check=False, capture_output=True, text=True)
            if info.returncode == 0 and "\nspec " in info.stdout:
                yield material, brdf
                break


class Draw:
    """Random values of one material: each is a function of the seed, the material and a name."""

    def __init__(self, seed, material):
        self.seed, self.material = seed, material

    def between(self, name, low, high):
        return low + (high - low) * uniform_of(self.seed, f"{self.material} {name}")

    def log(self, name, low, high):
        return low * (high / low) ** uniform_of(self.seed, f"{self.material} {name}")

    def colour(self, name, low, high):
        """An RGB colour; one in three is grey."""
        rgb = [self.between(f"{name} {channel}", low, high) for channel in "rgb"]
        return rgb if self.between(f"{name} grey", 0, 3) >= 1 else rgb[:1]


def spec(model, **settings):
    """"MODEL:key=value;..." with four digits."""
    def text(value):
        return ",".join(f"{x:.4g}" for x in (value if isinstance(value, list) else [value]))

    return f"{model}:" + ";".join(f"{key}={text(value)}" for key, value in settings.items())


def smooth_coat(i, draw):
    """A coat of roughness 0, the default of most models, over a rough base, every second time a metal."""
    base, rough, metal = draw.colour("base", 0.02, 0.9), draw.between("roughness", 0.15, 0.9), i // 5 % 2
    return (
        spec("gltf", base_color=base, metallic=metal, roughness=rough, clearcoat=1),
        spec("open-pbr", base_color=base, base_metalness=metal, specular_roughness=rough, coat_weight=1),
        spec("standard-surface", base_color=base, metalness=metal, specular_roughness=rough, coat=1, coat_roughness=0),
        spec("usd-preview", diffuseColor=base, metallic=metal, roughness=rough, clearcoat=1, clearcoatRoughness=0),
        spec("gltf", base_color=base, metallic=metal, roughness=rough, clearcoat=draw.between("coat", 0.3, 0.9)),
    )[i % 5]


def mirror(i, draw):
    """A mirror with alpha 0 (the smallest of the model) or up to 0.03, of metal or of a dielectric."""
    alpha = 0 if i % 3 == 0 else draw.log("alpha", 5e-4, 0.03)
    rough, dark = alpha**0.5, draw.colour("base", 0, 0.2)
    metal = 1 if i // 2 % 3 == 1 else draw.colour("metal", 0.4, 1)
    return (
        spec("gltf", base_color=metal, metallic=1, roughness=rough),
        spec("ggx", kd=dark, ks=1, alpha=max(alpha, 1e-4), f0=0.04),
        spec("open-pbr", base_color=metal, base_metalness=1, specular_roughness=rough),
        spec("gltf", base_color=dark, metallic=0, roughness=rough, ior=draw.between("ior", 1.3, 2.2)),
        spec("rough-conductor", alpha=max(alpha, 1e-4), eta=0, k=1, specular_reflectance=metal),
        spec("standard-surface", base_color=dark, metalness=0, specular_roughness=rough),
        spec("ggx", ks=1, alpha=max(alpha, 1e-4), f0=metal),
        spec("open-pbr", base_color=draw.colour("body", 0.3, 0.9), specular_roughness=rough),
        spec("usd-preview", diffuseColor=metal, metallic=1, roughness=rough),
        spec("principled", base_color=dark, roughness=rough, eta=draw.between("ior", 1.3, 2)),
    )[i % 10]


def layered(i, draw):
    """A coat of roughness up to 0.3, or sheen, or a metal with an edge tint."""
    base, rough = draw.colour("base", 0.02, 0.9), draw.between("roughness", 0.1, 0.9)
    coat = draw.between("coat", 0, 0.3)
    metal, sheen, tint = i // 7 % 2, draw.between("sheen", 0.2, 1), draw.colour("tint", 0.2, 1)
    return (
        spec("gltf", base_color=base, metallic=metal, roughness=rough, clearcoat=1, clearcoat_roughness=coat),
        spec("open-pbr", base_color=base, base_metalness=metal, specular_roughness=rough, coat_weight=1,
             coat_roughness=coat, coat_color=tint),
        spec("standard-surface", base_color=base, metalness=metal, specular_roughness=rough, coat=1, coat_roughness=coat),
        spec("gltf", base_color=base, metallic=0, roughness=rough, sheen_color=tint, sheen_roughness=sheen),
        spec("open-pbr", base_color=base, specular_weight=0, fuzz_weight=sheen, fuzz_color=tint, fuzz_roughness=rough),
        spec("open-pbr", base_color=base, base_metalness=1, specular_color=tint, specular_roughness=rough),
        spec("disney", baseColor=base, metallic=metal, roughness=rough, clearcoat=1, clearcoatGloss=1 - coat),
    )[i % 7]


def analytic(i, draw):
    kd, ks, alpha = draw.colour("kd", 0.01, 0.5), draw.colour("ks", 0.02, 0.4), draw.log("alpha", 0.02, 0.6)
    f0, n, eta = draw.between("f0", 0.03, 0.9), 2 / alpha**2, draw.between("eta", 1.2, 3)
    return (
        spec("ggx", kd=kd, ks=1, alpha=alpha, f0=draw.colour("f0", 0.02, 0.1)),
        spec("ward", kd=kd, ks=ks, alpha=alpha),
        spec("ggx", ks=1, alpha=alpha, f0=draw.colour("f0", 0.3, 1)),
        spec("blinn-phong", kd=kd, ks=ks, n=n),
        spec("cook-torrance", kd=kd, ks=ks, alpha=alpha, f0=f0),
        spec("ward-duer", kd=kd, ks=ks, alpha=alpha),
        spec("ashikhmin-shirley", kd=kd, ks=ks, n=n, f0=f0),
        spec("lambert", kd=kd),
        spec("low-cook-torrance", kd=kd, ks=ks, alpha=alpha, eta=eta),
        spec("abc", kd=kd, ks=ks, B=1 / alpha**2, C=draw.between("C", 0.6, 1.8), eta=eta),
    )[i % 10]


# source, function, number
GENERATED = (("renderer", "layered", layered, 14), ("mirror", "mirror", mirror, 15), ("mirror", "coat", smooth_coat, 10),
             ("analytic", "model", analytic, 20))


def scan_new(data, nqm, seed):
    """(source, material, brdf) of the references whose groups are not those of measurements."""
    for material, brdf in renderer_files(data, nqm, seed):
        yield "renderer", material, brdf
    for source, name, make, n in GENERATED:
        for i in range(n):
            yield source, f"{name}{i + 1}", make(i, Draw(seed, f"{source} {name} {i}"))


def split_of(seed, group, held_out):
    """held_out: the test materials; None: a part of all groups."""
    u = uniform_of(seed, group)
    if held_out is None:
        return "test" if u < TEST_FRACTION else "validation" if u < TEST_FRACTION + VALIDATION_FRACTION else "train"
    return "test" if group in held_out else "validation" if u < VALIDATION_FRACTION else "train"


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("data")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    try:
        labelled = materials_of(os.path.join(arguments.data, "labels", "labels_real.csv"))
        nqm = os.environ.get("NQM_TOOL", os.path.join(here, "..", "build", "nqm"))
        rows = list(scan(arguments.data, nqm))
        new = list(scan_new(arguments.data, nqm, arguments.seed))
    except (OSError, zipfile.BadZipFile, subprocess.CalledProcessError) as error:
        sys.exit(f"scan.py: {error}")
    if all(source == "sgd" for source, _, _ in rows):
        sys.exit(f"scan.py: {arguments.data}: holds none of rgl/*.bsdf, nbrdf/*.zip, nps/nps_latents.csv")
    held_out = {re.sub(r"(?<=.)_[0-9]+$", "", name) for name in labelled}  # "aluminium_7" is the 7th encoding of aluminium
    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(["name", "group", "brdf", "source", "split"])
    for source, material, brdf in rows:
        split = split_of(arguments.seed, material, held_out)
        out.writerow([f"{source}-{material}", material, brdf, source, split])
    for source, material, brdf in new:
        name = f"{source}-{material}"  # also of the group: a MERL material of this name is another material
        out.writerow([name, name, brdf, source, split_of(arguments.seed, name, None)])


if __name__ == "__main__":
    main()
