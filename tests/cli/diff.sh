#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm diff: versions of material files by name, with added, removed and renamed materials and changed properties; on a history of git, as
# its external difference and difftool.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
cd "$dir"

# paints FILE GOLD_ROUGHNESS RED_NAME EXTRA
paints() {
    cat >"$1" <<END
{"asset": {"version": "2.0"}, "materials": [
{"name": "gold", "pbrMetallicRoughness": {"baseColorFactor": [1, 0.8, 0.3, 1], "roughnessFactor": $2}},
{"name": "$3", "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.5, 0.05, 0.05, 1]}}$4,
{"name": "glass", "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}}]}
END
}
chalk=', {"name": "chalk", "pbrMetallicRoughness": {"metallicFactor": 0}}'
blue=', {"name": "blue", "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.05, 0.05, 0.5, 1]}}'
paints old.gltf 0.3 red "$chalk"
paints new.gltf 0.4 paint "$blue"
printf '{"asset": {"version": "2.0"}, "materials": [{"name": "lone"}]}' >lone.gltf
mkdir before after
cp old.gltf before/paints.gltf
cp new.gltf after/paints.gltf
cp lone.gltf after/

# Names with colons, as of name spaces: every verb addresses them.
sed 's/"gold"/"ns:a:gold"/' old.gltf >names.gltf
sed 's/"gold"/"ns:a:gold"/' new.gltf >names2.gltf
run 0 diff names.gltf names2.gltf
grep -q '  ns:a:gold  ' out && grep -q 'roughness 0.3 -> 0.4' out || fail "a name with colons: $(cat out)"
run 0 score names.gltf:ns:a:gold names2.gltf:ns:a:gold
run 0 score --ignore transmission names.gltf:ns:a:gold names.gltf:ns:a:gold
run 0 rank names.gltf:ns:a:gold names2.gltf:ns:a:gold names2.gltf:blue
run 0 dedup names.gltf --ignore transmission
! grep -q failed out || fail "dedup: $(cat out)"
run 0 nearest names.gltf:ns:a:gold --among names2.gltf --ignore transmission
grep -q 'names2.gltf:ns:a:gold' out || fail "nearest: $(cat out)"

run 0 diff old.gltf new.gltf
grep -q '  gold  ' out && grep -q 'roughness 0.3 -> 0.4' out && grep -q 'was red' out || fail "changed: $(cat out)"
grep -q '^  added   blue$' out && grep -q '^  removed chalk$' out || fail "added: $(cat out)"
grep -q '^1 changed, 1 added, 1 removed, 1 renamed, 1 unchanged$' out || fail "counts: $(cat out)"
run 1 diff old.gltf new.gltf --fail-under 9 --junit j.xml --markdown m.md --ignore transmission -q
[ "$(cat out)" = gold ] || fail "names: $(cat out)"
[ "$(grep -c '<failure' j.xml)" = 1 ] && grep -q "name='nqm diff' tests='3' failures='1' errors='0' skipped='0'" j.xml || fail "JUnit: $(cat j.xml)"
grep -q '^| FAIL | .* | gold | .*roughness 0.3 -\\> 0.4 |$' m.md || fail "Markdown: $(cat m.md)"
run 0 diff old.gltf new.gltf --json
tr -d ' \n' <out >flat
grep -q '"properties":\[{"property":"roughness","old":0.3,"new":0.4}\]' flat || fail "JSON: properties"
grep -q '"was":"red"' flat && grep -q '"added":\["blue"\],"removed":\["chalk"\]' flat || fail "JSON: names"
run 0 diff before after
grep -q '  paints.gltf:gold  ' out && grep -q '^  added   lone.gltf$' out || fail "folders: $(cat out)"
run 0 diff before before
grep -q '^0 changed, 0 added, 0 removed, 0 renamed, 4 unchanged$' out || fail "no change: $(cat out)"
run 0 diff /dev/null new.gltf
grep -q '0 changed, 4 added, 0 removed' out || fail "a new file: $(cat out)"
sed 's/"lone"/"lone", "pbrMetallicRoughness": {"roughnessFactor": 0.5}/' lone.gltf >one.gltf
sed 's/lone/only/' one.gltf >other.gltf
run 0 diff lone.gltf other.gltf
grep -q 'roughness default -> 0.5' out && grep -q 'was lone' out || fail "files of one material: $(cat out)"
run 0 diff old.gltf new.gltf --model paper
grep -q '^1 changed, 2 added, 2 removed, 0 renamed, 1 unchanged$' out || fail "renamed ones need pictures: $(cat out)"
run 3 diff missing.gltf new.gltf

# Maps: what they compute, whatever an image is called; a property that becomes a map; other pixels of the same name.
python3 "$NQM_SOURCE/examples/maps.py" maps 8
cp maps/steel/steel_Color.png colour.png
# textured FILE NAME IMAGE SCALE MORE
textured() {
    cat >"$1" <<END
{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_texture_transform"], "images": [{"uri": "$3"}, {"uri": "maps/steel/steel_NormalGL.png"}],
 "textures": [{"source": 0}, {"source": 1}], "materials": [{"name": "$2", "normalTexture": {"index": 1, "extensions":
 {"KHR_texture_transform": {"scale": [$4, $4]}}}, "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorTexture": {"index": 0} ${5:-}}}]}
END
}
textured t1.gltf a colour.png 2
textured t2.gltf a colour.png 1 ', "roughnessFactor": 0.5'
run 0 diff t1.gltf t2.gltf --json
tr -d '\n' <out | tr -s ' ' >flat
grep -q '{ "property": "roughness", "old": null, "new": 0.5 }' flat || fail "a value: $(cat flat)"
grep -q '"property": "normal", "old": "normal(maps/steel/steel_NormalGL.png \[2 0 0; 0 2 0\], 1)", "new": "normal(maps/steel/steel_NormalGL.png, 1)"' flat ||
    fail "a lost transform: $(cat flat)"
grep -q '"property": "base_color"' flat && fail "what is the same: $(cat flat)"
textured t3.gltf b maps/steel/steel_Color.png 2
run 0 diff t1.gltf t3.gltf
grep -q '^0 changed, 0 added, 0 removed, 1 renamed, 0 unchanged$' out || fail "other names: $(cat out)"
cp t1.gltf maps/t1.gltf
cp maps/half/steel_Color.png maps/colour.png
mkdir -p maps/maps/steel
cp maps/steel/steel_NormalGL.png maps/maps/steel
run 0 diff t1.gltf maps/t1.gltf
grep -q 'colour.png srgb_texture (other pixels)\|(other *$' out || fail "other pixels: $(cat out)"

# A history of git: its own commands show the differences, of changed, new and removed files.
command -v git >/dev/null || skip_rest diff_of_git
export HOME="$dir" GIT_CONFIG_NOSYSTEM=1
commit() { git add -A && git -c user.name=me -c user.email=me@localhost commit -qm "$1"; }
git init -q repository
cd repository
paints paints.gltf 0.3 red "$chalk"
echo text >readme
echo '*.gltf diff=nqm' >.gitattributes
commit first
paints paints.gltf 0.4 paint "$blue"
echo more >>readme
commit second
cp ../lone.gltf .
git rm -q paints.gltf
commit third
git config diff.nqm.command "'$tool' diff"
git --no-pager diff HEAD~2 HEAD~1 >../out 2>../err || fail "git diff"
grep -q "^old *paints.gltf$" ../out && grep -q "^new *paints.gltf$" ../out && grep -q 'roughness 0.3 -> 0.4' ../out && grep -q '^+more$' ../out || fail "git diff: $(cat ../out)"
git --no-pager diff HEAD~1 HEAD >../out 2>../err || fail "git diff"
grep -q '^  added   lone$' ../out && grep -q '^  removed gold$' ../out || fail "git diff: $(cat ../out)"
git checkout -q HEAD~1 && git mv paints.gltf colours.gltf && sed -i 's/0\.4/0.5/' colours.gltf && commit renamed
git --no-pager diff -M HEAD~1 HEAD >../out 2>../err || fail "git diff -M: $(cat ../err)"
{ grep -q '^old *paints.gltf$' ../out && grep -q '^new *colours.gltf$' ../out && grep -q 'roughness 0.4 -> 0.5' ../out; } ||
    fail "git diff -M: $(cat ../out ../err)"
git checkout -q -
git config difftool.nqm.cmd "'$tool' diff \"\$LOCAL\" \"\$REMOTE\""
git difftool -y -t nqm HEAD~2 HEAD~1 -- paints.gltf >../out 2>../err || fail "git difftool"
grep -q 'was red' ../out || fail "git difftool: $(cat ../out)"
git difftool -y -d -t nqm HEAD~2 HEAD~1 -- '*.gltf' >../out 2>../err || fail "git difftool -d"
grep -q '  paints.gltf:gold  ' ../out || fail "git difftool -d: $(cat ../out)"
GIT_EXTERNAL_DIFF="'$tool' diff" git --no-pager diff --ext-diff HEAD~2 HEAD~1 -- paints.gltf >../out 2>../err || fail "GIT_EXTERNAL_DIFF"
grep -q 'was red' ../out || fail "GIT_EXTERNAL_DIFF: $(cat ../out)"
