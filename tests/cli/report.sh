#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm report: the page is well-formed and self-contained, contains the values of nqm score and nqm label, escapes names,
# and is the same in two runs; errors and Ctrl-C leave no file.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
command -v xmllint >/dev/null || {
    echo "xmllint (libxml2-utils) reads the page here, and is not installed"
    exit 77
}
unset SOURCE_DATE_EPOCH
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors" 20
mkdir "$dir/files" "$dir/pages"
"$NQM_BUILD/tests/make_brdf_files" "$dir/files" >/dev/null
page=$dir/pages/page.html

# report CODE ARGUMENTS...
report() {
    code=$1
    shift
    run "$code" report --model "$dir/model.safetensors" --size 24 "$@"
}
# query XPATH: evaluate it on the page.
query() { xmllint --xpath "$1" "$page"; }
# empty: neither a page nor an unfinished file exists.
empty() { [ -z "$(ls "$dir/pages")" ] || fail "left: $(ls "$dir/pages")"; }

# ---- the page: a name with markup characters, tests that are not in the order of their scores
awkward="$dir/files/a<script>&amp;\"'b.bsdf"
cp "$dir/files/valid.bsdf" "$awkward"
set -- sgd:nickel ward:nickel "$awkward" sgd:nickel
report 0 "$@" -o "$page" --title "<b>&'\"" --json
cp "$dir/out" "$dir/printed"
xmllint --noout "$page" || fail "not well-formed"
[ "$(query 'string(/html/@lang)')" = en ] || fail "a language"
[ "$(query 'string(/html/head/title)')" = "<b>&'\"" ] || fail "title: $(query 'string(/html/head/title)')"
[ "$(query 'count(//h1)') $(query 'count(//section[@class="test"])')" = "1 3" ] || fail "one heading and 3 tests"
[ "$(query 'count(//p[@class="argument"]/code[contains(., "a<script>&amp;")])')" = 1 ] || fail "the awkward name"
[ "$(query 'string(//table[@class="summary"]/tbody/tr[th/a="sgd:nickel"]/td[3])')" = identical ] || fail "the verdict of equal BRDFs"
[ "$(query 'count(//table[@class="matrix"]/tbody/tr)')" = 3 ] || fail "preferences between 3 tests"
[ "$(query 'count(//table[@class="metrics"][1]/tbody/tr)')" = 27 ] || fail "nine metrics a test"
[ "$(query 'count(//img)') $(query 'count(//img[string-length(@alt) > 10])')" = "12 12" ] || fail "4 pictures a test, with words"

[ "$(query 'count(//section[@class="test"]//*[@id="jod-1" or @id="map-2" or @id="slices-3"])')" = 3 ] || fail "places of charts"
[ "$(query 'count(//noscript)')" = 1 ] || fail "what is missing without JavaScript"

# What differs, in words and numbers; this model predicts no parts, so only those of the pictures.
[ "$(query 'string(//section[@class="test"][h2/span="ward:nickel"]/p[@class="words"])' | grep -c '^In the pictures: [a-z ,]*\.$')" = 1 ] || fail "words"
[ "$(query 'string(//section[@class="test"][h2/span="sgd:nickel"]/p[@class="words"]/strong)')" = 'no visible difference' ] || fail "words of equal BRDFs"
[ "$(query 'count(//table[@class="parts"]/tbody/tr)') $(query 'string(//table[@class="parts"]/tbody/tr/td[6])')" = "3 10.00" ] || fail "parts"

