/* SPDX-License-Identifier: MIT
 *
 * The standard set of scenes, and the parts of a label against their definitions.
 */
#include "math/math.h"
#include "metric/metric.h"
#include "percept/percept.h"
#include "render/render.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/scenes.h"
#include <nqm/label.h>

static nqm_label label_in(nqm_scene_options o, const char *ref_spec, const char *test_spec) {
    nqm_scene *scene = make_scene(&o);
    nqm_label label = label_specs(scene, ref_spec, test_spec);
    nqm_scene_free(scene);
    return label;
}

/* ---- the standard set -------------------------------------------------------------------------------------------- */

TEST(set_is_the_mean_of_its_scenes) {
    static const char *const light[] = {"sun", "overcast", "studio", "interior"}, *const shape[] = {"blob", "sphere",
                                                                                                    "sphere", "blob"};
    static const char ref[] = "sgd:nickel", test[] = "ward:nickel";
    nqm_scene_options o = nqm_scene_options_default();
    if (!nqm_tracer_version())
        skip();
    o.n_points = 402; /* 100, 100, 101 and 101 */
    o.n_lights = 64;
    const nqm_label all = label_in(o, ref, test);
    nqm_label sum = {.delta_e = 0};
    for (size_t i = 0; i < 4; ++i) {
        nqm_scene_options one = o;
        one.light = light[i];
        one.shape = shape[i];
        one.n_points = i < 2 ? 100 : 101;
        const nqm_label label = label_in(one, ref, test);
        sum.delta_e += label.delta_e / 4;
        sum.contrast += label.contrast / 4;
        sum.structure += label.structure / 4;
        for (int k = 0; k < 3; ++k)
            sum.shift[k] += label.shift[k] / 4;
    }
    assert_relative(sum.delta_e, all.delta_e, 1e-12);
    assert_near(sum.contrast, all.contrast, 1e-12);
    assert_relative(sum.structure, all.structure, 1e-12);
    for (int k = 0; k < 3; ++k)
        assert_near(sum.shift[k], all.shift[k], 1e-9);
}

TEST(points_and_pixels_of_the_set) {
    nqm_scene_options o = nqm_scene_options_default();
    if (!nqm_tracer_version())
        skip();
    o.n_lights = 16;
    for (int picture = 0; picture < 2; ++picture) {
        o.n_points = picture ? 0 : 50;
        o.width = picture ? 12 : 0;
        o.height = picture ? 10 : 0;
        nqm_scene *scene = make_scene(&o);
        const double *weight = nqm_scene_get_info(scene).weights;
        const size_t n = nqm_scene_get_info(scene).n_points, *pixel = nqm_scene_get_info(scene).pixels;
        double sum = 0, in_frame[4] = {0};
        assert_non_null(weight);
        assert_true(!pixel == !picture);
        for (size_t i = 0; i < n; ++i) {
            sum += weight[i];
            if (pixel) {
                assert_true(pixel[i] < 4 * 120 && (i == 0 || pixel[i] > pixel[i - 1]));
                in_frame[pixel[i] / 120] += weight[i];
            }
        }
        assert_near(sum, 1, 1e-12);
        for (int f = 0; pixel && f < 4; ++f)
            assert_near(in_frame[f], 0.25, 1e-12);
        assert_true(picture || n == 50);
        nqm_scene_free(scene);
    }
    o = nqm_scene_options_default();
    o.n_points = 3;
    expect_no_scene(o, NQM_ERR_ARG);
    o.n_points = 4;
    o.n_lights = 16;
    o.light_width = 16;
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 8) { /* each round draws up to four lights */
        nqm_scene *scene;
        status = nqm_scene_create(&o, &scene, NULL);
        assert_true((status == NQM_OK) == (scene != NULL));
        nqm_scene_free(scene);
    }
}

/* ---- parts ------------------------------------------------------------------------------------------------------- */

/* Two passes over the points, in the terms of the definitions. */
static nqm_label parts_by_definition(const nqm_scene *scene, const double *ref, const double *test, double peak) {
    const size_t n = nqm_scene_get_info(scene).n_points;
    const double *weight = nqm_scene_get_info(scene).weights;
    nqm_label label = {.delta_e = 0};
    double mean[2] = {0}, variance[2] = {0}, rest = 0;
    for (int pass = 0; pass < 2; ++pass)
        for (size_t i = 0; i < n; ++i) {
            const double w = weight ? weight[i] : 1 / (double)n;
            double rgb[2][3], itp[2][3], left = 0;
            for (size_t k = 0; k < 3; ++k) {
                rgb[0][k] = fmin(ref[3 * i + k], peak);
                rgb[1][k] = fmin(test[3 * i + k], peak);
            }
            nqm_itp_from_rgb(rgb[0], itp[0]);
            nqm_itp_from_rgb(rgb[1], itp[1]);
            if (pass == 0) {
                label.delta_e += w * nqm_delta_e_itp(rgb[0], rgb[1]);
                for (int k = 0; k < 3; ++k)
                    label.shift[k] += w * 720 * (itp[1][k] - itp[0][k]);
                for (int j = 0; j < 2; ++j)
                    mean[j] += w * 720 * itp[j][0];
                continue;
            }
            for (int k = 0; k < 3; ++k)
                left += pow(720 * (itp[1][k] - itp[0][k]) - label.shift[k], 2);
            rest += w * left;
            for (int j = 0; j < 2; ++j)
                variance[j] += w * pow(720 * itp[j][0] - mean[j], 2);
        }
    label.contrast = log((1 + sqrt(variance[1])) / (1 + sqrt(variance[0])));
    label.structure = sqrt(rest);
    return label;
}

