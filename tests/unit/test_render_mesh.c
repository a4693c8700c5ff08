/* SPDX-License-Identifier: MIT
 *
 * Scenes with meshes: shadows and interreflection in a bowl against the closed form, the edge of a shadow, normals that
 * differ from those of the triangles, the pixels of a picture, and the same invariants as for the sphere: equal BRDFs
 * give exactly 0, one and two threads give the same bits.
 */
#include "math/math.h"
#include "render/render.h"
#include "support/check.h"
#include "support/scenes.h"
#include "support/scratch.h"
#include <nqm/label.h>

#include <malloc.h>
#include <omp.h>
#ifdef __SANITIZE_ADDRESS__
size_t __sanitizer_get_current_allocated_bytes(void); /* GCC of Debian 12 comes without the header of it */
#endif

/* ---- files and scenes -------------------------------------------------------------------------------------------- */

static const char *bowl_path, *roof_path, *white_path, *lamp_path;

/* A hemisphere that is open towards +z, with exact normals. */
static void write_bowl(void) {
    enum { RINGS = 60, SECTORS = 200 };
    bowl_path = scratch_path("bowl.obj");
    FILE *f = fopen(bowl_path, "wb");
    assert_non_null(f);
    for (int i = 0; i <= RINGS; ++i)
        for (int j = 0; j < SECTORS; ++j) {
            double w[3];
            nqm_spherical(NQM_PI - NQM_PI / 2 * i / RINGS, 2 * NQM_PI * j / SECTORS, w);
            fprintf(f, "v %.9g %.9g %.9g\nvn %.9g %.9g %.9g\n", w[0], w[1], w[2], -w[0], -w[1], -w[2]);
        }
    for (int i = 0; i < RINGS; ++i)
        for (int j = 0; j < SECTORS; ++j) {
            int a = i * SECTORS + j + 1, b = i * SECTORS + (j + 1) % SECTORS + 1, c = b + SECTORS, d = a + SECTORS;
            fprintf(f, "f %d//%d %d//%d %d//%d %d//%d\n", a, a, d, d, c, c, b, b);
        }
    fclose(f);
}

