/* SPDX-License-Identifier: MIT
 *
 * Which texel pairs are alike. Each pair gets a key of 64 bits: up to 8 bits of each dimension within its range, interleaved (Morton
 * 1966), or a hash of all bits. Sorted keys bring similar pairs together.
 */
#include "texture/texels.h"

#include <math.h>

enum { BLOCK = NQM_TEXEL_BLOCK, CHUNK = NQM_TEXEL_CHUNK, LEVELS = 256 };

/* A pass over all texels. */
typedef struct pass {
    nqm_texel_pair *pair;
    float (*ranges)[2];               /* (n_chunks, n_dimensions) low and high; NULL: keys are wanted */
    const uint64_t (*spread)[LEVELS]; /* (n_dimensions) the bits of each level; NULL: hashes */
    uint64_t *keys;                   /* (n) */
    uint8_t *failed;                  /* (n_chunks) out of memory */
    void (*visit)(struct pass *p, size_t chunk, size_t first, size_t n, const float *dimensions);
} pass;

/* ---- dimensions -------------------------------------------------------------------------------------------------- */

/* A component of a property, as it is compared. */
static void find_row(const nqm_pair_property *p, size_t side, const float *values, size_t c, size_t n, float *out) {
    const float *in = p->at[side] < 0 ? NULL : values + ((size_t)p->at[side] + c) * BLOCK;
    if (!in)
        for (size_t i = 0; i < n; ++i)
            out[i] = p->constant[side][c];
    else
        memcpy(out, in, n * sizeof *out);
    for (size_t i = 0; p->n == 3 && i < n; ++i)
        out[i] = sqrtf(out[i] > 0 ? out[i] : 0);
}

static void find_tilts(const nqm_texel_pair *pair, size_t n, const float *const values[2], float tilts[2][BLOCK]) {
    for (size_t i = 0; i < n; ++i) {
        double normal[2][3], tilt[3];
        for (size_t s = 0; s < 2; ++s)
            nqm_texel_pair_normal(pair, s, values[s], i, normal[s]);
        nqm_texel_pair_tilt(normal[0], normal[1], tilt);
        tilts[0][i] = (float)tilt[0];
        tilts[1][i] = (float)tilt[1];
    }
}

/* Differences are of the same property; equal values give exactly 0. */
static void find_dimensions(const nqm_texel_pair *pair, size_t n, const float *const values[2], float *out) {
    float ref[BLOCK], tilts[2][BLOCK];
    if (nqm_texel_pair_tilts(pair))
        find_tilts(pair, n, values, tilts);
    for (size_t k = 0; k < pair->n_dimensions; ++k, out += BLOCK) {
        const nqm_pair_dimension *d = &pair->dimensions[k];
        const nqm_pair_property *p = &pair->properties[d->property];
        if (d->kind == NQM_NORMAL) {
            memcpy(out, tilts[d->component], n * sizeof *out);
            continue;
        }
        const size_t side = d->kind == NQM_OF_REF ? 0 : 1;
        find_row(p, side, values[side], d->component, n, out);
        if (d->kind != NQM_DIFFERENCE)
            continue;
        find_row(p, 0, values[0], d->component, n, ref);
        for (size_t i = 0; i < n; ++i)
            out[i] -= ref[i];
    }
}

static void visit_chunk(void *user, size_t chunk) {
    pass *p = user;
    const nqm_texel_pair *pair = p->pair;
    const size_t n_values = nqm_texel_pair_workspace(pair);
    const size_t end = nqm_smaller((chunk + 1) * CHUNK, pair->n);
    float *workspace = nqm_alloc(n_values + pair->n_dimensions * BLOCK, sizeof *workspace);
    p->failed[chunk] = !workspace;
    for (size_t first = chunk * CHUNK, n; workspace && first < end; first += n) {
        const float *values[2];
        n = nqm_smaller(end - first, BLOCK);
        nqm_texel_pair_evaluate(pair, n, NULL, first, workspace, values);
        find_dimensions(pair, n, values, workspace + n_values);
        p->visit(p, chunk, first, n, workspace + n_values);
    }
    nqm_free(workspace);
}

