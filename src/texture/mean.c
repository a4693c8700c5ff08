/* SPDX-License-Identifier: MIT
 *
 * Far scores: the BRDFs of texels that are smaller than a pixel are averaged (Filip et al. 2016), each about its own normal. Both
 * materials are averaged over the same texels, a stratified sample. With normals, the light of pictures is averaged.
 */
#include "metric/azimuths.h"
#include "texture/score.h"

#include <math.h>
#include <stdlib.h>

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

/* Open the member of texel i of a block, or add its weight to that of the member before it, if that is equal. */
static nqm_status add_member(const nqm_texel_pair *pair, size_t side, const float *values, size_t i, double weight,
                             mean *m, nqm_error *err) {
    char *spec = nqm_texture_spec(pair->side[side], values + i, NQM_TEXEL_BLOCK);
    if (!spec)
        return nqm_fail_nomem(err, sizeof(nqm_shading));
    nqm_status status = NQM_OK;
    if (m->n && strcmp(nqm_brdf_get_info(m->members[m->n - 1]).name, spec) == 0) {
        m->weight[m->n - 1] += weight;
    } else {
        status = nqm_brdf_open(spec, &m->members[m->n], err);
        if (status == NQM_OK)
            m->weight[m->n++] = weight;
    }
    nqm_free(spec);
    return status;
}

static nqm_status make_mean(nqm_texture_job *job, size_t side, size_t n, const nqm_texel_choice *choices,
                            nqm_brdf **brdf_ret, nqm_error *err) {
    uint32_t texels[MAX_MEMBERS];
    const float *values[2];
    mean *m = nqm_alloc(1, sizeof *m);
    nqm_brdf_info info = {.name = job->pair.side[side]->name, .reciprocal = 1, .isotropic = 1};
    nqm_status status = m ? NQM_OK : nqm_fail_nomem(err, sizeof *m);
    if (!m)
        return status;
    for (size_t i = 0; i < n; ++i)
        texels[i] = choices[i].texel;
    nqm_texel_pair_evaluate(&job->pair, n, texels, 0, job->workspace, values);
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        status = add_member(&job->pair, side, values[side], i, choices[i].weight, m, err);
    if (status == NQM_OK && m->n == 1) {
        *brdf_ret = m->members[0];
        m->n = 0;
    }
    for (size_t k = 0; k < m->n; ++k) {
        info.isotropic = info.isotropic && nqm_brdf_get_info(m->members[k]).isotropic;
        info.reciprocal = info.reciprocal && nqm_brdf_get_info(m->members[k]).reciprocal;
    }
    if (status == NQM_OK && m->n)
        return nqm_brdf_wrap(&mean_class, m, &info, brdf_ret, err);
    mean_free(m);
    return status;
}

/* A texel with the place of its normals in an order in which similar ones are near each other. */
typedef struct candidate {
    uint32_t place; /* of its normals, then of the whole pair */
    nqm_texel_choice choice;
} candidate;

static int compare_candidates(const void *a, const void *b) {
    const candidate *x = a, *y = b;
    return (x->place > y->place) - (x->place < y->place);
}

/* Interleave bits of x and y of the reference's normal; of the test's, if only that one varies. */
static uint32_t place_of(const nqm_texel_pair *pair, const float *const values[2], size_t i) {
    enum { BITS = 4 };
    const size_t side = pair->side[0]->has_normal ? 0 : 1;
    double normal[3];
    uint32_t place = 0;
    nqm_texel_pair_normal(pair, side, values[side], i, normal);
    for (int bit = BITS - 1; bit >= 0; --bit)
        for (size_t c = 0; c < 2; ++c) /* roots: most normals are near (0, 0, 1) */
            place = 2 * place +
                    ((uint32_t)((copysign(sqrt(fabs(normal[c])), normal[c]) + 1) / 2 * ((1 << BITS) - 1)) >> bit & 1);
    return place;
}

/* Texels that cover the normals evenly. choices: (MAX_MEMBERS). */
static nqm_status choose_tilted(nqm_texture_job *job, nqm_texel_choice *choices, size_t *n_ret, nqm_error *err) {
    const uint64_t seed = job->options.seed + 1;
    nqm_texel_choice *all;
    candidate *sorted;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&all, N_CANDIDATES, sizeof *all}, {&sorted, N_CANDIDATES, sizeof *sorted}), err);
    if (status != NQM_OK)
        return status;
    const size_t n = nqm_texels_choose(&job->groups, N_CANDIDATES, true, seed, all);
    for (size_t first = 0, m; first < n; first += m) {
        uint32_t texels[NQM_TEXEL_BLOCK];
        const float *values[2];
        m = nqm_smaller(n - first, NQM_TEXEL_BLOCK);
        for (size_t i = 0; i < m; ++i)
            texels[i] = all[first + i].texel;
        nqm_texel_pair_evaluate(&job->pair, m, texels, 0, job->workspace, values);
        for (size_t i = 0; i < m; ++i)
            sorted[first + i] =
                (candidate){place_of(&job->pair, values, i) * N_CANDIDATES + (uint32_t)(first + i), all[first + i]};
    }
    qsort(sorted, n, sizeof *sorted, compare_candidates);
    *n_ret = nqm_smaller(n, MAX_MEMBERS);
    for (size_t k = 0; k < *n_ret; ++k) {
        const size_t begin = n * k / *n_ret, end = n * (k + 1) / *n_ret;
        choices[k] = sorted[begin + nqm_hash_u64(seed, n + k) % (end - begin)].choice;
        choices[k].weight = (double)(end - begin) / (double)n;
    }
    nqm_free(all);
    return NQM_OK;
}

