/* SPDX-License-Identifier: MIT
 *
 * Variants of a reference: the same spec with another width of a lobe or another value of one key, the material in another shading
 * model, its reciprocal table, and networks that were overfitted to few of its directions.
 */
#include "brdf/core/spec.h"
#include "corpus/corpus.h"

#include <math.h>
#include <string.h>

/* A key that sets the width of a lobe: value = alpha^exponent. The first row that fits is used. */
typedef struct width_key {
    const char *model; /* NULL: every model with this key */
    const char *key;
    double exponent;
} width_key;

static const width_key width_keys[] = {{"sgd", "alpha", 2},
                                       {NULL, "alpha", 1},
                                       {NULL, "n", -2},
                                       {NULL, "B", -2},
                                       {"pbrt-conductor", "roughness", 2},
                                       {NULL, "roughness", 0.5},
                                       {NULL, "specular_roughness", 0.5},
                                       {NULL, "clearcoat_roughness", 0.5},
                                       {NULL, "clearcoatRoughness", 0.5},
                                       {NULL, "coat_roughness", 0.5}};

enum { MAX_TRIES = 16, N_PAIRS = 64 };

/* The exponent of a key that sets a width; 0: it is another key. */
static double width_exponent(const nqm_spec_schema *schema, size_t key) {
    for (size_t i = 0; i < sizeof width_keys / sizeof *width_keys; ++i)
        if (strcmp(width_keys[i].key, schema->keys[key].name) == 0 &&
            (!width_keys[i].model || strcmp(width_keys[i].model, schema->model) == 0))
            return width_keys[i].exponent;
    return 0;
}

static double clamp(const nqm_spec_key *key, double value) {
    return fmin(fmax(nqm_round_digits(value, 4), key->low), key->high);
}

/* Multiply alpha by 0.1 to 10; one width in six becomes the smallest, of most models 0. */
static void change_width(nqm_rng *rng, const nqm_spec_key *key, double exponent, double *value) {
    const double factor = pow(nqm_rng_log_uniform(rng, 0.1, 10), exponent);
    const double small = pow(nqm_rng_log_uniform(rng, 1e-3, 0.1), exponent), u = nqm_rng_uniform(rng);
    for (size_t c = 0; c < 3; ++c)
        if (exponent > 0)
            value[c] = u < 1.0 / 6 ? key->low : clamp(key, value[c] <= key->low ? small : value[c] * factor);
        else
            value[c] = clamp(key, value[c] * factor);
}

/* Colours get a factor for all channels, or one for each; numbers up to 1 a difference, larger ones a factor. */
static void change_value(nqm_rng *rng, const nqm_spec_key *key, double *value) {
    const double size = nqm_rng_log_uniform(rng, 0.01, 1) * (nqm_rng_uniform(rng) < 0.5 ? -1 : 1);
    const bool is_grey = nqm_rng_uniform(rng) < 0.5;
    for (size_t c = 0; c < 3; ++c) {
        const double share = key->n == 1 || is_grey ? 1 : 2 * nqm_rng_uniform(rng) - 1;
        const double sum = value[c] + size;
        if (key->n == 3 || key->high > 1)
            value[c] = clamp(key, value[c] * exp(size * share));
        else
            value[c] = clamp(key, sum < key->low || sum > key->high ? value[c] - size : sum);
    }
}

/* Whether two specs have values that differ, and the second has one everywhere. */
static nqm_status compare(const char *before, const char *after, nqm_rng *rng, bool *differ_ret, nqm_error *err) {
    nqm_brdf *a, *b = NULL;
    double hd[3 * N_PAIRS], rgb[2][3 * N_PAIRS];
    uint8_t flag[2][N_PAIRS];
    bool differ = false, good = true;
    nqm_status status = nqm_brdf_open(before, &a, err);
    if (status == NQM_OK && nqm_brdf_open(after, &b, NULL) == NQM_ERR_NOMEM)
        status = nqm_fail_nomem(err, strlen(after));
    for (size_t i = 0; i < N_PAIRS; ++i) { /* below 81 degrees; the first ones in the mirror direction */
        hd[3 * i] = i < N_PAIRS / 4 ? 0 : 0.7 * nqm_rng_uniform(rng) * nqm_rng_uniform(rng);
        hd[3 * i + 1] = 0.7 * nqm_rng_uniform(rng);
        hd[3 * i + 2] = 6 * nqm_rng_uniform(rng);
    }
    if (b) { /* otherwise the changed value does not go with the others */
        nqm_brdf_eval_half_diff(a, N_PAIRS, hd, rgb[0], flag[0]);
        nqm_brdf_eval_half_diff(b, N_PAIRS, hd, rgb[1], flag[1]);
        for (size_t i = 0; i < 3 * N_PAIRS; ++i)
            differ = differ || fabs(rgb[1][i] - rgb[0][i]) > 1e-4 * rgb[0][i];
        for (size_t i = 0; i < N_PAIRS; ++i)
            good = good && nqm_has_value(flag[1][i]);
    }
    nqm_brdf_free(a);
    nqm_brdf_free(b);
    *differ_ret = differ && good;
    return status;
}

