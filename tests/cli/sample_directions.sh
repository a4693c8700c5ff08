#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm directions and nqm sample: round trip through files, the same set for the same seed, columns, invalid values,
# pipes, refusals.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors" 40

run 0 directions
[ "$(wc -l <"$dir/out")" = 501 ] || fail "500 directions and a header"
[ "$(head -n 1 "$dir/out")" = theta_h,theta_d,phi_d ] || fail "header"
cp "$dir/out" "$dir/default.csv"
run 0 directions -n 500 --seed 1 -o "$dir/again.csv"
diff "$dir/default.csv" "$dir/again.csv" || fail "the defaults are not what the help says"
grep -q 'id [0-9a-f]\{16\}' "$dir/err" || fail "the id"
run 0 directions --seed 2
diff -q "$dir/default.csv" "$dir/out" >/dev/null && fail "another seed, the same set"
awk -F, 'NR > 1 && ($1 < 0 || $1 > 40 || $2 > 40) {bad = 1} END {exit bad}' "$dir/out" && fail "40 degrees is no bound yet"
run 0 directions --max-polar 40
awk -F, 'NR > 1 && ($1 < 0 || $1 > 40 || $2 > 40) {bad = 1} END {exit bad}' "$dir/out" || fail "--max-polar"
run 0 directions -n 50 sgd:nickel sgd:red-fabric -o "$dir/drawn.csv"
run 0 directions show "$dir/drawn.csv"
diff "$dir/drawn.csv" "$dir/out" || fail "what is read is what was written"
run 0 directions show "$dir/drawn.csv" --json
grep -q '"n": 50' "$dir/out" || fail "JSON of directions"
run 0 directions show "$dir/model.safetensors"
[ "$(wc -l <"$dir/out")" = 41 ] || fail "directions of a model"

# Samples: one row per direction, in order; lambert is constant.
run 0 sample lambert:kd=.5,.25,.125 --directions "$dir/drawn.csv" --csv
[ "$(head -n 1 "$dir/out")" = theta_h,theta_d,phi_d,r,g,b ] || fail "columns"
cut -d, -f1-3 "$dir/out" | diff "$dir/drawn.csv" - || fail "directions of the samples"
awk -F, 'function off(a, b) {a = a / b * 3.14159265358979 - 1; return a < -1e-6 || a > 1e-6}
    NR > 1 && (off($4, .5) || off($5, .25) || off($6, .125)) {bad = 1} END {exit bad}' "$dir/out" || fail "values"
cp "$dir/out" "$dir/lambert.csv"
"$tool" sample lambert:kd=.5,.25,.125 -d - <"$dir/drawn.csv" | diff "$dir/lambert.csv" - || fail "directions from a pipe"
run 0 sample sgd:nickel -d "$dir/model.safetensors" --json
{ grep -q '"n": 40' "$dir/out" && [ "$(grep -c '"theta_h"' "$dir/out")" = 40 ]; } || fail "JSON of samples"

printf 'theta_h,theta_d,phi_d\n10,20,30\n' >"$dir/one.csv"
run 0 sample lambert:kd=.5 -d "$dir/one.csv" --json
[ "$(number theta_h 1) $(number theta_d 1) $(number phi_d 1)" = '10.0 20.0 30.0' ] || fail "angles: $(cat "$dir/out")"

# Below the horizon there is no value: an empty field, null, or the value of the --invalid policy.
printf 'theta_h,theta_d,phi_d\n10,20,30\n89,80,0\n' >"$dir/horizon.csv"
run 0 sample lambert:kd=.5,.5,.5 -d "$dir/horizon.csv"
tail -n 1 "$dir/out" | grep -q '^89,80,0,,,$' || fail "an empty field where there is no value"
grep -q 'no value at 1 of 2' "$dir/err" || fail "silence about a hole"
run 0 sample lambert:kd=.5,.5,.5 -d "$dir/horizon.csv" --invalid zero
tail -n 1 "$dir/out" | grep -q '^89,80,0,0,0,0$' || fail "--invalid zero"
run 0 sample lambert:kd=.5,.5,.5 -d "$dir/horizon.csv" --json
grep -q '"g": null' "$dir/out" || fail "null where there is no value"
run 5 sample lambert:kd=.5,.5,.5 -d "$dir/horizon.csv" --invalid error