static nqm_status run(pass *p, nqm_ticker *ticker, nqm_error *err) {
    const size_t n_chunks = nqm_ceil_div(p->pair->n, CHUNK);
    bool has_failed = false;
    p->failed = nqm_alloc(n_chunks, 1);
    if (!p->failed)
        return nqm_fail_nomem(err, n_chunks);
    const bool is_stopped = nqm_parallel_ticking(ticker, "texels", n_chunks, visit_chunk, p);
    for (size_t i = 0; i < n_chunks; ++i)
        has_failed = has_failed || p->failed[i];
    nqm_free(p->failed);
    if (is_stopped)
        return nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
    return has_failed ? nqm_fail_nomem(err, nqm_texel_pair_workspace(p->pair) * sizeof(float)) : NQM_OK;
}

/* ---- ranges ------------------------------------------------------------------------------------------------------ */

static void visit_ranges(pass *p, size_t chunk, size_t first, size_t n, const float *in) {
    const size_t n_dimensions = p->pair->n_dimensions;
    float(*range)[2] = p->ranges + chunk * n_dimensions;
    for (size_t d = 0; d < n_dimensions; ++d, in += BLOCK) {
        float low = first == chunk * CHUNK ? in[0] : range[d][0], high = first == chunk * CHUNK ? in[0] : range[d][1];
        for (size_t i = 0; i < n; ++i) {
            low = in[i] < low ? in[i] : low;
            high = in[i] > high ? in[i] : high;
        }
        range[d][0] = low;
        range[d][1] = high;
    }
}

nqm_status nqm_texel_pair_measure(nqm_texel_pair *pair, nqm_ticker *ticker, nqm_error *err) {
    const size_t n_chunks = nqm_ceil_div(pair->n, CHUNK), n = pair->n_dimensions;
    pass p = {.pair = pair, .visit = visit_ranges, .ranges = nqm_alloc(n_chunks * n, sizeof *p.ranges)};
    nqm_status status = p.ranges ? run(&p, ticker, err) : nqm_fail_nomem(err, n_chunks * n * sizeof *p.ranges);
    pair->n_dimensions = 0;
    for (size_t d = 0; status == NQM_OK && d < n; ++d) {
        nqm_pair_dimension at = pair->dimensions[d];
        at.low = p.ranges[d][0];
        at.high = p.ranges[d][1];
        for (size_t i = 1; i < n_chunks; ++i) {
            at.low = fminf(at.low, p.ranges[i * n + d][0]);
            at.high = fmaxf(at.high, p.ranges[i * n + d][1]);
        }
        /* A constant difference tells no texels apart, but is one. */
        const bool is_difference = at.kind == NQM_DIFFERENCE || at.kind == NQM_NORMAL;
        if (at.high > at.low || (is_difference && at.high != 0))
            pair->dimensions[pair->n_dimensions++] = at;
    }
    nqm_free(p.ranges);
    return status;
}

/* ---- keys -------------------------------------------------------------------------------------------------------- */

/* Differences and normals are finer near 0. */
static size_t level_of(const nqm_pair_dimension *d, float v) {
    if (d->kind == NQM_OF_REF || d->kind == NQM_OF_TEST)
        return d->high > d->low ? (size_t)((v - d->low) / (d->high - d->low) * 255.0f + 0.5f) : 0;
    const float most = fmaxf(fabsf(d->low), fabsf(d->high)), part = most > 0 ? sqrtf(fabsf(v) / most) : 0;
    return (size_t)(128 + (int)lrintf(copysignf(part, v) * 127));
}

/* Deal the 64 bits to the dimensions, one each in turn, the highest of each first. */
static void spread_levels(const nqm_texel_pair *pair, uint64_t (*spread)[LEVELS]) {
    size_t left = 64;
    for (int bit = 7; bit >= 0; --bit)
        for (size_t d = 0; d < pair->n_dimensions && left; ++d) {
            if (pair->dimensions[d].high == pair->dimensions[d].low)
                continue;
            --left;
            for (size_t level = 0; level < LEVELS; ++level)
                spread[d][level] |= (uint64_t)(level >> bit & 1) << left;
        }
}

static void visit_keys(pass *p, size_t chunk, size_t first, size_t n, const float *in) {
    uint64_t *keys = p->keys + first;
    (void)chunk;
    for (size_t d = 0; d < p->pair->n_dimensions; ++d, in += BLOCK)
        for (size_t i = 0; i < n; ++i) {
            uint32_t bits;
            const float v = in[i] + 0.0f; /* no -0 */
            memcpy(&bits, &v, sizeof bits);
            if (p->spread)
                keys[i] |= p->spread[d][level_of(&p->pair->dimensions[d], v)];
            else
                keys[i] = nqm_hash_mix(keys[i] + bits + NQM_GOLDEN);
        }
}

