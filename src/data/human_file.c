/* SPDX-License-Identifier: MIT
 *
 * The answers of people as a dataset: the BRDFs that they name are sampled. Rows are sorted by reference and test, so
 * that each reference, and each test of it, is opened once.
 */
#include "brdf/brdf.h"
#include "data/human.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* One test of one row. Strings are lent by the CSV. */
typedef struct entry {
    const char *ref, *test;
    size_t row, slot; /* slot 1: test_b */
} entry;

typedef struct reader {
    nqm_human *human;
    nqm_dataset *d;
    nqm_answers answers;
    const nqm_human_options *options;
    size_t n_entries;
    entry *entries;     /* (n_entries) sorted */
    uint32_t *pair_of;  /* (n_rows, n_slots) */
    size_t *ref_entry;  /* (n_refs) first entry of each reference */
    size_t *pair_entry; /* (n_pairs) likewise */
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

static bool same_pair(const entry *a, const entry *b) {
    return strcmp(a->ref, b->ref) == 0 && strcmp(a->test, b->test) == 0;
}

/* Number references and pairs. With choices equal pairs are one; a score is a pair of its own. */
static void number_pairs(reader *r, uint32_t *pair_ref) {
    qsort(r->entries, r->n_entries, sizeof *r->entries, compare_entries);
    for (size_t i = 0; i < r->n_entries; ++i) {
        const entry *e = &r->entries[i];
        if (i == 0 || strcmp(e->ref, e[-1].ref) != 0)
            r->ref_entry[r->d->n_refs++] = i;
        if (i == 0 || r->answers.n_slots == 1 || !same_pair(e, e - 1)) {
            pair_ref[r->d->n_pairs] = (uint32_t)(r->d->n_refs - 1);
            r->pair_entry[r->d->n_pairs++] = i;
        }
        r->pair_of[e->row * r->answers.n_slots + e->slot] = (uint32_t)(r->d->n_pairs - 1);
    }
}

/* Index of a name among `names`, appended when new. */
static uint32_t intern(size_t *n, const char **names, const char *name) {
    size_t i = *n;
    while (i-- > 0)
        if (strcmp(names[i], name) == 0)
            return (uint32_t)i;
    names[*n] = name;
    return (uint32_t)(*n)++;
}

/* The material of a reference, which is the same in all of its rows; without that column the reference itself. */
static nqm_status group_references(reader *r, uint32_t *ref_group, const char **group_names) {
    for (size_t ref = 0; ref < r->d->n_refs; ++ref) {
        size_t first = r->ref_entry[ref], end = ref + 1 < r->d->n_refs ? r->ref_entry[ref + 1] : r->n_entries;
        const char *name = r->entries[first].ref;
        if (r->answers.material >= 0)
            name = nqm_csv_text(r->answers.csv, r->entries[first].row, r->answers.material);
        for (size_t i = first; r->answers.material >= 0 && i < end; ++i)
            if (strcmp(nqm_csv_text(r->answers.csv, r->entries[i].row, r->answers.material), name) != 0)
                return nqm_fail(
                    r->err, NQM_ERR_INCOMPATIBLE, -1,
                    "%s: row %zu: the reference '%.100s' is of material '%.60s' here, and '%.60s' in row %zu",
                    r->answers.path, r->entries[i].row + 1, r->entries[i].ref,
                    nqm_csv_text(r->answers.csv, r->entries[i].row, r->answers.material), name,
                    r->entries[first].row + 1);
        ref_group[ref] = intern(&r->d->n_groups, group_names, name);
    }
    return NQM_OK;
}

/* ---- samples ----------------------------------------------------------------------------------------------------- */

/* Sample a BRDF; used (n_directions) becomes 1 where it has a value. */
static nqm_status sample_brdf(const reader *r, const char *name, size_t row, float *rgb, uint8_t *used) {
    nqm_error inner = {0};
    nqm_brdf *brdf = NULL;
    nqm_status status = nqm_brdf_open_below(name, r->options->root, &brdf, &inner);
    if (status == NQM_OK)
        status = nqm_sample(brdf, r->d->directions, NQM_INVALID_DROP, rgb, used, NULL, &inner);
    for (size_t i = 0; status == NQM_OK && i < r->d->n_directions; ++i)
        used[i] = used[i] == NQM_VALUE_OK || used[i] == NQM_VALUE_CLAMPED;
    nqm_brdf_free(brdf);
    return status == NQM_OK ? NQM_OK
                            : nqm_fail(r->err, status, inner.byte_offset, "%s: row %zu: %.400s", r->answers.path,
                                       row + 1, inner.message);
}

static nqm_status check_valid(const reader *r, size_t pair, const uint8_t *ref_used, const uint8_t *test_used) {
    size_t n_valid = 0, n = r->d->n_directions;
    for (size_t i = 0; i < n; ++i)
        n_valid += ref_used[i] && test_used[i];
    if (n_valid > 0 && (double)n_valid >= r->options->min_valid_fraction * (double)n)
        return NQM_OK;
    const entry *e = &r->entries[r->pair_entry[pair]];
    return nqm_fail(r->err, NQM_ERR_INCOMPATIBLE, -1,
                    "%s: row %zu: only at %zu of %zu directions have both BRDFs a value ('%.100s', '%.100s')",
                    r->answers.path, e->row + 1, n_valid, n, e->ref, e->test);
}

static nqm_status sample_pairs(reader *r, float *ref_rgb, float *test_rgb, uint8_t *ref_used, uint8_t *test_used) {
    nqm_status status = NQM_OK;
    size_t n = r->d->n_directions;
    nqm_ticker ticker = {.fn = r->options->progress, .user = r->options->progress_user};
    for (size_t ref = 0; status == NQM_OK && ref < r->d->n_refs; ++ref) {
        const entry *e = &r->entries[r->ref_entry[ref]];
        status = sample_brdf(r, e->ref, e->row, ref_rgb + 3 * n * ref, ref_used + n * ref);
    }
    for (size_t pair = 0; status == NQM_OK && pair < r->d->n_pairs; ++pair) {
        const entry *e = &r->entries[r->pair_entry[pair]];
        float *rgb = test_rgb + 3 * n * pair;
        uint8_t *used = test_used + n * pair;
        if (pair > 0 && same_pair(e, e - 1)) { /* one more score of the same pair */
            memcpy(rgb, rgb - 3 * n, 3 * n * sizeof *rgb);
            memcpy(used, used - n, n);
        } else {
            status = sample_brdf(r, e->test, e->row, rgb, used);
        }
        if (status == NQM_OK)
            status = check_valid(r, pair, ref_used + n * r->d->pair_ref[pair], used);
        if (status == NQM_OK && nqm_tick(&ticker, "sample", (double)(pair + 1), (double)r->d->n_pairs))
            status = nqm_fail(r->err, NQM_ERR_CANCELLED, -1, "interrupted");
    }
    return status;
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

static int compare_triplets(const void *x, const void *y) {
    const nqm_triplet *p = x, *q = y;
    int order = (p->group > q->group) - (p->group < q->group);
    if (order == 0)
        order = (p->a > q->a) - (p->a < q->a);
    return order ? order : (p->b > q->b) - (p->b < q->b);
}

/* Rows about the same three BRDFs become one triplet, whichever test is called a. */
static nqm_status gather_triplets(reader *r) {
    nqm_human *h = r->human;
    h->triplets = nqm_alloc(r->answers.n_rows, sizeof *h->triplets);
    if (!h->triplets)
        return nqm_fail_nomem(r->err, r->answers.n_rows * sizeof *h->triplets);
    for (size_t row = 0; row < r->answers.n_rows; ++row) {
        const uint32_t *pair = r->pair_of + 2 * row;
        const double *n = r->answers.values + 2 * row;
        bool swap = pair[0] > pair[1];
        h->triplets[row] = (nqm_triplet){.group = r->d->ref_group[r->d->pair_ref[pair[0]]],
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

static void fill_labels(const reader *r, double *delta_e, double *jod, uint32_t *pair_kind, const char **kind_names) {
    for (size_t pair = 0; pair < r->d->n_pairs; ++pair) {
        size_t row = r->entries[r->pair_entry[pair]].row;
        double value = r->answers.n_slots == 1 ? r->answers.values[row] : (double)NAN;
        delta_e[pair] = NAN;
        jod[pair] = r->human->kind == NQM_HUMAN_DISTANCE ? -value : value;
        bool named = r->answers.test_kind >= 0;
        pair_kind[pair] = intern(&r->d->n_kinds, kind_names,
                                 named ? nqm_csv_text(r->answers.csv, row, r->answers.test_kind) : "human");
    }
}

static nqm_status fill_dataset(reader *r) {
    nqm_dataset *d = r->d;
    size_t n = r->n_entries;
    uint32_t *pair_ref = nqm_dataset_alloc(d, n, sizeof *pair_ref),
             *ref_group = nqm_dataset_alloc(d, n, sizeof *ref_group);
    uint32_t *pair_kind = nqm_dataset_alloc(d, n, sizeof *pair_kind);
    uint8_t *group_split = nqm_dataset_alloc(d, n, 1);
    const char **ref_names = nqm_dataset_alloc(d, n, sizeof *ref_names);
    const char **group_names = nqm_dataset_alloc(d, n, sizeof *group_names);
    const char **kind_names = nqm_dataset_alloc(d, n, sizeof *kind_names);
    const char **pair_names = nqm_dataset_alloc(d, n, sizeof *pair_names);
    double *delta_e = nqm_dataset_alloc(d, n, sizeof *delta_e), *jod = nqm_dataset_alloc(d, n, sizeof *jod);
    if (!pair_ref || !ref_group || !pair_kind || !group_split || !ref_names || !group_names || !kind_names ||
        !pair_names || !delta_e || !jod)
        return nqm_fail_nomem(r->err, n * 8 * sizeof(double));
    number_pairs(r, pair_ref);
    nqm_status status = group_references(r, ref_group, group_names);
    if (status != NQM_OK)
        return status;
    fill_labels(r, delta_e, jod, pair_kind, kind_names);
    memset(group_split, NQM_SPLIT_TEST, d->n_groups);
    for (size_t i = 0; i < d->n_refs; ++i)
        ref_names[i] = r->entries[r->ref_entry[i]].ref;
    for (size_t i = 0; i < d->n_pairs; ++i)
        pair_names[i] = r->entries[r->pair_entry[i]].test;
    d->pair_ref = pair_ref;
    d->ref_group = ref_group;
    d->pair_kind = pair_kind;
    d->group_split = group_split;
    d->ref_names = ref_names;
    d->group_names = group_names;
    d->kind_names = kind_names;
    d->pair_names = pair_names;
    d->delta_e = delta_e;
    d->jod = jod;
    d->order_only = r->human->kind != NQM_HUMAN_JOD;
    return NQM_OK;
}

static nqm_status fill_samples(reader *r) {
    nqm_dataset *d = r->d;
    const nqm_directions *lent = r->options->directions;
    nqm_status status = lent ? nqm_directions_from_degrees(nqm_directions_count(lent), nqm_directions_degrees(lent),
                                                           &d->directions, r->err)
                             : nqm_directions_create(NULL, 0, NULL, &d->directions, r->err);
    if (status != NQM_OK)
        return status;
    size_t n = d->n_directions = nqm_directions_count(d->directions);
    d->directions_deg = nqm_directions_degrees(d->directions);
    float *ref_rgb = nqm_dataset_alloc(d, d->n_refs, 3 * n * sizeof *ref_rgb);
    float *test_rgb = nqm_dataset_alloc(d, d->n_pairs, 3 * n * sizeof *test_rgb);
    uint8_t *ref_used = nqm_dataset_alloc(d, d->n_refs, n), *test_used = nqm_dataset_alloc(d, d->n_pairs, n);
    if (!ref_rgb || !test_rgb || !ref_used || !test_used)
        return nqm_fail_nomem(r->err, (d->n_refs + d->n_pairs) * n * 13);
    d->ref_rgb = ref_rgb;
    d->test_rgb = test_rgb;
    d->ref_used = ref_used;
    d->test_used = test_used;
    status = sample_pairs(r, ref_rgb, test_rgb, ref_used, test_used);
    return status == NQM_OK ? nqm_dataset_hash(d, d->sha256, r->err) : status;
}

static nqm_status begin(reader *r) {
    const nqm_answers *a = &r->answers;
    r->n_entries = a->n_rows * a->n_slots;
    r->entries = nqm_alloc(r->n_entries, sizeof *r->entries);
    r->pair_of = nqm_alloc(r->n_entries, sizeof *r->pair_of);
    r->ref_entry = nqm_alloc(r->n_entries, sizeof *r->ref_entry);
    r->pair_entry = nqm_alloc(r->n_entries, sizeof *r->pair_entry);
    if (!r->entries || !r->pair_of || !r->ref_entry || !r->pair_entry)
        return nqm_fail_nomem(r->err, r->n_entries * (sizeof(entry) + 2 * sizeof(size_t)));
    for (size_t i = 0; i < r->n_entries; ++i) {
        size_t row = i / a->n_slots, slot = i % a->n_slots;
        r->entries[i] =
            (entry){nqm_csv_text(a->csv, row, a->reference), nqm_csv_text(a->csv, row, a->test[slot]), row, slot};
    }
    return NQM_OK;
}

static nqm_status read_all(reader *r, const char *csv_path) {
    nqm_status status = nqm_csv_load(csv_path, &r->human->csv, r->err);
    if (status == NQM_OK)
        status = nqm_answers_read(r->human->csv, csv_path, &r->answers, r->err);
    r->human->kind = r->answers.kind;
    if (status == NQM_OK)
        status = begin(r);
    if (status == NQM_OK)
        status = fill_dataset(r);
    if (status == NQM_OK && r->human->kind == NQM_HUMAN_CHOICE)
        status = gather_triplets(r);
    return status == NQM_OK ? fill_samples(r) : status;
}

nqm_status nqm_human_load(const char *csv_path, const nqm_human_options *options, nqm_human **human_ret,
                          nqm_error *err) {
    *human_ret = NULL;
    nqm_human_options o = options ? *options : nqm_human_options_default();
    if (!(o.min_valid_fraction >= 0 && o.min_valid_fraction <= 1))
        return nqm_fail(err, NQM_ERR_ARG, -1, "fraction of valid directions: %g is outside 0..1", o.min_valid_fraction);
    nqm_human *human = nqm_alloc(1, sizeof *human);
    if (human)
        human->dataset = nqm_alloc(1, sizeof *human->dataset);
    reader r = {.human = human, .options = &o, .err = err};
    nqm_status status = NQM_OK;
    if (!human || !human->dataset)
        status = nqm_fail_nomem(err, sizeof *human);
    r.d = human ? human->dataset : NULL;
    if (status == NQM_OK)
        status = read_all(&r, csv_path);
    void *blocks[] = {r.answers.values, r.entries, r.pair_of, r.ref_entry, r.pair_entry};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; ++i)
        nqm_free(blocks[i]);
    if (status == NQM_OK)
        *human_ret = human;
    else
        nqm_human_free(human);
    return status;
}
