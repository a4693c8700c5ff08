# SPDX-License-Identifier: MIT
"""The material of glTF 2.0 from its specification: Appendix B (as of December 2025, with height-correlated shadowing),
KHR_materials_specular, _ior, _anisotropy, _iridescence, _sheen and _clearcoat, in 80-bit floats from angles. The albedo of the sheen is that of
presets/sheen_albedo.txt (made by sheen_albedo.py), interpolated here by Lagrange's and Hermite's formulas.
shading_gltf.csv: spec, wi, wo, r, g, b."""
import csv
import pathlib

import numpy

SEED = 14
HERE = pathlib.Path(__file__).parent
real = numpy.longdouble
pi = numpy.arctan2(real(0), real(-1))


def polar(v):
    return numpy.arctan2(numpy.hypot(v[0], v[1]), v[2])


def geometry(wi, wo):
    """Polar angles of light, viewer and half vector, and the angle between half vector and light."""
    wi, wo = (v.astype(real) / numpy.sqrt((v.astype(real)**2).sum()) for v in (wi, wo))
    h = wi + wo
    h = h / numpy.sqrt(h @ h)
    return polar(wi), polar(wo), polar(h), numpy.arccos(min(real(1), wi @ h))


def ggx(ti, to, th, roughness):
    """D G / (4 cos cos), Heitz 2014, from Lambda."""
    alpha = max(real(roughness)**2, real("1e-4"))
    d = alpha**2 / (pi * numpy.cos(th)**4 * (alpha**2 + numpy.tan(th)**2)**2)
    shadowing = [(numpy.sqrt(1 + (alpha * numpy.tan(t))**2) - 1) / 2 for t in (ti, to)]
    return d / (1 + sum(shadowing)) / (4 * numpy.cos(ti) * numpy.cos(to))


def anisotropic_ggx(wi, wo, roughness, strength, rotation):
    """V D of KHR_materials_anisotropy, from vectors and without the clamp of V to 1."""
    wi, wo = (v.astype(real) / numpy.sqrt((v.astype(real)**2).sum()) for v in (wi, wo))
    h = (wi + wo) / numpy.sqrt((wi + wo) @ (wi + wo))
    n, t = numpy.array([0, 0, 1], real), numpy.array([numpy.cos(real(rotation)), numpy.sin(real(rotation)), 0])
    b = numpy.cross(n, t)
    ab = max(real(roughness)**2, real("1e-4"))
    at = ab * (1 - real(strength)**2) + real(strength)**2
    f = numpy.array([ab * (t @ h), at * (b @ h), at * ab * (n @ h)])
    d = at * ab * (at * ab / (f @ f))**2 / pi
    length = lambda v: numpy.sqrt((at * (t @ v))**2 + (ab * (b @ v))**2 + (n @ v)**2)
    return d * real("0.5") / ((n @ wi) * length(wo) + (n @ wo) * length(wi))


def schlick(f0, f90, cosine):
    return f0 + (f90 - f0) * (1 - cosine)**5


def sheen_lambda(theta, alpha):
    rows = [[21.5473, 25.3245], [3.82987, 3.32435], [0.19823, 0.16801], [-1.97760, -1.27393], [-4.32054, -4.85967]]
    t = (1 - alpha)**2
    a, b, c, d, e = (real(str(p)) * (1 - t) + real(str(q)) * t for p, q in rows)
    value = lambda x: a / (1 + b * x**c) + d * x + e
    x = numpy.cos(theta)
    return numpy.exp(value(x) if x < 0.5 else 2 * value(real(0.5)) - value(1 - x))


TABLE = numpy.array(numpy.loadtxt(HERE / "../../presets/sheen_albedo.txt", int, delimiter=","), real) / 10000
assert TABLE.shape == (32, 32)


def interpolate(samples, x):
    """Cubic Hermite, slopes by central differences; the ends are repeated."""
    i = min(int(x), 30)
    p = [samples[min(31, max(0, i + k))] for k in (-1, 0, 1, 2)]
    t = x - i
    return ((2 * t**3 - 3 * t**2 + 1) * p[1] + (t**3 - 2 * t**2 + t) * (p[2] - p[0]) / 2 + (3 * t**2 - 2 * t**3) * p[2] +
            (t**3 - t**2) * (p[3] - p[1]) / 2)


