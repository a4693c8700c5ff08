#!/bin/sh
# SPDX-License-Identifier: MIT
# The pieces of nqm batch hold only with the same files of BRDFs: a small one is known by its contents, a large one by size and time.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors"
"${NQM_BUILD:?}/tests/make_brdf_files" "$dir"
cd "$dir"
cp valid-network.safetensors small.safetensors
cp valid.binary large.binary
ref=ggx:alpha=.3

# begin ROW...: a list, and its piece.
begin() {
    echo reference,test >list.csv
    for row in "$@"; do echo "$ref,$row" >>list.csv; done
    rm -rf pieces
    score
}
score() {
    run 0 batch list.csv --work pieces -m model.safetensors --invalid zero
    cp out scores.csv
    new=$(stat -c %i pieces/*.safetensors)
}
# kept, again WHAT: after a change, the piece is used or scored again; the output is that of a run without pieces.
kept() {
    old=$new
    score
    [ "$new" = "$old" ] || fail "scored again: $1"
}
again() {
    old=$new
    score
    [ "$new" != "$old" ] || fail "an old piece is used: $1"
    run 0 batch list.csv -m model.safetensors --invalid zero
    cmp out scores.csv || fail "another output: $1"
}

begin small.safetensors large.binary
cp scores.csv network.csv
kept nothing
touch small.safetensors
kept "the time of a small file"
cp valid-table.safetensors small.safetensors
again "a small file"
cmp -s scores.csv network.csv && fail "the changed file is not read"
touch -d '2001-01-01' large.binary
again "the time of a large file"

# Inside a spec, and in an archive.
begin 'perturb:gloss=0.9;of=small.safetensors' valid.zip:valid
cp valid-network.safetensors small.safetensors
again "a file in a spec"
begin 'between:t=0.5;with=(small.safetensors);of=ggx:alpha=.3' valid.zip:valid
cp valid-table.safetensors small.safetensors
again "a file in parentheses"
printf '\0' >>valid.zip
again "an archive"

# A measured file that a material file names.
mkdir scene
cp valid.bsdf scene/measured.bsdf
echo 'Material "measured" "string filename" "measured.bsdf"' >scene/material.pbrt
begin scene/material.pbrt
touch -d '2001-01-01' scene/measured.bsdf
kept "the time of a measured file"
echo >>scene/measured.bsdf
again "a measured file"

# A run that is resumed: its first piece has another file, its second one ends it.
awk -v r=$ref 'BEGIN {print "reference,test\n" r ",small.safetensors"; for (i = 0; i < 260; ++i) print r ",ggx:alpha=." 100 + i; print r ",late.h5"}' >list.csv
run 3 batch list.csv -o out.csv -m model.safetensors
cp valid.h5 late.h5
cp valid-network.safetensors small.safetensors
run 0 batch list.csv -o out.csv -m model.safetensors --resume
run 0 batch list.csv -m model.safetensors
cmp out out.csv || fail "resumed with another file"
