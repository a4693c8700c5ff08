#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Scores of anisotropic pairs against their labels: intervals of the model "anisotropic" from one set of pairs, its errors on another.

usage: anisotropy.py pairs N SEED -o PAIRS.csv       draw pairs and label them (about a second a pair)
       anisotropy.py judge PAIRS.csv [--model NAME]  compare scores with labels, by kind of pair
"""
import argparse
import csv

import numpy as np

import nqm

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
    parser = argparse.ArgumentParser()
    commands = parser.add_subparsers(dest="command", required=True)
    pairs = commands.add_parser("pairs")
    pairs.add_argument("n", type=int)
    pairs.add_argument("seed", type=int)
    pairs.add_argument("-o", required=True)
    judge = commands.add_parser("judge")
    judge.add_argument("pairs")
    judge.add_argument("--model", default="default")
    args = parser.parse_args()
    if args.command == "pairs":
        rng, scene = np.random.default_rng(args.seed), nqm.Scene(n_lights=256)
        with open(args.o, "w", newline="") as out:
            table = csv.writer(out)
            table.writerow(["reference", "test", "kind", "jod", "jod_error"])
            for i in range(args.n):
                kind = KINDS[i % len(KINDS)]
                ref, test = draw(rng, kind)
                label = scene.label(ref, test)
                table.writerow([ref, test, kind, "%.5f" % label.jod, "%.5f" % label.jod_error])
                out.flush()
        return
    rows = list(csv.DictReader(open(args.pairs, newline="")))
    jod = np.array([float(r["jod"]) for r in rows])
    scores = nqm.score_many([(r["reference"], r["test"]) for r in rows], model=args.model)
    predicted = np.array([s.jod for s in scores])
    inside = np.array([s.low <= j <= s.high for s, j in zip(scores, jod)])
    kinds = np.array([r["kind"] for r in rows])

    def spearman(a, b):
        rank = [np.argsort(np.argsort(x)) for x in (a, b)]
        return np.corrcoef(*rank)[0, 1]

    print("kind       n  Spearman  mean error  worst  inside  label error")
    for kind in ("all", *KINDS):
        m = np.ones(len(rows), bool) if kind == "all" else kinds == kind
        print("%-8s %3d  %8.4f  %10.3f  %5.2f  %5.1f %%  %.3f" % (
            kind, m.sum(), spearman(predicted[m], jod[m]), abs(predicted - jod)[m].mean(), abs(predicted - jod)[m].max(),
            100 * inside[m].mean(), np.mean([float(r["jod_error"]) for r, k in zip(rows, m) if k])))


if __name__ == "__main__":
    main()
