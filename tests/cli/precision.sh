#!/bin/sh
# SPDX-License-Identifier: MIT
# --precision and NQM_KERNELS: the permitted and the forbidden differences, for the built-in models and presets only.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"

ref=sgd:nickel
tests="ward:nickel cook-torrance:nickel abc:nickel perturb:gloss=0.9;of=sgd:nickel perturb:tint=1.05,1,1;of=sgd:nickel $ref"

# jods PRECISION MODEL: print the JOD of each test, one per line.
jods() {
    # shellcheck disable=SC2086
    "$tool" score $ref $tests --precision "$1" --model "$2" -q || fail "score --precision $1"
}

# bf16 and int8 are close to f32, but not equal to it.
for model in default paper; do
    for precision in f32 bf16 int8; do
        jods $precision $model >"$dir/$precision"
    done
    paste "$dir/f32" "$dir/bf16" "$dir/int8" | awk -v model=$model '
        { for (i = 2; i <= 3; ++i) { d = $i - $1; d = d < 0 ? -d : d; if (d > worst[i]) worst[i] = d } }
        END { print model, worst[2], worst[3]
              if (worst[2] > 0.05 || worst[3] > 0.4 || worst[2] == 0 || worst[3] == 0) exit 1 }' || fail "$model: far from f32"
done

# The output names the precision unless it is the default.
run 0 score $ref ward:nickel --json
grep -q precision "$dir/out" && fail "f32 is named"
run 0 score $ref ward:nickel --json --precision bf16
grep -q '"precision": "bf16"' "$dir/out" || fail "score: bf16 is not named"
run 0 rank $ref ward:nickel abc:nickel --json --precision int8
grep -q '"precision": "int8"' "$dir/out" || fail "rank: int8 is not named"
printf 'reference,test\n%s,ward:nickel\n' $ref >"$dir/list.csv"
run 0 batch "$dir/list.csv" --json --precision int8
grep -q '"precision": *"int8"' "$dir/out" || fail "batch: int8 is not named"
for verb in "score $ref $ref" "rank $ref $ref" "batch $dir/list.csv" "eval $dir/list.csv"; do
    # shellcheck disable=SC2086
    run 2 $verb --precision f64
done

# There is no choice of a precision by its speed.
for verb in "score $ref $ref" "rank $ref $ref" "batch $dir/list.csv" "eval $dir/list.csv" "train $dir/none"; do
    # shellcheck disable=SC2086
    run 2 $verb --precision auto
done

# A resumed batch names the precision that it was begun with.
printf 'reference,test\n%s,ward:nickel\n%s,%s/missing.binary\n' $ref $ref "$dir" >"$dir/two.csv"
run 3 batch "$dir/two.csv" -o "$dir/two.out.csv" --precision bf16
run 5 batch "$dir/two.csv" -o "$dir/two.out.csv" --precision f32 --resume
says 'another --precision, bf16'

# All kernels with fused multiply-add give the same bits, plain loops the same printed digits; unknown names are
# refused.
NQM_KERNELS= "$tool" score $ref ward:nickel --json >"$dir/best.json" || fail "score"
for kernels in avx512+amx avx512+bf16 avx512 avx2 scalar; do
    NQM_KERNELS=$kernels "$tool" score $ref ward:nickel --json >"$dir/other.json" 2>"$dir/err" || {
        grep -q "does not have them" "$dir/err" || fail "NQM_KERNELS=$kernels"
        continue
    }
    if [ $kernels = scalar ]; then
        a=$(NQM_KERNELS= "$tool" score $ref ward:nickel -q) b=$(NQM_KERNELS=scalar "$tool" score $ref ward:nickel -q)
        [ "$a" = "$b" ] || fail "plain loops: $b for $a"
    else
        cmp "$dir/best.json" "$dir/other.json" || fail "$kernels gives other bits"
    fi
done
export NQM_KERNELS=abacus
refuses 2 "abacus.*scalar" score $ref $ref
