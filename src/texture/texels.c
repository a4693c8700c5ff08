/* SPDX-License-Identifier: MIT
 *
 * Which texel pairs are alike. The key of a pair is made of the first bits of each column, interleaved (Morton 1966), and a hash of all
 * bits: sorted keys bring similar pairs together, and equal ones are a group.
 */
#include "texture/score.h"

#include <math.h>

enum { BLOCK = NQM_TEXEL_BLOCK, LEVELS = 256 };

/* ---- columns ----------------------------------------------------------------------------------------------------- */

static void add_column(nqm_texture_job *job, int kind, size_t property, size_t component) {
    nqm_texel_column *column = &job->columns[job->n_columns++];
    *column = (nqm_texel_column){.property = property, .component = component};
    column->kind = kind;
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
    for (size_t c = 0; c < 2; ++c)
        if (job->side[0]->normal != NQM_NO_NODE || job->side[1]->normal != NQM_NO_NODE)
            add_column(job, NQM_TILT, 0, c);
    add_columns(job, NQM_OF_REF, 0);
    if (!job->is_same_model)
        add_columns(job, NQM_OF_TEST, 1);
}

static bool is_difference(const nqm_texel_column *column) {
    return column->kind == NQM_DIFFERENCE || column->kind == NQM_TILT;
}

bool nqm_texels_differ(const nqm_texture_job *job, size_t property) {
    bool differs = false;
    for (size_t k = 0; k < job->n_columns; ++k) {
        const nqm_texel_column *c = &job->columns[k];
        differs = differs || (c->kind == NQM_DIFFERENCE && c->property == property && (c->low < 0 || c->high > 0));
    }
    return differs;
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

/* texels NULL: those from `first` on. */
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

/* ---- a pass over texels ------------------------------------------------------------------------------------------ */

/* Every `step` blocks one task visits n_blocks of them. */
typedef struct pass {
    const nqm_texture_job *job;
    size_t n_tasks, step, n_blocks;
    float (*ranges)[2];         /* (n_tasks, n_columns) low and high of each */
    bool *failed;               /* (n_tasks) out of memory */
    uint64_t *words;            /* (n texels) NULL: ranges are wanted only */
    uint64_t (*spread)[LEVELS]; /* (n_columns) the bits of each level */
    unsigned n_spread;          /* bits that levels have */
} pass;

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
    const bool is_color = job->side[side]->keys[k].n == 3, subtracts = column->kind == NQM_DIFFERENCE;
    for (size_t i = 0; i < n; ++i) {
        const double x = nqm_texture_value(job->side[side], k, c, rows[side], i);
        const double y = subtracts ? nqm_texture_value(job->side[1], k, c, rows[1], i) : 0;
        if (subtracts)
            out[i] = (float)(y - x) / (x < y || x > y ? is_color ? root(x) + root(y) : 1 : 1);
        else
            out[i] = is_color ? root(x) : (float)x;
    }
}

static void measure(size_t n, const float *in, bool is_first, float range[2]) {
    float low = is_first ? in[0] : range[0], high = is_first ? in[0] : range[1];
    for (size_t i = 0; i < n; ++i) {
        low = in[i] < low ? in[i] : low;
        high = in[i] > high ? in[i] : high;
    }
    range[0] = low;
    range[1] = high;
}

/* Of 256 within the range, which was measured at some texels. Differences are finer near 0. */
static size_t level_of(const nqm_texel_column *column, float v) {
    const float low = column->low, high = column->high, x = v < low ? low : v > high ? high : v;
    if (!is_difference(column))
        return (size_t)((x - low) / (high - low) * 255.0f + 0.5f);
    const float most = fmaxf(fabsf(low), fabsf(high));
    return (size_t)(128 + (int)lrintf(copysignf(sqrtf(fabsf(x) / most), x) * 127));
}

