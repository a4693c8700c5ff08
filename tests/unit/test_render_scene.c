/* SPDX-License-Identifier: MIT
 *
 * The scene against closed forms and independent quadratures: white furnace, one small lamp, microfacets under a
 * constant light (vectors/render.py) and under the built-in sky, and the invariants of labels: equal BRDFs give exactly
 * 0, other seeds and more samples give the same label, one and two threads give the same bits.
 */
#include "brdf/brdf.h"
#include "math/math.h"
#include "render/render.h"
#include "support/check.h"
#include "support/scenes.h"
#include "support/scratch.h"
#include "support/vectors.h"
#include <nqm/label.h>

#include <omp.h>

/* ---- BRDFs of this test ------------------------------------------------------------------------------------------ */

/* A grey Lambert term plus a GGX lobe (Smith, separate shadowing and masking; Schlick with f0 = 0.5). */
typedef struct gloss {
    double albedo, specular, alpha;
} gloss;

static double smith(double alpha, double cosine) {
    return 2 / (1 + sqrt(1 + alpha * alpha * (1 / (cosine * cosine) - 1)));
}

static void gloss_eval(const void *self, size_t n, const double *wi, const double *wo, double *rgb) {
    const gloss *g = self;
    for (size_t i = 0; i < n; ++i) {
        const double *l = wi + 3 * i, *v = wo + 3 * i;
        double h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]};
        nqm_normalize3(h);
        double a2 = g->alpha * g->alpha, t = h[2] * h[2] * a2 + h[0] * h[0] + h[1] * h[1];
        double d = a2 / (NQM_PI * t * t), fresnel = 0.5 + 0.5 * pow(1 - nqm_dot3(v, h), 5);
        double f = g->albedo / NQM_PI +
                   g->specular * d * fresnel * smith(g->alpha, l[2]) * smith(g->alpha, v[2]) / (4 * l[2] * v[2]);
        rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = f;
    }
}

static const nqm_brdf_class gloss_class = {.format = "gloss", .reciprocal = 1, .eval = gloss_eval, .free = nqm_free};

/* The same BRDF, declared as costly: pictures come from a table. */
static const nqm_brdf_class costly_class = {
    .format = "costly", .reciprocal = 1, .is_costly = true, .eval = gloss_eval, .free = nqm_free};

static nqm_brdf *make_gloss_of(const nqm_brdf_class *class_, double albedo, double specular, double alpha) {
    gloss *g = nqm_alloc(1, sizeof *g);
    assert_non_null(g);
    *g = (gloss){albedo, specular, alpha};
    nqm_brdf *brdf;
    assert_int_equal(nqm_brdf_wrap(class_, g, &(nqm_brdf_info){.name = "gloss"}, &brdf, NULL), NQM_OK);
    return brdf;
}

static nqm_brdf *make_gloss(double albedo, double specular, double alpha) {
    return make_gloss_of(&gloss_class, albedo, specular, alpha);
}

/* ---- lights and scenes ------------------------------------------------------------------------------------------- */

/* A uniform grey light, except for n_cells cells from first_cell on, which have another grey. */
enum { WIDTH = NQM_LIGHT_WIDTH, HEIGHT = WIDTH / 2, CELLS = WIDTH * HEIGHT };

static nqm_light make_light(float grey, size_t first_cell, size_t n_cells, float bright) {
    nqm_image image = {.width = WIDTH, .height = HEIGHT};
    image.rgb = nqm_alloc(CELLS, 3 * sizeof *image.rgb);
    assert_non_null(image.rgb);
    for (size_t i = 0; i < 3 * (size_t)CELLS; ++i)
        image.rgb[i] = i / 3 - first_cell < n_cells ? bright : grey; /* wraps below first_cell */
    nqm_light light;
    assert_int_equal(nqm_light_create(&image, WIDTH, &light, NULL), NQM_OK);
    nqm_free(image.rgb);
    return light;
}

static nqm_scene *make_sphere(const char *path, size_t n_points, size_t n_lights, uint64_t seed) {
    nqm_scene_options o = nqm_scene_options_default();
    o.light = path;
    o.n_points = n_points;
    o.n_lights = n_lights;
    o.seed = seed;
    return make_scene(&o);
}

