#!/bin/sh
# SPDX-License-Identifier: MIT
# The default model scores every measured RGL file against itself within 0.1 JOD of the top of the range and reports the
# pair as identical; with increasing noise the mean score over the files decreases. Needs the measured data.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
data=${NQM_DATA:-${NQM_SOURCE:?}/../shared/data}
[ -d "$data/rgl" ] || exit 77

top=$("$tool" info default | sed -n 's/^JOD range .* to \([0-9.]*\)$/\1/p')
[ -n "$top" ] || { echo "the model tells no range"; exit 1; }
for file in "$data"/rgl/*_rgb.bsdf; do
    "$tool" score "$file" "$file" "perturb:noise=0.03;of=$file" "perturb:noise=0.1;of=$file" "perturb:noise=0.3;of=$file" \
        "perturb:noise=1;of=$file" --csv 2>/dev/null |
        awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) { if ($i == "jod") j = i; if ($i == "identical") same = i } next }
                 { printf "%s %s ", $j, $same } END { print "" }'
done >"$dir/scores"
[ "$(wc -l <"$dir/scores")" -ge 26 ] || { echo "too few files"; exit 1; }
awk -v top="$top" '
    NF != 10 { print "a row lacks scores: " $0; bad = 1 }
    $1 < top - 0.1 || ($2 != "true" && $2 != 1) { print "beside itself: " $1 " " $2; bad = 1 }
    $4 == "true" || $4 == 1 { print "noise is reported identical"; bad = 1 }
    { for (i = 0; i < 5; ++i) sum[i] += $(2 * i + 1) }
    END {
        for (i = 0; i < 5; ++i) printf "%.3f ", sum[i] / NR
        for (i = 1; i < 5; ++i) if (!(sum[i] < sum[i - 1])) { print "the mean does not fall"; bad = 1 }
        exit bad
    }' "$dir/scores"
