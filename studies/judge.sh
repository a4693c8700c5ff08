#!/bin/sh
# SPDX-License-Identifier: MIT
# Evaluation on unseen materials, run after models/make.sh with the same WORK: trains further seeds of both recipes,
# then evaluates every model and the boosted-trees control on the test pairs and on the validation materials. Resumable.
# Results: WORK/judged-*.txt, .csv, .json. (The recipe `paper` draws its validation pairs from all materials, so its
# results on the validation materials are too optimistic.)
# usage: studies/judge.sh WORK [SEEDS [PAPER_SEEDS]]   (default: 3 seeds each; the first is the shipped model)
set -eu
work=$(cd "${1:?usage: studies/judge.sh WORK [SEEDS [PAPER_SEEDS]]}" && pwd)
seeds=${2:-3}
paper_seeds=${3:-$seeds}
here=$(cd "$(dirname "$0")" && pwd)
nqm=$(realpath "${NQM_TOOL:-$here/../build/nqm}")
cd "$work"

models=
for recipe in "default nqm $seeds" "paper paper $paper_seeds"; do
    # shellcheck disable=SC2086 # three words
    set -- $recipe
    name=$1
    models=$models,$name.safetensors
    seed=2
    while [ "$seed" -le "$3" ]; do
        id=$name-seed$seed
        if [ ! -f "$id.safetensors" ]; then
            resume=
            [ ! -f "$id.checkpoint" ] || resume=--resume
            "$nqm" train train.safetensors --recipe "$2" --id "$id" --seed "$seed" -o "$id.safetensors" \
                --checkpoint "$id.checkpoint" $resume --log "$id.csv"
        fi
        models=$models,$id.safetensors
        seed=$((seed + 1))
    done
done
"$nqm" eval train.safetensors --split all --bootstrap 0 --model "${models#,}" --pairs train-pairs.csv >/dev/null
"$nqm" eval test.safetensors --split all --by all --model "${models#,}" --pairs test-pairs.csv --json >judged.json
for split in validation test; do
    /usr/bin/python3 "$here/control.py" train-pairs.csv test-pairs.csv --judge $split --seeds "$seeds" --csv judged-$split.csv \
        --json judged-$split.json >judged-$split.txt
done
cat judged-test.txt
