/* SPDX-License-Identifier: MIT
 *
 * Points on the path of an optimiser: each is a spec, the loss falls along the path on average, and the same seed gives the same
 * point.
 */
#include "fit/fit.h"
#include "support/check.h"
#include "support/fitting.h"

static const char truth[] = "ggx:kd=.3,.2,.05;ks=.5;alpha=.12;f0=.2";

static double loss_at(const nqm_fit_target *target, const nqm_brdf *ref, const char *model, uint64_t seed,
                      size_t n_steps) {
    char spec[512];
    nqm_fit_options options = nqm_fit_options_default();
    nqm_error err = {0};
    options.n_directions = 500;
    if (nqm_fit_path(ref, model, &options, seed, n_steps, spec, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return loss_of_spec(target, spec);
}

TEST(paths_lead_downhill) {
    enum { N_SEEDS = 8 };
    nqm_fit_options options = nqm_fit_options_default();
    nqm_fit_target target;
    nqm_brdf *ref = must_open(truth);
    assert_int_equal(nqm_fit_target_make(ref, &options, &target, NULL), NQM_OK);
    for (size_t k = 0; k < NQM_FIT_FIRST_SHADING; ++k) {
        const nqm_fit_entry *entry;
        double sum[3] = {0};
        assert_int_equal(nqm_fit_entry_find(nqm_fit_model(k), &entry, NULL), NQM_OK);
        for (uint64_t seed = 0; !entry->encode && seed < N_SEEDS; ++seed) {
            sum[0] += loss_at(&target, ref, entry->name, seed, 0) / N_SEEDS;
            sum[1] += loss_at(&target, ref, entry->name, seed, 3) / N_SEEDS;
            sum[2] += loss_at(&target, ref, entry->name, seed, 30) / N_SEEDS;
        }
        if (!entry->encode && !(sum[0] > 1.2 * sum[1] && sum[1] > sum[2]))
            fail_msg("%s: %g %g %g", entry->name, sum[0], sum[1], sum[2]);
    }
    nqm_brdf_free(ref);
    nqm_free(target.wi);
}

TEST(a_seed_is_a_path) {
    char a[512], b[512], c[512], d[512];
    nqm_fit_options options = nqm_fit_options_default();
    nqm_brdf *ref = must_open(truth);
    assert_int_equal(nqm_fit_path(ref, "ward", &options, 1, 2, a, NULL), NQM_OK);
    assert_int_equal(nqm_fit_path(ref, "ward", &options, 1, 2, b, NULL), NQM_OK);
    assert_int_equal(nqm_fit_path(ref, "ward", &options, 2, 2, c, NULL), NQM_OK);
    options.loss = NQM_FIT_LINEAR;
    assert_int_equal(nqm_fit_path(ref, "ward", &options, 1, 2, d, NULL), NQM_OK);
    assert_string_equal(a, b);
    assert_string_not_equal(a, c);
    assert_string_not_equal(a, d);
    nqm_error err = {0};
    assert_int_equal(nqm_fit_path(ref, "nbrdf", &options, 1, 2, d, &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "analytic"));
    nqm_brdf_free(ref);
}
