#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Time nqm.torch.Metric on a device of PyTorch next to the C library on the processor: milliseconds per pair of a score, and of a score
with its gradient, for batches that share nothing. Checks first that both agree. Prints a table in Markdown.

usage: torch_device.py [--device cuda] [--model default] [--compile] [--batches 1 16 256] [--threads N] [--seconds 2] [--cpu-time]"""
import argparse
import time

import numpy as np
import torch

import nqm


def pairs(n, model, seed=1):
    """Samples of n pairs of lobes on a Lambertian base, (n, directions, 3) each."""
    rng = np.random.default_rng(seed)
    wi, wo = nqm.Model.open(model).directions.vectors
    h = wi + wo
    cos_h = h[:, 2] / np.linalg.norm(h, axis=1)

    def brdf():
        power = 10 ** rng.uniform(.5, 3)
        return rng.uniform(0, .1, 3) + (rng.uniform(.02, .5) * (power + 2) / (2 * np.pi) * cos_h**power)[:, None]

    return [np.stack([brdf() for _ in range(n)]).astype("f4") for _ in range(2)]


def median_ms(function, wait, seconds, clock):
    """Milliseconds of a call: the median of as many as fit into the time, after two that are not counted."""
    times, end = [], time.monotonic() + seconds
    for i in range(10000):
        begin = clock()
        function()
        wait()
        if i > 1:
            times.append(clock() - begin)
        if len(times) > 2 and time.monotonic() > end:
            break
    return 1000 * float(np.median(times))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--device", default="cuda" if torch.cuda.is_available() else "cpu")
    parser.add_argument("--model", default="default")
    parser.add_argument("--compile", action="store_true")
    parser.add_argument("--batches", type=int, nargs="+", default=[1, 16, 256])
    parser.add_argument("--threads", type=int, help="of PyTorch on the processor")
    parser.add_argument("--seconds", type=float, default=2)
    parser.add_argument("--cpu-time", action="store_true", help="processor time of all threads instead of the clock: on a busy machine")
    args = parser.parse_args()
    if args.threads:
        torch.set_num_threads(args.threads)
    clock = time.process_time if args.cpu_time else time.perf_counter
    wait = torch.cuda.synchronize if args.device.startswith("cuda") else lambda: None
    metric = nqm.torch.Metric(args.model, device=args.device)
    scorer = nqm.Scorer(args.model, metrics=False)
    run = torch.compile(metric) if args.compile else metric
    name = torch.cuda.get_device_name() if args.device.startswith("cuda") else args.device
    print("PyTorch %s on %s, %d threads; %s\n" % (torch.__version__, name, torch.get_num_threads(), nqm.build_info()))
    print("| pairs a call | score, C | score, PyTorch | with gradient, C | with gradient, PyTorch |\n|---|---|---|---|---|")
    for n in args.batches:
        ref, test = pairs(n, args.model)
        a, b = [torch.tensor(x, device=args.device) for x in (ref, test)]

        def score():
            with torch.no_grad():
                return run(a, b)

        def gradient():
            leaf = b.clone().requires_grad_()
            run(a, leaf).sum().backward()
            return leaf.grad

        difference = np.max(np.abs(score().cpu().numpy() - scorer.score_grad(ref, test)[0]))
        if not difference < 1e-4:
            raise SystemExit("the scores of the device differ from those of the library by %g JOD" % difference)
        functions = ((lambda: scorer.score_samples(ref, test), lambda: None), (score, wait),
                     (lambda: scorer.score_grad(ref, test), lambda: None), (gradient, wait))
        print("| %d | %s |" % (n, " | ".join("%.3f" % (median_ms(f, w, args.seconds, clock) / n) for f, w in functions)), flush=True)
    print("\nmilliseconds per pair; largest difference of the scores %.1e JOD" % difference)


if __name__ == "__main__":
    main()
