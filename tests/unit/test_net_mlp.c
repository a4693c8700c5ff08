/* SPDX-License-Identifier: MIT
 *
 * The network's own promises: gradients by central differences, dropout by its hash, the same bits for one and two
 * threads, stable loss, He-uniform start, refused shapes, failing allocations.
 */
#include "base/memory_test.h"
#include "net/layers.h"
#include "net/net.h"
#include "support/check.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>

static const uint64_t seed = 5;

/* A network in training, on random data. */
typedef struct trainee {
    nqm_net_shape shape;
    size_t batch;
    nqm_params params, grads;
    nqm_adam adam;
    nqm_net_work *work;
    float *x, *target, *z, *dz;
} trainee;

static trainee make_trainee(nqm_net_shape shape, size_t batch) {
    trainee t = {.shape = shape, .batch = batch};
    assert_int_equal(nqm_params_create(&shape, &t.params, NULL), NQM_OK);
    assert_int_equal(nqm_params_create(&shape, &t.grads, NULL), NQM_OK);
    assert_int_equal(nqm_adam_create(&shape, &t.adam, NULL), NQM_OK);
    assert_int_equal(nqm_net_work_create(&shape, batch, true, &t.work, NULL), NQM_OK);
    nqm_params_init(&t.params, seed);
    nqm_rng rng = nqm_rng_make(seed, 100);
    t.x = nqm_alloc(batch * shape.sizes[0], sizeof *t.x);
    for (size_t i = 0; i < batch * shape.sizes[0]; ++i)
        t.x[i] = (float)nqm_rng_normal(&rng);
    t.target = nqm_alloc(batch, sizeof *t.target);
    for (size_t i = 0; i < batch; ++i)
        t.target[i] = (float)nqm_rng_normal(&rng);
    t.z = nqm_alloc(batch, sizeof *t.z);
    t.dz = nqm_alloc(batch, sizeof *t.dz);
    return t;
}

static void free_trainee(trainee *t) {
    nqm_params_free(&t->params);
    nqm_params_free(&t->grads);
    nqm_adam_free(&t->adam);
    nqm_net_work_free(t->work);
    float *blocks[] = {t->x, t->target, t->z, t->dz};
    for (size_t i = 0; i < 4; ++i)
        nqm_free(blocks[i]);
}

static double loss_of(trainee *t, const nqm_dropout *dropout) {
    nqm_net_forward(&t->params, t->work, t->batch, t->x, dropout, t->z);
    return nqm_logcosh_loss(t->batch, t->z, t->target, -2, 2, t->dz);
}

static double train_step(trainee *t, uint64_t step) {
    nqm_dropout dropout = {.p = 0.2, .seed = seed, .step = step};
    double loss = loss_of(t, &dropout);
    nqm_net_backward(&t->params, t->work, t->batch, t->x, t->dz, &t->grads, NULL);
    nqm_adam_step(&t->adam, &t->params, &t->grads, 1e-3, 1e-3, 1e-4, false);
    return loss;
}

/* Along random directions in the space of all parameters. The forward pass rounds to floats, so that a central
 * difference over 2h is good to about 1e-6/h; h = 0.02 balances that with its own error. The derivatives are around
 * 0.03. */
static void gradients_by_differences(void **state) {
    (void)state;
    trainee t = make_trainee((nqm_net_shape){4, {13, 17, 9, 6, 1}}, 20);
    const nqm_dropout dropout = {.p = 0.2, .seed = seed, .step = 3};
    nqm_rng rng = nqm_rng_make(seed, 200);
    const double h = 0.02;
    loss_of(&t, &dropout);
    nqm_net_backward(&t.params, t.work, t.batch, t.x, t.dz, &t.grads, NULL);
    float *start = nqm_alloc(t.params.n, sizeof *start), *u = nqm_alloc(t.params.n, sizeof *u);
    memcpy(start, t.params.block, t.params.n * sizeof *start);
    for (int trial = 0; trial < 20; ++trial) {
        double along = 0, u2 = 0, loss[2];
        for (size_t i = 0; i < t.params.n; ++i) {
            u[i] = (float)nqm_rng_normal(&rng);
            u2 += (double)(u[i] * u[i]);
        }
        for (size_t i = 0; i < t.params.n; ++i) {
            u[i] /= (float)sqrt(u2);
            along += (double)u[i] * (double)t.grads.block[i];
        }
        for (int side = 0; side < 2; ++side) {
            for (size_t i = 0; i < t.params.n; ++i)
                t.params.block[i] = start[i] + (float)(side ? h : -h) * u[i];
            loss[side] = loss_of(&t, &dropout);
        }
        assert_near((loss[1] - loss[0]) / (2 * h), along, 1e-4);
    }
    nqm_free(start);
    nqm_free(u);
    free_trainee(&t);
}