run 2 sample
run 2 sample lambert:kd=.5,.5,.5 --invalid never
run 2 sample lambert:kd=.5,.5,.5 --csv --json
run 3 sample "$dir/nowhere.binary"
run 3 sample lambert:kd=.5,.5,.5 -d "$dir/nowhere.csv"
printf 'theta_h,theta_d\n1,2\n' >"$dir/short.csv"
run 4 sample lambert:kd=.5,.5,.5 -d "$dir/short.csv"
grep -q 'short.csv.*phi_d' "$dir/err" || fail "the message names the file"
run 2 directions show
run 2 directions -n 0
run 2 directions -n 1000000
run 3 directions "$dir/nowhere.binary"
run 3 directions -o "$dir/no/such/folder.csv"
run 4 directions show "$dir/short.csv"
run 2 directions show default --pairs --json

# Scores of measured values: as those of the BRDFs that were sampled, from half-vector angles or from light and viewer, in any order
# of the rows.
jods() { run 0 score "$@" --json -m default; number jod 1; number jod_low 1; number delta_e_itp 1; }
jods sgd:nickel ward:nickel >"$dir/expected"
for brdf in sgd ward; do "$tool" sample $brdf:nickel >"$dir/$brdf.csv"; done
jods --samples "$dir/sgd.csv" "$dir/ward.csv" >"$dir/jods"
diff "$dir/expected" "$dir/jods" || fail "samples are scored as something else"
[ ! -s "$dir/err" ] || fail "talk about complete samples"
run 0 directions show default --pairs -o "$dir/pairs.csv"
head -n 1 "$dir/pairs.csv" | grep -qx 'theta_h,theta_d,phi_d,theta_i,phi_i,theta_o,phi_o' || fail "columns of --pairs"
run 0 directions show default
cut -d, -f 1-3 "$dir/pairs.csv" | diff - "$dir/out" || fail "--pairs changes the directions"
for brdf in sgd ward; do
    cut -d, -f 4-7 "$dir/pairs.csv" | paste -d, - "$dir/$brdf.csv" | cut -d, -f 1-4,8-10 >"$dir/$brdf-pairs.csv"
    { head -n 1 "$dir/$brdf-pairs.csv" && tail -n +2 "$dir/$brdf-pairs.csv" | sort -r; } >"$dir/$brdf-sorted.csv"
done
head -n 1 "$dir/sgd-pairs.csv" | grep -qx 'theta_i,phi_i,theta_o,phi_o,r,g,b' || fail "columns"
jods --samples "$dir/sgd-sorted.csv" "$dir/ward-pairs.csv" >"$dir/jods"
paste "$dir/expected" "$dir/jods" | awk '{ d = $1 - $2; if (d > 1e-6 || d < -1e-6) { print; bad = 1 } } END { exit bad }' ||
    fail "directions of light and viewer change the score"
run 0 info "$dir/sgd-sorted.csv"
grep -q '^albedo_normal  *-, -, -$' "$dir/out" || fail "an unknown albedo: $(cat "$dir/out")"

# Directions that are missing: how many, and what writes them. Other files are refused; a complete grid is interpolated.
head -n 401 "$dir/sgd.csv" >"$dir/short.csv"
run 5 score --samples "$dir/short.csv" "$dir/ward.csv"
grep -q 'short.csv: values at [0-9]* of the 1872 directions of the model, measured' "$dir/err" || fail "how many: $(cat "$dir/err")"
grep -q 'nqm directions show default --pairs' "$dir/err" || fail "no way out: $(cat "$dir/err")"
head -n 1801 "$dir/sgd.csv" >"$dir/nearly.csv"
run 0 score --samples "$dir/nearly.csv" "$dir/ward.csv"
grep -q 'nearly.csv: values at 18[0-9]* of the 1872' "$dir/err" || fail "silence about missing directions"
run 2 score --samples "$dir/sgd.csv" ward:nickel
says 'ward:nickel is no CSV of directions and values'
run 3 score --samples "$dir/sgd.csv" "$dir/nowhere.csv" "$dir/ward.csv" -q
[ "$(sed -n 1p "$dir/out")" = nan ] || fail "a missing file stops the others"
awk 'BEGIN { print "theta_h,theta_d,phi_d"; for (h = 0; h <= 90; h += 5) for (d = 0; d <= 90; d += 10) for (p = 0; p < 180; p += 30) print h "," d "," p }' >"$dir/grid.csv"
"$tool" sample sgd:nickel -d "$dir/grid.csv" >"$dir/grid-sgd.csv" 2>"$dir/err"
run 0 score --samples "$dir/sgd.csv" "$dir/grid-sgd.csv" -q
grep -q 'interpolated (19 theta_h x 10 theta_d x 6 phi_d, .* at most 5, 10 and 30 degrees apart)' "$dir/err" || fail "a grid: $(cat "$dir/err")"

