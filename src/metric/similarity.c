/* SPDX-License-Identifier: MIT
 *
 * The similarity of two materials that people see apart: a distance of the looks of their pictures and of their samples on a log
 * scale, on the JOD scale. A sum of distances with weights >= 0: 0 for equal pairs, symmetric, with the triangle inequality, and
 * never a higher score for a larger component. doc/people.md says how it agrees with people, studies/similarity.py fits it.
 */
#include "metric/sums.h"

#include <math.h>

/* Weights of the components, in units of Delta-E: constants fitted to the answers of Lagunas et al. 2019 ("which of two
 * materials is more like the reference", DOI 10.1145/3306346.3323036; answers under GPL-2.0, of which nothing but these
 * numbers is here). */
static const double of_structure = 0.1133, /* root mean square Delta-E without the shift */
    of_peaks = 27.81,                      /* log of the 4-norm of I less its mean: how far highlights stand out */
    of_skew = 3.523,                       /* third moment of I: few bright places or few dark ones */
    of_colours = 8.636,                    /* log of the standard deviation of T and P: how much colours vary */
    of_hue = 5.84,                         /* mean T and P, their length limited: colours near grey count most */
    of_log = 4.572;                        /* root mean square difference of log(1 + f_r) */
/* 95 % half-width of the logarithm of the distance, by a bootstrap over the materials of the fit. */
static const double half_width = 0.123;

void nqm_look_add(nqm_look_sums *s, double weight, const double itp[3]) {
    double power = weight;
    for (int k = 0; k < 4; ++k)
        s->power[k] += power *= itp[0];
    s->t += weight * itp[1];
    s->p += weight * itp[2];
    s->chroma2 += weight * (itp[1] * itp[1] + itp[2] * itp[2]);
}

/* What is compared of a picture. */
typedef struct look {
    double peaks, skew, colours, hue[2];
} look;

static look look_of(const nqm_look_sums *s) {
    const double *x = s->power, m = x[0], length2 = s->t * s->t + s->p * s->p, length = sqrt(length2);
    const double third = x[2] - 3 * m * x[1] + 2 * m * m * m;
    const double fourth = x[3] - 4 * m * x[2] + 6 * m * m * x[1] - 3 * m * m * m * m;
    const double scale = 10, grey = 20; /* Delta-E */
    return (look){.peaks = log1p(sqrt(sqrt(fmax(fourth, 0)))),
                  .skew = asinh(third / (scale * scale * scale)) / 3,
                  .colours = log1p(sqrt(fmax(s->chroma2 - length2, 0))),
                  .hue = {s->t / (grey + length), s->p / (grey + length)}};
}

double nqm_look_distance(const nqm_look_sums *ref, const nqm_look_sums *test, double structure) {
    const look a = look_of(ref), b = look_of(test);
    return of_structure * structure + of_peaks * fabs(a.peaks - b.peaks) + of_skew * fabs(a.skew - b.skew) +
           of_colours * fabs(a.colours - b.colours) + of_hue * hypot(a.hue[0] - b.hue[0], a.hue[1] - b.hue[1]);
}

void nqm_apart_distances(const nqm_label *e, double looks, const nqm_metric_sums *sums, double apart[NQM_APART]) {
    apart[NQM_APART_DELTA_E] = e->delta_e;
    apart[NQM_APART_BRIGHTNESS] = fabs(e->shift[0]);
    apart[NQM_APART_COLOUR] = hypot(e->shift[1], e->shift[2]);
    apart[NQM_APART_CONTRAST] = 30 * fabs(e->contrast);
    apart[NQM_APART_STRUCTURE] = e->structure;
    apart[NQM_APART_BUILT_IN] = looks + of_log * sqrt(sums->squares[NQM_SCALE_LOG1P_F] / sums->n);
}

void nqm_similarity(const nqm_model *model, const double apart[NQM_APART], double similarity[3]) {
    const bool is_own = model->similarity[NQM_APART] > 0;
    const double width = is_own ? model->similarity[NQM_APART] : half_width;
    double distance = is_own ? 0 : apart[NQM_APART_BUILT_IN];
    for (int k = 0; k < NQM_APART && is_own; ++k)
        distance += model->similarity[k] * apart[k];
    for (int k = 0; k < 3; ++k)
        similarity[k] = nqm_curve_jod(&nqm_curve_published, distance * exp(k == 0 ? 0 : k == 1 ? width : -width));
}
