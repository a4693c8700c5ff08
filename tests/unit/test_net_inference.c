/* SPDX-License-Identifier: MIT
 *
 * Inference: against PyTorch in double (vectors/net.py); equal bits for any batch size and number of threads,
 * with and without common references, before and after packing; weights are packed once per model; failing allocations.
 */
#include "base/memory_test.h"
#include "kernel/kernel.h"
#include "model/model.h"
#include "net/inference_state.h"
#include "support/check.h"
#include "support/random_network.h"
#include "support/vectors.h"

#include <nqm/train.h>
#include <omp.h>
#include <pthread.h>

enum { N_REF = 135, WIDTH = 3 * N_REF + 5, STRIDE = WIDTH + 3, ROWS = 199 }; /* more than the 192 rows of a block */

static const uint64_t seed = 11;

static nqm_params params;
static float x[ROWS * STRIDE];
static double expected[ROWS];

/* Runs of 1 to 5 consecutive rows have the same reference. */
static int setup(void **state) {
    (void)state;
    const nqm_net_shape shape = {4, {WIDTH, 100, 64, 33, 1}};
    make_random_params(&shape, seed, &params);
    uint64_t state_of_rows = seed;
    for (size_t i = 0; i < ROWS; ++i) {
        float *row = x + i * STRIDE;
        fill_random(&state_of_rows, STRIDE, 1.7, row); /* what is beyond the width is not read */
        if (i % 15 != 0 && i % 15 != 1 && i % 15 != 3 && i % 15 != 6 && i % 15 != 10)
            memcpy(row, row - STRIDE, N_REF * sizeof *row);
    }
    get_vector("net.safetensors", "inference.z", sizeof expected, expected);
    return 0;
}

static int teardown(void **state) {
    (void)state;
    nqm_params_free(&params);
    return 0;
}

typedef struct session {
    nqm_inference_net *net;
    nqm_inference_work *work;
} session;

static session begin(void) {
    session s;
    assert_int_equal(nqm_inference_net_create(&params, N_REF, &s.net, NULL), NQM_OK);
    assert_int_equal(nqm_inference_work_create(s.net, ROWS, &s.work, NULL), NQM_OK);
    return s;
}

static void end(session *s) {
    nqm_inference_work_free(s->work);
    nqm_inference_net_free(s->net);
}

/* All rows, `batch` at a time. */
static void run(const session *s, size_t batch, float *z) {
    for (size_t first = 0; first < ROWS; first += batch)
        nqm_inference_run(s->work, ROWS - first < batch ? ROWS - first : batch, x + first * STRIDE, STRIDE, z + first);
}

/* The standard deviation of the outputs is about 1. */
TEST(outputs_by_the_formulas) {
    for (size_t t = 0; nqm_kernels_at(t); ++t) {
        float z[ROWS];
        double worst = 0;
        nqm_kernels_use(nqm_kernels_at(t));
        session s = begin();
        run(&s, ROWS, z);
        for (size_t i = 0; i < ROWS; ++i)
            worst = fmax(worst, fabs((double)z[i] - expected[i]));
        print_message("%s: %.2g\n", nqm_kernels_at(t)->name, worst);
        assert_true(worst <= 2e-6);
        end(&s);
    }
    use_chosen_kernels();
}

/* Tables that give equal bits: fused multiply-add is the same everywhere. */
static bool same_bits(const nqm_kernels *kernels) {
#if defined __aarch64__
    const bool fused = true;
#else
    const bool fused = kernels != &nqm_kernels_generic;
#endif
    return kernels != &nqm_kernels_scalar && fused;
}

TEST(the_same_bits) {
    static const size_t batches[] = {ROWS, 1, 2, 7, 13, 100};
    const int threads = omp_get_max_threads();
    static float first[ROWS], all[ROWS], z[ROWS];
    for (size_t t = 0; nqm_kernels_at(t); ++t) {
        nqm_kernels_use(nqm_kernels_at(t));
        session s = begin();
        run(&s, ROWS, all);
        for (size_t b = 0; b < sizeof batches / sizeof *batches; ++b) {
            omp_set_num_threads((int)(b + t) % 3 + 1);
            run(&s, batches[b], z);
            assert_memory_equal(z, all, sizeof z);
        }
        omp_set_num_threads(threads);
        if (t == 0)
            memcpy(first, all, sizeof all);
        if (same_bits(nqm_kernels_at(t)))
            assert_memory_equal(all, first, sizeof all);
        end(&s);
    }
    use_chosen_kernels();
}

/* The first call, with at most 192 rows, packs a panel at a time. */
TEST(the_same_bits_before_packing) {
    static const size_t batches[] = {1, 2, 13, 40, 192};
    const int threads = omp_get_max_threads();
    static float all[ROWS], z[ROWS];
    for (size_t t = 0; nqm_kernels_at(t); ++t) {
        nqm_kernels_use(nqm_kernels_at(t));
        session packed = begin();
        run(&packed, ROWS, all);
        assert_true(packed.net->is_packed); /* at the first call: it has more than 192 rows */
        for (size_t b = 0; b < sizeof batches / sizeof *batches; ++b) {
            session fresh = begin();
            omp_set_num_threads((int)(b + t) % 2 + 1);
            nqm_inference_run(fresh.work, batches[b], x, STRIDE, z);
            assert_false(fresh.net->is_packed);
            assert_memory_equal(z, all, batches[b] * sizeof *z);
            run(&fresh, batches[b], z);
            assert_memory_equal(z, all, sizeof z);
            assert_true(fresh.net->is_packed);
            end(&fresh);
        }
        omp_set_num_threads(threads);
        end(&packed);
    }
    use_chosen_kernels();
}

