#!/bin/sh
# SPDX-License-Identifier: MIT
# Compiles the kernels for aarch64 (NEON) and tests them under an emulator. The rest of nqm does not depend on the processor.
# Needs Debian's gcc-aarch64-linux-gnu, libc6-dev-arm64-cross, qemu-user, and libcmocka-dev of the foreign architecture arm64.
# usage: tests/arm/run.sh (./dev arm installs what it needs)
set -eu
cd "$(dirname "$0")/../.."
out=build-arm
mkdir -p "$out"
cc="aarch64-linux-gnu-gcc -std=c17 -D_XOPEN_SOURCE=700 -D_DEFAULT_SOURCE -ffp-contract=off -fno-math-errno -fno-trapping-math
-Wall -Wextra -Wconversion -Wno-psabi -Wno-unknown-pragmas -Werror -ffunction-sections -Isrc -Iinclude -Itests -I/usr/include"
objects=
for name in isa_generic scalar kernels half panel panel_pack; do
    # shellcheck disable=SC2086 # a command with its options. No OpenMP: threads are slow under the emulator
    $cc -O3 -fopenmp-simd -c "src/kernel/$name.c" -o "$out/$name.o"
    objects="$objects $out/$name.o"
done
tests="test_kernel_tables test_kernel_rows"
for test in $tests; do
    # shellcheck disable=SC2086
    $cc -O2 -fopenmp $objects src/base/memory.c src/base/error.c src/base/rng.c tests/support/check.c \
        tests/support/main.c tests/unit/$test.c -o "$out/$test" -lcmocka -lm -Wl,--gc-sections
done
gomp=$(dirname "$(aarch64-linux-gnu-gcc -print-file-name=libgomp.so)")
for test in $tests; do
    qemu-aarch64 -E LD_LIBRARY_PATH="/usr/aarch64-linux-gnu/lib:$gomp" -L / "$out/$test"
done
echo "aarch64: $tests passed under an emulator"
