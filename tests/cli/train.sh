#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm train and nqm eval on a small dataset: formats of the results, options of the recipes, interrupted and resumed
# training, the authors' layout, documented exit codes.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
source=${NQM_SOURCE:?}
OMP_NUM_THREADS=1 # these networks are too small to use more threads
export OMP_NUM_THREADS
"${NQM_BUILD:?}/tests/tiny_dataset" "$dir/toy.safetensors"

# number KEY: print the first value of "KEY" in out.
number() { sed -n 's/.*"'"$1"'": *\([^,]*\),*$/\1/p' "$dir/out" | sed -n 1p; }
small="--hidden 32,16 --batch 64 --lr-first 0.001 --schedule plateau"

# Training: text, JSON, log, model file; the same command gives the same file.
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o "$dir/a.safetensors" $small --epochs 6 --log "$dir/a.csv"
grep -q 'validated on 144' "$dir/out" || fail "text"
[ "$(wc -l <"$dir/a.csv")" = 7 ] || fail "the log has a line an epoch"
[ "$(head -n 1 "$dir/a.csv")" = "epoch,train_loss,validation_loss,lr_first" ] || fail "head of the log"
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o "$dir/dash.safetensors" $small --epochs 1 --log -
grep -q '^epoch,train_loss' "$dir/out" || fail "the log on standard output"
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o "$dir/b.safetensors" $small --epochs 6 --json
cmp -s "$dir/a.safetensors" "$dir/b.safetensors" || fail "equal commands, different models"
[ "$(number schema)" = 1 ] || fail "schema"
[ "$(number n_train)" = 576 ] || fail "n_train"
[ "$(number steps)" = 54 ] || fail "steps"
[ "$(number recipe)" = '"nqm"' ] || fail "recipe"
[ "$(number epochs_resumed)" = 0 ] || fail "epochs_resumed"
grep -q '"validation_spearman": 0\.' "$dir/out" || fail "validation_spearman"
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o - $small --epochs 6
cmp -s "$dir/a.safetensors" "$dir/out" || fail "the model on standard output"

# Stopped after 2 of 6 epochs and resumed: the same file, the same log; a checkpoint is not overwritten by accident.
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o "$dir/c.safetensors" $small --epochs 2 --checkpoint "$dir/c.checkpoint"
# shellcheck disable=SC2086
run 2 train "$dir/toy.safetensors" -o "$dir/c.safetensors" $small --epochs 6 --checkpoint "$dir/c.checkpoint"
says 'resume'
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o "$dir/c.safetensors" $small --epochs 6 --checkpoint "$dir/c.checkpoint" --resume \
    --log "$dir/c.csv" --json
[ "$(number epochs_resumed)" = 2 ] || fail "epochs_resumed"
cmp -s "$dir/a.safetensors" "$dir/c.safetensors" || fail "a resumed training gave another model"
cmp -s "$dir/a.csv" "$dir/c.csv" || fail "a resumed training gave another log"
# shellcheck disable=SC2086
run 5 train "$dir/toy.safetensors" -o "$dir/c.safetensors" $small --dropout 0.3 --checkpoint "$dir/c.checkpoint" --resume
says 'dropout 0.1'
"$NQM_BUILD/tests/tiny_dataset" "$dir/other.safetensors" 2
# shellcheck disable=SC2086
run 5 train "$dir/other.safetensors" -o "$dir/c.safetensors" $small --checkpoint "$dir/c.checkpoint" --resume
says 'another dataset'

# Ctrl-C: exit code 130, no model, no unfinished files. The log is there while the training runs, and stays; an error of a resumed
# training keeps it, and a resumed training continues it.
# shellcheck disable=SC2086
"$tool" train "$dir/toy.safetensors" -o "$dir/d.safetensors" $small --epochs 100000 --checkpoint "$dir/d.checkpoint" \
    --log "$dir/d.csv" >"$dir/out" 2>"$dir/err" &
