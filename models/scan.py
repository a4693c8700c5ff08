#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Write the material list of a data folder, the input of `nqm dataset`, to standard output.

usage: models/scan.py DATA [--seed 1] > materials.csv

The list contains DATA/rgl/*.bsdf, the networks in DATA/nbrdf/*.zip, the materials of DATA/nps/nps_latents.csv and the
presets `sgd:` of nqm (NQM_TOOL, default build/nqm). Columns: name, group, brdf (relative to DATA), source, split. All
forms of one material are in one group. The materials of DATA/labels/labels_real.csv are the test split; a hash of the
group's name and the seed assigns 15 % of the other groups to validation. Needs only Python's standard library."""
import argparse
import csv
import os
import re
import subprocess
import sys
import zipfile
from glob import escape, glob

VALIDATION_FRACTION = 0.15
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


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("data")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    try:
        labelled = materials_of(os.path.join(arguments.data, "labels", "labels_real.csv"))
        rows = list(scan(arguments.data, os.environ.get("NQM_TOOL", os.path.join(here, "..", "build", "nqm"))))
    except (OSError, zipfile.BadZipFile, subprocess.CalledProcessError) as error:
        sys.exit(f"scan.py: {error}")
    if all(source == "sgd" for source, _, _ in rows):
        sys.exit(f"scan.py: {arguments.data}: holds none of rgl/*.bsdf, nbrdf/*.zip, nps/nps_latents.csv")
    held_out = {re.sub(r"(?<=.)_[0-9]+$", "", name) for name in labelled}  # "aluminium_7" is the 7th encoding of aluminium
    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(["name", "group", "brdf", "source", "split"])
    for source, material, brdf in rows:
        is_validation = uniform_of(arguments.seed, material) < VALIDATION_FRACTION
        split = "test" if material in held_out else "validation" if is_validation else "train"
        out.writerow([f"{source}-{material}", material, brdf, source, split])


if __name__ == "__main__":
    main()
