/* SPDX-License-Identifier: MIT
 *
 * Pairs of texels are scored as specs. Where normals differ the test is tilted.
 */
#include "texture/score.h"

#include <math.h>

enum { BLOCK = NQM_TEXEL_BLOCK };
_Static_assert((int)BLOCK == (int)NQM_SCORE_BLOCK, "texels are scored in blocks");

/* The specs of a block of pairs. */
typedef struct scoring {
    nqm_texture_job *job;
    int exchange;
    nqm_label *parts;
    char *ref[BLOCK], *test[BLOCK];
    size_t n_pairs, at[BLOCK];
    nqm_named_pair pairs[BLOCK]; /* those that differ */
    nqm_score_result results[BLOCK];
    nqm_error errors[BLOCK];
} scoring;

static bool make_pair(scoring *s, size_t i, const float *const rows[2]) {
    const nqm_texture *const *t = s->job->side;
    const size_t side = s->exchange == NQM_EXCHANGE_ALL || s->exchange == NQM_EXCHANGE_FLAT;
    s->ref[i] = nqm_texture_spec(t[0], rows[0], i);
    if (s->exchange >= 0) {
        const size_t k = (size_t)s->exchange;
        const nqm_values test = nqm_texture_values(t[1], rows[1], i);
        nqm_values exchanged = nqm_texture_values(t[0], rows[0], i);
        memcpy(exchanged.v[k], test.v[k], sizeof test.v[k]);
        exchanged.given |= UINT64_C(1) << k;
        s->test[i] = nqm_values_spec(&exchanged);
    } else {
        s->test[i] = nqm_texture_spec(t[side], rows[side], i);
    }
    if (s->exchange == NQM_EXCHANGE_ALL || s->exchange == NQM_EXCHANGE_NORMAL) {
        double tilt[3];
        nqm_texels_tilt(s->job, rows, i, tilt);
        s->test[i] = nqm_texture_tilt(s->test[i], tilt);
    }
    return s->ref[i] && s->test[i];
}

static nqm_status fail_texel(const nqm_texture_job *job, uint32_t texel, const nqm_error *why, nqm_error *err) {
    const nqm_status status = why->status == NQM_ERR_NOMEM ? NQM_ERR_NOMEM : NQM_ERR_INCOMPATIBLE;
    return nqm_fail(err, status, -1, "texel (%zu, %zu) of %s and %s: %.300s", texel % job->width, texel / job->width,
                    job->side[0]->name, job->side[1]->name, why->message);
}

static nqm_status score_block(void *user, size_t n, nqm_texel_sample *samples, const float *const rows[2],
                              nqm_error *err) {
    scoring *s = user;
    const double same = s->job->model->interval ? 10 : NAN;
    nqm_status status = NQM_OK;
    s->n_pairs = 0;
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        samples[i].delta_e = 0;
        samples[i].jod = 10;
        samples[i].jod_low = samples[i].jod_high = same;
        if (!make_pair(s, i, rows)) {
            status = nqm_fail_nomem(err, sizeof(nqm_values));
        } else if (strcmp(s->ref[i], s->test[i]) != 0) {
            s->at[s->n_pairs] = i;
            s->pairs[s->n_pairs++] = (nqm_named_pair){s->ref[i], s->test[i]};
        }
    }
    if (status == NQM_OK)
        status = nqm_scorer_run_named(s->job->scorer, s->n_pairs, s->pairs, s->results, s->errors, err);
    for (size_t i = 0; status == NQM_OK && i < s->n_pairs; ++i) {
        const nqm_score_result *r = &s->results[i];
        nqm_texel_sample *sample = &samples[s->at[i]];
        sample->delta_e = r->delta_e;
        sample->jod = r->jod;
        sample->jod_low = r->jod_low;
        sample->jod_high = r->jod_high;
        if (s->parts)
            nqm_label_add(s->parts, sample->weight, &r->parts);
        if (r->status != NQM_OK)
            status = fail_texel(s->job, sample->texel, &s->errors[i], err);
    }
    for (size_t i = 0; i < n; ++i) {
        nqm_free(s->ref[i]);
        nqm_free(s->test[i]);
        s->ref[i] = s->test[i] = NULL;
    }
    return status;
}

nqm_status nqm_texels_score(nqm_texture_job *job, const char *stage, int exchange, size_t n, nqm_texel_sample *samples,
                            nqm_label *parts, nqm_error *err) {
    scoring *s = nqm_alloc(1, sizeof *s);
    if (!s)
        return nqm_fail_nomem(err, sizeof *s);
    s->job = job;
    s->exchange = exchange;
    s->parts = parts;
    nqm_status status = nqm_texels_visit(job, stage, n, samples, score_block, s, err);
    nqm_free(s);
    return status;
}

int nqm_texels_compare_delta_e(const void *a, const void *b) {
    const double x = ((const nqm_texel_sample *)a)->delta_e, y = ((const nqm_texel_sample *)b)->delta_e;
    return (x > y) - (x < y);
}
