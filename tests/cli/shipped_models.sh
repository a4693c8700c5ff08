#!/bin/sh
# SPDX-License-Identifier: MIT
# The two built-in models: their properties, that a BRDF compared with itself scores at the top of the range, and that
# the default model scores more noise lower. Presets only; shipped_models_rgl.sh does the same on measured files.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"

below() { awk -v a="$1" -v b="$2" 'BEGIN { exit !(a < b) }'; }

"$tool" info paper --json >"$dir/paper.json"
grep -q '"parameters": 4171125' "$dir/paper.json" || fail "paper: the network is not the paper's"
"$tool" info default --json >"$dir/default.json"
grep -q '"card"' "$dir/default.json" || fail "default: no card"
"$tool" doctor >"$dir/doctor" || fail "doctor: $(cat "$dir/doctor")"

presets=$("$tool" info list | grep -o 'sgd:[^ ]*' | sort -u | awk 'NR % 10 == 1')
[ "$(echo "$presets" | wc -l)" -ge 10 ] || fail "hardly any preset was found"
for preset in $presets; do
    "$tool" score "$preset" "$preset" "perturb:noise=0.03;of=$preset" "perturb:noise=0.1;of=$preset" \
        "perturb:noise=0.3;of=$preset" "perturb:noise=1;of=$preset" -q | tr '\n' ' '
    echo
done >"$dir/noise"
awk '$1 < 9.9 { print "a preset beside itself scores " $1; bad = 1 } END { exit bad }' "$dir/noise" || fail "identity"
awk '{ for (i = 1; i <= NF; ++i) sum[i] += $i }
     END { for (i = 2; i <= 5; ++i) if (!(sum[i] < sum[i - 1])) bad = 1
           for (i = 1; i <= 5; ++i) printf "%.3f ", sum[i] / NR; exit bad }' "$dir/noise" || fail "noise: means do not fall"

# The order of reference and test: default changes within its interval and by 0.2 JOD at most, transport not at all.
"$tool" info list >"$dir/list"
echo reference,test >"$dir/orders.csv"
for preset in $presets; do
    test=ward${preset#sgd}
    ! grep -qx "$test" "$dir/list" || printf '%s\n' "$preset,$test" "$test,$preset" >>"$dir/orders.csv"
done
[ "$(wc -l <"$dir/orders.csv")" -ge 13 ] || fail "few pairs have two orders: $(cat "$dir/orders.csv")"
for model in default transport; do
    "$tool" batch "$dir/orders.csv" --model $model -k 2>/dev/null | awk -F, -v model=$model '
        NR > 1 && NR % 2 == 0 { jod = $3; low = $4; high = $5 }
        NR > 1 && NR % 2 == 1 { d = $3 - jod
            if (model == "transport" ? d * d > 1e-10 : d * d > 0.04 || $3 < low || $3 > high) { print model ": " $0 "; " jod; bad = 1 } }
        END { exit bad }' || fail "the order matters"
done
"$tool" score --help | grep -q 'exchanged with a TEST, the score changes' || fail "the help hides the order"

# A strong tint and a strong reduction of the highlight score lower than slight ones.
slight=$("$tool" score sgd:red-plastic "perturb:tint=1.02,1,1;of=sgd:red-plastic" -q)
strong=$("$tool" score sgd:red-plastic "perturb:tint=1.6,1,1;of=sgd:red-plastic" -q)
below "$strong" "$slight" || fail "tint: $strong is not below $slight"
slight=$("$tool" score sgd:nickel "perturb:gloss=0.95;of=sgd:nickel" -q)
strong=$("$tool" score sgd:nickel "perturb:gloss=0.4;of=sgd:nickel" -q)
below "$strong" "$slight" || fail "gloss: $strong is not below $slight"
