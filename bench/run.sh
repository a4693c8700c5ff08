#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs all benchmarks of nqm and writes the results to FOLDER: a line for each to report.txt, all values to NAME.json. ./dev
# bench runs it; it takes about two minutes. The results are valid only if no other program runs.
# usage: run.sh NQM-BENCH FOLDER [options of nqm-bench, such as --quick]
set -eu
program=$1 folder=$2
shift 2
data=${NQM_DATA:-$(dirname "$0")/../../shared/data}
mkdir -p "$folder"

# report NAME ARGUMENTS...: one run of nqm-bench.
report() {
    name=$1
    shift
    printf '== nqm-bench %s\n' "$*" >&2
    printf '\n== nqm-bench %s\n' "$*"
    "$program" "$@" -o "$folder/$name.json"
}

{
    printf 'Benchmarks, %s\n' "$(date -u +%Y-%m-%d)"
    report gemm gemm "$@"
    report train train "$@"
    report train-nqm train --recipe nqm --epochs 5 "$@"
    report score score "$@"
    "$(dirname "$program")/nqm" convert 'ggx:kd=.2,.1,.05;ks=.5;alpha=.1;f0=.1' -o "$folder/merl.binary" 2>/dev/null
    set -- load "$@" "$folder/merl.binary"
    for file in "$data/rgl/satin_purple_rgb.bsdf" "$data/rgl/cg_sunflower_rgb.bsdf"; do
        [ ! -f "$file" ] || set -- "$@" "$file"
    done
    [ ! -f "$data/nbrdf/merl_nbrdf.zip" ] || set -- "$@" "$data/nbrdf/merl_nbrdf.zip:gold-paint"
    report load "$@"
    printf '\n== commands\n'
    for command in --version 'score sgd:nickel ward:nickel -q'; do
        # shellcheck disable=SC2086 # words
        python3 "$(dirname "$0")/results.py" time 20 "$(dirname "$program")/nqm" $command
    done
} >"$folder/report.txt"
cat "$folder/report.txt"
