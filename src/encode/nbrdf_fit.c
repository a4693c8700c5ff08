/* SPDX-License-Identifier: MIT
 *
 * Training of one network for one BRDF, after Sztrajman et al. 2021 (section 3.1 and their code): minibatches and Adam on
 * the cosine-weighted mean absolute log error. Three differences, for speed and for highlights: the learning rate starts
 * twenty times higher and follows half a cosine to zero, batches are half as large, and half of the directions are dense
 * around theta_h = 0, like the cells of MERL's tables.
 */
#include "encode/encode.h"
#include "kernel/kernel.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

enum {
    BATCH = 256,
    SAMPLES_PER_DIRECTION = 16, /* training directions per direction of the options */
    PASSES = 128,               /* epochs */
    N_STARTS = 3,
    START_FRACTION = 32, /* each start is trained for 1 / START_FRACTION of all steps before the best one continues */
    N_FRESH = 32,        /* validation batches, never trained on */
    REPORT_EVERY = 512,
    N_OVERFIT_STEPS = 4000
};
static const double learning_rate = 1e-2;

/* Samples of the reference by batch; `input` owns the block. */
typedef struct samples {
    size_t n_batches;
    float *input, *weight, *goal; /* (n_batches, 6, BATCH), (n_batches, BATCH), (n_batches, 3, BATCH) */
} samples;

/** A network in training. */
typedef struct learner {
    float weights[NQM_NBRDF_WEIGHTS], m[NQM_NBRDF_WEIGHTS], v[NQM_NBRDF_WEIGHTS];
    uint64_t n_steps; /* done */
} learner;

/* ---- the reference ----------------------------------------------------------------------------------------------- */

static nqm_nbrdf_batch batch_at(const samples *s, size_t i) {
    return (nqm_nbrdf_batch){.n = BATCH,
                             .input = s->input + i * 6 * BATCH,
                             .weight = s->weight + i * BATCH,
                             .goal = s->goal + i * 3 * BATCH};
}

/* theta_d and phi_d uniform, theta_h uniform or distributed as the rows of MERL's tables; both directions above the horizon. */
static void draw_direction(nqm_rng *rng, double *hd) {
    double wi[3], wo[3];
    do {
        bool dense = nqm_rng_u64(rng) >> 63;
        double u = nqm_rng_uniform(rng);
        hd[0] = (dense ? u * u : u) * NQM_PI / 2;
        hd[1] = nqm_rng_uniform(rng) * NQM_PI / 2;
        hd[2] = nqm_rng_uniform(rng) * NQM_PI;
        nqm_half_diff_to_pair(hd, wi, wo);
    } while (!(wi[2] > 0 && wo[2] > 0));
}

static nqm_status samples_make(const nqm_brdf *ref, size_t n_batches, uint64_t seed, uint64_t stream, samples *s,
                               nqm_error *err) {
    nqm_rng rng = nqm_rng_make(seed, stream);
    s->n_batches = n_batches;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&s->input, n_batches * 6 * BATCH, sizeof(float)},
                                                    {&s->weight, n_batches * BATCH, sizeof(float)},
                                                    {&s->goal, n_batches * 3 * BATCH, sizeof(float)}),
                                         err);
    for (size_t b = 0; b < n_batches && status == NQM_OK; ++b) {
        double hd[3 * BATCH], rgb[3 * BATCH];
        float *goal = s->goal + b * 3 * BATCH, *weight = s->weight + b * BATCH;
        if (nqm_encode_sample(ref, BATCH, draw_direction, &rng, hd, rgb) < BATCH)
            return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: fewer than one direction in %d has a value",
                            nqm_brdf_get_info(ref).name, NQM_ENCODE_MAX_TRIES);
        nqm_nbrdf_fill(BATCH, hd, rgb, s->input + b * 6 * BATCH, weight, goal);
    }
    return status;
}

/* ---- training ---------------------------------------------------------------------------------------------------- */

/* Glorot and Bengio 2010, the default of Keras. `w` (n_in, n_out), then n_out biases of zero. */
static float *init_layer(nqm_rng *rng, size_t n_in, size_t n_out, float *w) {
    double limit = sqrt(6.0 / (double)(n_in + n_out));
    for (size_t i = 0; i < n_in * n_out; ++i)
        w[i] = (float)(limit * (2 * nqm_rng_uniform(rng) - 1));
    return w + (n_in + 1) * n_out;
}

static void learner_init(learner *l, uint64_t seed, uint64_t stream) {
    nqm_rng rng = nqm_rng_make(seed, stream);
    memset(l, 0, sizeof *l);
    float *w = init_layer(&rng, 6, 21, l->weights);
    init_layer(&rng, 21, 3, init_layer(&rng, 21, 21, w));
}

static double mean_loss(const learner *l, const samples *s) {
    double sum = 0;
    for (size_t b = 0; b < s->n_batches; ++b) {
        nqm_nbrdf_batch batch = batch_at(s, b);
        sum += nqm_nbrdf_loss(l->weights, &batch, NULL);
    }
    return sum / (double)s->n_batches;
}

/* State shared by all starts. */
typedef struct training {
    const samples *train, *fresh;
    size_t n_steps, n_done; /* n_done counts all starts, for the progress */
    const nqm_encode_options *options;
    nqm_error *err;
} training;

