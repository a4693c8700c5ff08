# SPDX-License-Identifier: MIT
"""The analytic BRDFs and presets from their published formulas, in 80-bit floats and in angles (the library uses
vectors), and BRDFs made of them by turning directions.
analytic.csv: spec, wi, wo, r, g, b. analytic_albedo.csv: directional albedos by adaptive quadrature: spec, theta_deg, albedo."""
import csv
import pathlib

import numpy
import scipy
from scipy import integrate

SEED = 11
real = numpy.longdouble
pi = numpy.arctan2(real(0), real(-1))
rng = numpy.random.default_rng(SEED)


def angles(wi, wo):
    """theta_h, theta_d, theta_i, theta_o of two float vectors, and the vectors with unit length."""
    wi, wo = wi.astype(real), wo.astype(real)
    wi, wo = wi / numpy.sqrt(wi @ wi), wo / numpy.sqrt(wo @ wo)
    h = wi + wo
    h = h / numpy.sqrt(h @ h)
    d = (wi - wo) / 2
    polar = lambda v: numpy.arctan2(numpy.hypot(v[0], v[1]), v[2])
    return polar(h), numpy.arctan2(numpy.sqrt(d @ d), (wi @ h)), polar(wi), polar(wo), wi, wo


def lambert(a, kd):
    return kd / pi


def ggx(a, kd, ks, alpha, f0):
    """Walter et al. 2007, equations 33 and 34; Schlick 1994; G as a product."""
    theta_h, theta_d, theta_i, theta_o, *_ = a
    d = alpha**2 / (pi * numpy.cos(theta_h)**4 * (alpha**2 + numpy.tan(theta_h)**2)**2)
    g1 = lambda t: 2 / (1 + numpy.sqrt(1 + alpha**2 * numpy.tan(t)**2))
    fresnel = f0 + (1 - f0) * (1 - numpy.cos(theta_d))**5
    return kd / pi + ks * d * g1(theta_i) * g1(theta_o) * fresnel / (4 * numpy.cos(theta_i) * numpy.cos(theta_o))


def ward(a, kd, ks, alpha):
    """Ward 1992, equation 5a with one alpha."""
    theta_h, _, theta_i, theta_o, *_ = a
    lobe = numpy.exp(-numpy.tan(theta_h)**2 / alpha**2) / (4 * pi * alpha**2)
    return kd / pi + ks * lobe / numpy.sqrt(numpy.cos(theta_i) * numpy.cos(theta_o))


def sgd(a, kd, ks, alpha, p, f0, f1, K, lam, c, k, theta0):
    """Bagher et al. 2012, section 3 and supplemental table."""
    theta_h, theta_d, theta_i, theta_o, *_ = a
    x = alpha + numpy.tan(theta_h)**2 / alpha
    d = K * numpy.exp(-x) / x**p / (pi * numpy.cos(theta_h)**4)
    fresnel = f0 - f1 * numpy.cos(theta_d) + (1 - f0) * (1 - numpy.cos(theta_d))**5

    def g1(theta):
        reach = numpy.maximum(theta - theta0, 0)
        with numpy.errstate(over="ignore"):
            return numpy.maximum(0, 1 + lam * (1 - numpy.exp(c * reach**k)))
    g = g1(theta_i) * g1(theta_o)
    return kd / pi + ks / pi * d * fresnel * g / (numpy.cos(theta_i) * numpy.cos(theta_o))


def ward_duer(a, kd, ks, alpha):
    """Ngan et al. 2005, supplement: Ward with cos theta_i cos theta_o instead of its square root."""
    theta_h, _, theta_i, theta_o, *_ = a
    lobe = numpy.exp(-numpy.tan(theta_h)**2 / alpha**2) / (4 * pi * alpha**2)
    return kd / pi + ks * lobe / (numpy.cos(theta_i) * numpy.cos(theta_o))


def blinn_phong(a, kd, ks, n):
    return kd / pi + ks * (n + 2) / (2 * pi) * numpy.cos(a[0])**n


def lafortune(a, kd, ks, cxy, cz, n):
    """Lafortune et al. 1997, equation 4, with the normalisation of Ngan et al. 2005."""
    wi, wo = a[4:]
    cosine = numpy.array([cxy, cxy, cz]) @ (wi * wo)
    return kd / pi + ks * (n + 2) / (2 * pi) * (numpy.maximum(cosine, 0) / max(abs(cxy), cz))**n


