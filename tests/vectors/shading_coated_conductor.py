# SPDX-License-Identifier: MIT
"""pbrt-v4's coatedconductor by its own random walk (LayeredBxDF::f of src/pbrt/bxdfs.h): the strategies and weights of each case of smooth
and rough layers, and Russian roulette, isotropic, without a medium that scatters. The reflection of a smooth interface, a mirror, is left
out; where both layers are smooth, the value is the reflectance of the mirror (LayeredBxDF::Sample_f followed to its end).
shading_coated_conductor.csv: spec, wi, wo, r, g, b, and the standard error of each. Usage: python3 shading_coated_conductor.py (4 minutes)"""
import csv
import pathlib

import numpy as np

import shading_coated as coat
from shading_coated import d, dot, fresnel, heuristic, lam, sample_transmission, transmit_f_pdf, visible, visible_pdf

WALKS, BATCH = 400_000, 100_000
SMOOTH = 1e-6
METAL = {"conductor.eta": [0.2, 0.9, 1.5], "conductor.k": [3.9, 2.4, 1.2]}


def conductor_fresnel(c, eta, k):
    """(n) cosines to (n, 3), by complex arithmetic."""
    c = np.clip(c, 0, 1)[:, None]
    n = np.array(eta) + 1j * np.array(k)
    ct = np.sqrt(1 - (1 - c * c) / n**2)
    return (np.abs((n * c - ct) / (n * c + ct))**2 + np.abs((c - n * ct) / (c + n * ct))**2) / 2


def conductor_f_pdf(o, i, a, index):
    h = o + i
    h = h / np.linalg.norm(h, axis=1)[:, None]
    lobe = d(h, a) / (1 + lam(o, a) + lam(i, a)) / (4 * o[:, 2] * i[:, 2])
    return lobe[:, None] * conductor_fresnel(dot(i, h), *index), visible_pdf(o, h, a) / (4 * dot(o, h))


def mirrored(w, m):
    out = 2 * dot(w, m)[:, None] * m - w
    return out, (out[:, 2] > 0) & (dot(w, m) > 0)


def reflect(w, a, f):
    """w upwards; f: of the cosine to (n, k). New direction, f cos / pdf, density of a rough layer."""
    smooth = a**2 < SMOOTH
    m = np.tile([0.0, 0, 1], (len(w), 1)) if smooth else visible(w, a)
    out, ok = mirrored(w, m)
    weight = f(np.clip(dot(w, m), 0, 1)) * ok[:, None]
    out = np.where(ok[:, None], out, [0, 0, 1])
    if smooth:
        return out, weight, None
    weight = weight * ((1 + lam(w, a)) / (1 + lam(w, a) + lam(out, a)))[:, None]
    return out, weight, visible_pdf(w, m, a) / (4 * np.maximum(dot(w, m), 1e-12))


def enter(w, a, eta):
    """Direction downwards, f cos / pdf, density."""
    if a**2 >= SMOOTH:
        t, weight, _, pdf = sample_transmission(w, a, eta)
        return t, weight, pdf
    t = -w / eta
    t[:, 2] = -np.sqrt(1 - (1 - w[:, 2]**2) / eta**2)
    return t, 1 - fresnel(w[:, 2], eta), None


def walk(wo, wi, v, n):
    ai, ac = np.sqrt(v["interface.roughness"]), np.sqrt(v["conductor.roughness"])
    eta, gap, depth = v["interface.eta"], v["thickness"], v["maxdepth"]
    index = np.array(v["conductor.eta"]) / eta, np.array(v["conductor.k"]) / eta
    interface_is_smooth, conductor_is_smooth = ai**2 < SMOOTH, ac**2 < SMOOTH
    wo, wi = (np.broadcast_to(w, (n, 3)) for w in (wo, wi))
    total = np.zeros((n, 3))
    if not interface_is_smooth:
        h = (wo + wi)[:1] / np.linalg.norm((wo + wi)[0])
        total += (d(h, ai) * fresnel(dot(wo[:1], h), eta) / (1 + lam(wo[:1], ai) + lam(wi[:1], ai)) / (4 * wo[0, 2] * wi[0, 2]))[:, None]
    w, weight, _ = enter(wo, ai, eta)
    beta = (weight / eta**2)[:, None] * np.ones(3)
    light, light_weight, light_pdf = enter(wi, ai, eta)
    beta = beta * ((weight > 0) & (light_weight > 0))[:, None]
    for step in range(depth):
        if step > 3:
            largest = beta.max(1)
            q = np.where(largest < 0.25, 1 - largest, 0)
            beta = beta * (coat.rng.uniform(size=n) >= q)[:, None] / np.maximum(1 - q, 1e-12)[:, None]
        w = np.where((beta.max(1) > 0)[:, None], w, [0, 0, -1 if step % 2 == 0 else 1])
        beta = beta * np.exp(-gap / np.abs(w[:, 2]))[:, None]
        if step % 2:
            out, factor, _ = reflect(w, ai, lambda c: fresnel(c, 1 / eta)[:, None])
            w, beta = -out, beta * factor
            continue
        if not conductor_is_smooth:
            f, pdf = conductor_f_pdf(-w, -light, ac, index)
            mis = 1 if interface_is_smooth else heuristic(light_pdf, pdf)
            total = total + beta * f * (light_weight * np.exp(-gap / np.abs(light[:, 2])) * mis)[:, None]
        w, factor, pdf = reflect(-w, ac, lambda c: conductor_fresnel(c, *index))
        beta = beta * factor
        if not interface_is_smooth:
            f, exit_pdf = transmit_f_pdf(-w, wi, ai, 1 / eta)
            mis = 1 if conductor_is_smooth else heuristic(pdf, np.where(f > 0, exit_pdf, 1))
            total = total + beta * (f * eta**2 * mis * np.exp(-gap / w[:, 2]))[:, None]
    return total


