/* SPDX-License-Identifier: MIT
 *
 * Converts rows to inputs of the network: keeps transformed samples in memory, computes whitening, scalar features and target
 * normalisation from the training examples, and gathers batches, with scaled copies computed on the fly. Random numbers
 * are functions of (seed, stream, example), so that the result does not depend on the order or the number of threads.
 */
#include "metric/metric.h"
#include "sample/loops.h"
#include "train/train.h"

#include <math.h>
#include <string.h>

static const double max_noise_bytes = 4294967296.0; /* 4 GiB; more noisy copies are most likely a mistake */

/* ---- samples ----------------------------------------------------------------------------------------------------- */

static size_t n_columns(const nqm_examples *e) {
    return 3 * e->dataset->n_directions;
}

/* Row i: references first, then tests. */
static void transform(void *user, size_t i) {
    const nqm_examples *e = user;
    const size_t n = n_columns(e), n_refs = e->dataset->n_refs;
    if (i < n_refs)
        nqm_features_transform(n, e->dataset->ref_rgb + i * n, e->ref_t + i * n);
    else
        nqm_features_transform(n, e->dataset->test_rgb + (i - n_refs) * n, e->test_t + (i - n_refs) * n);
}

static float *noisy_ref_t(const nqm_examples *e, const nqm_row *row) {
    return e->noisy_t + (e->rows.first_copy[row->pair] + row->copy - 1) * 2 * n_columns(e);
}

static void transform_noisy(void *user, size_t i) {
    nqm_examples *e = user;
    const nqm_row *row = &e->rows.row[i];
    if (row->copy == 0)
        return;
    size_t n = n_columns(e);
    float *out = noisy_ref_t(e, row);
    nqm_rng rng =
        nqm_rng_make(nqm_hash_u64(e->options->optimiser.seed, NQM_STREAM_NOISE), (uint64_t)row->pair << 32 | row->copy);
    nqm_add_noise(n, e->dataset->ref_rgb + e->dataset->pair_ref[row->pair] * n, e->dataset->test_rgb + row->pair * n,
                  e->options->augmentation.balance_sigma, &rng, out, out + n);
    nqm_features_transform(2 * n, out, out);
}

/* ---- scaled copies ----------------------------------------------------------------------------------------------- */

static double uniform_factor(uint64_t seed, uint64_t counter) {
    return 0.95 + 0.1 * ((double)(nqm_hash_u64(seed, counter) >> 11) * 0x1p-53);
}

static void scale_elements(size_t n, uint64_t seed, const float *ref_t, const float *test_t, float *out) {
    for (size_t i = 0; i < n; ++i) {
        float factor = (float)uniform_factor(seed, i);
        out[i] = ref_t[i] * factor;
        out[n + i] = test_t[i] * factor;
    }
}

/* The scaled copy of row i of e->rows. out: (2, n_directions, 3). */
static void scale(const nqm_examples *e, size_t i, const float *ref_t, const float *test_t, float *out) {
    const size_t n = n_columns(e);
    const uint64_t seed = nqm_hash_u64(e->options->optimiser.seed, NQM_STREAM_SCALE);
    if (e->options->augmentation.scale_copy == NQM_SCALE_ELEMENT_TRANSFORMED) {
        scale_elements(n, nqm_hash_u64(seed, i), ref_t, test_t, out);
    } else if (e->options->augmentation.scale_copy == NQM_SCALE_NONE) {
        memcpy(out, ref_t, n * sizeof *out);
        memcpy(out + n, test_t, n * sizeof *out);
    } else {
        const float k1 = (float)(cbrt(uniform_factor(seed, i)) - 1);
        nqm_sample_scale(n, k1, ref_t, out);
        nqm_sample_scale(n, k1, test_t, out + n);
    }
}

/* The index in e->rows of example i; of a scaled copy, that of its original. */
static size_t row_of(const nqm_examples *e, size_t i) {
    const size_t n_base = e->rows.n_train;
    return i < e->n_train ? i % n_base : n_base + i - e->n_train;
}

