# SPDX-License-Identifier: MIT
"""Does `nqm conform` name the mistake of a shader? A shader of glTF 2.0, written in float32 from the specification (Appendix B and its
extensions) as shaders are, and mistakes as a person types them: each is a text of the shader and what replaces it.

usage: conform_gltf.py TOOL [NUMBER...]    (without numbers: all; prints a row for each, and how many are named first and in three)"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

TABLE = (np.loadtxt(pathlib.Path(__file__).parent / "../../presets/sheen_albedo.txt", delimiter=",") / 1e4).astype("f4")

SHADER = '''
def smith_v(l, v, at, ab):
    ll = np.sqrt((at * l[0])**2 + (ab * l[1])**2 + l[2]**2)
    lv = np.sqrt((at * v[0])**2 + (ab * v[1])**2 + v[2]**2)
    return 0.5 / (l[2] * lv + v[2] * ll)

def ggx_d(h, at, ab):
    f = (ab * h[0])**2 + (at * h[1])**2 + (at * ab * h[2])**2
    a = at * ab
    return a * a * a / (PI * f * f)

def schlick(f0, f90, u):
    return f0 + (f90 - f0) * (1 - u)**5

def charlie_d(n_h, alpha):
    sin_h = np.sqrt(np.maximum(1 - n_h * n_h, 1e-7))
    return (2 + 1 / alpha) * sin_h**(1 / alpha) / (2 * PI)

def curve(x, alpha):
    t = (1 - alpha)**2
    a, b, c, d, e = (p + (q - p) * t for p, q in zip((21.5473, 3.82987, 0.19823, -1.97760, -4.32054),
                                                     (25.3245, 3.32435, 0.16801, -1.27393, -4.85967)))
    return a / (1 + b * x**c) + d * x + e

def charlie_lambda(cosine, alpha):
    return np.exp(np.where(cosine < 0.5, curve(cosine, alpha), 2 * curve(0.5, alpha) - curve(1 - cosine, alpha)))

def charlie_v(n_l, n_v, alpha):
    return 1 / ((1 + charlie_lambda(n_l, alpha) + charlie_lambda(n_v, alpha)) * 4 * n_l * n_v)

def brdf(m, l, v):
    h = l + v
    h = h / np.sqrt(dot(h, h))
    n_l, n_v, n_h, v_h = l[2], v[2], np.minimum(h[2], 1), np.clip(dot(v, h), 0, 1)
    roughness, metallic, base = m["roughness"], m["metallic"], m["base_color"]
    alpha = roughness * roughness
    strength = m["anisotropy_strength"]
    at = mix(alpha, 1, strength * strength)
    ab = alpha
    c, s = np.cos(m["anisotropy_rotation"]), np.sin(m["anisotropy_rotation"])
    local = lambda d: np.array([c * d[0] + s * d[1], c * d[1] - s * d[0], d[2]])
    visibility = smith_v(local(l), local(v), at, ab)
    specular = visibility * ggx_d(local(h), at, ab)
    ior_f0 = ((m["ior"] - 1) / (m["ior"] + 1))**2
    f0 = np.minimum(ior_f0 * m["specular_color"], 1) * m["specular"]
    f90 = m["specular"]
    fresnel = schlick(f0, f90, v_h)
    diffuse = base / PI
    kept = 1 - fresnel.max(axis=0)
    dielectric = kept * diffuse + fresnel * specular
    metal = schlick(base, 1, v_h) * specular
    color = mix(dielectric, metal, metallic)
    sheen_alpha = m["sheen_roughness"]**2
    sheen = m["sheen_color"] * charlie_d(n_h, sheen_alpha) * charlie_v(n_l, n_v, sheen_alpha)
    most = m["sheen_color"].max(axis=0)
    scaling = np.minimum(1 - most * albedo(n_v, m["sheen_roughness"]), 1 - most * albedo(n_l, m["sheen_roughness"]))
    color = sheen + color * scaling
    coat_alpha = m["clearcoat_roughness"]**2
    coat = ggx_d(h, coat_alpha, coat_alpha) * smith_v(l, v, coat_alpha, coat_alpha)
    coat_weight = m["clearcoat"] * schlick(0.04, 1, n_v)
    color = mix(color, coat, coat_weight)
    return color
'''

# What must be in the text of the named mistake; then texts of the shader and what is typed instead.
MISTAKES = [
    ("^roughness is not squared", "alpha = roughness * roughness", "alpha = roughness"),
    ("^roughness is squared twice", "alpha = roughness * roughness", "alpha = (roughness * roughness)**2"),
    ("distribution D lacks 1 / pi", "(PI * f * f)", "(f * f)"),
    ("distribution D is not squared|denominator of the distribution", "a * a * a / (PI * f * f)", "a / (PI * f)"),
    ("G is separable", "return 0.5 / (l[2] * lv + v[2] * ll)", "return 1 / ((l[2] + ll) * (v[2] + lv))"),
    ("k = alpha / 2", "visibility = smith_v(local(l), local(v), at, ab)",
     "k = alpha / 2; visibility = 0.25 / ((n_l * (1 - k) + k) * (n_v * (1 - k) + k))"),
    (r"\(roughness \+ 1\)\^2 / 8", "visibility = smith_v(local(l), local(v), at, ab)",
     "k = (roughness + 1)**2 / 8; visibility = 0.25 / ((n_l * (1 - k) + k) * (n_v * (1 - k) + k))"),
    ("G is left out", "return 0.5 / (l[2] * lv + v[2] * ll)", "return 1 / (4 * l[2] * v[2])"),
    (r"1 / \(4 cos cos\) is left out", "return 0.5 / (l[2] * lv + v[2] * ll)", "return 2 * l[2] * v[2] / (l[2] * lv + v[2] * ll)"),
    (r"1 / \(4 cos cos\) is applied twice", "specular = visibility * ggx_d(local(h), at, ab)",
     "specular = visibility * ggx_d(local(h), at, ab) / (4 * n_l * n_v)"),
    ("angle of normal and viewer", "schlick(f0, f90, v_h)", "schlick(f0, f90, n_v)", "schlick(base, 1, v_h)", "schlick(base, 1, n_v)"),
    ("angle of normal and light", "np.clip(dot(v, h), 0, 1)", "l[2]"),
    ("angle of normal and half vector", "np.clip(dot(v, h), 0, 1)", "h[2]"),
    ("normal incidence at every angle", "schlick(f0, f90, v_h)", "f0 + 0 * v_h", "schlick(base, 1, v_h)", "base"),
    ("Fresnel factor is left out", "schlick(f0, f90, v_h)", "np.ones_like(f0 * v_h)", "schlick(base, 1, v_h)", "1"),
    ("F90", 'f90 = m["specular"]', "f90 = 1"),
    ("diffuse part is not multiplied by what", "kept = 1 - fresnel.max(axis=0)", "kept = 1"),
    ("F of each channel", "kept = 1 - fresnel.max(axis=0)", "kept = 1 - fresnel"),
    ("diffuse part lacks 1 / pi", "diffuse = base / PI", "diffuse = base"),
    ("1 - metallic", "metal = schlick(base, 1, v_h) * specular", "metal = schlick(base, 1, v_h) * specular + kept * diffuse"),
    ("base_color is decoded", 'base = m["roughness"], m["metallic"], m["base_color"]',
     'base = m["roughness"], m["metallic"], m["base_color"]**2.2'),
    ("base_color is not decoded", 'base = m["roughness"], m["metallic"], m["base_color"]',
     'base = m["roughness"], m["metallic"], m["base_color"]**(1 / 2.2)'),
    ("half vector is not normalised", "    h = h / np.sqrt(dot(h, h))\n", ""),
    ("half vector is .light . viewer. / 2", "h = h / np.sqrt(dot(h, h))", "h = 0.5 * h"),
    ("include the cosine of the light", "return color", "return color * n_l"),
    ("include the cosine of the viewer", "return color", "return color * n_v"),
    ("pi times too large", "return color", "return color * PI"),
    ("divided by pi", "return color", "return color / PI"),
    ("^the values are read as .bgr", "return color", "return color[::-1]"),
    ("scaled by its albedo", "color = sheen + color * scaling", "color = sheen + color"),
    ("shadowing of the sheen", "/ ((1 + charlie_lambda(n_l, alpha) + charlie_lambda(n_v, alpha)) * 4 * n_l * n_v)",
     "/ (4 * (n_l + n_v - n_l * n_v))"),
    ("sheen is its roughness, not squared", 'sheen_alpha = m["sheen_roughness"]**2', 'sheen_alpha = m["sheen_roughness"]'),
    ("clearcoat_roughness is not squared", 'coat_alpha = m["clearcoat_roughness"]**2', 'coat_alpha = m["clearcoat_roughness"]'),
    ("below the clear coat", "color = mix(color, coat, coat_weight)", "color = color + coat * coat_weight"),
    ("clear coat has the angle of half", "schlick(0.04, 1, n_v)", "schlick(0.04, 1, v_h)"),
    ("tangent and bitangent", "at = mix(alpha, 1, strength * strength)\n    ab = alpha",
     "ab = mix(alpha, 1, strength * strength)\n    at = alpha"),
    ("anisotropy_strength is the square root", "strength * strength", "strength"),
    ("anisotropy_rotation is flipped", "c * d[0] + s * d[1], c * d[1] - s * d[0]", "c * d[0] - s * d[1], c * d[1] + s * d[0]"),
    ("anisotropy_strength is ignored", "at = mix(alpha, 1, strength * strength)", "at = alpha"),
    ("^ior is ignored", 'ior_f0 = ((m["ior"] - 1) / (m["ior"] + 1))**2', "ior_f0 = 0.04"),
    ("specular_color is ignored", 'ior_f0 * m["specular_color"]', "ior_f0 + 0 * base"),
    ("specular is ignored", '1) * m["specular"]', "1)", 'f90 = m["specular"]', "f90 = 1"),
    ("D is Beckmann's", "    return a * a * a / (PI * f * f)",
     "    e = ((h[0] / at)**2 + (h[1] / ab)**2) / h[2]**2\n    return np.exp(-e) / (PI * a * h[2]**4)"),
    ("encoded as sRGB", "return color", "return np.where(color < 0.0031308, 12.92 * color, 1.055 * color**(1 / 2.4) - 0.055)"),
    ("clamped at 1", "return color", "return np.minimum(color, 1)"),
    ("^roughness is inverted", 'roughness, metallic, base = m["roughness"]', 'roughness, metallic, base = 1 - m["roughness"]'),
    ("sheen_color is ignored", "color = sheen + color * scaling", "pass"),
    ("clearcoat is ignored", "color = mix(color, coat, coat_weight)", "pass"),
    ("metallic is taken as 0", "metal = schlick(base, 1, v_h) * specular", "metal = dielectric"),
    ("4 of 1 / .4 cos cos. is left out", "return 0.5 / (l[2] * lv", "return 2 / (l[2] * lv"),
    ("roughness is squared twice.*1 - F|1 - F.*roughness is squared twice", "alpha = roughness * roughness", "alpha = (roughness * roughness)**2",
     "kept = 1 - fresnel.max(axis=0)", "kept = 1"),
    ("pi.*anisotropy_rotation is flipped|rotation is flipped.*pi", "c * d[0] + s * d[1], c * d[1] - s * d[0]",
     "c * d[0] - s * d[1], c * d[1] + s * d[0]", "diffuse = base / PI", "diffuse = base"),
    ("pi cos cos", "return 0.5 / (l[2] * lv", "return 2 / PI / (l[2] * lv"),
    ("^the exponent of Schlick's factor is not 5 but 4$", "(1 - u)**5", "(1 - u)**4"),
    ("^the exponent of Schlick's factor is not 5 but 6$", "(1 - u)**5", "(1 - u)**6"),
    ("^roughness is raised to at least 0.2$", 'base = m["roughness"]', 'base = np.maximum(m["roughness"], np.float32(0.2))'),
    ("^roughness is raised to at least 0.35$", "alpha = roughness * roughness",
     "alpha = np.maximum(roughness * roughness, np.float32(0.1225))"),
    ("^clearcoat_roughness is raised to at least 0.3$", 'm["clearcoat_roughness"]**2', 'np.maximum(m["clearcoat_roughness"], np.float32(0.3))**2'),
    ("^the values are clamped at 8$", "return color", "return np.minimum(color, 8)"),
    ("^F0 of the clear coat is that of the base's index of refraction$", "schlick(0.04, 1, n_v)", "schlick(ior_f0, 1, n_v)"),
    ("^F0 of the clear coat is that of the base, with", "schlick(0.04, 1, n_v)", "schlick(f0, 1, n_v)"),
    ("^clearcoat_roughness has the value of roughness$", 'm["clearcoat_roughness"]**2', "alpha"),
    ("^base_color is read as .rrr$", 'm["base_color"]\n', 'm["base_color"][[0, 0, 0]]\n'),
    ("^base_color is read as .rgg$", 'm["base_color"]\n', 'm["base_color"][[0, 1, 1]]\n'),
    ("^specular_color is read as .grb$", 'm["specular_color"]', 'm["specular_color"][[1, 0, 2]]'),
    ("^the values are read as .rrb$", "return color", "return color[[0, 0, 2]]"),
    ("^the values: .r is added to .g, times 0.1$", "return color", "return np.array([color[0], color[1] + np.float32(0.1) * color[0], color[2]])"),
    ("^the values: .g is added to .b, times 0.3$", "return color", "return np.array([color[0], color[1], color[2] + np.float32(0.3) * color[1]])"),
    ("^anisotropy_rotation is multiplied by pi / 180", 'np.cos(m["anisotropy_rotation"]), np.sin(m["anisotropy_rotation"])',
     'np.cos(np.radians(m["anisotropy_rotation"])), np.sin(np.radians(m["anisotropy_rotation"]))'),
    ("^anisotropy_rotation is multiplied by 180 / pi", 'np.cos(m["anisotropy_rotation"]), np.sin(m["anisotropy_rotation"])',
     'np.cos(np.degrees(m["anisotropy_rotation"])), np.sin(np.degrees(m["anisotropy_rotation"]))'),
    ("raised to at least 0.2.*not 5 but 4|not 5 but 4.*raised to at least 0.2$", 'base = m["roughness"]', 'base = np.maximum(m["roughness"], np.float32(0.2))',
     "(1 - u)**5", "(1 - u)**4"),
]


def albedo(cosine, roughness):
    """The table of the sheen's albedo, linear between cubic samples as a texture would be."""
    def cubic(samples, x):
        i = np.clip(np.floor(x).astype(int), 0, 30)
        t = x - i.astype("f4")
        b, p, q, a = (samples(np.clip(i + k, 0, 31)) for k in (-1, 0, 1, 2))
        return p + 0.5 * t * (q - b + t * (2 * b - 5 * p + 4 * q - a + t * (3 * (p - q) + a - b)))
    return np.clip(cubic(lambda j: cubic(lambda i: TABLE[i, j], 31 * roughness), 31 * np.sqrt(cosine)), 0, 1)


