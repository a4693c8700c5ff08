/* SPDX-License-Identifier: MIT
 *
 * Measurement of the machine's peak rates, and alternating timings: values exist and are finite, and a longer run has a
 * longer time. No test requires a speed.
 */
#include "bench/bench.h"
#include "support/check.h"

static nqm_bench *tiny(void) {
    nqm_bench_options options = nqm_bench_options_default();
    options.quick = 1;
    nqm_bench *bench;
    assert_int_equal(nqm_bench_create(&options, &bench, NULL), NQM_OK);
    return bench;
}

TEST(test_every_unit_has_a_peak) {
    nqm_bench *bench = tiny();
    size_t n_available = 0, n_metered = 0;
    for (const nqm_bench_unit *unit = nqm_bench_units; unit->name; ++unit)
        n_available += nqm_bench_has_unit(unit);
    for (int i = 0; i < bench->n_meters; ++i) {
        n_metered += bench->meter[i].unit != NULL;
        assert_true(bench->meter[i].best > 0 && isfinite(bench->meter[i].best));
    }
    assert_true(n_available > 0 && n_metered == n_available);
    nqm_bench_free(bench);
}

/* The peak of a precision is that of the quickest unit: not of the one whose name has the precision. */
TEST(test_the_quickest_unit_counts) {
    static const nqm_bench_unit f32 = {.name = "f32", .precision = NQM_PRECISION_F32},
                                slow = {.name = "slow", .precision = NQM_PRECISION_BF16},
                                quick = {.name = "quick", .precision = NQM_PRECISION_BF16};
    static nqm_bench bench = {
        .n_meters = 2,
        .meter = {{.unit = &f32, .sample = {300}, .n_samples = 1}, {.unit = &slow, .sample = {150}, .n_samples = 1}}};
    assert_int_equal(nqm_bench_peak_meter(&bench, NQM_PRECISION_F32), 0);
    assert_int_equal(nqm_bench_peak_meter(&bench, NQM_PRECISION_BF16), 0);
    bench.meter[bench.n_meters++] = (nqm_bench_meter){.unit = &quick, .sample = {4800}, .n_samples = 1};
    assert_int_equal(nqm_bench_peak_meter(&bench, NQM_PRECISION_F32), 0);
    assert_int_equal(nqm_bench_peak_meter(&bench, NQM_PRECISION_BF16), 2);
}

TEST(test_reading) {
    nqm_bench *bench = tiny();
    int meter = nqm_bench_read_meter(bench, 100000);
    assert_true(bench->meter[meter].best > 0 && isfinite(bench->meter[meter].best));
    assert_true(nqm_bench_meter_peak(&bench->meter[meter]) == bench->meter[meter].best);
    size_t n_before = bench->meter[meter].n_samples;
    nqm_bench_release_memory(bench);
    nqm_bench_sample(bench, meter); /* without the meter's array there is no sample */
    assert_int_equal(bench->meter[meter].n_samples, n_before);
    assert_int_equal(nqm_bench_read_meter(bench, 100), NQM_METER_NONE);
    nqm_bench_free(bench);
}

static void spin(double seconds) {
    for (double begin = nqm_clock_s(); nqm_clock_s() - begin < seconds;)
        ;
}

static void run_short(void *user) {
    ++*(size_t *)user;
    spin(1e-3);
}

static void run_long(void *user) {
    ++*(size_t *)user;
    spin(10e-3);
}

static double number(const json_t *row, const char *key) {
    const json_t *value = json_object_get(row, key);
    assert_non_null(value);
    return json_number_value(value);
}

/* A run that takes 10 times as long must have more seconds, a lower rate, and a lower fraction of its limit. Rows keep
 * the order of the entries. The factor of 10 tolerates the load of other programs. */
TEST(test_race) {
    nqm_bench *bench = tiny();
    size_t n_short = 0, n_long = 0;
    bench->options.rounds = 8; /* on a busy machine, most short runs are interrupted */
    nqm_bench_entry entries[2] = {nqm_bench_entry_make("score", "short", run_short, &n_short),
                                  nqm_bench_entry_make("score", "long", run_long, &n_long)};
    for (size_t i = 0; i < 2; ++i) {
        nqm_bench_entry_work(bench, &entries[i], NQM_PRECISION_F32, 1e6);
        nqm_bench_entry_reading(bench, &entries[i], 1000000);
        nqm_bench_count(&entries[i], "batch", 4);
    }
    assert_int_equal(nqm_bench_race(bench, 2, entries, NULL), NQM_OK);
    assert_true(n_short >= 9 && n_long >= 9); /* a warm-up and the rounds */
    json_t *document = nqm_bench_finish(bench), *rows = json_object_get(document, "rows");
    const json_t *a = json_array_get(rows, 0), *b = json_array_get(rows, 1);
    assert_string_equal(json_string_value(json_object_get(a, "name")), "short");
    assert_string_equal(json_string_value(json_object_get(b, "name")), "long");
    assert_true(number(a, "seconds") >= 1e-3 && number(b, "seconds") >= 10e-3);
    assert_true(number(a, "seconds") <= number(a, "seconds_median"));
    static const char *const rising[] = {"seconds", "ms_per_pair", "times_floor"};
    static const char *const falling[] = {"gflops", "gb_per_s", "ratio"};
    for (size_t i = 0; i < 3; ++i) {
        assert_true(number(b, rising[i]) > 2 * number(a, rising[i]));
        assert_true(number(b, falling[i]) < number(a, falling[i]) / 2 && number(b, falling[i]) > 0);
    }
    assert_true(number(a, "ratio") < 1);
    assert_true(json_array_size(rows) > 2);
    for (size_t i = 2; i < json_array_size(rows); ++i)
        assert_string_equal(json_string_value(json_object_get(json_array_get(rows, i), "bench")), "peak");
    assert_true(json_is_string(json_object_get(json_object_get(document, "machine"), "cpu")));
    json_decref(document);
    nqm_bench_free(bench);
}

TEST(test_refusals) {
    nqm_bench *bench;
    nqm_error err = {0};
    nqm_bench_options options = nqm_bench_options_default();
    options.quick = 1;
    options.rounds = 0;
    assert_int_equal(nqm_bench_create(&options, &bench, &err), NQM_ERR_ARG);
    assert_null(bench);
    options.rounds = 1;
    options.precision = 8;
    assert_int_equal(nqm_bench_create(&options, &bench, &err), NQM_ERR_ARG);
    nqm_bench_free(NULL);
}
