/* SPDX-License-Identifier: MIT
 *
 * Which texel pairs are alike. The key of a pair is made of the first bits of each column, interleaved (Morton 1966),
 * and a hash of all bits: sorted keys bring similar pairs together, and equal ones are a group.
 */
#include "texture/score.h"

#include <math.h>

enum { BLOCK = NQM_TEXEL_BLOCK, LEVELS = 256, TASK = 64 * BLOCK, N_MEASURED = 1 << 14 };

/* ---- columns ----------------------------------------------------------------------------------------------------- */

static void add_column(nqm_texture_job *job, int kind, size_t property, size_t component) {
    nqm_texel_column *column = &job->columns[job->n_columns++];
    column->kind = kind;
    column->property = property;
    column->component = component;
    column->low = INFINITY;
    column->high = -INFINITY;
}

static bool varies(const nqm_texture *t, size_t property) {
    return t->properties[property].node != NQM_NO_NODE;
}

/* Of properties that vary on this side or, of differences, that are not the same constant. */
static void add_columns(nqm_texture_job *job, int kind, size_t side) {
    const nqm_texture *const *t = job->side;
    for (size_t k = 0; k < t[side]->n_properties; ++k) {
        const bool is_wanted = kind != NQM_DIFFERENCE ? varies(t[side], k)
                                                      : varies(t[0], k) || varies(t[1], k) ||
                                                            memcmp(t[0]->properties[k].v, t[1]->properties[k].v,
                                                                   sizeof t[0]->properties[k].v) != 0;
        for (size_t c = 0; is_wanted && c < t[side]->keys[k].n; ++c)
            add_column(job, kind, k, c);
    }
}

/* The first bits of a key are those of the first columns. */
static void find_columns(nqm_texture_job *job) {
    job->is_same_model = job->side[0]->keys && job->side[0]->keys == job->side[1]->keys;
    if (job->is_same_model)
        add_columns(job, NQM_DIFFERENCE, 0);
    for (size_t c = 0; job->has_normals && c < 2; ++c)
        add_column(job, NQM_TILT, 0, c);
    add_columns(job, NQM_OF_REF, 0);
    if (!job->is_same_model)
        add_columns(job, NQM_OF_TEST, 1);
}

