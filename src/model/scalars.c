/* SPDX-License-Identifier: MIT
 *
 * The scalar features that models may take as inputs: their names and their whitening. metric/scalars.c computes their
 * values.
 */
#include "model/model.h"

#include <math.h>
#include <string.h>

static const char *const scalar_names[NQM_SCALAR_COUNT] = {
    "log_rmse",
    "log_mae",
    "log_rms_crwe",
    "log_ma_crwe",
    "log_rms_loge",
    "log_ma_loge",
    "log_rms_logwe",
    "log_ma_logwe",
    "log_log_diff",
    [NQM_SCALAR_RMS] = "rms",
    [NQM_SCALAR_MAX] = "max",
    [NQM_SCALAR_TAIL] = "tail",
    [NQM_SCALAR_BULK] = "bulk",
    [NQM_SCALAR_BIAS] = "bias",
    [NQM_SCALAR_SHAPE] = "shape",
    [NQM_SCALAR_ZONE_BIAS] = "bias_0_2",
    "bias_2_5",
    "bias_5_15",
    "bias_15_35",
    "bias_35_90",
    [NQM_SCALAR_ZONE_RMS] = "rms_0_2",
    "rms_2_5",
    "rms_5_15",
    "rms_15_35",
    "rms_35_90",
    [NQM_SCALAR_GRAZING_BIAS] = "bias_grazing",
    [NQM_SCALAR_GRAZING_RMS] = "rms_grazing",
    [NQM_SCALAR_WIDTH] = "width",
    [NQM_SCALAR_CHROMA] = "chroma",
    [NQM_SCALAR_CHROMA_RG] = "chroma_rg",
    [NQM_SCALAR_CHROMA_B] = "chroma_b",
    [NQM_SCALAR_ENERGY] = "energy",
    [NQM_SCALAR_ENERGY_CHROMA] = "energy_chroma",
    [NQM_SCALAR_PEAK] = "peak",
    [NQM_SCALAR_SMOOTH] = "smooth",
    [NQM_SCALAR_SMOOTH_CHROMA] = "smooth_chroma",
    [NQM_SCALAR_REF_LEVEL] = "ref_level",
    [NQM_SCALAR_REF_ENERGY] = "ref_energy",
    [NQM_SCALAR_REF_PEAK] = "ref_peak",
    [NQM_SCALAR_REF_SPREAD] = "ref_spread",
    [NQM_SCALAR_REF_COLOUR] = "ref_colour",
    [NQM_SCALAR_ESTIMATE] = "estimate",
    "estimate_i",
    "estimate_t",
    "estimate_p",
    "estimate_contrast",
    "estimate_structure",
};

const char *nqm_scalar_name(size_t i) {
    return i < NQM_SCALAR_COUNT ? scalar_names[i] : NULL;
}

char *nqm_scalar_names(void) {
    size_t n = 1;
    for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
        n += strlen(scalar_names[i]) + 1;
    char *text = nqm_alloc(n, 1);
    for (size_t i = 0, at = 0; text && i < NQM_SCALAR_COUNT; ++i)
        at += (size_t)snprintf(text + at, n - at, "%s%s", i ? "," : "", scalar_names[i]);
    return text;
}

/* The feature with this name of n bytes; NQM_SCALAR_COUNT: there is none. */
static size_t find_scalar(const char *name, size_t n) {
    size_t i = 0;
    while (i < NQM_SCALAR_COUNT && (strncmp(scalar_names[i], name, n) != 0 || scalar_names[i][n]))
        ++i;
    return i;
}

nqm_status nqm_scalars_select(const char *names, nqm_scalar_whitening *w, nqm_error *err) {
    bool is_taken[NQM_SCALAR_COUNT] = {false};
    w->n = 0;
    for (size_t i = 0; !names && i < NQM_SCALAR_COUNT; ++i)
        w->feature[w->n++] = (uint8_t)i;
    while (names) {
        const size_t n = strcspn(names, ","), i = find_scalar(names, n);
        if (i == NQM_SCALAR_COUNT || is_taken[i])
            return nqm_fail(err, NQM_ERR_MODEL, -1, "scalar feature '%.*s' (metadata 'scalars') %s",
                            (int)nqm_smaller(n, 64), names,
                            i < NQM_SCALAR_COUNT ? "occurs twice" : "is unknown to this version");
        is_taken[i] = true;
        w->feature[w->n++] = (uint8_t)i;
        names = names[n] ? names + n + 1 : NULL;
    }
    return NQM_OK;
}

static const double most = 5;

void nqm_scalars_whiten(const nqm_scalar_whitening *w, const double *scalars, float *x) {
    for (size_t k = 0; k < w->n; ++k) {
        const double z = (scalars[w->feature[k]] - (double)w->mean[k]) / (double)w->std[k];
        x[k] = isnan(z) ? 0 : (float)(w->scale * fmin(fmax(z, -most), most));
    }
}

void nqm_scalars_whiten_back(const nqm_scalar_whitening *w, const double *scalars, const float *dx, double *gradient) {
    memset(gradient, 0, NQM_SCALAR_COUNT * sizeof *gradient);
    for (size_t k = 0; k < w->n; ++k) {
        const size_t i = w->feature[k];
        const double z = (scalars[i] - (double)w->mean[k]) / (double)w->std[k];
        gradient[i] = fabs(z) < most ? (double)dx[k] * w->scale / (double)w->std[k] : 0;
    }
}
