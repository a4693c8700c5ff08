#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm score: order and formats of the results, --metrics, --fail-under, lists in which some tests cannot be scored, and
# the documented exit codes. Uses a model with random weights; other tests check the scores of the built-in models.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors"

# score CODE ARGUMENTS...
score() {
    code=$1
    shift
    run "$code" score --model "$dir/model.safetensors" "$@"
}

ref=sgd:nickel
ward=ward:nickel
gloss='perturb:gloss=0.9;of=sgd:nickel'

# Quiet: one value per line, in the order of the arguments.
score 0 $ref $ward "$gloss" $ref -q
[ "$(wc -l <"$dir/out")" = 3 ] || fail "three lines"
[ ! -s "$dir/err" ] || fail "talk without need"
cp "$dir/out" "$dir/forward"
score 0 -q $ref $ref "$gloss" $ward
sed -n '3p;2p;1p' "$dir/out" | sort >"$dir/a"
sort "$dir/forward" | diff - "$dir/a" || fail "scores change with the order"
[ "$(sed -n 1p "$dir/out")" = "$(sed -n 3p "$dir/forward")" ] || fail "the order of the results is not that of the arguments"

# JSON: the documented members; identical pairs; all metrics unless some are selected.
score 0 $ref $ward $ref --json
for word in '"schema": 1' '"name": "nqm"' '"version"' '"id": "tiny"' '"sha256"' '"parameters": 36033' '"results"' '"test": "ward:nickel"' \
    '"warnings"' '"log_diff"' '"rmse"'; do
    grep -q "$word" "$dir/out" || fail "JSON lacks $word"
done
[ "$(number identical 1)" = false ] || fail "ward is not sgd"
[ "$(number identical 2)" = true ] || fail "equal BRDFs are identical"
[ "$(number rmse 2)" = 0.0 ] || fail "equal BRDFs differ by 0"
[ "$(number n_valid 1)" = 500 ] || fail "n_valid"
score 0 $ref $ward --json --metrics mae,log_diff
{ [ "$(grep -c '"rmse"' "$dir/out")" = 0 ] && grep -q '"mae"' "$dir/out" && grep -q '"log_diff"' "$dir/out"; } || fail "--metrics LIST"

score 0 $ref $ward --json --metrics mae,all
{ grep -q '"rmse"' "$dir/out" && grep -q '"log_diff"' "$dir/out"; } || fail "--metrics with all in a list"

# Text: one row per test, a legend; metrics on request.
score 0 $ref $ward $ref --metrics all
grep -q '^model  *tiny$' "$dir/out" || fail "the text names the model"
grep -q 'identical  .*sgd:nickel$' "$dir/out" || fail "the text says identical"
grep -q 'ma_logwe' "$dir/out" || fail "the text holds the metrics"
grep -q '75 % of people' "$dir/out" || fail "legend"
score 0 $ref $ward
grep -q 'rmse' "$dir/out" && fail "metrics without being asked"

