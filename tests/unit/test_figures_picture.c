/* SPDX-License-Identifier: MIT
 *
 * Pictures written and read back: OpenEXR exact to the float, Radiance HDR to its precision, PNG through libpng exact
 * to the byte; averaging; the tone curve; the colour map; scales; figures.
 */
#include "figures/picture.h"
#include "support/brdf_files.h"
#include "support/check.h"

#include <png.h>

enum { WIDTH = 38, HEIGHT = 22 };

/* Runs of equal pixels, noise, black, and values over six orders of magnitude. */
static void make_picture(double *rgb) {
    for (uint32_t i = 0; i < 3 * WIDTH * HEIGHT; ++i) {
        uint32_t x = i / 3 % WIDTH;
        rgb[i] = x < 10 ? 120 : x < 14 ? 0 : 1e4 * pow(10, -6 * noise(i, 1));
    }
}

static nqm_image write_and_load(const char *name, const nqm_picture *picture, size_t supersample) {
    nqm_image image;
    nqm_error err = {0};
    const char *path = scratch_path(name);
    if (nqm_picture_write(path, picture, supersample, NULL, &err) != NQM_OK ||
        nqm_image_load(path, &image, &err) != NQM_OK)
        fail_msg("%s", err.message);
    assert_int_equal(image.width, picture->width / supersample);
    assert_int_equal(image.height, picture->height / supersample);
    return image;
}

TEST(exr_and_hdr) {
    double rgb[3 * WIDTH * HEIGHT];
    make_picture(rgb);
    const size_t widths[] = {WIDTH, 5}; /* 5 is too narrow for run-length coding */
    for (size_t w = 0; w < 2; ++w) {
        const nqm_picture picture = {.width = widths[w], .height = HEIGHT, .rgb_cdm2 = rgb};
        nqm_image exr = write_and_load("picture.exr", &picture, 1), hdr = write_and_load("picture.HDR", &picture, 1);
        for (size_t i = 0; i < 3 * widths[w] * HEIGHT; ++i) {
            const double *pixel = rgb + i / 3 * 3;
            assert_true(exr.rgb[i] == (float)rgb[i]);
            double brightest = fmax(fmax(pixel[0], pixel[1]), pixel[2]);
            assert_near((double)hdr.rgb[i], rgb[i], brightest / 255);
        }
        nqm_free(exr.rgb);
        nqm_free(hdr.rgb);
    }
}

/* Values that would round up to 256, the smallest and the largest values, and negative values. */
TEST(hdr_limits) {
    const double rgb[] = {255.9, 0, 0, 1e-40, 1e-40, 0, 1e38, 1, 1, -5, 1, -1e-3, 3e38, 3e38, 3e38, 1, .5, .25};
    const nqm_picture picture = {.width = 6, .height = 1, .rgb_cdm2 = rgb};
    nqm_image hdr = write_and_load("limits.hdr", &picture, 1);
    assert_near((double)hdr.rgb[0], 256, 0);
    assert_near((double)hdr.rgb[3], 0, 0);
    assert_relative((double)hdr.rgb[6], 1e38, 0.005);
    assert_near((double)hdr.rgb[9], 0, 0);
    assert_near((double)hdr.rgb[10], 1, 0.005);
    assert_near((double)hdr.rgb[17], 0.25, 0);
    nqm_free(hdr.rgb);
}

/* The bytes of a PNG, through libpng's simple interface; free() them. */
static unsigned char *read_png(const char *path, size_t *width, size_t *height) {
    png_image png = {.version = PNG_IMAGE_VERSION};
    if (!png_image_begin_read_from_file(&png, path))
        fail_msg("%s: %s", path, png.message);
    png.format = PNG_FORMAT_RGB;
    unsigned char *rgb = malloc(PNG_IMAGE_SIZE(png));
    assert_non_null(rgb);
    assert_true(png_image_finish_read(&png, NULL, rgb, 0, NULL) != 0);
    *width = png.width;
    *height = png.height;
    return rgb;
}

