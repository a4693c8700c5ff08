#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Run the paper's study on the data of its authors, and compare the results with the published ones.

Fits the JOD curve to the human scores, trains each recipe with several seeds, tests the models and the metrics on the human scores, and
prints a table that compares the results with the published values (doc/reproduce.md). Runs `nqm regress`, `train`, `nqm-bench score` and
`eval`; needs only Python's standard library. After an interruption (Ctrl-C) the same command continues."""
import argparse
import csv
import json
import os
import shutil
import signal
import statistics
import struct
import subprocess
import sys
import tempfile

EXIT_OPEN, EXIT_INCOMPATIBLE, EXIT_INTERRUPTED = 3, 5, 130  # as nqm's
STATISTICS = {"spearman": "ci95", "spearman_mean_by_material": "ci95_mean_by_material"}  # and their intervals
STATISTICS.update((key, "ci95_" + key) for key in ("pearson", "kendall", "mae", "rmse", "r2", "order"))
MEANS = {"spearman": "Spearman", "spearman_mean_by_material": "by material", "mae": "MAE", "rmse": "RMSE", "r2": "R2",
         "training_seconds": "training s", "ms_per_pair": "ms a pair"}  # with their headings
# What must be as in the paper for a comparison to be meaningful. doc/reproduce.md says where the tolerances come from.
HUMAN, TRAINING, EPOCHS, MACHINE = {"human scores"}, {"training data"}, {"epochs"}, {"machine"}
ALL = HUMAN | TRAINING | EPOCHS
PUBLISHED = (  # name, recipe ("": the regression), source, place of our value, published value, tolerance (None: at least), conditions
    ("JOD curve, b1", "", "label files", "b1", -14.11197, 0.005, HUMAN),
    ("JOD curve, b2", "", "label files", "b2", -0.47364, 0.0005, HUMAN),
    ("JOD curve, b3", "", "label files", "b3", -0.21480, 0.0005, HUMAN),
    ("training examples", "paper", "paper", "n_train", 5344, 2, TRAINING),
    ("validation examples", "paper", "paper", "n_validation", 668, 1, TRAINING),
    ("whitening, mean", "notebook", "train_info.mat", "whitening.mean.0", 0.69127, 0.05, TRAINING),
    ("whitening, std", "notebook", "train_info.mat", "whitening.std.0", 0.55376, 0.05, TRAINING),
    ("training labels, mean", "notebook", "train_info.mat", "targets.mean", 6.67318, 0.1, TRAINING),
    ("training labels, std", "notebook", "train_info.mat", "targets.std", 1.96393, 0.1, TRAINING),
    ("parameters", "paper", "paper", "model.parameters", 4171125, 0, set()),
    ("model size, MB", "paper", "paper", "model.megabytes", 15.91, 0.005, set()),
    ("Spearman, mean over materials", "paper", "paper", "test.spearman_mean_by_material", 0.67, 0.03, ALL),
    ("Spearman, all pairs", "paper", "paper", "test.spearman", 0.67, 0.03, ALL),
    ("lead over the best of the 8", "paper", "paper", "test.lead", 0, None, ALL),
    ("MAE, JOD", "notebook", "notebook", "test.mae", 1.137, 0.1, ALL),
    ("RMSE, JOD", "notebook", "notebook", "test.rmse", 1.575, 0.1, ALL),
    ("R2", "notebook", "notebook", "test.r2", 0.326, 0.1, ALL),
    ("training, s", "paper", "paper", "training_seconds", 36, 0, MACHINE),
    ("score, ms a pair", "paper", "paper", "ms_per_pair", 0.04, 0, MACHINE),
)
child, interrupted = None, False


def interrupt(*_):
    global interrupted
    interrupted = True
    if child:
        child.send_signal(signal.SIGINT)


def stop(code, *messages):
    print(*("reproduce.py: " + message for message in messages), sep="\n", file=sys.stderr)
    sys.exit(code)


