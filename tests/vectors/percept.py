# SPDX-License-Identifier: MIT
"""ITP of colours with 50 digits (mpmath) from ITU-R BT.2087, BT.2100 and BT.2124; Delta-E of consecutive colours with
the BT.709 to BT.2020 matrix derived from the primaries instead of the rounded one; and a JOD curve fitted by scipy to
made-up scores. Writes percept.safetensors to the folder of this script. Usage: python3 percept.py"""
import random

import mpmath as mp
import numpy as np
import scipy
import scipy.stats
from scipy.optimize import least_squares

import store

mp.mp.dps = 50
N = 40
SEED = 20250611

ROUNDED = mp.matrix([["0.6274", "0.3293", "0.0433"], ["0.0691", "0.9195", "0.0114"], ["0.0164", "0.0880", "0.8956"]])
LMS = mp.matrix([[1688, 2146, 262], [683, 2951, 462], [99, 309, 3688]]) / 4096
ICTCP = mp.matrix([[2048, 2048, 0], [6610, -13613, 7003], [17933, -17390, -543]]) / 4096


def xyz_from_rgb(primaries):
    """RGB to XYZ from the chromaticities of the primaries and D65."""
    columns = [[mp.mpf(x) / mp.mpf(y), 1, (1 - mp.mpf(x) - mp.mpf(y)) / mp.mpf(y)] for x, y in primaries]
    m = mp.matrix(columns).T
    x, y = mp.mpf("0.3127"), mp.mpf("0.3290")
    scale = mp.lu_solve(m, mp.matrix([x / y, 1, (1 - x - y) / y]))
    return m * mp.diag(list(scale))


DERIVED = mp.inverse(xyz_from_rgb([("0.708", "0.292"), ("0.170", "0.797"), ("0.131", "0.046")])) * xyz_from_rgb(
    [("0.64", "0.33"), ("0.30", "0.60"), ("0.15", "0.06")])


def pq(luminance):
    y = (mp.mpf(luminance) / 10000) ** (mp.mpf(2610) / 16384)
    c1, c2, c3 = mp.mpf(3424) / 4096, mp.mpf(2413) / 128, mp.mpf(2392) / 128
    return ((c1 + c2 * y) / (1 + c3 * y)) ** (mp.mpf(2523) / 32)


def itp(rgb, matrix):
    lms = LMS * (matrix * mp.matrix(rgb))
    i, ct, cp = ICTCP * mp.matrix([pq(v) for v in lms])
    return [i, ct / 2, cp]


def delta_e(a, b, matrix):
    return 720 * mp.sqrt(sum((x - y) ** 2 for x, y in zip(itp(a, matrix), itp(b, matrix))))


def c(x):
    return mp.nstr(x, 19, min_fixed=-1, max_fixed=1)


def scores(rng):
    """Scores (Delta-E, JOD) with noise around a curve other than the published one, and the best of many scipy fits."""
    truth = np.array([-9.0, -0.42, -0.3])
    x = np.array([round(rng.uniform(1, 70), 2) for _ in range(30)])

    def jod(b):
        return 10 * (1 - 1 / (1 + np.exp(b[0] * (-x ** b[2] - b[1]))))

    y = np.round(jod(truth) + np.array([rng.gauss(0, 0.8) for _ in x]), 2)
    fits = [least_squares(lambda b: jod(b) - y, [b1, b2, b3], method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=20000)
            for b1 in (-20, -9, -4) for b2 in (-0.8, -0.4, -0.2) for b3 in (-0.6, -0.3, -0.15)]
    best = min(fits, key=lambda fit: fit.cost)
    return x, y, best.x, np.sqrt(2 * best.cost / len(x)), scipy.stats.spearmanr(x, y).correlation


np.seterr(over="ignore")  # large trial steps of the fits overflow


def main():
    rng = random.Random(SEED)
    colours = [[0, 0, 0], [100, 100, 100], [10000, 10000, 10000], [0, 0, 300], [1000, 0, 0], [0, 203, 0]]
    while len(colours) < N:
        grey = 10 ** rng.uniform(-3, 3.5)
        colours.append([round(grey * rng.uniform(0.3, 1.7), 6) for _ in range(3)])
    signals = [[float(y), float(c(pq(y)))] for y in ["0.001", "0.1", "1", "5", "10", "48", "100", "203", "1000", "4000", "9999"]]
    rows = []  # BT.709 RGB in cd/m2, ITP, Delta-E to the colour before by the rounded matrix of BT.2087 and by the derived one
    for last, rgb in zip([colours[-1], *colours], colours):
        row = [mp.mpf(v) for v in rgb] + itp(rgb, ROUNDED) + [delta_e(last, rgb, ROUNDED), delta_e(last, rgb, DERIVED)]
        rows.append([float(c(v)) for v in row])
    x, y, b, rmse, spearman = scores(rng)
    arrays = {"pq": signals, "itp": rows, "score": np.stack([x, y], 1), "fit": [*b, rmse, spearman]}  # pq: cd/m2, signal
    store.safetensors("percept.safetensors", {name: np.array(v, "f8") for name, v in arrays.items()},
                      {"made_by": store.made_by("percept.py", "mpmath " + mp.__version__, "scipy " + scipy.__version__, f"seed {SEED}")})


main()