/* A Radiance file of 8 x 4 pixels or more: all pixels equal, or all black except one. */
static const char *write_map(const char *name, int width, int bright) {
    const char *path = scratch_path(name);
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    int height = width / 2;
    fprintf(f, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", height, width);
    for (int i = 0; i < width * height; ++i) {
        unsigned char value = bright < 0 || i == bright ? 128 : 0;
        const unsigned char pixel[4] = {value, value, value, value ? 129 : 0};
        fwrite(pixel, 1, 4, f);
    }
    fclose(f);
    return path;
}

static int make_files(void **state) {
    (void)state;
    write_bowl();
    /* a floor of 2 x 2 at height 0 and a roof of 1 x 1 at height 1 above its centre */
    roof_path = scratch_text("roof.obj", "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nv -.5 1 -.5\nv -.5 1 .5\nv .5 1 .5\n"
                                         "v .5 1 -.5\nf 1 2 3 4\nf 5 6 7 8\n");
    white_path = write_map("white.hdr", 4, -1);
    lamp_path = write_map("lamp.hdr", 256, 0); /* at the zenith */
    return 0;
}

static nqm_scene_options small_scene(const char *shape) {
    nqm_scene_options o = nqm_scene_options_default();
    o.shape = shape;
    o.n_points = 200;
    o.n_lights = 256;
    o.exposure_cdm2 = 100;
    return o;
}

/* ---- closed forms ------------------------------------------------------------------------------------------------ */

/* The form factor between any two points of a sphere is the same, so every point of a hemisphere sees half of the sky,
 * and one interreflection in a white bowl adds half of the direct irradiance. */
TEST(bowl_of_white) {
    for (int bounce = 0; bounce < 2; ++bounce) {
        nqm_scene_options o = small_scene(bowl_path);
        o.light = white_path;
        o.interreflection = bounce;
        nqm_scene *scene = make_scene(&o);
        double *rgb = render_spec(scene, "lambert:kd=1,1,1"), mean = 0, expected = bounce ? 75 : 50;
        for (size_t i = 0; i < scene->seen.n; ++i) {
            assert_relative(rgb[3 * i], expected, 0.12);
            mean += rgb[3 * i] * scene->seen.weight[i];
        }
        assert_relative(mean, expected, 0.01);
        nqm_free(rgb);
        nqm_scene_free(scene);
    }
}

TEST(white_furnace_with_a_mesh) {
    nqm_scene_options o = small_scene("blob");
    o.light = white_path;
    o.shadows = 0;
    nqm_scene *scene = make_scene(&o);
    double *rgb = render_spec(scene, "lambert:kd=1,1,1");
    for (size_t i = 0; i < 3 * scene->seen.n; ++i)
        assert_relative(rgb[i], 100, 0.005);
    nqm_free(rgb);
    nqm_scene_free(scene);
}

/* A lamp at the zenith: the roof is lit, the floor below it is dark, the rest of the floor is lit. The viewer's
 * elevation is 45 degrees, so the floor below the roof is visible. */
TEST(shadow_of_a_roof) {
    nqm_scene_options o = small_scene(roof_path);
    o.light = lamp_path;
    o.elevation_rad = NQM_PI / 4;
    o.n_points = 800;
    nqm_scene *scene = make_scene(&o);
    double *rgb = render_spec(scene, "lambert:kd=1,1,1"), top = -INFINITY, half = 0;
    size_t n_dark = 0;
    for (size_t i = 0; i < scene->seen.n; ++i)
        top = fmax(top, scene->seen.point[i].origin[1]);
    for (size_t v = 0; v < scene->shape.mesh.n_vertices; ++v)
        half = fmax(half, (double)scene->shape.mesh.position[3 * v]);
    for (size_t i = 0; i < scene->seen.n; ++i) {
        const double *p = scene->seen.point[i].origin;
        double from_middle = fmax(fabs(p[0]), fabs(p[2])) / half;
        bool floor = p[1] < top - 0.1;
        if (floor && fabs(from_middle - 0.5) < 0.04)
            continue; /* penumbra: the lamp is 3 degrees wide */
        bool dark = floor && from_middle < 0.5;
        assert_true(dark ? rgb[3 * i] == 0 : fabs(rgb[3 * i] - 100) < 2);
        n_dark += dark;
    }
    assert_true(n_dark > 20);
    nqm_free(rgb);
    nqm_scene_free(scene);
}

/* ---- invariants -------------------------------------------------------------------------------------------------- */

static nqm_scene_options mode(int i) {
    nqm_scene_options o = small_scene("blob");
    o.n_lights = 32;
    o.n_frames = i == 0 ? 3 : 2;
    if (i > 0) {
        o.width = 24;
        o.height = 16;
    }
    o.interreflection = i == 2;
    return o;
}

TEST(equal_brdfs_give_exactly_zero) {
    for (int i = 0; i < 3; ++i) {
        nqm_scene_options o = mode(i);
        nqm_scene *scene = make_scene(&o);
        double *a = render_spec(scene, "sgd:nickel"), *b = render_spec(scene, "sgd:nickel"),
               *c = render_spec(scene, "ward:nickel");
        double *map = nqm_alloc(scene->seen.n, sizeof *map), sum = 0;
        assert_non_null(map);
        assert_true(nqm_scene_compare(scene, a, b, NULL).delta_e == 0);
        nqm_scene_compare(scene, a, c, map);
        for (size_t k = 0; k < scene->seen.n; ++k)
            sum += map[k] * (scene->seen.weight ? scene->seen.weight[k] : 1 / (double)scene->seen.n);
        assert_true(sum > 0);
        assert_relative(nqm_scene_compare(scene, a, c, NULL).delta_e, sum, 1e-12);
        nqm_free(a);
        nqm_free(b);
        nqm_free(c);
        nqm_free(map);
        nqm_scene_free(scene);
    }
}

TEST(threads_change_nothing) {
    int n_threads = omp_get_max_threads();
    for (int i = 0; i < 3; ++i) {
        nqm_scene_options o = mode(i);
        double *rgb[2];
        size_t n = 0;
        for (int t = 0; t < 2; ++t) {
            omp_set_num_threads(t + 1);
            nqm_scene *scene = make_scene(&o);
            rgb[t] = render_spec(scene, "sgd:nickel");
            n = nqm_scene_get_info(scene).n_points;
            nqm_scene_free(scene);
        }
        assert_memory_equal(rgb[0], rgb[1], n * 3 * sizeof(double));
        nqm_free(rgb[0]);
        nqm_free(rgb[1]);
    }
    omp_set_num_threads(n_threads);
}

/* A pixel is covered if its centre ray hits the shape; the sphere is a disc of 90 % of the picture's width. */
TEST(pictures_cover_the_shape) {
    nqm_scene_options o = small_scene("sphere");
    o.width = 60;
    o.height = 40;
    o.n_frames = 2;
    nqm_scene *scene = make_scene(&o);
    const size_t *pixel = nqm_scene_get_info(scene).pixels;
    size_t n = 0;
    for (size_t i = 0; i < 2 * 60 * 40; ++i) {
        double x = (double)(i % 60) + 0.5 - 30, y = 20 - (double)(i / 60 % 40) - 0.5;
        if (hypot(x, y) >= 18)
            continue;
        assert_true(n < scene->seen.n);
        assert_int_equal(pixel[n], i);
        const double *normal = scene->seen.point[n].frame + 6; /* bent towards the viewer beyond 85 degrees */
        if (hypot(x, y) < 17.9) {
            assert_near(normal[0], x / 18, 1e-9);
            assert_near(normal[1], y / 18, 1e-9);
        }
        ++n;
    }
    assert_int_equal(n, scene->seen.n);
    nqm_scene_free(scene);
}

/* Frame 2 of 4 equals frame 1 of a scene that starts a quarter turn later. */
TEST(turntable_and_points) {
    nqm_scene_options o = small_scene("blob");
    o.width = o.height = 64;
    o.n_frames = 4;
    nqm_scene *four = make_scene(&o);
    o.n_frames = 1;
    o.turn_rad = NQM_PI / 2;
    nqm_scene *second = make_scene(&o);
    size_t first = 0;
    while (nqm_scene_get_info(four).pixels[first] < 64 * 64)
        ++first;
    for (size_t i = 0; i < second->seen.n; ++i) {
        assert_int_equal(nqm_scene_get_info(four).pixels[first + i] - 64 * 64, nqm_scene_get_info(second).pixels[i]);
        for (int k = 0; k < 9; ++k)
            assert_near(four->seen.point[first + i].frame[k], second->seen.point[i].frame[k], 1e-9);
    }
    assert_true(nqm_scene_get_info(four).pixels[first + second->seen.n] >= 2 * 64 * 64);
    nqm_scene_free(four);
    nqm_scene_free(second);
}

/* On a closed smooth shape all visible normals occur, and none faces away, also with coarse triangles. */
TEST(frames_are_sound) {
    nqm_scene_options o = small_scene("blob");
    o.width = o.height = 100;
    o.elevation_rad = 0.3;
    nqm_scene *scene = make_scene(&o);
    double towards[9], most = 0;
    nqm_view_axes(o.elevation_rad, towards);
    for (size_t i = 0; i < scene->seen.n; ++i) {
        const nqm_surface_point *p = &scene->seen.point[i];
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b)
                assert_near(nqm_dot3(p->frame + 3 * a, p->frame + 3 * b), a == b, 1e-9);
        double wo[3];
        nqm_local_from_world(p, towards + 6, wo);
        for (int k = 0; k < 3; ++k)
            assert_near(wo[k], p->wo[k], 1e-9);
        assert_true(p->wo[2] >= cos(85.001 * NQM_PI / 180));
        most = fmax(most, p->wo[0]);
    }
    assert_true(most > sin(84 * NQM_PI / 180));
    nqm_scene_free(scene);
}