/* The specs of the members, with their normals. */
typedef struct tilted {
    double weights[MAX_MEMBERS];
    nqm_named_pair members[MAX_MEMBERS];
    char *specs[2][MAX_MEMBERS];
} tilted;

static nqm_status tilt_members(nqm_texture_job *job, size_t n, const nqm_texel_choice *choices, tilted *t,
                               nqm_error *err) {
    uint32_t texels[MAX_MEMBERS];
    const float *values[2];
    for (size_t i = 0; i < n; ++i)
        texels[i] = choices[i].texel;
    nqm_texel_pair_evaluate(&job->pair, n, texels, 0, job->workspace, values);
    for (size_t i = 0; i < n; ++i) {
        for (size_t s = 0; s < 2; ++s) {
            double normal[3];
            nqm_texel_pair_normal(&job->pair, s, values[s], i, normal);
            t->specs[s][i] =
                nqm_texture_tilt(nqm_texture_spec(job->pair.side[s], values[s] + i, NQM_TEXEL_BLOCK), normal);
            if (!t->specs[s][i])
                return nqm_fail_nomem(err, sizeof(nqm_shading));
        }
        t->members[i] = (nqm_named_pair){t->specs[0][i], t->specs[1][i]};
        t->weights[i] = choices[i].weight;
    }
    return NQM_OK;
}

static nqm_status score_tilted(nqm_texture_job *job, nqm_score_result *score, nqm_error *err) {
    nqm_texel_choice choices[MAX_MEMBERS];
    nqm_azimuths *azimuths = NULL;
    size_t n = 0;
    tilted *t = nqm_alloc(1, sizeof *t);
    nqm_status status = t ? choose_tilted(job, choices, &n, err) : nqm_fail_nomem(err, sizeof *t);
    if (status == NQM_OK)
        status = tilt_members(job, n, choices, t, err);
    if (status == NQM_OK)
        status = nqm_azimuths_create(job->model, &azimuths, err);
    if (status == NQM_OK)
        status = nqm_azimuths_score_means(azimuths, n, t->members, t->weights, &job->ticker, score, err);
    for (size_t i = 0; t && i < 2 * n; ++i)
        nqm_free(t->specs[i / n][i % n]);
    nqm_azimuths_free(azimuths);
    nqm_free(t);
    return status;
}

static nqm_status score_flat(nqm_texture_job *job, nqm_score_result *score, nqm_error *err) {
    nqm_texel_choice choices[MAX_MEMBERS];
    nqm_brdf *brdf[2] = {NULL, NULL};
    const size_t n = nqm_texels_choose(&job->groups, MAX_MEMBERS, false, job->options.seed + 1, choices);
    nqm_status status = NQM_OK;
    if (nqm_tick(&job->ticker, "far", 0, 1))
        status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
    for (size_t s = 0; status == NQM_OK && s < 2; ++s)
        status = make_mean(job, s, n, choices, &brdf[s], err);
    if (status == NQM_OK)
        status = nqm_scorer_run(job->scorer, brdf[0], 1, (const nqm_brdf *const *)&brdf[1], score, err);
    if (status == NQM_OK && score->status != NQM_OK)
        status = nqm_fail(err, score->status, -1, "the mean BRDFs of %s and %s cannot be compared: %s",
                          job->pair.side[0]->name, job->pair.side[1]->name, nqm_status_text(score->status));
    for (size_t s = 0; s < 2; ++s)
        nqm_brdf_free(brdf[s]);
    return status;
}

nqm_status nqm_texture_score_far(nqm_texture_job *job, nqm_texture_result *result, nqm_error *err) {
    const double certain = job->model->interval ? 10 : NAN;
    nqm_score_result score = {.jod = 10, .jod_low = certain, .jod_high = certain};
    nqm_status status = NQM_OK;
    if (!nqm_texel_pair_is_equal(&job->pair))
        status = job->pair.has_normals ? score_tilted(job, &score, err) : score_flat(job, &score, err);
    result->far_jod[0] = score.jod;
    result->far_jod[1] = score.jod_low;
    result->far_jod[2] = score.jod_high;
    result->far_delta_e = score.delta_e;
    return status;
}
