#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm label: figures with one row per test and with one row per reference, kept renders, groups of references, refusals.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
# label CODE ARGUMENTS...
label() {
    code=$1
    shift
    run "$code" label "$@"
}
lambert=lambert:kd=.5,.5,.5

# A figure has one row per test and is the same for 1 and 2 threads.
label 0 sgd:nickel ward:nickel --size 32 --map "$dir/one.png" --json
grep -q '"delta_e_itp"' "$dir/out" || fail "no label beside the figure"
end=$(number delta_e_max 1 | sed 's/\.0$//')
[ "$end" -ge 50 ] || fail "the scale of the colours: $end"
label 0 sgd:nickel ward:nickel --size 32 --map "$dir/text.png"
cmp "$dir/one.png" "$dir/text.png" || fail "another figure the second time"
grep -q "^colours of differences: Delta-E 0 (dark) to $end and above" "$dir/out" || fail "the scale of the colours: $(cat "$dir/out")"
label 0 sgd:nickel ward:nickel sgd:nickel sgd:nickel sgd:nickel --size 32 --map "$dir/four.png"
# shellcheck disable=SC2046
set -- $(png_size "$dir/one.png") $(png_size "$dir/four.png")
{ [ "$1" -gt 96 ] && [ "$1" = "$3" ] && [ "$4" -gt "$2" ]; } || fail "sizes of the figures: $*"
OMP_NUM_THREADS=2 "$tool" label sgd:nickel ward:nickel --size 32 --map "$dir/again.png" -q >/dev/null
cmp "$dir/one.png" "$dir/again.png" || fail "the number of threads changes the figure"
label 0 sgd:nickel ward:nickel --size 32 --shrink 2 --map "$dir/small.png"
# shellcheck disable=SC2046
set -- "$1" $(png_size "$dir/small.png")
[ "$2" -lt "$1" ] || fail "--shrink shrinks nothing"

# A figure shows all four scenes: they take as many pixels as one picture with twice the --size.
label 0 sgd:nickel ward:nickel --light sun --size 64 --map "$dir/sun.png"
label 0 sgd:nickel ward:nickel --size 32 --map "$dir/set.png"
[ "$(png_size "$dir/sun.png")" = "$(png_size "$dir/set.png")" ] || fail "four scenes do not fill the place of one"
! cmp -s "$dir/sun.png" "$dir/set.png" || fail "the standard set is the sun"

# Groups: every test is compared with its own reference.
label 0 sgd:nickel ward:nickel + $lambert $lambert lambert:kd=.4,.4,.4 --size 16 --grid "$dir/grid.png" --csv
[ "$(head -n 1 "$dir/out" | cut -d, -f1-5)" = "test,delta_e_itp,jod,error,reference" ] || fail "columns of groups"
[ "$(wc -l <"$dir/out")" = 4 ] || fail "a row a test"
[ "$(sed -n 3p "$dir/out")" = "\"$lambert\",0,10,,\"$lambert\",0,0,0,0,0,10,no visible difference,\"$lambert\",0,0,1" ] || fail "a grey beside itself: $(sed -n 3p "$dir/out")"
[ -s "$dir/grid.png" ] || fail "no grid"

# Kept renders: pictures of every BRDF and difference maps of the tests; a failed test has none, and the others are
# written.
label 3 sgd:nickel "$dir/nowhere.bsdf" ward:nickel --light sun --size 16 --keep-renders "$dir/keep" --map "$dir/failed.png" -q
kept=$(cd "$dir/keep" && echo ./*)
[ "$kept" = "./00-sgd_nickel.exr ./00-sgd_nickel.png ./02-ward_nickel-difference.png ./02-ward_nickel.exr ./02-ward_nickel.png" ] ||
    fail "kept: $kept"
[ -s "$dir/failed.png" ] || fail "no figure with a failed test"
label 0 sgd:nickel ward:nickel --light sun --size 8 --frames 2 --keep-renders "$dir/keep" -q
[ -f "$dir/keep/01-ward_nickel-0002-difference.png" ] || fail "no second frame"
label 0 sgd:nickel ward:nickel --size 8 --keep-renders "$dir/standard" -q
[ -f "$dir/standard/01-ward_nickel-0004.png" ] || fail "not one picture for each scene of the standard set"

label 2 sgd:nickel ward:nickel --points 100 --map "$dir/x.png"
label 2 sgd:nickel ward:nickel --size 32 --shrink 3 --map "$dir/x.png"
label 2 sgd:nickel + ward:nickel sgd:nickel
label 2 sgd:nickel ward:nickel +
label 2 + +
label 3 sgd:nickel ward:nickel --size 8 --map "$dir/nowhere/x.png"
label 3 sgd:nickel ward:nickel --size 8 --keep-renders "$dir/nowhere/x"
[ ! -f "$dir/x.png" ] || fail "a refusal left a figure"