def sheen_albedo(theta, roughness):
    return min(1, max(0, interpolate(interpolate(TABLE, 31 * roughness), 31 * numpy.sqrt(numpy.cos(theta)))))


def eval_sensitivity(opd, shift):
    """RGB; opd in nm."""
    phase = 2 * pi * opd * real("1e-9")
    val, pos, var = (numpy.array(v.split(), real) for v in ("5.4856e-13 4.4201e-13 5.2481e-13",
                                                            "1.6810e+06 1.7953e+06 2.2084e+06",
                                                            "4.3278e+09 9.3046e+09 6.6121e+09"))
    xyz = val * numpy.sqrt(2 * pi * var) * numpy.cos(pos * phase + shift) * numpy.exp(-phase**2 * var)
    more = real("4.5282e+09")
    xyz[0] += (real("9.7470e-14") * numpy.sqrt(2 * pi * more) * numpy.cos(real("2.2399e+06") * phase + shift[0]) *
               numpy.exp(-more * phase**2))
    matrix = numpy.array(["3.2404542 -1.5371385 -0.4985314".split(), "-0.9692660 1.8760108 0.0415560".split(),
                          "0.0556434 -0.2040259 1.0572252".split()], real)
    return matrix @ (xyz / real("1.0685e-7"))


def iridescent_fresnel(n, thickness, f0, cos1):
    """Of KHR_materials_iridescence, with the sample viewer's clamp of f0."""
    cos2 = 1 - (1 - cos1**2) / n**2
    if cos2 < 0:
        return numpy.ones(3, real)
    cos2 = numpy.sqrt(cos2)
    root = numpy.sqrt(numpy.clip(f0, 0, real("0.9999")))
    base = (1 + root) / (1 - root)
    r12 = schlick(((n - 1) / (n + 1))**2, 1, cos1)
    r23 = schlick(((base - n) / (base + n))**2, 1, cos2)
    phi = pi - (pi if n < 1 else 0) + numpy.where(base < n, pi, 0)
    r123 = numpy.clip(r12 * r23, real("1e-5"), real("0.9999"))
    rs = (1 - r12)**2 * r23 / (1 - r123)
    total = r12 + rs
    for m in (1, 2):
        total = total + (rs - 1 + r12) * numpy.sqrt(r123)**m * 2 * eval_sensitivity(m * 2 * n * thickness * cos2, m * phi)
    return numpy.maximum(total, 0)


def gltf(wi, wo, m):
    ti, to, th, td = geometry(wi, wo)
    m = {k: numpy.array(v, real) for k, v in m.items()}
    ior = m["ior"]
    f0 = numpy.minimum(((ior - 1) / (ior + 1))**2 * m["specular_color"], 1) * m["specular"]
    f = schlick(f0, m["specular"], numpy.cos(td))
    lobe = ggx(ti, to, th, m["roughness"])
    if "anisotropy_strength" in m:
        lobe = anisotropic_ggx(wi, wo, m["roughness"], m["anisotropy_strength"], m["anisotropy_rotation"])
    metal = schlick(m["base_color"], 1, numpy.cos(td))
    if m.get("iridescence", 0) > 0:
        on = lambda base: iridescent_fresnel(m["iridescence_ior"], m["iridescence_thickness"], base, numpy.cos(td))
        f = f + m["iridescence"] * (on(f0) - f)
        metal = metal + m["iridescence"] * (on(m["base_color"]) - metal)
    dielectric = f * lobe + (1 - f.max()) * m["base_color"] / pi
    metal = metal * lobe
    material = (1 - m["metallic"]) * dielectric + m["metallic"] * metal
    if m["sheen_color"].max() > 0:
        r = max(m["sheen_roughness"], real("1e-3"))
        d = (2 + 1 / r**2) * numpy.sin(th)**(1 / r**2) / (2 * pi)
        v = 1 / ((1 + sheen_lambda(ti, r**2) + sheen_lambda(to, r**2)) * 4 * numpy.cos(ti) * numpy.cos(to))
        scaling = min(1 - m["sheen_color"].max() * sheen_albedo(t, r) for t in (ti, to))
        material = m["sheen_color"] * d * v + material * scaling
    weight = m["clearcoat"] * schlick(real("0.04"), 1, numpy.cos(to))
    return (1 - weight) * material + weight * ggx(ti, to, th, m["clearcoat_roughness"])


