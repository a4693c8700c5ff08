/* SPDX-License-Identifier: MIT
 *
 * Which map is to blame: the reference is scored beside itself with one property of the test. Known mistakes are found by applying
 * them to the reference's map: one is named if it explains more than 90 % of the difference.
 */
#include "texture/score.h"

#include "material/color_space.h"
#include <math.h>
#include <stdlib.h>

/* ---- mistakes ---------------------------------------------------------------------------------------------------- */

static double square(double x) {
    return x * x;
}

static double invert(double x) {
    return 1 - x;
}

static double encode_srgb(double x) {
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}

static double keep(double x) {
    return x;
}

/* What may have been done with the values of a map. The first is the right thing. */
static const struct {
    double (*apply)(double x);
    const char *text;
} mistakes[] = {{keep, ""},
                {square, "%s is squared"},
                {sqrt, "%s is the square root"},
                {nqm_srgb_to_linear, "%s is decoded from sRGB"},
                {encode_srgb, "%s is not decoded from sRGB"},
                {invert, "%s is inverted"}};
/* After these of the list, for lack of a function: */
enum { N_MISTAKES = sizeof mistakes / sizeof *mistakes, EXCHANGED = N_MISTAKES, FLIPPED, N_RESIDUALS };

/* Mean absolute differences of a property, or of the normals, that each mistake leaves. */
typedef struct residuals {
    double of[N_RESIDUALS];
} residuals;

static bool is_key(const nqm_pair_property *p, const char *keys) {
    return p->n == 1 && nqm_has_word(keys, p->key, false);
}

/* The property with which this one may have been exchanged; NULL: none. */
static const nqm_pair_property *find_partner(const nqm_texel_pair *pair, const nqm_pair_property *p) {
    static const char metal[] = "metallic metalness base_metalness", rough[] = "roughness specular_roughness";
    const char *wanted = is_key(p, metal) ? rough : is_key(p, rough) ? metal : "";
    for (size_t k = 0; k < pair->n_properties; ++k)
        if (is_key(&pair->properties[k], wanted))
            return &pair->properties[k];
    return NULL;
}

static void add_texel(const nqm_pair_property *p, const nqm_pair_property *partner, const float *const values[2],
                      size_t i, double weight, residuals *r) {
    for (size_t c = 0; c < p->n; ++c) {
        const double x = (double)nqm_texel_pair_value(p, 0, values[0], c, i);
        const double y = (double)nqm_texel_pair_value(p, 1, values[1], c, i);
        for (size_t k = 0; k < N_MISTAKES; ++k)
            r->of[k] += weight * fabs(y - mistakes[k].apply(x));
        r->of[EXCHANGED] +=
            weight * (partner ? fabs(y - (double)nqm_texel_pair_value(partner, 0, values[0], 0, i)) : 1);
    }
}

static void add_normal(const nqm_texel_pair *pair, const float *const values[2], size_t i, double weight,
                       residuals *r) {
    double normal[2][3];
    for (size_t s = 0; s < 2; ++s)
        nqm_texel_pair_normal(pair, s, values[s], i, normal[s]);
    const double x = fabs(normal[1][0] - normal[0][0]);
    r->of[0] += weight * (x + fabs(normal[1][1] - normal[0][1]));
    r->of[FLIPPED] += weight * (x + fabs(normal[1][1] + normal[0][1]));
}

static size_t find_least(const residuals *r, size_t begin, size_t end) {
    size_t least = begin;
    for (size_t k = begin; k < end; ++k)
        least = r->of[k] < r->of[least] ? k : least;
    return r->of[least] < 0.1 * r->of[0] ? least : 0;
}

/* ---- blame ------------------------------------------------------------------------------------------------------- */

/* Texels at which properties are exchanged. */
typedef struct sample {
    size_t n;
    nqm_texel_choice *choices;
    nqm_texel_score *scores;
} sample;

static void find_residuals(nqm_texture_job *job, const sample *s, int property, residuals *r) {
    const nqm_texel_pair *pair = &job->pair;
    const nqm_pair_property *p = property >= 0 ? &pair->properties[property] : NULL;
    const nqm_pair_property *partner = p ? find_partner(pair, p) : NULL;
    for (size_t first = 0, n; first < s->n; first += n) {
        uint32_t texels[NQM_TEXEL_BLOCK];
        const float *values[2];
        n = nqm_smaller(s->n - first, NQM_TEXEL_BLOCK);
        for (size_t i = 0; i < n; ++i)
            texels[i] = s->choices[first + i].texel;
        nqm_texel_pair_evaluate(pair, n, texels, 0, job->workspace, values);
        for (size_t i = 0; i < n; ++i)
            if (p)
                add_texel(p, partner, values, i, s->choices[first + i].weight, r);
            else
                add_normal(pair, values, i, s->choices[first + i].weight, r);
    }
}

