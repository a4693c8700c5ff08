# SPDX-License-Identifier: MIT
"""f_r of the made-up materials of tests/support/brdf_files*.c, computed by numpy from the papers of the formats: RGL
(Dupuy and Jakob 2018) by integrating the interpolated density of the warp for each pair, its spectra after evaluation by the fits
of Wyman, Sloan and Shirley 2013 and D65 from the daylight components of CIE 15, UTIA (Filip and Vavra 2014), NBRDF (Sztrajman et al. 2021)
and neural processes (Zheng et al. 2021) as matrix products in float64. The material data use the same noise function as
the C files. Writes brdf.safetensors to the folder of this script.
Usage: python3 brdf.py"""
import numpy as np

import store

SEED = 20250612
N = 60
# The other direction must not be near the horizon, because the result is divided by its cosine.
MIN_COS = 0.05


def noise(n, row, start=0):
    x = (np.arange(start, start + n, dtype=np.uint64) + np.uint64(row) * np.uint64(0x9E3779B9)) & np.uint64(0xFFFFFFFF)
    m = np.uint64(0xFFFFFFFF)
    x = ((x ^ (x >> np.uint64(16))) * np.uint64(0x85EBCA6B)) & m
    x = ((x ^ (x >> np.uint64(13))) * np.uint64(0xC2B2AE35)) & m
    return ((x ^ (x >> np.uint64(16))) >> np.uint64(8)).astype(np.float64) / 16777216


def pairs(rng):
    """Random unit vectors in the upper hemisphere."""
    w = []
    while len(w) < 2 * N:
        v = rng.normal(size=3)
        v /= np.linalg.norm(v)
        v[2] = abs(v[2])
        if v[2] > MIN_COS:
            w.append(v)
    return np.array(w[:N]), np.array(w[N:])


def half_diff(wi, wo):
    h = wi + wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    phi = -np.arctan2(h[:, 1], h[:, 0])
    theta = np.arccos(h[:, 2])
    x = np.cos(phi) * wi[:, 0] - np.sin(phi) * wi[:, 1]
    y = np.sin(phi) * wi[:, 0] + np.cos(phi) * wi[:, 1]
    d = np.stack([np.cos(theta) * x - np.sin(theta) * wi[:, 2], y, np.sin(theta) * x + np.cos(theta) * wi[:, 2]], 1)
    return np.stack([theta, np.arccos(np.clip(d[:, 2], -1, 1)), np.arctan2(d[:, 1], d[:, 0]) % np.pi], 1)


def float32(x):
    return x.astype(np.float32).astype(np.float64)


WAVELENGTHS = np.array([360, 420, 450, 500, 540, 580, 620.5, 700, 1000])


def matching(nm):
    """The colour matching functions, (len(nm), 3), as sums of Gaussians with two widths."""
    def g(scale, mu, below, above):
        return scale * np.exp(-0.5 * ((nm - mu) * np.where(nm < mu, below, above))**2)
    return np.stack([g(0.362, 442.0, 0.0624, 0.0374) + g(1.056, 599.8, 0.0264, 0.0323) + g(-0.065, 501.1, 0.0490, 0.0382),
                     g(0.821, 568.8, 0.0213, 0.0247) + g(0.286, 530.9, 0.0613, 0.0322),
                     g(1.217, 437.0, 0.0845, 0.0278) + g(0.681, 459.0, 0.0385, 0.0725)], 1)


