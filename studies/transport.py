#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""How exact are transport matrices with different numbers of points, and how fast? (doc/labels.md)

usage: PYTHONPATH=python studies/transport.py CHECK.csv [--work DIR]

CHECK.csv is the output of `studies/check.py --csv`: pairs with labels by the full renderer. Matrices of the standard scenes are made
for each number of points, and their Delta-E is compared with the labels'. Time: scores of 256 pairs with references of 16 tests each on all
threads, samples to JOD; median of 7. NQM_TOOL: the program. Needs NumPy and SciPy."""
import argparse
import csv
import os
import subprocess
import time

import numpy as np
from scipy.stats import spearmanr

import nqm

NQM = os.environ.get("NQM_TOOL", os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "build", "nqm"))
CURVE = (-14.11196939758611, -0.47364347065458806, -0.21479944748134167)
SIZES = [32, 64, 128, 256, 512, 1024]  # points


def delta_e_of(jod):
    """The inverse of the JOD curve."""
    b1, b2, b3 = CURVE
    jod = np.clip(jod, 1e-9, 10 - 1e-12)
    return np.where(jod > 10 - 1e-10, 0, (-(np.log(jod / (10 - jod)) / b1 + b2)) ** (1 / b3))


def seconds_per_pair(scorer, rows):
    directions = scorer.model.directions
    samples = np.array([nqm.BRDF.open(row["ref"]).sample(directions)[0] for row in rows[:16]])
    times = []
    for _ in range(7):
        begin = time.perf_counter()
        for ref in samples:
            scorer.score_samples(ref, samples)
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
        subprocess.run([NQM, "transport", "make", "--points", str(points), "--seed", "2", "-o", path], check=True, stdout=subprocess.DEVNULL)
        scorer = nqm.Scorer(os.path.abspath(path))
        jods = [scorer.score(row["ref"], row["test"]).jod for row in rows]
        error = abs(np.array(jods) - labels)
        ratio = abs(delta_e_of(np.array(jods)) - rendered)[visible] / rendered[visible]
        print(f"{len(scorer.model.directions):10d} {points:6d} {os.path.getsize(path) / 1e6:5.1f}  {spearmanr(jods, labels)[0]:8.5f} {error.mean():18.3f}"
              f" {np.percentile(error, 95):5.3f}  {100 * np.median(ratio):17.2f} % {100 * np.percentile(ratio, 95):4.1f} %"
              f"  {1000 * seconds_per_pair(scorer, rows):10.3f}", flush=True)


if __name__ == "__main__":
    main()
