#!/bin/sh
# SPDX-License-Identifier: MIT
# Prediction intervals: nqm train and nqm calibrate make them, nqm score, batch and rank print them, nqm eval counts the
# labels inside. A model without intervals reports that; a calibration that would not be valid is refused.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
OMP_NUM_THREADS=1 # these networks are too small to use more threads
export OMP_NUM_THREADS
"${NQM_BUILD:?}/tests/tiny_dataset" "$dir/toy.safetensors" 1 48
"$NQM_BUILD/tests/tiny_dataset" "$dir/other.safetensors" 2 48
"$NQM_BUILD/tests/tiny_dataset" "$dir/small.safetensors" 1 24
"$NQM_BUILD/tests/tiny_model" "$dir/without.safetensors" 16

small="--hidden 32,16 --batch 64 --lr-first 0.001 --epochs 3"

# Training calibrates if there are enough validation materials and none is a training material.
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o "$dir/a.safetensors" $small
grep -q '^interval    95 %, from 288 pairs of 12 materials' "$dir/out" || fail "train: $(cat "$dir/out")"
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o "$dir/pairs.safetensors" $small --split pair --json
[ "$(number calibration 1)" = null ] || fail "a split over pairs was calibrated"
# shellcheck disable=SC2086
run 0 train "$dir/small.safetensors" -o "$dir/small-model.safetensors" $small
grep -q '^interval    none: too few' "$dir/out" || fail "train with few materials"
run 0 info "$dir/a.safetensors"
{ grep -q '^interval    95 %, from 288 pairs of 12 materials' "$dir/out" && grep -q '^## Interval' "$dir/out"; } || fail "models show"
run 0 info "$dir/a.safetensors" --json
[ "$(number materials 1)" = 12 ] || fail "info --json"
run 0 info "$dir/pairs.safetensors"
grep -q '^interval    none: not calibrated' "$dir/out" || fail "info without"
run 0 info "$dir/pairs.safetensors" --json
[ "$(number calibration 1)" = null ] || fail "info --json without"

# Calibration after training: the same table, one section in the card; invalid calibrations are refused.
run 0 calibrate "$dir/a.safetensors" "$dir/toy.safetensors" -o "$dir/b.safetensors" --json
for word in '"schema": 1' '"materials": 12' '"pairs": 288' '"coverage": 0\.' '"mean_width": '; do
    grep -q "$word" "$dir/out" || fail "JSON lacks $word"
done
run 0 calibrate "$dir/a.safetensors" "$dir/toy.safetensors" -o "$dir/b.safetensors"
grep -q '^interval    95 %' "$dir/out" || fail "text of calibrate"
run 0 info "$dir/b.safetensors"
[ "$(grep -c '^## Interval' "$dir/out")" = 1 ] || fail "two sections in the card"
run 0 calibrate "$dir/a.safetensors" "$dir/toy.safetensors" -o -
cmp -s "$dir/out" "$dir/b.safetensors" || fail "the model on standard output"
run 5 calibrate "$dir/pairs.safetensors" "$dir/toy.safetensors" -o "$dir/x.safetensors"
says 'drawn over all'
run 5 calibrate "$dir/a.safetensors" "$dir/small.safetensors" -o "$dir/x.safetensors"
says 'not trained on this dataset'
run 5 calibrate "$dir/a.safetensors" "$dir/other.safetensors" -o "$dir/x.safetensors" --new-materials
says 'directions'
run 5 calibrate "$dir/small-model.safetensors" "$dir/small.safetensors" -o "$dir/x.safetensors"
says 'too few'
[ ! -e "$dir/x.safetensors" ] || fail "a model was written nevertheless"
run 2 calibrate "$dir/a.safetensors" "$dir/toy.safetensors"
run 3 calibrate "$dir/nowhere" "$dir/toy.safetensors" -o "$dir/x.safetensors"
run 4 calibrate "$dir/a.safetensors" "$dir/a.safetensors" -o "$dir/x.safetensors"
run 3 calibrate "$dir/a.safetensors" "$dir/toy.safetensors" -o "$dir/no/such/folder/x"
"$tool" calibrate --help | grep -q 'nqm calibrate my' || fail "help with an example"

