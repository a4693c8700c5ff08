#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Scores of samples by NumPy in double, written from doc/model-format.md: metric.csv, the test vectors of that page, from pairs whose
samples are formulas of theta_h and theta_d; and the specification to which tests/python/test_torch_metric.py compares other pairs.
usage: metric.py    (writes metric.csv to the folder of this script)"""
import json
import math
import os
import sys

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
MODELS = {"default": "default.safetensors", "transport": "transport.safetensors", "paper": "full/paper.safetensors"}
DARK = 0.003
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def read(path):
    """Tensors in double, and metadata."""
    with open(path, "rb") as file:
        header = json.loads(file.read(int.from_bytes(file.read(8), "little")))
        data = file.read()
    kinds = {"F16": "<f2", "F32": "<f4", "F64": "<f8"}
    return {name: np.frombuffer(data[slice(*row["data_offsets"])], kinds[row["dtype"]]).astype("f8").reshape(row["shape"])
            for name, row in header.items() if name != "__metadata__"}, header["__metadata__"]


def model(name):
    return read(os.path.join(HERE, "../../models", MODELS[name]))


def cosines(degrees):
    """cos(theta_i) cos(theta_o) by vector algebra: wi is the difference vector turned to the half vector."""
    h, d, phi = np.radians(degrees).T
    x, z = np.sin(d) * np.cos(phi), np.cos(d)
    wi = z * np.cos(h) - x * np.sin(h)
    wo = 2 * z * np.cos(h) - wi
    return np.maximum(wi, 0) * np.maximum(wo, 0)


# ---- estimate by light transport ----

def picture(f, t):
    """ITP times 720 of each point, (points, 3)."""
    m = len(t["transport.points"])
    rgb = np.stack([f[:, c] @ t["transport"][:, m * c:m * (c + 1)] for c in range(3)], 1)
    rgb = np.minimum(rgb, t["transport.points"][:, 2:])
    bt2020 = rgb @ np.array([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]]).T
    lms = np.clip(bt2020 @ np.array([[1688, 2146, 262], [683, 2951, 462], [99, 309, 3688]]).T / 4096, 2.0**-30, 10000)
    y = (lms / 10000) ** (2610 / 16384)
    signal = ((3424 / 4096 + 2413 / 128 * y) / (1 + 2392 / 128 * y)) ** (2523 / 32)
    return 720 * signal @ np.array([[2048, 2048, 0], [3305, -6806.5, 3501.5], [17933, -17390, -543]]).T / 4096


def label(a, b, points):
    """Delta-E, shift of I, T, P, contrast, structure: means over the scenes."""
    parts = []
    for number in np.unique(points[:, 1]):
        scene = points[:, 1] == number
        w, d = points[scene, 0], (b - a)[scene]
        shift = w @ d
        deviation = [math.sqrt(w @ (x - w @ x) ** 2) for x in (a[scene, 0], b[scene, 0])]
        parts.append([w @ np.linalg.norm(d, axis=1), *shift, math.log((1 + deviation[1]) / (1 + deviation[0])),
                      math.sqrt(w @ ((d - shift) ** 2).sum(1))])
    return np.mean(parts, 0)


def estimate_targets(ref, test, used, t):
    delta_e, *shift, contrast, structure = label(picture(ref, t), picture(np.where(used[:, None], test, ref), t), t["transport.points"])
    return [math.log(max(delta_e, 0.05)), *np.arcsinh(shift), math.asinh(30 * contrast), math.log(max(structure, 0.05))]


# ---- scalar features ----

def size(x):
    return math.log(x + 1e-3)


def opponents(x):
    return x[..., 0] - x[..., 1], x[..., 2] - (x[..., 0] + x[..., 1]) / 2


def rms(x):
    return math.sqrt(np.mean(np.square(x))) if np.size(x) else 0.0


def ratio(weight, a, b):
    """Log ratios of weighted means: of luminance, and the opponents of those of the channels."""
    if not weight.sum() > 0:
        return 0.0, 0.0, 0.0
    mean_a, mean_b = weight @ a / weight.sum(), weight @ b / weight.sum()
    return (math.log((LUMINANCE @ mean_b + DARK) / (LUMINANCE @ mean_a + DARK)), *opponents(np.log((mean_b + DARK) / (mean_a + DARK))))


def scalars(ref, test, used, degrees):
    """The features up to ref_colour by name."""
    a, b, c, (theta_h, theta_d, _) = ref[used], test[used], cosines(degrees)[used], degrees[used].T
    out = {}
    for name, f in {"e": lambda x: x, "_crwe": lambda x: np.cbrt(c[:, None] * x), "_loge": np.log1p, "_logwe": lambda x: np.log1p(c[:, None] * x)}.items():
        out["log_rms" + name] = math.log(rms(f(b) - f(a)) + 1e-4)
        out["log_ma" + name] = math.log(np.mean(np.abs(f(b) - f(a))) + 1e-4)
    d, level = np.log((b + DARK) / (a + DARK)), np.log(a @ LUMINANCE + DARK)
    out["log_log_diff"] = math.log(np.mean(np.abs(d)) + 1e-4)
    light = np.log(b @ LUMINANCE + DARK) - level
    out.update(rms=size(rms(d)), max=size(np.abs(light).max()), tail=size(np.mean(light**4) ** 0.25), bias=np.mean(light),
               bulk=size(np.mean(np.sqrt(np.abs(light))) ** 2), shape=size(np.std(light)))
    ends = [0, 2, 5, 15, 35, 91]
    zones = [(theta_h >= low) & (theta_h < high) for low, high in zip(ends, ends[1:])]
    for name, zone in zip(("0_2", "2_5", "5_15", "15_35", "35_90"), zones):
        out["bias_" + name] = ratio(zone * 1.0, a, b)[0]
        out["rms_" + name] = size(rms(light[zone]))
    grazing = light[c < 0.25]
    out.update(bias_grazing=np.mean(grazing), rms_grazing=size(rms(grazing)),
               width=ratio((theta_h < 5) * 1.0, a, b)[0] - ratio((theta_h >= 5) * 1.0, a, b)[0])
    u, v = opponents(d)
    energy, *colour = ratio(c, a, b)
    out.update(chroma=size(math.sqrt(np.mean(u**2 + v**2))), chroma_rg=np.mean(u), chroma_b=np.mean(v), energy=energy,
               energy_chroma=size(math.hypot(*colour)))
    cells = [zone & (theta_d >= low) & (theta_d < high) for zone in zones for low, high in ((0, 30), (30, 60), (60, 91))]
    smooth = np.array([(cell.mean(), *ratio(cell * 1.0, a, b)) for cell in cells])
    peaks = [math.log((x @ LUMINANCE).max() + DARK) for x in (a, b)]
    out.update(peak=peaks[1] - peaks[0], smooth=size(math.sqrt(smooth[:, 0] @ smooth[:, 1] ** 2)),
               smooth_chroma=size(math.sqrt(smooth[:, 0] @ (smooth[:, 2] ** 2 + smooth[:, 3] ** 2))), ref_level=np.mean(level),
               ref_energy=math.log(c @ (a @ LUMINANCE) / c.sum() + DARK), ref_peak=peaks[0] - np.mean(level), ref_spread=np.std(level),
               ref_colour=math.sqrt(np.mean(np.square(opponents(np.log(a + DARK))).sum(0))))
    return out


# ---- network and score ----

def network(x, t):
    n_layers = 1 + sum(name.endswith(".norm.weight") for name in t)
    for i in range(n_layers):
        x = t[f"layers.{i}.weight"] @ x + t[f"layers.{i}.bias"]
        if i + 1 < n_layers:
            x = (x - x.mean()) / math.sqrt(x.var() + 1e-5) * t[f"layers.{i}.norm.weight"] + t[f"layers.{i}.norm.bias"]
            x = np.array([0.5 * y * (1 + math.erf(y / math.sqrt(2))) for y in x])
    return x[0]


def inputs(ref, test, used, targets, t, metadata):
    whitened = [((np.log(np.cbrt(f) + 1) - t["whitening.mean"]) / t["whitening.std"] * used[:, None]).ravel() for f in (ref, test)]
    if metadata["layout"] == "ref_test":
        x = whitened
    else:
        difference = t["difference_scale"] * (whitened[1] - whitened[0])
        x = [whitened[0], difference, np.abs(difference)]
    if "scalars" in metadata:
        values = scalars(ref, test, used, t["directions_deg"])
        for name, value in zip(("", "_i", "_t", "_p", "_contrast", "_structure"), targets):
            values["estimate" + name] = value
        chosen = np.array([values[name] for name in metadata["scalars"].split(",")])
        x.append(t["scalars.scale"] * np.clip((chosen - t["scalars.mean"]) / t["scalars.std"], -5, 5))
    return np.concatenate(x)


def score(ref, test, used, t, metadata):
    """Delta-E (None: the model predicts none) and JOD of samples (n, 3) at the model's directions; used: (n) booleans."""
    targets = estimate_targets(ref, test, used, t) if "transport" in t else [0] * 6
    z = network(inputs(ref, test, used, targets, t, metadata), t) if "layers.0.weight" in t else 0
    mean, std, low, high = t["target"]
    value = targets[0] + mean + std * (low + (high - low) / (1 + math.exp(-z)))
    if metadata["target"] == "jod":
        return None, value
    delta_e, worst = math.exp(value), np.abs(np.log((test + 5e-6) / (ref + 5e-6)))[used].max()
    if worst < math.log(1.65):
        delta_e = min(delta_e, 165 * worst)
    b1, b2, b3 = t["jod_curve"]
    return delta_e, 10 / (1 + math.exp(b1 * (delta_e**b3 + b2))) if delta_e > 1e-9 else 10


