#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm info and nqm check: text and JSON, the list of presets, verdicts and their exit codes, messages for files without
# a BRDF.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
has() { grep -q -- "$1" "$dir/out" || fail "no '$1' in: $(cat "$dir/out")"; }
complains() { grep -q -- "$1" "$dir/err" || fail "no '$1' in: $(cat "$dir/err")"; }

run 0 info list
[ "$(wc -l <"$dir/out")" = 1326 ] || fail "presets: $(wc -l <"$dir/out")"
[ "$(grep -c '^sgd:' "$dir/out")" = 100 ] || fail "sgd presets"
[ "$(grep -c '^ward:' "$dir/out")" = 86 ] || fail "ward presets"
run 0 info list --json
[ "$(grep -c '"material"' "$dir/out")" = 1326 ] || fail "presets in JSON"

run 0 info sgd:nickel
has 'format *sgd'
has 'source_doi *10.1111/j.1467-8659.2012.03147.x'
run 0 info 'lambert:kd=.5,.25,.125' --json
has '"kind": "brdf"'
has '"format": "lambert"'
has '"spec": "lambert:kd=0.5,0.25,0.125"'
has '"source_doi": null'
has '"n_values": 3'
has '"reciprocal": true'
has '^ *0.25,$' # the albedo
run 0 info 'ggx:kd=0;ks=1;alpha=0.1;f0=.04' --json # the albedo is that at normal incidence, about f0
awk '/albedo_normal/ {getline; exit !($1 > .038 && $1 < .042)}' "$dir/out" || fail "albedo: $(cat "$dir/out")"
run 0 info transport --json # a built-in model
has '"kind": "model"'
run 2 info 'ggx:alpha=7e9'
complains 'alpha needs one number or two separated by a comma, each from 0.0001 to 10'
[ ! -s "$dir/out" ] || fail "results on failure"
run 2 info
run 2 info sgd:nickle
complains 'sgd:nickel'
run 3 info "$dir/nowhere.bsdf"
complains 'nowhere.bsdf'
run 3 info "$dir"
printf 'no BRDF at all' >"$dir/text"
run 4 info "$dir/text"
complains 'text'
# A safetensors file that is neither a model nor a dataset; one whose header is cut off; one that claims a huge header.
printf '\020\000\000\000\000\000\000\000{"__metadata__":' >"$dir/cut.safetensors"
run 4 info "$dir/cut.safetensors"
complains 'cut.safetensors'
printf '\002\000\000\000\000\000\000\000{}' >"$dir/other.safetensors"
run 6 info "$dir/other.safetensors"
complains 'other.safetensors'
printf '\377\377\377\377\377\377\377\177{}' >"$dir/huge.safetensors"
run 4 info "$dir/huge.safetensors"

# a file of several materials
cat >"$dir/two.mtlx" <<'END'
<materialx version="1.39"><standard_surface name="a" type="surfaceshader"><input name="coat" type="float" value="1"/>
</standard_surface><standard_surface name="b" type="surfaceshader"><input name="coat" type="float" value="7"/>
</standard_surface><gltf_pbr name="c" type="surfaceshader"><input name="transmission" type="float" value="1"/></gltf_pbr></materialx>
END
run 0 info "$dir/two.mtlx"
has '^kind *materials'
has '^accepted *1'
has '^a  standard_surface  accepted'
has '^b  standard_surface  refused: standard-surface: coat needs one number from 0 to 1'
has '^c  gltf_pbr  refused: transmission is 1'
run 0 info "$dir/two.mtlx" --json
has '"byte_offset": 26'
has '"spec": "standard-surface:base=1;'
run 0 info "$dir/two.mtlx:a"
has 'format *standard-surface'
run 4 info "$dir/two.mtlx:b"
complains "two.mtlx: the material 'b' (standard_surface, byte 137): .*coat needs"
run 4 info "$dir/two.mtlx:c"
complains 'byte [0-9]*) is refused: transmission is 1'