/* A Radiance file of 8 x 4 equal pixels (uncompressed, because rows are too short for run-length coding). */
static const char *write_constant_map(const char *name, unsigned char mantissa) {
    const char *path = scratch_path(name);
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    fputs("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n", f);
    const unsigned char pixel[4] = {mantissa, mantissa, mantissa, 130};
    for (int i = 0; i < 32; ++i)
        fwrite(pixel, 1, 4, f);
    fclose(f);
    return path;
}

static double label(const nqm_scene *scene, const nqm_brdf *ref, const nqm_brdf *test) {
    double *a = render_scene(scene, ref), *b = render_scene(scene, test);
    double delta_e = nqm_scene_compare(scene, a, b, NULL).delta_e;
    nqm_free(a);
    nqm_free(b);
    return delta_e;
}

/* ---- the light map ----------------------------------------------------------------------------------------------- */

TEST(cells_and_directions) {
    nqm_light light = make_light(2, 0, 0, 0);
    double sphere = 0, power = 0;
    for (size_t cell = 0; cell < CELLS; ++cell) {
        double w[3], rgb[3];
        nqm_light_direction(&light, cell, (double)(cell % 7) / 7.1, (double)(cell % 11) / 11.1, w);
        assert_near(nqm_dot3(w, w), 1, 1e-12);
        if (cell % 7 && cell % 11) /* not at the edges of the cell */
            assert_int_equal(nqm_light_eval(&light, w, rgb), cell);
        nqm_light_eval(&light, w, rgb);
        assert_near(rgb[1], 2, 1e-12);
        sphere += light.solid_angle[cell / WIDTH];
        power += light.power[cell];
    }
    assert_near(sphere, 4 * NQM_PI, 1e-10);
    assert_near(power, 8 * NQM_PI, 1e-10);
    /* Uniform in solid angle: v = 0.5 halves the height, not the angle, of a cell at the pole. */
    double half[3];
    nqm_light_direction(&light, 0, 0.5, 0.5, half);
    assert_near(half[1], 0.5 * (1 + cos(2 * NQM_PI / WIDTH)), 1e-12);
    nqm_free(light.rgb);
    /* The axes are those of the header: the centre of the map is -z, up is +y, +x is at 3/4 of the width. */
    double w[3];
    nqm_map_direction(0.5, 0.5, w);
    assert_near(w[2], -1, 1e-12);
    nqm_map_direction(0.75, 0.5, w);
    assert_near(w[0], 1, 1e-12);
    nqm_map_direction(0.3, 0, w);
    assert_near(w[1], 1, 1e-12);
}

TEST(filtering_keeps_the_power) {
    static const size_t size[][2] = {{1, 1}, {3, 2}, {300, 170}, {700, 401}};
    for (size_t s = 0; s < sizeof size / sizeof *size; ++s) {
        nqm_image image = {.width = size[s][0], .height = size[s][1]};
        image.rgb = nqm_alloc(image.width * image.height, 3 * sizeof *image.rgb);
        assert_non_null(image.rgb);
        double expected = 0, power = 0;
        for (size_t y = 0; y < image.height; ++y)
            for (size_t x = 0; x < image.width; ++x) {
                float value = (float)((7 * x + 13 * y) % 29);
                for (size_t k = 0; k < 3; ++k)
                    image.rgb[3 * (y * image.width + x) + k] = value;
                double h = (double)image.height, band = cos(NQM_PI * (double)y / h) - cos(NQM_PI * (double)(y + 1) / h);
                expected += (double)value * band * 2 * NQM_PI / (double)image.width;
            }
        nqm_light light;
        assert_int_equal(nqm_light_create(&image, WIDTH, &light, NULL), NQM_OK);
        for (size_t cell = 0; cell < CELLS; ++cell)
            power += nqm_luminance(light.rgb + 3 * cell) * light.solid_angle[cell / WIDTH];
        assert_near(power, expected, 1e-9 * expected + 1e-12);
        nqm_free(light.rgb);
        nqm_free(image.rgb);
    }
}

