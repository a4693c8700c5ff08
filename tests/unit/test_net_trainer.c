/* SPDX-License-Identifier: MIT
 *
 * Training: gradients against central differences, dropout masks from the hash, equal bits for one and two threads
 * and in both layouts of activations, a stable loss, He-uniform initial weights, refused shapes, failing allocations.
 */
#include "base/memory_test.h"
#include "kernel/kernel.h"
#include "kernel/panel.h"
#include "net/trainer.h"
#include "support/check.h"
#include "support/network_gradients.h"

#include <omp.h>

static const uint64_t seed = 5;

/* A trainer with random parameters and data. */
typedef struct trainee {
    nqm_net_shape shape;
    size_t batch;
    nqm_params params, grads;
    nqm_trainer *trainer;
    float *target, *z, *dz;
} trainee;

static trainee make_trainee_of(nqm_net_shape shape, size_t batch, const nqm_trainer_options *options) {
    trainee t = {.shape = shape, .batch = batch};
    assert_int_equal(nqm_params_create(&shape, &t.params, NULL), NQM_OK);
    assert_int_equal(nqm_params_create(&shape, &t.grads, NULL), NQM_OK);
    assert_int_equal(nqm_trainer_create(&shape, options, &t.trainer, NULL), NQM_OK);
    nqm_params_init(&t.params, seed);
    nqm_trainer_load(t.trainer, &t.params, NULL);
    nqm_rng rng = nqm_rng_make(seed, 100);
    for (size_t i = 0; i < batch; ++i) {
        float *x = nqm_trainer_input(t.trainer, i);
        for (size_t k = 0; k < shape.sizes[0]; ++k)
            x[k] = (float)nqm_rng_normal(&rng);
        if (i % 2 || i + 1 == batch)
            nqm_trainer_inputs_done(t.trainer, i / 2 * 2, 1 + i % 2);
    }
    const size_t n_outputs = shape.sizes[shape.n_layers];
    t.target = nqm_alloc(batch * n_outputs, sizeof *t.target);
    for (size_t i = 0; i < batch * n_outputs; ++i)
        t.target[i] = (float)nqm_rng_normal(&rng);
    t.z = nqm_alloc(batch * n_outputs, sizeof *t.z);
    t.dz = nqm_alloc(batch * n_outputs, sizeof *t.dz);
    return t;
}

static trainee make_trainee(nqm_net_shape shape, size_t batch, nqm_precision precision) {
    return make_trainee_of(shape, batch, &(nqm_trainer_options){.precision = precision, .max_batch = batch});
}

static void free_trainee(trainee *t) {
    nqm_params_free(&t->params);
    nqm_params_free(&t->grads);
    nqm_trainer_free(t->trainer);
    float *blocks[] = {t->target, t->z, t->dz};
    for (size_t i = 0; i < 3; ++i)
        nqm_free(blocks[i]);
}

static double loss_of(trainee *t, const nqm_dropout *dropout) {
    nqm_trainer_forward(t->trainer, t->batch, dropout, t->z);
    static const nqm_output_bounds bounds[] = {{-2, 2, 1}, {-1, 2, 0.5}, {-2, 1, 0.25}};
    return nqm_logcosh_loss(t->batch, t->shape.sizes[t->shape.n_layers], bounds, t->z, t->target, t->dz);
}

static double train_step(trainee *t, uint64_t step) {
    nqm_dropout dropout = {.p = 0.2, .seed = seed, .step = step};
    double loss = loss_of(t, &dropout);
    nqm_trainer_step(t->trainer, t->batch, t->dz, &(nqm_step_rates){1e-3, 1e-3, 1e-4, false});
    return loss;
}

/* Along random directions in the space of all parameters. The forward pass rounds to float, so a central difference
 * over 2h has a rounding error of about 1e-6/h; h = 0.02 balances that with the truncation error. The derivatives are
 * around 0.03. */
static void check_gradients(size_t n_outputs) {
    /* 70 rows: three blocks, whose sums are added */
    trainee t = make_trainee((nqm_net_shape){4, {13, 17, 9, 6, n_outputs}}, 70, NQM_PRECISION_F32);
    const nqm_dropout dropout = {.p = 0.2, .seed = seed, .step = 3};
    nqm_rng rng = nqm_rng_make(seed, 200);
    const double h = 0.02;
    loss_of(&t, &dropout);
    network_gradients(t.trainer, t.batch, t.dz, &t.grads);
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
            nqm_trainer_load(t.trainer, &t.params, NULL);
            loss[side] = loss_of(&t, &dropout);
        }
        assert_near((loss[1] - loss[0]) / (2 * h), along, 1e-4);
    }
    nqm_free(start);
    nqm_free(u);
    free_trainee(&t);
}

TEST(gradients_by_differences) {
    check_gradients(1);
    check_gradients(3);
}

/* The complete state after training: parameters and Adam's moments. */
typedef struct outcome {
    nqm_params params;
    nqm_adam adam;
} outcome;

