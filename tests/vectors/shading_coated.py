# SPDX-License-Identifier: MIT
"""pbrt-v4's coateddiffuse by its own random walk (LayeredBxDF::f of src/pbrt/bxdfs.h, with its two strategies and their weights, and
Russian roulette), 200,000 walks a pair, isotropic, without a medium that scatters. shading_coated_conductor.py has its functions too.
shading_coated.csv: spec, wi, wo, r, g, b, and the standard error of each. Usage: python3 shading_coated.py (2 minutes)"""
import csv
import pathlib

import numpy as np

SEED, WALKS, BATCH = 5, 200_000, 100_000
rng = np.random.default_rng(SEED)


def lam(w, a):
    return (np.sqrt(1 + a * a * (1 / w[..., 2]**2 - 1)) - 1) / 2


def d(h, a):
    return a * a / (np.pi * (h[..., 2]**2 * (a * a - 1) + 1)**2)


def dot(a, b):
    return (a * b).sum(-1)


def fresnel(c, eta):
    """c: cosine with the interface, positive; eta: beyond relative to this side."""
    s2 = (1 - c * c) / eta**2
    ct = np.sqrt(np.maximum(0, 1 - s2))
    r = ((eta * c - ct) / (eta * c + ct))**2 / 2 + ((c - eta * ct) / (c + eta * ct))**2 / 2
    return np.where(s2 >= 1, 1, r)


def visible(w, a):
    """A visible normal of each direction (z > 0)."""
    n = len(w)
    v = w * [a, a, 1]
    v /= np.linalg.norm(v, axis=1)[:, None]
    t1 = np.where((v[:, 2] < 0.99999)[:, None], np.cross([0, 0, 1], v), [1, 0, 0])
    t1 /= np.linalg.norm(t1, axis=1)[:, None]
    t2 = np.cross(v, t1)
    r, phi = np.sqrt(rng.uniform(size=n)), 2 * np.pi * rng.uniform(size=n)
    x, y = r * np.cos(phi), r * np.sin(phi)
    h = np.sqrt(1 - x * x)
    y = (1 + v[:, 2]) / 2 * y + (1 - (1 + v[:, 2]) / 2) * h
    z = np.sqrt(np.maximum(0, 1 - x * x - y * y))
    m = x[:, None] * t1 + y[:, None] * t2 + z[:, None] * v
    m = np.stack([a * m[:, 0], a * m[:, 1], np.maximum(1e-6, m[:, 2])], 1)
    return m / np.linalg.norm(m, axis=1)[:, None]


def visible_pdf(w, m, a):
    return d(m, a) / (1 + lam(w, a)) * np.abs(dot(w, m)) / np.abs(w[..., 2])


def transmit_f_pdf(wo, wi, a, eta):
    """f (without the factor of radiance) and density of the transmission of wo to wi, on opposite sides; eta: of wi's side."""
    wm = wi * eta + wo
    wm = wm / np.linalg.norm(wm, axis=1)[:, None]
    wm = wm * np.sign(wm[:, 2])[:, None]
    o, i = dot(wo, wm), dot(wi, wm)
    ok = (o * wo[:, 2] > 0) & (i * wi[:, 2] > 0)
    f = fresnel(np.abs(o), eta)
    denominator = (i + o / eta)**2
    value = d(wm, a) * (1 - f) / (1 + lam(wo, a) + lam(wi, a)) * np.abs(i * o / (wi[:, 2] * wo[:, 2] * denominator))
    pdf = d(wm, a) / (1 + lam(wo, a)) * np.abs(o) / np.abs(wo[:, 2]) * np.abs(i) / denominator
    return np.where(ok, value, 0), np.where(ok, pdf, 0)


def sample_transmission(w, a, eta):
    """From outside to inside: direction, weight f cos / pdf, f and density; weight 0: none."""
    m = visible(w, a)
    c = dot(w, m)
    ct = np.sqrt(np.maximum(0, 1 - (1 - c * c) / eta**2))
    t = -w / eta + (c / eta - ct)[:, None] * m
    f, pdf = transmit_f_pdf(w, t, a, eta)
    ok = (t[:, 2] < 0) & (f > 0) & (pdf > 0)
    weight = np.where(ok, f * np.abs(t[:, 2]) / np.where(ok, pdf, 1), 0)
    return t, weight, np.where(ok, f, 0), np.where(ok, pdf, 1)


def heuristic(f, g):
    return f * f / (f * f + g * g)