static void same_bits_for_any_threads(void **state) {
    (void)state;
    int threads = omp_get_max_threads();
    nqm_params result[2];
    for (int n = 1; n <= 2; ++n) {
        omp_set_num_threads(n);
        trainee t = make_trainee((nqm_net_shape){4, {2100, 530, 201, 75, 1}}, 290);
        for (uint64_t step = 0; step < 4; ++step)
            train_step(&t, step);
        result[n - 1] = t.params;
        t.params = (nqm_params){0};
        free_trainee(&t);
    }
    omp_set_num_threads(threads);
    assert_memory_equal(result[0].block, result[1].block, result[0].n * sizeof(float));
    nqm_params_free(&result[0]);
    nqm_params_free(&result[1]);
}

static void training_learns(void **state) {
    (void)state;
    trainee t = make_trainee((nqm_net_shape){3, {20, 40, 12, 1}}, 32);
    double first = train_step(&t, 0), last = first;
    for (uint64_t step = 1; step < 300; ++step)
        last = train_step(&t, step);
    assert_true(last < 0.3 * first);
    free_trainee(&t);
}

/* Inference and training without dropout are the same function. */
static void inference_work(void **state) {
    (void)state;
    trainee t = make_trainee((nqm_net_shape){4, {30, 23, 31, 7, 1}}, 9);
    nqm_net_work *work;
    float z[9];
    assert_int_equal(nqm_net_work_create(&t.shape, 9, false, &work, NULL), NQM_OK);
    loss_of(&t, NULL);
    nqm_net_forward(&t.params, work, 9, t.x, NULL, z);
    assert_memory_equal(z, t.z, sizeof z);
    nqm_net_work_free(work);
    free_trainee(&t);
}

/* ---- dropout ----------------------------------------------------------------------------------------------------- */

enum { ROWS = 300, WIDTH = 501 };

/* Which elements one hidden layer kept; every kept one must be scaled by 1/(1-p). */
static void kept_elements(size_t layer_index, const nqm_dropout *dropout, uint8_t *kept) {
    float *block = nqm_alloc(4 * WIDTH + 5 * ROWS * WIDTH, sizeof *block);
    nqm_layer layer = {.b = block, .gamma = block + WIDTH, .beta = block + 2 * WIDTH};
    float *buffer = block + 4 * WIDTH;
    nqm_hidden h = {.index = layer_index, .n = WIDTH, .layer = &layer, .xhat = buffer};
    h.y = buffer + ROWS * WIDTH, h.slope = buffer + 2 * ROWS * WIDTH, h.rstd = buffer + 4 * ROWS * WIDTH;
    float *plain = buffer + 3 * ROWS * WIDTH;
    for (size_t pass = 0; pass < 2; ++pass) {
        nqm_rng rng = nqm_rng_make(seed, 300);
        for (size_t i = 0; i < ROWS * WIDTH; ++i)
            h.xhat[i] = (float)nqm_rng_normal(&rng);
        for (size_t i = 0; i < WIDTH; ++i)
            layer.gamma[i] = 1;
        nqm_hidden_forward(&h, ROWS, pass == 0 ? NULL : dropout);
        if (pass == 0)
            memcpy(plain, h.y, ROWS * WIDTH * sizeof *plain);
    }
    for (size_t i = 0; i < ROWS * WIDTH; ++i) {
        kept[i] = h.y[i] != 0.0f;
        if (kept[i])
            assert_relative((double)h.y[i], (double)plain[i] / (1 - dropout->p), 1e-6);
    }
    nqm_free(block);
}

static double fraction(const uint8_t *kept, const uint8_t *also) {
    double sum = 0;
    for (size_t i = 0; i < ROWS * WIDTH; ++i)
        sum += kept[i] && also[i];
    return sum / (ROWS * WIDTH);
}

static void dropout_by_hash(void **state) {
    (void)state;
    static uint8_t kept[4][ROWS * WIDTH], again[ROWS * WIDTH];
    const double p = 0.3, sigma = sqrt(p * (1 - p) / (ROWS * WIDTH));
    const nqm_dropout variants[] = {
        {.p = p, .seed = 1, .step = 1}, {.p = p, .seed = 1, .step = 2}, {.p = p, .seed = 2, .step = 1}};
    for (size_t i = 0; i < 3; ++i)
        kept_elements(0, &variants[i], kept[i]);
    kept_elements(1, &variants[0], kept[3]);
    kept_elements(0, &variants[0], again);
    assert_memory_equal(kept[0], again, sizeof again);
    for (size_t i = 0; i < 4; ++i) {
        assert_near(fraction(kept[i], kept[i]), 1 - p, 5 * sigma);
        for (size_t k = 0; k < i; ++k) /* step, seed and layer give independent masks */
            assert_near(fraction(kept[i], kept[k]), (1 - p) * (1 - p), 5 * sigma);
    }
    for (size_t lag = 1; lag <= 4; ++lag) { /* so do neighbours, which share a hash, and rows */
        double both = 0, below = 0;
        for (size_t i = 0; i + lag * WIDTH < ROWS * WIDTH; ++i) {
            both += kept[0][i] && kept[0][i + lag];
            below += kept[0][i] && kept[0][i + lag * WIDTH];
        }
        assert_near(both / (ROWS * WIDTH - (double)(lag * WIDTH)), (1 - p) * (1 - p), 5 * sigma);
        assert_near(below / (ROWS * WIDTH - (double)(lag * WIDTH)), (1 - p) * (1 - p), 5 * sigma);
    }
}

