#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Why does the paper's network fail as a loss, and what repairs it? The tables of doc/fitting.md.

usage: PYTHONPATH=python studies/fitting_network.py DATA WORK [--part why|repair] [--refs N] [--rounds N] [--pairs N] [--epochs N]

DATA holds rgl/, nbrdf/, nps/ and labels/; WORK is the folder of models/make.sh, with the datasets train.safetensors and
paper-train.safetensors. SciPy's L-BFGS minimises 10 - JOD (or Delta-E, where the model predicts it) of GGX over kd, alpha and f0,
with gradients from the Python package. `why` follows the paper's network from one start to its minimum.
`repair` trains networks of the paper's shape on more and more pairs, at last on those where optimisers go under the network
before (on-policy), and compares where fits end. Networks and datasets are kept in WORK/fitting. NQM_TOOL: the program. Needs
NumPy and SciPy."""
import argparse
import csv
import hashlib
import json
import os
import struct
import subprocess
import sys

import numpy as np
from scipy.optimize import minimize

PROGRAM_ENVIRONMENT = dict(os.environ)
os.environ["OMP_NUM_THREADS"] = "1"  # before the library is loaded: the optimiser asks it for one pair at a time
import nqm  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
NQM = os.environ.get("NQM_TOOL", os.path.join(HERE, "..", "build", "nqm"))
JOD, DELTA_E = "jod", "delta_e"


# ---- the library -------------------------------------------------------------------------------------------------------


class Model:
    """A model with a scorer, and its sampling directions."""

    def __init__(self, name):
        model = nqm.Model.open(name)
        self.scorer, self.directions = nqm.Scorer(model), model.directions
        self.jod_min, self.jod_max = model.info.jod_min, model.info.jod_max

    def gradient(self, ref, test, used, of):
        """Value and gradient (n, 3) by the test's f_r."""
        value, gradient = self.scorer.score_grad(ref, test * used[:, None], of=of, used=used)
        return value, gradient.astype(float)

    def score(self, ref, tests, used):
        """Scores of tests (m, n, 3) of one reference."""
        return self.scorer.score_samples(ref, np.asarray(tests) * used[:, None], used)


def evaluate(brdf, model):
    """f_r (n, 3), and a mask of the directions that have a value."""
    rgb, flag = nqm.BRDF.open(brdf).sample(model.directions)
    return rgb, (flag < 2).astype(np.uint8)