def nqm(a, *arguments, program=None):
    """The JSON that nqm or another program prints. A failure, which that reports, ends this program."""
    global child
    if not interrupted:
        try:  # in a session of its own: Ctrl-C arrives once, from interrupt()
            child = subprocess.Popen([program or a.nqm, *arguments, "--json"], stdout=subprocess.PIPE, text=True, start_new_session=True)
        except OSError as error:
            stop(EXIT_OPEN, f"{a.nqm}: {error.strerror} (--nqm PATH sets the program)")
        output = child.communicate()[0]
    if interrupted:
        stop(EXIT_INTERRUPTED, "interrupted; the same command again continues from there")
    if child.returncode:
        sys.exit(child.returncode)
    return json.loads(output)


def write(path, text):
    with open(path + ".part", "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(path + ".part", path)


def find_data(a):
    """Paths of the two folders and the two CSVs. A message for each missing part ends the program."""
    paths, missing = [], []
    for key, name in (("train", "uniform_rand_500"), ("train_labels", "labels_balanced_train.csv"), ("test", "test"),
                      ("test_labels", "labels_real.csv")):
        places = [os.path.join(a.data, name), os.path.join(a.data, "data", name)]
        path = getattr(a, key) or next(filter(os.path.exists, places), places[0])
        paths.append(path)
        for part in [path] if key.endswith("labels") else [os.path.join(path, inner) for inner in ("ref", "model")]:
            if not os.path.exists(part):
                kind = "file" if key.endswith("labels") else "folder"
                missing.append(f"{part}: no such {kind} (--{key.replace('_', '-')} sets another place for {name})")
    if missing:
        stop(EXIT_OPEN, *missing)
    return paths


def dataset(a, folder, labels):
    """Properties of a dataset, and the set of its materials. Loads every sample."""
    with tempfile.TemporaryDirectory() as scratch:
        pairs = os.path.join(scratch, "pairs.csv")
        report = nqm(a, "eval", folder, "--labels", labels, "--model", "none", "--bootstrap", "0", "--pairs", pairs)
        with open(pairs, newline="", encoding="utf-8") as file:
            materials = {row["material"] for row in csv.DictReader(file)}
    return {"path": folder, "labels": labels, "n": report["results"][0]["n"], "n_materials": len(materials),
            "sha256": report["dataset"]["sha256"], "nqm_version": report["tool"]["version"]}, materials


def constants(path):
    """Whitening and normalisation of the targets, from the tensors of a model file."""
    with open(path, "rb") as file:
        n_header = struct.unpack("<Q", file.read(8))[0]
        header = json.loads(file.read(n_header))

        def tensor(name):
            begin, end = header[name]["data_offsets"]
            file.seek(8 + n_header + begin)
            return [x for x, in struct.iter_unpack({"F32": "<f", "F64": "<d"}[header[name]["dtype"]], file.read(end - begin))]

        return {"whitening": {"mean": tensor("whitening.mean"), "std": tensor("whitening.std")},
                "targets": dict(zip(("mean", "std"), tensor("target")))}


def train(a, recipe, seed, data):
    """Train a model, or read the record of a finished training."""
    name = f"{recipe}-{seed}"
    model, checkpoint, record_path, losses = (os.path.join(a.output, name + end)
                                              for end in (".safetensors", ".checkpoint", ".json", "-loss.csv"))
    expected = {"recipe": recipe, "epochs": a.epochs, "dataset_sha256": data["sha256"], "nqm_version": data["nqm_version"]}
    if os.path.exists(record_path):
        with open(record_path, encoding="utf-8") as file:
            record = json.load(file)
        for key, value in expected.items():
            if record.get(key) != value:
                stop(EXIT_INCOMPATIBLE,
                     f"{record_path} is of a training with {key} {record.get(key)}, not {value}: choose another folder (-o)")
        if os.path.exists(model) and nqm(a, "info", model)["sha256"] == record["model"]["sha256"]:
            return record
    resume = ["--resume"] if os.path.exists(checkpoint) else []
    r = nqm(a, "train", data["path"], "--labels", data["labels"], "--recipe", recipe, "--id", name, "--seed", str(seed), "--epochs",
            str(a.epochs), "-o", model, "--checkpoint", checkpoint, "--log", losses, *resume)
    info = nqm(a, "info", model)
    ms_per_pair = time_scores(a, model)
    n_timed = r["epochs"] - r["epochs_resumed"]
    record = {"id": name, "seed": seed, **expected, **{key: value for key, value in r.items() if key not in ("schema", "tool")}}
    record["model"].update(megabytes=r["model"]["parameters"] * 4 / 2**20, n_directions=info["directions"]["n"])
    record.update(training_seconds=r["seconds"] / n_timed * r["epochs"] if n_timed else None, ms_per_pair=ms_per_pair, **constants(model))
    record["targets"].update(zip(("jod_min", "jod_max"), info["jod_range"]))
    write(record_path, json.dumps(record, indent=2) + "\n")
    os.remove(checkpoint)
    return record


def time_scores(a, model):
    """The time of a score in a batch of 180, ms; None if nqm-bench, which is not installed, is not beside the tool."""
    program = os.path.join(os.path.dirname(shutil.which(a.nqm) or a.nqm), "nqm-bench")
    if not os.path.exists(program):
        return None
    rows = nqm(a, "score", "--model", model, "--rounds", "3", program=program)["rows"]
    return next(1e3 * row["seconds_median"] / 180 for row in rows if (row["name"], row.get("batch")) == ("samples to JOD", 180))


def mean(values):
    return None if None in values else statistics.fmean(values)


def mean_and_sd(trainings, recipe, place):
    """Over the seeds. `place`: keys and indices with points between them."""
    values = []
    for entry in (t for t in trainings if t["recipe"] == recipe):
        for key in place.split("."):
            entry = entry[int(key)] if isinstance(entry, list) else entry[key]
        values.append(entry)
    return mean(values), statistics.stdev(values) if len(values) > 1 and None not in values else None


def evaluate(a, test, trainings):
    """Add the test of each model to its training. Returns the bars: the mean over the seeds of each recipe, and the metrics."""
    models = ",".join(t["model"]["path"] for t in trainings)
    rows = nqm(a, "eval", test["path"], "--labels", test["labels"], "--model", models)["results"]
    metrics = [{key: value for key, value in row.items() if key != "best_baseline"} for row in rows[len(trainings):]]
    best = max(m["spearman_mean_by_material"] or -1 for m in metrics if m["name"] != "log_diff")  # of the eight baselines
    for training, row in zip(trainings, rows):
        lead = None if row["spearman_mean_by_material"] is None else row["spearman_mean_by_material"] - best
        training["test"] = {key: value for key, value in row.items() if key not in ("type", "contrasts", "interval")}
        training["test"]["lead"] = lead
    bars = []
    for recipe in a.recipes:
        tests = [t["test"] for t in trainings if t["recipe"] == recipe]
        bar = {**tests[0], "name": recipe, "type": "model", "best_of_family": False}
        del bar["lead"]
        for key, interval in STATISTICS.items():
            ends = [test[interval] for test in tests]
            bar[key], bar[interval] = mean([test[key] for test in tests]), None if None in ends else [mean(end) for end in zip(*ends)]
        bars.append(bar)
    return bars + metrics


def compare(study, a, name, recipe, source, place, published, tolerance, needs):
    """Our value for a published one, and the verdict."""
    here, sd, test = None, None, study["test"]
    if not recipe or recipe in a.recipes:
        here, sd = mean_and_sd(study["trainings"], recipe, place) if recipe else (study["regression"][place], None)
    if recipe and recipe not in a.recipes:
        verdict = "not run"
    elif needs == MACHINE:
        verdict = "not comparable: other machine"
    elif needs & HUMAN and (test["n"], test["n_materials"]) != (180, 20) or needs & TRAINING and study["train"]["n"] != 3339:
        verdict = "not comparable: other data"
    elif needs & EPOCHS and a.epochs != 100:
        verdict = f"not comparable: {a.epochs} epochs"
    elif here is not None and (here > published if tolerance is None else abs(here - published) <= tolerance):
        verdict = "reproduced"
    else:
        verdict = "not reproduced"
    return {"name": name, "recipe": recipe, "source": source, "published": published, "tolerance": tolerance or 0,
            "at_least": tolerance is None, "here": here, "sd": sd, "verdict": verdict}


def bars_csv(bars):
    """With the columns of `nqm eval --csv`."""
    lines = ["by,selection,name,type,n,n_materials,spearman,ci95_low,ci95_high,spearman_mean_by_material,mean_ci95_low,mean_ci95_high,"
             "pearson,kendall,mae,rmse,r2,best_of_family"]
    for bar in bars:
        values = [x for key in list(STATISTICS)[:2] for x in (bar[key], *(bar[STATISTICS[key]] or (None, None)))]
        values += [bar[key] for key in list(STATISTICS)[2:7]]
        texts = ["" if value is None else f"{value:.9g}" for value in values]
        lines.append(",".join(["all,all", bar["name"], bar["type"], str(bar["n"]), str(bar["n_materials"]), *texts,
                               str(int(bar["best_of_family"]))]))
    return "\n".join(lines) + "\n"


def text(value, form=".3f"):
    return "-" if value is None else format(value, form)


def print_table(*rows):
    widths = [max(map(len, column)) for column in zip(*rows)]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip())
    print()


