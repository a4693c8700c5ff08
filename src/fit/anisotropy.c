/* SPDX-License-Identifier: MIT
 *
 * The anisotropic lobe of the base of shading models, which name its widths and its azimuth differently.
 */
#include "brdf/brdf.h"
#include "fit/fit.h"

#include <math.h>
#include <string.h>

/* The keys of the lobe. A width with two values has no amount. */
typedef struct lobe_keys {
    const nqm_schema *schema;
    size_t width, amount, azimuth; /* n_keys: none */
} lobe_keys;

static lobe_keys keys_of(const nqm_schema *schema) {
    return (lobe_keys){schema, nqm_schema_key_of(schema, NQM_ROLE_WIDTH),
                       nqm_schema_key_of(schema, NQM_ROLE_ANISOTROPY), nqm_schema_key_of(schema, NQM_ROLE_AZIMUTH)};
}

static bool has_two_widths(const lobe_keys *keys) {
    return keys->width < keys->schema->n_keys && keys->schema->keys[keys->width].n == 2;
}

static bool has_amount(const lobe_keys *keys) {
    return keys->amount < keys->schema->n_keys;
}

static bool has_azimuth(const lobe_keys *keys) {
    return keys->azimuth < keys->schema->n_keys;
}

static nqm_unit unit_of(const lobe_keys *keys, size_t key) {
    return key < keys->schema->n_keys ? keys->schema->keys[key].unit : NQM_UNIT_PLAIN;
}

bool nqm_fit_can_be_anisotropic(const nqm_schema *schema, bool needs_azimuth) {
    const lobe_keys keys = keys_of(schema);
    return (has_two_widths(&keys) || has_amount(&keys)) && (!needs_azimuth || has_azimuth(&keys));
}

/* The mean of both widths alpha, the ratio of the smaller to the larger, and the azimuth of the larger. */
typedef struct lobe {
    double mean, ratio, azimuth;
} lobe;

/* OpenPBR keeps the mean of the squares: its mean width is this times roughness^2. */
static double mean_of_ratio(nqm_unit unit, double ratio) {
    return unit == NQM_UNIT_RATIO_MEAN ? sqrt(2 * ratio / (1 + ratio * ratio)) : 1;
}

static double scale_of(nqm_unit unit) {
    return unit == NQM_UNIT_RATIO_90 ? 0.9 : 1;
}

static lobe lobe_of_widths(double x, double y) {
    return (lobe){sqrt(x * y), fmin(x, y) / fmax(x, y), x < y ? NQM_PI / 2 : 0};
}

static lobe read_lobe(const nqm_values *from, const lobe_keys *keys) {
    const double *width = from->v[keys->width];
    const nqm_unit of_width = unit_of(keys, keys->width), of_amount = unit_of(keys, keys->amount);
    const double alpha = nqm_schema_convert(width[0], of_width, NQM_UNIT_ALPHA);
    if (!has_amount(keys))
        return lobe_of_widths(alpha, nqm_schema_convert(width[1], of_width, NQM_UNIT_ALPHA));
    const double amount = from->v[keys->amount][0];
    const double azimuth = has_azimuth(keys) ? nqm_schema_convert(from->v[keys->azimuth][0],
                                                                  unit_of(keys, keys->azimuth), NQM_UNIT_RADIANS)
                                             : 0;
    if (of_amount == NQM_UNIT_STRENGTH) {
        lobe l = lobe_of_widths(alpha + (1 - alpha) * amount * amount, alpha);
        l.azimuth = azimuth;
        return l;
    }
    const double ratio = fmax(0.02, 1 - scale_of(of_amount) * amount); /* the least of the node roughness_anisotropy */
    return (lobe){alpha * mean_of_ratio(of_amount, ratio), ratio, azimuth};
}

/* Set a key to a value that is moved into its range. */
static void set_number(nqm_values *to, size_t key, double v) {
    const nqm_schema_key *k = &to->schema->keys[key];
    v = nqm_round_digits(fmin(fmax(v, k->low), k->high), 5);
    nqm_values_set(to, k->name, 1, &v);
}

static void write_lobe(nqm_values *to, const lobe_keys *keys, lobe l) {
    const double root = sqrt(l.ratio), across = l.mean * root;
    const nqm_unit of_width = unit_of(keys, keys->width), of_amount = unit_of(keys, keys->amount);
    if (!has_amount(keys)) {
        const double wide = l.mean / root, x = cos(2 * l.azimuth) > 0 ? wide : across, y = wide * across / x;
        nqm_values_set(to, to->schema->keys[keys->width].name, 2,
                       (double[]){nqm_schema_convert(x, NQM_UNIT_ALPHA, of_width),
                                  nqm_schema_convert(y, NQM_UNIT_ALPHA, of_width)});
        for (size_t k = 0; k < to->schema->n_keys; ++k) /* such as the index of a conductor: the fit finds it */
            if (to->schema->keys[k].required && !(to->given >> k & 1))
                set_number(to, k, 1);
        return;
    }
    const bool is_strength = of_amount == NQM_UNIT_STRENGTH;
    const double alpha = is_strength ? across : l.mean / mean_of_ratio(of_amount, l.ratio);
    set_number(to, keys->width, nqm_schema_convert(alpha, NQM_UNIT_ALPHA, of_width));
    set_number(to, keys->amount,
               is_strength ? sqrt((l.mean / root - across) / (1 - across)) : (1 - l.ratio) / scale_of(of_amount));
    if (has_azimuth(keys))
        set_number(to, keys->azimuth, nqm_schema_convert(l.azimuth, NQM_UNIT_RADIANS, unit_of(keys, keys->azimuth)));
}

/* A lobe that a model cannot turn where it belongs is nearer to an isotropic one. */
static void place_lobe(nqm_values *to, const lobe_keys *keys, lobe l) {
    const bool fits = has_azimuth(keys) || fabs(cos(2 * l.azimuth)) > 0.5;
    if (l.ratio < 1 && fits && (has_azimuth(keys) || !has_amount(keys) || cos(2 * l.azimuth) > 0)) {
        write_lobe(to, keys, l);
        return;
    }
    if (has_amount(keys))
        set_number(to, keys->amount, 0);
    if (has_azimuth(keys))
        set_number(to, keys->azimuth, 0);
}

void nqm_fit_copy_anisotropy(const nqm_values *from, nqm_values *to) {
    const lobe_keys source = keys_of(from->schema), target = keys_of(to->schema);
    if (nqm_fit_can_be_anisotropic(to->schema, false))
        place_lobe(to, &target,
                   nqm_fit_can_be_anisotropic(from->schema, false) ? read_lobe(from, &source) : (lobe){.ratio = 1});
}

char *nqm_fit_measure_anisotropy(const nqm_brdf *ref, const nqm_schema *schema, bool is_turned) {
    const double half = sqrt(sqrt(2) - 1); /* slope at which GGX of width 1 has fallen to a half */
    if (!nqm_fit_can_be_anisotropic(schema, false) || !(nqm_brdf_anisotropy(ref) > 0))
        return NULL;
    const lobe_keys target = keys_of(schema);
    const nqm_lobe found = nqm_lobe_measure(ref);
    const double longer = hypot(found.axes[0], found.axes[2]);
    const double azimuth = is_turned ? 0 : floor(atan2(found.axes[2], found.axes[0]) * 1e4 + 0.5) / 1e4;
    nqm_values to = nqm_values_of(schema);
    place_lobe(&to, &target, (lobe){found.width / half, 1 / (longer * longer), azimuth});
    return to.given ? nqm_values_spec(&to) : NULL;
}
