#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm learn: the file of a dictionary lists its four training materials and is the same for one and two threads; Ctrl-C
# leaves no file; bad arguments give the documented exit codes.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
cd "$dir"
learn() { "$tool" learn sparse sgd:nickel sgd:green-plastic lambert:kd=0.4,0.2,0.1 ward:pink-felt "$@" 2>err; }

OMP_NUM_THREADS=1 learn --steps 2 -o one.safetensors || fail "learn"
grep -q '4 BRDFs' err || fail "summary"
OMP_NUM_THREADS=2 learn --steps 2 -o two.safetensors --json >out || fail "learn --json"
cmp one.safetensors two.safetensors || fail "two threads give another file"
for word in '"encoder": "sparse"' '"references": 4' '"seed": 1' '"output": "two.safetensors"'; do
    grep -q "$word" out || fail "no $word: $(cat out)"
done
learn --steps 2 --seed 2 -o other.safetensors
if cmp -s one.safetensors other.safetensors; then fail "another seed gives the same file"; fi
head -c 2000 one.safetensors | tr -d '\134' | grep -qaF '"sgd:nickel","sgd:green-plastic"' || fail "the file does not name its references"

rm -f ./*.safetensors
"$tool" learn sparse sgd:nickel sgd:green-plastic --steps 1000000 -o stopped.safetensors 2>err &
sleep 0.5
ctrl_c
[ -z "$(find . -name 'stopped*')" ] || fail "a stopped run leaves a file"

refuses 2 . learn dictionary sgd:nickel -o x
refuses 2 . learn sparse -o x
refuses 2 . learn sparse sgd:nickel
refuses 2 . learn sparse 'lambert:kd=5000' -o x
refuses 3 . learn sparse missing.bsdf -o x
refuses 3 . learn sparse sgd:nickel sgd:green-plastic --steps 1 -o missing/x
refuses 5 . learn sparse lambert:kd=0.3 -o x
