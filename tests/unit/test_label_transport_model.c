/* SPDX-License-Identifier: MIT
 *
 * Models without a network that nqm_transport_create() makes: their scores are those of the scene, files and copies score the
 * same, golden scores, and refusals.
 */
#include "metric/metric.h"
#include "sample/node_grid.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/scenes.h"
#include "support/scratch.h"

#include <nqm/label.h>

static const char white[] = "lambert:kd=.8,.5,.2", grey[] = "lambert:kd=.5,.5,.5",
                  satin[] = "ggx:kd=.2,.15,.1;ks=1,1,1;alpha=.4;f0=.04";

static nqm_model *make_model(const nqm_scene_options *o, size_t n_points) {
    nqm_model *model;
    nqm_error err = {0};
    if (nqm_transport_create(o, 0, n_points, "mine", &model, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return model;
}

/* Constant BRDFs have no error of interpolation, so that only points and lights differ: the scene here has the model's. */
TEST(scores_are_of_the_scene) {
    nqm_scene_options o = studio_scene();
    nqm_model *model = make_model(&o, 96);
    o.n_points = 96;
    o.n_lights = 512; /* as transport.c */
    nqm_scene *scene = make_scene(&o);
    const nqm_label label = label_specs(scene, white, grey);
    const nqm_score_result result = score_specs(model, white, grey), same = score_specs(model, satin, satin);
    assert_int_equal(result.status, NQM_OK);
    assert_relative(result.delta_e, label.delta_e, 0.01);
    assert_near(result.jod, nqm_curve_jod(&nqm_curve_published, label.delta_e), 0.002);
    assert_near(result.parts.shift[0], label.shift[0], 1e-3 * label.delta_e);
    assert_near(result.parts.contrast, label.contrast, 1e-3);
    assert_near(result.parts.structure, label.structure, 1e-3 * label.delta_e);
    assert_true(isnan(result.jod_low) && isnan(result.novelty));
    assert_true(same.identical && same.jod == 10 && same.delta_e == 0);
    nqm_scene_free(scene);
    nqm_model_free(model);
}

TEST(facts) {
    const nqm_scene_options o = studio_scene();
    nqm_model *model = make_model(&o, 32);
    const nqm_model_info info = nqm_model_get_info(model);
    assert_string_equal(info.id, "mine");
    assert_string_equal(info.recipe, "transport");
    assert_true(info.n_layers == 0 && info.n_parameters == 0);
    bool is_grid;
    assert_int_equal(nqm_node_grid_check(info.directions, &is_grid, NULL), NQM_OK);
    assert_true(is_grid);
    assert_near(info.jod_max, 10, 1e-6);
    assert_near(info.jod_min, 0, 0.1);
    assert_string_equal(info.calibration, "");
    nqm_model_free(model);
}

static void assert_same_scores(const nqm_model *a, const nqm_model *b) {
    const nqm_score_result x = score_specs(a, white, satin), y = score_specs(b, white, satin);
    assert_int_equal(x.status, NQM_OK);
    assert_int_equal(y.status, NQM_OK);
    assert_true(x.jod == y.jod && x.delta_e == y.delta_e && x.parts.structure == y.parts.structure);
}

TEST(files_and_copies) {
    const nqm_scene_options o = studio_scene();
    nqm_model *model = make_model(&o, 32), *loaded, *copy;
    assert_int_equal(nqm_model_save(model, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &loaded, NULL), NQM_OK);
    assert_int_equal(nqm_model_copy(loaded, &copy, NULL), NQM_OK);
    assert_same_scores(model, loaded);
    nqm_model_free(loaded);
    assert_same_scores(model, copy);
    assert_int_equal(nqm_golden_check(copy, NULL), NQM_OK);
    for (size_t i = 0; i < copy->n_transport * 3 * copy->n_points; ++i)
        copy->transport[i] *= 0.5f; /* other light */
    assert_int_equal(nqm_golden_check(copy, NULL), NQM_ERR_NUMERIC);
    nqm_model_free(copy);
    nqm_model_free(model);
}

/* The number of points matters little. */
TEST(the_standard_scenes) {
    if (!nqm_tracer_version())
        skip();
    nqm_scene_options o = nqm_scene_options_default();
    o.n_lights = 128;
    nqm_model *few = make_model(&o, 128), *many = make_model(&o, 512);
    assert_relative(score_specs(few, white, grey).delta_e, score_specs(many, white, grey).delta_e, 0.05);
    nqm_model_free(few);
    nqm_model_free(many);
}

static void refuse(nqm_scene_options o, size_t n_points, nqm_status status, const char *words) {
    nqm_model *model;
    nqm_error err = {0};
    assert_int_equal(nqm_transport_create(&o, 0, n_points, "mine", &model, &err), status);
    assert_null(model);
    if (!strstr(err.message, words))
        fail_msg("'%s' lacks '%s'", err.message, words);
}

TEST(refusals) {
    static const size_t bad_points[] = {0, 1, 33, 127, 4128};
    nqm_scene_options o = studio_scene();
    for (size_t i = 0; i < sizeof bad_points / sizeof *bad_points; ++i)
        refuse(o, bad_points[i], NQM_ERR_ARG, "is no multiple of 32 up to 4096");
    o.light = "/nowhere/light.hdr";
    refuse(o, 32, NQM_ERR_IO, "/nowhere/light.hdr");
    o = studio_scene();
    o.shape = "/nowhere/shape.ply";
    refuse(o, 32, NQM_ERR_IO, "/nowhere/shape.ply");
}

/* Every allocation of the matrix, and some of the golden scores after it. */
TEST(out_of_memory) {
    nqm_scene_options o = studio_scene();
    nqm_model *model = NULL;
    nqm_status status = NQM_OK;
    long n = -1;
    o.n_lights = 16;
    EVERY_ALLOCATION(n, status, 20) {
        status = nqm_transport_create(&o, 0, 32, "mine", &model, NULL);
        assert_true((status == NQM_OK) == (model != NULL));
    }
    nqm_model_free(model);
}
