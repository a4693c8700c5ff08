# SPDX-License-Identifier: MIT
"""The surface shaders of MaterialX from their node graphs and the equations of MaterialX.PBRSpec.md, in 80-bit floats and in
angles (the library uses vectors). Directional albedos and compensation as in doc/materials.md.
shading_materialx.csv: spec, wi, wo, r, g, b."""
import csv
import pathlib

import numpy

SEED = 14
real = numpy.longdouble
pi = numpy.arctan2(real(0), real(-1))
rng = numpy.random.default_rng(SEED)
sin, cos, tan, sqrt, exp, maximum, minimum = (numpy.sin, numpy.cos, numpy.tan, numpy.sqrt, numpy.exp, numpy.maximum,
                                              numpy.minimum)
white = numpy.ones(3, real)


def one(v):
    return minimum(maximum(v, 0), 1)


def lerp(bg, fg, amount):
    return bg * (1 - amount) + fg * amount


class Pair:
    """Angles of a pair of directions."""

    def __init__(self, wi, wo):
        wi, wo = wi.astype(real), wo.astype(real)
        wi, wo = wi / sqrt(wi @ wi), wo / sqrt(wo @ wo)
        h = (wi + wo) / sqrt((wi + wo) @ (wi + wo))
        polar = lambda v: numpy.arctan2(numpy.hypot(v[0], v[1]), v[2])
        self.i, self.o, self.h = polar(wi), polar(wo), polar(h)
        self.half = h
        self.d = numpy.arctan2(sqrt((wi - wo) @ (wi - wo)) / 2, wi @ h)
        self.phi = numpy.arctan2(wi[1], wi[0]) - numpy.arctan2(wo[1], wo[0])
        self.dot = wi @ wo


# ---- nodes: each returns f_r and throughput -------------------------------------------------------------------------


class Roughness:
    """The inputs `roughness` (clamped) and `tangent` of a microfacet node."""

    def __init__(self, x, y, tangent):
        self.x, self.y = (minimum(maximum(v, real("1e-4")), 1) for v in (x, y))
        self.mean = sqrt(self.x * self.y)
        self.tangent = tangent


def alpha(roughness):
    return Roughness(roughness**2, roughness**2, numpy.array([1, 0, 0], real))


def roughness_anisotropy(roughness, anisotropy, turns=real(0)):
    """With the tangent by rotate3d, which is a row vector times Rodrigues' matrix."""
    axis, tangent = numpy.array([0, 0, 1], real), numpy.array([1, 0, 0], real)
    tangent = tangent * cos(2 * pi * turns) + numpy.cross(tangent, axis) * sin(2 * pi * turns)
    squared, aspect = minimum(maximum(roughness**2, real("1e-4")), 1), sqrt(1 - minimum(anisotropy, real("0.98")))
    return Roughness(minimum(squared / aspect, 1), squared * aspect, tangent)


def open_pbr_anisotropy(roughness, anisotropy):
    x = roughness**2 * sqrt(2 / (1 + (1 - anisotropy)**2))
    return Roughness(x, (1 - anisotropy) * x, numpy.array([1, 0, 0], real))


def ggx(p, roughness):
    """Microfacet BRDF without F, from the GGX distribution and the height-correlated Smith function."""
    hx, hy = p.half @ roughness.tangent, p.half @ numpy.cross(numpy.array([0, 0, 1], real), roughness.tangent)
    d = 1 / (pi * roughness.x * roughness.y * ((hx / roughness.x)**2 + (hy / roughness.y)**2 + cos(p.h)**2)**2)
    a = roughness.mean
    lam = lambda t: sqrt(a**2 + (1 - a**2) * cos(t)**2)
    g2 = 2 * cos(p.i) * cos(p.o) / (lam(p.o) * cos(p.i) + lam(p.i) * cos(p.o))
    return d * g2 / (4 * cos(p.i) * cos(p.o))


