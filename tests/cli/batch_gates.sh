#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm batch for continuous integration: gates and their exit codes, JUnit XML, Markdown, sorted rows, names of tests; the same files
# from a run that was stopped and resumed. Most parts use a model with random weights.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors" 20
cat >"$dir/pairs.csv" <<'END'
reference,test,name,note
sgd:nickel,"dull=perturb:gloss=.9;of=sgd:nickel",,1
sgd:nickel,ward:nickel,"a|b & <c>",2
sgd:nickel,sgd:nickel,,3
sgd:brass,nowhere.binary,gone,4
END

# batch CODE ARGUMENTS...
batch() {
    code=$1
    shift
    run "$code" batch "$dir/pairs.csv" -m "$dir/model.safetensors" -k "$@"
}

# A threshold between the scores of the two tests that differ from their reference.
batch 9
ward=$(sed -n 3p "$dir/out" | sed 's/.*,2,\([^,]*\),.*/\1/')
dull=$(sed -n 2p "$dir/out" | sed 's/.*,1,\([^,]*\),.*/\1/')
worst=$(printf '%s\n%s\n' "$ward" "$dull" | sort -n | head -n 1)
gate=$(awk -v a="$ward" -v b="$dull" 'BEGIN {print (a + b) / 2}')

# Gates: a mark in every row, a line at the end; pairs without a score have exit code 9, and 1 comes after all pairs have one.
batch 9 --fail-under "$gate" -o "$dir/all.csv" --junit "$dir/all.xml" --markdown "$dir/all.md"
[ "$(tail -n 1 "$dir/err")" = "nqm batch: 1 of 4 pairs FAIL: JOD below $gate" ] || fail "last line: $(cat "$dir/err")"
head -n 1 "$dir/all.csv" | grep -q ',gate,warnings,error$' || fail "a column: $(cat "$dir/all.csv")"
[ "$(grep -c ',FAIL,' "$dir/all.csv")$(grep -c ',pass,' "$dir/all.csv")" = 12 ] || fail "marks: $(cat "$dir/all.csv")"
grep ',FAIL,' "$dir/all.csv" | grep -q ",$worst," || fail "the mark of the worst: $(cat "$dir/all.csv")"
batch 9 --fail-under "$gate" --jsonl
[ "$(grep -c '"gate":"FAIL"' "$dir/out")$(grep -c '"gate":"pass"' "$dir/out")" = 12 ] || fail "marks in JSON Lines"
head -n 4 "$dir/pairs.csv" >"$dir/scored.csv"
run 1 batch "$dir/scored.csv" -m "$dir/model.safetensors" --fail-under "$gate"
run 0 batch "$dir/scored.csv" -m "$dir/model.safetensors" --fail-under "$(awk -v w="$worst" 'BEGIN {print w - .001}')"
grep -q '0 of 3 pairs FAIL' "$dir/err" || fail "no failure: $(cat "$dir/err")"
run 5 batch "$dir/scored.csv" -m "$dir/model.safetensors" --fail-under-low 5
run 1 batch "$dir/scored.csv" --fail-under-low 9
grep -q '2 of 3 pairs FAIL: lower end of the interval below 9' "$dir/err" || fail "intervals: $(cat "$dir/err")"
printf 'reference,test,gate\n' >"$dir/column.csv"
run 0 batch "$dir/column.csv"
run 4 batch "$dir/column.csv" --fail-under 5

# JUnit: counts, one case per pair in the order of the list, figures, escaped names.
python3 - "$dir/all.xml" "$worst" <<'END' || fail "JUnit: $(cat "$dir/all.xml")"
import sys
import xml.etree.ElementTree as tree
root = tree.parse(sys.argv[1]).getroot()
suite = root.find("testsuite")
assert root.tag == "testsuites" and all(x.get("tests") == "4" and x.get("failures") == "1" and x.get("errors") == "1" for x in (root, suite))
assert suite.get("name").endswith("pairs.csv")
cases = suite.findall("testcase")
assert [c.get("name") for c in cases] == ["dull", "a|b & <c>", "sgd:nickel", "gone"], [c.get("name") for c in cases]
assert [c.get("classname") for c in cases] == ["sgd:nickel"] * 3 + ["sgd:brass"]
failures = [c.find("failure") for c in cases]
assert sum(f is not None for f in failures) == 1
text = [f for f in failures if f is not None][0]
assert ("JOD %.2f" % float(sys.argv[2])) in text.get("message") and "Delta-E ITP" not in text.get("message"), text.get("message")
assert "nowhere.binary" in cases[3].find("error").get("message")
assert "identical" in cases[2].find("system-out").text
properties = {p.get("name"): p.get("value") for p in suite.iter("property")}
assert properties["model"] == "tiny" and len(properties["model sha256"]) == 64 and properties["gate"].startswith("JOD below")
END