# score, batch, rank: low <= jod <= high; identical pairs have the interval [10, 10]; no interval without a calibration.
run 0 score sgd:nickel ward:nickel sgd:nickel -m "$dir/a.safetensors" --json
low=$(number jod_low 1) jod=$(number jod 1) high=$(number jod_high 1)
awk -v l="$low" -v j="$jod" -v h="$high" 'BEGIN {exit !(l <= j && j <= h && l < h)}' || fail "interval: $low $jod $high"
{ [ "$(number jod_low 2)" = 10.0 ] && [ "$(number jod_high 2)" = 10.0 ]; } || fail "identical"
# Pairs far from the training pairs give a warning; models without training pairs have no novelty and give none.
awk -v n="$(number novelty 1)" 'BEGIN {exit !(n > 1)}' || fail "novelty: $(number novelty 1)"
[ "$(grep -c 'test: unlike the training pairs: novelty [1-9]' "$dir/out")" = 1 ] || fail "a warning of the novel pair only"
run 0 score sgd:nickel ward:nickel sgd:nickel -m "$dir/a.safetensors"
grep -q '^nqm score: ward:nickel: unlike the training pairs: novelty [1-9]' "$dir/err" || fail "no remark"
run 0 info "$dir/a.safetensors" --json
awk -v g="$(number novelty_growth 1)" 'BEGIN {exit !(g >= 0 && g <= 10)}' || fail "growth: $(number novelty_growth 1)"
run 0 score sgd:nickel ward:nickel sgd:nickel -m "$dir/without.safetensors" --json
[ "$(number novelty 1)" = null ] || fail "novelty without training pairs"
if grep -q 'unlike the training' "$dir/out"; then fail "a warning without a measure"; fi

run 0 score sgd:nickel ward:nickel -m "$dir/a.safetensors" --json
low=$(number jod_low 1)
run 0 score sgd:nickel ward:nickel -m "$dir/a.safetensors" --csv
grep -q '^reference,test,jod,jod_low,jod_high,delta_e_itp,' "$dir/out" || fail "CSV header of score"
awk -F, -v l="$low" 'NR == 2 {exit !($4 - l < 1e-4 && l - $4 < 1e-4)}' "$dir/out" || fail "CSV of score"
run 0 score sgd:nickel ward:nickel -m "$dir/a.safetensors"
grep -q ' \[[0-9.]*, [0-9.]*\] .*ward:nickel$' "$dir/out" || fail "text of score"
printf 'reference,test\nsgd:nickel,ward:nickel\n' >"$dir/list.csv"
run 0 batch "$dir/list.csv" -m "$dir/a.safetensors" --jsonl
grep -q '"jod":[0-9.]*,"jod_low":[0-9.]*,"jod_high":[0-9.]*,' "$dir/out" || fail "batch: $(cat "$dir/out")"
run 0 rank sgd:nickel ward:nickel sgd:nickel -m "$dir/a.safetensors"
grep -q '  1 .* \[10.00, 10.00\] .*sgd:nickel$' "$dir/out" || fail "rank: $(cat "$dir/out")"
run 0 rank sgd:nickel ward:nickel sgd:nickel -m "$dir/a.safetensors" --json
[ "$(number jod_low 1)" = 10.0 ] || fail "rank --json"
run 0 score sgd:nickel ward:nickel sgd:nickel -m "$dir/without.safetensors" --json
{ [ "$(number jod_low 1)" = null ] && [ "$(number jod_high 2)" = null ]; } || fail "null without a calibration"
for verb in score rank; do
    run 0 $verb sgd:nickel ward:nickel -m "$dir/without.safetensors"
    if grep -q '\[' "$dir/out"; then fail "$verb: an interval without a calibration"; fi