def ggx_albedo(p, a):
    """The rational fit of the GLSL generator: factors of F0 and F90."""
    x, y = cos(p.o), a.mean
    rows = [("0.1003", "0.9345", "1", "1"), ("-0.6303", "-2.323", "-1.765", "0.2281"), ("9.748", "2.229", "8.263", "15.94"),
            ("-2.038", "-3.748", "11.53", "-55.83"), ("29.34", "1.424", "28.96", "13.08"),
            ("-8.245", "-0.7684", "-7.507", "41.26"), ("-26.44", "1.436", "-36.11", "54.9"),
            ("19.99", "0.2913", "15.86", "300.2"), ("-5.448", "0.6286", "33.37", "-285.1")]
    powers = [1, x, y, x * y, x**2, y**2, x**2 * y, x * y**2, x**2 * y**2]
    a0, a1, b0, b1 = (sum(real(r[k]) * t for r, t in zip(rows, powers)) for k in range(4))
    return one(a0 / b0), one(a1 / b1)


def compensation(p, a, fresnel):
    e = sum(ggx_albedo(p, a))
    return 1 + fresnel * (1 - e) / e


# ---- thin films, from the complex amplitudes of both polarisations ---------------------------------------------------

CMF = [("5.4856e-13", "1.6810e6", "4.3278e9"), ("4.4201e-13", "1.7953e6", "9.3046e9"), ("5.2481e-13", "2.2084e6", "6.6121e9"),
       ("9.7470e-14", "2.2399e6", "4.5282e9")]


def sensitivity(path, shift):
    w = 2 * pi * path
    lobe = [real(v) * sqrt(2 * pi * real(s)) * cos(real(m) * w + shift[k % 3]) * exp(-real(s) * w**2)
            for k, (v, m, s) in enumerate(CMF)]
    return numpy.array([lobe[0] + lobe[3], lobe[1], lobe[2]]) / real("1.0685e-7")


def amplitudes(n1, n2, c1):
    """r_s, r_p and the cosine beyond; complex indices."""
    n1, n2, c1 = (numpy.asarray(x, numpy.clongdouble) for x in (n1, n2, c1))
    c2 = sqrt(1 - (n1 / n2)**2 * (1 - c1**2))
    return (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2), (n2 * c1 - n1 * c2) / (n2 * c1 + n1 * c2), c2


def airy(c, film, substrate):
    """substrate(cosine inside, index of the film): reflectances (3) and phases (3) of s and p."""
    thickness, n = film[0] * real("1e-9"), maximum(film[1], 1)
    rs, rp, inside = amplitudes(1, n, c)
    inside = inside.real
    total = numpy.zeros(3, real)
    for r12, (r23, phase) in zip((rs.real, rp.real), substrate(inside, n)):
        phase = phase + (0 if r12 < 0 else pi)  # r21 = -r12
        top, t = r12**2, 1 - r12**2
        rs_ = t**2 * r23 / (1 - top * r23)
        total += top + rs_
        for m in (1, 2):
            total += 2 * (rs_ - t) * sqrt(top * r23)**m * sensitivity(m * 2 * n * inside * thickness, m * phase)
    matrix = numpy.array([["2.3706743", "-0.9000405", "-0.4706338"], ["-0.5138850", "1.4253036", "0.0885814"],
                          ["0.0052982", "-0.0146949", "1.0093968"]]).astype(real)
    return one(matrix @ (total / 2))


def on_index(eta, kappa):
    def reflect(c, n):
        s, p, _ = amplitudes(n, eta + 1j * kappa, c)
        return [(abs(r)**2, numpy.angle(r)) for r in (s, p)]
    return reflect


def on_schlick(f0, f82, f90):
    def reflect(c, n):
        root = sqrt(minimum(maximum(f0, real("0.01")), real("0.99")))
        f = one(schlick_factor(f0, f82, f90, c))
        # the specification counts phases from another origin: s of film to air is pi there, and 0 in amplitudes
        phase = numpy.where((1 + root) / (1 - root) < n, pi, 0)
        return [(f, phase + pi), (f, phase)]
    return reflect


def dielectric(p, weight, tint, ior, a, film=None):
    c = cos(p.d)
    if film:
        f = airy(c, film, on_index(ior * white, 0 * white))
    elif ior**2 + c**2 < 1:
        f = real(1)
    else:
        g = sqrt(ior**2 + c**2 - 1)
        f = (g - c)**2 / (g + c)**2 * (1 + (c * (g + c) - 1)**2 / (c * (g - c) + 1)**2) / 2
    k0, k90 = ggx_albedo(p, a)
    comp = compensation(p, a, f)
    f0 = ((ior - 1) / (ior + 1))**2
    return weight * ggx(p, a) * f * comp * tint, (1 - weight * (k0 * f0 + k90) * comp) * white


