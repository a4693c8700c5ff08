/* SPDX-License-Identifier: MIT
 *
 * The keys that two shading models share: names that mean the same in different file formats.
 */
#include "brdf/core/spec.h"
#include "fit/anisotropy.h"
#include "material/material.h"
#include "nqm/fit/translate.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

static const translate_target targets[] = {
    {"gltf", "gltf", ".gltf"},
    {"open-pbr", "open-pbr", ".mtlx"},
    {"openpbr", "open-pbr", ".mtlx"},
    {"standard-surface", "standard-surface", ".mtlx"},
    {"usd-preview", "usd-preview", ".mtlx"},
    {"usd", "usd-preview", ".mtlx"},
    {"disney", "disney", ".mtlx"},
    {"principled", "principled", ".xml"},
    {"blender", "blender-principled", ".json"},
    {"rough-conductor", "rough-conductor", ".xml"},
    {"rough-plastic", "rough-plastic", ".xml"},
    {"pbrt-conductor", "pbrt-conductor", ".pbrt"},
};
enum { N_TARGETS = sizeof targets / sizeof *targets };

static bool is_shading_model(const char *model) {
    size_t i = NQM_FIT_FIRST_SHADING;
    while (nqm_fit_model(i) && strcmp(nqm_fit_model(i), model) != 0)
        ++i;
    return nqm_fit_model(i) != NULL;
}

const char *const *target_names(void) {
    static const char *names[N_TARGETS + 1];
    for (size_t i = 0, n = 0; i < N_TARGETS; ++i)
        if (is_shading_model(targets[i].model))
            names[n++] = targets[i].word;
    return names;
}

const translate_target *find_target(const char *word) {
    const size_t chosen = (size_t)choose("to", target_names(), word);
    size_t i = 0;
    while (strcmp(targets[i].word, target_names()[chosen]) != 0)
        ++i;
    return &targets[i];
}

/* ---- meanings ----------------------------------------------------------------------------------------------------- */

enum { MEANING = 48 };

static void get_meaning(const char *name, char meaning[MEANING]) {
    static const struct {
        const char *meaning, *names;
    } same[] = {
        {"metallic", "basemetalness metalness"},
        {"roughness", "specularroughness"},
        {"ior", "specularior intior"},
        {"specular", "specularweight"},
        {"clearcoat", "coat coatweight"},
        {"clearcoatroughness", "coatroughness"},
        {"clearcoatior", "coatior"},
        {"clearcoatcolor", "coatcolor coattint"},
        {"sheen", "fuzzweight"},
        {"sheencolor", "fuzzcolor"},
        {"sheenroughness", "fuzzroughness"},
        {"basecolor", "diffusecolor diffusereflectance"},
        {"base", "baseweight"},
        {"diffuseroughness", "basediffuseroughness"},
        {"anisotropy", "specularroughnessanisotropy specularanisotropy anisotropic anisotropystrength"},
        {"rotation", "specularrotation anisotropyrotation anisotropicrotation"},
        {"clearcoatanisotropy", "coatroughnessanisotropy coatanisotropy"},
        {"clearcoatrotation", "coatrotation"},
        {"speculartint", "spectint"},
        {"thinfilm", "iridescence thinfilmweight"},
        {"thinfilmior", "iridescenceior"},
        {"thinfilmthickness", "iridescencethickness"},
    };
    size_t n = 0;
    for (; *name && n < MEANING - 1; ++name)
        if (*name != '_')
            meaning[n++] = (char)tolower((unsigned char)*name);
    meaning[n] = 0;
    for (size_t i = 0; i < sizeof same / sizeof *same; ++i)
        if (nqm_contains_word(same[i].names, meaning, false)) {
            snprintf(meaning, MEANING, "%s", same[i].meaning);
            return;
        }
}

static bool means_same(const char *a, const char *b) {
    char x[MEANING], y[MEANING];
    get_meaning(a, x);
    get_meaning(b, y);
    return strcmp(x, y) == 0;
}

static const nqm_spec_schema *schema_of(const char *model) {
    return &nqm_analytic_model_find(model, strlen(model))->schema;
}

size_t find_same_key(const nqm_spec_key *key, size_t n_keys, const nqm_spec_key *keys) {
    size_t k = 0;
    while (k < n_keys && !means_same(keys[k].name, key->name))
        ++k;
    return k;
}

/* The properties of a canonical spec of a shading model; false: it is none. */
static bool read_spec(const char *spec, nqm_shading *shading) {
    return spec && nqm_shading_parse(spec, shading, NULL) == NQM_OK && is_shading_model(shading->model);
}

/* ---- the start ---------------------------------------------------------------------------------------------------- */

void convert_values(const nqm_property *p, const nqm_spec_key *key, double v[3]) {
    const double mean = p->n == 1 ? p->v[0] : p->n == 2 ? sqrt(p->v[0] * p->v[1]) : (p->v[0] + p->v[1] + p->v[2]) / 3;
    for (size_t c = 0; c < 3; ++c)
        v[c] = fmin(fmax(p->n > 1 && p->n == key->n ? p->v[c] : mean, key->low), key->high);
}

static const nqm_property *find_meaning(const nqm_shading *shading, const char *meaning) {
    for (size_t i = 0; i < shading->n; ++i)
        if (means_same(shading->properties[i].key, meaning))
            return &shading->properties[i];
    return NULL;
}

static bool is_of_film(const char *key) {
    char meaning[MEANING];
    get_meaning(key, meaning);
    return strncmp(meaning, "thinfilm", 8) == 0;
}