/* A property of which the reference has no map is no map that something was done with. */
static void name_mistake(nqm_texture_job *job, const sample *s, int property, nqm_texture_blame *blame) {
    const nqm_texel_pair *pair = &job->pair;
    residuals r = {{0}};
    find_residuals(job, s, property, &r);
    if (property == NQM_EXCHANGE_NORMAL) {
        if (find_least(&r, FLIPPED, N_RESIDUALS))
            snprintf(blame->mistake, sizeof blame->mistake, "the green channel of the normal map is flipped");
        return;
    }
    const nqm_pair_property *p = &pair->properties[property], *partner = find_partner(pair, p);
    const size_t mistake = find_least(&r, 1, FLIPPED);
    if (mistake == EXCHANGED && (p->at[0] >= 0 || partner->at[0] >= 0)) {
        const bool is_first = strstr(p->key, "metal") != NULL;
        snprintf(blame->mistake, sizeof blame->mistake, "%.30s and %.30s are exchanged",
                 is_first ? p->key : partner->key, is_first ? partner->key : p->key);
    } else if (mistake && mistake < N_MISTAKES && p->at[0] >= 0) {
        const char *text = mistakes[mistake].text + 2; /* after the key */
        snprintf(blame->mistake, sizeof blame->mistake, "%s%s", p->key, text);
    }
}

static bool differs(const nqm_texel_pair *pair, size_t property) {
    const nqm_pair_property *p = &pair->properties[property];
    bool is_different = p->at[0] < 0 && p->at[1] < 0; /* two constants are a property only if they differ */
    for (size_t d = 0; d < pair->n_dimensions; ++d)
        is_different =
            is_different || (pair->dimensions[d].kind == NQM_DIFFERENCE && pair->dimensions[d].property == property);
    return is_different;
}

static nqm_status blame_one(nqm_texture_job *job, const sample *s, int property, nqm_texture_result *result,
                            nqm_error *err) {
    if (result->n_blame == NQM_TEXTURE_MAX_BLAME)
        return NQM_OK;
    nqm_texture_blame *blame = &result->blame[result->n_blame];
    double delta_e = 0;
    nqm_status status = nqm_texels_score(job, "blame", property, s->n, s->choices, s->scores, err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < s->n; ++i)
        delta_e += s->choices[i].weight * s->scores[i].delta_e;
    blame->jod = s->n == 1 ? s->scores->jod : nqm_curve_jod(&job->model->curve, delta_e);
    snprintf(blame->key, sizeof blame->key, "%s", property < 0 ? "normal" : job->pair.properties[property].key);
    name_mistake(job, s, property, blame);
    ++result->n_blame;
    return NQM_OK;
}

static int compare_blame(const void *a, const void *b) {
    const nqm_texture_blame *x = a, *y = b;
    return x->jod != y->jod ? (x->jod > y->jod) - (x->jod < y->jod) : strcmp(x->key, y->key);
}

nqm_status nqm_texture_blame_find(nqm_texture_job *job, nqm_texture_result *result, nqm_error *err) {
    enum { SHARE = 8, SHARE_TILTED = 32, LEAST = 16 };
    const size_t max_n = nqm_larger(job->options.n_texels / SHARE, LEAST);
    sample s = {0};
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&s.choices, max_n, sizeof *s.choices}, {&s.scores, max_n, sizeof *s.scores}), err);
    if (status != NQM_OK)
        return status;
    s.n = nqm_texels_choose(&job->groups, max_n, false, job->options.seed + 2, s.choices);
    for (size_t k = 0; status == NQM_OK && k < job->pair.n_properties; ++k)
        if (differs(&job->pair, k))
            status = blame_one(job, &s, (int)k, result, err);
    if (status == NQM_OK && nqm_texel_pair_tilts(&job->pair)) {
        s.n = nqm_texels_choose(&job->groups, nqm_larger(job->options.n_texels / SHARE_TILTED, LEAST), false,
                                job->options.seed + 2, s.choices);
        status = blame_one(job, &s, NQM_EXCHANGE_NORMAL, result, err);
    }
    qsort(result->blame, result->n_blame, sizeof *result->blame, compare_blame);
    nqm_free(s.choices);
    return status;
}