run 0 check sgd:nickel 'ggx:kd=.3;alpha=.002'
[ "$(grep -c 'plausible$' "$dir/out")" = 2 ] || fail "two verdicts: $(cat "$dir/out")"
run 1 check lambert:kd=1 lambert:kd=1.1
has 'lambert:kd=1: plausible'
has 'lambert:kd=1.1: NOT PLAUSIBLE'
has 'FAILS.*110.0 %'
run 0 check lambert:kd=.0005
has 'lambert:kd=.0005: suspicious'
run 1 check 'ggx:ks=30;f0=1;alpha=.0005' --json # a lobe 0.03 degrees wide whose albedo exceeds 1
has '"ok": false'
has '"energy"'
run 0 check sgd:nickel --json --seed 5
cp "$dir/out" "$dir/first"
run 0 check sgd:nickel --json --seed 5
cmp -s "$dir/out" "$dir/first" || fail "the same seed gave other results"
run 3 check "$dir/nowhere" sgd:nickel lambert:kd=2 # the others are checked too
grep -q '^sgd:nickel: plausible' "$dir/out" || fail "a missing file ends the check"
grep -q '^lambert:kd=2: NOT' "$dir/out" || fail "a missing file ends the check"
run 0 check lambert:kd=.0005
grep -q 'a scale missing' "$dir/out" || fail "a wrong scale is not suspected"
! grep -q MERL "$dir/out" || fail "a spec with the scale of MERL files: $(cat "$dir/out")"
run 0 check lambert:kd=0
has 'suspicious: at most 0.0 %'
has '^ *every value is 0$'
run 2 check
# Tables without a positive value. In MERL files, negative numbers are no values.
{
    printf '\132\0\0\0\132\0\0\0\264\0\0\0'
    head -c 34992000 /dev/zero | tr '\0' '\277'
} >"$dir/negative.binary"
run 1 check "$dir/negative.binary"
has 'energy, reciprocity, positivity: unknown, there are no values'
has 'coverage *FAILS: 8192 of 8192 directions (100.0 %) have no value'
has 'in a MERL file, negative numbers mean that'
! grep -q ' ok' "$dir/out" || fail "no value is ok: $(cat "$dir/out")"
{
    printf '\223NUMPY\001\0\166\0%-117s\n' "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 2, 1, 3), }"
    for i in 1 2 3 4 5 6 7 8 9 10 11 12; do printf '\0\0\200\277'; done
} >"$dir/negative.npy"
run 1 check "$dir/negative.npy"
has 'positivity *FAILS: 8192 of 8192 values (100.0 %) have a negative channel'
has '^ *every value is negative or 0$'
awk 'length > 80' "$dir/out" | grep -v "$dir" && fail "lines wider than a terminal"
run 1 check "$dir/negative.npy" --json
has '"positivity"'
# A MERL file with its scale twice.
"$tool" convert lambert:kd=.0005 -o "$dir/dark.binary" >"$dir/err" 2>&1
run 0 check "$dir/dark.binary"
has 'is a scale missing? The values of$'
has '^ *a MERL file are those of the BRDF times 1500'

run 0 --version
[ "$(wc -l <"$dir/out")" = 3 ] || fail "lines: $(cat "$dir/out")"
has '^nqm [0-9]'
has '^libzip [0-9].*, kernels [a-z]'
has '^Embree \([0-9.]*[0-9] when needed\|off\), libjpeg-turbo [0-9].*, libpng [0-9].*, libwebp 1[.0-9]*, OpenEXR [0-9].*, no MPI library$'

# A list of directions and values is a BRDF with these values.
"$tool" sample sgd:nickel >"$dir/list.csv"
run 0 info "$dir/list.csv" --json
has '"format": "samples"'
"$tool" sample "$dir/list.csv" | cmp - "$dir/list.csv" || fail "the samples of a list differ from it"
run 0 check "$dir/list.csv"
has 'list.csv: plausible'
has 'energy *unknown: this is a list of directions'
has 'positivity *ok: 0 of 1872 values'
sed '2,$s/,[^,]*,[^,]*$/,-1,1/' "$dir/list.csv" >"$dir/negative.csv"
run 1 check "$dir/negative.csv" --json
has '"positivity"'
