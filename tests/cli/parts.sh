#!/bin/sh
# SPDX-License-Identifier: MIT
# Parts of labels: nqm eval judges those that a model with six outputs predicts, by subset of pairs too, and counts labels
# inside intervals by subset; nqm score, batch and report print them.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
OMP_NUM_THREADS=1 # these networks are too small to use more threads
export OMP_NUM_THREADS
"${NQM_BUILD:?}/tests/tiny_dataset" "$dir/toy.safetensors" 1 48 parts
"$NQM_BUILD/tests/tiny_dataset" "$dir/plain.safetensors" 1 48
small="--hidden 32,16 --batch 64 --lr-first 0.001 --epochs 3"
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o "$dir/six.safetensors" $small --id six
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o "$dir/without.safetensors" $small --id one --parts-weight 0
both=$dir/six.safetensors,$dir/without.safetensors

# holds PATTERN...: the last standard output matches every pattern.
holds() {
    for pattern in "$@"; do
        grep -q -- "$pattern" "$dir/out" || fail "no '$pattern' in $(cat "$dir/out")"
    done
}
# lines N PATTERN: N lines of it match.
lines() { [ "$(grep -c -- "$2" "$dir/out")" = "$1" ] || fail "not $1 lines '$2' in $(cat "$dir/out")"; }

# ---- eval: text. The toy's kinds are near ("gain") and far ("gloss", which its manifest lists as unseen).
run 0 eval "$dir/toy.safetensors" -m "$both" --bootstrap 50 --pairs "$dir/pairs.csv"
holds '^estimate  ' '^six less estimate: ' '^Parts of the label, all: .* that six predicts, 288 pairs of 12 materials' '^Estimate: '
holds '^shift_i  *[01].[0-9]* \[[-0-9., ]*\]  *[01].[0-9]* \[[-0-9., ]*\]  *[01].[0-9]* \[[-0-9., ]*\]  *\(bias\|energy\)  *[0-9.]* % of [0-9]*$'
holds '^contrast  .* \(peak\|width\)  *[0-9.]* % of [0-9]*$' '^structure  .* shape  *[0-9.]* % of ' '^adapted_jod  .* log_log_diff$'
holds '^  near pairs  *[0-9.]* % \[.*\] of 144, width ' '^  far pairs  .* of 144, ' '^  kinds of distortion in training  .* of 144, ' \
    '^  kinds of distortion not in training  .* of 144, '
lines 1 '^Parts of the label'
lines 0 'nearly equal'
head -n 1 "$dir/pairs.csv" |
    grep -q ',estimate,family,.*,shift_i,.*,adapted_jod,six:shift_i,.*,six:adapted_jod,estimate:shift_i,.*,estimate:adapted_jod$' ||
    fail "head of the pairs: $(head -n 1 "$dir/pairs.csv")"
