/* SPDX-License-Identifier: MIT
 *
 * Pictures and maps to files: tone curve, sRGB, viridis, averaging, and the format by the file name.
 */
#include "figures/picture.h"
#include "io/io.h"
#include "io/raster.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

enum { MAX_SUPERSAMPLE = 16 };

/* ---- colours ----------------------------------------------------------------------------------------------------- */

nqm_tone nqm_tone_default(void) {
    return (nqm_tone){.white_cdm2 = 400, .shoulder = 0.6};
}

double nqm_tone_apply(const nqm_tone *tone, double value_cdm2) {
    double x = fmax(value_cdm2, 0) / tone->white_cdm2, s = tone->shoulder;
    if (x <= s)
        return x;
    return s < 1 ? s - (1 - s) * expm1(-(x - s) / (1 - s)) : 1;
}

unsigned char nqm_srgb_byte(double linear) {
    double coded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
    return (unsigned char)nearbyint(255 * fmin(fmax(coded, 0), 1));
}

double nqm_srgb_linear(double coded) {
    return coded <= 0.04045 ? coded / 12.92 : pow((coded + 0.055) / 1.055, 2.4);
}

void nqm_viridis(double t, double *rgb) {
    /* Every eighth of the 256 sRGB colours of viridis (S. van der Walt and N. Smith 2015, CC0); linear between them. */
    static const unsigned char table[33][3] = {
        {68, 1, 84},    {71, 13, 96},   {72, 24, 106},  {72, 35, 116},  {71, 45, 123},  {69, 55, 129},  {66, 64, 134},
        {62, 73, 137},  {59, 82, 139},  {55, 91, 141},  {51, 99, 141},  {47, 107, 142}, {44, 114, 142}, {41, 122, 142},
        {38, 130, 142}, {35, 137, 142}, {33, 145, 140}, {31, 152, 139}, {31, 160, 136}, {34, 167, 133}, {40, 174, 128},
        {50, 182, 122}, {63, 188, 115}, {78, 195, 107}, {94, 201, 98},  {112, 207, 87}, {132, 212, 75}, {152, 216, 62},
        {173, 220, 48}, {194, 223, 35}, {216, 226, 25}, {236, 229, 27}, {253, 231, 37}};
    double at = 32 * fmin(fmax(t, 0), 1);
    size_t i = at < 31 ? (size_t)at : 31;
    for (size_t k = 0; k < 3; ++k)
        rgb[k] = nqm_srgb_linear((table[i][k] + (at - (double)i) * (table[i + 1][k] - table[i][k])) / 255);
}

/* ---- averaging --------------------------------------------------------------------------------------------------- */

static void add_pixel(const nqm_picture *p, const nqm_tone *tone, size_t at, double n_pixels, double *rgb) {
    double one[3] = {1, 1, 1};
    if (p->rgb_cdm2)
        for (size_t k = 0; k < 3; ++k)
            one[k] = tone ? nqm_tone_apply(tone, p->rgb_cdm2[3 * at + k]) : p->rgb_cdm2[3 * at + k];
    else if (!isnan(p->delta_e[at]))
        nqm_viridis(p->delta_e[at] / p->delta_e_max, one);
    for (size_t k = 0; k < 3; ++k)
        rgb[k] += one[k] / n_pixels;
}

static size_t count_blocks(const nqm_picture *p, size_t supersample) {
    return p->width / supersample * (p->height / supersample);
}

/* The mean of block i of n x n pixels, tone-mapped unless `tone` is NULL. */
static void average_block(const nqm_picture *p, size_t n, const nqm_tone *tone, size_t i, double *rgb) {
    const size_t n_columns = p->width / n, first = n * (i / n_columns * p->width + i % n_columns);
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (size_t k = 0; k < n * n; ++k)
        add_pixel(p, tone, first + k / n * p->width + k % n, (double)(n * n), rgb);
}

