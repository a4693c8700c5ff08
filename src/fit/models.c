/* SPDX-License-Identifier: MIT
 *
 * The models of nqm_fit(): analytic models, encodings, shading models. An analytic model has its nonlinear parameters
 * with the range of the search, and its starting points. All start from the same widths alpha of a lobe exp(-tan^2
 * theta_h / alpha^2), converted to the model's own parameters by equal curvature at the mirror direction; other
 * parameters start from a few values each.
 */
#include "brdf/core/spec.h"
#include "fit/fit.h"

#include <string.h>

static const double START_F0[] = {0.04, 0.5}, START_ETA[] = {1.3, 4}, START_FALL_OFF[] = {0.7, 1.6};
/* log of the ratio of a Lafortune lobe at grazing and at normal incidence */
static const double START_GROWTH[] = {0.3, 3};

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
/* clang-format off */
#define WIDTH          {"alpha", 5e-4, 1, NQM_FIT_SCALE_LOG}
#define EXPONENT(high) {"n", 0.3, high, NQM_FIT_SCALE_LOG}
#define F0(low)        {"f0", low, 0.98, NQM_FIT_SCALE_LINEAR}
#define ABC(low)       {"B", low, 1e9, NQM_FIT_SCALE_LOG}, {"C", 0.05, 20, NQM_FIT_SCALE_LOG}, {"eta", 1.03, 100, NQM_FIT_SCALE_LOG}
#define ANALYTIC(NAME, MODEL, N_SHAPE, N_START, START, ...) \
    {.name = (NAME), .model = &nqm_##MODEL##_model, .n_shape = (N_SHAPE), .n_start = (N_START), .start = (START), .shape = {__VA_ARGS__}}
#define ENCODING(NAME, ENCODE, N, STEP) {.name = (NAME), .encode = (ENCODE), .n_code = (N), .step = (STEP)}

/* The paper's NQM_FIT_N_ENCODINGS encodings come first, in its order: sparse and hyper at the authors' levels, of which 0 is
 * the finest. Their settings were chosen so that the median Delta-E of training materials is that of the authors' labels
 * (doc/encodings.md). */
static const nqm_fit_entry entries[] = {
    ANALYTIC("ward", ward, 1, 1, start_width_f0, WIDTH),
    ANALYTIC("ggx", ggx, 2, 2, start_width_f0, WIDTH, F0(0.02)),
    ENCODING("nbrdf", nqm_encode_nbrdf, 0, 0),
    ENCODING("sparse-0", nqm_encode_sparse, 3, 0),
    ENCODING("sparse-1", nqm_encode_sparse, 3, 40),
    ENCODING("sparse-2", nqm_encode_sparse, 3, 50),
    ENCODING("hyper-0", nqm_encode_hyper, 400, 0.175f),
    ENCODING("hyper-1", nqm_encode_hyper, 400, 0.185f),
    ENCODING("hyper-2", nqm_encode_hyper, 400, 0.215f),
    ENCODING("sparse-low", nqm_encode_sparse, 4, 0),
    ENCODING("sparse-mid", nqm_encode_sparse, 8, 0),
    ENCODING("sparse-high", nqm_encode_sparse, 32, 0),
    ENCODING("hyper-low", nqm_encode_hyper, 12, 0),
    ENCODING("hyper-mid", nqm_encode_hyper, 64, 0),
    ENCODING("hyper-high", nqm_encode_hyper, 400, 0),
    ANALYTIC("ward-duer", ward_duer, 1, 1, start_width_f0, WIDTH),
    ANALYTIC("blinn-phong", blinn_phong, 1, 1, start_exponent_f0, EXPONENT(1e7)),
    ANALYTIC("lafortune", lafortune, 2, 2, start_lafortune, {"cz", 0.02, 1 - 1e-8, NQM_FIT_SCALE_LOG_REST}, EXPONENT(3e6)),
    ANALYTIC("cook-torrance", cook_torrance, 2, 2, start_width_f0, WIDTH, F0(0.005)),
    ANALYTIC("ashikhmin-shirley", ashikhmin_shirley, 2, 2, start_exponent_f0, EXPONENT(1e7), F0(0.005)),
    ANALYTIC("abc", abc, 3, 4, start_abc, ABC(0.5)),
    ANALYTIC("smooth", smooth, 3, 4, start_smooth, ABC(0.1)),
};
/* clang-format on */
enum { N_ENTRIES = sizeof entries / sizeof *entries };

#define SHADING_ENTRY(NAME, ...) {.model = &nqm_##NAME##_model},
static const nqm_fit_entry shadings[] = {NQM_SHADING_SCHEMAS(SHADING_ENTRY){.name = NULL}};
enum { N_SHADINGS = sizeof shadings / sizeof *shadings - 1 };

_Static_assert((int)N_ENTRIES == (int)NQM_FIT_FIRST_SHADING, "shading models follow the others");

const char *nqm_fit_model(size_t i) {
    if (i < N_ENTRIES)
        return entries[i].name;
    return i < N_ENTRIES + N_SHADINGS ? shadings[i - N_ENTRIES].model->schema->model : NULL;
}

static const nqm_fit_entry *entry_at(size_t i) {
    return i < N_ENTRIES ? &entries[i] : &shadings[i - N_ENTRIES];
}

nqm_status nqm_fit_entry_find(const char *name, const nqm_fit_entry **entry_ret, nqm_error *err) {
    char names[480];
    size_t used = 0;
    for (size_t i = 0; i < N_ENTRIES + N_SHADINGS; ++i) {
        const nqm_fit_entry *entry = entry_at(i);
        const char *known = entry->name ? entry->name : entry->model->schema->model;
        if (strcmp(known, name) == 0) {
            *entry_ret = entry;
            return NQM_OK;
        }
        if (used < sizeof names)
            used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", known);
    }
    return nqm_fail(err, NQM_ERR_ARG, -1, "cannot fit a model '%.40s'; these can be fitted: %s", name, names);
}

const nqm_fit_shape *nqm_fit_find_shape(const nqm_fit_entry *entry, const char *key) {
    for (size_t k = 0; k < entry->n_shape; ++k)
        if (strcmp(entry->shape[k].key, key) == 0)
            return &entry->shape[k];
    return NULL;
}

int nqm_fit_model_has(const char *name, const char *key) {
    assert(name && key);
    const nqm_fit_entry *entry;
    if (nqm_fit_entry_find(name, &entry, NULL) != NQM_OK || entry->encode)
        return 0;
    if (entry->n_shape)
        return nqm_fit_find_shape(entry, key) != NULL;
    return nqm_schema_key_named(entry->model->schema, key, strlen(key)) < entry->model->schema->n_keys;
}
