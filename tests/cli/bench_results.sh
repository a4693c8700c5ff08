#!/bin/sh
# SPDX-License-Identifier: MIT
# bench/results.py: kept results are valid against their schema, a made-up regression is found and a slower machine's peak excuses it, and the
# page has every kept machine. No test requires a speed.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
command -v python3 >/dev/null 2>&1 || { echo "skipped: there is no python3"; exit 77; }
mkdir "$dir/bench" "$dir/runs"
cp "$NQM_SOURCE/bench/results.py" "$dir/bench"

# results CODE ARGUMENTS...: as run, of the script.
results() {
    code=$1
    shift
    got=0
    python3 "$dir/bench/results.py" "$@" >"$dir/out" 2>"$dir/err" || got=$?
    [ "$got" = "$code" ] || fail "exit code $got, not $code: $*"
}

"${NQM_BUILD:?}/nqm-bench" gemm --quick --precision f32 --rounds 1 -o "$dir/runs/gemm.json" >"$dir/out"
results 0 keep here "$dir/runs" "$dir/no-peers.json"
kept="$dir/bench/results/here.json"
results 0 check "$kept"
for word in '"kind": "here"' '"commit":' '"cpu_id":' '"family":' '"compiler":' '"utilisation":' '"unit":'; do
    grep -q "$word" "$kept" || fail "no $word in the kept results"
done
results 0 page
grep -q '^| product of layer' "$dir/out" || grep -q '^| peak of | GFLOP/s' "$dir/out" || fail "page"

# edit EXPRESSION FILE: change the first timed row of the kept results.
edit() {
    python3 - "$kept" "$2" "$1" <<'TEXT'
import json, sys
d = json.load(open(sys.argv[1]))
r = next(r for r in d["rows"] if r["bench"] == "gemm" and "ratio" in r)
exec(sys.argv[3])
json.dump(d, open(sys.argv[2], "w"))
TEXT
}
results 0 compare "$kept" "$kept"
edit 'r["seconds"] *= 2; r["cpu_seconds"] *= 2; r["ratio"] /= 2; r["ratio_cpu"] /= 2' "$dir/slow.json"
results 1 compare "$kept" "$dir/slow.json"
[ "$(grep -c SLOWER "$dir/out")" = 1 ] || fail "a made-up regression"
grep -q '; 1 slower by more than 10 %' "$dir/out" || fail "number of regressions"
results 0 compare "$kept" "$dir/slow.json" 0.6
results 0 compare "$dir/slow.json" "$kept"
edit 'r["seconds"] *= 2; r["ratio"] /= 2' "$dir/slow_peak.json" # other programs ran: the processor time is the same
results 0 compare "$kept" "$dir/slow_peak.json"
edit 'd["utilisation"] = 0.5' "$dir/busy.json"
results 0 compare "$kept" "$dir/busy.json"
grep -q 'utilisation 0.5: other programs' "$dir/out" || fail "a disturbed run"

# Documents that are not valid.
edit 'del d["machine"]["cpu_id"]' "$dir/bad.json"
results 1 check "$dir/bad.json"
grep -q "machine 'cpu_id' is missing" "$dir/out" || fail "machine"
edit 'r["seconds"] = 0' "$dir/bad.json"
results 1 check "$dir/bad.json"
grep -q "'seconds' is 0" "$dir/out" || fail "a time of 0"
results 1 compare "$dir/bad.json" "$kept"
results 1 compare "$dir/nowhere.json" "$kept"
results 1 keep here "$dir/bench" "$dir/no-peers.json"
results 2 nonsense

# The time of a command.
results 0 time 2 "${NQM_TOOL:?}" --version
grep -q 'nqm --version  seconds [0-9.e-]*  seconds_median [0-9.e-]*$' "$dir/out" || fail "time: $(cat "$dir/out")"
results 1 time 2 "$NQM_TOOL" --nonsense
results 2 time none "$NQM_TOOL"

# The results of this repository, and their page.
set -- "$NQM_SOURCE"/bench/results/*.json
[ ! -f "$1" ] || results 0 check "$@"
if [ -f "$NQM_SOURCE/bench/results/machines.md" ]; then
    python3 "$NQM_SOURCE/bench/results.py" page | cmp - "$NQM_SOURCE/bench/results/machines.md" || fail "python3 bench/results.py page >bench/results/machines.md"
fi
