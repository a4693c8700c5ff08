#!/bin/sh
# SPDX-License-Identifier: MIT
# make.sh DATA [NQM] - draw the figures of doc/labels.md: the bunny in five measured materials, each beside its nine encodings, and
# a map of differences. DATA is the folder of doc/corpus.md (rgl/ and scene/); NQM the tool, build/nqm unless given. None of the five
# is among the 20 test materials. Takes a few minutes, mostly for the fits.
set -eu
data=${1:?say where the data are: make.sh DATA [NQM]}
figures=$(cd "$(dirname "$0")" && pwd)
nqm=${2:-$figures/../../build/nqm}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

materials="paper_blue_rgb satin_purple_rgb colodur_azure_4e_rgb vch_ultra_pink_rgb cg_sunflower_rgb"
rows="blue paper,satin purple,azure plastic,ultra pink,sunflower"
encodings="ward ggx nbrdf sparse-low sparse-mid sparse-high hyper-low hyper-mid hyper-high"
columns="reference,Ward,GGX,NBRDF,sparse low,sparse mid,sparse high,hyper low,hyper mid,hyper high"
scene="--shape $data/scene/bunny.ply --light $data/scene/pixar_campus_rgbe.png --elevation 10"

# encode MATERIAL ENCODING: print the argument that stands for it.
encode() {
    case $2 in
    ward | ggx) "$nqm" fit "$data/rgl/$1.bsdf" --model "$2" -q ;;
    *)
        "$nqm" fit "$data/rgl/$1.bsdf" --model "$2" -o "$work/$1-$2.safetensors" >&2
        echo "$work/$1-$2.safetensors"
        ;;
    esac
}

set --
for material in $materials; do
    [ $# = 0 ] || set -- "$@" +
    set -- "$@" "$data/rgl/$material.bsdf"
    for encoding in $encodings; do
        set -- "$@" "$(encode "$material" "$encoding")"
    done
done
# shellcheck disable=SC2086
"$nqm" label "$@" $scene --size 256 --shrink 2 --rows "$rows" --columns "$columns" --grid "$figures/encodings.png"

material=satin_purple_rgb
# shellcheck disable=SC2086
"$nqm" label "$data/rgl/$material.bsdf" "$(encode $material ward)" "$(encode $material ggx)" $scene --size 384 --shrink 2 \
    --rows "Ward,GGX" --map "$figures/differences.png"
