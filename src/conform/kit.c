/* SPDX-License-Identifier: MIT
 *
 * The parameter sets of a kit, made from the schema of the model: sweeps of each key with its layer switched on, metals, and random
 * combinations of ends, defaults and values in between. Lobes are not narrower than shaders evaluate well in float32.
 */
#include "conform/conform.h"

#include "fit/fit.h"
#include "math/math.h"

const double nqm_conform_azimuths_deg[NQM_CONFORM_AZIMUTHS] = {0, 90, 40};

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
static nqm_status choose_keys(const nqm_schema *schema, const char *list, uint64_t *keys, nqm_error *err) {
    char names[512] = "";
    *keys = list ? 0 : UINT64_MAX;
    for (size_t k = 0, used = 0; k < schema->n_keys; ++k) {
        *keys |= (uint64_t)schema->keys[k].required << k;
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", k ? ", " : "", schema->keys[k].name);
    }
    for (const char *word = list; word && *word;) {
        const size_t n = strcspn(word, ","), k = nqm_schema_key_named(schema, word, n);
        if (k == schema->n_keys)
            return nqm_fail(err, NQM_ERR_ARG, -1, "keys: %s has no '%.*s'; it has %s", schema->model,
                            (int)nqm_smaller(n, 60), word, names);
        *keys |= (uint64_t)1 << k;
        word += n + (word[n] == ',');
    }
    return NQM_OK;
}

/* Whether a key describes a layer that is off. Shaders evaluate such layers, too: their widths are not 0, where that
 * divides by 0. */
static bool is_idle(const nqm_schema *schema, const nqm_values *values, size_t k) {
    const size_t layer = nqm_schema_layer_of(schema, k);
    const double *amount = values->v[layer];
    return layer != k && amount[0] == 0 && amount[1] == 0 && amount[2] == 0;
}

/* Add a set, in which idle keys have their values of the base, and keys that the shader lacks their defaults. */
static void add_set(nqm_conform_kit *kit, const nqm_values *base, const nqm_values *values) {
    const nqm_schema *schema = kit->schema;
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
    if (kit->n_sets < NQM_CONFORM_MAX_SETS)
        kit->sets[kit->n_sets++].values = kept;
}

/* Sweep a key: of a dielectric, and once of a metal. An azimuth shows on anisotropic lobes only. */
static void add_sweep(nqm_conform_kit *kit, const nqm_values *base, size_t k) {
    const nqm_schema *schema = kit->schema;
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
        for (size_t j = 0; j < schema->n_keys && nqm_schema_is_azimuth(schema->keys[k].role); ++j)
            if (nqm_schema_is_anisotropic(schema->keys[j].role) && !nqm_schema_is_azimuth(schema->keys[j].role))
                set_key(schema, &values, j, 0.8);
        set_key(schema, &values, k, at[i]);
        add_set(kit, base, &values);
    }
}

