#!/bin/sh
# SPDX-License-Identifier: MIT
# The unit tests built by clang with warnings as errors, beside gcc.
set -eu
cd "$(dirname "$0")/../.."
command -v clang >/dev/null || {
    echo "needs clang and libomp-dev"
    exit 77
}
[ -f build-clang/build.ninja ] || cmake -S . -B build-clang -G Ninja -DCMAKE_C_COMPILER=clang -DNQM_WERROR=ON >/dev/null
cmake --build build-clang >build-clang/build.log || {
    tail -n 40 build-clang/build.log
    exit 1
}
ctest --test-dir build-clang -R '^(unit|fuzz)[.]' -j "$(nproc)" --output-on-failure >build-clang/test.log || {
    grep -A 30 'Failed\|Exception' build-clang/test.log | head -n 60
    exit 1
}
echo "clang: $(grep 'tests passed' build-clang/test.log)"
