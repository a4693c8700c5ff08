/* SPDX-License-Identifier: MIT
 *
 * Text from outlines: UTF-8 to characters, quadratic curves to cubic ones, lines that must fit, and the font that keeps
 * an SVG small.
 */
#include "figures/lettering.h"

#include "figures/glyphs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TEXT_BYTES = 256 }; /* of a line */

static int compare_glyph(const void *key, const void *glyph) {
    uint32_t a = *(const uint32_t *)key, b = ((const struct glyph *)glyph)->character;
    return (a > b) - (a < b);
}

static const struct glyph *find_glyph(uint32_t character) {
    static const uint32_t unknown = '?';
    const struct glyph *g = bsearch(&character, glyphs, GLYPH_COUNT, sizeof *glyphs, compare_glyph);
    return g ? g : bsearch(&unknown, glyphs, GLYPH_COUNT, sizeof *glyphs, compare_glyph);
}

/* The character at *text, which moves behind it; 0 at the end. A broken sequence counts byte by byte. */
static uint32_t next_character(const char **text) {
    const unsigned char *p = (const unsigned char *)*text;
    uint32_t c = *p;
    if (c == 0)
        return 0;
    size_t n = c >= 0xf0 ? 3 : c >= 0xe0 ? 2 : c >= 0xc0 ? 1 : 0;
    uint32_t value = n ? c & (0x3fU >> n) : c;
    for (size_t i = 1; i <= n; ++i) {
        if ((p[i] & 0xc0) != 0x80) {
            n = 0;
            value = c;
            break;
        }
        value = value << 6 | (p[i] & 0x3f);
    }
    *text += n + 1;
    return value;
}

double nqm_text_width(const char *text, double size) {
    double units = 0;
    for (uint32_t c; (c = next_character(&text)) != 0;)
        units += find_glyph(c)->advance;
    return units * size / GLYPH_UNITS;
}

/* Point i of a contour (cyclic), in em units; true: on the curve. */
static bool point_of(const int16_t *contour, int i, double *x, double *y) {
    const int16_t *p = contour + 1 + 2 * (i % contour[0]);
    bool on = p[0] & 1;
    *x = (p[0] - on) * 0.5;
    *y = p[1];
    return on;
}

static void curve_to(cairo_t *cr, double cx, double cy, double x, double y) {
    double x0, y0;
    cairo_get_current_point(cr, &x0, &y0);
    cairo_curve_to(cr, x0 + (cx - x0) * 2 / 3, y0 + (cy - y0) * 2 / 3, x + (cx - x) * 2 / 3, y + (cy - y) * 2 / 3, x,
                   y);
}

static void contour_path(cairo_t *cr, const int16_t *contour) {
    double x, y, next_x, next_y;
    (void)point_of(contour, 0, &x, &y);
    cairo_move_to(cr, x, y);
    for (int i = 1; i <= contour[0]; ++i) {
        if (point_of(contour, i, &x, &y)) {
            cairo_line_to(cr, x, y);
            continue;
        }
        if (point_of(contour, i + 1, &next_x, &next_y)) {
            ++i;
        } else {
            next_x = (x + next_x) / 2;
            next_y = (y + next_y) / 2;
        }
        curve_to(cr, x, y, next_x, next_y);
    }
    cairo_close_path(cr);
}

/* Fill a glyph at the origin, in units of the outlines. */
static void draw_glyph(cairo_t *cr, const struct glyph *g) {
    const int16_t *contour = glyph_outlines + g->first;
    cairo_set_fill_rule(cr, CAIRO_FILL_RULE_WINDING);
    for (int i = 0; i < g->n_contours; ++i, contour += 1 + 2 * contour[0])
        contour_path(cr, contour);
    cairo_fill(cr);
}