TEST(png_bytes) {
    /* Black, half the white, at the shoulder, far above it; then a block whose average is that of displayed light. */
    const double grey[] = {0, 200, 240, 1e6, 0, 1e6, 0, 0, 0, 0, 0, 1e6};
    double rgb[3 * 12];
    for (size_t i = 0; i < 36; ++i)
        rgb[i] = grey[i / 3];
    const nqm_picture row = {.width = 4, .height = 1, .rgb_cdm2 = rgb};
    const nqm_picture block = {.width = 4, .height = 2, .rgb_cdm2 = rgb + 12};
    size_t width, height;
    const char *path = scratch_path("row.png");
    assert_int_equal(nqm_picture_write(path, &row, 1, NULL, NULL), NQM_OK);
    unsigned char *bytes = read_png(path, &width, &height);
    assert_int_equal(width, 4);
    assert_int_equal(height, 1);
    static const unsigned char expected[] = {0, 188, 203, 255}; /* sRGB of 0, 0.5, 0.6, 1 */
    for (size_t i = 0; i < 12; ++i)
        assert_int_equal(bytes[i], expected[i / 3]);
    free(bytes);
    path = scratch_path("block.png");
    assert_int_equal(nqm_picture_write(path, &block, 2, NULL, NULL), NQM_OK);
    bytes = read_png(path, &width, &height);
    assert_int_equal(width, 2);
    assert_int_equal(height, 1);
    assert_int_equal(bytes[0], 137); /* sRGB of 1/4 */
    assert_int_equal(bytes[3], 137);
    free(bytes);
    /* Without a shoulder it clips. */
    const nqm_tone clip = {.white_cdm2 = 240, .shoulder = 1};
    assert_int_equal(nqm_picture_write(path, &row, 1, &clip, NULL), NQM_OK);
    bytes = read_png(path, &width, &height);
    assert_int_equal(bytes[6], 255);
    free(bytes);
}

TEST(averaging) {
    double rgb[3 * WIDTH * HEIGHT];
    make_picture(rgb);
    const nqm_picture picture = {.width = WIDTH, .height = HEIGHT, .rgb_cdm2 = rgb};
    nqm_image exr = write_and_load("averaged.exr", &picture, 2);
    for (size_t y = 0; y < HEIGHT / 2; ++y)
        for (size_t i = 0; i < 3 * (WIDTH / 2); ++i) {
            const double *corner = rgb + 3 * (2 * y * WIDTH + i / 3 * 2) + i % 3;
            double mean = (corner[0] + corner[3] + corner[3 * WIDTH] + corner[3 * WIDTH + 3]) / 4;
            assert_relative((double)exr.rgb[y * 3 * (WIDTH / 2) + i], mean, 1e-6);
        }
    nqm_free(exr.rgb);
}

