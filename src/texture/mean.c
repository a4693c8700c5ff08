/* SPDX-License-Identifier: MIT
 *
 * Scores of means: from afar, and of pixels with several texels. The BRDFs of texels that are smaller than a pixel are
 * averaged (Filip et al. 2016), each about its own normal. Both materials are averaged over the same texels, a
 * stratified sample. With normals, the light of pictures is averaged (tilted.c).
 */
#include "math/math.h"
#include "texture/score.h"

#include <math.h>

/* Members of a mean, and the texels from which those with normals are chosen. */
enum { MAX_MEMBERS = NQM_TEXEL_BLOCK, N_CANDIDATES = 4096 };

/* A mean of BRDFs. */
typedef struct mean {
    size_t n;
    double weight[MAX_MEMBERS];
    nqm_brdf *members[MAX_MEMBERS];
} mean;

static void mean_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    enum { BLOCK = 128 };
    const mean *self = state;
    double value[3 * BLOCK];
    uint8_t flag[BLOCK];
    for (size_t first = 0, m; first < n; first += m) {
        double *out = rgb + 3 * first;
        m = nqm_smaller(n - first, BLOCK);
        memset(out, 0, 3 * m * sizeof *out);
        for (size_t k = 0; k < self->n; ++k) {
            nqm_brdf_eval(self->members[k], m, wi + 3 * first, wo + 3 * first, value, flag);
            for (size_t i = 0; i < 3 * m; ++i)
                out[i] += flag[i / 3] == NQM_VALUE_INVALID ? NAN : self->weight[k] * value[i];
        }
    }
}

static void mean_free(void *state) {
    mean *self = state;
    for (size_t k = 0; k < self->n; ++k)
        nqm_brdf_free(self->members[k]);
    nqm_free(self);
}

static const nqm_brdf_class mean_class = {
    .format = "mean", .anisotropic = true, .is_costly = true, .eval = mean_eval, .free = mean_free};

/* ---- members ----------------------------------------------------------------------------------------------------- */

/* The values of texels of both sides, with their normals. */
typedef struct members {
    nqm_texture_job *job;
    size_t n, n_added; /* n_added: of n */
    double weights[MAX_MEMBERS];
    nqm_subject subjects[2 * MAX_MEMBERS]; /* (2, n) */
    nqm_values values[2 * MAX_MEMBERS];
} members;

static nqm_status add_members(void *user, size_t n, nqm_texel_sample *samples, const float *const rows[2],
                              nqm_error *err) {
    members *m = user;
    (void)err;
    for (size_t i = 0; i < n; ++i, ++m->n_added) {
        for (size_t s = 0; s < 2; ++s) {
            const nqm_texture *t = m->job->side[s];
            const size_t at = s * m->n + m->n_added;
            double normal[3];
            nqm_texture_normal(t, rows[s], i, normal);
            m->subjects[at] = nqm_texture_subject(t, rows[s], i, &m->values[at]);
            nqm_subject_tilt(&m->subjects[at], normal);
        }
        m->weights[m->n_added] = samples[i].weight;
    }
    return NQM_OK;
}

/* ---- without normals --------------------------------------------------------------------------------------------- */

/* Of equal members that follow each other one is opened. */
static nqm_status open_mean(const members *list, size_t side, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_brdf_info info = {.name = list->job->side[side]->name, .reciprocal = 1, .isotropic = 1};
    mean *m = nqm_alloc(1, sizeof *m);
    nqm_status status = m ? NQM_OK : nqm_fail_nomem(err, sizeof *m);
    const nqm_subject *subjects = list->subjects + side * list->n;
    for (size_t i = 0; status == NQM_OK && i < list->n; ++i) {
        if (i == 0 || !nqm_subjects_equal(&subjects[i], &subjects[i - 1]))
            status = nqm_subject_open(&subjects[i], NULL, &m->members[m->n++], err);
        m->weight[m->n - 1] += list->weights[i];
    }
    for (size_t k = 0; status == NQM_OK && k < m->n; ++k) {
        const nqm_brdf_info member = nqm_brdf_get_info(m->members[k]);
        info.isotropic = info.isotropic && member.isotropic;
        info.reciprocal = info.reciprocal && member.reciprocal;
    }
    if (status == NQM_OK && m->n > 1)
        return nqm_brdf_wrap(&mean_class, m, &info, brdf_ret, err);
    if (status == NQM_OK) {
        *brdf_ret = m->members[0];
        m->n = 0;
    }
    if (m)
        mean_free(m);
    return status;
}

