#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""The published translation graphs of MaterialX, applied to one material: the baseline of the study in doc/materials.md.

usage: studies/translation_graphs.py DEFINITIONS MATERIAL TARGET

DEFINITIONS is the folder with MaterialX's *_to_*.mtlx; MATERIAL a spec or a material file that nqm reads (FILE or FILE:NAME), of the
shading model open-pbr or standard-surface; TARGET is open-pbr, standard-surface, gltf or usd-preview. Prints the spec of the target.
Where no graph leads from one to the other, it goes through standard-surface. The node graphs are interpreted with the material's
constants. Outputs that are no keys of nqm's shading model (transmission, thin films) are dropped, and values are moved into the
range that nqm accepts, with a note on standard error. The tool is NQM_TOOL, default build/nqm. Python's standard library only."""
import math
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as xml

# model: its name in the files; (graph file, target model) of its translations
NODES = {"open-pbr": "open_pbr_surface", "standard-surface": "standard_surface", "gltf": "gltf_pbr", "usd-preview": "UsdPreviewSurface"}
GRAPHS = {"open-pbr": {"standard-surface": "open_pbr_to_standard_surface.mtlx"},
          "standard-surface": {"open-pbr": "standard_surface_to_open_pbr.mtlx", "gltf": "standard_surface_to_gltf_pbr.mtlx",
                               "usd-preview": "standard_surface_to_usd.mtlx"}}


class Failure(Exception):
    pass


# ---- nodes: a value is a tuple of floats ----------------------------------------------------------------------------


def divide(a, b):
    """As IEEE 754: graphs divide by 0 on branches that they do not take."""
    if b:
        return a / b
    return math.nan if a == 0 or math.isnan(a) else math.copysign(math.inf, a)


def power(a, b):
    try:
        value = a**b
    except (ZeroDivisionError, OverflowError):
        return math.inf
    return math.nan if isinstance(value, complex) else value


def by_component(function):
    """A node that works on each component; numbers count for all of them."""
    def apply(**inputs):
        n = max(map(len, inputs.values()))
        return tuple(function(**{k: v[i] if len(v) > 1 else v[0] for k, v in inputs.items()}) for i in range(n))
    return apply


def choose(compare):
    return lambda value1, value2, in1, in2: in1 if compare(value1[0], value2[0]) else in2


def roughness_anisotropy(roughness=(0,), anisotropy=(0,)):
    square, aspect = roughness[0]**2, math.sqrt(1 - min(max(anisotropy[0], 0), 0.98))
    return (min(square / aspect, 1), square * aspect)


def luminance(**inputs):
    weights = inputs.get("lumacoeffs", (0.2722287, 0.6740818, 0.0536895))
    return (sum(w * c for w, c in zip(weights, inputs["in"])),) * 3


def separate(**inputs):
    return dict(zip(("outx", "outy", "outz"), ((v,) for v in inputs["in"])))


def unary(function):
    """Of the input `in`, which is a keyword of Python."""
    return by_component(lambda **inputs: function(inputs["in"]))


OPERATIONS = {
    "constant": lambda value: value,
    "dot": lambda **inputs: inputs["in"],
    "convert": lambda **inputs: inputs["in"],
    "add": by_component(lambda in1, in2: in1 + in2),
    "subtract": by_component(lambda in1, in2: in1 - in2),
    "multiply": by_component(lambda in1, in2: in1 * in2),
    "divide": by_component(lambda in1, in2: divide(in1, in2)),
    "power": by_component(lambda in1, in2: power(in1, in2)),
    "min": by_component(lambda in1, in2: min(in1, in2)),
    "max": by_component(lambda in1, in2: max(in1, in2)),
    "mix": by_component(lambda fg, bg, mix: bg * (1 - mix) + fg * mix),
    "invert": by_component(lambda amount=1.0, **inputs: amount - inputs["in"]),
    "clamp": by_component(lambda low=0.0, high=1.0, **inputs: min(max(inputs["in"], low), high)),
    "sqrt": unary(lambda v: math.sqrt(v) if v >= 0 else math.nan),
    "absval": unary(abs),
    "dotproduct": lambda in1, in2: (sum(a * b for a, b in zip(in1, in2)),),
    "extract": lambda index, **inputs: (inputs["in"][int(index[0])],),
    "separate2": separate,
    "separate3": separate,
    "ifgreater": choose(lambda a, b: a > b),
    "ifgreatereq": choose(lambda a, b: a >= b),
    "ifequal": choose(lambda a, b: a == b),
    "luminance": luminance,
    "roughness_anisotropy": roughness_anisotropy,
}


