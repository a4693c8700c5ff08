#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Pictures and labels that a transport matrix makes of samples, by NumPy in double: writes transport.safetensors to the folder of
this script.

Random matrix A of three scenes with displays of different peaks. The first BRDF is the reference. Pictures are min(A f, peak)
in ITP by the matrices of ITU-R BT.2087 and BT.2100 and the exact PQ function; labels are those of doc/labels.md for each scene,
averaged over the scenes; so are the distances of looks of doc/people.md. `used` drops directions, at which tests have the values of the reference.
"""
import numpy as np

import store

N, POINTS, BRDFS = 7, 128, 5
SCENES = ((50, 1000.0), (30, 60.0), (48, 4000.0))  # points, peak in cd/m2
rng = np.random.default_rng(20261)

M_2020 = np.array([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]])
M_LMS = np.array([[1688, 2146, 262], [683, 2951, 462], [99, 309, 3688]]) / 4096
M_ITP = np.array([[2048, 2048, 0], [6610 / 2, -13613 / 2, 7003 / 2], [17933, -17390, -543]]) / 4096


def pq(luminance):
    y = (luminance / 10000) ** (2610 / 16384)
    return ((3424 / 4096 + 2413 / 128 * y) / (1 + 2392 / 128 * y)) ** (2523 / 32)


light = (rng.random((N, 3, POINTS)) * 10 ** rng.uniform(-1, 2.5, (N, 1, POINTS)) * (rng.random((N, 1, POINTS)) < 0.6)).astype("f4")
points = np.zeros((POINTS, 3))
first = 0
for number, (n, peak) in enumerate(SCENES):
    weight = rng.random(n) + 0.1
    points[first:first + n] = np.stack([weight / weight.sum(), np.full(n, number), np.full(n, peak)], 1)
    first += n

ref = 10 ** rng.uniform(-1.5, 0.5, (N, 3))
rgb = np.stack([ref, ref * 1.02, ref * [1.5, 0.9, 0.6], 10 ** rng.uniform(-1.5, 1.5, (N, 3)), np.zeros((N, 3))]).astype("f4")
used = (rng.random((BRDFS, N)) < 0.7).astype("u1")


def picture(f):
    rgb_cdm2 = np.minimum(np.einsum("kcp,kc->pc", light.astype("f8"), f.astype("f8")), points[:, 2:])
    return 720 * pq(np.minimum(rgb_cdm2, 10000) @ M_2020.T @ M_LMS.T) @ M_ITP.T


def label(a, b):
    parts = []
    for number in range(len(SCENES)):
        scene = points[:, 1] == number
        w, x, y = points[scene, 0], a[scene], b[scene]
        d = y - x
        shift = w @ d

        def deviation(i):
            return np.sqrt(w @ (i - w @ i) ** 2)

        parts.append([w @ np.sqrt((d**2).sum(1)), *shift, np.log((1 + deviation(y[:, 0])) / (1 + deviation(x[:, 0]))),
                      np.sqrt(w @ ((d - shift) ** 2).sum(1))])
    return np.mean(parts, 0)


def looks(a, b):
    """The distance of doc/people.md but for the samples' part."""
    total = 0
    for number, (n, _) in enumerate(SCENES):
        scene = points[:, 1] == number
        w, seen = points[scene, 0], []
        for x in (a[scene], b[scene]):
            mean = w @ x
            d = x - mean
            seen.append((np.log1p((w @ d[:, 0] ** 4) ** 0.25), np.arcsinh(w @ (d[:, 0] / 10) ** 3) / 3,
                         np.log1p(np.sqrt(w @ (d[:, 1:] ** 2).sum(1))), mean[1:] / (20 + np.linalg.norm(mean[1:]))))
        (peaks_a, skew_a, colours_a, hue_a), (peaks_b, skew_b, colours_b, hue_b) = seen
        difference = b[scene] - a[scene]
        structure = np.sqrt(w @ ((difference - w @ difference) ** 2).sum(1))
        total += (0.1133 * structure + 27.81 * abs(peaks_a - peaks_b) + 3.523 * abs(skew_a - skew_b) +
                  8.636 * abs(colours_a - colours_b) + 5.84 * np.linalg.norm(hue_a - hue_b))
    return total / len(SCENES)


itp = np.stack([picture(f) for f in rgb])
itp_used = np.stack([picture(np.where(used[i][:, None] > 0, f, rgb[0])) for i, f in enumerate(rgb)])
tensors = {"points": points, "itp": itp, "itp_used": itp_used, "labels": np.stack([label(itp[0], x) for x in itp]),
           "labels_used": np.stack([label(itp[0], x) for x in itp_used]),
           "looks": np.array([[looks(itp[0], x) for x in itp], [looks(itp[0], x) for x in itp_used]]), "light": light, "rgb": rgb, "used": used}

store.safetensors("transport.safetensors", tensors, {"made_by": store.made_by("transport.py", "seed 20261")})
