#!/bin/sh
# SPDX-License-Identifier: MIT
# examples/demo.sh (./dev demo) runs to its end and shows the far pairs with score, label and words.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
TMPDIR=$dir sh "$NQM_SOURCE/examples/demo.sh" "$tool" >"$dir/demo" 2>"$dir/err" || fail "$(tail -n 3 "$dir/demo" "$dir/err")"
far="sgd:red-fabric sgd:chrome sgd:pink-fabric sgd:green-fabric"
for verb in score label; do
    awk -v wanted="\$ nqm $verb $far" '/^\$ nqm / { shown = $0 == wanted } shown' "$dir/demo" >"$dir/part"
    [ "$(grep -c ' sgd:[a-z]*-*[a-z]*$' "$dir/part")" -ge 3 ] || fail "$verb of the far pairs: $(cat "$dir/part")"
done
grep -q '^ *much brighter, much bluer' "$dir/part" || fail "no words beside the label"