def run(*arguments):
    done = subprocess.run([NQM, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          env=PROGRAM_ENVIRONMENT)
    if done.returncode:
        sys.exit(f"nqm {' '.join(arguments)}: {done.stderr}")
    return done.stdout


# ---- fits of GGX -------------------------------------------------------------------------------------------------------

START = np.r_[np.log([0.2] * 3), np.log(0.2), np.log(0.05 / 0.95)]  # kd, alpha, f0 of the paper's experiment: ours to choose
BOUNDS = [(np.log(1e-4), np.log(3))] * 3 + [(np.log(0.005), 0), (-6, 4)]


def values_of(x):
    return np.exp(x[:3]), np.exp(x[3]), 1 / (1 + np.exp(-x[4]))


def spec_of(x):
    kd, alpha, f0 = values_of(x)
    return "ggx:kd=%.9g,%.9g,%.9g;ks=1;alpha=%.9g;f0=%.9g" % (*kd, alpha, f0)


def slopes(x, model, ref, used, of):
    """Score of a fit, and its gradient by x."""
    rgb, jacobian = nqm.BRDF.open(spec_of(x)).jacobian(*model.directions.vectors)
    value, by_rgb = model.gradient(ref, rgb, used, of)
    by = np.einsum("nc,ncp->p", by_rgb, jacobian)
    kd, alpha, f0 = values_of(x)
    return value, np.r_[by[:3] * kd, by[6] * alpha, by[7:10].sum() * f0 * (1 - f0)]


def minimise(model, ref, used, start, of, steps=150):
    """The points of the path of L-BFGS, with the start and the end."""
    path, sign = [start], -1 if of == JOD else 1

    def loss(x):
        value, gradient = slopes(x, model, ref, used, of)
        return sign * value, sign * gradient

    minimize(loss, start, jac=True, method="L-BFGS-B", bounds=BOUNDS, options={"maxiter": steps},
             callback=lambda x: path.append(x.copy()))
    return path


def random_start(rng):
    return np.array([rng.uniform(low, high) for low, high in BOUNDS])


def references(data, split, n, forms=("rgl", "sgd", "nbrdf", "nps")):
    listing = subprocess.run([sys.executable, os.path.join(HERE, "..", "models", "scan.py"), data], stdout=subprocess.PIPE,
                             text=True, check=True).stdout
    rows = [r for r in csv.DictReader(listing.splitlines()) if r["split"] == split and r["source"] in forms]
    brdfs = [(r["name"], r["brdf"] if r["source"] == "sgd" else os.path.join(data, r["brdf"])) for r in rows]
    return [brdfs[i] for i in np.linspace(0, len(brdfs) - 1, min(n, len(brdfs))).astype(int)]


# ---- why ---------------------------------------------------------------------------------------------------------------


def print_path(models, refs):
    """Means over references at steps of the path of the paper's network."""
    paper, pictures = models["paper"], models["transport-paper"]
    rows = {step: [] for step in (0, 1, 2, 5, 10, 20, "end")}
    for _, brdf in refs:
        ref, used = evaluate(brdf, paper)
        ref_seen, used_seen = evaluate(brdf, pictures)
        path = minimise(paper, ref, used, START, JOD)
        for step, row in rows.items():
            x = path[-1] if step == "end" else path[min(step, len(path) - 1)]
            test, _ = evaluate(spec_of(x), paper)
            said = paper.score(ref, [test], used)[0]
            rendered = pictures.score(ref_seen, [evaluate(spec_of(x), pictures)[0]], used_seen)[0]
            share = (said.jod - paper.jod_min) / (paper.jod_max - paper.jod_min)
            _, by_paper = slopes(x, paper, ref, used, JOD)
            _, by_transport = slopes(x, pictures, ref_seen, used_seen, DELTA_E)
            nearby = [slopes(x + 0.01 * np.random.default_rng(k).normal(size=5), paper, ref, used, JOD)[1] for k in range(4)]

            def cosine(a, b):
                return float(a @ b / max(np.linalg.norm(a) * np.linalg.norm(b), 1e-30))

            row.append([said.jod, rendered.jod, rendered.parts.shift[0], rendered.parts.shift[1], rendered.parts.shift[2],
                        models["default"].score(ref, [test], used)[0].novelty, share * (1 - share) * 4,
                        cosine(by_paper, -by_transport), np.mean([cosine(by_paper, g) for g in nearby])])
    print(f"\nThe path of the paper's network as the loss, GGX, mean over {len(refs)} references")
    print("step  JOD said  JOD of pictures  shift I      T      P   novelty  sigmoid's slope   cosine with pictures  with 1 % away")
    for step, row in rows.items():
        m = np.median(row, axis=0)
        mean = np.mean(row, axis=0)
        print(f"{step!s:>4s}  {mean[0]:8.2f}  {mean[1]:15.2f}  {mean[2]:+7.2f} {mean[3]:+6.2f} {mean[4]:+6.2f}  {m[5]:8.2f}"
              f"  {mean[6]:15.3f}  {mean[7]:+21.2f}  {mean[8]:+13.2f}")


def print_tints(models, refs):
    """Factor of one channel of the reference at which each model says the highest JOD: 1 would be right."""
    factors = np.exp(np.linspace(-1.2, 1.2, 200))  # 1 is not among them: equal pairs are certain
    print(f"\nFactor of one channel at which a copy of the reference has the highest JOD, {len(refs)} references")
    print(f"{'model':16s} {'channel':8s} {'median':>7s} {'5 %':>6s} {'95 %':>6s}  {'JOD there':>9s} {'JOD at half of it':>18s}")
    for name, model in models.items():
        for channel, letter in enumerate("RGB"):
            best, top, half = [], [], []
            for _, brdf in refs:
                ref, used = evaluate(brdf, model)
                tests = np.repeat(ref[None], len(factors), 0)
                tests[:, :, channel] *= factors[:, None].astype(np.float32)
                jods = np.array([r.jod for r in model.score(ref, tests, used)])
                best.append(factors[np.argmax(jods)])
                top.append(np.max(jods))
                half.append(jods[np.argmin(abs(factors - 0.5))])
            low, median, high = np.percentile(best, [5, 50, 95])
            print(f"{name:16s} {letter:8s} {median:7.2f} {low:6.2f} {high:6.2f}  {np.mean(top):9.2f} {np.mean(half):18.2f}")


def print_colours(dataset):
    """What the pairs of a dataset say of colour."""
    tensors, _ = read_tensors(dataset)
    parts, jod, ref = tensors["parts"], tensors["jod"], tensors["ref_rgb"].mean(axis=1)
    chosen = np.asarray(tensors["group_split"])[tensors["ref_group"][tensors["pair_ref"]]] == 0
    log = np.log(ref[:, :] + 1e-3)
    print(f"\nColours of {os.path.basename(dataset)}, {chosen.sum()} training pairs: references' mean log R/G "
          f"{np.mean(log[:, 0] - log[:, 1]):+.2f}, B/G {np.mean(log[:, 2] - log[:, 1]):+.2f}")
    print("JOD         pairs   mean shift I      T      P   share with |T|, |P| above 1")
    for low, high in ((0, 4), (4, 6), (6, 8), (8, 9), (9, 9.5), (9.5, 10.01)):
        p = parts[chosen & (jod >= low) & (jod < high)]
        print(f"{low:4.1f}-{high:4.1f}  {len(p):7d}   {np.mean(p[:, 0]):+12.2f} {np.mean(p[:, 1]):+6.2f} {np.mean(p[:, 2]):+6.2f}"
              f"   {np.mean(abs(p[:, 1]) > 1):.2f}, {np.mean(abs(p[:, 2]) > 1):.2f}")


# ---- datasets ----------------------------------------------------------------------------------------------------------

TYPES = {"F64": np.float64, "F32": np.float32, "U32": np.uint32, "U8": np.uint8}


def read_tensors(path):
    """(name -> array, metadata) of a safetensors file."""
    with open(path, "rb") as file:
        size, = struct.unpack("<Q", file.read(8))
        header = json.loads(file.read(size))
    meta = header.pop("__metadata__")
    return {name: np.memmap(path, TYPES[t["dtype"]], "r", 8 + size + t["data_offsets"][0], tuple(t["shape"]))
            for name, t in header.items()}, meta


def write_tensors(path, tensors, meta):
    """The inverse, with the checksum of doc/files.md."""
    names = {np.dtype(v): k for k, v in TYPES.items()}
    order = sorted(tensors, key=lambda name: (tensors[name].nbytes % 64 != 0, -tensors[name].itemsize))
    header, at = {"__metadata__": {**meta, "sha256": "0" * 64}}, 0
    for name in order:
        t = tensors[name]
        header[name] = {"dtype": names[t.dtype], "shape": list(t.shape), "data_offsets": [at, at + t.nbytes]}
        at += t.nbytes
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-(8 + len(text)) % 64)
    digest = hashlib.sha256(struct.pack("<Q", len(text)) + text)
    for name in order:
        digest.update(np.ascontiguousarray(tensors[name]))
    text = text.replace(b'"sha256":"' + b"0" * 64, b'"sha256":"' + digest.hexdigest().encode())
    with open(path + ".part", "wb") as file:
        file.write(struct.pack("<Q", len(text)) + text)
        for name in order:
            np.ascontiguousarray(tensors[name]).tofile(file)
    os.replace(path + ".part", path)