static void draw_outlines(cairo_t *cr, double x, double y, double size, const char *text) {
    cairo_save(cr);
    cairo_translate(cr, x, y);
    cairo_scale(cr, size / GLYPH_UNITS, -size / GLYPH_UNITS);
    for (uint32_t c; (c = next_character(&text)) != 0;) {
        const struct glyph *g = find_glyph(c);
        draw_glyph(cr, g);
        cairo_translate(cr, g->advance, 0);
    }
    cairo_restore(cr);
}

/* ---- as a font: SVG ---------------------------------------------------------------------------------------------- */

static cairo_status_t render_glyph(cairo_scaled_font_t *font, unsigned long index, cairo_t *cr,
                                   cairo_text_extents_t *extents) {
    (void)font;
    cairo_scale(cr, 1.0 / GLYPH_UNITS, -1.0 / GLYPH_UNITS);
    draw_glyph(cr, &glyphs[index]);
    extents->x_advance = (double)glyphs[index].advance / GLYPH_UNITS;
    return CAIRO_STATUS_SUCCESS;
}

static void destroy_face(void *face) {
    cairo_font_face_destroy(face);
}

/* The glyphs as a font, one for all text of a surface, which is how cairo knows a glyph again; NULL: out of memory. */
static cairo_font_face_t *face_of(cairo_surface_t *surface) {
    static const cairo_user_data_key_t key;
    cairo_font_face_t *face = cairo_surface_get_user_data(surface, &key);
    if (face)
        return face;
    face = cairo_user_font_face_create();
    cairo_user_font_face_set_render_glyph_func(face, render_glyph);
    if (cairo_surface_set_user_data(surface, &key, face, destroy_face) == CAIRO_STATUS_SUCCESS)
        return face;
    cairo_font_face_destroy(face);
    return NULL;
}

static void show_glyphs(cairo_t *cr, cairo_font_face_t *face, double x, double y, double size, const char *text) {
    cairo_glyph_t line[TEXT_BYTES];
    int n = 0;
    for (uint32_t c; (c = next_character(&text)) != 0; ++n) {
        const struct glyph *g = find_glyph(c);
        line[n] = (cairo_glyph_t){(unsigned long)(g - glyphs), x, y};
        x += g->advance * size / GLYPH_UNITS;
    }
    cairo_set_font_face(cr, face);
    cairo_set_font_size(cr, size);
    cairo_show_glyphs(cr, line, n);
}

/* An SVG holds a glyph of a font once, and an outline as often as it is drawn. On pixels outlines are better: they stand
 * where they belong, the glyphs of a font on whole pixels. `text` is shorter than TEXT_BYTES. */
static void draw_line(cairo_t *cr, double x, double y, double size, const char *text) {
    cairo_surface_t *target = cairo_get_target(cr);
    cairo_font_face_t *face = cairo_surface_get_type(target) == CAIRO_SURFACE_TYPE_SVG ? face_of(target) : NULL;
    if (face)
        show_glyphs(cr, face, x, y, size, text);
    else
        draw_outlines(cr, x, y, size, text);
}

void nqm_text_draw(cairo_t *cr, double x, double y, nqm_align align, double size, double room, const char *text) {
    char shown[TEXT_BYTES];
    double width = nqm_text_width(text, size), smallest = size * 2 / 3;
    size_t n = strnlen(text, sizeof shown - 4);
    memcpy(shown, text, n);
    memcpy(shown + n, text[n] ? "..." : "", text[n] ? 4 : 1);
    if (width > room)
        size = fmax(size * room / width, smallest);
    while (n > 0 && nqm_text_width(shown, size) > room * (1 + 1e-9)) {
        --n;
        while (n > 0 && ((unsigned char)shown[n] & 0xc0) == 0x80) /* not inside a character */
            --n;
        memcpy(shown + n, "...", 4);
    }
    width = nqm_text_width(shown, size);
    draw_line(cr, align == NQM_LEFT ? x : align == NQM_RIGHT ? x - width : x - width / 2, y, size, shown);
}
