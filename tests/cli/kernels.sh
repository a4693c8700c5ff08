#!/bin/sh
# SPDX-License-Identifier: MIT
# NQM_KERNELS: scores have the same bits by all kernels with fused multiply-add, and the same printed digits by the others; unknown
# names are refused.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"

tests="ward:nickel cook-torrance:nickel abc:nickel perturb:gloss=0.9;of=sgd:nickel perturb:tint=1.05,1,1;of=sgd:nickel sgd:nickel"

# by KERNELS MODEL OPTION: the scores of all tests.
by() {
    # shellcheck disable=SC2086
    NQM_KERNELS=$1 "$tool" score sgd:nickel $tests --model "$2" "$3" 2>"$dir/err"
}

for model in default paper transport; do
    by "" $model --json >"$dir/best.json" || fail "score"
    by "" $model -q >"$dir/best"
    for kernels in avx512+bf16 avx512 avx2 generic scalar; do
        by $kernels $model --json >"$dir/other.json" || {
            grep -q "does not have them" "$dir/err" || fail "NQM_KERNELS=$kernels"
            continue
        }
        case $kernels in
        generic | scalar)
            by $kernels $model -q >"$dir/other"
            cmp "$dir/best" "$dir/other" || fail "$kernels: other digits of $model"
            ;;
        *) cmp "$dir/best.json" "$dir/other.json" || fail "$kernels: other bits of $model" ;;
        esac
    done
done
