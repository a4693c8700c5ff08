#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Test vectors of NBRDF training from PyTorch: writes nbrdf_batch.csv and nbrdf_weights.csv to the folder of this
script.

A network 6-21-21-3 with random weights, a batch of directions (theta_h, theta_d, phi_d in radians) with goals
log(1 + c f_r); the loss |log(1 + c (exp(x) - 1)) - goal| of each direction, c = cos(theta_i), and the gradient of their
mean by autograd, in float64 from values that float32 represents exactly. Weights are stored layer by layer: kernel
(in, out), then bias.
"""
import pathlib
import sys

import numpy as np
import torch

N = 200
HERE = pathlib.Path(__file__).parent
torch.manual_seed(303)
torch.set_default_dtype(torch.float64)
rng = np.random.default_rng(303)


def representable(array):
    return torch.tensor(np.asarray(array, dtype=np.float32).astype(np.float64))


# Above the horizon, by a separate derivation: rotate the difference vector by theta_h about y.
angles = rng.uniform(size=(20 * N, 3)) * [np.pi / 2, np.pi / 2, np.pi]
h, d, p = angles.T
cos_i = -np.sin(h) * np.sin(d) * np.cos(p) + np.cos(h) * np.cos(d)
cos_o = np.sin(h) * np.sin(d) * np.cos(p) + np.cos(h) * np.cos(d)
above = (cos_i > 0.02) & (cos_o > 0.02)
angles, cos_i = angles[above][:N], cos_i[above][:N]
h, d, p = angles.T
x = torch.tensor(np.stack([np.sin(h), 0 * h, np.cos(h), np.sin(d) * np.cos(p), np.sin(d) * np.sin(p), np.cos(d)], axis=1))
goal = representable(np.log1p(cos_i[:, None] * rng.exponential(size=(N, 3))))
layers = [(representable(0.5 * rng.standard_normal((i, o))).requires_grad_(True),
           representable(0.3 * rng.standard_normal(o)).requires_grad_(True)) for i, o in ((6, 21), (21, 21), (21, 3))]

y = x
for index, (kernel, bias) in enumerate(layers):
    y = y @ kernel + bias
    y = torch.relu(y) if index < 2 else y
error = torch.abs(torch.log(1 + torch.tensor(cos_i)[:, None] * (torch.exp(y) - 1)) - goal)
error.mean().backward()

made_by = f"# made by tests/vectors/nbrdf.py, PyTorch {torch.__version__}, NumPy {np.__version__}, Python {sys.version.split()[0]}\n"
with open(HERE / "nbrdf_batch.csv", "w") as file:
    file.write(made_by + "theta_h,theta_d,phi_d,goal_r,goal_g,goal_b,loss\n")
    for row in np.column_stack([angles, goal.numpy(), error.mean(axis=1).detach().numpy()]):
        file.write(",".join(repr(float(v)) for v in row) + "\n")
with open(HERE / "nbrdf_weights.csv", "w") as file:
    file.write(made_by + "weight,gradient\n")
    for kernel, bias in layers:
        for tensor in (kernel, bias):
            for w, g in zip(tensor.detach().flatten().tolist(), tensor.grad.flatten().tolist()):
                file.write(f"{w!r},{g!r}\n")