static void make_words(const pass *p, size_t first, size_t n, const float *columns) {
    uint64_t *words = p->words + first, hash[BLOCK] = {0};
    const nqm_texture_job *job = p->job;
    for (size_t k = 0; k < job->n_columns; ++k, columns += BLOCK) {
        const bool is_spread = job->columns[k].high > job->columns[k].low;
        for (size_t i = 0; i < n; ++i) {
            uint32_t bits;
            const float v = columns[i] + 0.0f; /* no -0 */
            memcpy(&bits, &v, sizeof bits);
            hash[i] = (hash[i] ^ (hash[i] >> 29) ^ bits) * NQM_GOLDEN;
            if (is_spread)
                words[i] |= p->spread[k][level_of(&job->columns[k], v)];
        }
    }
    for (size_t i = 0; i < n; ++i)
        words[i] = ((words[i] | nqm_hash_mix(hash[i]) >> p->n_spread) & ~job->order.mask) | (first + i);
}

static void visit_task(void *user, size_t task) {
    const pass *p = user;
    const nqm_texture_job *job = p->job;
    const size_t n_values = workspace_size(job), n_columns = job->n_columns, begin = task * p->step * BLOCK;
    const size_t end = nqm_smaller(begin + p->n_blocks * BLOCK, job->order.n);
    float *workspace = nqm_alloc(n_values + n_columns * BLOCK, sizeof *workspace), *columns = workspace + n_values;
    p->failed[task] = !workspace;
    for (size_t first = begin, n; workspace && first < end; first += n) {
        const float *rows[2];
        n = nqm_smaller(end - first, BLOCK);
        evaluate(job, n, NULL, first, workspace, rows);
        for (size_t k = 0; k < n_columns; ++k)
            fill(job, &job->columns[k], n, rows, columns + k * BLOCK);
        for (size_t k = 0; k < n_columns; ++k)
            measure(n, columns + k * BLOCK, first == begin, p->ranges[task * n_columns + k]);
        if (p->words)
            make_words(p, first, n, columns);
    }
    nqm_free(workspace);
}

/* Visit texels, and give the columns the ranges there. */
static nqm_status run(nqm_texture_job *job, pass *p, nqm_error *err) {
    bool has_failed = false;
    p->job = job;
    p->n_tasks = nqm_ceil_div(job->order.n, p->step * BLOCK);
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&p->ranges, p->n_tasks * job->n_columns, sizeof *p->ranges},
                                                    {&p->failed, p->n_tasks, sizeof *p->failed}),
                                         err);
    if (status != NQM_OK)
        return status;
    if (nqm_parallel_ticking(&job->ticker, "texels", p->n_tasks, visit_task, p))
        status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
    for (size_t i = 0; i < p->n_tasks; ++i)
        has_failed = has_failed || p->failed[i];
    if (status == NQM_OK && has_failed)
        status = nqm_fail_nomem(err, workspace_size(job) * sizeof(float));
    for (size_t k = 0; status == NQM_OK && k < job->n_columns; ++k) {
        nqm_texel_column *column = &job->columns[k];
        column->low = p->ranges[k][0];
        column->high = p->ranges[k][1];
        for (size_t i = 1; i < p->n_tasks; ++i) {
            column->low = fminf(column->low, p->ranges[i * job->n_columns + k][0]);
            column->high = fmaxf(column->high, p->ranges[i * job->n_columns + k][1]);
        }
    }
    nqm_free(p->ranges);
    return status;
}

/* ---- order ------------------------------------------------------------------------------------------------------- */

/* Deal bits to the columns, one each in turn, the highest of each first. */
static unsigned spread_levels(const nqm_texture_job *job, unsigned n_bits, uint64_t (*spread)[LEVELS]) {
    unsigned n = 0;
    for (int bit = 7; bit >= 0; --bit)
        for (size_t k = 0; k < job->n_columns && n < n_bits; ++k) {
            if (job->columns[k].high <= job->columns[k].low)
                continue;
            ++n;
            for (size_t level = 0; level < LEVELS; ++level)
                spread[k][level] |= (uint64_t)(level >> bit & 1) << (64 - n);
        }
    return n;
}

