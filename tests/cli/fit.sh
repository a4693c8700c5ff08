#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm fit: a model fitted to itself recovers its parameters, other commands accept the printed spec, all output formats
# agree, and a stopped fit leaves nothing.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
ref='ward:kd=0.3,0.2,0.1;ks=0.05;alpha=0.1'

spec=$("$tool" fit "$ref" --model ward --samples 1500 -q)
echo "$spec" | awk -F'[=;,]' '
    function near(a, b) {d = a - b; return (d < 0 ? -d : d) <= 0.002 * b}
    /^ward:/ && near($2, .3) && near($3, .2) && near($4, .1) && near($6, .05) && near($8, .1) {ok = 1}
    END {exit !ok}' || fail "parameters: $spec"
"$tool" info "$spec" --json | grep -q '"ward"' || fail "info does not take $spec"

"$tool" fit "$ref" --model ward --samples 1500 --json >"$dir/ward.json"
for key in spec model loss_name loss metrics jod jod_low jod_high delta_e_itp; do
    grep -q "\"$key\":" "$dir/ward.json" || fail "no $key: $(cat "$dir/ward.json")"
done
grep -qF "\"$spec\"" "$dir/ward.json" || fail "JSON says another spec than -q"
[ "$(grep -c '"[rml][a-z_]*": [0-9.e+-]*,*$' "$dir/ward.json")" -ge 9 ] || fail "nine metrics: $(cat "$dir/ward.json")"
"$tool" fit "$ref" --model ward --verbose --loss cube-root | grep -q "(cube-root), 6000 directions" || fail "verbose"
"$tool" fit "$ref" --model ward --samples 500 -q --seed 2 >/dev/null

# Several models: one row per model, the best JOD first, without duplicates.
"$tool" fit "$ref" --model abc,ward,abc --samples 500 >"$dir/table"
awk 'NR == 1 && $1 == "model" && $4 == "JOD" {ok++} NR == 2 && $1 == "ward" && $4 == "10.00" {ok++}
     NR == 3 && $1 == "abc" && $4 < 10 && $NF ~ /^abc:/ {ok++}
     END {exit !(ok == 3 && NR == 3)}' "$dir/table" || fail "table: $(cat "$dir/table")"
"$tool" fit "$ref" --model ward,lafortune,smooth --samples 500 --json | grep -c '"spec": "' | grep -qx 3 || fail "results in JSON"

# Losses: words, sums, and the selection among candidates, which JSON names.
for loss in log_diff ma_crwe nqm transport log_diff+0.2*nqm; do
    "$tool" fit "$ref" --model ward --samples 500 --loss "$loss" --json >"$dir/out"
    grep -qF "\"loss_name\": \"$loss\"" "$dir/out" || fail "$loss: $(cat "$dir/out")"
done
"$tool" fit sgd:nickel --model ward --samples 500 --loss auto --json >"$dir/auto.json"
grep -q '"selected": "[a-z_-]*\(, then 100.ma_crwe+transport\)*"' "$dir/auto.json" || fail "auto: $(cat "$dir/auto.json")"
"$tool" transport make --shape sphere --light sun --points 32 -o "$dir/sun.safetensors" >/dev/null 2>&1
"$tool" fit sgd:nickel --model ward --samples 500 --loss auto:transport --transport "$dir/sun.safetensors" --metric transport -q |
    grep -q '^ward:' || fail "a scene of the user's"

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

# One of several fits fails: the message names it, the others are printed, and its error gives the exit code.
code=0
"$tool" fit "$ref" --model ggx,lafortune --bounds f0=.1:2 --samples 500 --json >"$dir/out" 2>"$dir/err" || code=$?
[ "$code" = 2 ] || fail "exit code $code of a failure among others"
grep -q 'ggx: the bounds of f0' "$dir/err" || fail "the failure is not named"
{ grep -q '"error":' "$dir/out" && grep -q '"lafortune:' "$dir/out"; } || fail "results: $(cat "$dir/out")"

# A run that ends without a result leaves no folder.
"$tool" fit "$ref" --model nbrdf,ward -o "$dir/stopped/" 2>"$dir/err" &
fitting=$!
until [ -d "$dir/stopped" ] || ! kill -0 "$fitting"; do sleep .1; done
kill -TERM "$fitting"
got=0
wait "$fitting" || got=$?
[ "$got" = 130 ] || fail "exit code of an interrupted fit: $got"
[ ! -e "$dir/stopped" ] || fail "an empty folder is left"

# The report: the fit by log and the one by the loss, with pictures.
"$tool" fit sgd:nickel --model ward --samples 500 --loss log_diff+nqm --report "$dir/page.html" -q >"$dir/out"
grep -qF "$(cat "$dir/out")" "$dir/page.html" || fail "the fit in the page"
grep -q 'ward, loss log_diff+nqm' "$dir/page.html" && grep -q 'ward, loss log (before)' "$dir/page.html" || fail "names in the page"
[ "$(grep -o '<img' "$dir/page.html" | wc -l)" = 8 ] || fail "pictures in the page"
grep -q "<img width='256' height='256'" "$dir/page.html" || fail "the size of the pictures"
