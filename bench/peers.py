# SPDX-License-Identifier: MIT
"""Compares nqm with PyTorch and ONNX Runtime on the same weights and inputs. The timings alternate between the
programs, so that other load on the machine disturbs all of them alike. ./dev bench peers runs it. Prints Markdown
tables; --json FILE stores all values.

Before timing, it checks that the JOD of a few pairs by PyTorch and ONNX Runtime is within 1e-4 of `nqm
score`."""
import argparse
import csv
import io
import json
import os
import statistics
import subprocess
import sys
import tempfile

import numpy as np

from network import Model, write_onnx

HERE = os.path.dirname(os.path.abspath(__file__))
BATCHES = (1, 180, 512)
SPECS = ["sgd:nickel", "ward:nickel", "sgd:brass", "ward:brass", "ggx:kd=.2,.1,.05;ks=.5;alpha=.1;f0=.04", "lambert:kd=.5"]


class Worker:
    """A program that answers each line of its input with a line of JSON."""

    def __init__(self, name, command):
        self.name = name
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.version = self.answer()["version"]

    def answer(self):
        line = self.process.stdout.readline()
        if not line:
            sys.exit(f"peers: {self.name} ended with {self.process.wait()}")
        return json.loads(line)

    def ask(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        return self.answer()

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def bench(tool, *arguments):
    """The rows of nqm-bench beside the tool, without those that measure the machine's peak rates."""
    done = subprocess.run([f"{tool}-bench", *arguments, "--json"], check=True, capture_output=True, text=True)
    return [row for row in json.loads(done.stdout)["rows"] if row["bench"] != "peak"]


def say(text):
    print(text, file=sys.stderr, flush=True)


# ---- agreement ----------------------------------------------------------------------------------------------------------


def sampled(tool, spec, model_file):
    text = subprocess.run([tool, "sample", spec, "--directions", model_file, "--csv"], check=True, capture_output=True, text=True)
    rows = list(csv.DictReader(io.StringIO(text.stdout)))
    return np.array([[float(row[c]) for c in "rgb"] for row in rows])


def our_scores(tool, model_file):
    command = [tool, "score", *SPECS, "--model", model_file, "--json"]
    results = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)["results"]
    return np.array([r["jod"] for r in results])


def check_agreement(model, ours, workers):
    """Print the difference of each implementation; exit if one differs by more than 1e-4."""
    say("largest difference of JOD from ours:")
    for worker in workers:
        for way, z in worker.ask(f"check {len(ours)}").items():
            difference = np.abs(model.jod(z) - ours).max()
            say(f"  {worker.name} {way}: {difference:.2g}")
            if not difference < 1e-4:
                sys.exit(f"peers: {worker.name} {way} computes something else")


# ---- scoring ------------------------------------------------------------------------------------------------------------


def race_scores(args, folder):
    model = Model(args.model)
    samples = [sampled(args.tool, spec, args.model) for spec in SPECS]
    pairs = [model.input(samples[0], test) for test in samples[1:]]
    more = np.random.default_rng(1).standard_normal((max(BATCHES) + 3 - len(pairs), model.sizes[0]), np.float32)
    inputs = os.path.join(folder, "x.bin")
    np.concatenate([np.array(pairs), more]).astype(np.float32).tofile(inputs)
    network = os.path.join(folder, "network.onnx")
    write_onnx(model, network)
    threads = str(args.threads)
    torch = Worker("PyTorch", [sys.executable, f"{HERE}/torch_worker.py", "score", threads, args.model, inputs])
    onnx = Worker("ONNX Runtime", ["node", f"{HERE}/onnx_worker.mjs", os.path.abspath(args.packages), threads, inputs, str(model.sizes[0]),
                                   f"f32={network}"])
    say(f"PyTorch {torch.version}, ONNX Runtime {onnx.version}")
    check_agreement(model, our_scores(args.tool, args.model), [torch, onnx])
    times = {}  # (batch, precision, program) -> list of seconds, one per turn
    for turn in range(args.turns):
        say(f"scoring, turn {turn + 1} of {args.turns}")
        for row in bench(args.tool, "score", "--model", args.model, "--rounds", str(args.rounds)):
            if row["batch"] in BATCHES and row["name"] == "network":
                times.setdefault((row["batch"], row["precision"], "nqm"), []).append(row["cpu_seconds" if args.cpu else "seconds"])
        for worker in (torch, onnx):
            for batch in BATCHES:
                for way, seconds in worker.ask(f"time {batch} {args.rounds} {args.seconds}").items():
                    precision, *rest = way.split()
                    times.setdefault((batch, precision, " ".join([worker.name] + rest)), []).append(min(seconds))
    torch.close()
    onnx.close()
    return times


