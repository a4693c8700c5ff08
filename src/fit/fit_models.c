/* SPDX-License-Identifier: MIT
 *
 * The analytic models that can be fitted: their nonlinear parameters with the range of the search, and where it starts.
 * Every model starts from the same widths alpha of a lobe exp(-tan^2 theta_h / alpha^2); a model's own parameters follow
 * from the curvature of its lobe at the mirror direction. What has no width starts from a few values each.
 */
#include "fit/fit.h"

#include <math.h>
#include <string.h>

static const double START_F0[] = {0.04, 0.5}, START_ETA[] = {1.3, 4}, START_FALL_OFF[] = {0.7, 1.6};
static const double START_GROWTH[] = {0.3, 3}; /* logarithm of a Lafortune lobe's growth from normal to grazing */

static void start_width(double alpha, size_t which, double *shape) {
    (void)which;
    shape[0] = alpha;
}

static void start_width_f0(double alpha, size_t which, double *shape) {
    shape[0] = alpha;
    shape[1] = START_F0[which];
}

/* cos^n is about exp(-n theta^2 / 2). */
static void start_exponent_f0(double alpha, size_t which, double *shape) {
    shape[0] = 2 / (alpha * alpha);
    shape[1] = START_F0[which];
}

static void start_exponent(double alpha, size_t which, double *shape) {
    start_exponent_f0(alpha, which, shape);
}

/* About the mirrored direction, which turns twice as fast as the half vector. */
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

/* Above 0.98 Schlick's rise toward grazing vanishes and below 0.02 a GGX lobe does at normal incidence: there ks and f0
 * could trade places. */
#define WIDTH                                                                                                          \
    { "alpha", 5e-4, 1, NQM_FIT_SCALE_LOG }
#define EXPONENT(high)                                                                                                 \
    { "n", 0.3, high, NQM_FIT_SCALE_LOG }
#define ETA                                                                                                            \
    { "eta", 1.03, 100, NQM_FIT_SCALE_LOG }

static const nqm_fit_model models[] = {
    {"ward", 1, {WIDTH}, 1, start_width},
    {"ggx", 2, {WIDTH, {"f0", 0.02, 0.98, NQM_FIT_SCALE_LINEAR}}, 2, start_width_f0},
    {"ward-duer", 1, {WIDTH}, 1, start_width},
    {"blinn-phong", 1, {EXPONENT(1e7)}, 1, start_exponent},
    {"lafortune", 2, {{"cz", 0.02, 1 - 1e-8, NQM_FIT_SCALE_LOG_REST}, EXPONENT(3e6)}, 2, start_lafortune},
    {"cook-torrance", 2, {WIDTH, {"f0", 0.005, 0.98, NQM_FIT_SCALE_LINEAR}}, 2, start_width_f0},
    {"ashikhmin-shirley", 2, {EXPONENT(1e7), {"f0", 0.005, 0.98, NQM_FIT_SCALE_LINEAR}}, 2, start_exponent_f0},
    {"abc", 3, {{"B", 0.5, 1e9, NQM_FIT_SCALE_LOG}, {"C", 0.05, 20, NQM_FIT_SCALE_LOG}, ETA}, 4, start_abc},
    {"smooth", 3, {{"B", 0.1, 1e9, NQM_FIT_SCALE_LOG}, {"C", 0.05, 20, NQM_FIT_SCALE_LOG}, ETA}, 4, start_smooth},
};

const nqm_fit_model *nqm_fit_model_find(const char *name) {
    for (size_t i = 0; i < sizeof models / sizeof *models; ++i)
        if (strcmp(models[i].name, name) == 0)
            return &models[i];
    return NULL;
}

int nqm_fit_model_has(const char *name, const char *key) {
    const nqm_fit_model *model = nqm_fit_model_find(name);
    for (size_t k = 0; model && k < model->n_shape; ++k)
        if (strcmp(model->shape[k].key, key) == 0)
            return 1;
    return 0;
}

nqm_status nqm_fit_apply_bounds(const nqm_fit_options *options, nqm_fit_model *model, nqm_error *err) {
    for (size_t b = 0; b < options->n_bounds; ++b) {
        const nqm_fit_bound *bound = &options->bounds[b];
        size_t k = 0;
        while (k < model->n_shape && strcmp(model->shape[k].key, bound->key) != 0)
            ++k;
        if (k == model->n_shape)
            return nqm_fail(err, NQM_ERR_ARG, -1, "the %s fit has no bounds for '%.40s'", model->name, bound->key);
        nqm_fit_shape *shape = &model->shape[k];
        if (!(bound->low >= shape->low && bound->low < bound->high && bound->high <= shape->high))
            return nqm_fail(err, NQM_ERR_ARG, -1, "the bounds of %s in a %s fit must rise and lie within %g and %g",
                            shape->key, model->name, shape->low, shape->high);
        shape->low = bound->low;
        shape->high = bound->high;
    }
    return NQM_OK;
}

/* ---- between a parameter and its place in [0, 1] ------------------------------------------------------------------ */

double nqm_fit_shape_place(const nqm_fit_shape *shape, double value) {
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

double nqm_fit_shape_value(const nqm_fit_shape *shape, double place) {
    double low = shape->low, high = shape->high;
    switch (shape->scale) {
    case NQM_FIT_SCALE_LOG:
        return low * pow(high / low, place);
    case NQM_FIT_SCALE_LOG_REST:
        return 1 - (1 - low) * pow((1 - high) / (1 - low), place);
    case NQM_FIT_SCALE_LINEAR:
        break;
    }
    return low + (high - low) * place;
}
