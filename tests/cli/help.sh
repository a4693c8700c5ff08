#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm help: what is made from the option tables (man pages, Markdown, completions), and names near a misspelt one.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
verbs=$("$tool" --help | sed -n 's/^  \([a-z]*\)  .*/\1/p')

# Every verb has a page with its options, its usage and its examples, in each form.
for verb in $verbs; do
    run 0 "$verb" --help
    cp "$dir/out" "$dir/text"
    run 0 help "$verb"
    cmp -s "$dir/out" "$dir/text" || fail "help $verb differs from $verb --help"
    awk '/^options:/ {table = 1} /^example:/ {table = 0} table && length > 110' "$dir/text" >"$dir/long"
    [ ! -s "$dir/long" ] || fail "$verb --help has long lines: $(cat "$dir/long")"
    options=$(sed -n '/^options:/,/^example:/s/^  .*  *--\([a-z0-9-]*\).*/\1/p' "$dir/text")
    run 0 help "$verb" --format man
    sed 's/\\-/-/g' "$dir/out" >"$dir/page"
    for option in $options; do
        grep -q -- "--$option" "$dir/page" || fail "nqm-$verb.1 lacks --$option"
    done
    grep -q "^nqm-$verb - ." "$dir/page" || fail "nqm-$verb.1 has no name"
    ! grep -q "^[.'][^A-Z\\\\bnf]" "$dir/out" || fail "nqm-$verb.1 has text that begins like a command"
done
"$tool" help --format man >"$dir/page"
for verb in $verbs; do
    grep -q "nqm.-$verb" "$dir/page" || fail "nqm.1 lacks $verb"
done
if command -v man >/dev/null && man --warnings -l "$dir/page" >"$dir/out" 2>"$dir/err"; then
    [ ! -s "$dir/err" ] || fail "man warns of nqm.1"
fi

# The page of the reference is up to date.
run 0 help --format markdown
diff "$NQM_SOURCE/doc/reference-cli.md" "$dir/out" >"$dir/err" || fail "doc/reference-cli.md is old: run ./dev pages"

# bash: completes verbs, options, words of an option and of the first argument, and leaves files to the shell.
"$tool" help --format bash >"$dir/completion"
touch "$dir/lambda-nothing"
cat >"$dir/complete.bash" <<'END'
source "$1" || exit 1
shift
nqm() { "$NQM_BUILD/nqm" "$@"; }
COMP_WORDS=(nqm "$@") COMP_CWORD=$#
_nqm
echo "${COMPREPLY[*]}"
END
# completes EXPECTED WORD...: the last word is being typed.
completes() {
    expected=$1
    shift
    got=$(cd "$dir" && bash complete.bash "$dir/completion" "$@")
    [ "$got" = "$expected" ] || fail "bash completes nqm $* to '$got', not '$expected'"
}
if command -v bash >/dev/null; then
    completes "score" sc
    completes "--min-valid" score a b --min-v
    completes "drop" score --invalid d
    completes "bf16" train --precision = bf
    completes "make" transport ma
    completes "man markdown" help --format ma
    completes "" score nickel.bin
    completes "default" score --model de
    completes "transport transport-paper" score -m tr
    completes "open-pbr openpbr" translate --to op
    completes "sgd:nickel" score sgd:nick
    completes "nickel" score sgd : nick
    completes "nickel" score ref = sgd : nick
    completes "lambda-nothing" score lambda-no
fi
for shell in zsh fish; do
    run 0 help --format $shell
    for verb in $verbs; do
        grep -q "$verb" "$dir/out" || fail "$shell: no $verb"
    done
    if command -v $shell >/dev/null; then
        $shell -n "$dir/out" 2>"$dir/err" || fail "$shell cannot read its completion"
    fi
done
refuses 2 "give none" help score --format bash

