#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Write the pairs of the standard corpus, the input of `nqm dataset`, to standard output.

usage: models/plan.py materials.csv [--root DATA] [options] > pairs.csv

materials.csv has the columns name, group, brdf, source and split (models/scan.py writes one). Each of its references gets tests of
eight families (doc/corpus.md): encodings, published parameters, other forms of the material, perturbations, compositions of two,
variants, BRDFs that really differ (far), roundings. Some kinds occur in the test split only, so that a metric can be judged on
kinds that it has not seen. Of the far tests, half as many again as --far are written: `nqm dataset --keep far=N` keeps those with
the most even labels. Draws are functions of the seed and the name of the reference: more materials change no pair of the others but
some far ones. Needs only Python's standard library, and nqm (NQM_TOOL, default build/nqm)."""
import argparse
import csv
import json
import math
import os
import random
import subprocess
import sys

from scan import uniform_of

ENCODINGS = ("ward ggx nbrdf sparse-0 sparse-1 sparse-2 hyper-0 hyper-1 hyper-2 sparse-low sparse-mid sparse-high hyper-low hyper-mid "
             "hyper-high ward-duer blinn-phong lafortune cook-torrance ashikhmin-shirley abc smooth").split()
SHADING = ("rough-plastic rough-conductor pbrt-conductor open-pbr gltf usd-preview standard-surface disney principled").split()
PATH_DIRECTIONS = 1000  # a loss need not be exact on the path of an optimiser


def number(x):
    return f"{x:.4g}"


def log_uniform(rng, low, high):
    return low * (high / low) ** rng.random()


def sign(rng):
    return rng.choice((-1, 1))


class Nqm:
    """The tool, in the folder of the data."""

    def __init__(self, root):
        here = os.path.dirname(os.path.abspath(__file__))
        self.tool = os.path.abspath(os.environ.get("NQM_TOOL", os.path.join(here, "..", "build", "nqm")))
        self.root = root
        self.presets = [p for p in self.run("info", "list").stdout.split() if not p.startswith("physical:")]  # of MERL

    def run(self, *arguments):
        return subprocess.run([self.tool, *arguments], cwd=self.root, check=False, capture_output=True, text=True)

    def info(self, brdf):
        """spec ("": it has none) and albedo at normal incidence."""
        rows = dict(line.split(None, 1) for line in self.run("info", brdf).stdout.splitlines() if len(line.split(None, 1)) == 2)
        return rows.get("spec", ""), [float(x) for x in rows.get("albedo_normal", "0").split(",")]

    def different(self, brdf, tests):
        """Those of the tests that open and have other values than `brdf`."""
        if not tests:
            return []
        rows = json.loads(self.run("score", brdf, *tests, "--json").stdout or "{}").get("results", [])
        by_name = {row.get("test"): row.get("delta_e_itp") or 0 for row in rows}
        return [test for test in tests if by_name.get(test, 0) > 0]


# ---- perturbations: log-uniform from barely measurable to very strong -------------------------------------------------

def tint(rng, size):
    d = [rng.gauss(0, 1) for _ in range(3)]
    d = [x - sum(d) / 3 for x in d]
    return "tint=" + ",".join(number(math.exp(size * x / max(map(abs, d)))) for x in d)


def peak(rng, size):
    """Fits often miss a sharp highlight: one copy in six has none, one in six a very weak one."""
    u = rng.random()
    factor = math.exp(sign(rng) * size)
    return "peak=" + number(0 if u < 1 / 6 else log_uniform(rng, 0.002, 0.1) if u < 2 / 6 else factor)


def plain(key, more=""):
    return lambda rng, size: f"{key}={number(size)}" + more.format(cells=rng.randrange(6, 25), bands=rng.randrange(2, 25),
                                                                   seed=rng.randrange(1000000))


def signed(key):
    return lambda rng, size: f"{key}={number(sign(rng) * size)}"


def factor(key):
    return lambda rng, size: f"{key}={number(math.exp(sign(rng) * size))}"