/* Tone-map a picture, or colour a map, and average blocks of supersample x supersample pixels into bytes of sRGB. */
static void picture_bytes(const nqm_picture *picture, size_t supersample, const nqm_tone *tone, unsigned char *rgb) {
    for (size_t i = 0; i < count_blocks(picture, supersample); ++i) {
        double linear[3];
        average_block(picture, supersample, tone, i, linear);
        for (size_t k = 0; k < 3; ++k)
            rgb[3 * i + k] = nqm_srgb_byte(linear[k]);
    }
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static nqm_status write_png(const char *path, const nqm_picture *p, size_t supersample, const nqm_tone *tone,
                            nqm_error *err) {
    const size_t n = count_blocks(p, supersample);
    unsigned char *rgb = nqm_alloc(n, 3);
    if (!rgb)
        return nqm_fail_nomem(err, 3 * n);
    picture_bytes(p, supersample, tone, rgb);
    const nqm_raster raster = {.width = p->width / supersample,
                               .height = p->height / supersample,
                               .channels = 3,
                               .type = NQM_RASTER_U8,
                               .data = rgb};
    nqm_status status = nqm_raster_write_png(path, &raster, true, NULL, err);
    nqm_free(rgb);
    return status;
}

static nqm_status write_linear(const char *path, const nqm_picture *p, size_t supersample, nqm_error *err) {
    const size_t n = count_blocks(p, supersample);
    nqm_image image = {.width = p->width / supersample, .height = p->height / supersample};
    image.rgb = nqm_alloc(n, 3 * sizeof *image.rgb);
    if (!image.rgb)
        return nqm_fail_nomem(err, n * 3 * sizeof *image.rgb);
    for (size_t i = 0; i < n; ++i) {
        double linear[3];
        average_block(p, supersample, NULL, i, linear);
        for (size_t k = 0; k < 3; ++k)
            image.rgb[3 * i + k] = (float)linear[k];
    }
    nqm_status status = (nqm_name_ends_in(path, ".exr") ? nqm_image_write_exr : nqm_image_write_hdr)(path, &image, err);
    nqm_free(image.rgb);
    return status;
}

/* The smallest of 1, 2, 5 times a power of ten that divides [0, length] into at most five parts. */
static double choose_step(double length) {
    const double least = length / 5, power = pow(10, floor(log10(least) + 1e-9)), digit = least / power * (1 - 1e-9);
    return power * (digit <= 1 ? 1 : digit <= 2 ? 2 : digit <= 5 ? 5 : 10);
}

nqm_status nqm_map_scale(size_t n_maps, const double *const *maps, size_t n, double *end_ret, nqm_error *err) {
    size_t n_values = 0, n_most;
    double *values = nqm_mul_size(n_maps, n, &n_most) ? nqm_alloc(n_most, sizeof *values) : NULL;
    if (!values)
        return nqm_fail_nomem(err, n_maps * n * sizeof *values);
    for (size_t m = 0; m < n_maps; ++m)
        for (size_t i = 0; i < n; ++i)
            if (isfinite(maps[m][i]))
                values[n_values++] = maps[m][i];
    double high = n_values ? fmax(nqm_quantile(n_values, values, 0.99), 1) : 1, step = choose_step(high);
    nqm_free(values);
    *end_ret = step * ceil(high / step * (1 - 1e-9));
    return NQM_OK;
}

nqm_status nqm_picture_write(const char *path, const nqm_picture *p, size_t supersample, const nqm_tone *tone,
                             nqm_error *err) {
    const nqm_tone defaults = nqm_tone_default();
    tone = tone ? tone : &defaults;
    if (p->width < 1 || p->height < 1 || p->width > NQM_IMAGE_MAX_WIDTH || p->height > NQM_IMAGE_MAX_HEIGHT)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: a picture must have 1 x 1 to %d x %d pixels", path,
                        (int)NQM_IMAGE_MAX_WIDTH, (int)NQM_IMAGE_MAX_HEIGHT);
    if (supersample < 1 || supersample > MAX_SUPERSAMPLE || p->width % supersample || p->height % supersample)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: %zu pixels a side cannot be averaged in a picture of %zu x %zu",
                        path, supersample, p->width, p->height);
    if (!(tone->white_cdm2 > 0 && tone->shoulder > 0 && tone->shoulder <= 1))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: the tone curve needs a white above 0 and a shoulder in (0, 1]",
                        path);
    if (!p->rgb_cdm2 && (!(p->delta_e_max > 0) || !nqm_name_ends_in(path, ".png")))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: a map needs a scale above 0, and a name that ends in .png", path);
    if (nqm_name_ends_in(path, ".png"))
        return write_png(path, p, supersample, tone, err);
    if (nqm_name_ends_in(path, ".exr") || nqm_name_ends_in(path, ".hdr"))
        return write_linear(path, p, supersample, err);
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: the name of a picture must end in .png, .exr or .hdr", path);
}

