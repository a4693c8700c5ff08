/* SPDX-License-Identifier: MIT
 *
 * Transport matrices of corpora: pictures by the matrix against renderings of the same points. A constant BRDF has no error of
 * interpolation, so that its picture tests the light; a smooth lobe tests how light is distributed to the sampling directions.
 */
#include "label/label.h"
#include "metric/metric.h"
#include "sample/node_grid.h"
#include "support/check.h"
#include "support/predict.h"
#include "support/scenes.h"

#include <omp.h>

enum { POINTS = NQM_TRANSPORT_POINTS, MAX_DIRECTIONS = 2000, N_LIGHTS = 256 };

static const char white[] = "lambert:kd=.8,.5,.2", satin[] = "ggx:kd=.2,.15,.1;ks=1,1,1;alpha=.4;f0=.04",
                  glossy[] = "ggx:kd=.2,.15,.1;ks=1,1,1;alpha=.2;f0=.04";

/* A transport matrix and the scene with its points. */
typedef struct fixture {
    nqm_directions *directions;
    nqm_scene *scene;
    float light[MAX_DIRECTIONS * 3 * POINTS];
    double points[3 * POINTS];
    nqm_transport transport;
} fixture;

static fixture f;

static nqm_scene_options scene_of(const char *light, const char *shape) {
    nqm_scene_options o = nqm_scene_options_default();
    o.light = light;
    o.shape = nqm_tracer_version() || !shape ? shape : "sphere";
    o.n_points = POINTS;
    o.n_lights = 1024; /* as transport.c has for a corpus */
    return o;
}

/* The matrix is of the scene of a corpus with another number of points; fewer lights than a corpus has. */
static void make(const nqm_scene_options *o, size_t n_lights) {
    nqm_scene_options scene = *o;
    scene.n_points = 300;
    scene.n_lights = n_lights;
    assert_int_equal(nqm_node_grid_directions(&f.directions, NULL), NQM_OK);
    assert_true(nqm_directions_get_info(f.directions).n <= MAX_DIRECTIONS);
    f.scene = make_scene(o);
    assert_int_equal(nqm_transport_fill(&scene, POINTS, f.light, f.points, NULL), NQM_OK);
    f.transport = (nqm_transport){nqm_directions_get_info(f.directions).n, f.light, {POINTS, f.points}};
    assert_null(nqm_transport_fault(&f.transport, true));
}

static void drop(void) {
    nqm_directions_free(f.directions);
    nqm_scene_free(f.scene);
}

static float *sample(const char *spec) {
    nqm_brdf *brdf = must_open(spec);
    float *rgb = nqm_alloc(f.transport.n_directions, 3 * sizeof *rgb);
    assert_int_equal(nqm_sample(brdf, f.directions, NQM_INVALID_ZERO, rgb, NULL, NULL, NULL), NQM_OK);
    nqm_brdf_free(brdf);
    return rgb;
}

/* The radiance of a point by the matrix. */
static double light_of(const float *rgb, size_t point, size_t channel) {
    double sum = 0;
    for (size_t k = 0; k < f.transport.n_directions; ++k)
        sum += (double)rgb[3 * k + channel] * (double)f.light[(3 * k + channel) * POINTS + point];
    return sum;
}

/* Sum of the absolute errors of a picture, relative to the sum of the picture. */
static double error_of(const char *spec) {
    float *rgb = sample(spec);
    double *picture = render_spec(f.scene, spec), error = 0, sum = 0;
    for (size_t i = 0; i < POINTS; ++i)
        for (size_t c = 0; c < 3; ++c) {
            error += fabs(light_of(rgb, i, c) - picture[3 * i + c]);
            sum += picture[3 * i + c];
        }
    nqm_free(rgb);
    nqm_free(picture);
    return error / sum;
}

/* The estimated label of a pair against the label of the same points. */
static void check_label(const char *ref, const char *test, double tolerance) {
    float *a = sample(ref), *b = sample(test);
    const nqm_label label = label_specs(f.scene, ref, test), estimate = transport_estimate(&f.transport, a, b, NULL);
    assert_relative(estimate.delta_e, label.delta_e, tolerance);
    assert_near(estimate.shift[0], label.shift[0], tolerance * label.delta_e);
    nqm_free(a);
    nqm_free(b);
}

TEST(a_sphere) {
    const nqm_scene_options o = scene_of("studio", "sphere");
    make(&o, N_LIGHTS);
    for (size_t i = 0; i < POINTS; ++i) {
        assert_near(f.points[3 * i], 1.0 / POINTS, 1e-15);
        assert_true(f.points[3 * i + 1] == 0 && f.points[3 * i + 2] == o.peak_cdm2);
    }
    assert_true(error_of(white) < 0.01);
    assert_true(error_of(satin) < 0.05);
    assert_true(error_of(glossy) < 0.1);
    check_label(white, "lambert:kd=.7,.5,.3", 1e-3);
    check_label(satin, glossy, 0.25);
    drop();
}

/* The scene of the paper has a mesh in several views, seen from the horizon. */
TEST(a_mesh_in_eight_views) {
    nqm_scene_options o = scene_of("interior", "blob");
    o.n_frames = 8;
    o.peak_cdm2 = 500;
    o.interreflection = 1; /* the matrix has none */
    make(&o, N_LIGHTS);
    nqm_scene_free(f.scene);
    o.interreflection = 0;
    f.scene = make_scene(&o);
    double sum = 0;
    for (size_t i = 0; i < POINTS; ++i) {
        sum += f.points[3 * i];
        assert_true(f.points[3 * i + 1] == 0 && f.points[3 * i + 2] == 500);
    }
    assert_near(sum, 1, 1e-9);
    assert_true(error_of(white) < 0.01);
    assert_true(error_of(satin) < 0.05);
    check_label(white, "lambert:kd=.7,.5,.3", 1e-3);
    drop();
}

TEST(the_standard_set) {
    if (!nqm_tracer_version())
        skip();
    const nqm_scene_options o = scene_of(NULL, NULL);
    make(&o, N_LIGHTS);
    double sum[NQM_STANDARD_SCENES] = {0};
    for (size_t i = 0; i < POINTS; ++i) {
        const double number = f.points[3 * i + 1];
        assert_true(number == (double)(i / (POINTS / NQM_STANDARD_SCENES)));
        sum[(size_t)number] += f.points[3 * i];
    }
    for (size_t s = 0; s < NQM_STANDARD_SCENES; ++s)
        assert_near(sum[s], 1, 1e-9);
    assert_true(error_of(white) < 0.01);
    check_label(white, "lambert:kd=.7,.5,.3", 1e-3);
    drop();
}

TEST(the_same_bits_on_any_threads) {
    const nqm_scene_options o = scene_of("sun", "sphere");
    omp_set_num_threads(1);
    make(&o, 64);
    float *before = nqm_alloc(MAX_DIRECTIONS * 3 * POINTS, sizeof *before);
    memcpy(before, f.light, sizeof f.light);
    drop();
    omp_set_num_threads(2);
    make(&o, 64);
    assert_memory_equal(f.light, before, sizeof f.light);
    drop();
    nqm_free(before);
}