static nqm_status score_flat(const members *m, nqm_score_result *score, nqm_error *err) {
    nqm_texture_job *job = m->job;
    nqm_brdf *brdf[2] = {NULL, NULL};
    nqm_status status = NQM_OK;
    if (nqm_tick(&job->ticker, "far", 0, 1))
        status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
    for (size_t s = 0; status == NQM_OK && s < 2; ++s)
        status = open_mean(m, s, &brdf[s], err);
    if (status == NQM_OK)
        status = nqm_scorer_run(job->scorer, brdf[0], 1, (const nqm_brdf *const *)&brdf[1], score, err);
    if (status == NQM_OK && score->status != NQM_OK)
        status = nqm_fail(err, score->status, -1, "the mean BRDFs of %s and %s cannot be compared: %s",
                          job->side[0]->name, job->side[1]->name, nqm_status_text(score->status));
    for (size_t s = 0; s < 2; ++s)
        nqm_brdf_free(brdf[s]);
    return status;
}

/* ---- with normals ------------------------------------------------------------------------------------------------ */

/* Candidates, and the keys by which they are sorted. */
typedef struct candidates {
    const nqm_texture_job *job;
    size_t n;
    nqm_texel_sample samples[N_CANDIDATES];
    double key[N_CANDIDATES];
    nqm_indexed order[N_CANDIDATES];
} candidates;

/* A key: bits of x and y of the reference's normal, interleaved; of the test's if only that one varies. */
static nqm_status find_keys(void *user, size_t n, nqm_texel_sample *samples, const float *const rows[2],
                            nqm_error *err) {
    enum { BITS = 4 };
    candidates *all = user;
    const nqm_texture *const *t = all->job->side;
    const size_t side = t[0]->normal != NQM_NO_NODE ? 0 : 1;
    (void)samples, (void)err;
    for (size_t i = 0; i < n; ++i) {
        double normal[3];
        unsigned key = 0;
        nqm_texture_normal(t[side], rows[side], i, normal);
        for (int bit = BITS - 1; bit >= 0; --bit)
            for (size_t c = 0; c < 2; ++c) { /* roots: most normals are near (0, 0, 1) */
                const double x = copysign(sqrt(fabs(normal[c])), normal[c]);
                key = 2 * key + ((unsigned)((x + 1) / 2 * ((1 << BITS) - 1)) >> bit & 1);
            }
        all->key[all->n++] = key;
    }
    return NQM_OK;
}

/* Texels that cover the normals evenly. samples: (MAX_MEMBERS). */
static nqm_status choose_tilted(nqm_texture_job *job, nqm_texel_sample *samples, size_t *n_ret, nqm_error *err) {
    const uint64_t seed = job->options.seed + 1;
    nqm_texel_order runs = job->order;
    candidates *all = nqm_alloc(1, sizeof *all);
    if (!all)
        return nqm_fail_nomem(err, sizeof *all);
    runs.begin = NULL;
    all->job = job;
    const size_t n = nqm_texels_choose(&runs, N_CANDIDATES, seed, all->samples);
    nqm_status status = nqm_texels_visit(job, NULL, n, all->samples, find_keys, all, err);
    nqm_sort_indexed(n, all->key, all->order);
    *n_ret = nqm_texels_choose(&(nqm_texel_order){.n = n}, MAX_MEMBERS, nqm_hash_u64(seed, 0), samples);
    for (size_t k = 0; k < *n_ret; ++k)
        samples[k].texel = all->samples[all->order[samples[k].texel].index].texel;
    nqm_free(all);
    return status;
}

