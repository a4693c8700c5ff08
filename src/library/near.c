/* SPDX-License-Identifier: MIT
 *
 * Members that look like another BRDF, or like each other: candidates by pictures, then scores.
 */
#include "library/library.h"
#include "math/math.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

enum { BLOCK = 1024 };

/* ---- the nearest ------------------------------------------------------------------------------------------------- */

typedef struct scan_job {
    const nqm_gallery *one; /* picture 0 is that of the material */
    const nqm_library *among;
    bool is_apart;
    float *jod; /* (n) */
} scan_job;

static void scan(void *user, size_t block) {
    const scan_job *job = user;
    const size_t first = block * BLOCK, n = nqm_smaller(job->among->n - first, BLOCK);
    nqm_gallery_jods(job->one, 0, job->among->state->gallery, first, n, job->is_apart, job->jod + first);
}

/* The members by their estimates, the best first. */
static nqm_status find_candidates(const nqm_gallery *one, const nqm_library *among, bool is_apart,
                                  nqm_indexed **candidates_ret, nqm_error *err) {
    scan_job job = {one, among, is_apart, NULL};
    double *keys;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&job.jod, among->n, sizeof *job.jod}, {&keys, among->n, sizeof *keys}), err);
    *candidates_ret = nqm_alloc(among->n, sizeof **candidates_ret);
    if (status == NQM_OK && !*candidates_ret)
        status = nqm_fail_nomem(err, among->n * sizeof **candidates_ret);
    if (status == NQM_OK) {
        nqm_parallel_for(nqm_ceil_div(among->n, BLOCK), scan, &job);
        for (size_t i = 0; i < among->n; ++i)
            keys[i] = isnan(job.jod[i]) ? (double)INFINITY : -(double)job.jod[i];
        nqm_sort_indexed(among->n, keys, *candidates_ret);
    }
    nqm_free(job.jod);
    return status;
}

/* A score of textures takes a second: of candidates with one, twice as many are scored as are wanted. Returns how many remain. */
static size_t leave_textured(bool is_textured, const nqm_library *of, size_t n_wanted, nqm_indexed *candidates,
                             size_t n) {
    size_t n_left = 0, n_textured = 0;
    for (size_t i = 0; i < n; ++i)
        if (!(is_textured || of->members[candidates[i].index].is_textured) || n_textured++ < 2 * n_wanted)
            candidates[n_left++] = candidates[i];
    return n_left;
}

/* Best first, those without a score last; equal ones as they were. */
static nqm_status sort_best(struct nqm_library_state *s, bool is_apart, nqm_error *err) {
    nqm_library_pair *sorted;
    double *keys;
    nqm_indexed *order;
    const size_t n = s->n_pairs;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&sorted, n, sizeof *sorted}, {&keys, n, sizeof *keys}, {&order, n, sizeof *order}), err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        const nqm_score_result *r = &s->pairs[i].result;
        const double quality = is_apart ? r->similarity[0] : r->jod;
        keys[i] = s->pairs[i].error.status != NQM_OK ? (double)INFINITY : isnan(quality) ? 1e300 : -quality;
    }
    if (status == NQM_OK) {
        nqm_sort_indexed(n, keys, order);
        for (size_t i = 0; i < n; ++i)
            sorted[i] = s->pairs[order[i].index];
        memcpy(s->pairs, sorted, n * sizeof *sorted);
    }
    nqm_free(sorted);
    return status;
}

static nqm_status score_nearest(nqm_library *of, const nqm_library_query *query, const nqm_library_member *to,
                                const nqm_gallery *one, nqm_error *err) {
    enum { LEAST_SCORED = 128 };
    struct nqm_library_state *s = of->state;
    nqm_indexed *candidates;
    nqm_status status = find_candidates(one, of, query->is_apart, &candidates, err);
    size_t n = nqm_smaller(of->n, nqm_larger(LEAST_SCORED, 4 * query->n));
    if (status == NQM_OK) {
        n = leave_textured(to->is_textured, of, query->n, candidates, n);
        status = nqm_library_begin_pairs(s, n, err);
    }
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        nqm_library_set_pair(s, i, to, SIZE_MAX, &of->members[candidates[i].index], candidates[i].index);
    nqm_free(candidates);
    if (status == NQM_OK)
        status = nqm_library_score(s, n, true, err);
    return status == NQM_OK ? sort_best(s, query->is_apart, err) : status;
}

