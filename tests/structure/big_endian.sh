#!/bin/sh
# SPDX-License-Identifier: MIT
# A build for a big-endian processor ends with a message that says why, from the compiler and from CMake: the loaders use mapped
# files in their byte order. With a cross compiler for s390x the same for a real one.
set -eu
cd "${NQM_SOURCE:-$(dirname "$0")/../..}"
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
message='byte order of the host'
for cc in "${CC:-cc} -U__BYTE_ORDER__ -D__BYTE_ORDER__=__ORDER_BIG_ENDIAN__" s390x-linux-gnu-gcc; do
    command -v "${cc%% *}" >/dev/null || continue
    # shellcheck disable=SC2086 # a command with its options
    if $cc -std=c17 -Isrc -Iinclude -fsyntax-only src/base/number.c 2>"$dir/err"; then
        echo "$cc builds for a big-endian processor"
        exit 1
    fi
    grep -q "$message" "$dir/err" || {
        cat "$dir/err"
        exit 1
    }
done
if cmake -G Ninja -S . -B "$dir/build" -DCMAKE_C_BYTE_ORDER=BIG_ENDIAN -DCMAKE_C_COMPILER_FORCED=ON >"$dir/err" 2>&1 || ! grep -q 'needs a little-endian processor' "$dir/err"; then
    tail "$dir/err"
    exit 1
fi
