#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm transport make: the model scores, batches and is shown like others; its options change the scene; refusals come before the
# work.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
OMP_NUM_THREADS=1
export OMP_NUM_THREADS
make() {
    code=$1
    shift
    run "$code" transport make "$@"
}

make 0 --light studio --shape sphere --points 64 --id mine -o "$dir/studio.safetensors"
grep -q 'studio.safetensors: 1872 directions, 64 points' "$dir/err" || fail "report: $(cat "$dir/err")"
run 0 info "$dir/studio.safetensors"
grep -q '^id *mine' "$dir/out" || fail "the name: $(cat "$dir/out")"
grep -q '^layers *no network' "$dir/out" || fail "layers"
run 0 score sgd:nickel ward:nickel sgd:nickel --model "$dir/studio.safetensors" --json
jod=$(number jod 1)
awk -v j="$jod" 'BEGIN {exit !(j > 0 && j < 10)}' || fail "JOD $jod"
[ "$(number jod 2)" = 10.0 ] || fail "equal BRDFs"
[ "$(number jod_low 1)" = null ] || fail "an interval without a calibration"
awk -v d="$(number delta_e_itp 1)" 'BEGIN {exit !(d > 1)}' || fail "no Delta-E"
run 0 score sgd:nickel ward:nickel --metric "$dir/studio.safetensors" --json
[ "$(number jod 1)" = "$jod" ] || fail "--metric is not --model"
printf 'reference,test\nsgd:nickel,ward:nickel\n' >"$dir/list.csv"
run 0 batch "$dir/list.csv" --model "$dir/studio.safetensors" --jsonl
grep -q '"jod":[0-9.]*,' "$dir/out" || fail "batch: $(cat "$dir/out")"
run 0 rank sgd:nickel ward:nickel sgd:nickel --model "$dir/studio.safetensors" --json
[ "$(number jod 1)" = 10.0 ] || fail "rank"
run 0 info "$dir/studio.safetensors"

# The same options give the same bytes, on any number of threads; other options another scene.
OMP_NUM_THREADS=2 "$tool" transport make --light studio --shape sphere --points 64 --id mine \
    -o "$dir/again.safetensors" 2>/dev/null
cmp "$dir/studio.safetensors" "$dir/again.safetensors" || fail "the number of threads changes the matrix"
make 0 --light sun --shape sphere --points 64 -o "$dir/sun.safetensors" --json
grep -q '"id": "transport"' "$dir/out" || fail "JSON: $(cat "$dir/out")"
grep -q '"sha256": "[0-9a-f]\{64\}"' "$dir/out" || fail "JSON without a checksum"
run 0 score sgd:nickel ward:nickel --model "$dir/sun.safetensors" --json
[ "$(number jod 1)" != "$jod" ] || fail "the light has no effect"
make 0 --light studio --shape sphere --points 64 --id mine -o -
cmp -s "$dir/out" "$dir/studio.safetensors" || fail "the model on standard output"

# Refusals. An output that cannot be written is found before the light is read.
run 2 transport
make 3 --light studo -o "$dir/x"
says "did you mean 'studio'"
run 2 transport make
run 2 transport show -o "$dir/x"
says "no 'show'"
run 2 transport make make -o "$dir/x"
make 2 --points 100 -o "$dir/x"
says 'points: 100 is no multiple of 32 up to 4096'
make 2 --points 8192 -o "$dir/x"
make 3 --light "$dir/nowhere.hdr" -o "$dir/x"
says 'nowhere.hdr'
make 3 --light "$dir/nowhere.hdr" -o "$dir/no/such/folder/x"
says 'folder/x: cannot write'
printf 'no light' >"$dir/bad.hdr"
make 4 --light "$dir/bad.hdr" -o "$dir/x"
says 'bad.hdr'
[ ! -e "$dir/x" ] || fail "a refusal left a file"
"$tool" transport --help | grep -q 'nqm transport make --light' || fail "help without an example"