enum { FEW = 20 };

static void *run_thrice(void *net) {
    nqm_inference_work *work;
    float *z = nqm_alloc(FEW, sizeof *z);
    if (!z || nqm_inference_work_create(net, FEW, &work, NULL) != NQM_OK)
        return NULL;
    for (size_t i = 0; i < 3; ++i)
        nqm_inference_run(work, FEW, x, STRIDE, z);
    nqm_inference_work_free(work);
    return z;
}

/* Some calls read weights that are not packed while another call packs them. */
TEST(packing_during_other_calls) {
    enum { N_THREADS = 6 };
    pthread_t thread[N_THREADS];
    void *z[N_THREADS];
    session s = begin();
    for (size_t i = 0; i < N_THREADS; ++i)
        assert_int_equal(pthread_create(&thread[i], NULL, run_thrice, s.net), 0);
    for (size_t i = 0; i < N_THREADS; ++i)
        assert_int_equal(pthread_join(thread[i], &z[i]), 0);
    assert_true(s.net->is_packed);
    float *after = run_thrice(s.net);
    for (size_t i = 0; i < N_THREADS; ++i) {
        assert_memory_equal(z[i], after, FEW * sizeof *after);
        nqm_free(z[i]);
    }
    nqm_free(after);
    end(&s);
}

/* The kept reference is not used with other kernels than those that computed its partial product. */
TEST(kernels_change) {
    session s = begin(), fresh = begin();
    const nqm_kernels *first = nqm_kernels_get();
    const nqm_kernels *second = first == &nqm_kernels_scalar ? &nqm_kernels_generic : &nqm_kernels_scalar;
    size_t n_changed = 0;
    for (size_t i = 0; i < ROWS; ++i) {
        float before, after, expected_after;
        nqm_kernels_use(first);
        nqm_inference_run(s.work, 1, x + i * STRIDE, STRIDE, &before);
        nqm_kernels_use(second);
        nqm_inference_run(s.work, 1, x + i * STRIDE, STRIDE, &after);
        nqm_inference_run(fresh.work, 1, x + i * STRIDE, STRIDE, &expected_after);
        assert_true(after == expected_after);
        n_changed += before != expected_after;
    }
    use_chosen_kernels();
    assert_true(n_changed > ROWS / 4); /* otherwise the test has no effect */
    end(&s);
    end(&fresh);
}

static void *find(void *model) {
    const nqm_inference_net *net;
    return nqm_model_inference(model, &net, NULL) == NQM_OK ? (void *)(uintptr_t)net : NULL;
}

TEST(packed_once) {
    struct nqm_model *model = nqm_alloc(1, sizeof *model);
    const nqm_net_shape shape = {2, {9 * 7, 300, 1}};
    assert_int_equal(nqm_params_create(&shape, &model->params, NULL), NQM_OK);
    const double degrees[3 * 7] = {0};
    assert_int_equal(nqm_directions_from_degrees(7, degrees, &model->directions, NULL), NQM_OK);
    model->features.layout = NQM_LAYOUT_REF_DIFF_ABSDIFF;
    nqm_alloc_fail_after(2);
    assert_null(find(model));
    nqm_alloc_fail_after(-1);
    enum { N_THREADS = 8 };
    pthread_t thread[N_THREADS];
    void *net[N_THREADS];
    for (size_t i = 0; i < N_THREADS; ++i)
        assert_int_equal(pthread_create(&thread[i], NULL, find, model), 0);
    for (size_t i = 0; i < N_THREADS; ++i)
        assert_int_equal(pthread_join(thread[i], &net[i]), 0);
    for (size_t i = 0; i < N_THREADS; ++i)
        assert_true(net[i] && net[i] == net[0]);
    nqm_model_free(model);
}

TEST(out_of_memory) {
    session s;
    bool made = false;
    for (long n = 0; !made; ++n) {
        nqm_alloc_fail_after(n);
        nqm_status status = nqm_inference_net_create(&params, N_REF, &s.net, NULL);
        if (status == NQM_OK)
            status = nqm_inference_work_create(s.net, 3, &s.work, NULL);
        else
            s = (session){0};
        nqm_alloc_fail_after(-1);
        made = status == NQM_OK;
        assert_true(made || (status == NQM_ERR_NOMEM && !s.work));
        end(&s);
        assert_true(n < 60);
    }
    s = begin();
    nqm_inference_work *none;
    assert_int_equal(nqm_inference_work_create(s.net, 0, &none, NULL), NQM_ERR_ARG);
    assert_null(none);
    end(&s);
}

TEST_FILE(setup, teardown)