# Names near a misspelt one; '_' for '-' in options.
refuses 2 "no verb 'scroe' (did you mean 'score'?)" scroe
refuses 2 "no verb 'xyzzy';" xyzzy
refuses 2 "no verb 'scroe' (did you mean 'score'?)" help scroe
refuses 2 "did you mean '--metrics'?" score sgd:nickel ward:nickel --metrcis=all
refuses 2 "no model 'wrad' (did you mean 'ward'?)" info wrad:nickel
refuses 2 "no model 'GGX' (did you mean 'ggx'?)" info GGX:alpha=.1
refuses 2 "no key 'alhpa' (did you mean 'alpha'?); the keys are kd, ks, alpha, f0" info ggx:alhpa=.1
refuses 2 "no key 'baseMetalnes' (did you mean 'base_metalness'?)" info open-pbr:baseMetalnes=.1
echo '{"asset": {"version": "2.0"}, "materials": [{"name": "brass"}, {"name": "wood"}]}' >"$dir/two.gltf"
refuses 2 "no material 'wod' in this file (did you mean 'wood'?); it has brass, wood" info "$dir/two.gltf:wod"
refuses 2 "a spec of this model is 'ggx:key=value;...'" info ggx
refuses 2 "a preset of this name is 'sgd:nickel'" info nickel
refuses 2 "lambert: needs parameters, lambert:key=value;..., not ''; the keys are kd" info lambert:
refuses 6 "no model 'defualt' (did you mean 'default'?)" score sgd:nickel ward:nickel --model defualt
refuses 6 "scalar metric, which --metrics rmse adds" score sgd:nickel ward:nickel --metric rmse
refuses 2 "not 'mae,rsme' (did you mean 'rmse'?)" score sgd:nickel ward:nickel --metrics mae,rsme
refuses 2 "cannot fit a model 'gxg' (did you mean 'ggx'?)" fit sgd:nickel --model gxg
refuses 2 "not 'opnpbr' (did you mean 'openpbr'?)" translate sgd:nickel --to opnpbr
refuses 3 "light: there is no file 'overcst' (did you mean 'overcast'?); built in are sun," label sgd:nickel ward:nickel --light overcst
refuses 3 "shape: there is no file 'cube'; built in are sphere, blob" render sgd:nickel -o "$dir/x.png" --shape cube
refuses 2 "no verb 'version' (did you mean '--version'?)" version
refuses 2 "did you mean '--version'?" score --verison
run 0 score --version
grep -q "^nqm [0-9]" "$dir/out" || fail "score --version"
refuses 2 "no loss 'jod' (did you mean 'nqm'?)" fit sgd:nickel --loss jod
refuses 2 "no loss 'log-cso' (did you mean 'log-cos'?)" fit sgd:nickel --loss log-cso
run 0 info list sgd:nick
[ "$(cat "$dir/out")" = sgd:nickel ] || fail "presets with a word"
refuses 2 "no preset has 'nikel' in its name" info list nikel
refuses 2 "there is no file 'lsit' (did you mean 'list'?)" info lsit
refuses 2 "there is no file 'shwo' (did you mean 'show'?)" directions shwo default
refuses 2 "wrad: there is no such file, model or preset (did you mean 'ward'?)" info wrad
refuses 2 "nickle: there is no such file, model or preset (did you mean 'nickel'?)" info nickle
refuses 3 "nowhere: No such file" info nowhere
# A wrong first word is named before what is missing, and before outputs.
refuses 2 "no 'mkae' (did you mean 'make'?)" transport mkae
# Models and BRDFs in each other's place, and models nearly.
for verb in "score sgd:nickel" "rank sgd:nickel" "label sgd:nickel" "report -o $dir/x.html sgd:nickel" check sample \
    "convert -o $dir/x.binary" fit "translate --to gltf" "render -o $dir/x.png" directions; do
    # shellcheck disable=SC2086
    refuses 2 "'default' is a model, not a BRDF: models belong to --model" $verb default
done
refuses 2 "'paper' is a model" score default=paper sgd:nickel
for verb in eval "eval --human"; do
    # shellcheck disable=SC2086
    refuses 3 "'default' is a model, not a dataset: models belong to --model (nqm eval DATASET --model default)" $verb default
done
refuses 3 "no file 'defualt' (did you mean 'default'?)" score sgd:nickel defualt
refuses 3 "no file and no model 'defualt' (did you mean 'default'?)" sample sgd:nickel -d defualt
refuses 6 "'ggx:alpha=.1' is a BRDF, not a model" score sgd:nickel ward:nickel --model ggx:alpha=.1
refuses 6 "'defualt' is not built in (did you mean 'default'?)" bench score --model defualt
refuses 2 "'default' is a model, which belongs to --model" score sgd:nickel ward:nickel --metrics default
printf 'reference,test,score\nsgd:nickel,ward:nickel,1\n' >"$dir/opinions.csv"
for verb in "score sgd:nickel ward:nickel" "rank sgd:nickel ward:nickel" "batch $dir/opinions.csv" "fit sgd:nickel" \
    "report sgd:nickel ward:nickel -o $dir/x.html" "translate sgd:nickel --to gltf" "eval --human $dir/opinions.csv"; do
    # shellcheck disable=SC2086
    refuses 6 "no model 'all': it is the word for all scalar metrics, which --metrics all adds to the results of score" $verb --metric all
done
# Another character where the colon of a spec belongs.
refuses 2 "ggx;alpha=.1: no such file; in a spec, ':' follows the model: 'ggx:alpha=.1'" info 'ggx;alpha=.1'
refuses 2 "'ggx:alpha=.1;kd=.2'" info 'ggx=alpha=.1;kd=.2'
refuses 2 "'sgd:nickel'" info 'sgd;nickel'
for wrong in ward-nickel ward_nickel ward.nickel 'ward nickel'; do
    refuses 3 "$wrong: No such file or directory (did you mean 'ward:nickel'?)" info "$wrong"
