#!/bin/sh
# SPDX-License-Identifier: MIT
# run.sh [SECONDS] [TARGET...] - build the fuzz targets with clang's libFuzzer, AddressSanitizer and UBSan in
# build-fuzz/ and run each for SECONDS (default 60), starting from the corpus of earlier runs. The first crash ends the
# run; its input is in build-fuzz/.
set -eu
cd "$(dirname "$0")/.."
seconds=${1:-60}
[ $# = 0 ] || shift
if ! command -v clang >/dev/null 2>&1; then
    echo "fuzzing needs clang with libFuzzer and OpenMP (Debian: clang libomp-dev)" >&2
    exit 77
fi
[ -f build-fuzz/build.ninja ] || cmake -S . -B build-fuzz -G Ninja -DCMAKE_C_COMPILER=clang -DNQM_FUZZ=ON \
    -DNQM_SANITIZE=address,undefined,fuzzer-no-link >/dev/null
# dictionary NAME: the option with the words of the target's format.
dictionary() {
    case $1 in
    fuzz_csv | fuzz_listed | fuzz_human | fuzz_columns | fuzz_material_list) words=csv ;;
    fuzz_pair_list | *_gltf | *_json) words=json ;;
    *_xml | fuzz_materialx) words=xml ;;
    *_pbrt) words=pbrt ;;
    fuzz_mesh_*) words=mesh ;;
    fuzz_spec) words=spec ;;
    fuzz_safetensors | fuzz_npy | fuzz_model* | fuzz_dataset | fuzz_dictionary | fuzz_hyper) words=tensors ;;
    *) return ;;
    esac
    echo "-dict=fuzz/dictionaries/$words.dict"
}

[ $# != 0 ] || set -- fuzz/fuzz_*.c
names=
for target; do names="$names $(basename "$target" .c) seed_$(basename "$target" .c)"; done
# shellcheck disable=SC2086 # a list of names
cmake --build build-fuzz --target $names
for target; do
    name=$(basename "$target" .c)
    corpus=build-fuzz/corpus/$name
    mkdir -p "$corpus"
    "build-fuzz/tests/seed_$name" --seed "$corpus/seed"
    echo "== $name, $seconds s"
    # Inputs that declare huge sizes must fail without large allocations: 256 MB is far more than a valid input needs.
    # shellcheck disable=SC2046 # no option without a dictionary
    OMP_NUM_THREADS=1 "build-fuzz/tests/$name" $(dictionary "$name") -max_total_time="$seconds" -max_len=32768 -malloc_limit_mb=256 \
        -artifact_prefix=build-fuzz/ -print_final_stats=1 -verbosity=1 "$corpus" 2>build-fuzz/"$name".log || {
        tail -n 40 build-fuzz/"$name".log
        exit 1
    }
    grep -E '^stat::number_of_executed_units|^Done' build-fuzz/"$name".log
done
