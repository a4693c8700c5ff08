#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Make presets/rough_plastic.txt: transmittance and internal reflectance of rough dielectric interfaces, the integrals that
Mitsuba 3's roughplastic evaluates when a scene is loaded:

  T(mu) = E[(1 - F(c, eta)) G1(wt)]       light from outside, wt refracted; at 64 cosines mu = max(1e-6, i / 63)
  R     = 2 mean over mu of mu E[F(c, 1 / eta) G1(wo)]     light from inside, wo reflected above the horizon; the mean over the 64
          cosines is computed from the integral over mu, because it jumps with eta where alpha is less than their distance

where c = wi . m, and E is the mean over the visible microfacet normals m (density D(m) c / mu, normalised). The integrals are
computed in polar coordinates of m with Gauss-Legendre panels between the places where the integrand is not smooth.

Table: values at Chebyshev nodes of log(1 + 100 alpha) and of log(eta - 1), compressed by a singular value decomposition over the 65
outputs. The script prints the largest error at random alpha and eta."""
import multiprocessing
import pathlib
import sys

import numpy

N_MU, N_ALPHA, N_ETA, RANK = 64, 32, 11, 18
ALPHA = 1e-4, 1.0
ETA = 1.05, 3.0
GL = 8  # nodes of a panel
node, weight = numpy.polynomial.legendre.leggauss(GL)


def fresnel(c, eta):
    """Reflectance at a dielectric; eta = transmitted / incident."""
    ct2 = 1 - (1 - c * c) / eta**2
    ct = numpy.sqrt(numpy.maximum(0, ct2))
    s = (c - eta * ct) / (c + eta * ct)
    p = (eta * c - ct) / (eta * c + ct)
    return numpy.where(ct2 > 0, (s * s + p * p) / 2, 1)


def g1(cosine, alpha, is_ggx):
    c2 = cosine * cosine
    with numpy.errstate(divide="ignore", invalid="ignore"):
        t2 = alpha**2 * (1 - c2) / c2
        if is_ggx:
            return numpy.where(c2 > 0, 2 / (1 + numpy.sqrt(1 + t2)), 0)
        a = 1 / numpy.sqrt(t2)
        return numpy.where(a >= 1.6, 1, numpy.nan_to_num((3.535 * a + 2.181 * a * a) / (1 + 2.276 * a + 2.577 * a * a), nan=1))


def density(theta, alpha, is_ggx):
    """D(m) sin(theta_m)."""
    t2, c = (numpy.tan(theta) / alpha)**2, numpy.cos(theta)
    d = 1 / (1 + t2)**2 if is_ggx else numpy.exp(-t2)
    return d / (numpy.pi * alpha**2 * c**4) * numpy.sin(theta)


def panels(edges):
    """Nodes and weights between consecutive edges: (n_panels * GL)."""
    edges = numpy.asarray(edges)
    half = numpy.diff(edges) / 2
    return ((edges[:-1] + half)[:, None] + half[:, None] * node).ravel(), (half[:, None] * weight).ravel()


def theta_nodes(alpha, is_ggx, breaks):
    last = numpy.pi / 2 if is_ggx else min(numpy.pi / 2, numpy.arctan(7 * alpha))
    edges = {0.0, last}
    edges |= {float(numpy.arctan(alpha * 2.0**k)) for k in range(-3, 20)}
    edges |= {float(b) for b in breaks}
    return panels(sorted(e for e in edges if 0 <= e <= last))


def angle(cosine):
    """acos, for cosines beyond -1 and 1 too."""
    return numpy.arccos(numpy.clip(cosine, -1, 1))


def phi_nodes(ends, n_panels):
    """(n_theta, n) nodes of phi in n_panels panels between consecutive `ends`, (n_ends, n_theta), which do not decrease."""
    x, w = [], []
    for a, b in zip(ends[:-1], ends[1:]):
        for k in range(n_panels):
            half = (b - a) / (2 * n_panels)
            mid = a + (2 * k + 1) * half
            x.append(mid[:, None] + half[:, None] * node)
            w.append(half[:, None] * weight)
    return numpy.concatenate(x, 1), numpy.concatenate(w, 1)


def visible(mu, theta, wt, phi, wp, alpha, is_ggx):
    """c and the weights of the mean over visible normals, without normalisation."""
    s = numpy.sqrt(1 - mu * mu)
    c = mu * numpy.cos(theta)[:, None] + s * numpy.sin(theta)[:, None] * numpy.cos(phi)
    return c, (wt * density(theta, alpha, is_ggx))[:, None] * wp * numpy.maximum(0, c)


def phi_above(mu, theta, least):
    """The largest phi at which c >= least (n_theta)."""
    s = numpy.sqrt(1 - mu * mu)
    return angle((least - mu * numpy.cos(theta)) / (s * numpy.sin(theta) + 1e-300))


def transmittance(mu, alpha, etas, is_ggx):
    t = numpy.arccos(mu)
    theta, wt = theta_nodes(alpha, is_ggx, [numpy.pi / 2 - t, t])
    end = phi_above(mu, theta, 0)
    phi, wp = phi_nodes([0 * end, end / 8, end], 2)
    c, w = visible(mu, theta, wt, phi, wp, alpha, is_ggx)
    result = []
    for eta in etas:
        ct = numpy.sqrt(1 - (1 - c * c) / eta**2)
        z = mu / eta + (ct - c / eta) * numpy.cos(theta)[:, None]
        result.append((w * (1 - fresnel(c, eta)) * g1(numpy.minimum(z, 1), alpha, is_ggx)).sum() / w.sum())
    return result


def internal(mu, alpha, etas, is_ggx):
    """E[F(c, 1 / eta) G1(wo)] for each eta > 1."""
    t = numpy.arccos(mu)
    theta, wt = theta_nodes(alpha, is_ggx, [numpy.pi / 2 - t, t])
    end = phi_above(mu, theta, 0)
    total = visible(mu, theta, wt, *phi_nodes([0 * end, end / 8, end], 2), alpha, is_ggx)[1].sum()
    result = []
    for eta in etas:
        crit = numpy.arcsin(1 / eta)
        theta, wt = theta_nodes(alpha, is_ggx, [t, (numpy.pi / 2 - t) / 2, (numpy.pi / 2 + t) / 2, abs(t - crit), t + crit])
        above = phi_above(mu, theta, mu / (2 * numpy.cos(theta)))
        edge = numpy.minimum(above, phi_above(mu, theta, numpy.cos(crit)))
        # Panels that shrink towards the edge of total reflection, where F has a square root.
        ends = [0 * above, edge * 0.6, edge * 0.93, edge, edge + (above - edge) * 0.5, above]
        phi, wp = phi_nodes(ends, 1)
        c, w = visible(mu, theta, wt, phi, wp, alpha, is_ggx)
        z = 2 * c * numpy.cos(theta)[:, None] - mu
        result.append((w * fresnel(c, 1 / eta) * g1(numpy.clip(z, 1e-12, 1), alpha, is_ggx)).sum() / total)
    return numpy.array(result)


def reflectance(alpha, eta, is_ggx):
    """2 mean(mu E) over the 64 cosines: 63 / 64 of the integral, and half the values at both ends (the trapezoidal rule)."""
    value = lambda mu: internal(mu, alpha, [eta], is_ggx)[0]
    crit = numpy.sqrt(1 - 1 / eta**2)
    edges = {0.0, 0.5, 1.0} | {crit + alpha * k for k in (-4, -2, -1, 0, 1, 2, 4)}
    edges = sorted(e for e in edges if 0 <= e <= 1)
    total = 0
    for a, b in zip(edges[:-1], edges[1:]):
        x, w = numpy.polynomial.legendre.leggauss(7)
        total += sum(w * [value(m) * m for m in (a + b) / 2 + (b - a) / 2 * x]) * (b - a) / 2
    return 2 * (63 * total + value(MU[-1]) / 2) / 64


MU = numpy.maximum(1e-6, numpy.arange(N_MU) / (N_MU - 1))
MU[-1] = 1 - 1e-12


def outputs(alpha, etas, is_ggx):
    """(n_etas, 65): the 64 transmittances and the internal reflectance."""
    t = numpy.array([transmittance(mu, alpha, etas, is_ggx) for mu in MU]).T
    r = [reflectance(alpha, eta, is_ggx) for eta in etas]
    return numpy.concatenate([t, numpy.array(r)[:, None]], 1)


def chebyshev(n, low, high):
    return (low + high) / 2 + (high - low) / 2 * numpy.cos(numpy.pi * (numpy.arange(n) + 0.5) / n)


def basis(n, low, high, x):
    """Weights of the values at the Chebyshev nodes, of the polynomial through them at x."""
    y = (2 * x - low - high) / (high - low)
    k, j = numpy.arange(n), numpy.arange(n)
    poly = numpy.cos(k * numpy.arccos(numpy.clip(y, -1, 1)))
    at = numpy.cos(k[:, None] * numpy.pi * (j + 0.5) / n)
    return (numpy.where(k == 0, 1, 2) * poly) @ at / n


def scale(alpha):
    return numpy.log1p(100 * alpha)


S, E = (scale(ALPHA[0]), scale(ALPHA[1])), (float(numpy.log(ETA[0] - 1)), float(numpy.log(ETA[1] - 1)))


def make_table(is_ggx):
    alphas, etas = numpy.expm1(chebyshev(N_ALPHA, *S)) / 100, 1 + numpy.exp(chebyshev(N_ETA, *E))
    full = numpy.array([outputs(a, etas, is_ggx) for a in alphas])
    u, d, v = numpy.linalg.svd(full.reshape(-1, N_MU + 1), full_matrices=False)
    return (u[:, :RANK] * d[:RANK]).reshape(N_ALPHA, N_ETA, RANK), v[:RANK]


def evaluate(core, vectors, alpha, eta):
    return basis(N_ALPHA, *S, scale(alpha)) @ numpy.einsum("aer,e->ar", core, basis(N_ETA, *E, numpy.log(eta - 1))) @ vectors


def report(job):
    is_ggx, core, vectors = job
    rng = numpy.random.default_rng(1)
    for _ in range(4):
        alpha, eta = float(numpy.exp(rng.uniform(*numpy.log(ALPHA)))), float(rng.uniform(*ETA))
        diff = abs(evaluate(core, vectors, alpha, eta) - outputs(alpha, [eta], is_ggx)[0])
        print(f"ggx {is_ggx} alpha {alpha:.4f} eta {eta:.3f}: T {diff[:-1].max():.1e} R {diff[-1]:.1e}", file=sys.stderr)


def write_rows(file, array):
    for row in array:
        file.write(",".join(f"{x:.8g}" + ("" if set(f"{x:.8g}") & set(".e") else ".0") for x in row) + "\n")


def main():
    with multiprocessing.Pool(2) as pool:
        tables = pool.map(make_table, (False, True))
        pool.map(report, [(is_ggx, *tables[is_ggx]) for is_ggx in (False, True)])
    path = pathlib.Path(__file__).parent.parent / "presets/rough_plastic.txt"
    with open(path, "w") as f:
        f.write(f"""# Transmittances and internal reflectances of rough dielectrics, by cmake/rough_plastic.py (NumPy {numpy.__version__}), which says
# what they are: the core of Beckmann and of GGX (a row for each alpha and eta, rank), then the vectors of both (rank, 64 transmittances and the reflectance).
""")
        for i, (part, n) in enumerate(((0, RANK), (0, RANK), (1, N_MU + 1), (1, N_MU + 1))):
            f.write("\n" if i else "")
            write_rows(f, tables[i % 2][part].reshape(-1, n))


if __name__ == "__main__":
    main()
