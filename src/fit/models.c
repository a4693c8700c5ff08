/* SPDX-License-Identifier: MIT
 *
 * The models that a BRDF can be fitted with, by name, and the public entries of fitting and of learning encoders.
 */
#include "fit/encoders.h"
#include "fit/fit.h"

#include <string.h>

typedef nqm_status (*encode_fn)(const nqm_brdf *ref, nqm_budget budget, const nqm_fit_options *options,
                                nqm_fit_report *report, nqm_brdf **brdf_ret, nqm_error *err);

static nqm_status encode_nbrdf(const nqm_brdf *ref, nqm_budget budget, const nqm_fit_options *options,
                               nqm_fit_report *report, nqm_brdf **brdf_ret, nqm_error *err) {
    (void)budget;
    return nqm_fit_nbrdf(ref, options, report, brdf_ret, err);
}

/* A model of the list; `encode` is NULL for analytic ones. */
typedef struct entry {
    const char *name;
    encode_fn encode;
    nqm_budget budget;
    const char *summary;
} entry;

static const entry entries[] = {
    {"ward", NULL, 0, "Ward 1992: exponential lobe over Lambert, 7 numbers"},
    {"ggx", NULL, 0, "GGX microfacets (Walter et al. 2007), Schlick's Fresnel, over Lambert, 8 numbers"},
    {"nbrdf", encode_nbrdf, 0, "network of 6-21-21-3 trained for this BRDF (Sztrajman et al. 2021), 675 numbers"},
    {"sparse-low", nqm_fit_sparse, NQM_BUDGET_LOW,
     "few atoms of a learned dictionary (after Tongbuasirilai et al. 2022)"},
    {"sparse-mid", nqm_fit_sparse, NQM_BUDGET_MID,
     "some atoms of a learned dictionary (after Tongbuasirilai et al. 2022)"},
    {"sparse-high", nqm_fit_sparse, NQM_BUDGET_HIGH,
     "many atoms of a learned dictionary (after Tongbuasirilai et al. 2022)"},
    {"hyper-low", nqm_fit_hyper, NQM_BUDGET_LOW, "network written from 12 samples (after Gokbudak et al. 2024)"},
    {"hyper-mid", nqm_fit_hyper, NQM_BUDGET_MID, "network written from 64 samples (after Gokbudak et al. 2024)"},
    {"hyper-high", nqm_fit_hyper, NQM_BUDGET_HIGH, "network written from 400 samples (after Gokbudak et al. 2024)"},
    {"ward-duer", NULL, 0, "Ward's lobe in the normalisation of Duer, 7 numbers"},
    {"blinn-phong", NULL, 0, "power of the half vector's cosine (Blinn 1977), 7 numbers"},
    {"lafortune", NULL, 0, "one generalised cosine lobe (Lafortune et al. 1997), 8 numbers"},
    {"cook-torrance", NULL, 0, "Beckmann microfacets in V-grooves (Cook and Torrance 1982), 8 numbers"},
    {"ashikhmin-shirley", NULL, 0, "Phong microfacets with a Fresnel term (Ashikhmin and Shirley 2000), 8 numbers"},
    {"abc", NULL, 0, "microfacets with the ABC distribution (Low et al. 2012), 9 numbers"},
    {"smooth", NULL, 0, "smooth surface with the ABC power spectrum (Low et al. 2012), 9 numbers"},
};
enum { N_ENTRIES = sizeof entries / sizeof *entries };

size_t nqm_fit_model_count(void) {
    return N_ENTRIES;
}

const char *nqm_fit_model_name(size_t i) {
    return entries[i].name;
}

const char *nqm_fit_model_summary(size_t i) {
    return entries[i].summary;
}

static nqm_status fail_unknown(const char *model, nqm_error *err) {
    char names[400];
    size_t used = 0;
    for (size_t i = 0; i < N_ENTRIES && used < sizeof names; ++i)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", entries[i].name);
    return nqm_fail(err, NQM_ERR_ARG, -1, "cannot fit a model '%.40s'; these can be fitted: %s", model, names);
}

nqm_status nqm_fit(const nqm_brdf *ref, const char *model, const nqm_fit_options *options_or_null,
                   nqm_fit_report *report_ret, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_fit_options options = options_or_null ? *options_or_null : nqm_fit_options_default();
    nqm_fit_report report = {0};
    nqm_brdf *brdf = NULL;
    if (brdf_ret)
        *brdf_ret = NULL;
    size_t i = 0;
    while (i < N_ENTRIES && strcmp(entries[i].name, model) != 0)
        ++i;
    if (i == N_ENTRIES)
        return fail_unknown(model, err);
    nqm_status status = nqm_fit_check_options(&options, err);
    if (status != NQM_OK)
        return status;
    status = entries[i].encode ? entries[i].encode(ref, entries[i].budget, &options, &report, &brdf, err)
                               : nqm_fit_analytic(ref, model, &options, &report, &brdf, err);
    if (status != NQM_OK)
        return status;
    *report_ret = report;
    if (brdf_ret)
        *brdf_ret = brdf;
    else
        nqm_brdf_free(brdf);
    return NQM_OK;
}

/* ---- learning ---------------------------------------------------------------------------------------------------- */

nqm_learn_options nqm_learn_options_default(void) {
    return (nqm_learn_options){.seed = 1};
}

nqm_status nqm_learn(nqm_encoder what, size_t n, const nqm_brdf *const *refs, const char *const *names,
                     const nqm_learn_options *options_or_null, const char *path, nqm_error *err) {
    nqm_learn_options options = options_or_null ? *options_or_null : nqm_learn_options_default();
    if (n == 0)
        return nqm_fail(err, NQM_ERR_ARG, -1, "there is nothing to learn from");
    return what == NQM_ENCODER_SPARSE ? nqm_learn_sparse(n, refs, names, &options, path, err)
                                      : nqm_learn_hyper(n, refs, names, &options, path, err);
}
