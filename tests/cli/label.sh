#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm label: greys under a white light give the Delta-E computed from the PQ curve; equal BRDFs give exactly 0; the
# output is the same for 1 and 2 threads; output formats; broken lights give the documented exit codes.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
# label CODE ARGUMENTS...
label() {
    code=$1
    shift
    run "$code" label "$@"
}

# A white light of 8 x 4 pixels. Lambert BRDFs of albedo 1/2 and 1/4 are displayed at 100 and 50 cd/m2; the ITP of a
# grey is (PQ, 0, 0).
header='#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n'
# pixels N BYTES
pixels() {
    i=0
    while [ $i -lt "$1" ]; do
        printf '%b' "$2"
        i=$((i + 1))
    done
}
{ printf '%b' "$header"; pixels 32 '\0200\0200\0200\0201'; } >"$dir/white.hdr"
label 0 lambert:kd=.5,.5,.5 lambert:kd=.25,.25,.25 lambert:kd=.5,.5,.5 --light "$dir/white.hdr" --exposure 200 --json
awk -v got="$(number delta_e_itp 1)" 'BEGIN {
    y1 = exp(2610 / 16384 * log(100 / 10000)); y2 = exp(2610 / 16384 * log(50 / 10000))
    p1 = exp(2523 / 32 * log((3424 / 4096 + 2413 / 128 * y1) / (1 + 2392 / 128 * y1)))
    p2 = exp(2523 / 32 * log((3424 / 4096 + 2413 / 128 * y2) / (1 + 2392 / 128 * y2)))
    error = got - 720 * (p1 - p2)
    exit !(error < 0.01 && error > -0.01)}' || fail "Delta-E of two greys is $(number delta_e_itp 1)"
[ "$(number delta_e_itp 2)" = 0.0 ] || fail "equal BRDFs differ"
grep -A1 '"tabulated"' "$dir/out" | grep -q '"reference": false' || fail "an analytic reference is tabulated: $(cat "$dir/out")"
[ "$(number jod 2)" = 10.0 ] || fail "equal BRDFs have no JOD of 10"

# The same bytes for 1 and 2 threads; text, CSV and plain values; another seed changes the result slightly.
small="--points 200 --lights 100"
# shellcheck disable=SC2086
{
    OMP_NUM_THREADS=1 "$tool" label sgd:nickel ward:nickel $small --json >"$dir/one"
    OMP_NUM_THREADS=2 "$tool" label sgd:nickel ward:nickel $small --json >"$dir/two"
    cmp "$dir/one" "$dir/two" || fail "the number of threads changes the label"
    label 0 sgd:nickel ward:nickel $small
    grep -qx 'reference  sgd:nickel' "$dir/out" || fail "the reference is not named"
    grep -q '^  Delta-E  *JOD  *adapted  *verdict  *test$' "$dir/out" || fail "no head line"
    ! grep -q '.\{81\}' "$dir/out" || fail "lines of more than 80 columns: $(cat "$dir/out")"
    label 0 sgd:nickel ward:nickel $small --csv
    [ "$(wc -l <"$dir/out")" = 2 ] || fail "CSV: two lines"
    label 0 sgd:nickel ward:nickel ward:nickel $small -q
    [ "$(wc -l <"$dir/out")" = 2 ] || fail "quiet: two lines"
    label 0 sgd:nickel ward:nickel $small --seed 2 --json
    ! cmp -s "$dir/one" "$dir/out" || fail "the seed changes nothing"
}

# The paper's scene: eight views, of a shape and a light that must be given.
paper="--scene paper --shape sphere --light sun --points 50 --json"
# shellcheck disable=SC2086
label 0 sgd:nickel ward:nickel $paper
cp "$dir/out" "$dir/one"
label 0 sgd:nickel ward:nickel --shape sphere --light sun --points 50 --frames 8 --json
cmp "$dir/one" "$dir/out" || fail "--scene paper has not 8 frames"
# shellcheck disable=SC2086
label 0 sgd:nickel ward:nickel $paper --frames 2
[ "$(number frames 1)" = 2 ] || fail "--scene paper ignores --frames"