# S0, S1, S2 of CIE 15, 380 to 780 nm in steps of 10.
DAYLIGHT = np.array([
    63.4, 38.5, 3, 65.8, 35, 1.2, 94.8, 43.4, -1.1, 104.8, 46.3, -0.5, 105.9, 43.9, -0.7, 96.8, 37.1, -1.2, 113.9, 36.7,
    -2.6, 125.6, 35.9, -2.9, 125.5, 32.6, -2.8, 121.3, 27.9, -2.6, 121.3, 24.3, -2.6, 113.5, 20.1, -1.8, 113.1, 16.2, -1.5,
    110.8, 13.2, -1.3, 106.5, 8.6, -1.2, 108.8, 6.1, -1, 105.3, 4.2, -0.5, 104.4, 1.9, -0.3, 100, 0, 0, 96, -1.6, 0.2, 95.1,
    -3.5, 0.5, 89.1, -3.5, 2.1, 90.5, -5.8, 3.2, 90.3, -7.2, 4.1, 88.4, -8.6, 4.7, 84, -9.5, 5.1, 85.1, -10.9, 6.7, 81.9,
    -10.7, 7.3, 82.6, -12, 8.6, 84.9, -14, 9.8, 81.3, -13.6, 10.2, 71.9, -12, 8.3, 74.3, -13.3, 9.6, 76.4, -12.9, 8.5, 63.3,
    -10.6, 7, 71.7, -11.6, 7.6, 77, -12.2, 8, 65.2, -10.2, 6.7, 47.7, -7.8, 5.2, 68.6, -11.2, 7.4, 65, -10.4, 6.8
]).reshape(-1, 3)


def daylight(nm):
    """D65, by the formula of CIE 15 for a correlated colour temperature of 6504 K."""
    t = 6500 * 1.4388 / 1.438
    x = -4.6070e9 / t**3 + 2.9678e6 / t**2 + 0.09911e3 / t + 0.244063
    y = -3 * x * x + 2.87 * x - 0.275
    m = 0.0241 + 0.2562 * x - 0.7341 * y
    m1, m2 = round((-1.3515 - 1.7703 * x + 5.9114 * y) / m, 3), round((0.03 - 31.4424 * x + 30.0717 * y) / m, 3)
    return np.interp(nm, np.arange(380, 781, 10), DAYLIGHT @ [1, m1, m2])


def spectrum_to_rgb(values, illuminant, wavelengths=WAVELENGTHS):
    """Linear BT.709 of spectra (n, wavelengths), adapted from the illuminant's white by Bradford's cones."""
    nm = np.arange(380, 781, 1.0)
    light = (daylight(nm) if illuminant == "D65" else np.ones(len(nm)))[:, None] * matching(nm)
    spectra = np.stack([np.interp(nm, wavelengths, v) for v in values])
    cones = np.array([[.8951, .2664, -.1614], [-.7502, 1.7135, .0367], [.0389, -.0685, 1.0296]])
    column = lambda x, y: np.array([x / y, 1, (1 - x - y) / y])
    primaries = np.stack([column(.64, .33), column(.30, .60), column(.15, .06)], 1)
    white = column(.3127, .3290)
    to_rgb = np.linalg.inv(primaries * np.linalg.solve(primaries, white))
    adapted = np.linalg.inv(cones) @ np.diag((cones @ white) / (cones @ light.sum(0))) @ cones
    return spectra @ light @ (to_rgb @ adapted).T


