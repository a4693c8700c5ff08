#!/bin/sh
# SPDX-License-Identifier: MIT
# Ctrl-C in every verb that can work for seconds: the exit code is 130, nothing is on standard output, and no output and no
# temporary file is left, except what a verb keeps for a later run. `info` and `calibrate` end at once with any input made here. NQM_INTERRUPT_TIMES names a file for the times to the end.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
make=$NQM_BUILD/tests
in=$dir/in
mkdir "$in" "$dir/work"
"$make/make_brdf_files" "$in" >/dev/null
"$make/tiny_dataset" "$in/toy.safetensors" 1 48
"$tool" directions -n 2000 -o "$in/directions.csv" 2>"$dir/err"
network=$in/valid.bin:second # a neural process: the slowest BRDF
awk 'BEGIN { print "reference,test"; for (i = 0; i < 100000; ++i) printf "sgd:nickel,ggx:kd=%.6f;alpha=.3\n", i / 100001 }' >"$in/list.csv"
awk 'BEGIN { print "DeltaE,JOD"; for (i = 0; i < 300000; ++i) print i % 300 / 10 "," i * 7919 % 1000 / 100 }' >"$in/labels.csv"
awk -v n="$network" 'BEGIN { print "reference,test"; for (i = 1; i < 200; ++i) print n ",perturb:scale=" i ";of=" n "\nsgd:brass,perturb:gloss=" i / 10 ";of=sgd:brass" }' >"$in/pairs.csv"
cd "$dir/work"
signal=INT

# stops NAME KEPT ARGUMENTS...: interrupt the verb; KEPT is a regular expression for files that it may leave (- if none).
stops() {
    name=$1 kept=$2
    shift 2
    "$tool" "$@" >"$dir/out" 2>"$dir/err" &
    pid=$!
    while [ -d /proc/$pid ] && ! grep -q 'SigCgt:.*[2367abef]$' /proc/$pid/status 2>/dev/null; do sleep 0.05; done
    sleep "${NQM_INTERRUPT_AFTER:-0.4}"
    begin=$(date +%s.%N)
    kill -$signal $pid 2>/dev/null || fail "$name: it ended before Ctrl-C"
    got=0
    wait $pid || got=$?
    [ -z "${NQM_INTERRUPT_TIMES:-}" ] ||
        echo "$name $begin $(date +%s.%N)" | awk '{ printf "%-20s %.2f s\n", $1, $3 - $2 }' >>"$NQM_INTERRUPT_TIMES"
    [ "$got" = 130 ] || fail "$name: exit code $got after Ctrl-C"
    [ ! -s "$dir/out" ] || fail "$name: results on standard output"
    left=$(find . -type f | grep -v "^./$kept" || true)
    [ -z "$left" ] || fail "$name: files are left: $left"
    rm -rf ./*
}

stops label - label sgd:nickel ward:nickel --points 204800 --lights 2000
stops label-network - label "$network" "$network" --exact
stops render - render sgd:nickel -o picture.png --size 2000 --quality
stops report - report sgd:nickel ward:nickel "$network" -o page.html --size 1000
stops fit - fit --model all "$network" -o fitted
stops dataset - dataset "$in/pairs.csv" --directions "$in/directions.csv" -o corpus.safetensors
stops dataset-work groups/ dataset "$in/pairs.csv" --directions "$in/directions.csv" \
    -o corpus.safetensors --work groups
stops train - train "$in/toy.safetensors" -o trained.safetensors --epochs 10000
stops batch scores.csv.pieces/ batch "$in/list.csv" -o scores.csv
stops batch-work pieces/ batch "$in/list.csv" -o scores.csv --work pieces
stops eval - eval "$in/toy.safetensors" --model none --bootstrap 1000000
stops translate - translate "$network" "$in/valid.bsdf" sgd:nickel sgd:brass ward:nickel --to openpbr -d materials
stops convert - convert "$network" -o table.binary
stops regress - regress "$in/labels.csv"
stops transport - transport make --points 2048 -o transport.safetensors
# Many times: the third ends the process at once.
"$tool" train "$in/toy.safetensors" -o trained.safetensors --epochs 10000 >"$dir/out" 2>"$dir/err" &
pid=$!
while [ -d /proc/$pid ] && ! grep -q 'SigCgt:.*[2367abef]$' /proc/$pid/status 2>/dev/null; do sleep 0.05; done
for i in 1 2 3 4 5; do kill -INT $pid 2>/dev/null && sleep 0.02; done
got=0
wait $pid || got=$?
[ "$got" = 130 ] || fail "exit code $got after five times Ctrl-C"
signal=HUP # the terminal is closed
stops report-hangup - report sgd:nickel ward:nickel "$network" -o page.html --size 1000
signal=INT
stops check - check --json "$network" "$network" "$network" "$network" "$network" "$network"
