/* SPDX-License-Identifier: MIT
 *
 * Figures: a grid of pictures and maps with titles, captions and a colour scale. Lengths are pixels.
 */
#include "figures/draw.h"
#include "io/io.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

enum { MAX_CELLS = 64, MAX_SIDE = 16384, BAR_STEPS = 5 };

typedef struct layout {
    size_t panel_width, panel_height;
    double font, line; /* size of the font, distance of lines */
    double left, top;  /* corner of the first panel */
    double step_x, step_y;
    double bar_x, bar_width; /* place of the colour scale; bar_width 0: none */
    double delta_e_max;
    double width, height;
} layout;

static bool any_text(const char *const *texts, size_t n) {
    for (size_t i = 0; texts && i < n; ++i)
        if (texts[i])
            return true;
    return false;
}

static size_t caption_lines(const nqm_figure *f) {
    size_t most = 0;
    for (size_t i = 0; i < f->n_rows * f->n_columns; ++i) {
        size_t n = 0;
        for (const char *p = f->panels[i].caption; p && *p; p = strchr(p, '\n') ? strchr(p, '\n') + 1 : "")
            ++n;
        most = n > most ? n : most;
    }
    return most;
}

static bool is_map(const nqm_panel *panel) {
    return !panel->rgb_cdm2 && panel->delta_e;
}

/* The upper end of the colour scale; 0 when there are no maps. */
static nqm_status find_scale(const nqm_figure *f, double *end, nqm_error *err) {
    const double *maps[MAX_CELLS * MAX_CELLS];
    size_t n_maps = 0;
    *end = 0;
    for (size_t i = 0; i < f->n_rows * f->n_columns; ++i)
        if (is_map(&f->panels[i]))
            maps[n_maps++] = f->panels[i].delta_e;
    return n_maps ? nqm_map_scale(n_maps, maps, f->width * f->height, end, err) : NQM_OK;
}

static layout lay_out(const nqm_figure *f, size_t supersample, double delta_e_max) {
    layout l = {.panel_width = f->width / supersample, .panel_height = f->height / supersample};
    l.font = fmin(fmax(floor((double)l.panel_width / 11), 11), 16);
    l.line = ceil(1.35 * l.font);
    double gap = 6;
    l.left = gap + (any_text(f->row_titles, f->n_rows) ? l.line : 0);
    l.top = gap + (any_text(f->column_titles, f->n_columns) ? l.line : 0);
    l.step_x = (double)l.panel_width + gap;
    l.step_y = (double)l.panel_height + gap + l.line * (double)caption_lines(f);
    l.width = l.left + l.step_x * (double)f->n_columns;
    l.height = l.top + l.step_y * (double)f->n_rows;
    l.delta_e_max = delta_e_max;
    if (delta_e_max > 0) {
        l.bar_x = l.width + gap;
        l.bar_width = l.font;
        l.width = l.bar_x + l.bar_width + ceil(4.5 * l.font);
        l.top = fmax(l.top, gap + l.line);
        l.height = fmax(l.top + l.step_y * (double)f->n_rows, l.top + 8 * l.line);
    }
    return l;
}

static void place_panel(cairo_surface_t *surface, const layout *l, size_t row, size_t column,
                        const unsigned char *rgb) {
    cairo_surface_flush(surface);
    unsigned char *data = cairo_image_surface_get_data(surface);
    size_t stride = (size_t)cairo_image_surface_get_stride(surface);
    size_t left = (size_t)(l->left + l->step_x * (double)column), top = (size_t)(l->top + l->step_y * (double)row);
    for (size_t y = 0; y < l->panel_height; ++y)
        for (size_t x = 0; x < l->panel_width; ++x, rgb += 3) {
            uint32_t pixel = (uint32_t)rgb[0] << 16 | (uint32_t)rgb[1] << 8 | rgb[2];
            memcpy(data + (top + y) * stride + 4 * (left + x), &pixel, sizeof pixel);
        }
    cairo_surface_mark_dirty(surface);
}

static void draw_caption(cairo_t *cr, const layout *l, double x, double y, const char *caption) {
    for (; caption && *caption; y += l->line) {
        char line[256];
        size_t n = strcspn(caption, "\n"), n_kept = n < sizeof line ? n : sizeof line - 1;
        memcpy(line, caption, n_kept);
        line[n_kept] = 0;
        nqm_text_draw(cr, x, y + l->font, NQM_CENTRE, l->font, (double)l->panel_width + 4, line);
        caption += n + (caption[n] == '\n');
    }
}

static void draw_row_title(cairo_t *cr, const layout *l, size_t row, const char *title) {
    cairo_save(cr);
    cairo_translate(cr, l->left - 0.35 * l->line, l->top + l->step_y * (double)row + (double)l->panel_height / 2);
    cairo_rotate(cr, -NQM_PI / 2);
    nqm_text_draw(cr, 0, 0, NQM_CENTRE, l->font, (double)l->panel_height + 4, title);
    cairo_restore(cr);
}

static void draw_texts(cairo_t *cr, const nqm_figure *f, const layout *l) {
    double middle = l->left + (double)l->panel_width / 2;
    for (size_t c = 0; f->column_titles && c < f->n_columns; ++c)
        if (f->column_titles[c])
            nqm_text_draw(cr, middle + l->step_x * (double)c, l->top - 0.35 * l->line, NQM_CENTRE, l->font,
                          (double)l->panel_width + 4, f->column_titles[c]);
    for (size_t r = 0; f->row_titles && r < f->n_rows; ++r)
        if (f->row_titles[r])
            draw_row_title(cr, l, r, f->row_titles[r]);
    for (size_t i = 0; i < f->n_rows * f->n_columns; ++i) {
        size_t row = i / f->n_columns, column = i % f->n_columns;
        draw_caption(cr, l, middle + l->step_x * (double)column,
                     l->top + l->step_y * (double)row + (double)l->panel_height + 2, f->panels[i].caption);
    }
}

