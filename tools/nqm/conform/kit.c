/* SPDX-License-Identifier: MIT
 *
 * The parameter sets of a kit, made from the schema of the model: sweeps of each key with its layer switched on, metals, and random
 * combinations of ends, defaults and values in between. Lobes are not narrower than shaders evaluate well in float32.
 */
#include "fit/fit.h"
#include "nqm/conform/conform.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

const double kit_turns_deg[KIT_TURNS] = {0, 90, 40};

/* ---- keys -------------------------------------------------------------------------------------------------------- */

/* The range of the sets: of widths without lobes that float32 does not resolve, of others what materials have. */
static void range_of(const nqm_schema *schema, size_t k, double *low, double *high) {
    const nqm_schema_key *key = &schema->keys[k];
    const nqm_fit_parameter p = nqm_fit_describe(schema, k);
    *low = fmax(p.low, 0);
    *high = p.high;
    if (nqm_schema_is_width(key->role)) {
        *low = key->unit == NQM_UNIT_GLOSS ? 0 : key->unit == NQM_UNIT_PLAIN ? 0.1 : 0.02;
        *high = key->unit == NQM_UNIT_GLOSS ? 0.8 : fmin(p.high, 1);
    } else if (nqm_schema_is_anisotropic(key->role)) {
        *high = 0.9;
    } else if (key->role == NQM_ROLE_METAL_ETA || key->role == NQM_ROLE_METAL_K) {
        *low = 0.1;
        *high = 5;
    } else if (key->low < key->high && p.high > 1) {
        *low = fmax(p.low, 1.1);
        *high = fmin(p.high, 2.5);
    }
}

/* Value t in [0, 1] of a key; the channels of colours differ. */
static void set_key(const nqm_schema *schema, nqm_values *values, size_t k, double t) {
    const nqm_schema_key *key = &schema->keys[k];
    double low, high;
    range_of(schema, k, &low, &high);
    for (size_t c = 0; c < 3; ++c) {
        const double spread = key->n == 3        ? fmod(t + 0.37 * (double)c, 1.0001)
                              : key->n == 2 && c ? fmin(1, 1.5 * t)
                                                 : t;
        values->v[k][c] = key->whole ? round(key->low + t * (key->high - key->low))
                                     : nqm_round_digits(low + spread * (high - low), 3);
    }
}

static void set_equal(nqm_values *values, size_t k, double v) {
    for (size_t c = 0; c < 3; ++c)
        values->v[k][c] = v;
}

/* A dielectric with a coloured base, without layers. */
static nqm_values base_of(const nqm_schema *schema) {
    nqm_values values = nqm_values_of(schema);
    for (size_t k = 0; k < schema->n_keys; ++k) {
        double low, high;
        range_of(schema, k, &low, &high);
        const double v =
            nqm_schema_is_width(schema->keys[k].role) ? low + (high - low) / 3 : nqm_fit_default(&schema->keys[k]);
        set_equal(&values, k, nqm_round_digits(v, 2));
        if (schema->keys[k].required && schema->keys[k].n == 3)
            set_key(schema, &values, k, 0.1);
    }
    const size_t metal = nqm_schema_key_of(schema, NQM_ROLE_METAL),
                 color = nqm_schema_key_of(schema, NQM_ROLE_BASE_COLOR);
    if (metal < schema->n_keys)
        set_equal(&values, metal, 0);
    if (color < schema->n_keys)
        set_key(schema, &values, color, 0.2);
    return values;
}

/* ---- sets -------------------------------------------------------------------------------------------------------- */

/* The keys of a list with commas; required ones are always among them. */
static uint64_t choose_keys(const nqm_schema *schema, const char *list) {
    uint64_t keys = list ? 0 : UINT64_MAX;
    for (size_t k = 0; k < schema->n_keys; ++k)
        keys |= (uint64_t)schema->keys[k].required << k;
    for (const char *word = list; word && *word;) {
        const size_t n = strcspn(word, ",");
        const size_t k = nqm_schema_key_named(schema, word, n);
        if (k == schema->n_keys)
            stop(EXIT_USAGE, "--keys: %s has no '%.*s'; `nqm conform %s --directions -` has all in its first line",
                 schema->model, (int)n, word, schema->model);
        keys |= (uint64_t)1 << k;
        word += n + (word[n] == ',');
    }
    return keys;
}

