# SPDX-License-Identifier: MIT
"""Keeps results of benchmarks by machine, compares them, and makes the page of all machines.

results.py keep KIND FOLDER PEERS.json   one document of all FOLDER/*.json of `nqm-bench -o` of one build, and of bench/peers.py if
                                         PEERS.json exists, as bench/results/KIND.json
results.py compare OLD NEW [SHARE]       speeds of NEW relative to OLD; exit code 1 if a row is slower by more than SHARE (0.1)
results.py check FILE...                 check such documents; exit code 1 and a message for each fault
results.py time N COMMAND...             seconds of a command from its start to its end, best and median of N runs
results.py page                          bench/results/machines.md from bench/results/*.json, to standard output

./dev bench runs it. A result is compared by its processor time relative to the peak of the same run where it has one, so that other programs and the
clock of the day count less, and by its time otherwise.
"""
import datetime
import glob
import itertools
import json
import math
import os
import statistics
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
KEYS = ("bench", "name", "subject", "model", "by", "kernels", "precision", "batch", "layer", "m", "n", "k", "pairs", "epochs", "seed", "threads")
TEXTS = {"bench", "name", "subject", "model", "by", "kernels", "unit", "precision"}
MACHINE = {"cpu": str, "cpu_id": dict, "compiler": str, "cores": int, "threads": int, "load_average": float, "build": str}
BUSY = 0.9  # a lower processor utilisation means that other programs ran


def stop(text):
    sys.exit("results: " + text)


def load(path):
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except (OSError, ValueError) as fault:
        stop(f"{path}: {fault}")


def label(row):
    """A row without its values."""
    shape = "x".join(str(row[k]) for k in "mnk") if "m" in row else ""
    words = [row.get("bench"), row.get("model"), row.get("subject"), row.get("name"), f"layer {row['layer']}" if "layer" in row else "",
             shape, f"{row['batch']} pairs" if "batch" in row else "", row.get("precision"), row.get("by"), row.get("kernels"),
             f"seed {row['seed']}" if "seed" in row else ""]
    return ", ".join(str(w) for w in words if w)


def faults_of(document):
    """What is wrong with a document of results, as sentences."""
    faults = []
    for key, kind in {"schema": int, "kind": str, "origin": str, "date": str, "commit": str, "machine": dict, "rows": list, "peers": dict}.items():
        if not isinstance(document.get(key), kind):
            faults.append(f"'{key}' is missing or not a {kind.__name__}")
    if faults:
        return faults
    if document["schema"] != 1:
        faults.append(f"schema {document['schema']}, not 1")
    if document["origin"] == "nqm bench":
        for key, kind in MACHINE.items():
            if not isinstance(document["machine"].get(key), (int, float) if kind is float else kind):
                faults.append(f"machine '{key}' is missing or not a {kind.__name__}")
        if not any(row.get("bench") == "peak" for row in document["rows"]):
            faults.append("no row has a peak of the machine")
        if not isinstance(document.get("utilisation"), float):
            faults.append("'utilisation' is missing")
    for i, row in enumerate(document["rows"]):
        if not row.get("bench"):
            faults.append(f"row {i} names no benchmark")
        for key, value in row.items():
            good = isinstance(value, str) if key in TEXTS else isinstance(value, (int, float)) and math.isfinite(value) and value > 0
            if not good:
                faults.append(f"row {i} ({label(row)}): '{key}' is {value!r}")
    return faults


def checked(path):
    document = load(path)
    for fault in faults_of(document):
        stop(f"{path}: {fault}")
    return document


# ---- keep ---------------------------------------------------------------------------------------------------------------


def commit():
    done = subprocess.run(["git", "-C", HERE, "describe", "--always", "--dirty"], capture_output=True, text=True, check=False)
    return done.stdout.strip() or "unknown"


def peak_rows(rows):
    """The best of each peak: every run of nqm-bench measures them."""
    best = {}
    for row in rows:
        key = (row["name"], row.get("unit"), row.get("megabytes"), row["threads"])
        rate = max(row.get("peak_gflops", 0), row.get("peak_gb_per_s", 0))
        if key not in best or rate > best[key][0]:
            best[key] = (rate, row)
    return [row for _, row in best.values()]