TEST(sky_has_the_contrast_of_a_real_one) {
    nqm_image image;
    assert_int_equal(nqm_light_draw("sun", &image, NULL), NQM_OK);
    double sum = 0, area = 0, max = 0, sun = 0;
    for (size_t y = 0; y < image.height; ++y)
        for (size_t x = 0; x < image.width; ++x) {
            const float *p = image.rgb + 3 * (y * image.width + x);
            const double rgb[3] = {(double)p[0], (double)p[1], (double)p[2]};
            double luminance = nqm_luminance(rgb), weight = sin(NQM_PI * ((double)y + 0.5) / (double)image.height);
            assert_true(p[0] > 0 && p[1] > 0 && p[2] > 0);
            sum += weight * luminance;
            area += weight;
            max = fmax(max, luminance);
            sun += luminance > 30 ? weight * luminance : 0;
        }
    assert_true(max / (sum / area) > 500 && max / (sum / area) < 2000);
    assert_true(sun / sum > 0.3 && sun / sum < 0.5);
    nqm_free(image.rgb);
}

/* ---- pictures against closed forms ------------------------------------------------------------------------------- */

TEST(white_furnace) {
    nqm_scene *scene = make_sphere(write_constant_map("white.hdr", 77), 300, 384, 5);
    nqm_brdf *white = make_gloss(1, 0, 1);
    double *rgb = render_scene(scene, white);
    for (size_t i = 0; i < 3 * nqm_scene_get_info(scene).n_points; ++i)
        assert_relative(rgb[i], nqm_scene_options_default().exposure_cdm2, 0.005);
    nqm_free(rgb);
    nqm_brdf_free(white);
    nqm_scene_free(scene);
}

TEST(sphere_under_a_small_lamp) {
    nqm_scene *scene = make_sphere("sun", 200, 16, 1); /* owns the surface points */
    size_t cell = 40 * WIDTH + 30;                     /* high, left of and behind the viewer */
    nqm_light lamp = make_light(0, cell, 1, 1000);
    double towards[3], flux = 1000 * lamp.solid_angle[40]; /* interpolation spreads the cell but preserves its flux */
    nqm_light_direction(&lamp, cell, 0.5, 0.5, towards);
    for (size_t i = 0; i < scene->seen.n; ++i) {
        double wi[3 * 384], weight[3 * 384], sum = 0;
        nqm_direction_set set = {.n_max = 384, .wi = wi, .weight = weight};
        assert_true(nqm_choose_directions(&lamp, &scene->seen.point[i], NULL, i, &set));
        assert_true(set.n_used <= 384);
        for (size_t j = 0; j < set.n_used; ++j)
            sum += weight[3 * j + 1];
        double expected = flux * fmax(nqm_dot3(scene->seen.point[i].frame + 6, towards), 0);
        assert_near(sum, expected,
                    0.01 * expected + 0.005 * flux);      /* the lamp is 3 degrees wide: the terminator is soft */
        assert_near(set.irradiance[1], sum, 2e-7 * flux); /* where nothing but the spiral meets the lamp */
    }
    nqm_free(lamp.rgb);
    nqm_scene_free(scene);
}

/* A surface point seen at theta; its normal is the world's z. */
static nqm_surface_point point_seen_at(double theta) {
    return (nqm_surface_point){.frame = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .wo = {sin(theta), 0, cos(theta)}};
}

static double shade(const nqm_light *light, const nqm_surface_point *point, const nqm_brdf *brdf, uint64_t seed,
                    size_t n) {
    double *wi = nqm_alloc(n, 3 * sizeof *wi), *weight = nqm_alloc(n, 3 * sizeof *weight);
    double *wo = nqm_alloc(n, 3 * sizeof *wo), *f = nqm_alloc(n, 3 * sizeof *f), sum = 0;
    assert_true(wi && weight && wo && f);
    nqm_direction_set set = {.n_max = n, .wi = wi, .weight = weight};
    assert_true(nqm_choose_directions(light, point, NULL, seed, &set));
    n = set.n_used;
    for (size_t j = 0; j < n; ++j)
        memcpy(wo + 3 * j, point->wo, sizeof point->wo);
    nqm_brdf_eval(brdf, n, wi, wo, f, NULL);
    for (size_t j = 0; j < n; ++j)
        sum += f[3 * j] * weight[3 * j];
    nqm_free(wi);
    nqm_free(weight);
    nqm_free(wo);
    nqm_free(f);
    return sum;
}

