/* SPDX-License-Identifier: MIT
 *
 * The gradient of a network by its inputs: against PyTorch in double (vectors/net.py), with weights of float and of
 * binary16; equal bits for any batch size and number of threads; failing allocations.
 */
#include "kernel/panel.h"
#include "net/input_gradient.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/random_network.h"
#include "support/vectors.h"

#include <omp.h>

enum { WIDTH = 75, N_REF = 40, OUTPUTS = 6, ROWS = 37, CHECKED = 3 /* rows that are recorded */ };

static const nqm_net_shape shapes[] = {{4, {WIDTH, 100, 64, 33, OUTPUTS}}, {2, {WIDTH, 40, 1}}, {3, {WIDTH, 7, 70, 1}}};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static nqm_params params;
static uint16_t *half; /* the hidden layers' weights, if they are binary16 */
static size_t n_outputs, stride;
static float *x, dz[ROWS * OUTPUTS];

/* Round the hidden layers' weights to binary16 and keep them in both formats. */
static void round_weights(void) {
    half = nqm_alloc(params.n, sizeof *half);
    for (size_t l = 0, at = 0; l + 1 < params.shape.n_layers; ++l) {
        const size_t n = params.shape.sizes[l] * params.shape.sizes[l + 1];
        nqm_half_from_float(n, params.layer[l].w, half + at);
        nqm_half_to_float(n, half + at, params.layer[l].w);
        at += n;
    }
}

static void make(const nqm_net_shape *shape, bool is_half) {
    uint64_t seed = 7;
    n_outputs = shape->sizes[shape->n_layers];
    stride = nqm_row_stride(WIDTH);
    make_random_params(shape, 5, &params);
    x = nqm_alloc(ROWS * stride, sizeof *x);
    for (size_t i = 0; i < ROWS; ++i)
        fill_random(&seed, WIDTH, 1.7, x + i * stride);
    for (size_t i = 1; i < ROWS; ++i)
        if (i % 3) /* runs of three rows have the same reference */
            memcpy(x + i * stride, x + (i - 1) * stride, N_REF * sizeof *x);
    fill_random(&seed, ROWS * n_outputs, 1.7, dz);
    half = NULL;
    if (is_half)
        round_weights();
}

static void drop(void) {
    nqm_params_free(&params);
    nqm_free(x);
    nqm_free(half);
}

/* The parameters as a model file has them: without floats where there is binary16. */
static nqm_params stored(void) {
    nqm_params p = params;
    for (size_t l = 0, at = 0; half && l + 1 < p.shape.n_layers; ++l) {
        p.layer[l].w = NULL;
        p.layer[l].half = half + at;
        at += p.shape.sizes[l] * p.shape.sizes[l + 1];
    }
    return p;
}

/* All rows, `batch` at a time. */
static void run(size_t batch, float *z, float *dx) {
    const nqm_params p = stored();
    nqm_gradient_net *net;
    assert_int_equal(nqm_gradient_net_create(&p, N_REF, batch, &net, NULL), NQM_OK);
    for (size_t first = 0; first < ROWS; first += batch) {
        const size_t n = nqm_smaller(batch, ROWS - first);
        nqm_gradient_forward(net, n, x + first * stride, z + first * n_outputs);
        nqm_gradient_backward(net, n, dz + first * n_outputs, dx + first * stride);
    }
    nqm_gradient_net_free(net);
}

/* Compare the first rows with those of shape s. */
static void check_values(size_t s, const char *name) {
    float *dx = nqm_alloc(ROWS * stride, sizeof *dx), z[ROWS * OUTPUTS];
    double expected_z[CHECKED * OUTPUTS], expected_dx[CHECKED][WIDTH], worst = 0;
    char vector[64];
    snprintf(vector, sizeof vector, "inputs.%zu.%d.z", s, half != NULL);
    get_vector("net.safetensors", vector, CHECKED * n_outputs * sizeof *expected_z, expected_z);
    snprintf(vector, sizeof vector, "inputs.%zu.%d.dx", s, half != NULL);
    get_vector("net.safetensors", vector, sizeof expected_dx, expected_dx);
    run(ROWS, z, dx);
    for (size_t i = 0; i < CHECKED * n_outputs; ++i)
        assert_near((double)z[i], expected_z[i], 1e-5);
    for (size_t i = 0; i < CHECKED; ++i) {
        double largest = 0, error = 0;
        for (size_t k = N_REF; k < WIDTH; ++k) {
            largest = fmax(largest, fabs(expected_dx[i][k]));
            error = fmax(error, fabs((double)dx[i * stride + k] - expected_dx[i][k]));
        }
        worst = fmax(worst, error / largest);
    }
    print_message("%s, %zu layers%s: %.2g\n", name, params.shape.n_layers, half ? ", binary16" : "", worst);
    assert_true(worst <= 1e-5);
    nqm_free(dx);
}

TEST(as_pytorch) {
    for (size_t s = 0; s < 2 * SHAPES; ++s) {
        make(&shapes[s / 2], s % 2);
        for (size_t t = 0; nqm_kernels_at(t); ++t) {
            nqm_kernels_use(nqm_kernels_at(t));
            check_values(s / 2, nqm_kernels_at(t)->name);
        }
        use_chosen_kernels();
        drop();
    }
}

TEST(the_same_bits) {
    static const size_t batches[] = {ROWS, 1, 2, 13, 20};
    const int threads = omp_get_max_threads();
    make(&shapes[0], false);
    const size_t n_bytes = ROWS * stride * sizeof(float);
    float *dx = nqm_alloc(n_bytes, 1), *all_dx = nqm_alloc(n_bytes, 1), z[ROWS * OUTPUTS], all_z[ROWS * OUTPUTS];
    for (size_t t = 0; nqm_kernels_at(t); ++t) {
        nqm_kernels_use(nqm_kernels_at(t));
        omp_set_num_threads(1);
        run(ROWS, all_z, all_dx);
        for (size_t b = 0; b < 2 * sizeof batches / sizeof *batches; ++b) {
            omp_set_num_threads((int)b % 2 + 1);
            run(batches[b / 2], z, dx);
            assert_memory_equal(z, all_z, sizeof z);
            for (size_t i = 0; i < ROWS; ++i)
                assert_memory_equal(dx + i * stride + N_REF, all_dx + i * stride + N_REF, (WIDTH - N_REF) * sizeof *dx);
        }
    }
    omp_set_num_threads(threads);
    use_chosen_kernels();
    nqm_free(dx);
    nqm_free(all_dx);
    drop();
}

/* A gradient of 0 by the outputs gives 0 for the inputs, whatever the workspace held before. */
TEST(no_weight_no_gradient) {
    make(&shapes[0], false);
    float *dx = nqm_alloc(ROWS * stride, sizeof *dx), z[ROWS * OUTPUTS];
    memset(dz, 0, sizeof dz);
    run(5, z, dx);
    for (size_t i = 0; i < ROWS * WIDTH; ++i)
        assert_true(dx[i / WIDTH * stride + i % WIDTH] == 0);
    nqm_free(dx);
    drop();
}

TEST(out_of_memory) {
    make(&shapes[0], false);
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 0) {
        nqm_gradient_net *net = NULL;
        status = nqm_gradient_net_create(&params, N_REF, 3, &net, NULL);
        assert_true((status == NQM_OK) == (net != NULL));
        nqm_gradient_net_free(net);
    }
    nqm_gradient_net_free(NULL);
    drop();
}
