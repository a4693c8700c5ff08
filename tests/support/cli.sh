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

# says PATTERN: the last run said so on standard error, and nothing on standard output.
says() {
    grep -q -- "$1" "$dir/err" || fail "no '$1' in the message"
    [ ! -s "$dir/out" ] || fail "results on failure"
}

# refuses CODE PATTERN ARGUMENTS...: run the tool, which must end with CODE and say PATTERN (. is anything).
refuses() {
    code=$1 pattern=$2
    shift 2
    run "$code" "$@"
    says "$pattern"
}

# until_written FILE: wait until FILE is there and not empty, for half a minute at most.
until_written() {
    i=0
    while [ ! -s "$1" ] && [ $i -lt 300 ]; do
        sleep 0.1
        i=$((i + 1))
    done
}

# ctrl_c: interrupt the command that was started last, which must end with 130. (A shell without job control starts
# background commands with SIGINT ignored; the tool installs its handler nevertheless.)
ctrl_c() {
    kill -INT $! 2>/dev/null || fail "it ended before Ctrl-C"
    got=0
    wait $! || got=$?
    [ "$got" = 130 ] || fail "exit code $got after Ctrl-C"
}

# number KEY N: the N-th value of "KEY" in the JSON in out.
number() { sed -n 's/.*"'"$1"'": *\([^,]*\),*$/\1/p' "$dir/out" | sed -n "$2p"; }

# png_size FILE: "width height" from its header.
png_size() { od -A n -t u1 -j 16 -N 8 "$1" | awk '{print $3 * 256 + $4, $7 * 256 + $8}'; }
