#!/bin/sh
# SPDX-License-Identifier: MIT
# make.sh DATA [NQM] - draw the figures of doc/labels.md (the bunny in five measured materials, each beside its nine encodings, and
# a map of differences) and doc/people.md. DATA is the folder of doc/corpus.md (rgl/ and scene/); NQM the tool, build/nqm unless given. None of the five
# is among the 20 test materials. Takes a few minutes, mostly for the fits.
set -eu
data=${1:?say where the data are: make.sh DATA [NQM]}
figures=$(cd "$(dirname "$0")" && pwd)
nqm=${2:-$figures/../../build/nqm}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

materials="paper_blue_rgb satin_purple_rgb colodur_azure_4e_rgb vch_ultra_pink_rgb cg_sunflower_rgb"
scene="--shape $data/scene/bunny.ply --light $data/scene/pixar_campus_rgbe.png --elevation 10"

set -f
set --
for material in $materials; do
    [ $# = 0 ] || set -- "$@" +
    set -- "$@" "$data/rgl/$material.bsdf"
    mkdir "$work/$material"
    "$nqm" fit "$data/rgl/$material.bsdf" --model encodings -o "$work/$material/" -q >"$work/$material/arguments"
    while read -r argument; do
        set -- "$@" "$argument"
    done <"$work/$material/arguments"
done
# shellcheck disable=SC2086
"$nqm" label "$@" $scene --size 256 --shrink 2 --grid "$figures/encodings.png"

material=vch_ultra_pink_rgb
set -- "$data/rgl/$material.bsdf"
for encoding in 1 2 3; do # Ward, GGX, NBRDF
    set -- "$@" "$(sed -n ${encoding}p "$work/$material/arguments")"
done
# shellcheck disable=SC2086
"$nqm" label "$@" $scene --size 384 --shrink 2 --map "$figures/differences.png"

plastic=sgd:red-specular-plastic
"$nqm" label $plastic "perturb:scale=.6;of=$plastic" "perturb:gloss=.35;of=$plastic" --size 256 --shrink 2 \
    --grid "$figures/apart.png"