def schlick_factor(color0, color82, color90, c):
    ct = 1 / real(7)
    dip = (color0 + (color90 - color0) * (1 - ct)**5) * (1 - color82) / (ct * (1 - ct)**6)
    return color0 + (color90 - color0) * (1 - c)**5 - dip * c * (1 - c)**6


def schlick(p, weight, color0, color82, a, color90=white, film=None):
    f = maximum(schlick_factor(color0, color82, color90, cos(p.d)), 0)
    if film:
        f = airy(cos(p.d), film, on_schlick(color0, color82, color90))
    k0, k90 = ggx_albedo(p, a)
    comp = compensation(p, a, f)
    return weight * ggx(p, a) * f * comp, (1 - weight * numpy.mean((k0 * color0 + k90 * color90) * comp)) * white


def conductor(p, eta, kappa, a, film=None):
    s2, c = sin(p.d)**2, cos(p.d)
    ab = sqrt((eta**2 - kappa**2 - s2)**2 + 4 * eta**2 * kappa**2)
    q = sqrt(maximum(0, (ab + eta**2 - kappa**2 - s2) / 2))
    rs = (ab - 2 * q * c + c**2) / (ab + 2 * q * c + c**2)
    rp = rs * (c**2 * ab - 2 * q * c * s2 + s2**2) / (c**2 * ab + 2 * q * c * s2 + s2**2)
    f = airy(c, film, on_index(eta, kappa)) if film else (rs + rp) / 2
    return ggx(p, a) * f * compensation(p, a, f), 0 * white


def artistic_ior(reflectivity, edge):
    r, g = minimum(maximum(reflectivity, 0), real("0.99")), one(edge)
    n = g * (1 - r) / (1 + r) + (1 - g) * (1 + sqrt(r)) / (1 - sqrt(r))
    return n, sqrt(maximum(0, ((n + 1)**2 * r - (n - 1)**2) / (1 - r)))


def oren_nayar(p, weight, color, sigma):
    s2 = sigma**2
    a, b = 1 - s2 / (s2 + real("0.33")) / 2, real("0.45") * s2 / (s2 + real("0.09"))
    g = maximum(0, cos(p.phi)) * sin(maximum(p.i, p.o)) * tan(minimum(p.i, p.o))
    return weight * color / pi * (a + b * g), 0 * white


def eon(p, weight, color, sigma):
    c1, c2 = 1 / real(2) - 2 / (3 * pi), 2 / real(3) - 28 / (15 * pi)
    a = 1 / (1 + c1 * sigma)
    s = p.dot - cos(p.i) * cos(p.o)
    st = s / maximum(cos(p.i), cos(p.o)) if s > 0 else s
    single = color / pi * a * (1 + sigma * st)
    if sigma == 0:
        return weight * single, 0 * white

    def e(t):
        g = sin(t) * (t - sin(t) * cos(t)) + 2 * (sin(t) * (1 - sin(t)**3) / cos(t) - sin(t)) / 3
        return a + sigma * a / pi * g
    mean = (1 + c2 * sigma) / (1 + c1 * sigma)
    many = color**2 * mean / (1 - color * (1 - mean))
    return weight * (single + many / pi * (1 - e(p.o)) * (1 - e(p.i)) / (1 - mean)), 0 * white


def burley(p, weight, color, sigma):
    f90 = real("0.5") + 2 * sigma * cos(p.d)**2
    f = lambda t: 1 + (f90 - 1) * (1 - cos(t))**5
    return weight * color / pi * f(p.i) * f(p.o), 0 * white


def conty_kulla(p, weight, color, r):
    inverse = 1 / maximum(r, real("0.005"))
    d = (2 + inverse) * (1 - cos(p.h)**2)**(inverse / 2) / (2 * pi)
    f = color * d / (4 * (cos(p.i) + cos(p.o) - cos(p.i) * cos(p.o)))
    x = cos(p.o)
    fit = lambda *k: sum(real(c) * t for c, t in zip(k, (1, x, r, x * r, x * x, r * r)))
    albedo = one(fit("13.67300", "-68.78018", "799.08825", "-905.00061", "60.28956", "1086.96473") /
                 fit("1", "61.57746", "442.78211", "2597.49308", "121.81241", "3045.55075"))
    return weight * f, (1 - weight * albedo) * white


