/* SPDX-License-Identifier: MIT
 *
 * score_renderer.c - score the BRDF of your own renderer, in two ways: as callbacks, which nqm evaluates at the model's
 * directions; and as samples, which your program evaluates there itself. Both give the same result.
 *
 *   cc score_renderer.c $(pkg-config --cflags --libs nqm) -lm -o score_renderer && ./score_renderer
 */
#include <math.h>
#include <nqm/metric.h>
#include <stdio.h>
#include <stdlib.h>

/* The renderer's material: Blinn-Phong, whose exponent the renderer rounds to a power of two. */
typedef struct material {
    double kd[3], ks, exponent;
} material;

/* f_r in 1/sr without the cosine; wi points to the light, wo to the viewer, z is the normal. */
static void evaluate(void *user, size_t n, const double *wi, const double *wo, double *rgb) {
    const material *m = user;
    for (size_t i = 0; i < n; ++i) {
        const double *a = wi + 3 * i, *b = wo + 3 * i;
        double h[3] = {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
        double cos_h = h[2] / sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
        double lobe = m->ks * (m->exponent + 2) / 6.283185307179586 * pow(cos_h, m->exponent);
        for (int c = 0; c < 3; ++c)
            rgb[3 * i + (size_t)c] = m->kd[c] / 3.141592653589793 + lobe;
    }
}

int main(void) {
    material exact = {{.20, .10, .05}, .05, 90};
    material rounded = {{.20, .10, .05}, .05, 64};
    nqm_error err = {0};
    nqm_model *model = NULL;
    nqm_scorer *scorer = NULL;
    nqm_brdf *ref = NULL, *test = NULL;
    nqm_score_result by_callbacks, by_samples;
    float *samples = NULL;
    char spec[128];

    /* The reference: the exact model, as a spec. */
    snprintf(spec, sizeof spec, "blinn-phong:kd=%g,%g,%g;ks=%g;n=%g", exact.kd[0], exact.kd[1], exact.kd[2], exact.ks,
             exact.exponent);
    /* 1. The renderer's BRDF through callbacks. evaluate() keeps no state, so threads may call it concurrently. */
    nqm_brdf_callbacks callbacks = {.eval = evaluate, .user = &rounded, .name = "rounded", .reciprocal = 1};
    nqm_status status = nqm_model_load("default", &model, &err);
    if (status == NQM_OK)
        status = nqm_brdf_open(spec, &ref, &err);
    if (status == NQM_OK)
        status = nqm_brdf_create(&callbacks, &test, &err);
    if (status == NQM_OK)
        status = nqm_score(model, ref, 1, (const nqm_brdf *const *)&test, NULL, &by_callbacks, &err);

    /* 2. The same values, sampled by this program: (n, 3) floats for each BRDF. */
    if (status == NQM_OK) {
        const nqm_directions *directions = nqm_model_get_info(model).directions;
        size_t n = nqm_directions_get_info(directions).n;
        const double *degrees = nqm_directions_get_info(directions).degrees; /* (n, 3) theta_h, theta_d, phi_d */
        samples = malloc(2 * n * 3 * sizeof *samples);
        for (size_t i = 0; i < n && samples; ++i) {
            double hd[3], wi[3], wo[3], rgb[2][3];
            for (int c = 0; c < 3; ++c)
                hd[c] = degrees[3 * i + (size_t)c] * (3.141592653589793 / 180);
            nqm_half_diff_to_directions(hd, wi, wo);
            evaluate(&exact, 1, wi, wo, rgb[0]);
            evaluate(&rounded, 1, wi, wo, rgb[1]);
            for (size_t c = 0; c < 3; ++c) {
                samples[3 * i + c] = (float)rgb[0][c];
                samples[3 * (n + i) + c] = (float)rgb[1][c];
            }
        }
        nqm_sample_pair pair = {.ref = samples, .test = samples ? samples + 3 * n : NULL};
        status = samples ? nqm_scorer_create(model, NULL, &scorer, &err) : NQM_ERR_NOMEM;
        if (status == NQM_OK)
            status = nqm_scorer_run_samples(scorer, 1, &pair, &by_samples, &err);
    }

    /* A pair that cannot be scored is a failure of its own result. */
    if (status == NQM_OK)
        status = by_callbacks.status != NQM_OK ? by_callbacks.status : by_samples.status;
    if (status == NQM_OK)
        printf("by callbacks: %.2f JOD, by samples: %.2f JOD\n", by_callbacks.jod, by_samples.jod);
    else
        fprintf(stderr, "score_renderer: %s\n", err.message[0] ? err.message : nqm_status_text(status));
    free(samples);
    nqm_scorer_free(scorer);
    nqm_brdf_free(test);
    nqm_brdf_free(ref);
    nqm_model_free(model);
    return status == NQM_OK ? 0 : 1;
}