# kind: weakest, strongest, settings
PERTURBATIONS = {
    "gloss": (0.02, 1.6, factor("gloss")),
    "tint": (0.01, 0.8, tint),
    "scale": (0.01, 1.2, factor("scale")),
    "fresnel": (0.3, 4.5, factor("fresnel")),
    "blur": (0.4, 15, plain("smooth")),  # degrees
    "mix": (0.01, 0.9, plain("mix")),
    "noise": (0.02, 1.2, plain("noise", ";seed={seed};cells={cells}")),
    "peak": (0.03, 2, peak),
    "desaturate": (0.03, 1, signed("desaturate")),
    "quantise": (1, 40, plain("quantise")),  # steps per decade: fewer are stronger
    "shift": (0.2, 12, signed("shift")),  # degrees
    "lopsided": (0.025, 0.35, signed("lopsided")),  # logarithms: halves differ by 1.05 to 2
    "clamp": (0.01, 0.9, plain("clamp")),
    "ripple": (0.02, 0.8, plain("ripple", ";bands={bands}")),
    "hue": (2, 90, signed("hue")),  # degrees
}
UNSEEN = {"clamp", "ripple", "hue", "between-log", "white", "random-lafortune", "random-smooth"}  # in the test split only


def settings(rng, kind):
    low, high, make = PERTURBATIONS[kind]
    return make(rng, log_uniform(rng, low, high))


def perturbations(rng, ref, models, n):
    """Cycle through the kinds; `blur`, which evaluates its base many times, is in every fourth round."""
    quick = [kind for kind in PERTURBATIONS if kind != "blur" and kind not in UNSEEN]
    choices, rounds = [], 0
    for _ in range(n):
        if not choices:
            choices = [kind for kind in PERTURBATIONS
                       if (ref.is_test or kind not in UNSEEN) and (kind != "blur" or rounds % 4 == 0)]
            choices += ["composed", "refit" if models else "composed"] * 2
            rng.shuffle(choices)
            rounds += 1
        kind = choices.pop()
        if kind in PERTURBATIONS:
            yield "perturbation", kind, f"perturb:{settings(rng, kind)};of={ref.brdf}"
            continue
        first, second = (settings(rng, k) for k in rng.sample(quick, 2))
        base = f"fit:model={rng.choice(models)};of={ref.brdf}" if kind == "refit" else f"perturb:{second};of={ref.brdf}"
        yield "composed", kind, f"perturb:{first};of={base}"


def roundings(rng, ref, n):
    for i in range(n):
        kind, setting = (("float32", "bits=24"), ("float16", "half=1"), ("bits", f"bits={rng.randrange(5, 24)}"))[i % 3]
        yield "rounding", kind, f"perturb:{setting};of={ref.brdf}"


# ---- variants ---------------------------------------------------------------------------------------------------------

WHOLE = {"distribution", "nonlinear", "useSpecularWorkflow"}


def width_exponent(model, key):
    """Of a key that sets the width of a lobe, value = alpha^exponent; 0: it is another key."""
    if key == "alpha":
        return 2 if model == "sgd" else 1
    if key in ("n", "B"):
        return -2
    if key in ("roughness", "specular_roughness", "clearcoat_roughness", "clearcoatRoughness", "coat_roughness"):
        return 2 if model == "pbrt-conductor" else 0.5
    return 0


def change_width(rng, values, exponent):
    """Multiply alpha by 0.1 to 10; one width in six becomes nearly 0."""
    ratio, small, u = log_uniform(rng, 0.1, 10) ** exponent, log_uniform(rng, 1e-3, 0.1) ** exponent, rng.random()
    low = {0.5: 0, 1: 1e-4, 2: 1e-6}.get(exponent, 0)
    if exponent < 0:
        return [min(max(x * ratio, 0), 1e8) for x in values]
    top = 1 if exponent < 1 else 2
    return [low if u < 1 / 6 else min(small if x <= low else x * ratio, top) for x in values]