/* ---- figures: a grid of pictures and maps, with a bar of the maps' colours --------------------------------------- */

enum { MAX_CELLS = 64, MAX_SIDE = 16384, GAP = 6, BAR = 12 };

static bool has_maps(const nqm_figure *f) {
    size_t i = 0;
    while (i < f->n_rows * f->n_columns && (f->panels[i].rgb_cdm2 || !f->panels[i].delta_e))
        ++i;
    return i < f->n_rows * f->n_columns;
}

/* Copy (height, width, 3) bytes to a place of the sheet. */
static void place(const nqm_raster *sheet, size_t left, size_t top, size_t width, size_t height,
                  const unsigned char *rgb) {
    unsigned char *to = sheet->data;
    for (size_t y = 0; y < height; ++y)
        memcpy(to + 3 * ((top + y) * sheet->width + left), rgb + 3 * y * width, 3 * width);
}

static void draw_bar(const nqm_raster *sheet) {
    const size_t n = sheet->height - 2 * GAP;
    for (size_t y = 0; y < n; ++y) {
        double value = ((double)(n - y) - 0.5) / (double)n, values[BAR];
        unsigned char rgb[3 * BAR];
        for (size_t i = 0; i < BAR; ++i)
            values[i] = value;
        picture_bytes(&(nqm_picture){BAR, 1, NULL, values, 1}, 1, NULL, rgb);
        place(sheet, sheet->width - GAP - BAR, GAP + y, BAR, 1, rgb);
    }
}

static void draw(const nqm_raster *sheet, const nqm_figure *f, size_t supersample, unsigned char *panel_rgb) {
    const nqm_tone tone = f->tone.white_cdm2 > 0 ? f->tone : nqm_tone_default();
    const size_t width = f->width / supersample, height = f->height / supersample;
    memset(sheet->data, 255, 3 * sheet->width * sheet->height);
    for (size_t i = 0; i < f->n_rows * f->n_columns; ++i) {
        const nqm_panel *panel = &f->panels[i];
        if (!panel->rgb_cdm2 && !panel->delta_e)
            continue;
        picture_bytes(&(nqm_picture){f->width, f->height, panel->rgb_cdm2, panel->delta_e, f->delta_e_max}, supersample,
                      &tone, panel_rgb);
        place(sheet, GAP + i % f->n_columns * (width + GAP), GAP + i / f->n_columns * (height + GAP), width, height,
              panel_rgb);
    }
    if (has_maps(f))
        draw_bar(sheet);
}

nqm_status nqm_figure_write(const char *path, const nqm_figure *f, nqm_error *err) {
    const size_t supersample = f->supersample ? f->supersample : 1;
    if (f->n_rows < 1 || f->n_rows > MAX_CELLS || f->n_columns < 1 || f->n_columns > MAX_CELLS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: a figure must have 1 to %d rows and columns", path, (int)MAX_CELLS);
    if (f->width < supersample || f->height < supersample || f->width % supersample || f->height % supersample ||
        f->width > NQM_IMAGE_MAX_WIDTH || f->height > NQM_IMAGE_MAX_WIDTH)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: panels of %zu x %zu pixels cannot be reduced by %zu", path, f->width,
                        f->height, supersample);
    if (has_maps(f) && !(f->delta_e_max > 0))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: maps need a scale above 0", path);
    nqm_raster sheet = {.width = GAP + f->n_columns * (f->width / supersample + GAP) + (has_maps(f) ? BAR + GAP : 0),
                        .height = GAP + f->n_rows * (f->height / supersample + GAP),
                        .channels = 3};
    if (sheet.width > MAX_SIDE || sheet.height > MAX_SIDE)
        return nqm_fail(err, NQM_ERR_LIMIT, -1, "%s: a figure of %zu x %zu pixels; at most %d a side", path,
                        sheet.width, sheet.height, (int)MAX_SIDE);
    unsigned char *panel_rgb;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&sheet.data, sheet.width * sheet.height, 3}, {&panel_rgb, f->width * f->height, 3}), err);
    if (status != NQM_OK)
        return status;
    draw(&sheet, f, supersample, panel_rgb);
    status = nqm_raster_write_png(path, &sheet, true, NULL, err);
    nqm_free(sheet.data);
    return status;
}
