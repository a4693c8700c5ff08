# SPDX-License-Identifier: MIT
"""As conform_gltf.py, with Mitsuba 3's principled: mistakes that were typed after the list of nqm was finished.

usage: conform_principled.py TOOL [NUMBER...]"""
import sys

from conform_gltf import main

SHADER = '''
def fresnel(eta, cosine):
    sine2 = (1 - cosine * cosine) / (eta * eta)
    t = np.sqrt(np.maximum(1 - sine2, 0))
    s = (cosine - eta * t) / (cosine + eta * t)
    p = (eta * cosine - t) / (eta * cosine + t)
    return 0.5 * (s * s + p * p)

def g1(w, ax, ay):
    return 2 / (1 + np.sqrt(1 + ((ax * w[0])**2 + (ay * w[1])**2) / (w[2] * w[2])))

def pow5(x):
    return x**5

def brdf(m, l, v):
    h = l + v
    h = h / np.sqrt(dot(h, h))
    n_l, n_v, n_h, l_h = l[2], v[2], h[2], np.clip(dot(l, h), 0, 1)
    base, metallic, roughness = m["base_color"], m["metallic"], m["roughness"]
    luminance = 0.212671 * base[0] + 0.715160 * base[1] + 0.072169 * base[2]
    tint = np.where(luminance > 0, base / np.maximum(luminance, 1e-20), 1)
    aspect = np.sqrt(1 - 0.9 * m["anisotropic"])
    ax = np.maximum(0.001, roughness * roughness / aspect)
    ay = np.maximum(0.001, roughness * roughness * aspect)
    e = (h[0] / ax)**2 + (h[1] / ay)**2 + n_h * n_h
    d = 1 / (PI * ax * ay * e * e)
    g = g1(l, ax, ay) * g1(v, ax, ay)
    weight = pow5(1 - l_h)
    tinted = tint * ((m["eta"] - 1) / (m["eta"] + 1))**2
    f_glass = fresnel(m["eta"], l_h)
    f_metal = mix(base, 1, weight)
    f_tint = mix(tinted, 1, weight)
    f = (1 - metallic) * (mix(f_glass, f_tint, m["spec_tint"])) + metallic * f_metal
    color = f * d * g / (4 * n_l * n_v)
    a = mix(0.1, 0.001, m["clearcoat_gloss"])
    d_coat = (a * a - 1) / (PI * np.log(a * a) * (1 + (a * a - 1) * n_h * n_h))
    g_coat = g1(l, 0.25, 0.25) * g1(v, 0.25, 0.25)
    color = color + 0.25 * m["clearcoat"] * mix(0.04, 1, weight) * d_coat * g_coat
    f_l, f_v = pow5(1 - n_l), pow5(1 - n_v)
    rr = 2 * roughness * l_h * l_h
    shape = (1 - 0.5 * f_l) * (1 - 0.5 * f_v) + rr * (f_l + f_v + f_l * f_v * (rr - 1))
    ss = mix(1, 0.5 * rr, f_v) * mix(1, 0.5 * rr, f_l)
    flat = 1.25 * (ss * (1 / (n_l + n_v) - 0.5) + 0.5)
    color = color + (1 - metallic) * base / PI * mix(shape, flat, m["flatness"])
    return color + (1 - metallic) * m["sheen"] * weight * mix(1, tint, m["sheen_tint"])
'''