# The other tests are labelled if one cannot be opened.
label 3 sgd:nickel "$dir/nowhere.bsdf" sgd:nickel --points 50 --lights 50 --json
[ "$(number delta_e_itp 1)" = null ] || fail "a missing test has a label"
[ "$(number delta_e_itp 2)" = 0.0 ] || fail "the test behind a missing one has no label"
grep -q 'nowhere.bsdf' "$dir/err" || fail "the message does not name the file"

# A test that cannot be opened is told in its row.
label 2 sgd:nickel sgd:nosuchmetal
# Broken lights.
head -c 100 "$dir/white.hdr" >"$dir/cut.hdr"
label 4 sgd:nickel ward:nickel --light "$dir/cut.hdr"
grep -q 'cut.hdr: Radiance HDR at byte [0-9]' "$dir/err" || fail "the message does not name file and byte"
printf '#?RADIANCE\n\n-Y 2147483648 +X 2147483648\n' >"$dir/huge.hdr"
label 4 sgd:nickel ward:nickel --light "$dir/huge.hdr"
{ printf '%b' "$header"; pixels 32 '\0000\0000\0000\0000'; } >"$dir/black.hdr"
label 4 sgd:nickel ward:nickel --light "$dir/black.hdr"

# Ctrl-C.
interrupt label sgd:nickel ward:nickel --map "$dir/d.png" --size 512 --lights 2048

# Progress on a terminal: percent of each phase, no number of BRDFs or scenes that the percent contradicts.
script -qec "'$tool' label sgd:nickel ward:nickel --size 32" /dev/null </dev/null | tr '\r' '\n' >"$dir/out"
grep -q '^light: [0-9]* %' "$dir/out" || fail "no progress of the light: $(cat "$dir/out")"
grep -q '^label: [0-9]* % ' "$dir/out" || fail "no progress of the labels: $(cat "$dir/out")"
if grep -q '^view\|^l[a-z]*: .* of ' "$dir/out"; then fail "odd progress: $(cat "$dir/out")"; fi

# A list that ends at 70 degrees, beside the function that it lists: what has no value counts in neither picture, and is said.
awk 'BEGIN { print "theta_i,phi_i,theta_o,phi_o,r,g,b"
    for (i = 0; i <= 70; i += 10) for (o = 0; o <= 70; o += 10) for (p = 0; p < 360; p += 30) print i ",0," o "," p ",.1,.1,.1" }' >"$dir/grid.csv"
grey=lambert:kd=0.3141592654
label 5 "$dir/grid.csv" $grey --points 100 --lights 64
grep -q 'grid.csv: values at directions of [0-9.]* % of the light of the scene, and 90 % are required' "$dir/err" || fail "refusal: $(cat "$dir/err")"
label 0 "$dir/grid.csv" $grey --points 100 --lights 64 --min-valid .5
grep -q '(no value for [0-9.]* % of the light, which counts in neither picture)' "$dir/out" || fail "no note: $(cat "$dir/out")"
for pair in "$dir/grid.csv $grey" "$grey $dir/grid.csv"; do
    # shellcheck disable=SC2086
    label 0 $pair --size 16 --min-valid .5 --json --map "$dir/holes.png"
    awk -v d="$(number delta_e_itp 1)" -v v="$(number valid 1)" -v m="$(number delta_e_max 1)" \
        'BEGIN { exit !(d < 1e-4 && m == 1 && v > .5 && v < 1) }' || fail "$pair: $(cat "$dir/out")"
done
run 0 render "$dir/grid.csv" -o "$dir/holes.png" --size 16 --min-valid .5 --json
grep -q 'has no value for directions of [0-9.]* % of the light, which is missing in the picture' "$dir/err" || fail "render: $(cat "$dir/err")"
awk -v v="$(number valid 1)" 'BEGIN { exit !(v > .5 && v < 1) }' || fail "render: $(cat "$dir/out")"