/* A thin film: open-pbr has micrometres, others have nm; where there is no weight, a thickness of 0 means none. Fits
 * keep its values. */
static void copy_film(const nqm_shading *from, nqm_shading *to) {
    const nqm_property *thickness = find_meaning(from, "thinfilmthickness"), *weight = find_meaning(from, "thinfilm");
    const nqm_property *ior = find_meaning(from, "thinfilmior");
    const nqm_spec_schema *schema = schema_of(to->model);
    const double unit =
        (strcmp(from->model, "open-pbr") == 0 ? 1000 : 1) / (strcmp(to->model, "open-pbr") == 0 ? 1000.0 : 1);
    const double amount = weight ? weight->v[0] : 1;
    for (size_t k = 0; thickness && ior && amount * thickness->v[0] > 0 && k < schema->n_keys; ++k) {
        const char *key = schema->keys[k].name;
        const double scaled = unit == 1 ? thickness->v[0] : thickness->v[0] * unit;
        if (is_of_film(key))
            nqm_shading_set(to, key, 1,
                            means_same(key, "thinfilm")            ? &amount
                            : means_same(key, "thinfilmthickness") ? &scaled
                                                                   : ior->v);
    }
}

char *copy_keys(const char *spec, const char *model) {
    nqm_shading from, to = {.n = 0};
    const nqm_spec_schema *schema = schema_of(model);
    if (!read_spec(spec, &from))
        return NULL;
    const bool is_same = strcmp(from.model, model) == 0;
    snprintf(to.model, sizeof to.model, "%s", model);
    for (size_t k = 0; k < schema->n_keys; ++k)
        for (size_t i = 0; i < from.n; ++i) {
            const nqm_spec_key *key = &schema->keys[k];
            const nqm_property *p = &from.properties[i];
            double v[3];
            if (is_of_film(key->name) ||
                (is_same ? strcmp(p->key, key->name) != 0 : key->whole || !means_same(p->key, key->name)))
                continue;
            convert_values(p, key, v);
            nqm_shading_set(&to, key->name, key->n, v);
        }
    if (!is_same)
        nqm_fit_copy_anisotropy(&from, &to);
    copy_film(&from, &to);
    char *copy = to.n ? nqm_shading_spec(&to) : NULL;
    nqm_brdf *brdf = NULL;
    if (copy &&
        nqm_brdf_open(copy, &brdf, NULL) != NQM_OK) { /* keys that a model needs, such as `eta` of a conductor */
        nqm_free(copy);
        copy = NULL;
    }
    nqm_brdf_free(brdf);
    return copy;
}

/* ---- what is dropped ---------------------------------------------------------------------------------------------- */

/* Whether the target can say the same in other words: an amount in a colour, a gloss as a roughness. */
static bool has_counterpart(const nqm_spec_schema *schema, const char *key) {
    static const char *const forms[][2] = {{"base", "basecolor"},
                                           {"sheen", "sheencolor"},
                                           {"sheencolor", "sheen"},
                                           {"thinfilm", "thinfilmthickness"},
                                           {"clearcoatgloss", "clearcoatroughness"},
                                           {"clearcoatroughness", "clearcoatgloss"},
                                           {"roughness", "alpha"},
                                           {"alpha", "roughness"},
                                           {"eta", "ior"},
                                           {"ior", "eta"}};
    if (means_same(key, "anisotropy") || means_same(key, "rotation"))
        return nqm_fit_can_be_anisotropic(schema->model, means_same(key, "rotation"));
    for (size_t k = 0; k < schema->n_keys; ++k) {
        if (means_same(schema->keys[k].name, key))
            return true;
        for (size_t i = 0; i < sizeof forms / sizeof *forms; ++i)
            if (means_same(key, forms[i][0]) && means_same(schema->keys[k].name, forms[i][1]))
                return true;
    }
    return false;
}

/* Whether a property belongs to a layer whose weight is 0. */
static bool is_inactive(const nqm_shading *shading, const char *key) {
    static const char *const layers[] = {"clearcoat", "sheen", "thinfilm"};
    char meaning[MEANING];
    const nqm_property *weight = NULL;
    get_meaning(key, meaning);
    for (size_t l = 0; l < 3; ++l)
        if (strncmp(meaning, layers[l], strlen(layers[l])) == 0)
            weight = find_meaning(shading, layers[l]);
    return weight && weight->v[0] == 0;
}

static bool is_default(const nqm_spec_schema *schema, const nqm_property *p) {
    for (size_t k = 0; k < schema->n_keys; ++k) {
        const nqm_spec_key *key = &schema->keys[k];
        if (strcmp(key->name, p->key) == 0)
            return !key->required && p->v[0] == key->fallback && p->v[1] == key->fallback && p->v[2] == key->fallback;
    }
    return true;
}

void list_dropped(const char *spec, const char *model, char *text, size_t n_text) {
    nqm_shading from;
    size_t used = 0;
    *text = 0;
    if (!read_spec(spec, &from))
        return;
    const nqm_spec_schema *schema = schema_of(from.model), *target = schema_of(model);
    for (size_t i = 0; i < from.n && used < n_text; ++i) {
        const nqm_property *p = &from.properties[i];
        if (!is_default(schema, p) && !is_inactive(&from, p->key) && !has_counterpart(target, p->key))
            used += (size_t)snprintf(text + used, n_text - used, "%s%s", used ? ", " : "", p->key);
    }
}