MISTAKES = [
    ("^roughness is not squared", "roughness * roughness", "roughness"),
    ("^roughness is squared twice", "roughness * roughness", "(roughness * roughness)**2"),
    ("^roughness is inverted", 'm["roughness"]', '1 - m["roughness"]'),
    ("D lacks 1 / pi", "1 / (PI * ax * ay * e * e)", "1 / (ax * ay * e * e)"),
    ("denominator of the distribution", "ax * ay * e * e)", "ax * ay * e)"),
    ("D is Beckmann's", "    d = 1 / (PI * ax * ay * e * e)", "    d = np.exp(1 - e / n_h**2) / (PI * ax * ay * n_h**4)"),
    ("height-correlated, not separable", "g = g1(l, ax, ay) * g1(v, ax, ay)", "g = 1 / (1 / g1(l, ax, ay) + 1 / g1(v, ax, ay) - 1)"),
    ("G is left out", "g = g1(l, ax, ay) * g1(v, ax, ay)", "g = 1"),
    ("k = alpha / 2", "g = g1(l, ax, ay) * g1(v, ax, ay)",
     "k = roughness * roughness / 2; g = n_l / mix(n_l, 1, k) * n_v / mix(n_v, 1, k)"),
    ("has alpha where alpha", "g = g1(l, ax, ay) * g1(v, ax, ay)", "g = g1(l, np.sqrt(ax), np.sqrt(ay)) * g1(v, np.sqrt(ax), np.sqrt(ay))"),
    (r"1 / \(4 cos cos\) is left out", " / (4 * n_l * n_v)", ""),
    ("4 of 1 / .4 cos cos", " / (4 * n_l * n_v)", " / (n_l * n_v)"),
    ("pi cos cos", " / (4 * n_l * n_v)", " / (PI * n_l * n_v)"),
    ("half vector is not normalised", "    h = h / np.sqrt(dot(h, h))\n", ""),
    ("angle of normal and viewer", "l_h = l[2], v[2], h[2], np.clip(dot(l, h), 0, 1)", "l_h = l[2], v[2], h[2], v[2]"),
    ("angle of normal and half", "np.clip(dot(l, h), 0, 1)", "h[2]"),
    ("Schlick's, not the exact", 'fresnel(m["eta"], l_h)', 'mix(((m["eta"] - 1) / (m["eta"] + 1))**2, 1, weight)'),
    ("normal incidence at every angle", "weight = pow5(1 - l_h)", "weight = 0 * l_h", "fresnel(m[\"eta\"], l_h)", "fresnel(m[\"eta\"], 1 + 0 * l_h)"),
    ("Fresnel factor is left out", "f = (1 - metallic)", "f = 1 + 0 * (1 - metallic)"),
    ("multiplied by 1 - metallic", "color + (1 - metallic) * base / PI", "color + base / PI"),
    ("diffuse part lacks 1 / pi", "base / PI", "base"),
    ("Lambert's", "mix(shape, flat", "mix(1, flat"),
    ("^anisotropic is ignored", "0.9 * m[\"anisotropic\"]", "0"),
    ("tangent and bitangent", "roughness * roughness / aspect", "roughness * roughness * aspect", "    ay = np.maximum(0.001, roughness * roughness * aspect)",
     "    ay = np.maximum(0.001, roughness * roughness / aspect)"),
    ("spec_tint is ignored", 'm["spec_tint"]', "0"),
    ("sheen_tint is ignored", 'm["sheen_tint"]', "0"),
    ("sheen is ignored", 'm["sheen"] * weight', "0 * weight"),
    ("clearcoat is ignored", '0.25 * m["clearcoat"]', "0"),
    ("clearcoat_gloss is inverted", "mix(0.1, 0.001,", "mix(0.001, 0.1,"),
    ("flatness is ignored", 'm["flatness"]', "0"),
    ("eta is ignored", 'm["eta"]', "1.5"),
    ("metallic is ignored", 'm["metallic"]', "0 * m[\"metallic\"]"),
    ("base_color is decoded", 'base, metallic, roughness = m["base_color"]', 'base, metallic, roughness = m["base_color"]**2.2'),
    ("^the values are read as .bgr", "return color + (1", "color = color + (1", "m[\"sheen_tint\"])\n", "m[\"sheen_tint\"])\n    return color[::-1]\n"),
    ("cosine of the light", "return color + (1", "color = color + (1", "m[\"sheen_tint\"])\n", "m[\"sheen_tint\"])\n    return color * n_l\n"),
    ("pi times too large", "return color + (1", "color = color + (1", "m[\"sheen_tint\"])\n", "m[\"sheen_tint\"])\n    return color * PI\n"),
    ("^the exponent of Schlick's factor is not 5 but 4$", "x**5", "x**4"),
    ("^F0 of the clear coat is that of the base's index", "mix(0.04, 1, weight)", 'mix(((m["eta"] - 1) / (m["eta"] + 1))**2, 1, weight)'),
    ("^roughness is raised to at least 0.25$", 'm["roughness"]', 'np.maximum(m["roughness"], np.float32(0.25))'),
    ("^base_color is read as .rrr$", 'm["base_color"]', 'm["base_color"][[0, 0, 0]]'),
]

if __name__ == "__main__":
    sys.exit(main("principled", SHADER, MISTAKES))
