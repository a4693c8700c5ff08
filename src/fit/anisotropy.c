/* SPDX-License-Identifier: MIT
 *
 * The anisotropic lobe of the base of shading models: each names its widths and its azimuth differently.
 */
#include "fit/anisotropy.h"
#include "brdf/brdf.h"
#include "brdf/core/spec.h"

#include <math.h>
#include <string.h>

/* amount NULL: the key of the roughness has both widths. */
typedef struct anisotropy {
    const char *model, *roughness, *amount;
    double scale; /* the amount a has the ratio 1 - scale a of the widths; 0: glTF's strength */
    const char *rotation;
    double turn; /* azimuth of the rotation 1, radians */
} anisotropy;

static const anisotropy anisotropies[] = {
    {"open-pbr", "specular_roughness", "specular_roughness_anisotropy", 1, NULL, 0},
    {"standard-surface", "specular_roughness", "specular_anisotropy", 1, "specular_rotation", -2 * NQM_PI},
    {"gltf", "roughness", "anisotropy_strength", 0, "anisotropy_rotation", 1},
    {"disney", "roughness", "anisotropic", 1, NULL, 0},
    {"principled", "roughness", "anisotropic", 0.9, NULL, 0},
    {"blender-principled", "roughness", "anisotropic", 0.9, "anisotropic_rotation", 2 * NQM_PI},
    {"rough-conductor", "alpha", NULL, 0, NULL, 0},
    {"pbrt-conductor", "roughness", NULL, 0, NULL, 0},
};

/* NULL: the model is isotropic. */
static const anisotropy *find_anisotropy(const char *model) {
    for (size_t i = 0; i < sizeof anisotropies / sizeof *anisotropies; ++i)
        if (strcmp(anisotropies[i].model, model) == 0)
            return &anisotropies[i];
    return NULL;
}

bool nqm_fit_can_be_anisotropic(const char *model, bool turned) {
    const anisotropy *a = find_anisotropy(model);
    return a && (!turned || a->rotation);
}

/* The mean of both widths alpha, the ratio of the smaller to the larger, and the azimuth of the larger. */
typedef struct lobe {
    double mean, ratio, turn;
} lobe;

/* OpenPBR keeps the mean of the squares: its mean width is this times roughness^2. */
static double open_pbr_mean(const anisotropy *a, double ratio) {
    return strcmp(a->model, "open-pbr") == 0 ? sqrt(2 * ratio / (1 + ratio * ratio)) : 1;
}

static double value_of(const nqm_shading *shading, const char *key) {
    const nqm_property *p = key ? nqm_shading_find(shading, key) : NULL;
    return p ? p->v[0] : 0;
}

static lobe lobe_of_widths(double x, double y) {
    return (lobe){sqrt(x * y), fmin(x, y) / fmax(x, y), x < y ? NQM_PI / 2 : 0};
}

/* Of a canonical spec. */
static lobe read_lobe(const nqm_shading *s, const anisotropy *a) {
    const nqm_property *r = nqm_shading_find(s, a->roughness);
    const double alpha = r->v[0] * r->v[0], amount = value_of(s, a->amount), turn = a->turn * value_of(s, a->rotation);
    if (!a->amount && strcmp(a->roughness, "alpha") == 0)
        return lobe_of_widths(r->v[0], r->v[1]);
    if (!a->amount)
        return lobe_of_widths(sqrt(r->v[0]), sqrt(r->v[1]));
    if (a->scale == 0) {
        lobe l = lobe_of_widths(alpha + (1 - alpha) * amount * amount, alpha);
        l.turn = turn;
        return l;
    }
    const double ratio = fmax(0.02, 1 - a->scale * amount); /* the least of the node roughness_anisotropy */
    return (lobe){alpha * open_pbr_mean(a, ratio), ratio, turn};
}

static const nqm_spec_schema *schema_of(const nqm_shading *shading) {
    return &nqm_analytic_model_find(shading->model, strlen(shading->model))->schema;
}

/* Set a key to a value that is moved into its range. */
static void set_number(nqm_shading *shading, const char *key, double v) {
    const nqm_spec_schema *schema = schema_of(shading);
    size_t k = 0;
    while (strcmp(schema->keys[k].name, key) != 0)
        ++k;
    v = nqm_round_digits(fmin(fmax(v, schema->keys[k].low), schema->keys[k].high), 5);
    nqm_shading_set(shading, key, 1, &v);
}

/* Keys that the model needs, such as the index of a conductor: the fit finds their values. */
static void set_required(nqm_shading *shading) {
    const nqm_spec_schema *schema = schema_of(shading);
    for (size_t k = 0; k < schema->n_keys; ++k)
        if (schema->keys[k].required && !nqm_shading_find(shading, schema->keys[k].name))
            set_number(shading, schema->keys[k].name, 1);
}

static void write_lobe(nqm_shading *to, const anisotropy *a, lobe l) {
    const double root = sqrt(l.ratio), across = l.mean * root;
    if (!a->amount) {
        const double wide = l.mean / root, x = cos(2 * l.turn) > 0 ? wide : across, y = wide * across / x;
        const bool is_alpha = strcmp(a->roughness, "alpha") == 0;
        nqm_shading_set(to, a->roughness, 2, is_alpha ? (double[]){x, y} : (double[]){x * x, y * y});
        set_required(to);
        return;
    }
    const bool is_gltf = a->scale == 0;
    set_number(to, a->roughness, sqrt(is_gltf ? across : l.mean / open_pbr_mean(a, l.ratio)));
    set_number(to, a->amount, is_gltf ? sqrt((l.mean / root - across) / (1 - across)) : (1 - l.ratio) / a->scale);
    if (a->rotation)
        set_number(to, a->rotation, l.turn / a->turn);
}

/* A lobe that a model cannot turn where it belongs is nearer to an isotropic one. */
static void place_lobe(nqm_shading *to, const anisotropy *target, lobe l) {
    const bool fits = target->rotation || fabs(cos(2 * l.turn)) > 0.5;
    if (l.ratio < 1 && fits && (target->rotation || !target->amount || cos(2 * l.turn) > 0)) {
        write_lobe(to, target, l);
        return;
    }
    if (target->amount)
        set_number(to, target->amount, 0);
    if (target->rotation)
        set_number(to, target->rotation, 0);
}

void nqm_fit_copy_anisotropy(const nqm_shading *from, nqm_shading *to) {
    const anisotropy *source = find_anisotropy(from->model), *target = find_anisotropy(to->model);
    if (target)
        place_lobe(to, target, source ? read_lobe(from, source) : (lobe){.ratio = 1});
}

char *nqm_fit_measure_anisotropy(const nqm_brdf *ref, const char *model, bool is_turned) {
    const double half = sqrt(sqrt(2) - 1); /* slope at which GGX of width 1 has fallen to a half */
    const anisotropy *target = find_anisotropy(model);
    if (!target || !(nqm_brdf_anisotropy(ref) > 0))
        return NULL;
    const nqm_lobe found = nqm_lobe_measure(ref);
    const double longer = hypot(found.axes[0], found.axes[2]);
    const double turn = is_turned ? 0 : floor(atan2(found.axes[2], found.axes[0]) * 1e4 + 0.5) / 1e4;
    nqm_shading to = {.n = 0};
    snprintf(to.model, sizeof to.model, "%s", model);
    place_lobe(&to, target, (lobe){found.width / half, 1 / (longer * longer), turn});
    return to.n ? nqm_shading_spec(&to) : NULL;
}