def schlick(f0, cosine):
    return f0 + (1 - f0) * (1 - cosine)**5


def dielectric(eta, theta):
    """Fresnel's equations with Snell's law."""
    inner = numpy.arcsin(numpy.sin(theta) / eta)
    s = (numpy.cos(theta) - eta * numpy.cos(inner)) / (numpy.cos(theta) + eta * numpy.cos(inner))
    p = (numpy.cos(inner) - eta * numpy.cos(theta)) / (numpy.cos(inner) + eta * numpy.cos(theta))
    return (s**2 + p**2) / 2


def grooves(a):
    """Cook and Torrance 1982, section 4."""
    theta_h, theta_d, theta_i, theta_o, *_ = a
    masks = [2 * numpy.cos(theta_h) * numpy.cos(theta) / numpy.cos(theta_d) for theta in (theta_i, theta_o)]
    return min(1, *masks) / (numpy.cos(theta_i) * numpy.cos(theta_o))


def cook_torrance(a, kd, ks, alpha, f0):
    d = numpy.exp(-numpy.tan(a[0])**2 / alpha**2) / (pi * alpha**2 * numpy.cos(a[0])**4)
    return kd / pi + ks / pi * d * grooves(a) * schlick(f0, numpy.cos(a[1]))


def low_cook_torrance(a, kd, ks, alpha, eta):
    d = numpy.exp(-numpy.tan(a[0])**2 / alpha**2) / (alpha**2 * numpy.cos(a[0])**4)
    return kd / pi + ks / pi * d * grooves(a) * dielectric(eta, a[1])


def phong_over_cosines(a, n):
    """Ashikhmin and Shirley 2000, equation 4 with one exponent."""
    theta_h, theta_d, theta_i, theta_o, *_ = a
    return (n + 1) / (8 * pi) * numpy.cos(theta_h)**n / (numpy.cos(theta_d) * numpy.cos(min(theta_i, theta_o)))


def ashikhmin_shirley(a, kd, ks, n, f0):
    return kd / pi + ks * phong_over_cosines(a, n) * schlick(f0, numpy.cos(a[1]))


def low_ashikhmin_shirley(a, kd, ks, n, eta):
    return kd / pi + ks * phong_over_cosines(a, n) * dielectric(eta, a[1])


def abc(a, kd, ks, b, c, eta):
    """Low et al. 2012, equations 15 and 16, divided by pi."""
    s = 1 / (1 + b * (1 - numpy.cos(a[0])))**c
    return kd / pi + ks / pi * s * grooves(a) * dielectric(eta, a[1])


def smooth(a, kd, ks, b, c, eta):
    """Low et al. 2012, equations 10, 12 and 14."""
    wi, wo = (v[:2] for v in a[4:])
    s = 1 / (1 + b * numpy.sum((wi + wo)**2))**c
    return kd / pi + ks * s * dielectric(eta, numpy.arcsin(numpy.sqrt(numpy.sum((wi - wo)**2)) / 2))


def at_azimuth(v, x, y):
    """x cos^2 + y sin^2 of the azimuth of a vector."""
    phi = numpy.arctan2(v[1], v[0])
    return x * numpy.cos(phi)**2 + y * numpy.sin(phi)**2


def ggx_xy(a, kd, ks, x, y, f0):
    """The same with two widths: Heitz 2014, equations 80 and 86 for G."""
    theta_h, theta_d, theta_i, theta_o, wi, wo = a
    stretched = numpy.tan(theta_h)**2 * at_azimuth(wi + wo, x**-2, y**-2)
    d = 1 / (pi * x * y * numpy.cos(theta_h)**4 * (1 + stretched)**2)
    g1 = lambda w, t: 1 / (1 + (numpy.sqrt(1 + at_azimuth(w, x**2, y**2) * numpy.tan(t)**2) - 1) / 2)
    fresnel = schlick(f0, numpy.cos(theta_d))
    return kd / pi + ks * d * g1(wi, theta_i) * g1(wo, theta_o) * fresnel / (4 * numpy.cos(theta_i) * numpy.cos(theta_o))