# ---- self-contained: no addresses; the policy forbids loading, and allows one script, which is that of the browser page
query 'string(//meta[@http-equiv="Content-Security-Policy"]/@content)' | grep -q "script-src 'sha256-[A-Za-z0-9+/]\{43\}=';" || fail "the hash of the script"
query 'string(//script[@type="module"])' | sed '1d;$d' | sed '$d' | cmp - "$NQM_SOURCE/web/charts.js" || fail "another script than the page's"
query 'string(//meta[@http-equiv="Content-Security-Policy"]/@content)' | grep -q "^default-src 'none'; img-src data:;" || fail "policy"
[ "$(query 'count(//@src) - count(//img/@src[starts-with(., "data:image/png;base64,iVBORw0KGgo")])')" = 0 ] || fail "foreign src"
[ "$(query 'count(//@href[not(starts-with(., "#"))])')" = 0 ] || fail "foreign links"
[ "$(query 'count(//link) + count(//iframe) + count(//object) + count(//script[not(@type="application/json")])')" = 1 ] ||
    fail "elements that load or run something"
! sed 's,"http://www.w3.org/2000/svg",,' "$page" | grep -qiE 'https?:|url\(|@import|<script>' || fail "an address in the page"

# ---- the values equal those of nqm score and nqm label for the same arguments
# same ID FILE: the data block equals the JSON in the file, except for white space.
same() {
    query "string(//script[@id='$1'])" | sed 's/\\u003c/</g; s/\\u003e/>/g; s/\\u0026/\&/g' | tr -d ' \n' >"$dir/block"
    tr -d ' \n' <"$2" | cmp - "$dir/block" || fail "$1 differs"
}
run 0 score --model "$dir/model.safetensors" "$@" --json
cmp "$dir/out" "$dir/printed" || fail "--json"
same nqm-report "$dir/out"
number jod '1,$' | sort -g | awk '{printf "%.2f\n", $1}' >"$dir/jods"
for i in 3 2 1; do query "string(//table[@class='summary']/tbody/tr[$i]/td[2]/strong)"; done | diff "$dir/jods" - || fail "JODs of the summary"
query '//table[@class="summary"]/tbody/tr/th/a/text()' >"$dir/ranked"
query '//section[@class="test"]/h2/span[@class="name"]/text()' | diff "$dir/ranked" - || fail "sections in the order of the summary"
run 0 label "$@" --size 24 --json
same nqm-label "$dir/out"

# ---- the values of the charts: both BRDFs are constant, 0.5 and 0.25 / pi
report 0 lambert:kd=.5 lambert:kd=.25 -o "$page"
query 'string(//script[@id="nqm-charts"])' >"$dir/charts"
[ "$(grep -o '0\.1592' "$dir/charts" | wc -l) $(grep -o '0\.07958' "$dir/charts" | wc -l)" = "2172 2172" ] || fail "slices"
[ "$(sed 's/.*"map"/map/' "$dir/charts" | grep -o '0\.6748\|null' | wc -l)" = 5400 ] || fail "map: $(sed 's/.*"map"//' "$dir/charts" | head -c 100)"

# ---- the date is an argument
report 0 sgd:nickel ward:nickel -o "$page" --date 'on Sunday'
query 'string(//p[@class="quote"])' | grep -q '; on Sunday\.$' || fail "date"
SOURCE_DATE_EPOCH=86400 report 0 sgd:nickel ward:nickel -o "$page" --shrink 2 --frames 2
grep -q ", 2 views" "$page" || fail "the number of views"
query 'string(//p[@class="quote"])' | grep -q '; 1970-01-02\.$' || fail "SOURCE_DATE_EPOCH"
[ "$(query 'string(/html/head/title)')" = "How closely ward:nickel matches sgd:nickel" ] || fail "title of one test"
[ "$(query 'count(//table[@class="matrix"])')" = 0 ] || fail "a comparison with nothing"
[ "$(query 'string(//img[1]/@width)')" = 36 ] || fail "--shrink, and not three columns of eight pictures"

# ---- the interval of a model that has one
[ "$(query 'count(//*[@class="interval"])')" = 0 ] || fail "an interval of a model that has none"
"$NQM_BUILD/tests/tiny_dataset" "$dir/toy.safetensors" 1 48
run 0 train "$dir/toy.safetensors" -o "$dir/calibrated.safetensors" --hidden 16 --batch 64 --epochs 1
run 0 report sgd:nickel ward:nickel -m "$dir/calibrated.safetensors" --size 24 -o "$page" --json
[ "$(query 'string(//table[@class="summary"]/tbody/tr/td[2]/span)')" = "$(printf '%.2f to %.2f' "$(number jod_low 1)" "$(number jod_high 1)")" ] ||
    fail "interval: $(query 'string(//table[@class="summary"]/tbody/tr/td[2])')"
[ "$(query 'count(//p[@class="verdict"]/span[@class="interval"])')" = 1 ] || fail "an interval in words"

# ---- the same bytes with one thread
cp "$page" "$dir/first.html"
OMP_NUM_THREADS=1 run 0 report sgd:nickel ward:nickel -m "$dir/calibrated.safetensors" --size 24 -o "$page"
cmp "$page" "$dir/first.html" || fail "another page the second time"

# ---- the parts of a model that predicts them
"$NQM_BUILD/tests/tiny_dataset" "$dir/parts.safetensors" 1 24 parts
run 0 train "$dir/parts.safetensors" -o "$dir/six.safetensors" --hidden 16 --batch 64 --epochs 1
run 0 report sgd:nickel ward:nickel -m "$dir/six.safetensors" --size 24 -o "$page" --json
[ "$(query 'string(//p[@class="words"]/strong[1])')" = "$(sed -n 's/^ *"words": "\(.*\)"$/\1/p' "$dir/out")" ] || fail "predicted words"
[ "$(query 'string(//table[@class="parts"]/tbody/tr[1]/td[5])')" = "$(printf %.2f "$(number structure 1)")" ] || fail "structure"
[ "$(query 'count(//table[@class="parts"]/tbody/tr)')" = 2 ] || fail "rows of parts"

# ---- errors: the exit code; the old page is unchanged, and there is no new file
cp "$page" "$dir/first.html"
report 3 sgd:nickel ward:nickel "$dir/nowhere.binary" -o "$page"
cmp "$page" "$dir/first.html" || fail "a fault touched the old page"
rm "$page"
SOURCE_DATE_EPOCH=soon report 2 sgd:nickel ward:nickel -o "$page"
report 3 "$dir/nowhere.binary" ward:nickel -o "$page"
report 2 sgd:nickel lambert:nonsense=1 -o "$page"
report 2 sgd:nickel ward:nickel
report 2 sgd:nickel ward:nickel -o -
report 2 sgd:nickel ward:nickel -o /dev/null
report 2 sgd:nickel ward:nickel -o "$page" --points 100
report 2 sgd:nickel ward:nickel -o "$page" --shrink 7
report 3 sgd:nickel ward:nickel -o "$dir/nowhere/page.html"
report 3 sgd:nickel ward:nickel -o "$page" --light "$dir/nowhere.exr"
empty

# ---- Ctrl-C
i=0
set -- sgd:nickel
while [ $i -lt 300 ]; do
    set -- "$@" "lambert:kd=.$((100 + i))"
    i=$((i + 1))
done
"$tool" report --model "$dir/model.safetensors" --size 24 "$@" -o "$page" 2>"$dir/err" &
while [ -z "$(ls "$dir/pages")" ]; do sleep 0.01; done
ctrl_c
empty

run 0 help report
grep -q '^  nqm report sgd:nickel' "$dir/out" || fail "help with an example"

# A page is HTML under that name; Ctrl-C stops the pictures.
run 2 report sgd:nickel ward:nickel -o "$dir/a.pdf"
interrupt report sgd:nickel ward:nickel -o "$dir/stopped.html" --size 512 --lights 2048
[ -z "$(find "$dir" -name 'stopped*')" ] || fail "Ctrl-C left a file"
