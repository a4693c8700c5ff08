#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm plot: every drawing in every format, equal bytes in two runs, sizes and titles, messages for wrong inputs.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
OMP_NUM_THREADS=1
export OMP_NUM_THREADS
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors" 40

# plot CODE ARGUMENTS...
plot() {
    code=$1
    shift
    run "$code" plot "$@"
}
png_size() { od -A n -t u1 -j 16 -N 8 "$1" | awk '{print $3 * 256 + $4 "x" $7 * 256 + $8}'; }

"$tool" plot network "$dir/model.safetensors" -o "$dir/probe.svg" 2>"$dir/err" || {
    grep -q 'NQM_CAIRO is off' "$dir/err" || fail "nothing can be drawn"
    exit 77
}

# Inputs: labels near a curve, an evaluation, its pairs, two logs.
awk 'BEGIN {print "material,model,level,DeltaE,JOD,class"
    for (i = 1; i <= 60; ++i) printf "m,%s,0,%g,%g,1\n", i % 2 ? "ward" : "ggx", i, 10 / (1 + (i / 25) ^ 1.5) + (i % 3 - 1) / 5}' \
    >"$dir/labels.csv"
cat >"$dir/eval.json" <<'JSON'
{"schema": 1, "dataset": {"split": "test"}, "results": [
 {"name": "rmse", "type": "metric", "n": 60, "n_materials": 6, "spearman": -0.1, "ci95": null, "spearman_mean_by_material": null},
 {"name": "default", "type": "model", "n": 60, "n_materials": 6, "spearman": 0.9, "ci95": [0.8, 0.95],
  "spearman_mean_by_material": 0.92, "ci95_mean_by_material": [0.85, 0.97]}]}
JSON
awk 'BEGIN {print "ref,material,test,kind,split,delta_e,jod,default,rmse,family"
    for (i = 1; i <= 50; ++i) printf "r,m,t,k,test,%g,%g,%g,%g,%s\n", i, 10 - i / 10, 10 - i / 11, i / 90, i % 2 ? "encoding" : ""}' \
    >"$dir/pairs.csv"
awk 'BEGIN {print "epoch,train_loss,validation_loss,lr_first"
    for (i = 1; i <= 20; ++i) printf "%d,%g,%g,%g\n", i, 1 / i, 1.2 / i, i < 11 ? 1e-4 : 1e-5}' >"$dir/log.csv"
cp "$dir/log.csv" "$dir/second.csv"

# well_formed FILE: the elements of an XML file are closed in the right order.
well_formed() {
    head -n 2 "$1" | grep -q '<svg xmlns=' || fail "$1 is no SVG"
    tr '\n' ' ' <"$1" | sed 's/<?[^>]*?>//; s/</\n</g' | awk '
        /^<\// {sub(/^<\//, ""); sub(/>.*/, ""); if (n < 1 || open[n] != $0) exit bad = 1; --n; next}
        /^</ {if (!/>/) exit bad = 1; if (/\/>/) next; sub(/^</, ""); sub(/[ >].*/, ""); open[++n] = $0}
        END {exit bad || n != 0}' || fail "$1: elements do not match"
    if grep -qi 'nan\|inf"' "$1"; then fail "$1 has numbers that are not finite"; fi
}

# draw NAME ARGUMENTS...: draw twice in each format.
draw() {
    name=$1
    shift
    for format in svg pdf png; do
        plot 0 "$@" -o "$dir/$name.$format"
        { [ ! -s "$dir/out" ] && [ ! -s "$dir/err" ]; } || fail "$name talks"
        [ "$(wc -c <"$dir/$name.$format")" -gt 2000 ] || fail "$name.$format is empty"
        plot 0 "$@" -o "$dir/again.$format"
        cmp "$dir/$name.$format" "$dir/again.$format" || fail "$name.$format differs the second time"
    done
    well_formed "$dir/$name.svg"
    [ "$(head -c 5 "$dir/$name.pdf")" = %PDF- ] || fail "$name.pdf is no PDF"
    grep -a '/CreationDate' "$dir/$name.pdf" | grep -q '(20000101' || fail "$name.pdf holds a date" # a fixed one
    { grep -aq '/FontFile' "$dir/$name.pdf" && grep -aq '/ToUnicode' "$dir/$name.pdf"; } || fail "$name.pdf holds no text"
    [ "$(od -A n -t x1 -N 4 "$dir/$name.png")" = ' 89 50 4e 47' ] || fail "$name.png is no PNG"
}
draw curve curve "$dir/labels.csv"
draw bars bars "$dir/eval.json"
draw scatter scatter "$dir/pairs.csv"
draw loss loss "$dir/log.csv" "$dir/second.csv"
draw directions directions "$dir/model.safetensors"
draw slice slice sgd:nickel ward:nickel lambert:kd=0,0,0
draw attribution attribution sgd:nickel ward:nickel
draw network network "$dir/model.safetensors"
printf 'map,kind,size,jod\nroughness,a,.5,9.2\nroughness,b,2,9.9\nroughness,c,4,9.8\nnormal,a,1,9\n' >"$dir/sizes.csv"
draw sizes sizes "$dir/sizes.csv"

