/* SPDX-License-Identifier: MIT
 *
 * Random pictures: their mean over seeds against renderings, Delta-E against the label of the whole scene, its gradient against
 * central differences, equal BRDFs, independence of threads, faults.
 */
#include "base/base.h"
#include "support/allocations.h"
#include "support/central.h"
#include "support/check.h"
#include "support/scenes.h"
#include <nqm/label.h>

#include <omp.h>

enum { N_RAYS = 2048 };

static const char white[] = "lambert:kd=.8,.5,.2", satin[] = "ggx:kd=.2,.15,.1;ks=1,1,1;alpha=.2;f0=.04",
                  dull[] = "ggx:kd=.25,.15,.1;ks=1,1,1;alpha=.3;f0=.04";

static nqm_scene *make(const char *light, const char *shape) {
    nqm_scene_options o = nqm_scene_options_default();
    o.light = light;
    o.shape = shape;
    o.n_points = 400;
    o.n_lights = 256;
    return make_scene(&o);
}

static nqm_rays draw(const nqm_scene *scene, size_t n, uint64_t seed) {
    nqm_rays rays;
    assert_int_equal(nqm_rays_draw(scene, n, seed, &rays, NULL), NQM_OK);
    assert_true(rays.n > 0 && rays.n <= n);
    return rays;
}

static double *eval(const nqm_rays *rays, const char *spec) {
    nqm_brdf *brdf = must_open(spec);
    double *rgb = nqm_alloc(rays->n, 3 * sizeof *rgb);
    assert_non_null(rgb);
    nqm_brdf_eval(brdf, rays->n, rays->wi, rays->wo, rgb, NULL);
    nqm_brdf_free(brdf);
    return rgb;
}

/* Mean light of a picture in each channel, a mean over its scenes. */
static void mean_of_rays(const nqm_rays *rays, const char *spec, double *mean) {
    double *f = eval(rays, spec);
    const double n_scenes = 1 + rays->points[3 * rays->n_points - 2];
    for (size_t i = 0; i < 3 * rays->n; ++i)
        mean[i % 3] += rays->points[3 * rays->point[i / 3]] * rays->weight[i] * f[i] / n_scenes;
    nqm_free(f);
}

static void mean_of_scene(const nqm_scene *scene, const char *spec, double *mean) {
    const size_t n = nqm_scene_get_info(scene).n_points;
    const double *weights = nqm_scene_get_info(scene).weights;
    double *rgb = render_spec(scene, spec);
    for (size_t i = 0; i < 3 * n; ++i)
        mean[i % 3] += (weights ? weights[i / 3] : 1 / (double)n) * rgb[i];
    nqm_free(rgb);
}

static nqm_label compare(const nqm_rays *rays, const double *ref, const double *test, double *gradient) {
    nqm_label label;
    assert_int_equal(nqm_rays_compare(rays, ref, test, &label, gradient, NULL), NQM_OK);
    return label;
}

/* ---- pictures ----------------------------------------------------------------------------------------------------- */

TEST(the_mean_over_seeds_is_the_picture) {
    enum { N_SEEDS = 400 };
    nqm_scene *scenes[] = {make("studio", "sphere"), make(NULL, NULL)};
    for (size_t s = 0; s < (nqm_tracer_version() ? 2 : 1); ++s) {
        double mean[2][3] = {{0}}, expected[2][3] = {{0}}, delta_e = 0;
        mean_of_scene(scenes[s], white, expected[0]);
        mean_of_scene(scenes[s], satin, expected[1]);
        for (uint64_t seed = 0; seed < N_SEEDS; ++seed) {
            nqm_rays rays = draw(scenes[s], N_RAYS, seed);
            double *ref = eval(&rays, satin), *test = eval(&rays, dull);
            mean_of_rays(&rays, white, mean[0]);
            mean_of_rays(&rays, satin, mean[1]);
            delta_e += compare(&rays, ref, test, NULL).delta_e / N_SEEDS;
            nqm_free(ref);
            nqm_free(test);
            nqm_rays_clear(&rays);
        }
        for (size_t i = 0; i < 6; ++i)
            assert_relative(mean[i / 3][i % 3] / N_SEEDS, expected[i / 3][i % 3], 0.01);
        assert_relative(delta_e, label_specs(scenes[s], satin, dull).delta_e, 0.02);
        nqm_scene_free(scenes[s]);
    }
}

TEST(rays_are_unit_vectors_above_the_horizon) {
    nqm_scene *scene = make("sun", "sphere");
    nqm_rays rays = draw(scene, N_RAYS, 3);
    double azimuths = 0;
    for (size_t i = 0; i < rays.n; ++i) {
        const double *v[] = {rays.wi + 3 * i, rays.wo + 3 * i};
        for (size_t k = 0; k < 2; ++k) {
            assert_near(v[k][0] * v[k][0] + v[k][1] * v[k][1] + v[k][2] * v[k][2], 1, 1e-12);
            assert_true(v[k][2] > 0);
        }
        assert_true(rays.point[i] < rays.n_points && (i == 0 || rays.point[i] >= rays.point[i - 1]));
        azimuths += v[1][0] / (double)rays.n;
    }
    assert_near(azimuths, 0, 0.3);
    nqm_rays_clear(&rays);
    nqm_scene_free(scene);
}

