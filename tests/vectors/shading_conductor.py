# SPDX-License-Identifier: MIT
"""Rough conductors from the documentation of Mitsuba 3 (roughconductor: Walter et al. 2007) and pbrt-v4 (conductor: Physically
Based Rendering, 4th edition, 9.3 and 9.6), in 80-bit floats, angles and complex Fresnel amplitudes.
shading_conductor.csv: spec, wi, wo, r, g, b."""
import csv
import pathlib

import numpy

SEED = 14
real = numpy.longdouble
pi = numpy.arctan2(real(0), real(-1))
rng = numpy.random.default_rng(SEED)


def polar(v):
    return numpy.arctan2(numpy.hypot(v[0], v[1]), v[2])


def geometry(wi, wo):
    wi, wo = (v.astype(real) / numpy.sqrt((v.astype(real)**2).sum()) for v in (wi, wo))
    h = wi + wo
    h = h / numpy.sqrt(h @ h)
    return polar(wi), polar(wo), polar(h), numpy.arccos(min(real(1), wi @ h))


def fresnel(eta, k, theta):
    """Reflectance of a conductor from the complex amplitudes of both polarisations."""
    n = numpy.clongdouble(complex(eta, k))
    cos_i = numpy.cos(theta)
    cos_t = numpy.sqrt(1 - (numpy.sin(theta) / n)**2)
    rs = (cos_i - n * cos_t) / (cos_i + n * cos_t)
    rp = (n * cos_i - cos_t) / (n * cos_i + cos_t)
    return (abs(rs)**2 + abs(rp)**2) / 2


def beckmann(theta, alpha):
    return numpy.exp(-(numpy.tan(theta) / alpha)**2) / (pi * alpha**2 * numpy.cos(theta)**4)


def beckmann_g1(theta, alpha):
    """Equation 27 and the approximation below it."""
    a = 1 / (alpha * numpy.tan(theta))
    return (real("3.535") * a + real("2.181") * a**2) / (1 + real("2.276") * a + real("2.577") * a**2) if a < real("1.6") else real(1)


def ggx(theta, alpha):
    return alpha**2 / (pi * numpy.cos(theta)**4 * (alpha**2 + numpy.tan(theta)**2)**2)


def ggx_lambda(theta, alpha):
    return (numpy.sqrt(1 + (alpha * numpy.tan(theta))**2) - 1) / 2


def lobe(wi, wo, ax, ay, distribution, correlated):
    """D G with two widths, from vectors: Walter et al. 2007 and Heitz 2014."""
    wi, wo = (v.astype(real) / numpy.sqrt(v.astype(real) @ v) for v in (wi, wo))
    h = wi + wo
    slopes = (h[0] / h[2] / ax)**2 + (h[1] / h[2] / ay)**2
    cos_h = h[2] / numpy.sqrt(h @ h)
    d = (1 / (1 + slopes)**2 if distribution else numpy.exp(-slopes)) / (pi * ax * ay * cos_h**4)
    tans = [numpy.sqrt((ax * w[0])**2 + (ay * w[1])**2) / w[2] for w in (wi, wo)]  # alpha tan
    if distribution:
        lambdas = [(numpy.sqrt(1 + t**2) - 1) / 2 for t in tans]
        return d / (1 + sum(lambdas)) if correlated else d / (1 + lambdas[0]) / (1 + lambdas[1])
    for t in tans:
        d = d * beckmann_g1(numpy.arctan(t), real(1))
    return d


def anisotropic(wi, wo, ax, ay, distribution, correlated, eta, k, specular):
    ti, to, th, td = geometry(wi, wo)
    dg = lobe(wi, wo, real(ax), real(ay), distribution, correlated)
    return [s * dg * fresnel(e, q, td) / (4 * numpy.cos(ti) * numpy.cos(to)) for e, q, s in zip(eta, k, specular)]


def mitsuba(wi, wo, alpha, distribution, eta, k, specular):
    ti, to, th, td = geometry(wi, wo)
    alpha = real(alpha)
    if distribution:
        dg = ggx(th, alpha) / (1 + ggx_lambda(ti, alpha)) / (1 + ggx_lambda(to, alpha))
    else:
        dg = beckmann(th, alpha) * beckmann_g1(ti, alpha) * beckmann_g1(to, alpha)
    return [s * dg * fresnel(e, q, td) / (4 * numpy.cos(ti) * numpy.cos(to)) for e, q, s in zip(eta, k, specular)]


def pbrt(wi, wo, roughness, eta, k):
    ti, to, th, td = geometry(wi, wo)
    alpha = numpy.sqrt(real(roughness))
    dg = ggx(th, alpha) / (1 + ggx_lambda(ti, alpha) + ggx_lambda(to, alpha))
    return [dg * fresnel(e, q, td) / (4 * numpy.cos(ti) * numpy.cos(to)) for e, q in zip(eta, k)]


def pairs(alpha, n):
    """Half the pairs are anywhere, half near the mirror direction, where narrow lobes are."""
    for i in range(n):
        wi = rng.normal(size=3)
        wi[2] = abs(wi[2]) + 1e-3
        wi /= numpy.linalg.norm(wi)
        wo = rng.normal(size=3) if i % 2 else wi * [-1, -1, 1] + alpha * rng.normal(size=3) / 2
        wo[2] = abs(wo[2]) + 1e-3
        yield wi, wo / numpy.linalg.norm(wo)


def rgb(v):
    return ",".join(repr(float(x)) for x in v)


rows = []
for case in range(48):
    alpha = float(10**rng.uniform(-2.5, 0))
    eta, k, specular = rng.uniform(0.05, 4, 3), rng.uniform(0.5, 7, 3), rng.uniform(0.1, 1, 3)
    if case < 16:
        distribution = case % 2
        spec = f"rough-conductor:alpha={alpha!r};distribution={distribution};eta={rgb(eta)};k={rgb(k)};specular_reflectance={rgb(specular)}"
        values = lambda wi, wo: mitsuba(wi, wo, alpha, distribution, eta, k, specular)
    elif case < 24:
        spec = f"pbrt-conductor:roughness={alpha!r};eta={rgb(eta)};k={rgb(k)}"
        values = lambda wi, wo: pbrt(wi, wo, alpha, eta, k)
    else:
        x, y = sorted((alpha, float(alpha * rng.uniform(0.1, 1))), reverse=case % 2 == 0)
        x, y = max(x, 0.002), max(y, 0.002)
        if case % 3 < 2:
            spec = f"rough-conductor:alpha={x!r},{y!r};distribution={case % 3};eta={rgb(eta)};k={rgb(k)};specular_reflectance={rgb(specular)}"
            values = lambda wi, wo: anisotropic(wi, wo, x, y, case % 3, False, eta, k, specular)
        else:
            spec = f"pbrt-conductor:roughness={x!r},{y!r};eta={rgb(eta)};k={rgb(k)}"
            values = lambda wi, wo: anisotropic(wi, wo, numpy.sqrt(real(x)), numpy.sqrt(real(y)), 1, True, eta, k, numpy.ones(3))
    for wi, wo in pairs(alpha, 8):
        rows.append([spec, *map(repr, map(float, wi)), *map(repr, map(float, wo)), *(f"{float(v):.17g}" for v in values(wi, wo))])

with open(pathlib.Path(__file__).with_suffix(".csv"), "w", newline="") as f:
    f.write(f"# shading_conductor.py, NumPy {numpy.__version__}, seed {SEED}\n")
    out = csv.writer(f, lineterminator="\n")
    out.writerow("spec wix wiy wiz wox woy woz r g b".split())
    out.writerows(rows)
