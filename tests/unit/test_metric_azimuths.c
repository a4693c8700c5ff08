/* SPDX-License-Identifier: MIT
 *
 * Anisotropic pairs: pictures of the model "anisotropic" against renderings, its file, what other models do with such
 * pairs, and scores that are continuous where the anisotropy vanishes.
 */
#include "brdf/brdf.h"
#include "metric/metric.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/scenes.h"
#include "support/scratch.h"

#include <nqm/label.h>

static const char brushed[] = "ggx:kd=.1;ks=1;alpha=.08,.3;f0=.9,.6,.3",
                  wider[] = "ggx:kd=.1;ks=1;alpha=.1,.35;f0=.9,.6,.3",
                  turned[] = "rotate:deg=90;of=ggx:kd=.1;ks=1;alpha=.08,.3;f0=.9,.6,.3",
                  plain[] = "ggx:kd=.1;ks=1;alpha=.15;f0=.9,.6,.3";

static nqm_model *make_model(void) {
    const nqm_scene_options o = studio_scene();
    nqm_model *model;
    nqm_error err = {0};
    if (nqm_transport_create(&o, 1, 64, "mine", &model, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return model;
}

static nqm_model *builtin(const char *name) {
    nqm_model *model;
    assert_int_equal(nqm_model_builtin(name, &model, NULL), NQM_OK);
    return model;
}

/* ---- the model --------------------------------------------------------------------------------------------------- */

/* Delta-E of the model's pictures and of renderings of the same points: of constant BRDFs, and of lobes of any width and shape. */
TEST(pictures_are_those_of_the_scene) {
    static const struct {
        const char *ref, *test;
        double tolerance; /* Delta-E */
    } pairs[] = {{"lambert:kd=.8,.5,.2", "lambert:kd=.5", 0.01},
                 {plain, "ggx:kd=.1;ks=1;alpha=.2;f0=.9,.6,.3", 0.4},
                 {brushed, wider, 0.4},
                 {brushed, turned, 0.5},
                 {"ggx:alpha=.001;f0=.9", "ggx:alpha=.001;f0=.8", 0.05},
                 {"ggx:alpha=.01,.05;f0=.9", "ggx:alpha=.02;f0=.9", 0.1},
                 {plain, "tilt:deg=5;azimuth=40;of=ggx:kd=.1;ks=1;alpha=.15;f0=.9,.6,.3", 1.8},
                 {"ggx:alpha=.001;f0=.9", "tilt:deg=.5;azimuth=30;of=ggx:alpha=.001;f0=.9", 0.5},
                 {"tilt:deg=20;azimuth=30;of=gltf:base_color=.6,.58,.5;metallic=0;roughness=.4",
                  "tilt:deg=20;azimuth=30;of=gltf:base_color=.59,.575,.49;metallic=0;roughness=.4", 0.05}};
    nqm_scene_options o = studio_scene();
    nqm_model *model = make_model();
    o.n_points = 64;
    o.n_lights = 4096;
    nqm_scene *scene = make_scene(&o);
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; ++i) {
        const nqm_label label = label_specs(scene, pairs[i].ref, pairs[i].test);
        const nqm_score_result result = score_specs(model, pairs[i].ref, pairs[i].test);
        assert_near(result.delta_e, label.delta_e, pairs[i].tolerance);
        assert_true(isnan(result.jod_low) && isnan(result.similarity[0]));
    }
    nqm_scene_free(scene);
    nqm_model_free(model);
}

TEST(files_and_copies_score_the_same) {
    nqm_model *model = make_model(), *loaded, *copy;
    assert_int_equal(nqm_model_save(model, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &loaded, NULL), NQM_OK);
    assert_int_equal(nqm_model_copy(model, &copy, NULL), NQM_OK);
    const double jod = score_specs(model, brushed, turned).jod;
    assert_true(score_specs(loaded, brushed, turned).jod == jod && score_specs(copy, brushed, turned).jod == jod);
    assert_true(jod < 9 && score_specs(model, brushed, brushed).identical);
    assert_int_equal(nqm_golden_check(loaded, NULL), NQM_OK);
    nqm_model_free(copy);
    nqm_model_free(loaded);
    nqm_model_free(model);
}

TEST(samples_have_no_score) {
    nqm_model *model = make_model();
    nqm_scorer *scorer;
    nqm_score_result result;
    nqm_error err = {0};
    float *f = nqm_alloc(model->directions->n, 3 * sizeof *f);
    assert_int_equal(nqm_scorer_create(model, NULL, &scorer, NULL), NQM_OK);
    assert_int_equal(nqm_scorer_run_samples(scorer, 1, &(nqm_sample_pair){f, f, NULL}, &result, &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "no score of samples"));
    nqm_free(f);
    nqm_scorer_free(scorer);
    nqm_model_free(model);
}

TEST(memory_runs_out) {
    const nqm_scene_options o = studio_scene();
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 8) {
        nqm_model *model = NULL;
        status = nqm_transport_create(&o, 1, 8, "mine", &model, NULL);
        assert_true((status == NQM_OK) == (model != NULL));
        nqm_model_free(model);
    }
}