TEST(parts_follow_their_definitions) {
    static const char *const pairs[][2] = {{"sgd:nickel", "ward:nickel"},
                                           {"lambert:kd=0", "lambert:kd=.5"},
                                           {"sgd:red-plastic", "perturb:gloss=.5;tint=1.2,.9,1;of=sgd:red-plastic"}};
    static const char *const lights[] = {"sun", "studio"};
    for (size_t l = 0; l < 2; ++l) {
        nqm_scene_options o = nqm_scene_options_default();
        o.light = lights[l];
        o.shape = l == 0 && nqm_tracer_version() ? "blob" : "sphere";
        o.n_points = 120;
        o.n_lights = 64;
        nqm_scene *scene = make_scene(&o);
        for (size_t i = 0; i < sizeof pairs / sizeof *pairs; ++i) {
            double *ref = render_spec(scene, pairs[i][0]), *test = render_spec(scene, pairs[i][1]);
            const nqm_label label = nqm_scene_compare(scene, ref, test, NULL),
                            expected = parts_by_definition(scene, ref, test, o.peak_cdm2);
            assert_relative(label.delta_e, expected.delta_e, 1e-12);
            for (int k = 0; k < 3; ++k)
                assert_near(label.shift[k], expected.shift[k], 1e-9);
            assert_near(label.contrast, expected.contrast, 1e-9);
            assert_relative(label.structure, expected.structure, 1e-9);
            nqm_free(ref);
            nqm_free(test);
        }
        nqm_scene_free(scene);
    }
}

TEST(signs_of_the_parts) {
    nqm_scene_options o = nqm_scene_options_default();
    o.light = "overcast";
    o.n_points = 200;
    o.n_lights = 64;
    const nqm_label bright = label_in(o, "lambert:kd=.2", "lambert:kd=.4"),
                    blue = label_in(o, "lambert:kd=.2", "lambert:kd=.2,.2,.3"),
                    red = label_in(o, "lambert:kd=.2", "lambert:kd=.3,.2,.2"),
                    glossy = label_in(o, "lambert:kd=.2", "ggx:kd=.2;ks=1;alpha=.05;f0=.3"),
                    flat = label_in(o, "ggx:kd=.2;ks=1;alpha=.05;f0=.3", "lambert:kd=.2"),
                    equal = label_in(o, "sgd:nickel", "sgd:nickel");
    assert_true(bright.shift[0] > 10 && fabs(bright.shift[1]) < 3 && fabs(bright.shift[2]) < 3);
    assert_true(bright.structure < bright.shift[0] / 5);
    assert_true(blue.shift[1] > 3 && red.shift[2] > 3);
    assert_true(glossy.contrast > 0.05);
    assert_near(flat.contrast, -glossy.contrast, 1e-12);
    assert_near(flat.shift[0], -glossy.shift[0], 1e-9);
    assert_true(equal.delta_e == 0 && equal.contrast == 0 && equal.structure == 0);
    for (int k = 0; k < 3; ++k)
        assert_true(equal.shift[k] == 0);
    /* Apart, a change of brightness matters less than beside each other; a change of gloss matters about as much. */
    const nqm_curve curve = nqm_curve_published;
    assert_true(nqm_label_adapted_jod(&equal) == 10);
    assert_true(nqm_label_adapted_jod(&bright) > nqm_curve_jod(&curve, bright.delta_e) + 1);
    assert_true(nqm_label_adapted_jod(&glossy) < nqm_label_adapted_jod(&bright));
    const nqm_label known = {.shift = {2, -6, 9}, .structure = 3};
    assert_near(nqm_label_adapted_jod(&known), nqm_curve_jod(&curve, sqrt(9 + 0.0225 * 121)), 1e-12);
}

/* ---- the bound on Delta-E from samples ---------------------------------------------------------------------------- */