static outcome outcome_of(const trainee *t) {
    outcome o;
    assert_int_equal(nqm_params_create(&t->shape, &o.params, NULL), NQM_OK);
    assert_int_equal(nqm_adam_create(&t->shape, &o.adam, NULL), NQM_OK);
    nqm_trainer_store(t->trainer, &o.params, &o.adam);
    return o;
}

static void assert_equal_and_free(outcome *a, outcome *b) {
    assert_memory_equal(a->params.block, b->params.block, a->params.n * sizeof(float));
    assert_memory_equal(a->adam.m.block, b->adam.m.block, a->params.n * sizeof(float));
    assert_memory_equal(a->adam.v.block, b->adam.v.block, a->params.n * sizeof(float));
    assert_int_equal(a->adam.step, b->adam.step);
    for (size_t i = 0; i < 2; ++i) {
        nqm_params_free(&(i ? a : b)->params);
        nqm_adam_free(&(i ? a : b)->adam);
    }
}

static const nqm_net_shape large = {4, {2100, 530, 201, 75, 3}};

static outcome trained(nqm_precision precision, int threads, const nqm_kernels *kernels) {
    int before = omp_get_max_threads();
    omp_set_num_threads(threads);
    nqm_kernels_use(kernels);
    trainee t = make_trainee(large, 290, precision);
    for (uint64_t step = 0; step < 4; ++step)
        train_step(&t, step);
    outcome o = outcome_of(&t);
    free_trainee(&t);
    use_chosen_kernels();
    omp_set_num_threads(before);
    return o;
}

TEST(same_bits_for_any_threads) {
    for (int precision = NQM_PRECISION_F32; precision <= NQM_PRECISION_BF16; ++precision) {
        outcome one = trained((nqm_precision)precision, 1, NULL), two = trained((nqm_precision)precision, 2, NULL);
        assert_equal_and_free(&one, &two);
    }
}

#if defined __x86_64__
/* AVX2 and AVX-512 do the same operations on each element. */
TEST(same_bits_on_wider_vectors) {
    if (nqm_kernels_at(0) == &nqm_kernels_generic || nqm_kernels_at(0) == &nqm_kernels_avx2)
        skip();
    outcome narrow = trained(NQM_PRECISION_F32, 2, &nqm_kernels_avx2), wide = trained(NQM_PRECISION_F32, 2, NULL);
    assert_equal_and_free(&narrow, &wide);
}
#endif

/* Training continued by a new trainer from the stored state. */
TEST(stopped_and_resumed) {
    const nqm_net_shape shape = {4, {50, 40, 33, 7, 1}};
    for (int precision = NQM_PRECISION_F32; precision <= NQM_PRECISION_BF16; ++precision) {
        trainee whole = make_trainee(shape, 20, (nqm_precision)precision);
        trainee resumed = make_trainee(shape, 20, (nqm_precision)precision);
        for (uint64_t step = 0; step < 6; ++step) {
            train_step(&whole, step);
            if (step == 2) {
                outcome half = outcome_of(&whole);
                nqm_trainer_load(resumed.trainer, &half.params, &half.adam);
                outcome again = outcome_of(&resumed);
                assert_equal_and_free(&half, &again);
            }
            if (step > 2)
                train_step(&resumed, step);
        }
        outcome a = outcome_of(&whole), b = outcome_of(&resumed);
        assert_equal_and_free(&a, &b);
        free_trainee(&whole);
        free_trainee(&resumed);
    }
}

TEST(training_learns) {
    for (int precision = NQM_PRECISION_F32; precision <= NQM_PRECISION_BF16; ++precision) {
        trainee t = make_trainee((nqm_net_shape){3, {20, 40, 12, 1}}, 32, (nqm_precision)precision);
        double first = train_step(&t, 0), last = first;
        for (uint64_t step = 1; step < 300; ++step)
            last = train_step(&t, step);
        assert_true(last < 0.3 * first);
        free_trainee(&t);
    }
}

/* In bfloat16, outputs and gradients differ from those in float only by the rounding of factors to 8 bits. */
static void check_bfloat16(const nqm_kernels *kernels) {
    const nqm_net_shape shape = {4, {300, 120, 70, 33, 1}};
    trainee t[2] = {make_trainee(shape, 33, NQM_PRECISION_F32), make_trainee(shape, 33, NQM_PRECISION_BF16)};
    nqm_kernels_use(kernels);
    for (size_t i = 0; i < 2; ++i) {
        loss_of(&t[i], NULL);
        network_gradients(t[i].trainer, t[i].batch, t[i].dz, &t[i].grads);
    }
    double difference = 0, size = 0;
    for (size_t i = 0; i < t[0].grads.n; ++i) {
        double d = (double)t[1].grads.block[i] - (double)t[0].grads.block[i];
        difference += d * d;
        size += (double)t[0].grads.block[i] * (double)t[0].grads.block[i];
    }
    print_message("gradient of bf16 differs by %.2g of its norm\n", sqrt(difference / size));
    assert_true(difference > 0 && sqrt(difference / size) < 0.03);
    for (size_t i = 0; i < t[0].batch; ++i)
        assert_near((double)t[1].z[i], (double)t[0].z[i], 0.05);
    free_trainee(&t[0]);
    free_trainee(&t[1]);
    use_chosen_kernels();
}