def print_scores(times):
    print("\n### Scoring: the network, ms a pair\n\n| pairs | precision | by | best | median of turns | times ours | by the medians |")
    print("|---|---|---|---|---|---|---|")
    for batch, precision, who in sorted(times, key=lambda k: (k[0], k[2] != "nqm", k[2])):
        mine, ours = times[batch, precision, who], times[batch, precision, "nqm"]
        best, median = min(mine) / min(ours), statistics.median(mine) / statistics.median(ours)
        print(f"| {batch} | {precision} | {who} | {1e3 * min(mine) / batch:.4f} | {1e3 * statistics.median(mine) / batch:.4f} "
              f"| {best:.2f} | {median:.2f} |")


# ---- training -----------------------------------------------------------------------------------------------------------

PRECISION_OF = {"authors": "f32", "tuned": "f32", "bf16": "bf16"}


def race_training(args):
    workers = {way: Worker("PyTorch " + way, [sys.executable, f"{HERE}/torch_worker.py", "train", str(args.threads), way])
               for way in PRECISION_OF}
    times, memory = {}, {}
    for turn in range(args.turns):
        say(f"training, turn {turn + 1} of {args.turns}")
        for row in bench(args.tool, "train", "--epochs", "2"):
            times.setdefault((row["precision"], "nqm"), []).append(row["cpu_seconds"] / row["epochs"] if args.cpu else row["best_epoch_seconds"])
            memory[row["precision"], "nqm"] = max(row["max_rss_mb"], memory.get((row["precision"], "nqm"), 0))
        for way, worker in workers.items():
            times.setdefault((PRECISION_OF[way], worker.name), []).append(worker.ask("epoch"))
    for way, worker in workers.items():
        memory[PRECISION_OF[way], worker.name] = worker.ask("memory")
        worker.close()
    return times, memory


def print_training(times, memory):
    print("\n### Training: one epoch of the paper's run, 5,344 pairs in batches of 512 and 668 for validation\n")
    print("| precision | by | best, s | median of turns, s | times ours | by the medians | MB |\n|---|---|---|---|---|---|---|")
    for precision, who in sorted(times, key=lambda k: (k[0] != "f32", k[1] != "nqm", k[1])):
        mine, ours = times[precision, who], times[precision, "nqm"]
        best, median = min(mine) / min(ours), statistics.median(mine) / statistics.median(ours)
        print(f"| {precision} | {who} | {min(mine):.3f} | {statistics.median(mine):.3f} | {best:.2f} | {median:.2f} "
              f"| {memory[precision, who]:.0f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tool", required=True, help="the nqm to compare; nqm-bench is beside it")
    parser.add_argument("--model", required=True, help="a model file of layout ref_test")
    parser.add_argument("--packages", required=True, help="folder whose node_modules contains onnxruntime-node")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--turns", type=int, default=7)
    parser.add_argument("--rounds", type=int, default=3, help="timings of each value in a turn")
    parser.add_argument("--seconds", type=float, default=0.02, help="that a timing takes at least")
    parser.add_argument("--cpu", action="store_true",
                        help="processor time / threads instead of the clock: for a busy machine, best with one thread")
    parser.add_argument("--only", choices=["score", "train"])
    parser.add_argument("--json", help="file for all values")
    args = parser.parse_args()
    os.environ["OMP_NUM_THREADS"] = str(args.threads)
    if args.cpu:
        os.environ["NQM_PEERS_CPU"] = "1"
    results = {"clock": "processor time" if args.cpu else "clock", "threads": args.threads}
    if args.only != "train":
        with tempfile.TemporaryDirectory() as folder:
            scores = race_scores(args, folder)
        print_scores(scores)
        results["scoring"] = [{"batch": b, "precision": p, "by": w, "seconds": t} for (b, p, w), t in scores.items()]
    if args.only != "score":
        training, memory = race_training(args)
        print_training(training, memory)
        results["training"] = [{"precision": p, "by": w, "epoch_seconds": t, "max_rss_mb": memory[p, w]}
                               for (p, w), t in training.items()]
    if args.json:
        with open(args.json, "w", encoding="utf-8") as out:
            json.dump(results, out, indent=2)


if __name__ == "__main__":
    main()