static bool is_second_copy(const nqm_examples *e, size_t i) {
    return i >= e->rows.n_train && i < e->n_train;
}

static void find_unscaled(const nqm_examples *e, const nqm_row *row, const float **ref_t, const float **test_t) {
    const size_t n = n_columns(e);
    *ref_t = row->copy ? noisy_ref_t(e, row) : e->ref_t + e->dataset->pair_ref[row->pair] * n;
    *test_t = row->copy ? *ref_t + n : e->test_t + row->pair * n;
}

/* The transformed samples of example i: training examples without scaling, their scaled copies, validation examples. `slot` (below
 * max_batch) is the row of used_scratch that the calling thread may write to; scratch (2, n_directions, 3) receives a scaled copy.
 * Returns the mask of used directions; NULL: all are used. */
static const uint8_t *find_samples(const nqm_examples *e, size_t i, size_t slot, float *scratch, const float **ref_t,
                                   const float **test_t) {
    const size_t n = n_columns(e), row = row_of(e, i);
    const uint32_t pair = e->rows.row[row].pair;
    find_unscaled(e, &e->rows.row[row], ref_t, test_t);
    if (is_second_copy(e, i)) {
        if (e->options->augmentation.swap) {
            const float *test = *ref_t;
            *ref_t = *test_t;
            *test_t = test;
        }
        scale(e, row, *ref_t, *test_t, scratch);
        *ref_t = scratch;
        *test_t = scratch + n;
    }
    return nqm_dataset_samples(e->dataset, pair, e->used_scratch + slot * e->dataset->n_directions).used;
}

/* Examples or pairs from `first` on, at most max_batch. */
typedef struct piece {
    const nqm_examples *e;
    const nqm_sum_plan *plan;
    size_t first;
    double *out; /* of all */
} piece;

/* Call `work` for each of n examples or pairs, on all threads. */
static void for_each(const nqm_examples *e, size_t n, void (*work)(void *user, size_t i), const nqm_sum_plan *plan,
                     double *out) {
    for (piece p = {e, plan, 0, out}; p.first < n; p.first += e->max_batch)
        nqm_parallel_for(nqm_smaller(n - p.first, e->max_batch), work, &p);
}

/* ---- whitening --------------------------------------------------------------------------------------------------- */

/* out: (9) of each example: count, sum, sum of squares of each channel. */
static void row_moments(void *user, size_t r) {
    const piece *p = user;
    const nqm_examples *e = p->e;
    const float *ref_t, *test_t;
    const uint8_t *used = find_samples(e, p->first + r, r, e->scratch + r * 2 * n_columns(e), &ref_t, &test_t);
    double *sums = p->out + 9 * (p->first + r);
    for (size_t k = 0; k < n_columns(e); ++k) {
        if (used && !used[k / 3])
            continue;
        double t = (double)ref_t[k], *sum = sums + 3 * (k % 3);
        sum[0] += 1;
        sum[1] += t;
        sum[2] += t * t;
    }
}

/* Mean and standard deviation (divisor n - 1, as torch.std) of the references of all training examples. */
static nqm_status find_whitening(nqm_examples *e, nqm_error *err) {
    double total[9] = {0}, *sums = nqm_alloc(e->n_train, 9 * sizeof *sums);
    if (!sums)
        return nqm_fail_nomem(err, e->n_train * 9 * sizeof *sums);
    for_each(e, e->n_train, row_moments, NULL, sums);
    for (size_t i = 0; i < e->n_train * 9; ++i)
        total[i % 9] += sums[i];
    nqm_free(sums);
    if (e->options->input.whitening == NQM_WHITEN_SCALAR)
        for (size_t i = 0; i < 3; ++i)
            total[i] = total[3 + i] = total[6 + i] = total[i] + total[3 + i] + total[6 + i];
    for (size_t k = 0; k < 3; ++k) {
        const double *sum = total + 3 * k;
        double mean = sum[1] / sum[0], variance = (sum[2] - sum[1] * mean) / (sum[0] - 1);
        if (!(sum[0] > 1) || !(variance > 1e-12))
            return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                            "the training references do not differ: nothing can be learnt");
        e->features.mean[k] = (float)mean;
        e->features.std[k] = (float)sqrt(variance);
    }
    return NQM_OK;
}

