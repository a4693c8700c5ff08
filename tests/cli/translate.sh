#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm translate: materials of one renderer as materials of another, written, read back and scored; the gate and refused materials.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
red='gltf:base_color=0.8,0.3,0.1;metallic=0;roughness=0.35'

# A model's own material is itself, in any of its files.
"$tool" translate "$red" --to gltf -o "$dir/red.glb" --samples 300 >"$dir/out"
grep -q '^JOD 10.00' "$dir/out" || fail "own material: $(cat "$dir/out")"
[ "$("$tool" score "$red" "$dir/red.glb" -q)" = 10.0000 ] || fail "the file is another material"

# A file for each material of a list; one is refused, which does not stop the others; the last line counts.
code=0
"$tool" translate "$dir/red.glb" nowhere.mtlx --to usd -d "$dir/usd" --samples 300 --loss log >"$dir/out" 2>&1 || code=$?
[ "$code" = 9 ] || fail "exit code $code of a refusal: $(cat "$dir/out")"
[ "$(tail -1 "$dir/out")" = "2 materials, 1 refused" ] || fail "summary: $(tail -1 "$dir/out")"
[ "$(ls "$dir/usd")" = red.mtlx ] || fail "files: $(ls "$dir/usd")"
grep -q UsdPreviewSurface "$dir/usd/red.mtlx" || fail "not a UsdPreviewSurface: $(cat "$dir/usd/red.mtlx")"

# A folder of files: all of its materials, also fitted; a file that is none is named.
mkdir "$dir/folder"
cp "$dir/red.glb" "$dir/folder/red.glb"
cp "$dir/usd/red.mtlx" "$dir/folder/usd.mtlx"
"$tool" translate "$dir/folder" --to gltf -d "$dir/from_folder" --samples 300 --loss log >"$dir/out"
[ "$(tail -1 "$dir/out")" = "2 materials, 0 refused" ] || fail "summary of a folder: $(cat "$dir/out")"
[ "$(ls "$dir/from_folder" | tr '\n' ' ')" = 'red.gltf usd.gltf ' ] || fail "files of a folder: $(ls "$dir/from_folder")"
echo nothing >"$dir/folder/notes.csv"
"$tool" fit "$dir/folder" --samples 300 --loss log >"$dir/out" 2>"$dir/err"
[ "$(grep -c '^reference ' "$dir/out")" = 2 ] && [ "$(grep -c '^ggx ' "$dir/out")" = 2 ] || fail "fits of a folder: $(cat "$dir/out")"
grep -q 'folder: these files are no materials or BRDFs: notes.csv$' "$dir/err" || fail "what is not read: $(cat "$dir/err")"
printf 'theta_i,phi_i,theta_o,phi_o,r\n10,0,20,x,1\n' >"$dir/folder/list.csv"
run 4 fit "$dir/folder" --samples 300 --loss log
grep -q "folder/list.csv: line 2, byte 38: column 'phi_o' needs a finite number" "$dir/err" || fail "a damaged list: $(cat "$dir/err")"
[ "$(grep -c '^reference ' "$dir/out")" = 2 ] || fail "the others are not fitted: $(cat "$dir/out")"
refuses 2 'folder is a folder: its fits are printed' fit "$dir/folder" --json

# What is lost: a conductor cannot be red paint; the gate says so, in the exit code too.
code=0
"$tool" translate "$red;sheen_color=0.5;clearcoat=0;clearcoat_roughness=0.3" --to rough-conductor --samples 300 --fail-under 9.99 --json >"$dir/json" || code=$?
[ "$code" = 1 ] || fail "exit code $code of the gate"
grep -q '"dropped": "base_color, metallic, sheen_color"' "$dir/json" || fail "dropped: $(cat "$dir/json")"
code=0
"$tool" translate "$red" nowhere.mtlx --to rough-conductor --samples 300 --loss log --fail-under 9.99 >"$dir/out" 2>&1 || code=$?
[ "$code" = 9 ] || fail "exit code $code of a refusal and the gate"
[ "$(tail -1 "$dir/out")" = "2 materials, 1 failed (JOD below 9.99), 1 refused" ] || fail "summary: $(tail -1 "$dir/out")"
for key in model input output spec jod jod_low jod_high transport_jod selected seconds pass failed refused; do
    grep -q "\"$key\":" "$dir/json" || fail "no $key: $(cat "$dir/json")"
done

# A file that only has refused materials is not written.
cat >"$dir/glass.mtlx" <<'XML'
<?xml version="1.0"?>
<materialx version="1.38">
  <standard_surface name="glass" type="surfaceshader"><input name="transmission" type="float" value="1" /></standard_surface>
  <surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="glass" /></surfacematerial>
</materialx>
XML
run 9 translate "$dir/glass.mtlx" "$dir/glass.mtlx" --to gltf -o "$dir/two.gltf"
[ ! -e "$dir/two.gltf" ] || fail "a file of refused arguments"

# Several materials in one file of each format: the names of the materials, a number where two are equal; what is refused is left out;
# each is scored as it was written; a line counts what was lost.
cd "$dir" || exit 1
cat >two.mtlx <<'XML'
<?xml version="1.0"?>
<materialx version="1.38" colorspace="lin_rec709">
  <gltf_pbr name="s1" type="surfaceshader"><input name="metallic" type="float" value="1" />
    <input name="clearcoat" type="float" value="1" /></gltf_pbr>
  <gltf_pbr name="s2" type="surfaceshader"><input name="metallic" type="float" value="0" />
    <input name="sheen_color" type="color3" value="0.3, 0.3, 0.3" /></gltf_pbr>
  <surfacematerial name="one" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s1" /></surfacematerial>
  <surfacematerial name="two" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s2" /></surfacematerial>
</materialx>
XML
for target in gltf.gltf gltf.glb gltf.mtlx rough-conductor.xml rough-conductor.json pbrt-conductor.pbrt; do
    run 9 translate two.mtlx glass.mtlx two.mtlx:one --to ${target%.*} -o all.${target#*.} --samples 300 --loss log 2>/dev/null
    for pair in one:one two:two one:one_2; do
        jod=$("$tool" score two.mtlx:${pair%:*} all.${target#*.}:${pair#*:} --csv 2>/dev/null | awk -F, 'NR == 2 {printf "%.2f", $3}')
        grep -q "^JOD  *$jod.* two.mtlx:${pair%:*} -> all.${target#*.}:${pair#*:}\($\|  dropped\)" out ||
            fail "$target, $pair, $jod: $(cat out)"
    done
done
grep -qx 'dropped: clearcoat in 2 materials, metallic in 1, sheen_color in 1' out || fail "what was lost: $(cat out)"

# The report, with pictures of the rendered size.
run 0 translate "$red" --to gltf --samples 300 --report page.html
grep -q "<img width='256' height='256'" page.html || fail "pictures of the report: $(grep -o "<img width='[0-9]*' height='[0-9]*'" page.html)"