def ward_xy(a, kd, ks, x, y):
    """Ward 1992, equation 5a."""
    theta_h, _, theta_i, theta_o, wi, wo = a
    lobe = numpy.exp(-numpy.tan(theta_h)**2 * at_azimuth(wi + wo, x**-2, y**-2)) / (4 * pi * x * y)
    return kd / pi + ks * lobe / numpy.sqrt(numpy.cos(theta_i) * numpy.cos(theta_o))


def ward_duer_xy(a, kd, ks, x, y):
    return kd / pi + (ward_xy(a, 0, ks, x, y)) / numpy.sqrt(numpy.cos(a[2]) * numpy.cos(a[3]))


def ashikhmin_shirley_xy(a, kd, ks, nu, nv, f0):
    """Ashikhmin and Shirley 2000, equation 4."""
    theta_h, theta_d, theta_i, theta_o, wi, wo = a
    lobe = numpy.sqrt((nu + 1) * (nv + 1)) / (8 * pi) * numpy.cos(theta_h)**at_azimuth(wi + wo, nu, nv)
    return kd / pi + ks * lobe * schlick(f0, numpy.cos(theta_d)) / (numpy.cos(theta_d) * numpy.cos(min(theta_i, theta_o)))


def turned(axis, angle, v):
    """Rodrigues' rotation of v about a unit vector."""
    return v * numpy.cos(angle) + numpy.cross(axis, v) * numpy.sin(angle) + axis * (axis @ v) * (1 - numpy.cos(angle))


Z = numpy.array([0, 0, 1], dtype=real)


def rotate(a, deg, model, *parameters):
    return model(angles(*(turned(Z, -deg * pi / 180, w) for w in a[4:])), *parameters)


def tilt(a, deg, azimuth, model, *parameters):
    axis = turned(Z, azimuth * pi / 180, numpy.array([0, 1, 0], dtype=real))
    wi, wo = (turned(axis, -deg * pi / 180, w) for w in a[4:])
    return model(angles(wi, wo), *parameters) * wi[2] / a[4][2] if min(wi[2], wo[2]) > 0 else real(0)


def gloss(a, factor, model, *parameters):
    """The setting of doc/brdf.md: the half vector moves on its meridian, and the pair with it."""
    theta_h, theta_d, *_, wi, wo = a
    h = wi + wo
    phi_h = numpy.arctan2(h[1], h[0])
    axis = turned(Z, phi_h, numpy.array([0, 1, 0], dtype=real))
    in_frame = turned(Z, -phi_h, turned(axis, -theta_h, wi))  # of the half vector
    largest = numpy.arctan2(numpy.cos(theta_d), abs(in_frame[0]))
    u = theta_h / largest
    step = largest * factor * u / (1 + (factor - 1) * u) - theta_h
    return model(angles(*(turned(axis, step, w) for w in (wi, wo))), *parameters)


def presets(model):
    path = pathlib.Path("../../presets") / f"{model}.csv"
    rows = csv.reader(line for line in path.open() if not line.startswith("#"))
    next(rows)
    return {row[0]: [real(x) for x in row[1:]] for row in rows}


def rgb(*values):
    return numpy.array(values, dtype=real)


cases = [("lambert:kd=0.3,0.5,0.8", lambert, [rgb("0.3", "0.5", "0.8")]),
         ("ggx:kd=0.2,0.1,0.05;ks=0.04;alpha=0.1;f0=0.04", ggx, [rgb("0.2", "0.1", "0.05"), real("0.04"), real("0.1"), real("0.04")]),
         ("ggx:ks=1,0.8,0.6;alpha=0.003;f0=0.9,0.8,0.7", ggx,
          [real(0), rgb("1", "0.8", "0.6"), real("0.003"), rgb("0.9", "0.8", "0.7")]),
         ("ggx:alpha=0.8", ggx, [real(0), real(1), real("0.8"), real("0.04")]),
         ("ward:kd=0.1;ks=0.2,0.1,0.05;alpha=0.01", ward, [real("0.1"), rgb("0.2", "0.1", "0.05"), real("0.01")]),
         ("ward:ks=0.3;alpha=0.4", ward, [real(0), real("0.3"), real("0.4")])]
