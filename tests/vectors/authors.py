# SPDX-License-Identifier: MIT
"""A tiny dataset in the layout of the paper's authors, written by SciPy: authors/labels.csv, authors/ref/NAME.mat,
authors/model/NAME.mat, and authors_expected.csv with their values. Plain and compressed files, doubles and singles,
columns and rows, a negative value, equal references of one material, and a reference that is stored once for its
material."""
import pathlib

import numpy
import scipy.io

SEED, N = 11, 7
rng = numpy.random.default_rng(SEED)
root = pathlib.Path("authors")
for folder in ("ref", "model"):
    (root / folder).mkdir(parents=True, exist_ok=True)
locations = rng.uniform((0, 0, 0), (60, 30, 180), (N, 3))
head = f"# made by authors.py: numpy {numpy.__version__}, scipy {scipy.__version__}, seed {SEED}\n"


def save(path, rgb, dtype=float, rows=False, **options):
    shape = (1, N) if rows else (N, 1)
    data = {c: rgb[:, k].astype(dtype).reshape(shape) for k, c in enumerate("rgb")}
    scipy.io.savemat(path, {**data, "random_locations": locations}, **options)


brass, felt = rng.uniform(0.01, 2, (2, N, 3))
rows = [  # name, model, level, DeltaE, JOD, class
    ("brass_1", "ward", 0, 22.5, 6.5, 3), ("brass_2", "sbrdf", 2, 9.25, 8.75, 5), ("brass_10", "sbrdf", 2, 9.25, 8.75, 5),
    ("felt_m_68_rgb_1", "ggx", 0, 3.5, 9.875, 6), ("felt_m_68_rgb_2", "ggx", 0, 4.5, 10.25, 6),
]
with open("authors_expected.csv", "w") as expected, open(root / "labels.csv", "w") as labels:
    expected.write(head + "pair,member,direction,r,g,b\n")
    labels.write("material,model,level,DeltaE,JOD,class\n")
    for i, row in enumerate(rows):
        ref = brass + (0.01 if row[0] == "brass_10" else 0) if i < 3 else felt
        test = ref * rng.uniform(0.7, 1.4, (N, 3))
        if i == 1:
            test[4, 2] = -0.01  # out of gamut
        labels.write(",".join(map(str, row)) + "\n")
        if i < 3:
            save(root / "ref" / f"{row[0]}.mat", ref, do_compression=i == 1)
        save(root / "model" / f"{row[0]}.mat", test, numpy.float32 if i == 3 else float, i == 4, do_compression=i > 2)
        for member, rgb in (("ref", ref), ("test", test)):
            for d in range(N):
                values = numpy.maximum(rgb[d], 0).astype(numpy.float32)
                expected.write(f"{i},{member},{d}," + ",".join(repr(v.item()) for v in values) + "\n")
    save(root / "ref" / "felt_m_68_rgb.mat", felt)
numpy.savetxt("authors_locations.csv", locations, fmt="%.17g", delimiter=",", header=head + "theta_h,theta_d,phi_d", comments="")
