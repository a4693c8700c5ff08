/* SPDX-License-Identifier: MIT
 *
 * `nqm score --exact`: whether two BRDFs have the same values, beside how similar they look.
 */
#include "nqm/score/score.h"

#include <math.h>

void compare_rows(score_run *run) {
    nqm_error err = {0};
    if (!run->exact)
        return;
    if (run->format == FORMAT_CSV || run->format == FORMAT_QUIET)
        stop(EXIT_USAGE, "--exact prints text or --json");
    nqm_brdf *ref = NULL;
    for (size_t i = 0; i < run->n_rows; ++i) {
        scored_pair *row = &run->rows[i];
        if (i && !has_reference_of(row, row - 1)) {
            nqm_brdf_free(ref);
            ref = NULL;
        }
        if (row->err.status != NQM_OK || row->texture)
            continue;
        ref = ref ? ref : open_brdf(row->pair.ref);
        nqm_brdf *test = open_brdf(row->pair.test);
        must(nqm_brdf_compare(ref, test, run->tolerance, 1, &row->difference, &err), &err);
        nqm_brdf_free(test);
    }
    nqm_brdf_free(ref);
}

static double polar_deg(const double *direction) {
    return acos(fmin(direction[2], 1)) * 57.29577951308232;
}

void print_exact(const score_run *run, const scored_pair *row) {
    static const char *const channels[] = {"red", "green", "blue"};
    const nqm_brdf_difference *d = &row->difference;
    printf("         %s within %g: values differ by up to %.3g %%\n", d->is_equal ? "equal" : "NOT equal",
           run->tolerance, 100 * d->largest);
    if (d->is_equal)
        return;
    if (d->n_different)
        printf("         (%s %.4g, reference %.4g, at wi %.4f,%.4f,%.4f, wo %.4f,%.4f,%.4f:\n"
               "         light at %.1f, viewer at %.1f degrees); at %zu of %zu pairs of directions\n",
               channels[d->channel], d->test, d->ref, d->wi[0], d->wi[1], d->wi[2], d->wo[0], d->wo[1], d->wo[2],
               polar_deg(d->wi), polar_deg(d->wo), d->n_different, d->n_pairs);
    if (d->n_missing)
        printf("         only one of them has a value at %zu of %zu pairs of directions\n", d->n_missing, d->n_pairs);
}

json_t *json_exact(const score_run *run, const scored_pair *row) {
    const nqm_brdf_difference *d = &row->difference;
    return json_pack("{s:b,s:f,s:f,s:[f,f,f],s:[f,f,f],s:i,s:f,s:f,s:I,s:I,s:I}", "equal", d->is_equal, "tolerance",
                     run->tolerance, "largest", d->largest, "wi", d->wi[0], d->wi[1], d->wi[2], "wo", d->wo[0],
                     d->wo[1], d->wo[2], "channel", d->channel, "reference", d->ref, "test", d->test, "n_different",
                     (json_int_t)d->n_different, "n_missing", (json_int_t)d->n_missing, "n_pairs",
                     (json_int_t)d->n_pairs);
}

bool report_unequal(const score_run *run) {
    size_t n = 0;
    for (size_t i = 0; i < run->n_rows; ++i)
        n += run->rows[i].err.status == NQM_OK && !run->rows[i].texture && !run->rows[i].difference.is_equal;
    if (n)
        report(EXIT_GATE, "%zu of %zu pairs are not equal within %g", n, run->n_rows, run->tolerance);
    return n > 0;
}