# The drawing depends on the input; equal BRDFs can also be drawn.
{ [ "$(grep -c '<symbol' "$dir/slice.svg")" -gt 10 ] && [ "$(grep -c '<symbol' "$dir/slice.svg")" -lt 150 ]; } ||
    fail "an SVG does not hold each glyph once: $(grep -c '<symbol' "$dir/slice.svg")"
plot 0 attribution sgd:nickel sgd:nickel -o "$dir/same.svg"
cmp -s "$dir/same.svg" "$dir/attribution.svg" && fail "a difference is drawn like none"
plot 0 scatter "$dir/pairs.csv" --predictor rmse -o "$dir/rmse.svg"
cmp -s "$dir/rmse.svg" "$dir/scatter.svg" && fail "--predictor changes nothing"
plot 0 slice sgd:nickel ward:nickel lambert:kd=0,0,0 --theta-d 40 -o "$dir/slice40.svg"
cmp -s "$dir/slice40.svg" "$dir/slice.svg" && fail "--theta-d changes nothing"

# Curves differ in their dashes too: solid, and three patterns.
plot 0 slice sgd:nickel ward:nickel abc:nickel lambert:kd=.1,.1,.1 -o "$dir/four.svg"
[ "$(grep -o 'stroke-dasharray:[0-9.,]*' "$dir/four.svg" | sort -u | wc -l)" = 3 ] || fail "curves with the same dashes"

# The legend has no sample of a BRDF that is 0 everywhere: the third pattern is missing.
[ "$(grep -o 'stroke-dasharray:[0-9.,]*' "$dir/slice.svg" | sort -u | wc -l)" = 1 ] || fail "a sample of a curve that is not drawn"

# Answers of people: choices can be drawn, and neither scores nor choices have a split.
split() { sed 's/"split": "[a-z]*"/"split": "train"/' "$1"; }
split "$dir/eval.json" | plot 0 bars - -o "$dir/train.svg"
cmp -s "$dir/train.svg" "$dir/bars.svg" && fail "the split of labels is not drawn"
sed 's/"results"/"human": {"kind": "score"}, "results"/' "$dir/eval.json" >"$dir/human.json"
plot 0 bars "$dir/human.json" -o "$dir/human.svg"
split "$dir/human.json" | plot 0 bars - -o "$dir/train.svg"
cmp "$dir/train.svg" "$dir/human.svg" || fail "human scores with a split"
printf 'reference,test_a,test_b,choice\n' >"$dir/choices.csv"
for tests in .21,lambert:kd=.4,a .25,lambert:kd=.3,a .5,lambert:kd=.21,b; do
    echo "lambert:kd=.2,lambert:kd=$tests" >>"$dir/choices.csv"
done
"$tool" eval --human "$dir/choices.csv" --model none --json >"$dir/choices.json" || fail "choices"
draw choices bars "$dir/choices.json"

# Only what is drawn is named: one material has no mean over materials and no intervals. Letters are counted.
glyphs() { grep -c '<use ' "$1"; }
one() { printf '{"results": [{"name": "default", "n": 3, "n_materials": 1, "spearman": 0.9%s}]}' "$1" >"$dir/one.json"; }
one ''
plot 0 bars "$dir/one.json" -o "$dir/plain.svg"
one ', "ci95": [0.8, 0.95]'
plot 0 bars "$dir/one.json" -o "$dir/interval.svg"
[ "$(($(glyphs "$dir/interval.svg") - $(glyphs "$dir/plain.svg")))" -gt 40 ] || fail "whiskers are named without one"
one ', "spearman_mean_by_material": 0.9'
plot 0 bars "$dir/one.json" -o "$dir/mean.svg"
[ "$(($(glyphs "$dir/mean.svg") - $(glyphs "$dir/plain.svg")))" -gt 15 ] || fail "a mean is named without its bar"

