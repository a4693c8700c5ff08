# SPDX-License-Identifier: MIT
"""Arrays as numpy.save() writes them, and f_r of the tables in them, interpolated linearly in sqrt(theta_h), theta_d, phi_d and phi_h
by numpy. Writes the folder npy and npy.safetensors. Usage: python3 npy.py"""
import os

import numpy as np

import store

SEED = 20261122
N_H, N_D, N_P, N_PHI_H = 3, 2, 4, 3


def interpolate_turned(table, hd, phi_h):
    """f_r of a table with phi_h, which is an axis of its own."""
    x = phi_h / (2 * np.pi) * N_PHI_H
    around = np.abs(x - np.arange(N_PHI_H))
    weight = np.maximum(0, 1 - np.minimum(around, N_PHI_H - around))
    return sum(w * interpolate(table[:, :, :, m], hd) for m, w in enumerate(weight) if w > 0)


def directions(hd, phi_h):
    """Light and viewer of half-vector coordinates, by rotations about the second and third axis."""
    d = np.array([np.sin(hd[1]) * np.cos(hd[2]), np.sin(hd[1]) * np.sin(hd[2]), np.cos(hd[1])])
    c, s = np.cos(hd[0]), np.sin(hd[0])
    tilt = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    c, s = np.cos(phi_h), np.sin(phi_h)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return [turn @ tilt @ (d * sign) for sign in ([1, 1, 1], [-1, -1, 1])]


def interpolate(table, hd):
    """f_r at (theta_h, theta_d, phi_d); nodes with NaN are left out."""
    a = np.sqrt(hd[0] / (np.pi / 2)) * (N_H - 1)
    b = hd[1] / (np.pi / 2) * (N_D - 1)
    c = hd[2] % np.pi / np.pi * N_P
    total, weight = np.zeros(3), 0
    for i in range(N_H):
        for j in range(N_D):
            for k in range(N_P):
                around = min(abs(c - k), N_P - abs(c - k))
                w = max(0, 1 - abs(a - i)) * max(0, 1 - abs(b - j)) * max(0, 1 - around)
                if w > 0 and not np.isnan(table[i, j, k, 0]):
                    weight += w
                    total += w * table[i, j, k]
    return total / weight


def main():
    rng = np.random.default_rng(SEED)
    table = rng.uniform(0, 2, (N_H, N_D, N_P, 3)).astype("<f4")
    table[1, 0, 2, 0] = np.nan
    turned = np.random.default_rng(SEED + 1).uniform(0, 2, (N_H, N_D, N_P, N_PHI_H, 3)).astype("<f4")
    files = {"f4": table, "turned": turned, "f8": table.astype("<f8"), "fortran": np.asfortranarray(table), "big": table.astype(">f4"),
             "integer": np.ones((2, 2, 2, 3), "<i4"), "planes": np.ones((3, 2, 2, 2), "<f4")}
    points = np.stack([rng.uniform(0, 1.2, 20), rng.uniform(0, 0.35, 20), rng.uniform(0, 2 * np.pi, 20)], 1)
    for name, array in files.items():
        np.save(os.path.join(store.HERE, "npy", name), array)
    values, turned_values = [], []
    for i, hd in enumerate(points):
        phi_h = (0.1 + 2.4 * i) % (2 * np.pi)
        values.append([*hd, *interpolate(table.astype(float), hd)])
        turned_values.append([*np.concatenate(directions(hd, phi_h)), *interpolate_turned(turned.astype(float), hd, phi_h)])
    # theta_h, theta_d, phi_d in radians and f_r of the table; light, viewer and f_r of the table with phi_h
    store.safetensors("npy.safetensors", {"values": np.array(values), "turned": np.array(turned_values)},
                      {"made_by": store.made_by("npy.py", f"seed {SEED}")})


main()
