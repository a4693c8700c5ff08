/* SPDX-License-Identifier: MIT
 *
 * Evaluation of shading models with mistakes (core/mistakes.h), and the mistakes that change values of any model.
 */
#include "brdf/core/mistakes.h"

#include "brdf/core/spec.h"

#define TWIN_OF(NAME, ...) &nqm_##NAME##_model_mistaken,
static const nqm_analytic_model *const twins[] = {NQM_SHADING_SCHEMAS(TWIN_OF)};

static bool is_in(const nqm_mistakes *mistakes, int mistake) {
    return mistakes->made >> mistake & 1;
}

static double change(double v, const nqm_mistakes *m, double cos_i, double cos_o) {
    v *= is_in(m, NQM_MISTAKE_TIMES_PI) ? NQM_PI : is_in(m, NQM_MISTAKE_DIVIDED_BY_PI) ? 1 / NQM_PI : 1;
    v *= is_in(m, NQM_MISTAKE_COSINE_INCLUDED) ? cos_i : is_in(m, NQM_MISTAKE_COSINE_OF_VIEWER) ? cos_o : 1;
    v = is_in(m, NQM_MISTAKE_CLAMPED) ? fmin(v, m->amount) : v;
    return is_in(m, NQM_MISTAKE_ENCODED) ? nqm_linear_to_srgb(v) : v;
}

void nqm_mistaken_eval(const nqm_values *values, const nqm_mistakes *mistakes, size_t n, const double *wi,
                       const double *wo, float *rgb) {
    enum { PIECE = 256 };
    _Alignas(max_align_t) char state[NQM_SPEC_MAX_STATE];
    double piece[3 * PIECE];
    size_t twin = 0;
    const char *to = mistakes->channels;
    const bool leaks = to && strlen(to) == 2;
    while (twins[twin]->schema != values->schema)
        ++twin;
    const nqm_analytic_model *model = twins[twin];
    nqm_mistakes_made = *mistakes;
    *(nqm_spec_state *)state = (nqm_spec_state){model, *values};
    model->prepare(values, state);
    for (size_t at = 0, end; at < n; at = end) {
        end = nqm_smaller(n, at + PIECE);
        const bool is_exchanged = is_in(mistakes, NQM_MISTAKE_EXCHANGED);
        model->class_.eval(state, end - at, 3 * at + (is_exchanged ? wo : wi), 3 * at + (is_exchanged ? wi : wo),
                           piece);
        for (size_t i = at; i < end; ++i)
            for (size_t c = 0; c < 3; ++c) {
                const double *right = piece + 3 * (i - at);
                const double leak =
                    leaks && nqm_channel_of(to[0]) == c ? mistakes->amount * right[nqm_channel_of(to[1])] : 0;
                const double v = right[to && !leaks ? nqm_channel_of(to[c]) : c] + leak;
                rgb[3 * i + c] = v > 0 && isfinite(v) ? (float)change(v, mistakes, wi[3 * i + 2], wo[3 * i + 2]) : 0;
            }
    }
    nqm_mistakes_made.made = 0;
}
