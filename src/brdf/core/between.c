/* SPDX-License-Identifier: MIT
 *
 * A BRDF between two others: the arithmetic or the geometric mean of their values, with the weight t of the second. It is
 * reciprocal if both are.
 */
#include "brdf/core/spec.h"

#include <math.h>

enum { T, LOG, N_KEYS };

typedef struct between {
    nqm_between_bases bases;
    double t;
    bool is_geometric;
} between;

static double mean(const between *self, double of, double with) {
    if (self->is_geometric) /* pow(0, 0) is 1, so that t = 0 and t = 1 give one of the two */
        return pow(of, 1 - self->t) * pow(with, self->t);
    return (1 - self->t) * of + self->t * with;
}

static void between_eval(const void *state, size_t n, const double *hd, const double *turn, double *rgb) {
    enum { BLOCK = 128 };
    const between *self = state;
    double with[3 * BLOCK];
    uint8_t flag[2][BLOCK];
    for (size_t first = 0; first < n; first += BLOCK) {
        size_t m = nqm_smaller(n - first, BLOCK);
        double *out = rgb + 3 * first;
        const double *turned = turn ? turn + 2 * first : NULL;
        nqm_brdf_eval_turned(self->bases.of, m, hd + 3 * first, turned, out, flag[0]);
        nqm_brdf_eval_turned(self->bases.with, m, hd + 3 * first, turned, with, flag[1]);
        for (size_t i = 0; i < 3 * m; ++i)
            out[i] = nqm_has_value(flag[0][i / 3]) && nqm_has_value(flag[1][i / 3]) ? mean(self, out[i], with[i]) : NAN;
    }
}

static nqm_status create(const nqm_values *values, const nqm_between_bases *bases, nqm_brdf_info *info, void **self_ret,
                         nqm_error *err) {
    (void)bases, (void)info;
    between *self = *self_ret = nqm_alloc(1, sizeof *self);
    if (!self)
        return nqm_fail_nomem(err, sizeof *self);
    self->t = values->v[T][0];
    self->is_geometric = values->v[LOG][0] != 0;
    return NQM_OK;
}

const nqm_spec_wrapper nqm_between_wrapper = {
    .schema = {"between",
               N_KEYS,
               {[T] = {.name = "t", .n = 1, .low = 0, .high = 1, .required = true},
                [LOG] = {.name = "log", .n = 1, .low = 0, .high = 1, .whole = true, .fallback = 0}}},
    .has_with = true,
    .form = "between: the form is between:t=0.5;with=(BRDF);of=BRDF",
    .class_ = {.format = "between", .anisotropic = true, .eval_turned = between_eval, .free = nqm_wrapper_free},
    .create = create,
};
