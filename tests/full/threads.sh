#!/bin/sh
# SPDX-License-Identifier: MIT
# ThreadSanitizer over the tests in which threads share a model, a dataset, a BRDF, the first use of a table or a library that is
# loaded when it is needed. Needs clang, libomp-dev: its library libarcher.so tells the sanitizer what OpenMP waits for; GCC's
# OpenMP would give false reports. Embree is not built with the sanitizer, so that races inside of it are not seen.
set -eu
cd "$(dirname "$0")/../.."
tests="test_base test_base_shared_work test_brdf_create test_brdf_merl test_metric_batch test_metric_scorer test_metric_transport
test_net_inference test_net_trainer test_percept_itp test_render_mesh test_sample_directions test_train_loop"
archer=$(find /usr/lib/llvm-* -name libarcher.so 2>/dev/null | head -n 1)
[ -n "$archer" ] || {
    echo "needs libarcher.so (Debian: libomp-dev)"
    exit 77
}
[ -f build-threads/build.ninja ] || cmake -S . -B build-threads -G Ninja -DCMAKE_C_COMPILER=clang -DNQM_SANITIZE=thread \
    -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG="-O1 -g1" >/dev/null
# program TEST: the program of the room of a file of tests.
program() { echo "$1" | cut -d _ -f 1-2; }
programs=$(for test in $tests; do program "$test"; done | sort -u)
# shellcheck disable=SC2086
cmake --build build-threads --target $programs >build-threads/build.log || {
    cat build-threads/build.log
    exit 1
}
# Threads that OpenMP keeps are no leak. Races that are reported end a test with 66.
export OMP_TOOL_LIBRARIES="$archer" OMP_NUM_THREADS=4 TSAN_OPTIONS="ignore_noninstrumented_modules=1 exitcode=66 history_size=4"
n=0
for test in $tests; do
    build-threads/tests/"$(program "$test")" "$test" >build-threads/"$test".log 2>&1 || {
        echo "$test: $(grep -c 'WARNING: ThreadSanitizer' build-threads/"$test".log) reports; see build-threads/$test.log"
        grep -A 12 'WARNING: ThreadSanitizer' build-threads/"$test".log | head -n 40
        exit 1
    }
    n=$((n + 1))
done
echo "$n test programs with 4 threads under ThreadSanitizer"
