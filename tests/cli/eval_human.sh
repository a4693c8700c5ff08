#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm eval --human: human scores and choices against models and metrics, in all formats; further columns of nqm eval;
# errors.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
OMP_NUM_THREADS=1
export OMP_NUM_THREADS
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors" 60
"$NQM_BUILD/tests/tiny_dataset" "$dir/toy.safetensors"

# has PATTERN...: every pattern must match a line of out.
has() {
    for word in "$@"; do
        grep -q -- "$word" "$dir/out" || fail "no '$word' in: $(cat "$dir/out")"
    done
}
# field ROW COLUMN: print a field of the CSV in out.
field() {
    awk -F, -v row="$1" -v column="$2" 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == column) c = i }
        NR > 1 && $1 == row { print $c }' "$dir/out"
}

# Scores: made-up human scores in the order of the mean absolute difference.
cat >"$dir/scores.csv" <<END
reference,test,score,kind
lambert:kd=.2,lambert:kd=.21,5,near
lambert:kd=.2,lambert:kd=.25,4,near
lambert:kd=.2,lambert:kd=.4,1,far
lambert:kd=.5,lambert:kd=.52,4.5,near
lambert:kd=.5,lambert:kd=.6,3,far
lambert:kd=.5,lambert:kd=.9,0.5,far
END
run 0 eval --human "$dir/scores.csv" --model "$dir/model.safetensors" --pairs "$dir/pairs.csv" --by all
has 'column: score' '^all: 6 pairs of 2 materials' '^near: 3 pairs' '^tiny  ' '^mae ' 'differ by more than 0\.' '^tiny less .*, best of the eight: '
[ "$(wc -l <"$dir/pairs.csv")" = 7 ] || fail "a line a score"
grep -q nan "$dir/pairs.csv" && fail "nan in a CSV"
run 0 eval "$dir/scores.csv" --human --model none --json --bootstrap 50
has '"kind": "score"' '"materials": 2' '"spearman": 1.0' '"best_of_family": true' '"n_ordered": 6' '"order": 1.0' '"mae": null'
sed 's/,score,/,distance,/' "$dir/scores.csv" >"$dir/distance.csv"
run 0 eval --human "$dir/distance.csv" --model none --json
has '"spearman": -1.0' '"order": 0.0'
sed 's/,score,/,jod,/' "$dir/scores.csv" >"$dir/jod.csv"
run 0 eval --human "$dir/jod.csv" --model "$dir/model.safetensors" --by range
has 'more than 0.25' '^JOD < 9.5: 6 pairs' '^JOD >= 9.5: no pairs'

# Choices: paths relative to --root; counts.
printf 'reference,test_a,test_b,n_a,n_b\nref.binary,near.binary,sgd:brass,8,2\nlambert:kd=.5,lambert:kd=.6,lambert:kd=.9,3,1\n' >"$dir/choices.csv"
run 3 eval --human "$dir/choices.csv" --model none
says 'choices.csv: row 1: '
mkdir "$dir/brdfs"
"$tool" convert lambert:kd=.3 -o "$dir/brdfs/ref.binary" >"$dir/log" 2>&1 || fail "convert"
cp "$dir/brdfs/ref.binary" "$dir/brdfs/near.binary"
run 0 eval --human "$dir/choices.csv" --root "$dir/brdfs" --model "$dir/model.safetensors"
has '14 between 2 pairs of tests, 2 references of 2 materials' 'reaches 0.786' '^mae  *\*\{0,1\}  *0.786  '  'best of the eight' '^No intervals: .* at least 4 materials'
run 0 eval --human "$dir/choices.csv" --root "$dir/brdfs" --model "$dir/model.safetensors" --json
has '"ceiling": 0.785714' '"triplets": 2' '"choices": 14.0' '"agreement": 0.785714' '"contrasts": \[' '"share_below_0"'
cp "$dir/out" "$dir/first"
run 0 eval --human "$dir/choices.csv" --root "$dir/brdfs" --model "$dir/model.safetensors" --json
cmp -s "$dir/out" "$dir/first" || fail "equal commands, different results"
run 0 eval --human "$dir/choices.csv" --root "$dir/brdfs" --model "$dir/model.safetensors" --csv
[ "$(awk -F, '{print NF}' "$dir/out" | sort -u | wc -l)" = 1 ] || fail "CSV fields"
[ "$(field mae agreement)" = 0.785714286 ] || fail "agreement in CSV: $(field mae agreement)"
[ "$(field tiny rival_2)" = log_diff ] || fail "rivals in CSV"

# Intervals need at least 4 materials, and resamples.
for kd in 3 4 5 6; do
    printf 'lambert:kd=.%s,lambert:kd=.%s2,4,near\nlambert:kd=.%s,lambert:kd=.%s4,5,near\n' $kd $kd $kd $kd
