/* SPDX-License-Identifier: MIT
 *
 * Comparisons, inputs that must be valid, the kernels in use, and paths of the shared data, for unit tests.
 */
#include "support/check.h"
#include "kernel/kernel.h"

void check_near(double actual, double expected, double tolerance, const char *what, const char *file, int line) {
    if (fabs(actual - expected) <= tolerance)
        return;
    print_error("%s is %.17g, not %.17g +- %g\n", what, actual, expected, tolerance);
    _fail(file, line);
}

void check_relative(double actual, double expected, double tolerance, const char *what, const char *file, int line) {
    check_near(actual, expected, tolerance * fabs(expected), what, file, line);
}

double csv_number(const nqm_csv *csv, size_t row, int column) {
    double value;
    assert_int_equal(nqm_csv_number(csv, row, column, &value, NULL), NQM_OK);
    return value;
}

__attribute__((constructor)) void use_chosen_kernels(void) {
    const char *name = getenv("NQM_KERNELS");
    nqm_error err = {0};
    if (nqm_kernels_select(name && *name ? name : NULL, &err) != NQM_OK) {
        fprintf(stderr, "NQM_KERNELS: %s\n", err.message);
        exit(EXIT_FAILURE);
    }
}

nqm_brdf *must_open(const char *argument) {
    nqm_brdf *brdf;
    nqm_error err = {0};
    if (nqm_brdf_open(argument, &brdf, &err) != NQM_OK)
        fail_msg("%s: %s", argument, err.message);
    return brdf;
}

nqm_error must_refuse(const char *argument, nqm_status status, const char *words) {
    nqm_error err = {0};
    nqm_brdf *brdf = (nqm_brdf *)&err;
    char path[4200], at[32];
    assert_int_equal(nqm_brdf_open(argument, &brdf, &err), status);
    assert_null(brdf);
    assert_int_equal(err.status, status);
    const bool has_path = *argument == '/' && status != NQM_ERR_IO;
    snprintf(path, sizeof path, "%.*s", has_path ? (int)strcspn(argument, ":") : 0, argument);
    snprintf(at, sizeof at, "byte %lld", (long long)err.byte_offset);
    const bool has_byte = status == NQM_ERR_FORMAT && err.byte_offset >= 0;
    if (!strstr(err.message, path) || !strstr(err.message, words) || (has_byte && !strstr(err.message, at)))
        fail_msg("message without '%s', '%s' or '%s': %s", path, words, has_byte ? at : "", err.message);
    assert_int_equal(nqm_brdf_open(argument, &brdf, NULL), status);
    return err;
}

size_t check_brdf_values(const nqm_brdf *brdf, size_t n, const double (*pair)[6], const double (*value)[3],
                         double tolerance) {
    size_t n_clamped = 0;
    for (size_t i = 0; i < n; ++i) {
        double rgb[3];
        uint8_t flag;
        nqm_brdf_eval(brdf, 1, pair[i], pair[i] + 3, rgb, &flag);
        bool clamped = false;
        for (size_t c = 0; c < 3; ++c) {
            clamped = clamped || value[i][c] < 0;
            assert_near(rgb[c], fmax(value[i][c], 0), tolerance * (1 + fabs(value[i][c])));
        }
        assert_int_equal(flag, clamped ? NQM_VALUE_CLAMPED : NQM_VALUE_OK);
        n_clamped += clamped;
    }
    return n_clamped;
}

void free_nothing(void *self) {
    (void)self;
}

const char *shared_data(const char *relative_path) {
    static char path[4096];
    const char *data = getenv("NQM_DATA"), *source = getenv("NQM_SOURCE");
    if (data)
        snprintf(path, sizeof path, "%s/%s", data, relative_path);
    else
        snprintf(path, sizeof path, "%s/../shared/data/%s", source ? source : ".", relative_path);
    return access(path, R_OK) == 0 ? path : NULL;
}

const char *test_vector(const char *name) {
    static char path[4096];
    const char *source = getenv("NQM_SOURCE");
    snprintf(path, sizeof path, "%s/tests/vectors/%s", source ? source : ".", name);
    return path;
}

float *random_block(nqm_rng *rng, size_t n) {
    float *block = nqm_alloc(n, sizeof *block);
    for (size_t i = 0; i < n; ++i)
        block[i] = (float)nqm_rng_normal(rng);
    return block;
}