table = presets("sgd")
for name in ("nickel", "chrome", "alum-bronze", "beige-fabric", "red-specular-plastic", "specular-orange-phenolic", "white-fabric2",
             "two-layer-gold"):
    cases.append((f"sgd:{name}", sgd, [numpy.array(table[name][i:i + 3]) for i in range(0, 33, 3)]))
table = presets("ward")
for name in ("nickel", "orange-paint"):
    cases.append((f"ward:{name}", ward, [numpy.array(table[name][0:3]), numpy.array(table[name][3:6]), table[name][6]]))
lobes = {"ward-duer": ward_duer, "blinn-phong": blinn_phong, "lafortune": lafortune, "cook-torrance": cook_torrance,
         "ashikhmin-shirley": ashikhmin_shirley, "low-cook-torrance": low_cook_torrance, "low-cook-torrance-e1": low_cook_torrance,
         "low-ashikhmin-shirley": low_ashikhmin_shirley, "low-ashikhmin-shirley-e1": low_ashikhmin_shirley, "abc": abc,
         "smooth": smooth}
for model, formula in lobes.items():
    table = presets(model)
    for name in ("nickel", "orange-paint"):
        cases.append((f"{model}:{name}", formula, [numpy.array(table[name][0:3]), numpy.array(table[name][3:6]), *table[name][6:]]))
cases.append(("lafortune:ks=0.4,0.2,0.1;cz=0.8;n=30", lafortune, [real(0), rgb("0.4", "0.2", "0.1"), real(-1), real("0.8"), real(30)]))
cases.append(("lafortune:ks=1;cxy=-0.5;cz=1;n=2", lafortune, [real(0), real(1), real("-0.5"), real(1), real(2)]))
cases.append(("smooth:ks=100;B=3e4;C=1.7;eta=1", smooth, [real(0), real(100), real("3e4"), real("1.7"), real(1)]))
def grey(*values):
    return [real(v) for v in values]


anisotropic = {"ggx": (ggx_xy, "kd=0.1;ks=0.5;alpha={},{};f0=0.3"), "ward": (ward_xy, "kd=0.1;ks=0.5;alpha={},{}"),
               "ward-duer": (ward_duer_xy, "kd=0.1;ks=0.5;alpha={},{}")}
for x, y in (("0.001", "0.01"), ("0.03", "0.003"), ("0.1", "0.4"), ("1", "0.1"), ("0.25", "0.2")):
    for model, (formula, text) in anisotropic.items():
        cases.append((f"{model}:" + text.format(x, y), formula, grey("0.1", "0.5", x, y, *["0.3"] * (model == "ggx"))))
for nu, nv in ((100, 10000), (7, 3), (200000, 20000)):
    cases.append((f"ashikhmin-shirley:ks=0.5;n={nu},{nv};f0=0.3", ashikhmin_shirley_xy, grey(0, "0.5", nu, nv, "0.3")))
    cases.append((f"low-ashikhmin-shirley:ks=0.5;n={nu},{nv};eta=1.5",
                  lambda a, nu, nv: ashikhmin_shirley_xy(a, 0, real("0.5"), nu, nv, 1) * dielectric(real("1.5"), a[1]), grey(nu, nv)))
base, base_values = "ggx:kd=0.1;ks=0.5;alpha=0.1,0.4;f0=0.3", [ggx_xy, *grey("0.1", "0.5", "0.1", "0.4", "0.3")]
for deg in (30, -75, 200):
    cases.append((f"rotate:deg={deg};of={base}", rotate, [real(deg), *base_values]))
for deg, azimuth in ((5, 90), (20, -30), (60, 250), (10, 0)):
    cases.append((f"tilt:deg={deg};azimuth={azimuth};of={base}", tilt, [real(deg), real(azimuth), *base_values]))
cases.append(("tilt:deg=25;azimuth=100;of=ward:ks=0.3;alpha=0.4", tilt, [real(25), real(100), ward, *grey(0, "0.3", "0.4")]))
for factor in ("0.5", "2"):
    cases.append((f"perturb:gloss={factor};of={base}", gloss, [real(factor), *base_values]))