class Pairs:
    """New pairs for a dataset: references by their index, tests by their samples, labels by light transport or by rendering."""

    def __init__(self):
        self.refs, self.tests, self.labels, self.names = [], [], [], []

    def add(self, ref, test, label, name):
        self.refs.append(ref)
        self.tests.append(test)
        self.labels.append(label)
        self.names.append(name)


def extended(base, pairs, kind, extra_refs=()):
    """(tensors, metadata) of a dataset with more pairs of a new kind; extra_refs: (index of the original, samples, used)."""
    tensors, meta = base
    tensors, n_refs = dict(tensors), len(tensors["ref_rgb"])
    kinds, families, names, ref_names = (json.loads(meta[k]) for k in ("kind_names", "kind_families", "pair_names", "ref_names"))
    used = np.concatenate([tensors["ref_used"], *(u[None] for _, _, u in extra_refs)]) if extra_refs else tensors["ref_used"]
    if extra_refs:
        tensors["ref_rgb"] = np.concatenate([tensors["ref_rgb"], np.array([rgb for _, rgb, _ in extra_refs], np.float32)])
        tensors["ref_used"] = used
        tensors["ref_group"] = np.concatenate([tensors["ref_group"], tensors["ref_group"][[i for i, _, _ in extra_refs]]])
        ref_names += [f"{ref_names[i]} {k}" for k, (i, _, _) in enumerate(extra_refs, n_refs)]
    labels = np.array(pairs.labels)
    for name, more in (("test_rgb", np.array(pairs.tests, np.float32)), ("test_used", used[pairs.refs]),
                       ("pair_ref", np.array(pairs.refs, np.uint32)),
                       ("pair_kind", np.full(len(pairs.refs), len(kinds), np.uint32)), ("delta_e", labels[:, 0]),
                       ("jod", labels[:, 1]), ("parts", labels[:, 2:])):
        tensors[name] = np.concatenate([tensors[name], more])
    meta = {**meta, "kind_names": json.dumps(kinds + [kind]), "kind_families": json.dumps(families + ["perturbation"]),
            "pair_names": json.dumps(names + pairs.names), "ref_names": json.dumps(ref_names)}
    return tensors, meta


