/* SPDX-License-Identifier: MIT
 *
 * Colours of styles, and labels with subscripts and superscripts.
 */
#include "figures/draw.h"

#include <math.h>
#include <string.h>

void nqm_draw_colour(cairo_t *cr, size_t style, double alpha) {
    /* Okabe and Ito 2008, "Color universal design"; yellow last, which is faint on white. */
    static const unsigned char colours[NQM_STYLES][3] = {{0, 114, 178}, {213, 94, 0},   {0, 158, 115}, {204, 121, 167},
                                                         {230, 159, 0}, {86, 180, 233}, {0, 0, 0},     {240, 228, 66}};
    const unsigned char *c = colours[style % NQM_STYLES];
    cairo_set_source_rgba(cr, c[0] / 255.0, c[1] / 255.0, c[2] / 255.0, alpha);
}

void nqm_draw_grey(cairo_t *cr, double level) {
    cairo_set_source_rgb(cr, level, level, level);
}

/* The next run of text in one size: copied to `run`, *shift is how far up it stands in em. */
static bool next_run(const char **text, char run[256], double *shift) {
    const char *p = *text;
    if (!*p)
        return false;
    bool small = (p[0] == '_' || p[0] == '^') && p[1] == '{';
    *shift = small ? (p[0] == '_' ? -0.2 : 0.4) : 0;
    size_t n = 0;
    p += small ? 2 : 0;
    for (; *p && (small ? *p != '}' : !((p[0] == '_' || p[0] == '^') && p[1] == '{')); ++p)
        if (n < 255)
            run[n++] = *p;
    run[n] = 0;
    *text = p + (small && *p);
    return true;
}

static double size_of(double size, double shift) {
    return shift == 0 ? size : 0.75 * size;
}

double nqm_label_width(const char *text, double size) {
    char run[256];
    double shift, width = 0;
    while (next_run(&text, run, &shift))
        width += nqm_text_width(run, size_of(size, shift));
    return width;
}

void nqm_label_draw(cairo_t *cr, double x, double y, nqm_align align, double size, const char *text) {
    char run[256];
    double shift, width = nqm_label_width(text, size);
    x -= align == NQM_LEFT ? 0 : align == NQM_RIGHT ? width : width / 2;
    while (next_run(&text, run, &shift)) {
        double here = size_of(size, shift), run_width = nqm_text_width(run, here);
        nqm_text_draw(cr, x, y - shift * size, NQM_LEFT, here, run_width + 1, run);
        x += run_width;
    }
}