def print_study(study, a):
    for key in ("train", "test"):
        print("{0:9} {path}, {labels}: {n} rows of {n_materials} materials, {n_directions} directions".format(key, **study[key]))
    print("curve     b1 {b1:.5f}, b2 {b2:.5f}, b3 {b3:.5f}; RMSE {rmse:.4f} JOD, Spearman of Delta-E with JOD {spearman:.4f}, n {n}\n"
          .format(**study["regression"]))
    print_table(["training", "epochs", "examples", "loss", "validation", "training s", "ms a pair", "whitening mean R G B, std R G B"],
                *([t["id"], str(t["epochs"]), str(t["n_train"]), text(t["train_loss"], ".4f"), text(t["validation_loss"], ".4f"),
                   text(t["training_seconds"], ".1f"), text(t["ms_per_pair"], ".4f"),
                   " ".join(f"{x:.4f}" for x in t["whitening"]["mean"] + t["whitening"]["std"])] for t in study["trainings"]))
    tested = [["test", "", "Spearman [95 %]", "mean over materials", "MAE", "RMSE", "R2"]]
    for row in [t["test"] for t in study["trainings"]] + study["results"][len(a.recipes):]:
        intervals = (text(row[key]) + (" [{:.3f}, {:.3f}]".format(*row[STATISTICS[key]]) if row[STATISTICS[key]] else "")
                     for key in list(STATISTICS)[:2])
        star = "*" if row.get("best_of_family") else ""
        tested.append([row["name"], star, *intervals, *(text(row[key]) for key in ("mae", "rmse", "r2"))])
    print_table(*tested)
    print("* best of its family\n")
    print_table(["mean (sd)", "seeds", *MEANS.values()],
                *([r["recipe"], str(r["seeds"]), *(text(r[key]["mean"], ".4g") + ("" if r[key]["sd"] is None else f" ({r[key]['sd']:.2g})")
                                                   for key in MEANS)] for r in study["recipes"]))
    print_table(["published", "recipe", "source", "value", "tolerance", "here", "verdict"],
                *([f["name"], f["recipe"], f["source"], ("> %g" if f["at_least"] else "%.7g") % f["published"],
                   text(f["tolerance"] or None, "g"), text(f["here"], ".7g"), f["verdict"]] for f in study["figures"]))
    print(f"{a.output}: models, losses, bars.csv, reproduce.json")


