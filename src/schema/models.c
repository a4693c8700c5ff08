/* SPDX-License-Identifier: MIT
 *
 * The schemas of the shading models, and what their roles and units say of keys.
 */
#include "schema/models.h"

#include "math/math.h"

#include <math.h>

#define DEFINE_SCHEMA(NAME, MODEL, KEYS, ALIAS, ABOUT)                                                                 \
    const nqm_schema nqm_##NAME##_schema = {.model = (MODEL),                                                          \
                                            .n_keys = sizeof((nqm_schema_key[]){KEYS(NQM_KEY_ROW)}) /                  \
                                                      sizeof(nqm_schema_key),                                          \
                                            .keys = {KEYS(NQM_KEY_ROW)},                                               \
                                            .alias = (ALIAS),                                                          \
                                            .about = (ABOUT)};
NQM_SHADING_SCHEMAS(DEFINE_SCHEMA)
NQM_SLOW_SCHEMAS(DEFINE_SCHEMA)
NQM_PLAIN_SCHEMAS(DEFINE_SCHEMA)

#define POINTER_TO(NAME, ...) &nqm_##NAME##_schema,
static const nqm_schema *const schemas[] = {NQM_SHADING_SCHEMAS(POINTER_TO) NQM_SLOW_SCHEMAS(POINTER_TO)
                                                NQM_PLAIN_SCHEMAS(POINTER_TO) NULL};
#define COUNT_ONE(...) +1
enum { N_SHADINGS = 0 NQM_SHADING_SCHEMAS(COUNT_ONE) }; /* the first ones */

const nqm_schema *nqm_schema_find(const char *name, size_t n) {
    const nqm_schema *const *s = schemas;
    while (*s && !(strncmp((*s)->model, name, n) == 0 && (*s)->model[n] == 0))
        ++s;
    return *s;
}

const nqm_schema *nqm_schema_shading(size_t i) {
    return i < N_SHADINGS ? schemas[i] : NULL;
}

nqm_status nqm_schema_find_shading(const char *name, const nqm_schema **schema_ret, nqm_error *err) {
    char names[300] = "";
    size_t used = 0;
    for (size_t i = 0; i < N_SHADINGS; ++i) {
        *schema_ret = schemas[i];
        if (strcmp(name, schemas[i]->model) == 0 || (schemas[i]->alias && strcmp(name, schemas[i]->alias) == 0))
            return NQM_OK;
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", schemas[i]->model);
    }
    *schema_ret = NULL;
    return nqm_fail(err, NQM_ERR_ARG, -1, "'%.40s' is no shading model; there are %s", name, names);
}

size_t nqm_schema_key_named(const nqm_schema *schema, const char *name, size_t n) {
    size_t k = 0;
    while (k < schema->n_keys && !(strncmp(schema->keys[k].name, name, n) == 0 && schema->keys[k].name[n] == 0))
        ++k;
    return k;
}

size_t nqm_schema_key_of(const nqm_schema *schema, nqm_role role) {
    size_t k = 0;
    while (k < schema->n_keys && schema->keys[k].role != role)
        ++k;
    return k;
}

bool nqm_schema_is_width(nqm_role role) {
    return role == NQM_ROLE_WIDTH || role == NQM_ROLE_DIFFUSE_ROUGHNESS || role == NQM_ROLE_COAT_WIDTH ||
           role == NQM_ROLE_SHEEN_WIDTH;
}

bool nqm_schema_is_azimuth(nqm_role role) {
    return role == NQM_ROLE_AZIMUTH || role == NQM_ROLE_COAT_AZIMUTH;
}

bool nqm_schema_is_anisotropic(nqm_role role) {
    return role == NQM_ROLE_ANISOTROPY || role == NQM_ROLE_COAT_ANISOTROPY || nqm_schema_is_azimuth(role);
}

bool nqm_schema_is_film(nqm_role role) {
    return role >= NQM_ROLE_FILM_WEIGHT;
}

size_t nqm_schema_layer_of(const nqm_schema *schema, size_t key) {
    const nqm_role role = schema->keys[key].role;
    size_t amount = schema->n_keys;
    if (role >= NQM_ROLE_COAT_WEIGHT && role <= NQM_ROLE_COAT_EFFECT)
        amount = nqm_schema_key_of(schema, NQM_ROLE_COAT_WEIGHT);
    else if (role >= NQM_ROLE_SHEEN_WEIGHT && role <= NQM_ROLE_SHEEN_TINT)
        amount = nqm_schema_key_of(schema, NQM_ROLE_SHEEN_WEIGHT);
    if (amount == schema->n_keys && role >= NQM_ROLE_SHEEN_WEIGHT && role <= NQM_ROLE_SHEEN_TINT)
        amount = nqm_schema_key_of(schema, NQM_ROLE_SHEEN_COLOR); /* glTF: black means none */
    return amount < schema->n_keys ? amount : key;
}

bool nqm_schema_is_layer(const nqm_schema *schema, size_t key) {
    const nqm_role role = schema->keys[key].role;
    return (role == NQM_ROLE_COAT_WEIGHT || role == NQM_ROLE_SHEEN_WEIGHT || role == NQM_ROLE_SHEEN_COLOR) &&
           nqm_schema_layer_of(schema, key) == key;
}

/* In alpha, radians or nanometres. */
static double to_common(double v, nqm_unit unit) {
    switch (unit) {
    case NQM_UNIT_PLAIN:
        return v * v;
    case NQM_UNIT_ALPHA_SQUARED:
        return sqrt(v);
    case NQM_UNIT_GLOSS:
        return (1 - v) * (1 - v);
    case NQM_UNIT_TURNS:
        return 2 * NQM_PI * v;
    case NQM_UNIT_TURNS_CLOCKWISE:
        return -2 * NQM_PI * v;
    case NQM_UNIT_MICROMETRES:
        return 1000 * v;
    default:
        return v;
    }
}

double nqm_schema_convert(double v, nqm_unit from, nqm_unit to) {
    const double common = to_common(v, from);
    if (from == to)
        return v;
    switch (to) {
    case NQM_UNIT_PLAIN:
        return sqrt(common);
    case NQM_UNIT_ALPHA_SQUARED:
        return common * common;
    case NQM_UNIT_GLOSS:
        return 1 - sqrt(common);
    case NQM_UNIT_TURNS:
        return common / (2 * NQM_PI);
    case NQM_UNIT_TURNS_CLOCKWISE:
        return common / (-2 * NQM_PI);
    case NQM_UNIT_MICROMETRES:
        return common / 1000;
    default:
        return common;
    }
}