# ---- pairs ----

def samples(parameters, degrees):
    """f_r of a constant R, G, B and a lobe: scale s, exponent n, Fresnel factor k; rounded to float."""
    r, g, b, s, n, k = parameters
    lobe = s * (n + 2) / (2 * math.pi) * np.cos(np.radians(degrees[:, 0])) ** n * (1 + k * (1 - np.cos(np.radians(degrees[:, 1]))) ** 5)
    return (np.array([r, g, b]) + lobe[:, None]).astype("f4").astype("f8")


def pairs(n, seed=34):
    """Parameters of n pairs, from equal to unlike."""
    rng = np.random.default_rng(seed)
    for i in range(n):
        ref, other = [[*rng.uniform(0, 0.2, 3), 10 ** rng.uniform(-2.5, 0), 10 ** rng.uniform(0.3, 3.3), rng.uniform(0, 4)] for _ in range(2)]
        test = ref if i % 20 == 0 else other if i % 4 == 1 else ref * np.exp(rng.normal(0, 10 ** rng.uniform(-4, -0.3), 6))
        yield np.round(ref, 6), np.round(test, 6)


def main():
    opened = {name: model(name) for name in MODELS}
    names = ["r", "g", "b", "s", "n", "k"]
    with open(os.path.join(HERE, "metric.csv"), "w", encoding="utf-8") as file:
        file.write(f"# made by metric.py: numpy {np.__version__}, Python {sys.version.split()[0]}\n")
        columns = [f"{of}_{name}" for of in ("ref", "test") for name in names]
        file.write(",".join([*columns, "left_out", "default_delta_e", "default_jod", "transport_delta_e", "transport_jod", "paper_jod"]) + "\n")
        for i, (ref, test) in enumerate(pairs(24)):
            row, left_out = [*ref, *test], 0 if i % 3 else 11  # each 11th direction, from the first on; 0: none
            for t, metadata in opened.values():
                degrees = t["directions_deg"]
                used = np.arange(len(degrees)) % left_out > 0 if left_out else np.ones(len(degrees), bool)
                values = score(samples(ref, degrees), samples(test, degrees), used, t, metadata)
                row += [value for value in values if value is not None]
            file.write(",".join([*map(repr, map(float, row[:12])), str(left_out), *(f"{value:.12g}" for value in row[12:])]) + "\n")


if __name__ == "__main__":
    main()
