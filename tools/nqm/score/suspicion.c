/* SPDX-License-Identifier: MIT
 *
 * Suspicions about a bad score: values of another scale, or with the cosine, are often a fault of the file. The ratio of the test to
 * its reference is then about the same at all directions, or as a cosine.
 */
#include "nqm/score/score.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a logarithm; range: between the quartiles. */
typedef struct spread {
    double median, range;
} spread;

static int compare_numbers(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Of log(test / reference) less `sign` log(cos(theta_o)); scratch: (n). */
static spread measure(size_t n, const float *ref, const float *test, const double *wo, double sign, double *scratch) {
    size_t m = 0;
    for (size_t i = 0; i < n; ++i) {
        const double r = (double)ref[3 * i + 1], t = (double)test[3 * i + 1];
        if (r > 0 && t > 0)
            scratch[m++] = log(t / r) - sign * log(wo[3 * i + 2]);
    }
    qsort(scratch, m, sizeof *scratch, compare_numbers);
    return m < 4 ? (spread){0, INFINITY} : (spread){scratch[m / 2], scratch[3 * m / 4] - scratch[m / 4]};
}

static void compare(const char *name, const nqm_directions *directions, const float *ref, const float *test,
                    double *scratch) {
    const size_t n = nqm_directions_count(directions);
    const double *wo = nqm_directions_wo(directions);
    const spread plain = measure(n, ref, test, wo, 0, scratch);
    if (fabs(plain.median) > log(100) && plain.range < 3)
        report(EXIT_OK,
               "%s: about %.4g times its reference at most directions: is a scale missing in one of them? It is 1500, "
               "1304 and 904 in MERL files, 255 in values of 8 bits",
               name, exp(plain.median));
    for (int sign = -1; sign <= 1; sign += 2) {
        const spread with = measure(n, ref, test, wo, sign, scratch);
        if (fabs(with.median) < log(1.3) && with.range < 0.2 * plain.range)
            report(EXIT_OK, "%s: about its reference %s the cosine of light or viewer: f_r is without a cosine", name,
                   sign > 0 ? "times" : "divided by");
    }
}

/* rgb (n, 3); false: it has no values. */
static bool sample(const char *argument, const nqm_directions *directions, float *rgb) {
    nqm_brdf *brdf;
    bool done = nqm_brdf_open(argument, &brdf, NULL) == NQM_OK;
    done = done && nqm_sample(brdf, directions, NQM_INVALID_DROP, rgb, NULL, NULL, NULL) == NQM_OK;
    nqm_brdf_free(brdf);
    return done;
}

void report_suspicions(const score_run *run) {
    const nqm_directions *directions = nqm_model_get_info(run->model).directions;
    const size_t n = nqm_directions_count(directions);
    const double suspicious = 9;
    float *ref = allocate(6 * n, sizeof *ref);
    double *scratch = allocate(n, sizeof *scratch);
    bool has_ref = false;
    for (size_t i = 0; i < run->n_rows; ++i) {
        const scored_pair *row = &run->rows[i];
        if (row->err.status != NQM_OK || !(row->result.jod < suspicious))
            continue;
        has_ref = has_ref || sample(row->pair.ref, directions, ref);
        if (has_ref && sample(row->pair.test, directions, ref + 3 * n))
            compare(row->name, directions, ref, ref + 3 * n, scratch);
    }
    free(ref);
    free(scratch);
}
