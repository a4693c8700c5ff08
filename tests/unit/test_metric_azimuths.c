/* SPDX-License-Identifier: MIT
 *
 * Anisotropic pairs: the model "rays" against the labels of its rays and their gradients, its file, what other models do with such
 * pairs, and scores that are continuous where the anisotropy vanishes.
 */
#include "base/memory_test.h"
#include "brdf/brdf.h"
#include "metric/metric.h"
#include "support/check.h"
#include "support/scenes.h"
#include "support/temp_file.h"

#include <math.h>
#include <nqm/label.h>
#include <string.h>

static const char brushed[] = "ggx:kd=.1;ks=1;alpha=.08,.3;f0=.9,.6,.3",
                  wider[] = "ggx:kd=.1;ks=1;alpha=.1,.35;f0=.9,.6,.3",
                  turned[] = "rotate:deg=90;of=ggx:kd=.1;ks=1;alpha=.08,.3;f0=.9,.6,.3",
                  plain[] = "ggx:kd=.1;ks=1;alpha=.15;f0=.9,.6,.3";

static nqm_rays studio_rays(void) {
    nqm_scene_options o = nqm_scene_options_default();
    o.light = "studio";
    o.shape = "sphere";
    nqm_scene *scene = make_scene(&o);
    nqm_rays rays;
    assert_int_equal(nqm_rays_draw(scene, 2048, 1, &rays, NULL), NQM_OK);
    nqm_scene_free(scene);
    return rays;
}

