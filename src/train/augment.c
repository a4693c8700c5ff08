/* SPDX-License-Identifier: MIT
 *
 * Lists the examples of a training (paper, section 3.1): class balancing with noisy copies, then the split into
 * training and validation examples. The second augmentation of the paper, scaled copies, is computed when batches are
 * gathered (examples.c).
 */
#include "train/train.h"

#include <math.h>
#include <string.h>

/* ---- balancing --------------------------------------------------------------------------------------------------- */

/* Bins of equal width over [lo, hi]; the last one includes hi. Counts of the authors' 1,242 training labels: 4, 29, 61,
 * 137, 253, 281, 477. */
static size_t bin_of(double label, double lo, double hi) {
    if (!(hi > lo))
        return 0;
    size_t bin = (size_t)((label - lo) / (hi - lo) * NQM_BALANCE_BINS);
    return bin < NQM_BALANCE_BINS ? bin : NQM_BALANCE_BINS - 1;
}

size_t nqm_balance(size_t n, const double *label, uint32_t *copies) {
    double lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; i < n; ++i) {
        lo = fmin(lo, label[i]);
        hi = fmax(hi, label[i]);
    }
    size_t count[NQM_BALANCE_BINS] = {0}, seen[NQM_BALANCE_BINS] = {0}, fullest = 0, sum = 0;
    for (size_t i = 0; i < n; ++i) {
        size_t bin = bin_of(label[i], lo, hi);
        if (++count[bin] > fullest)
            fullest = count[bin];
    }
    for (size_t i = 0; i < n; ++i) {
        size_t bin = bin_of(label[i], lo, hi), missing = fullest - count[bin];
        copies[i] = (uint32_t)(missing / count[bin] + (seen[bin]++ < missing % count[bin]));
        sum += copies[i];
    }
    return sum;
}

void nqm_add_noise(size_t n, const float *ref, const float *test, double sigma, nqm_rng *rng, float *noisy_ref,
                   float *noisy_test) {
    for (size_t i = 0; i < n; ++i) {
        float noise = (float)(sigma * nqm_rng_normal(rng));
        noisy_ref[i] = fmaxf(ref[i] + noise, 0);
        noisy_test[i] = fmaxf(test[i] + noise, 0);
    }
}

/* ---- split ------------------------------------------------------------------------------------------------------- */

/* round(n * fraction), clamped so that neither part is empty. */
static nqm_status part_size(size_t n, double fraction, const char *what, size_t *part_ret, nqm_error *err) {
    if (n < 2)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                        "%zu %s, without test pairs: too few to split into training and validation", n, what);
    size_t part = (size_t)round((double)n * fraction);
    *part_ret = part < 1 ? 1 : part > n - 1 ? n - 1 : part;
    return NQM_OK;
}

/* Mark a random part of the items idx (n) as validation; shuffles idx. */
static nqm_status mark_random(const nqm_train_options *o, size_t n, size_t *idx, const char *what,
                              uint8_t *is_validation, nqm_error *err) {
    size_t part = 0;
    nqm_status status = part_size(n, o->split.validation_fraction, what, &part, err);
    nqm_rng rng = nqm_rng_make(o->optimiser.seed, NQM_STREAM_SPLIT);
    nqm_rng_shuffle(&rng, n, idx);
    for (size_t i = 0; i < part; ++i)
        is_validation[idx[i]] = 1;
    return status;
}

static nqm_status split_by_row(const nqm_train_options *o, size_t n, uint8_t *is_validation, nqm_error *err) {
    size_t *idx = nqm_alloc(n, sizeof *idx);
    if (!idx)
        return nqm_fail_nomem(err, n * sizeof *idx);
    for (size_t i = 0; i < n; ++i)
        idx[i] = i;
    nqm_status status = mark_random(o, n, idx, "pairs", is_validation, err);
    nqm_free(idx);
    return status;
}

