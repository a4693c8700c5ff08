# SPDX-License-Identifier: MIT
"""Mitsuba 3's principled BSDF without transmission, from its documentation and Burley's course notes of 2012 and 2015, in 80-bit
floats, angles and Fresnel amplitudes. shading_principled.csv: spec, wi, wo, r, g, b."""
import csv
import pathlib

import numpy

SEED = 15
real = numpy.longdouble
pi = numpy.arctan2(real(0), real(-1))
rng = numpy.random.default_rng(SEED)


def geometry(wi, wo):
    wi, wo = (v.astype(real) / numpy.sqrt((v.astype(real)**2).sum()) for v in (wi, wo))
    h = wi + wo
    h = h / numpy.sqrt(h @ h)
    polar = lambda v: numpy.arctan2(numpy.hypot(v[0], v[1]), v[2])
    return polar(wi), polar(wo), polar(h), numpy.arccos(min(real(1), wi @ h))


def fresnel(eta, theta):
    """Reflectance at a dielectric from Fresnel's sine and tangent laws."""
    if theta < 1e-6:
        return ((eta - 1) / (eta + 1))**2
    t = numpy.arcsin(numpy.sin(theta) / eta)
    s = (numpy.sin(theta - t) / numpy.sin(theta + t))**2
    p = (numpy.tan(theta - t) / numpy.tan(theta + t))**2
    return (s + p) / 2


def g1(alpha, theta):
    return 2 / (1 + numpy.sqrt(1 + (alpha * numpy.tan(theta))**2))


def half_vector(wi, wo):
    h = wi.astype(real) / numpy.sqrt(wi.astype(real) @ wi) + wo.astype(real) / numpy.sqrt(wo.astype(real) @ wo)
    return h / numpy.sqrt(h @ h)


def anisotropic_ggx(wi, wo, roughness, anisotropic):
    """D G1 G1 of Walter et al. in the form with two widths of Heitz 2014, from vectors."""
    aspect = numpy.sqrt(1 - real("0.9") * anisotropic)
    ax, ay = (max(real("0.001"), real(roughness)**2 * s) for s in (1 / aspect, aspect))
    h = half_vector(wi, wo)
    d = 1 / (pi * ax * ay * ((h[0] / ax)**2 + (h[1] / ay)**2 + h[2]**2)**2)
    for w in (wi.astype(real), wo.astype(real)):
        d = d * 2 / (1 + numpy.sqrt(1 + ((ax * w[0])**2 + (ay * w[1])**2) / w[2]**2))
    return d


def principled(wi, wo, base_color, roughness, metallic, eta, spec_tint, sheen, sheen_tint, flatness, clearcoat, clearcoat_gloss,
               anisotropic=None):
    ti, to, th, td = geometry(wi, wo)
    ci, co, ch, cd = (numpy.cos(x) for x in (ti, to, th, td))
    base = base_color.astype(real)
    weight = lambda cosine: (1 - cosine)**5
    lum = real("0.212671") * base[0] + real("0.715160") * base[1] + real("0.072169") * base[2]
    tint = base / lum if lum > 0 else base * 0 + 1
    # main lobe: GGX
    alpha = max(real("0.001"), real(roughness)**2)
    d = alpha**2 / (pi * ch**4 * (alpha**2 + numpy.tan(th)**2)**2)
    r0 = ((real(eta) - 1) / (real(eta) + 1))**2 * tint
    schlick = lambda f0: f0 + (1 - f0) * weight(cd)
    f = (1 - metallic) * (1 - spec_tint) * fresnel(real(eta), td) + metallic * schlick(base) + (1 - metallic) * spec_tint * schlick(r0)
    dg = d * g1(alpha, ti) * g1(alpha, to) if anisotropic is None else anisotropic_ggx(wi, wo, roughness, anisotropic)
    value = f * dg / (4 * ci * co)
    # clearcoat: GTR of exponent 1
    a = real("0.1") + (real("0.001") - real("0.1")) * clearcoat_gloss
    d = (a**2 - 1) / (2 * pi * numpy.log(a) * (numpy.sin(th)**2 + a**2 * ch**2))
    value = value + real("0.25") * clearcoat * schlick(real("0.04")) * d * g1(real("0.25"), ti) * g1(real("0.25"), to)
    # diffuse, retro-reflection, flat subsurface
    fi, fo = weight(ci), weight(co)
    rr = 2 * real(roughness) * cd**2
    diffuse = (1 - fi / 2) * (1 - fo / 2) + rr * (fo + fi + fo * fi * (rr - 1))
    ss = (1 + (rr / 2 - 1) * fi) * (1 + (rr / 2 - 1) * fo)
    flat = real("1.25") * (ss * (1 / (ci + co) - real("0.5")) + real("0.5"))
    value = value + (1 - metallic) * base / pi * ((1 - flatness) * diffuse + flatness * flat)
    return value + sheen * (1 - metallic) * weight(cd) * (1 - sheen_tint + sheen_tint * tint)


def pairs(n):
    for i in range(n):
        wi = rng.normal(size=3)
        wi[2] = abs(wi[2]) + 1e-3
        wi /= numpy.linalg.norm(wi)
        wo = rng.normal(size=3) if i % 2 else wi * [-1, -1, 1] + rng.normal(size=3) * 10**rng.uniform(-3, -0.5)
        wo[2] = abs(wo[2]) + 1e-3
        yield wi, wo / numpy.linalg.norm(wo)


KEYS = "base_color roughness metallic eta spec_tint sheen sheen_tint flatness clearcoat clearcoat_gloss".split()
rows = []
for case in range(40):
    values = {k: float(rng.uniform()) if rng.uniform() < 0.7 else float(rng.integers(2)) for k in KEYS}
    values["eta"] = float(rng.uniform(1.05, 2.5))
    values["base_color"] = rng.uniform(size=3) if case else numpy.zeros(3)
    if case >= 20:
        values["anisotropic"] = float(rng.uniform()) if case % 5 else 1.0
    spec = "principled:" + ";".join(
        f"{k}={','.join(repr(float(x)) for x in v) if k == 'base_color' else repr(v)}" for k, v in values.items())
    for wi, wo in pairs(8):
        rows.append([spec, *map(repr, map(float, wi)), *map(repr, map(float, wo)),
                     *(f"{float(v):.17g}" for v in principled(wi, wo, **values))])

with open(pathlib.Path(__file__).with_suffix(".csv"), "w", newline="") as f:
    f.write(f"# shading_principled.py, NumPy {numpy.__version__}, seed {SEED}\n")
    out = csv.writer(f, lineterminator="\n")
    out.writerow("spec wix wiy wiz wox woy woz r g b".split())
    out.writerows(rows)
