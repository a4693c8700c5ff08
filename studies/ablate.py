#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Train variants of a recipe with several seeds and compare them on the validation materials.

usage: studies/ablate.py DATASET WORK VARIANTS.txt [--seeds 3] [--tool build/nqm] [--by range]

VARIANTS.txt has one line per variant: a name, a colon, flags of `nqm train` ("no scalars: --no-scalars --dropout 0.2");
'#' begins a comment. WORK stores models and results; variants with a model in WORK are not trained again. Prints the
mean (and the standard deviation over the seeds) of four statistics: Spearman over all validation pairs, its mean over
materials, the MAE in JOD, and Spearman in each further table. Test pairs are not used."""
import argparse
import json
import os
import statistics
import subprocess
import sys


def read_variants(path):
    with open(path, encoding="utf-8") as file:
        lines = [line.split("#")[0].strip() for line in file]
    return [(name.strip(), flags.split()) for name, colon, flags in (line.partition(":") for line in lines) if colon]


def results_of(options, name, flags, seed):
    """Tables of `nqm eval` for one variant and seed: selection -> statistics of the model."""
    stem = os.path.join(options.work, "{}-{}".format("".join(c if c.isalnum() else "_" for c in name), seed))
    model, judged = stem + ".safetensors", f"{stem}-{options.by}.json"
    if not os.path.exists(model):
        command = [options.tool, "train", options.dataset, "-o", model, "--id", "variant", "--seed", str(seed)] + flags
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    if not os.path.exists(judged):
        command = [options.tool, "eval", options.dataset, "--model", model, "--split", "validation", "--by", options.by, "--bootstrap",
                   "0", "--json"]
        with open(judged + ".part", "w", encoding="utf-8") as file:
            subprocess.run(command, check=True, stdout=file)
        os.rename(judged + ".part", judged)
    with open(judged, encoding="utf-8") as file:
        tables = json.load(file)
    out = {"all": tables["results"][0]}
    for key in tables:
        if key.startswith("by_"):
            out.update({selection: rows[0] for selection, rows in tables[key].items() if rows})
    return out


def cell(values):
    if any(v is None for v in values):
        return "-"
    spread = f" ({statistics.stdev(values):.3f})" if len(values) > 1 else ""
    return f"{statistics.mean(values):.3f}{spread}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("dataset")
    parser.add_argument("work")
    parser.add_argument("variants")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--by", default="range", help="further tables, as in nqm eval")
    parser.add_argument("--tool", default=os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "build", "nqm"))
    options = parser.parse_args()
    os.makedirs(options.work, exist_ok=True)
    head = None
    for name, flags in read_variants(options.variants):
        seeds = [results_of(options, name, flags, seed) for seed in range(1, options.seeds + 1)]
        selections = [s for s in seeds[0] if s != "all"]
        if head != selections:
            print("| variant | Spearman | mean by material | MAE |" + "".join(f" {s} |" for s in selections))
            print("|---|---|---|---|" + "---|" * len(selections))
            head = selections
        figures = [cell([r["all"][key] for r in seeds]) for key in ("spearman", "spearman_mean_by_material", "mae")]
        figures += [cell([r[s]["spearman"] for r in seeds]) for s in selections]
        print("| " + " | ".join([name] + figures) + " |")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
