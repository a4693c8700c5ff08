/* SPDX-License-Identifier: MIT
 *
 * Builds a dataset from the answers of people by sampling the BRDFs that the answers name. Rows are sorted by reference
 * and test; a BRDF that is in several of them is sampled once.
 */
#include "argument/argument.h"
#include "data/data.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A test of a row. The strings belong to the CSV. */
typedef struct entry {
    const char *ref, *test;
    size_t row, slot; /* slot 1: test_b */
} entry;

/* A BRDF by its name, and its samples, which belong to the dataset. */
typedef struct sampled {
    const char *name;
    const float *rgb;
    const uint8_t *used;
} sampled;

typedef struct reader {
    nqm_human *human;
    nqm_dataset *dataset;
    nqm_answers answers;
    const nqm_human_options *options;
    size_t n_entries, n_refs, n_pairs;
    entry *entries;    /* (n_entries) sorted; owns the block of all three arrays */
    uint32_t *pair_of; /* (n_rows, n_slots) */
    size_t n_sampled;
    sampled *sampled;  /* (n_sampled) */
    nqm_index by_name; /* of these */
    nqm_ticker ticker;
    nqm_error *err;
} reader;

/* ---- references and pairs ---------------------------------------------------------------------------------------- */

static int compare_entries(const void *x, const void *y) {
    const entry *a = x, *b = y;
    int order = strcmp(a->ref, b->ref);
    if (order == 0)
        order = strcmp(a->test, b->test);
    if (order == 0)
        order = (a->row > b->row) - (a->row < b->row);
    return order;
}

static bool begins_ref(const reader *r, size_t i) {
    return i == 0 || strcmp(r->entries[i].ref, r->entries[i - 1].ref) != 0;
}

static bool repeats_pair(const reader *r, size_t i) {
    return !begins_ref(r, i) && strcmp(r->entries[i].test, r->entries[i - 1].test) == 0;
}

/* For choices, all entries with the same reference and test form one pair; for scores, every row is a separate pair. */
static bool begins_pair(const reader *r, size_t i) {
    return r->answers.n_slots == 1 || !repeats_pair(r, i);
}

static nqm_status sort_entries(reader *r) {
    const nqm_answers *a = &r->answers;
    r->n_entries = a->n_rows * a->n_slots;
    const nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&r->entries, r->n_entries, sizeof *r->entries},
                                                          {&r->pair_of, r->n_entries, sizeof *r->pair_of},
                                                          {&r->sampled, 2 * r->n_entries, sizeof *r->sampled}),
                                               r->err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < r->n_entries; ++i) {
        size_t row = i / a->n_slots, slot = i % a->n_slots;
        r->entries[i] =
            (entry){nqm_csv_text(a->csv, row, a->reference), nqm_csv_text(a->csv, row, a->test[slot]), row, slot};
    }
    qsort(r->entries, r->n_entries, sizeof *r->entries, compare_entries);
    for (size_t i = 0; i < r->n_entries; ++i) {
        r->n_refs += begins_ref(r, i);
        r->n_pairs += begins_pair(r, i);
        r->pair_of[r->entries[i].row * a->n_slots + r->entries[i].slot] = (uint32_t)(r->n_pairs - 1);
    }
    return NQM_OK;
}

/* ---- samples ----------------------------------------------------------------------------------------------------- */

static nqm_index_key key_of_sampled(const void *value) {
    return (nqm_index_key){.name = ((const sampled *)value)->name};
}

