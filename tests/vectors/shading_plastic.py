# SPDX-License-Identifier: MIT
"""Mitsuba 3's roughplastic from its documentation and source: the integrals that Mitsuba tabulates are means over the visible
normals, here by the midpoint rule over slopes, without cmake/rough_plastic.py. shading_plastic.csv: spec, wi, wo, r, g, b."""
import csv
import pathlib

import numpy

SEED = 16
rng = numpy.random.default_rng(SEED)
pi = numpy.pi


def fresnel(c, n1, n2):
    """From the angles of Snell's law; 1 at total reflection."""
    sine = numpy.sqrt(1 - c * c) * n1 / n2
    t = numpy.sqrt(numpy.maximum(0, 1 - sine**2))
    rs, rp = (n1 * c - n2 * t) / (n1 * c + n2 * t), (n1 * t - n2 * c) / (n1 * t + n2 * c)
    return numpy.where(sine < 1, (rs**2 + rp**2) / 2, 1)


def slopes_density(tan_m, alpha, ggx):
    """D(m) cos(theta_m)^4."""
    q = (tan_m / alpha)**2
    return (1 / (1 + q)**2 if ggx else numpy.exp(-q)) / (pi * alpha**2)


def g1(cosine, alpha, ggx):
    tan = numpy.sqrt(1 - cosine**2) / numpy.maximum(cosine, 1e-30)
    if ggx:
        return 2 / (1 + numpy.sqrt(1 + (alpha * tan)**2))
    a = 1 / numpy.maximum(alpha * tan, 1e-30)
    return numpy.where(a < 1.6, (3.535 * a + 2.181 * a * a) / (1 + 2.276 * a + 2.577 * a * a), 1)


class Interface:
    def __init__(self, alpha, eta, ggx, n_x, n_phi):
        self.alpha, self.eta, self.ggx = alpha, eta, ggx
        x = (numpy.arange(n_x) + 0.5) / n_x * pi / 2
        self.phi = (numpy.arange(n_phi) + 0.5) / n_phi * pi
        tan_m = alpha * numpy.tan(x)
        # The slope measure: D cos dm = P22 tan dtan dphi; visible normals have the density D (wi . m).
        self.cos_m = 1 / numpy.sqrt(1 + tan_m**2)
        self.w = slopes_density(tan_m, alpha, ggx) * tan_m * alpha / numpy.cos(x)**2 / self.cos_m
        self.sin_m = tan_m * self.cos_m
        self.cache = {}

    def mean(self, mu, value):
        c = mu * self.cos_m[:, None] + numpy.sqrt(1 - mu**2) * self.sin_m[:, None] * numpy.cos(self.phi)
        w = self.w[:, None] * numpy.maximum(0, c)
        return (w * value(numpy.clip(c, 1e-9, 1), self.cos_m[:, None])).sum() / w.sum()

    def transmitted(self, mu):
        def value(c, cos_m):
            t = numpy.sqrt(1 - (1 - c * c) / self.eta**2)
            below = mu / self.eta + (t - c / self.eta) * cos_m
            return (1 - fresnel(c, 1, self.eta)) * g1(numpy.minimum(below, 1), self.alpha, self.ggx)
        return self.mean(mu, value)

    def reflected_inside(self, mu):
        def value(c, cos_m):
            z = 2 * c * cos_m - mu
            return numpy.where(z > 0, fresnel(c, self.eta, 1) * g1(numpy.clip(z, 0, 1), self.alpha, self.ggx), 0)
        return self.mean(mu, value)

    def node(self, i):
        if i not in self.cache:
            self.cache[i] = self.transmitted(max(1e-6, i / 63))
        return self.cache[i]

    def t(self, cosine):
        i = min(int(cosine * 63), 62)
        return self.node(i) + (self.node(i + 1) - self.node(i)) * (cosine * 63 - i)

    def r(self):
        """Mitsuba: 2 mean(mu E) over the 64 cosines; here of many more, by the trapezoidal rule, with the same ends."""
        mu = numpy.maximum(1e-6, numpy.arange(64 * 8 - 7) / (63 * 8))
        f = numpy.array([self.reflected_inside(m) * m for m in mu])
        return 2 * (63 * numpy.trapz(f, mu) + (f[0] + f[-1]) / 2) / 64


rows = []
for case in range(8):
    alpha, eta, ggx, nonlinear = (0.05, 0.17, 0.4, 0.8)[case // 2], float(rng.uniform(1.2, 2.2)), case % 2, case // 2 % 2
    diffuse, specular = rng.uniform(size=3), rng.uniform(size=3)
    interface = Interface(alpha, eta, ggx, 1000, 400)
    r = Interface(alpha, eta, ggx, 400, 150).r()
    base = diffuse / (1 - (diffuse * r if nonlinear else r)) / (pi * eta**2)
    rgb = lambda v: ",".join(repr(float(e)) for e in v)
    spec = f"rough-plastic:alpha={alpha!r};distribution={ggx};eta={eta!r};diffuse_reflectance={rgb(diffuse)};specular_reflectance={rgb(specular)};nonlinear={nonlinear}"
    for i in range(16):
        wi = rng.normal(size=3)
        wo = rng.normal(size=3) if i % 2 else wi * [-1, -1, 1] + alpha * rng.normal(size=3) / 2
        wi[2], wo[2] = abs(wi[2]) + 0.02, abs(wo[2]) + 0.02
        wi, wo = wi / numpy.linalg.norm(wi), wo / numpy.linalg.norm(wo)
        h = (wi + wo) / numpy.linalg.norm(wi + wo)
        tan_h = numpy.hypot(h[0], h[1]) / h[2]
        lobe = slopes_density(tan_h, alpha, ggx) / h[2]**4 * g1(wi[2], alpha, ggx) * g1(wo[2], alpha, ggx) / (4 * wi[2] * wo[2])
        f = specular * lobe * fresnel(wi @ h, 1, eta) + base * interface.t(wi[2]) * interface.t(wo[2])
        rows.append([spec, *map(repr, map(float, wi)), *map(repr, map(float, wo)), *(f"{v:.12g}" for v in f)])

with open(pathlib.Path(__file__).with_suffix(".csv"), "w", newline="") as f:
    f.write(f"# shading_plastic.py, NumPy {numpy.__version__}, seed {SEED}\n")
    out = csv.writer(f, lineterminator="\n")
    out.writerow("spec wix wiy wiz wox woy woz r g b".split())
    out.writerows(rows)