TEST(microfacets_under_constant_light) {
    nqm_light white = make_light(1, 0, 0, 0);
    enum { N = 25 };
    double albedo[N][3]; /* alpha, theta of the viewer in degrees, albedo */
    get_vector("render.safetensors", "albedo", sizeof albedo, albedo);
    for (size_t i = 0; i < N; ++i) {
        const double *row = albedo[i];
        nqm_brdf *brdf = make_gloss(0, 1, row[0]);
        nqm_surface_point point = point_seen_at(row[1] * NQM_PI / 180);
        double sum = 0;
        for (uint64_t seed = 0; seed < 32; ++seed) {
            double value = shade(&white, &point, brdf, seed, 384);
            assert_relative(value, row[2], 0.05);
            sum += value;
        }
        assert_relative(sum / 32, row[2], 0.01);
        nqm_brdf_free(brdf);
    }
    nqm_free(white.rgb);
}

/* The reflected radiance as a direct sum over the map with subdivided cells. */
static double dense_sum(const nqm_light *light, const nqm_surface_point *point, const nqm_brdf *brdf) {
    enum { SPLIT = 6 };
    double sum = 0;
    for (size_t i = 0; i < (size_t)CELLS * SPLIT * SPLIT; ++i) {
        size_t cell = i / (SPLIT * SPLIT), part = i % (SPLIT * SPLIT);
        double world[3], wi[3], f[3], rgb[3];
        nqm_light_direction(light, cell, ((double)(part % SPLIT) + 0.5) / SPLIT, ((double)(part / SPLIT) + 0.5) / SPLIT,
                            world);
        for (int k = 0; k < 3; ++k)
            wi[k] = nqm_dot3(point->frame + 3 * k, world);
        if (!(wi[2] > 0))
            continue;
        nqm_light_eval(light, world, rgb);
        nqm_brdf_eval(brdf, 1, wi, point->wo, f, NULL);
        sum += rgb[0] * f[0] * wi[2] * light->solid_angle[cell / WIDTH] / (SPLIT * SPLIT);
    }
    return sum;
}

TEST(microfacets_under_the_sky) {
    nqm_image image;
    nqm_light sky;
    assert_int_equal(nqm_light_draw("sun", &image, NULL), NQM_OK);
    assert_int_equal(nqm_light_create(&image, WIDTH, &sky, NULL), NQM_OK);
    nqm_free(image.rgb);
    nqm_scene *scene = make_sphere("sun", 40, 16, 1); /* owns the surface points */
    static const double alphas[] = {0.02, 0.06, 0.2};
    for (size_t a = 0; a < 3; ++a) {
        nqm_brdf *brdf = make_gloss(0.1, 1, alphas[a]);
        for (size_t i = 1; i < scene->seen.n; i += 13) {
            double expected = dense_sum(&sky, &scene->seen.point[i], brdf), sum = 0;
            for (uint64_t seed = 0; seed < 8; ++seed)
                sum += shade(&sky, &scene->seen.point[i], brdf, seed, 384) / 8;
            assert_relative(sum, expected, 0.02);
        }
        nqm_brdf_free(brdf);
    }
    nqm_free(sky.rgb);
    nqm_scene_free(scene);
}

/* The largest fraction of a point's light that one of 384 directions carries. */
static double largest_share(const nqm_light *light, const nqm_surface_point *point, uint64_t seed) {
    double wi[3 * 384], weight[3 * 384], sum = 0, max = 0;
    nqm_direction_set set = {.n_max = 384, .wi = wi, .weight = weight};
    assert_true(nqm_choose_directions(light, point, NULL, seed, &set));
    for (size_t j = 0; j < set.n_used; ++j) {
        sum += weight[3 * j];
        max = fmax(max, weight[3 * j]);
    }
    return max / sum;
}

