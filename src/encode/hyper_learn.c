/* SPDX-License-Identifier: MIT
 *
 * Learning of the hypernetwork: each step reads samples of a few materials, a random number of 8 to 512 from each,
 * and minimises the loss of the predicted NBRDFs at other directions of these materials. Adam (Kingma and Ba
 * 2015, arXiv:1412.6980) with a cosine schedule.
 */
#include "encode/hyper.h"
#include "encode/nbrdf_net.h"
#include "kernel/kernel.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

enum { N_SETS = 16, N_QUERIES = 512, N_PLACES = 4096, MIN_SAMPLES = 8, MAX_SAMPLES = 512, DEFAULT_STEPS = 16000 };
static const nqm_hyper_shape default_shape = {{128, 128, 192, 384, 384, NQM_NBRDF_WEIGHTS}};

/* The state of learning. */
typedef struct learner {
    nqm_hyper_data data;
    nqm_hyper hyper, gradient;
    nqm_hyper_pass pass;
    float *moments[2];   /* (hyper.n) of Adam; the first owns the block with d_out and queries */
    float *d_out;        /* (N_SETS, NQM_NBRDF_WEIGHTS) */
    float *queries;      /* (N_SETS, 10, N_QUERIES) input, weight, goal */
    double loss[N_SETS]; /* loss of each predicted NBRDF */
    size_t step, n_steps;
    uint64_t seed;
} learner;

/* An NBRDF with random weights (He et al. 2015): initial bias of the last layer of the hypernetwork. */
static void random_nbrdf(uint64_t seed, float *weights) {
    static const size_t sizes[] = {6, 21, 21, 3};
    nqm_rng rng = nqm_rng_make(seed, NQM_HYPER_N_LAYERS);
    memset(weights, 0, NQM_NBRDF_WEIGHTS * sizeof *weights);
    for (size_t l = 0; l < 3; ++l) {
        double deviation = sqrt(2.0 / (double)sizes[l]);
        for (size_t i = 0; i < sizes[l] * sizes[l + 1]; ++i)
            *weights++ = (float)(deviation * nqm_rng_normal(&rng));
        weights += sizes[l + 1];
    }
}

static nqm_status create(learner *l, size_t n, const nqm_brdf *const *refs, nqm_ticker *ticker, nqm_error *err) {
    nqm_status status = nqm_hyper_data_create(n, refs, N_PLACES, l->seed, ticker, &l->data, err);
    if (status == NQM_OK)
        status = nqm_hyper_create(&default_shape, &l->hyper, err);
    if (status == NQM_OK)
        status = nqm_hyper_create(&default_shape, &l->gradient, err);
    if (status == NQM_OK)
        status = nqm_hyper_pass_create(&l->hyper, N_SETS, MAX_SAMPLES, &l->pass, err);
    if (status != NQM_OK)
        return status;
    status = nqm_alloc_arrays(NQM_ARRAYS({&l->moments[0], l->hyper.n, sizeof(float)},
                                         {&l->moments[1], l->hyper.n, sizeof(float)},
                                         {&l->d_out, N_SETS, NQM_NBRDF_WEIGHTS * sizeof(float)},
                                         {&l->queries, N_SETS, 10 * N_QUERIES * sizeof(float)}),
                              err);
    if (status != NQM_OK)
        return status;
    float mean[NQM_NBRDF_WEIGHTS];
    random_nbrdf(l->seed, mean);
    nqm_hyper_init(&l->hyper, mean, l->seed);
    return NQM_OK;
}

static void destroy(learner *l) {
    nqm_free(l->data.place);
    nqm_free(l->hyper.block);
    nqm_free(l->gradient.block);
    nqm_hyper_pass_free(&l->pass);
    nqm_free(l->moments[0]);
}

/* ---- one step ---------------------------------------------------------------------------------------------------- */

/* Number of samples: uniform in the logarithm. */
static size_t draw_count(const learner *l) {
    nqm_rng rng = nqm_rng_make(l->seed + 1, l->step);
    return (size_t)(MIN_SAMPLES * pow((double)MAX_SAMPLES / MIN_SAMPLES, nqm_rng_uniform(&rng)));
}

static nqm_hyper_example example_of(const learner *l, size_t set) {
    float *queries = l->queries + set * 10 * N_QUERIES;
    return (nqm_hyper_example){.n_samples = l->pass.n_samples,
                               .n_queries = N_QUERIES,
                               .samples = l->pass.input + set * l->pass.n_samples * NQM_HYPER_FEATURES,
                               .input = queries,
                               .weight = queries + 6 * N_QUERIES,
                               .goal = queries + 7 * N_QUERIES};
}