uint64_t *nqm_texels_sort(size_t n, uint64_t *words, uint64_t *other, unsigned bit) {
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

/* Groups of equal keys, unless these are more than max_groups. */
static nqm_status divide(nqm_texture_job *job, size_t max_groups, nqm_error *err) {
    nqm_texel_order *o = &job->order;
    job->n_different = 1;
    for (size_t i = 1; i < o->n; ++i)
        job->n_different += ((o->words[i] ^ o->words[i - 1]) & ~o->mask) != 0;
    o->n_groups = nqm_smaller(job->n_different, max_groups);
    if (job->n_different > max_groups)
        return NQM_OK;
    o->begin = nqm_alloc(o->n_groups + 1, sizeof *o->begin);
    if (!o->begin)
        return nqm_fail_nomem(err, (o->n_groups + 1) * sizeof *o->begin);
    for (size_t i = 1, k = 0; i < o->n; ++i)
        if ((o->words[i] ^ o->words[i - 1]) & ~o->mask)
            o->begin[++k] = i;
    o->begin[o->n_groups] = o->n;
    return NQM_OK;
}

/* Where normals differ the pair is anisotropic, which takes 15 times as long: then a quarter as many texels are chosen. */
static size_t most_groups(const nqm_texture_job *job) {
    enum { TILTED = 4, LEAST = 16 };
    const size_t n = job->options.n_texels;
    return job->options.exact ? job->order.n : job->tilts ? nqm_larger(n / TILTED, LEAST) : n;
}

nqm_status nqm_texels_compare(nqm_texture_job *job, nqm_error *err) {
    enum {
        N_MEASURED = 1024,
        TASK = 64,
        HASHED = 12
    }; /* blocks from which ranges are, and of a task; least bits of a hash */
    nqm_texel_order *o = &job->order;
    uint64_t *other, (*spread)[LEVELS];
    unsigned n_bits = 0;
    find_columns(job);
    o->n = job->width * job->height;
    while (o->n - 1 > o->mask)
        o->mask = 2 * o->mask + 1, ++n_bits;
    pass some = {.step = nqm_ceil_div(nqm_ceil_div(o->n, BLOCK), N_MEASURED), .n_blocks = 1};
    nqm_status status = run(job, &some, err);
    if (status == NQM_OK)
        status = nqm_alloc_arrays(NQM_ARRAYS({&o->words, o->n, sizeof *o->words}, {&other, o->n, sizeof *other},
                                             {&spread, job->n_columns, sizeof *spread}),
                                  err);
    if (status != NQM_OK)
        return status;
    pass all = {.step = TASK, .n_blocks = TASK, .words = o->words, .spread = spread};
    all.n_spread = job->options.exact ? 0 : spread_levels(job, 64 - n_bits - HASHED, spread);
    status = run(job, &all, err);
    job->is_equal = job->is_same_model;
    for (size_t k = 0; k < job->n_columns; ++k) {
        const nqm_texel_column *c = &job->columns[k];
        const bool differs = is_difference(c) && (c->low < 0 || c->high > 0);
        job->is_equal = job->is_equal && !differs;
        job->tilts = job->tilts || (differs && c->kind == NQM_TILT);
    }
    if (status != NQM_OK)
        return status;
    o->block = o->words;
    o->words = nqm_texels_sort(o->n, o->words, other, n_bits);
    return divide(job, most_groups(job), err);
}

void nqm_texel_order_free(nqm_texel_order *o) {
    nqm_free(o->block);
    nqm_free(o->begin);
}

/* ---- samples ----------------------------------------------------------------------------------------------------- */

size_t nqm_texels_begin(const nqm_texel_order *o, size_t n, size_t k) {
    return o->begin && n == o->n_groups ? o->begin[k] : o->n * k / n;
}

size_t nqm_texels_choose(const nqm_texel_order *o, size_t max_n, uint64_t seed, nqm_texel_sample *samples) {
    const size_t n = o->begin && o->n_groups <= max_n ? o->n_groups : nqm_smaller(max_n, o->n);
    for (size_t k = 0; k < n; ++k) {
        const size_t begin = nqm_texels_begin(o, n, k), end = nqm_texels_begin(o, n, k + 1);
        const size_t at = begin + nqm_hash_u64(seed, k) % (end - begin);
        samples[k] = (nqm_texel_sample){.texel = (uint32_t)(o->words[at] & o->mask),
                                        .weight = (double)(end - begin) / (double)o->n};
    }
    return n;
}
