#!/bin/sh
# SPDX-License-Identifier: MIT
# All tests of code with each table of kernels that this processor can run but the best one, which the regular tests use: NQM_KERNELS selects
# it for the tool and for the unit tests. Uses the regular build.
# usage: tables.sh [BUILD]
set -eu
cd "$(dirname "$0")/../.."
build=${1:-build}
names=$(NQM_KERNELS=unknown "$build/nqm" --version 2>&1 | sed -n 's/.*choose one of: [^ ]* *//p')
[ -n "$names" ] || {
    echo "$build/nqm names no kernels"
    exit 1
}
passed=
for name in $names; do
    NQM_KERNELS=$name ctest --test-dir "$build" -j "$(nproc)" --output-on-failure -E '^(structure|docs)[.]' >"$build/tables.log" 2>&1 || {
        grep -E '^ *[0-9]+ - |tests passed' "$build/tables.log"
        echo "failed with NQM_KERNELS=$name; see $build/tables.log"
        exit 1
    }
    passed="$passed $name: $(grep -c ' Passed ' "$build/tables.log");"
done
echo "tests that passed:${passed%;}"