/* Stored incident light and light that is computed again for every picture give the same result. */
TEST(kept_or_not_is_the_same) {
    nqm_scene_options o = mode(2);
    nqm_scene *scene = make_scene(&o);
    double *kept = render_spec(scene, "sgd:nickel");
    for (size_t i = 0; i < scene->seen.n; ++i)
        nqm_free(scene->kept[i].ray);
    nqm_free(scene->kept);
    scene->kept = NULL;
    double *made = render_spec(scene, "sgd:nickel");
    assert_memory_equal(kept, made, scene->seen.n * 3 * sizeof *kept);
    nqm_free(kept);
    nqm_free(made);
    nqm_scene_free(scene);
}

/* So do stored points and those that are computed again from their pixels. */
TEST(stored_points_or_not_is_the_same) {
    static const char *const shapes[] = {"sphere", "blob"};
    for (size_t s = 0; s < 2; ++s)
        for (int kept = 0; kept < 2; ++kept) {
            nqm_scene_options o = small_scene(shapes[s]);
            o.n_lights = 32;
            o.width = 40;
            o.height = 30;
            o.n_frames = 2;
            o.elevation_rad = 0.3;
            nqm_scene *scene = make_scene(&o);
            for (size_t i = 0; !kept && i < scene->seen.n; ++i)
                nqm_free(scene->kept[i].ray);
            if (!kept) {
                nqm_free(scene->kept);
                scene->kept = NULL;
            }
            double *stored = render_spec(scene, "sgd:nickel");
            scene->seen.point = NULL;
            double *computed = render_spec(scene, "sgd:nickel");
            assert_memory_equal(stored, computed, scene->seen.n * 3 * sizeof *stored);
            nqm_free(stored);
            nqm_free(computed);
            nqm_scene_free(scene);
        }
}

