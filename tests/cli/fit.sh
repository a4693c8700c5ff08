#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm fit: a model fitted to itself gives its parameters back, the spec it prints is what other verbs take, all output forms
# agree, and bad arguments give the contract's exit codes.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
ref='ward:kd=0.3,0.2,0.1;ks=0.05;alpha=0.1'

spec=$("$tool" fit "$ref" --model ward -q)
echo "$spec" | awk -F'[=;,]' '
    function near(a, b) {d = a - b; return (d < 0 ? -d : d) <= 0.002 * b}
    /^ward:/ && near($2, .3) && near($3, .2) && near($4, .1) && near($6, .05) && near($10, .1) {ok = 1}
    END {exit !ok}' || fail "parameters: $spec"
"$tool" info "$spec" --json | grep -q '"ward"' || fail "info does not take $spec"

"$tool" fit "$ref" --model ward --json >"$dir/ward.json"
for key in spec model loss_name loss metrics; do
    grep -q "\"$key\":" "$dir/ward.json" || fail "no $key: $(cat "$dir/ward.json")"
done
grep -qF "\"$spec\"" "$dir/ward.json" || fail "JSON says another spec than -q"
[ "$(grep -c '"[rml][a-z_]*": [0-9.e+-]*,*$' "$dir/ward.json")" -ge 9 ] || fail "nine metrics: $(cat "$dir/ward.json")"
"$tool" fit "$ref" --model all --json | grep -c '"spec"' | grep -qx 2 || fail "--model all"
"$tool" fit "$ref" --model ggx --loss cube-root | grep -q "'cube-root'" || fail "text"
"$tool" fit "$ref" --model ward -q --seed 2 >/dev/null

# expect CODE ARGUMENTS...
expect() {
    code=$1
    shift
    got=0
    "$tool" fit "$@" >"$dir/out" 2>"$dir/err" || got=$?
    [ "$got" = "$code" ] || fail "exit code $got, not $code: fit $*: $(cat "$dir/err")"
    { [ -s "$dir/err" ] && [ ! -s "$dir/out" ]; } || fail "output of a failure: fit $*"
}
expect 2 "$ref" --model phong
expect 2 "$ref" --loss square
expect 2 "$ref" --samples 3
expect 2
expect 3 "$dir/missing.bsdf"
expect 2 'ward:kd=5000'
echo nonsense >"$dir/bad.bsdf"
expect 4 "$dir/bad.bsdf"