def subset(base, families, n, seed):
    """A dataset with n training pairs of these families of kinds, and a quarter as many validation pairs."""
    tensors, meta = base
    of_pair = np.isin(np.array(json.loads(meta["kind_families"]))[tensors["pair_kind"]], families)
    split = np.asarray(tensors["group_split"])[tensors["ref_group"][tensors["pair_ref"]]]
    rng = np.random.default_rng(seed)
    chosen = np.sort(np.concatenate([rng.choice(np.flatnonzero(of_pair & (split == k)), m, replace=False)
                                     for k, m in ((0, n), (1, n // 4))]))
    names = json.loads(meta["pair_names"])
    tensors = {name: np.array(t[chosen]) if len(t) == len(names) else t for name, t in tensors.items()}
    return tensors, {**meta, "pair_names": json.dumps([names[i] for i in chosen])}


def label_of(result):
    p = result.parts
    return [result.delta_e, result.jod, *p.shift, p.contrast, p.structure]


def coloured(base, transport, n, seed):
    """Pairs of the base with permuted channels and random tints of both members, labelled by light transport."""
    tensors, _ = base
    rng, pairs, extra = np.random.default_rng(seed), Pairs(), []
    training = np.flatnonzero(np.asarray(tensors["group_split"])[tensors["ref_group"][tensors["pair_ref"]]] == 0)
    n_refs = len(tensors["ref_rgb"])
    for ref in rng.choice(np.unique(tensors["pair_ref"][training]), n // 16):
        order, tint = rng.permutation(3), np.exp(rng.uniform(-0.7, 0.7, 3)).astype(np.float32)
        used = np.array(tensors["ref_used"][ref])
        rgb = np.ascontiguousarray(tensors["ref_rgb"][ref][:, order] * tint)
        chosen = rng.choice(training[tensors["pair_ref"][training] == ref], 16)
        tests = np.array([np.where(tensors["test_used"][i][:, None] > 0, tensors["test_rgb"][i][:, order] * tint, rgb)
                          for i in chosen], np.float32)
        extra.append((ref, rgb, used))
        for i, test, result in zip(chosen, tests, transport.score(rgb, tests, used)):
            pairs.add(n_refs + len(extra) - 1, test, label_of(result), f"colours {i}")
    return extended(base, pairs, "colours", extra)


def noised(base, n, seed, sigma=0.1):
    """Training pairs with noise on the test, labels kept: on average a penalty sigma^2 |gradient|^2 (Bishop 1995, DOI
    10.1162/neco.1995.7.1.108)."""
    tensors, _ = base
    rng, pairs = np.random.default_rng(seed), Pairs()
    training = np.flatnonzero(np.asarray(tensors["group_split"])[tensors["ref_group"][tensors["pair_ref"]]] == 0)
    for i in rng.choice(training, n):
        noise = np.exp(sigma * rng.normal(size=tensors["test_rgb"][i].shape))
        label = [tensors["delta_e"][i], tensors["jod"][i], *tensors["parts"][i]]
        pairs.add(int(tensors["pair_ref"][i]), tensors["test_rgb"][i] * noise, label, f"noise {i}")
    return extended(base, pairs, "noise")


def on_policy(base, model, of, brdfs, n_refs, seed):
    """Points on the paths of an optimiser under `model`, from random starts, labelled by rendering."""
    tensors, meta = base
    names, rng, pairs = json.loads(meta["ref_names"]), np.random.default_rng(seed), Pairs()
    index = {name: i for i, name in enumerate(names)}
    for name in rng.permutation(sorted(n for n in brdfs if n in index))[:n_refs]:
        ref, used = evaluate(brdfs[name], model)
        specs = []
        for start in (START, random_start(rng)):
            path = minimise(model, ref, used, start, of)
            specs += [spec_of(path[k]) for k in sorted({*(np.array([0.2, 0.5, 1]) * (len(path) - 1)).astype(int)})]
        for spec, r in zip(specs, json.loads(run("label", brdfs[name], *specs, "--json", "--points", "1024"))["results"]):
            p = r["parts"]
            label = [r["delta_e_itp"], r["jod"], *p["shift_itp"], p["contrast"], p["structure"]]
            pairs.add(index[name], evaluate(spec, model)[0], label, spec)
    return extended(base, pairs, f"path {seed}")


# ---- repairs -----------------------------------------------------------------------------------------------------------


def train(work, name, dataset, epochs):
    """A network of the paper's shape and recipe, trained on a dataset (tensors, metadata)."""
    path = os.path.join(work, name + ".safetensors")
    if not os.path.exists(path):
        data = os.path.join(work, "data.safetensors")
        write_tensors(data, *dataset)
        run("train", data, "--recipe", "paper", "--epochs", str(epochs), "--split", "group", "--id", name, "-o", path)
    return Model(path)


def ends(model, of, refs, n_starts):
    """[(reference's BRDF, spec at the end, JOD that the model says)] of fits from the same starts for all models."""
    found = []
    for k, (_, brdf) in enumerate(refs):
        ref, used = evaluate(brdf, model)
        rng = np.random.default_rng(k)
        for start in [START, *(random_start(rng) for _ in range(n_starts - 1))]:
            spec = spec_of(minimise(model, ref, used, start, of)[-1])
            found.append((brdf, spec, model.score(ref, [evaluate(spec, model)[0]], used)[0].jod))
    return found


def print_repairs(found, refs):
    rendered = {}
    for brdf in dict.fromkeys(b for _, b in refs):
        specs = list(dict.fromkeys(spec for rows in found.values() for b, spec, _ in rows if b == brdf))
        results = json.loads(run("label", brdf, *specs, "--json", "--points", "1024"))["results"]
        rendered.update(((brdf, spec), r) for spec, r in zip(specs, results))
    best = {}
    for rows in found.values():
        for brdf, spec, _ in rows:
            best[brdf] = min(best.get(brdf, 1e9), rendered[brdf, spec]["delta_e_itp"])
    print(f"\nGGX fitted to {len(refs)} held-out references under one model each; pictures: nqm label")
    print(f"{'loss':44s} {'JOD said':>8s} {'of pictures':>11s} {'apart by':>8s} {'T':>6s} {'P':>6s} {'colour':>7s} {'failed':>7s}")
    for name, rows in found.items():
        results = [rendered[brdf, spec] for brdf, spec, _ in rows]
        shift = np.array([r["parts"]["shift_itp"] for r in results])
        jod, said = np.array([r["jod"] for r in results]), np.array([s for _, _, s in rows])
        lost = [r["delta_e_itp"] > 2 * best[b] + 1 for r, (b, _, _) in zip(results, rows)]
        print(f"{name:44s} {said.mean():8.2f} {jod.mean():11.2f} {np.mean(abs(said - jod)):8.2f} {shift[:, 1].mean():+6.2f}"
              f" {shift[:, 2].mean():+6.2f} {np.hypot(shift[:, 1], shift[:, 2]).mean():7.2f} {100 * np.mean(lost):6.1f}%", flush=True)


def repair(options, models):
    folder = os.path.join(options.work, "fitting")
    os.makedirs(folder, exist_ok=True)
    refs = references(options.data, "test", options.refs)
    training = dict(references(options.data, "train", 1000, ("rgl", "sgd", "nbrdf")))
    base = read_tensors(os.path.join(options.work, "train.safetensors"))
    near = ["encoding", "published", "form", "perturbation", "composed"]
    found = {"paper, as shipped": ends(models["paper"], JOD, refs, 3)}
    model = train(folder, "near", subset(base, near, options.pairs, 1), options.epochs)
    found[f"{options.pairs} near pairs"] = ends(model, JOD, refs, 3)
    data = subset(base, near + ["far", "rounding"], options.pairs, 1)
    model = train(folder, "far", data, options.epochs)
    found[f"{options.pairs} pairs, a third far"] = ends(model, JOD, refs, 3)
    model = train(folder, "penalty", noised(data, options.pairs, 1), options.epochs)
    found["and a gradient penalty (noise on the inputs)"] = ends(model, JOD, refs, 3)
    estimate = os.path.join(folder, "estimate.safetensors")
    run("transport", "make", "-o", estimate)
    data = coloured(data, Model(os.path.abspath(estimate)), options.pairs // 2, 1)
    model = train(folder, "colours", data, options.epochs)
    found["and permuted channels, tints"] = ends(model, JOD, refs, 3)
    for k in range(1, options.rounds + 1):
        data = on_policy(data, model, JOD, training, 100, k)
        model = train(folder, f"path{k}", data, options.epochs)
        found[f"and points of its own paths, round {k}"] = ends(model, JOD, refs, 3)
    found["default: corrections of the estimate"] = ends(models["default"], DELTA_E, refs, 3)
    found["transport: the estimate"] = ends(models["transport"], DELTA_E, refs, 3)
    print_repairs(found, refs)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data")
    parser.add_argument("work")
    parser.add_argument("--part", choices=["why", "repair"])
    parser.add_argument("--refs", type=int, default=40)
    parser.add_argument("--rounds", type=int, default=3, help="of training on the optimisers' own paths")
    parser.add_argument("--pairs", type=int, default=4000, help="of the networks for `repair`")
    parser.add_argument("--epochs", type=int, default=8)
    options = parser.parse_args()
    models = {name: Model(name) for name in ("paper", "default", "transport", "transport-paper")}
    if options.part != "repair":
        refs = references(options.data, "test", options.refs)
        print_path(models, refs)
        print_tints(models, refs)
        for dataset in ("paper-train.safetensors", "train.safetensors"):
            print_colours(os.path.join(options.work, dataset))
    if options.part != "why":
        repair(options, models)


if __name__ == "__main__":
    main()
