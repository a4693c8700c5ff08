# SPDX-License-Identifier: MIT
"""Files of an anisotropic model, written here in the layouts of RGL, UTIA and NumPy, give the model back within their resolution, also when
the sample is turned."""
import os
import struct
import tempfile
import unittest

import numpy as np

import nqm


def turn(w, angle):
    """w (..., 3) turned about the normal."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * w[..., 0] - s * w[..., 1], s * w[..., 0] + c * w[..., 1], w[..., 2]], -1)


class Brushed:
    """Lambert and GGX with the widths .35 along the tangent and .8 across it (Heitz 2014), on a sample turned by an angle."""

    def __init__(self, angle=0):
        self.angle = angle

    def ndf(self, m):
        m = turn(m, -self.angle)
        return 1 / (np.pi * .35 * .8 * np.maximum((m[..., 0] / .35)**2 + (m[..., 1] / .8)**2 + m[..., 2]**2, 1e-12)**2)

    def smith(self, w):
        return 2 / (1 + np.sqrt(1 + ((.35 * w[..., 0])**2 + (.8 * w[..., 1])**2) / w[..., 2]**2))

    def eval(self, wi, wo):
        """f_r (..., 3); 0 below the horizon."""
        up = (wi[..., 2] > 0) & (wo[..., 2] > 0)
        m = wi + wo
        m = m / np.maximum(np.linalg.norm(m, axis=-1, keepdims=True), 1e-12)
        i, o = turn(wi, -self.angle), turn(wo, -self.angle)
        cosines = np.where(up, wi[..., 2] * wo[..., 2], 1)
        lobe = self.ndf(m) * self.smith(i) * self.smith(o) / (4 * cosines)
        return np.where(up, lobe, 0)[..., None] * [.5, .4, .3] + up[..., None] * np.array([.1, .2, .3]) / np.pi


def spherical(theta, phi):
    return np.stack(np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), -1)


def pairs(n, most_deg, seed=1):
    """Light and viewer (n, 3), uniform up to a polar angle."""
    rng = np.random.default_rng(seed)
    z = 1 - (1 - np.cos(np.radians(most_deg))) * rng.uniform(size=(2, n))
    return spherical(np.arccos(z), rng.uniform(0, 2 * np.pi, (2, n)))


# ---- RGL -----------------------------------------------------------------------------------------------------------------


def invert_integral(density, share):
    """Where the integral of a piecewise linear density over [0, 1] reaches these shares of the whole."""
    n = len(density) - 1
    whole = np.concatenate([[0], np.cumsum((density[1:] + density[:-1]) / 2)])
    target = share * whole[-1]
    cell = np.clip(np.searchsorted(whole, target, side="right") - 1, 0, n - 1)
    rest, a, b = target - whole[cell], density[cell], density[cell + 1]
    root = np.sqrt(np.maximum(a * a + 2 * rest * (b - a), 0))
    return (cell + np.clip(2 * rest / (a + root), 0, 1)) / n


def bilinear(table, u, v):
    h, w = table.shape
    x, y = u * (w - 1), v * (h - 1)
    i, j = np.minimum(x.astype(int), w - 2), np.minimum(y.astype(int), h - 2)
    x, y = x - i, y - j
    return (1 - y) * ((1 - x) * table[j, i] + x * table[j, i + 1]) + y * ((1 - x) * table[j + 1, i] + x * table[j + 1, i + 1])


def half_vector(u, v):
    """The grids of the file: theta = u^2 pi/2, phi = (2 v - 1) pi."""
    return spherical(u * u * np.pi / 2, (2 * v - 1) * np.pi)


def rgl_slice(model, viewer, vndf, ndf, sigma, n):
    """The values on the warped grid (3, n, n): f_r cos 4 sigma / ndf at the half vectors to which the warp maps its nodes."""
    x = y = np.linspace(0, 1, n)
    rows = vndf.sum(1) - (vndf[:, 0] + vndf[:, -1]) / 2
    v = invert_integral(rows, y)
    at = v * (len(rows) - 1)
    j = np.minimum(at.astype(int), len(rows) - 2)
    u = np.stack([invert_integral((1 - t) * vndf[k] + t * vndf[k + 1], x) for k, t in zip(j, at - j)])
    v = np.broadcast_to(v[:, None], u.shape)
    m = half_vector(u, v)
    light = 2 * (m @ viewer)[..., None] * m - viewer
    return np.moveaxis(model.eval(light, viewer) * (np.maximum(light[..., 2], 0) * 4 * sigma / bilinear(ndf, u, v))[..., None], -1, 0)


def write_rgl(path, model, phi_i, n_theta=9, n=48):
    phi_i, theta_i = np.array(phi_i, "<f4"), np.radians(np.linspace(0, 88, n_theta)).astype("<f4")
    u, v = np.meshgrid(np.linspace(0, 1, 64), np.linspace(0, 1, 64))
    m = half_vector(u, v)
    ndf, sigma = model.ndf(m).astype("<f4"), np.full((2, 2), .7, "<f4")
    area = u * np.sin(u * u * np.pi / 2) + .02
    viewers = [[spherical(float(t), float(p)) for t in theta_i] for p in phi_i]
    # Any positive density: that of visible normals and a floor.
    vndf = np.array([[(model.ndf(m) * np.maximum(m @ w, 0) + .05) * area for w in row] for row in viewers]).astype("<f4")
    values = np.array([[rgl_slice(model, w, d.astype(float), ndf.astype(float), .7, n) for w, d in zip(row, density)]
                       for row, density in zip(viewers, vndf)]).astype("<f4")
    fields = {"description": np.frombuffer(b"brushed", "u1"), "phi_i": phi_i, "theta_i": theta_i, "sigma": sigma, "ndf": ndf, "vndf": vndf,
              "luminance": values[:, :, 0], "rgb": values, "jacobian": np.array([1], "u1")}
    at = 18 + sum(2 + len(k) + 2 + 1 + 8 + 8 * a.ndim for k, a in fields.items())
    table, blocks = b"", b""
    for name, a in fields.items():
        table += struct.pack("<H", len(name)) + name.encode() + struct.pack("<HBQ", a.ndim, 10 if a.dtype.kind == "f" else 1, at + len(blocks))
        table += struct.pack("<%dQ" % a.ndim, *a.shape)
        blocks += a.tobytes()
    with open(path, "wb") as f:
        f.write(b"tensor_file\0\1\0" + struct.pack("<I", len(fields)) + table + blocks)


# ---- other files ---------------------------------------------------------------------------------------------------------


def write_utia(path, model):
    theta, phi = np.radians(15 * np.arange(6)), np.radians(7.5 * np.arange(48))
    w = spherical(theta[:, None], phi).reshape(288, 3)
    np.moveaxis(model.eval(w[:, None], w), -1, 0).astype("<f8").tofile(path)


def write_table(path, model, n_phi_h=48):
    wi, wo = nqm.half_diff_to_directions(nqm.table_nodes(60, 30, 24))
    below = (wi[..., 2] <= 0) | (wo[..., 2] <= 0)
    slices = [model.eval(turn(wi, a), turn(wo, a)) for a in 2 * np.pi * np.arange(n_phi_h) / n_phi_h]
    slices = [np.where(below[..., None], np.nan, s) for s in slices]
    np.save(path, np.stack(slices, 3).astype("<f4"))


class Files(unittest.TestCase):
    def compare(self, write, *arguments, model=Brushed(), most_deg=60, median, p95):
        """The relative differences of the file from the model have at most this median and 95 % quantile."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "file" + (".npy" if write == write_table else ""))
            write(path, model, *arguments)
            brdf = nqm.BRDF.open(path)
        wi, wo = pairs(4000, most_deg)
        value, flag = brdf.eval_flags(wi, wo)
        self.assertTrue((flag <= 1).all())
        expected = model.eval(wi, wo)
        difference = np.abs(value - expected) / expected
        self.assertLess(np.median(difference), median)
        self.assertLess(np.quantile(difference, .95), p95)
        # The model is far from isotropic: a wrong azimuth cannot pass.
        turned = np.abs(model.eval(turn(wi, .4), turn(wo, .4)) - expected) / expected
        self.assertGreater(np.quantile(turned, .95), 4 * p95)

    def test_rgl(self):
        for angle in 0, .5:
            self.compare(write_rgl, np.linspace(-np.pi, np.pi, 17), model=Brushed(angle), median=.01, p95=.07)

    def test_rgl_of_symmetric_samples(self):
        for angle in 0, .5:  # f_r does not change by half a turn
            self.compare(write_rgl, np.linspace(-np.pi, 0, 9), model=Brushed(angle), median=.01, p95=.07)
        self.compare(write_rgl, np.linspace(0, np.pi, 9), model=Brushed(.5), median=.01, p95=.07)
        self.compare(write_rgl, np.linspace(-np.pi, -np.pi / 2, 5), median=.01, p95=.07)
        self.compare(write_rgl, np.linspace(0, np.pi / 2, 5), median=.01, p95=.07)

    def test_utia(self):
        for angle in 0, .5:
            self.compare(write_utia, model=Brushed(angle), median=.015, p95=.04)

    def test_tables(self):
        for angle in 0, .5:
            self.compare(write_table, model=Brushed(angle), median=.003, p95=.01)


if __name__ == "__main__":
    unittest.main()