/* Sample a BRDF, unless it was sampled for another row. used (n_directions) receives 1 where it has a value, else 0. */
static nqm_status sample_brdf(reader *r, const char *name, size_t row, float *rgb, uint8_t *used) {
    const nqm_dataset *d = r->dataset;
    const sampled *known = nqm_index_find(&r->by_name, (nqm_index_key){.name = name});
    if (known) {
        memcpy(rgb, known->rgb, d->n_directions * 3 * sizeof *rgb);
        memcpy(used, known->used, d->n_directions);
        return NQM_OK;
    }
    nqm_error inner = {0};
    nqm_brdf *brdf = NULL;
    nqm_status status = nqm_argument_open_below(name, r->options->root, &brdf, &inner);
    if (status == NQM_OK)
        status = nqm_sample(brdf, d->directions, NQM_INVALID_DROP, rgb, used, NULL, &inner);
    for (size_t i = 0; status == NQM_OK && i < d->n_directions; ++i)
        used[i] = nqm_has_value(used[i]);
    nqm_brdf_free(brdf);
    if (status != NQM_OK)
        return nqm_fail(r->err, status, inner.byte_offset, "%s: row %zu: %.400s", r->answers.path, row + 1,
                        inner.message);
    r->sampled[r->n_sampled] = (sampled){name, rgb, used};
    nqm_index_add(&r->by_name, &r->sampled[r->n_sampled++]);
    return NQM_OK;
}

static const double least_valid = 0.9; /* fraction of the directions at which both BRDFs of a pair need a value */

static nqm_status check_valid(const reader *r, const entry *e, const uint8_t *ref_used, const uint8_t *test_used) {
    size_t n_valid = 0, n = r->dataset->n_directions;
    for (size_t i = 0; i < n; ++i)
        n_valid += ref_used[i] && test_used[i];
    if (n_valid > 0 && (double)n_valid >= least_valid * (double)n)
        return NQM_OK;
    return nqm_fail(r->err, NQM_ERR_INCOMPATIBLE, -1,
                    "%s: row %zu: both BRDFs have a value at only %zu of %zu directions ('%.100s', '%.100s')",
                    r->answers.path, e->row + 1, n_valid, n, e->ref, e->test);
}

/* ---- rows of the dataset ----------------------------------------------------------------------------------------- */

/* The material of a row. Without a material column, every reference is its own material. */
static const char *material_of(const reader *r, const entry *e) {
    return r->answers.material >= 0 ? nqm_csv_text(r->answers.csv, e->row, r->answers.material) : e->ref;
}

/* Add the reference whose entries start at `first`; all its rows must name the same material. */
static nqm_status add_reference(reader *r, size_t first) {
    const entry *e = &r->entries[first];
    const char *name = material_of(r, e);
    nqm_dataset *d = r->dataset;
    uint32_t group = 0;
    for (size_t i = first + 1; i < r->n_entries && !begins_ref(r, i); ++i)
        if (strcmp(material_of(r, &r->entries[i]), name) != 0)
            return nqm_fail(r->err, NQM_ERR_INCOMPATIBLE, -1,
                            "%s: row %zu: the reference '%.100s' is of material '%.60s' here, and '%.60s' in row %zu",
                            r->answers.path, r->entries[i].row + 1, e->ref, material_of(r, &r->entries[i]), name,
                            e->row + 1);
    const size_t n = d->n_directions, ref = d->n_refs;
    nqm_status status = nqm_dataset_add_group(r->dataset, name, strlen(name), NQM_SPLIT_TEST, &group, r->err);
    if (status == NQM_OK)
        status = nqm_dataset_add_reference(r->dataset, e->ref, group, r->err);
    return status == NQM_OK ? sample_brdf(r, e->ref, e->row, d->ref_rgb + 3 * n * ref, d->ref_used + n * ref) : status;
}