/* ---- estimates and scalar features ------------------------------------------------------------------------------- */

static void estimate_pair(void *user, size_t r) {
    const piece *p = user;
    const nqm_dataset *d = p->e->dataset;
    const nqm_transport transport = nqm_dataset_transport(d);
    const nqm_sample_pair samples = nqm_dataset_samples(d, p->first + r, p->e->used_scratch + r * d->n_directions);
    nqm_transport_estimates(&transport, 1, &samples, &p->e->estimate[p->first + r], NULL);
}

/* The transformed samples are converted back to f_r, so that the features of a copy match the samples that the network receives
 * with them. */
static void example_scalars(void *user, size_t r) {
    const piece *p = user;
    const nqm_examples *e = p->e;
    const size_t i = p->first + r, n = n_columns(e);
    float *rho = e->scratch + r * 2 * n;
    const float *ref_t, *test_t;
    const uint8_t *used = find_samples(e, i, r, rho, &ref_t, &test_t);
    nqm_features_restore(n, ref_t, rho);
    nqm_features_restore(n, test_t, rho + n);
    /* only if the model gets it: predictions must compute the same features */
    const nqm_transport transport = e->estimate ? nqm_dataset_transport(e->dataset) : (nqm_transport){0};
    nqm_label estimate;
    nqm_compare_samples(p->plan, &transport, &(nqm_sample_pair){rho, rho + n, used}, NULL, &estimate,
                        p->out + i * NQM_SCALAR_COUNT);
}

/* Mean and standard deviation over the training examples. A constant feature gets the standard deviation 1, so that its
 * whitened value is 0. */
static void find_moments(nqm_examples *e, const double *scalars) {
    double n = (double)e->n_train;
    (void)!nqm_scalars_select(NULL, &e->scalar_whitening, NULL); /* all: cannot fail */
    for (size_t k = 0; k < NQM_SCALAR_COUNT; ++k) {
        double sum = 0, squares = 0;
        for (size_t i = 0; i < e->n_train; ++i)
            sum += scalars[i * NQM_SCALAR_COUNT + k];
        for (size_t i = 0; i < e->n_train; ++i)
            squares += pow(scalars[i * NQM_SCALAR_COUNT + k] - sum / n, 2);
        double std = sqrt(squares / n);
        e->scalar_whitening.mean[k] = (float)(sum / n);
        e->scalar_whitening.std[k] = std > 1e-6 ? (float)std : 1;
    }
}

static nqm_status find_scalars(nqm_examples *e, nqm_error *err) {
    const size_t n = e->n_train + e->rows.n_validation;
    nqm_sum_plan *plan;
    double *scalars = nqm_alloc(n, NQM_SCALAR_COUNT * sizeof *scalars);
    nqm_status status = nqm_sum_plan_create(e->dataset->directions, &plan, err);
    if (status == NQM_OK && !scalars)
        status = nqm_fail_nomem(err, n * NQM_SCALAR_COUNT * sizeof *scalars);
    if (status == NQM_OK) {
        for_each(e, n, example_scalars, plan, scalars);
        find_moments(e, scalars);
        e->scalar_whitening.scale = e->options->input.scalar_scale;
        for (size_t i = 0; i < n; ++i)
            nqm_scalars_whiten(&e->scalar_whitening, scalars + i * NQM_SCALAR_COUNT, e->scalars + i * NQM_SCALAR_COUNT);
    }
    nqm_sum_plan_free(plan);
    nqm_free(scalars);
    return status;
}

/* ---- targets ----------------------------------------------------------------------------------------------------- */

