# SPDX-License-Identifier: MIT
"""Blender's Principled BSDF from Cycles' description of it (svm/closure.h, closure/bsdf_microfacet.h, bsdf_oren_nayar.h, bsdf_util.h), in
80-bit floats and angles; tables: ../../presets/principled_energy.txt, sheen_ltc.txt. cycles_principled.py has what Cycles itself renders.
shading_blender.csv: spec, wi, wo, r, g, b."""
import csv
import pathlib

import numpy

import shading_materialx as mx
from shading_materialx import Pair, cos, exp, lerp, maximum, minimum, one, pi, real, sqrt, white

SEED = 41
rng = numpy.random.default_rng(SEED)
HERE = pathlib.Path(__file__).parent
NUMBERS, LTC = ([[int(x) for x in line.split(",")] for line in open(HERE / "../../presets" / name) if not line.startswith("#")]
                for name in ("principled_energy.txt", "sheen_ltc.txt"))
SHEEN = numpy.array(LTC, real).reshape(3, 32, 32) / 50000
E = numpy.array(NUMBERS[:32], real) / 10000
E_MEAN = numpy.array(NUMBERS[32], real) / 10000
S = numpy.array(NUMBERS[33:], real).reshape(16, 16, 16) / 10000


def table(values, *places):
    """Multilinear."""
    for x in places:
        x = one(x) * (len(values) - 1)
        i = min(int(x), len(values) - 2)
        values = lerp(values[i], values[i + 1], x - i)
    return values


def inverse(f0, f):
    return one((f - f0) / (1 - f0))


def f0_of(ior):
    return ((ior - 1) / (ior + 1))**2


def fresnel(c, eta):
    if eta**2 + c**2 < 1:
        return real(1)
    ct = sqrt(1 - (1 - c * c) / eta**2)
    return ((c - eta * ct) / (c + eta * ct))**2 / 2 + ((eta * c - ct) / (eta * c + ct))**2 / 2


def mean_fresnel(eta):
    k = lambda t: real(t)
    if eta < 1:
        return k("0.997118") + k("0.1014") * eta - k("0.965241") * eta**2 - k("0.130607") * eta**3
    return (eta - 1) / (k("4.08567") + k("1.00071") * eta)


def film(c, eta, thickness, ior):
    """fresnel_iridescence of Cycles 4.2, from complex amplitudes."""
    t = minimum(thickness / 30, 1)
    n = lerp(1, ior, t * t * (3 - 2 * t))
    rs, rp, inside = mx.amplitudes(1, n, c)
    inside = inside.real
    total = numpy.zeros(3, real)
    for r12, r23 in zip((rs.real, rp.real), mx.amplitudes(n, eta, inside)[:2]):
        if abs(abs(r23) - 1) < 1e-15:  # total reflection
            total += 1
            continue
        r23 = r23.real
        phi = pi - (pi if r12 < 0 else 0) + (pi if r23 < 0 else 0)
        t121, product = 1 - r12**2, r12**2 * r23**2
        dc = t121**2 * r23**2 / (1 - product)
        total += r12**2 + dc
        for m in (1, 2, 3):
            path = m * 2 * n * thickness * inside * real("1e-9")
            total += 2 * (dc - t121) * sqrt(product)**m * mx.sensitivity(path, m * phi * white)
    xyz = total / 2 * numpy.array(["0.95047", "1", "1.08883"]).astype(real)
    matrix = numpy.array([["3.2404542", "-1.5371385", "-0.4985314"], ["-0.9692660", "1.8760108", "0.0415560"],
                          ["0.0556434", "-0.2040259", "1.0572252"]]).astype(real)
    return one(matrix @ xyz)