/* No direction may carry a large fraction, not even with a bright light at the horizon: here a ring of cells whose
 * centres are just below the horizon and whose upper edges are above it. */
TEST(no_fireflies) {
    nqm_light light = make_light(1, 64 * WIDTH, WIDTH, 1000);
    const double tilt = 0.6 * NQM_PI / 180;
    nqm_surface_point point = {.frame = {1, 0, 0, 0, sin(tilt), -cos(tilt), 0, cos(tilt), sin(tilt)},
                               .wo = {sin(1.2), 0, cos(1.2)}};
    double max = 0;
    for (uint64_t seed = 0; seed < 500; ++seed)
        max = fmax(max, largest_share(&light, &point, seed));
    assert_true(max < 0.1);
    nqm_free(light.rgb);
}

/* ---- labels ------------------------------------------------------------------------------------------------------ */

TEST(equal_brdfs_give_exactly_zero) {
    nqm_scene *scene = make_sphere("sun", 200, 100, 9);
    nqm_brdf *a = make_gloss(0.2, 1, 0.01), *b = make_gloss(0.2, 1, 0.01);
    assert_true(label(scene, a, b) == 0);
    nqm_brdf_free(a);
    nqm_brdf_free(b);
    nqm_scene_free(scene);
}

TEST(labels_repeat) {
    static const double pair[][6] = {
        {0.1, 1, 0.004, 0.1, 1, 0.03}, {0.05, 1, 0.05, 0.05, 1, 0.07}, {0.3, 0.1, 0.2, 0.4, 0.1, 0.3}};
    nqm_scene_options standard = nqm_scene_options_default();
    nqm_scene *first = make_sphere("studio", standard.n_points, 0, 1);
    nqm_scene *second = make_sphere("studio", standard.n_points, 0, 2);
    nqm_scene *finer = make_sphere("studio", 2 * standard.n_points, 2 * nqm_scene_n_lights(&standard), 3);
    for (size_t i = 0; i < sizeof pair / sizeof *pair; ++i) {
        const double *p = pair[i];
        nqm_brdf *ref = make_gloss(p[0], p[1], p[2]), *test = make_gloss(p[3], p[4], p[5]);
        double delta_e = label(first, ref, test);
        assert_true(delta_e > 2);
        assert_relative(label(second, ref, test), delta_e, 0.02);
        assert_relative(label(finer, ref, test), delta_e,
                        p[2] < 0.01 ? 0.05 : 0.02); /* the picture of a mirror is noisy */
        nqm_brdf_free(ref);
        nqm_brdf_free(test);
    }
    nqm_scene_free(first);
    nqm_scene_free(second);
    nqm_scene_free(finer);
}

TEST(threads_change_nothing) {
    nqm_brdf *brdf = make_gloss(0.2, 1, 0.02);
    double *rgb[2];
    int n_threads = omp_get_max_threads();
    for (int i = 0; i < 2; ++i) {
        omp_set_num_threads(i + 1);
        nqm_scene *scene = make_sphere("sun", 150, 384, 4);
        rgb[i] = render_scene(scene, brdf);
        nqm_scene_free(scene);
    }
    omp_set_num_threads(n_threads);
    assert_memory_equal(rgb[0], rgb[1], 150 * 3 * sizeof(double));
    nqm_free(rgb[0]);
    nqm_free(rgb[1]);
    nqm_brdf_free(brdf);
}

TEST(brighter_than_the_display_is_clipped) {
    nqm_scene_options o = nqm_scene_options_default();
    o.n_points = 50;
    o.n_lights = 64;
    o.exposure_cdm2 = 10000;
    o.peak_cdm2 = 100;
    nqm_scene *scene = make_scene(&o);
    nqm_brdf *a = make_gloss(0.9, 0, 1), *b = make_gloss(1, 0, 1);
    assert_true(label(scene, a, b) == 0);
    nqm_brdf_free(a);
    nqm_brdf_free(b);
    nqm_scene_free(scene);
}

/* The paper's scene sets the number of frames only, unless it is given. */
/* ---- tables ------------------------------------------------------------------------------------------------------ */

/* Stop at the first report of the stage that `user` names. */
static int stop_stage(void *user, const char *stage, double done, double total) {
    (void)done, (void)total;
    return strcmp(stage, user) == 0;
}

