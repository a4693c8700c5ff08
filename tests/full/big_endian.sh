#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm on a big-endian processor: builds it for s390x and runs the tests of the rooms that read, write or pack values, and the fuzz
# targets' first inputs, under an emulator. Then the native tool and the emulated one must write the same bytes in each format,
# and read each other's. Debian's libraries for s390x are unpacked in build-s390x/root; nothing is installed. Uses the native build.
# usage: big_endian.sh [BUILD [TESTS]], TESTS: a regular expression of ctest
set -eu
cd "$(dirname "$0")/../.."
build=${1:-build} tests=${2:-'^unit[.]test_(base|io|brdf|material|data|model|kernel)|^fuzz[.]'}
out=$PWD/build-s390x root=$PWD/build-s390x/root
# brdf_loading counts pages in memory, which the emulator reads ahead; the others need no file and take minutes.
skipped='(brdf_loading|brdf_analytic)$'
for need in s390x-linux-gnu-gcc qemu-s390x apt-get dpkg-deb; do
    command -v "$need" >/dev/null || {
        echo "needs $need (Debian: gcc-s390x-linux-gnu qemu-user)"
        exit 77
    }
done

# Download the libraries and what they need, and unpack them; absolute links become links into the folder.
fetch() {
    mkdir -p "$out/apt/lists/partial" "$out/apt/cache/archives/partial" "$root"
    set -- -qq -y -o "Dir::State=$out/apt" -o Dir::State::status=/dev/null -o "Dir::Cache=$out/apt/cache" -o APT::Architecture=s390x \
        -o APT::Architectures=s390x -o "APT::Sandbox::User=$(id -un)" -o APT::Install-Recommends=false
    apt-get "$@" update &&
        apt-get "$@" --download-only install libc6-dev libgomp1 libcminpack-dev libhdf5-dev libzip-dev \
            libopenexr-dev libpng-dev libjpeg62-turbo-dev libwebp-dev zlib1g-dev libjansson-dev libexpat1-dev libssl-dev libcmocka-dev || return 1
    for package in "$out"/apt/cache/archives/*.deb; do dpkg-deb -x "$package" "$root"; done
    find "$root" -type l -lname '/*' | while read -r link; do ln -sfn "$root$(readlink "$link")" "$link"; done
    touch "$root/complete"
}
mkdir -p "$out"
[ -f "$root/complete" ] || fetch >"$out/apt.log" 2>&1 || {
    echo "cannot download Debian's libraries for s390x: $(tail -n 1 "$out/apt.log")"
    exit 77
}

export PKG_CONFIG_SYSROOT_DIR="$root" PKG_CONFIG_LIBDIR="$root/usr/lib/s390x-linux-gnu/pkgconfig"
[ -f "$out/build.ninja" ] || cmake -S . -B "$out" -G Ninja -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=s390x \
    -DCMAKE_C_COMPILER=s390x-linux-gnu-gcc -DCMAKE_SYSROOT="$root" -DNQM_EMBREE=OFF -DNQM_WERROR=ON \
    -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG=-O2 \
    -DCMAKE_CROSSCOMPILING_EMULATOR="$(command -v qemu-s390x);-L;$root" >"$out/configure.log" 2>&1 || {
    tail -n 40 "$out/configure.log"
    exit 1
}
{
    cmake --build "$out" --target nqm_tool tiny_model tiny_dataset unit nqm-fuzz &&
        cmake --build "$build" --target nqm_tool tiny_model tiny_dataset
} >"$out/build.log" 2>&1 || {
    tail -n 40 "$out/build.log"
    exit 1
}
n_jobs=$(nproc)           # which depends on the next variable
export OMP_NUM_THREADS=1 # threads are slow under the emulator
ctest --test-dir "$out" -R "$tests" -E "$skipped" -j "$n_jobs" --output-on-failure >"$out/test.log" || {
    grep -A 30 'Failed\|Exception\|Timeout' "$out/test.log" | head -n 100
    exit 1
}

# native PROGRAM ARGUMENTS..., emulated PROGRAM ARGUMENTS...: a program of the build folder.
native() {
    program=$build/$1
    shift
    "$program" "$@"
}
emulated() {
    program=$out/$1
    shift
    qemu-s390x -L "$root" "$program" "$@"
}
ward='ward:kd=.1,.2,.3;ks=.2;alpha=.2' ggx='ggx:kd=.1,.2,.3;ks=.2;alpha=.15'
for run in native emulated; do
    to=$out/$run
    rm -rf "$to"
    mkdir "$to"
    for name in table.npy table.binary; do "$run" nqm convert "$ward" -o "$to/$name" >/dev/null; done
    for name in light.png light.hdr light.exr; do "$run" nqm render --size 40 -o "$to/$name" "$ward" >/dev/null 2>&1; done
    "$run" nqm sample "$ward" >"$to/samples.csv"
    "$run" nqm score "$ggx" "$ward" >"$to/score.txt" # with the built-in model
    "$run" tests/tiny_model "$to/model.safetensors"
    "$run" tests/tiny_dataset "$to/dataset.safetensors"
done
n=0
for file in "$out"/native/*; do
    cmp "$file" "$out/emulated/${file##*/}"
    n=$((n + 1))
done
for table in table.npy table.binary; do
    emulated nqm score "$ggx" "$out/native/$table" >"$out/score.txt"
    native nqm score "$ggx" "$out/native/$table" | cmp - "$out/score.txt"
done
echo "s390x: $(grep 'tests passed' "$out/test.log"); $n files with the same bytes"