def change_value(rng, values, key):
    """Colours get a factor for all channels, or one for each; numbers up to 1 a difference, larger ones a factor."""
    size = log_uniform(rng, 0.01, 1) * sign(rng)
    if len(values) == 3:
        grey = rng.random() < 0.5
        return [min(x * math.exp(size * (1 if grey else 2 * rng.random() - 1)), max(1, x)) for x in values]
    if key in ("ior", "eta", "specular_ior", "specular_IOR", "coat_ior", "coat_IOR"):
        return [min(1 + max(values[0] - 1, 0.05) * math.exp(size), 3)]
    moved = values[0] + size
    return [moved if 0 <= moved <= 1 else min(max(values[0] - size, 0), 1)] if values[0] <= 1 else [values[0] * math.exp(size)]


def change_spec(rng, spec, of_width):
    """The spec with another value of one key; "": it has no such key."""
    model, _, rest = spec.partition(":")
    keys = [part.split("=") for part in rest.split(";")]
    if model == "sgd":
        keys_to_change = keys[:3]  # its other values are plausible only together
    else:
        keys_to_change = keys
    keys_to_change = [k for k in keys_to_change if k[0] not in WHOLE and bool(width_exponent(model, k[0])) == of_width]
    if not keys_to_change:
        return ""
    key = rng.choice(keys_to_change)
    values = [float(x) for x in key[1].split(",")]
    changed = change_width(rng, values, width_exponent(model, key[0])) if of_width else change_value(rng, values, key[0])
    return model + ":" + ";".join(f"{k}={','.join(map(number, changed)) if k is key[0] else v}" for k, v in keys)


def variants(rng, ref, n, nqm):
    cycle = ("roughness", "key", "overfit", "key", "roughness", "translated", "roughness", "folded")
    spec = nqm.info(ref.brdf)[0] if n else ""
    spec = "" if spec.startswith(("perturb:", "between:")) else spec
    kinds = [cycle[i % len(cycle)] for i in range(n)]
    tries = {of_width: [change_spec(rng, spec, of_width) for _ in range(4 * n)] if spec else [] for of_width in (True, False)}
    good = {of_width: nqm.different(ref.brdf, list(dict.fromkeys(filter(None, tests)))) for of_width, tests in tries.items()}
    for i, kind in enumerate(kinds):
        if kind == "overfit":
            where, count = rng.choice(("at", "own")), int(log_uniform(rng, 50, 500))
            yield "variant", kind, f"fit:model=nbrdf;{where}={count};seed={rng.randrange(1000000)};of={ref.brdf}"
        elif kind == "translated":
            model = rng.choice([m for m in SHADING if not spec.startswith(m)])
            yield "variant", kind, f"fit:model={model};samples={PATH_DIRECTIONS};seed={rng.randrange(1000000)};of={ref.brdf}"
        elif kind == "folded":
            if i < len(cycle) and ref.source != "nps":  # those are tables already
                yield "variant", kind, f"fit:model=table;of={ref.brdf}"
        elif good[kind == "roughness"]:
            yield "variant", kind, good[kind == "roughness"].pop(0)


# ---- far tests --------------------------------------------------------------------------------------------------------

# key: lowest, highest, whether log-uniform. The ranges of the specs hold few plausible materials.
SHAPES = {
    "p": (0, 1.5, False), "K": (1, 1, False), "lambda": (0.1, 6, True), "c": (1e-3, 1, True), "k": (5, 15, True),
    "theta0": (0.5, 1.2, False), "alpha": (2e-3, 1, True), "n": (1, 1e5, True), "cxy": (-1, -1, False), "cz": (0.95, 1.05, False),
    "f0": (0.02, 1, True), "eta": (1.1, 20, True), "B": (1, 1e7, True), "C": (0.2, 3, True),
    "lafortune n": (1, 100, True),  # with larger ones the lobe vanishes at most angles unless cz is 1
    "sgd alpha": (1e-5, 0.5, True), "sgd f1": (-0.5, 0.2, False),
}
ANALYTIC = {
    "lambert": "", "ggx": "alpha f0", "ward": "alpha", "sgd": "alpha p f0 f1 K lambda c k theta0", "ward-duer": "alpha",
    "blinn-phong": "n", "lafortune": "cxy cz n", "cook-torrance": "alpha f0", "low-cook-torrance": "alpha eta",
    "ashikhmin-shirley": "n f0", "low-ashikhmin-shirley": "n eta", "abc": "B C eta", "smooth": "B C eta",
}
PATHS = "ward ggx ward-duer blinn-phong lafortune cook-torrance ashikhmin-shirley abc smooth".split()
# kind: times in a round of draws
FAR = {"other-same": 8, "other-source": 8, "between": 8, "between-log": 4, "black": 1, "white": 2, "mirror": 1, "scaled": 1}
FAR |= {f"random-{model}": 3 if f"random-{model}" in UNSEEN else 1 for model in ANALYTIC}
FAR |= {f"path-{model}": 1 for model in PATHS}