def pairs(rng, alpha, n):
    """Half the pairs are anywhere, half near the mirror direction, where narrow lobes are."""
    for i in range(n):
        wi = rng.normal(size=3)
        wi[2] = abs(wi[2]) + 1e-3
        wi /= numpy.linalg.norm(wi)
        wo = rng.normal(size=3) if i % 2 else wi * [-1, -1, 1] + alpha * rng.normal(size=3) / 2
        wo[2] = abs(wo[2]) + 1e-3
        yield wi, wo / numpy.linalg.norm(wo)


def text(value):
    return ",".join(repr(float(x)) for x in numpy.atleast_1d(value))


def write_vectors(script, seed, model, function, materials, rng):
    """materials: (values of all keys, those given in the spec)."""
    rows = []
    for values, given in materials:
        spec = f"{model}:" + ";".join(f"{k}={text(values[k])}" for k in given)
        for wi, wo in pairs(rng, max(1e-3, values["roughness"]**2), 8):
            f = function(wi, wo, values)
            rows.append([spec, *map(repr, map(float, wi)), *map(repr, map(float, wo)), *(f"{float(v):.17g}" for v in f)])
    with open(pathlib.Path(script).with_suffix(".csv"), "w", newline="") as f:
        f.write(f"# {pathlib.Path(script).name}, NumPy {numpy.__version__}, seed {seed}\n")
        out = csv.writer(f, lineterminator="\n")
        out.writerow("spec wix wiy wiz wox woy woz r g b".split())
        out.writerows(rows)


DEFAULTS = {"base_color": [1, 1, 1], "metallic": 1, "roughness": 1, "ior": 1.5, "specular": 1, "specular_color": [1, 1, 1],
            "clearcoat": 0, "clearcoat_roughness": 0, "sheen_color": [0, 0, 0], "sheen_roughness": 0}


def materials(rng):
    yield dict(DEFAULTS), ["metallic"]
    yield dict(DEFAULTS, roughness=0), ["roughness"]
    yield dict(DEFAULTS, metallic=0, ior=0), ["metallic", "ior"]
    yield dict(DEFAULTS, metallic=0, sheen_color=[1, .5, .2]), ["metallic", "sheen_color"]
    yield dict(DEFAULTS, clearcoat=1, base_color=[.9, .1, .1]), ["clearcoat", "base_color"]
    for i in range(30):
        m = {k: rng.uniform(0.05, 1, 3) if isinstance(v, list) else float(rng.uniform(0.05, 1)) for k, v in DEFAULTS.items()}
        m["ior"] = float(rng.uniform(1, 3))
        m["specular_color"] = rng.uniform(0, 12 if i % 3 == 0 else 1, 3)
        if i % 4 == 0:
            m["metallic"] = 0
        if i % 5 < 2:
            m["sheen_color"] = [0, 0, 0]
        if i % 7 < 3:
            m["clearcoat"] = 0
        yield m, list(DEFAULTS)
    for i in range(20):
        m = dict(DEFAULTS, metallic=i % 2, base_color=rng.uniform(0.05, 1, 3), roughness=float(rng.uniform(0.1, 1)),
                 anisotropy_strength=float(rng.uniform(0, 1)), anisotropy_rotation=float(rng.uniform(0, 2 * numpy.pi)))
        if i % 5 == 0:
            m.update(clearcoat=0.7, clearcoat_roughness=0.2, sheen_color=[.2, .3, .4], sheen_roughness=0.5)
        yield m, list(m)
    for i in range(24):
        m = dict(DEFAULTS, metallic=(i % 3) / 2, base_color=rng.uniform(0.02, 1, 3), roughness=float(rng.uniform(0.1, 1)),
                 ior=float(rng.uniform(1, 2.5)), specular=float(rng.uniform(0, 1)), iridescence=float(rng.uniform(0, 1)),
                 iridescence_ior=float(rng.uniform(1, 2.5)), iridescence_thickness=float(rng.uniform(50, 1200)))
        if i % 4 == 0:
            m.update(base_color=[1, 1, 1], iridescence=1)
        yield m, list(m)


if __name__ == "__main__":
    generator = numpy.random.default_rng(SEED)
    write_vectors(__file__, SEED, "gltf", gltf, materials(generator), generator)
