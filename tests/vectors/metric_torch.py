#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""What nqm.torch.Metric in float64 says of sampled pairs: features, labels and scores, and how these change along given changes of the
test. Writes metric_torch.safetensors, and the models small_*.safetensors that it is said of, to the folder of this script.
Needs PyTorch and the library ($NQM_LIBRARY)."""
import os

import numpy as np
import torch

import nqm.torch
import store
from nqm._torch_metric import _SCALARS

N, ALONG = 150, 12  # directions: more than a stretch of sums.c, the last one incomplete; changes of the test
WAYS = np.sin(np.outer(np.arange(1, ALONG + 1), np.arange(1, 3 * N + 1)))
at = np.arange(N)
DEGREES = np.stack([80 * (at % 30 / 30) ** 2, 85 * (at // 30) / 5 + .1 * (at % 7), at * 37 % 180], 1)
rng = np.random.default_rng(49)


def make_pair(strength, largest):
    """A diffuse part and a lobe; in no direction and channel equal to the test, and the luminance is not either. Direction `largest`
    differs most and is the brightest of the test. Blue differs the other way in every fifth direction."""
    lobe = np.exp(-.05 * DEGREES[:, :1])
    ref = .02 + .03 * np.arange(3) + (1 + rng.random((N, 3))) * lobe
    way = np.where(rng.random((N, 1)) < .5, -1, 1) * np.where((at[:, None] % 5 == 0) & (np.arange(3) == 2), -1, 1)
    test = ref * np.exp(strength * way * (.3 + rng.random((N, 3))))
    test[largest] = ref[largest] * np.exp(4 * strength) + 3
    return np.stack([ref, test]).astype("f4")


def make_pairs():
    """(pairs, 2, N, 3) and (pairs, N); tests name them by their number."""
    pairs = [make_pair(*x) for x in ((.02, 40), (.2, 70), (1, 100), (.3, 70), (.4, 20), (.4, 20), (.1, 100), (.1, 100), (.002, 40), (.05, 40), (.6, 70))]
    used = np.ones((len(pairs), N), "u1")
    used[3] = (at % 3 != 0) & (DEGREES[:, 0] >= 2)  # the first zone is empty
    for i in range(0, N, 4):
        pairs[4][1, i, :1 + i % 3] = 0
    pairs[5][0] = pairs[5][1]
    for pair, factor in ((pairs[6], 1.01), (pairs[7], .99)):  # a second direction attains the maxima nearly
        pair[0, 10], pair[1, 10] = pair[0, 100], pair[1, 100] * np.float32(factor)
    used[10, ::13] = 0
    return np.stack(pairs), used


def make_transport(n_points, n_scenes, peak):
    """The matrix (N, 3 n_points) and points of make_transport() of tests/support/recorded.c."""
    unit = store.units(n_points + n_scenes)
    light = np.array([2000 / N * next(unit) if next(unit) < .3 else 0 for _ in range(3 * N * n_points)], "f4")
    points = []
    for s in range(n_scenes):
        share = np.array([.1 + next(unit) for _ in range(n_points * s // n_scenes, n_points * (s + 1) // n_scenes)])
        points += [(x, s, peak * (s + 1)) for x in share / share.sum()]
    return light.reshape(N, -1), np.array(points)


def network(sizes):
    tensors, last = {}, f"layers.{len(sizes) - 2}."
    for i, (n_in, n) in enumerate(zip(sizes, sizes[1:])):
        tensors[f"layers.{i}.weight"] = rng.normal(0, n_in**-.5, (n, n_in))
        tensors[f"layers.{i}.bias"] = rng.normal(0, 1, n)
        if i + 2 < len(sizes):
            tensors.update({f"layers.{i}.norm.weight": rng.normal(1, .2, n), f"layers.{i}.norm.bias": rng.normal(0, .2, n)})
    return {name: x.astype("f2" if np.ndim(x) == 2 and not name.startswith(last) else "f4") for name, x in tensors.items()}


def write_model(name, tensors, transport=None, target="log_delta_e", layout="ref_diff_absdiff", degrees=DEGREES, **metadata):
    whole = {**tensors, "directions_deg": degrees, "whitening.mean": np.array([.4, .45, .5], "f4"), "whitening.std": np.full(3, .3, "f4"),
             "difference_scale": np.array([3.]), "jod_curve": np.array([-14.11196939758611, -0.47364347065458806, -0.21479944748134167])}
    whole.setdefault("target", np.array([0, 1, -1, 1.]))
    if transport:
        whole.update({"transport": transport[0], "transport.points": transport[1]})
    if transport or "label_parts" in tensors:
        whole.setdefault("label_parts", np.tile([0, 1, -1, 1.], (5, 1)))
    texts = dict(format="nqm-model", schema="1", id=name, recipe="paper", layout=layout, target=target, licence="MIT", card="For tests only.",
                 training="{}", manifest_sha256="")
    store.safetensors(f"small_{name}.safetensors", whole, {**texts, **metadata, "sha256": "0" * 64})


def metric_of(name, of="jod"):
    return nqm.torch.Metric(os.path.join(store.HERE, f"small_{name}.safetensors"), of=of, dtype=torch.float64)


def estimator(transport, degrees=DEGREES):
    """A metric without a network."""
    write_model("temporary", {}, transport, degrees=degrees)
    try:
        return metric_of("temporary")
    finally:
        os.remove(os.path.join(store.HERE, "small_temporary.safetensors"))


def record(function, ref, test, used, ways):
    """The values of function(ref, test, used), (k), and what they change by along the ways, (k, ALONG); where the test is 0, by no change."""
    f, g, u = [torch.tensor(x, dtype=torch.float64) for x in (ref, test, used)]
    values = function(f, g.requires_grad_(), u)
    slopes = [torch.autograd.grad(value, g, retain_graph=True)[0].numpy().ravel() @ ways for value in values]
    return values.detach().numpy(), slopes


def members(metric):
    """Delta-E, shift, contrast and structure of the label, and a sum of them."""
    def label(f, g, u):
        e = metric._estimate(f, torch.where(u[:, None] > 0, g, f))
        sizes = torch.where(e > np.log(.05), e.exp(), 0 * e)  # the estimate has no smaller ones
        x = torch.cat([sizes[:1], e[1:4].sinh(), e[4:5].sinh() / 30, sizes[5:]])
        return torch.cat([x, x @ torch.tensor([[1, .5, -2, .3, 7, -1]], dtype=torch.float64).T])
    return label


def sums(out):
    """A reference of 301 directions, three stretches of which the last is short, and 16 tests that differ by noise of size 10^-(k / 2), by
    a factor, or by both."""
    n, k = 301, 16
    degrees = np.stack([75 * rng.random(n) ** 2, 75 * rng.random(n), 180 * rng.random(n)], 1)
    ref = np.exp(4 * rng.normal(size=(3 * n)) - 2)
    ref[::17] = 0
    test = np.stack([ref * (3 if i % 4 == 1 else np.exp(10.**-(i // 2) * rng.normal(size=3 * n))) for i in range(k)])
    test[:, 5] = 0
    used = (rng.random((k, n)) < .8) | (np.arange(k) % 3 == 0)[:, None]
    ref, test = ref.astype("f4"), test.astype("f4")
    metric = estimator((np.ones((n, 96), "f4"), np.stack([np.full(32, 1 / 32), np.zeros(32), np.ones(32)], 1)), degrees)
    f, g = torch.tensor(ref, dtype=torch.float64).reshape(n, 3), torch.tensor(test, dtype=torch.float64).reshape(k, n, 3)
    out.update({"sums.degrees": degrees, "sums.ref": ref, "sums.test": test, "sums.used": used.astype("u1")})
    for name, u in (("all", torch.ones(k, n, dtype=torch.float64)), ("some", torch.tensor(used, dtype=torch.float64))):
        out["sums." + name] = torch.stack(metric._scalars(f.expand_as(g), g, u), -1).numpy()


def main():
    pairs, used = make_pairs()
    out = {"degrees": DEGREES, "pairs": pairs, "used": used}

    def keep(name, recorded):
        values, slopes = zip(*recorded)
        out.update({name: np.stack(values), name + ".slopes": np.stack(slopes)})

    metric = estimator(make_transport(64, 2, 1500))
    keep("features", [record(lambda f, g, u: torch.stack(metric._scalars(f, g, u)), *pairs[i], used[i], WAYS.T) for i in range(8)])
    cases = [(8, 128, 1, 1e5), (1, 128, 1, 1e5), (2, 128, 1, 1e5), (1, 32, 1, 1e5), (1, 32, 3, 1e5), (1, 160, 1, 1e5), (1, 160, 7, 1e5), (1, 288, 2, 1e5),
             (1, 64, 2, 300), (3, 96, 2, 1e5), (5, 64, 2, 1e5)]
    out["labels.cases"] = np.array(cases, "f8")
    nearly = pairs.astype("f8")
    nearly[5, 1] *= 1 + 1e-9  # at equal pairs asinh() of _torch_metric.py has no derivative
    keep("labels", [record(members(estimator(make_transport(*case))), *nearly[i], used[i], WAYS.T) for i, *case in cases])
    sums(out)

    n_scalars = len(_SCALARS)
    names = ",".join(_SCALARS)
    scalars = torch.stack([*metric._scalars(*[torch.tensor(x, dtype=torch.float64) for x in (*pairs[1], used[1])]), *torch.zeros(6)]).numpy()
    number = np.arange(n_scalars)
    whitening = {"scalars.mean": (scalars - .3 * (number % 7 - 3.) - 20 * (number % 11 == 5)).astype("f4"),  # some are out of range
                 "scalars.std": (1 + .1 * (number % 5)).astype("f4"), "scalars.scale": np.array([.8])}
    correction = np.array([.1, .5, -1.2, 1])
    write_model("paper", {**network([6 * N, 24, 10, 1]), "target": np.array([5, 2, -2, 2.2])}, target="jod", layout="ref_test")
    write_model("scalars", {**network([9 * N + n_scalars, 24, 10, 1]), **whitening, "target": correction}, scalars=names)
    whole = {**network([9 * N + n_scalars, 24, 10, 6]), **whitening, "target": correction, "label_parts": np.tile(correction, (5, 1))}
    write_model("all", whole, scalars=names)
    write_model("with_transport", whole, make_transport(64, 2, 1500), scalars=names)
    for kind in ("paper", "scalars", "all", "transport"):
        for of in ("jod", "delta_e")[:1 if kind == "paper" else 2]:
            m = metric if kind == "transport" else metric_of("with_transport" if kind == "all" else kind, of)
            m.of = of
            keep(f"{kind}.{of}", [record(lambda f, g, u: m(f, g, u)[None], *pairs[i], used[i], (WAYS * (pairs[i][1].ravel() > 0)).T) for i in (9, 10, 4)])
    os.remove(os.path.join(store.HERE, "small_with_transport.safetensors"))
    store.safetensors("metric_torch.safetensors", out, {"made_by": store.made_by("metric_torch.py", "PyTorch " + torch.__version__), "features": names})


if __name__ == "__main__":
    main()
