# SPDX-License-Identifier: MIT
"""PyTorch for bench/peers.py: answers each line of standard input with a line of JSON.

check: ends with a message if PyTorch uses the reference BLAS, as do the others
score MODEL THREADS INPUTS: "check N" and "time BATCH ROUNDS SECONDS" as in bench/onnx_worker.mjs, for each
implementation of the network
train THREADS WAY: "epoch" trains one epoch of the paper's run and answers with its time in seconds; "memory" answers
with the peak memory in MB
"""
import json
import os
import re
import resource
import sys
import time
import warnings

import numpy as np
import torch
from torch import nn

warnings.filterwarnings("ignore")


def blas_libraries():
    """The BLAS libraries that this process has loaded, by their paths; none if PyTorch contains its own."""
    torch.ones(2, 2) @ torch.ones(2, 2)
    with open("/proc/self/maps", encoding="utf-8") as maps:
        return sorted({line.split()[-1] for line in maps if "blas" in os.path.basename(line)})


def check_blas():
    """End with a message on the reference BLAS, which is ten times and more slower than OpenBLAS: that would be no comparison."""
    for path in blas_libraries():
        if re.match(r"lib(c?blas|gslcblas)\.so", os.path.basename(path)) and not re.search("openblas|blis|atlas|mkl", path):
            sys.exit(f"peers: PyTorch {torch.__version__} uses the reference BLAS ({path}), so that its times would be no comparison: "
                     "install libopenblas0 (Debian), which replaces it")


def version():
    """Versions of PyTorch and of its BLAS."""
    return " with ".join([torch.__version__] + [os.path.basename(path) for path in blas_libraries()])


class Norm(nn.LayerNorm):
    """LayerNorm in float, also under autocast: this version of PyTorch cannot mix bfloat16 with float parameters."""

    def forward(self, x):
        return super().forward(x.to(self.weight.dtype))


def network(sizes, dropout):
    layers = []
    for n_in, n_out in zip(sizes[:-2], sizes[1:-1]):
        layers += [nn.Linear(n_in, n_out), Norm(n_out), nn.GELU(), nn.Dropout(dropout)]
    return nn.Sequential(*layers, nn.Linear(sizes[-2], sizes[-1]))


# ---- scoring ------------------------------------------------------------------------------------------------------------


def with_weights(model):
    net = network(model.sizes, 0.2).eval()
    linears = [m for m in net if isinstance(m, nn.Linear)]
    norms = [m for m in net if isinstance(m, Norm)]
    for i, m in enumerate(linears):
        m.weight.data, m.bias.data = torch.tensor(model.weight(i)), torch.tensor(model.bias(i))
    for i, m in enumerate(norms):
        m.weight.data, m.bias.data = (torch.tensor(a) for a in model.norm(i))
    return net


def scoring_ways(model, example):
    """Map of name to function of x (n, n_inputs). Implementations that this build of PyTorch cannot run are left
    out."""
    from torch.utils import mkldnn

    def frozen(net, x):
        return torch.jit.optimize_for_inference(torch.jit.freeze(torch.jit.trace(net, x)))

    makers = {
        "f32 eager": lambda: with_weights(model),
        "f32 frozen": lambda: frozen(with_weights(model), example),
        "f32 mkldnn": lambda: mkldnn.to_mkldnn(with_weights(model)),
    }
    ways = {}
    for name, make in makers.items():
        try:
            way = make()
            way(example)
            ways[name] = way
        except (RuntimeError, NotImplementedError) as fault:
            print(f"torch: {name}: {str(fault).splitlines()[0]}", file=sys.stderr)
    return ways


def clock():
    """Seconds: of the clock, or with NQM_PEERS_CPU the processor time of all threads / threads, which excludes other programs."""
    return time.process_time() / torch.get_num_threads() if "NQM_PEERS_CPU" in os.environ else time.perf_counter()


def time_calls(way, batches, rounds, seconds):
    way(batches[0])
    out = []
    for _ in range(rounds):
        begin, n = clock(), 0
        while True:
            way(batches[n % 3])
            n += 1
            if clock() - begin >= seconds:
                break
        out.append((clock() - begin) / n)
    return out


