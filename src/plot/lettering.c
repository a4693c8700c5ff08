/* SPDX-License-Identifier: MIT
 *
 * Text from outlines: UTF-8 to characters, quadratic curves to cubic ones, and lines that must fit.
 */
#include "plot/lettering.h"

#include "plot/glyphs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

static void draw_line(cairo_t *cr, double x, double y, double size, const char *text) {
    cairo_save(cr);
    cairo_translate(cr, x, y);
    cairo_scale(cr, size / GLYPH_UNITS, -size / GLYPH_UNITS);
    cairo_set_fill_rule(cr, CAIRO_FILL_RULE_WINDING);
    for (uint32_t c; (c = next_character(&text)) != 0;) {
        const struct glyph *g = find_glyph(c);
        const int16_t *contour = glyph_outlines + g->first;
        for (int i = 0; i < g->n_contours; ++i, contour += 1 + 2 * contour[0])
            contour_path(cr, contour);
        cairo_fill(cr);
        cairo_translate(cr, g->advance, 0);
    }
    cairo_restore(cr);
}

void nqm_text_draw(cairo_t *cr, double x, double y, nqm_align align, double size, double room, const char *text) {
    char shown[256];
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