[ "$(sed 's/"[^"]*"/x/g' "$dir/pairs.csv" | awk -F, '{print NF}' | sort -u | wc -l)" = 1 ] || fail "fields of the pairs"
run 0 eval "$dir/toy.safetensors" -m "$dir/six.safetensors" --bootstrap 0 --by subset
holds '^near: 144 pairs of 12 materials' '^far: 144 pairs' '^unseen: 144 pairs' '^Parts of the label, far: ' '^shift_p  *[01].[0-9]*  *[01].[0-9]*  *[01].[0-9]* '
lines 0 '^rounding'

# JSON and CSV have the same.
run 0 eval "$dir/toy.safetensors" -m "$both" --bootstrap 50 --by subset --json
holds '"type": "estimate"' '"with": "estimate"' '"by_subset": \[' '"subset": "near"' '"part": "adapted_jod"' '"name": "chroma_b"' '"by_subset": {'
[ "$(number part 1)" = '"shift_i"' ] || fail "order of the parts"
lines 30 '"same_sign": [01n]'
lines 30 '"part": "' # six parts of all pairs and of four subsets
lines 5 '"parts": null'
run 0 eval "$dir/toy.safetensors" -m "$both" --bootstrap 50 --csv
lines 6 '^all,all,six,part,288,12,'
lines 4 '^subset,[a-z]*,six,coverage,144,12,'
lines 1 '^all,all,estimate,estimate,288,12,'
[ "$(awk -F, '{print NF}' "$dir/out" | sort -u | wc -l)" = 1 ] || fail "CSV fields"
head -n 1 "$dir/out" | grep -q ',rival_3,.*,part,estimate,estimate_low,estimate_high,scalar,scalar_spearman,scalar_low,scalar_high,n_plain,same_sign$' || fail "CSV header"
awk -F, 'NR == 1 {for (i = 1; i <= NF; ++i) at[$i] = i}
    $(at["part"]) == "shift_t" && $(at["scalar"]) == "chroma_b" && $(at["estimate"]) > 0.9 && $(at["spearman"]) > 0.5 {++n}
    $4 == "coverage" && $(at["coverage"]) > 0.5 && $(at["interval_width"]) > 0 && $(at["spearman"]) == "" {++n}
    END {exit n != 9}' "$dir/out" || fail "CSV values: $(cat "$dir/out")"

# ---- score, rank, batch: the columns of a label and the words; empty for a test without a score
columns=shift_i,shift_t,shift_p,contrast,structure,similarity_jod,similarity_low,similarity_high,words
run 3 score sgd:nickel ward:nickel sgd:nickel "$dir/nowhere.binary" -m "$dir/six.safetensors" --csv --metrics mae
[ "$(sed -n 1p "$dir/out")" = "reference,test,jod,jod_low,jod_high,delta_e_itp,identical,n_valid,novelty,verdict,$columns,mae,name,warnings,error" ] || fail "score --csv: $(cat "$dir/out")"
sed -n 2p "$dir/out" | grep -q ',0,16,[0-9.e]*,[a-z ]*,[-0-9.e]*,[-0-9.e]*,[-0-9.e]*,[-0-9.e]*,[0-9.e]*,[0-9.]*,[0-9.]*,[0-9.]*,"*[a-z]' || fail "score --csv: $(cat "$dir/out")"
holds '^sgd:nickel,sgd:nickel,.*,1,16,[0-9.]*,identical,0,0,0,0,0,10,10,10,no visible difference,0,sgd:nickel,,$' 'nowhere.binary,,,,,,,,,,,,,,,,,,,'
run 0 rank sgd:nickel ward:nickel sgd:nickel -m "$dir/six.safetensors" --csv
holds ",$columns," '^sgd:nickel,1,sgd:nickel,.*,0,0,0,0,0,10,10,10,no visible difference,sgd:nickel,$'
printf 'reference,test\nsgd:nickel,ward:nickel\nsgd:nickel,sgd:nickel\n' >"$dir/list.csv"
run 0 batch "$dir/list.csv" -m "$dir/six.safetensors"
holds "^reference,test,jod,.*,n_valid,novelty,verdict,$columns,warnings,error$" '^sgd:nickel,sgd:nickel,.*,10,no visible difference,'
run 0 batch "$dir/list.csv" -m "$dir/six.safetensors" --jsonl
lines 2 '"parts":{"shift_itp":\[[-0-9.,e]*\],"contrast":[-0-9.e]*,"structure":[0-9.e]*,"similarity_jod":[0-9.]*,"similarity_low":[0-9.]*,"similarity_high":[0-9.]*,"words":"[a-z, ]*"},"warnings":'
run 0 batch "$dir/list.csv" -m "$dir/without.safetensors" --json
lines 0 '"parts"'
run 0 batch "$dir/list.csv" -m "$dir/without.safetensors"
holds ',n_valid,novelty,verdict,warnings,error$'
printf 'reference,test,words\n' >"$dir/named.csv"
run 4 batch "$dir/named.csv" -m "$dir/six.safetensors"
says "'words'"
run 0 batch "$dir/named.csv" -m "$dir/without.safetensors"

# The parts of a pair that differs by rounding only are as certainly small as its Delta-E.
run 0 score sgd:chrome 'perturb:bits=12;of=sgd:chrome' -m "$dir/six.safetensors" --csv
awk -F, 'NR == 2 && $11 * $11 < 0.01 && $12 * $12 < 0.01 && $13 * $13 < 0.01 && $15 < 0.1 && $16 > 9.9 {good = 1} END {exit !good}' "$dir/out" ||
    fail "rounding: $(cat "$dir/out")"

# ---- eval: without parts in the labels or the model, and without a matrix, there is none of that.
run 0 eval "$dir/plain.safetensors" -m "$dir/six.safetensors" --bootstrap 0
lines 0 '^estimate\|^Parts\|^Estimate\|less estimate'
lines 1 '^  near pairs'
run 0 eval "$dir/toy.safetensors" -m "$dir/without.safetensors" --bootstrap 0
lines 0 '^Parts'
lines 1 '^estimate'