/* Sort texels by their keys, stably, by 16 bits at a time; `other` are arrays of the same size. */
static void sort(size_t n, uint64_t *keys, uint32_t *order, uint64_t *other_keys, uint32_t *other_order,
                 uint32_t *count) {
    enum { BITS = 16, DIGITS = 1 << BITS };
    uint64_t *const sorted_keys = keys;
    uint32_t *const sorted_order = order;
    for (unsigned shift = 0; shift < 64; shift += BITS) {
        memset(count, 0, DIGITS * sizeof *count);
        for (size_t i = 0; i < n; ++i)
            ++count[keys[i] >> shift & (DIGITS - 1)];
        if (count[keys[0] >> shift & (DIGITS - 1)] == n)
            continue;
        for (size_t k = 0, sum = 0, next; k < DIGITS; ++k, sum = next) {
            next = sum + count[k];
            count[k] = (uint32_t)sum;
        }
        for (size_t i = 0; i < n; ++i) {
            const uint32_t to = count[keys[i] >> shift & (DIGITS - 1)]++;
            other_keys[to] = keys[i];
            other_order[to] = order[i];
        }
        uint64_t *const swapped_keys = keys;
        uint32_t *const swapped_order = order;
        keys = other_keys;
        order = other_order;
        other_keys = swapped_keys;
        other_order = swapped_order;
    }
    if (keys != sorted_keys) {
        memcpy(sorted_keys, keys, n * sizeof *keys);
        memcpy(sorted_order, order, n * sizeof *order);
    }
}

/* ---- groups ------------------------------------------------------------------------------------------------------ */

static nqm_status divide(size_t n, const uint64_t *keys, size_t max_groups, nqm_texel_groups *g, nqm_error *err) {
    g->n_different = 1;
    for (size_t i = 1; i < n; ++i)
        g->n_different += keys[i] != keys[i - 1];
    g->is_sample = g->n_different > max_groups;
    g->n_groups = nqm_smaller(g->n_different, max_groups);
    g->begin = nqm_alloc(g->n_groups + 1, sizeof *g->begin);
    if (!g->begin)
        return nqm_fail_nomem(err, (g->n_groups + 1) * sizeof *g->begin);
    for (size_t k = 0; g->is_sample && k < g->n_groups; ++k)
        g->begin[k] = n * k / g->n_groups;
    for (size_t i = 1, k = 0; !g->is_sample && i < n; ++i)
        if (keys[i] != keys[i - 1])
            g->begin[++k] = i;
    g->begin[g->n_groups] = n;
    return NQM_OK;
}

nqm_status nqm_texel_groups_find(const nqm_texel_pair *pair, size_t max_groups, bool is_exact, nqm_ticker *ticker,
                                 nqm_texel_groups *g, nqm_error *err) {
    enum { DIGITS = 1 << 16 };
    const size_t n = pair->n;
    nqm_texel_pair copy = *pair;
    uint64_t *keys[2], (*spread)[LEVELS];
    uint32_t *other_order, *count;
    *g = (nqm_texel_groups){.n = n};
    g->order = nqm_alloc(n, sizeof *g->order);
    nqm_status status = g->order ? NQM_OK : nqm_fail_nomem(err, n * sizeof *g->order);
    if (status == NQM_OK)
        status = nqm_alloc_arrays(NQM_ARRAYS({&keys[0], n, sizeof *keys[0]}, {&keys[1], n, sizeof *keys[1]},
                                             {&other_order, n, sizeof *other_order}, {&count, DIGITS, sizeof *count},
                                             {&spread, pair->n_dimensions, sizeof *spread}),
                                  err);
    if (status != NQM_OK) {
        nqm_texel_groups_free(g);
        return status;
    }
    spread_levels(pair, spread);
    pass p = {.pair = &copy, .visit = visit_keys, .spread = is_exact ? NULL : spread, .keys = keys[0]};
    status = run(&p, ticker, err);
    for (size_t i = 0; i < n; ++i)
        g->order[i] = (uint32_t)i;
    if (status == NQM_OK) {
        sort(n, keys[0], g->order, keys[1], other_order, count);
        status = divide(n, keys[0], is_exact ? n : max_groups, g, err);
    }
    nqm_free(keys[0]);
    if (status != NQM_OK)
        nqm_texel_groups_free(g);
    return status;
}

void nqm_texel_groups_free(nqm_texel_groups *g) {
    nqm_free(g->order);
    nqm_free(g->begin);
    *g = (nqm_texel_groups){.n = 0};
}
