/* SPDX-License-Identifier: MIT
 *
 * The reference at the directions of a fit: those of a list of measured ones, or drawn (and moved to the nearest nodes of a
 * goniometer's grid). Most direction pairs are uniform over the cap of the hemisphere; the others have half vectors dense around
 * the normal, because the lobe of a polished metal (0.2 degrees) would otherwise contain a millionth of all pairs.
 */
#include "brdf/formats/listed.h"
#include "fit/fit.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

/* ---- losses ------------------------------------------------------------------------------------------------------ */

/* The entries of NQM_VALUE_METRICS in the order of nqm_fit_loss: first the losses of the paths in corpora. */
#define LOSSES(X)                                                                                                      \
    X("log", "log(1 + f)", NQM_VALUE_LOG, false, 2)                                                                    \
    X("log-cos", "log(1 + c f)", NQM_VALUE_LOG, true, 2)                                                               \
    X("cube-root", "\xe2\x88\x9b f", NQM_VALUE_CUBE_ROOT, false, 2)                                                    \
    X("linear", "f", NQM_VALUE_LINEAR, false, 2)                                                                       \
    NQM_VALUE_METRICS(X)

const nqm_value_difference nqm_fit_losses[] = {LOSSES(NQM_VALUE_ROW)};
const char *const nqm_fit_loss_words[] = {LOSSES(NQM_VALUE_NAME) NULL};

_Static_assert(sizeof nqm_fit_losses / sizeof *nqm_fit_losses == NQM_FIT_N_LOSSES, "one row per loss");

double nqm_fit_transform(nqm_fit_loss loss, double weight, double f) {
    return nqm_value_on_curve(nqm_fit_losses[loss].curve, weight * f);
}

double nqm_fit_transform_slope(nqm_fit_loss loss, double weight, double f) {
    return weight * nqm_value_slope(nqm_fit_losses[loss].curve, weight * f);
}

double nqm_fit_loss_value(const nqm_fit_target *target, const double *rgb, double *gradient) {
    size_t n = 3 * target->n;
    bool squares = nqm_fit_losses[target->loss].power == 2;
    double sum = 0;
    for (size_t i = 0; i < n; ++i) {
        double weight = target->weight[i / 3];
        double r = nqm_fit_transform(target->loss, weight, rgb[i]) - target->goal[i];
        double length = sqrt(r * r + target->rounding * target->rounding);
        sum += squares ? r * r : length - target->rounding;
        if (gradient)
            gradient[i] = (squares      ? r
                           : length > 0 ? r / length
                                        : 0) *
                          nqm_fit_transform_slope(target->loss, weight, rgb[i]) / (double)n;
    }
    double value = squares ? sqrt(sum / (double)n) : sum / (double)n;
    for (size_t i = 0; gradient && squares && i < n; ++i)
        gradient[i] = value > 0 ? gradient[i] / value : 0;
    return value;
}

/* ---- the target -------------------------------------------------------------------------------------------------- */

enum { MIN_VALID = 100 };

static void draw_pairs(const nqm_fit_options *options, const nqm_fit_target *target) {
    nqm_rng rng = nqm_rng_make(options->seed, 0);
    size_t n_highlight = (size_t)(options->highlight_fraction * (double)options->n_directions + 0.5);
    for (size_t i = 0; i < options->n_directions; ++i) {
        double *wi = target->wi + 3 * i, *wo = target->wo + 3 * i;
        if (i < n_highlight) {
            double hd[3];
            nqm_encode_draw_dense(&rng, options->max_polar_rad, options->max_polar_rad, 2 * NQM_PI, hd);
            nqm_half_diff_to_pair(hd, wi, wo);
        } else {
            nqm_encode_draw_uniform(&rng, options->max_polar_rad, wi, wo);
        }
    }
}

