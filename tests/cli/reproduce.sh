#!/bin/sh
# SPDX-License-Identifier: MIT
# studies/reproduce.py on a made-up study in the authors' layout (tests/tools/authors_folder.c): its values equal those of
# separate runs of nqm regress, train and eval, the final table is complete, finished trainings are not repeated,
# interrupted ones are resumed, and messages name missing inputs.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
OMP_NUM_THREADS=1
export OMP_NUM_THREADS
script="${NQM_SOURCE:?}/studies/reproduce.py"
# study CODE ARGUMENTS...: as run, of the script.
study() {
    code=$1
    shift
    got=0
    python3 "$script" "$@" >"$dir/out" 2>"$dir/err" || got=$?
    [ "$got" = "$code" ] || fail "exit code $got, not $code: $*"
}

# values KEY FILE: print the values of KEY, one per line, in order.
values() { sed -n 's/^ *"'"$1"'": \([^,[{]*\),*$/\1/p' "$2"; }
# same KEY FILE: every value of KEY in FILE is also a value of KEY in the study.
same() {
    [ -n "$(values "$1" "$2")" ] || fail "$2 has no $1"
    values "$1" "$2" | while read -r value; do
        values "$1" "$dir/study.json" | grep -qxF -- "$value" || fail "$1 is $value by hand"
    done
}

