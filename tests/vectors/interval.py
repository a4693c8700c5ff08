# SPDX-License-Identifier: MIT
"""Intervals of a model by the formulas of include/nqm/model.h: a table of three rows, the factor of novelty, disagreement and
peak, and the least half-width. Writes interval.safetensors. Needs python3-numpy."""

import numpy as np

import store

CASES, KNOTS, SOFT = 24, 17, 1e-3
B1, B2, B3 = 1.75, -2.1, 0.35
GROWTH = np.array([0.25, 0.3, 0.4])  # novelty, disagreement, peak
TABLE = np.array([[0, 0, 0.2], [6, 5.8, 6.1], [10, 9.97, 10]])


def logit(jod):
    return np.log((jod + SOFT) / (10 - jod + SOFT))


def from_logit(y):
    return np.clip((10 + SOFT - SOFT * np.exp(-y)) / (1 + np.exp(-y)), 0, 10)


def curve(delta_e):
    return 10 * (1 - 1 / (1 + np.exp(B1 * (-(delta_e**B3) - B2))))


rng = np.random.default_rng(20261123)
knots = np.linspace(-logit(10), logit(10), KNOTS)
least = np.abs(rng.normal(size=KNOTS)) * np.where(np.arange(KNOTS) % 3, 0.2, 0)
jod = np.concatenate([[0, 10, 9.9999, 6], 10 * rng.uniform(size=CASES - 4) ** 0.5])
novelty = rng.uniform(0, 2, CASES)
log_estimate = rng.uniform(np.log(0.05), np.log(60), CASES)
ref_peak = rng.uniform(0, 20, CASES)

disagreement = np.log(1 + np.abs(logit(jod) - logit(curve(np.exp(log_estimate)))) / 0.1)
peak = np.maximum(0, ref_peak - 8) / 10
factor = np.exp(GROWTH[0] * novelty + GROWTH[1] * disagreement + GROWTH[2] * peak)
y, floor = logit(jod), np.interp(logit(jod), knots, least)
down, up = [np.abs(y - logit(np.interp(jod, TABLE[:, 0], TABLE[:, k]))) for k in (1, 2)]
low, high = from_logit(y - np.maximum(factor * down, floor)), from_logit(y + np.maximum(factor * up, floor))

model = np.concatenate([[B1, B2, B3], GROWTH, TABLE.ravel(), least])
cases = np.stack([jod, novelty, log_estimate, ref_peak, disagreement, peak, low, high], 1)
store.safetensors("interval.safetensors", {"model": model, "cases": cases}, {"made_by": store.made_by("interval.py")})