# Markers at the ends of the data do not touch the frame: discs have a diameter of 5 pixels.
inside_frame() {
    awk '/stroke-width:1;.* Z M/ {split($0, d, " d=\""); n = split(d[2], c, " "); x0 = c[2]; y0 = c[3]; x1 = c[5]; y1 = c[9]}
        /stroke-width:5;stroke-linecap:round/ {
            split($0, d, " d=\""); n = split(d[2], c, " ")
            for (i = 1; i + 2 <= n; i += 3) {
                ++points
                if (c[i + 1] < x0 + 3 || c[i + 1] > x1 - 3 || c[i + 2] < y0 + 3 || c[i + 2] > y1 - 3) bad = 1
            }
        }
        END {exit bad || points < 2}' "$1"
}
printf 'jod,default,rmse\n10,10,0.1\n0,0,1\n5,4,0.5\n' >"$dir/ends.csv"
for predictor in default rmse; do
    for size in 560x580 300x250; do
        plot 0 scatter "$dir/ends.csv" --predictor $predictor --size $size -o "$dir/ends.svg"
        inside_frame "$dir/ends.svg" || fail "$predictor, $size: markers touch the frame"
    done
done

# Predictions need labels, which scores of nqm batch have not. On the scale of people there is no diagonal.
printf 'reference,test\nsgd:nickel,ward:nickel\nsgd:nickel,abc:nickel\n' >"$dir/list.csv"
"$tool" batch "$dir/list.csv" --model "$dir/model.safetensors" -o "$dir/scores.csv" || fail "batch"
plot 5 scatter "$dir/scores.csv" -o "$dir/x.svg"
says 'scores.csv.*no labels.*eval --pairs'
printf 'reference,test,jod\nsgd:nickel,ward:nickel,4\n' >"$dir/opinions.csv"
sed 's/jod/score/' "$dir/opinions.csv" >"$dir/opinions2.csv"
for file in opinions opinions2; do
    plot 4 scatter "$dir/$file.csv" -o "$dir/x.svg"
    says "$file.csv: scatter needs the column jod (labels) and after it a column of predictions; these are answers of people: .nqm eval --human .*$file.csv --pairs pairs.csv. writes both"
done
plot 4 scatter "$dir/choices.csv" -o "$dir/x.svg"
says 'these are choices of people, which .nqm eval --human .*choices.csv --json | nqm plot bars'
plot 4 scatter "$dir/list.csv" -o "$dir/x.svg"
says 'list.csv: scatter needs .*; .nqm eval --pairs FILE.csv. writes both'
plot 4 scatter "$dir/pairs.csv" --predictor defualt -o "$dir/x.svg"
says "no column defualt (did you mean 'default'?)"
sed 's/,test,[0-9.]*,/,test,,/' "$dir/pairs.csv" >"$dir/people.csv"
plot 0 scatter "$dir/people.csv" -o "$dir/people.svg"
{ grep -q 'stroke-dasharray' "$dir/scatter.svg" && ! grep -q 'stroke-dasharray' "$dir/people.svg"; } || fail "a diagonal"

# Size, scale, title, JSON, standard input.
[ "$(png_size "$dir/curve.png")" = 1280x880 ] || fail "default size: $(png_size "$dir/curve.png")"
plot 0 curve "$dir/labels.csv" --size 300x250 --scale 1 -o "$dir/small.PNG" --json
[ "$(png_size "$dir/small.PNG")" = 300x250 ] || fail "--size: $(png_size "$dir/small.PNG")"
grep -q '"drawing": "curve"' "$dir/out" || fail "JSON"
plot 0 bars - -o "$dir/piped.svg" <"$dir/eval.json"
cmp "$dir/piped.svg" "$dir/bars.svg" || fail "standard input"
plot 0 curve "$dir/labels.csv" --title "" -o "$dir/untitled.svg"
cmp -s "$dir/untitled.svg" "$dir/curve.svg" && fail "--title '' leaves a title"