/* Whether a key describes a layer that is off. Shaders evaluate such layers, too: their widths are not 0, where that
 * divides by 0. */
static bool is_idle(const nqm_schema *schema, const nqm_values *values, size_t k) {
    const size_t layer = nqm_schema_layer_of(schema, k);
    const double *amount = values->v[layer];
    return layer != k && amount[0] == 0 && amount[1] == 0 && amount[2] == 0;
}

/* Add a set, in which idle keys have their values of the base, and keys that the shader lacks their defaults. */
static void add_set(conform_kit *kit, const nqm_values *base, const nqm_values *values) {
    const nqm_schema *schema = kit->model->schema;
    nqm_values kept = *values;
    for (size_t k = 0; k < schema->n_keys; ++k) {
        if (is_idle(schema, &kept, k))
            memcpy(kept.v[k], base->v[k], sizeof kept.v[k]);
        if (!(kit->keys >> k & 1))
            set_equal(&kept, k, schema->keys[k].fallback);
    }
    for (size_t s = 0; s < kit->n_sets; ++s)
        if (memcmp(kit->sets[s].values.v, kept.v, sizeof kept.v) == 0)
            return;
    if (kit->n_sets < KIT_MAX_SETS)
        kit->sets[kit->n_sets++].values = kept;
}

/* A rotation shows on anisotropic lobes only. */
static void set_amounts(const nqm_schema *schema, nqm_values *values) {
    for (size_t k = 0; k < schema->n_keys; ++k)
        if (schema->keys[k].role == NQM_ROLE_ANISOTROPY || schema->keys[k].role == NQM_ROLE_COAT_ANISOTROPY)
            set_key(schema, values, k, 0.8);
}

/* Sweep a key: of a dielectric, and once of a metal. */
static void add_sweep(conform_kit *kit, const nqm_values *base, size_t k) {
    const nqm_schema *schema = kit->model->schema;
    const size_t layer = nqm_schema_layer_of(schema, k), metal = nqm_schema_key_of(schema, NQM_ROLE_METAL);
    for (size_t i = 0; i < 4; ++i) {
        static const double at[] = {0, 0.5, 1, 0.3};
        nqm_values values = *base;
        if (i == 3 && metal == schema->n_keys)
            continue;
        if (i == 3)
            set_equal(&values, metal, 1);
        if (layer != k)
            set_equal(&values, layer, 1);
        if (schema->keys[k].low < 0)
            set_amounts(schema, &values);
        set_key(schema, &values, k, at[i]);
        add_set(kit, base, &values);
    }
}

static void add_random(conform_kit *kit, const nqm_values *base, nqm_rng *rng) {
    const nqm_schema *schema = kit->model->schema;
    nqm_values values = *base;
    for (size_t k = 0; k < schema->n_keys; ++k) {
        const double kind = nqm_rng_uniform(rng), t = nqm_rng_uniform(rng);
        const double at_base = nqm_schema_is_layer(schema, k)                    ? 0.5
                               : nqm_schema_is_anisotropic(schema->keys[k].role) ? 0.6
                                                                                 : 0.3;
        if (kind > at_base)
            set_key(schema, &values, k, kind > 0.9 ? 1 : kind > 0.8 ? 0 : t);
    }
    add_set(kit, base, &values);
}

