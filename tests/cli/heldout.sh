#!/bin/sh
# SPDX-License-Identifier: MIT
# The 20 materials of the human study (Kavoosighafi et al. 2025) are in no training artefact: no reference or group of the
# manifest of the shipped training corpus names one, no learned encoder was trained on one, and a list made from the
# shared data assigns none to training. The test corpus contains all of them, the test groups of the renderer materials, mirrors
# and analytic models, and no other material; those are in no training manifest either. The kinds of distortion reserved for it
# are not in the training corpus.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
source=${NQM_SOURCE:?}
data=${NQM_DATA:-$source/../shared/data}
held_out='acrylic_felt_green_rgb aluminium blue-fabric blue-metallic-paint bluebook cardboard cc_amber_citrine_rgb
color-changing-paint1 gold-metallic-paint2 green-metallic-paint2 ilm_l3_37_dark_green_rgb ilm_solo_m_68_rgb light-red-paint
notebook red-metallic-paint silver-metallic-paint2 specular-green-phenolic vch_dragon_eye_red_rgb vch_golden_yellow_rgb
violet-acrylic'
checked=0

# absent FILE: no reference or other material of this manifest is a held-out material by its group, its name
# (SOURCE-MATERIAL) or its BRDF.
absent() {
    grep -q '"references"' "$1" || fail "$1 is no manifest"
    if grep -q '"split": "test"' "$1"; then fail "$1 contains references of the test split"; fi
    for material in $held_out; do
        if grep -E "\"group\": \"$material\"|\"name\": \"[a-z]*-$material\"|^ *\"[a-z]*-$material\": |\"brdf\": \"(.*[:/])?$material(\.bsdf)?\"" "$1"; then
            fail "$1 contains $material"
        fi
    done
    checked=$((checked + 1))
}

# unseen FILE: the manifest counts no pairs of the kinds of distortion that it lists as unseen.
unseen() {
    kinds=$(sed -n '/"unseen_kinds": \[/,/\]/s/^ *"\(.*\)",*$/\1/p' "$1" | grep -v unseen_kinds)
    [ -n "$kinds" ] || fail "$1 names no unseen kinds"
    for kind in $kinds; do
        if grep -E "^ *\"$kind\":" "$1"; then fail "$1 contains pairs of $kind"; fi
    done
}

# same_splits MANIFEST...: references and other materials of the sources whose splits are a hash of their names are in that split.
same_splits() {
    PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$source/models python3 - "$@" <<'END' || fail "splits of $*"
import json
import sys

from scan import GENERATED, split_of

sources = {"renderer"} | {source for source, _, _, _ in GENERATED}
for path in sys.argv[1:]:
    with open(path) as file:
        manifest = json.load(file)
    for reference in manifest["references"]:
        if reference["source"] in sources:
            expected = split_of(1, reference["group"], None)
            assert reference["split"] == expected, (path, reference["name"], expected)
    for split, names in manifest["other_materials"].items():
        for name in names:
            if name.split("-")[0] in sources:
                assert split_of(1, name, None) == split, (path, split, name)
END
}

# learned FILE: a learned encoder names its training materials, and no held-out material is among them.
learned() {
    head -c 1000000 "$1" | tr -c '[:print:]' '\n' | sed -n 's/.*"references":"\[\([^]]*\)\]".*/\1/p' | tr ',' '\n' |
        sed 's/^\\"//; s/\\"$//' >"$dir/seen"
    [ "$(wc -l <"$dir/seen")" -ge 50 ] || fail "$1 does not say what it was learned from"
    for material in $held_out; do
        if grep -E "^([a-z]+-)?$material(\.bsdf)?\$|[:/]$material(\.bsdf)?\$" "$dir/seen"; then fail "$1 has seen $material"; fi
    done
    checked=$((checked + 1))
}

for manifest in "$source"/models/*train*.json; do
    if [ -f "$manifest" ]; then
        absent "$manifest"
        unseen "$manifest"
        same_splits "$manifest"
    fi
done
for encoder in "$source"/models/encoders/*.safetensors; do
    if [ -f "$encoder" ]; then learned "$encoder"; fi
done

if [ -f "$source/models/corpus-test.json" ]; then
    if grep -E '"split": "(train|validation)"' "$source/models/corpus-test.json"; then fail "the test corpus has other splits"; fi
    same_splits "$source/models/corpus-test.json"
    sed -n 's/^ *"group": "\(.*\)",$/\1/p' "$source/models/corpus-test.json" | grep -Ev '^(renderer|mirror|analytic)-' | sort -u >"$dir/groups"
    for material in $held_out; do echo "$material"; done | sort | cmp - "$dir/groups" || fail "the test corpus has other materials"
fi

if [ -f "$data/labels/labels_real.csv" ]; then
    awk -F, 'NR > 1 {sub(/_[0-9]+$/, "", $1); print $1}' "$data/labels/labels_real.csv" | sort -u >"$dir/names"
    for material in $held_out; do echo "$material"; done | sort >"$dir/expected"
    cmp "$dir/names" "$dir/expected" || fail "the list of this test is not that of labels_real.csv"
    python3 "$source/models/scan.py" "$data" >"$dir/materials.csv"
    python3 - "$dir/materials.csv" "$dir/expected" <<'END' || fail "the splits of models/scan.py"
import collections
import csv
import sys

with open(sys.argv[2]) as file:
    held_out = set(file.read().split())
with open(sys.argv[1], newline="") as file:
    rows = list(csv.DictReader(file))
new = [row for row in rows if row["source"] in ("renderer", "mirror", "analytic")]
assert {row["group"] for row in rows if row["split"] == "test" and row not in new} == held_out
assert not {row["group"] for row in new} & {row["group"] for row in rows if row not in new}
assert len({row["group"] for row in new}) == len(new) and all(row["group"] == row["name"] for row in new)
for group in {row["group"] for row in rows}:
    assert len({row["split"] for row in rows if row["group"] == group}) == 1, group
splits = collections.Counter((row["source"], row["split"]) for row in new)
for source in ("renderer", "mirror", "analytic"):
    assert splits[source, "test"] >= 2 and splits[source, "validation"] >= 2, splits
assert len(new) >= 90 and 0.08 < sum(row["split"] == "test" for row in new) / len(new) < 0.22, splits
END
    checked=$((checked + 1))
fi
[ "$checked" -gt 0 ] || exit 77
