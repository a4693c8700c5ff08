#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""How exact are transport matrices with different numbers of points, and how fast? (doc/labels.md)

usage: studies/transport.py CHECK.csv [--work DIR]

CHECK.csv is the output of `studies/check.py --csv`: pairs with labels by the full renderer. Matrices of the standard scenes are made
for each number of points, and their Delta-E is compared with the labels'. Time: scores of 256 pairs with references of 16 tests each on all
threads, samples to JOD; median of 7. LIBNQM and NQM_TOOL as in studies/fitting_network.py. Needs NumPy and SciPy."""
import argparse
import csv
import os
import time

import numpy as np
from scipy.stats import spearmanr

from fitting_network import Model, evaluate, nqm

CURVE = (-14.11196939758611, -0.47364347065458806, -0.21479944748134167)
SIZES = [32, 64, 128, 256, 512, 1024]  # points


def delta_e_of(jod):
    """The inverse of the JOD curve."""
    b1, b2, b3 = CURVE
    jod = np.clip(jod, 1e-9, 10 - 1e-12)
    return np.where(jod > 10 - 1e-10, 0, (-(np.log(jod / (10 - jod)) / b1 + b2)) ** (1 / b3))


def seconds_per_pair(model, rows):
    samples = [evaluate(row["ref"], model)[0] for row in rows[:16]]
    used = np.ones(model.n, np.uint8)
    times = []
    for _ in range(7):
        begin = time.perf_counter()
        for ref in samples:
            model.score(ref, np.array(samples), used)
        times.append((time.perf_counter() - begin) / len(samples) ** 2)
    return np.median(times)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("check")
    parser.add_argument("--work", default=".")
    options = parser.parse_args()
    with open(options.check, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    labels = np.array([float(row["label"]) for row in rows])
    rendered = delta_e_of(labels)
    visible = rendered > 1
    print(f"{len(rows)} pairs\ndirections points    MB  Spearman  error of JOD: mean  95 %   of Delta-E: median  95 %   ms a pair")
    for points in SIZES:
        path = os.path.join(options.work, f"transport-{points}.safetensors")
        nqm("transport", "make", "--points", str(points), "--seed", "2", "-o", path)
        model = Model(os.path.abspath(path))
        jods = []
        for row in rows:
            (ref, ref_used), (test, test_used) = evaluate(row["ref"], model), evaluate(row["test"], model)
            jods.append(model.score(ref, [test], ref_used & test_used)[0].jod)
        error = abs(np.array(jods) - labels)
        ratio = abs(delta_e_of(np.array(jods)) - rendered)[visible] / rendered[visible]
        print(f"{model.n:10d} {points:6d} {os.path.getsize(path) / 1e6:5.1f}  {spearmanr(jods, labels)[0]:8.5f} {error.mean():18.3f}"
              f" {np.percentile(error, 95):5.3f}  {100 * np.median(ratio):17.2f} % {100 * np.percentile(ratio, 95):4.1f} %"
              f"  {1000 * seconds_per_pair(model, rows):10.3f}", flush=True)


if __name__ == "__main__":
    main()
