# SPDX-License-Identifier: MIT
"""A metallic-roughness shader of glTF in NumPy, for `nqm conform`; it has one mistake (doc/conform.md).
  nqm conform gltf --keys base_color,metallic,roughness --command 'python3 examples/conform/shader.py'"""
import sys

import numpy as np

names = sys.stdin.readline().strip().split(",")
rows = dict(zip(names, np.loadtxt(sys.stdin, "f4", delimiter=",").T))
base = np.array([rows["base_color_" + c] for c in "rgb"])
light, viewer = (np.array([rows[f"{side}_{axis}"] for axis in "xyz"]) for side in ("light", "viewer"))

a2 = rows["roughness"]**4
h = light + viewer
h /= np.sqrt((h * h).sum(axis=0))
n_l, n_v, n_h, v_h = light[2], viewer[2], h[2], (viewer * h).sum(axis=0)
d = a2 / (np.pi * (n_h * n_h * (a2 - 1) + 1)**2)
v = 0.5 / (n_l * np.sqrt(n_v * n_v * (1 - a2) + a2) + n_v * np.sqrt(n_l * n_l * (1 - a2) + a2))
fresnel = 0.04 + 0.96 * (1 - v_h)**5
plain = base / np.pi + fresnel * d * v
metal = (base + (1 - base) * (1 - v_h)**5) * d * v
np.savetxt(sys.stdout, (plain + (metal - plain) * rows["metallic"]).T, "%.9g", delimiter=",", header="r,g,b", comments="")