def keep(kind, folder, peers):
    paths = sorted(glob.glob(os.path.join(folder, "*.json")))
    if not paths:
        stop(f"{folder}: no results: run ./dev bench first")
    runs = [load(path) for path in paths]
    rows = [row for run in runs for row in run["rows"]]
    timed = [row for row in rows if row["bench"] != "peak"]
    document = {"schema": 1, "kind": kind, "origin": "nqm bench", "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d"),
                "commit": commit(), "utilisation": round(statistics.median(row["cpu_share"] for row in timed if "cpu_share" in row), 3),
                "machine": runs[0]["machine"], "rows": peak_rows([r for r in rows if r["bench"] == "peak"]) + timed,
                "peers": load(peers) if os.path.exists(peers) else {}}
    document["machine"]["load_average"] = max(float(run["machine"]["load_average"]) for run in runs)
    for fault in faults_of(document):
        stop(fault)
    path = os.path.join(HERE, "results", kind + ".json")
    os.makedirs(os.path.dirname(path), exist_ok=True)
    rows = document.pop("rows")
    head = json.dumps(document, indent=1)
    with open(path + ".part", "w", encoding="utf-8") as out:  # one line a row: differences are readable
        out.write(head[:-2] + ',\n "rows": [\n' + ",\n".join("  " + json.dumps(row) for row in rows) + "\n ]\n}\n")
    os.replace(path + ".part", path)
    print(f"{path}: {len(rows)} rows, processor utilisation {document['utilisation']}")


# ---- compare ------------------------------------------------------------------------------------------------------------


def speed(row):
    """A number that is larger for a quicker result: relative to the peak, by processor time, where that is known."""
    return row.get("ratio_cpu") or row.get("ratio") or 1 / row["seconds"]


def timed_rows(document):
    return {tuple(row.get(k) for k in KEYS): row for row in document["rows"] if row["bench"] != "peak" and "seconds" in row}


def compare(old_path, new_path, share=0.1):
    old, new = checked(old_path), checked(new_path)
    before, after = timed_rows(old), timed_rows(new)
    slower = []
    print("| result | relative speed | |\n|---|---|---|")
    for key, row in after.items():
        if key in before:
            ratio = speed(row) / speed(before[key])
            if ratio < 1 - share:
                slower.append(label(row))
            print(f"| {label(row)} | {ratio:.3f} | {'SLOWER' if ratio < 1 - share else ''} |")
    only = len(before.keys() ^ after.keys())
    print(f"\n{len(before.keys() & after.keys())} results in both files, {only} in one only; {len(slower)} slower by more than {100 * share:.0f} %")
    for path, document in ((old_path, old), (new_path, new)):
        if document.get("utilisation", 1) < BUSY:
            print(f"{path}: processor utilisation {document['utilisation']}: other programs disturbed this run")
    if old["kind"] != new["kind"]:
        print(f"different machines: {old['kind']}, {new['kind']}")
    return 1 if slower else 0


# ---- time ---------------------------------------------------------------------------------------------------------------


def time_command(n, command):
    """Without the shell; the first run warms up."""
    seconds = []
    with open(os.devnull, "wb") as null:
        for _ in range(n + 1):
            begin = time.perf_counter()
            pid = os.posix_spawnp(command[0], command, os.environ, file_actions=[(os.POSIX_SPAWN_DUP2, null.fileno(), 1)])
            if os.waitpid(pid, 0)[1] != 0:
                stop(f"'{' '.join(command)}' failed")
            seconds.append(time.perf_counter() - begin)
    print(f"{' '.join(command)}  seconds {min(seconds[1:]):.4g}  seconds_median {statistics.median(seconds[1:]):.4g}")


# ---- page ---------------------------------------------------------------------------------------------------------------

PRECISIONS = ("f32", "bf16")  # of products and trainings; scores are float


def find(document, **want):
    """The rows with these values, best first."""
    rows = [r for r in document["rows"] if all(r.get(k) == v for k, v in want.items())]
    return sorted(rows, key=lambda r: r.get("seconds", r.get("best_epoch_seconds", 0)))


def digits(value, n=3):
    if value is None or not math.isfinite(value):
        return ""
    places = max(0, n - 1 - math.floor(math.log10(abs(value)))) if value else 0
    return f"{value:.{places}f}"


def times(value):
    return f"{digits(value)} x" if value else ""


def ours_and_peer(ours, peer, who):
    """Two cells: the peer's value, and how many times as long as ours it takes."""
    return (f"{digits(peer)} ({who})", times(peer / ours) if ours else "") if peer else ("", "")