def colour(rng):
    """An albedo; half of them grey, the others with factors up to e between the channels."""
    albedo, grey = log_uniform(rng, 0.003, 0.9), rng.random() < 0.5
    return [albedo * (1 if grey else math.exp(-rng.random())) for _ in range(3)]


def random_spec(rng, model, nqm):
    """The specular colour is an albedo: in some models that of a lobe with ks = 1 depends on its shape by orders of magnitude."""
    base, specular, has_base = colour(rng), colour(rng), rng.random() < 0.75
    if model == "lambert":
        return "lambert:kd=" + ",".join(map(number, base))
    shapes = []
    for key in ANALYTIC[model].split():
        low, high, is_log = SHAPES.get(f"{model} {key}") or SHAPES[key]
        shapes.append(f"{key}={number(log_uniform(rng, low, high) if is_log else rng.uniform(low, high))}")
    shape = ";".join(shapes)
    albedo = nqm.info(f"{model}:kd=0;ks=1;{shape}")[1][0]
    albedo = albedo if 1e-9 < albedo < 1e30 else 1
    kd = ",".join(map(number, base)) if has_base else "0"
    return f"{model}:kd={kd};ks={','.join(number(min(x / albedo, 1e6)) for x in specular)};{shape}"


class Others:
    """Materials of the same split in other groups, by a hash of both names: a material that is added to the list appears in few
    pairs of others."""

    def __init__(self, seed, ref, refs):
        self.lists = {}
        for kind in ("other-same", "other-source", "between", "between-log"):
            found = [other for other in refs if other.group != ref.group and other.split == ref.split and
                     (kind.startswith("between") or (other.source == ref.source) == (kind == "other-same"))]
            found.sort(key=lambda other, kind=kind: uniform_of(seed, f"{kind} {ref.name} {other.name}"))
            self.lists[kind] = [found, 0]

    def next(self, kind):
        """None: no material is left; mixtures begin again."""
        found, at = self.lists[kind]
        if not found or (at >= len(found) and not kind.startswith("between")):
            return None
        self.lists[kind][1] = at + 1
        return found[at % len(found)]


def far_test(rng, ref, kind, other, nqm):
    form, _, model = kind.partition("-")
    if form == "other":
        return other.brdf
    if form == "between":
        log = ";log=1" if model == "log" else ""
        return f"between:t={number(0.02 + 0.96 * rng.random())}{log};with=({other.brdf});of={ref.brdf}"
    if form == "random":
        return random_spec(rng, model, nqm)
    if form == "path":
        loss = rng.choice(("log", "log-cos", "cube-root", "linear"))
        return (f"fit:model={model};loss={loss};steps={rng.randrange(9)};samples={PATH_DIRECTIONS};seed={rng.randrange(1000000)};"
                f"of={ref.brdf}")
    if form == "mirror":
        f0 = ",".join(number(rng.uniform(0.5, 1)) for _ in range(3))
        return f"ggx:ks=1;alpha={number(log_uniform(rng, 0.001, 0.05))};f0={f0}"
    if form == "scaled":
        return f"perturb:scale={number(10 ** (sign(rng) * rng.uniform(0.5, 3)))};of={ref.brdf}"
    low, high = (1e-5, 0.005) if form == "black" else (0.7, 1)
    kd = log_uniform(rng, low, high)
    return f"lambert:kd={number(kd if kd >= 1e-4 else 0)}"


