/* SPDX-License-Identifier: MIT
 *
 * The self-test: checks, in about a second, results that a wrong compiler flag, library or processor would change.
 * NumPy computed the expected values of BRDFs and of the JOD curve (tests/vectors/selftest.py); the golden scores of a
 * model were computed when it was created.
 */
#include "kernel/kernel.h"
#include "math/math.h"
#include "metric/metric.h"
#include "net/inference.h"
#include "percept/percept.h"
#include "selftest_golden.h" /* in presets/ */

#include <math.h>

typedef struct session {
    void (*report)(void *user, const char *name, int passed);
    void *user;
    size_t n_failed;
    nqm_error first; /* error of the first failed check */
} session;

static void record(session *s, const char *name, nqm_status status, const nqm_error *err) {
    bool passed = status == NQM_OK;
    if (!passed && s->n_failed++ == 0)
        nqm_fail(&s->first, NQM_ERR_NUMERIC, -1, "%s: %s", name, err->message);
    if (s->report)
        s->report(s->user, name, passed);
}

static bool near(double actual, double expected, double relative) {
    return fabs(actual - expected) <= relative * fabs(expected);
}

/* ---- coordinates ------------------------------------------------------------------------------------------------- */

static nqm_status check_coordinates(nqm_error *err) {
    nqm_rng rng = nqm_rng_make(2, 0);
    for (int i = 0; i < 10000; ++i) {
        double hd[3] = {1.3 * nqm_rng_uniform(&rng), 1.3 * nqm_rng_uniform(&rng), NQM_PI * nqm_rng_uniform(&rng)};
        double wi[3], wo[3], back[3];
        nqm_half_diff_to_directions(hd, wi, wo);
        nqm_directions_to_half_diff(wi, wo, back);
        double turn = fabs(back[2] - hd[2]); /* azimuths 0 and pi are equal, and undefined where a sine is 0 */
        double azimuth = fmin(turn, NQM_PI - turn) * sin(hd[0]) * sin(hd[1]);
        if (!(fabs(back[0] - hd[0]) <= 1e-13 && fabs(back[1] - hd[1]) <= 1e-13 && azimuth <= 1e-13))
            return nqm_fail(err, NQM_ERR_NUMERIC, -1, "theta_h %g, theta_d %g, phi_d %g comes back as %g, %g, %g",
                            hd[0], hd[1], hd[2], back[0], back[1], back[2]);
    }
    return NQM_OK;
}

/* ---- published values -------------------------------------------------------------------------------------------- */

static nqm_status check_curve(nqm_error *err) {
    double top = nqm_curve_jod(&nqm_curve_published, 0);
    if (top != 10)
        return nqm_fail(err, NQM_ERR_NUMERIC, -1, "Delta-E 0 has JOD %.17g, not 10", top);
    for (size_t i = 0; i < sizeof golden_jod / sizeof *golden_jod; ++i) {
        double jod = nqm_curve_jod(&nqm_curve_published, golden_jod[i][0]);
        if (!near(jod, golden_jod[i][1], 1e-12))
            return nqm_fail(err, NQM_ERR_NUMERIC, -1, "Delta-E %g has JOD %.15g, not %.15g", golden_jod[i][0], jod,
                            golden_jod[i][1]);
    }
    return NQM_OK;
}

static nqm_status check_brdfs(nqm_error *err) {
    for (size_t i = 0; i < sizeof golden_brdfs / sizeof *golden_brdfs; ++i) {
        nqm_brdf *brdf;
        nqm_status status = nqm_brdf_open(golden_brdfs[i].spec, &brdf, err);
        if (status != NQM_OK)
            return status;
        double hd[3], rgb[3];
        for (int k = 0; k < 3; ++k)
            hd[k] = golden_brdfs[i].hd_deg[k] * (NQM_PI / 180);
        nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, NULL);
        nqm_brdf_free(brdf);
        for (int k = 0; k < 3; ++k)
            if (!near(rgb[k], golden_brdfs[i].rgb[k], 1e-9))
                return nqm_fail(err, NQM_ERR_NUMERIC, -1, "%s, golden value %zu, channel %d: %.15g, not %.15g",
                                golden_brdfs[i].spec, i, k, rgb[k], golden_brdfs[i].rgb[k]);
    }
    return NQM_OK;
}

