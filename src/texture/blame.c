/* SPDX-License-Identifier: MIT
 *
 * Which map is to blame: the reference is scored beside itself with one property of the test. Known mistakes are found by applying
 * them to the reference's map: one is named if it explains more than 90 % of the difference.
 */
#include "texture/score.h"

#include "brdf/core/mistakes.h"
#include <math.h>
#include <stdlib.h>

/* ---- mistakes ---------------------------------------------------------------------------------------------------- */

/* What may have been done with the values of a map. Those without a function: */
enum { NOTHING, EXCHANGED };
static const nqm_property_mistake mistakes[] = {
    [NOTHING] = {"", NULL}, [EXCHANGED] = {" are exchanged", NULL}, NQM_PROPERTY_MISTAKES};
enum { N_MISTAKES = sizeof mistakes / sizeof *mistakes, NO_PROPERTY = NQM_SCHEMA_MAX_KEYS };

/* A property, or the normal, and what each mistake leaves of the difference. */
typedef struct suspect {
    const nqm_texture_job *job;
    int exchange;
    size_t partner; /* the property with which it may have been exchanged, or NO_PROPERTY */
    double left[N_MISTAKES];
} suspect;

/* Channels of one map that are exchanged easily: metalness and roughness. */
static size_t find_partner(const nqm_texture *t, int exchange) {
    const nqm_role role = exchange < 0 ? NQM_ROLE_NONE : t->keys[exchange].role;
    if (role != NQM_ROLE_METAL && role != NQM_ROLE_WIDTH)
        return NO_PROPERTY;
    const size_t k = nqm_schema_key_of(t->values.schema, role == NQM_ROLE_METAL ? NQM_ROLE_WIDTH : NQM_ROLE_METAL);
    return k < t->n_properties ? k : NO_PROPERTY;
}

/* partner: NaN if there is none. A difference that a mistake cannot have becomes NaN. */
static void compare(suspect *s, double weight, double ref, double test, double partner) {
    for (size_t k = 0; k < N_MISTAKES; ++k)
        s->left[k] += weight * fabs(test - (mistakes[k].apply ? mistakes[k].apply(ref)
                                            : k == EXCHANGED  ? partner
                                                              : ref));
}

static nqm_status compare_block(void *user, size_t n, nqm_texel_sample *samples, const float *const rows[2],
                                nqm_error *err) {
    suspect *s = user;
    const nqm_texture *const *t = s->job->side;
    (void)err;
    for (size_t i = 0; i < n; ++i) {
        const double weight = samples[i].weight;
        double normal[2][3];
        for (size_t side = 0; side < 2; ++side)
            nqm_texture_normal(t[side], rows[side], i, normal[side]);
        for (size_t c = 0; s->exchange >= 0 && c < t[0]->keys[s->exchange].n; ++c)
            compare(s, weight, nqm_texture_value(t[0], (size_t)s->exchange, c, rows[0], i),
                    nqm_texture_value(t[1], (size_t)s->exchange, c, rows[1], i),
                    s->partner == NO_PROPERTY ? NAN : nqm_texture_value(t[0], s->partner, 0, rows[0], i));
        if (s->exchange < 0)
            compare(s, weight, normal[0][1], normal[1][1], NAN);
        for (size_t k = 0; s->exchange < 0 && k < N_MISTAKES; ++k)
            s->left[k] += weight * fabs(normal[1][0] - normal[0][0]);
    }
    return NQM_OK;
}

/* A property of which the reference has no map is no map that something was done with. */
static nqm_status name_mistake(nqm_texture_job *job, int exchange, size_t n, nqm_texel_sample *samples,
                               nqm_texture_blame *blame, nqm_error *err) {
    const nqm_texture *t = job->side[0];
    suspect s = {.job = job, .exchange = exchange, .partner = find_partner(t, exchange)};
    nqm_status status = nqm_texels_visit(job, NULL, n, samples, compare_block, &s, err);
    size_t least = NOTHING;
    for (size_t k = 0; k < N_MISTAKES; ++k)
        least = s.left[k] < s.left[least] ? k : least;
    const bool has_map = exchange < 0 || t->properties[exchange].node != NQM_NO_NODE ||
                         (least == EXCHANGED && t->properties[s.partner].node != NQM_NO_NODE);
    if (status != NQM_OK || !has_map || !(s.left[least] < 0.1 * s.left[NOTHING]))
        return status;
    const char *key = exchange < 0 ? "the green channel of the normal map" : t->keys[exchange].name;
    const char *other = least == EXCHANGED ? t->keys[s.partner].name : "";
    const bool is_first = least != EXCHANGED || t->keys[exchange].role == NQM_ROLE_METAL;
    char text[160];
    snprintf(text, sizeof text, "%s%s%s%s", is_first ? key : other, *other ? " and " : "", is_first ? other : key,
             mistakes[least].text);
    snprintf(blame->mistake, sizeof blame->mistake, "%.79s", text);
    return NQM_OK;
}

/* ---- blame ------------------------------------------------------------------------------------------------------- */

static nqm_status blame_one(nqm_texture_job *job, int exchange, size_t n, nqm_texel_sample *samples,
                            nqm_texture_result *result, nqm_error *err) {
    if (result->n_blame == NQM_TEXTURE_MAX_BLAME)
        return NQM_OK;
    nqm_texture_blame *blame = &result->blame[result->n_blame++];
    double delta_e = 0;
    nqm_status status = nqm_texels_score(job, "blame", exchange, n, samples, NULL, err);
    for (size_t i = 0; i < n; ++i)
        delta_e += samples[i].weight * samples[i].delta_e;
    blame->jod = n == 1 ? samples->jod : nqm_curve_jod(&job->model->curve, delta_e);
    snprintf(blame->key, sizeof blame->key, "%s", exchange < 0 ? "normal" : job->side[0]->keys[exchange].name);
    return status == NQM_OK ? name_mistake(job, exchange, n, samples, blame, err) : status;
}

static int compare_blame(const void *a, const void *b) {
    const nqm_texture_blame *x = a, *y = b;
    return x->jod != y->jod ? (x->jod > y->jod) - (x->jod < y->jod) : strcmp(x->key, y->key);
}

nqm_status nqm_texture_blame_find(nqm_texture_job *job, nqm_texture_result *result, nqm_error *err) {
    enum { SHARE = 8, SHARE_TILTED = 32, LEAST = 16 };
    const size_t n_texels = job->options.n_texels, max_n = nqm_larger(n_texels / SHARE, LEAST);
    const uint64_t seed = job->options.seed + 2;
    nqm_texel_sample *samples = nqm_alloc(max_n, sizeof *samples);
    if (!samples)
        return nqm_fail_nomem(err, max_n * sizeof *samples);
    nqm_status status = NQM_OK;
    size_t n = nqm_texels_choose(&job->order, max_n, seed, samples);
    for (size_t k = 0; status == NQM_OK && k < job->side[0]->n_properties; ++k)
        if (nqm_texels_differ(job, NQM_DIFFERENCE, k))
            status = blame_one(job, (int)k, n, samples, result, err);
    if (status == NQM_OK && nqm_texels_differ(job, NQM_TILT, 0)) {
        n = nqm_texels_choose(&job->order, nqm_larger(n_texels / SHARE_TILTED, LEAST), seed, samples);
        status = blame_one(job, NQM_EXCHANGE_NORMAL, n, samples, result, err);
    }
    qsort(result->blame, result->n_blame, sizeof *result->blame, compare_blame);
    nqm_free(samples);
    return status;
}