# Markdown: worst first, escaped.
grep -q '^### nqm: 1 of 4 pairs FAIL, 1 without a score$' "$dir/all.md" || fail "heading: $(cat "$dir/all.md")"
[ "$(sed -n '/^| [EFp]/p' "$dir/all.md" | cut -d' ' -f2 | tr '\n' ' ')" = 'ERROR FAIL pass pass ' ] || fail "order: $(cat "$dir/all.md")"
grep -q '| a\\|b \\& \\<c\\> |' "$dir/all.md" || fail "a cell: $(cat "$dir/all.md")"
[ "$(grep '^|' "$dir/all.md" | sed 's/\\|//g' | tr -cd '|\n' | sort -u)" = '||||||||' ] || fail "columns: $(cat "$dir/all.md")"
batch 9 -o "$dir/x.csv" --markdown - --worst 1
grep -q '^3 more pairs are not shown' "$dir/out" || fail "rows that are not shown: $(cat "$dir/out")"

# Worst first: rows without a score, then by JOD, in every format.
batch 9 --sort worst
[ "$(cut -d, -f1 "$dir/out" | tail -n +2 | head -n 1)" = sgd:brass ] || fail "--sort: $(cat "$dir/out")"
sed -n 3p "$dir/out" | grep -q ",$worst," || fail "--sort: $(cat "$dir/out")"
cp "$dir/out" "$dir/sorted.csv"
printf 'reference,test\nsgd:nickel,sgd:nickel\nsgd:nickel,ward:nickel\n' >"$dir/best-first.csv"
run 0 batch "$dir/best-first.csv" -m "$dir/model.safetensors" --sort worst
sed -n 3p "$dir/out" | grep -q '^sgd:nickel,sgd:nickel,' || fail "the best row comes first: $(cat "$dir/out")"
batch 9 --sort worst -o "$dir/sorted-out.csv"
cmp "$dir/sorted.csv" "$dir/sorted-out.csv" || fail "a sorted file"
[ "$(find "$dir" -name 'sorted-out*' | wc -l)" = 1 ] || fail "left-over files"
batch 9 --worst 2 --json
python3 -c 'import json, sys; r = json.load(open(sys.argv[1]))["results"]; assert len(r) == 2 and r[0]["jod"] is None' "$dir/out" || fail "--worst: $(cat "$dir/out")"
batch 9 --sort worst --jsonl
[ "$(wc -l <"$dir/out")" = 4 ] || fail "JSON Lines, sorted"
batch 2 --sort better

# A run that was stopped before its last row and resumed gives the same files.
awk 'NR < 5 {print} NR == 5 {row = $0} END {for (i = 0; i < 300; ++i) print "sgd:nickel,ggx:alpha=." 100 + i ",," i; sub("nowhere", "later", row); print row}' \
    "$dir/pairs.csv" >"$dir/later.csv"
for form in csv json; do
    set -- "$dir/later.csv" -m "$dir/model.safetensors" --fail-under "$gate" --sort worst
    run 3 batch "$@" -o "$dir/after.$form" --junit "$dir/after.xml" --markdown "$dir/after.md"
    { [ ! -e "$dir/after.xml" ] && [ ! -e "$dir/after.md" ]; } || fail "reports of an unfinished run"
    [ -e "$dir/after.$form.pieces" ] || fail "no pieces"
    run 9 batch "$@" -k -o "$dir/after.$form" --junit "$dir/after.xml" --markdown "$dir/after.md" --resume
    run 9 batch "$@" -k -o "$dir/whole.$form" --junit "$dir/whole.xml" --markdown "$dir/whole.md"
    for file in "$form" xml md; do cmp "$dir/whole.$file" "$dir/after.$file" || fail "another .$file after --resume"; done
    rm "$dir/after.xml" "$dir/after.md"
done

# Names that score refuses are refused, before the outputs are touched: NAME=TEST and the column.
printf 'reference,test\nsgd:nickel,a\033[31m=ward:nickel\n' >"$dir/odd.csv"
printf 'reference,test,name\nsgd:nickel,ward:nickel,a\nsgd:brass,ward:brass,a\nsgd:nickel,a=abc:nickel,\n' >"$dir/twice.csv"
for verb in "batch $dir/odd.csv -o $dir/named.csv" "rank --list $dir/odd.csv"; do
    # shellcheck disable=SC2086
    refuses 4 "odd.csv: row 1: the name 'a?\[31m' has a control character" $verb -m "$dir/model.safetensors"
done
echo kept >"$dir/named.csv"
for verb in "batch $dir/twice.csv -o $dir/named.csv" "rank --list $dir/twice.csv"; do
    # shellcheck disable=SC2086
    refuses 4 "twice.csv: rows 1 and 3: two BRDFs have the name 'a'; give each" $verb -m "$dir/model.safetensors"
done
[ "$(cat "$dir/named.csv")" = kept ] || fail "an output before the names were checked"

# Outputs are checked before the work; one text only on standard output; a path from another folder.
batch 3 --junit "$dir/nowhere/x.xml" -o "$dir/early.csv"
[ "$(find "$dir" -name "early.csv*" | wc -l)" = 0 ] || fail "work before the outputs were checked"
batch 2 --markdown -
batch 2 -o "$dir/x.csv" --markdown - --junit -
mkdir "$dir/sub"
cp "$dir/scored.csv" "$dir/sub"
(cd "$dir" && run 0 batch sub/scored.csv -m model.safetensors -o there.csv --junit there.xml)
[ -e "$dir/there.xml" ] || fail "a report in the working folder"
