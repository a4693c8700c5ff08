#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm fit: a model fitted to itself recovers its parameters, other commands accept the printed spec, all output formats
# agree, and bad arguments give the documented exit codes.
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
"$tool" fit "$ref" --model ward --report --loss cube-root | grep -q "(cube-root), 6000 directions" || fail "report"
"$tool" fit "$ref" --model ward -q --seed 2 >/dev/null

# Several models: one row per model, in the order of the arguments, without duplicates.
"$tool" fit "$ref" --model abc,ward,abc --samples 500 >"$dir/table"
awk 'NR == 1 && $1 == "model" {ok++} NR == 2 && $1 == "abc" && $5 ~ /^abc:/ {ok++} NR == 3 && $1 == "ward" {ok++}
     END {exit !(ok == 3 && NR == 3)}' "$dir/table" || fail "table: $(cat "$dir/table")"
"$tool" fit "$ref" --model ward,lafortune,smooth --samples 500 --json | grep -c '"spec": "' | grep -qx 3 || fail "results in JSON"

# Bounds apply only to models that have the parameter; the number of starts must be an integer.
"$tool" fit "$ref" --model ward,blinn-phong --bounds alpha=.2:.5 --starts 3 --samples 500 -q >"$dir/bounded"
awk -F'alpha=' '/^ward:/ && $2 >= .2 && $2 < .21 {ok++} /^blinn-phong:/ {ok++} END {exit ok != 2}' "$dir/bounded" ||
    fail "bounds: $(cat "$dir/bounded")"

# A fitted network is written to a file, which nqm score accepts; without -o there is no file, and a message says so.
"$tool" fit "$ref" --model hyper-low --samples 500 --json >"$dir/hyper.json" 2>"$dir/err"
grep -q '"spec": null' "$dir/hyper.json" || fail "a spec of a network: $(cat "$dir/hyper.json")"
grep -q '"note":' "$dir/hyper.json" || fail "no note: $(cat "$dir/hyper.json")"
grep -q -- '-o FILE' "$dir/err" || fail "no hint"
"$tool" fit "$ref" --model hyper-low --samples 500 -o "$dir/one.safetensors" -q | grep -qxF "$dir/one.safetensors" || fail "path"
"$tool" score "$ref" "$dir/one.safetensors" -q >/dev/null || fail "score does not take the file"
"$tool" fit "$ref" --model ward,hyper-low --samples 500 -o "$dir/fits" -q >"$dir/out"
[ "$(tail -1 "$dir/out")" = "$dir/fits/hyper-low.safetensors" ] || fail "folder: $(cat "$dir/out")"
cmp "$dir/one.safetensors" "$dir/fits/hyper-low.safetensors" || fail "two runs differ"
[ "$(ls "$dir/fits")" = hyper-low.safetensors ] || fail "files: $(ls "$dir/fits")"
"$tool" fit "$ref" --model ward --samples 500 -o "$dir/none" >/dev/null 2>"$dir/err"
{ grep -q 'is not written' "$dir/err" && [ ! -e "$dir/none" ]; } || fail "a file for a spec"

# One of several fits fails: the message names it, the others are printed, and its error gives the exit code.
code=0
"$tool" fit "$ref" --model ggx,lafortune --bounds f0=.1:2 --samples 500 --json >"$dir/out" 2>"$dir/err" || code=$?
[ "$code" = 2 ] || fail "exit code $code of a failure among others"
grep -q 'ggx: the bounds of f0' "$dir/err" || fail "the failure is not named"
{ grep -q '"error":' "$dir/out" && grep -q '"lafortune:' "$dir/out"; } || fail "results: $(cat "$dir/out")"

refuses 2 . fit "$ref" --model phong
refuses 2 . fit "$ref" --model ward,
refuses 2 . fit "$ref" --model ward --bounds alpha=.1
refuses 2 . fit "$ref" --model ward --bounds alpha=.5:.1
refuses 2 . fit "$ref" --model ward --bounds f0=.1:.5
refuses 2 . fit "$ref" --starts 0
refuses 3 . fit "$ref" -o "$dir/no/such/"
refuses 2 . fit "$ref" --loss square
refuses 2 . fit "$ref" --samples 3
refuses 2 . fit
refuses 3 . fit "$dir/missing.bsdf"
refuses 2 . fit 'ward:kd=5000'
echo nonsense >"$dir/bad.bsdf"
refuses 4 . fit "$dir/bad.bsdf"