def zeltner(p, weight, color, r):
    x, y = cos(p.o), minimum(maximum(r, real("0.01")), 1)
    k = real
    s = y * (k("0.0206607") + k("1.58491") * y) / (k("0.0379424") + y * (k("1.32227") + y))
    m = y * (k("-0.193854") + y * (k("-1.14885") + y * (k("1.7932") - k("0.95943") * y**2))) / (k("0.046391") + y)
    o = y * (k("0.000654023") + (k("-0.0207818") + k("0.119681") * y) * y) / (k("1.26264") + y * (k("-1.92021") + y))
    albedo = exp(-((x - m) / s)**2 / 2) / (s * sqrt(2 * pi)) + o
    a = (k("2.58126") * x + k("0.813703") * y) * y / (1 + k("0.310327") * x**2 + k("2.60994") * x * y)
    b = sqrt(1 - x) * (y - 1) * y**3 / (k("0.0000254053") + k("1.71228") * x - k("1.71506") * x * y + k("1.34174") * y**2)
    return transformed_sheen(p, weight, color, albedo, a, b)


def transformed_sheen(p, weight, color, albedo, a, b):
    w = numpy.array([sin(p.i) * cos(p.phi), sin(p.i) * sin(p.phi), cos(p.i)])
    w = numpy.array([[a, 0, b], [0, a, 0], [0, 0, 1]]) @ w
    norm = sqrt(w @ w)
    f = color * albedo * (w[2] / norm / pi) * a**2 / norm**3 / cos(p.i)
    return weight * f, (1 - weight * albedo) * white


def layer(top, base):
    return top[0] + top[1] * base[0], top[1] * base[1]


def mix(bg, fg, amount):
    return lerp(bg[0], fg[0], amount), lerp(bg[1], fg[1], amount)


def times(node, color):
    return node[0] * one(color), node[1] * one(color)


# ---- surfaces -------------------------------------------------------------------------------------------------------


def open_pbr(p, v):
    widened = minimum(1, 2 * v.coat_roughness**4 + v.specular_roughness**4)**(1 / real(4))
    rough = open_pbr_anisotropy(lerp(v.specular_roughness, widened, v.coat_weight), v.specular_roughness_anisotropy)
    ratio = v.specular_ior / v.coat_ior
    eta = lerp(v.specular_ior, ratio if ratio > 1 else 1 / ratio, v.coat_weight)
    e = numpy.sign(eta - 1) * sqrt(minimum(v.specular_weight * ((eta - 1) / (eta + 1))**2, real("0.99999")))
    diffuse = eon(p, v.base_weight, v.base_color, v.base_diffuse_roughness)
    film = (v.thin_film_thickness * 1000, v.thin_film_ior)
    top = dielectric(p, 1, v.specular_color, (1 + e) / (1 - e), rough)
    metal = schlick(p, v.specular_weight, v.base_color * v.base_weight, v.specular_color, rough)
    if v.thin_film_weight > 0:
        top = mix(top, dielectric(p, 1, v.specular_color, (1 + e) / (1 - e), rough, film), v.thin_film_weight)
        metal = mix(metal, schlick(p, v.specular_weight, v.base_color * v.base_weight, v.specular_color, rough, film=film),
                    v.thin_film_weight)
    base = layer(top, diffuse)
    base = mix(base, metal, v.base_metalness)
    f0 = ((v.coat_ior - 1) / (v.coat_ior + 1))**2
    k = 1 - (1 - f0) / v.coat_ior**2
    e_base = lerp(v.base_color, v.base_color * v.specular_weight, v.base_metalness)
    base = times(base, lerp(white, (1 - k) / (1 - e_base * k), v.coat_weight * v.coat_darkening))
    base = times(base, lerp(white, v.coat_color, v.coat_weight))
    coat = open_pbr_anisotropy(v.coat_roughness, v.coat_roughness_anisotropy)
    base = layer(dielectric(p, v.coat_weight, white, v.coat_ior, coat), base)
    return layer(zeltner(p, v.fuzz_weight, v.fuzz_color, v.fuzz_roughness), base)[0]


