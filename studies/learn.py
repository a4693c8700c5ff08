#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Learns what encodings of `nqm fit` need from BRDFs: the dictionary of sparse-* or the hypernetwork of hyper-* (doc/encodings.md), as an
encoder file (doc/files.md) that lists its references. models/make.sh makes those that CMake embeds, from training materials only. Needs
NumPy; the hypernetwork, of 16,000 steps, also OpenBLAS (Debian's libopenblas0), or it takes hours.

usage: PYTHONPATH=python studies/learn.py sparse|hyper BRDF... -o FILE [--steps N] [--seed N]
"""
import argparse
import hashlib
import json
import os
import sys
from pathlib import Path

import numpy as np

import nqm


def progress(stage, done, total):
    if sys.stderr.isatty():
        print(f"\r{stage} {done} of {total}", end="\n" if done == total else "", file=sys.stderr, flush=True)


def write(path, kind, names, seed, steps, tensors):
    """Write an encoder file with float32 tensors (a dict)."""
    zeros, data = "0" * 64, b""  # the checksum is that of the whole file with this one
    header = {"__metadata__": {"format": "nqm-encoder", "schema": "1", "kind": kind, "tool": f"nqm {nqm.__version__}", "seed": str(seed),
                               "steps": str(steps), "references": json.dumps(names, separators=(",", ":")), "sha256": zeros}}
    for name, array in tensors.items():
        if not np.isfinite(array).all():
            sys.exit(f"learn.py: the learning diverged: {name} has a value that is not finite; try another --seed")
        begin, data = len(data), data + array.astype("<f4").tobytes()
        header[name] = {"dtype": "F32", "shape": array.shape, "data_offsets": (begin, len(data))}
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-(8 + len(text)) % 64)  # the data begin at a multiple of 64 bytes
    whole = len(text).to_bytes(8, "little") + text + data
    part = Path(f"{path}.{os.getpid()}")
    try:
        part.write_bytes(whole.replace(zeros.encode(), hashlib.sha256(whole).hexdigest().encode(), 1))
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


# ---- the dictionary -------------------------------------------------------------------------------------------------------------------------

SHAPE, BASIS = (90, 24, 12), (40, 16, 7)  # nodes of a table along theta_h, theta_d, phi_d, and vectors of the bases
N_ATOMS, N_CODE = 128, 8  # atoms of the dictionary, and of a code while learning: few, so that each atom stays a typical material
EPS = 1e-3  # of the mapping (Nielsen et al. 2015)
COLOUR = np.array([[1, 1, 1], [1, 0, -1], [-1, 2, -1]]) / np.sqrt([[3], [2], [6]])  # grey, red - blue, green - magenta


def sample(name, cosine):
    """c f_r of a BRDF at the nodes: (3, *SHAPE) float32; 0 below the horizon, NaN where there is no value."""
    rgb = np.moveaxis(nqm.BRDF.open(name).to_table(*SHAPE).astype(float), -1, 0)
    n_valid = np.count_nonzero(~np.isnan(rgb[0]) & (cosine > 0))
    if n_valid < 100:
        sys.exit(f"learn.py: {name}: values at only {n_valid} of {np.count_nonzero(cosine)} directions; codes need 100")
    return np.where(cosine > 0, cosine * rgb, 0).astype(np.float32)


def fill(table, cosine, axis):
    """Give cells without a value f_r of the previous node along an axis, else of the next one; in place."""
    cells, c = np.moveaxis(table, axis + 1, 0), np.moveaxis(cosine, axis, 0)
    n = len(cells)
    for k, near in [(k, k - 1) for k in range(1, n)] + [(k, k + 1) for k in range(n - 2, -1, -1)]:
        ratio = np.divide(c[k], c[near], out=np.full(c[k].shape, np.nan), where=c[near] > 0)
        cells[k] = np.where(np.isnan(cells[k]), cells[near] * ratio, cells[k])


def mapped(table, typical, cosine):
    """log((c f_r + EPS) / (typical + EPS)) as brightness and two colours (3, *SHAPE)."""
    fill(table, cosine, 0)
    fill(table, cosine, 1)
    log = np.nan_to_num(np.log((table.astype(float) + EPS) / (typical.astype(float) + EPS)))
    return np.where(cosine > 0, np.tensordot(COLOUR, log, 1), 0).astype(np.float32)


def basis(tables, axis, n):
    """The n orthonormal directions in which the tables vary most along an axis, as rows."""
    rows = np.moveaxis(tables, axis + 1, 0).reshape(SHAPE[axis], -1).astype(float)
    return np.linalg.eigh(rows @ rows.T)[1].T[::-1][:n].astype(np.float32)


def signals_of(names):
    """All tensors of the file but the atoms, and the signals (3 n, product of BASIS) to be coded: the mapped channels in the bases."""
    wi, wo = nqm.half_diff_to_directions(nqm.table_nodes(*SHAPE))
    cosine = np.where(np.minimum(wi[..., 2], wo[..., 2]) >= 1e-6, wi[..., 2] * wo[..., 2], 0)
    tables = np.array([sample(name, cosine) for name in names])
    typical, values = np.zeros(SHAPE, np.float32), tables.reshape(-1, *SHAPE)
    has_value = ~np.isnan(values).all(axis=0)
    typical[has_value] = np.nanmedian(values[:, has_value].astype(float), axis=0)
    tables = np.concatenate([mapped(table, typical, cosine) for table in tables])
    h, d, p = bases = [basis(tables, axis, n) for axis, n in enumerate(BASIS)]
    signals = np.einsum("thdp,ih,jd,kp->tijk", tables.astype(float), h, d, p, optimize=True).reshape(len(tables), -1)
    return dict(zip(("typical", "basis.theta_h", "basis.theta_d", "basis.phi_d"), (typical.reshape(SHAPE[0], -1), *bases))), signals


def pursue(gram, correlation):
    """Coefficients (n_atoms) of a code of at most N_CODE atoms, by orthogonal matching pursuit. gram: inner products of the atoms;
    correlation: inner products of the atoms and the signal."""
    chosen, code, left, is_open = [], np.zeros(len(gram)), correlation, np.ones(len(gram))
    while len(chosen) < N_CODE:
        match = np.abs(left) * is_open
        best = match.argmax()
        if not match[best] > 1e-10 * np.abs(correlation).max():
            break
        is_open[best] = 0
        cross = gram[chosen, best]
        if gram[best, best] - cross @ np.linalg.solve(gram[np.ix_(chosen, chosen)], cross) > 1e-8:  # linearly independent of them
            chosen.append(best)
            code[chosen] = np.linalg.solve(gram[np.ix_(chosen, chosen)], correlation[chosen])
            left = correlation - code @ gram
    return code


def ksvd(signals, first, steps):
    """Atoms (n, length) of length 1 from the signals with the indices `first`: each step codes all signals, then improves the atoms one by
    one, with their coefficients, on the residual of the others (approximate K-SVD: Rubinstein et al. 2008)."""
    atoms = signals[first] / np.linalg.norm(signals[first], axis=1)[:, None]
    for step in range(steps):
        codes = np.array([pursue(atoms @ atoms.T, correlation) for correlation in signals @ atoms.T])
        residual, is_taken = signals - codes @ atoms, np.zeros(len(signals), bool)
        for k, atom in enumerate(atoms):
            users = np.flatnonzero(codes[:, k])
            coefficient = codes[users, k]
            better = coefficient @ residual[users] + coefficient @ coefficient * atom
            if better.any():  # one step of the power method
                better /= np.linalg.norm(better)
                residual[users] += np.outer(coefficient, atom)
                residual[users] -= np.outer(residual[users] @ better, better)
                atoms[k] = better
                continue
            left = np.where(is_taken, 0, (residual**2).sum(axis=1))
            if left.any():  # an unused atom becomes the largest residual
                atoms[k] = residual[left.argmax()] / np.sqrt(left.max())
                is_taken[left.argmax()] = True
        progress("step", step + 1, steps)
    return atoms


def learn_sparse(names, seed, steps):
    tensors, signals = signals_of(names)
    length = np.linalg.norm(signals, axis=1)
    length[length <= 1e-6 * length.max()] = 0  # the colour channels of grey materials are no atoms
    n_atoms = min(N_ATOMS, np.count_nonzero(length))
    if n_atoms == 0:
        sys.exit("learn.py: the references are all equal: no atoms can be learned")
    first = np.random.default_rng(seed).choice(len(signals), n_atoms, replace=False, p=length / length.sum())
    return {**tensors, "atoms": ksvd(signals, first, steps)}


# ---- the hypernetwork -----------------------------------------------------------------------------------------------------------------------

WIDTHS = (128, 128, 192, 384, 384)  # three layers for each sample, two after the pooling; the last layer has the weights of an NBRDF
POOLED, USUAL_COUNT = 3, 200  # the first layer after the pooling; its input log(samples / USUAL_COUNT)
NBRDF = ((6, 21), (21, 21), (21, 3))  # inputs and outputs of its layers
N_SETS, N_QUERIES, N_PLACES = 16, 512, 4096


def gelu(x):
    """Values and slopes; the error function within 1.5e-7 (Abramowitz and Stegun, 7.1.26)."""
    t = 1 / (1 + 0.2316419 * np.abs(x))
    bell = np.exp(-0.5 * x * x)
    tail = 0.5 * bell * t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))))
    below = np.where(x < 0, tail, 1 - tail)
    return x * below, below + x * bell * 0.39894228


def forward(layers, samples):
    """NBRDF weights (sets, 675) of the features (sets, n, 13) of samples, and what backward() needs."""
    x, kept = samples, []
    for l, (w, b) in enumerate(layers):
        if l == POOLED:
            count = np.full((len(x), 1), np.log(x.shape[1] / USUAL_COUNT), x.dtype)
            x = np.concatenate([x.mean(axis=1), x.max(axis=1), count], axis=1)
        y, slope = gelu(x @ w + b) if l < len(layers) - 1 else (x @ w + b, 1)
        kept.append((x, y, slope))
        x = y
    return x, kept


def backward(layers, kept, dy):
    """Gradients by the weights and biases of all layers from that by the output."""
    gradients = []
    for l in reversed(range(len(layers))):
        x, _, slope = kept[l]
        dz = dy * slope
        rows = dz.reshape(-1, dz.shape[-1])
        gradients = [x.reshape(-1, x.shape[-1]).T @ rows, rows.sum(axis=0)] + gradients
        dy = dz @ layers[l][0].T
        if l == POOLED:
            y = kept[l - 1][1]
            d_mean, d_top, _ = np.split(dy[:, None], [y.shape[2], 2 * y.shape[2]], axis=2)
            dy = d_mean / y.shape[1] + d_top * (np.arange(y.shape[1])[:, None] == y.argmax(axis=1)[:, None])
    return gradients


def nbrdf_loss(weights, inputs, cosine, goal):
    """Mean |log(1 + c f_r) - goal| of each NBRDF (sets), and its gradient by the weights (sets, 675). inputs (sets, n, 6): half and
    difference vectors; cosine (sets, n, 1): c of the light; goal (sets, n, 3) (Sztrajman et al. 2021)."""
    x, at, kept = inputs, 0, []
    for n_in, n_out in NBRDF:
        w = weights[:, at:at + n_in * n_out].reshape(-1, n_in, n_out)
        at += n_in * n_out + n_out
        kept.append((x, w))
        z = x @ w + weights[:, None, at - n_out:at]
        x = np.maximum(z, 0)
    rise = cosine * np.exp(np.clip(z, -60, 80))  # f_r = exp(z) - 1
    inside = 1 - cosine + rise
    error = np.log(inside) - goal
    d = np.sign(error) * rise / inside / goal[0].size  # the slope at z = 80 holds above it too, so that z falls
    gradient = []
    for x, w in reversed(kept):
        gradient = [(np.swapaxes(x, 1, 2) @ d).reshape(len(x), -1), d.sum(axis=1)] + gradient
        d = d @ np.swapaxes(w, 1, 2) * (x > 0)
    return np.abs(error).mean(axis=(1, 2)), np.concatenate(gradient, axis=1)


def draw_places(rng):
    """Direction pairs wi, wo (N_PLACES, 3) within 80 degrees, the first half dense about the mirror direction, the second uniform, with the
    hypernetwork's features of a place, the inputs of an NBRDF, and c of the light."""
    hd = rng.random((8 * N_PLACES, 3)) ** (2, 1, 1) * (np.pi / 2, np.pi / 2, np.pi)
    dense = np.array(nqm.half_diff_to_directions(hd))
    wide = rng.normal(size=(2, 8 * N_PLACES, 3))
    wide /= np.linalg.norm(wide, axis=-1, keepdims=True)
    # Measurements at larger angles are often extrapolated.
    near = [pair[:, (pair[..., 2] >= np.cos(np.radians(80))).all(axis=0)][:, :N_PLACES // 2] for pair in (dense, wide)]
    wi, wo = np.concatenate(near, axis=1)
    hd = nqm.directions_to_half_diff(wi, wo)
    h, d, p = hd.T
    wi, wo = nqm.half_diff_to_directions(hd)  # exchanged where hd is that of the reciprocal pair
    inputs = np.column_stack([np.sin(h), 0 * h, np.cos(h), np.sin(d) * np.cos(p), np.sin(d) * np.sin(p), np.cos(d)])
    features = np.column_stack([np.delete(inputs, 1, axis=1), 2 * np.sqrt(h / (np.pi / 2)) - 1, 2 * wi[:, 2] * wo[:, 2] - 1])
    return wi, wo, features, inputs, wi[:, 2:]


def values(name, wi, wo, rng):
    """f_r (2, n, 3) of a BRDF and of a copy with another gloss and peak; NaN: no value."""
    gloss, peak = np.exp(rng.uniform(-0.5, 0.5, 2))
    both = [nqm.BRDF.open(spec).eval_flags(wi, wo) for spec in (name, f"perturb:gloss={gloss:.3g};peak={peak:.3g};of={name}")]
    rgb = np.array([np.where(flag[:, None] < 2, rgb, np.nan) for rgb, flag in both])
    if np.isnan(rgb[..., 0]).mean(axis=1).max() > 0.25:
        sys.exit(f"learn.py: {name}: no value at more than a quarter of {len(wi)} directions")
    return rgb


def draw_example(rgb, features, inputs, cosine, n_samples, rng):
    """Features of n_samples dense places of a synthetic material - a reference or a mixture of two, with permuted and scaled channels - and
    the arrays of nbrdf_loss() at N_QUERIES places, a quarter of them dense: most of a picture shows no highlight."""
    material, other = rgb[rng.integers(len(rgb), size=2)]
    if rng.random() < 0.3:
        material = material + rng.random() * (other - material)
    if rng.random() < 0.5:
        material = material[:, rng.permutation(3)]
    if rng.random() < 0.7:
        material = material * np.exp(0.4 * rng.normal() + 0.25 * rng.normal(size=3))
    valid = np.flatnonzero(~np.isnan(material[:, 0]))
    dense, wide = np.split(valid, [np.searchsorted(valid, N_PLACES // 2)])
    at = rng.choice(dense, n_samples)
    of = np.concatenate([rng.choice(dense, N_QUERIES // 4), rng.choice(wide, N_QUERIES - N_QUERIES // 4)])
    read = np.column_stack([features[at], 0.5 * (np.log(material[at] + 1e-3) + 2), np.log1p(material[at])])
    return read, inputs[of], cosine[of], np.log1p(cosine[of] * material[of])


def initial_layers(rng):
    """He et al. 2015. The last layer has small weights, and as its bias an NBRDF with random weights."""
    random_nbrdf = np.concatenate([part for a, b in NBRDF for part in (rng.normal(0, np.sqrt(2 / a), a * b), np.zeros(b))])
    n_in = (13, *WIDTHS[:POOLED - 1], 2 * WIDTHS[POOLED - 1] + 1, *WIDTHS[POOLED:])
    layers = [(rng.normal(0, np.sqrt(2 / a), (a, b)), np.zeros(b)) for a, b in zip(n_in, (*WIDTHS, len(random_nbrdf)))]
    layers[-1] = (0.05 * layers[-1][0], random_nbrdf)
    return [(w.astype(np.float32), b.astype(np.float32)) for w, b in layers]


def learn_hyper(names, seed, steps):
    rng = np.random.default_rng(seed)
    wi, wo, *places = draw_places(rng)
    rgb = np.concatenate([values(name, wi, wo, rng) for name in names])
    layers = initial_layers(rng)
    parameters = [p for layer in layers for p in layer]
    moments = [(np.zeros_like(p), np.zeros_like(p)) for p in parameters]
    for step in range(1, steps + 1):
        n_samples = int(8 * 64 ** rng.random())
        sets = [draw_example(rgb, *places, n_samples, rng) for _ in range(N_SETS)]
        read, inputs, cosine, goal = (np.array(part, np.float32) for part in zip(*sets))
        weights, kept = forward(layers, read)
        # Relative to the brightness of the material: otherwise mirrors would dominate.
        scale = 1 / (N_SETS * (goal.mean(axis=(1, 2)) + 0.03))
        gradients = backward(layers, kept, nbrdf_loss(weights, inputs, cosine, goal)[1] * scale[:, None])
        # The norm of the gradient is at most 1: the loss of the predicted NBRDFs is not smooth.
        shorten = 1 / max(1, np.sqrt(sum((g.astype(float) ** 2).sum() for g in gradients)))
        rate = 3e-3 * min(1, step / 200) * 0.5 * (1 + np.cos(np.pi * step / steps))
        for p, (m, v), g in zip(parameters, moments, gradients):  # Adam (Kingma and Ba 2015)
            m += 0.1 * (shorten * g - m)
            v += 0.001 * ((shorten * g) ** 2 - v)
            p -= rate / (1 - 0.9**step) * m / (np.sqrt(v / (1 - 0.999**step)) + 1e-8)
        progress("step", step, steps)
    return {f"layers.{i // 2}.{'bias' if i % 2 else 'weight'}": p for i, p in enumerate(parameters)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=("sparse", "hyper"))
    parser.add_argument("brdf", nargs="+")
    parser.add_argument("-o", "--output", required=True, metavar="FILE")
    parser.add_argument("--steps", type=int, help="steps of the optimiser (40 for sparse, 16000 for hyper)")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    learn, default_steps = {"sparse": (learn_sparse, 40), "hyper": (learn_hyper, 16000)}[arguments.kind]
    use = arguments.brdf, arguments.seed, arguments.steps or default_steps
    try:
        write(arguments.output, arguments.kind, *use, learn(*use))
    except (nqm.Error, OSError) as error:
        sys.exit(f"learn.py: {error}")


if __name__ == "__main__":
    main()
