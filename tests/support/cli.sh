# shellcheck shell=sh
# SPDX-License-Identifier: MIT
# Shared by the command-line tests: the tool under test, a temporary folder that is removed when the test ends, and
# functions that run the tool and report failures.
# Source it first: . "${NQM_SOURCE:?}/tests/support/cli.sh"
set -eu
tool=${NQM_TOOL:?}
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT

# fail MESSAGE: end the test and print the message and the tool's last standard error, if the test stored it in err.
fail() {
    echo "$1"
    [ ! -f "$dir/err" ] || cat "$dir/err"
    exit 1
}

# skip_rest NAME: the rest needs what is not there. `./dev test` lists the name, as those of tests that cmocka skips.
skip_rest() {
    echo "[  SKIPPED ] $1"
    exit 0
}

# run CODE ARGUMENTS...: run the tool, which must exit with CODE; standard output goes to out, standard error to err.
run() {
    code=$1
    shift
    got=0
    "$tool" "$@" >"$dir/out" 2>"$dir/err" || got=$?
    [ "$got" = "$code" ] || fail "exit code $got, not $code: $*"
}

# says PATTERN: the standard error of the last run must match PATTERN, and its standard output must be empty.
says() {
    grep -q -- "$1" "$dir/err" || fail "no '$1' in the message"
    [ ! -s "$dir/out" ] || fail "results on failure"
}

# refuses CODE PATTERN ARGUMENTS...: run the tool, which must exit with CODE and a message that matches PATTERN.
refuses() {
    code=$1 pattern=$2
    shift 2
    run "$code" "$@"
    says "$pattern"
}

# until_written FILE: wait until FILE exists and is not empty, for at most half an hour.
until_written() {
    i=0
    while [ ! -s "$1" ] && [ $i -lt 18000 ]; do
        sleep 0.1
        i=$((i + 1))
    done
}

# ctrl_c: interrupt the last background command, which must exit with 130. (A shell without job control starts
# background commands with SIGINT ignored; the tool installs its handler nevertheless.)
ctrl_c() {
    kill -INT $! 2>/dev/null || fail "it ended before Ctrl-C"
    got=0
    wait $! || got=$?
    [ "$got" = 130 ] || fail "exit code $got after Ctrl-C"
}

# number KEY N: print the N-th value of "KEY" in the JSON in out.
number() { sed -n 's/.*"'"$1"'": *\([^,]*\),*$/\1/p' "$dir/out" | sed -n "$2p"; }

# png_size FILE: print "width height" from the PNG header.
png_size() { od -A n -t u1 -j 16 -N 8 "$1" | awk '{print $3 * 256 + $4, $7 * 256 + $8}'; }

# interrupt ARGUMENTS...: run nqm and press Ctrl-C after a moment; exit code 130, nothing on standard output.
interrupt() {
    "$tool" "$@" >"$dir/out" 2>"$dir/err" &
    pid=$!
    # A shell without job control starts background commands with SIGINT ignored, until nqm installs its handler.
    while [ -d /proc/$pid ] && ! grep -q 'SigCgt:.*[2367abef]$' /proc/$pid/status 2>/dev/null; do sleep 0.05; done
    sleep 0.3
    kill -INT $pid || fail "ended before Ctrl-C: $*"
    got=0
    wait $pid || got=$?
    [ "$got" = 130 ] || fail "exit code $got after Ctrl-C: $*"
    [ ! -s "$dir/out" ] || fail "results of an interrupted run: $*"
}
