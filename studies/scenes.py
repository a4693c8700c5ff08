#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Do the built-in scenes rank pairs of BRDFs as measured lights do? The table of doc/labels.md.

usage: studies/scenes.py DATA [--refs N] [--seed N]

DATA holds rgl/, scene/ and labels/ (doc/corpus.md). Random references that are not test materials (SGD presets and RGL files) are
compared with perturbed copies, published fits and other materials, in the standard set, in each of its scenes, and on the bunny in
eight frames under three measured lights. Printed: Spearman's correlation of Delta-E over all pairs with each measured light and
with the mean over them; the mean of the correlations within a reference and within a kind; the median ratio; and the spread over
the scenes. The tool is NQM_TOOL, default build/nqm. Python's standard library only."""
import argparse
import csv
import glob
import json
import math
import os
import random
import re
import statistics
import subprocess

MODELS = ("ward", "ggx", "cook-torrance", "blinn-phong", "abc", "lafortune", "he", "ashikhmin")
SCENES = {"standard": [], "sun, blob": ["--light", "sun", "--shape", "blob"], "overcast, sphere": ["--light", "overcast"],
          "studio, sphere": ["--light", "studio"], "interior, blob": ["--light", "interior", "--shape", "blob"]}
MEASURED = {"Pixar Campus": "pixar_campus_rgbe.png", "Grace": "grace_cathedral.exr", "museum": "museum.exr"}


def perturbations(rng):
    def factor(size):
        return math.exp(rng.choice((-1, 1)) * rng.uniform(size / 30, size))

    yield from ((f"{key}={value:.4g}") for key, value in (
        ("gloss", factor(1.4)), ("scale", factor(1)), ("fresnel", factor(2)), ("smooth", rng.uniform(0.5, 12)), ("mix", rng.uniform(0.02, 0.8)),
        ("peak", rng.choice((0, 0.05, 0.5, 2))), ("desaturate", rng.uniform(0.05, 1)), ("clamp", rng.uniform(0.05, 0.9)),
        ("shift", rng.uniform(0.5, 10)), ("noise", rng.uniform(0.03, 1))))
    yield "tint=" + ",".join(f"{math.exp(rng.uniform(-0.5, 0.5)):.4g}" for _ in range(3))


def make_pairs(nqm, data, n_refs, seed):
    """(reference, kind, test) of all pairs, by reference."""
    rng = random.Random(seed)
    with open(os.path.join(data, "labels", "labels_real.csv"), newline="", encoding="utf-8") as file:
        held_out = {re.sub(r"_\d+$", "", next(iter(row.values()))) for row in csv.DictReader(file)}
    listing = subprocess.run([nqm, "info", "list", "--json"], stdout=subprocess.PIPE, check=True).stdout
    presets = set(re.findall(r'"([a-z-]+:[a-z0-9-]+)"', listing.decode()))
    sgd = sorted(p for p in presets if p.startswith("sgd:") and p[4:] not in held_out)
    rgl = sorted(f for f in glob.glob(os.path.join(data, "rgl", "*.bsdf")) if os.path.basename(f)[:-5] not in held_out)
    rgl = rng.sample(rgl, min(len(rgl), n_refs * 2 // 5))
    for ref in rng.sample(sgd, n_refs - len(rgl)) + rgl:
        for change in perturbations(rng):
            yield ref, change.split("=")[0], f"perturb:{change};of={ref}"
        for model in MODELS:
            if ref.startswith("sgd:") and f"{model}:{ref[4:]}" in presets:
                yield ref, "published", f"{model}:{ref[4:]}"
        for other in rng.sample(sgd + rgl, 4):
            if other != ref:
                yield ref, "other", other


def delta_e(nqm, pairs, options):
    words, before = [], None
    for ref, _, test in pairs:
        if ref != before:
            words += (["+"] if words else []) + [ref]
            before = ref
        words.append(test)
    done = subprocess.run([nqm, "label", *words, *options, "--json"], stdout=subprocess.PIPE, check=True)
    return [result["delta_e_itp"] for result in json.loads(done.stdout)["results"]]


def ranks(values):
    order, out, i = sorted(range(len(values)), key=values.__getitem__), [0.0] * len(values), 0
    while i < len(order):
        j = i
        while j < len(order) and values[order[j]] == values[order[i]]:
            j += 1
        for k in order[i:j]:
            out[k] = (i + j - 1) / 2
        i = j
    return out


def spearman(a, b):
    a, b = ranks(a), ranks(b)
    p, q = statistics.fmean(a), statistics.fmean(b)
    size = math.sqrt(sum((x - p) ** 2 for x in a) * sum((y - q) ** 2 for y in b))
    return sum((x - p) * (y - q) for x, y in zip(a, b)) / size if size else math.nan


def within(names, a, b):
    found = []
    for name in sorted(set(names)):
        rows = [i for i, n in enumerate(names) if n == name]
        found.append(spearman([a[i] for i in rows], [b[i] for i in rows]) if len(rows) > 9 else math.nan)
    return statistics.fmean(x for x in found if not math.isnan(x))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data")
    parser.add_argument("--refs", type=int, default=36)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    nqm = os.environ.get("NQM_TOOL", os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "build", "nqm"))
    pairs = list(make_pairs(nqm, options.data, options.refs, options.seed))
    bunny = ["--scene", "paper", "--shape", os.path.join(options.data, "scene", "bunny.ply")]
    found = {name: delta_e(nqm, pairs, words) for name, words in SCENES.items()}
    for name, file in MEASURED.items():
        found[name] = delta_e(nqm, pairs, ["--light", os.path.join(options.data, "scene", file), *bunny])
    found["mean of the three"] = [statistics.fmean(row) for row in zip(*(found[name] for name in MEASURED))]
    against = [*MEASURED, "mean of the three"]
    refs, kinds = [ref for ref, _, _ in pairs], [kind for _, kind, _ in pairs]
    print(f"{len(pairs)} pairs of {len(set(refs))} references\n")
    print("| scene | " + " | ".join(against) + " | within references | within kinds | median ratio |\n" + "|---" * (len(against) + 4) + "|")
    for name in [*SCENES, *MEASURED]:
        mean = found["mean of the three"]
        row = [f"{spearman(found[name], found[other]):.4f}" for other in against]
        ratio = statistics.median(a / b for a, b in zip(found[name], mean) if b > 0)
        print(f"| {name} | " + " | ".join(row) + f" | {within(refs, found[name], mean):.3f} | {within(kinds, found[name], mean):.3f} | {ratio:.2f} |")
    single = [row for row in zip(*(found[name] for name in SCENES if name != "standard")) if statistics.fmean(row) >= 1]
    spread = [statistics.stdev(row) / statistics.fmean(row) for row in single]
    print(f"\nspread over the four scenes, standard deviation / mean, Delta-E from 1 ({len(spread)} pairs): median {statistics.median(spread):.2f}, "
          f"90 % below {sorted(spread)[len(spread) * 9 // 10]:.2f}")


if __name__ == "__main__":
    main()