# The whole study: two recipes, one seed, two epochs.
mkdir "$dir/data"
"${NQM_BUILD:?}/tests/authors_folder" "$dir/data"
study 0 "$dir/data" --seeds 1 --epochs 2 -o "$dir/study" --json
cp "$dir/out" "$dir/study.json"
cmp "$dir/out" "$dir/study/reproduce.json" || fail "--json and reproduce.json differ"
[ "$(values published "$dir/study.json" | wc -l)" = 19 ] || fail "19 published figures"
[ "$(grep -c '"type": "m' "$dir/out")" = 11 ] || fail "a bar a recipe and a metric"

# The same steps by separate commands.
train="$dir/data/uniform_rand_500 --labels $dir/data/labels_balanced_train.csv"
test="$dir/data/test --labels $dir/data/labels_real.csv"
run 0 regress "$dir/data/labels_real.csv" --json
for key in b1 b2 b3 rmse; do
    same "$key" "$dir/out"
done
for recipe in paper notebook; do
    # shellcheck disable=SC2086
    run 0 train $train --recipe $recipe --id $recipe-1 --seed 1 --epochs 2 -o "$dir/$recipe.safetensors" --json
    cmp "$dir/$recipe.safetensors" "$dir/study/$recipe-1.safetensors" || fail "another model by hand: $recipe"
    for key in sha256 parameters n_train n_validation steps train_loss validation_loss; do
        same "$key" "$dir/out"
    done
    [ "$(wc -l <"$dir/study/$recipe-1-loss.csv")" = 3 ] || fail "a line an epoch"
    [ ! -e "$dir/study/$recipe-1.checkpoint" ] || fail "a checkpoint of a finished training"
done
# shellcheck disable=SC2086
run 0 eval $test --model "$dir/paper.safetensors,$dir/notebook.safetensors" --json
for key in spearman spearman_mean_by_material pearson kendall mae rmse r2; do
    same "$key" "$dir/out"
done
[ "$(values spearman "$dir/out" | wc -l)" -ge 11 ] || fail "two models and nine metrics"

# A second run, as text: nothing is trained again, and the table is complete.
touch "$dir/before"
study 0 "$dir/data" --seeds 1 --epochs 2 -o "$dir/study"
[ -z "$(find "$dir/study" -name '*-1*' -newer "$dir/before")" ] || fail "a finished training was done again"
# line NAME PUBLISHED VERDICT
line() {
    grep -q "^$1  .* $2 .*  $3\$" "$dir/out" || fail "the table lacks '$1', $2, '$3': $(grep "^$1" "$dir/out")"
}
line 'JOD curve, b1' -14.11197 reproduced
line 'JOD curve, b2' -0.47364 reproduced
line 'JOD curve, b3' -0.2148 reproduced
line 'training examples' 5344 'not comparable: other data'
line 'validation examples' 668 'not comparable: other data'
line 'whitening, mean' 0.69127 'not comparable: other data'
line 'whitening, std' 0.55376 'not comparable: other data'
line 'training labels, mean' 6.67318 'not comparable: other data'
line 'training labels, std' 1.96393 'not comparable: other data'
line 'parameters' 4171125 reproduced
line 'model size, MB' 15.91 reproduced
line 'Spearman, mean over materials' 0.67 'not comparable: other data'
line 'Spearman, all pairs' 0.67 'not comparable: other data'
line 'lead over the best of the 8' '> 0' 'not comparable: other data'
line 'MAE, JOD' 1.137 'not comparable: other data'
line 'RMSE, JOD' 1.575 'not comparable: other data'
line 'R2' 0.326 'not comparable: other data'
line 'training, s' 36 'not comparable: other machine'
line 'score, ms a pair' 0.04 'not comparable: other machine'
[ "$(grep -c '^[a-z_]*  *\*  *[0-9.-]* \[' "$dir/out")" = 4 ] || fail "the better of four pairs of baselines"

# The bar chart: one line per recipe and per metric, with the columns of nqm eval.
run 0 eval "$dir/data/test" --labels "$dir/data/labels_real.csv" --model none --csv
head -n 1 "$dir/out" | cut -d, -f1-17 >"$dir/head"
head -n 1 "$dir/study/bars.csv" | cut -d, -f1-17 | cmp - "$dir/head" || fail "columns of the bars"
[ "$(wc -l <"$dir/study/bars.csv")" = 12 ] || fail "bars"
grep -qF "$(grep '^all,all,ma_crwe,' "$dir/out" | cut -d, -f1-13)" "$dir/study/bars.csv" || fail "a bar is not eval's"

# A run with other options does not overwrite the results.
study 5 "$dir/data" --seeds 1 --epochs 3 -o "$dir/study"
says 'paper-1.json is of a training with epochs 2, not 3'
cp "$dir/study/paper-1.json" "$dir/record"
sed 's/"nqm_version": "[^"]*"/"nqm_version": "0.0.9"/' "$dir/record" >"$dir/study/paper-1.json"
study 5 "$dir/data" --seeds 1 --epochs 2 -o "$dir/study"
says 'paper-1.json is of a training with nqm_version 0.0.9'
cp "$dir/record" "$dir/study/paper-1.json"

# A smaller study: an interrupted training is resumed and gives the same model.
mkdir "$dir/small" "$dir/half" "$dir/long"
"$NQM_BUILD/tests/authors_folder" "$dir/small" 20
mkdir "$dir/small/data"
mv "$dir/small"/*.csv "$dir/small/data" # as in the authors' repository
# shellcheck disable=SC2086
small="$dir/small/uniform_rand_500 --labels $dir/small/data/labels_balanced_train.csv --recipe notebook --id notebook-1"
# shellcheck disable=SC2086
run 0 train $small --epochs 2 -o "$dir/whole.safetensors"
# shellcheck disable=SC2086
run 0 train $small --epochs 1 -o "$dir/unused.safetensors" --checkpoint "$dir/half/notebook-1.checkpoint"
study 0 "$dir/small" --recipes notebook --seeds 1 --epochs 2 -o "$dir/half"
cmp "$dir/whole.safetensors" "$dir/half/notebook-1.safetensors" || fail "resumed to another model"
grep -q '^Spearman, all pairs .* not run$' "$dir/out" || fail "a recipe that was not run"

# A further seed: the first is not trained again; the mean is that of both seeds.
study 0 "$dir/small" --recipes notebook --seeds 2 --epochs 2 -o "$dir/half" --json
cmp "$dir/whole.safetensors" "$dir/half/notebook-1.safetensors" || fail "the first seed was trained again"
{
    values mae "$dir/out" | sed -n 1,2p
    values mean "$dir/out" | sed -n 5p # the first four: two targets, Spearman, its mean over materials
} | awk '{v[NR] = $1} END {d = (v[1] + v[2]) / 2 - v[3]; exit !(NR == 3 && v[1] != v[2] && d < 1e-7 && d > -1e-7)}' ||
    fail "the mean of two seeds"

# Ctrl-C.
python3 "$script" "$dir/small" --recipes paper --epochs 100000 -o "$dir/long" >"$dir/out" 2>"$dir/err" &
until_written "$dir/long/paper-1.checkpoint"
ctrl_c
says 'same command again'
[ -s "$dir/long/paper-1.checkpoint" ] || fail "no checkpoint is left"
for file in "$dir"/long/*.part "$dir"/long/*.csv.*; do
    [ ! -e "$file" ] || fail "unfinished files lie about"
done

# Messages name what is missing.
study 2
study 2 "$dir/small" --recipes paper,best -o "$dir/x"
says 'best'
study 2 "$dir/small" --recipes paper,paper -o "$dir/x"
says 'twice'
study 3 "$dir/nowhere" -o "$dir/x"
says 'nowhere'
study 3 "$dir/small" -o "$dir/no/such/folder"
says 'no/such/folder'
study 5 "$dir/small" --train "$dir/small/test" --train-labels "$dir/small/data/labels_real.csv" -o "$dir/x"
says 'is in both'
file=$(find "$dir/small/test/model" -name '*_3.mat' | sort | head -n 1)
rm "$file"
study 3 "$dir/small" -o "$dir/x"
says "$(basename "$file")"
mv "$dir/small/test/ref" "$dir/small/test/references"
rm "$dir/small/data/labels_balanced_train.csv"
study 3 "$dir/small" -o "$dir/x"
says 'small/test/ref: no such folder'
says 'labels_balanced_train.csv: no such file'