cases.append((f"perturb:gloss=2;of=rotate:deg=30;of={base}", gloss, [real(2), rotate, real(30), *base_values]))
cases.append((f"between:t=0.25;with=(rotate:deg=90;of={base});of={base}",
              lambda a, *p: real("0.75") * ggx_xy(a, *p) + real("0.25") * rotate(a, real(90), ggx_xy, *p), base_values[1:]))


def direction(theta, phi):
    return numpy.array([numpy.sin(theta) * numpy.cos(phi), numpy.sin(theta) * numpy.sin(phi), numpy.cos(theta)])


def draw_pair(kind):
    theta_i = numpy.radians(85) * rng.uniform()
    wi = direction(theta_i, rng.uniform(0, 2 * numpy.pi))
    if kind == 0:
        return wi, direction(numpy.radians(85) * rng.uniform(), rng.uniform(0, 2 * numpy.pi))
    while True:  # near the mirror direction
        h = direction(10 ** rng.uniform(-5, -0.5), rng.uniform(0, 2 * numpy.pi))
        wo = 2 * (wi @ h) * h - wi
        if wo[2] > 0.05:
            return wi, wo


note = f"# made by analytic.py: numpy {numpy.__version__}, {numpy.finfo(real).nmant + 1} bit floats, seed {SEED}\n"
with open("analytic.csv", "w") as out:
    out.write(note + "spec,wix,wiy,wiz,wox,woy,woz,r,g,b\n")
    for spec, model, parameters in cases:
        for i in range(12):
            wi, wo = draw_pair(i % 2)
            f = numpy.broadcast_to(model(angles(wi, wo), *parameters), 3)
            values = [*wi, *wo, *(float(x) for x in f)]
            out.write(f'"{spec}",' + ",".join(repr(float(x)) for x in values) + "\n")


def albedo(lobe, width, theta):
    """Integral of f_r cos(theta_o) over the viewer's hemisphere in half-vector coordinates: dwo = 4 cos(theta_d)
    dwh."""
    wi = direction(theta, 0)

    def integrand(log_tan, phi):
        tan_h = numpy.exp(log_tan)
        cos_h = 1 / numpy.sqrt(1 + tan_h**2)
        h = numpy.array([tan_h * cos_h * numpy.cos(phi), tan_h * cos_h * numpy.sin(phi), cos_h])
        cos_d = wi @ h
        wo = 2 * cos_d * h - wi
        if wo[2] <= 0 or cos_d <= 0:
            return 0.0
        a = numpy.arctan(tan_h), numpy.arccos(min(1.0, cos_d)), theta, numpy.arccos(min(1.0, wo[2])), wi, wo
        return float(lobe(a) * wo[2] * 4 * cos_d * tan_h**2 * cos_h**3)  # sin(theta_h) dtheta_h/dlog_tan
    bounds = numpy.log(width * 1e-4), numpy.log(1e4)
    return 2 * integrate.dblquad(integrand, 0, numpy.pi, *bounds, epsabs=1e-6, epsrel=1e-5)[0]


with open("analytic_albedo.csv", "w") as out:
    out.write(note.replace("numpy", f"scipy {scipy.__version__}, numpy", 1) + "spec,theta_deg,albedo\n")
    for alpha in (0.001, 0.05, 0.5):
        for theta in (0, 60):
            value = albedo(lambda a: ggx(a, 0, 1, alpha, 1), alpha, numpy.radians(theta))
            out.write(f'"ggx:f0=1;alpha={alpha}",{theta},{value:.7f}\n')
    for theta in (0, 60):
        value = albedo(lambda a: ward(a, 0.0, 0.5, 0.1), 0.1, numpy.radians(theta))
        out.write(f'"ward:ks=0.5;alpha=0.1",{theta},{value:.7f}\n')
    for x, y in ((0.001, 0.01), (0.5, 0.05)):
        for theta in (0, 60):
            value = albedo(lambda a: ggx_xy(a, 0, 1, x, y, 1), min(x, y), numpy.radians(theta))
            out.write(f'"ggx:f0=1;alpha={x},{y}",{theta},{value:.7f}\n')
    value = albedo(lambda a: ward_xy(a, 0.0, 1, 0.01, 0.1), 0.01, 0.0)
    out.write(f'"ward:ks=1;alpha=0.01,0.1",0,{value:.7f}\n')