# CSV: a header and as many fields in every row; names with commas are quoted.
score 0 $ref $ward 'perturb:tint=1.2,1,1;of=sgd:nickel' --csv
grep -q '^reference,test,jod,jod_low,jod_high,delta_e_itp,identical,n_valid,novelty,verdict,rmse,' "$dir/out" || fail "CSV header"
grep -q '"perturb:tint=1.2,1,1;of=sgd:nickel"' "$dir/out" || fail "CSV quoting"
head -n 1 "$dir/out" | grep -q ',warnings,error$' || fail "CSV columns at the end"
[ "$(sed 's/"[^"]*"/x/g' "$dir/out" | awk -F, '{print NF}' | sort -u | wc -l)" = 1 ] || fail "CSV fields"

# Thresholds.
jod=$(sed -n 1p "$dir/forward")
score 0 $ref $ward -q --fail-under "$(awk -v j="$jod" 'BEGIN {print j - 0.01}')"
score 1 $ref $ward -q --fail-under "$(awk -v j="$jod" 'BEGIN {print j + 0.01}')"
[ "$(sed -n 1p "$dir/out")" = "$jod" ] || fail "the gate must not swallow the results"

# If some tests cannot be scored, the others are scored; the exit code is that of the first error and takes precedence
# over that of --fail-under.
score 3 $ref "$dir/nowhere.binary" $ward -q
{ [ "$(sed -n 1p "$dir/out")" = nan ] && [ "$(sed -n 2p "$dir/out")" = "$jod" ]; } || fail "faults of one test"
grep -q 'nowhere.binary' "$dir/err" || fail "the message names the file"
echo nothing >"$dir/odd.binary"
score 4 $ref "$dir/odd.binary" "$dir/nowhere.binary" $ward --fail-under 10 --json
{ [ "$(number jod 1)" = null ] && [ "$(number jod 3)" != null ]; } || fail "JSON of faults"
grep -q '"error": ".*odd.binary' "$dir/out" || fail "JSON error"
score 2 $ref 'ggx:nonsense=1' -q
score 2 $ref 'ggx:nonsense=1'
! grep -q '75 % of people' "$dir/out" || fail "a legend of no score"
score 3 "$dir/nowhere.binary" $ward -q
[ ! -s "$dir/out" ] || fail "results without a reference"

# Too few values: this reference, a Lambert BRDF with values only for angles of incidence below 30 degrees, has no value
# at most of the model's directions.
if [ -x "${NQM_BUILD:?}/tests/make_brdf_files" ]; then
    "$NQM_BUILD/tests/make_brdf_files" "$dir" >/dev/null
    score 5 "$dir/valid.binary" $ward -q --min-valid 1
    grep -q 'ward:nickel: .* at only [0-9]* of 500 directions' "$dir/err" || fail "too few values"
    score 5 "$dir/valid.binary" $ward -q --invalid error
    score 0 "$dir/valid.binary" $ward --json --min-valid 0
    grep -q 'reference: no value at' "$dir/out" || fail "a warning of missing values"
    for policy in drop zero nearest; do score 0 "$dir/valid.binary" $ward -q --min-valid 0 --invalid $policy; done
fi

# Usage, models.
score 2 $ref
score 2 $ref $ward --json --csv
for form in --csv -q; do score 2 $ref $ward --exact $form; done
score 2 $ref $ward --exact --tolerance -1

# The values themselves: a change that nobody sees is a difference.
near='perturb:scale=1.001;of=sgd:nickel'
score 1 $ref $ref "$near" --exact
grep -q 'equal within 0.0001: values differ by up to 0 %' "$dir/out" || fail "--exact of one BRDF: $(cat "$dir/out")"
grep -q 'NOT equal within 0.0001: values differ by up to 0.0999 %' "$dir/out" || fail "--exact: $(cat "$dir/out")"
grep -q '1 of 2 pairs are not equal within 0.0001' "$dir/err" || fail "--exact says how many: $(cat "$dir/err")"
score 0 $ref "$near" --exact --tolerance .002
score 1 $ref "$near" --exact --json
[ "$(number n_different 1)" = 8192 ] || fail "--exact in JSON"
score 3 $ref "$dir/nowhere.binary" $ref --exact --json
score 2 $ref $ward --metrics rmse,nonsense
grep -q 'log_diff' "$dir/err" || fail "names of the metrics"
score 2 $ref $ward --fail-under eleven
score 2 $ref $ward --invalid maybe
score 2 $ref $ward --unknown
score 6 $ref $ward --model nonsense
score 3 $ref $ward --model "$dir/nowhere.safetensors"
score 4 $ref $ward --model "$dir/odd.binary"
head -c 100000 "$dir/model.safetensors" >"$dir/cut.safetensors"
score 4 $ref $ward --model "$dir/cut.safetensors"
size=$(wc -c <"$dir/model.safetensors")
head -c $((size - 100)) "$dir/model.safetensors" >"$dir/changed.safetensors"
head -c 100 /dev/zero >>"$dir/changed.safetensors"
score 6 $ref $ward --model "$dir/changed.safetensors"
grep -q 'checksum' "$dir/err" || fail "a damaged model"
"$tool" score --help | grep -q 'nqm score sgd:nickel ward:nickel' || fail "help with an example"

# A pair that differs by rounding only is certain, also far from the training pairs; the words are no more certain than the interval.
score 0 sgd:chrome 'perturb:bits=12;of=sgd:chrome' --csv -m default
awk -F, 'NR == 2 && $4 > 9.9 && $3 > 9.9 { good = 1 } END { exit !good }' "$dir/out" || fail "rounding: $(cat "$dir/out")"
score 0 sgd:nickel abc:nickel -m default
grep -q 'between .* and very different' "$dir/out" || fail "a verdict more certain than its interval: $(cat "$dir/out")"
grep -q 'interval: where its ends have different words' "$dir/out" || fail "the verdict contradicts the legend: $(cat "$dir/out")"
[ "$(sed -n '/^JOD 10/,$p' "$dir/out" | awk 'length > 80' | wc -l)" = 0 ] || fail "a legend wider than a terminal"
score 0 $ref $ward # no intervals, no word about them
! grep -q 'interval' "$dir/out" || fail "intervals of a model without them: $(cat "$dir/out")"

# A test whose name is not UTF-8 still has a row; a failed write of the results is an error.
score 3 $ref "$(printf 'caf\351.binary')" --json
[ "$(number test 1)" = '"caf?.binary"' ] || fail "a name in Latin-1 in JSON"
if [ -c /dev/full ]; then
    for form in --json --csv -q; do
        got=0
        "$tool" score --model "$dir/model.safetensors" $ref $ward $form >/dev/full 2>"$dir/err" || got=$?
        [ "$got" = 3 ] || fail "a full disk: exit code $got"
    done
    got=0
    "$tool" info list >/dev/full 2>"$dir/err" || got=$?
    [ "$got" = 3 ] || fail "info on a full disk: exit code $got"
fi

# A mark in every row and a line at the end; identical BRDFs pass every gate; the lower end of the interval is a gate for models
# that have one. NAME=TEST.
run 1 score sgd:nickel a=ward:nickel 'perturb:gloss=.9;of=sgd:nickel' sgd:nickel -m default --fail-under 6
grep -q 'very different  *FAIL  a$' "$dir/out" || fail "a mark: $(cat "$dir/out")"
[ "$(grep -c ' pass  ' "$dir/out")" = 2 ] || fail "marks: $(cat "$dir/out")"
tail -n 1 "$dir/err" | grep -qx 'nqm score: 1 of 3 pairs FAIL: JOD below 6' || fail "the last line: $(cat "$dir/err")"
run 1 score sgd:nickel a=ward:nickel sgd:nickel -m default --fail-under 10 --fail-under-low 3 --csv
head -n 1 "$dir/out" | grep -q ',gate,name,warnings,error$' || fail "a column: $(cat "$dir/out")"
sed -n 2p "$dir/out" | grep -q '^sgd:nickel,ward:nickel,.*,FAIL,a,,$' || fail "a mark in CSV: $(cat "$dir/out")"
sed -n 3p "$dir/out" | grep -q ',pass,sgd:nickel,,$' || fail "identical BRDFs pass: $(cat "$dir/out")"
run 1 score sgd:nickel 'perturb:gloss=.9;of=sgd:nickel' -m default --fail-under 8.4 --fail-under-low 8.4 --json
grep -q '"gate": "FAIL"' "$dir/out" || fail "a mark in JSON"
grep -q 'FAIL: JOD below 8.4 or lower end of the interval below 8.4' "$dir/err" || fail "both gates: $(cat "$dir/err")"
run 0 score sgd:nickel 'perturb:gloss=.9;of=sgd:nickel' -m default --fail-under 8.4 -q
score 5 $ref $ward --fail-under-low 5
run 0 rank r=sgd:nickel w=ward:nickel sgd:nickel -m transport
grep -q ' w$' "$dir/out" || fail "names in a ranking"
run 0 rank sgd:nickel w=ward:nickel -m transport --csv
sed -n 2p "$dir/out" | grep -q '^sgd:nickel,1,ward:nickel,.*,w,$' || fail "names in the CSV of a ranking: $(cat "$dir/out")"
run 0 label r=sgd:nickel w=ward:nickel --points 60 --lights 16
grep -q ' w$' "$dir/out" || fail "names of labels"
(cd "$dir" && cp "${NQM_SOURCE}/tests/cli/score.sh" a=b && run 4 score sgd:nickel a=b) || fail "an existing file is no name"
# Names have no control characters; those of file names and messages are shown as '?'.
run 0 label sgd:nickel a=ward:nickel + sgd:gold-paint a=ward:gold-paint --light sun --points 60 --lights 16
odd=$(printf 'a\033[31m\n\302\233b')
refuses 2 "the name 'a?\[31m???b' has a control character" score sgd:nickel "$odd=ward:nickel"
refuses 3 '/a?\[31m???b: ' info "$dir/$odd"
"$tool" convert ward:nickel -o "$dir/$odd.npy" >"$dir/out" 2>"$dir/err"
grep -q '/a?\[31m???b.npy: ward:nickel as ' "$dir/out" || fail "convert: $(cat "$dir/out")"
for verb in score rank "label --light sun --points 60 --lights 16"; do
    # shellcheck disable=SC2086
    run 0 $verb sgd:nickel "$dir/$odd.npy"
    grep -q '  .*/a?\[31m???b.npy$' "$dir/out" || fail "$verb of an odd file name: $(cat "$dir/out")"
done
run 0 score sgd:nickel "$dir/$odd.npy" --csv
grep -q '31m$' "$dir/out" || fail "a CSV has the file name as it is"
printf '{"asset": {"version": "2.0"}, "materials": [{"name": "x\\u001b[1m"}, {"name": "y"}]}' >"$dir/two.gltf"
run 0 info "$dir/two.gltf"
grep -q '^x?\[1m ' "$dir/out" || fail "the name of a material: $(cat "$dir/out")"
"$tool" sample sgd:nickel | "$tool" score - ward:nickel >"$dir/out"
grep -q '^reference  standard input$' "$dir/out" || fail "standard input has another name: $(cat "$dir/out")"
run 0 score sgd:nickel ward:nickel
grep -q '^seen apart: how similar people find the two materials' "$dir/out" || fail "'seen apart' is not explained"
run 0 score sgd:red-fabric sgd:chrome
[ -z "$(awk 'length($0) > 80' "$dir/out")" ] || fail "lines wider than a terminal: $(awk 'length($0) > 80' "$dir/out")"

# Dark pairs: the bound from ratios of samples must not hide what the pictures show. Labels: 7.21, 3.19, 8.12 (standard errors below .02).
for row in '.001 .002 7.0 7.5' '0 .001 3.0 3.5'; do
    # shellcheck disable=SC2086
    set -- $row
    "$tool" score lambert:kd="$1" lambert:kd="$2" -q >"$dir/out"
    awk -v low="$3" -v high="$4" '{ exit !($1 > low && $1 < high) }' "$dir/out" || fail "albedo $1 and $2: $(cat "$dir/out")"
done
"$tool" score 'ggx:kd=.001;alpha=.4;ks=.02' 'ggx:kd=.002;alpha=.4;ks=.02' -q >"$dir/out"
awk '{ exit !($1 > 7.9 && $1 < 8.3) }' "$dir/out" || fail "dark plastic: $(cat "$dir/out")"