bool nqm_texels_differ(const nqm_texture_job *job, int kind, size_t property) {
    bool differs = false;
    for (size_t k = 0; k < job->n_columns; ++k) {
        const nqm_texel_column *c = &job->columns[k];
        differs = differs || ((int)c->kind == kind && c->property == property && atomic_load(&c->is_nonzero));
    }
    return differs;
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

/* samples NULL: the texels from `first` on. */
static void evaluate(const nqm_texture_job *job, size_t n, const nqm_texel_sample *samples, size_t first,
                     float *workspace, const float *rows[2]) {
    double u[BLOCK], v[BLOCK];
    const double du = job->period[0] / (double)job->width, dv = job->period[1] / (double)job->height;
    for (size_t i = 0; i < n; ++i) {
        const size_t texel = samples ? samples[i].texel : first + i;
        u[i] = ((double)(texel % job->width) + 0.5) * du;
        v[i] = ((double)(texel / job->width) + 0.5) * dv;
    }
    float *const each[2] = {workspace, workspace + (size_t)job->side[0]->n_rows * BLOCK};
    for (size_t s = 0; s < 2; ++s) {
        nqm_texture_evaluate(job->side[s], n, u, v, each[s]);
        rows[s] = each[s];
    }
}

static size_t workspace_size(const nqm_texture_job *job) {
    return ((size_t)job->side[0]->n_rows + job->side[1]->n_rows) * BLOCK;
}

/* With the axis (-y, x, 0) of the rotation and 1 / (1 + z) in place of (1 - cos) / sin^2. Equal normals give (0, 0, 1) exactly. */
void nqm_texels_tilt(const nqm_texture_job *job, const float *const rows[2], size_t i, double tilt[3]) {
    double ref[3], test[3];
    nqm_texture_normal(job->side[0], rows[0], i, ref);
    nqm_texture_normal(job->side[1], rows[1], i, test);
    const double x = ref[0], y = ref[1], z = ref[2], along = (x * test[0] + y * test[1]) / (1 + z);
    const bool is_equal = memcmp(ref, test, sizeof ref) == 0;
    tilt[0] = is_equal ? 0 : test[0] - x * along - x * test[2];
    tilt[1] = is_equal ? 0 : test[1] - y * along - y * test[2];
    tilt[2] = is_equal ? 1 : x * test[0] + y * test[1] + z * test[2];
}

nqm_status nqm_texels_visit(nqm_texture_job *job, const char *stage, size_t n, nqm_texel_sample *samples,
                            nqm_texels_visitor *visit, void *user, nqm_error *err) {
    const size_t size = workspace_size(job);
    float *workspace = nqm_alloc(size, sizeof *workspace);
    nqm_status status = workspace ? NQM_OK : nqm_fail_nomem(err, size * sizeof *workspace);
    for (size_t first = 0, n_block; status == NQM_OK && first < n; first += n_block) {
        const float *rows[2];
        n_block = nqm_smaller(n - first, BLOCK);
        if (stage && nqm_tick(&job->ticker, stage, (double)first, (double)n)) {
            status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
        } else {
            evaluate(job, n_block, samples + first, 0, workspace, rows);
            status = visit(user, n_block, samples + first, rows, err);
        }
    }
    nqm_free(workspace);
    return status;
}

static float root(double x) {
    return x > 0 ? sqrtf((float)x) : 0;
}

/* Differences are 0 only of equal values. Both tilts are filled with the first. */
static void fill(const nqm_texture_job *job, const nqm_texel_column *column, size_t n, const float *const rows[2],
                 float *out) {
    const size_t side = column->kind == NQM_OF_TEST, k = column->property, c = column->component;
    if (column->kind == NQM_TILT) {
        for (size_t i = 0; c == 0 && i < n; ++i) {
            double tilt[3];
            nqm_texels_tilt(job, rows, i, tilt);
            out[i] = (float)tilt[0];
            out[BLOCK + i] = (float)tilt[1];
        }
        return;
    }
    const bool is_color = job->side[side]->keys[k].n == 3;
    for (size_t i = 0; i < n; ++i) {
        const double x = nqm_texture_value(job->side[side], k, c, rows[side], i);
        if (column->kind != NQM_DIFFERENCE) {
            out[i] = is_color ? root(x) : (float)x;
            continue;
        }
        const double y = nqm_texture_value(job->side[1], k, c, rows[1], i);
        const float roots = is_color ? root(x) + root(y) : 1;
        out[i] = (float)(y - x) / (roots > 0 ? roots : 1);
    }
}

/* Ranges at some texels; values beyond them count as their ends. */
static nqm_status measure(void *user, size_t n, nqm_texel_sample *samples, const float *const rows[2], nqm_error *err) {
    nqm_texture_job *job = user;
    float values[2 * BLOCK]; /* a pair of tilts */
    (void)samples, (void)err;
    for (size_t k = 0; k < job->n_columns; ++k) {
        nqm_texel_column *column = &job->columns[k];
        float *v = values + (column->kind == NQM_TILT && column->component) * BLOCK;
        fill(job, column, n, rows, v);
        for (size_t i = 0; i < n; ++i) {
            column->low = fminf(column->low, v[i]);
            column->high = fmaxf(column->high, v[i]);
        }
    }
    return NQM_OK;
}

/* ---- keys -------------------------------------------------------------------------------------------------------- */

typedef struct keys {
    nqm_texture_job *job;
    uint64_t *words; /* (n) a key above the number of the texel, of which these are the bits: */
    uint64_t mask;
    uint64_t (*spread)[LEVELS]; /* (n_columns) the bits of each level */
    unsigned n_spread;          /* how many these are; the others are of a hash */
    atomic_bool has_failed;     /* out of memory */
} keys;

/* Deal bits to the columns, one each in turn, the highest of each first. */
static void spread_levels(keys *s, unsigned n_bits) {
    const nqm_texture_job *job = s->job;
    for (int bit = 7; bit >= 0; --bit)
        for (size_t k = 0; k < job->n_columns && s->n_spread < n_bits; ++k) {
            if (job->columns[k].high <= job->columns[k].low)
                continue;
            ++s->n_spread;
            for (size_t level = 0; level < LEVELS; ++level)
                s->spread[k][level] |= (uint64_t)(level >> bit & 1) << (64 - s->n_spread);
        }
}

/* Differences are finer near 0. */
static size_t level_of(const nqm_texel_column *column, float v) {
    const float low = column->low, high = column->high, x = v < low ? low : v > high ? high : v;
    if (column->kind == NQM_OF_REF || column->kind == NQM_OF_TEST)
        return (size_t)((x - low) / (high - low) * 255.0f + 0.5f);
    const float most = fmaxf(fabsf(low), fabsf(high));
    return (size_t)(128 + (int)lrintf(copysignf(sqrtf(fabsf(x) / most), x) * 127));
}

/* Hashes are sums of multiples, to which values of 0 add nothing. */
static void add_to_keys(const keys *s, size_t k, size_t n, const float *v, uint64_t *words, uint64_t *hashes) {
    nqm_texel_column *column = &s->job->columns[k];
    const uint64_t times = nqm_hash_u64(column->kind, 3 * column->property + column->component) | 1;
    bool is_nonzero = false;
    for (size_t i = 0; i < n; ++i) {
        uint32_t bits;
        const float x = v[i] + 0.0f; /* no -0 */
        memcpy(&bits, &x, sizeof bits);
        hashes[i] += bits * times;
        is_nonzero = is_nonzero || bits != 0;
    }
    for (size_t i = 0; column->high > column->low && i < n; ++i)
        words[i] |= s->spread[k][level_of(column, v[i])];
    if (is_nonzero)
        atomic_store(&column->is_nonzero, true);
}

static void make_keys(void *user, size_t task) {
    keys *s = user;
    const nqm_texture_job *job = s->job;
    const size_t n_rows = workspace_size(job), end = nqm_smaller((task + 1) * TASK, job->order.n);
    float *workspace = nqm_alloc(n_rows + job->n_columns * BLOCK, sizeof *workspace), *columns = workspace + n_rows;
    if (!workspace)
        atomic_store(&s->has_failed, true);
    for (size_t first = task * TASK, n; workspace && first < end; first += n) {
        const float *rows[2];
        uint64_t hashes[BLOCK] = {0}, *words = s->words + first;
        n = nqm_smaller(end - first, BLOCK);
        evaluate(job, n, NULL, first, workspace, rows);
        for (size_t k = 0; k < job->n_columns; ++k) {
            fill(job, &job->columns[k], n, rows, columns + k * BLOCK);
            add_to_keys(s, k, n, columns + k * BLOCK, words, hashes);
        }
        for (size_t i = 0; i < n; ++i)
            words[i] = ((words[i] | nqm_hash_mix(hashes[i]) >> s->n_spread) & ~s->mask) | (first + i);
    }
    nqm_free(workspace);
}

/* ---- order ------------------------------------------------------------------------------------------------------- */

/* Sort words by their bits from `bit` on, stably. other: (n); returns the array that is sorted, which is one of both. */
static uint64_t *sort(size_t n, uint64_t *words, uint64_t *other, unsigned bit) {
    enum { BITS = 11, DIGITS = 1 << BITS };
    for (unsigned shift = bit; shift < 64; shift += BITS) {
        uint64_t *const swapped = words;
        size_t place[DIGITS + 1] = {0};
        for (size_t i = 0; i < n; ++i)
            ++place[(words[i] >> shift & (DIGITS - 1)) + 1];
        for (size_t k = 0; k < DIGITS; ++k)
            place[k + 1] += place[k];
        for (size_t i = 0; i < n; ++i)
            other[place[words[i] >> shift & (DIGITS - 1)]++] = words[i];
        words = other;
        other = swapped;
    }
    return words;
}

/* Where normals differ the pair is anisotropic, which takes 15 times as long: then a quarter as many texels are chosen. */
static size_t most_groups(const nqm_texture_job *job) {
    enum { TILTED = 4, LEAST = 16 };
    const size_t n = job->options.n_texels, n_tilted = nqm_larger(n / TILTED, LEAST);
    return job->options.exact ? job->order.n : nqm_texels_differ(job, NQM_TILT, 0) ? n_tilted : n;
}

/* Keep the texels of sorted words, and groups of equal keys unless these are too many. */
static nqm_status divide(nqm_texture_job *job, const uint64_t *words, uint64_t mask, nqm_error *err) {
    nqm_texel_order *o = &job->order;
    const size_t max_groups = nqm_smaller(most_groups(job), o->n);
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&o->texels, o->n, sizeof *o->texels}, {&o->begin, max_groups + 1, sizeof *o->begin}), err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < o->n; ++i) {
        const bool is_new = i == 0 || ((words[i] ^ words[i - 1]) & ~mask);
        if (is_new && job->n_different++ < max_groups)
            o->begin[job->n_different - 1] = i;
        o->texels[i] = (uint32_t)(words[i] & mask);
    }
    o->n_groups = nqm_smaller(job->n_different, max_groups);
    if (job->n_different > max_groups)
        o->begin = NULL; /* part of the block of the texels */
    else
        o->begin[o->n_groups] = o->n;
    return NQM_OK;
}