/* Every cell has its own slopes, and their areas fill the disc. */
TEST(cells_cover_the_slopes) {
    double area = 0;
    for (size_t cell = 0; cell < NQM_SLOPE_CELLS; ++cell)
        area += nqm_slope_area(cell);
    assert_relative(area, 3.14159265358979 * NQM_SLOPE_MOST * NQM_SLOPE_MOST, 1e-9);
    assert_int_equal(nqm_slope_cell(0, 0), 0);
    assert_int_equal(nqm_slope_cell(1e3, 0), 1 + (NQM_SLOPE_RINGS - 1) * NQM_SLOPE_AZIMUTHS);
    assert_int_equal(nqm_slope_cell(NQM_SLOPE_LEAST * 1.0001, 0), 1);
    assert_int_equal(nqm_slope_cell(-1e-9, 1e3) - nqm_slope_cell(1e3, 0), NQM_SLOPE_AZIMUTHS / 4);
}

/* Ratio, azimuth and centre of lobes. */
TEST(lobes_are_measured) {
    static const struct {
        const char *spec;
        double ratio, phi_deg, x, y;
    } lobes[] = {{"ggx:kd=.3;alpha=.1", 1, 0, 0, 0},
                 {"ggx:alpha=.3,.1", 3, 0, 0, 0},
                 {"ggx:alpha=.02,.08;f0=.9", 4, 90, 0, 0},
                 {"rotate:deg=45;of=ward:ks=.1;alpha=.05,.01", 5, 45, 0, 0},
                 {"tilt:deg=10;azimuth=90;of=ggx:alpha=.05", 1, 0, 0, 0.176327}};
    for (size_t i = 0; i < sizeof lobes / sizeof *lobes; ++i) {
        nqm_brdf *brdf = must_open(lobes[i].spec);
        const nqm_lobe l = nqm_lobe_measure(brdf);
        const double longer = hypot(l.axes[0], l.axes[2]);
        assert_near(l.axes[0] * l.axes[3] - l.axes[1] * l.axes[2], 1, 1e-12);
        assert_relative(longer * longer, lobes[i].ratio, 0.12);
        assert_near(l.center[0], lobes[i].x, 0.002);
        assert_near(l.center[1], lobes[i].y, 0.002);
        if (lobes[i].ratio > 1)
            assert_near(fabs(l.axes[0] / longer), fabs(cos(lobes[i].phi_deg / 57.29577951)), 0.06);
        nqm_brdf_free(brdf);
    }
}

/* ---- which model ------------------------------------------------------------------------------------------------- */

