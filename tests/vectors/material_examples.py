# SPDX-License-Identifier: MIT
"""Which example materials of MaterialX and OpenPBR have a BRDF, by Python's XML reader and the definitions of the surfaces.
material_examples.csv: file, material, surface, verdict ("accepted", the first input that cannot be honoured, or of a material that is
textured the first input that varies), textured (1 or 0).
Usage: material_examples.py FOLDER, the folder materials of the shared data; without it the stored table stays."""
import csv
import pathlib
import sys
import xml.etree.ElementTree

# inputs that must keep the defaults of the definition
NEUTRAL = {
    "open_pbr_surface": "transmission_weight subsurface_weight emission_luminance geometry_opacity",
    "standard_surface": "transmission subsurface emission opacity",
    "gltf_pbr": "transmission alpha_mode emissive",
    "UsdPreviewSurface": "emissiveColor opacity displacement",
    "disney_principled": "specTrans subsurface",
}
# those among them that refuse a material only if it is not ignored (--ignore): others are named first
IGNORABLE = "transmission subsurface emission emissive emissiveColor opacity alpha_mode specTrans " \
            "transmission_weight subsurface_weight emission_luminance geometry_opacity"
# inputs that a BRDF needs as numbers, by the beginning of their names
NEEDED = {
    "open_pbr_surface": "base_ specular_ fuzz_ coat_ thin_film_",
    "standard_surface": "base diffuse_ metalness specular sheen coat thin_film",
    "gltf_pbr": "base_color metallic roughness ior specular clearcoat sheen_ anisotropy iridescence",
    "UsdPreviewSurface": "diffuseColor useSpecularWorkflow specularColor metallic roughness clearcoat ior",
    "disney_principled": "baseColor metallic roughness anisotropic specular sheen clearcoat",
}
# inputs that are ignored where they are maps, and nodes that are not evaluated
IGNORED = "emissive emissiveColor emission subsurface"
PROCEDURAL = {"position", "fractal3d"}
# ACES AP1 (D60) to BT.709 (D65), Bradford
AP1 = [[1.70505, -0.62179, -0.08326], [-0.13026, 1.14080, -0.01055], [-0.02400, -0.12897, 1.15297]]


def numbers(text):
    return [float(x) for x in text.split(",")]


def is_procedural(root, i):
    graph = next((e for e in root if e.get("name") == i.get("nodegraph")), [])
    return any(e.tag in PROCEDURAL for e in graph)


def verdict(root, shader, space, defaults):
    """The first input that refuses the material or, if none does, varies; and whether it is textured."""
    kind = shader.tag
    varies = aside = None
    value = {i.get("name"): i.get("value", "") for i in shader.iter("input")}
    connected = lambda i: i.get("nodename") or i.get("nodegraph")
    for i in shader.iter("input"):
        name = i.get("name")
        if "normal" in name and connected(i):
            varies = varies or name
            continue
        if "normal" in name and numbers(i.get("value")) != [0, 0, 1]:
            return name, 0
        if name in IGNORED.split() and connected(i):
            continue
        if name in NEUTRAL[kind].split() and (connected(i) or numbers(i.get("value")) != numbers(defaults[kind][name])):
            if name not in IGNORABLE.split():
                return name, 0
            aside = aside or name
        if "tangent" in name and any(numbers(v) != [0] for k, v in value.items() if "anisotrop" in k):
            return name, 0
        if not any(name.startswith(n) for n in NEEDED[kind].split()):
            continue
        if connected(i) and is_procedural(root, i):
            return name, 0
        if connected(i):
            varies = varies or name
            continue
        if i.get("type") == "color3" and space == "acescg":
            if min(sum(m * x for m, x in zip(row, numbers(i.get("value")))) for row in AP1) < -1e-3:
                return name, 0
    if aside:
        return aside, 0
    return (varies, 1) if varies else ("accepted", 0)


def defaults_of(folder):
    found = {}
    for path in (folder / "definitions").glob("*.mtlx"):
        for definition in xml.etree.ElementTree.parse(path).getroot().iter("nodedef"):
            entry = found.setdefault(definition.get("node"), {})
            for i in definition.iter("input"):
                entry.setdefault(i.get("name"), i.get("value"))
    return found


def main(folder):
    defaults = defaults_of(folder)
    rows = []
    for path in sorted((folder / "materialx").glob("*.mtlx")) + sorted((folder / "openpbr").glob("*.mtlx")):
        root = xml.etree.ElementTree.parse(path).getroot()
        for material in root.iter("surfacematerial"):
            target = next(i for i in material.iter("input") if i.get("name") == "surfaceshader").get("nodename")
            shader = next(e for e in root if e.get("name") == target)
            rows.append([f"{path.parent.name}/{path.name}", material.get("name"), shader.tag,
                         *verdict(root, shader, root.get("colorspace"), defaults)])
        if not any(True for _ in root.iter("surfacematerial")):
            rows.append([f"{path.parent.name}/{path.name}", "", "", "no material", 0])
    with open(pathlib.Path(__file__).with_suffix(".csv"), "w", newline="") as file:
        file.write("# made by material_examples.py\nfile,material,surface,verdict,textured\n")
        csv.writer(file, lineterminator="\n").writerows(rows)


if len(sys.argv) > 1:
    main(pathlib.Path(sys.argv[1]))