def mirror(cosine, v):
    """Reflectance of two mirrors, event after event."""
    eta, r, inside, total = v["interface.eta"], np.zeros(3), np.ones(3), np.zeros(3)
    index = np.array(v["conductor.eta"]) / eta, np.array(v["conductor.k"]) / eta
    ct = np.sqrt(1 - (1 - cosine**2) / eta**2)
    r = fresnel(np.array([cosine]), eta)
    total, inside = r * np.ones(3), (1 - r) * np.ones(3)
    for step in range(v["maxdepth"]):
        inside = inside * np.exp(-v["thickness"] / ct)
        if step % 2:
            out = fresnel(np.array([ct]), 1 / eta)
            total, inside = total + inside * (1 - out), inside * out
        else:
            inside = inside * conductor_fresnel(np.array([ct]), *index)[0]
    return total


def rows(cases):
    for interface, conductor, eta, thickness, depth in cases:
        v = {"interface.roughness": interface, "interface.eta": eta, "conductor.roughness": conductor, **METAL,
             "thickness": thickness, "maxdepth": depth}
        spec = "pbrt-coated-conductor:" + ";".join(
            f"{k}={','.join(map(str, x)) if isinstance(x, list) else x}" for k, x in v.items())
        for cos_i, cos_o, phi in ((0.95, 0.8, 1), (0.6, 0.7, 2.5), (0.25, 0.5, 0.3), (0.5, 0.52, 3.1)):
            wi = np.array([np.sqrt(1 - cos_i**2), 0, cos_i])
            wo = np.array([np.sqrt(1 - cos_o**2) * np.cos(phi), np.sqrt(1 - cos_o**2) * np.sin(phi), cos_o])
            if interface < SMOOTH and conductor < SMOOTH:
                yield spec, wi, wo, mirror(np.linalg.norm(wi + wo) / 2, v), np.zeros(3)
                continue
            total, squares = np.zeros(3), np.zeros(3)
            for _ in range(WALKS // BATCH):
                f = walk(wo, wi, v, BATCH)
                total, squares = total + f.sum(0), squares + (f**2).sum(0)
            mean = total / WALKS
            yield spec, wi, wo, mean, np.sqrt(np.maximum(0, squares / WALKS - mean**2) / WALKS)


def main():
    with open(pathlib.Path(__file__).with_suffix(".csv"), "w", newline="") as file:
        file.write(f"# made by shading_coated_conductor.py: numpy {np.__version__}, {WALKS} walks, seed {coat.SEED}\n")
        file.write("spec,wix,wiy,wiz,wox,woy,woz,r,g,b,er,eg,eb\n")
        out = csv.writer(file, lineterminator="\n", quoting=csv.QUOTE_NONNUMERIC)
        cases = [(0.1, 0.1, 1.5, 0.01, 10), (0.01, 0.3, 1.3, 0.1, 10), (0.3, 0.02, 1.5, 0, 10), (0.2, 0.4, 2, 0.05, 4), (0.05, 0.05, 1.8, 0.5, 2),
                 (0, 0.1, 1.5, 0.01, 10), (0, 0.02, 1.3, 0.1, 20), (0.1, 0, 1.5, 0.01, 10), (0.4, 0, 1.8, 0, 6), (0, 0, 1.5, 0.01, 10), (0, 0, 1.8, 0.3, 3)]
        for spec, wi, wo, mean, error in rows(cases):
            out.writerow([spec, *map(float, wi), *map(float, wo), *(float(f"{x:.8g}") for x in (*mean, *error))])


main()