TEST(default_takes_the_score_of_anisotropic) {
    nqm_model *models[] = {builtin("default"), builtin("transport")}, *whole = builtin("anisotropic");
    const nqm_score_result seen = score_specs(whole, brushed, turned);
    for (size_t i = 0; i < 2; ++i) {
        const nqm_score_result result = score_specs(models[i], brushed, turned),
                               flat = score_specs(models[i], plain, "ggx:ks=1;alpha=.2");
        assert_int_equal(result.status, NQM_OK);
        assert_true(result.anisotropy > 0.1 && result.jod == seen.jod &&
                    result.parts.structure == seen.parts.structure);
        assert_true(result.n_valid == models[i]->directions->n);
        assert_true(flat.anisotropy == 0);
        nqm_model_free(models[i]);
    }
    nqm_model_free(whole);
}

/* A model of another scene with the name of a built-in one, and the file of a built-in one. */
TEST(names_do_not_make_a_model_of_the_standard_scenes) {
    const nqm_scene_options o = studio_scene();
    nqm_model *model = builtin("transport"), *file, *other;
    assert_int_equal(nqm_model_save(model, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &file, NULL), NQM_OK);
    assert_int_equal(nqm_transport_create(&o, 0, 64, "transport", &other, NULL), NQM_OK);
    assert_true(score_specs(file, brushed, turned).jod == score_specs(model, brushed, turned).jod);
    assert_int_equal(score_specs(other, brushed, turned).status, NQM_ERR_INCOMPATIBLE);
    assert_int_equal(score_specs(other, plain, plain).status, NQM_OK);
    nqm_model_free(model);
    nqm_model_free(file);
    nqm_model_free(other);
}

/* The names of the same pair, and a model whose directions see one azimuth and that is not of the standard scenes. */
TEST(named_pairs) {
    nqm_model *model = builtin("default"), *paper = builtin("paper");
    const nqm_named_pair pairs[] = {{brushed, turned}, {plain, plain}, {plain, turned}};
    nqm_score_result results[3], refused[3];
    nqm_error errors[3];
    nqm_scorer *scorer;
    assert_int_equal(nqm_scorer_create(model, NULL, &scorer, NULL), NQM_OK);
    assert_int_equal(nqm_scorer_run_named(scorer, 3, pairs, results, errors, NULL), NQM_OK);
    nqm_scorer_free(scorer);
    assert_true(results[0].jod == score_specs(model, brushed, turned).jod &&
                results[2].jod == score_specs(model, plain, turned).jod);
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
TEST(scores_are_continuous_where_anisotropy_vanishes) {
    nqm_model *model = builtin("default");
    const nqm_score_result flat = score_specs(model, plain, "ggx:kd=.1;ks=1;alpha=.2;f0=.9,.6,.3");
    double last = flat.jod, last_delta_e = flat.delta_e;
    for (int i = 0; i <= 20; ++i) {
        char spec[100];
        snprintf(spec, sizeof spec, "ggx:kd=.1;ks=1;alpha=%.4f,%.4f;f0=.9,.6,.3", 0.2 + 0.0005 * i, 0.2 - 0.0005 * i);
        const nqm_score_result result = score_specs(model, plain, spec);
        assert_true((result.anisotropy > 0) == (i > 0));
        assert_near(result.jod, last, 0.05);
        assert_near(result.delta_e, last_delta_e, 0.3);
        last = result.jod;
        last_delta_e = result.delta_e;
    }
    nqm_model_free(model);
}

static void find_out(void *user, size_t n, const double *wi, const double *wo, double *rgb) {
    for (size_t i = 0; i < n; ++i)
        for (size_t k = 0; k < 3; ++k)
            rgb[3 * i + k] = *(const double *)user * (wi[3 * i] + wo[3 * i]) + 0.3;
}

/* A function of the caller says nothing about isotropy; it is measured. */
TEST(functions_are_found_out) {
    nqm_model *model = builtin("default");
    nqm_brdf *ref = must_open("lambert:kd=.9");
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