static nqm_status find_nearest(nqm_library *of, const nqm_library_query *query, nqm_error *err) {
    struct nqm_library_state *s = of->state;
    nqm_argument *to = nqm_argument_parse(query->to, NULL);
    if (!to)
        return nqm_fail_nomem(err, strlen(query->to) + 1);
    nqm_gallery *one = NULL;
    nqm_error why = {0};
    const nqm_library_member self = {query->to, NULL, nqm_argument_is_textured(to)};
    nqm_argument_free(to);
    nqm_status status = nqm_gallery_create(s->model, 1, NULL, &one, err);
    if (status == NQM_OK)
        status = nqm_library_need_scorer(s, err);
    if (status == NQM_OK)
        status = nqm_library_draw_one(s, &self, one, 0, &why, err);
    if (status == NQM_OK && why.status != NQM_OK)
        status = nqm_fail(err, why.status, why.byte_offset, "%s", why.message);
    if (status == NQM_OK)
        status = nqm_library_draw(of, err);
    if (status == NQM_OK)
        status = score_nearest(of, query, &self, one, err);
    nqm_gallery_free(one);
    return status;
}

/* ---- pairs ------------------------------------------------------------------------------------------------------- */

/* Two members, first < second. */
typedef struct near_pair {
    size_t a, b;
} near_pair;

typedef struct row_job {
    const nqm_library *of;
    double least;
    near_pair **rows;     /* (n) */
    size_t *n_rows;       /* (n) */
    atomic_bool is_short; /* of memory */
} row_job;

static void find_row(void *user, size_t a) {
    row_job *job = user;
    const nqm_gallery *gallery = job->of->state->gallery;
    float jod[BLOCK];
    size_t max_n = 0;
    for (size_t begin = a + 1, n; begin < job->of->n; begin += n) {
        n = nqm_smaller(job->of->n - begin, BLOCK);
        nqm_gallery_jods(gallery, a, gallery, begin, n, false, jod);
        for (size_t i = 0; i < n; ++i) {
            if ((double)jod[i] < job->least)
                continue;
            near_pair *grown = nqm_grow(job->rows[a], &max_n, job->n_rows[a] + 1, sizeof *grown);
            if (!grown) {
                job->is_short = true;
                return;
            }
            job->rows[a] = grown;
            grown[job->n_rows[a]++] = (near_pair){a, begin + i};
        }
    }
}

/* Pairs that may have this JOD. */
static nqm_status find_pairs(const nqm_library *of, double jod, near_pair **pairs_ret, size_t *n_ret, nqm_error *err) {
    row_job job = {.of = of, .least = nqm_library_least_estimate(jod)};
    size_t n = 0;
    *pairs_ret = NULL;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&job.rows, of->n, sizeof *job.rows}, {&job.n_rows, of->n, sizeof *job.n_rows}), err);
    if (status == NQM_OK && nqm_parallel_ticking(&of->state->ticker, "compare", of->n, find_row, &job))
        status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted");
    for (size_t a = 0; job.rows && a < of->n; ++a)
        n += job.n_rows[a];
    if (status == NQM_OK)
        *pairs_ret = nqm_alloc(n, sizeof **pairs_ret);
    if (status == NQM_OK && (job.is_short || !*pairs_ret))
        status = nqm_fail_nomem(err, n * sizeof **pairs_ret);
    *n_ret = 0;
    for (size_t a = 0; job.rows && a < of->n; ++a) {
        if (status == NQM_OK && job.n_rows[a])
            memcpy(*pairs_ret + *n_ret, job.rows[a], job.n_rows[a] * sizeof **pairs_ret);
        *n_ret += job.n_rows[a];
        nqm_free(job.rows[a]);
    }
    nqm_free(job.rows);
    return status;
}

/* Score both orders of the pairs; pairs below the JOD are removed. */
static nqm_status confirm(const nqm_library *of, double jod, near_pair *pairs, size_t *n_pairs, nqm_error *err) {
    struct nqm_library_state *s = of->state;
    const size_t n = *n_pairs;
    nqm_status status = NQM_OK;
    *n_pairs = 0;
    for (size_t first = 0, n_block; status == NQM_OK && first < n; first += n_block) {
        n_block = nqm_smaller(n - first, NQM_SCORE_BLOCK / 2);
        status = nqm_library_step(s, "score", first, n, err);
        if (status == NQM_OK)
            status = nqm_library_begin_pairs(s, 2 * n_block, err);
        for (size_t i = 0; status == NQM_OK && i < n_block; ++i) {
            const near_pair *p = &pairs[first + i];
            const nqm_library_member *a = &of->members[p->a], *b = &of->members[p->b];
            nqm_library_set_pair(s, 2 * i, a, p->a, b, p->b);
            nqm_library_set_pair(s, 2 * i + 1, b, p->b, a, p->a);
        }
        if (status == NQM_OK)
            status = nqm_library_score_few(s, 2 * n_block, err);
        for (size_t i = 0; status == NQM_OK && i < n_block; ++i)
            if (s->pairs[2 * i].result.jod >= jod && s->pairs[2 * i + 1].result.jod >= jod) /* false for NaN */
                pairs[(*n_pairs)++] = pairs[first + i];
    }
    return status;
}

/* ---- clusters ---------------------------------------------------------------------------------------------------- */

