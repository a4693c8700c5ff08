#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm-bench at tiny sizes: values exist, are finite and positive, ratios equal the quotient of their parts, wrong
# arguments are refused. No test requires a speed.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
tool=${NQM_BUILD:?}/nqm-bench

# check_rows: every row of the JSON in out is consistent.
check_rows() {
    awk -v what="$1" '
        function value(line) { sub(/^[^:]*: */, "", line); sub(/,$/, "", line); gsub(/"/, "", line); return line }
        function near(a, b) { return a > 0 && b > 0 && a / b > 1 - 1e-6 && a / b < 1 + 1e-6 }
        /^    \{/ { delete f; inside = 1 }
        /^      "/ { split($0, part, "\""); f[part[2]] = value($0) }
        /nan|inf/ { print "not a number: " $0; bad = 1 }
        inside && /^    \}/ {
            inside = 0
            ++rows
            for (k in f) if (f[k] ~ /^-?[0-9.]/ && !(f[k] > 0)) { print k " of " f["name"] " is " f[k]; bad = 1 }
            if ("floor_seconds" in f) {
                ++ratios
                if (!near(f["ratio"], f["floor_seconds"] / f["seconds"])) { print "ratio of " f["name"]; bad = 1 }
                if (!near(f["times_floor"], f["seconds"] / f["floor_seconds"])) { print "times_floor"; bad = 1 }
            }
            if (("gflop" in f) && !near(f["gflops"], f["gflop"] / f["seconds"])) { print "gflops of " f["name"]; bad = 1 }
            if (f["bench"] == "train") { # the time of a run includes more than its epochs
                if (f["seconds"] + 0 < f["epochs"] * f["best_epoch_seconds"]) { print "a run shorter than its epochs"; bad = 1 }
            } else if (f["bench"] != "peak" && f["seconds"] + 0 > f["seconds_median"] + 0) { print "best above median"; bad = 1 }
        }
        END { if (rows < 4 || (what != "load" && ratios < 2)) { print rows " rows, " ratios " ratios: too few"; bad = 1 }; exit bad }' "$dir/out" ||
        fail "rows of $1"
}

run 0 gemm --quick --json
for word in '"schema": 1' '"cpu":' '"kernels":' '"bench": "peak"' '"name": "forward"' \
    '"peak_gb_per_s":' '"cpu_share":'; do
    grep -q "$word" "$dir/out" || fail "JSON lacks $word"
done
[ "$(grep -c '"name": "forward"' "$dir/out")" = 2 ] || fail "a row for each precision"
check_rows gemm
run 0 gemm --quick --precision f32 -o "$dir/gemm.json"
grep -q '"schema": 1' "$dir/gemm.json" || fail "JSON into a file"
grep -q '^gemm  forward  nqm  .*  f32  .*layer 2  batch 512  m 512  n 716  k 1024 .*times_floor' "$dir/out" || fail "lines"

run 0 train --quick --epochs 2 --recipe paper --json
check_rows train
[ "$(grep -c '"bench": "train"' "$dir/out")" = 2 ] || fail "a row for each precision"
[ "$(number epochs 1)" = 2 ] || fail "epochs"
[ "$(number pairs 1)" = 192 ] || fail "pairs" # 120 pairs minus a fifth for validation, twice
for word in max_rss_mb validation_loss cpu_share; do
    grep -q "\"$word\":" "$dir/out" || fail "JSON of train lacks $word"
done

"$NQM_BUILD/tests/tiny_model" "$dir/model.safetensors"
run 0 score --quick --model "$dir/model.safetensors" --json
check_rows score
[ "$(grep -c '"bench": "score"' "$dir/out")" = 5 ] || fail "rows of score"

"$NQM_TOOL" convert lambert:kd=.2 --format npy -o "$dir/table.npy" 2>"$dir/err"
run 0 load "$dir/table.npy" --quick --json
check_rows load
for word in '"subject": "table.npy"' '"name": "to samples"'; do
    grep -q "$word" "$dir/out" || fail "JSON of load lacks $word"
done
run 3 load "$dir/nowhere.bsdf" --quick
run 3 load "$dir/model.safetensors" --quick

run 2 nonsense
run 2 load
run 2 train "$dir/file"
run 2 train --recipe nonsense
run 2 train --epochs 10001
run 3 score --model nonsense
run 2 gemm --precision f64
run 2 gemm --kernels nonsense
run 2 gemm --rounds 0
run 2 gemm --rounds
run 2 gemm --nonsense
run 0 --help
grep -q '^  --rounds N .*\[7\]' "$dir/out" || fail "help"
