#!/bin/sh
# SPDX-License-Identifier: MIT
# Makes the built-in models: material list, directions, corpora, training, evaluation, and the results appended to each
# model card. Resumable: existing files in WORK are kept. The corpus of the model `default` takes about two and a half hours
# on two cores; with "quick", which makes only this model and keeps a fifth of its pairs, less than one.
# usage: models/make.sh DATA WORK [quick]   (DATA: folders rgl, nbrdf, nps, materials, labels, scene; doc/corpus.md lists
# their sources)
set -eu
usage='usage: models/make.sh DATA WORK [quick]'
data=${1:?$usage}
mkdir -p "${2:?$usage}"
case ${3-} in
'') every=1 every_test=1 ;;
quick) every=5 every_test=3 ;;
*)
    echo "models/make.sh: '$3' is not 'quick'; $usage" >&2
    exit 2
    ;;
esac
work=$(cd "$2" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
nqm=$(realpath "${NQM_TOOL:-$here/../build/nqm}")
# Model `default` predicts the standard set of scenes (doc/labels.md) for any two BRDFs, at the directions of light transport.
any_pair="--roundings 3 --variants 10"
train_pairs="$any_pair --every $every --perturbations 52 --far 20"
test_pairs="$any_pair --every $every_test --perturbations 22 --far 14"
train_scene="--directions $work/grid.csv --keep far=$(((20 + every - 1) / every))"
test_scene="--directions $work/grid.csv --keep far=$(((14 + every_test - 1) / every_test))"
# Model `paper` predicts the paper's scene, a rotating bunny under the Pixar Campus light, for encodings and perturbations.
paper_scene="--directions $work/directions.csv --scene paper --light $data/scene/pixar_campus_rgbe.png --shape $data/scene/bunny.ply --points 1536"
paper_pairs="--models ward,ggx,nbrdf,sparse-0,sparse-1,sparse-2,hyper-0,hyper-1,hyper-2 --perturbations 30 --far 0 --roundings 0 --variants 0"

NQM_TOOL=$nqm python3 "$here/scan.py" "$data" >"$work/materials.csv"

# training FOLDER SOURCES: the training references of these sources ("": all) as arguments; files below FOLDER. No name or folder
# of the data has blanks.
training() {
    python3 - "$work/materials.csv" "$1" "$2" <<'END'
import csv, sys

path, folder, sources = sys.argv[1:]
with open(path, newline="", encoding="utf-8") as file:
    for row in csv.DictReader(file):
        if row["split"] == "train" and (not sources or row["source"] in sources.split()):
            is_spec = row["source"] == "sgd" or "=" in row["brdf"]
            print(row["brdf"] if is_spec else folder + row["brdf"])
END
}

# learn KIND: make the dictionary or hypernetwork of the encodings KIND-* from training materials only; the file names
# them relative to DATA. Needs NumPy and the library (cmake --build build --target nqm_full).
learn() {
    [ ! -f "$here/encoders/$1.safetensors" ] || return 0
    # shellcheck disable=SC2046 # arguments without blanks
    (cd "$data" && PYTHONPATH="$here/../python" python3 "$here/../studies/learn.py" "$1" $(training "" "rgl nbrdf nps sgd") -o "$here/encoders/$1.safetensors")
    new_encoders=yes
}
new_encoders=
learn sparse
learn hyper
if [ "$new_encoders" ]; then
    echo "models/encoders is new: build nqm again, so that it holds them, then start this again" >&2
    exit 1
fi

# corpus NAME LIST SPLITS PLAN OPTIONS: make the dataset WORK/NAME.safetensors of the materials in WORK/LIST.csv. The list of its
# pairs has those of the other splits too, so that the manifest can say which kinds are in one part only.
corpus() {
    [ ! -f "$work/$1.safetensors" ] || return 0
    # shellcheck disable=SC2086 # a list of options
    NQM_TOOL=$nqm python3 "$here/plan.py" "$work/$2.csv" --root "$data" $4 >"$work/$1-pairs.csv"
    # shellcheck disable=SC2086 # a list of options
    "$nqm" dataset "$work/$1-pairs.csv" --root "$data" --work "$work/groups" \
        --only "$3" $5 -o "$work/$1.safetensors" --log
    cp "$work/$1.safetensors.json" "$here/corpus-$1.json"
}
[ -f "$work/grid.csv" ] || "$nqm" directions --grid -o "$work/grid.csv"
corpus train materials train,validation "$train_pairs" "$train_scene"
corpus test materials test "$test_pairs" "$test_scene"
if [ "$every" = 1 ]; then
    [ -f "$work/directions.csv" ] || # drawn by the energy of the training references only
        # shellcheck disable=SC2046 # arguments without blanks
        "$nqm" directions $(training "$data/" "") -o "$work/directions.csv"
    grep -Ev ',(renderer|mirror|analytic),[a-z]+$' "$work/materials.csv" >"$work/paper-materials.csv"
    corpus paper-train paper-materials train,validation "$paper_pairs" "$paper_scene"
    corpus paper-test paper-materials test "$paper_pairs" "$paper_scene"
fi

# judged NAME PREFIX SCENE MORE: the results of nqm eval as Markdown, for the model card. PREFIX: of the datasets' names. MORE: what
# else the test split contains.
judged() {
    echo "## Judged on"
    echo
    echo "The 20 materials of the authors' study with people, in every form$4: no model, whitening, direction or threshold has"
    echo "seen them. Labels are those of \`nqm label\`$3, not of people. Manifest: corpus-$2test.json. \`clamp\`, \`ripple\`,"
    echo "\`hue\`, \`between-log\`, \`white\`, \`random-lafortune\` and \`random-smooth\` are kinds of difference that do not occur in training."
    echo
    echo '```'
    (cd "$work" && "$nqm" eval "$2test.safetensors" --model "$1.safetensors" --by subset)
    echo '```'
    echo
    if [ "$1" = paper ]; then
        echo "This recipe draws its validation pairs at random, so it has trained on pairs of every other material of the corpus."
    else
        echo "On the validation materials, half of which settled the recipe, on a smaller corpus (doc/training.md):"
        echo
        echo '```'
        (cd "$work" && "$nqm" eval "$2train.safetensors" --split validation --model "$1.safetensors")
        echo '```'
    fi
    cat "$here/notes.md"
}

# train NAME RECIPE PREFIX SCENE FILE MORE [--half]: train with a checkpoint, evaluate, append the results to the model card.
train() {
    if [ ! -f "$work/$1.safetensors" ]; then
        resume=
        [ ! -f "$work/$1.checkpoint" ] || resume=--resume
        "$nqm" train "$work/$3train.safetensors" --recipe "$2" --id "$1" --licence MIT -o "$work/$1.safetensors" \
            --checkpoint "$work/$1.checkpoint" $resume --log "$work/$1.csv"
    fi
    judged "$1" "$3" "$4" "$6" >"$work/$1.md"
    # shellcheck disable=SC2086 # no word or one
    "$nqm" info "$work/$1.safetensors" --notes "$work/$1.md" ${7-} -o "$here/$5"
}
train default nqm "" " without options (four built-in scenes)" default.safetensors \
    ", and 15 % of the renderer materials, mirrors and analytic models" --half
[ "$every" = 1 ] || exit 0
train paper paper paper- " --scene paper (a rotating bunny under the Pixar Campus light)" full/paper.safetensors ""
# The scenes of both corpora as metrics without a network, with twice the points.
"$nqm" transport make --points 256 --seed 2 --id transport -o "$here/transport.safetensors"
# shellcheck disable=SC2046,SC2086 # a list of options
"$nqm" transport make --points 256 --seed 2 --id transport-paper $(echo "${paper_scene% --points*}" | sed "s/.*--scene/--scene/") \
    -o "$here/full/transport-paper.safetensors"

# Anisotropic pairs of analytic and OpenPBR materials; the seed is the best of 24 for these (studies/anisotropy.py).
python3 "$here/../studies/anisotropy.py" 420 1 >"$work/anisotropic.csv"
[ -f "$work/anisotropic.safetensors" ] ||
    "$nqm" dataset "$work/anisotropic.csv" --anisotropic --directions "$work/grid.csv" --lights 256 \
        -o "$work/anisotropic.safetensors" --log
"$nqm" transport make --anisotropic --seed 7 --id anisotropic -o "$work/slopes.safetensors"
"$nqm" calibrate "$work/slopes.safetensors" "$work/anisotropic.safetensors" --new-materials -o "$here/anisotropic.safetensors"

echo "build nqm again, so that it contains the new models; then draw the figures of the pages:"
echo "  sh doc/figures/make.sh $data && sh doc/gallery/make.sh $data $work/train.safetensors $work/default.csv"
