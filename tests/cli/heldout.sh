#!/bin/sh
# SPDX-License-Identifier: MIT
# The 20 materials of the human study (Kavoosighafi et al. 2025) are in no training artefact: no reference or group of the
# manifest of the shipped training corpus names one, no learned encoder was trained on one, and a list made from the
# shared data assigns none to training. The test corpus contains all of them and no other material, and the kinds of
# distortion reserved for it are not in the training corpus.
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
    fi
done
for encoder in "$source"/models/encoders/*.safetensors; do
    if [ -f "$encoder" ]; then learned "$encoder"; fi
done

if [ -f "$source/models/corpus-test.json" ]; then
    if grep -E '"split": "(train|validation)"' "$source/models/corpus-test.json"; then fail "the test corpus has other splits"; fi
    sed -n 's/^ *"group": "\(.*\)",$/\1/p' "$source/models/corpus-test.json" | sort -u >"$dir/groups"
    for material in $held_out; do echo "$material"; done | sort | cmp - "$dir/groups" || fail "the test corpus has other materials"
fi

if [ -f "$data/labels/labels_real.csv" ]; then
    awk -F, 'NR > 1 {sub(/_[0-9]+$/, "", $1); print $1}' "$data/labels/labels_real.csv" | sort -u >"$dir/names"
    for material in $held_out; do echo "$material"; done | sort >"$dir/expected"
    cmp "$dir/names" "$dir/expected" || fail "the list of this test is not that of labels_real.csv"
    python3 "$source/models/scan.py" "$data" >"$dir/materials.csv"
    for material in $held_out; do
        awk -F, -v m="$material" '$2 == m && $5 != "test" {exit 1}' "$dir/materials.csv" || fail "$material is not held out"
        awk -F, -v m="$material" '$2 == m {n++} END {exit !n}' "$dir/materials.csv" || fail "$material is not listed"
    done
    [ "$(awk -F, '$5 == "test" {print $2}' "$dir/materials.csv" | sort -u | wc -l)" = 20 ] || fail "not 20 test groups"
    checked=$((checked + 1))
fi
[ "$checked" -gt 0 ] || exit 77
