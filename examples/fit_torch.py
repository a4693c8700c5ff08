#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Fit a GGX model and a small network to a BRDF with PyTorch, so that they look like it. The GGX has few parameters: its Delta-E at the
metric's directions is minimised with L-BFGS. A network would learn fixed directions by heart: it is trained by the loss at fresh
directions, and judged by the metric and by a label.

usage: fit_torch.py [BRDF] [STEPS]      a BRDF argument, isotropic (sgd:nickel); steps of the network's training (600)"""
import sys

import numpy as np
import torch

import nqm


def ggx(parameters, wi, wo):
    """f_r of nqm's model ggx; parameters: logarithms of kd and ks (R, G, B) and alpha, and the logit of f0."""
    kd, ks, alpha = parameters[:3].exp(), parameters[3:6].exp(), parameters[6].exp()
    h = torch.nn.functional.normalize(wi + wo, dim=1)
    cos_h2 = h[:, 2].clamp(max=1) ** 2

    def visibility(cosine):
        return 1 / (cosine + torch.sqrt(cosine**2 + alpha**2 * (1 - cosine**2)))

    density = alpha**2 / (np.pi * (cos_h2 * (alpha**2 - 1) + 1) ** 2)
    f0 = torch.sigmoid(parameters[7])
    fresnel = f0 + (1 - f0) * (1 - (wi * h).sum(1)) ** 5
    lobe = density * fresnel * visibility(wi[:, 2]) * visibility(wo[:, 2])
    return kd / np.pi + ks * lobe[:, None]


def spec(parameters):
    kd, ks = [",".join("%.6g" % x for x in parameters[i:i + 3].exp()) for i in (0, 3)]
    return "ggx:kd=%s;ks=%s;alpha=%.6g;f0=%.6g" % (kd, ks, parameters[6].exp(), torch.sigmoid(parameters[7]))


def fit_ggx(ref):
    """The spec of a GGX model that is like the samples of a reference, and its JOD."""
    distance, jod = [nqm.torch.Metric(of=of, dtype=torch.float64) for of in ("delta_e", "jod")]
    best = None
    for alpha in (.02, .1, .4):  # from several widths, because the descent ends in the nearest minimum
        level = ref.median(0).values.clamp(min=1e-3)
        parameters = torch.cat([(level * np.pi).log(), torch.zeros(3), torch.tensor([np.log(alpha), 0.])]).double().requires_grad_()
        optimiser = torch.optim.LBFGS([parameters], max_iter=60, line_search_fn="strong_wolfe")

        def closure():
            optimiser.zero_grad()
            value = distance(ref, ggx(parameters, distance.wi, distance.wo)).log()
            value.backward()
            return value

        optimiser.step(closure)
        value = closure().item()
        if best is None or value < best[0]:
            best = value, parameters.detach()
    return spec(best[1]), jod(ref, ggx(best[1], jod.wi, jod.wo)).item()


class Network(torch.nn.Module):
    """log f_r of the angles of half and difference vector."""

    def __init__(self):
        super().__init__()
        self.layers = torch.nn.Sequential(torch.nn.Linear(6, 32), torch.nn.GELU(), torch.nn.Linear(32, 32), torch.nn.GELU(),
                                          torch.nn.Linear(32, 3))

    def forward(self, wi, wo):
        h = torch.nn.functional.normalize(wi + wo, dim=1)
        sine = h[:, :2].norm(dim=1)
        features = [torch.log(sine + .003), sine, h[:, 2], (wi * h).sum(1), wi[:, 2] * wo[:, 2], wi[:, 2] + wo[:, 2]]
        return (self.layers(torch.stack(features, 1)) - 2).clamp(max=12).exp()


def train_network(ref, samples, steps):
    network, metric = Network(), nqm.torch.Metric()
    loss, optimiser = nqm.torch.Loss(), torch.optim.Adam(network.parameters(), 1e-2)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, 1e-2, steps)
    for step in range(steps):
        optimiser.zero_grad()
        loss(ref, network).backward()
        optimiser.step()
        schedule.step()
        if (step + 1) % max(1, steps // 4) == 0:
            with torch.no_grad():
                print("  step %4d: %.2f JOD" % (step + 1, metric(samples, network(metric.wi, metric.wo))))
    return network


def main():
    torch.manual_seed(1)
    ref = nqm.BRDF.open(sys.argv[1] if len(sys.argv) > 1 else "sgd:nickel")
    samples = torch.tensor(ref.sample(nqm.Model.open().directions)[0])
    text, jod = fit_ggx(samples.double())
    print("GGX: %.2f JOD; nqm score: %s\n  %s" % (jod, nqm.score(ref, text), text))
    print("network:")
    network = train_network(ref, samples, int(sys.argv[2]) if len(sys.argv) > 2 else 600)

    def test(wi, wo):
        with torch.no_grad():
            return network(torch.tensor(wi, dtype=torch.float32), torch.tensor(wo, dtype=torch.float32)).double().numpy()

    print("  score %s, label %.2f JOD" % (nqm.score(ref, test), nqm.label(ref, test).jod))


if __name__ == "__main__":
    main()
