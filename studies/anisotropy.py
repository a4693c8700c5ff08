#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draw anisotropic pairs. models/make.sh calibrates the model "anisotropic" on 420 of seed 1; tests have other seeds:

    studies/anisotropy.py 315 3 --split test > test.csv
    nqm directions --grid -o grid.csv
    nqm dataset test.csv --anisotropic --directions grid.csv --lights 256 --only test -o test.safetensors
    nqm eval test.safetensors --model anisotropic --by source
"""
import argparse
import csv
import sys

import numpy as np

KINDS = ("widths", "round", "rotated", "tilted", "model", "colour", "far")


def ggx(rng, kd, f0, ax, ay):
    return "ggx:kd=%.3f;ks=1;alpha=%.5f,%.5f;f0=%s" % (kd, ax, ay, ",".join("%.3f" % f for f in f0))


def draw(rng, kind):
    """A reference, and a test of this kind. Widths are 0.01 to 0.4 in the geometric mean and differ by at most ten times."""
    width, ratio = 10 ** rng.uniform(-2, -0.4), 10 ** rng.uniform(0.1, 1)
    ax, ay = width * ratio**0.5, width / ratio**0.5
    if rng.random() < 0.5:
        ax, ay = ay, ax
    metal = rng.random() < 0.6
    f0, kd = (rng.uniform(0.2, 0.95, 3), 0.0) if metal else (np.full(3, rng.uniform(0.03, 0.08)), rng.choice([0.05, 0.2, 0.4]))
    form = rng.integers(4)
    if form < 2:
        ref = ggx(rng, kd, f0, ax, ay)
    elif form == 2:
        ref = "ward:kd=%.3f;ks=%.4f;alpha=%.5f,%.5f" % (kd, f0.mean(), ax, ay)
    else:
        ref = "open-pbr:base_metalness=%d;base_color=%.3f,%.3f,%.3f;specular_roughness=%.3f;specular_roughness_anisotropy=%.3f" % (
            metal, *f0, width**0.5, rng.uniform(0.2, 0.9))
    if rng.random() < 0.4:
        ref = "rotate:deg=%d;of=%s" % (rng.integers(1, 180), ref)
    if kind == "widths":
        return ref if form < 2 and ref.startswith("ggx") else ggx(rng, kd, f0, ax, ay), ggx(
            rng, kd, f0, *np.minimum((ax, ay) * 10 ** rng.normal(0, 0.15, 2), 1.5))
    if kind == "round":
        return ggx(rng, kd, f0, ax, ay), ggx(rng, kd, f0, width, width)
    if kind == "rotated":
        return ref, "rotate:deg=%d;of=%s" % (rng.choice([3, 5, 10, 20, 45, 90]), ref)
    if kind == "tilted":
        return ref, "tilt:deg=%.1f;azimuth=%d;of=%s" % (rng.choice([0.5, 1, 2, 5]), rng.integers(360), ref)
    if kind == "model":
        return ggx(rng, kd, f0, ax, ay), "ward:kd=%.3f;ks=%.4f;alpha=%.5f,%.5f" % (kd, f0.mean(), ax, ay)
    if kind == "colour":
        change = rng.choice(["scale=.8", "scale=.95", "tint=1.1,1,1", "tint=1,.9,.8", "gloss=.8", "gloss=1.2"])
        return ref, "perturb:%s;of=%s" % (change, ref)
    return ref, draw(rng, "widths")[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("n", type=int)
    parser.add_argument("seed", type=int)
    parser.add_argument("--split", default="validation")
    args = parser.parse_args()
    rng, table = np.random.default_rng(args.seed), csv.writer(sys.stdout)
    table.writerow(["reference", "test", "group", "kind", "source", "split"])
    for i in range(args.n):
        kind = KINDS[i % len(KINDS)]
        table.writerow([*draw(rng, kind), "material %d" % i, kind, kind, args.split])


if __name__ == "__main__":
    main()
