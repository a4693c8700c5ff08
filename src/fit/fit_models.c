/* SPDX-License-Identifier: MIT
 *
 * The models of nqm_fit(). An analytic model is one row of the table below: its nonlinear parameters with the range of the
 * search, and its starting points. All start from the same widths alpha of a lobe exp(-tan^2 theta_h / alpha^2), converted
 * to the model's own parameters by equal curvature at the mirror direction; other parameters start from a few values each.
 */
#include "brdf/core/spec.h"
#include "fit/shading.h"

#include <math.h>
#include <string.h>

static const double START_F0[] = {0.04, 0.5}, START_ETA[] = {1.3, 4}, START_FALL_OFF[] = {0.7, 1.6};
static const double START_GROWTH[] = {0.3,
                                      3}; /* log of the ratio of a Lafortune lobe at grazing and at normal incidence */

/* Models without f0 use only the first value. */
static void start_width_f0(double alpha, size_t which, double *shape) {
    shape[0] = alpha;
    shape[1] = START_F0[which];
}

/* cos^n is about exp(-n theta^2 / 2). */
static void start_exponent_f0(double alpha, size_t which, double *shape) {
    shape[0] = 2 / (alpha * alpha);
    shape[1] = START_F0[which];
}

/* The lobe is about the mirrored direction, whose angle is twice that of the half vector. */
static void start_lafortune(double alpha, size_t which, double *shape) {
    double n = 0.5 / (alpha * alpha);
    shape[0] = 1 - START_GROWTH[which] / (START_GROWTH[which] + n);
    shape[1] = n;
}

/* (1 + B theta^2 / 2)^-C */
static void start_abc(double alpha, size_t which, double *shape) {
    double fall_off = START_FALL_OFF[which / 2];
    shape[0] = 2 / (fall_off * alpha * alpha);
    shape[1] = fall_off;
    shape[2] = START_ETA[which % 2];
}

/* (1 + B (2 theta)^2)^-C */
static void start_smooth(double alpha, size_t which, double *shape) {
    start_abc(alpha, which, shape);
    shape[0] /= 8;
}

/* The range of f0 is narrower than [0, 1]: above 0.98 Schlick's rise towards grazing vanishes, and below 0.02 a GGX lobe
 * vanishes at normal incidence, so that ks and f0 could not be told apart. */
#define WIDTH                                                                                                          \
    { "alpha", 5e-4, 1, NQM_FIT_SCALE_LOG }
#define EXPONENT(high)                                                                                                 \
    { "n", 0.3, high, NQM_FIT_SCALE_LOG }
#define ETA                                                                                                            \
    { "eta", 1.03, 100, NQM_FIT_SCALE_LOG }

/* The paper's NQM_FIT_N_ENCODINGS encodings come first, in its order: sparse and hyper at the authors' levels, of which 0 is
 * the finest. Their settings were chosen so that the median Delta-E of training materials is that of the authors' labels
 * (doc/encodings.md). */
static const nqm_fit_entry entries[] = {
    {"ward", 1, {WIDTH}, 1, start_width_f0, NULL, 0, 0, NULL},
    {"ggx", 2, {WIDTH, {"f0", 0.02, 0.98, NQM_FIT_SCALE_LINEAR}}, 2, start_width_f0, NULL, 0, 0, NULL},
    {.name = "nbrdf", .encode = nqm_encode_nbrdf},
    {.name = "sparse-0", .encode = nqm_encode_sparse, .n_code = 3},
    {.name = "sparse-1", .encode = nqm_encode_sparse, .n_code = 3, .step = 40},
    {.name = "sparse-2", .encode = nqm_encode_sparse, .n_code = 3, .step = 50},
    {.name = "hyper-0", .encode = nqm_encode_hyper, .n_code = 400, .step = 0.175f},
    {.name = "hyper-1", .encode = nqm_encode_hyper, .n_code = 400, .step = 0.185f},
    {.name = "hyper-2", .encode = nqm_encode_hyper, .n_code = 400, .step = 0.215f},
    {.name = "sparse-low", .encode = nqm_encode_sparse, .n_code = 4},
    {.name = "sparse-mid", .encode = nqm_encode_sparse, .n_code = 8},
    {.name = "sparse-high", .encode = nqm_encode_sparse, .n_code = 32},
    {.name = "hyper-low", .encode = nqm_encode_hyper, .n_code = 12},
    {.name = "hyper-mid", .encode = nqm_encode_hyper, .n_code = 64},
    {.name = "hyper-high", .encode = nqm_encode_hyper, .n_code = 400},
    {"ward-duer", 1, {WIDTH}, 1, start_width_f0, NULL, 0, 0, NULL},
    {"blinn-phong", 1, {EXPONENT(1e7)}, 1, start_exponent_f0, NULL, 0, 0, NULL},
    {"lafortune",
     2,
     {{"cz", 0.02, 1 - 1e-8, NQM_FIT_SCALE_LOG_REST}, EXPONENT(3e6)},
     2,
     start_lafortune,
     NULL,
     0,
     0,
     NULL},
    {"cook-torrance", 2, {WIDTH, {"f0", 0.005, 0.98, NQM_FIT_SCALE_LINEAR}}, 2, start_width_f0, NULL, 0, 0, NULL},
    {"ashikhmin-shirley",
     2,
     {EXPONENT(1e7), {"f0", 0.005, 0.98, NQM_FIT_SCALE_LINEAR}},
     2,
     start_exponent_f0,
     NULL,
     0,
     0,
     NULL},
    {"abc",
     3,
     {{"B", 0.5, 1e9, NQM_FIT_SCALE_LOG}, {"C", 0.05, 20, NQM_FIT_SCALE_LOG}, ETA},
     4,
     start_abc,
     NULL,
     0,
     0,
     NULL},
    {"smooth",
     3,
     {{"B", 0.1, 1e9, NQM_FIT_SCALE_LOG}, {"C", 0.05, 20, NQM_FIT_SCALE_LOG}, ETA},
     4,
     start_smooth,
     NULL,
     0,
     0,
     NULL},
};
enum { N_ENTRIES = sizeof entries / sizeof *entries };