done
refuses 3 "ward.binary: No such file or directory" info ward.binary
grep -q 'did you mean' "$dir/err" && fail "a hint for a file's name: $(cat "$dir/err")"
refuses 3 "No such file or directory, and no model 'merl'" info merl:nickel
refuses 3 'No such file' info data/merl:nickel
refuses 2 "'perturb:gloss=.9;of=sgd:nickel'" info 'perturb;gloss=.9;of=sgd:nickel'
for wrong in 'ggx;alpha=.1' 'ggx=alpha=.1' 'ggx,alpha=.1' 'ggx alpha=.1'; do
    run 2 score sgd:nickel "$wrong" -q
    grep -q "follows the model: 'ggx:alpha=.1'" "$dir/err" || fail "$wrong is read as a name"
done
run 0 rank sgd:nickel ggx=ward:nickel -q -m transport
# A folder with the name of a file.
refuses 2 "x.gltf: the materials are written to a folder; leave out '.gltf'" translate sgd:nickel --to gltf -d "$dir/x.gltf"
refuses 2 "x.png: the pictures are written to a folder" label sgd:nickel ward:nickel --keep-renders "$dir/x.png"
refuses 2 "x.csv: finished pieces of the list are written to a folder" batch "$dir/opinions.csv" --work "$dir/x.csv"
refuses 2 "x.safetensors/: the results of several models are written" fit sgd:nickel --model ward,ggx -o "$dir/x.safetensors/"
for file in "$dir"/x.*; do [ ! -e "$file" ] || fail "a refusal left $file"; done
refuses 2 "x: too many arguments" info sgd:nickel x

refuses 2 "translate: --to MODEL is missing: gltf" translate sgd:nickel

# What a file is written as is what its name says: each option for a file, before the work.
misnamed() {
    name=$1 option=$2
    shift 2
    refuses 2 "^nqm $1: $option writes FILE.*, and '$dir/$name' names another kind" "$@" "$option" "$dir/$name"
    [ ! -e "$dir/$name" ] || fail "$* wrote $name"
}
misnamed x.csv -o sample sgd:nickel
misnamed x.png -o convert sgd:nickel
misnamed x.xlsx -o batch list.csv
misnamed x -o batch list.csv
misnamed x.html --junit batch list.csv
misnamed x.txt --markdown batch list.csv
misnamed x.csv -o dataset pairs.csv --directions x.csv
misnamed x.bin -o train corpus.safetensors
misnamed x.png --log train corpus.safetensors -o "$dir/x.safetensors"
misnamed x.json -o calibrate default corpus.safetensors
misnamed x.csv -o fit sgd:nickel
misnamed x.pdf --report fit sgd:nickel
misnamed x.pdf --report translate sgd:nickel --to gltf
misnamed x.xlsx --pairs eval corpus.safetensors
misnamed x.pdf -o report sgd:nickel ward:nickel
misnamed x.jpg --map label sgd:nickel ward:nickel
misnamed x.jpg --grid label sgd:nickel ward:nickel
misnamed x.jpg -o render sgd:nickel
misnamed x.mat -o directions
misnamed x.csv -o transport make
misnamed x.md -o info default --notes notes.md
misnamed x.csv -o bench gemm
refuses 2 "x.gif: no file of this name holds a material" translate sgd:nickel --to gltf -o "$dir/x.gif"
refuses 2 "json: '$dir/x.csv' names another kind" batch list.csv --json -o "$dir/x.csv"
refuses 3 "$dir/no/x.safetensors" train corpus.safetensors -o "$dir/no/x.safetensors"
run 0 directions -o "$dir/set-1.2" # a number is not an ending
refuses 2 "would replace the file of --" label sgd:nickel ward:nickel --map "$dir/x.png" --grid "$dir/x.png"
# Every option that names an output has the check.
for verb in $verbs; do
    run 0 "$verb" --help
    ! grep -E -- '--(output|report|pairs|map|grid|junit|markdown|log) (FILE|CSV)( |$)' "$dir/out" | grep -v 'extension selects' ||
        fail "$verb: an output of any name"
done
refuses 2 "merl writes MERL tables (.binary), and '.*x.npy' names another kind" convert sgd:nickel --format merl -o "$dir/x.npy"
run 0 convert lambert:kd=.2 -o "$dir/x.npy"
grep -q 'nodes of a .npy array' "$dir/out" || fail "the format of a .npy name"
refuses 3 "No such file" info folder/wrad.binary
refuses 2 "fail-under needs a number from 0 to 10" score sgd:nickel ward:nickel --fail_under 11
run 0 info sgd:nickel
