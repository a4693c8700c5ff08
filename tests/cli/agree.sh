#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm agree: brighter and brighter copies rank as made; text, JSON and faults; and, where the shared data are, the table of
# doc/labels.md: the order of the encodings, and ranks no worse than expected.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"

cat >"$dir/pairs.csv" <<'CSV'
reference,test,encoding,delta_e
lambert:.1,perturb:scale=1.2;of=lambert:.1,ward,1
lambert:.2,perturb:scale=1.4;of=lambert:.2,ward,2
lambert:.3,perturb:scale=1.6;of=lambert:.3,ward,3
CSV
sed -i 's/lambert:\./lambert:kd=./g' "$dir/pairs.csv"
"$tool" agree "$dir/pairs.csv" --points 64 --lights 32 >"$dir/out"
grep -q '^| ward | 3 | 1.00 \[' "$dir/out" || fail "text: $(cat "$dir/out")"
"$tool" agree "$dir/pairs.csv" --points 64 --lights 32 --json >"$dir/out.json"
grep -q '"spearman": 1' "$dir/out.json" || fail "json: $(cat "$dir/out.json")"
got=0
"$tool" agree "$dir/pairs.csv" --loss squares 2>"$dir/err" || got=$?
[ "$got" = 2 ] || fail "a bad loss: exit code $got"
sed 's/delta_e/difference/' "$dir/pairs.csv" >"$dir/bad.csv"
got=0
"$tool" agree "$dir/bad.csv" --points 64 --lights 32 2>"$dir/err" || got=$?
[ "$got" = 4 ] || fail "a missing column: exit code $got"
grep -q 'no column delta_e' "$dir/err" || fail "a missing column is not named"

data=${NQM_DATA:-$NQM_SOURCE/../shared/data}
[ -d "$data/rgl" ] && [ -z "${NQM_SANITIZE:-}" ] || exit 0
NQM_TOOL=$tool sh "$NQM_SOURCE/doc/agreement.sh" "$data" --points 256 --lights 192 >"$dir/table"
awk -F'|' '$2 ~ /ward/ { split($4, s, " "); if (s[1] >= 0.5) ++good } $2 ~ /ggx/ { split($4, s, " "); if (s[1] >= 0.3) ++good }
    /^nbrdf below/ { split($0, w, " "); if (w[7] >= 21 && w[9] == 23) ++good }
    END { exit good != 3 }' "$dir/table" || fail "agreement with the authors: $(cat "$dir/table")"