static nqm_status add_pair(reader *r, size_t i) {
    const entry *e = &r->entries[i];
    const nqm_answers *a = &r->answers;
    const nqm_dataset *d = r->dataset;
    const size_t n = d->n_directions, ref = d->n_refs - 1;
    const double value = a->n_slots == 1 ? a->values[e->row] : (double)NAN;
    const char *kind_name = a->test_kind >= 0 ? nqm_csv_text(a->csv, e->row, a->test_kind) : "human";
    uint8_t *used = d->test_used + n * d->n_pairs;
    uint32_t kind = 0;
    nqm_status status = sample_brdf(r, e->test, e->row, d->test_rgb + 3 * n * d->n_pairs, used);
    if (status == NQM_OK)
        status = check_valid(r, e, d->ref_used + n * ref, used);
    if (status == NQM_OK)
        status = nqm_dataset_add_kind(r->dataset, kind_name, NULL, &kind, r->err);
    if (status == NQM_OK)
        status = nqm_dataset_add_pair(r->dataset, (uint32_t)ref, e->test, kind, (double)NAN,
                                      a->kind == NQM_HUMAN_DISTANCE ? -value : value, r->err);
    if (status == NQM_OK && nqm_tick(&r->ticker, "sample", (double)d->n_pairs, (double)r->n_pairs))
        status = nqm_fail(r->err, NQM_ERR_CANCELLED, -1, "interrupted");
    return status;
}

static nqm_status build_dataset(reader *r) {
    const nqm_directions *given = r->options->directions;
    nqm_directions *made = NULL;
    nqm_status status = given ? NQM_OK : nqm_directions_create(NULL, 0, NULL, &made, r->err);
    if (status != NQM_OK)
        return status;
    const nqm_directions *directions = given ? given : made;
    const nqm_dataset_limits limits = {.n_directions = nqm_directions_get_info(directions).n,
                                       .directions_deg = nqm_directions_get_info(directions).degrees,
                                       .max_refs = r->n_refs,
                                       .max_pairs = r->n_pairs,
                                       .has_masks = true};
    status = nqm_dataset_begin(&limits, &r->dataset, r->err);
    nqm_directions_free(made);
    if (status != NQM_OK)
        return status;
    r->ticker = (nqm_ticker){.fn = r->options->progress, .user = r->options->progress_user};
    for (size_t i = 0; status == NQM_OK && i < r->n_entries; ++i) {
        if (begins_ref(r, i))
            status = add_reference(r, i);
        if (status == NQM_OK && begins_pair(r, i))
            status = add_pair(r, i);
    }
    r->dataset->order_only = r->answers.kind != NQM_HUMAN_JOD;
    return nqm_dataset_finish(r->dataset, status, NULL, NULL, &r->human->dataset, r->err);
}

/* ---- noise of scores --------------------------------------------------------------------------------------------- */

/* Variance of the noise of a row: the mean of sd^2 / n, or that within rows with the same reference and test; NaN: unknown. */
static nqm_status find_noise(const reader *r, int sd, int n, double *noise) {
    const nqm_answers *a = &r->answers;
    nqm_status status = NQM_OK;
    double squares = 0, more = 0, x[2];
    for (size_t row = 0; sd >= 0 && n >= 0 && status == NQM_OK && row < a->n_rows; ++row) {
        status = nqm_csv_number(a->csv, row, sd, &x[0], r->err);
        if (status == NQM_OK)
            status = nqm_csv_number(a->csv, row, n, &x[1], r->err);
        if (status == NQM_OK && !(x[0] >= 0 && x[1] >= 1))
            status =
                nqm_fail(r->err, NQM_ERR_FORMAT, -1, "%s: row %zu: sd is at least 0, n at least 1", a->path, row + 1);
        squares += x[0] * x[0] / x[1];
        more += 1;
    }
    for (size_t i = 0, end; more == 0 && i < r->n_entries; i = end) {
        double mean = 0;
        for (end = i; end == i || (end < r->n_entries && repeats_pair(r, end)); ++end)
            mean += (a->values[r->entries[end].row] - mean) / (double)(end - i + 1);
        for (size_t k = i; k < end; ++k)
            squares += pow(a->values[r->entries[k].row] - mean, 2);
        more += (double)(end - i - 1);
    }
    *noise = more > 0 ? squares / more : NAN;
    return status;
}