/* Try once to change a key of `values`; returns false if it may not be changed. */
static bool change(nqm_rng *rng, const nqm_spec_schema *schema, bool of_width, nqm_spec_values *values) {
    const bool has_shapes =
        strcmp(schema->model, "sgd") == 0; /* only its albedos and widths are plausible when changed */
    const size_t k = (size_t)nqm_rng_below(rng, has_shapes ? 3 : schema->n_keys);
    const nqm_spec_key *key = &schema->keys[k];
    const double exponent = width_exponent(schema, k);
    if (key->whole || (exponent != 0) != of_width)
        return false;
    if (of_width)
        change_width(rng, key, exponent, values->v[k]);
    else
        change_value(rng, key, values->v[k]);
    values->given |= UINT64_C(1) << k;
    return true;
}

nqm_status nqm_corpus_change_spec(nqm_rng *rng, const char *spec, bool of_width, char **spec_ret, nqm_error *err) {
    const size_t n = strcspn(spec, ":");
    const nqm_analytic_model *model = spec[n] ? nqm_analytic_model_find(spec, n) : NULL;
    nqm_spec_values before;
    *spec_ret = NULL;
    nqm_status status = model ? nqm_spec_parse(&model->schema, spec + n + 1, &before, err) : NQM_OK;
    for (size_t tries = 0; model && status == NQM_OK && tries < MAX_TRIES * model->schema.n_keys; ++tries) {
        nqm_spec_values after = before;
        bool differ = false;
        if (!change(rng, &model->schema, of_width, &after))
            continue;
        char *text = nqm_spec_format(&model->schema, &after);
        status = text ? compare(spec, text, rng, &differ, err) : nqm_fail_nomem(err, sizeof after);
        if (differ) {
            *spec_ret = text;
            return NQM_OK;
        }
        nqm_free(text);
    }
    return status;
}

/* ---- all variants of a reference --------------------------------------------------------------------------------- */

static const char *const kinds[] = {"roughness", "key",        "overfit",   "key",
                                    "roughness", "translated", "roughness", "folded"};
enum { N_KINDS = sizeof kinds / sizeof *kinds };

/* The network or translation of a test. Directions of overfitted networks: every second one has the corpus's own. */
static void draw_made(nqm_rng *rng, const char *spec, nqm_corpus_test *test) {
    size_t n_models = 0;
    test->path = (nqm_corpus_path){.seed = nqm_rng_below(rng, 1000000)};
    if (test->base == NQM_BASE_OVERFIT) {
        test->path.n_steps = (size_t)nqm_rng_log_uniform(rng, 50, 500);
        test->which = (size_t)nqm_rng_below(rng, 2);
        return;
    }
    while (nqm_fit_shading(n_models))
        ++n_models;
    do
        test->path.model = nqm_fit_shading((size_t)nqm_rng_below(rng, n_models));
    while (spec && strncmp(spec, test->path.model, strlen(test->path.model)) == 0);
}

/* A changed spec that is NULL: the reference has no such variant. */
static nqm_status draw_variant(nqm_rng *rng, const nqm_brdf *ref, const char *kind, nqm_corpus_test *test,
                               nqm_error *err) {
    const char *spec = nqm_brdf_get_info(ref).spec;
    snprintf(test->kind.name, sizeof test->kind.name, "%s", kind);
    test->base = NQM_BASE_SPEC;
    if (strcmp(kind, "folded") == 0)
        test->base = NQM_BASE_TABLE;
    else if (strcmp(kind, "overfit") == 0)
        test->base = NQM_BASE_OVERFIT;
    else if (strcmp(kind, "translated") == 0)
        test->base = NQM_BASE_TRANSLATED;
    else if (spec)
        return nqm_corpus_change_spec(rng, spec, strcmp(kind, "roughness") == 0, &test->spec, err);
    if (test->base == NQM_BASE_OVERFIT || test->base == NQM_BASE_TRANSLATED)
        draw_made(rng, spec, test);
    return NQM_OK;
}

nqm_status nqm_corpus_draw_variants(nqm_rng *rng, const char *path, size_t n, size_t *n_drawn, nqm_corpus_test *tests,
                                    nqm_error *err) {
    nqm_brdf *ref = NULL;
    *n_drawn = 0;
    nqm_status status = n ? nqm_brdf_open(path, &ref, err) : NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        nqm_corpus_test *test = &tests[*n_drawn];
        const char *kind = kinds[i % N_KINDS];
        if (strcmp(kind, "folded") == 0 && (i >= N_KINDS || ref->class_->is_costly))
            continue; /* one table; costly references are tables */
        *test = (nqm_corpus_test){.kind.family = NQM_FAMILY_VARIANT};
        status = draw_variant(rng, ref, kind, test, err);
        *n_drawn += status == NQM_OK && (test->base != NQM_BASE_SPEC || test->spec);
    }
    nqm_brdf_free(ref);
    return status;
}