done
run 0 batch "$dir/list.csv" -m "$dir/without.safetensors"
sed -n 2p "$dir/out" | grep -q '^sgd:nickel,ward:nickel,[0-9.]*,,,' || fail "batch without a calibration: $(cat "$dir/out")"

# nqm eval counts the labels inside their intervals.
run 0 eval "$dir/toy.safetensors" -m "$dir/a.safetensors,$dir/pairs.safetensors" --by range --bootstrap 50
[ "$(grep -c 'labels inside its 95 % interval: [0-9.]* % \[' "$dir/out")" -ge 2 ] || fail "eval: $(cat "$dir/out")"
run 0 eval "$dir/toy.safetensors" -m "$dir/a.safetensors,$dir/pairs.safetensors" --bootstrap 50 --json
grep -q '"inside": 0\.' "$dir/out" || grep -q '"inside": 1\.0' "$dir/out" || fail "eval --json"
[ "$(grep -c '"interval": null' "$dir/out")" = 1 ] || fail "eval --json without a calibration"
run 0 eval "$dir/toy.safetensors" -m "$dir/a.safetensors,$dir/pairs.safetensors" --bootstrap 0 --csv
head -n 1 "$dir/out" | grep -q ',coverage,.*,interval_width,' || fail "CSV header of eval"
[ "$(awk -F, '{print NF}' "$dir/out" | sort -u | wc -l)" = 1 ] || fail "CSV fields of eval"

# Answers of people: weights that predict them are written; without a gain there is no file, and the exit code is 1.
awk 'BEGIN {
    print "reference,test_a,test_b,n_a,n_b"
    for (i = 1; i <= 8; ++i)
        for (j = 1; j <= 2; ++j) {
            k = .1 + .04 * i; a = .05 + .05 * i
            printf "\"ggx:kd=%g;alpha=%g\",\"ggx:kd=%g;alpha=%g\",\"ggx:kd=%g,%g,%g;alpha=%g\",4,1\n", k, a, k / 2, a * (1 + .2 * j), k * (1 + .1 * j), k, k * .9, a
        }
}' >"$dir/colour.csv"
run 0 calibrate --human "$dir/colour.csv" -m transport -o "$dir/mine.safetensors"
cp "$dir/out" "$dir/text"
run 0 calibrate --human "$dir/colour.csv" -m transport -o -
cmp -s "$dir/out" "$dir/mine.safetensors" || fail "the model on standard output is another one"
run 0 calibrate --human "$dir/colour.csv" -m transport -o "$dir/again.safetensors" --json
grep -q '"output": ".*again.safetensors"' "$dir/out" || fail "JSON of answers: $(cat "$dir/out")"
mv "$dir/text" "$dir/out"
grep -q '^answers     80 choices, 8 materials$' "$dir/out" || fail "answers: $(cat "$dir/out")"
grep -q '^gain        +0.600 ' "$dir/out" || fail "gain: $(cat "$dir/out")"
run 0 info "$dir/mine.safetensors"
grep -q '^Fitted to 80 answers of people about 8 materials' "$dir/out" || fail "the card: $(cat "$dir/out")"
run 0 eval --human "$dir/colour.csv" -m "transport,$dir/mine.safetensors" --apart --json
[ "$(number majority 1) $(number majority 2)" = "0.0 1.0" ] || fail "the fitted similarity: $(cat "$dir/out")"
sed 's/4,1$/1,1/' "$dir/colour.csv" >"$dir/guesses.csv"
run 1 calibrate --human "$dir/guesses.csv" -m transport -o "$dir/none.safetensors" --json
grep -q '"output": null' "$dir/out" || fail "JSON without a gain"
[ ! -e "$dir/none.safetensors" ] || fail "a file without a gain"
run 5 calibrate --human "$dir/colour.csv" -m "$dir/a.safetensors" -o "$dir/none.safetensors"
run 2 calibrate --human "$dir/colour.csv" "$dir/toy.safetensors" -o "$dir/none.safetensors"
run 2 calibrate "$dir/a.safetensors" -o "$dir/none.safetensors"