class Rgl:
    def __init__(self):
        self.theta_i = float32(np.array([0, 0.6, 1.1, 1.5707964]))
        self.sigma = float32(noise(14, ord("s")) + 0.125).reshape(2, 7)
        self.ndf = float32(2 * noise(18, ord("n")) + 0.25).reshape(2, 9)
        self.vndf = float32(noise(192, ord("v"))).reshape(4, 6, 8)
        self.vndf[:2, :2] = 0
        self.rgb = float32(4 * noise(420, ord("r")) - 1).reshape(4, 3, 5, 7)
        self.spectra = float32(4 * noise(4 * 9 * 35, ord("s")) - 1).reshape(4, 9, 5, 7)

    @staticmethod
    def bilinear(table, u, v):
        h, w = table.shape[-2:]
        x, y = u * (w - 1), v * (h - 1)
        i, j = min(int(x), w - 2), min(int(y), h - 2)
        x, y = x - i, y - j
        return ((1 - y) * ((1 - x) * table[..., j, i] + x * table[..., j, i + 1]) + y *
                ((1 - x) * table[..., j + 1, i] + x * table[..., j + 1, i + 1]))

    @staticmethod
    def integral(f, x):
        """The integral of a piecewise linear function with values f at 0, 1, 2... from 0 to x."""
        whole = int(x)
        total = sum((f[i] + f[i + 1]) / 2 for i in range(whole))
        if whole < len(f) - 1:
            at_x = f[whole] + (x - whole) * (f[whole + 1] - f[whole])
            total += (x - whole) * (f[whole] + at_x) / 2
        return total

    def mixed(self, table, theta):
        k = min(max(np.searchsorted(self.theta_i, theta, side="right") - 1, 0), len(self.theta_i) - 2)
        t = min(max((theta - self.theta_i[k]) / (self.theta_i[k + 1] - self.theta_i[k]), 0), 1)
        return (1 - t) * table[k] + t * table[k + 1]

    def eval(self, viewer, light, spectral=False):
        h = viewer + light
        h /= np.linalg.norm(h)
        phi = np.arctan2(h[1], h[0]) - np.arctan2(viewer[1], viewer[0])
        return self.eval_at(np.arccos(viewer[2]), 0.5, np.arccos(h[2]), phi, spectral) / light[2]

    def eval_at(self, theta_i, v_i, theta_h, phi, spectral):
        """f_r times the cosine of the light. v_i: the azimuth of incidence and phi: that of the half vector on the grids of the file."""
        u, v = np.sqrt(theta_h * 2 / np.pi), ((phi + np.pi) / (2 * np.pi)) % 1
        unit = np.array([self.integral(np.array([self.integral(row, 7) for row in s]), 5) for s in self.vndf.reshape(-1, 6, 8)])
        unit = unit.reshape(self.vndf.shape[:-2])
        density = self.mixed(self.vndf / unit[..., None, None], theta_i)
        # The density along the half vector's row, and the integrals of all rows.
        y = v * 5
        j = min(int(y), 4)
        row = (1 - (y - j)) * density[j] + (y - j) * density[j + 1]
        rows = np.array([self.integral(r, 7) for r in density])
        s_u = self.integral(row, u * 7) / self.integral(row, 7) if self.integral(row, 7) > 0 else u
        s_v = self.integral(rows, y)
        value = self.bilinear(self.mixed(self.spectra if spectral else self.rgb, theta_i), min(s_u, 1), min(s_v, 1))
        d = self.bilinear(self.ndf, u, v)
        sigma = self.bilinear(self.sigma, np.sqrt(theta_i * 2 / np.pi), v_i)
        return value * d / (4 * sigma)


class AnisotropicRgl(Rgl):
    """Several phi_i, over a turn (reduction 1), a half (2) or a quarter (4), with azimuths from the tangent. The symmetries are those of
    Mitsuba 3: a pair is turned or mirrored so that x (of quarters) and y of omega_i are not positive."""
    PHI = {1: [-np.pi, -1.5, 0.25, 1.75, np.pi], 2: [-np.pi, -2, -1.25, 0], 4: [-np.pi, -2.5, -np.pi / 2]}

    def __init__(self, reduction):
        super().__init__()
        self.reduction = reduction
        self.phi_i = float32(np.array(self.PHI[reduction]))
        n = len(self.phi_i)
        self.vndf = float32(noise(n * 192, ord("v"))).reshape(n, 4, 6, 8)
        self.vndf[:, :2, :2] = 0
        self.rgb = float32(4 * noise(n * 420, ord("r")) - 1).reshape(n, 4, 3, 5, 7)
        self.spectra = float32(4 * noise(n * 4 * 9 * 35, ord("s")) - 1).reshape(n, 4, 9, 5, 7)

    def mixed(self, table, theta):
        k = min(max(np.searchsorted(self.phi_i, self.phi, side="right") - 1, 0), len(self.phi_i) - 2)
        t = min(max((self.phi - self.phi_i[k]) / (self.phi_i[k + 1] - self.phi_i[k]), 0), 1)
        return (1 - t) * super().mixed(table[k], theta) + t * super().mixed(table[k + 1], theta)

    def eval(self, viewer, light, spectral=False):
        sign = np.ones(3)
        if self.reduction >= 2:
            sign[1] = -np.sign(viewer[1])
            sign[0] = -np.sign(viewer[0]) if self.reduction == 4 else sign[1]
            sign[sign == 0] = 1
        viewer, light = viewer * sign, light * sign
        h = viewer + light
        h /= np.linalg.norm(h)
        self.phi = np.arctan2(viewer[1], viewer[0])
        return self.eval_at(np.arccos(viewer[2]), (self.phi + np.pi) / (2 * np.pi), np.arccos(h[2]), np.arctan2(h[1], h[0]),
                            spectral) / light[2]


