#!/bin/sh
# SPDX-License-Identifier: MIT
# valgrind over the loaders: each fuzz target with its valid first input, 400 truncations, and mutations for 10 s, and the tests of the readers. Fails when
# a value that was never written decides something, or memory is read or written out of bounds. Uses the regular build.
# usage: memory.sh [BUILD]
set -eu
cd "$(dirname "$0")/../.."
build=${1:-build}
command -v valgrind >/dev/null || {
    echo "needs valgrind"
    exit 77
}
targets=
for source in fuzz/fuzz_*.c; do targets="$targets $(basename "$source" .c)"; done
tests="test_io_csv test_io_xml test_io_mat test_io_kind test_brdf_npy"
cmake --build "$build" --target nqm-fuzz test_io test_brdf >"$build/memory.log" || {
    tail -n 40 "$build/memory.log"
    exit 1
}
n=0
# check PROGRAM NAME: the tests of one file, or one fuzz target.
check() {
    OMP_NUM_THREADS=1 valgrind -q --error-exitcode=9 "$build/tests/$1" "$2" >"$build/valgrind.log" 2>&1 || {
        echo "$2:"
        tail -n 40 "$build/valgrind.log"
        exit 1
    }
    n=$((n + 1))
}
for name in $targets; do check nqm-fuzz "$name"; done
for name in $tests; do check "$(echo "$name" | cut -d _ -f 1-2)" "$name"; done
echo "$n programs that read files under valgrind"