def parse_arguments():
    build = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "build", "nqm")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    add = parser.add_argument
    add("data", metavar="DIR", help="the authors' data, in the layout of doc/reproduce.md")
    add("-o", "--output", metavar="DIR", default="reproduce", help="folder for models, checkpoints and results [%(default)s]")
    add("--recipes", metavar="LIST", default="paper,notebook", help="paper, notebook, nqm, with commas [%(default)s]")
    add("--seeds", metavar="N", type=int, default=3, help="trainings of each recipe, with seeds 1 to N [%(default)s]")
    add("--epochs", metavar="N", type=int, default=100, help="of each training [%(default)s, as in the paper]")
    add("--train", metavar="FOLDER", help="training samples, if not DIR/uniform_rand_500")
    add("--train-labels", metavar="CSV", help="their labels, if not labels_balanced_train.csv in DIR or DIR/data")
    add("--test", metavar="FOLDER", help="test samples, if not DIR/test")
    add("--test-labels", metavar="CSV", help="the human scores, if not labels_real.csv in DIR or DIR/data")
    add("--json", action="store_true", help="print JSON, which is also written to reproduce.json")
    add("--nqm", metavar="PATH", default=os.environ.get("NQM_TOOL", build), help="the program nqm [NQM_TOOL, else build/nqm]")
    a = parser.parse_args()
    a.recipes = a.recipes.split(",")
    for recipe in a.recipes:
        if recipe not in ("paper", "notebook", "nqm"):
            parser.error(f"--recipes: there is no recipe '{recipe}'; choose from paper, notebook, nqm")
        if a.recipes.count(recipe) > 1:
            parser.error(f"--recipes: '{recipe}' is named twice")
    if not 1 <= a.seeds <= 20 or a.epochs < 1 or "," in a.output:
        parser.error("--seeds needs a number from 1 to 20, --epochs one from 1, --output a path without commas")
    return a