# A fit uses the rows of a list as they are. Where they are far from the directions of the model, how far is said, and perceptual losses
# are refused or left out.
ward='ward:kd=.3,.2,.1;ks=.05;alpha=.1'
"$tool" sample "$ward" >"$dir/list.csv"
run 0 fit "$dir/list.csv" -m ward --json
[ ! -s "$dir/err" ] || fail "talk about a complete list: $(cat "$dir/err")"
grep -q '"jod": 10.0' "$dir/out" || fail "not the BRDF that was sampled: $(cat "$dir/out")"
head -n 541 "$dir/list.csv" >"$dir/few.csv"
run 0 fit "$dir/few.csv" -m ward -q
spec=$(cat "$dir/out")
grep -q 'few.csv: its nearest row is [0-9.]* degrees (median; 95 %: [0-9.]*) away' "$dir/err" || fail "how far: $(cat "$dir/err")"
grep -q 'few.csv, ward: fitted by ma_crwe, as too few directions' "$dir/err" || fail "no word about the loss: $(cat "$dir/err")"
run 0 score "$ward" "$spec" --json
grep -q '"jod": \(10.0\|9.99\)' "$dir/out" || fail "another BRDF: $spec"
run 5 fit "$dir/few.csv" -m ward --loss nqm
says "few.csv: values at only [0-9]* of the 1872 directions of the model 'default'; the loss auto or ma_crwe"
run 0 score "$dir/few.csv:20" "$ward" -q --min-valid .1
grep -q 'few.csv:20: its nearest row is' "$dir/err" || fail "how far: $(cat "$dir/err")"

run 5 fit "$dir/few.csv" -m sparse-0 -o "$dir/few.safetensors"
says 'few.csv: a list of directions; only analytic and shading models'

# Faults of measured values that a low score shows.
awk -F, 'NR > 1 { for (i = 4; i < 7; ++i) $i *= 255 } { print $1 "," $2 "," $3 "," $4 "," $5 "," $6 }' "$dir/sgd.csv" >"$dir/scaled.csv"
run 0 score sgd:nickel "$dir/scaled.csv" -q
grep -q 'scaled.csv: about 255 times its reference at most directions: is a scale missing' "$dir/err" || fail "a scale: $(cat "$dir/err")"
paste -d, "$dir/pairs.csv" "$dir/sgd.csv" | awk -F, 'NR == 1 { print "theta_h,theta_d,phi_d,r,g,b" }
    NR > 1 { c = cos($6 * atan2(0, -1) / 180); print $1 "," $2 "," $3 "," $11 * c "," $12 * c "," $13 * c }' >"$dir/cosine.csv"
run 0 score sgd:nickel "$dir/cosine.csv" -q
grep -q 'cosine.csv: about its reference times the cosine of light or viewer' "$dir/err" || fail "a cosine: $(cat "$dir/err")"
run 0 score lambert:kd=.2 'lambert:kd=.62831853' -q
grep -q 'kd=.62831853: its reference times pi at nearly all directions: a Lambertian f_r is its albedo / pi' "$dir/err" || fail "pi: $(cat "$dir/err")"
run 0 score sgd:nickel ward:nickel -q
[ ! -s "$dir/err" ] || fail "a suspicion of a fit: $(cat "$dir/err")"

# The same words in the documents of `score`, and in the rows of `batch`, also where finished pieces have them.
run 0 score sgd:nickel "$dir/cosine.csv" --json
grep -q '"test: about its reference times the cosine of light or viewer' "$dir/out" || fail "no suspicion in JSON"
printf 'reference,test\nsgd:nickel,%s\nsgd:nickel,%s\nsgd:nickel,ward:nickel\n%s:20,%s\n' scaled.csv cosine.csv few.csv "$ward" >"$dir/list-faults.csv"
sed -i "s/,ward:kd.*/,\"$ward\"/" "$dir/list-faults.csv"
for work in '' "--work $dir/pieces" "--work $dir/pieces"; do
    # shellcheck disable=SC2086
    run 0 batch "$dir/list-faults.csv" --min-valid .1 $work
    sed -n 2p "$dir/out" | grep -q 'test: about 255 times its reference at most directions: is a scale missing' || fail "a scale in batch"
    sed -n 3p "$dir/out" | grep -q 'test: about its reference times the cosine of light or viewer' || fail "a cosine in batch"
    sed -n 4p "$dir/out" | grep -q 'about' && fail "a suspicion of a fit in batch"
    sed -n 5p "$dir/out" | grep -q 'reference: its nearest row is [0-9.]* degrees (median; 95 %: [0-9.]*) away' || fail "how far in batch"
done