#define SHADING_ENTRY(NAME) {.shading = &(NAME)},
static const nqm_fit_entry shadings[] = {NQM_SHADING_MODELS(SHADING_ENTRY){.name = NULL}};
enum { N_SHADINGS = sizeof shadings / sizeof *shadings - 1 };

const char *nqm_fit_model(size_t i) {
    return i < N_ENTRIES ? entries[i].name : NULL;
}

const char *nqm_fit_shading(size_t i) {
    return i < N_SHADINGS ? shadings[i].shading->schema.model : NULL;
}

static const nqm_fit_entry *entry_at(size_t i) {
    return i < N_ENTRIES ? &entries[i] : &shadings[i - N_ENTRIES];
}

static const char *name_of(const nqm_fit_entry *entry) {
    return entry->shading ? entry->shading->schema.model : entry->name;
}

nqm_status nqm_fit_entry_find(const char *name, const nqm_fit_entry **entry_ret, nqm_error *err) {
    char names[480];
    size_t used = 0;
    for (size_t i = 0; i < N_ENTRIES + N_SHADINGS; ++i) {
        const nqm_fit_entry *entry = entry_at(i);
        if (strcmp(name_of(entry), name) == 0) {
            *entry_ret = entry;
            return NQM_OK;
        }
        if (used < sizeof names)
            used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", name_of(entry));
    }
    return nqm_fail(err, NQM_ERR_ARG, -1, "cannot fit a model '%.40s'; these can be fitted: %s", name, names);
}

static nqm_fit_shape *find_shape(nqm_fit_entry *model, const char *key) {
    for (size_t k = 0; k < model->n_shape; ++k)
        if (strcmp(model->shape[k].key, key) == 0)
            return &model->shape[k];
    return NULL;
}

int nqm_fit_model_has(const char *name, const char *key) {
    assert(name && key);
    const nqm_fit_entry *found;
    if (nqm_fit_entry_find(name, &found, NULL) != NQM_OK)
        return 0;
    if (found->shading)
        return nqm_shading_key(&found->shading->schema, key) < found->shading->schema.n_keys;
    nqm_fit_entry entry = *found;
    return find_shape(&entry, key) != NULL;
}

nqm_status nqm_fit_apply_bounds(const nqm_fit_options *options, nqm_fit_entry *model, nqm_error *err) {
    for (size_t b = 0; b < options->n_bounds; ++b) {
        const nqm_fit_bound *bound = &options->bounds[b];
        nqm_fit_shape *shape = find_shape(model, bound->key);
        if (!shape)
            return nqm_fail(err, NQM_ERR_ARG, -1, "the %s fit has no bounds for '%.40s'", model->name, bound->key);
        if (!(bound->low >= shape->low && bound->low < bound->high && bound->high <= shape->high))
            return nqm_fail(err, NQM_ERR_ARG, -1,
                            "the bounds of %s in a %s fit must be increasing and between %g and %g", shape->key,
                            model->name, shape->low, shape->high);
        shape->low = bound->low;
        shape->high = bound->high;
    }
    return NQM_OK;
}

/* ---- a parameter and its position in [0, 1] ----------------------------------------------------------------------- */

double nqm_fit_shape_position(const nqm_fit_shape *shape, double value) {
    double low = shape->low, high = shape->high;
    switch (shape->scale) {
    case NQM_FIT_SCALE_LOG:
        return log(value / low) / log(high / low);
    case NQM_FIT_SCALE_LOG_REST:
        return log((1 - value) / (1 - low)) / log((1 - high) / (1 - low));
    case NQM_FIT_SCALE_LINEAR:
        break;
    }
    return (value - low) / (high - low);
}

double nqm_fit_shape_value(const nqm_fit_shape *shape, double position) {
    double low = shape->low, high = shape->high;
    switch (shape->scale) {
    case NQM_FIT_SCALE_LOG:
        return low * pow(high / low, position);
    case NQM_FIT_SCALE_LOG_REST:
        return 1 - (1 - low) * pow((1 - high) / (1 - low), position);
    case NQM_FIT_SCALE_LINEAR:
        break;
    }
    return low + (high - low) * position;
}

double nqm_fit_shape_derivative(const nqm_fit_shape *shape, double value) {
    double low = shape->low, high = shape->high;
    switch (shape->scale) {
    case NQM_FIT_SCALE_LOG:
        return value * log(high / low);
    case NQM_FIT_SCALE_LOG_REST:
        return (value - 1) * log((1 - high) / (1 - low));
    case NQM_FIT_SCALE_LINEAR:
        break;
    }
    return high - low;
}
