# SPDX-License-Identifier: MIT
"""grammars.py - random files of each format of materials and measurements, as their exporters write them, in parts that can be dropped,
changed and broken."""
import copy
import itertools
import json
import random
import re
import struct
import zlib


def _chunk(name, data):
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


PIXEL = (b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 6, 0, 0, 0)) +
         _chunk(b"IDAT", zlib.compress(b"\0\x80\x40\x20\xff")) + _chunk(b"IEND", b""))


class Change:
    """A version of a file: what it does to which statement. names: one of these words names it."""

    def __init__(self, how, name, text, names=()):
        self.how, self.name, self.text, self.names = how, name, text, (name,) + tuple(names)


class Case:
    """A file and its versions. ending: of its name; "": a folder. refused: a word of the reason for which it must be; None: accepted."""

    def __init__(self, ending, text, changes, breaks, refused=None):
        self.ending, self.text, self.changes, self.breaks, self.refused = ending, text, changes, breaks, refused

    def texts(self):
        return [self.text] + [change.text for change in self.changes + self.breaks]


def other(rng, value, choices=()):
    """Another valid value of the same kind."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, (int, float)):
        return round(value * 0.5 + 0.11, 6) if value != 0.22 else 0.23
    if isinstance(value, list):
        return [other(rng, value[0])] + value[1:]
    left = [c for c in choices if c != value]
    return rng.choice(left) if left else None


# ---- JSON -----------------------------------------------------------------------------------------------------------

NEUTRAL = {"asset", "version", "generator", "extras", "name", "extensionsUsed", "extensionsRequired", "type", "sampler"}
CHOICES = {"alphaMode": ["OPAQUE", "MASK", "BLEND"], "uri": ["a.png", "b.png", "c.png"], "filename": ["a.png", "b.png"],
           "filter_type": ["bilinear", "nearest"], "wrap_mode": ["repeat", "mirror", "clamp"]}


def snake(name):
    """The key of a shading model for a property of glTF."""
    name = {"diffuseFactor": "baseColorFactor", "glossinessFactor": "roughnessFactor"}.get(name, name)
    return re.sub("([A-Z])", lambda m: "_" + m.group(1).lower(), name.replace("Factor", ""))


def walk(node, path=()):
    """The paths of all members and list entries of objects."""
    if isinstance(node, dict):
        for key, value in node.items():
            yield path + (key,)
            yield from walk(value, path + (key,))
    elif isinstance(node, list) and node and isinstance(node[0], dict):
        for i, value in enumerate(node):
            yield from walk(value, path + (i,))


def at(document, path):
    for key in path:
        document = document[key]
    return document


def with_value(document, path, value):
    """A copy in which the path has the value; None: is gone."""
    new = copy.deepcopy(document)
    if value is None:
        del at(new, path[:-1])[path[-1]]
    else:
        at(new, path[:-1])[path[-1]] = value
    return json.dumps(new)


def json_case(rng, ending, document, is_free, breaks, refused=None, names=lambda path: ()):
    """is_free: of a path that has no effect and need not be named. names: other names of a path. breaks: pairs of a path and a value that is
    wrong there."""
    changes = []
    for path in walk(document):
        value, name = at(document, path), str(path[-1])
        if is_free(path) or value in ({}, False):
            continue
        changes.append(Change("drop", name, with_value(document, path, None), names(path)))
        new = None if isinstance(value, dict) or (isinstance(value, list) and isinstance(value[0], dict)) else other(rng, value, CHOICES.get(name, ()))
        if isinstance(value, int) and not isinstance(value, bool):
            new = None  # an index
        if new is not None:
            changes.append(Change("alter", name, with_value(document, path, new), names(path)))
    return Case(ending, json.dumps(document), changes,
                [Change("break", str(path[-1]), with_value(document, path, value), list(names(path)) + [snake(str(path[-1]))]) for path, value in breaks], refused)


def unit(rng):
    return round(rng.uniform(0.05, 0.95), 3)


def colour(rng, n=3):
    return [unit(rng) for _ in range(n)]


# group: (property, kind); t: texture, n: number, c: colour
GLTF = {"KHR_materials_ior": [("ior", "i")],
        "KHR_materials_specular": [("specularFactor", "n"), ("specularColorFactor", "c"), ("specularTexture", "t"), ("specularColorTexture", "t")],
        "KHR_materials_clearcoat": [("clearcoatFactor", "n"), ("clearcoatRoughnessFactor", "n"), ("clearcoatTexture", "t"),
                                    ("clearcoatRoughnessTexture", "t"), ("clearcoatNormalTexture", "t")],
        "KHR_materials_sheen": [("sheenColorFactor", "c"), ("sheenRoughnessFactor", "n"), ("sheenColorTexture", "t"), ("sheenRoughnessTexture", "t")],
        "KHR_materials_anisotropy": [("anisotropyStrength", "n"), ("anisotropyRotation", "n"), ("anisotropyTexture", "t")],
        "KHR_materials_iridescence": [("iridescenceFactor", "n"), ("iridescenceIor", "i"), ("iridescenceThicknessMinimum", "n"),
                                      ("iridescenceThicknessMaximum", "n"), ("iridescenceTexture", "t"), ("iridescenceThicknessTexture", "t")],
        "KHR_materials_transmission": [("transmissionFactor", "n"), ("transmissionTexture", "t")],
        "KHR_materials_volume": [("thicknessFactor", "n"), ("attenuationDistance", "n"), ("attenuationColor", "c"), ("thicknessTexture", "t")],
        "KHR_materials_dispersion": [("dispersion", "n")],
        "KHR_materials_emissive_strength": [("emissiveStrength", "n")]}
CORE = [("baseColorFactor", "4"), ("metallicFactor", "n"), ("roughnessFactor", "n"), ("baseColorTexture", "t"), ("metallicRoughnessTexture", "t")]
GLOSSY = [("diffuseFactor", "4"), ("specularFactor", "c"), ("glossinessFactor", "n"), ("diffuseTexture", "t"), ("specularGlossinessTexture", "t")]


def gltf(rng):
    n_images = rng.randint(1, 3)

    def texture(**more):
        info = {"index": rng.randrange(n_images), **more}
        if rng.random() < .3:
            info["texCoord"] = 1
        if rng.random() < .3:
            transform = {"offset": [unit(rng), unit(rng)], "rotation": unit(rng), "scale": [1.5, 2.5]}
            info["extensions"] = {"KHR_texture_transform": {k: v for k, v in transform.items() if rng.random() < .7}}
        return info

    def group(properties, p):
        kinds = {"n": lambda: unit(rng), "i": lambda: round(rng.uniform(1.1, 2.4), 3), "c": lambda: colour(rng), "4": lambda: colour(rng) + [1.0], "t": texture}
        return {name: kinds[kind]() for name, kind in properties if rng.random() < p}

    material = {"name": "m"}
    is_glossy = rng.random() < .1
    extensions = {name: group(GLTF[name], .6) for name in GLTF
                  if rng.random() < .25 and not (is_glossy and name in ("KHR_materials_ior", "KHR_materials_specular"))}
    if is_glossy:
        extensions["KHR_materials_pbrSpecularGlossiness"] = group(GLOSSY, .7)
    else:
        material["pbrMetallicRoughness"] = group(CORE, .6)
    if extensions:
        material["extensions"] = extensions
    if rng.random() < .3:
        material["normalTexture"] = texture(**({"scale": 0.5} if rng.random() < .5 else {}))
    if rng.random() < .2:
        material["occlusionTexture"] = texture(**({"strength": 0.5} if rng.random() < .5 else {}))
    if rng.random() < .2:
        material["emissiveFactor"] = [0, 0.5, 0]
    for name, value in (("alphaMode", rng.choice(["OPAQUE", "MASK", "BLEND"])), ("alphaCutoff", .4), ("doubleSided", True)):
        if rng.random() < .2:
            material[name] = value
    document = {"asset": {"version": "2.0", "generator": "sweep"}, "materials": [material],
                "textures": [{"source": i, **({"sampler": 0} if rng.random() < .6 else {})} for i in range(n_images)],
                "samplers": [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9729, "minFilter": 9987}],
                "images": [{"uri": "%s.png" % "abc"[i]} for i in range(n_images)]}
    users = {p[-2]: at(document, p) for p in walk(document) if p[-1] == "index"}
    used = set(users.values())
    uses_sampler = any("sampler" in document["textures"][i] for i in used)

    all_users = list(users) + ["clear coat"] * ("clearcoatNormalTexture" in users) + ["occlusion"] * ("occlusionTexture" in users)

    def names(path):
        more = [key for key in path if str(key).endswith("Texture")]
        if path[0] in ("textures", "images"):  # one of those that use it; the grammar has no unused one beside a used one often
            more = [name for name, i in users.items() if i == path[1]]
            more += ["occlusion"] * ("occlusionTexture" in more) + ["clear coat"] * ("clearcoatNormalTexture" in more)
        if path[-1] == "extensions":  # an empty one
            more.append("")
        if "occlusionTexture" in path:
            more.append("occlusion")
        if "clearcoatNormalTexture" in path:
            more.append("clear coat")
        return more + {"texCoord": ["texture coordinates"], 
                       "thicknessFactor": ["transmission"], "dispersion": ["transmission"], "KHR_materials_dispersion": ["transmission"], "KHR_materials_volume": ["transmission"],
                       "emissiveFactor": ["emission"], "KHR_materials_transmission": ["transmission"], "wrapS": all_users, "wrapT": all_users,
                       "magFilter": all_users, "minFilter": all_users, "iridescenceThicknessMinimum": ["iridescenceThicknessTexture"]}.get(path[-1], [])

    def is_free(path):
        own = path[0] == "materials" or (path[0] in ("textures", "images") and len(path) > 1 and path[1] in used)
        own = own or (path[0] == "samplers" and uses_sampler and len(path) > 1)
        return not own or path[-1] in NEUTRAL or path == ("materials",)

    breaks = []
    for path in walk(material, ("materials", 0)):
        value, name = at(document, path), path[-1]
        if name in ("index",):
            breaks.append((path, 99))
            breaks[-1] = (path[:-1], {"index": 99})
        elif isinstance(value, float):
            breaks.append((path, "x"))
        elif isinstance(value, list) and name.endswith("Factor"):
            breaks.append((path, value + [1, 1]))
        if name in ("metallicFactor", "roughnessFactor", "glossinessFactor", "baseColorFactor"):
            breaks.append((path, -7 if isinstance(value, float) else [-7] + value[1:]))
    gates = [name for name in ("transmissionFactor", "thicknessFactor", "dispersion") if any(name in g for g in extensions.values())]
    return json_case(rng, ".gltf", document, is_free, breaks, gates[0] if gates else None, names)


BLENDER = ("metallic roughness ior diffuse_roughness specular_ior_level anisotropic anisotropic_rotation coat_weight coat_roughness coat_ior "
           "sheen_weight sheen_roughness thin_film_thickness thin_film_ior multiscatter").split()
BLENDER_COLOURS = "base_color specular_tint coat_tint sheen_tint".split()


def blender(rng):
    material = {"type": "blender-principled"}
    for name in BLENDER:
        if rng.random() < .5:
            material[name] = round(rng.uniform(1.1, 2), 3) if name.endswith("ior") else rng.choice([0.0, 1.0]) if name == "multiscatter" else unit(rng)
    for name in BLENDER_COLOURS:
        if rng.random() < .5:
            material[name] = {"type": "rgb", "value": colour(rng)}
    for name in ("subsurface_radius", "subsurface_scale", "emission_color"):
        if rng.random() < .2:
            material[name] = {"type": "rgb", "value": colour(rng)} if name != "subsurface_scale" else unit(rng)
    for name in ("base_color", "roughness"):
        if rng.random() < .3:
            material[name] = {"type": "bitmap", "filename": "a.png", "raw": name == "roughness"}
            material[name].update({k: v for k, v in (("filter_type", "nearest"), ("wrap_mode", "clamp")) if rng.random() < .3})
    document = {"type": "scene", "Gold": material}
    breaks = [(("Gold", name), -7) for name in material if isinstance(material[name], float) and "ior" not in name and name in BLENDER[:4]]
    breaks += [(("Gold", name), {"type": "rgb", "value": [1, 2]}) for name in material if isinstance(material[name], dict) and name in BLENDER_COLOURS]
    # a bitmap's other form: a number, which is another material in any case
    return json_case(rng, ".json", document, lambda path: path[-1] in NEUTRAL or path[0] != "Gold" or len(path) == 1 or path[-1] == "value", breaks)


# ---- files of statements ----------------------------------------------------------------------------------------------


class Text:
    """A file as fixed text and statements: each a name, its text, other texts with another value, and broken ones."""

    def __init__(self):
        self.parts = []

    def add(self, text):
        self.parts.append(text)

    def state(self, name, text, others=(), broken=(), may_go=True, names=()):
        """names: other words that name it."""
        self.parts.append((name, text, others, broken, may_go, names))

    def case(self, ending, refused=None):
        def render(k=-1, text=""):
            return "".join(p if isinstance(p, str) else text if i == k else p[1] for i, p in enumerate(self.parts))

        changes, breaks = [], []
        for k, part in enumerate(self.parts):
            if isinstance(part, str):
                continue
            if part[4] and part[1]:
                changes.append(Change("drop", part[0], render(k), part[5]))
            changes += [Change("alter", part[0], render(k, text), part[5]) for text in part[2]]
            breaks += [Change("break", part[0], render(k, text), part[5]) for text in part[3]]
        return Case(ending, render(), changes, breaks, refused)


# name, kind (f: 0 to 1, i: index of refraction, c: colour, a: turns, t: thickness, z: 0 or refused), separated by blanks
MATERIALX = {
    "standard_surface": "base:f base_color:c diffuse_roughness:f metalness:f specular:f specular_color:c specular_roughness:f specular_IOR:i "
    "specular_anisotropy:f specular_rotation:a sheen:f sheen_color:c sheen_roughness:f coat:f coat_color:c coat_roughness:f coat_anisotropy:f "
    "coat_rotation:a coat_IOR:i coat_affect_color:f coat_affect_roughness:f thin_film_thickness:t thin_film_IOR:i transmission:z subsurface:z emission:z "
    "transmission_color:c transmission_depth:f transmission_scatter:c transmission_scatter_anisotropy:f transmission_dispersion:f "
    "transmission_extra_roughness:f subsurface_color:c subsurface_radius:c subsurface_scale:f subsurface_anisotropy:f emission_color:c",
    "open_pbr_surface": "base_weight:f base_color:c base_diffuse_roughness:f base_metalness:f specular_weight:f specular_color:c specular_roughness:f "
    "specular_roughness_anisotropy:f specular_ior:i fuzz_weight:f fuzz_color:c fuzz_roughness:f coat_weight:f coat_color:c coat_roughness:f "
    "coat_roughness_anisotropy:f coat_ior:i coat_darkening:f thin_film_weight:f thin_film_thickness:f thin_film_ior:i transmission_weight:z "
    "subsurface_weight:z emission_luminance:z transmission_color:c transmission_depth:f transmission_scatter:c transmission_scatter_anisotropy:f "
    "transmission_dispersion_scale:f transmission_dispersion_abbe_number:f subsurface_color:c subsurface_radius:f subsurface_radius_scale:c "
    "subsurface_scatter_anisotropy:f emission_color:c",
    "gltf_pbr": "base_color:c metallic:f roughness:f anisotropy_strength:f anisotropy_rotation:a ior:i specular:f specular_color:c clearcoat:f "
    "clearcoat_roughness:f sheen_color:c sheen_roughness:f iridescence:f iridescence_ior:i iridescence_thickness:t transmission:z alpha:f "
    "alpha_cutoff:f emissive_strength:f thickness:f attenuation_distance:f attenuation_color:c occlusion:f",
    "UsdPreviewSurface": "diffuseColor:c specularColor:c metallic:f roughness:f clearcoat:f clearcoatRoughness:f ior:i opacityThreshold:f occlusion:f",
    "disney_principled": "baseColor:c metallic:f roughness:f anisotropic:f specular:f specularTint:f sheen:f sheenTint:f clearcoat:f clearcoatGloss:f "
    "specTrans:z subsurface:z ior:i subsurfaceDistance:c"}


# node: (input that is connected, (input, value, other value))
OPERATIONS = {"multiply": ("in1", [("in2", "0.5", "0.25")]), "add": ("in1", [("in2", "0.1", "0.2")]), "subtract": ("in1", [("in2", "0.1", "0.2")]),
              "divide": ("in1", [("in2", "2", "3")]), "power": ("in1", [("in2", "2.2", "2")]), "invert": ("in", [("amount", "0.9", "0.8")]),
              "clamp": ("in", [("low", "0.1", "0.2"), ("high", "0.8", "0.9")]), "mix": ("fg", [("bg", "0.3", "0.4"), ("mix", "0.5", "0.6")]),
              "remap": ("in", [("inlow", "0.1", "0.2"), ("inhigh", "0.8", "0.9"), ("outlow", "0.2", "0.3"), ("outhigh", "0.7", "0.75")]),
              "smoothstep": ("in", [("low", "0.1", "0.2"), ("high", "0.8", "0.9")]), "min": ("in1", [("in2", "0.5", "0.4")]),
              "range": ("in", [("inlow", "0.1", "0.2"), ("gamma", "1.5", "1.8"), ("outhigh", "0.7", "0.75")]),
              "contrast": ("in", [("amount", "1.5", "1.8"), ("pivot", "0.4", "0.3")]), "max": ("in1", [("in2", "0.5", "0.4")]),
              "saturate": ("in", [("amount", "0.5", "0.4")]), "hsvadjust": ("in", [("amount", "0.5", "0.4")])}


def values(rng, kind):
    """Two values as texts, and one out of the range or "" where there is none."""
    if kind == "c":
        return [", ".join("%g" % x for x in colour(rng)) for _ in range(2)], "-1, 0, 0"
    if kind == "z":
        return ["0", "0.4"], ""
    low, high, beyond = {"f": (.05, .95, ""), "i": (1.55, 2.2, "-3"), "a": (.05, .95, ""), "t": (50, 900, "-1")}[kind]
    return ["%.4g" % rng.uniform(low, (low + high) / 2), "%.4g" % rng.uniform((low + high) / 2, high)], beyond


def materialx(rng):
    surface = rng.choice(list(MATERIALX))
    t = Text()
    t.add('<?xml version="1.0"?>\n<materialx version="1.38" colorspace="lin_rec709">\n')
    inputs = [p.split(":") for p in MATERIALX[surface].split() if rng.random() < .4]
    mapped = {name: kind for name, kind in inputs if kind in "fc" and rng.random() < .15}
    if mapped:
        t.add('<nodegraph name="g">\n')
    for k, (name, kind) in enumerate(mapped.items()):
        kind = "color3" if kind == "c" else "float"
        node = rng.choice(["image", "tiledimage"])
        t.add('<%s name="i%d" type="%s">\n' % (node, k, kind))
        line = '<input name="%s" type="%s" value="%s"%s/>\n'
        t.state("file", line % ("file", "filename", "a.png", ""), [line % ("file", "filename", "b.png", "")], names=[name])
        space = ' colorspace="srgb_texture"'
        if kind == "color3":
            t.parts[-1] = ("file", line % ("file", "filename", "a.png", space), [line % ("file", "filename", "a.png", "")], [], True, [name])
        if node == "tiledimage":
            t.state("uvtiling", line % ("uvtiling", "vector2", "2, 3", ""), [line % ("uvtiling", "vector2", "4, 3", "")],
                    [line % ("uvtiling", "vector2", "2, x", "")], names=[name])
        else:
            for mode in ("uaddressmode", "vaddressmode"):
                if rng.random() < .5:
                    t.state(mode, line % (mode, "string", "clamp", ""), [line % (mode, "string", "mirror", "")], [line % (mode, "string", "wild", "")], names=[name])
        if rng.random() < .3:
            t.state("filtertype", line % ("filtertype", "string", "cubic", ""), names=[name])
        t.add("</%s>\n" % node)
        if rng.random() < .6:
            operation = rng.choice([o for o in OPERATIONS if kind == "color3" or o not in ("saturate", "hsvadjust")])
            t.add('<%s name="x%d" type="%s"><input name="%s" type="%s" nodename="i%d"/>\n' % (operation, k, kind, OPERATIONS[operation][0], kind, k))
            for operand, value, new in OPERATIONS[operation][1]:
                own = "float" if kind == "float" or (operand in ("mix", "amount", "gamma") and operation in ("mix", "saturate")) else "vector3" if operation == "hsvadjust" else kind
                wide = (lambda v: v) if own == "float" else (lambda v: ", ".join([v] * 3))
                t.state(operand, line % (operand, own, wide(value), ""), [line % (operand, own, wide(new), "")], [line % (operand, own, "a", "")], names=[name])
            if rng.random() < .1:
                t.state("wobble", line % ("wobble", "float", "0.5", ""), names=[name])
            t.add("</%s>\n" % operation)
            t.add('<output name="o%d" type="%s" nodename="x%d"/>\n' % (k, kind, k))
        else:
            t.add('<output name="o%d" type="%s" nodename="i%d"/>\n' % (k, kind, k))
    if mapped:
        t.add("</nodegraph>\n")
    t.add('<%s name="s" type="surfaceshader">\n' % surface)
    for name, kind in inputs:
        kind_name = "color3" if kind == "c" else "float"
        line = '<input name="%s" type="%s" value="%%s"/>\n' % (name, kind_name)
        if name in mapped:
            k = list(mapped).index(name)
            t.state(name, '<input name="%s" type="%s" nodegraph="g" output="o%d"/>\n' % (name, kind_name, k), [line % "0.5, 0.5, 0.5" if kind == "c" else line % "0.5"],
                    ['<input name="%s" type="%s" nodegraph="g" output="none"/>\n' % (name, kind_name)])
            continue
        (value, new), beyond = values(rng, kind)
        t.state(name, line % value, [line % new], [line % "x"] if kind != "z" else [], kind != "z")
        if beyond and rng.random() < .5 and not name.startswith(("subsurface", "transmission", "emission", "attenuation")) and name not in (
                "thin_film_thickness", "iridescence_thickness", "ior"):
            t.parts[-1] = t.parts[-1][:3] + ([line % beyond],) + t.parts[-1][4:]
    t.state("unknown_input", "", (), ['<input name="unknown_input" type="float" value="1"/>\n'])
    t.add('</%s>\n<surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>\n</materialx>\n' % surface)
    return t.case(".mtlx")


USD_KINDS = {"f": "float", "i": "float", "c": "color3f"}


def usd(rng):
    t = Text()
    t.add('#usda 1.0\n(\n    defaultPrim = "Looks"\n    upAxis = "Y"\n)\ndef Scope "Looks"\n{\n    def Material "M"\n    {\n')
    t.add("        token outputs:surface.connect = </Looks/M/S.outputs:surface>\n")
    inputs = [p.split(":") for p in MATERIALX["UsdPreviewSurface"].split() if rng.random() < .6]
    interface = Text()
    mapped = {name: kind for name, kind in inputs if kind in "fc" and rng.random() < .25 and name not in ("occlusion", "opacityThreshold")}
    place = len(t.parts)
    t.add('        def Shader "S"\n        {\n            uniform token info:id = "UsdPreviewSurface"\n')
    for name, kind in inputs:
        line = "            %s inputs:%s = %%s\n" % (USD_KINDS[kind], name)
        if name in mapped:
            t.state(name, "            %s inputs:%s.connect = </Looks/M/T_%s.outputs:%s>\n" % (USD_KINDS[kind], name, name, "rgb" if kind == "c" else "r"),
                    [line % ("(0.5, 0.4, 0.3)" if kind == "c" else "0.5")],
                    ["            %s inputs:%s.connect = </Looks/M/None.outputs:r>\n" % (USD_KINDS[kind], name)])
        else:
            (value, new), _ = values(rng, kind)
            form = "(%s)" if kind == "c" else "%s"
            way = rng.random()
            if way < .2:  # an interface input of the material
                own = "        %s inputs:own_%s = %%s\n" % (USD_KINDS[kind], name)
                interface.state("own_" + name, own % (form % value), [own % (form % new)], names=[name])
                t.state(name, "            %s inputs:%s.connect = </Looks/M.inputs:own_%s>\n" % (USD_KINDS[kind], name, name), [line % (form % "0.01, 0.02, 0.03" if kind == "c" else "0.01")])
            elif way < .3:  # the first of several values
                sampled = "            %s inputs:%s.timeSamples = { 0: %%s, 10: %%s }\n" % (USD_KINDS[kind], name)
                t.state(name, sampled % (form % value, form % new), [sampled % (form % new, form % value)])
            else:
                t.state(name, line % (form % value), [line % (form % new)], [line % '"x"'])
    if rng.random() < .2:
        t.state("useSpecularWorkflow", "            int inputs:useSpecularWorkflow = 1\n", ["            int inputs:useSpecularWorkflow = 0\n"])
    t.add("            token outputs:surface\n        }\n")
    has_reader = False
    for name, kind in mapped.items():
        t.add('        def Shader "T_%s"\n        {\n            uniform token info:id = "UsdUVTexture"\n' % name)
        line = "            %s inputs:%s = %s\n"
        t.state("file", line % ("asset", "file", "@a.png@"), [line % ("asset", "file", "@b.png@")], names=[name])
        if rng.random() < .6:
            space = rng.choice(["raw", "sRGB"])
            t.state("sourceColorSpace", line % ("token", "sourceColorSpace", '"%s"' % space),
                    [line % ("token", "sourceColorSpace", '"%s"' % ("sRGB" if space == "raw" else "raw"))], [line % ("token", "sourceColorSpace", '"wild"')], names=[name])
        for wrap in ("wrapS", "wrapT"):
            if rng.random() < .5:
                t.state(wrap, line % ("token", wrap, '"clamp"'), [line % ("token", wrap, '"mirror"')], [line % ("token", wrap, '"wild"')], names=[name])
        for way, value, new in (("scale", "(0.5, 0.6, 0.7, 1)", "(0.2, 0.3, 0.4, 1)"), ("bias", "(0.1, 0.2, 0.3, 0)", "(0.2, 0.1, 0.1, 0)")):
            if rng.random() < .3:
                t.state(way, line % ("float4", way, value), [line % ("float4", way, new)], names=[name])
        if rng.random() < .3:
            t.state("fallback", line % ("float4", "fallback", "(0.5, 0.5, 0.5, 1)"), names=[name])
        if rng.random() < .5:
            has_reader = True
            t.state("st", "            float2 inputs:st.connect = </Looks/M/X.outputs:result>\n", names=[name])
        t.add("            float3 outputs:rgb\n            float outputs:r\n        }\n")
    if has_reader:
        t.add('        def Shader "X"\n        {\n            uniform token info:id = "UsdTransform2d"\n')
        t.add("            float2 inputs:in.connect = </Looks/M/R.outputs:result>\n")
        t.state("rotation", "            float inputs:rotation = 30\n", ["            float inputs:rotation = 40\n"])
        t.state("scale", "            float2 inputs:scale = (2, 3)\n", ["            float2 inputs:scale = (2, 4)\n"])
        t.state("translation", "            float2 inputs:translation = (0.1, 0.2)\n", ["            float2 inputs:translation = (0.1, 0.3)\n"])
        t.add('            float2 outputs:result\n        }\n        def Shader "R"\n        {\n            uniform token info:id = "UsdPrimvarReader_float2"\n')
        t.add('            string inputs:varname = "st"\n')
        t.state("fallback", "            float2 inputs:fallback = (0.1, 0.2)\n")
        t.add('            float2 outputs:result\n        }\n')
    t.add("    }\n}\n")
    t.parts[place:place] = interface.parts
    return t.case(".usda")


# type: (name, kind) as above; d: distribution; m: name of a metal; b: flag
MITSUBA = {"principled": "base_color:c roughness:f anisotropic:f metallic:f specular:f spec_tint:f sheen:f sheen_tint:f flatness:f clearcoat:f "
           "clearcoat_gloss:f main_specular_sampling_rate:f",
           "roughplastic": "alpha:f distribution:d int_ior:i ext_ior:i diffuse_reflectance:c specular_reflectance:c nonlinear:b sample_visible:b",
           "plastic": "int_ior:i diffuse_reflectance:c specular_reflectance:c nonlinear:b",
           "roughconductor": "alpha:f distribution:d material:m specular_reflectance:c sample_visible:b",
           "conductor": "material:m specular_reflectance:c", "diffuse": "reflectance:c"}


def mitsuba(rng):
    kind = rng.choice(list(MITSUBA))
    t = Text()
    t.add('<scene version="3.0.0">\n')
    wrapper = rng.choice([None, None, "twosided", "normalmap", "blendbsdf"])
    t.add('<bsdf type="%s" id="m">\n<bsdf type="%s">\n' % (wrapper, kind) if wrapper else '<bsdf type="%s" id="m">\n' % kind)
    for name, form in (p.split(":") for p in MITSUBA[kind].split()):
        if rng.random() < .4:
            continue
        if form == "c" and rng.random() < .25 and wrapper != "blendbsdf":
            t.add('<texture name="%s" type="bitmap">\n' % name)
            t.state("filename", '<string name="filename" value="a.png"/>\n', ['<string name="filename" value="b.png"/>\n'])
            for word, tag, value, new in (("raw", "boolean", "true", "false"), ("wrap_mode", "string", "clamp", "mirror"), ("filter_type", "string", "nearest", "bilinear")):
                if rng.random() < .4:
                    line = '<%s name="%s" value="%%s"/>\n' % (tag, word)
                    t.state(word, line % value, [line % new], [line % "wild"])
            if rng.random() < .4:
                t.state("to_uv", '<transform name="to_uv"><scale x="2" y="3"/></transform>\n', ['<transform name="to_uv"><scale x="2" y="4"/></transform>\n'])
            t.add("</texture>\n")
            continue
        tag = {"c": "rgb", "d": "string", "m": "string", "b": "boolean"}.get(form, "float")
        if name == "ext_ior":
            form = "e"
        pair, beyond = {"e": (["1.01", "1.05"], "-1"), "d": (["ggx", "beckmann"], ""), "m": (["Au", "Cu"], "Unobtainium"), "b": (["true", "false"], "")}.get(form) or values(rng, form)
        line = '<%s name="%s" value="%%s"/>\n' % (tag, name)
        if form == "d":
            pair = ["ggx", "ggx"]
        is_free = name in ("sample_visible", "main_specular_sampling_rate")
        t.state(name, line % pair[0], [] if form == "d" else [line % pair[1]], [line % (beyond or "wild")] if not is_free else [],
                name != "distribution", ["kd"] if kind == "diffuse" else [])
    if kind != "diffuse":
        t.state("unheard_of", "", [], ['<float name="unheard_of" value="1"/>\n'])
    t.add("</bsdf>\n")
    if wrapper == "normalmap":
        t.add('<texture name="normalmap" type="bitmap">\n')
        t.state("filename", '<string name="filename" value="n.png"/>\n', ['<string name="filename" value="m.png"/>\n'])
        t.state("raw", '<boolean name="raw" value="true"/>\n', ['<boolean name="raw" value="false"/>\n'])
        t.add("</texture>\n")
    if wrapper == "blendbsdf":
        t.add('<bsdf type="diffuse">\n')
        t.state("reflectance", '<rgb name="reflectance" value="0.1, 0.2, 0.3"/>\n', ['<rgb name="reflectance" value="0.2, 0.2, 0.3"/>\n'])
        t.add("</bsdf>\n")
        t.state("weight", '<float name="weight" value="0.4"/>\n', ['<float name="weight" value="0.5"/>\n'], ['<float name="weight" value="wild"/>\n'])
    t.add("</bsdf>\n</scene>\n" if wrapper else "</scene>\n")
    return t.case(".xml")


PBRT = {"diffuse": "reflectance:c", "coateddiffuse": "reflectance:c roughness:f eta:i thickness:f maxdepth:n nsamples:n g:f",
        "conductor": "roughness:f spectrum", "dielectric": "",
        "coatedconductor": "interface.roughness:f conductor.roughness:f interface.eta:i thickness:f maxdepth:n nsamples:n"}


def pbrt(rng):
    kind = rng.choice([k for k in PBRT if k != "dielectric"])
    t = Text()
    body = Text()
    body.add('MakeNamedMaterial "m"\n    "string type" "%s"\n' % kind)
    if kind == "conductor":
        line = '    "spectrum eta" "%s"\n    "spectrum k" "%s"\n'
        body.state("eta", line % ("metal-Au-eta", "metal-Au-k"), [line % ("metal-Cu-eta", "metal-Cu-k")], [line % ("metal-Xy-eta", "metal-Xy-k")])
    for item in PBRT[kind].split():
        name, _, form = item.partition(":")
        if not form or rng.random() < .4:
            continue
        if form == "c" and rng.random() < .4 or form == "f" and name == "roughness" and rng.random() < .2:
            is_colour = form == "c"
            t.add('Texture "t_%s" "%s" "imagemap"\n' % (name, "spectrum" if is_colour else "float"))
            t.state("filename", '    "string filename" "a.png"\n', ['    "string filename" "b.png"\n'])
            for word, line, value, new, wrong in (
                    ("scale", '    "float scale" [ %s ]\n', "0.5", "0.25", '"x"'), ("uscale", '    "float uscale" [ %s ]\n', "2", "3", '"x"'),
                    ("vdelta", '    "float vdelta" [ %s ]\n', "0.2", "0.3", '"x"'), ("invert", '    "bool invert" %s\n', "true", "false", "1"),
                    ("wrap", '    "string wrap" "%s"\n', "clamp", "repeat", "wild"), ("encoding", '    "string encoding" "%s"\n', "linear", "sRGB", "wild"),
                    ("filter", '    "string filter" "%s"\n', "point", "trilinear", "")):
                if rng.random() < .3:
                    t.state(word, line % value, [line % new], [line % wrong] if wrong else [])
            used = "t_" + name
            if rng.random() < .4:
                used = "u_" + name
                t.add('Texture "%s" "%s" "%s"\n' % (used, "spectrum" if is_colour else "float", rng.choice(["scale", "mix"])))
                if '"mix"' in t.parts[-1]:
                    t.add('    "texture tex1" "t_%s"\n' % name)
                    t.state("tex2", '    "%s tex2" [ %s ]\n' % (("rgb", "0.1 0.2 0.3") if is_colour else ("float", "0.2")),
                            ['    "%s tex2" [ %s ]\n' % (("rgb", "0.2 0.2 0.3") if is_colour else ("float", "0.3"))])
                    t.state("amount", '    "float amount" [ 0.3 ]\n', ['    "float amount" [ 0.4 ]\n'], ['    "float amount" [ "x" ]\n'])
                else:
                    t.add('    "texture tex" "t_%s"\n' % name)
                    t.state("scale", '    "float scale" [ 0.3 ]\n', ['    "float scale" [ 0.4 ]\n'], ['    "float scale" [ "x" ]\n'])
                t.state("wobble", "", [], ['    "float wobble" [ 0.4 ]\n'])
            body.state(name, '    "texture %s" "%s"\n' % (name, used), [], ['    "texture %s" "none"\n' % name])
            continue
        tag = {"c": "rgb", "b": "bool", "n": "integer"}.get(form, "float")
        pair, _ = {"b": (["true", "false"], ""), "n": (["7", "9"], "")}.get(form) or values(rng, form)
        line = '    "%s %s" [ %%s ]\n' % (tag, name)
        body.state(name, line % pair[0].replace(",", ""), [line % pair[1].replace(",", "")], [line % '"wild"'] if name not in ("g", "nsamples") else [])
        if name == "roughness":
            body.state("remaproughness", '    "bool remaproughness" false\n', ['    "bool remaproughness" true\n'], ['    "bool remaproughness" 7\n'])
    body.state("unheard_of", "", [], ['    "float unheard_of" [ 1 ]\n'])
    t.parts += body.parts
    t.add('AttributeBegin\nNamedMaterial "m"\nShape "sphere"\nAttributeEnd\n')
    return t.case(".pbrt")


# ---- folders of maps, lists of directions, BSDF tables ------------------------------------------------------------------

FOLDERS = ["_Color _Roughness _Metalness _NormalGL _AmbientOcclusion _Displacement", "_basecolor _occlusionRoughnessMetallic _normal",
           "_AlbedoTransparency _MetallicSmoothness _Normal", "_BC _N _ORM", "_COL_2K _GLOSS_2K _NRM_2K", "_diff_2k _rough_2k _nor_gl_2k _arm_2k _disp_2k",
           "_baseColor _metallic _roughness _normal _height", "_Diffuse _Glossiness _normals _specular",
           "_albedo _roughness _metalness _ao _normal-ogl", "_Base_Color _Metallic _Roughness _Normal_OpenGL _Height _Mixed_AO", "-albedo -metallic -roughness -normal-dx",
           "_BC _Roughness _M _N _AO", "_basecolor _orm _normal _emissive _opacity"]


def folder(rng):
    names = rng.choice(FOLDERS).split()
    names = names[:1] + [name for name in names[1:] if rng.random() < .8]
    t = Text()
    for name in names:
        t.state("wood" + name, "wood%s.png " % name, may_go=len(names) > 1)
    if rng.random() < .3:
        extra = rng.choice(["_preview", "_wobble", "_mask3"])
        t.state("wood" + extra, "wood%s.png " % extra)
    return t.case("")


PAIRS = [["theta_i", "phi_i", "theta_o", "phi_o"], ["theta_in", "phi_in", "theta_r", "phi_r"], ["Theta_l", "Phi_l", "Theta_v", "Phi_v"],
         ["theta_s", "phi_s", "theta_v", "phi_v"]]
VALUES = [["r", "g", "b"], ["R", "G", "B"], ["X", "Y", "Z"], ["brdf"], ["450nm", "550nm", "650nm"], ["luminance"]]
EXTRA = ["sample", "sigma", "time_s", "comment"]


def csv(rng):
    is_half = rng.random() < .3
    angles, shown = ["theta_h", "theta_d", "phi_d"] if is_half else rng.choice(PAIRS), rng.choice(VALUES)
    unit_of = rng.choice(["", " (deg)", " [deg]", "_deg"])
    columns = [(name + unit_of, "angle") for name in angles] + [(name, "value") for name in shown]
    columns += [(name, "extra") for name in EXTRA if rng.random() < .25]
    if "450nm" not in shown:
        rng.shuffle(columns)
    rows = []
    for theta_i, theta, phi in itertools.product((0, 40, 80), range(0, 81, 20), range(0, 181, 60)):
        at_angle = dict(zip(angles, (theta_i, theta, phi) if is_half else (theta_i, 0, theta, phi)))
        rows.append([at_angle.get(name[:len(name) - len(unit_of)] if unit_of else name, "") if kind == "angle" else "%.4f" % rng.uniform(.1, 2)
                     if kind == "value" else "7" for name, kind in columns])

    def render(rows, skip=-1, header=None):
        lines = [header or [name for name, _ in columns]] + rows
        return "\n".join(",".join(str(x) for i, x in enumerate(line) if i != skip) for line in lines) + "\n"

    def with_cell(row, column, value):
        return render([line[:column] + [value] + line[column + 1:] if i == row else line for i, line in enumerate(rows)])

    row, changes, breaks = rng.randrange(len(rows)), [], []
    for i, (name, kind) in enumerate(columns):
        changes.append(Change("drop", name.split(" ")[0], render(rows, i)))
        changes.append(Change("alter", name.split(" ")[0], render([line[:i] + [3.5 if kind == "value" else other(rng, line[i])] + line[i + 1:] for line in rows])))
        if kind != "extra":
            breaks.append(Change("break", name.split(" ")[0], with_cell(row, i, "abc")))
    changes.append(Change("drop row", "row", render(rows[:row] + rows[row + 1:])))
    changes.append(Change("empty row", "without a value", render([[("" if columns[i][1] == "value" else x) for i, x in enumerate(line)] if k == row else line
                                                                   for k, line in enumerate(rows)])))
    twice = [name for name, _ in columns] + [columns[[k for _, k in columns].index("value")][0]]
    breaks.append(Change("give twice", twice[-1].split(" ")[0], render([line + ["1"] for line in rows], header=twice), ["wavelengths"]))
    return Case(".csv", render(rows), changes, breaks)


def zemax(rng):
    t = Text()
    n = rng.choice([3, 4])
    t.add("# made by a test\n")
    t.state("Source", "Source  Measured\n", ["Source  Simulated\n"])
    t.state("Symmetry", "Symmetry  PlaneSymmetrical\n", ["Symmetry  ASymmetrical\n"], ["Symmetry  Wild\n"], names=["kind of table"])
    t.state("SpectralContent", "SpectralContent  Monochrome\n", [], ["SpectralContent  Wild\n"], False, ["kind of table"])
    t.state("ScatterType", "ScatterType  BRDF\n", [], ["ScatterType  BTDF\n"], False, ["kind of table"])
    t.add("SampleRotation  1\n0\nAngleOfIncidence  %d\n%s\nScatterAzimuth  3\n0 90 180\n" % (n, " ".join(str(25 * i) for i in range(n))))
    t.state("ScatterRadial", "ScatterRadial  3\n0 30 60\n", ["ScatterRadial  3\n0 40 60\n"], ["ScatterRadial  3\n0 60 30\n", "ScatterRadial  x\n"], names=["angles do not rise", "not a number of its range"])
    t.add("Monochrome\nDataBegin\n")
    for i in range(n):
        t.state("TIS", "TIS  0.5\n", ["TIS  0.4\n"], [])
        for _ in range(3):
            numbers = ["%.3f" % rng.uniform(.1, 2) for _ in range(3)]
            t.state("number", " ".join(numbers) + "\n", [" ".join(["9"] + numbers[1:]) + "\n"], [" ".join(["x"] + numbers[1:]) + "\n"])
    t.state("DataEnd", "DataEnd\n", may_go=True)
    return t.case(".bsdf")


FORMATS = {"gltf": gltf, "blender": blender, "materialx": materialx, "usd": usd, "mitsuba": mitsuba, "pbrt": pbrt, "folder": folder, "csv": csv, "zemax": zemax}


def make(name, seed, i):
    """File i of a format."""
    return FORMATS[name](random.Random("%s %d %d" % (name, seed, i)))