def scoring_peer(document, batch):
    """Best ms per pair among the peers, and whose it is."""
    found = [(1e3 * min(s["seconds"]) / batch, s["by"]) for s in document["peers"].get("scoring", [])
             if s["batch"] == batch and s["precision"] == "f32" and s["by"] != "nqm"]
    return min(found, default=(None, ""))


def training_peer(document, precision):
    found = [(min(s["epoch_seconds"]), s["by"]) for s in document["peers"].get("training", []) if s["precision"] == precision and s["by"] != "nqm"]
    return min(found, default=(None, ""))


def ours_with_peers(document, part, key, **want):
    """Our best in the run of the peers; None without such a run."""
    found = [min(s[key]) for s in document["peers"].get(part, []) if s["by"] == "nqm" and all(s.get(k) == v for k, v in want.items())]
    return min(found, default=None)


def is_busy(document):
    return document.get("utilisation", 1) < BUSY


def seconds_of(document, row):
    """The best time; of a disturbed run the processor time of a thread; None if the row has neither."""
    return row.get("cpu_seconds") if is_busy(document) else row.get("seconds")


def epoch_of(document, row):
    return row["cpu_seconds"] / row["epochs"] if is_busy(document) else row.get("best_epoch_seconds")


def ms_of(document, row):
    seconds = seconds_of(document, row)
    return 1e3 * seconds / row["batch"] if seconds else row.get("ms_per_pair")


def gflops_of(document, row):
    seconds = seconds_of(document, row)
    return row["gflop"] / seconds if seconds else row["gflops"]


def rows_of_training(document):
    for precision in ("bf16", "f32"):
        for row in find(document, bench="train", model="paper", precision=precision)[:1]:
            ours = ours_with_peers(document, "training", "epoch_seconds", precision=precision)
            value = epoch_of(document, row)
            peer, who = training_peer(document, precision)
            yield (f"train, {precision}, s per epoch", value, row, *ours_and_peer(ours or value, peer, who))


def rows_of_scoring(document):
    for model in ("paper", "default"):
        for batch in (1, 9, 180, 512):
            for row in find(document, bench="score", model=model, name="network", batch=batch, precision="f32")[:1]:
                peer, who = scoring_peer(document, batch) if model == "paper" else (None, "")
                ours = ours_with_peers(document, "scoring", "seconds", batch=batch, precision="f32")
                value = ms_of(document, row)
                yield (f"score, `{model}`, {batch} pairs, ms per pair", value, row,
                       *ours_and_peer(1e3 * ours / batch if ours else value, peer, who))


def rows_of_whole_way(document):
    """Samples to JOD next to the network alone, and with the gradient next to the score."""
    for models, name, part, what in ((["default"], "samples to JOD", "network", "network alone"),
                                     (["paper", "default", "transport"], "samples to JOD and gradient", "samples to JOD", "score")):
        for model, batch in itertools.product(models, (1, 9, 512)):
            want = {"bench": "score", "model": model, "batch": batch, "precision": "f32"}
            parts = find(document, name=part, **want)
            for row in find(document, name=name, **want)[:1]:
                alone = ms_of(document, parts[0]) if parts else None
                yield (f"{name}, `{model}`, {batch} pairs, ms per pair", ms_of(document, row), row,
                       f"{digits(alone)} ({what})" if alone else "", times(ms_of(document, row) / alone) if alone else "")


def rows_of_products(document):
    for layer, name in ((1, "paper"), (2, "both")):
        for what in ("forward", "weight gradient"):
            for precision in PRECISIONS:
                want = {"bench": "gemm", "model": name, "layer": layer, "name": what, "precision": precision, "batch": 512}
                ours, theirs = find(document, by="nqm", **want), find(document, by="onednn", **want)
                for row in ours[:1]:
                    other = gflops_of(document, theirs[0]) if theirs else None
                    yield (f"product of layer {layer}, {what}, 512 pairs, {precision}, GFLOP/s", gflops_of(document, row), row,
                           f"{digits(other)} (oneDNN)" if other else "", times(gflops_of(document, row) / other) if other else "")


def levels_of(machine):
    """Names of caches, of runs until November 2026, and of memory, with the size of the array that is read from each, 1e6 bytes."""
    sizes = [kib * 1024e-6 / 2 for kib in machine.get("cache_kib", [])]
    return [(f"L{i + 1}", size if i == 2 else size * machine["threads"]) for i, size in enumerate(sizes)] + [("memory", 256)]


