# SPDX-License-Identifier: MIT
"""Orthogonal matching pursuit by its definition: two concatenated signals in a block-diagonal dictionary; every step
solves a dense least-squares problem over the selected columns. Writes omp.safetensors. Needs python3-numpy."""

import numpy as np

import store

BLOCKS, ATOMS, LENGTH, CHOSEN = 2, 14, 9, 7
rng = np.random.default_rng(20220705)
atoms = rng.normal(size=(ATOMS, LENGTH))
atoms /= np.linalg.norm(atoms, axis=1)[:, None]
signals = rng.normal(size=(BLOCKS, LENGTH)) * np.array([[3.0], [1.5]])

columns = np.kron(np.eye(BLOCKS), atoms).T  # (BLOCKS * LENGTH, BLOCKS * ATOMS)
target = signals.ravel()
chosen, residuals = [], []
rest = target
for _ in range(CHOSEN):
    match = np.abs(columns.T @ rest)
    match[chosen] = -1
    chosen.append(int(match.argmax()))
    coefficient = np.linalg.lstsq(columns[:, chosen], target, rcond=None)[0]
    rest = target - columns[:, chosen] @ coefficient
    residuals.append(np.linalg.norm(rest))

store.safetensors("omp.safetensors", {"atoms": atoms, "signals": signals, "index": np.array(chosen, "i8"), "coefficient": coefficient,
                                      "residual": np.array(residuals)}, {"made_by": store.made_by("omp.py")})
