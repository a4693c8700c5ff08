#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm regress: made-up scores give the coefficients of their curve; bad files give the documented exit codes; with the
# shared data, the authors' scores give the paper's coefficients.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
# near VALUE EXPECTED TOLERANCE
near() { awk -v a="$1" -v b="$2" -v t="$3" 'BEGIN {d = a - b; if (d < 0) d = -d; exit !(d <= t)}'; }
number() { sed -n 's/.*"'"$1"'": *\(-*[0-9.e+-]*\).*/\1/p' "$2"; }

# The paper's formula for b = (-14, -0.47, -0.21), computed by awk.
{
    echo 'name,jod,deltae'
    awk 'BEGIN {for (i = 1; i <= 40; ++i) {
        d = 1.7 * i; z = -14 * (-exp(-0.21 * log(d)) + 0.47)
        printf "pair %d,%.12f,%.12f\n", i, 10 * (1 - 1 / (1 + exp(z))), d}}'
} >"$dir/scores.csv"
"$tool" regress "$dir/scores.csv" --json >"$dir/out.json"
near "$(number b1 "$dir/out.json")" -14 1e-4 || fail "b1: $(cat "$dir/out.json")"
near "$(number b2 "$dir/out.json")" -0.47 1e-5 || fail "b2"
near "$(number b3 "$dir/out.json")" -0.21 1e-5 || fail "b3"
near "$(number spearman "$dir/out.json")" -1 1e-12 || fail "spearman"
[ "$(number n "$dir/out.json")" = 40 ] || fail "n"
"$tool" regress "$dir/scores.csv" | grep -q 'RMSE' || fail "no text"

data=${NQM_DATA:-${NQM_SOURCE:-.}/../shared/data}
[ -r "$data/labels/labels_real.csv" ] || exit 77
"$tool" regress "$data/labels/labels_real.csv" --json >"$dir/out.json"
near "$(number b1 "$dir/out.json")" -14.112 0.001 || fail "the authors' b1: $(cat "$dir/out.json")"
near "$(number b2 "$dir/out.json")" -0.4737 0.0001 || fail "the authors' b2"
near "$(number b3 "$dir/out.json")" -0.2148 0.0001 || fail "the authors' b3"
near "$(number rmse "$dir/out.json")" 1.0353 0.00005 || fail "the authors' RMSE"
near "$(number spearman "$dir/out.json")" -0.8457 0.00005 || fail "the authors' Spearman"
[ "$(number n "$dir/out.json")" = 180 ] || fail "the authors' n"
