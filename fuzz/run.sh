#!/bin/sh
# SPDX-License-Identifier: MIT
# run.sh [SECONDS] [TARGET...] - build the fuzz targets with clang's libFuzzer, AddressSanitizer and UBSan in
# build-fuzz/ and run each for SECONDS (default 60), one on each core, starting from the corpus of earlier runs. Prints one line
# per target. A target that crashes does not stop the others; its input is build-fuzz/NAME-crash-*.
# run.sh --one SECONDS TARGET - run one target that is built.
set -eu
cd "$(dirname "$0")/.."
one=
if [ "${1:-}" = --one ]; then
    one=$3
    set -- "$2"
fi
seconds=${1:-60}
[ $# = 0 ] || shift
if ! command -v clang >/dev/null 2>&1; then
    echo "fuzzing needs clang with libFuzzer and OpenMP (Debian: clang libomp-dev)" >&2
    exit 77
fi
# libFuzzer's usual optimisation, which compiles in a third of the time of -O2.
[ -f build-fuzz/build.ninja ] || cmake -S . -B build-fuzz -G Ninja -DCMAKE_C_COMPILER=clang -DNQM_FUZZ=ON \
    -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG="-O1 -g1" -DNQM_SANITIZE=address,undefined,fuzzer-no-link >/dev/null
# dictionary NAME: the option with the words of the target's format.
dictionary() {
    case $1 in
    fuzz_csv | fuzz_listed | fuzz_human | fuzz_columns | fuzz_authors | fuzz_latents) words=csv ;;
    fuzz_pairs | *_gltf | *_json) words=json ;;
    *_xml | fuzz_materialx) words=xml ;;
    *_pbrt) words=pbrt ;;
    fuzz_mesh_*) words=mesh ;;
    fuzz_spec) words=spec ;;
    fuzz_safetensors | fuzz_npy | fuzz_checkpoint | fuzz_model* | fuzz_dataset | fuzz_dictionary | fuzz_hyper) words=tensors ;;
    *) return ;;
    esac
    echo "-dict=fuzz/dictionaries/$words.dict"
}

# fuzz NAME: run it for the given time and print what it did.
fuzz() {
    corpus=build-fuzz/corpus/$1 log=build-fuzz/$1.log
    mkdir -p "$corpus"
    build-fuzz/tests/nqm-fuzz "$1" --seed "$corpus/seed"
    # libFuzzer would cut the first input to its limit.
    n_max=$(wc -c <"$corpus/seed")
    [ "$n_max" -ge 32768 ] || n_max=32768
    # Inputs that declare huge sizes must fail without large allocations: 256 MB is far more than a valid input needs.
    # shellcheck disable=SC2046 # no option without a dictionary
    OMP_NUM_THREADS=1 build-fuzz/tests/nqm-fuzz "$1" $(dictionary "$1") -max_total_time="$seconds" -max_len="$n_max" -malloc_limit_mb=256 \
        -artifact_prefix="build-fuzz/$1-" -print_final_stats=1 "$corpus" 2>"$log" || {
        grep -v '^#' "$log" | tail -n 60
        echo "$1: FAILED: $(grep -m 1 '^SUMMARY' "$log")"
        return 1
    }
    echo "$1: $(sed -n 's/^Done \([0-9]*\) runs in \([0-9]*\).*/\1 inputs in \2 s/p' "$log"), $(find "$corpus" -type f | wc -l) kept"
}

if [ "$one" ]; then
    fuzz "$one"
    exit
fi
[ $# != 0 ] || set -- fuzz/fuzz_*.c
names=
for target; do names="$names $(basename "$target" .c)"; done
cmake --build build-fuzz --target nqm-fuzz >build-fuzz/build.log || {
    tail -n 40 build-fuzz/build.log
    exit 1
}
# shellcheck disable=SC2086
printf '%s\n' $names | xargs -P "$(nproc)" -n 1 sh fuzz/run.sh --one "$seconds" | tee build-fuzz/summary
n_done=$(grep -c ' inputs in ' build-fuzz/summary || true)
echo "$# targets under libFuzzer, $seconds s each, $(($# - n_done)) failed"
[ "$n_done" = $# ]
