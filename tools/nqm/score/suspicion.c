/* SPDX-License-Identifier: MIT
 *
 * Suspicions about a bad score: values of another scale, or with the cosine, are often a fault of the file. The ratio of the test to
 * its reference is then about the same at all directions, or as a cosine.
 */
#include "metric/metric.h"
#include "nqm/score/score.h"

#include <math.h>
#include <stdlib.h>

/* rgb: (2, n, 3) */
static void compare(const char *name, const nqm_directions *directions, const float *rgb, double *scratch) {
    double plain[2], with_cosine[2]; /* median and interquartile range */
    nqm_log_ratio(directions, rgb, 0, scratch, plain);
    if (fabs(plain[0]) > log(100) && plain[1] < 3)
        report(EXIT_OK,
               "%s: about %.4g times its reference at most directions: is a scale missing in one of them? It is 1500, "
               "1304 and 904 in MERL files, 255 in values of 8 bits",
               name, exp(plain[0]));
    for (int sign = -1; sign <= 1; sign += 2) {
        nqm_log_ratio(directions, rgb, sign, scratch, with_cosine);
        if (fabs(with_cosine[0]) < log(1.3) && with_cosine[1] < 0.2 * plain[1])
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
    float *rgb = allocate(6 * n, sizeof *rgb);
    double *scratch = allocate(n, sizeof *scratch);
    bool has_ref = false;
    for (size_t i = 0; i < run->n_rows; ++i) {
        const scored_pair *row = &run->rows[i];
        if (i && !has_reference_of(row, row - 1))
            has_ref = false;
        if (row->err.status != NQM_OK || !(row->result.jod < 9))
            continue;
        has_ref = has_ref || sample(row->pair.ref, directions, rgb);
        if (has_ref && sample(row->pair.test, directions, rgb + 3 * n))
            compare(row->name, directions, rgb, scratch);
    }
    free(rgb);
    free(scratch);
}
