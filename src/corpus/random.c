/* SPDX-License-Identifier: MIT
 *
 * Random parameters of analytic models. The ranges of a model's keys catch typing errors and hold few plausible materials, so
 * shapes are drawn from narrower ranges, and the specular colour from a range of albedos: in some models the albedo of a lobe
 * with ks = 1 depends on its shape by many orders of magnitude.
 */
#include "brdf/core/spec.h"
#include "corpus/corpus.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

typedef struct range {
    const char *model; /* NULL: every model with this key */
    const char *key;
    double low, high;
    bool is_log; /* log-uniform; otherwise uniform */
} range;

/* The first row that fits is used. The ranges of sgd, whose alpha is the square of a slope, are those of the published fits, where
 * they do not darken all of the hemisphere. */
/* clang-format off */
static const range ranges[] = {
    {"lafortune", "n", 1, 100, true}, /* with larger ones the lobe vanishes at most angles unless cz is 1 */
    {"sgd", "alpha", 1e-5, 0.5, true},
    {"sgd", "f1", -0.5, 0.2, false},
    {NULL, "p", 0, 1.5, false},
    {NULL, "K", 1, 1, false}, /* a factor of ks */
    {NULL, "lambda", 0.1, 6, true},
    {NULL, "c", 1e-3, 1, true},
    {NULL, "k", 5, 15, true},
    {NULL, "theta0", 0.5, 1.2, false},
    {NULL, "alpha", 2e-3, 1, true},
    {NULL, "n", 1, 1e5, true},
    {NULL, "cxy", -1, -1, false},
    {NULL, "cz", 0.95, 1.05, false},
    {NULL, "f0", 0.02, 1, true},
    {NULL, "eta", 1.1, 20, true},
    {NULL, "B", 1, 1e7, true},
    {NULL, "C", 0.2, 3, true},
};
/* clang-format on */
static const double LOW_ALBEDO = 0.003, HIGH_ALBEDO = 0.9;

/* An albedo; half of them grey, the others with factors up to e between the channels. */
static void draw_colour(nqm_rng *rng, double rgb[3]) {
    double albedo = nqm_rng_log_uniform(rng, LOW_ALBEDO, HIGH_ALBEDO);
    bool is_grey = nqm_rng_uniform(rng) < 0.5;
    for (int c = 0; c < 3; ++c) {
        double factor = exp(-nqm_rng_uniform(rng));
        rgb[c] = is_grey ? albedo : albedo * factor;
    }
}

static double draw_shape(nqm_rng *rng, const char *model, const nqm_spec_key *key) {
    const range *r = ranges;
    while (r < ranges + sizeof ranges / sizeof *ranges &&
           !(strcmp(r->key, key->name) == 0 && (!r->model || strcmp(r->model, model) == 0)))
        ++r;
    bool found = r < ranges + sizeof ranges / sizeof *ranges;
    double low = found ? r->low : key->low, high = found ? r->high : key->high;
    return found && r->is_log ? nqm_rng_log_uniform(rng, low, high) : low + (high - low) * nqm_rng_uniform(rng);
}

/* Albedo of the model without its base for ks = 1, for light at 45 degrees. */
static nqm_status lobe_albedo(const nqm_spec_schema *schema, nqm_spec_values values, double *albedo_ret,
                              nqm_error *err) {
    nqm_brdf *brdf;
    double rgb[3];
    memset(values.v[0], 0, sizeof values.v[0]);
    char *spec = nqm_spec_format(schema, &values);
    nqm_status status = spec ? nqm_brdf_open(spec, &brdf, err) : nqm_fail_nomem(err, sizeof values);
    nqm_free(spec);
    if (status != NQM_OK)
        return status;
    nqm_brdf_albedo(brdf, NQM_PI / 4, 1, rgb);
    nqm_brdf_free(brdf);
    *albedo_ret = rgb[0] > 1e-9 && isfinite(rgb[0]) ? rgb[0] : 1;
    return NQM_OK;
}

nqm_status nqm_corpus_random_spec(nqm_rng *rng, const char *model, char **spec_ret, nqm_error *err) {
    const nqm_spec_schema *schema = &nqm_analytic_model_find(model, strlen(model))->schema;
    nqm_spec_values values = {.given = (1u << schema->n_keys) - 1};
    double base[3], specular[3], albedo = 1;
    *spec_ret = NULL;
    draw_colour(rng, base);
    draw_colour(rng, specular);
    bool has_base = nqm_rng_uniform(rng) < 0.75, has_lobe = false;
    for (size_t k = 0; k < schema->n_keys; ++k) {
        const nqm_spec_key *key = &schema->keys[k];
        bool is_specular = strcmp(key->name, "ks") == 0;
        double value = is_specular || k == 0 ? 1 : draw_shape(rng, model, key);
        for (int c = 0; c < 3; ++c)
            values.v[k][c] = nqm_round_digits(value, 4);
        has_lobe = has_lobe || is_specular;
    }
    nqm_status status = has_lobe ? lobe_albedo(schema, values, &albedo, err) : NQM_OK;
    if (status != NQM_OK)
        return status;
    for (int c = 0; c < 3; ++c) { /* kd and ks are the first two keys of every model that has both */
        values.v[0][c] = has_base || !has_lobe ? nqm_round_digits(base[c], 4) : 0;
        if (has_lobe)
            values.v[1][c] = nqm_round_digits(fmin(specular[c] / albedo, schema->keys[1].high), 4);
    }
    *spec_ret = nqm_spec_format(schema, &values);
    return *spec_ret ? NQM_OK : nqm_fail_nomem(err, sizeof values);
}
