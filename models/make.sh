#!/bin/sh
# SPDX-License-Identifier: MIT
# Makes the built-in models: material list, directions, corpora, training, evaluation, and the results appended to each
# model card. Resumable: existing files in WORK are kept. Takes about an hour on two cores.
# usage: models/make.sh DATA WORK   (DATA: folders rgl, nbrdf, nps, labels, scene; doc/corpus.md lists their sources)
set -eu
data=${1:?usage: models/make.sh DATA WORK}
mkdir -p "${2:?usage: models/make.sh DATA WORK}"
work=$(cd "$2" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
nqm=$(realpath "${NQM_TOOL:-$here/../build/nqm}")
# The paper's scene, a rotating bunny under the Pixar Campus light: eight views, labelled by points (doc/labels.md).
scene="--light $data/scene/pixar_campus_rgbe.png --shape $data/scene/bunny.ply --frames 8 --points 1536 --lights 128"

NQM_TOOL=$nqm python3 "$here/scan.py" "$data" >"$work/materials.csv"

# learn KIND: make the dictionary or hypernetwork of the encodings KIND-* from training materials only; the file names
# them relative to DATA.
learn() {
    [ ! -f "$here/encoders/$1.safetensors" ] || return 0
    training=$(awk -F, 'NR > 1 && $5 == "train" { print $3 }' "$work/materials.csv")
    # shellcheck disable=SC2086 # neither materials nor folders of the data have blanks in their names
    (cd "$data" && "$nqm" learn "$1" $training -o "$here/encoders/$1.safetensors")
    new_encoders=yes
}
new_encoders=
learn sparse
learn hyper
if [ "$new_encoders" ]; then
    echo "models/encoders is new: build nqm again, so that it holds them, then start this again" >&2
    exit 1
fi

if [ ! -f "$work/directions.csv" ]; then
    # The directions are drawn by the energy of the training references only.
    references=$(awk -F, -v data="$data" 'NR > 1 && $5 == "train" { print ($4 == "sgd" ? $3 : data "/" $3) }' "$work/materials.csv")
    # shellcheck disable=SC2086 # neither materials nor folders of the data have blanks in their names
    "$nqm" directions $references -o "$work/directions.csv"
fi
for part in train test; do
    [ ! -f "$work/$part.safetensors" ] || continue
    if [ $part = train ]; then only="train,validation"; else only="test"; fi
    # shellcheck disable=SC2086 # a list of options
    "$nqm" dataset "$work/materials.csv" --root "$data" --directions "$work/directions.csv" $scene --work "$work/groups" \
        --only $only --perturbations 30 -o "$work/$part.safetensors" --log
    cp "$work/$part.safetensors.json" "$here/corpus-$part.json"
done

# judged NAME: the results of nqm eval as Markdown, for the model card.
judged() {
    echo "## Judged on"
    echo
    echo "The 20 materials of the authors' study with people, in every form: no model, whitening, direction or threshold has"
    echo "seen them. Labels are those of \`nqm label\` (a rotating bunny under the Pixar Campus light), not of people. Manifest: corpus-test.json."
    echo "\`clamp\`, \`ripple\` and \`hue\` are kinds of distortion that do not occur in training. Higher is better."
    echo
    echo '```'
    (cd "$work" && "$nqm" eval test.safetensors --model "$1.safetensors" --by all)
    echo '```'
    echo
    if [ "$1" = paper ]; then
        echo "This recipe draws its validation pairs at random, so it has trained on pairs of every other material of the corpus."
    else
        echo "On the validation materials, half of which settled the recipe, on a smaller corpus (doc/training.md):"
        echo
        echo '```'
        (cd "$work" && "$nqm" eval train.safetensors --split validation --model "$1.safetensors")
        echo '```'
    fi
    cat "$here/notes.md"
}

# train NAME RECIPE: train with a checkpoint, evaluate, append the results to the model card.
train() {
    if [ ! -f "$work/$1.safetensors" ]; then
        resume=
        [ ! -f "$work/$1.checkpoint" ] || resume=--resume
        "$nqm" train "$work/train.safetensors" --recipe "$2" --id "$1" --licence MIT -o "$work/$1.safetensors" \
            --checkpoint "$work/$1.checkpoint" $resume --log "$work/$1.csv"
    fi
    judged "$1" >"$work/$1.md"
    "$nqm" models annotate "$work/$1.safetensors" "$work/$1.md" -o "$here/$1.safetensors"
}
train default nqm
train paper paper
