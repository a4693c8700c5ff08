/* SPDX-License-Identifier: MIT
 *
 * Golden scores: computed when a model is created, stored in its file, checked by the self-test.
 */
#include "io/json.h"
#include "metric/metric.h"

#include <math.h>

/* The specs state all parameters, because presets may change. */
static const char *const materials[] = {
    "ggx:kd=.2,.1,.05;ks=.5,.5,.5;alpha=.1;f0=.04",
    "ggx:kd=.2,.1,.05;ks=.5,.5,.5;alpha=.12;f0=.04",
    "ggx:kd=.18,.12,.05;ks=.5,.5,.5;alpha=.1;f0=.04",
    "ward:kd=.05,.05,.06;ks=.4,.35,.3;alpha=.05",
    "ggx:kd=.05,.05,.06;ks=.4,.35,.3;alpha=.05;f0=1",
    "lambert:kd=.5,.4,.3",
    "lambert:kd=.05,.1,.3",
};

/* Pairs of them, from identical to very different. */
static const size_t probes[][2] = {{0, 0}, {0, 1}, {0, 2}, {3, 4}, {5, 6}};
enum { N_PROBES = sizeof probes / sizeof *probes };

static const double tolerance_jod = 1e-3;

/* The JOD of a pair of specs; NaN when the pair has no score (too few directions with a value). */
static nqm_status score_specs(const nqm_model *model, const char *ref_spec, const char *test_spec, double *jod_ret,
                              nqm_error *err) {
    nqm_brdf *ref = NULL, *test = NULL;
    nqm_score_result result = {.jod = NAN};
    nqm_status status = nqm_brdf_open(ref_spec, &ref, err);
    if (status == NQM_OK)
        status = nqm_brdf_open(test_spec, &test, err);
    if (status == NQM_OK) {
        const nqm_brdf *tests[] = {test};
        status = nqm_score(model, ref, 1, tests, NULL, &result, err);
    }
    nqm_brdf_free(ref);
    nqm_brdf_free(test);
    *jod_ret = result.jod;
    return status == NQM_ERR_INCOMPATIBLE ? NQM_OK : status;
}

nqm_status nqm_golden_make(const nqm_model *model, char **json_ret, nqm_error *err) {
    *json_ret = NULL;
    json_t *list = json_array();
    nqm_status status = list ? NQM_OK : nqm_fail_nomem(err, 0);
    for (size_t i = 0; status == NQM_OK && i < N_PROBES; ++i) {
        const char *ref = materials[probes[i][0]], *test = materials[probes[i][1]];
        double jod;
        status = score_specs(model, ref, test, &jod, err);
        if (status == NQM_OK && isfinite(jod) &&
            json_array_append_new(list, json_pack("{s:s,s:s,s:f}", "ref", ref, "test", test, "jod", jod)))
            status = nqm_fail_nomem(err, 0);
    }
    char *text = nqm_json_text(list, 9);
    if (status == NQM_OK && !text)
        status = nqm_fail_nomem(err, 0);
    if (status == NQM_OK)
        *json_ret = text;
    else
        nqm_free(text);
    return status;
}

static nqm_status check_probe(const nqm_model *model, const json_t *probe, nqm_error *err) {
    const char *ref, *test;
    double stored, jod;
    if (json_unpack((json_t *)(uintptr_t)probe, "{s:s,s:s,s:F}", "ref", &ref, "test", &test, "jod", &stored) != 0)
        return nqm_fail(err, NQM_ERR_MODEL, -1, "model '%s': its golden scores cannot be read", model->id);
    nqm_status status = score_specs(model, ref, test, &jod, err);
    if (status == NQM_OK && !(fabs(jod - stored) <= tolerance_jod))
        status = nqm_fail(err, NQM_ERR_NUMERIC, -1, "model '%s': %s compared with %s has JOD %.5f, stored is %.5f",
                          model->id, test, ref, jod, stored);
    return status;
}

nqm_status nqm_golden_check(const nqm_model *model, nqm_error *err) {
    json_t *list;
    nqm_status status = nqm_json_parse(model->golden, &list, err);
    if (status != NQM_OK)
        return status;
    if (!list || !json_is_array(list) || json_array_size(list) == 0) {
        json_decref(list);
        return nqm_fail(err, NQM_ERR_MODEL, -1, "model '%s': has no golden scores", model->id);
    }
    for (size_t i = 0; status == NQM_OK && i < json_array_size(list); ++i)
        status = check_probe(model, json_array_get(list, i), err);
    json_decref(list);
    return status;
}