class Lobe:
    def __init__(self, p, x, y, turns, compensated):
        x, y = (minimum(maximum(a, real("1e-4")), 1) for a in (x, y))
        t = numpy.array([cos(2 * pi * turns), numpy.sin(2 * pi * turns), 0])
        b = numpy.array([-t[1], t[0], 0])
        h, wi, wo = p.half, p.wi, p.wo
        d = 1 / (pi * x * y * ((h @ t / x)**2 + (h @ b / y)**2 + h[2]**2)**2)
        lam = lambda w: (sqrt(1 + ((x * (w @ t))**2 + (y * (w @ b))**2) / w[2]**2) - 1) / 2
        self.f = d / (1 + lam(wi) + lam(wo)) / (4 * wi[2] * wo[2])
        self.rough = sqrt(sqrt(x * y))
        self.e, self.e_mean = table(E, self.rough, wo[2]), table(E_MEAN, self.rough)
        self.compensated = compensated

    def scale_and_weight(self, fss):
        """energy_scale, and the factor of the weight."""
        if not self.compensated:
            return real(1), white
        missing = (1 - self.e) / self.e
        fms = fss * self.e_mean / (1 - fss * (1 - self.e_mean))
        return 1 + missing, (1 + fms * missing) / (1 + missing)


def layering(albedo, weight):
    ratio = numpy.where(weight > 0, albedo / numpy.where(weight > 0, weight, 1), 0)
    return weight * one(1 - ratio.max())


def principled(p, v):
    multi = v["multiscatter"] > 0
    weight, total, mu, cd = white.copy(), numpy.zeros(3, real), p.wo[2], cos(p.d)
    if v["sheen_weight"] > 0:
        albedo, a, b = (table(t, maximum(v["sheen_roughness"], real("0.001")), mu) for t in SHEEN)
        sheen, passed = mx.transformed_sheen(p, real(1), white, albedo, a, -b)
        w = v["sheen_weight"] * v["sheen_tint"] * weight
        total = total + w * sheen
        weight = layering(w * (1 - passed), weight)
    if v["coat_weight"] > 0:
        ior = v["coat_ior"]
        lobe = Lobe(p, v["coat_roughness"]**2, v["coat_roughness"]**2, real(0), False)
        w = v["coat_weight"] * weight
        total = total + w * lobe.f * fresnel(cd, ior)
        weight = layering(w * fresnel(mu, ior), weight)
        depth = 1 / sqrt(1 - (1 - mu**2) / ior**2)
        weight = weight * lerp(white, v["coat_tint"]**depth, v["coat_weight"])
    aspect = sqrt(1 - real("0.9") * v["anisotropic"])
    lobe = Lobe(p, v["roughness"]**2 / aspect, v["roughness"]**2 * aspect, v["anisotropic_rotation"], multi)
    if v["metallic"] > 0:
        f0, tint = v["base_color"], minimum(v["specular_tint"], 1)
        f = real(6) / 7
        b = lerp(f0, white, f**5) * (7 / f**6) * (1 - tint)
        curve = one(lerp(f0, white, (1 - cd)**5) - b * cd * (1 - cd)**6)
        scale, darkening = lobe.scale_and_weight(lerp(f0, white, real(1) / 21) - b / 126)
        total = total + v["metallic"] * weight * darkening * scale * lobe.f * curve
        weight = weight * (1 - v["metallic"])
    eta, f0 = v["ior"], f0_of(v["ior"])
    if v["specular_ior_level"] != real("0.5"):
        f0 = f0 * 2 * v["specular_ior_level"]
        root = sqrt(minimum(f0, real("0.99")))
        eta = (1 + root) / (1 - root)
        if v["ior"] < 1:
            eta = 1 / eta
    thickness = v["thin_film_thickness"]
    if eta != 1 or thickness > 0.1:
        real_f0, color = f0_of(eta), one(f0 * v["specular_tint"])

        def factor(c):
            if thickness <= 0.1:
                return lerp(color, white, inverse(real_f0, fresnel(c, eta)))
            f = film(c, eta, thickness, v["thin_film_ior"])
            if real_f0 > 1e-5:
                f = f * lerp(white, color / real_f0, one((f - 1) / (real_f0 - 1)))
            return f
        scale, darkening = lobe.scale_and_weight(lerp(color, white, inverse(real_f0, mean_fresnel(eta))))
        total = total + weight * darkening * scale * lobe.f * factor(cd)
        s = table(S, sqrt(abs(eta - 1) / (eta + 1)), lobe.rough, mu)
        estimate = factor(mu) if thickness > 0.1 else lerp(color, white, s)
        weight = layering(weight * darkening * estimate, weight)
    color, sigma = v["base_color"], v["diffuse_roughness"]
    a = 1 / (pi + sigma * (pi / 2 - real(2) / 3))
    b = sigma * a

    def g(t):
        return numpy.sin(t) * (t - real(2) / 3 - numpy.sin(t) * cos(t)) + 2 * numpy.tan(t) * (1 - numpy.sin(t)**3) / 3
    st = p.dot - cos(p.i) * cos(p.o)
    st = st / maximum(cos(p.i), cos(p.o)) if st > 0 else st
    diffuse = (a + b * st) * white
    if sigma > 0:
        mean = a * pi + (2 * pi - real("5.6")) / 3 * b
        many = color**2 / pi * mean / (1 - mean) / (1 - color * (1 - mean))
        diffuse = diffuse + many * (1 - a * pi - b * g(p.o)) * (1 - a * pi - b * g(p.i))
    return total + weight * color * diffuse