/* Turn anisotropic sets in turn, mark what differs from the defaults, and write the specs. */
static void finish_sets(conform_kit *kit) {
    const nqm_schema *schema = kit->model->schema;
    size_t n_anisotropic = 0;
    for (size_t s = 0; s < kit->n_sets; ++s) {
        kit_set *set = &kit->sets[s];
        for (size_t k = 0; k < schema->n_keys; ++k) {
            const nqm_schema_key *key = &schema->keys[k];
            for (size_t c = 0; c < key->n && !is_idle(schema, &set->values, k); ++c)
                if (key->required || set->values.v[k][c] != key->fallback)
                    set->values.given |= (uint64_t)1 << k;
        }
        if (!nqm_values_are_isotropic(&set->values))
            set->turn = n_anisotropic++ % KIT_TURNS;
        snprintf(set->name, sizeof set->name, "set %zu", s + 1);
        char *spec = nqm_values_spec(&set->values);
        set->spec =
            must_have(spec && set->turn ? nqm_strdupf("rotate:deg=%g;of=%s", -kit_turns_deg[set->turn], spec) : spec);
        if (set->spec != spec)
            nqm_free(spec);
    }
}

static void turn_directions(conform_kit *kit, const nqm_directions *directions) {
    kit->directions = allocate(6 * KIT_TURNS * kit->n_directions, sizeof *kit->directions);
    for (size_t turn = 0; turn < KIT_TURNS; ++turn) {
        const double angle = kit_turns_deg[turn] * NQM_PI / 180, c = turn ? cos(angle) : 1, s = turn ? sin(angle) : 0;
        for (size_t side = 0; side < 2; ++side) {
            const double *from = side ? nqm_directions_get_info(directions).wo : nqm_directions_get_info(directions).wi;
            double *to = kit_directions(kit, turn, side);
            for (size_t i = 0; i < kit->n_directions; ++i, from += 3, to += 3) {
                to[0] = c * from[0] - s * from[1];
                to[1] = s * from[0] + c * from[1];
                to[2] = from[2];
            }
        }
    }
}

conform_kit *make_kit(const char *model, const char *keys) {
    enum { N_RANDOM = 24, N_LEAST = 64 };
    conform_kit *kit = allocate(1, sizeof *kit);
    kit->model = nqm_analytic_model_find(model, strlen(model));
    kit->keys = choose_keys(kit->model->schema, keys);
    kit->metric = open_model(NULL);
    const nqm_directions *directions = nqm_model_get_info(kit->metric).directions;
    kit->n_directions = nqm_directions_get_info(directions).n;
    turn_directions(kit, directions);
    const nqm_values base = base_of(kit->model->schema);
    add_set(kit, &base, &base);
    for (size_t k = 0; k < kit->model->schema->n_keys; ++k)
        add_sweep(kit, &base, k);
    nqm_rng rng = nqm_rng_make(1, 0);
    const size_t n = nqm_smaller(nqm_larger(kit->n_sets + N_RANDOM, keys ? 0 : N_LEAST), KIT_MAX_SETS);
    for (size_t i = 0; kit->n_sets < n && i < 100 * n; ++i) /* few keys may not have as many sets */
        add_random(kit, &base, &rng);
    finish_sets(kit);
    return kit;
}

void free_kit(conform_kit *kit) {
    for (size_t s = 0; s < kit->n_sets; ++s)
        nqm_free(kit->sets[s].spec);
    nqm_model_free(kit->metric);
    free_kit_copy(kit);
}

conform_kit *copy_kit(const conform_kit *kit, size_t stride) {
    conform_kit *copy = allocate(1, sizeof *copy);
    *copy = *kit;
    copy->n_directions = nqm_ceil_div(kit->n_directions, stride);
    copy->directions = allocate(6 * KIT_TURNS * copy->n_directions, sizeof *copy->directions);
    for (size_t turn = 0; turn < KIT_TURNS; ++turn)
        for (size_t side = 0; side < 2; ++side)
            for (size_t i = 0; i < copy->n_directions; ++i)
                memcpy(kit_directions(copy, turn, side) + 3 * i, kit_directions(kit, turn, side) + 3 * stride * i,
                       3 * sizeof *copy->directions);
    return copy;
}

void free_kit_copy(conform_kit *copy) {
    free(copy->directions);
    free(copy);
}
