#!/bin/sh
# SPDX-License-Identifier: MIT
# The printed examples of all verbs go through a shell as they are, and their options are right: each is run with --help added,
# which is read last. Those that need neither files nor time are also run as printed.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
mkdir -p "$dir/bin" "$dir/here/models"
cat >"$dir/bin/nqm" <<END
#!/bin/sh
"$tool" "\$@" \${ADDED-}
code=\$?
[ \$code = 0 ] || echo "exit code \$code: nqm \$*" >>"$dir/failed"
exit \$code
END
printf '#!/bin/sh\nshift 2\nexec "$@"\n' >"$dir/bin/mpirun"
printf '#!/bin/sh\ncat >/dev/null\n' >"$dir/bin/man" # a bare Debian has none
printf '#!/bin/sh\n' >"$dir/here/models/plan.py"
chmod +x "$dir/bin/nqm" "$dir/bin/mpirun" "$dir/bin/man" "$dir/here/models/plan.py"
PATH=$dir/bin:$PATH
export PATH

# Examples that are run as printed; the others need files, or take longer than a second.
as_printed='^nqm (score sgd:nickel ward:nickel$|rank sgd|info (sgd|.ggx|list|--models|default)|check .lambert|sample sgd:nickel (--csv|>)|directions show|help score$|help --format bash)'
n=0
for verb in $("$tool" --help | sed -n 's/^  \([a-z]*\)  .*/\1/p'); do
    # A line that ends with a backslash or a pipe is continued.
    "$tool" "$verb" --help | sed '1,/^example:/d; s/^  //' | sed -e ':a' -e '/[|\\]$/N; s/\n/ /; ta' >"$dir/examples"
    [ -s "$dir/examples" ] || fail "$verb has no example"
    while IFS= read -r example; do
        n=$((n + 1))
        rm -f "$dir/failed"
        (cd "$dir/here" && ADDED=--help sh -c "$example" </dev/null >"$dir/out" 2>"$dir/err") || true
        [ ! -e "$dir/failed" ] || fail "$example: $(cat "$dir/failed")"
        grep -q 'not found' "$dir/err" && fail "$example: a shell breaks it"
        grep -q '^usage: nqm' "$dir/out" || case $example in *'| '* | models/*) ;; *) fail "$example does not call nqm" ;; esac
        if printf '%s\n' "$example" | grep -qE "$as_printed"; then
            ADDED='' code=0
            export ADDED
            (cd "$dir/here" && sh -c "$example" </dev/null >"$dir/out" 2>"$dir/err") || code=$?
            case $code$example in 0* | 1nqm\ check*) ;; *) fail "$example: exit code $code" ;; esac
        fi
    done <"$dir/examples"
done
[ $n -gt 40 ] || fail "only $n examples"