static void draw_set(void *user, size_t set) {
    learner *l = user;
    nqm_rng rng = nqm_rng_make(l->seed + 2, l->step * N_SETS + set);
    nqm_hyper_example example = example_of(l, set);
    nqm_hyper_draw_example(&l->data, &rng, &example);
}

/* Loss of one NBRDF and its gradient, relative to the brightness of the material: otherwise mirrors would dominate. */
static void compute_set_loss(void *user, size_t set) {
    const double dark = 0.03;
    learner *l = user;
    nqm_hyper_example example = example_of(l, set);
    nqm_nbrdf_batch batch = {.n = N_QUERIES, .input = example.input, .weight = example.weight, .goal = example.goal};
    float *gradient = l->d_out + set * NQM_NBRDF_WEIGHTS;
    double brightness = 0;
    for (size_t i = 0; i < 3 * N_QUERIES; ++i)
        brightness += (double)example.goal[i];
    double scale = 1 / (N_SETS * (brightness / (3 * N_QUERIES) + dark));
    const float *written = l->pass.y[NQM_HYPER_N_LAYERS - 1] + set * NQM_NBRDF_WEIGHTS;
    l->loss[set] = scale * nqm_nbrdf_loss(written, &batch, gradient);
    for (size_t i = 0; i < NQM_NBRDF_WEIGHTS; ++i)
        gradient[i] *= (float)scale;
}

/* A step of Adam. The norm of the gradient is clipped to 1: the loss of the predicted NBRDFs is not smooth. */
static void descend(learner *l) {
    const double peak_rate = 3e-3, warm_up = 200;
    double t = (double)l->step + 1, square = 0;
    float *gradient = l->gradient.block;
    for (size_t i = 0; i < l->hyper.n; ++i)
        square += (double)gradient[i] * (double)gradient[i];
    float shorten = (float)(1 / fmax(1, sqrt(square)));
    for (size_t i = 0; i < l->hyper.n; ++i)
        gradient[i] *= shorten;
    const double lr = peak_rate * fmin(1, t / warm_up) * 0.5 * (1 + cos(NQM_PI * t / (double)l->n_steps));
    const nqm_adam_rate rate = nqm_adam_rate_at(lr, 0, l->step + 1);
    nqm_adam_update(l->hyper.n, &rate, gradient, l->moments[0], l->moments[1], l->hyper.block);
}

static double take_step(learner *l) {
    l->pass.n_samples = draw_count(l);
    nqm_parallel_for(N_SETS, draw_set, l);
    nqm_hyper_forward(&l->hyper, &l->pass);
    nqm_parallel_for(N_SETS, compute_set_loss, l);
    nqm_hyper_backward(&l->hyper, &l->pass, l->d_out, &l->gradient);
    descend(l);
    double loss = 0;
    for (size_t set = 0; set < N_SETS; ++set)
        loss += l->loss[set];
    return loss;
}

nqm_status nqm_learn_hyper(size_t n, const nqm_brdf *const *refs, const char *const *names,
                           const nqm_learn_options *options, const char *path, nqm_error *err) {
    nqm_learn_options used = *options;
    if (used.n_steps == 0)
        used.n_steps = DEFAULT_STEPS;
    nqm_ticker ticker = {.fn = options->progress, .user = options->progress_user};
    learner *l = nqm_alloc(1, sizeof *l);
    if (!l)
        return nqm_fail_nomem(err, sizeof *l);
    l->seed = used.seed;
    l->n_steps = used.n_steps;
    nqm_status status = create(l, n, refs, &ticker, err);
    for (; status == NQM_OK && l->step < l->n_steps; ++l->step) {
        if (!isfinite(take_step(l)))
            status = nqm_fail(err, NQM_ERR_NUMERIC, -1, "the learning diverged in step %zu", l->step + 1);
        else if (nqm_tick(&ticker, "learn", (double)(l->step + 1), (double)l->n_steps))
            status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "stopped after %zu of %zu steps", l->step + 1, l->n_steps);
    }
    if (status == NQM_OK)
        status = nqm_hyper_write(&l->hyper, n, names, &used, path, err);
    destroy(l);
    nqm_free(l);
    return status;
}