KEYS = {"base_color": (3, 0, 1), "metallic": (1, 0, 1), "roughness": (1, 0.05, 1), "ior": (1, 0.6, 3),
        "diffuse_roughness": (1, 0, 1), "specular_ior_level": (1, 0, 1), "specular_tint": (3, 0, 2), "anisotropic": (1, 0, 1),
        "anisotropic_rotation": (1, 0, 1), "coat_weight": (1, 0, 1), "coat_roughness": (1, 0.02, 1), "coat_ior": (1, 1, 4),
        "coat_tint": (3, 0, 1), "sheen_weight": (1, 0, 1), "sheen_roughness": (1, 0, 1), "sheen_tint": (3, 0, 1),
        "thin_film_thickness": (1, 0, 900), "thin_film_ior": (1, 1, 2.5), "multiscatter": (1, 0, 1)}
NEUTRAL = {"metallic": 0, "specular_ior_level": 0.5, "anisotropic": 0, "coat_weight": 0, "sheen_weight": 0,
           "thin_film_thickness": 0, "diffuse_roughness": 0}


def draw():
    values, text = {}, []
    for name, (n, low, high) in KEYS.items():
        v = numpy.round(rng.uniform(low, high, n), 3)
        if name in NEUTRAL and rng.uniform() < 0.4:
            v = numpy.full(n, NEUTRAL[name])
        if name == "multiscatter":
            v = numpy.round(v)
        values[name] = v.astype(real) if n == 3 else real(v[0])
        text.append(name + "=" + ",".join(repr(float(x)) for x in v))
    return values, "blender-principled:" + ";".join(text)


def main():
    with open(HERE / "shading_blender.csv", "w", newline="") as file:
        file.write(f"# made by shading_blender.py: numpy {numpy.__version__}, 80-bit floats, seed {SEED}\n")
        out = csv.writer(file, lineterminator="\n", quoting=csv.QUOTE_NONNUMERIC)
        file.write("spec,wix,wiy,wiz,wox,woy,woz,r,g,b\n")
        for _ in range(80):
            values, text = draw()
            for k in range(2):
                wo = mx.direction()
                wi = mx.near_mirror(wo) if k else mx.direction()
                p = Pair(wi, wo)
                p.wi, p.wo = (w.astype(real) / sqrt(w.astype(real) @ w.astype(real)) for w in (wi, wo))
                out.writerow([text, *map(float, wi), *map(float, wo), *map(float, principled(p, values))])


main()
