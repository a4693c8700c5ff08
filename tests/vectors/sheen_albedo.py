# SPDX-License-Identifier: MIT
"""Directional albedo E of the sheen lobe of KHR_materials_sheen ("Charlie" distribution and shadowing, Estevez and Kulla 2017,
"Production Friendly Microfacet Sheen BRDF"), by Gauss-Legendre quadrature. Writes the table of ../../presets/sheen_albedo.txt and
sheen_albedo.csv, random points for the test of the interpolation. The table has E up to 2; above 1 (small roughness, grazing light) it counts as 1: the
layer below cannot lose more than all of its light. Usage: python3 sheen_albedo.py (3 minutes)"""
import os

import numpy as np

N = 32
HERE = os.path.dirname(os.path.abspath(__file__))
SEED = 20261122


def shadowing_exponent(x, a):
    first, second = np.array([21.5473, 3.82987, 0.19823, -1.97760, -4.32054]), np.array(
        [25.3245, 3.32435, 0.16801, -1.27393, -4.85967])
    p = first + (second - first) * (1 - a) ** 2
    return p[0] / (1 + p[1] * x ** p[2]) + p[3] * x + p[4]


def shadowing(c, a):
    low = np.exp(shadowing_exponent(np.minimum(c, 0.5), a))
    high = np.exp(2 * shadowing_exponent(0.5, a) - shadowing_exponent(1 - np.maximum(c, 0.5), a))
    return np.where(c < 0.5, low, high)


def gauss(n):
    x, w = np.polynomial.legendre.leggauss(n)
    return (x + 1) / 2, w / 2


def albedo(cosine, roughness, n=220):
    a = max(roughness, 1e-3) ** 2
    s, ws = gauss(n)
    c, wc = s ** 2, 2 * s * ws  # dense at the horizon
    phi, wphi = np.pi * s ** 2, 4 * np.pi * s * ws  # both halves; dense where light and viewer have one azimuth
    sine = np.sqrt(1 - c * c)
    x = sine[:, None] * np.cos(phi) + np.sqrt(1 - cosine ** 2)
    y = sine[:, None] * np.sin(phi)
    xy, z = x * x + y * y, (c + cosine)[:, None]
    distribution = (2 + 1 / a) * (xy / (xy + z * z)) ** (0.5 / a) / (2 * np.pi)
    visibility = 1 / (4 * cosine * c * (1 + shadowing(c, a) + shadowing(np.array(cosine), a)))
    return (distribution @ wphi) @ (visibility * c * wc)


def main():
    axis = np.linspace(0, 1, N)
    # roughness and cosine 0 have no finite albedo: the limits for all other cosines, and a cosine of 1e-4
    table = [[0 if r == 0 else min(2, albedo(max(t * t, 1e-4), r)) for t in axis] for r in axis]
    with open(os.path.join(HERE, "../../presets/sheen_albedo.txt"), "w") as f:
        f.write("# Directional albedo E of the sheen lobe of glTF, by tests/vectors/sheen_albedo.py, which explains it. Rows: roughness i / 31;\n"
                "# columns: square root of the cosine j / 31; unit 1/10000.\n")
        for row in table:
            f.write(",".join(str(round(1e4 * e)) for e in row) + "\n")
    rng = np.random.default_rng(SEED)
    with open(os.path.join(HERE, "sheen_albedo.csv"), "w") as f:
        f.write("roughness,cosine,albedo\n")
        for r, t in zip(rng.uniform(0.05, 1, 40), rng.uniform(0.05, 1, 40)):
            f.write(f"{r:.6f},{t * t:.6f},{min(1, albedo(round(t * t, 6), round(r, 6), 320)):.6f}\n")


if __name__ == "__main__":
    main()