static nqm_status find_ceiling(const reader *r) {
    const nqm_answers *a = &r->answers;
    double mean = 0, variance = 0, noise;
    const nqm_status status = find_noise(r, nqm_csv_column(a->csv, "sd"), nqm_csv_column(a->csv, "n"), &noise);
    for (size_t row = 0; row < a->n_rows; ++row)
        mean += a->values[row] / (double)a->n_rows;
    for (size_t row = 0; row < a->n_rows; ++row)
        variance += pow(a->values[row] - mean, 2) / fmax((double)a->n_rows - 1, 1);
    r->human->ceiling = isnan(noise) || variance == 0 ? (double)NAN : sqrt(fmax(1 - noise / variance, 0));
    return status;
}

/* ---- choices ----------------------------------------------------------------------------------------------------- */

static int compare_triplets(const void *x, const void *y) {
    const nqm_triplet *p = x, *q = y;
    int order = (p->group > q->group) - (p->group < q->group);
    if (order == 0)
        order = (p->a > q->a) - (p->a < q->a);
    return order ? order : (p->b > q->b) - (p->b < q->b);
}

/* Merge the rows that compare the same two tests of a reference into one triplet, regardless of the tests' order. */
static nqm_status gather_triplets(reader *r) {
    nqm_human *h = r->human;
    h->triplets = nqm_alloc(r->answers.n_rows, sizeof *h->triplets);
    if (!h->triplets)
        return nqm_fail_nomem(r->err, r->answers.n_rows * sizeof *h->triplets);
    for (size_t row = 0; row < r->answers.n_rows; ++row) {
        const uint32_t *pair = r->pair_of + 2 * row;
        const double *n = r->answers.values + 2 * row;
        bool swap = pair[0] > pair[1];
        h->triplets[row] = (nqm_triplet){.group = h->dataset->ref_group[h->dataset->pair_ref[pair[0]]],
                                         .a = pair[swap],
                                         .b = pair[!swap],
                                         .n_a = n[swap],
                                         .n_b = n[!swap]};
    }
    qsort(h->triplets, r->answers.n_rows, sizeof *h->triplets, compare_triplets);
    for (size_t row = 0; row < r->answers.n_rows; ++row) {
        const nqm_triplet t = h->triplets[row];
        nqm_triplet *last = h->n_triplets ? &h->triplets[h->n_triplets - 1] : NULL;
        if (last && compare_triplets(last, &t) == 0) {
            last->n_a += t.n_a;
            last->n_b += t.n_b;
        } else {
            h->triplets[h->n_triplets++] = t;
        }
    }
    return NQM_OK;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

nqm_status nqm_human_load(const char *csv_path, const nqm_human_options *options, nqm_human **human_ret,
                          nqm_error *err) {
    *human_ret = NULL;
    nqm_csv *csv = NULL;
    reader r = {.human = nqm_alloc(1, sizeof *r.human), .options = options, .err = err};
    nqm_status status = r.human ? nqm_csv_load(csv_path, &csv, err) : nqm_fail_nomem(err, sizeof *r.human);
    if (status == NQM_OK)
        status = nqm_answers_read(csv, csv_path, &r.answers, err);
    if (status == NQM_OK) {
        r.human->kind = r.answers.kind;
        r.human->n_rows = r.answers.n_rows;
        status = sort_entries(&r);
    }
    if (status == NQM_OK)
        status = nqm_index_create(2 * r.n_entries, key_of_sampled, &r.by_name, err);
    if (status == NQM_OK)
        status = build_dataset(&r);
    if (status == NQM_OK)
        status = r.answers.kind == NQM_HUMAN_CHOICE ? gather_triplets(&r) : find_ceiling(&r);
    nqm_free(r.answers.values);
    nqm_free(r.entries);
    nqm_index_free(&r.by_name);
    nqm_csv_free(csv);
    if (status == NQM_OK)
        *human_ret = r.human;
    else
        nqm_human_free(r.human);
    return status;
}
