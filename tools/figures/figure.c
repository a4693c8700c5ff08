/* SPDX-License-Identifier: MIT
 *
 * Figures: a grid of pictures and maps of differences, with a bar of the maps' colours. Lengths are pixels.
 */
#include "figures/picture.h"
#include "io/io.h"
#include "io/raster.h"

#include <string.h>

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
        nqm_picture_bytes(&(nqm_picture){BAR, 1, NULL, values, 1}, 1, NULL, rgb);
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
        nqm_picture_bytes(&(nqm_picture){f->width, f->height, panel->rgb_cdm2, panel->delta_e, f->delta_e_max},
                          supersample, &tone, panel_rgb);
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
    status = nqm_raster_write_png(path, &sheet, true, err);
    nqm_free(sheet.data);
    return status;
}