TEST(refusals) {
    double rgb[12] = {0};
    const nqm_tone no_white = {.shoulder = 1}, no_shoulder = {.white_cdm2 = 1};
    const nqm_picture picture = {.width = 2, .height = 2, .rgb_cdm2 = rgb};
    const nqm_picture empty = {.width = 0, .height = 2, .rgb_cdm2 = rgb}, large = {.width = 9000, .height = 1};
    nqm_error err = {0};
    assert_int_equal(nqm_picture_write("x.jpg", &picture, 1, NULL, &err), NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "x.jpg"));
    assert_int_equal(nqm_picture_write(".png", &picture, 1, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_picture_write("x.png", &empty, 1, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_picture_write("x.png", &large, 1, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_picture_write("x.png", &picture, 3, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_picture_write("x.png", &picture, 0, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_picture_write("x.png", &picture, 1, &no_white, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_picture_write("x.png", &picture, 1, &no_shoulder, &err), NQM_ERR_ARG);
    static const char *const nowhere[] = {"/nonexistent/x.png", "/nonexistent/x.exr", "/nonexistent/x.hdr"};
    for (size_t i = 0; i < 3; ++i) {
        assert_int_equal(nqm_picture_write(nowhere[i], &picture, 1, NULL, &err), NQM_ERR_IO);
        assert_non_null(strstr(err.message, nowhere[i]));
    }
}

/* The tone curve increases smoothly, is the identity for small values, and approaches 1. */
TEST(tone_curve) {
    const nqm_tone tone = nqm_tone_default();
    double before = 0;
    for (int i = 1; i < 4000; ++i) {
        double y = nqm_tone_apply(&tone, i);
        assert_true(y > before && y <= 1);
        assert_true(y - before <= 1 / tone.white_cdm2 * (1 + 1e-9));
        before = y;
    }
    assert_near(nqm_tone_apply(&tone, 200), 0.5, 1e-15);
    assert_near(nqm_tone_apply(&tone, 400), 0.6 + 0.4 * (1 - exp(-1)), 1e-15);
    assert_near(nqm_tone_apply(&tone, -3), 0, 0);
    for (int i = 0; i < 256; ++i)
        assert_int_equal(nqm_srgb_byte(nqm_srgb_linear(i / 255.0)), i);
    assert_int_equal(nqm_srgb_byte(-1), 0);
    assert_int_equal(nqm_srgb_byte(2), 255);
}

/* Perceptually ordered: lightness (CIE L*), which does not depend on colour vision, increases in nearly equal steps. */
TEST(colour_map) {
    double before = 0, least = 100, most = 0;
    for (int i = 0; i <= 64; ++i) {
        double rgb[3];
        nqm_viridis(i / 64.0, rgb);
        double lightness = 116 * cbrt(0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]) - 16;
        if (i) {
            least = fmin(least, lightness - before);
            most = fmax(most, lightness - before);
        }
        before = lightness;
    }
    assert_true(least > 0.8);
    assert_true(most < 1.6);
}

TEST(scales) {
    double map[1000], other[1000], end;
    for (size_t i = 0; i < 1000; ++i) {
        map[i] = i < 5 ? 1e6 : (double)i / 100; /* a few outliers do not change the scale */
        other[i] = (double)NAN;
    }
    const double *const maps[] = {other, map}, *const nothing[] = {other};
    assert_int_equal(nqm_map_scale(2, maps, 1000, &end, NULL), NQM_OK);
    assert_near(end, 10, 1e-9);
    for (size_t i = 5; i < 1000; ++i)
        map[i] = (double)i * 0.023; /* 99th percentile 22.8 in steps of 5 */
    assert_int_equal(nqm_map_scale(1, maps + 1, 1000, &end, NULL), NQM_OK);
    assert_near(end, 25, 1e-9);
    assert_int_equal(nqm_map_scale(1, nothing, 1000, &end, NULL), NQM_OK);
    assert_near(end, 1, 1e-9);
}

/* A map without a frame: same size in pixels, reduced on request; invalid sizes, scales and names are refused. */
TEST(maps_alone) {
    double map[8 * 4];
    for (size_t i = 0; i < 8 * 4; ++i)
        map[i] = i == 0 ? (double)NAN : i == 31 ? 99 : 0;
    nqm_error err = {0};
    const char *path = scratch_path("map.png");
    assert_int_equal(nqm_picture_write(path, &(nqm_picture){8, 4, NULL, map, 40}, 1, NULL, &err), NQM_OK);
    size_t width, height;
    unsigned char *rgb = read_png(path, &width, &height);
    assert_true(width == 8 && height == 4);
    static const unsigned char none[] = {255, 255, 255}, least[] = {68, 1, 84}, most[] = {253, 231, 37};
    assert_memory_equal(rgb, none, 3);
    assert_memory_equal(rgb + 3, least, 3);
    assert_memory_equal(rgb + 3 * 31, most, 3);
    free(rgb);
    assert_int_equal(nqm_picture_write(path, &(nqm_picture){8, 4, NULL, map, 40}, 4, NULL, &err), NQM_OK);
    rgb = read_png(path, &width, &height);
    assert_true(width == 2 && height == 1);
    free(rgb);
    assert_int_equal(nqm_picture_write(path, &(nqm_picture){8, 4, NULL, map, 40}, 3, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_picture_write(path, &(nqm_picture){0, 4, NULL, map, 40}, 1, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_picture_write(path, &(nqm_picture){8, 4, NULL, map, 0}, 1, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_picture_write(path, &(nqm_picture){8, 4, NULL, map, (double)NAN}, 1, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_picture_write("map.exr", &(nqm_picture){8, 4, NULL, map, 40}, 1, NULL, &err), NQM_ERR_ARG);
    assert_int_equal(nqm_picture_write("/nonexistent/map.png", &(nqm_picture){8, 4, NULL, map, 40}, 1, NULL, &err),
                     NQM_ERR_IO);
}

/* A figure of two grey pictures, a map whose left half is NaN, and an empty panel, on white; the bar of colours at the
 * right is dark below and bright above. */
TEST(figures) {
    double grey[3 * 40 * 40], map[40 * 40];
    for (size_t i = 0; i < 3 * 40 * 40; ++i)
        grey[i] = 200;
    for (size_t i = 0; i < 40 * 40; ++i)
        map[i] = i % 40 < 20 ? (double)NAN : 10;
    const nqm_panel panels[] = {{.rgb_cdm2 = grey}, {.delta_e = map}, {0}, {.rgb_cdm2 = grey}};
    nqm_figure f = {.n_rows = 2, .n_columns = 2, .width = 40, .height = 40, .panels = panels, .delta_e_max = 10};
    nqm_error err = {0};
    const char *path = scratch_path("figure.png");
    assert_int_equal(nqm_figure_write(path, &f, &err), NQM_OK);
    size_t width, height;
    unsigned char *rgb = read_png(path, &width, &height);
    assert_true(width == 2 * 46 + 6 + 18 && height == 2 * 46 + 6);
    static const unsigned char white[] = {255, 255, 255}, mid[] = {188, 188, 188}, yellow[] = {253, 231, 37};
    for (size_t i = 0; i < width * height; ++i) {
        const size_t x = i % width, y = i / width, column = x / 46, row = y / 46;
        const bool is_inside = x % 46 >= 6 && y % 46 >= 6 && column < 2 && row < 2;
        const unsigned char *expected = !is_inside || (row && !column) ? white
                                        : row == column                ? mid
                                        : x % 46 - 6 < 20              ? white
                                                                       : yellow;
        if (x < 2 * 46 + 6)
            assert_memory_equal(rgb + 3 * i, expected, 3);
    }
    const unsigned char *top = rgb + 3 * (6 * width + width - 10),
                        *bottom = rgb + 3 * ((height - 7) * width + width - 10);
    assert_true(top[0] > 240 && top[1] > 220 && bottom[0] < 75 && bottom[1] < 10);
    free(rgb);
    f.supersample = 2;
    assert_int_equal(nqm_figure_write(path, &f, &err), NQM_OK);
    f.supersample = 3;
    assert_int_equal(nqm_figure_write(path, &f, &err), NQM_ERR_ARG);
    f.supersample = 1;
    f.delta_e_max = 0;
    assert_int_equal(nqm_figure_write(path, &f, &err), NQM_ERR_ARG);
    f.delta_e_max = 10;
    f.n_rows = 0;
    assert_int_equal(nqm_figure_write(path, &f, &err), NQM_ERR_ARG);
    f.n_rows = 1;
    assert_int_equal(nqm_figure_write("/nonexistent/x.png", &f, &err), NQM_ERR_IO);
    f.width = f.height = 40;
    f.n_columns = 64;
    nqm_panel many[64] = {0};
    f.panels = many;
    f.width = 400;
    assert_int_equal(nqm_figure_write(path, &f, &err), NQM_ERR_LIMIT);
}
