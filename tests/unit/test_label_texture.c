/* SPDX-License-Identifier: MIT
 *
 * Pictures and labels of textured materials: against those of BRDFs where the texture is constant, against the mean of the points
 * where it is not, and against `tilt:` where its normal leans.
 */
#include "base/memory_test.h"
#include "label/label.h"
#include "label/textured.h"
#include "math/math.h"
#include "support/check.h"
#include "support/scenes.h"

static nqm_texture *make_texture(const char *base, const char *key, size_t height, size_t width, size_t channels,
                                 const float *values) {
    const nqm_texture_map map = {key, height, width, channels, values};
    nqm_texture *texture;
    nqm_error err = {0};
    if (nqm_texture_create(base, key ? 1 : 0, &map, &texture, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return texture;
}

static double *render_texture(const nqm_scene *scene, const nqm_texture *texture, const nqm_texture_view *view) {
    double *rgb = nqm_alloc(nqm_scene_get_info(scene).n_points, 9 * sizeof *rgb);
    nqm_error err = {0};
    assert_non_null(rgb);
    if (nqm_scene_render_texture(scene, texture, view, rgb, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return rgb;
}

/* A texture with one map, which is freed. */
static double *render_map(const nqm_scene *scene, const char *base, const char *key, size_t width, size_t channels,
                          const float *values, const nqm_texture_view *view) {
    nqm_texture *texture = make_texture(base, key, 1, width, channels, values);
    double *rgb = render_texture(scene, texture, view);
    nqm_texture_free(texture);
    return rgb;
}

static double *render_halves(const nqm_scene *scene, const char *spec) {
    nqm_brdf *brdf = must_open(spec);
    double *rgb = nqm_alloc(nqm_scene_get_info(scene).n_points, 9 * sizeof *rgb);
    assert_non_null(rgb);
    assert_int_equal(nqm_scene_render(scene, brdf, 1, rgb, NULL, NULL), NQM_OK);
    nqm_brdf_free(brdf);
    return rgb;
}

static nqm_scene *small_scene(const char *shape, size_t width) {
    nqm_scene_options o = nqm_scene_options_default();
    o.light = "studio";
    o.shape = nqm_tracer_version() ? shape : "sphere";
    o.n_points = 512;
    o.width = o.height = width;
    o.n_lights = 64;
    return make_scene(&o);
}

/* ---- texture coordinates ------------------------------------------------------------------------------------------- */

/* The definition, by the point's normal, which a sphere has in the direction of the position. */
TEST(test_texcoord_of_spheres) {
    for (size_t width = 0; width <= 32; width += 32) {
        nqm_scene *scene = small_scene("sphere", width);
        for (size_t i = 0; i < nqm_scene_get_info(scene).n_points; ++i) {
            nqm_surface_point made;
            const nqm_surface_point *point = nqm_scene_point(scene, i, &made);
            const double *n = point->frame + 6, none[2] = {0, 0};
            double uv[2];
            nqm_scene_texcoord(scene, i, none, uv);
            const double s = sin(NQM_PI * uv[1]), phi = 2 * NQM_PI * (uv[0] - 0.5);
            const double direction[3] = {s * sin(phi), cos(NQM_PI * uv[1]), s * cos(phi)};
            assert_true(nqm_dot3(direction, n) >
                        (width ? 0.99 : 1 - 1e-12)); /* normals at the edge are turned to the viewer */
        }
        nqm_scene_free(scene);
    }
}

/* The tangent is the direction of growing u, the bitangent that of falling v: steps to the right and up in the middle
 * of the picture. */
TEST(test_texcoord_directions) {
    nqm_scene *scene = small_scene("sphere", 33);
    const size_t *pixel = nqm_scene_get_info(scene).pixels;
    const double at[3][2] = {{0, 0}, {1, 0}, {0, 1}};
    for (size_t i = 0; i < nqm_scene_get_info(scene).n_points; ++i)
        if (pixel[i] == 16 * 33 + 16) {
            double uv[3][2], side = 2.0 / 33;
            for (size_t k = 0; k < 3; ++k)
                nqm_scene_texcoord(scene, i, at[k], uv[k]);
            assert_near(uv[0][0], 0.5, 1e-9);
            assert_near(uv[0][1], 0.5, 1e-9);
            assert_near(uv[1][0] - uv[0][0], atan(side / 0.9) / (2 * NQM_PI), 1e-9);
            assert_near(uv[2][1] - uv[0][1], -atan(side / 0.9) / NQM_PI, 1e-9);
            nqm_surface_point made;
            const nqm_surface_point *point = nqm_scene_point(scene, i, &made);
            double tangent[3] = {1, 0, 0}, back[2] = {-point->tangent[0], point->tangent[1]}, world[3];
            nqm_turn3(back, tangent, tangent);
            nqm_world_from_local(point, tangent, world);
            assert_near(world[0], 1, 1e-9);
        }
    nqm_scene_free(scene);
}

/* Neighbouring footprints meet: the positions of a pixel's right edge are those of the left edge of the next. */
TEST(test_footprints_meet) {
    nqm_scene *scene = small_scene("blob", 64);
    const size_t *pixel = nqm_scene_get_info(scene).pixels, n = nqm_scene_get_info(scene).n_points;
    const double right[2] = {0.5, 0}, left[2] = {-0.5, 0};
    size_t n_near = 0, n_all = 0;
    for (size_t i = 0; i + 1 < n; ++i)
        if (pixel[i + 1] == pixel[i] + 1) {
            double a[2], b[2], c[2], d[2];
            nqm_scene_texcoord(scene, i, right, a);
            nqm_scene_texcoord(scene, i + 1, left, b);
            nqm_scene_texcoord(scene, i, left, c);
            nqm_scene_texcoord(scene, i + 1, right, d);
            n_near += hypot(a[0] - b[0], a[1] - b[1]) < 0.15 * hypot(c[0] - d[0], c[1] - d[1]);
            ++n_all;
        }
    assert_true(n_near > 0.9 * (double)n_all);
    nqm_scene_free(scene);
}

/* ---- constant textures --------------------------------------------------------------------------------------------- */

TEST(test_constant_is_the_brdf) {
    static const char *const specs[] = {"gltf:base_color=.5,.3,.1;roughness=.3",
                                        "gltf:metallic=1;roughness=.4;anisotropy_strength=.8"};
    const nqm_texture_view views[] = {nqm_scene_texture_view_default(), {.tiles = 3.5, .n_samples = 7}};
    for (size_t k = 0; k < 4; ++k) {
        nqm_scene *scene = small_scene(k / 2 ? "blob" : "sphere", k == 3 ? 16 : 0);
        const char *spec = specs[k % 2];
        nqm_texture *texture = make_texture(spec, NULL, 0, 0, 0, NULL);
        double *expected = render_halves(scene, spec), *rgb = render_texture(scene, texture, &views[k / 2]);
        assert_memory_equal(rgb, expected, 9 * nqm_scene_get_info(scene).n_points * sizeof *rgb);
        nqm_free(expected);
        nqm_free(rgb);
        nqm_texture_free(texture);
        nqm_scene_free(scene);
    }
}

TEST(test_standard_scenes) {
    if (!nqm_tracer_version())
        skip();
    nqm_scene_options o = nqm_scene_options_default();
    o.n_points = 256;
    o.n_lights = 32;
    nqm_scene *scene = make_scene(&o);
    const float roughness[] = {0.25F, 0.25F};
    double *rgb = render_map(scene, "gltf:metallic=1", "roughness", 2, 1, roughness, NULL);
    double *expected = render_halves(scene, "gltf:metallic=1;roughness=.25");
    assert_memory_equal(rgb, expected, 9 * nqm_scene_get_info(scene).n_points * sizeof *rgb);
    nqm_free(expected);
    nqm_free(rgb);
    nqm_scene_free(scene);
}

/* ---- textures that vary -------------------------------------------------------------------------------------------- */

/* Without filter, each point has the light of its half; the label is the mean over the points of both labels. */
TEST(test_halves_by_points) {
    nqm_scene *scene = small_scene("sphere", 0);
    const size_t n = nqm_scene_get_info(scene).n_points;
    const float values[] = {0.25F, 0.5F};
    const nqm_texture_view view = {.tiles = 1, .n_samples = 1};
    double *rgb = render_map(scene, "gltf:metallic=1", "roughness", 2, 1, values, &view);
    double *ref = render_halves(scene, "gltf:metallic=1;roughness=.4"), *delta_e = nqm_alloc(3 * n, sizeof *delta_e);
    assert_non_null(delta_e);
    double *of[2] = {render_halves(scene, "gltf:metallic=1;roughness=.25"),
                     render_halves(scene, "gltf:metallic=1;roughness=.5")};
    double mean = 0;
    for (size_t k = 0; k < 2; ++k)
        nqm_scene_compare(scene, ref, of[k], delta_e + k * n);
    for (size_t i = 0; i < n; ++i) {
        const double none[2] = {0, 0};
        double uv[2];
        nqm_scene_texcoord(scene, i, none, uv);
        const size_t half = uv[0] >= 0.5;
        assert_memory_equal(rgb + 3 * i, of[half] + 3 * i, 3 * sizeof *rgb);
        mean += delta_e[half * n + i] / (double)n;
    }
    assert_near(nqm_scene_compare(scene, ref, rgb, NULL).delta_e, mean, 1e-9 * mean);
    for (size_t k = 0; k < 2; ++k)
        nqm_free(of[k]);
    nqm_free(delta_e);
    nqm_free(ref);
    nqm_free(rgb);
    nqm_scene_free(scene);
}

/* A coarse texture that is compared with a finer one is interpolated at the centres of the finer texels; without it, it is not. */
TEST(test_positions_of_a_pair) {
    nqm_scene *scene = small_scene("sphere", 0);
    const size_t n_bytes = 9 * nqm_scene_get_info(scene).n_points * sizeof(double);
    const float coarse[] = {0.25F, 0.5F}, fine[] = {0.3125F, 0.25F, 0.25F, 0.3125F, 0.4375F, 0.5F, 0.5F, 0.4375F};
    nqm_texture *finer = make_texture("gltf:metallic=1", "roughness", 1, 8, 1, fine);
    const nqm_texture_view own = {.tiles = 2, .n_samples = 1}, paired = {.tiles = 2, .n_samples = 1, .beside = finer};
    double *a = render_map(scene, "gltf:metallic=1", "roughness", 2, 1, coarse, &own);
    double *b = render_map(scene, "gltf:metallic=1", "roughness", 2, 1, coarse, &paired);
    const float as_seen[] = {0.34375F, 0.28125F, 0.28125F, 0.34375F, 0.40625F, 0.46875F, 0.46875F, 0.40625F};
    double *c = render_map(scene, "gltf:metallic=1", "roughness", 8, 1, as_seen, &own);
    assert_memory_not_equal(a, b, n_bytes);
    assert_memory_equal(b, c, n_bytes);
    double *pictures[] = {a, b, c};
    for (size_t k = 0; k < 3; ++k)
        nqm_free(pictures[k]);
    nqm_texture_free(finer);
    nqm_scene_free(scene);
}

/* From afar, each point has the mean light of the texels, but for the noise of their choice. */
TEST(test_far_is_the_mean) {
    nqm_scene *scene = small_scene("sphere", 0);
    const size_t n = nqm_scene_get_info(scene).n_points;
    const float values[] = {0.125F, 0.75F};
    double *a = render_halves(scene, "gltf:metallic=1;roughness=.125"),
           *b = render_halves(scene, "gltf:metallic=1;roughness=.75");
    double *mean = nqm_alloc(9 * n, sizeof *mean), error[2];
    assert_non_null(mean);
    for (size_t i = 0; i < 9 * n; ++i)
        mean[i] = (a[i] + b[i]) / 2;
    for (size_t k = 0; k < 2; ++k) {
        const nqm_texture_view far = {.tiles = 1024, .n_samples = k ? 256 : 64};
        double *rgb = render_map(scene, "gltf:metallic=1", "roughness", 2, 1, values, &far);
        error[k] = nqm_scene_compare(scene, mean, rgb, NULL).delta_e;
        nqm_free(rgb);
    }
    const double apart = nqm_scene_compare(scene, mean, a, NULL).delta_e;
    assert_true(error[0] < 0.06 * apart && error[1] < 0.6 * error[0]);
    nqm_free(a);
    nqm_free(b);
    nqm_free(mean);
    nqm_scene_free(scene);
}

/* ---- normals ------------------------------------------------------------------------------------------------------- */

/* A normal map of one value shows what tilt: shows, also of an anisotropic BRDF; but for the noise of the light directions, whose
 * lobe `tilt:` measures. */
TEST(test_normal_is_tilt) {
    static const float normals[2][3] = {{0.1F, 0, 1}, {-0.1F, 0.2F, 1}};
    static const char *const bases[] = {"gltf:base_color=.6,.4,.2;roughness=.35;metallic=1",
                                        "gltf:base_color=.6,.4,.2;roughness=.5;anisotropy_strength=.7;metallic=1"};
    nqm_scene_options o = studio_scene();
    o.n_points = 256;
    o.n_lights = 512;
    nqm_scene *scene = make_scene(&o);
    for (size_t k = 0; k < 4; ++k) {
        const double x = (double)normals[k / 2][0], y = (double)normals[k / 2][1], degree = NQM_PI / 180;
        char spec[200];
        snprintf(spec, sizeof spec, "tilt:deg=%.12g;azimuth=%.12g;of=%s", atan(hypot(x, y)) / degree,
                 atan2(y, x) / degree, bases[k % 2]);
        double *rgb = render_map(scene, bases[k % 2], "normal", 1, 3, normals[k / 2], NULL);
        double *expected = render_halves(scene, spec), *flat = render_halves(scene, bases[k % 2]);
        const double error = nqm_scene_compare_halves(scene, expected, rgb).delta_e;
        const double change = nqm_scene_compare_halves(scene, flat, rgb).delta_e;
        print_message("%s: %g, change %g, of tilt: %g\n", spec, error, change,
                      nqm_scene_compare_halves(scene, flat, expected).delta_e);
        assert_true(error < 0.03 * change);
        assert_relative(change, nqm_scene_compare_halves(scene, flat, expected).delta_e, 0.02);
        nqm_free(rgb);
        nqm_free(expected);
        nqm_free(flat);
    }
    nqm_scene_free(scene);
}

/* Normals to the side of the surface and below it give black or light, never a value that is not finite. */
TEST(test_steep_normals) {
    static const float normals[] = {1, 0, 0, 0, 1, -1, -0.5F, 0.5F, 0.01F};
    nqm_scene *scene = small_scene("sphere", 0);
    double *rgb = render_map(scene, "gltf:roughness=.3", "normal", 3, 3, normals, NULL);
    for (size_t i = 0; i < 9 * nqm_scene_get_info(scene).n_points; ++i)
        assert_true(rgb[i] >= 0 && rgb[i] < 1e6);
    nqm_free(rgb);
    nqm_scene_free(scene);
}

/* ---- failures ------------------------------------------------------------------------------------------------------ */

TEST(test_threads) {
    nqm_scene *scene = small_scene("blob", 0);
    static const float normals[] = {0.1F, 0, 1, 0, 0, 1, 0, -0.3F, 1};
    double *many = render_map(scene, "gltf:metallic=1", "normal", 3, 3, normals, NULL);
    const int limit = nqm_limit_threads(1);
    double *one = render_map(scene, "gltf:metallic=1", "normal", 3, 3, normals, NULL);
    (void)nqm_limit_threads(limit);
    assert_memory_equal(one, many, 9 * nqm_scene_get_info(scene).n_points * sizeof *one);
    nqm_free(one);
    nqm_free(many);
    nqm_scene_free(scene);
}

TEST(test_refused_arguments) {
    nqm_scene_options o = studio_scene();
    nqm_texture *texture = make_texture("gltf:metallic=1", NULL, 0, 0, 0, NULL);
    const nqm_texture_view bad[] = {{.tiles = 0, .n_samples = 1},
                                    {.tiles = (double)NAN, .n_samples = 1},
                                    {.tiles = 1, .n_samples = 0},
                                    {.tiles = 1, .n_samples = 5000}};
    double rgb[9 * 16];
    o.n_points = 16;
    nqm_scene *scene = make_scene(&o);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i)
        assert_int_equal(nqm_scene_render_texture(scene, texture, &bad[i], rgb, NULL), NQM_ERR_ARG);
    assert_int_equal(nqm_scene_render_texture(scene, NULL, NULL, rgb, NULL), NQM_ERR_ARG);
    nqm_scene_free(scene);
    o.interreflection = 1;
    scene = make_scene(&o);
    assert_int_equal(nqm_scene_render_texture(scene, texture, NULL, rgb, NULL), NQM_ERR_ARG);
    nqm_scene_free(scene);
    nqm_texture_free(texture);
}

static int stop_render(void *user, const char *stage, double done, double total) {
    (void)user, (void)done, (void)total;
    return strcmp(stage, "render") == 0;
}

TEST(test_cancel) {
    nqm_scene_options o = studio_scene();
    o.n_points = 512;
    o.progress = stop_render;
    nqm_scene *scene = make_scene(&o);
    nqm_texture *texture = make_texture("gltf:metallic=1", NULL, 0, 0, 0, NULL);
    double *rgb = nqm_alloc(9 * o.n_points, sizeof *rgb);
    const nqm_texture_view view = {.tiles = 1, .n_samples = 64};
    assert_non_null(rgb);
    assert_int_equal(nqm_scene_render_texture(scene, texture, &view, rgb, NULL), NQM_ERR_CANCELLED);
    nqm_free(rgb);
    nqm_texture_free(texture);
    nqm_scene_free(scene);
}

/* The memory checker finds what a failed allocation leaks. */
TEST(test_out_of_memory) {
    nqm_scene_options o = studio_scene();
    const float normal[] = {0.1F, 0, 1};
    double rgb[9 * 16];
    o.n_points = 16;
    o.n_lights = 16;
    nqm_scene *scene = make_scene(&o);
    nqm_texture *texture = make_texture("gltf:metallic=1", "normal", 1, 1, 3, normal);
    const nqm_texture_view view = {.tiles = 1, .n_samples = 1};
    const int limit = nqm_limit_threads(1);
    const long before = nqm_alloc_count();
    assert_int_equal(nqm_scene_render_texture(scene, texture, &view, rgb, NULL), NQM_OK);
    const long n = nqm_alloc_count() - before;
    assert_true(n > 16);
    for (long k = 0; k < n; ++k) {
        nqm_alloc_fail_after(k);
        assert_int_equal(nqm_scene_render_texture(scene, texture, &view, rgb, NULL), NQM_ERR_NOMEM);
        nqm_alloc_fail_after(-1);
    }
    (void)nqm_limit_threads(limit);
    nqm_texture_free(texture);
    nqm_scene_free(scene);
}