TEST(labels_keep_to_the_bound) {
    static const char *const refs[] = {"sgd:nickel", "sgd:chrome", "sgd:pink-felt",
                                       "ggx:kd=.5,.02,.02;ks=1;alpha=.3;f0=.04"};
    static const char *const changes[] = {"bits=20", "bits=7",  "half=1",         "scale=1.02", "tint=1.05,1,.96",
                                          "hue=4",   "mix=.02", "desaturate=.08", "noise=.05",  "fresnel=1.1"};
    nqm_scene_options o = nqm_scene_options_default();
    if (!nqm_tracer_version())
        o.light = "sun";
    o.n_points = 240;
    o.n_lights = 32;
    nqm_scene *scene = make_scene(&o);
    nqm_directions *directions;
    assert_int_equal(nqm_directions_create(NULL, 0, NULL, &directions, NULL), NQM_OK);
    const size_t n = nqm_directions_get_info(directions).n;
    float *samples = nqm_alloc(6 * n, sizeof *samples);
    uint8_t *used = nqm_alloc(n, 1);
    size_t n_bounded = 0;
    for (size_t r = 0; r < 4; ++r) {
        double *ref_picture = render_spec(scene, refs[r]);
        for (size_t c = 0; c < 10; ++c) {
            char spec[200];
            snprintf(spec, sizeof spec, "perturb:%s;of=%s", changes[c], refs[r]);
            nqm_brdf *ref = must_open(refs[r]), *test = must_open(spec);
            assert_int_equal(nqm_sample(ref, directions, NQM_INVALID_ZERO, samples, used, NULL, NULL), NQM_OK);
            assert_int_equal(nqm_sample(test, directions, NQM_INVALID_ZERO, samples + 3 * n, used, NULL, NULL), NQM_OK);
            double bound = nqm_delta_e_bound(n, &(nqm_sample_pair){samples, samples + 3 * n, NULL});
            double *picture = render_spec(scene, spec);
            double delta_e = nqm_scene_compare(scene, ref_picture, picture, NULL).delta_e;
            assert_true(delta_e <= bound + 1e-9);
            n_bounded += isfinite(bound);
            nqm_free(picture);
            nqm_brdf_free(ref);
            nqm_brdf_free(test);
        }
        nqm_free(ref_picture);
    }
    assert_true(n_bounded >= 24);
    assert_true(isinf(nqm_delta_e_bound(1, &(nqm_sample_pair){(float[]){1, 1, 1}, (float[]){1, 2, 1}, NULL})));
    assert_near(nqm_delta_e_bound(1, &(nqm_sample_pair){(float[]){1, 1, 1}, (float[]){1, 1.1F, 1}, NULL}),
                165 * log(1.100005 / 1.000005), 1e-4);
    assert_near(nqm_delta_e_bound(
                    2, &(nqm_sample_pair){(float[]){1, 1, 1, 0, 0, 0}, (float[]){1, 1, 1, 9, 9, 9}, (uint8_t[]){1, 0}}),
                0, 0);
    nqm_free(samples);
    nqm_free(used);
    nqm_directions_free(directions);
    nqm_scene_free(scene);
}

TEST(words_for_the_parts) {
    const nqm_label none = {.delta_e = 0.4, .shift = {0.4, -0.3, 0}, .contrast = 0.01, .structure = 0.5},
                    some = {.shift = {-4, 0, 1.5}, .contrast = -0.5, .structure = 0.2},
                    near = {.delta_e = 5.9 /* JOD 9.50 */, .shift = {-4, 0, 1.5}, .contrast = 0.2, .structure = 11},
                    hardly = {.delta_e = 8 /* JOD 9.2 */, .shift = {-4, 0, 1.5}, .contrast = -0.5, .structure = 11},
                    all = {.shift = {-1e9, 1e9, -1e9}, .contrast = 1e9, .structure = 1e9};
    assert_string_equal(nqm_label_get_info(&none).words, "no visible difference");
    assert_string_equal(nqm_label_get_info(&some).words, "darker, a little redder, much flatter");
    assert_string_equal(nqm_label_get_info(&near).words, "a little darker, a little redder, a little more contrast, "
                                                         "a little changed in highlights and shading");
    assert_string_equal(nqm_label_get_info(&hardly).words,
                        "darker, a little redder, flatter, changed in highlights and shading");
    assert_string_equal(nqm_label_get_info(&all).words, "much darker, much bluer, much greener, much more contrast, "
                                                        "much changed in highlights and shading");
}

TEST(errors_of_scenes_are_independent) {
    const nqm_label scene = {.delta_e = 2, .error = 0.3}, other = {.delta_e = 4, .error = 0.4};
    nqm_label mean = {.delta_e = 0};
    nqm_label_add(&mean, 0.5, &scene);
    nqm_label_add(&mean, 0.5, &other);
    assert_near(mean.delta_e, 3, 0);
    assert_near(mean.error, 0.25, 1e-15);
}
