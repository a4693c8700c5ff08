#!/bin/sh
# SPDX-License-Identifier: MIT
# The table of doc/labels.md: our Delta-E beside the authors' published Delta-E for their Ward, GGX and NBRDF encodings of the
# measured RGL materials that are not in the test set, by agreement.py. DATA holds rgl/, nbrdf/, labels/ and scene/ (doc/corpus.md).
# usage: studies/agreement.sh DATA [options of nqm label]
set -eu
data=${1:?usage: studies/agreement.sh DATA [options of nqm label]}
shift
here=$(dirname "$0")
pairs=$(mktemp)
trap 'rm -f "$pairs"' EXIT

# The authors' file repeats rows with a counter behind the name to balance it: each pair counts once here.
echo "reference,test,encoding,delta_e" >"$pairs"
for file in "$data"/rgl/*.bsdf; do
    material=$(basename "$file" .bsdf)
    awk -F, -v m="$material" '
        { name = $1; sub(/_[0-9]+$/, "", name) }
        name == m && ($2 == "ward" || $2 == "ggx" || $2 == "nbrdf") && !seen[$2]++ {
            test = $2 == "nbrdf" ? "nbrdf/rgl-isotropic_nbrdf.zip:" m : "fit"
            print "rgl/" m ".bsdf," test "," $2 "," $4
        }' "$data/labels/labels_balanced_train.csv"
done >>"$pairs"
python3 "$here/agreement.py" "$pairs" --root "$data" --light "$data/scene/pixar_campus_rgbe.png" "$@"
