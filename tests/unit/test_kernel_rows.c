/* SPDX-License-Identifier: MIT
 *
 * The kernels for rows of every table that this processor supports against the plain loops: hidden layers, Adam, logarithms, dot
 * products and whitening.
 */
#include "kernel/kernel.h"
#include "support/check.h"

static const uint64_t seed = 17;

enum { N = 501 };

/* The results of the forward and backward pass of one hidden row with one kernel table. */
typedef struct row_result {
    float x[N], y[N], slope[N], dy[N], dbias[N], dgamma[N], dbeta[N], rstd;
} row_result;

static void run_row(const nqm_kernels *kernels, const float *x, const float *layer, double p, row_result *r) {
    *r = (row_result){.rstd = 0};
    memcpy(r->x, x, sizeof r->x);
    memcpy(r->dy, layer + 3 * N, sizeof r->dy);
    kernels->hidden_row(&(nqm_hidden_row){.n = N,
                                          .bias = layer,
                                          .gamma = layer + N,
                                          .beta = layer + 2 * N,
                                          .x = r->x,
                                          .y = r->y,
                                          .slope = r->slope,
                                          .rstd = &r->rstd,
                                          .p = p,
                                          .key = 5,
                                          .counter = 77});
    kernels->hidden_row_back(
        &(nqm_hidden_row_back){N, layer + N, r->x, r->slope, r->rstd, r->dy, r->dbias, r->dgamma, r->dbeta});
}

static void check_close(const char *what, const float *actual, const float *expected) {
    double largest = 0, worst = 0;
    for (size_t i = 0; i < N; ++i) {
        largest = fmax(largest, fabs((double)expected[i]));
        worst = fmax(worst, fabs((double)actual[i] - (double)expected[i]));
    }
    if (!(worst <= 2e-6 * largest))
        print_error("%s: %g of %g\n", what, worst, largest);
    assert_true(worst <= 2e-6 * largest);
}

TEST(rows_of_every_table) {
    nqm_rng rng = nqm_rng_make(seed, 4);
    float *x = random_block(&rng, N), *layer = random_block(&rng, 4 * N);
    for (int dropout = 0; dropout < 2; ++dropout) {
        static row_result expected, actual, first;
        run_row(&nqm_kernels_scalar, x, layer, dropout ? 0.3 : 0, &expected);
        run_row(nqm_kernels_at(0), x, layer, dropout ? 0.3 : 0, &first);
        for (size_t t = 0; nqm_kernels_at(t) != &nqm_kernels_scalar; ++t) {
            run_row(nqm_kernels_at(t), x, layer, dropout ? 0.3 : 0, &actual);
            assert_memory_equal(&actual, &first, sizeof actual);
            check_close("xhat", actual.x, expected.x);
            check_close("y", actual.y, expected.y);
            check_close("slope", actual.slope, expected.slope);
            check_close("dy", actual.dy, expected.dy);
            check_close("dbias", actual.dbias, expected.dbias);
            check_close("dgamma", actual.dgamma, expected.dgamma);
            check_close("dbeta", actual.dbeta, expected.dbeta);
        }
    }
    nqm_free(x);
    nqm_free(layer);
}

TEST(adam_of_every_table) {
    nqm_rng rng = nqm_rng_make(seed, 5);
    float *start = random_block(&rng, N), *grad = random_block(&rng, N);
    static float moments[2][2][N], first[N], param[2][N];
    for (size_t t = 0; nqm_kernels_at(t) != &nqm_kernels_scalar; ++t) {
        const nqm_kernels *tables[] = {&nqm_kernels_scalar, nqm_kernels_at(t)};
        memset(moments, 0, sizeof moments);
        for (size_t which = 0; which < 2; ++which) {
            memcpy(param[which], start, sizeof param[which]);
            for (uint64_t step = 1; step <= 5; ++step) {
                const nqm_adam_rate rate = nqm_adam_rate_at(1e-3, 1e-2, step);
                tables[which]->adam(N, &rate, grad, moments[which][0], moments[which][1], param[which]);
            }
        }
        check_close("parameters", param[1], param[0]);
        check_close("second moments", moments[1][1], moments[0][1]);
        if (t == 0)
            memcpy(first, param[1], sizeof first);
        assert_memory_equal(param[1], first, sizeof first);
    }
    nqm_free(start);
    nqm_free(grad);
}

TEST(dots_of_every_table) {
    nqm_rng rng = nqm_rng_make(seed, 13);
    float *x = random_block(&rng, N), *y = random_block(&rng, N);
    static const size_t sizes[] = {1, 7, 31, 32, 33, 64, N};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; ++s)
        for (size_t k = 0; nqm_kernels_at(k); ++k) {
            double sum = 0, size = 0;
            for (size_t i = 0; i < sizes[s]; ++i) {
                sum += (double)x[i] * (double)y[i];
                size += fabs((double)x[i] * (double)y[i]);
            }
            const float actual = nqm_kernels_at(k)->dot(sizes[s], x, y), first = nqm_kernels_at(0)->dot(sizes[s], x, y);
            assert_near((double)actual, sum, 2e-6 * size);
            assert_true(actual == first || nqm_kernels_at(k) == &nqm_kernels_scalar);
        }
    nqm_free(x);
    nqm_free(y);
}