/* ---- built-in models --------------------------------------------------------------------------------------------- */

enum { BATCH = 3 };

/* Run the network on rows of random input. z: (BATCH, outputs of the network) */
static nqm_status run_network(const nqm_inference_net *net, size_t width, float *z, nqm_error *err) {
    float *x = nqm_alloc(BATCH, width * sizeof *x);
    nqm_inference_work *work = NULL;
    nqm_status status =
        x ? nqm_inference_work_create(net, BATCH, &work, err) : nqm_fail_nomem(err, BATCH * width * sizeof *x);
    nqm_rng rng = nqm_rng_make(3, 0);
    for (size_t i = 0; status == NQM_OK && i < BATCH * width; ++i)
        x[i] = (float)nqm_rng_normal(&rng);
    if (status == NQM_OK)
        nqm_inference_run(work, BATCH, x, width, z);
    nqm_inference_work_free(work);
    nqm_free(x);
    return status;
}

/* Compare the output of the current kernels with that of the plain loops. */
static nqm_status check_forward(const nqm_model *model, nqm_error *err) {
    float fast[BATCH * (1 + NQM_LABEL_PARTS)], plain[BATCH * (1 + NQM_LABEL_PARTS)];
    const size_t width = model->params.shape.sizes[0];
    const nqm_inference_net *net;
    nqm_status status = nqm_model_inference(model, &net, err);
    if (status == NQM_OK)
        status = run_network(net, width, fast, err);
    if (status != NQM_OK)
        return status;
    const nqm_kernels *in_use = nqm_kernels_get();
    nqm_kernels_use(&nqm_kernels_scalar); /* affects other threads too: they compute the same values, more slowly */
    status = run_network(net, width, plain, err);
    nqm_kernels_use(in_use);
    for (size_t i = 0; status == NQM_OK && i < BATCH * nqm_model_n_outputs(model); ++i)
        if (!(fabs((double)fast[i] - (double)plain[i]) <= 1e-4 * fmax(1, fabs((double)plain[i]))))
            return nqm_fail(err, NQM_ERR_NUMERIC, -1, "model '%s': output %g, by plain loops %g", model->id,
                            (double)fast[i], (double)plain[i]);
    return status;
}

static void check_model(session *s, const nqm_embedded_file *embedded) {
    char name[120];
    nqm_error err = {0};
    nqm_model *model = NULL;
    /* verify: opening a built-in model skips the checksum and the search for non-finite weights */
    nqm_status status =
        nqm_model_parse(embedded->begin, (size_t)(embedded->end - embedded->begin), embedded->name, true, &model, &err);
    snprintf(name, sizeof name, "model %s: checksum and tensors", embedded->name);
    record(s, name, status, &err);
    if (status == NQM_OK) {
        if (nqm_model_has_network(model)) {
            snprintf(name, sizeof name, "model %s: network by plain loops", embedded->name);
            record(s, name, check_forward(model, &err), &err);
        }
        snprintf(name, sizeof name, "model %s: golden scores", embedded->name);
        record(s, name, nqm_golden_check(model, &err), &err);
    }
    nqm_model_free(model);
}

nqm_status nqm_selftest(void (*report)(void *user, const char *name, int passed), void *user, nqm_error *err) {
    static const struct {
        const char *name;
        nqm_status (*check)(nqm_error *err);
    } checks[] = {{"half-vector coordinates there and back", check_coordinates},
                  {"JOD curve", check_curve},
                  {"BRDF presets by NumPy", check_brdfs}};
    session s = {.report = report, .user = user};
    for (size_t i = 0; i < sizeof checks / sizeof *checks; ++i) {
        nqm_error inner = {0};
        record(&s, checks[i].name, checks[i].check(&inner), &inner);
    }
    for (const nqm_embedded_file *m = nqm_embedded_models; m->name; ++m)
        check_model(&s, m);
    return s.n_failed ? nqm_fail(err, NQM_ERR_NUMERIC, -1, "%s", s.first.message) : NQM_OK;
}
