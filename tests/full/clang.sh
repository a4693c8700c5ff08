#!/bin/sh
# SPDX-License-Identifier: MIT
# The tool, the unit tests and the fuzz targets built by clang with warnings as errors, as gcc builds them but without debug
# information; then the tests, and the tool's own.
set -eu
cd "$(dirname "$0")/../.."
command -v clang >/dev/null || {
    echo "needs clang and libomp-dev"
    exit 77
}
[ -f build-clang/build.ninja ] || cmake -S . -B build-clang -G Ninja -DCMAKE_C_COMPILER=clang -DNQM_WERROR=ON \
    -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG=-O2 >/dev/null
cmake --build build-clang --target nqm_tool unit nqm-fuzz >build-clang/build.log || {
    tail -n 40 build-clang/build.log
    exit 1
}
ctest --test-dir build-clang -R '^(unit|fuzz)[.]' -j "$(nproc)" --output-on-failure >build-clang/test.log || {
    grep -A 30 'Failed\|Exception' build-clang/test.log | head -n 60
    exit 1
}
build-clang/nqm doctor >build-clang/doctor.log || {
    cat build-clang/doctor.log
    exit 1
}
echo "clang: $(grep 'tests passed' build-clang/test.log)"