/* Remove the pairs for which the reference has no value, and those of a list beyond the largest polar angle. */
static void drop_invalid(nqm_fit_target *target, double max_polar, const uint8_t *flag) {
    const double least = cos(max_polar + 1e-6);
    size_t kept = 0;
    for (size_t i = 0; i < target->n; ++i) {
        if (!nqm_has_value(flag[i]) || target->wi[3 * i + 2] < least || target->wo[3 * i + 2] < least)
            continue;
        memmove(target->wi + 3 * kept, target->wi + 3 * i, 3 * sizeof(double));
        memmove(target->wo + 3 * kept, target->wo + 3 * i, 3 * sizeof(double));
        memmove(target->rgb + 3 * kept, target->rgb + 3 * i, 3 * sizeof(double));
        ++kept;
    }
    target->n = kept;
}

/* The weights and the transformed reference of the target's loss. */
static void set_goal(nqm_fit_target *target) {
    for (size_t i = 0; i < target->n; ++i)
        target->weight[i] = nqm_fit_losses[target->loss].weighted ? target->wi[3 * i + 2] * target->wo[3 * i + 2] : 1;
    for (size_t i = 0; i < 3 * target->n; ++i)
        target->goal[i] = nqm_fit_transform(target->loss, target->weight[i / 3], target->rgb[i]);
}

static nqm_status alloc_target(nqm_fit_target *t, nqm_error *err) {
    const size_t size = sizeof(double);
    return nqm_alloc_arrays(NQM_ARRAYS({&t->wi, 3 * t->n, size}, {&t->wo, 3 * t->n, size}, {&t->weight, t->n, size},
                                       {&t->rgb, 3 * t->n, size}, {&t->goal, 3 * t->n, size}),
                            err);
}

nqm_status nqm_fit_target_make(const nqm_brdf *ref, const nqm_fit_options *options, nqm_fit_target *target,
                               nqm_error *err) {
    const size_t n_rows = nqm_scattered_rows(ref, NULL, NULL), n = n_rows ? n_rows : options->n_directions;
    *target = (nqm_fit_target){.loss = options->loss, .n = n};
    nqm_status status = alloc_target(target, err);
    uint8_t *flag = status == NQM_OK ? nqm_alloc(n, sizeof *flag) : NULL;
    if (!flag)
        return status == NQM_OK ? nqm_fail_nomem(err, n) : status;
    if (n_rows) {
        nqm_scattered_rows(ref, target->wi, target->wo);
    } else {
        draw_pairs(options, target);
        const bool has_azimuths = nqm_brdf_anisotropy(ref) > 0;
        for (size_t i = 0; i < n && has_azimuths; ++i)
            nqm_turn_pair(i, target->wi + 3 * i, target->wo + 3 * i);
        nqm_listed_snap(ref, n, target->wi, target->wo);
    }
    nqm_brdf_eval(ref, n, target->wi, target->wo, target->rgb, flag);
    drop_invalid(target, options->max_polar_rad, flag);
    nqm_free(flag);
    if (target->n < MIN_VALID)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: values at only %zu of %zu directions; a fit needs %d",
                        nqm_brdf_get_info(ref).name, target->n, n, MIN_VALID);
    set_goal(target);
    return NQM_OK;
}

nqm_status nqm_fit_target_under(const nqm_fit_target *from, nqm_fit_loss loss, nqm_fit_target *target, nqm_error *err) {
    *target = *from;
    target->loss = loss;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&target->weight, from->n, sizeof(double)}, {&target->goal, from->n, 3 * sizeof(double)}), err);
    if (status == NQM_OK)
        set_goal(target);
    return status;
}

nqm_status nqm_fit_target_thin(const nqm_fit_target *from, size_t n, nqm_fit_target *thin, nqm_error *err) {
    const size_t stride = nqm_larger(from->n / n, 1);
    *thin = *from;
    thin->n = (from->n + stride - 1) / stride;
    nqm_status status = alloc_target(thin, err);
    for (size_t i = 0; status == NQM_OK && i < thin->n; ++i) {
        memcpy(thin->wi + 3 * i, from->wi + 3 * i * stride, 3 * sizeof(double));
        memcpy(thin->wo + 3 * i, from->wo + 3 * i * stride, 3 * sizeof(double));
        memcpy(thin->rgb + 3 * i, from->rgb + 3 * i * stride, 3 * sizeof(double));
    }
    if (status == NQM_OK)
        set_goal(thin);
    return status;
}
