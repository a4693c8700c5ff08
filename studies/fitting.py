#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Which loss gives the fits that look best? The tables of doc/fitting.md.

usage: studies/fitting.py DATA [--work DIR] [--refs N] [--part fits|tables] [--models LIST]

DATA holds rgl/, nbrdf/, nps/, scene/ and labels/ (doc/corpus.md). GGX, Ward and Cook-Torrance are fitted to the measured RGL files
and to 40 further references of the 20 test materials under each loss. The full renderer compares every fit with its reference on the bunny under the paper's light and
two lights that no loss has seen. Results are kept in DIR (default: fitting-study), so an interrupted run continues. The tool is
NQM_TOOL, default build/nqm. Needs Python's standard library and NumPy."""
import argparse
import concurrent.futures
import csv
import json
import math
import os
import subprocess
import sys

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
NQM = os.environ.get("NQM_TOOL", os.path.join(HERE, "..", "build", "nqm"))
CLASSICAL = ["rmse", "mae", "rms_crwe", "ma_crwe", "rms_loge", "ma_loge", "rms_logwe", "ma_logwe", "log_diff"]
# Name of a row -> options of nqm fit.
LOSSES = {**{name: ["--loss", name] for name in CLASSICAL}, "paper": ["--loss", "nqm", "--metric", "paper"],
          "nqm": ["--loss", "nqm"], "transport": ["--loss", "transport"], "log_diff+0.2*nqm": ["--loss", "log_diff+0.2*nqm"],
          "100*ma_crwe+nqm": ["--loss", "100*ma_crwe+nqm"], "100*ma_crwe+transport": ["--loss", "100*ma_crwe+transport"],
          "auto": ["--loss", "auto"]}
MODELS = ["ggx", "ward", "cook-torrance"]
LIGHTS = {"paper": "pixar_campus_rgbe.png", "grace": "grace_cathedral.exr", "museum": "museum.exr"}
UNSEEN = ["grace", "museum"]
MEASURES = ["delta_e", "jod", "shift_i", "shift_t", "shift_p"]