def walk(wo, wi, v, n):
    a, eta, gap, rho = np.sqrt(v["roughness"]), v["eta"], v["thickness"], np.array(v["reflectance"])
    wo, wi = (np.broadcast_to(w, (n, 3)) for w in (wo, wi))
    h = (wo + wi)[:1] / np.linalg.norm((wo + wi)[0])
    top = d(h, a) * fresnel(dot(wo[:1], h), eta) / (1 + lam(wo[:1], a) + lam(wi[:1], a)) / (4 * wo[0, 2] * wi[0, 2])
    total = np.tile(top[:, None], (n, 3))
    w, enter, _, _ = sample_transmission(wo, a, eta)
    beta = (enter / eta**2)[:, None] * np.ones(3)  # radiance
    s, _, s_f, s_pdf = sample_transmission(wi, a, eta)
    alive = (enter > 0) & (s_f > 0)
    for depth in range(v["maxdepth"]):
        if depth > 3:
            largest = beta.max(1)
            q = np.where(largest < 0.25, 1 - largest, 0)
            alive &= rng.uniform(size=n) >= q
            beta = beta / np.maximum(1 - q, 1e-12)[:, None]
        beta = beta * np.exp(-gap / np.maximum(np.abs(w[:, 2]), 1e-9))[:, None] * alive[:, None]
        if depth % 2:  # the interface from inside
            up = w * [1, 1, 1]
            m = visible(np.where(up[:, 2:] > 1e-7, up, [0, 0, 1]), a)
            c = dot(up, m)
            out = 2 * c[:, None] * m - up
            ok = alive & (out[:, 2] > 0) & (c > 0)
            g = (1 + lam(up, a)) / (1 + lam(up, a) + lam(np.where(ok[:, None], out, up), a))
            beta = beta * np.where(ok, fresnel(np.maximum(c, 0), 1 / eta) * g, 0)[:, None]
            alive = ok
            w = np.where(ok[:, None], -out, [0, 0, -1])
        else:
            light = np.abs(s[:, 2])
            weight = heuristic(s_pdf, light / np.pi)
            total = total + beta * rho / np.pi * (light * weight * np.exp(-gap / np.maximum(light, 1e-9)) * s_f / s_pdf)[:, None]
            r, phi = np.sqrt(rng.uniform(size=n)), 2 * np.pi * rng.uniform(size=n)
            w = np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(np.maximum(1e-12, 1 - r * r))], 1)
            beta = beta * rho
            f, pdf = transmit_f_pdf(-w, wi, a, 1 / eta)
            weight = np.where(f > 0, heuristic(w[:, 2] / np.pi, pdf), 0)
            total = total + beta * (np.exp(-gap / w[:, 2]) * f * eta**2 * weight)[:, None]
    return total


def main():
    with open(pathlib.Path(__file__).with_suffix(".csv"), "w", newline="") as file:
        file.write(f"# made by shading_coated.py: numpy {np.__version__}, {WALKS} walks, seed {SEED}\n")
        file.write("spec,wix,wiy,wiz,wox,woy,woz,r,g,b,er,eg,eb\n")
        out = csv.writer(file, lineterminator="\n", quoting=csv.QUOTE_NONNUMERIC)
        cases = [(0.1, 1.5, 0.01, 10), (0.01, 1.3, 0.01, 10), (0.5, 1.5, 0.1, 100), (0.3, 2, 0, 20), (0.04, 1.8, 0.5, 3)]
        for roughness, eta, thickness, depth in cases:
            v = {"roughness": roughness, "eta": eta, "reflectance": [0.9, 0.5, 0.1], "thickness": thickness, "maxdepth": depth}
            spec = "pbrt-coated-diffuse:" + ";".join(
                f"{k}={','.join(map(str, x)) if isinstance(x, list) else x}" for k, x in v.items())
            for cos_i, cos_o, phi in ((0.95, 0.8, 1), (0.6, 0.7, 2.5), (0.25, 0.5, 0.3)):
                wi = np.array([np.sqrt(1 - cos_i**2), 0, cos_i])
                wo = np.array([np.sqrt(1 - cos_o**2) * np.cos(phi), np.sqrt(1 - cos_o**2) * np.sin(phi), cos_o])
                total, squares = np.zeros(3), np.zeros(3)
                for _ in range(WALKS // BATCH):
                    f = walk(wo, wi, v, BATCH)
                    total, squares = total + f.sum(0), squares + (f**2).sum(0)
                mean = total / WALKS
                error = np.sqrt(np.maximum(0, squares / WALKS - mean**2) / WALKS)
                out.writerow([spec, *map(float, wi), *map(float, wo), *(float(f"{x:.8g}") for x in (*mean, *error))])


if __name__ == "__main__":
    main()
