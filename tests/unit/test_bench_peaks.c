/* SPDX-License-Identifier: MIT
 *
 * Meters of the machine's peaks: there are figures, they are plausible against each other, rows are settled as documented.
 * How fast anything is, is nobody's promise.
 */
#include "bench/inside.h"
#include "support/check.h"

#include <math.h>

static nqm_bench *tiny(void) {
    nqm_bench_options options = nqm_bench_options_default();
    options.rounds = 2;
    options.round_s = 1e-4;
    options.memory_mb = 2;
    nqm_bench *bench;
    assert_int_equal(nqm_bench_create(&options, &bench, NULL), NQM_OK);
    return bench;
}

static void test_every_table_has_a_peak(void **state) {
    (void)state;
    nqm_bench *bench = tiny();
    for (size_t i = 0; nqm_kernels_name(i); ++i) {
        assert_int_equal(nqm_kernels_select(nqm_kernels_name(i), NULL), NQM_OK);
        int f32 = nqm_bench_peak_meter(bench, NQM_PRECISION_F32),
            bf16 = nqm_bench_peak_meter(bench, NQM_PRECISION_BF16);
        assert_true(f32 >= 0 && bf16 >= 0);
        assert_true(bench->meter[f32].best > 0 && isfinite(bench->meter[f32].best));
        assert_int_equal(nqm_bench_peak_meter(bench, NQM_PRECISION_F32), f32); /* made once */
    }
    assert_int_equal(nqm_kernels_select(NULL, NULL), NQM_OK);
    nqm_bench_free(bench);
}

static void test_reading(void **state) {
    (void)state;
    nqm_bench *bench = tiny();
    int meter = nqm_bench_read_meter(bench, 100000, 1);
    assert_true(bench->meter[meter].best > 0 && isfinite(bench->meter[meter].best));
    assert_true(bench->meter[meter].best >= nqm_bench_meter_median(&bench->meter[meter]));
    size_t n_before = bench->meter[meter].n_samples;
    nqm_bench_release_memory(bench);
    nqm_bench_sample(bench, meter); /* nothing to read: no sample */
    assert_int_equal(bench->meter[meter].n_samples, n_before);
    assert_int_equal(nqm_bench_read_meter(bench, 100, 1), NQM_METER_NONE);
    nqm_bench_free(bench);
}

static size_t n_calls;

static void count_call(void *user) {
    (void)user;
    ++n_calls;
}

static void test_race_and_rows(void **state) {
    (void)state;
    nqm_bench *bench = tiny();
    nqm_bench_entry entries[2] = {nqm_bench_entry_make("score", "one"), nqm_bench_entry_make("score", "two")};
    nqm_bench_entry_work(bench, &entries[0], NQM_PRECISION_F32, 1e6);
    nqm_bench_entry_reading(bench, &entries[0], 1000000);
    entries[0].row.batch = 4;
    const nqm_contender contenders[2] = {{count_call, NULL}, {count_call, NULL}};
    assert_int_equal(nqm_bench_race(bench, 2, contenders, entries, NULL), NQM_OK);
    assert_true(n_calls >= 6); /* two rounds and a warm call each */
    assert_int_equal(nqm_bench_finish(bench, NULL), NQM_OK);
    nqm_bench_row r = nqm_bench_get_row(bench, 0);
    assert_int_equal(r.rounds, 2);
    assert_true(r.seconds > 0 && r.seconds <= r.seconds_median && r.seconds_median <= r.seconds_worst);
    double arithmetic = 1e-3 / r.peak_gflops, reading = 1e-3 / r.peak_gb_per_s;
    assert_near(r.floor_seconds, fmax(arithmetic, reading), 1e-12 * r.floor_seconds);
    assert_near(r.ratio * r.times_floor, 1, 1e-12);
    assert_near(r.ratio, r.floor_seconds / r.seconds, 1e-12 * r.ratio);
    assert_near(r.ms_per_pair, 250 * r.seconds, 1e-12 * r.ms_per_pair);
    nqm_bench_row other = nqm_bench_get_row(bench, 1);
    assert_true(isnan(other.ratio) && isnan(other.gflops) && other.seconds > 0);
    size_t n_peaks = 0;
    for (size_t i = 2; i < nqm_bench_count(bench); ++i) {
        assert_string_equal(nqm_bench_get_row(bench, i).bench, "peak");
        ++n_peaks;
    }
    assert_int_equal(n_peaks, bench->n_meters);
    nqm_bench_free(bench);
}

static int stop(void *user, const char *stage, double done, double total) {
    (void)user, (void)stage, (void)done, (void)total;
    return 1;
}

static void test_refusals(void **state) {
    (void)state;
    nqm_bench *bench;
    nqm_error err = {0};
    nqm_bench_options options = nqm_bench_options_default();
    options.memory_mb = 1;
    options.rounds = 0;
    assert_int_equal(nqm_bench_create(&options, &bench, &err), NQM_ERR_ARG);
    assert_null(bench);
    options.rounds = 1;
    options.precisions = 8;
    assert_int_equal(nqm_bench_create(&options, &bench, &err), NQM_ERR_ARG);
    options.precisions = 1;
    options.quick = 1;
    options.progress = stop;
    assert_int_equal(nqm_bench_create(&options, &bench, &err), NQM_OK);
    assert_int_equal(nqm_bench_gemm(bench, &err), NQM_ERR_CANCELLED);
    nqm_bench_free(bench);
    nqm_bench_free(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_table_has_a_peak), cmocka_unit_test(test_reading),
                                       cmocka_unit_test(test_race_and_rows), cmocka_unit_test(test_refusals)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