until_written "$dir/d.checkpoint"
until_written "$dir/d.csv"
ctrl_c
says 'interrupted'
[ ! -e "$dir/d.safetensors" ] || fail "a model from an interrupted training"
for file in "$dir"/*.part; do
    [ ! -e "$file" ] || fail "unfinished files lie about"
done
cp "$dir/d.csv" "$dir/stopped.csv"
n=$(($(wc -l <"$dir/d.csv") - 1))
[ $n -ge 1 ] || fail "no epoch in the log of a stopped training"
# shellcheck disable=SC2086
run 5 train "$dir/other.safetensors" -o "$dir/d.safetensors" $small --checkpoint "$dir/d.checkpoint" --resume --log "$dir/d.csv"
cmp -s "$dir/d.csv" "$dir/stopped.csv" || fail "a training that cannot be resumed changes the log"
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o "$dir/d.safetensors" $small --epochs $((n + 2)) --checkpoint "$dir/d.checkpoint" --resume \
    --log "$dir/d.csv"
[ "$(wc -l <"$dir/d.csv")" = $((n + 3)) ] || fail "the log of a resumed training"
head -n $((n + 1)) "$dir/d.csv" | cmp -s - "$dir/stopped.csv" || fail "a resumed training does not continue the log"
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o "$dir/d.safetensors" $small --epochs 1 --log "$dir/d.csv"
[ "$(wc -l <"$dir/d.csv")" = 2 ] || fail "rows of an older training in the log"
# shellcheck disable=SC2086
[ ! -c /dev/full ] || run 3 train "$dir/toy.safetensors" -o "$dir/d.safetensors" $small --epochs 1 --log /dev/full
run 3 train "$dir/toy.safetensors" -o "$dir/d.safetensors" --log "$dir/no/such/folder.csv"

# Recipes: paper and notebook; the card describes the training.
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o "$dir/paper.safetensors" --recipe paper $small --epochs 2 --id mine --json
[ "$(number recipe)" = '"paper"' ] || fail "recipe paper"
[ "$(number id)" = '"mine"' ] || fail "--id"
run 0 info "$dir/paper.safetensors"
grep -q 'Validation examples were drawn over pairs' "$dir/out" || fail "card of the paper's recipe"
grep -q '| gloss | 144 | 72 | 72 |' "$dir/out" || fail "kinds in the card"
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o "$dir/notebook.safetensors" --recipe=notebook $small --epochs 2 --no-balance
run 0 train --recipe paper --help
grep -q -- '--batch N .*512' "$dir/out" || fail "help shows the recipe's defaults"

# A training that cannot begin leaves the log of an earlier one, and never replaces its dataset.
printf 'epoch,train_loss,validation_loss,lr_first\n1,.5,.6,1e-4\n' >"$dir/earlier.csv"
run 2 train "$dir/toy.safetensors" -o "$dir/toy.safetensors"
head -n 2 "$source/tests/vectors/authors/labels.csv" >"$dir/one_label.csv"
run 5 train "$source/tests/vectors/authors" --labels "$dir/one_label.csv" -o "$dir/x.safetensors" --log "$dir/earlier.csv" --recipe paper
grep -q '^1,.5,.6' "$dir/earlier.csv" || fail "the earlier log is emptied"

# Evaluation: several models and the metrics, tables by kind and range, JSON, CSV, pairs.
run 0 eval "$dir/toy.safetensors" --model "$dir/a.safetensors,$dir/paper.safetensors" --by both --bootstrap 100 --pairs "$dir/pairs.csv"
grep -q '^all: 144 pairs of 6 materials' "$dir/out" || fail "text of eval"
for word in '^nqm  ' '^mine  ' '^log_diff  ' '^gloss: 72' '^JOD < 9.5'; do
    grep -q "$word" "$dir/out" || fail "eval lacks $word"
done
[ "$(wc -l <"$dir/pairs.csv")" = 145 ] || fail "a line a pair"
head -n 1 "$dir/pairs.csv" | grep -q '^ref,material,test,kind,split,delta_e,jod,nqm,mine,rmse,.*,log_diff,family,class,scalar:log_rmse,' || fail "head of the pairs"
# Models with one id are named by their files.
cp "$dir/a.safetensors" "$dir/b.safetensors"
run 0 eval "$dir/toy.safetensors" --model "$dir/a.safetensors,$dir/paper.safetensors,$dir/b.safetensors" --bootstrap 0
for name in '[^ ]*/a.safetensors' mine '[^ ]*/b.safetensors'; do
    grep -q "^$name  " "$dir/out" || fail "eval of two models with one id has no row $name"