static double raw_target(const nqm_examples *e, size_t row, size_t output) {
    const nqm_dataset *d = e->dataset;
    const double least = e->options->labels.min_delta_e;
    uint32_t pair = e->rows.row[row].pair;
    double targets[NQM_LABEL_PARTS], base[1 + NQM_LABEL_PARTS];
    nqm_estimate_targets(e->estimate ? &e->estimate[pair] : NULL, base);
    if (output > 0) {
        nqm_parts_to_targets(d->parts + (size_t)pair * NQM_LABEL_PARTS, least, targets);
        return targets[output - 1] - base[output];
    }
    return e->options->labels.target == NQM_TARGET_JOD ? d->jod[pair] : log(fmax(d->delta_e[pair], least)) - base[0];
}

/* Corrections are limited to this many standard deviations, so that a few large ones do not take the resolution of the
 * sigmoid. */
static const double largest_correction = 6;

/* Normalise the targets of an output to z-scores of the training examples, whose range becomes that of the sigmoid. */
static nqm_status find_targets(nqm_examples *e, size_t output, nqm_error *err) {
    size_t n_base = e->rows.n_train, n_rows = n_base + e->rows.n_validation;
    double copies = (double)e->n_train / (double)n_base, sum = 0, squares = 0, lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; i < n_base; ++i)
        sum += raw_target(e, i, output);
    const double mean = sum / (double)n_base;
    for (size_t i = 0; i < n_base; ++i) {
        double d = raw_target(e, i, output) - mean;
        squares += d * d;
        lo = fmin(lo, d);
        hi = fmax(hi, d);
    }
    const double std = sqrt(copies * squares / ((double)e->n_train - 1));
    if (!(std > 1e-9))
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "the training labels do not differ: nothing can be learnt");
    if (e->estimate) {
        lo = fmax(lo, -largest_correction * std);
        hi = fmin(hi, largest_correction * std);
    }
    e->output[output] = (nqm_output_range){.mean = mean, .std = std, .lo = lo / std, .hi = hi / std};
    for (size_t i = 0; i < n_rows; ++i)
        e->target[i * e->n_outputs + output] = (float)((raw_target(e, i, output) - mean) / std);
    return NQM_OK;
}

/* ---- creation ---------------------------------------------------------------------------------------------------- */

static nqm_status allocate_examples(nqm_examples *e, nqm_error *err) {
    const nqm_dataset *d = e->dataset;
    size_t n = n_columns(e), n_rows = e->rows.n_train + e->rows.n_validation;
    double noise_bytes = (double)e->rows.n_noisy * 2 * (double)n * sizeof(float);
    if (noise_bytes > max_noise_bytes)
        return nqm_fail(err, NQM_ERR_LIMIT, -1, "balancing needs %zu noisy copies, %.1f GB: train without balancing",
                        e->rows.n_noisy, noise_bytes * 1e-9);
    return nqm_alloc_arrays(
        NQM_ARRAYS(
            {&e->ref_t, d->n_refs, n * sizeof(float)}, {&e->test_t, d->n_pairs, n * sizeof(float)},
            {&e->noisy_t, e->rows.n_noisy, 2 * n * sizeof(float)}, {&e->target, n_rows, e->n_outputs * sizeof(float)},
            {&e->scalars, e->options->input.scalars ? n_rows - e->rows.n_train + e->n_train : 0,
             NQM_SCALAR_COUNT * sizeof(float)},
            {&e->estimate, e->options->input.transport && d->transport ? d->n_pairs : 0, sizeof *e->estimate},
            {&e->scratch, e->max_batch, 2 * n * sizeof(float)}, {&e->used_scratch, e->max_batch, d->n_directions}),
        err);
}

