/* SPDX-License-Identifier: MIT
 *
 * The network against PyTorch (tests/vectors/net.py): forward pass, loss, every gradient tensor, ten Adam steps,
 * without dropout, with given masks and with the first LayerNorm frozen; the learning-rate schedule; the parameter
 * count. Each tensor must agree to 1e-5, relative to its norm and to its largest
 * value.
 */
#include "kernel/panel.h"
#include "net/input_gradient.h"
#include "net/trainer.h"
#include "support/check.h"
#include "support/network_gradients.h"
#include "support/vectors.h"

enum { BATCH = 12, STEPS = 10, INPUTS = 30, N_LAYERS = 4 };
static const nqm_net_shape shape = {N_LAYERS, {INPUTS, 16, 11, 8, 1}};
static const double dropout_p = 0.2, lo = -2.5, hi = 1.25;
static const double lr_first = 1e-3, lr_deeper = 1e-2, weight_decay = 1e-2;

static float x[BATCH * INPUTS], target[BATCH];

/* ---- the stored vectors ------------------------------------------------------------------------------------------ */

static void get(const char *name, size_t n_bytes, void *to) {
    get_vector("net.safetensors", name, n_bytes, to);
}

static void get_floats(const char *name, size_t n, float *out) {
    get(name, n * sizeof *out, out);
}

static void get_doubles(const char *name, size_t n, double *out) {
    get(name, n * sizeof *out, out);
}

static void compare(const char *name, size_t n, const float *actual) {
    double *expected = nqm_alloc(n, sizeof *expected);
    get_doubles(name, n, expected);
    double difference2 = 0, norm2 = 0, largest = 0, largest_difference = 0;
    for (size_t i = 0; i < n; ++i) {
        double difference = (double)actual[i] - expected[i];
        difference2 += difference * difference;
        norm2 += expected[i] * expected[i];
        largest = fmax(largest, fabs(expected[i]));
        largest_difference = fmax(largest_difference, fabs(difference));
    }
    nqm_free(expected);
    bool agrees = sqrt(difference2) <= 1e-5 * sqrt(norm2) && largest_difference <= 1e-5 * largest;
    if (!agrees)
        print_error("%s: norm-wise %.3g, max-wise %.3g\n", name, sqrt(difference2 / norm2),
                    largest_difference / largest);
    assert_true(agrees);
}

/* Call a function for every parameter tensor with its full name and its view in `params`. */
static void each_tensor(const char *prefix, const nqm_params *params, void (*visit)(const char *, size_t, float *)) {
    static const char *const suffixes[] = {"weight", "bias", "norm.weight", "norm.bias"};
    for (size_t l = 0; l < N_LAYERS; ++l) {
        const nqm_layer *layer = &params->layer[l];
        float *const parts[] = {layer->w, layer->b, layer->gamma, layer->beta};
        for (size_t i = 0; i < 4 && parts[i]; ++i) {
            char name[80];
            snprintf(name, sizeof name, "%slayers.%zu.%s", prefix, l, suffixes[i]);
            visit(name, shape.sizes[l + 1] * (i == 0 ? shape.sizes[l] : 1), parts[i]);
        }
    }
}

static void compare_tensor(const char *name, size_t n, float *values) {
    compare(name, n, values);
}

/* ---- one network under test -------------------------------------------------------------------------------------- */

typedef struct fixture {
    nqm_params params, grads;
    nqm_trainer *trainer;
    nqm_dropout dropout;
    uint8_t *masks[N_LAYERS - 1]; /* (steps, batch, width) */
} fixture;

static int make_fixture(void **state) {
    fixture *f = nqm_alloc(1, sizeof *f);
    assert_int_equal(nqm_params_create(&shape, &f->params, NULL), NQM_OK);
    assert_int_equal(nqm_params_create(&shape, &f->grads, NULL), NQM_OK);
    const nqm_trainer_options options = {.max_batch = BATCH};
    assert_int_equal(nqm_trainer_create(&shape, &options, &f->trainer, NULL), NQM_OK);
    each_tensor("start.", &f->params, get_floats);
    nqm_trainer_load(f->trainer, &f->params, NULL);
    f->dropout.p = dropout_p;
    for (size_t l = 0; l + 1 < N_LAYERS; ++l) {
        char name[32];
        snprintf(name, sizeof name, "masks.%zu", l);
        size_t n = STEPS * BATCH * shape.sizes[l + 1];
        f->masks[l] = nqm_alloc(n, 1);
        get(name, n, f->masks[l]);
    }
    *state = f;
    return 0;
}

static int free_fixture(void **state) {
    fixture *f = *state;
    for (size_t l = 0; l + 1 < N_LAYERS; ++l)
        nqm_free(f->masks[l]);
    nqm_params_free(&f->params);
    nqm_params_free(&f->grads);
    nqm_trainer_free(f->trainer);
    nqm_free(f);
    use_chosen_kernels();
    return 0;
}

static const nqm_dropout *masks_of_step(fixture *f, size_t step) {
    for (size_t l = 0; l + 1 < N_LAYERS; ++l)
        f->dropout.given[l] = f->masks[l] + step * BATCH * shape.sizes[l + 1];
    return &f->dropout;
}

/* Loss of a batch; dz (BATCH) receives its gradient. */
static double loss_of(fixture *f, const nqm_dropout *dropout, float *z, float *dz) {
    for (size_t i = 0; i < BATCH; ++i) {
        memcpy(nqm_trainer_input(f->trainer, i), x + i * INPUTS, INPUTS * sizeof *x);
        if (i % 2 || i + 1 == BATCH)
            nqm_trainer_inputs_done(f->trainer, i / 2 * 2, 1 + i % 2);
    }
    nqm_trainer_forward(f->trainer, BATCH, dropout, z);
    return nqm_logcosh_loss(BATCH, 1, &(nqm_output_bounds){lo, hi, 1}, z, target, dz);
}