/* The members that look like a member in both orders, as lists after one another. */
typedef struct graph {
    size_t n, *begin; /* (n + 2) */
    size_t *to;
    size_t *kept; /* (n) the member that is kept for each */
    nqm_indexed *order;
    double *key;
} graph;

static nqm_status make_graph(size_t n, const near_pair *pairs, size_t n_pairs, graph *g, nqm_error *err) {
    *g = (graph){.n = n};
    const nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&g->begin, n + 2, sizeof *g->begin}, {&g->to, 2 * n_pairs, sizeof *g->to},
                   {&g->kept, n, sizeof *g->kept}, {&g->order, n, sizeof *g->order}, {&g->key, n, sizeof *g->key}),
        err);
    if (status != NQM_OK)
        return status;
    size_t *place = g->begin + 1;
    for (size_t i = 0; i < n_pairs; ++i) {
        ++g->begin[pairs[i].a + 2];
        ++g->begin[pairs[i].b + 2];
    }
    for (size_t i = 2; i < n + 2; ++i)
        g->begin[i] += g->begin[i - 1];
    for (size_t i = 0; i < n_pairs; ++i) { /* place[a] becomes begin[a + 1] */
        g->to[place[pairs[i].a]++] = pairs[i].b;
        g->to[place[pairs[i].b]++] = pairs[i].a;
    }
    return NQM_OK;
}

/* Set the member that is kept for each. Returns how many are replaced. */
static size_t make_clusters(graph *g) {
    size_t n_replaced = 0;
    for (size_t i = 0; i < g->n; ++i) {
        g->key[i] = -(double)(g->begin[i + 1] - g->begin[i]);
        g->kept[i] = SIZE_MAX;
    }
    nqm_sort_indexed(g->n, g->key, g->order);
    for (size_t k = 0; k < g->n; ++k) {
        const size_t keep = g->order[k].index;
        if (g->kept[keep] != SIZE_MAX)
            continue;
        g->kept[keep] = keep;
        for (size_t e = g->begin[keep]; e < g->begin[keep + 1]; ++e)
            if (g->kept[g->to[e]] == SIZE_MAX) {
                g->kept[g->to[e]] = keep;
                ++n_replaced;
            }
    }
    return n_replaced;
}

/* The pairs of a replaced member and the one that is kept for it, clusters after one another. */
static nqm_status score_replaced(nqm_library *of, graph *g, nqm_error *err) {
    struct nqm_library_state *s = of->state;
    const size_t n = make_clusters(g), *kept = g->kept;
    size_t *first = nqm_alloc(of->n + 1, sizeof *first);
    nqm_status status = first ? nqm_library_begin_pairs(s, n, err) : nqm_fail_nomem(err, of->n * sizeof *first);
    if (status != NQM_OK) {
        nqm_free(first);
        return status;
    }
    for (size_t i = 0; i < of->n; ++i)
        first[kept[i] + 1] += kept[i] != i;
    for (size_t i = 1; i <= of->n; ++i)
        first[i] += first[i - 1];
    for (size_t i = 0; i < of->n; ++i)
        if (kept[i] != i)
            nqm_library_set_pair(s, first[kept[i]]++, &of->members[i], i, &of->members[kept[i]], kept[i]);
    nqm_free(first);
    return nqm_library_score(s, n, false, err);
}

static nqm_status find_clusters(nqm_library *of, double jod, nqm_error *err) {
    near_pair *pairs = NULL;
    graph g = {.n = 0};
    size_t n = 0;
    nqm_status status = nqm_library_draw(of, err);
    if (status == NQM_OK)
        status = find_pairs(of, jod, &pairs, &n, err);
    if (status == NQM_OK)
        status = confirm(of, jod, pairs, &n, err);
    if (status == NQM_OK)
        status = make_graph(of->n, pairs, n, &g, err);
    if (status == NQM_OK)
        status = score_replaced(of, &g, err);
    nqm_free(g.begin);
    nqm_free(pairs);
    return status;
}

nqm_status nqm_library_near(nqm_library *library, const nqm_library_query *query, size_t *n_ret,
                            const nqm_library_pair **pairs_ret, nqm_error *err) {
    NQM_REQUIRE(err, library, query, n_ret, pairs_ret);
    if (!library->state->model)
        return nqm_fail(err, NQM_ERR_MODEL, -1, "%s: the library was opened without a model", library->path);
    if (query->to ? query->n < 1 || query->n > 1000 : !(query->jod >= 9 && query->jod <= 10))
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        query->to ? "the number of nearest materials is 1 to 1000" : "the JOD is 9 to 10");
    const nqm_status status = query->to ? find_nearest(library, query, err) : find_clusters(library, query->jod, err);
    *n_ret = status == NQM_OK ? library->state->n_pairs : 0;
    *pairs_ret = status == NQM_OK ? library->state->pairs : NULL;
    return status;
}
