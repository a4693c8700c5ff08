/* SPDX-License-Identifier: MIT
 *
 * The encodings hyper-*: more samples and a finer latent vector give a better network, and the number of threads does
 * not change the bits; a BRDF without values is refused.
 */
#include "brdf/brdf.h"
#include "fit/fit.h"
#include "support/check.h"

#include <nqm/fit.h>
#include <omp.h>

/* ---- encoding ---------------------------------------------------------------------------------------------------- */

static double loss_of(const nqm_brdf *ref, const char *model) {
    nqm_fit_report report;
    nqm_error err = {0};
    if (nqm_fit(ref, model, NULL, &report, NULL, &err) != NQM_OK)
        fail_msg("%s: %s", model, err.message);
    assert_string_equal(report.spec, "");
    assert_int_equal(report.n_numbers, NQM_NBRDF_WEIGHTS);
    return report.loss;
}

/* The losses are compared by their geometric means, so that the brightest material does not dominate. */
static void losses_of(const char *const models[3], double log_loss[3]) {
    static const char *const materials[] = {"sgd:pink-fabric",
                                            "sgd:maroon-plastic",
                                            "sgd:yellow-paint",
                                            "sgd:teflon",
                                            "ggx:kd=0.3,0.1,0.05;alpha=0.25",
                                            "ward:kd=0.1,0.2,0.3;ks=0.1;alpha=0.15"};
    enum { N_MATERIALS = sizeof materials / sizeof *materials };
    for (size_t m = 0; m < 3; ++m)
        log_loss[m] = 0;
    for (size_t i = 0; i < N_MATERIALS; ++i) {
        nqm_brdf *ref = must_open(materials[i]);
        for (size_t m = 0; m < 3; ++m)
            log_loss[m] += log(loss_of(ref, models[m])) / N_MATERIALS;
        nqm_brdf_free(ref);
    }
}

TEST(more_samples_are_better) {
    double loss[3];
    losses_of((const char *const[]){"hyper-low", "hyper-mid", "hyper-high"}, loss);
    if (!(loss[0] > loss[1] + 0.1 && loss[1] > loss[2] + 0.02 && loss[2] < log(0.015)))
        fail_msg("mean losses %g, %g, %g", exp(loss[0]), exp(loss[1]), exp(loss[2]));
}

TEST(level_0_is_the_finest) {
    double loss[3];
    losses_of((const char *const[]){"hyper-0", "hyper-1", "hyper-2"}, loss);
    if (!(loss[0] < loss[1] - 0.01 && loss[1] < loss[2] - 0.1))
        fail_msg("mean losses %g, %g, %g", exp(loss[0]), exp(loss[1]), exp(loss[2]));
}

static void values_of(const char *model, size_t n, double *rgb) {
    static const double hd[3 * 2] = {0.01, 0.3, 0.5, 0.6, 0.4, 1.5};
    nqm_fit_report report;
    nqm_brdf *ref = must_open("sgd:red-plastic"), *brdf;
    assert_int_equal(nqm_fit(ref, model, NULL, &report, &brdf, NULL), NQM_OK);
    assert_string_equal(nqm_brdf_get_info(brdf).format, "nbrdf");
    nqm_brdf_eval_half_diff(brdf, n, hd, rgb, NULL);
    nqm_brdf_free(brdf);
    nqm_brdf_free(ref);
}

TEST(encoding_does_not_depend_on_threads) {
    double one[6], two[6];
    int n_threads = omp_get_max_threads();
    omp_set_num_threads(1);
    values_of("hyper-high", 2, one);
    omp_set_num_threads(2);
    values_of("hyper-high", 2, two);
    omp_set_num_threads(n_threads);
    assert_memory_equal(one, two, sizeof one);
    assert_true(one[0] > one[1]); /* red */
}

static void empty_eval(const void *self, size_t n, const double *hd, double *rgb) {
    (void)self, (void)hd;
    for (size_t i = 0; i < 3 * n; ++i)
        rgb[i] = (double)NAN;
}

static const nqm_brdf_class empty_class = {.format = "empty", .eval_half_diff = empty_eval, .free = free_nothing};

TEST(brdfs_without_values_are_refused) {
    nqm_brdf *empty;
    nqm_fit_report report;
    nqm_error err = {0};
    static int self;
    assert_int_equal(nqm_brdf_wrap(&empty_class, &self, &(nqm_brdf_info){.name = "nothing"}, &empty, NULL), NQM_OK);
    assert_int_equal(nqm_fit(empty, "hyper-low", NULL, &report, NULL, &err), NQM_ERR_INCOMPATIBLE);
    assert_non_null(strstr(err.message, "nothing"));
    nqm_brdf_free(empty);
}
