/* SPDX-License-Identifier: MIT
 *
 * What the keys of shading models mean, which is read from their names, because the models take their names from file formats
 * that agree on them (roughness, metallic, base_color, clearcoat, sheen, ...): bounds and scale of the search, layers.
 */
#include "fit/fit.h"

#include <ctype.h>
#include <math.h>

/* Names without '_' in lower case: some formats write coat_roughness, others coatRoughness. */
typedef struct plain_name {
    char text[64];
} plain_name;

static plain_name plain(const char *name) {
    plain_name p = {""};
    for (size_t n = 0; *name && n < sizeof p.text - 1; ++name)
        if (*name != '_')
            p.text[n++] = (char)tolower((unsigned char)*name);
    return p;
}

static bool contains(const char *name, const char *word) {
    return strstr(plain(name).text, word) != NULL;
}

static bool is_index_of_refraction(const nqm_spec_key *key) {
    return contains(key->name, "ior") || (key->low >= 1 && contains(key->name, "eta"));
}

/* Layers over the base: coat, clearcoat, sheen, fuzz. */
static bool is_of_layer(const char *name) {
    return contains(name, "coat") || contains(name, "sheen") || contains(name, "fuzz");
}

static bool is_width(const char *name) {
    return contains(name, "rough") || strcmp(name, "alpha") == 0;
}

/* Films make f_r oscillate with their thickness: no fit finds it. */
bool nqm_fit_is_kept(const nqm_spec_key *key) {
    return key->whole || key->turns || contains(key->name, "film") || contains(key->name, "iridescence");
}

bool nqm_fit_is_layer(const nqm_spec_key *key) {
    static const char *const names[] = {"clearcoat", "coat",       "coatweight", "sheen",
                                        "fuzz",      "fuzzweight", "sheencolor", "sheenweight"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
        if (strcmp(plain(key->name).text, names[i]) == 0)
            return key->fallback == 0 && !key->whole && !key->required;
    return false;
}

double nqm_fit_default(const nqm_spec_key *key) {
    double value = !key->required ? key->fallback : is_index_of_refraction(key) ? 1.5 : is_width(key->name) ? 0.3 : 0.5;
    return fmin(fmax(value, key->low), key->high);
}

/* Length of the plain name of the amount of a layer without its ending, as of coat_weight. */
static size_t stem_length(const char *text) {
    static const char *const endings[] = {"weight", "color"};
    size_t n = strlen(text);
    for (size_t i = 0; i < 2; ++i)
        if (n > strlen(endings[i]) && strcmp(text + n - strlen(endings[i]), endings[i]) == 0)
            return n - strlen(endings[i]);
    return n;
}

/* The key of the amount of the layer that a key describes, as coat_weight for coat_ior; the key itself: none. */
static size_t layer_of(const nqm_spec_schema *schema, size_t key) {
    const plain_name name = plain(schema->keys[key].name);
    for (size_t k = 0; k < schema->n_keys && !nqm_fit_is_layer(&schema->keys[key]); ++k) {
        const plain_name amount = plain(schema->keys[k].name);
        if (nqm_fit_is_layer(&schema->keys[k]) && strncmp(name.text, amount.text, stem_length(amount.text)) == 0)
            return k;
    }
    return key;
}

/* ---- roles in the base and in layers ------------------------------------------------------------------------------ */

static bool is_base(const nqm_spec_key *key, nqm_fit_role role) {
    switch (role) {
    case NQM_FIT_BASE_WIDTH:
        return key->n < 3 && is_width(key->name) && !is_of_layer(key->name) && !contains(key->name, "diffuse");
    case NQM_FIT_BASE_METAL:
        return key->n == 1 && contains(key->name, "metal");
    default:
        return key->n == 3 && (contains(key->name, "basecolor") || contains(key->name, "diffusecolor") ||
                               contains(key->name, "diffusereflectance"));
    }
}

size_t nqm_fit_base_key(const nqm_spec_schema *schema, nqm_fit_role role) {
    size_t k = 0;
    while (k < schema->n_keys && !is_base(&schema->keys[k], role))
        ++k;
    return k;
}

size_t nqm_fit_layer_key(const nqm_spec_schema *schema, size_t layer, const char *ending) {
    char key[sizeof(plain_name) + 16];
    const plain_name amount = plain(schema->keys[layer].name);
    size_t k = 0;
    snprintf(key, sizeof key, "%.*s%s", (int)stem_length(amount.text), amount.text, ending);
    while (k < schema->n_keys && strcmp(plain(schema->keys[k].name).text, key) != 0)
        ++k;
    return k;
}

double nqm_fit_layer_width(const nqm_spec_schema *schema, size_t layer) {
    return contains(schema->keys[layer].name, "coat") ? 0.1 : 0.4;
}

/* ---- the scale of the search -------------------------------------------------------------------------------------- */

/* A unit of every coordinate changes f_r by about the factor e: widths count by the square, as alpha = roughness^2. */
nqm_fit_parameter nqm_fit_describe(const nqm_spec_schema *schema, size_t k) {
    const nqm_spec_key *key = &schema->keys[k];
    nqm_fit_parameter p = {
        .key = k, .layer = layer_of(schema, k), .low = key->low, .high = key->high, .units = 1, .is_log = true};
    double offset = 0.05; /* of the logarithm, from the lower end */
    if (is_index_of_refraction(key)) {
        p.low = fmax(key->low, 1);
        p.high = fmin(key->high, 5);
        p.units = 4;
        offset = p.low;
    } else if (strcmp(key->name, "alpha") == 0) {
        offset = 4e-4;
    } else if (is_width(key->name)) {
        p.units = 2;
        offset = 0.02;
    } else if (contains(key->name, "gloss")) {
        p.units = 4;
        p.is_log = false;
    } else if (is_base(key, NQM_FIT_BASE_METAL)) {
        p.units = 2;
        p.is_log = false;
    }
    p.zero = p.low - offset;
    /* Weights and colours that renderers and their editors take, although the formats allow more. The outer index only scales
     * the inner one. */
    if (!is_index_of_refraction(key) && key->fallback <= 1)
        p.high = fmin(p.high, 1);
    if (contains(key->name, "extior"))
        p.high = p.low;
    return p;
}