def print_machine(document):
    machine, measured = document["machine"], document["origin"] == "nqm bench"
    print(f"\n## {document.get('title') or machine['cpu'] + ', ' + document['kind']}\n")
    if measured:
        ids = ", ".join(f"{k} {v}" for k, v in machine["cpu_id"].items())
        caches = ", ".join(f"L{i + 1} {size} KiB" for i, size in enumerate(machine.get("cache_kib", [])))
        print(f"{machine['cpu']} ({ids}), {machine['threads']} threads; {caches + '; ' if caches else ''}gcc {machine['compiler']}; {machine['build'].split(' when')[0]}. "
              f"Measured {document['date']} at commit {document['commit']}; largest load average {digits(machine['load_average'], 2)}; median processor "
              f"utilisation {document['utilisation']}.")
        if "note" in document:
            print("\n" + document["note"])
        if is_busy(document):
            print("\n**Other programs disturbed this run**: times are processor times of a thread, and include what their use of the caches and of the "
                  "memory costs.")
    else:
        print(f"{document['origin']}")
    units = [r for r in document["rows"] if r["bench"] == "peak" and r["name"] == "arithmetic"]
    if units:
        absent = [r["unit"] for r in document["rows"] if r["bench"] == "peak" and r["name"] == "absent"]
        print("\n| peak of | GFLOP/s or GOP/s |\n|---|---|")
        for row in units:
            print(f"| {row['unit']} ({row['precision']}) | {digits(row['peak_gflops'])} |")
        for level, size in levels_of(machine):
            for row in find(document, bench="peak", name="reading", threads=machine["threads"]):
                if abs(row["megabytes"] / size - 1) < 1e-3:
                    print(f"| reading {digits(size)} MB ({level}), GB/s | {digits(row['peak_gb_per_s'])} |")
        if absent:
            print(f"\nAbsent: {', '.join(absent)}.")
    print("\n| result | nqm | of its own peak | by processor time | peer in the same run | peer's time / ours |\n|---|---|---|---|---|---|")
    for rows in (rows_of_training, rows_of_scoring, rows_of_products, rows_of_whole_way):
        for name, value, row, peer, relative in rows(document):
            print(f"| {name} | {digits(value)} | {digits(row.get('ratio'), 2)} | {digits(row.get('ratio_cpu'), 2)} | {peer} | {relative} |")


def page():
    print("""# Results by machine

How fast is nqm on other machines, and how near to their limits? One section per machine; [performance.md](../../doc/performance.md) has the method.

<!-- Made by `python3 bench/results.py page` from bench/results/*.json; do not edit. -->

"Of its own peak" is floor / time: 1 is the limit of the machine, by the quickest unit that can compute the product and by the bandwidth of the
memory that has to be read, both measured in the same run. "By processor time" is the same for the processor time of all threads, which
excludes other programs. The peer is the quicker of PyTorch 1.13 and ONNX Runtime 1.23 (oneDNN for single
products, with which nqm-bench compared until 23 November 2026; for samples to JOD the network alone, and with the gradient the score: there the quotient is the time of the whole way / the part). A quotient above 1 means that nqm is quicker.

<!-- test: skip because they take an hour; tests/cli/bench_results.sh runs the script on small sizes -->

    ./dev bench                       # measure: build/bench
    ./dev bench peers                 # the peers: build/peers
    ./dev bench keep KIND             # keep both as bench/results/KIND.json
    ./dev bench compare OLD.json NEW.json""")
    for path in sorted(glob.glob(os.path.join(HERE, "results", "*.json"))):
        print_machine(checked(path))


def main(arguments):
    verb, rest = (arguments[0], arguments[1:]) if arguments else ("", [])
    if verb == "keep" and len(rest) == 3:
        return keep(*rest)
    if verb == "compare" and len(rest) in (2, 3):
        return compare(rest[0], rest[1], *(float(s) for s in rest[2:]))
    if verb == "time" and len(rest) > 1 and rest[0].isdigit() and int(rest[0]) > 0:
        return time_command(int(rest[0]), rest[1:])
    if verb == "check" and rest:
        faults = [f"{path}: {fault}" for path in rest for fault in faults_of(load(path))]
        print("\n".join(faults) if faults else "valid")
        return 1 if faults else 0
    if verb == "page" and not rest:
        return page()
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
