#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm info of models: the list, properties of a model file and of the built-in models, copies with notes, refusals; former verbs.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
"${NQM_BUILD:?}/tests/tiny_model" "$dir/model.safetensors"

run 0 info "$dir/model.safetensors" --json
for word in '"id": "tiny"' '"parameters": 36033' '"sha256": "[0-9a-f]\{64\}"' '"n": 500' '"card": "Random'; do
    grep -q "$word" "$dir/out" || fail "JSON lacks $word"
done
run 0 info "$dir/model.safetensors"
{ grep -q '4500-8-1' "$dir/out" && grep -q 'Random weights' "$dir/out"; } || fail "text of a model"
# Notes are appended to the card; the copy differs as a file, passes all checks, and gives the same scores.
echo "Judged by nobody." >"$dir/notes.md"
run 0 info "$dir/model.safetensors" --notes "$dir/notes.md" -o "$dir/annotated.safetensors"
run 0 info "$dir/annotated.safetensors"
{ grep -q 'Random weights' "$dir/out" && grep -q 'Judged by nobody' "$dir/out"; } || fail "annotated card"
run 0 score sgd:nickel ward:nickel --model "$dir/model.safetensors" -q
cp "$dir/out" "$dir/before"
run 0 score sgd:nickel ward:nickel --model "$dir/annotated.safetensors" -q
diff "$dir/before" "$dir/out" || fail "notes change scores"
run 2 info "$dir/model.safetensors" --notes "$dir/notes.md"
run 2 info "$dir/model.safetensors" -o "$dir/x.safetensors"
run 3 info "$dir/model.safetensors" --notes "$dir/no-notes.md" -o "$dir/annotated.safetensors"
# Texts of a model file: control characters are shown as '?', lines of the card remain.
printf 'first\033[31m line\r\n\tsecond\n' >"$dir/notes.md"
"$tool" info transport --notes "$dir/notes.md" -o "$dir/noted.safetensors"
run 0 info "$dir/noted.safetensors"
{ grep -q '^first?\[31m line$' "$dir/out" && grep -q '^ second$' "$dir/out"; } || fail "a card: $(tail -n 5 "$dir/out")"
run 3 info "$dir/nowhere.safetensors"
run 2 info
run 2 info --models default

run 0 info --models --json
names=$(sed -n 's/^ *"id": "\([a-z0-9-]*\)",$/\1/p' "$dir/out" | grep -v '^[0-9a-f]\{16\}$' || true)
for name in $names; do
    run 0 info "$name" --json
    grep -q '"card": "..*"' "$dir/out" || fail "$name: no card"
    run 0 score sgd:nickel sgd:nickel ward:nickel --model "$name" --json
    [ "$(grep -c '"identical": true' "$dir/out")" = 1 ] || fail "$name: identical"
    n=1872
    case $name in paper) n=500 ;; esac
    run 0 directions show "$name"
    [ "$(wc -l <"$dir/out")" = $((n + 1)) ] || fail "$name: $n directions"
done

# Former names of verbs, and of those that are no verbs any more.
run 0 info default --json
cp "$dir/out" "$dir/default"
run 0 models show default --json
cmp "$dir/default" "$dir/out" || fail "models show"
run 0 info --models
cp "$dir/out" "$dir/list"
for words in models "models list"; do
    # shellcheck disable=SC2086
    run 0 $words
    cmp "$dir/list" "$dir/out" || fail "$words"
done
run 0 selftest --json
grep -q '"failed": 0' "$dir/out" || fail "selftest"