static void draw_scale(cairo_t *cr, const layout *l) {
    double top = l->top + ceil(l->line / 2); /* room between the highest number and the title */
    size_t n = (size_t)fmin(l->height - top - l->line, 320);
    double bottom = top + (double)n;
    const nqm_axis axis = {.max = l->delta_e_max};
    nqm_colour_bar_draw(cr, (nqm_box){l->bar_x, top, l->bar_width, (double)n}, &axis);
    cairo_set_source_rgb(cr, 0, 0, 0);
    cairo_set_line_width(cr, 1);
    double step = nqm_tick_step(l->delta_e_max, BAR_STEPS), right = l->bar_x + l->bar_width;
    size_t n_steps = (size_t)floor(l->delta_e_max / step * (1 + 1e-9));
    for (size_t i = 0; i <= n_steps; ++i) {
        char text[32], number[32];
        double tick = step * (double)i;
        double y = floor(bottom - tick / l->delta_e_max * (double)n) + 0.5;
        nqm_line_draw(cr, right, y, right + 4, y);
        bool last = tick > l->delta_e_max * (1 - 1e-9); /* larger values have this colour too */
        snprintf(text, sizeof text, "%s%s", last ? "\xe2\x89\xa5 " : "",
                 nqm_format_double(number, sizeof number, nqm_round_digits(tick, 6)));
        nqm_text_draw(cr, right + 7, y + 0.36 * l->font, NQM_LEFT, l->font, 4 * l->font, text);
    }
    nqm_text_draw(cr, l->bar_x - 2, l->top - 0.35 * l->line - 2, NQM_LEFT, l->font, l->width - l->bar_x,
                  "\xce\x94"
                  "E ITP");
}

static nqm_status draw_panels(cairo_surface_t *surface, const nqm_figure *f, const layout *l, size_t supersample,
                              const nqm_tone *tone, nqm_error *err) {
    unsigned char *rgb = nqm_alloc(l->panel_width * l->panel_height, 3);
    if (!rgb)
        return nqm_fail_nomem(err, 3 * l->panel_width * l->panel_height);
    for (size_t i = 0; i < f->n_rows * f->n_columns; ++i) {
        const nqm_panel *panel = &f->panels[i];
        const nqm_picture picture = {f->width, f->height, panel->rgb_cdm2, panel->delta_e, l->delta_e_max};
        if (!panel->rgb_cdm2 && !panel->delta_e)
            continue;
        nqm_picture_bytes(&picture, supersample, tone, rgb);
        place_panel(surface, l, i / f->n_columns, i % f->n_columns, rgb);
    }
    nqm_free(rgb);
    return NQM_OK;
}

static nqm_status draw(const char *path, const nqm_figure *f, const layout *l, size_t supersample, const nqm_tone *tone,
                       nqm_error *err) {
    cairo_surface_t *surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, (int)l->width, (int)l->height);
    cairo_t *cr = cairo_create(surface);
    cairo_set_source_rgb(cr, 1, 1, 1);
    cairo_paint(cr);
    nqm_status status = NQM_OK;
    if (cairo_status(cr) != CAIRO_STATUS_SUCCESS)
        status = nqm_fail_nomem(err, (size_t)(4 * l->width * l->height));
    if (status == NQM_OK)
        status = draw_panels(surface, f, l, supersample, tone, err);
    if (status == NQM_OK) {
        cairo_set_source_rgb(cr, 0, 0, 0);
        draw_texts(cr, f, l);
        if (l->delta_e_max > 0)
            draw_scale(cr, l);
        status = cairo_status(cr) == CAIRO_STATUS_SUCCESS ? nqm_surface_write_png(path, surface, err)
                                                          : nqm_fail_nomem(err, (size_t)(l->width * l->height));
    }
    cairo_destroy(cr);
    cairo_surface_destroy(surface);
    return status;
}

const char *nqm_cairo_version(void) {
    return cairo_version_string();
}

nqm_status nqm_figure_write(const char *path, const nqm_figure *f, nqm_error *err) {
    size_t supersample = f->supersample ? f->supersample : 1;
    const nqm_tone tone = f->tone.white_cdm2 > 0 ? f->tone : nqm_tone_default();
    if (f->n_rows < 1 || f->n_rows > MAX_CELLS || f->n_columns < 1 || f->n_columns > MAX_CELLS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: a figure must have 1 to %d rows and columns", path, (int)MAX_CELLS);
    if (f->width < supersample || f->height < supersample || f->width % supersample || f->height % supersample ||
        f->width > NQM_IMAGE_MAX_WIDTH || f->height > NQM_IMAGE_MAX_WIDTH)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: panels of %zu x %zu pixels cannot be reduced by %zu", path, f->width,
                        f->height, supersample);
    if (!(tone.shoulder > 0 && tone.shoulder <= 1))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: the shoulder of the tone curve must lie in (0, 1]", path);
    double delta_e_max;
    nqm_status status = find_scale(f, &delta_e_max, err);
    if (status != NQM_OK)
        return status;
    const layout l = lay_out(f, supersample, delta_e_max);
    if (l.width > MAX_SIDE || l.height > MAX_SIDE)
        return nqm_fail(err, NQM_ERR_LIMIT, -1, "%s: a figure of %.0f x %.0f pixels; at most %d a side", path, l.width,
                        l.height, (int)MAX_SIDE);
    return draw(path, f, &l, supersample, &tone, err);
}
