#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Label pairs that somebody else has labelled, and compare the two labels by rank.

usage: studies/agreement.py PAIRS.csv [--root DIR] [--loss NAME] [--json] [options of nqm label]

PAIRS.csv has the columns reference, test, encoding, delta_e (their label); the test `fit` stands for the fit by `nqm fit` of the
model that `encoding` names. Relative paths start at DIR. For each encoding the table gives Spearman's correlation of our Delta-E ITP
with theirs over the references (95 % bootstrap interval), the correlation that the mean luminance of the reference's picture reaches
by itself, the medians of both, and the median ratio of ours to theirs. The tool is NQM_TOOL, default build/nqm. Python's standard
library only."""
import argparse
import csv
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

N_BOOTSTRAP = 2000
MASK = 2**64 - 1
COLUMNS = ("reference", "test", "encoding", "delta_e")


def fail(code, message):
    print(f"agreement.py: {message}", file=sys.stderr)
    sys.exit(code)


# ---- our labels --------------------------------------------------------------------------------------------------------


class Labels:
    def __init__(self, arguments, label_options):
        self.nqm = os.environ.get("NQM_TOOL", os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "build", "nqm"))
        self.arguments, self.label_options = arguments, label_options

    def run(self, *arguments):
        done = subprocess.run([self.nqm, *arguments, "--json"], stdout=subprocess.PIPE, check=False)
        if done.returncode:
            sys.exit(done.returncode)
        return json.loads(done.stdout)

    def below_root(self, brdf):
        path = os.path.join(self.arguments.root, brdf)
        return path if os.path.exists(path.rsplit(":", 1)[0]) or os.path.exists(path) else brdf

    def test_of(self, row, folder):
        if row["test"] != "fit":
            return self.below_root(row["test"])
        file = os.path.join(folder, f"{row['line']}.safetensors")
        fit = ["fit", row["reference"], "--model", row["encoding"], "--loss", self.arguments.loss]
        return self.run(*fit)["spec"] or self.run(*fit, "-o", file)["spec"]  # networks and tables are files

    def add_to(self, rows):
        """Set `ours` and `luminance` of every row, from one call of nqm label."""
        with tempfile.TemporaryDirectory() as folder:
            words, before = [], None
            for row in rows:
                row["reference"] = self.below_root(row["reference"])
                if row["reference"] != before:
                    words += (["+"] if before else []) + [row["reference"]]
                    before = row["reference"]
                words.append(self.test_of(row, folder))
            results = self.run("label", *words, *self.label_options)["results"]
        for row, result in zip(rows, results):
            row["ours"], row["luminance"] = result["delta_e_itp"], result["reference_luminance_cdm2"]


def read_pairs(path):
    try:
        with open(path, newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            for name in COLUMNS:
                if name not in (reader.fieldnames or []):
                    fail(4, f"{path}: the header has no column {name}")
            rows = [{**row, "theirs": float(row["delta_e"]), "line": reader.line_num} for row in reader]
    except OSError as error:
        fail(3, error)
    except ValueError as error:
        fail(4, f"{path}: line {reader.line_num}: {error}")
    if len(rows) < 2:
        fail(5, f"{path}: a comparison needs 2 pairs or more")
    return rows


# ---- statistics --------------------------------------------------------------------------------------------------------


def ranks(values):
    """Ranks from 1; equal values get their mean rank."""
    order = sorted(range(len(values)), key=values.__getitem__)
    rank, begin = [0.0] * len(values), 0
    while begin < len(order):
        end = begin
        while end < len(order) and values[order[end]] == values[order[begin]]:
            end += 1
        for i in order[begin:end]:
            rank[i] = (begin + 1 + end) / 2
        begin = end
    return rank


def spearman(x, y):
    """NaN where one of the two is constant."""
    if len(set(x)) < 2 or len(set(y)) < 2:
        return math.nan
    middle = (len(x) + 1) / 2
    a, b = [r - middle for r in ranks(x)], [r - middle for r in ranks(y)]
    return sum(p * q for p, q in zip(a, b)) / math.sqrt(sum(p * p for p in a) * sum(q * q for q in b))


def quantile(values, q):
    values = sorted(values)
    if not values:
        return math.nan
    at = q * (len(values) - 1)
    below = int(at)
    above = min(below + 1, len(values) - 1)
    return values[below] + (at - below) * (values[above] - values[below])


def mix(z):
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
    return z ^ (z >> 31)


def splitmix(seed, counter):
    golden = 0x9E3779B97F4A7C15
    return mix((mix((seed + golden) & MASK) + (counter + 1) * golden) & MASK)


def resample(n, stream):
    """n indices below n: xoshiro256** seeded as src/base/rng.c does, so that the interval is that of nqm's own bootstrap."""
    base = splitmix(1, stream)
    s = [splitmix(base, i) for i in range(4)]
    for _ in range(n):
        product = s[1] * 5 & MASK
        yield ((product << 7 | product >> 57) * 9 & MASK) % n  # without the rejection of rng.c: its chance is n / 2^64
        t = s[1] << 17 & MASK
        s[2] ^= s[0]
        s[3] ^= s[1]
        s[1] ^= s[2]
        s[0] ^= s[3]
        s[2] ^= t
        s[3] = (s[3] << 45 | s[3] >> 19) & MASK