def main():
    a = parse_arguments()
    signal.signal(signal.SIGINT, interrupt)  # also when the shell ignores it for background commands
    train_folder, train_labels, test_folder, test_labels = find_data(a)
    try:
        if not os.path.isdir(a.output):
            os.mkdir(a.output)
    except OSError as error:
        stop(EXIT_OPEN, f"{a.output}: cannot make this folder: {error.strerror}")
    regression = nqm(a, "regress", test_labels)
    tool = regression.pop("tool")
    test, test_materials = dataset(a, test_folder, test_labels)
    training, train_materials = dataset(a, train_folder, train_labels)
    for material in sorted(train_materials & test_materials):  # the materials of the human study must not be trained on
        stop(EXIT_INCOMPATIBLE, f"material '{material}' is in both {train_labels} and {test_labels}")
    trainings = [train(a, recipe, seed, training) for recipe in a.recipes for seed in range(1, a.seeds + 1)]
    test["n_directions"] = training["n_directions"] = trainings[0]["model"]["n_directions"]
    study = {"schema": regression.pop("schema"), "tool": tool, "train": training, "test": test, "regression": regression,
             "trainings": trainings, "recipes": [], "results": evaluate(a, test, trainings)}
    for recipe in a.recipes:
        places = {key: key if key in trainings[0] else "test." + key for key in MEANS}
        means = {key: dict(zip(("mean", "sd"), mean_and_sd(trainings, recipe, place))) for key, place in places.items()}
        study["recipes"].append({"recipe": recipe, "seeds": a.seeds, **means})
    study["figures"] = [compare(study, a, *row) for row in PUBLISHED]
    document = json.dumps(json.loads(json.dumps(study), parse_float=lambda x: float(f"{float(x):.9g}")), indent=2) + "\n"
    write(os.path.join(a.output, "bars.csv"), bars_csv(study["results"]))
    write(os.path.join(a.output, "reproduce.json"), document)
    if a.json:
        sys.stdout.write(document)
    else:
        print_study(study, a)


main()