def far(rng, ref, refs, n, arguments, nqm):
    others, choices, made = Others(arguments.seed, ref, refs), [], 0
    while made < n:
        if not choices:
            choices = [kind for kind, times in FAR.items() for _ in range(times) if ref.is_test or kind not in UNSEEN]
            rng.shuffle(choices)
        kind = choices.pop()
        other = others.next(kind) if kind in others.lists else None
        if kind in others.lists and other is None:
            continue
        made += 1
        yield "far", kind, far_test(rng, ref, kind, other, nqm), other.name if other else ""


# ---- the list ---------------------------------------------------------------------------------------------------------

class Reference:
    def __init__(self, row):
        self.name, self.group, self.brdf = row["name"], row["group"], row["brdf"]
        self.source, self.split = row["source"], row["split"]
        self.is_test = self.split == "test"


def forms(ref, refs, presets):
    """Other references of the material, and published parameters of its name."""
    listed = {other.brdf for other in refs if other.group == ref.group}
    for other in refs:
        if other.group == ref.group and other is not ref:
            if other.brdf in presets:
                yield "published", "published-" + other.brdf.split(":")[0], other.brdf
            else:
                yield "form", "form-" + other.source, other.brdf
    for preset in presets:
        table, _, material = preset.partition(":")
        if material == ref.group and preset not in listed:
            yield "published", "published-" + table, preset


def near_tests(ref, refs, arguments, nqm):
    def rng(what):
        return random.Random(f"{arguments.seed} {ref.name} {what}")

    for model in arguments.models:
        yield "encoding", model, f"fit:model={model};of={ref.brdf}"
    yield from forms(ref, refs, nqm.presets)
    yield from perturbations(rng("perturbations"), ref, arguments.models, arguments.perturbations)
    yield from roundings(rng("roundings"), ref, arguments.roundings)
    yield from variants(rng("variants"), ref, arguments.variants, nqm)


def plan(ref, refs, arguments, nqm):
    """(family, kind, test, other) of the tests of a reference. --every keeps one in N by a hash."""
    for i, test in enumerate(near_tests(ref, refs, arguments, nqm)):
        if uniform_of(arguments.seed, f"{ref.name} {i}") * arguments.every < 1:
            yield *test, ""
    n_far = -(-arguments.far // arguments.every)
    draws = random.Random(f"{arguments.seed} {ref.name} far")
    yield from far(draws, ref, refs, n_far + (n_far + 1) // 2, arguments, nqm)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("materials")
    parser.add_argument("--root", help="folder of relative paths (default: that of the list)")
    parser.add_argument("--only", choices=("train,validation", "test"), help="tests of these splits (default: all)")
    parser.add_argument("--models", default="all", help="models that encode each reference (default: all)")
    for name, default, what in (("perturbations", 26, "perturbed copies"), ("far", 26, "far tests that will be kept"),
                                ("roundings", 3, "rounded copies"), ("variants", 8, "at most this many variants")):
        parser.add_argument("--" + name, type=int, default=default, metavar="N", help=f"{what} per reference (default {default})")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="keep one test in N (default 1)")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    arguments.models = ENCODINGS if arguments.models == "all" else list(filter(None, arguments.models.split(",")))
    unknown = [model for model in arguments.models if model not in ENCODINGS]
    if unknown:
        parser.error(f"there is no model '{unknown[0]}'; there are {', '.join(ENCODINGS)}")
    return arguments


def main():
    arguments = parse_arguments()
    try:
        with open(arguments.materials, newline="", encoding="utf-8") as file:
            refs = [Reference(row) for row in csv.DictReader(file)]
        nqm = Nqm(arguments.root or os.path.dirname(os.path.abspath(arguments.materials)))
    except (OSError, KeyError) as error:
        sys.exit(f"plan.py: {arguments.materials}: {error!r}")
    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(["reference", "test", "name", "group", "source", "split", "family", "kind", "other"])
    for ref in refs:
        if arguments.only and (arguments.only == "test") != ref.is_test:
            continue
        for family, kind, test, other in plan(ref, refs, arguments, nqm):
            out.writerow([ref.brdf, test, ref.name, ref.group, ref.source, ref.split, family, kind, other])


if __name__ == "__main__":
    main()
