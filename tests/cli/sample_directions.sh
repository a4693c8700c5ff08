#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm directions and nqm sample: round trip through files, the same set for the same seed, columns, invalid values,
# pipes, refusals.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors" 40

run 0 directions
[ "$(wc -l <"$dir/out")" = 501 ] || fail "500 directions and a header"
[ "$(head -n 1 "$dir/out")" = theta_h,theta_d,phi_d ] || fail "header"
cp "$dir/out" "$dir/default.csv"
run 0 directions -n 500 --seed 1 -o "$dir/again.csv"
diff "$dir/default.csv" "$dir/again.csv" || fail "the defaults are not what the help says"
grep -q 'id [0-9a-f]\{16\}' "$dir/err" || fail "the id"
run 0 directions --seed 2
diff -q "$dir/default.csv" "$dir/out" >/dev/null && fail "another seed, the same set"
awk -F, 'NR > 1 && ($1 < 0 || $1 > 40 || $2 > 40) {bad = 1} END {exit bad}' "$dir/out" && fail "40 degrees is no bound yet"
run 0 directions --max-polar 40
awk -F, 'NR > 1 && ($1 < 0 || $1 > 40 || $2 > 40) {bad = 1} END {exit bad}' "$dir/out" || fail "--max-polar"
run 0 directions -n 50 sgd:nickel sgd:red-fabric -o "$dir/drawn.csv"
run 0 directions show "$dir/drawn.csv"
diff "$dir/drawn.csv" "$dir/out" || fail "what is read is what was written"
run 0 directions show "$dir/drawn.csv" --json
grep -q '"n": 50' "$dir/out" || fail "JSON of directions"
run 0 directions show "$dir/model.safetensors"
[ "$(wc -l <"$dir/out")" = 41 ] || fail "directions of a model"

# Samples: one row per direction, in order; lambert is constant.
run 0 sample lambert:kd=.5,.25,.125 --directions "$dir/drawn.csv" --csv
[ "$(head -n 1 "$dir/out")" = theta_h,theta_d,phi_d,r,g,b ] || fail "columns"
cut -d, -f1-3 "$dir/out" | diff "$dir/drawn.csv" - || fail "directions of the samples"
awk -F, 'function off(a, b) {a = a / b * 3.14159265358979 - 1; return a < -1e-6 || a > 1e-6}
    NR > 1 && (off($4, .5) || off($5, .25) || off($6, .125)) {bad = 1} END {exit bad}' "$dir/out" || fail "values"
cp "$dir/out" "$dir/lambert.csv"
"$tool" sample lambert:kd=.5,.25,.125 -d - <"$dir/drawn.csv" | diff "$dir/lambert.csv" - || fail "directions from a pipe"
run 0 sample sgd:nickel -d "$dir/model.safetensors" --json
{ grep -q '"n": 40' "$dir/out" && [ "$(grep -c '"theta_h"' "$dir/out")" = 40 ]; } || fail "JSON of samples"

# Below the horizon there is no value: an empty field, null, or the value of the --invalid policy.
printf 'theta_h,theta_d,phi_d\n10,20,30\n89,80,0\n' >"$dir/horizon.csv"
run 0 sample lambert:kd=.5,.5,.5 -d "$dir/horizon.csv"
tail -n 1 "$dir/out" | grep -q '^89,80,0,,,$' || fail "an empty field where there is no value"
grep -q 'no value at 1 of 2' "$dir/err" || fail "silence about a hole"
run 0 sample lambert:kd=.5,.5,.5 -d "$dir/horizon.csv" --invalid zero
tail -n 1 "$dir/out" | grep -q '^89,80,0,0,0,0$' || fail "--invalid zero"
run 0 sample lambert:kd=.5,.5,.5 -d "$dir/horizon.csv" --json
grep -q '"g": null' "$dir/out" || fail "null where there is no value"
run 5 sample lambert:kd=.5,.5,.5 -d "$dir/horizon.csv" --invalid error

run 2 sample
run 2 sample lambert:kd=.5,.5,.5 --invalid never
run 2 sample lambert:kd=.5,.5,.5 --csv --json
run 3 sample "$dir/nowhere.binary"
run 3 sample lambert:kd=.5,.5,.5 -d "$dir/nowhere.csv"
printf 'theta_h,theta_d\n1,2\n' >"$dir/short.csv"
run 4 sample lambert:kd=.5,.5,.5 -d "$dir/short.csv"
grep -q 'short.csv.*phi_d' "$dir/err" || fail "the message names the file"
run 2 directions show
run 2 directions -n 0
run 2 directions -n 1000000
run 3 directions "$dir/nowhere.binary"
run 3 directions -o "$dir/no/such/folder.csv"
run 4 directions show "$dir/short.csv"
