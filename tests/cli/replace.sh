#!/bin/sh
# SPDX-License-Identifier: MIT
# No run replaces a file that it reads, whatever the path by which the file is named; outputs keep permissions and links.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
cd "$dir"
mkdir kept d

# keep FILE: remember the content; refuses_to_replace FILE ARGUMENTS...: exit code 2 (a row of a list: with its number), same content.
keep() { cp "$1" kept/; }
refuses_to_replace() {
    file=$1
    shift
    run 2 "$@"
    grep -q 'would replace an input' err || fail "no reason: $*"
    cmp "$file" "kept/${file##*/}" || fail "replaced: $*"
}

# Names with characters that have a meaning in specs; members of files.
"$tool" translate 'gltf:base_color=0.8,0.3,0.1' --to standard-surface -o 'gold (1).mtlx' --samples 300 >out
name=$(sed -n 's/.*surfacematerial name="\([^"]*\)".*/\1/p' 'gold (1).mtlx')
keep 'gold (1).mtlx'
refuses_to_replace 'gold (1).mtlx' translate "gold (1).mtlx:$name" --to standard-surface -o 'gold (1).mtlx' --samples 300
"$tool" sample sgd:nickel >'s(2).csv'
keep 's(2).csv'
refuses_to_replace 's(2).csv' directions 'perturb:scale=.5;of=s(2).csv' -o 's(2).csv'
refuses_to_replace 's(2).csv' directions 'perturb:scale=.5;of=s(2).csv' -o './d/../s(2).csv'

# Files that lists and materials name.
printf 'reference,test\ns(2).csv,sgd:nickel\n' >list.csv
refuses_to_replace 's(2).csv' batch list.csv -o 's(2).csv'
keep list.csv
ln list.csv hard.csv
for output in list.csv ./d/../list.csv hard.csv; do refuses_to_replace list.csv batch list.csv -o "$output"; done
run 2 batch list.csv --keep-going -o 's(2).csv'
cmp 's(2).csv' 'kept/s(2).csv' || fail "a batch with --keep-going"
cp 'gold (1).mtlx' m.xml
keep m.xml
printf 'reference,test\nm.xml,sgd:nickel\n' >list-xml.csv
refuses_to_replace m.xml batch list-xml.csv -o new.csv --junit m.xml
"$tool" convert sgd:nickel -o d/x.binary
keep d/x.binary
cat >m.xml <<XML
<scene version="3.0.0"><bsdf type="measured" id="a"><string name="filename" value="d/x.binary"/></bsdf></scene>
XML
refuses_to_replace d/x.binary convert m.xml:a -o d/x.binary
"$tool" fit sgd:nickel --model sparse-0 -o d/sparse-0.safetensors >out 2>err || fail "an encoding to read"
keep d/sparse-0.safetensors
refuses_to_replace d/sparse-0.safetensors fit d/sparse-0.safetensors --model sparse-0,ward -o d/
"$tool" render sgd:nickel --size 16x8 -o f-1.exr
keep f-1.exr
refuses_to_replace f-1.exr render sgd:nickel --size 8 --light f-1.exr -o f-%d.exr --frames 2

# A later argument reads what an earlier one would replace.
mkdir out.d
"$tool" translate 'gltf:base_color=0.8,0.3,0.1' --to gltf -o red.gltf --samples 300 >out
cp red.gltf out.d/red.gltf
keep out.d/red.gltf
name=$(sed -n 's/.*"materials".*"name": *"\([^"]*\)".*/\1/p; s/^ *"name": *"\([^"]*\)".*/\1/p' red.gltf | head -1)
refuses_to_replace out.d/red.gltf translate red.gltf "perturb:gloss=.5;of=out.d/red.gltf:$name" --to gltf -d out.d --samples 300

# A material beside two of one name.
printf '{"asset":{"version":"2.0"},"materials":[{"name":"a"},{"name":"b"},{"name":"a"}]}' >twins.gltf
run 0 score twins.gltf:b sgd:nickel

# The dataset and its manifest.
"$tool" directions -n 40 -o directions.csv
cp d/sparse-0.safetensors enc.safetensors
keep enc.safetensors
printf 'reference,test\nenc.safetensors,sgd:nickel\n' >dataset-pairs.csv
refuses_to_replace enc.safetensors dataset dataset-pairs.csv --directions directions.csv -o enc.safetensors
cp dataset-pairs.csv set.safetensors.json
keep set.safetensors.json
refuses_to_replace set.safetensors.json dataset set.safetensors.json --directions directions.csv -o set.safetensors
[ ! -e set.safetensors ] || fail "work before the refusal"

# Permissions and links.
"$tool" directions -o free.csv
cp free.csv protected.csv
keep protected.csv
chmod 444 protected.csv
refuses 3 write-protected directions -n 5 -o protected.csv
cmp protected.csv kept/protected.csv || fail "a write-protected file"
umask 022
cp free.csv private.csv
chmod 600 private.csv
ln -s private.csv link.csv
run 0 directions -n 5 -o link.csv
[ -L link.csv ] || fail "a link is replaced"
[ "$(wc -l <private.csv)" = 6 ] || fail "the file of a link is unchanged"
[ "$(stat -c %a private.csv)" = 600 ] || fail "permissions $(stat -c %a private.csv)"
chmod 640 link.csv
run 0 batch list.csv -o link.csv
[ -L link.csv ] || fail "a link is replaced by a batch"
[ "$(stat -c %a private.csv)" = 640 ] || fail "permissions after a batch: $(stat -c %a private.csv)"

# What a run continues is no input.
run 0 batch list.csv -o again.csv
run 0 batch list.csv -o again.csv

# A map that a later material reads is not replaced by the map of an earlier one, whatever its name.
python3 "$NQM_SOURCE/examples/maps.py" maps 8
cp maps/steel/steel_Color.png mats_a_baseColor.png
cp maps/half/steel_Color.png col.png
cat >mats.gltf <<'END'
{"asset": {"version": "2.0"}, "images": [{"uri": "col.png"}, {"uri": "mats_a_baseColor.png"}], "textures": [{"source": 0}, {"source": 1}],
 "materials": [{"name": "a", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}},
               {"name": "b", "pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}}]}
END
run 9 translate mats.gltf --to gltf -d . --loss log --samples 200
grep -q 'refused.*mats_a_baseColor.png.*would replace an input' "$dir/out" || fail "the map is not named: $(cat "$dir/out")"
cmp -s mats_a_baseColor.png maps/steel/steel_Color.png || fail "a map that is read was replaced"