def evaluate(source, kit):
    names = {"np": np, "PI": np.float32(np.pi), "albedo": albedo, "mix": lambda a, b, t: a * (1 - t) + b * t,
             "dot": lambda a, b: (a * b).sum(axis=0)}
    exec(source, names)
    with np.errstate(all="ignore"):
        values = names["brdf"](*kit)
    assert values.dtype == np.float32, values.dtype
    return np.ascontiguousarray(values.T)


def load_kit(path):
    with open(path) as f:
        columns = f.readline().strip().split(",")
    rows = np.loadtxt(path, "f4", delimiter=",", skiprows=1).T
    at = {name: rows[i] for i, name in enumerate(columns)}
    triple = lambda name, ends: np.array([at[f"{name}_{e}"] for e in ends])
    m = {n: at[n] for n in columns if not re.search(r"_[rgbxyz]$", n)}
    m.update({n[:-2]: triple(n[:-2], "rgb") for n in columns if n.endswith("_r")})
    return m, triple("light", "xyz"), triple("viewer", "xyz")


def conform(command, folder, values):
    np.save(folder / "values.npy", values)
    out = subprocess.run([*command, str(folder / "values.npy"), "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert out.returncode in (0, 1, 5), out.stderr.decode()  # 5: sets that are NaN, as a GGX of alpha 0 gives
    result = json.loads(out.stdout)
    return result["lowest_jod"], result["mistakes"], out.returncode


def main(model, shader, mistakes, keys=None):
    """keys: the parameters that the shader has; None: all."""
    tool, numbers = sys.argv[1], [int(n) for n in sys.argv[2:]] or range(len(mistakes) + 1)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        command = [tool, "conform", model, *(["--keys", keys] if keys else [])]
        subprocess.run([*command, "--directions", str(folder / "kit.csv")], check=True, stderr=subprocess.PIPE)
        kit = load_kit(folder / "kit.csv")
        ranks = []
        for number in numbers:
            expected, *edits = mistakes[number - 1] if number else ("",)
            source = shader
            for old, new in zip(edits[::2], edits[1::2]):
                assert old in source, old
                source = source.replace(old, new)
            jod, found, exit_code = conform(command, folder, evaluate(source, kit))
            assert (exit_code == 1) == (jod < 9.99) or exit_code == 5, (jod, exit_code)
            if not number:
                print(f"right: lowest JOD {jod:.4f}, {len(found)} mistakes")
                assert jod >= 9.99 and not found and not exit_code
                continue
            rank = next((i for i, m in enumerate(found) if re.search(expected, m["mistake"])), 9)
            ranks.append(rank)
            named = found[0] if found else {"mistake": "none", "lowest_jod": jod, "remaining": 0}
            print(f"{number:2} rank {rank + 1} JOD {jod:5.2f} -> {named['lowest_jod']:5.2f} ({100 * named['remaining']:.2g} %) {named['mistake']}")
        first, three = sum(r == 0 for r in ranks), sum(r < 3 for r in ranks)
        print(f"{first} first, {three} in the first three, of {len(ranks)}")
        return 10 * first < 9 * len(ranks) or 100 * three < 98 * len(ranks)


if __name__ == "__main__":
    sys.exit(main("gltf", SHADER, MISTAKES, "base_color,metallic,roughness,anisotropy_strength,anisotropy_rotation,ior,specular,"
                  "specular_color,clearcoat,clearcoat_roughness,sheen_color,sheen_roughness"))