static void add_random(nqm_conform_kit *kit, const nqm_values *base, nqm_rng *rng) {
    const nqm_schema *schema = kit->schema;
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

/* Give anisotropic sets one azimuth after the other, mark what differs from the defaults, and write the specs; false: out of memory. */
static bool finish_sets(nqm_conform_kit *kit) {
    size_t n_anisotropic = 0;
    double *column = kit->columns;
    for (nqm_kit_set *set = kit->sets; set < kit->sets + kit->n_sets; ++set) {
        for (size_t k = 0; k < kit->schema->n_keys; ++k) {
            const nqm_schema_key *key = &kit->schema->keys[k];
            const bool counts = !is_idle(kit->schema, &set->values, k);
            for (size_t c = 0; c < key->n; ++c) {
                *column++ = set->values.v[k][c];
                if (counts && (key->required || set->values.v[k][c] != key->fallback))
                    set->values.given |= (uint64_t)1 << k;
            }
        }
        if (!nqm_values_are_isotropic(&set->values))
            set->azimuth = n_anisotropic++ % NQM_CONFORM_AZIMUTHS;
        char *spec = nqm_values_spec(&set->values);
        set->spec = spec && set->azimuth
                        ? nqm_strdupf("rotate:deg=%g;of=%s", -nqm_conform_azimuths_deg[set->azimuth], spec)
                        : spec;
        if (set->spec != spec)
            nqm_free(spec);
        if (!set->spec)
            return false;
    }
    return true;
}

static void rotate_directions(nqm_conform_kit *kit, const nqm_directions *directions) {
    for (size_t i = 0; i < NQM_CONFORM_AZIMUTHS; ++i) {
        const double angle = nqm_conform_azimuths_deg[i] * NQM_PI / 180,
                     turn[2] = {i ? sin(angle) : 0, i ? cos(angle) : 1};
        for (size_t side = 0; side < 2; ++side) {
            const double *from = side ? nqm_directions_get_info(directions).wo : nqm_directions_get_info(directions).wi;
            double *to = nqm_conform_directions(kit, i, side), *end = to + 3 * kit->n_directions;
            for (; to < end; from += 3, to += 3)
                nqm_turn3(turn, from, to);
        }
    }
}

static void fill_sets(nqm_conform_kit *kit, bool has_all_keys) {
    enum { N_RANDOM = 24, N_LEAST = 64 };
    const nqm_values base = base_of(kit->schema);
    add_set(kit, &base, &base);
    for (size_t k = 0; k < kit->schema->n_keys; ++k)
        add_sweep(kit, &base, k);
    nqm_rng rng = nqm_rng_make(1, 0);
    const size_t n = nqm_smaller(nqm_larger(kit->n_sets + N_RANDOM, has_all_keys ? N_LEAST : 0), NQM_CONFORM_MAX_SETS);
    for (size_t i = 0; kit->n_sets < n && i < 100 * n; ++i) /* few keys may not have as many sets */
        add_random(kit, &base, &rng);
}

/* ---- the kit ----------------------------------------------------------------------------------------------------- */

static void name_columns(nqm_conform_kit *kit) {
    size_t used = 0;
    for (const nqm_schema_key *key = kit->schema->keys; key < kit->schema->keys + kit->schema->n_keys; ++key)
        for (size_t c = 0; c < key->n; ++c, ++kit->n_columns)
            used += (size_t)snprintf(kit->names + used, sizeof kit->names - used, key->n > 1 ? "%s%s_%c" : "%s%s",
                                     used ? "," : "", key->name, (key->n == 3 ? "rgb" : "xy")[c]);
}

nqm_status nqm_conform_kit_create(const char *model, const char *keys, const nqm_model *metric,
                                  nqm_conform_kit **kit_ret, nqm_error *err) {
    NQM_MAKE(err, kit_ret, model, metric);
    const nqm_schema *schema;
    uint64_t chosen;
    nqm_status status = nqm_schema_find_shading(model, &schema, err);
    if (status == NQM_OK)
        status = choose_keys(schema, keys, &chosen, err);
    if (status != NQM_OK)
        return status;
    nqm_conform_kit *kit = nqm_alloc(1, sizeof *kit);
    if (!kit)
        return nqm_fail_nomem(err, sizeof *kit);
    const nqm_directions *directions = nqm_model_get_info(metric).directions;
    kit->schema = schema;
    kit->keys = chosen;
    kit->metric = metric;
    kit->n_directions = nqm_directions_get_info(directions).n;
    name_columns(kit);
    fill_sets(kit, keys == NULL);
    status = nqm_alloc_arrays(
        NQM_ARRAYS({&kit->directions, 6 * NQM_CONFORM_AZIMUTHS * kit->n_directions, sizeof *kit->directions},
                   {&kit->columns, kit->n_sets * kit->n_columns, sizeof *kit->columns}),
        err);
    if (status == NQM_OK) {
        rotate_directions(kit, directions);
        if (!finish_sets(kit))
            status = nqm_fail_nomem(err, sizeof *kit->sets);
    }
    if (status != NQM_OK)
        nqm_conform_kit_free(kit);
    else
        *kit_ret = kit;
    return status;
}

void nqm_conform_kit_free(nqm_conform_kit *kit) {
    for (size_t s = 0; kit && s < kit->n_sets; ++s)
        nqm_free(kit->sets[s].spec);
    if (kit)
        nqm_free(kit->directions);
    nqm_free(kit);
}

nqm_conform_info nqm_conform_kit_get_info(const nqm_conform_kit *kit, size_t set) {
    assert(kit);
    nqm_conform_info info = {.model = kit->schema->model,
                             .n_sets = kit->n_sets,
                             .n_directions = kit->n_directions,
                             .n_columns = kit->n_columns,
                             .columns = kit->names};
    if (set < kit->n_sets) {
        info.spec = kit->sets[set].spec;
        info.values = kit->columns + set * kit->n_columns;
        info.light = nqm_conform_directions(kit, kit->sets[set].azimuth, 0);
        info.viewer = nqm_conform_directions(kit, kit->sets[set].azimuth, 1);
    }
    return info;
}