TEST(making_a_picture_can_be_stopped) {
    nqm_scene_options o = nqm_scene_options_default();
    nqm_scene *scene;
    o.light = "sun";
    o.n_points = 0;
    o.width = o.height = 20;
    o.progress = stop_stage;
    o.progress_user = (char[]){"view"};
    assert_int_equal(nqm_scene_create(&o, &scene, NULL), NQM_ERR_CANCELLED);
    o.progress_user = (char[]){"light"};
    assert_int_equal(nqm_scene_create(&o, &scene, NULL), NQM_ERR_CANCELLED);
}

TEST(costly_brdfs_are_tabulated) {
    nqm_scene_options o = nqm_scene_options_default();
    o.light = "studio";
    o.n_points = 700; /* times 128 directions: more than the table's 69,120 nodes */
    nqm_brdf *plain = make_gloss(0.2, 0.5, 0.1), *costly = make_gloss_of(&costly_class, 0.2, 0.5, 0.1);
    nqm_scene *scene = make_scene(&o);
    o.exact = 1;
    nqm_scene *exact = make_scene(&o);
    assert_true(nqm_scene_tabulates(scene, costly));
    assert_false(nqm_scene_tabulates(scene, plain));
    assert_false(nqm_scene_tabulates(exact, costly));
    double *a = render_scene(exact, plain), *b = render_scene(exact, costly), *c = render_scene(scene, costly);
    assert_memory_equal(a, b, 3 * nqm_scene_get_info(exact).n_points * sizeof *a);
    const double delta_e = nqm_scene_compare(exact, a, c, NULL).delta_e;
    assert_true(delta_e > 0 && delta_e < 0.3);
    o.exact = 0;
    o.n_points = 500;
    nqm_scene *few = make_scene(&o);
    assert_false(nqm_scene_tabulates(few, costly));
    o.n_points = 700;
    o.progress = stop_stage;
    o.progress_user = (char[]){"table"};
    nqm_scene *stopping = make_scene(&o);
    assert_int_equal(nqm_scene_render(stopping, costly, 0, c, NULL, NULL), NQM_ERR_CANCELLED);
    for (int i = 0; i < 4; ++i)
        nqm_scene_free((nqm_scene *[]){scene, exact, few, stopping}[i]);
    nqm_brdf_free(plain);
    nqm_brdf_free(costly);
    nqm_free(a);
    nqm_free(b);
    nqm_free(c);
}

TEST(paper_scene_has_eight_frames) {
    nqm_scene_options o = nqm_scene_options_default();
    assert_int_equal(nqm_scene_n_frames(&o), 1);
    o.scene = NQM_SCENE_PAPER;
    o.light = "sun";
    o.shape = "sphere";
    o.n_points = 50;
    for (size_t n = 0; n < 4; n += 3) {
        o.n_frames = n;
        nqm_scene *scene = make_scene(&o);
        assert_int_equal(scene->options.n_frames, n ? n : 8);
        nqm_scene_free(scene);
    }
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

TEST(bad_options_and_lights) {
    nqm_scene_options good = nqm_scene_options_default(), o;
    o = good, o.n_points = 0, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.n_points = SIZE_MAX, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.scene = NQM_SCENE_PAPER, expect_no_scene(o, NQM_ERR_ARG);
    o.light = "sun", expect_no_scene(o, NQM_ERR_ARG);
    o.light = NULL, o.shape = "sphere", expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.scene = (nqm_scene_kind)2, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.n_lights = 3, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.n_lights = SIZE_MAX, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.exposure_cdm2 = NAN, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.peak_cdm2 = 0, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.light = "/nowhere/light.exr", expect_no_scene(o, NQM_ERR_IO);
    o = good, o.light = write_constant_map("black.hdr", 0), o.n_points = 20, expect_no_scene(o, NQM_ERR_FORMAT);
}

TEST(out_of_memory) {
    nqm_scene_options o = nqm_scene_options_default();
    o.light = "sun";
    o.n_points = 3;
    o.n_lights = 16;
    check_scene_without_memory(&o, 50);
}