nqm_status nqm_examples_create(const nqm_dataset *d, const nqm_train_options *o, size_t max_batch, nqm_examples *e,
                               nqm_error *err) {
    *e = (nqm_examples){.dataset = d, .options = o, .max_batch = max_batch};
    e->features = (nqm_features){.layout = o->input.layout, .difference_scale = o->input.difference_scale};
    e->samples_width = nqm_features_width(o->input.layout, d->n_directions);
    e->width = e->samples_width + (o->input.scalars ? NQM_SCALAR_COUNT : 0);
    e->n_outputs = d->parts && o->labels.parts_weight > 0 ? 1 + NQM_LABEL_PARTS : 1;
    nqm_status status = nqm_rows_create(d, o, &e->rows, err);
    e->n_train = e->rows.n_train * (o->augmentation.scale_copy == NQM_SCALE_NONE && !o->augmentation.swap ? 1 : 2);
    if (status == NQM_OK)
        status = allocate_examples(e, err);
    if (status == NQM_OK) {
        nqm_parallel_for(d->n_refs + d->n_pairs, transform, e);
        nqm_parallel_for(e->rows.n_train + e->rows.n_validation, transform_noisy, e);
        status = find_whitening(e, err);
        if (!o->input.transport || !d->transport)
            e->estimate = NULL;
        else
            for_each(e, d->n_pairs, estimate_pair, NULL, NULL);
    }
    if (status == NQM_OK && o->input.scalars)
        status = find_scalars(e, err);
    for (size_t output = 0; status == NQM_OK && output < e->n_outputs; ++output)
        status = find_targets(e, output, err);
    if (status != NQM_OK)
        nqm_examples_free(e);
    return status;
}

void nqm_examples_free(nqm_examples *e) {
    nqm_rows_free(&e->rows);
    nqm_free(e->ref_t);
    *e = (nqm_examples){0};
}

/* ---- batches ----------------------------------------------------------------------------------------------------- */

typedef struct gather_job {
    const nqm_examples *e;
    const size_t *index; /* NULL: consecutive examples from `first` */
    size_t first, n;
    nqm_trainer *trainer;
    float *target;
} gather_job;

static size_t example_of(const gather_job *job, size_t r) {
    return job->index ? job->index[r] : job->first + r;
}

/* The parts of a label that change their sign when reference and test are exchanged: the shifts and the contrast. */
enum { N_SIGNED_PARTS = 4 };

static void gather_row(const gather_job *job, size_t r) {
    const nqm_examples *e = job->e;
    const size_t i = example_of(job, r);
    const float *ref_t, *test_t;
    float *x = nqm_trainer_input(job->trainer, r); /* also the buffer of a scaled copy: compose works in place */
    const uint8_t *used = find_samples(e, i, r, x, &ref_t, &test_t);
    nqm_features_compose(&e->features, e->dataset->n_directions, ref_t, test_t, used, x);
    if (e->options->input.scalars)
        memcpy(x + e->samples_width, e->scalars + i * NQM_SCALAR_COUNT, NQM_SCALAR_COUNT * sizeof *x);
    float *target = job->target + r * e->n_outputs;
    memcpy(target, e->target + row_of(e, i) * e->n_outputs, e->n_outputs * sizeof *target);
    for (size_t output = 1; output < e->n_outputs && output <= N_SIGNED_PARTS; ++output)
        if (e->options->augmentation.swap && is_second_copy(e, i))
            target[output] = -target[output] - (float)(2 * e->output[output].mean / e->output[output].std);
}

/* Rows per task. Even, so that the same thread processes both rows of a pair: their results may share cache
 * lines. */
enum { ROWS_AT_ONCE = 8 };

static void gather_rows(void *user, size_t i) {
    const gather_job *job = user;
    const size_t first = ROWS_AT_ONCE * i, end = nqm_smaller(first + ROWS_AT_ONCE, job->n);
    for (size_t r = first; r < end; ++r) {
        gather_row(job, r);
        if (r % 2 || r + 1 == end)
            nqm_trainer_inputs_done(job->trainer, r / 2 * 2, 1 + r % 2);
    }
}

void nqm_examples_gather(const nqm_examples *e, size_t n, const size_t *index, size_t first, nqm_trainer *trainer,
                         float *target) {
    gather_job job = {e, index, e->n_train + first, n, trainer, target};
    nqm_parallel_for(nqm_ceil_div(n, ROWS_AT_ONCE), gather_rows, &job);
}