def standard_surface(p, v):
    rough = roughness_anisotropy(lerp(v.specular_roughness, 1, v.coat_affect_roughness * v.coat * v.coat_roughness),
                                 v.specular_anisotropy, v.specular_rotation)
    diffuse = oren_nayar(p, v.base, v.base_color**(1 + v.coat * v.coat_affect_color), v.diffuse_roughness)
    base = layer(conty_kulla(p, v.sheen, v.sheen_color, v.sheen_roughness), diffuse)
    film = (v.thin_film_thickness, v.thin_film_IOR) if v.thin_film_thickness > 0 else None
    base = layer(dielectric(p, v.specular, v.specular_color, v.specular_IOR, rough, film), base)
    eta, kappa = artistic_ior(v.base_color * v.base, v.specular_color * v.specular)
    base = times(mix(base, conductor(p, eta, kappa, rough, film), v.metalness), lerp(white, v.coat_color, v.coat))
    coat = roughness_anisotropy(v.coat_roughness, v.coat_anisotropy, v.coat_rotation)
    return layer(dielectric(p, v.coat, white, v.coat_IOR, coat), base)[0]


def disney(p, v):
    base = layer(conty_kulla(p, v.sheen, lerp(white, v.baseColor, v.sheenTint), real("0.3")),
                 burley(p, 1 - v.metallic, v.baseColor, v.roughness))
    tint = lerp(white, v.baseColor, v.specularTint)
    rough = roughness_anisotropy(v.roughness, v.anisotropic)
    base = layer(schlick(p, v.specular * real("0.08"), tint, white, rough), base)
    base = mix(base, schlick(p, 1, v.baseColor, white, rough), v.metallic)
    return layer(schlick(p, v.clearcoat * real("0.04"), white, white, alpha(1 - v.clearcoatGloss)), base)[0]


def usd_preview(p, v):
    diffuse = oren_nayar(p, lerp(1 - v.metallic, 1, v.useSpecularWorkflow), v.diffuseColor, real(0))
    specular_workflow = layer(schlick(p, 1, v.specularColor, white, alpha(v.roughness)), diffuse)
    r2 = ((1 - v.ior) / (1 + v.ior))**2
    color = lerp(white, v.diffuseColor, v.metallic)
    plastic = layer(schlick(p, 1, lerp(color * r2, color, v.metallic), white, alpha(v.roughness), color), diffuse)
    eta, kappa = artistic_ior(v.diffuseColor, v.diffuseColor)
    metalness_workflow = mix(plastic, conductor(p, eta, kappa, alpha(v.roughness)), v.metallic)
    base = mix(metalness_workflow, specular_workflow, v.useSpecularWorkflow)
    return layer(schlick(p, v.clearcoat, r2 * white, white, alpha(v.clearcoatRoughness)), base)[0]


# name: (values, the usual interval, chance of being drawn instead of one of the ends); the others keep the defaults
KEYS = {
    "open-pbr": (open_pbr, {
        "base_weight": (1, 0, 1), "base_color": (3, 0, 1), "base_diffuse_roughness": (1, 0, 1), "base_metalness": (1, 0, 1),
        "specular_weight": (1, 0, 1), "specular_color": (3, 0, 1), "specular_roughness": (1, 0, 1), "specular_ior": (1, 1, 3),
        "fuzz_weight": (1, 0, 1), "fuzz_color": (3, 0, 1), "fuzz_roughness": (1, 0, 1), "coat_weight": (1, 0, 1),
        "coat_color": (3, 0, 1), "coat_roughness": (1, 0, 1), "coat_ior": (1, 1, 3), "coat_darkening": (1, 0, 1)}),
    "standard-surface": (standard_surface, {
        "base": (1, 0, 1), "base_color": (3, 0, 1), "diffuse_roughness": (1, 0, 1), "metalness": (1, 0, 1),
        "specular": (1, 0, 1), "specular_color": (3, 0, 1), "specular_roughness": (1, 0, 1), "specular_IOR": (1, 0.5, 3),
        "sheen": (1, 0, 1), "sheen_color": (3, 0, 1), "sheen_roughness": (1, 0, 1), "coat": (1, 0, 1), "coat_color": (3, 0, 1),
        "coat_roughness": (1, 0, 1), "coat_IOR": (1, 0.5, 3), "coat_affect_color": (1, 0, 1),
        "coat_affect_roughness": (1, 0, 1)}),
    "disney": (disney, {
        "baseColor": (3, 0, 1), "metallic": (1, 0, 1), "roughness": (1, 0, 1), "specular": (1, 0, 1),
        "specularTint": (1, 0, 1), "sheen": (1, 0, 1), "sheenTint": (1, 0, 1), "clearcoat": (1, 0, 1),
        "clearcoatGloss": (1, 0, 1)}),
    "usd-preview": (usd_preview, {
        "diffuseColor": (3, 0, 1), "useSpecularWorkflow": (1, 0, 1), "specularColor": (3, 0, 1), "metallic": (1, 0, 1),
        "roughness": (1, 0, 1), "clearcoat": (1, 0, 1), "clearcoatRoughness": (1, 0, 1), "ior": (1, 0, 3)}),
}


