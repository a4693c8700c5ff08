/* SPDX-License-Identifier: MIT
 *
 * The properties that two shading models share, by their roles.
 */
#include "translate/translate.h"

#include "fit/fit.h"

#include <math.h>
#include <string.h>

/* Keys without a role, and effects of coats, mean the same only where they have the same name. */
size_t nqm_translate_key(const nqm_schema *from, size_t key, const nqm_schema *to) {
    const nqm_schema_key *k = &from->keys[key];
    return k->role == NQM_ROLE_NONE || k->role == NQM_ROLE_COAT_EFFECT || from == to
               ? nqm_schema_key_named(to, k->name, strlen(k->name))
               : nqm_schema_key_of(to, k->role);
}

void nqm_translate_value(const nqm_schema_key *from, const double v[3], const nqm_schema_key *to, double out[3]) {
    const double mean = from->n == 1 ? v[0] : from->n == 2 ? sqrt(v[0] * v[1]) : (v[0] + v[1] + v[2]) / 3;
    const bool is_ior = to->role == NQM_ROLE_IOR || to->role == NQM_ROLE_COAT_IOR;
    for (size_t c = 0; c < 3; ++c) {
        double x = nqm_schema_convert(from->n > 1 && from->n == to->n ? v[c] : mean, from->unit, to->unit);
        /* An index and its inverse reflect the same at normal incidence; glTF's 0 reflects all. */
        if (is_ior && x < 1 && to->low >= 1)
            x = x > 0 ? 1 / x : to->high;
        out[c] = fmin(fmax(x, to->low), to->high);
    }
}

/* ---- copies ------------------------------------------------------------------------------------------------------- */

static double first_of(const nqm_values *values, nqm_role role, double otherwise) {
    const size_t k = nqm_schema_key_of(values->schema, role);
    return k < values->schema->n_keys ? values->v[k][0] : otherwise;
}

/* A thin film: where there is no weight, a thickness of 0 means none. Fits keep its values. */
static void copy_film(const nqm_values *from, nqm_values *to) {
    static const nqm_role roles[] = {NQM_ROLE_FILM_WEIGHT, NQM_ROLE_FILM_THICKNESS, NQM_ROLE_FILM_IOR};
    const double weight = first_of(from, NQM_ROLE_FILM_WEIGHT, 1);
    if (!(weight * first_of(from, NQM_ROLE_FILM_THICKNESS, 0) > 0))
        return;
    for (size_t i = 0; i < sizeof roles / sizeof *roles; ++i) {
        const size_t k = nqm_schema_key_of(from->schema, roles[i]), at = nqm_schema_key_of(to->schema, roles[i]);
        if (at == to->schema->n_keys)
            continue;
        const nqm_schema_key *key = &to->schema->keys[at];
        const double v = k == from->schema->n_keys
                             ? weight
                             : nqm_schema_convert(from->v[k][0], from->schema->keys[k].unit, key->unit);
        nqm_values_set(to, key->name, 1, &v);
    }
}

void nqm_translate_values(const nqm_values *from, nqm_values *to) {
    const bool is_same = from->schema == to->schema;
    for (size_t k = 0; k < from->schema->n_keys; ++k) {
        const nqm_schema_key *key = &from->schema->keys[k];
        const size_t at = nqm_translate_key(from->schema, k, to->schema);
        if (at == to->schema->n_keys || nqm_schema_is_film(key->role) || (to->given >> at & 1) ||
            (!is_same && (key->whole || key->role == NQM_ROLE_ANISOTROPY || key->role == NQM_ROLE_AZIMUTH)))
            continue;
        double v[3];
        nqm_translate_value(key, from->v[k], &to->schema->keys[at], v);
        nqm_values_set(to, to->schema->keys[at].name, to->schema->keys[at].n, v);
    }
    if (!is_same)
        nqm_fit_copy_anisotropy(from, to);
    copy_film(from, to);
    if (nqm_values_check(to, NULL) != NQM_OK) /* keys that a model needs, such as `eta` of a conductor */
        to->given = 0;
}

/* ---- what is dropped ---------------------------------------------------------------------------------------------- */

/* Whether the target can say the same in other words: an amount in a colour, a film by its thickness. */
static bool has_counterpart(const nqm_schema *from, size_t key, const nqm_schema *to) {
    static const nqm_role forms[][2] = {{NQM_ROLE_BASE_WEIGHT, NQM_ROLE_BASE_COLOR},
                                        {NQM_ROLE_SHEEN_WEIGHT, NQM_ROLE_SHEEN_COLOR},
                                        {NQM_ROLE_SHEEN_COLOR, NQM_ROLE_SHEEN_WEIGHT},
                                        {NQM_ROLE_FILM_WEIGHT, NQM_ROLE_FILM_THICKNESS}};
    const nqm_role role = from->keys[key].role;
    if (role == NQM_ROLE_ANISOTROPY || role == NQM_ROLE_AZIMUTH)
        return nqm_fit_can_be_anisotropic(to, role == NQM_ROLE_AZIMUTH);
    bool has = nqm_translate_key(from, key, to) < to->n_keys;
    for (size_t i = 0; i < sizeof forms / sizeof *forms; ++i)
        has = has || (role == forms[i][0] && nqm_schema_key_of(to, forms[i][1]) < to->n_keys);
    return has;
}

/* Whether a key belongs to a layer or film that is off. */
static bool is_inactive(const nqm_values *values, size_t key) {
    size_t amount = nqm_schema_layer_of(values->schema, key);
    if (nqm_schema_is_film(values->schema->keys[key].role)) {
        amount = nqm_schema_key_of(values->schema, NQM_ROLE_FILM_WEIGHT);
        if (amount == values->schema->n_keys)
            amount = nqm_schema_key_of(values->schema, NQM_ROLE_FILM_THICKNESS);
    } else if (!nqm_schema_is_layer(values->schema, amount)) {
        return false;
    }
    const double *v = values->v[amount];
    return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

void nqm_translate_drop(const char *key, char *text, size_t n_text) {
    const size_t used = strlen(text), n = strlen(key);
    for (const char *at = strstr(text, key); at; at = strstr(at + 1, key))
        if ((at == text || at[-1] == ' ') && (at[n] == ',' || at[n] == 0))
            return;
    snprintf(text + used, n_text - used, "%s%s", used ? ", " : "", key);
}

void nqm_translate_list_dropped(const nqm_values *from, const nqm_schema *to, char *text, size_t n_text) {
    for (size_t k = 0; k < from->schema->n_keys; ++k) {
        const nqm_schema_key *key = &from->schema->keys[k];
        const double *v = from->v[k];
        const bool is_default =
            !key->required && v[0] == key->fallback && v[1] == key->fallback && v[2] == key->fallback;
        if (!is_default && !is_inactive(from, k) && !has_counterpart(from->schema, k, to))
            nqm_translate_drop(key->name, text, n_text);
    }
}
