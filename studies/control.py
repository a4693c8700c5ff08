#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""A control for the networks: boosted trees on the scalar features of a pair, evaluated on the same pairs.

usage: studies/control.py PAIRS.csv... [--judge test] [--seeds 3] [--csv OUT.csv] [--json OUT.json] [--pairs OUT.csv]

PAIRS.csv are files of `nqm eval --pairs`; together they contain the training pairs and the evaluation pairs (split
`--judge`). The trees (histogram boosting, Ke et al. 2017) learn log Delta-E from the columns `scalar:` of the training
pairs. Their sizes and number are selected on the validation materials, or on folds of the training materials if the
validation materials are the evaluation materials. Each seed omits a random tenth of the training materials; the control
is the mean over the seeds, and each seed is also evaluated by itself. The models and metrics in the files, and rank
averages of the control with each model, are evaluated on the same pairs. Models NAME, NAME-seed2, NAME-seed3 are seeds
of one recipe: their mean and standard deviation are also printed. Intervals are bootstrap percentiles over materials,
as in `nqm eval`. Needs numpy, scipy and scikit-learn (Debian: python3-sklearn)."""
import argparse
import csv
import json
import re

import numpy
from scipy.stats import rankdata
from sklearn.ensemble import HistGradientBoostingRegressor

CURVE = (-14.11196939758611, -0.47364347065458806, -0.21479944748134167)  # DESIGN: the published labels' JOD curve
MIN_DELTA_E = 0.05  # as --min-delta-e of nqm train
GRID = [{"max_leaf_nodes": leaves, "min_samples_leaf": least, "l2_regularization": 1.0} for leaves in (8, 16, 31) for least in (10, 40)]
MAX_TREES, LEARNING_RATE, FOLDS, EDGE = 600, 0.05, 5, 9.5
FIXED = {"ref", "material", "test", "kind", "split", "delta_e", "jod", "family", "class", "shift_i", "shift_t", "shift_p",
         "contrast", "structure", "similarity_jod", "adapted_jod"}
METRICS = ["rmse", "mae", "rms_crwe", "ma_crwe", "rms_loge", "ma_loge", "rms_logwe", "ma_logwe", "log_diff"]


def read(paths):
    """Rows of all files, each pair once, and the names of the models in the files that contain the evaluation pairs."""
    rows = []
    for path in paths:
        with open(path, newline="", encoding="utf-8") as file:
            rows += list(csv.DictReader(file))
    return rows


def jod_of(log_delta_e):
    b1, b2, b3 = CURVE
    return 10 * (1 - 1 / (1 + numpy.exp(b1 * (-(numpy.exp(log_delta_e) ** b3) - b2))))


class Part:
    """The pairs of one split as arrays."""

    def __init__(self, rows, features):
        self.rows = rows
        self.x = numpy.array([[float(row[name]) for name in features] for row in rows]).reshape(len(rows), len(features))
        self.jod = numpy.array([float(row["jod"]) for row in rows])
        self.target = numpy.log(numpy.maximum([float(row["delta_e"]) for row in rows], MIN_DELTA_E))
        self.material = numpy.array([row["material"] for row in rows])

    def column(self, name):
        return numpy.array([row[name] for row in self.rows])


# ---- fitting ---------------------------------------------------------------------------------------------------------


def boosted(settings, n_trees, x, y):
    model = HistGradientBoostingRegressor(learning_rate=LEARNING_RATE, max_iter=n_trees, early_stopping=False, **settings)
    return model.fit(x, y)


def folds_of(train, seed):
    """(fit, held-out) masks over the training pairs, split by material."""
    materials = numpy.random.default_rng(seed).permutation(numpy.unique(train.material))
    for k in range(FOLDS):
        held = numpy.isin(train.material, materials[k::FOLDS])
        yield ~held, held


def curve_of_errors(settings, fit, held):
    model = boosted(settings, MAX_TREES, *fit)
    return numpy.array([numpy.mean(numpy.abs(p - held[1])) for p in model.staged_predict(held[0])])


def choose(train, validation):
    """The settings and the number of trees with the smallest mean absolute error of log Delta-E on held-out
    materials."""
    best = None
    for settings in GRID:
        if validation:
            errors = curve_of_errors(settings, (train.x, train.target), (validation.x, validation.target))
        else:
            errors = numpy.mean([curve_of_errors(settings, (train.x[a], train.target[a]), (train.x[b], train.target[b]))
                                 for a, b in folds_of(train, 0)], axis=0)
        n_trees = int(numpy.argmin(errors)) + 1
        if best is None or errors[n_trees - 1] < best[0]:
            best = (errors[n_trees - 1], settings, n_trees)
    return best


def fit_seed(train, settings, n_trees, seed):
    materials = numpy.unique(train.material)
    left_out = numpy.random.default_rng(seed).choice(materials, len(materials) // 10, replace=False)
    keep = ~numpy.isin(train.material, left_out)
    return boosted(settings, n_trees, train.x[keep], train.target[keep])


# ---- evaluation ------------------------------------------------------------------------------------------------------


def spearman(a, b):
    if len(a) < 2:
        return numpy.nan
    p, q = rankdata(a), rankdata(b)
    p, q = p - p.mean(), q - q.mean()
    size = numpy.sqrt((p @ p) * (q @ q))
    return p @ q / size if size > 0 else numpy.nan


def mean_of(values):
    values = [v for v in values if not numpy.isnan(v)]
    return float(numpy.mean(values)) if values else numpy.nan


def judge(prediction, jod, material, n_bootstrap, has_jod):
    """Spearman over all pairs and as the mean over materials with at least 3 pairs, with 95 % intervals by material."""
    index = {m: numpy.flatnonzero(material == m) for m in numpy.unique(material)}
    inside = {m: spearman(prediction[i], jod[i]) if len(i) > 2 else numpy.nan for m, i in index.items()}
    names, rng, pooled, means = list(index), numpy.random.default_rng(1), [], []
    for _ in range(n_bootstrap if len(names) > 1 else 0):
        drawn = [names[k] for k in rng.integers(len(names), size=len(names))]
        i = numpy.concatenate([index[m] for m in drawn])
        pooled.append(spearman(prediction[i], jod[i]))
        means.append(mean_of([inside[m] for m in drawn]))
    interval = [numpy.nanpercentile(v, [2.5, 97.5]).tolist() if v else [numpy.nan] * 2 for v in (pooled, means)]
    return {"n": len(jod), "n_materials": len(names), "spearman": float(spearman(prediction, jod)), "ci95": interval[0],
            "spearman_mean_by_material": mean_of(inside.values()), "ci95_mean_by_material": interval[1],
            "mae": float(numpy.mean(numpy.abs(prediction - jod))) if has_jod else numpy.nan}


def selections(part):
    """(by, name, mask) of every table: all pairs, then near and far pairs, and by family, kind, class and range."""
    yield "all", "all", numpy.ones(len(part.rows), bool)
    far = numpy.isin(part.column("family"), ["far", "rounding"])
    yield "subset", "near", ~far
    yield "subset", "far", part.column("family") == "far"
    for by in ("family", "kind", "class"):
        values = part.column(by)
        for value in sorted(set(values) - {""}):
            yield by, value, values == value
    yield "range", f"JOD < {EDGE}", part.jod < EDGE
    yield "range", f"JOD >= {EDGE}", part.jod >= EDGE


def recipe_of(name):
    """The recipe of a model name: "default" for "default-seed2", "control" for "control seed 2"."""
    return re.sub("[- ]seed ?[0-9]+$", "", name)


def predictions_of(part, control, seeds):
    """name -> (values, whether the values are in JOD, where higher is better)"""
    out = {}
    models = [name for name in part.rows[0] if name not in FIXED and name not in METRICS and ":" not in name]
    for name in models + METRICS:
        values = numpy.array([float(row[name]) for row in part.rows])
        out[name] = (values, True) if name in models else (-values, False)
    out["control"] = (control, True)
    for k, values in enumerate(seeds):
        out[f"control seed {k + 1}"] = (values, True)
    for name in dict.fromkeys(map(recipe_of, models)):
        out[f"control+{name}"] = (rankdata(control) + rankdata(out[name][0]), False)
    return out


def judge_all(part, predictions, n_bootstrap):
    results = []
    for by, name, mask in selections(part):
        if mask.any():
            for predictor, (values, has_jod) in predictions.items():
                n = n_bootstrap if by in ("all", "subset") else 0
                figures = judge(values[mask], part.jod[mask], part.material[mask], n, has_jod)
                results.append({"by": by, "selection": name, "name": predictor, **figures})
    return results


def over_seeds(results):
    """Mean and standard deviation of each statistic over the seeds of a recipe, for every selection."""
    groups = {}
    for r in results:
        if r["name"] != "control" and "+" not in r["name"]:  # "control" itself is the mean of its seeds
            groups.setdefault((r["by"], r["selection"], recipe_of(r["name"])), []).append(r)
    out = []
    for (by, selection, name), rows in groups.items():
        if len(rows) > 1:
            figures = {k: [r[k] for r in rows] for k in ("spearman", "spearman_mean_by_material", "mae")}
            out.append({"by": by, "selection": selection, "name": name, "seeds": len(rows),
                        **{k: float(numpy.mean(v)) for k, v in figures.items()},
                        **{k + "_sd": float(numpy.std(v, ddof=1)) for k, v in figures.items()}})
    return out


# ---- output ----------------------------------------------------------------------------------------------------------


def show(results, predictions):
    width = max(len(name) for name in predictions) + 2
    print(f"{'':{width}}{'Spearman [95 %]':24}{'mean by material':24}{'MAE':>6}")
    for r in results:
        if r["by"] in ("all", "subset"):
            pooled = "{:.3f} [{:.3f}, {:.3f}]".format(r["spearman"], *r["ci95"])
            means = "{:.3f} [{:.3f}, {:.3f}]".format(r["spearman_mean_by_material"], *r["ci95_mean_by_material"])
            if r["name"] == next(iter(predictions)):
                print(f"{r['selection']}: {r['n']} pairs")
            print(f"{r['name']:{width}}{pooled:24}{means:24}" + ("" if numpy.isnan(r["mae"]) else f"{r['mae']:6.3f}"))
    for s in over_seeds(results):
        if s["by"] == "all":
            pooled = "{:.3f} (sd {:.3f})".format(s["spearman"], s["spearman_sd"])
            means = "{:.3f} (sd {:.3f})".format(s["spearman_mean_by_material"], s["spearman_mean_by_material_sd"])
            print(f"{s['name'] + ' x' + str(s['seeds']):{width}}{pooled:24}{means:24}{s['mae']:6.3f} (sd {s['mae_sd']:.3f})")
    names = [name for name in predictions if name not in METRICS[:-1] and name == recipe_of(name)]
    print("\nSpearman over the pairs of each selection:\n\n" + f"{'':22}{'n':>6}  " + "  ".join(f"{n:>10}" for n in names))
    for by, selection in dict.fromkeys((r["by"], r["selection"]) for r in results):
        row = {r["name"]: r for r in results if (r["by"], r["selection"]) == (by, selection)}
        figures = "  ".join(f"{row[n]['spearman']:{max(len(n), 10)}.3f}" for n in names)
        print(f"{selection:22}{row[names[0]]['n']:6}  {figures}")


def plain(value):
    """NaN becomes null."""
    if isinstance(value, dict):
        return {k: plain(v) for k, v in value.items()}
    if isinstance(value, list):
        return [plain(v) for v in value]
    return None if isinstance(value, float) and numpy.isnan(value) else value


def write_csv(path, results):
    columns = ["by", "selection", "name", "n", "n_materials", "spearman", "ci95", "spearman_mean_by_material",
               "ci95_mean_by_material", "mae"]
    with open(path, "w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow([c for name in columns for c in ([name + "_low", name + "_high"] if name.startswith("ci95") else [name])])
        for r in results:
            values = [v for name in columns for v in (r[name] if name.startswith("ci95") else [r[name]])]
            out.writerow(["" if isinstance(v, float) and numpy.isnan(v) else v for v in values])


def write_pairs(path, part, predictions):
    with open(path, "w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        names = ["ref", "material", "test", "kind", "family", "class", "split", "jod"]
        out.writerow(names + list(predictions))
        for i, row in enumerate(part.rows):
            out.writerow([row[n] for n in names] + [values[i] for values, _ in predictions.values()])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("files", nargs="+", metavar="PAIRS.csv")
    parser.add_argument("--judge", default="test", choices=["test", "validation"])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--bootstrap", type=int, default=1000)
    for name in ("csv", "json", "pairs"):
        parser.add_argument("--" + name, metavar="OUT")
    options = parser.parse_args()
    rows = read(options.files)
    features = [name for name in rows[0] if name.startswith("scalar:")]
    train, validation, judged = (Part([r for r in rows if r["split"] == s], features) for s in ("train", "validation", options.judge))
    if not train.rows or not judged.rows or not features:
        parser.error("the files hold no training pairs, no pairs to judge on or no scalar features")
    error, settings, n_trees = choose(train, None if options.judge == "validation" or not validation.rows else validation)
    seeds = [jod_of(fit_seed(train, settings, n_trees, seed).predict(judged.x)) for seed in range(1, options.seeds + 1)]
    predictions = predictions_of(judged, numpy.mean(seeds, axis=0), seeds)
    results = judge_all(judged, predictions, options.bootstrap)
    print(f"control: {n_trees} trees, {settings}; {len(train.rows)} pairs of {len(set(train.material))} materials, error {error:.3f}")
    print(f"judged on {options.judge}: {len(judged.rows)} pairs of {len(set(judged.material))} materials\n")
    show(results, predictions)
    if options.csv:
        write_csv(options.csv, results)
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump(plain({"schema": 1, "trees": n_trees, "settings": settings, "results": results, "seeds": over_seeds(results)}), file, indent=1)
    if options.pairs:
        write_pairs(options.pairs, judged, predictions)


if __name__ == "__main__":
    main()
