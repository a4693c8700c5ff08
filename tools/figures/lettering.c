/* SPDX-License-Identifier: MIT
 *
 * Colours, and text set in DejaVu Sans, or the nearest font that the machine has.
 */
#include "figures/draw.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

enum { TEXT_BYTES = 256 }; /* bytes of a line, with its final 0 */

void nqm_draw_colour(cairo_t *cr, size_t style, double alpha) {
    /* Okabe and Ito 2008, "Color universal design"; yellow last, because it is faint on white. */
    static const unsigned char colours[NQM_STYLES][3] = {{0, 114, 178}, {213, 94, 0},   {0, 158, 115}, {204, 121, 167},
                                                         {230, 159, 0}, {86, 180, 233}, {0, 0, 0},     {240, 228, 66}};
    const unsigned char *c = colours[style % NQM_STYLES];
    cairo_set_source_rgba(cr, c[0] / 255.0, c[1] / 255.0, c[2] / 255.0, alpha);
}

void nqm_draw_grey(cairo_t *cr, double level) {
    cairo_set_source_rgb(cr, level, level, level);
}

/* ---- text -------------------------------------------------------------------------------------------------------- */

/* Bytes of the valid UTF-8 sequence at p, without checks for overlong forms; 0 for a broken one. */
static size_t sequence_length(const unsigned char *p) {
    size_t n = *p < 0x80 ? 1 : *p < 0xc2 ? 0 : *p < 0xe0 ? 2 : *p < 0xf0 ? 3 : *p < 0xf5 ? 4 : 0;
    for (size_t i = 1; i < n; ++i)
        if ((p[i] & 0xc0) != 0x80)
            return 0;
    return n;
}

/* Copy the start of `text`, cut at the end of a character, with '?' for each byte that is not UTF-8: cairo refuses to
 * draw such text, and file names may contain it. */
static void copy_text(const char *text, char line[TEXT_BYTES]) {
    size_t n_line = 0;
    while (*text) {
        size_t n = sequence_length((const unsigned char *)text), n_copied = n ? n : 1;
        if (n_line + n_copied > TEXT_BYTES - sizeof "...")
            break;
        memcpy(line + n_line, n ? text : "?", n_copied);
        n_line += n_copied;
        text += n_copied;
    }
    strcpy(line + n_line, *text ? "..." : "");
}

/* Unhinted, so that the layout is the same at every scale. */
static double set_font(cairo_t *cr, double size, const char *line) {
    cairo_font_options_t *options = cairo_font_options_create();
    cairo_text_extents_t extents;
    cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    cairo_set_font_options(cr, options);
    cairo_font_options_destroy(options);
    cairo_select_font_face(cr, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(cr, size);
    cairo_text_extents(cr, line, &extents);
    return extents.x_advance;
}

double nqm_text_width(cairo_t *cr, const char *text, double size) {
    char line[TEXT_BYTES];
    copy_text(text, line);
    return set_font(cr, size, line);
}

void nqm_text_draw(cairo_t *cr, double x, double y, nqm_align align, double size, double room, const char *text) {
    char line[TEXT_BYTES];
    copy_text(text, line);
    double width = set_font(cr, size, line);
    if (width > room)
        width = set_font(cr, size * fmax(room / width, 2.0 / 3), line);
    for (size_t n = strlen(line); n > 0 && width > room * (1 + 1e-9); width = set_font(cr, size * 2 / 3, line)) {
        --n;
        while (n > 0 && ((unsigned char)line[n] & 0xc0) == 0x80) /* cut between characters */
            --n;
        strcpy(line + n, "...");
    }
    cairo_move_to(cr, align == NQM_LEFT ? x : align == NQM_RIGHT ? x - width : x - width / 2, y);
    if (cairo_surface_get_type(cairo_get_target(cr)) != CAIRO_SURFACE_TYPE_IMAGE) {
        cairo_show_text(cr, line);
        return;
    }
    cairo_text_path(cr, line); /* cairo_show_text() would round the place of each glyph to whole pixels */
    cairo_fill(cr);
}

/* ---- subscripts and superscripts --------------------------------------------------------------------------------- */

/* Copy the next run of text of one size; *shift is its height above the baseline in em. false at the end. */
static bool next_run(const char **text, char run[TEXT_BYTES], double *shift) {
    const char *p = *text;
    if (!*p)
        return false;
    bool is_small = (p[0] == '_' || p[0] == '^') && p[1] == '{';
    *shift = is_small ? (p[0] == '_' ? -0.2 : 0.4) : 0;
    size_t n = 0;
    p += is_small ? 2 : 0;
    for (; *p && (is_small ? *p != '}' : !((p[0] == '_' || p[0] == '^') && p[1] == '{')); ++p)
        if (n < TEXT_BYTES - 1)
            run[n++] = *p;
    run[n] = 0;
    *text = p + (is_small && *p);
    return true;
}

static double run_size(double size, double shift) {
    return shift == 0 ? size : 0.75 * size;
}

double nqm_label_width(cairo_t *cr, const char *text, double size) {
    char run[TEXT_BYTES];
    double shift, width = 0;
    while (next_run(&text, run, &shift))
        width += nqm_text_width(cr, run, run_size(size, shift));
    return width;
}

void nqm_label_draw(cairo_t *cr, double x, double y, nqm_align align, double size, const char *text) {
    char run[TEXT_BYTES];
    double shift, width = nqm_label_width(cr, text, size);
    x -= align == NQM_LEFT ? 0 : align == NQM_RIGHT ? width : width / 2;
    while (next_run(&text, run, &shift)) {
        double font = run_size(size, shift), run_width = nqm_text_width(cr, run, font);
        nqm_text_draw(cr, x, y - shift * size, NQM_LEFT, font, run_width + 1, run);
        x += run_width;
    }
}

void nqm_label_draw_upwards(cairo_t *cr, double x, double y, const char *text) {
    cairo_save(cr);
    cairo_translate(cr, x, y);
    cairo_rotate(cr, -NQM_PI / 2);
    nqm_label_draw(cr, 0, 0, NQM_CENTRE, NQM_FONT, text);
    cairo_restore(cr);
}
