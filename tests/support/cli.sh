# shellcheck shell=sh
# SPDX-License-Identifier: MIT
# What the command-line tests share: the tool under test, a folder that goes away with the test, the way to fail, and
# running the tool.
# Source it first: . "${NQM_SOURCE:?}/tests/support/cli.sh"
set -eu
tool=${NQM_TOOL:?}
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT

# fail MESSAGE: end the test; what the tool said last, if the test kept it in err, says why.
fail() {
    echo "$1"
    [ ! -f "$dir/err" ] || cat "$dir/err"
    exit 1
}

# run CODE ARGUMENTS...: run the tool, which must end with CODE; what it says is in out and err.
run() {
    code=$1
    shift
    got=0
    "$tool" "$@" >"$dir/out" 2>"$dir/err" || got=$?
    [ "$got" = "$code" ] || fail "exit code $got, not $code: $*"
}

# number KEY N: the N-th value of "KEY" in the JSON in out.
number() { sed -n 's/.*"'"$1"'": *\([^,]*\),*$/\1/p' "$dir/out" | sed -n "$2p"; }

# png_size FILE: "width height" from its header.
png_size() { od -A n -t u1 -j 16 -N 8 "$1" | awk '{print $3 * 256 + $4, $7 * 256 + $8}'; }
