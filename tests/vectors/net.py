#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Test vectors of the network and its training from PyTorch: writes net.safetensors to the folder of this script.

A reduced MLP (30-16-11-8-1: LayerNorm, erf GELU, dropout) with random parameters; one forward pass, every gradient and ten
Adam steps, without dropout, with given masks, and with the first LayerNorm excluded from the optimiser; a learning-rate
schedule; the parameter count of the paper's network. PyTorch computes in float64 from values that float32 represents
exactly, so that differences are nqm's rounding only.
"""
import numpy as np
import torch

import store

SIZES = [30, 16, 11, 8, 1]
BATCH, STEPS, DROPOUT = 12, 10, 0.2
LO, HI = -2.5, 1.25
LR_FIRST, LR_DEEPER, WEIGHT_DECAY = 1e-3, 1e-2, 1e-2

torch.manual_seed(20250)
torch.set_default_dtype(torch.float64)


def representable(tensor):
    return tensor.float().double()


class Mlp(torch.nn.Module):
    def __init__(self, sizes):
        super().__init__()
        pairs = list(zip(sizes, sizes[1:]))
        self.linear = torch.nn.ModuleList(torch.nn.Linear(i, o) for i, o in pairs)
        self.norm = torch.nn.ModuleList(torch.nn.LayerNorm(o) for _, o in pairs[:-1])

    def forward(self, x, masks=None):
        return self.outputs(x, masks)[:, 0]

    def outputs(self, x, masks=None):
        for layer, (linear, norm) in enumerate(zip(self.linear, self.norm)):
            x = torch.nn.functional.gelu(norm(linear(x)))
            if masks is not None:  # torch.nn.Dropout with a given mask
                x = x * masks[layer] / (1 - DROPOUT)
        return self.linear[-1](x)

    def named(self):
        for layer, linear in enumerate(self.linear):
            yield f"layers.{layer}.weight", linear.weight
            yield f"layers.{layer}.bias", linear.bias
            if layer < len(self.norm):
                yield f"layers.{layer}.norm.weight", self.norm[layer].weight
                yield f"layers.{layer}.norm.bias", self.norm[layer].bias


def loss_of(z, target):
    prediction = LO + (HI - LO) * torch.sigmoid(z)
    return torch.log(torch.cosh(prediction - target)).mean()


def groups_of(net, with_first_norm=True):
    first = [net.linear[0].weight, net.linear[0].bias]
    deeper = [p for _, p in net.named() if not any(p is q for q in first)]
    if not with_first_norm:
        deeper = [p for p in deeper if p is not net.norm[0].weight and p is not net.norm[0].bias]
    return [{"params": first, "lr": LR_FIRST}, {"params": deeper, "lr": LR_DEEPER}]


net = Mlp(SIZES)
with torch.no_grad():
    for _, p in net.named():
        p.copy_(representable(p + 0.2 * torch.randn_like(p)))
start = {name: p.detach().clone() for name, p in net.named()}
x = representable(torch.randn(BATCH, SIZES[0]))
target = representable(torch.randn(BATCH))
masks = [[(torch.rand(BATCH, n) >= DROPOUT).double() for n in SIZES[1:-1]] for _ in range(STEPS)]

out = {"x": x.float(), "target": target.float()}
out.update({f"start.{name}": p.float() for name, p in start.items()})
for layer in range(len(SIZES) - 2):
    out[f"masks.{layer}"] = torch.stack([m[layer] for m in masks]).to(torch.uint8)

for case, given in (("plain", None), ("masked", masks[0])):
    inputs = x.clone().requires_grad_(True)
    net.zero_grad()
    z = net(inputs, given)
    loss = loss_of(z, target)
    loss.backward()
    out[f"{case}.z"] = z
    out[f"{case}.loss"] = loss.reshape(1)
    out[f"{case}.dx"] = inputs.grad
    out.update({f"{case}.grad.{name}": p.grad.clone() for name, p in net.named()})

for case, given, first_norm in (("plain", None, True), ("masked", masks, True), ("frozen", None, False)):
    with torch.no_grad():
        for name, p in net.named():
            p.copy_(start[name])
    adam = torch.optim.Adam(groups_of(net, first_norm), weight_decay=WEIGHT_DECAY)
    losses = []
    for step in range(STEPS):
        adam.zero_grad()
        loss = loss_of(net(x, given[step] if given else None), target)
        loss.backward()
        adam.step()
        losses.append(loss.detach())
    out[f"{case}.adam.losses"] = torch.stack(losses)
    out.update({f"{case}.adam.{name}": p.detach().clone() for name, p in net.named()})

group = torch.optim.SGD([{"params": [torch.zeros(1)], "lr": 1e-4}, {"params": [torch.zeros(1)], "lr": 1e-3}], lr=1)
plateau = torch.optim.lr_scheduler.ReduceLROnPlateau(group, factor=0.1, patience=3)
rng = np.random.default_rng(7)
losses = np.concatenate([1 / np.arange(1, 12) + 0.01 * rng.standard_normal(11),
                         0.1 * (1 - 0.99e-4 * np.arange(8)),  # each step is within the threshold, the sum is not
                         0.09 + 0.01 * rng.standard_normal(61)])
rates = []
for value in losses:
    plateau.step(value)
    rates.append([g["lr"] for g in group.param_groups])
out["plateau.losses"] = torch.tensor(losses)
out["plateau.rates"] = torch.tensor(rates)
out["paper.parameters"] = torch.tensor([sum(p.numel() for p in Mlp([3000, 1024, 716, 501, 1]).parameters())])



# ---- networks of tests/support/random_network.c

def filled(unit, n, span):
    return np.array([(2 * next(unit) - 1) * span for _ in range(n)], "f4")


def random_network(sizes, seed, is_half=False):
    """make_random_params(); is_half: hidden weights rounded to binary16."""
    unit, net = store.units(seed), Mlp(sizes)
    with torch.no_grad():
        for layer, (linear, n_in, n) in enumerate(zip(net.linear, sizes, sizes[1:])):
            weight = filled(unit, n_in * n, (3 / n_in)**.5).reshape(n, n_in)
            is_hidden = layer + 2 < len(sizes)
            linear.weight.copy_(torch.tensor(weight.astype("f2") if is_half and is_hidden else weight))
            linear.bias.copy_(torch.tensor(filled(unit, n, 1.5)))
            if is_hidden:
                net.norm[layer].weight.copy_(torch.tensor(filled(unit, n, .4) + np.float32(1)))
                net.norm[layer].bias.copy_(torch.tensor(filled(unit, n, .4)))
    return net


def shared(rows, n_ref, is_new):
    """Rows of one reference as those of the row before it."""
    for i in range(len(rows)):
        if not is_new(i):
            rows[i, :n_ref] = rows[i - 1, :n_ref]
    return torch.tensor(rows, dtype=torch.float64)


rows = shared(filled(store.units(11), 199 * 413, 1.7).reshape(199, 413)[:, :410], 135, lambda i: i % 15 in (0, 1, 3, 6, 10))
with torch.no_grad():
    out["inference.z"] = random_network([410, 100, 64, 33, 1], 11).outputs(rows)[:, 0]
for i, sizes in enumerate(([75, 100, 64, 33, 6], [75, 40, 1], [75, 7, 70, 1])):
    unit = store.units(7)
    rows = shared(filled(unit, 37 * 75, 1.7).reshape(37, 75), 40, lambda i: i % 3 == 0)[:3].requires_grad_()
    slopes = torch.tensor(filled(unit, 37 * sizes[-1], 1.7).reshape(37, -1)[:3])
    for is_half in (False, True):
        z = random_network(sizes, 5, is_half).outputs(rows)
        out[f"inputs.{i}.{int(is_half)}.z"] = z
        out[f"inputs.{i}.{int(is_half)}.dx"], = torch.autograd.grad((z * slopes).sum(), rows)

store.safetensors("net.safetensors", {name: tensor.detach().numpy() for name, tensor in out.items()},
                  {"made_by": store.made_by("net.py", "PyTorch " + torch.__version__)})