/* Bytes on the heap. Not what is resident: a sanitizer gives freed memory back to the system when it pleases. */
static size_t allocated_bytes(void) {
#ifdef __SANITIZE_ADDRESS__
    return __sanitizer_get_current_allocated_bytes();
#else
    const struct mallinfo2 heap = mallinfo2();
    return heap.uordblks + heap.hblkhd;
#endif
}

/* Notes the memory in use when all points are known, and stops. */
static int stop_at_light(void *user, const char *stage, double done, double total) {
    (void)done, (void)total;
    if (strcmp(stage, "light") != 0)
        return 0;
    *(size_t *)user = allocated_bytes();
    return 1;
}

/* Points of a large picture are not stored: 1.1 million of them would take 150 MB. */
TEST(large_pictures_store_pixels_only) {
    const size_t before = allocated_bytes();
    size_t during = 0;
    nqm_scene_options o = small_scene("sphere");
    nqm_scene *scene;
    o.n_lights = 16;
    o.width = o.height = 1200;
    o.progress = stop_at_light;
    o.progress_user = &during;
    assert_int_equal(nqm_scene_create(&o, &scene, NULL), NQM_ERR_CANCELLED);
    assert_true(during > 0 && during < before + ((size_t)64 << 20));
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

TEST(bad_options) {
    nqm_scene_options good = small_scene("blob"), o;
    o = good, o.shape = "/nowhere/shape.ply", expect_no_scene(o, NQM_ERR_IO);
    o = good, o.width = 100, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.height = 100, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.width = o.height = SIZE_MAX, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.width = o.height = 4096, o.n_frames = 2, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.n_points = 1000000, o.n_lights = 60000, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.n_frames = 4097, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.light_width = 100, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.elevation_rad = 2, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.turn_rad = NAN, expect_no_scene(o, NQM_ERR_ARG);
    o = good, o.shadows = 0, o.interreflection = 1, expect_no_scene(o, NQM_ERR_ARG);
}

TEST(out_of_memory) {
    nqm_scene_options o = small_scene("blob");
    o.n_points = 3;
    o.n_lights = 16;
    o.interreflection = 1;
    o.light_width = 16;
    check_scene_without_memory(&o, 300);
}

TEST_FILE(make_files, NULL)

/* A build without Embree has no meshes. */
static bool has_meshes(void) {
    return nqm_tracer_version() != NULL;
}

TEST_FILE_NEEDS(has_meshes)