/* ---- loss, parameters, refusals ---------------------------------------------------------------------------------- */

static void loss_is_stable(void **state) {
    (void)state;
    /* prediction 0 at z = 0 in a symmetric range; d = -target */
    const float z = 0, targets[] = {0, 1e-3f, 1, 40, 1e6f, -1e6f};
    for (size_t i = 0; i < 6; ++i) {
        float dz;
        double d = fabs((double)targets[i]), expected = d < 30 ? log(cosh(d)) : d - log(2);
        assert_near(nqm_logcosh_loss(1, &z, &targets[i], -3, 3, &dz), expected, 1e-15 + 1e-12 * expected);
        assert_near((double)dz, tanh(-(double)targets[i]) * 6 * 0.25, 1e-6);
    }
    assert_near(nqm_sigmoid(800), 1, 0);
    assert_near(nqm_sigmoid(-800), 0, 0);
    assert_near(nqm_sigmoid(-2), 1 - nqm_sigmoid(2), 2e-16);
}

static void he_uniform_start(void **state) {
    (void)state;
    nqm_params params;
    assert_int_equal(nqm_params_create(&(nqm_net_shape){2, {600, 400, 1}}, &params, NULL), NQM_OK);
    nqm_params_init(&params, seed);
    const nqm_layer *layer = &params.layer[0];
    double limit = sqrt(6.0 / 600), sum = 0, sum2 = 0, largest = 0, n = 600 * 400;
    for (size_t i = 0; i < 600 * 400; ++i) {
        double w = (double)layer->w[i];
        sum += w;
        sum2 += w * w;
        largest = fmax(largest, fabs(w));
    }
    assert_true(largest <= limit && largest > 0.999 * limit);
    assert_near(sum / n, 0, 5 * limit / sqrt(3 * n));
    assert_relative(sum2 / n, limit * limit / 3, 0.01);
    for (size_t i = 0; i < 400; ++i)
        assert_true(layer->b[i] == 0 && layer->gamma[i] == 1 && layer->beta[i] == 0);
    assert_null(params.layer[1].gamma);
    assert_int_equal(params.n, 400 * 603 + 401);
    nqm_params_free(&params);
}

static void refused_shapes(void **state) {
    (void)state;
    const nqm_net_shape bad[] = {
        {0}, {2, {3, 0, 1}}, {1, {3, 2}}, {9, {3, 1, 1, 1, 1, 1, 1, 1, 1}}, {2, {(size_t)1 << 60, 16, 1}}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        nqm_params params;
        nqm_error err = {0};
        assert_int_equal(nqm_params_create(&bad[i], &params, &err), NQM_ERR_ARG);
        assert_null(params.block);
        assert_true(err.message[0] != '\0');
    }
    nqm_net_work *work;
    assert_int_equal(nqm_net_work_create(&(nqm_net_shape){1, {3, 1}}, 0, true, &work, NULL), NQM_ERR_ARG);
    assert_null(work);
}

static void out_of_memory(void **state) {
    (void)state;
    const nqm_net_shape shape = {2, {3, 4, 1}};
    for (long n = 0; n < 2; ++n) {
        nqm_adam adam;
        nqm_net_work *work;
        nqm_alloc_fail_after(n);
        assert_int_equal(nqm_adam_create(&shape, &adam, NULL), NQM_ERR_NOMEM);
        assert_null(adam.m.block);
        nqm_alloc_fail_after(n);
        assert_int_equal(nqm_net_work_create(&shape, 5, true, &work, NULL), NQM_ERR_NOMEM);
        assert_null(work);
    }
    nqm_alloc_fail_after(-1);
}

int main(void) {
    printf("seed %llu\n", (unsigned long long)seed);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gradients_by_differences),
        cmocka_unit_test(same_bits_for_any_threads),
        cmocka_unit_test(training_learns),
        cmocka_unit_test(inference_work),
        cmocka_unit_test(dropout_by_hash),
        cmocka_unit_test(loss_is_stable),
        cmocka_unit_test(he_uniform_start),
        cmocka_unit_test(refused_shapes),
        cmocka_unit_test(out_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
