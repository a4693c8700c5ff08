# SPDX-License-Identifier: MIT
"""The tables by which Cycles keeps the energy of GGX lobes (kernel/closure/bsdf_microfacet.h, app/cycles_precompute.cpp of Blender), by
quadrature over the visible normals of Heitz 2018, where Cycles has random samples. alpha = roughness^2; nodes are i / (n - 1):

  E      (32 roughnesses, 32 cosines)       albedo of a lobe without Fresnel factor
  E mean (32 roughnesses)                   2 times the integral of E cos
  s      (16 z, 16 roughnesses, 16 cosines) albedo between F0 (0) and 1 (1) of a dielectric; sqrt(F0) = z^2

Writes the rows of ../../presets/principled_energy.txt, unit 1/10000. Usage: python3 principled_energy.py (2 minutes)"""
import pathlib

import numpy as np

N = 192  # points of the quadrature along each axis
T = ((np.arange(N) + 0.5) / N)[:, None]
MASS = np.repeat(3 * T**2 / N**2, N, axis=1)  # of the points, which are dense where normals are steep


def visible(rough, mu):
    """G2 / G1, cosine between viewer and normal, and whether light comes from above, at points of the space of samples."""
    r, phi = np.sqrt(1 - T**3), 2 * np.pi * T.T
    a = rough**2
    v = np.array([a * np.sqrt(1 - mu * mu), 0, mu])
    v /= np.linalg.norm(v)
    t1 = np.array([0, 1.0, 0])
    t2 = np.cross(v, t1)
    x, y = r * np.cos(phi), r * np.sin(phi)
    s = (1 + v[2]) / 2
    y = (1 - s) * np.sqrt(1 - x * x) + s * y
    z = np.sqrt(np.maximum(0, 1 - x * x - y * y))
    h = x[..., None] * t1 + y[..., None] * t2 + z[..., None] * v
    h = np.stack([a * h[..., 0], a * h[..., 1], np.maximum(0, h[..., 2])], -1)
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    wo = np.array([np.sqrt(1 - mu * mu), 0, mu])
    c = h @ wo
    ci = 2 * c * h[..., 2] - mu
    with np.errstate(divide="ignore", invalid="ignore"):
        lam = lambda x: (np.sqrt(1 + a * a * (1 / x**2 - 1)) - 1) / 2
        weight = np.where(ci > 0, (1 + lam(mu)) / (1 + lam(mu) + lam(np.maximum(ci, 1e-9))), 0)
    return weight, np.clip(c, 0, 1), ci > 0


def fresnel(c, eta):
    g = np.sqrt(eta**2 - 1 + c * c)
    return ((g - c) / (g + c))**2 * (1 + ((c * (g + c) - 1) / (c * (g - c) + 1))**2) / 2


def node(i, n, top=1.0):
    return min(max(i / (n - 1), 1e-4), top)


def main():
    gx, gw = np.polynomial.legendre.leggauss(48)
    rows = []
    means = []
    for i in range(32):
        e = lambda mu: (MASS * visible(node(i, 32), mu)[0]).sum()
        rows.append([e(node(j, 32)) for j in range(32)])
        means.append(sum(w * (x + 1) / 2 * e((x + 1) / 2) for x, w in zip(gx, gw)))
    rows.append(means)
    parts = [[visible(node(i, 16), node(j, 16))[1:] for j in range(16)] for i in range(16)]
    for k in range(16):
        root = node(k, 16, 0.99)**2
        eta, f0 = (1 + min(root, 0.99**0.5)) / (1 - min(root, 0.99**0.5)), min(root**2, 0.99)
        for i in range(16):
            rows.append([(MASS * np.clip((fresnel(c, eta) - f0) / (1 - f0), 0, 1) * up).sum() for c, up in parts[i]])
    out = pathlib.Path(__file__).parent / "../../presets/principled_energy.txt"
    with open(out, "w") as f:
        f.write("# Albedos of GGX lobes as Cycles uses them, by tests/vectors/principled_energy.py, which explains them: 32 rows of E and one "
                "of its\n# mean; then 16 times 16 rows of s. Unit 1/10000.\n")
        for row in rows:
            f.write(",".join(str(int(round(1e4 * min(1, max(0, v))))) for v in row) + "\n")


main()
