#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Can a training fool the loss of nqm.torch? The table of doc/python.md.

usage: studies/loss_study.py [REF ...] [--steps N] [--model MODEL]

A small neural BRDF (6-21-21-3, the size of NBRDF, Sztrajman et al. 2021) is trained on each reference by nqm.torch.Loss. Printed are the
JOD by the loss at new rays, by the model "default", and by rendering (the label): they should agree. --model default trains at
the fixed directions of a model instead. NQM_DATA, the folder of rgl/, adds a measured reference. Five minutes on one core. Needs
PyTorch."""
import argparse
import os
import time

import torch

import nqm

REFS = ["sgd:nickel", "sgd:red-plastic", "sgd:gold-paint", "gltf:base_color=.9,.6,.3;metallic=1;roughness=.3"]
MEASURED = "rgl/cc_ibiza_sunset_rgb.bsdf"


class Network(torch.nn.Module):
    """Logarithms of f_r from six isotropic and reciprocal functions of the directions."""

    def __init__(self):
        super().__init__()
        self.layers = torch.nn.Sequential(torch.nn.Linear(6, 21), torch.nn.ReLU(), torch.nn.Linear(21, 21), torch.nn.ReLU(),
                                          torch.nn.Linear(21, 3))

    def forward(self, wi, wo):
        h = torch.nn.functional.normalize(wi + wo, dim=1)
        inputs = [h[:, 2], h[:, :2].norm(dim=1), (wi * h).sum(1), wi[:, 2] * wo[:, 2], wi[:, 2] + wo[:, 2],
                  (wi[:, :2] * wo[:, :2]).sum(1)]
        return self.layers(torch.stack(inputs, 1)).exp()

    def brdf(self):
        """The network as a BRDF for the library."""
        def eval_numpy(wi, wo):
            with torch.no_grad():
                return self(torch.tensor(wi, dtype=torch.float32), torch.tensor(wo, dtype=torch.float32)).double().numpy()

        return nqm.BRDF.from_function(eval_numpy, name="network")


def train(ref, steps, model):
    torch.manual_seed(1)
    network = Network()
    optimiser = torch.optim.Adam(network.parameters(), 1e-2)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, 1e-2, steps)
    loss = nqm.torch.Loss(model=model)
    if model:
        directions = nqm.Model.open(model).directions
        samples = ref.sample(directions)[0]
        wi, wo = (torch.tensor(v, dtype=torch.float32) for v in directions.vectors)
    for _ in range(steps):
        optimiser.zero_grad()
        value = loss(samples, network(wi, wo)) if model else loss(ref, network)
        value.backward()
        optimiser.step()
        schedule.step()
    return network.brdf()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("refs", nargs="*")
    parser.add_argument("--steps", type=int, default=3000)
    parser.add_argument("--model")
    options = parser.parse_args()
    torch.set_num_threads(1)
    data = os.environ.get("NQM_DATA")
    print("reference                                            loss  score  label  score-label  seconds")
    for name in options.refs or REFS + ([os.path.join(data, MEASURED)] if data else []):
        begin, ref = time.perf_counter(), nqm.BRDF.open(name)
        test = train(ref, options.steps, options.model)
        seconds = time.perf_counter() - begin
        rays = nqm.Rays(1 << 16, 1 << 20)
        loss = 10 - nqm.torch.Loss("jod")(*(torch.tensor(rays.eval(f)) for f in (ref, test)), rays).item()
        score, label = nqm.score(ref, test).jod, nqm.label(ref, test).jod
        print(f"{os.path.basename(name):52s} {loss:4.2f}  {score:5.2f}  {label:5.2f}  {score - label:11.2f}  {seconds:7.0f}", flush=True)


if __name__ == "__main__":
    main()
