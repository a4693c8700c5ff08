/* SPDX-License-Identifier: MIT
 *
 * Pairs of texels are scored by their values. Where normals differ the test is tilted.
 */
#include "texture/score.h"

#include <math.h>

enum { BLOCK = NQM_TEXEL_BLOCK };
_Static_assert((int)BLOCK == (int)NQM_SCORE_BLOCK, "texels are scored in blocks");

/* A block of pairs. */
typedef struct scoring {
    nqm_texture_job *job;
    int exchange;
    nqm_label *parts;
    size_t n_pairs, at[BLOCK];
    nqm_subject subjects[2 * BLOCK]; /* (n_pairs, 2) those that differ */
    nqm_values values[2 * BLOCK];
    nqm_score_result results[BLOCK];
    nqm_error errors[BLOCK];
} scoring;

/* The reference and the test of texel i, at the place of the next pair. */
static void make_pair(scoring *s, size_t i, const float *const rows[2]) {
    const nqm_texture *const *t = s->job->side;
    nqm_subject *pair = s->subjects + 2 * s->n_pairs;
    nqm_values *values = s->values + 2 * s->n_pairs;
    const size_t side = s->exchange == NQM_EXCHANGE_ALL || s->exchange == NQM_EXCHANGE_FLAT;
    pair[0] = nqm_texture_subject(t[0], rows[0], i, &values[0]);
    pair[1] = nqm_texture_subject(t[side], rows[side], i, &values[1]);
    for (size_t c = 0; s->exchange >= 0 && c < 3; ++c)
        values[1].v[s->exchange][c] = nqm_texture_value(t[1], (size_t)s->exchange, c, rows[1], i);
    if (s->exchange == NQM_EXCHANGE_ALL || s->exchange == NQM_EXCHANGE_NORMAL) {
        double tilt[3];
        nqm_texels_tilt(s->job, rows, i, tilt);
        nqm_subject_tilt(&pair[1], tilt);
    }
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
    for (size_t i = 0; i < n; ++i) {
        samples[i].delta_e = 0;
        samples[i].jod = 10;
        samples[i].jod_low = samples[i].jod_high = same;
        make_pair(s, i, rows);
        if (!nqm_subjects_equal(&s->subjects[2 * s->n_pairs], &s->subjects[2 * s->n_pairs + 1]))
            s->at[s->n_pairs++] = i;
    }
    if (status == NQM_OK)
        status = nqm_scorer_run_subjects(s->job->scorer, s->n_pairs, s->subjects, s->results, s->errors, err);
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