class Pbsdf:
    """Element (0, 0) of M, linear between nodes in every angle and wavelength; nodes with NaN are left out."""
    WAVELENGTHS = np.array([450, 500, 550, 600, 650.0])

    def __init__(self):
        self.axes = [float32(np.array(a)) for a in ([-np.pi, -2, -0.5, 1, 2.25, np.pi], [0, 0.25, 0.75, np.pi / 2],
                                                    [0, 0.125, 0.5, 1, np.pi / 2])]
        m = float32(2 * noise(6 * 4 * 5 * 80, ord("M")) - 0.25)
        m[np.arange(len(m)) // 80 % 7 == 3] = np.nan
        self.m00 = m.reshape(6, 4, 5, 5, 4, 4)[..., 0, 0]

    def eval(self, light, viewer):
        h = light + viewer
        h /= np.linalg.norm(h)
        # The frame of the half vector: its z axis; y is perpendicular to the normal.
        y = np.cross([0, 0, 1], h)
        y /= np.linalg.norm(y)
        x = np.cross(y, h)
        point = [np.arctan2(light @ y, light @ x), np.arccos(light @ h), np.arccos(h[2])]
        total, weight = np.zeros(5), 0
        spans = []
        for node, value in zip(self.axes, point):
            i = min(np.searchsorted(node, value, side="right") - 1, len(node) - 2)
            t = (value - node[i]) / (node[i + 1] - node[i])
            spans.append([(i, 1 - t), (i + 1, t)])
        for a, wa in spans[0]:
            for b, wb in spans[1]:
                for c, wc in spans[2]:
                    if not np.isnan(self.m00[a, b, c, 0]):
                        weight += wa * wb * wc
                        total += wa * wb * wc * self.m00[a, b, c]
        return total / weight


class Utia:
    """Linear in the four angles as in the authors' TBRDF.cpp, which continues the lines beyond 75 degrees."""

    def __init__(self):
        self.value = (2 * noise(3 * 288 * 288, ord("u")) - 0.1).reshape(3, 6, 48, 6, 48)

    def eval(self, light, viewer):
        weights = []
        for w in light, viewer:
            theta, phi = np.degrees(np.arccos(w[2])), np.degrees(np.arctan2(w[1], w[0])) % 360
            i, j = min(int(theta // 15), 4), int(phi // 7.5)
            t, p = (theta - 15 * i) / 15, (phi - 7.5 * j) / 7.5
            weights += [[(i, 1 - t), (i + 1, t)], [(j % 48, 1 - p), ((j + 1) % 48, p)]]
        return sum(self.value[:, a, b, c, d] * wa * wb * wc * wd for a, wa in weights[0] for b, wb in weights[1]
                   for c, wc in weights[2] for d, wd in weights[3])


def dense(shapes, row):
    for i, (n_in, n_out) in enumerate(shapes):
        scale = float32(np.array(1 / np.sqrt(n_in)))
        w = float32(float32(2 * noise(n_in * n_out, row + 2 * i) - 1) * scale).reshape(n_in, n_out)
        b = float32(float32(2 * noise(n_out, row + 2 * i + 1) - 1) * scale)
        yield w, b


def nbrdf(hd):
    h, d, p = hd.T
    x = np.stack([np.sin(h), 0 * h, np.cos(h), np.sin(d) * np.cos(p), np.sin(d) * np.sin(p), np.cos(d)], 1)
    for i, (w, b) in enumerate(dense([(6, 21), (21, 21), (21, 3)], 1)):
        x = x @ w + b
        x = np.maximum(x, 0) if i < 2 else np.expm1(x)
    return x


def nps(hd, latent):
    h, d, p = hd.T
    x = np.stack([np.cos(2 * p) / 2 + 0.5, np.sin(2 * p) / 2 + 0.5, h * 2 / np.pi, d * 2 / np.pi], 1)
    x = np.concatenate([x, np.broadcast_to(latent, (len(x), 7))], 1)
    at = 0
    widths = [11] + [400] * 6 + [3]
    for n_in, n_out in zip(widths[:-1], widths[1:]):
        scale = float32(np.array(np.sqrt(6 / n_in)))
        w = float32(float32(2 * noise(n_in * n_out, 23, at) - 1) * scale).reshape(n_in, n_out)
        b = noise(n_out, 23, at + n_in * n_out)
        at += n_in * n_out + n_out
        x = np.maximum(x @ w + b, 0)
    x *= 0.15
    for _ in range(4):
        x = np.expm1(x)
    return x


def main():
    rng = np.random.default_rng(SEED)
    wi, wo = pairs(rng)
    wi[0], wo[0] = [0, 0, 1], [0.6, 0, 0.8]  # light along the normal
    wi[1], wo[1] = [0.6, 0, 0.8], [0, 0, 1]  # viewer along the normal
    wi[2], wo[2] = [0.6, 0, 0.8], [-0.28, 0, 0.96]  # in one plane, on both sides of the normal
    wi[3], wo[3] = [0.6, 0, 0.8], [0.8, 0, 0.6]  # almost retroreflection
    rgl, pbsdf, utia = Rgl(), Pbsdf(), Utia()
    spectra = np.array([rgl.eval(o, i, spectral=True) for i, o in zip(wi, wo)])
    polarized = np.array([pbsdf.eval(i, o) for i, o in zip(wi, wo)])
    half_turn = np.array([AnisotropicRgl(2).eval(o, i, spectral=True) for i, o in zip(wi, wo)])
    out = {"pair": np.concatenate([wi, wo], 1),  # light, viewer
           "rgl": [rgl.eval(o, i) for i, o in zip(wi, wo)],  # negative where its data are
           "rgl_e": spectrum_to_rgb(spectra, "E"), "rgl_d65": spectrum_to_rgb(spectra, "D65"),
           "pbsdf": spectrum_to_rgb(polarized, "E", Pbsdf.WAVELENGTHS), "pbsdf_d65": spectrum_to_rgb(polarized, "D65", Pbsdf.WAVELENGTHS),
           "nbrdf": nbrdf(half_diff(wi, wo)),  # negative where the network is
           "nps": nps(half_diff(wi, wo), np.array([-0.5, 0.25, 0, 1, 0.5, -0.125, -0.75])),  # material 'second'
           "rgl_2_d65": spectrum_to_rgb(half_turn, "D65"), "utia": [utia.eval(i, o) for i, o in zip(wi, wo)]}
    for n in [1, 2, 4]:  # with 1 / n of a turn of phi_i
        turned = AnisotropicRgl(n)
        out["rgl_%d" % n] = [turned.eval(o, i) for i, o in zip(wi, wo)]
    store.safetensors("brdf.safetensors", {name: np.array(x, "f8") for name, x in out.items()}, {"made_by": store.made_by("brdf.py", f"seed {SEED}")})


main()