def serve_scores(path, inputs):
    from network import Model

    model = Model(path)
    x = torch.from_numpy(np.fromfile(inputs, np.float32).reshape(-1, model.sizes[0]))
    with torch.inference_mode():
        ways = scoring_ways(model, x[:4])
        print(json.dumps({"version": version()}), flush=True)
        for line in sys.stdin:
            word, *numbers = line.split()
            if word == "check":
                answer = {name: way(x[: int(numbers[0])]).reshape(-1).tolist() for name, way in ways.items()}
            else:
                batch, rounds, seconds = int(numbers[0]), int(numbers[1]), float(numbers[2])
                batches = [x[i : i + batch] for i in range(3)]
                answer = {name: time_calls(way, batches, rounds, seconds) for name, way in ways.items()}
            print(json.dumps(answer), flush=True)


# ---- training -----------------------------------------------------------------------------------------------------------

N_TRAIN, N_VALIDATION, BATCH = 5344, 668, 512


class Training:
    """The paper's training run (section 3.2) on random data of the paper's sizes. Ways: "authors", simple code with
    data loaders; "tuned", batches indexed from one tensor and the foreach form of Adam; "bf16", the same under
    autocast."""

    def __init__(self, way):
        torch.manual_seed(1)
        self.way = way
        self.net = network([3000, 1024, 716, 501, 1], 0.2)
        first, deeper = self.net[0].parameters(), (p for m in list(self.net)[1:] for p in m.parameters())
        groups = [{"params": first, "lr": 1e-4}, {"params": deeper, "lr": 1e-3}]
        self.adam = torch.optim.Adam(groups, weight_decay=1e-4, foreach=way != "authors")
        self.schedule = torch.optim.lr_scheduler.ReduceLROnPlateau(self.adam, factor=0.1, patience=5)
        x, y = torch.randn(N_TRAIN + N_VALIDATION, 3000), torch.randn(N_TRAIN + N_VALIDATION, 1)
        self.train, self.validation = (x[:N_TRAIN], y[:N_TRAIN]), (x[N_TRAIN:], y[N_TRAIN:])
        if way == "authors":
            data = torch.utils.data
            self.loader = data.DataLoader(data.TensorDataset(*self.train), batch_size=BATCH, shuffle=True)
            self.validation_loader = data.DataLoader(data.TensorDataset(*self.validation), batch_size=BATCH)

    def batches(self, training):
        if self.way == "authors":
            yield from self.loader if training else self.validation_loader
            return
        x, y = self.train if training else self.validation
        order = torch.randperm(len(x)) if training else None
        for first in range(0, len(x), BATCH):
            if training:
                index = order[first : first + BATCH]
                yield x[index], y[index]
            else:
                yield x[first : first + BATCH], y[first : first + BATCH]

    def loss(self, x, y):
        with torch.autocast("cpu", torch.bfloat16, enabled=self.way == "bf16"):
            z = self.net(x)
        d = -1 + 3 * torch.sigmoid(z.float()) - y
        if self.way == "authors":
            return torch.log(torch.cosh(d)).mean()
        return (d.abs() + torch.nn.functional.softplus(-2 * d.abs())).mean() - np.log(2)

    def epoch(self):
        self.net.train()
        for x, y in self.batches(True):
            self.adam.zero_grad(set_to_none=True)
            self.loss(x, y).backward()
            self.adam.step()
        self.net.eval()
        with torch.no_grad():
            total = sum(self.loss(x, y).item() * len(x) for x, y in self.batches(False))
        self.schedule.step(total / N_VALIDATION)


def serve_training(way):
    training = Training(way)
    training.epoch()  # the first call is not timed because it allocates
    print(json.dumps({"version": version()}), flush=True)
    for line in sys.stdin:
        if line.strip() == "memory":
            answer = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024e-6
        else:
            begin = clock()
            training.epoch()
            answer = clock() - begin
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    check_blas()
    if sys.argv[1] != "check":
        torch.set_num_threads(int(sys.argv[2]))
    if sys.argv[1] == "score":
        serve_scores(sys.argv[3], sys.argv[4])
    elif sys.argv[1] == "train":
        serve_training(sys.argv[3])
