# SPDX-License-Identifier: MIT
"""Orthogonal matching pursuit by its definition: two concatenated signals in a block-diagonal dictionary; every step
solves a dense least-squares problem over the selected columns. Writes omp_vectors.h. Needs python3-numpy."""

import numpy as np

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


def array(kind, name, values):
    text = ",\n    ".join(str(v) if kind == "size_t" else repr(float(v)) for v in np.ravel(values))
    return f"static const {kind} {name}[] = {{\n    {text}}};\n"


with open("omp_vectors.h", "w") as out:
    out.write(f"/* SPDX-License-Identifier: MIT\n *\n * Made by omp.py: numpy {np.__version__}.\n */\n/* clang-format off */\n")
    out.write(f"enum {{ OMP_BLOCKS = {BLOCKS}, OMP_ATOMS = {ATOMS}, OMP_LENGTH = {LENGTH}, OMP_CHOSEN = {CHOSEN} }};\n")
    out.write(array("double", "omp_atoms", atoms))
    out.write(array("double", "omp_signals", signals))
    out.write(array("size_t", "omp_index", chosen))
    out.write(array("double", "omp_coefficient", coefficient))
    out.write(array("double", "omp_residual", residuals))