/* The order of the texels is by number at first. */
static nqm_status find_order(nqm_texture_job *job, keys *s, uint64_t *other, nqm_error *err) {
    enum { HASHED = 16 }; /* least bits of a hash */
    const size_t n = job->order.n;
    unsigned n_bits = 0;
    while (n - 1 > s->mask) {
        s->mask = 2 * s->mask + 1;
        ++n_bits;
    }
    if (!job->options.exact)
        spread_levels(s, 64 - n_bits - HASHED);
    if (nqm_parallel_ticking(&job->ticker, "texels", nqm_ceil_div(n, TASK), make_keys, s))
        return nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
    if (atomic_load(&s->has_failed))
        return nqm_fail_nomem(err, workspace_size(job) * sizeof(float));
    return divide(job, sort(n, s->words, other, n_bits), s->mask, err);
}

nqm_status nqm_texels_compare(nqm_texture_job *job, nqm_error *err) {
    const size_t n = job->width * job->height;
    keys s = {.job = job};
    nqm_texel_sample *samples;
    uint64_t *other;
    find_columns(job);
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&s.words, n, sizeof *s.words}, {&other, n, sizeof *other},
                                                    {&s.spread, job->n_columns, sizeof *s.spread},
                                                    {&samples, N_MEASURED, sizeof *samples}),
                                         err);
    if (status != NQM_OK)
        return status;
    job->order.n = n;
    const size_t n_measured = nqm_texels_choose(&job->order, N_MEASURED, 0, samples);
    status = nqm_texels_visit(job, NULL, n_measured, samples, measure, job, err);
    if (status == NQM_OK)
        status = find_order(job, &s, other, err);
    nqm_free(s.words);
    return status;
}

size_t nqm_texels_begin(const nqm_texel_order *o, size_t n, size_t k) {
    return o->begin && n == o->n_groups ? o->begin[k] : (size_t)((uint64_t)o->n * k / n); /* size_t may have 32 bits */
}

size_t nqm_texels_choose(const nqm_texel_order *o, size_t max_n, uint64_t seed, nqm_texel_sample *samples) {
    const size_t n = o->begin && o->n_groups <= max_n ? o->n_groups : nqm_smaller(max_n, o->n);
    for (size_t k = 0; k < n; ++k) {
        const size_t begin = nqm_texels_begin(o, n, k), end = nqm_texels_begin(o, n, k + 1);
        const size_t at = begin + nqm_hash_u64(seed, k) % (end - begin);
        samples[k].texel = o->texels ? o->texels[at] : (uint32_t)at;
        samples[k].weight = (double)(end - begin) / (double)o->n;
    }
    return n;
}
