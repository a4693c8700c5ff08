#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm models and nqm selftest: lists, properties of a model file and of the built-in models, refusals; the self-test
# passes.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors"

run 0 models show "$dir/model.safetensors" --json
for word in '"id": "tiny"' '"parameters": 36033' '"sha256": "[0-9a-f]\{64\}"' '"n": 500' '"card": "Random'; do
    grep -q "$word" "$dir/out" || fail "JSON lacks $word"
done
run 0 models show "$dir/model.safetensors"
{ grep -q '4500-8-1' "$dir/out" && grep -q 'Random weights' "$dir/out"; } || fail "text of a model"
# Notes are appended to the card; the copy differs as a file, passes all checks, and gives the same scores.
echo "Judged by nobody." >"$dir/notes.md"
run 0 models annotate "$dir/model.safetensors" "$dir/notes.md" -o "$dir/annotated.safetensors"
run 0 models show "$dir/annotated.safetensors"
{ grep -q 'Random weights' "$dir/out" && grep -q 'Judged by nobody' "$dir/out"; } || fail "annotated card"
run 0 score sgd:nickel ward:nickel --model "$dir/model.safetensors" -q
cp "$dir/out" "$dir/before"
run 0 score sgd:nickel ward:nickel --model "$dir/annotated.safetensors" -q
diff "$dir/before" "$dir/out" || fail "notes change scores"
run 2 models annotate "$dir/model.safetensors" "$dir/notes.md"
run 3 models annotate "$dir/model.safetensors" "$dir/no-notes.md" -o "$dir/annotated.safetensors"
run 6 models show nonsense
# Texts of a model file: control characters are shown as '?', lines of the card remain.
printf 'first\033[31m line\r\n\tsecond\n' >"$dir/notes.md"
"$tool" models annotate transport "$dir/notes.md" -o "$dir/noted.safetensors"
for verb in "models show" info; do
    # shellcheck disable=SC2086
    run 0 $verb "$dir/noted.safetensors"
    { grep -q '^first?\[31m line$' "$dir/out" && grep -q '^ second$' "$dir/out"; } || fail "$verb: a card: $(tail -n 5 "$dir/out")"
done
run 3 models show "$dir/nowhere.safetensors"
run 2 models show
run 2 models delete default

run 0 models --json
names=$(sed -n 's/^ *"id": "\([a-z0-9-]*\)",$/\1/p' "$dir/out" | grep -v '^[0-9a-f]\{16\}$' || true)
for name in $names; do
    run 0 models show "$name" --json
    grep -q '"card": "..*"' "$dir/out" || fail "$name: no card"
    run 0 score sgd:nickel sgd:nickel ward:nickel --model "$name" --json
    [ "$(grep -c '"identical": true' "$dir/out")" = 1 ] || fail "$name: identical"
    n=1872
    case $name in paper) n=500 ;; esac
    run 0 directions show "$name"
    [ "$(wc -l <"$dir/out")" = $((n + 1)) ] || fail "$name: $n directions"
done

run 0 selftest
grep -q '0 failed' "$dir/out" || fail "selftest"
grep -q 'FAILED' "$dir/out" && fail "selftest says FAILED and ends with 0"
run 0 selftest --json
grep -q '"failed": 0' "$dir/out" || fail "selftest JSON"