static nqm_status split_by_group(const nqm_dataset *d, const nqm_train_options *o, size_t n, const nqm_row *rows,
                                 uint8_t *is_validation, nqm_error *err) {
    size_t n_train = 0, n_validation = 0, *idx;
    uint8_t *group_is_validation;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&idx, d->n_groups, sizeof *idx}, {&group_is_validation, d->n_groups, 1}), err);
    if (status != NQM_OK)
        return status;
    for (size_t g = 0; g < d->n_groups; ++g) {
        group_is_validation[g] = d->group_split[g] == NQM_SPLIT_VALIDATION;
        n_validation += group_is_validation[g];
        if (d->group_split[g] == NQM_SPLIT_TRAIN)
            idx[n_train++] = g;
    }
    if (n_validation == 0) /* draw some of the training groups */
        status = mark_random(o, n_train, idx, "material groups", group_is_validation, err);
    for (size_t i = 0; i < n; ++i)
        is_validation[i] = group_is_validation[d->ref_group[d->pair_ref[rows[i].pair]]];
    nqm_free(idx);
    return status;
}

/* Stable partition: training rows first, then validation rows. sorted (n) is scratch. */
static void partition(nqm_rows *rows, size_t n, const uint8_t *is_validation, nqm_row *sorted) {
    size_t k = 0;
    for (int part = 0; part < 2; ++part) {
        for (size_t i = 0; i < n; ++i)
            if (is_validation[i] == part)
                sorted[k++] = rows->row[i];
        if (part == 0)
            rows->n_train = k;
    }
    rows->n_validation = n - rows->n_train;
    memcpy(rows->row, sorted, n * sizeof *sorted);
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

/* List all pairs that are not test pairs, each with its noisy copies; *n_ret receives the number of rows. */
static nqm_status list_rows(const nqm_dataset *d, const nqm_train_options *o, nqm_rows *rows, size_t *n_ret,
                            nqm_error *err) {
    size_t *pool, n = 0, k = 0;
    double *label;
    uint32_t *copies;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&pool, d->n_pairs, sizeof *pool}, {&label, d->n_pairs, sizeof *label},
                                    {&copies, d->n_pairs, sizeof *copies}),
                         err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < d->n_pairs; ++i)
        if (nqm_dataset_pair_split(d, i) != NQM_SPLIT_TEST) {
            pool[n] = i;
            label[n++] = d->jod[i];
        }
    const size_t n_copies = o->augmentation.balance ? nqm_balance(n, label, copies) : 0;
    status = nqm_alloc_arrays(NQM_ARRAYS({&rows->row, n + n_copies, sizeof *rows->row},
                                         {&rows->first_copy, d->n_pairs, sizeof *rows->first_copy}),
                              err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        rows->first_copy[pool[i]] = (uint32_t)rows->n_noisy;
        for (uint32_t copy = 0; copy <= copies[i]; ++copy)
            rows->row[k++] = (nqm_row){(uint32_t)pool[i], copy};
        rows->n_noisy += copies[i];
    }
    *n_ret = k;
    nqm_free(pool);
    return status;
}

nqm_status nqm_rows_create(const nqm_dataset *d, const nqm_train_options *o, nqm_rows *rows_ret, nqm_error *err) {
    nqm_rows rows = {0};
    uint8_t *is_validation;
    nqm_row *sorted = NULL;
    size_t n = 0;
    nqm_status status = list_rows(d, o, &rows, &n, err);
    if (status == NQM_OK)
        status = nqm_alloc_arrays(NQM_ARRAYS({&sorted, n, sizeof *sorted}, {&is_validation, n, 1}), err);
    if (status == NQM_OK)
        status = o->split.by_pair ? split_by_row(o, n, is_validation, err)
                                  : split_by_group(d, o, n, rows.row, is_validation, err);
    if (status == NQM_OK) {
        partition(&rows, n, is_validation, sorted);
        if (rows.n_train == 0 || rows.n_validation == 0)
            status =
                nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "the dataset has %zu pairs to train on and %zu to validate",
                         rows.n_train, rows.n_validation);
    }
    nqm_free(sorted);
    if (status != NQM_OK)
        nqm_rows_free(&rows);
    *rows_ret = rows;
    return status;
}

void nqm_rows_free(nqm_rows *rows) {
    nqm_free(rows->row);
    *rows = (nqm_rows){0};
}