static nqm_model *model_of(const nqm_rays *rays) {
    nqm_model *model;
    nqm_error err = {0};
    if (nqm_rays_model(rays, "mine", &model, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return model;
}

static nqm_model *builtin(const char *name) {
    nqm_model *model;
    assert_int_equal(nqm_model_builtin(name, &model, NULL), NQM_OK);
    return model;
}

static nqm_score_result score(const nqm_model *model, const char *ref_spec, const char *test_spec) {
    nqm_brdf *ref = open_brdf(ref_spec), *test = open_brdf(test_spec);
    const nqm_brdf *tests[] = {test};
    nqm_score_result result;
    assert_int_equal(nqm_score(model, ref, 1, tests, NULL, &result, NULL), NQM_OK);
    nqm_brdf_free(ref);
    nqm_brdf_free(test);
    return result;
}

static double *values_at(const double *wi, const double *wo, size_t n, const char *spec) {
    nqm_brdf *brdf = open_brdf(spec);
    double *f = nqm_alloc(n, 3 * sizeof *f);
    assert_non_null(f);
    nqm_brdf_eval(brdf, n, wi, wo, f, NULL);
    nqm_brdf_free(brdf);
    return f;
}

/* ---- the model of rays ------------------------------------------------------------------------------------------- */

static void scores_and_gradients_are_those_of_the_rays(void **state) {
    (void)state;
    nqm_rays rays = studio_rays();
    nqm_model *model = model_of(&rays);
    const nqm_directions *d = model->directions;
    const size_t n = d->n;
    assert_int_equal(n, rays.n);
    for (size_t i = 0; i < 3 * n; ++i) {
        assert_near(d->wi[i], rays.wi[i], 1e-9);
        assert_near(d->wo[i], rays.wo[i], 1e-9);
    }
    double *ref = values_at(d->wi, d->wo, n, brushed), *test = values_at(d->wi, d->wo, n, wider), delta_e;
    double *expected = nqm_alloc(n, 3 * sizeof *expected);
    float *f = nqm_alloc(n, 9 * sizeof *f), *gradient = f + 6 * n;
    nqm_label label;
    for (size_t i = 0; i < 3 * n; ++i) {
        f[i] = (float)ref[i];
        f[3 * n + i] = (float)test[i];
    }
    assert_int_equal(nqm_rays_compare(&rays, ref, test, &label, expected, NULL), NQM_OK);
    const nqm_score_result result = score(model, brushed, wider);
    assert_relative(result.delta_e, label.delta_e, 1e-5);
    assert_near(result.parts.contrast, label.contrast, 1e-5);
    assert_true(result.anisotropy == 0 && isnan(result.jod_low)); /* the model sees azimuths itself */
    nqm_scorer *scorer;
    assert_int_equal(nqm_scorer_create(model, NULL, &scorer, NULL), NQM_OK);
    const nqm_sample_pair pair = {f, f + 3 * n, NULL};
    assert_int_equal(nqm_score_grad(scorer, NQM_SCORE_DELTA_E, 1, &pair, &delta_e, gradient, NULL), NQM_OK);
    assert_relative(delta_e, label.delta_e, 1e-5);
    double largest = 0;
    for (size_t i = 0; i < 3 * n; ++i)
        largest = fmax(largest, fabs(expected[i]));
    for (size_t i = 0; i < 3 * n; ++i)
        assert_near((double)gradient[i], expected[i], 1e-4 * largest);
    nqm_scorer_free(scorer);
    nqm_model_free(model);
    nqm_rays_clear(&rays);
    nqm_free(ref);
    nqm_free(test);
    nqm_free(expected);
    nqm_free(f);
}

static void files_and_copies_score_the_same(void **state) {
    (void)state;
    nqm_rays rays = studio_rays();
    nqm_model *model = model_of(&rays), *loaded, *copy;
    nqm_directions *read;
    assert_int_equal(nqm_model_save(model, temp_file, NULL), NQM_OK);
    assert_int_equal(nqm_model_load(temp_file, &loaded, NULL), NQM_OK);
    assert_int_equal(nqm_model_copy(model, &copy, NULL), NQM_OK);
    const double jod = score(model, brushed, turned).jod;
    assert_true(score(loaded, brushed, turned).jod == jod && score(copy, brushed, turned).jod == jod);
    assert_true(jod < 9);
    assert_int_equal(nqm_golden_check(loaded, NULL), NQM_OK);
    assert_int_equal(nqm_directions_save_csv(model->directions, temp_file, NULL), NQM_OK);
    assert_int_equal(nqm_directions_load_csv(temp_file, &read, NULL), NQM_OK);
    assert_string_equal(nqm_directions_id(read), nqm_directions_id(loaded->directions));
    assert_true(nqm_directions_equal(read, copy->directions));
    nqm_directions_free(read);
    nqm_model_free(copy);
    nqm_model_free(loaded);
    nqm_model_free(model);
    nqm_rays_clear(&rays);
}

static void memory_runs_out(void **state) {
    (void)state;
    nqm_rays rays = studio_rays();
    nqm_status status = NQM_ERR_NOMEM;
    for (long n = 0; status != NQM_OK && n < 2000; ++n) {
        nqm_model *model = NULL;
        nqm_error err = {0};
        nqm_alloc_fail_after(n);
        status = nqm_rays_model(&rays, "mine", &model, &err);
        nqm_alloc_fail_after(-1);
        assert_true(status == NQM_OK || (status == NQM_ERR_NOMEM && !model));
        nqm_model_free(model);
    }
    assert_int_equal(status, NQM_OK);
    nqm_rays_clear(&rays);
}

/* ---- which model ------------------------------------------------------------------------------------------------- */

static void default_takes_the_score_of_rays(void **state) {
    (void)state;
    nqm_model *models[] = {builtin("default"), builtin("transport")}, *rays = builtin("rays");
    const nqm_score_result seen = score(rays, brushed, turned);
    for (size_t i = 0; i < 2; ++i) {
        const nqm_score_result result = score(models[i], brushed, turned),
                               flat = score(models[i], plain, "ggx:ks=1;alpha=.2");
        assert_int_equal(result.status, NQM_OK);
        assert_true(result.anisotropy > 0.1 && result.jod == seen.jod &&
                    result.parts.structure == seen.parts.structure);
        assert_true(result.n_valid == models[i]->directions->n);
        assert_true(flat.anisotropy == 0);
        nqm_model_free(models[i]);
    }
    nqm_model_free(rays);
}

/* The names of the same pair, and a model whose directions see one azimuth and that is not of the standard scenes. */
static void named_pairs(void **state) {
    (void)state;
    nqm_model *model = builtin("default"), *paper = builtin("paper");
    const nqm_named_pair pairs[] = {{brushed, turned}, {plain, plain}, {plain, turned}};
    nqm_score_result results[3], refused[3];
    nqm_error errors[3];
    nqm_scorer *scorer;
    assert_int_equal(nqm_scorer_create(model, NULL, &scorer, NULL), NQM_OK);
    assert_int_equal(nqm_scorer_run_named(scorer, 3, pairs, results, errors, NULL), NQM_OK);
    nqm_scorer_free(scorer);
    assert_true(results[0].jod == score(model, brushed, turned).jod &&
                results[2].jod == score(model, plain, turned).jod);
    assert_true(results[1].identical && results[1].anisotropy == 0);
    assert_int_equal(nqm_scorer_create(paper, NULL, &scorer, NULL), NQM_OK);
    assert_int_equal(nqm_scorer_run_named(scorer, 3, pairs, refused, errors, NULL), NQM_OK);
    nqm_scorer_free(scorer);
    assert_int_equal(refused[0].status, NQM_ERR_INCOMPATIBLE);
    assert_int_equal(refused[1].status, NQM_OK);
    assert_non_null(strstr(errors[2].message, "anisotropic"));
    nqm_model_free(model);
    nqm_model_free(paper);
}

/* JOD of ggx of two widths against one of another width, as the widths become equal. */
static void scores_are_continuous_where_anisotropy_vanishes(void **state) {
    (void)state;
    nqm_model *model = builtin("default");
    double last = score(model, plain, "ggx:kd=.1;ks=1;alpha=.2;f0=.9,.6,.3").jod;
    for (int i = 0; i <= 20; ++i) {
        char spec[100];
        snprintf(spec, sizeof spec, "ggx:kd=.1;ks=1;alpha=%.4f,%.4f;f0=.9,.6,.3", 0.2 + 0.0005 * i, 0.2 - 0.0005 * i);
        const nqm_score_result result = score(model, plain, spec);
        assert_true((result.anisotropy > 0) == (i > 0));
        assert_near(result.jod, last, 0.05);
        last = result.jod;
    }
    nqm_model_free(model);
}

static void find_out(void *user, size_t n, const double *wi, const double *wo, double *rgb) {
    for (size_t i = 0; i < n; ++i)
        for (size_t k = 0; k < 3; ++k)
            rgb[3 * i + k] = *(const double *)user * (wi[3 * i] + wo[3 * i]) + 0.3;
}

/* A function of the caller says nothing about isotropy; it is measured. */
static void functions_are_found_out(void **state) {
    (void)state;
    nqm_model *model = builtin("default");
    nqm_brdf *ref = open_brdf("lambert:kd=.9");
    for (int i = 0; i < 2; ++i) {
        double slope = 0.1 * i;
        nqm_brdf *test;
        nqm_score_result result;
        nqm_brdf_check_report report;
        assert_int_equal(nqm_brdf_create(&(nqm_brdf_callbacks){.eval = find_out, .user = &slope}, &test, NULL), NQM_OK);
        assert_int_equal(nqm_brdf_check(test, 1, &report, NULL), NQM_OK);
        assert_true((report.anisotropy > 0.01) == (i == 1) && (report.anisotropy == 0) == (i == 0));
        assert_int_equal(nqm_score(model, ref, 1, (const nqm_brdf *const *)&test, NULL, &result, NULL), NQM_OK);
        assert_true(result.anisotropy == report.anisotropy && (result.anisotropy > 0) == (i == 1));
        nqm_brdf_free(test);
    }
    nqm_brdf_free(ref);
    nqm_model_free(model);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scores_and_gradients_are_those_of_the_rays),
        cmocka_unit_test(files_and_copies_score_the_same),
        cmocka_unit_test(memory_runs_out),
        cmocka_unit_test(default_takes_the_score_of_rays),
        cmocka_unit_test(named_pairs),
        cmocka_unit_test(scores_are_continuous_where_anisotropy_vanishes),
        cmocka_unit_test(functions_are_found_out),
    };
    return cmocka_run_group_tests(tests, make_temp_file, remove_temp_file);
}