/* Fewer points than the rays are meant for. */
TEST(few_points_have_more_directions) {
    nqm_scene_options o = nqm_scene_options_default();
    o.shape = "sphere";
    o.n_points = 3;
    nqm_scene *scene = make_scene(&o);
    nqm_rays rays = draw(scene, N_RAYS, 3);
    assert_int_equal(rays.n_points, 3);
    assert_true(rays.n > N_RAYS / 2);
    nqm_rays_clear(&rays);
    nqm_scene_free(scene);
}

TEST(threads_and_seeds) {
    nqm_scene *scene = make("studio", "sphere");
    nqm_rays rays[3];
    const int n_threads = omp_get_max_threads();
    for (int i = 0; i < 3; ++i) {
        omp_set_num_threads(i == 1 ? 2 : 1);
        rays[i] = draw(scene, N_RAYS, i < 2 ? 5 : 6);
    }
    omp_set_num_threads(n_threads);
    assert_int_equal(rays[0].n, rays[1].n);
    assert_memory_equal(rays[0].wi, rays[1].wi, rays[0].n * 3 * sizeof(double));
    assert_memory_equal(rays[0].weight, rays[1].weight, rays[0].n * 3 * sizeof(double));
    assert_memory_not_equal(rays[0].wi, rays[2].wi, 30 * sizeof(double));
    for (int i = 0; i < 3; ++i)
        nqm_rays_clear(&rays[i]);
    nqm_scene_free(scene);
}

/* ---- Delta-E ------------------------------------------------------------------------------------------------------ */

TEST(equal_values_give_zero) {
    nqm_scene *scene = make("studio", "sphere");
    nqm_rays rays = draw(scene, N_RAYS, 1);
    double *f = eval(&rays, satin), *gradient = nqm_alloc(rays.n, 3 * sizeof *gradient);
    assert_true(compare(&rays, f, f, gradient).delta_e == 0);
    for (size_t i = 0; i < 3 * rays.n; ++i)
        assert_true(gradient[i] == 0);
    nqm_free(f);
    nqm_free(gradient);
    nqm_rays_clear(&rays);
    nqm_scene_free(scene);
}

/* Every 37th value by itself, by differences of order 4. */
TEST(gradients_are_those_of_differences) {
    nqm_scene *scene = make(nqm_tracer_version() ? NULL : "studio", nqm_tracer_version() ? NULL : "sphere");
    nqm_rays rays = draw(scene, N_RAYS, 1);
    double *ref = eval(&rays, satin), *test = eval(&rays, dull), *gradient = nqm_alloc(rays.n, 3 * sizeof *gradient);
    (void)compare(&rays, ref, test, gradient);
    for (size_t i = 0; i < 3 * rays.n; i += 37) {
        double expected;
        CENTRAL_DIFFERENCE(expected, test[i], 1e-4 * (test[i] + 1e-3), compare(&rays, ref, test, NULL).delta_e);
        assert_near(expected, gradient[i], 1e-6 + 1e-5 * fabs(gradient[i]));
    }
    nqm_free(ref);
    nqm_free(test);
    nqm_free(gradient);
    nqm_rays_clear(&rays);
    nqm_scene_free(scene);
}

/* ---- faults ------------------------------------------------------------------------------------------------------- */

TEST(faults) {
    nqm_scene *scene = make("studio", "sphere");
    nqm_error err = {0};
    nqm_rays rays = draw(scene, N_RAYS, 1), none;
    nqm_label label;
    double *f = eval(&rays, white), *g = eval(&rays, satin);
    assert_int_equal(nqm_rays_draw(scene, 15, 1, &none, &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "16"));
    assert_int_equal(nqm_rays_draw(scene, SIZE_MAX, 1, &none, &err), NQM_ERR_ARG);
    assert_true(!none.wi && none.n == 0);
    nqm_rays_clear(&none);
    f[3 * 7 + 1] = NAN;
    assert_int_equal(nqm_rays_compare(&rays, g, f, &label, NULL, &err), NQM_ERR_NUMERIC);
    assert_string_equal(err.message, "the test has no finite value at ray 7");
    assert_int_equal(nqm_rays_compare(&rays, f, g, &label, NULL, &err), NQM_ERR_NUMERIC);
    assert_non_null(strstr(err.message, "reference"));
    nqm_free(f);
    nqm_free(g);
    nqm_rays_clear(&rays);
    nqm_scene_free(scene);
}

TEST(memory_runs_out) {
    nqm_scene *scene = make("studio", "sphere");
    nqm_rays rays = draw(scene, 256, 1);
    double *f = eval(&rays, satin);
    for (int of_drawing = 0; of_drawing < 2; ++of_drawing) {
        nqm_status status = NQM_OK;
        long n = -1;
        EVERY_ALLOCATION(n, status, 0) {
            nqm_rays drawn = {.n = 0};
            nqm_label label;
            nqm_error err = {0};
            status = of_drawing ? nqm_rays_draw(scene, 256, 1, &drawn, &err)
                                : nqm_rays_compare(&rays, f, f, &label, NULL, &err);
            assert_true(status == NQM_OK || (err.status == NQM_ERR_NOMEM && !drawn.wi));
            nqm_rays_clear(&drawn);
        }
    }
    nqm_free(f);
    nqm_rays_clear(&rays);
    nqm_scene_free(scene);
}
