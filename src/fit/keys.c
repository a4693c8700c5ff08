/* SPDX-License-Identifier: MIT
 *
 * What the roles of the keys of shading models mean to a search: bounds, scale, and which keys it leaves alone.
 */
#include "fit/fit.h"

#include <math.h>

static bool is_index_of_refraction(nqm_role role) {
    return role == NQM_ROLE_IOR || role == NQM_ROLE_COAT_IOR || role == NQM_ROLE_FILM_IOR;
}

/* Films make f_r oscillate with their thickness: no fit finds it. */
bool nqm_fit_is_kept(const nqm_schema_key *key) {
    return key->whole || nqm_schema_is_anisotropic(key->role) || nqm_schema_is_film(key->role) ||
           key->role == NQM_ROLE_SPECULAR_LEVEL;
}

double nqm_fit_default(const nqm_schema_key *key) {
    const double value = !key->required                      ? key->fallback
                         : is_index_of_refraction(key->role) ? 1.5
                         : nqm_schema_is_width(key->role)    ? 0.3
                                                             : 0.5;
    return fmin(fmax(value, key->low), key->high);
}

/* Coordinates are scaled so that a step of 1 changes f_r by about the factor e; that of a roughness is its square, alpha. */
nqm_fit_parameter nqm_fit_describe(const nqm_schema *schema, size_t k) {
    const nqm_schema_key *key = &schema->keys[k];
    nqm_fit_parameter p = {.key = k,
                           .layer = nqm_schema_layer_of(schema, k),
                           .low = key->low,
                           .high = key->high,
                           .units = 1,
                           .is_log = true};
    double offset = 0.05; /* of the logarithm, from the lower end */
    if (is_index_of_refraction(key->role)) {
        p.low = fmax(key->low, 1);
        p.high = fmin(key->high, 5);
        p.units = 4;
        offset = p.low;
    } else if (key->unit == NQM_UNIT_GLOSS) {
        p.units = 4;
        p.is_log = false;
    } else if (key->unit == NQM_UNIT_ALPHA) {
        offset = 4e-4;
    } else if (nqm_schema_is_width(key->role)) {
        p.units = 2;
        offset = 0.02;
    } else if (key->role == NQM_ROLE_METAL) {
        p.units = 2;
        p.is_log = false;
    }
    p.zero = p.low - offset;
    /* Weights and colours that renderers and their editors take, although the formats allow more. */
    if (!is_index_of_refraction(key->role) && key->fallback <= 1)
        p.high = fmin(p.high, 1);
    return p;
}
