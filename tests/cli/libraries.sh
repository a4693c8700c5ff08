#!/bin/sh
# SPDX-License-Identifier: MIT
# Files of several materials as arguments of score and rank and in lists: their materials are paired by name; materials that are
# refused alike are skipped by batch; the order best first.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors" 20
cd "$dir" || exit 1
cat >old.gltf <<'END'
{"asset": {"version": "2.0"}, "materials": [
 {"name": "gold", "pbrMetallicRoughness": {"baseColorFactor": [1, 0.77, 0.34, 1], "roughnessFactor": 0.3}},
 {"name": "chalk", "pbrMetallicRoughness": {"metallicFactor": 0}},
 {"name": "glass", "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}},
 {"name": "gone", "pbrMetallicRoughness": {"metallicFactor": 0}}]}
END
sed 's/0.3}}/0.4}}/; s/"gone"/"new"/' old.gltf >new.gltf

# Pairs in the order of the reference; a material without partner has no score, one of the test only is named.
run 4 score old.gltf new.gltf -m model.safetensors --csv
cut -d, -f1,2 out >pairs
printf '%s\n' reference,test old.gltf:gold,new.gltf:gold old.gltf:chalk,new.gltf:chalk old.gltf:glass,new.gltf:glass \
    old.gltf:gone,new.gltf:gone | cmp - pairs || fail "pairs: $(cat pairs)"
grep -q 'new.gltf:new is not compared' err || fail "a new material: $(cat err)"
grep -q "there is no material 'gone'" err || fail "a removed material: $(cat err)"
"$tool" score old.gltf:gold new.gltf:gold -m model.safetensors --csv >one || fail "gold alone"
[ "$(sed -n 2p one)" = "$(sed -n 2p out)" ] || fail "the score of gold: $(cat one)"
run 4 score old.gltf new.gltf -m model.safetensors --json
[ "$(grep -c '"reference": "old.gltf:' out)$(grep -c '"reference": "old.gltf",' out)" = 41 ] || fail "references: $(cat out)"
run 4 score old.gltf new.gltf -m model.safetensors --exact
[ "$(grep -c 'NOT equal' out)$(grep -c '[^T] equal within' out)" = 11 ] || fail "values of two references: $(cat out)"

# One reference and a library of tests; a library is no reference of one test.
run 4 rank sgd:nickel L=old.gltf -m model.safetensors --csv
[ "$(grep -c '^sgd:nickel,[123],' out)" = 3 ] || fail "ranks: $(cat out)"
grep -q ',L:gold,' out || fail "names: $(cat out)"
run 2 score old.gltf sgd:nickel -m model.safetensors
grep -q "name one material of this file" err || fail "a library as reference: $(cat err)"

# A list: further columns are copied, names get the material, the refused material is skipped and does not end the run.
printf 'reference,test,note,name\nold.gltf,new.gltf,7,lib\nsgd:nickel,ward:nickel,8,\n' >list.csv
run 2 batch list.csv -m model.safetensors
grep -q 'row 4: new.gltf: there is no material' err || fail "the first failed row: $(cat err)"
run 9 batch list.csv -m model.safetensors -k -o all.csv --junit all.xml --markdown all.md
[ "$(grep -c '^old.gltf:[a-z]*,new.gltf:[a-z]*,7,lib,' all.csv)$(grep -c '^sgd:nickel,ward:nickel,8,,' all.csv)" = 41 ] ||
    fail "rows: $(cat all.csv)"
grep -q "tests='5' failures='0' errors='1' skipped='1'>$" all.xml || fail "counts: $(cat all.xml)"
grep -q "name='lib:glass'" all.xml || fail "names of cases: $(cat all.xml)"
grep -q "<skipped message='both are refused: .*transmissionFactor is 1" all.xml || fail "skipped: $(cat all.xml)"
grep -qx '### nqm: 5 pairs, 1 without a score, 1 skipped' all.md || fail "headline: $(cat all.md)"
sed 's/"transmissionFactor": 1/"transmissionFactor": 0.5/' new.gltf >newer.gltf
sed 's/new.gltf/newer.gltf/' list.csv >changed.csv
run 9 batch changed.csv -m model.safetensors -k --junit changed.xml
grep -q "errors='2' skipped='0'" changed.xml || fail "a refused material that changed: $(cat changed.xml)"

# Best first: the reverse order of the worst, but for rows without a score, which come last.
run 9 batch list.csv -m model.safetensors -k --sort worst -o worst.csv
run 9 batch list.csv -m model.safetensors -k --sort best -o best.csv
{ head -n 1 worst.csv; sed 1d worst.csv | tail -n 3 | tac; sed -n 2,3p worst.csv; } | cmp - best.csv || fail "the order: $(cat best.csv)"
run 2 batch list.csv -m model.safetensors -k --sort best --worst 1

# The same run again.
run 9 batch list.csv -m model.safetensors -k -o again.csv
cmp all.csv again.csv || fail "the same run"
