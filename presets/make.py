#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Write sgd.csv and ward.csv from the published fits: make.py FOLDER

FOLDER holds bagher_sgd.fit and ngan_ward.fit in the notation of BBM (github.com/bsdfbenchmark/bbm, folder fits): one line
a material, `NAME = Aggregate(Lambertian(albedo = [...]), MODEL(key = value, ...))`. The tables are written beside this
script. Needs nothing but Python 3.
"""
import pathlib
import sys

# Ngan et al. fitted the MERL tables times 1/1500 in every channel. MERL's own reader multiplies by these as well, and so do
# all later works and every other reference of nqm: the colours are brought to that scale here.
MERL_COLOUR_SCALE = (1.0, 1.15, 1.66)


def read_fits(path, model):
    """{material: (parameters of the diffuse part, of the specular part)}"""
    def keep(**parameters):
        return parameters
    names = {"Aggregate": lambda diffuse, specular: (diffuse, specular), "Lambertian": keep, model: keep}
    fits = {}
    for line in path.read_text().splitlines():
        if line and not line.startswith("#"):
            name, _, value = line.partition(" = ")
            fits[name] = eval(value, {"__builtins__": {}}, names)
    return fits


def sgd_row(diffuse, specular):
    f0, f1 = specular["eta"]
    triples = [diffuse["albedo"], specular["albedo"], specular["alpha"], specular["p"], f0, f1]
    triples += [specular[key] for key in ("K", "Lambda", "c", "k", "theta0")]
    return [x for triple in triples for x in triple]


def ward_row(diffuse, specular):
    scaled = [x * s for colour in (diffuse["albedo"], specular["albedo"]) for x, s in zip(colour, MERL_COLOUR_SCALE)]
    return [*scaled, specular["roughness"]]


def rgb(*keys):
    return [f"{key}_{channel}" for key in keys for channel in "rgb"]


def write_table(path, comment, columns, rows):
    with path.open("w") as out:
        out.write("".join(f"# {line}\n" for line in comment))
        out.write(",".join(["name", *columns]) + "\n")
        for name in sorted(rows):
            out.write(",".join([name] + [f"{x:.6g}" for x in rows[name]]) + "\n")


def main():
    source, here = pathlib.Path(sys.argv[1]), pathlib.Path(__file__).resolve().parent
    fits = read_fits(source / "bagher_sgd.fit", "Bagher")
    write_table(here / "sgd.csv", [
        "Shifted gamma distribution fits of the 100 MERL materials.",
        "Bagher, Soler and Holzschuch 2012, Accurate fitting of measured reflectances using a Shifted Gamma micro-facet",
        "distribution, Computer Graphics Forum 31(4). DOI 10.1111/j.1467-8659.2012.03147.x",
        "Columns, each for r, g and b: kd, ks albedos; alpha, p width and shape of the distribution; f0, f1 Fresnel;",
        "K normalisation; lambda, c, k, theta0 (radians) shadowing. Formula and units: doc/brdf.md. Made by make.py."],
        rgb("kd", "ks", "alpha", "p", "f0", "f1", "K", "lambda", "c", "k", "theta0"),
        {name: sgd_row(*fit) for name, fit in fits.items()})
    fits = read_fits(source / "ngan_ward.fit", "NganWard")
    write_table(here / "ward.csv", [
        "Isotropic Ward fits of 86 MERL materials.",
        "Ngan, Durand and Matusik 2005, Experimental Analysis of BRDF Models, Eurographics Symposium on Rendering.",
        "DOI 10.2312/EGWR/EGSR05/117-126",
        "Columns: kd, ks albedos for r, g and b; alpha lobe width. The published green and blue albedos are multiplied by",
        "1.15 and 1.66, the colour scale of the MERL tables, which the fits leave out. Made by make.py."],
        [*rgb("kd", "ks"), "alpha"], {name: ward_row(*fit) for name, fit in fits.items()})


if __name__ == "__main__":
    main()
