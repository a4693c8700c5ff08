#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm models and nqm selftest: lists, facts of a file and of whatever is built in, refusals; the self-test passes.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors"

expect() {
    code=$1
    shift
    got=0
    "$tool" "$@" >"$dir/out" 2>"$dir/err" || got=$?
    [ "$got" = "$code" ] || fail "exit code $got, not $code: $*: $(cat "$dir/err")"
}

expect 0 models show "$dir/model.safetensors" --json
for word in '"id": "tiny"' '"parameters": 36033' '"sha256": "[0-9a-f]\{64\}"' '"n": 500' '"card": "Random'; do
    grep -q "$word" "$dir/out" || fail "JSON lacks $word"
done
expect 0 models show "$dir/model.safetensors"
{ grep -q '4500-8-1' "$dir/out" && grep -q 'Random weights' "$dir/out"; } || fail "text of a model"
# Notes go behind the card; the copy is another file that passes all checks, and scores the same.
echo "Judged by nobody." >"$dir/notes.md"
expect 0 models annotate "$dir/model.safetensors" "$dir/notes.md" -o "$dir/annotated.safetensors"
expect 0 models show "$dir/annotated.safetensors"
{ grep -q 'Random weights' "$dir/out" && grep -q 'Judged by nobody' "$dir/out"; } || fail "annotated card"
expect 0 score sgd:nickel ward:nickel --model "$dir/model.safetensors" -q
cp "$dir/out" "$dir/before"
expect 0 score sgd:nickel ward:nickel --model "$dir/annotated.safetensors" -q
diff "$dir/before" "$dir/out" || fail "notes change scores"
expect 2 models annotate "$dir/model.safetensors" "$dir/notes.md"
expect 3 models annotate "$dir/model.safetensors" "$dir/no-notes.md" -o "$dir/annotated.safetensors"
expect 6 models show nonsense
expect 3 models show "$dir/nowhere.safetensors"
expect 2 models show
expect 2 models delete default

expect 0 models --json
names=$(sed -n 's/^ *"id": "\([a-z0-9-]*\)",$/\1/p' "$dir/out" | grep -v '^[0-9a-f]\{16\}$' || true)
for name in $names; do
    expect 0 models show "$name" --json
    grep -q '"card": "..*"' "$dir/out" || fail "$name: no card"
    expect 0 score sgd:nickel sgd:nickel ward:nickel --model "$name" --json
    [ "$(grep -c '"identical": true' "$dir/out")" = 1 ] || fail "$name: identical"
    expect 0 directions show "$name"
    [ "$(wc -l <"$dir/out")" = 501 ] || fail "$name: 500 directions"
done

expect 0 selftest
grep -q '0 failed' "$dir/out" || fail "selftest"
grep -q 'FAILED' "$dir/out" && fail "selftest says FAILED and ends with 0"
expect 0 selftest --json
grep -q '"failed": 0' "$dir/out" || fail "selftest JSON"