# Refusals: no file is written, and the message names the error.
plot 2 curve "$dir/labels.csv"
plot 2 pie "$dir/labels.csv" -o "$dir/x.svg"
says "no 'pie'"
plot 2 slcie # the wrong word, not the option that is missing too
says "no 'slcie' (did you mean 'slice'?)"
plot 0 attribution sgd:nickel 'My fit=sgd:nickel' -o "$dir/named.svg"
cmp -s "$dir/same.svg" "$dir/named.svg" && fail "NAME= in the title of attribution"
plot 2 attribution sgd:nickel -o "$dir/x.svg"
plot 2 curve "$dir/labels.csv" -o "$dir/x.gif"
says 'FILE.svg|.pdf|.png'
plot 2 curve "$dir/labels.csv" --size 10x10 -o "$dir/x.svg"
plot 2 curve "$dir/labels.csv" --size 300 -o "$dir/x.svg"
plot 2 slice sgd:nonsense -o "$dir/x.svg"
plot 3 curve "$dir/nowhere.csv" -o "$dir/x.svg"
plot 3 bars "$dir/nowhere.json" -o "$dir/x.svg"
plot 3 curve "$dir/labels.csv" -o "$dir/nowhere/x.svg"
plot 3 curve "$dir/labels.csv" -o "$dir/nowhere/x.png"
plot 4 curve "$dir/log.csv" -o "$dir/x.svg"
says 'log.csv.*DeltaE'
plot 4 loss "$dir/labels.csv" -o "$dir/x.svg"
says 'labels.csv: no column train_loss; loss draws the file of .nqm train --log.'
plot 4 bars "$dir/labels.csv" -o "$dir/x.svg"
says "the document of .nqm eval --json."
says 'labels.csv: line 1'
echo '{"results": [{"name": "a", "spearman": null}]}' >"$dir/bad.json"
plot 4 bars "$dir/bad.json" -o "$dir/x.svg"
says 'result 0 (a)'
sed '3s/0.5/half/' "$dir/log.csv" >"$dir/bad.csv"
plot 4 loss "$dir/bad.csv" -o "$dir/x.svg"
says 'bad.csv.*3'
plot 4 scatter "$dir/pairs.csv" --predictor nobody -o "$dir/x.svg"
head -n 1 "$dir/log.csv" >"$dir/empty.csv"
plot 5 loss "$dir/empty.csv" -o "$dir/x.svg"
echo '{"results": []}' >"$dir/bad.json"
plot 5 bars "$dir/bad.json" -o "$dir/x.svg"
plot 6 network nobody -o "$dir/x.svg"
for file in "$dir"/x.* "$dir"/*.part; do
    [ ! -e "$file" ] || fail "a refusal left $file"
done
# One epoch is drawn as points; one pair has no correlation; slices without a value above 0.
head -n 2 "$dir/log.csv" >"$dir/one_epoch.csv"
plot 0 loss "$dir/one_epoch.csv" -o "$dir/one_epoch.svg"
[ "$(grep -c 'stroke-width:6;stroke-linecap:round' "$dir/one_epoch.svg")" = 2 ] || fail "one epoch is no disc in the frame and one in the legend"
printf 'jod,default\n9,8.5\n' >"$dir/one_pair.csv"
plot 0 scatter "$dir/one_pair.csv" -o "$dir/one_pair.svg"
plot 8 slice lambert:kd=0 -o "$dir/x.svg"
says 'no BRDF has a value above 0 in any slice'
plot 0 slice lambert:kd=0 lambert:kd=.5 -o "$dir/black.svg"

# A full disk: each kind of drawing names the file, and nothing is left.
mkdir "$dir/small"
for kind in svg pdf png; do
    code=0
    (
        trap '' XFSZ
        ulimit -f 2 # blocks of 512 or 1024 bytes
        "$tool" plot slice sgd:nickel ward:nickel -o "$dir/small/x.$kind"
    ) >"$dir/out" 2>"$dir/err" || code=$?
    [ "$code" = 3 ] || fail "exit code $code of a full disk, $kind: $(cat "$dir/err")"
    grep -q "small/x.$kind: .*[Ww]rit" "$dir/err" || fail "no file is named: $(cat "$dir/err")"
done
[ -z "$(ls -A "$dir/small")" ] || fail "files of a full disk: $(ls -A "$dir/small")"