static void descend(learner *l, const nqm_nbrdf_batch *batch, size_t n_steps) {
    float gradient[NQM_NBRDF_WEIGHTS];
    nqm_nbrdf_loss(l->weights, batch, gradient);
    const double lr = learning_rate * 0.5 * (1 + cos(NQM_PI * (double)l->n_steps / (double)n_steps));
    const nqm_adam_rate rate = nqm_adam_rate_at(lr, 0, ++l->n_steps);
    nqm_adam_update(NQM_NBRDF_WEIGHTS, &rate, gradient, l->m, l->v, l->weights);
}

/* Train up to step `last`. */
static nqm_status train(training *c, learner *l, size_t last) {
    double n_total = (double)c->n_steps * (1 + (N_STARTS - 1.0) / START_FRACTION);
    for (; l->n_steps < last; ++c->n_done) {
        if (c->n_done % REPORT_EVERY == 0 && c->options->progress &&
            c->options->progress(c->options->progress_user, "training a network", (double)c->n_done, n_total) != 0)
            return nqm_fail(c->err, NQM_ERR_CANCELLED, -1, "interrupted");
        nqm_nbrdf_batch batch = batch_at(c->train, l->n_steps % c->train->n_batches);
        descend(l, &batch, c->n_steps);
    }
    return NQM_OK;
}

/* Train a few starts briefly and continue the best: in some starts ReLU neurons die early. */
static nqm_status train_best(training *c, learner *best, size_t *best_start) {
    learner candidate;
    double best_loss = INFINITY;
    for (size_t start = 0; start < N_STARTS; ++start) {
        learner_init(&candidate, c->options->seed, 2 + start);
        nqm_status status = train(c, &candidate, c->n_steps / START_FRACTION);
        if (status != NQM_OK)
            return status;
        double loss = mean_loss(&candidate, c->fresh);
        if (loss < best_loss) {
            best_loss = loss;
            *best = candidate;
            *best_start = start;
        }
    }
    return train(c, best, c->n_steps);
}

static nqm_status make_brdf(const learner *l, const nqm_brdf *ref, nqm_brdf **brdf_ret, nqm_error *err) {
    char name[256];
    snprintf(name, sizeof name, "nbrdf of %.240s", nqm_brdf_get_info(ref).name);
    return nqm_nbrdf_create(l->weights, name, brdf_ret, err);
}

nqm_status nqm_encode_nbrdf(const nqm_brdf *ref, const nqm_encode_options *options, nqm_encode_report *report,
                            nqm_brdf **brdf_ret, nqm_error *err) {
    size_t n_batches = (options->n_directions * SAMPLES_PER_DIRECTION + BATCH - 1) / BATCH;
    samples trained = {0}, fresh = {0};
    learner best;
    training c = {.train = &trained, .fresh = &fresh, .n_steps = n_batches * PASSES, .options = options, .err = err};
    nqm_status status = samples_make(ref, n_batches, options->seed, 0, &trained, err);
    if (status == NQM_OK)
        status = samples_make(ref, N_FRESH, options->seed, 1, &fresh, err);
    if (status == NQM_OK)
        status = train_best(&c, &best, &report->best_start);
    if (status == NQM_OK) {
        report->loss = mean_loss(&best, &fresh);
        report->n_directions = n_batches * BATCH;
        report->n_numbers = NQM_NBRDF_WEIGHTS;
        status = isfinite(report->loss) ? make_brdf(&best, ref, brdf_ret, err)
                                        : nqm_fail(err, NQM_ERR_NUMERIC, -1, "the training of a network diverged");
    }
    nqm_free(trained.input);
    nqm_free(fresh.input);
    return status;
}

nqm_status nqm_encode_nbrdf_at(const nqm_brdf *ref, size_t n, const double *hd, uint64_t seed, nqm_brdf **brdf_ret,
                               nqm_error *err) {
    double *at, *rgb;
    float *input, *weight, *goal;
    uint8_t *flag;
    learner l;
    *brdf_ret = NULL;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&at, n, 3 * sizeof *at}, {&rgb, n, 3 * sizeof *rgb},
                                                    {&input, n, 6 * sizeof *input}, {&weight, n, sizeof *weight},
                                                    {&goal, n, 3 * sizeof *goal}, {&flag, n, 1}),
                                         err);
    if (status != NQM_OK)
        return status;
    nqm_brdf_eval_half_diff(ref, n, hd, rgb, flag);
    memcpy(at, hd, 3 * n * sizeof *at);
    const size_t m = nqm_encode_keep_valid(n, flag, at, rgb);
    nqm_nbrdf_fill(m, at, rgb, input, weight, goal);
    const nqm_nbrdf_batch batch = {.n = m, .input = input, .weight = weight, .goal = goal};
    learner_init(&l, seed, 2);
    for (size_t step = 0; m > 0 && step < N_OVERFIT_STEPS; ++step)
        descend(&l, &batch, N_OVERFIT_STEPS);
    status = m > 0 ? make_brdf(&l, ref, brdf_ret, err)
                   : nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: no direction of %zu has a value",
                              nqm_brdf_get_info(ref).name, n);
    nqm_free(at);
    return status;
}