/* The score of the means over texels. anisotropic: the model for tilted BRDFs; NULL without normals. */
static nqm_status score_mean(nqm_texture_job *job, const nqm_model *anisotropic, size_t n, nqm_texel_sample *samples,
                             nqm_score_result *score, nqm_error *err) {
    const double certain = job->model->interval ? 10 : NAN;
    members *m = nqm_alloc(1, sizeof *m);
    if (!m)
        return nqm_fail_nomem(err, sizeof *m);
    m->job = job;
    m->n = n;
    bool is_equal = true;
    nqm_status status = nqm_texels_visit(job, NULL, n, samples, add_members, m, err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        is_equal = is_equal && nqm_subjects_equal(&m->subjects[i], &m->subjects[n + i]);
    *score = (nqm_score_result){.jod = 10, .jod_low = certain, .jod_high = certain};
    if (status == NQM_OK && !is_equal && anisotropic)
        status = nqm_texture_score_tilted(anisotropic, n, m->subjects, m->weights, &job->ticker, score, err);
    else if (status == NQM_OK && !is_equal)
        status = score_flat(m, score, err);
    nqm_free(m);
    return status;
}

/* ---- pixels ------------------------------------------------------------------------------------------------------ */

/* Texels of the pixel that contains a texel: all, or one in each of the cells of a grid. chosen: (MAX_MEMBERS). */
static size_t choose_in_pixel(const nqm_texture_job *job, size_t texel, size_t max_side, nqm_texel_sample *chosen) {
    const size_t side = job->options.texels_per_pixel;
    const size_t x = texel % job->width / side * side, y = texel / job->width / side * side;
    const size_t width = nqm_smaller(side, job->width - x), height = nqm_smaller(side, job->height - y);
    const size_t n_x = nqm_smaller(width, max_side), n_y = nqm_smaller(height, max_side), n = n_x * n_y;
    for (size_t k = 0; k < n; ++k) {
        const size_t i = k % n_x, j = k / n_x, left = i * width / n_x, upper = j * height / n_y;
        const uint64_t random = nqm_hash_u64(job->options.seed + texel, k);
        const size_t at_x = x + left + random % ((i + 1) * width / n_x - left);
        const size_t at_y = y + upper + (random >> 32) % ((j + 1) * height / n_y - upper);
        chosen[k] = (nqm_texel_sample){.texel = (uint32_t)(at_y * job->width + at_x), .weight = 1 / (double)n};
    }
    return n;
}

nqm_status nqm_pixels_score(nqm_texture_job *job, size_t n, nqm_texel_sample *samples, nqm_label *parts,
                            nqm_error *err) {
    enum { SIDE = 16, SIDE_TILTED = 6 };
    nqm_texel_sample chosen[MAX_MEMBERS];
    const nqm_model *anisotropic = NULL;
    nqm_status status = job->has_normals ? nqm_scorer_anisotropic(job->scorer, &anisotropic, err) : NQM_OK;
    for (size_t k = 0; status == NQM_OK && k < n; ++k) {
        nqm_score_result r;
        if (nqm_tick(&job->ticker, "pixels", (double)k, (double)n)) {
            status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
            break;
        }
        const size_t n_chosen = choose_in_pixel(job, samples[k].texel, anisotropic ? SIDE_TILTED : SIDE, chosen);
        status = score_mean(job, anisotropic, n_chosen, chosen, &r, err);
        samples[k].delta_e = r.delta_e;
        samples[k].jod = r.jod;
        samples[k].jod_low = r.jod_low;
        samples[k].jod_high = r.jod_high;
        if (status == NQM_OK)
            nqm_label_add(parts, samples[k].weight, &r.parts);
    }
    return status;
}

nqm_status nqm_texture_score_far(nqm_texture_job *job, nqm_texture_result *result, nqm_error *err) {
    nqm_texel_sample samples[MAX_MEMBERS];
    nqm_score_result score = {.jod = NAN};
    const nqm_model *anisotropic = NULL;
    size_t n = 0;
    nqm_status status = job->has_normals ? nqm_scorer_anisotropic(job->scorer, &anisotropic, err) : NQM_OK;
    if (status == NQM_OK && job->has_normals)
        status = choose_tilted(job, samples, &n, err);
    else
        n = nqm_texels_choose(&job->order, MAX_MEMBERS, job->options.seed + 1, samples);
    if (status == NQM_OK)
        status = score_mean(job, anisotropic, n, samples, &score, err);
    result->far_jod[0] = score.jod;
    result->far_jod[1] = score.jod_low;
    result->far_jod[2] = score.jod_high;
    result->far_delta_e = score.delta_e;
    return status;
}