def number(text):
    return {"true": 1.0, "false": 0.0}.get(text) if text in ("true", "false") else float(text)


SIZES = {"color3": 3, "vector3": 3, "vector2": 2}


def parse(text, kind):
    values = tuple(number(v.strip()) for v in text.split(","))
    return values * SIZES.get(kind, 1) if len(values) == 1 else values


class Graph:
    """A node graph with values of its interface."""

    def __init__(self, path, interface):
        root = xml.parse(path).getroot()
        definition, graph = root.find("nodedef"), root.find("nodegraph")
        self.path, self.nodes, self.known = path, {node.get("name"): node for node in graph if node.tag != "output"}, {}
        self.outputs = {node.get("name"): node for node in graph.findall("output")}
        self.interface = {i.get("name"): parse(i.get("value"), i.get("type")) for i in definition.findall("input") if i.get("value")}
        names = {i.get("name") for i in definition.findall("input")}
        self.interface.update({k: v for k, v in interface.items() if k in names})

    def value(self, reference):
        """Of an input or output: a constant, an input of the graph, or (an output of) a node."""
        name = reference.get("interfacename")
        if name:
            return self.interface.get(name, (0.0, 0.0, 1.0))  # a geometric property: normal, tangent
        if reference.get("nodename"):
            result = self.node(reference.get("nodename"))
            return result[reference.get("output")] if isinstance(result, dict) else result
        return parse(reference.get("value"), reference.get("type"))

    def node(self, name):
        if name not in self.known:
            node = self.nodes[name]
            if node.tag not in OPERATIONS:
                raise Failure(f"{self.path}: the node {node.tag} is not known")
            result = OPERATIONS[node.tag](**{i.get("name"): self.value(i) for i in node.findall("input")})
            size = SIZES.get(node.get("type"), 1)
            if not isinstance(result, dict) and len(result) != size:
                result = result * size if len(result) == 1 else result[:size]
            self.known[name] = result
        return self.known[name]

    def results(self):
        """By the input of the target that each is meant for."""
        return {name.removesuffix("_out"): self.value(output) for name, output in self.outputs.items()}


# ---- specs ----------------------------------------------------------------------------------------------------------


def run_nqm(*arguments):
    result = subprocess.run([os.environ.get("NQM_TOOL", "build/nqm"), *arguments], capture_output=True, text=True, check=False)
    if result.returncode:
        raise Failure(result.stderr.strip())
    return result.stdout


def canonical(argument):
    """The spec with every key of its model, also for a file."""
    return re.search(r"^spec +(.*)$", run_nqm("info", argument), re.M).group(1)


def split(spec):
    model, _, settings = spec.partition(":")
    pairs = (setting.split("=") for setting in settings.split(";"))
    return model, {key: tuple(map(float, text.split(","))) for key, text in pairs}


def join(model, values):
    return f"{model}:" + ";".join(f"{k}=" + ",".join(repr(x) for x in (v if len(set(v)) > 1 else v[:1])) for k, v in values.items())


FILM = ("iridescence_ior", "iridescence_thickness")


def limit(model, key, values, note):
    """Colours and weights of glTF and USD end at 1; nothing is negative."""
    high = 1 if model in ("gltf", "usd-preview") and key not in ("ior", "specular_color", *FILM) else math.inf
    limited = tuple(min(max(v, 0.0), high) for v in values)
    if limited != values:
        note(f"{model}: {key} = {values} becomes {limited}")
    return limited


def translate(definitions, spec, target, note):
    model, values = split(spec)
    if model == target:
        return spec
    following = target if target in GRAPHS.get(model, ()) else "standard-surface"
    if following not in GRAPHS.get(model, ()):
        raise Failure(f"there is no published translation from {model} to {target}")
    defaults = split(canonical(following + ":"))[1]
    colors = {k for k in re.findall(r"(\w+) \(RGB\)", run_nqm("info", model + ":"))}
    interface = {k: v * 3 if k in colors and len(v) == 1 else v for k, v in values.items()}
    graph = Graph(os.path.join(definitions, GRAPHS[model][following]), interface)
    results = {k: limit(following, k, v, note) for k, v in graph.results().items() if k in defaults}
    # properties that the graph says nothing of keep the defaults of the target
    return translate(definitions, canonical(join(following, defaults | results)), target, note)


def main():
    if len(sys.argv) != 4 or sys.argv[3] not in NODES:
        sys.exit(__doc__)
    definitions, material, target = sys.argv[1:]
    try:
        spec = canonical(material)
        print(translate(definitions, spec, target, lambda text: print(text, file=sys.stderr)))
    except Failure as failure:
        sys.exit(str(failure))


if __name__ == "__main__":
    main()
