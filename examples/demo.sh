#!/bin/sh
# SPDX-License-Identifier: MIT
# Score a few BRDFs without any files, and label some by rendering. Published SGD parameters of MERL materials (Bagher et al. 2012)
# serve as references; published Ward fits (Ngan et al. 2005), perturbed copies and other materials are compared with them.
# usage: demo.sh PATH-TO-NQM
set -eu
nqm=${1:-nqm}

# Print a command as a shell reads it, and run it.
run() {
    printf '\n$ nqm'
    for argument in "$@"; do
        case $argument in *';'*) printf " '%s'" "$argument" ;; *) printf ' %s' "$argument" ;; esac
    done
    echo
    "$nqm" "$@"
}

echo "nqm: how good does a BRDF approximation look next to its reference?"
run score sgd:nickel ward:nickel "perturb:gloss=0.9;of=sgd:nickel" sgd:nickel
run score sgd:blue-rubber ward:blue-rubber "perturb:tint=1.2,1,1;of=sgd:blue-rubber"
run score sgd:gold-metallic-paint "perturb:noise=0.02;of=sgd:gold-metallic-paint" \
    "perturb:noise=0.1;of=sgd:gold-metallic-paint" "perturb:noise=0.4;of=sgd:gold-metallic-paint" --metrics all
run score "ggx:alpha=.1,.4;f0=.9,.6,.3" "rotate:deg=90;of=ggx:alpha=.1,.4;f0=.9,.6,.3" "ggx:alpha=.2;f0=.9,.6,.3"
run check sgd:nickel
echo
echo "Materials that really differ: first predicted from the BRDFs, then measured on rendered pictures (JOD, Delta-E and words)."
set -- sgd:red-fabric sgd:chrome sgd:pink-fabric sgd:green-fabric
run score "$@"
run label "$@"
echo
echo "Materials with image maps: a rusty plate, and a copy with two classical mistakes."
maps=$(mktemp -d)/maps
python3 "$(dirname "$0")/maps.py" "$maps"
run score "$maps/steel" "$maps/export" --map "$maps/difference.png"
echo "Where they differ: $maps/difference.png"
echo
echo "Next: nqm score YOUR_REFERENCE YOUR_APPROXIMATION (MERL .binary, RGL .bsdf, NBRDF .h5, or a spec; nqm info list)"
