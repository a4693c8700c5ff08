/* SPDX-License-Identifier: MIT
 *
 * A bound on the Delta-E of two BRDFs whose samples hardly differ, whatever a network says; and what it does to scores, their
 * gradients and their intervals.
 */
#include "metric/metric.h"
#include "percept/percept.h"

#include <math.h>

/* A pixel is a sum of samples with positive weights, so it changes by no larger factor than they do. Over all colours, channels that
 * change against one another, and luminances up to the display's, the slope of Delta-E by the logarithm is at most 162, at saturated
 * colours (tests/unit/test_metric_bound.c). Below `darkness` (an albedo of 1.6e-5) a ratio means nothing: PQ is nearly flat there. */
static const double delta_e_per_log = 165;
static const float darkness = 5e-6F; /* 1/sr, added to both */

static float ratio_of(float ref, float test) {
    const float a = ref + darkness, b = test + darkness;
    return a > b ? a / b : b / a;
}

/* The largest ratio of the members in any channel of any direction that is used, or the first that reaches `enough`;
 * *at receives its index. */
static float worst_ratio(size_t n_directions, const nqm_sample_pair *p, float enough, size_t *at) {
    float worst = 1;
    *at = 0;
    for (size_t k = 0; k < 3 * n_directions && worst < enough; ++k) {
        const float ratio = ratio_of(p->ref[k], p->test[k]);
        if (ratio > worst && (!p->used || p->used[k / 3])) {
            worst = ratio;
            *at = k;
        }
    }
    return worst;
}

double nqm_delta_e_bound(size_t n_directions, const nqm_sample_pair *p) {
    const float large = 1.65F; /* a factor in any channel of any direction beyond which the bound says nothing */
    size_t at;
    const float worst = worst_ratio(n_directions, p, large, &at);
    return worst < large ? delta_e_per_log * log((double)worst) : INFINITY;
}

double nqm_delta_e_bound_slope(size_t n_directions, const nqm_sample_pair *p, size_t *at_ret) {
    if (!(worst_ratio(n_directions, p, INFINITY, at_ret) > 1))
        return 0;
    const float ref = p->ref[*at_ret], test = p->test[*at_ret];
    return (test > ref ? delta_e_per_log : -delta_e_per_log) / (double)(test + darkness);
}

bool nqm_bound_score(const nqm_model *model, double bound, double *jod, double *delta_e) {
    if (!(*delta_e > bound)) /* true for NaN: models that predict no Delta-E */
        return false;
    *delta_e = bound;
    *jod = nqm_curve_jod(&model->curve, bound);
    return true;
}

void nqm_bounded_interval(const nqm_model *model, const nqm_prediction *p, double *low, double *high) {
    /* Labels see all directions, samples a few: a rounding that leaves the samples of a mirror equal changed its label by up to
     * 0.33 Delta-E (3,039 pairs of 100 references; 1.5 is JOD 9.98). */
    static const double unseen = 1.5;
    const double least = isfinite(p->bound) ? nqm_curve_jod(&nqm_curve_published, p->bound + unseen) : 0;
    nqm_model_interval(model, p->jod, p->novelty, p->spread, low, high);
    if (*low < least) /* false for NaN */
        *low = least;
}
