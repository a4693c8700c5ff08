#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm batch --resume and --work go on only with the same files of BRDFs: a small one is known by its contents, a large one by size and
# time; the message names the file that has changed.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors"
"${NQM_BUILD:?}/tests/make_brdf_files" "$dir"
cd "$dir"
cp valid-network.safetensors small.safetensors
cp valid.binary large.binary
ref=ggx:alpha=.3
printf 'reference,test\n%s,small.safetensors\n%s,large.binary\n%s,late.h5\n' $ref $ref $ref >list.csv

# begin: a run that ends in its last row, because the file is missing.
begin() {
    rm -f late.h5 out.csv out.csv.part*
    run 3 batch list.csv -o out.csv -m model.safetensors --invalid zero
    cp valid.h5 late.h5
}

resume() { run "$1" batch list.csv -o out.csv -m model.safetensors --invalid zero --resume; }

begin
resume 0
mv out.csv expected.csv
[ "$(wc -l <expected.csv)" = 4 ] || fail "not all rows"

begin
cp valid-table.safetensors small.safetensors
resume 5
says "small.safetensors: --resume needs the same"
cp valid-network.safetensors small.safetensors # the same contents, another time
resume 0
cmp out.csv expected.csv

begin
touch -d '2001-01-01' large.binary
resume 5
says "large.binary: --resume needs the same"
begin
rm large.binary
resume 5
says "large.binary: --resume needs the same"
cp valid.binary large.binary

# Inside a spec, and in an archive.
printf 'reference,test\n%s,perturb:gloss=0.9;of=small.safetensors\n%s,valid.zip:valid\n%s,late.h5\n' $ref $ref $ref >list.csv
begin
cp valid-table.safetensors small.safetensors
resume 5
says "small.safetensors: --resume needs the same"
cp valid-network.safetensors small.safetensors
printf 'reference,test\n%s,between:t=0.5;with=(small.safetensors);of=%s\n%s,valid.zip:valid\n%s,late.h5\n' $ref $ref $ref $ref >list.csv
begin
cp valid-table.safetensors small.safetensors
resume 5
says "small.safetensors: --resume needs the same"
cp valid-network.safetensors small.safetensors
echo >>valid.zip
resume 5
says "valid.zip: --resume needs the same"

# A measured file that a material file names.
mkdir scene
cp valid.bsdf scene/measured.bsdf
echo 'Material "measured" "string filename" "measured.bsdf"' >scene/material.pbrt
printf 'reference,test\n%s,scene/material.pbrt\n%s,late.h5\n' $ref $ref >list.csv
begin
touch -d '2001-01-01' scene/measured.bsdf
resume 0
begin
echo >>scene/measured.bsdf
resume 5
says "scene/measured.bsdf: --resume needs the same"

# Pieces of another content are scored again.
printf 'reference,test\n%s,small.safetensors\n' $ref >list.csv
run 0 batch list.csv --work pieces -m model.safetensors
cp out network.csv
run 0 batch list.csv --work pieces -m model.safetensors
cmp out network.csv
cp valid-table.safetensors small.safetensors
run 0 batch list.csv --work pieces -m model.safetensors
cp out table.csv
run 0 batch list.csv -m model.safetensors
cmp out table.csv
! cmp -s network.csv table.csv || fail "the changed file was not read"
