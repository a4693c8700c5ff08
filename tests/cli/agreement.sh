#!/bin/sh
# SPDX-License-Identifier: MIT
# studies/agreement.py: correlations, medians and order of known labels, own fits, errors. With the shared data also the
# table of doc/labels.md: the order of the encodings, and lower limits for the rank correlations.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
export NQM_TOOL="$tool"
agree() { python3 "$NQM_SOURCE/studies/agreement.py" "$dir/pairs.csv" --points 64 --lights 32 "$@"; }
# expect KEY N VALUE: the N-th value of KEY in the JSON in out.
expect() { number "$1" "$2" | awk -v e="$3" '{d = $1 - e; exit !(d * d < 1e-12)}' || fail "$1 $2 is $(number "$1" "$2"), not $3"; }

# Greys: the difference grows with the ratio of the albedos, so every rank is known in advance.
cat >"$dir/pairs.csv" <<'CSV'
reference,test,encoding,delta_e
lambert:kd=.1,lambert:kd=.11,ward,3
lambert:kd=.2,lambert:kd=.3,ward,2
lambert:kd=.3,lambert:kd=.9,ward,1
lambert:kd=.1,lambert:kd=.12,ggx,10
lambert:kd=.2,lambert:kd=.31,ggx,30
lambert:kd=.3,lambert:kd=.91,ggx,20
CSV
agree --json >"$dir/out" || fail "--json"
expect n 1 3 && expect n 2 3 && expect n 3 6
expect spearman 1 -1 && expect null_luminance 1 -1 && expect spearman 2 0.5 && expect null_luminance 2 0.5
# Medians of the other labels of the encoding: ward 1.5, 2, 2.5; ggx 25, 15, 20. Ranks 1 2 3 6 4 5 against 3 2 1 4 6 5.
expect pooled_null_encoding 1 "$(awk 'BEGIN {print 1 - 6 * 16 / (6 * 35)}')"
expect median_theirs 1 2
expect references 1 0
agree >"$dir/out" || fail "the table"
grep -q '^| ward | 3 | -1.00 \[' "$dir/out" || fail "the table: $(cat "$dir/out")"

# The order of the encodings is computed over the references that have all three.
cat >"$dir/pairs.csv" <<'CSV'
delta_e,encoding,reference,test
1,nbrdf,sgd:nickel,perturb:scale=1.1;of=sgd:nickel
2,ward,sgd:nickel,perturb:scale=2;of=sgd:nickel
3,ggx,sgd:nickel,perturb:scale=3;of=sgd:nickel
1,nbrdf,sgd:pearl-paint,perturb:scale=2.5;of=sgd:pearl-paint
2,ward,sgd:pearl-paint,perturb:scale=2;of=sgd:pearl-paint
3,ggx,sgd:pearl-paint,perturb:scale=3;of=sgd:pearl-paint
5,nbrdf,lambert:kd=.5,lambert:kd=.1
CSV
agree --json >"$dir/out" || fail "order"
expect references 1 2 && expect ours 1 1 && expect theirs 1 2

# Own fits: Ward's model must fit itself with a Delta-E below 1.
cat >"$dir/pairs.csv" <<'CSV'
reference,test,encoding,delta_e
"ward:kd=.1,.1,.1;ks=.05,.05,.05;alpha=.2",fit,ward,1
"ward:kd=.1,.1,.1;ks=.05,.05,.05;alpha=.2",lambert:kd=.2,other,2
CSV
agree --json >"$dir/out" 2>"$dir/err" || fail "own fits"
[ "$(number median_ours 1 | cut -d. -f1)" = 0 ] && [ "$(number median_ours 2 | cut -d. -f1)" -ge 2 ] || fail "own fits: $(cat "$dir/out")"
[ "$(number spearman 1)" = NaN ] || fail "a correlation of one pair"

# refused CODE MESSAGE ARGUMENTS...
refused() {
    code=$1 message=$2 got=0
    shift 2
    agree "$@" >"$dir/out" 2>"$dir/err" || got=$?
    [ "$got" = "$code" ] || fail "exit code $got, not $code: $message"
    grep -q "$message" "$dir/err" || fail "'$message' is not said"
}
refused 2 squares --loss squares
printf 'reference,test,delta_e\nlambert:,lambert:,1\n' >"$dir/pairs.csv"
refused 4 'no column encoding'
printf 'reference,test,encoding,delta_e\nlambert:,lambert:,a,1\n' >"$dir/pairs.csv"
refused 5 '2 pairs'
printf 'reference,test,encoding,delta_e\nlambert:,lambert:,a,1\nlambert:,lambert:,a,x\n' >"$dir/pairs.csv"
refused 4 'line 3'
printf 'reference,test,encoding,delta_e\nlambert:,fit,phong,1\nlambert:,lambert:,a,2\n' >"$dir/pairs.csv"
refused 2 phong
printf 'reference,test,encoding,delta_e\n/nowhere,fit,ward,1\nlambert:,lambert:,a,2\n' >"$dir/pairs.csv"
refused 3 nowhere

data=${NQM_DATA:-$NQM_SOURCE/../shared/data}
[ -d "$data/rgl" ] && [ -z "${NQM_SANITIZE:-}" ] || skip_rest agreement_of_measured_files
sh "$NQM_SOURCE/studies/agreement.sh" "$data" --points 256 --lights 192 >"$dir/table"
awk -F'|' '$2 ~ /ward/ { split($4, s, " "); if (s[1] >= 0.5) ++good } $2 ~ /ggx/ { split($4, s, " "); if (s[1] >= 0.3) ++good }
    /^nbrdf below/ { split($0, w, " "); if (w[7] >= 21 && w[9] == 23) ++good }
    END { exit good != 3 }' "$dir/table" || fail "agreement with the authors: $(cat "$dir/table")"
