#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Fits the readout of `similarity` to answers of people, and judges it on materials that the fit has not seen.

usage: PYTHONPATH=python studies/similarity.py DATA [--model MODEL] [--cache FILE.npz] [--loge-share X] [--explore]

DATA/people/similarity_train.csv has triplets "which of two materials is more like the reference" (Lagunas et al. 2019,
DOI 10.1145/3306346.3323036; the answers are GPL-2.0: constants only are used). Triplets with one of the 20 test materials are judged
and never fitted; every choice was made by five folds over the other materials, whose triplets are not fitted either if one material is
of the fold. MODEL has a transport matrix (default: models/transport.safetensors); its pictures and the samples at its directions are
compared here by NumPy alone. Printed: the constants of src/metric/similarity.c, folds, held-out answers for every predictor with
bootstrap intervals over materials. --explore: other components and shares. Needs NumPy and SciPy; 3 minutes, then the cache."""
import argparse
import csv
import json
import os
import struct

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.optimize import minimize
from scipy.stats import rankdata, spearmanr

CURVE = (-14.11196939758611, -0.47364347065458806, -0.21479944748134167)
M_2020 = np.array([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]])
M_LMS = np.array([[1688, 2146, 262], [683, 2951, 462], [99, 309, 3688]]) / 4096
M_ITP = np.array([[2048, 2048, 0], [6610 / 2, -13613 / 2, 7003 / 2], [17933, -17390, -543]]) / 4096
PICTURES = ("structure", "peaks", "skew", "colours", "hue")
RIDGE, FOLDS, RESAMPLES = 1e-3, 5, 300
HERE = os.path.dirname(os.path.abspath(__file__))


# ---- pictures and samples ------------------------------------------------------------------------------------------------


def itp_of(rgb):
    """ITP in units of Delta-E of linear BT.709 in cd/m2."""
    y = (np.clip(rgb, 0, 10000) @ M_2020.T @ M_LMS.T / 10000) ** (2610 / 16384)
    return 720 * ((3424 / 4096 + 2413 / 128 * y) / (1 + 2392 / 128 * y)) ** (2523 / 32) @ M_ITP.T


def tensors_of(path):
    with open(path, "rb") as file:
        data = file.read()
    n = 8 + struct.unpack("<Q", data[:8])[0]
    return {k: np.frombuffer(data[n + v["data_offsets"][0]:n + v["data_offsets"][1]], {"F32": "<f4", "F64": "<f8"}[v["dtype"]])
            .reshape(v["shape"]) for k, v in json.loads(data[8:n]).items() if k != "__metadata__"}


def look(samples, model):
    """What the components compare: of the pictures that a transport matrix makes of samples (n, directions, 3)."""
    t = tensors_of(model)
    points = t["transport.points"]
    rgb = np.einsum("ndc,dcp->npc", samples, t["transport"].reshape(len(samples[0]), 3, -1).astype("f8"))
    itp = itp_of(np.minimum(rgb, points[:, 2:]))
    scenes = []
    for number in np.unique(points[:, 1]):
        here = points[:, 1] == number
        w, x = points[here, 0], itp[:, here]
        mean = np.einsum("p,npc->nc", w, x)
        d = x - mean[:, None]
        moment = [np.einsum("p,npc->nc", w, d**k) for k in (2, 3, 4)]
        chroma = mean[:, 1:]
        scenes.append({"structure": (d * np.sqrt(w)[:, None]).reshape(len(x), -1),
                       "peaks": np.log1p(moment[2][:, :1] ** 0.25),
                       "skew": np.arcsinh(moment[1][:, :1] / 1000) / 3,
                       "colours": np.log1p(np.sqrt(moment[0][:, 1:].sum(1, keepdims=True))),
                       "hue": chroma / (20 + np.linalg.norm(chroma, axis=1, keepdims=True)),
                       "shift": mean})
    return scenes


def distances(x, a, b):
    return np.array([np.linalg.norm(x[i] - x[j]) for i, j in zip(a, b)])


def components(samples, model, a, b):
    """Each is a distance between the BRDFs of pairs (a, b): 0 if they are equal, symmetric, and with the triangle inequality."""
    scenes = look(samples, model)
    g = {k: np.mean([distances(s[k], a, b) for s in scenes], 0) for k in scenes[0]}
    flat = np.log1p(samples).reshape(len(samples), -1)
    g["loge"] = distances(flat, a, b) / np.sqrt(flat.shape[1])
    g["log_diff"] = np.array([np.abs(x).mean() for x in (np.log(samples[a[i:i + 1]] + .003) - np.log(samples[b[i:i + 1]] + .003)
                                                        for i in range(len(a)))])
    return g


def ssim(x, y):
    """SSIM of Wang et al. 2004 of pictures in [0, 1], and its structure term; means over the pixels."""
    def blur(z):
        return gaussian_filter(z, 1.5, truncate=3.4)
    mx, my = blur(x), blur(y)
    vx, vy, c = np.maximum(blur(x * x) - mx * mx, 0), np.maximum(blur(y * y) - my * my, 0), blur(x * y) - mx * my
    s = (c + 4.5e-4) / (np.sqrt(vx * vy) + 4.5e-4)
    return np.mean((2 * mx * my + 1e-4) * (2 * c + 9e-4) / ((mx * mx + my * my + 1e-4) * (vx + vy + 9e-4))), s.mean()


def rendered(brdfs, a, b):
    """Image metrics of the pictures of the standard scenes, as `nqm render` draws them: distances of pairs (a, b)."""
    import nqm
    scene = nqm.Scene(width=96, height=96)
    linear = [scene.render(brdf) for brdf in brdfs]
    inside = scene.image(np.ones(len(scene))) > 0
    itp = [itp_of(np.minimum(x, scene.peak_cdm2)) for x in linear]
    grey = [nqm.srgb(x) @ np.array([.299, .587, .114]) / 255 for x in linear]
    out = []
    for i, j in zip(a, b):
        d = [(itp[j] - itp[i])[s][m] for s, m in enumerate(inside)]
        s = np.mean([ssim(x, y) for x, y in zip(grey[i], grey[j])], 0)
        left = [np.linalg.norm(x - .85 * x.mean(0), axis=1).mean() for x in d]
        out.append([1 - s[0], 1 - s[1], np.mean([np.linalg.norm(x, axis=1).mean() for x in d]), np.mean(left),
                    np.sqrt(np.mean((grey[i] - grey[j]) ** 2))])
    return dict(zip(("SSIM", "SSIM, structure term", "Delta-E ITP of pictures", "Delta-E less 85 % of the shift", "RMSE of pictures"),
                    np.array(out).T))


def load(arguments):
    import nqm
    with open(os.path.join(arguments.data, "people", "similarity_train.csv"), encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    keys = ("reference", "test_a", "test_b")
    names = sorted({r[k] for r in rows for k in keys})
    with open(os.path.join(arguments.data, "labels", "labels_real.csv"), encoding="utf-8") as file:
        tests = {line.split(",")[0].rsplit("_", 1)[0] for line in file}
    d = {"triplets": np.array([[names.index(r[k]) for k in keys] for r in rows]),
         "n": np.array([[float(r["n_a"]), float(r["n_b"])] for r in rows]),
         "kept": np.array([name.split(":")[1] in tests for name in names])}
    brdfs = [nqm.BRDF.open(os.path.join(arguments.data, "nps", name)) for name in names]
    a, b = np.triu_indices(len(names), 1)
    directions = nqm.Model.open(arguments.model).directions
    samples = np.stack([brdf.sample(directions)[0] for brdf in brdfs])
    for k, x in components(samples.astype("f8"), arguments.model, a, b).items():
        d["g:" + k] = x
    scores = [s for i in range(0, len(a), 200)
              for s in nqm.score_samples(samples[a[i:i + 200]], samples[b[i:i + 200]], model=arguments.model)]
    d["p:JOD of the estimate"] = np.array([-s.jod for s in scores])
    d["p:JOD, 85 % of the shift removed"] = np.array(
        [np.hypot(s.parts.structure, .15 * np.linalg.norm(s.parts.shift)) for s in scores])
    for k in scores[0].metrics:
        d["p:" + k] = np.array([s.metrics[k] for s in scores])
    for k, x in rendered(brdfs, a, b).items():
        d["p:" + k] = x
    return d


# ---- fit -------------------------------------------------------------------------------------------------------------------


class Answers:
    def __init__(self, d):
        self.triplets, self.n, self.kept = d["triplets"], d["n"], d["kept"]
        size = len(self.kept)
        index = np.zeros((size, size), int)
        index[np.triu_indices(size, 1)] = np.arange(size * (size - 1) // 2)
        index += index.T
        r, a, b = self.triplets.T
        self.a, self.b = index[r, a], index[r, b]  # pairs
        self.is_test = self.kept[self.triplets].any(1)

    def judge(self, distance, weight):
        """Fraction of triplets in which it agrees with the majority, and of answers."""
        x, y, (na, nb) = distance[self.a], distance[self.b], self.n.T
        p = np.where(x < y, 1.0, np.where(x > y, 0, .5))
        return np.array([np.average(np.where(na > nb, p, 1 - p), weights=weight * (na != nb)),
                         (weight * (p * na + (1 - p) * nb)).sum() / (weight * (na + nb)).sum()])

    def times(self, rng, materials):
        """Weights of the triplets for materials drawn with replacement; others count once."""
        count = np.ones(len(self.kept))
        count[materials] = np.bincount(rng.choice(len(materials), len(materials)), minlength=len(materials))
        return count[self.triplets].prod(1)

    def fit(self, x, weight):
        """Weights >= 0 of components x (pairs, k) whose sum is the distance: a person chooses a with the probability
        1 / (1 + exp(d_a - d_b)); maximum likelihood with a ridge."""
        rows = weight > 0
        d, (na, nb) = (x[self.b] - x[self.a])[rows], (self.n[rows] * weight[rows, None]).T
        total = (na + nb).sum()

        def loss(w):
            z = d @ w
            p = 1 / (1 + np.exp(-z))
            value = (na * np.logaddexp(0, -z) + nb * np.logaddexp(0, z)).sum() / total + RIDGE * (w**2).sum()
            return value, -(na * (1 - p) - nb * p) @ d / total + 2 * RIDGE * w
        return minimize(loss, np.full(x.shape[1], .2), jac=True, method="L-BFGS-B", bounds=[(0, None)] * x.shape[1]).x


def design(d, names, shares):
    """Columns for a fit in which the mean of each component of `shares` over all pairs is its share of the distance's mean; and the
    function from weights of these columns to weights of the raw components."""
    means = np.array([d["g:" + k].mean() for k in names])
    x = np.stack([d["g:" + k] for k in names], 1) / means
    extra = sum(share * d["g:" + k] / d["g:" + k].mean() for k, share in shares.items()) if shares else 0
    rest = 1 - sum(shares.values())

    def raw(w):
        return {**dict(zip(names, w / means)), **{k: w.sum() * s / rest / d["g:" + k].mean() for k, s in shares.items()}}
    return x + np.reshape(extra / rest, (-1, 1)), raw


def folds_of(answers, x, seeds=(1, 2, 3)):
    """Mean of judge() over folds of the materials that are no test materials."""
    materials, out = np.flatnonzero(~answers.kept), []
    for seed in seeds:
        order = np.random.default_rng(seed).permutation(materials)
        for k in range(FOLDS):
            held = np.isin(answers.triplets, order[k::FOLDS]).any(1)
            w = answers.fit(x, (~held & ~answers.is_test).astype(float))
            out.append(answers.judge(x @ w, (held & ~answers.is_test).astype(float)))
    return np.mean(out, 0)


def curve(delta_e):
    return 10 / (1 + np.exp(-CURVE[0] * (-np.power(delta_e, CURVE[2]) - CURVE[1])))


def scale_of(d, distance, pairs):
    """The factor c with which the mean of the curve at c times the distance is that of the JOD without 85 % of the shift."""
    goal = curve(d["p:JOD, 85 % of the shift removed"][pairs]).mean()
    low, high = 1e-3, 1e3
    for _ in range(60):
        c = np.sqrt(low * high)
        low, high = (c, high) if curve(c * distance[pairs]).mean() > goal else (low, c)
    return c


def explore(d, answers):
    sets = [(PICTURES, {"loge": s}) for s in (0, .15, .2, .25, .3, .4)] + [(PICTURES, {"log_diff": s}) for s in (.2, .25, .3, .4)]
    sets += [(tuple(k for k in PICTURES if k != without), {"loge": .25}) for without in PICTURES] + [((k,), {}) for k in PICTURES]
    for names, shares in sets:
        x, _ = design(d, names, shares)
        w = answers.fit(x, (~answers.is_test).astype(float))
        print("folds: majority %.4f agreement %.4f; Spearman with RMS-LogE %.2f" %
              (*folds_of(answers, x), spearmanr(x @ w, d["g:loge"])[0]), *names, shares)


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n")[3][7:])
    parser.add_argument("data")
    parser.add_argument("--model", default=os.path.join(HERE, "..", "models", "transport.safetensors"))
    parser.add_argument("--cache")
    parser.add_argument("--loge-share", type=float, default=.25)
    parser.add_argument("--explore", action="store_true")
    arguments = parser.parse_args()
    if arguments.cache and os.path.exists(arguments.cache):
        d = dict(np.load(arguments.cache))
    else:
        d = load(arguments)
        if arguments.cache:
            np.savez(arguments.cache, **d)
    answers = Answers(d)
    train, test = (~answers.is_test).astype(float), answers.is_test.astype(float)
    print("%d triplets to fit, %d to judge, which have one of %d held-out materials" % (train.sum(), test.sum(), answers.kept.sum()))
    if arguments.explore:
        return explore(d, answers)
    x, raw = design(d, PICTURES, {"loge": arguments.loge_share})
    w = answers.fit(x, train)
    print("folds: majority %.4f, agreement %.4f" % tuple(folds_of(answers, x)))

    a, b = np.triu_indices(len(answers.kept), 1)
    pairs = ~(answers.kept[a] | answers.kept[b])  # the scale, too, has seen no test material
    distance, rng = x @ w, np.random.default_rng(1)
    c = scale_of(d, distance, pairs)
    for k, value in raw(w).items():
        print("constant %-10s %.4g    (%.2f of the mean)" % (k, c * value, value * d["g:" + k].mean() / distance.mean()))
    spread = []
    for _ in range(RESAMPLES):
        again = x @ answers.fit(x, train * answers.times(rng, np.flatnonzero(~answers.kept)))
        spread.append(np.log(again / again[pairs].mean() * distance[pairs].mean() / distance))
    print("half-width of log d, 95 %%: %.3f" % (1.96 * np.std(spread)))

    predictors = {"similarity": distance, **{k[2:]: v for k, v in d.items() if k.startswith("p:")}}
    draws = [test * answers.times(rng, np.flatnonzero(answers.kept)) for _ in range(RESAMPLES)]
    best = (answers.n.max(1) * test).sum() / (answers.n.sum(1) * test).sum()
    print("held out: best possible agreement %.3f\n%-33s majority            agreement           Spearman with similarity" % (best, ""))
    for k, v in predictors.items():
        low, high = np.percentile([answers.judge(v, t) for t in draws], [2.5, 97.5], axis=0)
        at = answers.judge(v, test)
        print("%-33s %.3f [%.3f, %.3f]  %.3f [%.3f, %.3f]  %5.2f" % (k, at[0], low[0], high[0], at[1], low[1], high[1],
                                                                    np.corrcoef(rankdata(v), rankdata(distance))[0, 1]))
    gain = [answers.judge(distance, t) - answers.judge(d["p:SSIM"], t) for t in draws]
    print("similarity less SSIM: majority [%.3f, %.3f], agreement [%.3f, %.3f]" % tuple(np.percentile(gain, [2.5, 97.5], axis=0).T.ravel()))
    return None


if __name__ == "__main__":
    main()