done
run 0 eval "$dir/toy.safetensors" --model "$dir/a.safetensors" --by kind --json --bootstrap 100
cp "$dir/out" "$dir/first"
for word in '"schema": 1' '"spearman"' '"ci95": \[' '"spearman_mean_by_material"' '"by_kind"' '"gain"' '"split": "test"' '"n": 144' \
    '"r2"' '"type": "metric"'; do
    grep -q "$word" "$dir/out" || fail "JSON lacks $word"
done
run 0 eval "$dir/toy.safetensors" --model "$dir/a.safetensors" --by kind --json --bootstrap 100
cmp -s "$dir/out" "$dir/first" || fail "equal commands, different intervals"
run 0 eval "$dir/toy.safetensors" --model none --split all --by all --json --bootstrap 0
for word in '"by_family"' '"encoding"' '"by_class"' '"by_range"' '"by_kind"'; do
    grep -q "$word" "$dir/out" || fail "JSON of --by all lacks $word"
done
run 0 eval "$dir/toy.safetensors" --model none --split all --by family
grep -q '^perturbation: 288 pairs of 24 materials' "$dir/out" || fail "by family"
for file in "$dir"/*.csv.*; do
    [ ! -e "$file" ] || fail "unfinished CSVs lie about"
done
run 3 eval "$dir/toy.safetensors" --model none --pairs "$dir/no/such/folder/pairs.csv"
run 0 eval "$dir/toy.safetensors" --model none --split all --csv --bootstrap 0
[ "$(wc -l <"$dir/out")" = 10 ] || fail "a line a metric"
grep -q '^all,all,rmse,metric,576,24,0\.' "$dir/out" || fail "CSV"

# The authors' layout can be used directly for training and evaluation.
run 0 train "$source/tests/vectors/authors" --labels "$source/tests/vectors/authors/labels.csv" --recipe notebook \
    -o "$dir/authors.safetensors" --epochs 2 --hidden 8
run 0 eval "$source/tests/vectors/authors" --labels "$source/tests/vectors/authors/labels.csv" --model "$dir/authors.safetensors"
grep -q '^all: 5 pairs of 2 materials' "$dir/out" || fail "eval of the authors' layout"

# Errors.
run 2 train "$dir/toy.safetensors"
says '-o'
run 2 train "$dir/toy.safetensors" -o "$dir/x" --recipe best
says 'notebook'
run 2 train "$dir/toy.safetensors" -o "$dir/x" --target pain
says 'log_delta_e'
run 2 train "$dir/toy.safetensors" -o "$dir/x" --hidden 10,,2
says 'hidden'
run 2 train "$dir/toy.safetensors" -o "$dir/x" --batch 0
run 2 train "$source/tests/vectors/authors" -o "$dir/x"
says '--labels'
run 3 train "$dir/nowhere" -o "$dir/x"
says 'nowhere'
run 3 train "$dir/toy.safetensors" -o "$dir/no/such/folder/x"
says 'cannot write'
run 4 train "$dir/a.safetensors" -o "$dir/x"
says 'no nqm dataset'
run 4 train "$dir/a.csv" -o "$dir/x"
run 2 eval "$dir/toy.safetensors" --model none --split rest
run 3 eval "$dir/nowhere" --model none
run 6 eval "$dir/toy.safetensors" --model "$dir/toy.safetensors"
run 5 eval "$dir/other.safetensors" --model "$dir/a.safetensors"
says 'directions'
head -c 3000 "$dir/toy.safetensors" >"$dir/cut.safetensors"
run 4 eval "$dir/cut.safetensors" --model none
says 'cut.safetensors'

# The card is a part of the model; a log that is no file; by pairs there is no interval, as the validation materials were trained on.
printf 'Made for a test.\n' >"$dir/card.md"
# shellcheck disable=SC2086
run 0 train "$dir/toy.safetensors" -o "$dir/card.safetensors" $small --epochs 1 --recipe=nqm --card "$dir/card.md" --log /dev/null --split pair
grep -q '^interval *none: the validation materials were trained on' "$dir/out" || fail "interval: $(cat "$dir/out")"
run 0 info "$dir/card.safetensors"
grep -q 'Made for a test' "$dir/out" || fail "card: $(cat "$dir/out")"
# The words behind -- are no options, and the recipe is looked for among options alone.
# shellcheck disable=SC2086
run 0 train -o "$dir/dashes.safetensors" $small --epochs 1 -- "$dir/toy.safetensors"