def summary(name, rows):
    ours, theirs = [row["ours"] for row in rows], [row["theirs"] for row in rows]
    resamples = [list(resample(len(rows), k)) for k in range(N_BOOTSTRAP)]
    rho = [spearman([ours[i] for i in at], [theirs[i] for i in at]) for at in resamples] if len(rows) > 1 else []
    rho = [value for value in rho if not math.isnan(value)]
    return {
        "encoding": name,
        "n": len(rows),
        "spearman": spearman(ours, theirs),
        "ci95": [quantile(rho, 0.025), quantile(rho, 0.975)],
        "null_luminance": spearman([row["luminance"] for row in rows], theirs),
        "median_theirs": quantile(theirs, 0.5),
        "median_ours": quantile(ours, 0.5),
        "median_ratio": quantile([row["ours"] / row["theirs"] for row in rows if row["theirs"] > 0], 0.5),
    }


def compare(rows):
    encodings = list(dict.fromkeys(row["encoding"] for row in rows))
    null = []  # what the encoding's name says: the median of their labels for the other references
    for row in rows:
        others = [other["theirs"] for other in rows if other is not row and other["encoding"] == row["encoding"]]
        null.append(statistics.median(others) if others else 0)
    table = {}
    for row in rows:
        table.setdefault(row["reference"], {}).setdefault(row["encoding"], row)
    triples = [t for t in table.values() if {"ward", "ggx", "nbrdf"} <= t.keys()]

    def n_ordered(key):
        return sum(t["nbrdf"][key] < min(t["ward"][key], t["ggx"][key]) for t in triples)

    return {
        "results": [summary(name, [row for row in rows if row["encoding"] == name]) for name in encodings],
        "pooled": summary("all", rows),
        "pooled_null_encoding": spearman(null, [row["theirs"] for row in rows]),
        "order": {"references": len(triples), "ours": n_ordered("ours"), "theirs": n_ordered("theirs")},
    }


def print_table(result):
    print(
        "| encoding | n | Spearman of ours with theirs [95 %] | of the reference's luminance | median of theirs | of ours "
        "| median ratio |\n|---|---|---|---|---|---|---|"
    )
    for r in [*result["results"], result["pooled"]]:
        print(
            f"| {r['encoding']} | {r['n']} | {r['spearman']:.2f} [{r['ci95'][0]:.2f}, {r['ci95'][1]:.2f}] | {r['null_luminance']:.2f} "
            f"| {r['median_theirs']:.1f} | {r['median_ours']:.1f} | {r['median_ratio']:.2f} |"
        )
    print(f"\nOver all pairs, the encoding's name alone reaches {result['pooled_null_encoding']:.2f}.")
    order = result["order"]
    if order["references"]:
        print(f"nbrdf below both ward and ggx: {order['ours']} of {order['references']} references (theirs: {order['theirs']}).")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0], epilog="Other options go to nqm label.")
    parser.add_argument("pairs")
    parser.add_argument("--root", default="", help="folder at which relative paths of PAIRS.csv start")
    parser.add_argument("--loss", default="log", help="of the fits: log, log-cos, cube-root, linear")
    parser.add_argument("--json", action="store_true", help="print JSON; NaN where a value is undefined")
    arguments, label_options = parser.parse_known_args()
    if "--points" not in label_options and "--size" not in label_options:
        label_options += ["--points", "3072"]
    rows = read_pairs(arguments.pairs)
    Labels(arguments, label_options).add_to(rows)
    result = compare(rows)
    if arguments.json:
        print(json.dumps(result, indent=1))
    else:
        print_table(result)


if __name__ == "__main__":
    main()