def run(*arguments):
    done = subprocess.run([NQM, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          env={**os.environ, "OMP_NUM_THREADS": "1"})
    if done.returncode:
        sys.exit(f"nqm {' '.join(arguments)}: {done.stderr}")
    return done.stdout


def references(data, n):
    """(name, material, BRDF, whether the metric has not seen the material): all RGL files, then forms of the test materials."""
    listing = subprocess.run([sys.executable, os.path.join(HERE, "..", "models", "scan.py"), data], stdout=subprocess.PIPE,
                             text=True, check=True).stdout
    rows = list(csv.DictReader(listing.splitlines()))

    def path(row):
        return row["brdf"] if row["source"] == "sgd" else os.path.join(data, row["brdf"])

    measured = [r for r in rows if r["source"] == "rgl"]
    held_out = [r for source in ("nbrdf", "sgd", "nps") for r in rows if r["source"] == source and r["split"] == "test"][:40]
    chosen = [(r["name"], r["group"], path(r), r["split"] == "test") for r in measured + held_out]
    return chosen[::max(1, len(chosen) // n)] if n else chosen


# ---- work, kept in CSV files -------------------------------------------------------------------------------------------


class Table:
    """Rows of a CSV file by the first n_key columns; new rows are appended at once."""

    def __init__(self, path, columns, n_key):
        self.n_key, self.rows = n_key, {}
        is_new = not os.path.exists(path)
        if not is_new:
            with open(path, newline="", encoding="utf-8") as file:
                for row in list(csv.reader(file))[1:]:
                    if len(row) == len(columns):
                        self.rows[tuple(row[:n_key])] = row[n_key:]
        self.file = open(path, "a", newline="", encoding="utf-8")
        if is_new:
            csv.writer(self.file).writerow(columns)

    def add(self, row):
        self.rows[tuple(row[:self.n_key])] = row[self.n_key:]
        csv.writer(self.file).writerow(row)
        self.file.flush()


def in_parallel(title, jobs, function, keep):
    """keep(function(job)) for all jobs, two at a time."""
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for i, result in enumerate(pool.map(function, jobs)):
            keep(result)
            print(f"\r{title}: {i + 1} of {len(jobs)}", end="", file=sys.stderr, flush=True)
    if jobs:
        print(file=sys.stderr)


def fit_all(refs, fits, losses, models):
    """Fit what is missing."""
    brdf = {name: path for name, _, path, _ in refs}
    jobs = [(name, model, loss) for model in models for name in brdf for loss in losses if (name, model, loss) not in fits.rows]

    def fit(job):
        name, model, loss = job
        result = json.loads(run("fit", brdf[name], "--model", model, *LOSSES[loss], "--json"))
        return [*job, result["spec"], f"{result['seconds']:.3f}"]

    in_parallel("fits", jobs, fit, fits.add)


def label_all(refs, fits, labels, data, lights):
    """Render and compare what is missing."""
    brdf = {name: path for name, _, path, _ in refs}
    missing = {}
    for (name, _, _), (spec, _) in fits.rows.items():
        for light in lights:
            if name in brdf and (name, spec, light) not in labels.rows:
                missing.setdefault((name, light), {})[spec] = None

    def label(job):
        (name, light), specs = job
        results = json.loads(run("label", brdf[name], *specs, "--json", "--scene", "paper", "--points", "1024", "--shape",
                                 os.path.join(data, "scene", "bunny.ply"), "--light",
                                 os.path.join(data, "scene", LIGHTS[light])))["results"]
        return [[name, spec, light, r["delta_e_itp"], r["jod"], *r["parts"]["shift_itp"]] for spec, r in zip(specs, results)]

    def keep(rows):
        for row in rows:
            labels.add([str(x) for x in row])

    in_parallel("pictures", list(missing.items()), label, keep)


# ---- tables ------------------------------------------------------------------------------------------------------------


def bootstrap(values, groups, n=10000):
    """Mean and 95 % interval over resamples of the materials."""
    rng = np.random.default_rng(1)
    names = sorted(set(groups))
    sums = np.array([[sum(v for v, g in zip(values, groups) if g == name), groups.count(name)] for name in names])
    draws = sums[rng.integers(0, len(names), (n, len(names)))].sum(axis=1)
    low, high = np.percentile(draws[:, 0] / draws[:, 1], [2.5, 97.5])
    return float(np.mean(values)), low, high


class Judged:
    """Measures of fits: value(measure, reference, model, loss, lights) is the mean over the lights."""

    def __init__(self, fits, labels):
        self.fits, self.labels = fits.rows, labels.rows

    def value(self, measure, ref, model, loss, lights):
        rows = [self.labels[(ref, self.fits[(ref, model, loss)][0], light)] for light in lights]
        if measure == "colour":  # length of the mean shift in T and P
            return float(np.mean([math.hypot(float(r[3]), float(r[4])) for r in rows]))
        return float(np.mean([float(r[MEASURES.index(measure)]) for r in rows]))

    def column(self, measure, refs, model, loss, lights):
        return [self.value(measure, name, model, loss, lights) for name, *_ in refs]


def failed(judged, refs, model, losses):
    """By loss, whether each fit has a Delta-E above twice that of the best loss, plus 1, under the paper's light."""
    columns = {loss: judged.column("delta_e", refs, model, loss, ["paper"]) for loss in losses}
    best = [min(values) for values in zip(*columns.values())]
    return {loss: [v > 2 * b + 1 for v, b in zip(values, best)] for loss, values in columns.items()}


def print_fits(judged, refs, title, model):
    groups = [material for _, material, *_ in refs]
    lost = failed(judged, refs, model, LOSSES)
    print(f"\n{title}, {model}: {len(refs)} references of {len(set(groups))} materials")
    print(f"{'loss':24s} {'paper light':>12s} {'unseen':>7s} {'JOD unseen [95 %]':>22s} {'colour':>7s} {'redder':>7s} {'failed':>7s}"
          f" {'s':>5s}")
    for loss in LOSSES:
        jod, low, high = bootstrap(judged.column("jod", refs, model, loss, UNSEEN), groups)
        print(f"{loss:24s} {np.mean(judged.column('delta_e', refs, model, loss, ['paper'])):12.2f}"
              f" {np.mean(judged.column('delta_e', refs, model, loss, UNSEEN)):7.2f} {jod:8.3f} [{low:.2f}, {high:.2f}]"
              f" {np.mean(judged.column('colour', refs, model, loss, UNSEEN)):7.2f}"
              f" {np.mean(judged.column('shift_p', refs, model, loss, UNSEEN)):+7.2f} {100 * np.mean(lost[loss]):6.1f}%"
              f" {np.median([float(judged.fits[(name, model, loss)][1]) for name, *_ in refs]):5.2f}")
    jods = {loss: np.array(judged.column("jod", refs, model, loss, UNSEEN)) for loss in LOSSES}
    best = max(CLASSICAL, key=lambda loss: jods[loss].mean())
    for loss, than in (("nqm", best), ("transport", best), ("auto", best), ("auto", "nqm"), ("auto", "transport")):
        print("%s less %s, JOD under the unseen lights: %+.3f [%+.3f, %+.3f]" % (
            loss, than + (", best of the nine" if than == best else ""), *bootstrap(list(jods[loss] - jods[than]), groups)))


PICTURES = {"reference": None, "rms_loge": "rms_loge", "log_diff": "log_diff", "paper": "paper", "nqm": "nqm", "auto": "auto"}


def draw(judged, refs, model, path):
    """A row for each of four references: itself and its fits, on a blob in a room (built in)."""
    chosen = [r for r in refs if r[0] in ("rgl-vch_golden_yellow_rgb", "rgl-ilm_solo_m_68_rgb", "rgl-vch_dragon_eye_red_rgb")]
    chosen += [r for r in refs if r[0].startswith("sgd-")][:2]
    arguments = []
    for name, _, brdf, _ in chosen:
        fits = [judged.fits[(name, model, loss)][0] for loss in PICTURES.values() if loss]
        arguments += (["+"] if arguments else []) + [brdf, *fits]
    run("label", *arguments, "--light", "interior", "--shape", "blob", "--size", "320", "--shrink", "2", "--grid", path)
    print("%s: columns %s; rows %s" % (path, ", ".join(PICTURES), ", ".join(material.replace("_rgb", "") for _, material, *_ in chosen)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data")
    parser.add_argument("--work", default="fitting-study")
    parser.add_argument("--refs", type=int, default=0, help="about this many references instead of all")
    parser.add_argument("--part", choices=["fits", "tables"], help="only this part (default: all)")
    parser.add_argument("--models", default=",".join(MODELS))
    options = parser.parse_args()
    os.makedirs(options.work, exist_ok=True)
    refs = references(options.data, options.refs)
    held_out, measured = [r for r in refs if r[3]], [r for r in refs if r[0].startswith("rgl-")]
    fits = Table(os.path.join(options.work, "fits.csv"), ["reference", "model", "loss", "spec", "seconds"], 3)
    labels = Table(os.path.join(options.work, "labels.csv"), ["reference", "spec", "light", *MEASURES], 3)
    if options.part in (None, "fits"):
        fit_all(refs, fits, LOSSES, options.models.split(","))
        label_all(refs, fits, labels, options.data, LIGHTS)
    judged = Judged(fits, labels)
    for model in options.models.split(","):
        print_fits(judged, held_out, "Held-out materials", model)
        print_fits(judged, measured, "Measured RGL files", model)
    if options.part in (None, "tables"):
        draw(judged, held_out, "ggx", os.path.join(HERE, "..", "doc", "figures", "fits.png"))


if __name__ == "__main__":
    main()
