#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm rank: order, tied ranks, preferences, output formats, lists with several references, tests without a score.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors" 20

# rank CODE ARGUMENTS...: run with the model; standard output goes to out, standard error to err.
rank() {
    code=$1
    shift
    run "$code" rank --model "$dir/model.safetensors" "$@"
}
ref=sgd:nickel a=ward:nickel b=lambert:kd=.4 c='perturb:tint=1.5,1,1;of=sgd:nickel'

# Tests are sorted by score; equal tests have the same rank, and the next rank counts them all.
rank 0 $ref $a $b "$c" $b --csv
head -n 1 "$dir/out" | grep -qx 'reference,rank,test,jod,jod_low,jod_high,over_next,best_preferred,name,error' || fail "header"
"$tool" score --model "$dir/model.safetensors" $ref $a $b "$c" --csv | sed 1d |
    sed 's/"[^"]*"/"tint"/; s/^sgd:nickel,\([^,]*\),\([^,]*\),.*/\2 \1/' | sort -rn >"$dir/scores"
sed 1d "$dir/out" | sed 's/"[^"]*"/"tint"/' >"$dir/rows"
awk -F, 'NR == FNR {split($0, s, " "); order[++n] = s[2]; jod[s[2]] = s[1]; next}
    {names = names " " $3; seen = 0}
    $4 - jod[$3] > 1e-4 || jod[$3] - $4 > 1e-4 {print "score of " $3; exit 1}
    FNR > 1 && $4 > last + 1e-4 {print "order"; exit 1}
    FNR > 1 {tie = last - $4 < 1e-4; if (tie != ($2 == rank)) {print "ranks"; exit 1}}
    FNR > 1 && $2 != rank && $2 != FNR {print "rank " $2 " in row " FNR; exit 1}
    {last = $4; rank = $2}' "$dir/scores" "$dir/rows" >"$dir/why" || fail "$(cat "$dir/why")"
[ "$(cut -d, -f2 "$dir/rows" | sort | uniq -d | wc -l)" = 1 ] || fail "equal tests share a rank: $(cat "$dir/rows")"

# Preferences: Phi(0.6745 difference), here by a series accurate to 1e-6 for small differences; empty without a second
# test.
awk -F, 'function phi(x,   t, s, k) {t = x; s = x; for (k = 1; k < 60; ++k) {t *= -x * x / (2 * k); s += t / (2 * k + 1)}
        return 0.5 + s / sqrt(2 * 3.14159265358979)}
    function off(a, b) {return a - b > 1e-5 || b - a > 1e-5}
    {jod[NR] = $4; next_[NR] = $7; best[NR] = $8}
    END {if (best[1] != "" || next_[NR] != "") {print "first and last"; exit 1}
        for (i = 1; i <= NR; ++i) {
            if (i > 1 && off(best[i], phi(0.67448975 * (jod[1] - jod[i])))) {print "best over row " i; exit 1}
            if (i < NR && off(next_[i], phi(0.67448975 * (jod[i] - jod[i + 1])))) {print "row " i " over next"; exit 1}}}' \
    "$dir/rows" >"$dir/why" || fail "$(cat "$dir/why"): $(cat "$dir/rows")"

# Other output formats.
rank 0 $ref $a $b "$c" -q
cut -d' ' -f2 "$dir/scores" | sed "s|\"tint\"|$c|" | diff - "$dir/out" || fail "names, best first"
rank 0 $ref $a $b "$c"
grep -q '^reference  sgd:nickel$' "$dir/out" || fail "text: reference"
grep -q '^ *1 .* % *-  *[a-z]' "$dir/out" || fail "text: the best: $(cat "$dir/out")"
rank 0 $ref $a $b --json
for word in '"schema": 1' '"id": "tiny"' '"reference": "sgd:nickel"' '"rank": 2' '"over_next": null' '"best_preferred": null' '"test": "ward:nickel"'; do
    grep -q "$word" "$dir/out" || fail "JSON lacks $word"
done

# Lists: one ranking per reference, in order of first appearance; the rows of a reference need not be contiguous.
printf '{"reference":"ward:nickel","test":"%s"}\n{"reference":"sgd:nickel","test":"%s"}\n{"reference":"ward:nickel","test":"ward:nickel"}\n' \
    $b $a >"$dir/list.jsonl"
rank 0 --list "$dir/list.jsonl" --csv
sed 1d "$dir/out" | cut -d, -f1,2 | sort >"$dir/places"
printf 'sgd:nickel,1\nward:nickel,1\nward:nickel,2\n' | diff - "$dir/places" || fail "rankings of a list"
[ "$(sed -n 2p "$dir/out" | cut -d, -f1)" = ward:nickel ] || fail "references by first appearance"
cp "$dir/out" "$dir/first"
rank 0 --list - --csv <"$dir/list.jsonl"
cmp "$dir/first" "$dir/out" || fail "standard input"

# A test without a score is last and has no rank; its error gives the exit code.
rank 3 $ref "$dir/nowhere.binary" $a --csv
sed -n 3p "$dir/out" | grep -q '^sgd:nickel,,.*nowhere.binary,,,,.*nowhere.binary: No such' || fail "no score: $(cat "$dir/out")"
sed -n 2p "$dir/out" | grep -q '^sgd:nickel,1,ward:nickel,.*,,,ward:nickel,$' || fail "nobody to prefer: $(cat "$dir/out")"
grep -q 'nowhere.binary' "$dir/err" || fail "a message"
rank 2 $ref 'lambert:nonsense=1' $a -q
[ "$(cat "$dir/out")" = $a ] || fail "names of those with a score"
rank 3 "$dir/nowhere.binary" $a

rank 2
rank 2 $ref
rank 2 $ref $a --list "$dir/list.jsonl"
rank 2 $ref $a --json --csv
rank 3 --list "$dir/nowhere.csv"
rank 3 --list "$dir/list.jsonl" --root "$dir/nowhere"
rank 2 $ref $a --root "$dir"