done | sed '1i reference,test,score,kind' >"$dir/four.csv"
run 0 eval --human "$dir/four.csv" --model none
has '^all: 8 pairs of 4 materials' '^mae .* \[' '^Correlations .* Intervals: bootstrap over materials'
head -n 7 "$dir/four.csv" >"$dir/three.csv"
run 0 eval --human "$dir/three.csv" --model none
has '^all: 6 pairs of 3 materials' 'No intervals: they need --bootstrap above 0 and at least 4 materials'
! grep -q '[0-9] \[' "$dir/out" || fail "intervals of 3 materials"
head -n 4 "$dir/scores.csv" >"$dir/one.csv"
run 0 eval --human "$dir/one.csv" --model none
has '^all: 3 pairs of 1 materials' 'No intervals: they need --bootstrap above 0 and at least 4 materials'
printf 'lambert:kd=.%s,lambert:kd=.9,lambert:kd=.8,3,1\n' 3 4 >>"$dir/choices.csv"
run 0 eval --human "$dir/choices.csv" --root "$dir/brdfs" --model none
has '^mae .* \[' '^Intervals: bootstrap over materials'
run 0 eval --human "$dir/choices.csv" --root "$dir/brdfs" --model none --bootstrap 0
has '^No intervals' '^mae  *\*\{0,1\}  *0.591  '
! grep -q '[0-9] \[' "$dir/out" || fail "intervals without resamples"

# The same further statistics for a dataset.
run 0 eval "$dir/toy.safetensors" --model none --split all --bootstrap 100
has ' order$' '^[a-z_]* \* ' 'differ by more than 0.25'
run 0 eval "$dir/toy.safetensors" --model none --split all --bootstrap 100 --margin 2 --json
has '"order_margin": 2.0' '"ci95_order": \[' '"ci95_pearson": \['

run 0 eval "$dir/toy.safetensors" --model none --split all --bootstrap 100 --csv
[ "$(awk -F, '{print NF}' "$dir/out" | sort -u | wc -l)" = 1 ] || fail "CSV fields of a dataset"
head -n 1 "$dir/out" | grep -q ',kendall_low,.*,order,.*,rival,.*,share_2_below_0,coverage,.*,interval_width,' || fail "CSV columns"

# Models of different directions share a table: each row is that of the model alone, choices and intervals too.
for list in jod choices; do
    [ -e "$dir/$list.csv" ] || fail "no $list.csv"
    run 0 eval --human "$dir/$list.csv" --root "$dir/brdfs" --model "default,$dir/model.safetensors,transport" --csv
    grep '^all,all,[a-z]*,model,\|^[a-z]*,model,' "$dir/out" >"$dir/together"
    for model in default "$dir/model.safetensors" transport; do
        run 0 eval --human "$dir/$list.csv" --root "$dir/brdfs" --model "$model" --csv
        grep '^all,all,[a-z]*,model,\|^[a-z]*,model,' "$dir/out"
    done >"$dir/alone"
    [ -s "$dir/alone" ] || fail "no rows of models: $(cat "$dir/out")"
    cut -d, -f1-17 "$dir/alone" >"$dir/alone.front"
    cut -d, -f1-17 "$dir/together" | cmp - "$dir/alone.front" || fail "rows of $list: $(cat "$dir/together")"
done

# Errors. Models with other directions, and splits without pairs: what is there, and the way out.
run 5 eval "$dir/toy.safetensors" --model "$dir/model.safetensors" --split all
says "toy.safetensors: model 'tiny' uses 60 directions (identity [0-9a-f]\{16\}), the dataset 16 other ones (identity [0-9a-f]\{16\}): .*--model none"
run 5 eval --human "$dir/jod.csv" --model none --split train
says "jod.csv: the dataset has no pair in the split 'train'; it has 6 in 'test': --split selects"
run 4 eval "$dir/jod.csv" --model none
says 'jod.csv: is no dataset but a CSV with the column reference: answers of people need --human'
run 2 eval --human "$dir/choices.csv" --root "$dir/brdfs" --model none --by kind
says 'choices'
run 2 eval --human "$dir/scores.csv" --labels x.csv --model none
says '--labels'
run 2 eval "$dir/toy.safetensors" --root "$dir" --model none
says '--human'
run 3 eval --human "$dir/nowhere.csv" --model none
echo 'reference,test,opinion' >"$dir/bad.csv"
run 4 eval --human "$dir/bad.csv" --model none
says 'none of the columns'
printf 'reference,test,score\nlambert:kd=.2,lambert:kd=.3,1\nlambert:kd=.2,lambert:kd=.3,fine\n' >"$dir/bad.csv"
run 4 eval --human "$dir/bad.csv" --model none
says 'bad.csv: line 3'
printf 'reference,test,score\nlambert:kd=.2,lambert:kd=.3,1\nlambert:kd=.2,lambert:kx=.3,2\n' >"$dir/bad.csv"
run 2 eval --human "$dir/bad.csv" --model none
says 'bad.csv: row 2'

# Materials seen apart: a model without parts keeps its JOD; --apart is about people only.
run 0 eval --human "$dir/choices.csv" --root "$dir/brdfs" --model "$dir/model.safetensors" --apart --json
grep -q '"agreement"' "$dir/out" || fail "no agreement"
run 2 eval "$dir/toy.safetensors" --apart --model none
says '--apart needs --human'
