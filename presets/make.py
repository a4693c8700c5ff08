#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Write the tables of presets from the published fits: make.py FOLDER; or `physical` from the database: make.py materials.json

FOLDER holds the lists of Ngan et al. 2005, Low et al. 2012 and Bagher et al. 2012 in the notation of BBM
(github.com/bsdfbenchmark/bbm, folder fits): one line a material,
`NAME = Aggregate(Lambertian(albedo = [...]), MODEL(key = value, ...))`. materials.json is that of
github.com/AntonPalmqvist/physically-based-api. The tables are written beside this script. Needs nothing but Python 3.
"""
import json
import pathlib
import re
import sys

# Ngan et al. fitted the MERL tables times 1/1500 in every channel. MERL's own reader multiplies by these as well, and so do
# all later works and every other reference of nqm: the colours are brought to that scale here.
MERL_COLOUR_SCALE = (1.0, 1.15, 1.66)

NGAN = ("Ngan, Durand and Matusik 2005, Experimental Analysis of BRDF Models, Eurographics Symposium on Rendering.\n"
        "DOI 10.2312/EGWR/EGSR05/117-126")
NGAN_SCALE = ("The published green and blue albedos are multiplied by 1.15 and 1.66, the colour scale of the MERL tables, which the\n"
              "fits leave out.")
LOW = ("Low, Kronander, Ynnerman and Unger 2012, BRDF Models for Accurate and Efficient Rendering of Glossy Surfaces, ACM\n"
       "Transactions on Graphics 31(1), supplement. DOI 10.1145/2077341.2077350")
LOW_LOSS = {"e1": "Fitted with their first error measure: squared differences of the values times the cosine.",
            "e2": "Fitted with their second error measure: squared differences of the logarithms of one plus the values times the cosine."}
BAGHER = ("Bagher, Soler and Holzschuch 2012, Accurate fitting of measured reflectances using a Shifted Gamma micro-facet\n"
          "distribution, Computer Graphics Forum 31(4). DOI 10.1111/j.1467-8659.2012.03147.x")


def read_fits(path):
    """{material: (parameters of the diffuse part, of the specular part)}"""
    text = path.read_text()
    names = {word: lambda **parameters: parameters for word in re.findall(r"(\w+)\(", text)}
    names["Aggregate"] = lambda diffuse, specular: (diffuse, specular)
    fits = {}
    for line in text.splitlines():
        if line and not line.startswith("#"):
            name, _, value = line.partition(" = ")
            fits[name] = eval(value, {"__builtins__": {}}, names)
    return fits


def rgb(*keys):
    return [f"{key}_{channel}" for key in keys for channel in "rgb"]


def write_table(source, here, table, model, comment, columns, row, file):
    fits = read_fits(source / file)
    rows = {name: row(*parameters) for name, parameters in fits.items()}
    write_rows(here, table, model, f"{len(fits)} MERL materials", comment, columns, rows)


def write_rows(here, table, model, what, comment, columns, rows):
    lines = [f"Model {model}. {what}.", *comment.splitlines(), "Formula and units of the columns: doc/brdf.md. Made by make.py."]
    with (here / f"{table}.csv").open("w") as out:
        out.write("".join(f"# {line}\n" for line in lines))
        out.write(",".join(["name", *columns]) + "\n")
        for name in sorted(rows):
            out.write(",".join([name] + [f"{x:.6g}" for x in rows[name]]) + "\n")


def sgd_row(diffuse, specular):
    f0, f1 = specular["eta"]
    triples = [diffuse["albedo"], specular["albedo"], specular["alpha"], specular["p"], f0, f1]
    triples += [specular[key] for key in ("K", "Lambda", "c", "k", "theta0")]
    return [x for triple in triples for x in triple]


def lobe_row(colour_scale, amplitude, keys):
    def row(diffuse, specular):
        colours = [x * s for colour in (diffuse["albedo"], specular[amplitude]) for x, s in zip(colour, colour_scale)]
        return [*colours, *(specular[key] for key in keys)]
    return row


PHYSICAL = ("Physically Based, physicallybased.info, by Anton Palmqvist (CC0 1.0), as of {updated}.\n"
            "Metals have the colours of normal and of almost grazing incidence (F82) of the database. What a material\n"
            "transmits is left out; what scatters below its surface is diffuse.")


def linear(colors):
    return next(c["color"] for c in colors if c["colorSpace"] == "srgb-linear")


def physical_row(material):
    f82 = [c["color"] for c in material.get("specularColor", []) if "F82" in c["format"]]
    specular = linear(f82[0]) if f82 and material["metalness"] else [1, 1, 1]
    return [1 - material.get("transmission", 0), *linear(material["color"]), material["metalness"], *specular,
            material["roughness"], material.get("ior", 1.5), *film_of(material)]


def film_of(material):
    """Weight, thickness in micrometres (typical, or the middle of its range) and index of refraction."""
    range_nm = material.get("thinFilmThickness")
    if not range_nm:
        return 0, 0.5, 1.4
    return 1, (range_nm[2] if len(range_nm) > 2 else sum(range_nm) / 2) / 1000, material["thinFilmIor"]


def write_physical(file, here):
    database = json.loads(file.read_text())
    rows = {re.sub(r"\W+", "-", m["name"].lower()).strip("-"): physical_row(m) for m in database["data"]}
    columns = ["base_weight", *rgb("base_color"), "base_metalness", *rgb("specular_color"), "specular_roughness", "specular_ior",
               "thin_film_weight", "thin_film_thickness", "thin_film_ior"]
    write_rows(here, "physical", "open-pbr", f"{len(rows)} materials", PHYSICAL.format(**database["header"]), columns, rows)


def main():
    source, here = pathlib.Path(sys.argv[1]), pathlib.Path(__file__).resolve().parent
    if source.is_file():
        write_physical(source, here)
        return
    write_table(source, here, "sgd", "sgd", BAGHER,
                rgb("kd", "ks", "alpha", "p", "f0", "f1", "K", "lambda", "c", "k", "theta0"), sgd_row, "bagher_sgd.fit")
    # table: its columns behind kd and ks, and what the list calls them
    ngan = {"ward": {"alpha": "roughness"}, "ward-duer": {"alpha": "roughness"}, "blinn-phong": {"n": "sharpness"},
            "lafortune": {"cxy": "Cxy", "cz": "Cz", "n": "sharpness"}, "cook-torrance": {"alpha": "roughness", "f0": "eta"},
            "ashikhmin-shirley": {"n": "sharpness", "f0": "fresnelReflectance"}}
    for model, keys in ngan.items():
        write_table(source, here, model, model, f"{NGAN}\n{NGAN_SCALE}", [*rgb("kd", "ks"), *keys],
                    lobe_row(MERL_COLOUR_SCALE, "albedo", keys.values()), f"ngan_{model.replace('-', '')}.fit")
    low = {"cook-torrance": {"alpha": "roughness", "eta": "eta"}, "ashikhmin-shirley": {"n": "sharpness", "eta": "fresnelReflectance"}}
    for model, keys in low.items():
        for loss, table in (("e1", f"low-{model}-e1"), ("e2", f"low-{model}")):
            write_table(source, here, table, f"low-{model}", f"{LOW}\n{LOW_LOSS[loss]}", [*rgb("kd", "ks"), *keys],
                        lobe_row((1, 1, 1), "albedo", keys.values()), f"low_{model.replace('-', '')}_{loss.upper()}.fit")
    keys = {"B": "B", "C": "C", "eta": "eta"}
    for model, name in (("abc", "lowmicrofacet"), ("smooth", "lowsmooth")):
        write_table(source, here, model, model, f"{LOW}\n{LOW_LOSS['e2']}", [*rgb("kd", "ks"), *keys],
                    lobe_row((1, 1, 1), "A", keys.values()), f"low_{name}_E2.fit")


if __name__ == "__main__":
    main()