ANISOTROPY = {
    "open-pbr": {"specular_roughness_anisotropy": (1, 0, 1), "coat_roughness_anisotropy": (1, 0, 1)},
    "standard-surface": {"specular_anisotropy": (1, 0, 1), "specular_rotation": (1, 0, 1), "coat_anisotropy": (1, 0, 1),
                         "coat_rotation": (1, 0, 1)},
    "disney": {"anisotropic": (1, 0, 1)},
}


FILM = {
    "open-pbr": {"thin_film_weight": (1, 0, 1), "thin_film_thickness": (1, 0.05, 1), "thin_film_ior": (1, 1, 2.5)},
    "standard-surface": {"thin_film_thickness": (1, 50, 1200), "thin_film_IOR": (1, 1, 2.5)},
}


class Values:
    pass


def draw(keys):
    values, text = Values(), []
    for extra in (*ANISOTROPY.values(), *FILM.values()):
        for name in extra:
            setattr(values, name, real(0))
    for name, (n, low, high) in keys.items():
        v = numpy.round(rng.uniform(low, high, n), 3)
        if rng.uniform() < 0.25:
            v = numpy.full(n, rng.choice([low, high]))
        if name.startswith("use"):
            v = numpy.round(v)
        setattr(values, name, v.astype(real) if n == 3 else real(v[0]))
        text.append(name + "=" + ",".join(repr(float(x)) for x in v))
    return values, ";".join(text)


def direction():
    z = rng.uniform(0.05, 1)
    phi = rng.uniform(0, 2 * numpy.pi)
    r = numpy.sqrt(1 - z * z)
    return numpy.array([r * numpy.cos(phi), r * numpy.sin(phi), z])


def near_mirror(wo):
    """A direction whose half vector is near the normal."""
    w = numpy.array([-wo[0], -wo[1], wo[2]]) + 0.1 * rng.normal(size=3)
    w[2] = abs(w[2]) + 0.02
    return w / numpy.linalg.norm(w)


def write_rows(out, model, function, keys, n=60):
    for _ in range(n):
        values, text = draw(keys)
        for k in range(2):
            wo = direction()
            wi = near_mirror(wo) if k else direction()
            f = function(Pair(wi, wo), values)
            out.writerow([model + ":" + text, *map(float, wi), *map(float, wo), *map(float, f)])


def main():
    path = pathlib.Path(__file__).with_suffix(".csv")
    with open(path, "w", newline="") as file:
        file.write(f"# made by {pathlib.Path(__file__).name}: numpy {numpy.__version__}, 80-bit floats, seed {SEED}\n")
        out = csv.writer(file, lineterminator="\n", quoting=csv.QUOTE_NONNUMERIC)
        file.write("spec,wix,wiy,wiz,wox,woy,woz,r,g,b\n")
        for model, (function, keys) in KEYS.items():
            write_rows(out, model, function, keys)
        for model, extra in ANISOTROPY.items():
            write_rows(out, model, KEYS[model][0], {**KEYS[model][1], **extra})
        for model, extra in FILM.items():
            write_rows(out, model, KEYS[model][0], {**KEYS[model][1], **extra}, 25)


if __name__ == "__main__":
    main()
