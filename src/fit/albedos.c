/* SPDX-License-Identifier: MIT
 *
 * The albedos of an analytic model f_r = kd D + ks L(shape) that are best for a given shape. f_r is linear in them: two
 * unknowns per channel are solved by non-negative least squares with weights that make the transformed residual linear.
 */
#include "fit/fit.h"

#include <math.h>

enum { N_REWEIGHTED = 6 };

/* Minimise |w (kd a + ks b - y)| over kd, ks >= 0 from the sums of the normal equations. */
static void solve_two(const double sums[5], double *kd, double *ks) {
    double aa = sums[0], ab = sums[1], bb = sums[2], ay = sums[3], by = sums[4];
    double det = aa * bb - ab * ab;
    double x = 0, y = 0;
    if (det > 1e-12 * aa * bb) {
        x = (bb * ay - ab * by) / det;
        y = (aa * by - ab * ay) / det;
    }
    if (det > 1e-12 * aa * bb && x >= 0 && y >= 0) {
        *kd = x;
        *ks = y;
        return;
    }
    /* One of them is 0: the one that reduces the residual less. */
    double gain_a = ay > 0 && aa > 0 ? ay * ay / aa : 0, gain_b = by > 0 && bb > 0 ? by * by / bb : 0;
    *kd = gain_a >= gain_b && gain_a > 0 ? ay / aa : 0;
    *ks = gain_b > gain_a ? by / bb : 0;
}

/* Slope of the secant of the loss's transform between y and f: times this weight, the residual f - y equals the residual
 * of the loss. */
static double secant(nqm_fit_loss loss, double weight, double f, double y, double goal) {
    double difference = f - y, tiny = 1e-6 * (y + 1e-3);
    if (fabs(difference) < tiny) {
        f = y + tiny;
        difference = tiny;
    }
    return (nqm_fit_transform(loss, weight, f) - goal) / difference;
}

/* base, lobe: (n, 3) f_r with kd = 1 and with ks = 1 alone. */
static void solve_channel(const nqm_fit_target *t, const double *base, const double *lobe, size_t c, double *kd,
                          double *ks) {
    for (int round = 0; round < N_REWEIGHTED; ++round) {
        double sums[5] = {0};
        for (size_t i = 0; i < t->n; ++i) {
            double a = base[3 * i + c], b = lobe[3 * i + c], y = t->rgb[3 * i + c];
            double f = round ? *kd * a + *ks * b : y; /* round 0: the tangent at the reference */
            double w = secant(t->loss, t->weight[i], f, y, t->goal[3 * i + c]);
            double ww = w * w;
            sums[0] += ww * a * a;
            sums[1] += ww * a * b;
            sums[2] += ww * b * b;
            sums[3] += ww * a * y;
            sums[4] += ww * b * y;
        }
        solve_two(sums, kd, ks);
    }
}

nqm_status nqm_fit_solve_albedos(const nqm_fit_space *space, const nqm_fit_target *t, nqm_values *values,
                                 nqm_error *err) {
    static const double one[3] = {1, 1, 1}, zero[3] = {0, 0, 0};
    const size_t kd = nqm_schema_key_named(space->model->schema, "kd", 2),
                 ks = nqm_schema_key_named(space->model->schema, "ks", 2);
    double *base, *lobe, found[2][3] = {{0}};
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&base, 3 * t->n, sizeof *base}, {&lobe, 3 * t->n, sizeof *lobe}), err);
    if (status != NQM_OK)
        return status;
    nqm_fit_set(space, values, kd, one);
    nqm_fit_set(space, values, ks, zero);
    nqm_fit_eval(space, values, t->n, t->wi, t->wo, base);
    nqm_fit_set(space, values, kd, zero);
    nqm_fit_set(space, values, ks, one);
    nqm_fit_eval(space, values, t->n, t->wi, t->wo, lobe);
    for (size_t c = 0; c < 3; ++c)
        solve_channel(t, base, lobe, c, &found[0][c], &found[1][c]);
    nqm_fit_set(space, values, kd, found[0]);
    nqm_fit_set(space, values, ks, found[1]);
    nqm_free(base);
    return NQM_OK;
}