static void check_one_pass(fixture *f, const char *kind, const nqm_dropout *dropout) {
    float z[BATCH], dz[BATCH];
    double loss = loss_of(f, dropout, z, dz), expected;
    network_gradients(f->trainer, BATCH, dz, &f->grads);
    char name[64];
    snprintf(name, sizeof name, "%s.loss", kind);
    get_doubles(name, 1, &expected);
    assert_relative(loss, expected, 1e-6);
    snprintf(name, sizeof name, "%s.z", kind);
    compare(name, BATCH, z);
    snprintf(name, sizeof name, "%s.grad.", kind);
    each_tensor(name, &f->grads, compare_tensor);
}

/* The gradient by the inputs, of all but the first: that is the reference, by which it is not computed. */
static void check_input_gradient(const fixture *f) {
    float z[BATCH], dz[BATCH], dx[BATCH * INPUTS], padded[BATCH * (INPUTS + NQM_PANEL + 16)];
    double expected[BATCH * INPUTS];
    const size_t stride = nqm_row_stride(INPUTS);
    nqm_gradient_net *net;
    assert_int_equal(nqm_gradient_net_create(&f->params, 1, BATCH, &net, NULL), NQM_OK);
    get_doubles("plain.dx", BATCH * INPUTS, expected);
    for (size_t i = 0; i < BATCH; ++i)
        memcpy(padded + i * stride, x + i * INPUTS, INPUTS * sizeof *x);
    nqm_gradient_forward(net, BATCH, padded, z);
    compare("plain.z", BATCH, z);
    nqm_logcosh_loss(BATCH, 1, &(nqm_output_bounds){lo, hi, 1}, z, target, dz);
    nqm_gradient_backward(net, BATCH, dz, padded);
    for (size_t i = 0; i < BATCH * INPUTS; ++i)
        dx[i] = i % INPUTS ? padded[i / INPUTS * stride + i % INPUTS] : (float)expected[i];
    compare("plain.dx", BATCH * INPUTS, dx);
    nqm_gradient_net_free(net);
}

static void check_adam(fixture *f, const char *kind, bool with_masks, bool freeze_first_layernorm) {
    double losses[STEPS];
    char name[64];
    snprintf(name, sizeof name, "%s.adam.losses", kind);
    get_doubles(name, STEPS, losses);
    for (size_t step = 0; step < STEPS; ++step) {
        float z[BATCH], dz[BATCH];
        assert_relative(loss_of(f, with_masks ? masks_of_step(f, step) : NULL, z, dz), losses[step], 1e-5);
        nqm_trainer_step(f->trainer, BATCH, dz,
                         &(nqm_step_rates){lr_first, lr_deeper, weight_decay, freeze_first_layernorm});
    }
    assert_int_equal(nqm_trainer_steps(f->trainer), STEPS);
    nqm_trainer_store(f->trainer, &f->params, NULL);
    snprintf(name, sizeof name, "%s.adam.", kind);
    each_tensor(name, &f->params, compare_tensor);
}

TEST_WITH(pass_without_dropout, make_fixture, free_fixture) {
    check_one_pass(*state, "plain", NULL);
}

TEST_WITH(pass_with_masks, make_fixture, free_fixture) {
    check_one_pass(*state, "masked", masks_of_step(*state, 0));
}

/* All tables of kernels, including the plain loops that define them. */
TEST_WITH(passes_of_every_table, make_fixture, free_fixture) {
    for (size_t i = 0; nqm_kernels_at(i); ++i) {
        nqm_kernels_use(nqm_kernels_at(i));
        check_one_pass(*state, "plain", NULL);
        check_input_gradient(*state);
    }
}

TEST_WITH(adam_without_dropout, make_fixture, free_fixture) {
    check_adam(*state, "plain", false, false);
}

TEST_WITH(adam_with_masks, make_fixture, free_fixture) {
    check_adam(*state, "masked", true, false);
}

TEST_WITH(adam_with_frozen_layernorm, make_fixture, free_fixture) {
    check_adam(*state, "frozen", false, true);
}

TEST(schedule) {
    enum { EPOCHS = 80 };
    double losses[EPOCHS], rates[EPOCHS][2], lr[2] = {1e-4, 1e-3};
    get_doubles("plateau.losses", EPOCHS, losses);
    get_doubles("plateau.rates", 2 * EPOCHS, &rates[0][0]);
    nqm_plateau plateau = {.factor = 0.1, .patience = 3, .best = INFINITY};
    for (size_t i = 0; i < EPOCHS; ++i) {
        double factor = nqm_plateau_step(&plateau, losses[i]);
        for (size_t k = 0; k < 2; ++k) {
            lr[k] = nqm_plateau_rate(lr[k], factor);
            assert_relative(lr[k], rates[i][k], 1e-12);
        }
    }
    assert_true(lr[0] < 1e-7); /* the rate has reached PyTorch's lower limit */
}

TEST(parameter_count) {
    int64_t expected;
    get("paper.parameters", sizeof expected, &expected);
    assert_int_equal(expected, 4171125);
    assert_int_equal(nqm_params_count(&(nqm_net_shape){4, {3000, 1024, 716, 501, 1}}), expected);
}

static int read_batch(void **state) {
    (void)state;
    get_floats("x", BATCH * INPUTS, x);
    get_floats("target", BATCH, target);
    return 0;
}

TEST_FILE(read_batch, NULL)
