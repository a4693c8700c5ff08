#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Score and label random pairs that are in no corpus, and count the labels inside the intervals of the scores.

usage: studies/check.py [--pairs 300] [--seed 1] [--model default] [--csv OUT.csv]

Both BRDFs of a pair are specs, which corpora never use as references: published fits of other models than sgd, copies
of them with one or two perturbations, mixtures of two of them, and GGX or Ward with random parameters. A third of the
pairs is near (a perturbed copy), the others are far. Scores and labels are those of `nqm score A B` and `nqm label A B`
without further options. Needs only Python's standard library; NQM_TOOL: the program (default build/nqm)."""
import argparse
import csv
import json
import math
import os
import random
import subprocess
import sys

NQM = os.environ.get("NQM_TOOL", os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "build", "nqm"))
# Ranges of strength, all log-uniform: signed settings get a random sign, factors a random direction.
FACTORS = {"gloss": (0.02, 1.2), "scale": (0.02, 1), "peak": (0.05, 1.5), "fresnel": (0.3, 3)}
SIGNED = {"desaturate": (0.05, 1), "shift": (0.2, 10), "hue": (2, 90)}
PLAIN = {"mix": (0.02, 0.8), "noise": (0.02, 1), "smooth": (0.5, 12), "clamp": (0.02, 0.8), "ripple": (0.02, 0.6)}


def run(*arguments):
    done = subprocess.run([NQM, *arguments], check=True, stdout=subprocess.PIPE, text=True)
    return done.stdout


def log_uniform(rng, low, high):
    return low * (high / low) ** rng.random()


def perturbation(rng):
    """One setting with a random value, as in a spec `perturb:`."""
    key = rng.choice(sorted([*FACTORS, *SIGNED, *PLAIN]))
    if key in FACTORS:
        value = math.exp(rng.choice((-1, 1)) * log_uniform(rng, *FACTORS[key]))
    else:
        value = log_uniform(rng, *(SIGNED.get(key) or PLAIN[key])) * (rng.choice((-1, 1)) if key in SIGNED else 1)
    return f"{key}={value:.4g}"


def random_lobe(rng):
    base = ",".join(f"{log_uniform(rng, 0.003, 0.8):.4g}" for _ in range(3))
    alpha = log_uniform(rng, 0.01, 0.6)
    if rng.random() < 0.5:
        return f"ggx:kd={base};ks=1;alpha={alpha:.4g};f0={log_uniform(rng, 0.02, 0.9):.4g}"
    return f"ward:kd={base};ks={log_uniform(rng, 0.01, 0.5):.4g};alpha={alpha:.4g}"


def draw(rng, kind, presets):
    """(reference, test) of a kind."""
    ref, other = rng.sample(presets, 2)
    if kind == "copy":
        return ref, f"perturb:{perturbation(rng)};of={ref}"
    if kind == "two perturbations":
        return ref, f"perturb:{perturbation(rng)};of=perturb:{perturbation(rng)};of={ref}"
    if kind == "mixture":
        return ref, f"between:t={rng.uniform(0.05, 0.95):.4g};with=({other});of={ref}"
    if kind == "random lobes":
        return random_lobe(rng), random_lobe(rng)
    return ref, other


def result_of(command, ref, test, *options):
    return json.loads(run(command, ref, test, "--json", *options))["results"][0]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--pairs", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--model", default="default")
    parser.add_argument("--csv", metavar="OUT")
    options = parser.parse_args()
    rng = random.Random(options.seed)
    presets = [name for name in run("info", "list").split() if not name.startswith("sgd:")]
    kinds = ("copy", "two perturbations", "mixture", "other material", "random lobes", "other material")
    rows = []
    for i in range(options.pairs):
        kind = kinds[i % len(kinds)]
        ref, test = draw(rng, kind, presets)
        label = result_of("label", ref, test)
        score = result_of("score", ref, test, "--model", options.model)
        low, high = score["jod_low"], score["jod_high"]
        inside = low - 0.005 <= label["jod"] <= high + 0.005  # as printed, with two decimals
        rows.append({"kind": kind, "ref": ref, "test": test, "label": label["jod"], "score": score["jod"], "low": low,
                     "high": high, "inside": int(inside)})
        if sys.stderr.isatty():
            print(f"\r{i + 1} of {options.pairs}", end="", file=sys.stderr)
    print(f"{'':20}{'n':>5}{'inside':>9}{'MAE':>8}{'width':>8}")
    for kind in [*dict.fromkeys(kinds), "all"]:
        some = [r for r in rows if kind in ("all", r["kind"])]
        n = len(some)
        if n:
            print(f"{kind:20}{n:5}{sum(r['inside'] for r in some) / n:9.1%}"
                  f"{sum(abs(r['score'] - r['label']) for r in some) / n:8.3f}"
                  f"{sum(r['high'] - r['low'] for r in some) / n:8.3f}")
    if options.csv:
        with open(options.csv, "w", newline="", encoding="utf-8") as file:
            out = csv.DictWriter(file, rows[0])
            out.writeheader()
            out.writerows(rows)


if __name__ == "__main__":
    main()
