#!/bin/sh
# SPDX-License-Identifier: MIT
# make.sh DATA [CORPUS LOG [NQM]] - draw the pictures of doc/gallery.md. DATA is the folder of doc/corpus.md (labels/ and rgl/); CORPUS
# a training corpus (models/make.sh makes it), whose validation pairs give bars and scatter; LOG what `nqm train --log` wrote. Without
# these two, bars, scatter and loss stay as they are. PYTHON: a Python with matplotlib. Takes a minute, mostly for the evaluation.
set -eu
data=${1:?say where the data are: make.sh DATA [CORPUS LOG [NQM]]}
corpus=${2:-}
log=${3:-}
gallery=$(cd "$(dirname "$0")" && pwd)
nqm=${4:-$gallery/../../build/nqm}
PYTHONPATH=$gallery/../../python NQM_LIBRARY=${NQM_LIBRARY:-$(dirname "$nqm")/libnqm-full.so} MPLBACKEND=Agg
export PYTHONPATH NQM_LIBRARY MPLBACKEND
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# draw NAME SCALE WHAT INPUT...: PNG, so many pixels a CSS pixel that files stay below 150 KB.
draw() {
    name=$1 scale=$2
    shift 2
    "${PYTHON:-python3}" -m nqm.plot "$@" --scale "$scale" -o "$gallery/$name.png"
}
draw curve 1.5 curve "$data/labels/labels_real.csv"
draw directions 1.25 directions default
draw network 1.5 network paper
draw slice 1 slice "$data/rgl/vch_ultra_pink_rgb.bsdf" sgd:nickel ward:nickel
draw attribution 1.5 attribution sgd:nickel ward:nickel
metal='open-pbr:base_metalness=1;base_color=.9,.62,.35;specular_roughness=.4'
brushed="$metal;specular_roughness_anisotropy=.8"
"$nqm" label "$brushed" "rotate:deg=90;of=$brushed" "$metal" --size 256 --shrink 2 \
    --grid "$gallery/brushed.png"
python3 "$(dirname "$0")/../../examples/maps.py" "$work"
"$nqm" score "$work/steel" "$work/export" --map "$gallery/texels.png" -q
(cd "$work" && python3 "$gallery/../../studies/texture_sizes.py" steel sizes && "$nqm" batch sizes/sizes.csv --root . -o scores.csv)
draw sizes 1.25 sizes "$work/scores.csv"
"$nqm" label "reference=$work/steel" "test=$work/export" --tiles 2 --shape sphere --light interior --size 256 --lights 96 -q \
    --map "$gallery/textures.png"
if [ -n "$corpus" ]; then
    "$nqm" eval "$corpus" --split validation --pairs "$work/pairs.csv" --json >"$work/eval.json"
    draw bars 1.5 bars "$work/eval.json"
    draw scatter 1.25 scatter "$work/pairs.csv"
fi
[ -z "$log" ] || draw loss 1.5 loss "$log"

# The page needs a browser; without one its picture stays as it is.
if command -v chromium >/dev/null 2>&1; then
    "$nqm" report sgd:nickel 'perturb:gloss=0.9;of=sgd:nickel' abc:nickel ward:nickel -o "$work/report.html"
    chromium --headless --no-sandbox --disable-gpu --no-first-run --user-data-dir="$work/profile" --hide-scrollbars \
        --force-device-scale-factor=0.8 --window-size=1040,1695 --screenshot="$gallery/report.png" "file://$work/report.html"
    page=$gallery/../../build-web/nqm.html
    [ ! -e "$page" ] || node "$gallery/../../tests/web/shots.mjs" "$page" chromium "$gallery"
fi