TEST(bfloat16_near_float) {
    for (size_t t = 0; nqm_kernels_at(t); ++t)
        check_bfloat16(nqm_kernels_at(t));
}

/* ---- dropout ----------------------------------------------------------------------------------------------------- */

enum { ROWS = 300, WIDTH = 501 };

/* Which elements the hidden layers kept; every kept one must be scaled by 1/(1-p). */
static void kept_elements(size_t layer_index, const nqm_dropout *dropout, uint8_t *kept) {
    static float x[WIDTH], y[WIDTH], slope[WIDTH], plain[WIDTH], layer[3 * WIDTH];
    for (size_t i = 0; i < WIDTH; ++i)
        layer[WIDTH + i] = 1;
    for (size_t row = 0; row < ROWS; ++row) {
        for (int pass = 0; pass < 2; ++pass) {
            nqm_rng rng = nqm_rng_make(seed, 300 + row);
            for (size_t i = 0; i < WIDTH; ++i)
                x[i] = (float)nqm_rng_normal(&rng);
            nqm_hidden_row r = {.n = WIDTH, .bias = layer, .gamma = layer + WIDTH, .beta = layer + 2 * WIDTH, .x = x};
            r.y = pass ? y : plain, r.slope = slope;
            if (pass)
                nqm_dropout_of_row(dropout, layer_index, row, WIDTH, &r);
            nqm_kernels_get()->hidden_row(&r);
        }
        for (size_t i = 0; i < WIDTH; ++i) {
            kept[row * WIDTH + i] = y[i] != 0.0f;
            if (y[i] != 0.0f)
                assert_relative((double)y[i], (double)plain[i] / (1 - dropout->p), 1e-6);
        }
    }
}

static double fraction(const uint8_t *kept, const uint8_t *also) {
    double sum = 0;
    for (size_t i = 0; i < ROWS * WIDTH; ++i)
        sum += kept[i] && also[i];
    return sum / (ROWS * WIDTH);
}

TEST(dropout_by_hash) {
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
    for (size_t lag = 1; lag <= 4; ++lag) { /* neighbours, which use the same hash, and rows are independent too */
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

TEST(loss_is_stable) {
    /* prediction 0 at z = 0 in a symmetric range; d = -target */
    const float z = 0, targets[] = {0, 1e-3f, 1, 40, 1e6f, -1e6f};
    for (size_t i = 0; i < 6; ++i) {
        float dz;
        double d = fabs((double)targets[i]), expected = d < 30 ? log(cosh(d)) : d - log(2);
        assert_near(nqm_logcosh_loss(1, 1, &(nqm_output_bounds){-3, 3, 1}, &z, &targets[i], &dz), expected,
                    1e-15 + 1e-12 * expected);
        assert_near((double)dz, tanh(-(double)targets[i]) * 6 * 0.25, 1e-6);
    }
    assert_near(nqm_sigmoid(800), 1, 0);
    assert_near(nqm_sigmoid(-800), 0, 0);
    assert_near(nqm_sigmoid(-2), 1 - nqm_sigmoid(2), 2e-16);
}

TEST(he_uniform_start) {
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

TEST(refused_shapes) {
    const nqm_net_shape bad[] = {
        {0}, {2, {3, 0, 1}}, {1, {3, 2}}, {9, {3, 1, 1, 1, 1, 1, 1, 1, 1}}, {2, {(size_t)1 << 60, 16, 1}}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        nqm_params params;
        nqm_error err = {0};
        assert_int_equal(nqm_params_create(&bad[i], &params, &err), NQM_ERR_ARG);
        assert_null(params.block);
        assert_true(err.message[0] != '\0');
    }
    const nqm_net_shape shape = {1, {3, 1}};
    const nqm_trainer_options refused[] = {{.max_batch = 0}, {.precision = NQM_PRECISION_COUNT, .max_batch = 1}};
    for (size_t i = 0; i < 2; ++i) {
        nqm_trainer *trainer;
        assert_int_equal(nqm_trainer_create(&shape, &refused[i], &trainer, NULL), NQM_ERR_ARG);
        assert_null(trainer);
    }
}

TEST(out_of_memory) {
    const nqm_net_shape shape = {2, {3, 4, 1}};
    const nqm_trainer_options options = {.precision = NQM_PRECISION_BF16, .max_batch = 5};
    long n = 0;
    for (nqm_status status = NQM_ERR_NOMEM; status != NQM_OK; ++n) {
        nqm_trainer *trainer;
        nqm_alloc_fail_after(n);
        status = nqm_trainer_create(&shape, &options, &trainer, NULL);
        assert_true(status == NQM_OK ? trainer != NULL : status == NQM_ERR_NOMEM && !trainer);
        nqm_alloc_fail_after(-1);
        nqm_trainer_free(trainer);
    }
    assert_true(n > 6); /* the trainer, its arrays and four matrices in panels */
    nqm_adam adam;
    nqm_alloc_fail_after(1);
    assert_int_equal(nqm_adam_create(&shape, &adam, NULL), NQM_ERR_NOMEM);
    assert_null(adam.m.block);
    nqm_alloc_fail_after(-1);
}
