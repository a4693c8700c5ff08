/* SPDX-License-Identifier: MIT
 *
 * A sheet to a file: the layout of title, legend, panels and note, and cairo's surfaces for SVG, PDF and PNG.
 */
#include "figures/draw.h"
#include "io/io.h"
#include "io/raster.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <math.h>
#include <string.h>

enum { MARGIN = 12, GAP = 14 };

/* ---- layout ------------------------------------------------------------------------------------------------------ */

static void draw_panel(cairo_t *cr, nqm_box box, const nqm_sheet_panel *panel) {
    if (panel->chart)
        nqm_chart_draw(cr, box, panel->chart);
    if (panel->heat)
        nqm_heat_draw(cr, box, panel->heat);
    if (panel->bars)
        nqm_bars_draw(cr, box, panel->bars);
    if (panel->table)
        nqm_table_draw(cr, box, panel->table);
}

static void draw_panels(cairo_t *cr, nqm_box box, const nqm_sheet *sheet) {
    double width = (box.width - GAP * (double)(sheet->n_columns - 1)) / (double)sheet->n_columns;
    double all = box.height - GAP * (double)(sheet->n_rows - 1), y = box.y;
    for (size_t i = 0; i < sheet->n_rows; ++i) {
        double height = all * (sheet->row_heights ? sheet->row_heights[i] : 1 / (double)sheet->n_rows);
        for (size_t k = 0; k < sheet->n_columns; ++k)
            draw_panel(cr, (nqm_box){box.x + (width + GAP) * (double)k, y, width, height},
                       &sheet->panels[i * sheet->n_columns + k]);
        y += height + GAP;
    }
}

enum { NOTE_BYTES = 512, NOTE_STEP = 16 };

/* Length in bytes of the first line of `text`: up to a line feed, or as many words as fit into the width. */
static size_t first_line(cairo_t *cr, const char *text, double width) {
    size_t end = strcspn(text, "\n"), n = 0;
    for (size_t next = 0; next < end && next < NOTE_BYTES - 1;) {
        char line[NOTE_BYTES];
        next += 1 + strcspn(text + next + 1, " \n");
        snprintf(line, sizeof line, "%.*s", (int)next, text);
        if (n > 0 && nqm_label_width(cr, line, NQM_SMALL_FONT) > width)
            return n;
        n = next;
    }
    return n;
}

/* Lines of small text at the bottom of the box; returns their height. */
static double draw_note(cairo_t *cr, nqm_box box, const char *note) {
    size_t n_lines = 0;
    for (const char *p = note; *p; ++n_lines) {
        p += first_line(cr, p, box.width);
        p += *p != 0;
    }
    double height = NOTE_STEP * (double)n_lines, y = box.y + box.height - height + NQM_SMALL_FONT;
    nqm_draw_grey(cr, 0.3);
    for (; *note; y += NOTE_STEP) {
        char line[NOTE_BYTES];
        size_t n = first_line(cr, note, box.width);
        snprintf(line, sizeof line, "%.*s", (int)n, note);
        nqm_label_draw(cr, box.x, y, NQM_LEFT, NQM_SMALL_FONT, line);
        note += n + (note[n] != 0);
    }
    return height + 6;
}

static void draw_sheet(cairo_t *cr, const nqm_sheet *sheet) {
    nqm_box box = {MARGIN, MARGIN, sheet->width - 2 * MARGIN, sheet->height - 2 * MARGIN};
    nqm_draw_grey(cr, 1);
    cairo_paint(cr);
    if (sheet->title && *sheet->title) {
        nqm_draw_grey(cr, 0);
        nqm_text_draw(cr, sheet->width / 2, box.y + NQM_TITLE_FONT, NQM_CENTRE, NQM_TITLE_FONT, box.width,
                      sheet->title);
        box.y += NQM_TITLE_FONT + 12;
        box.height -= NQM_TITLE_FONT + 12;
    }
    double legend = nqm_legend_draw(cr, box, sheet);
    box.y += legend;
    box.height -= legend;
    if (sheet->note)
        box.height -= draw_note(cr, box, sheet->note);
    draw_panels(cr, box, sheet);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

nqm_status nqm_surface_write_png(const char *path, cairo_surface_t *surface, nqm_error *err) {
    cairo_surface_flush(surface);
    const unsigned char *data = cairo_image_surface_get_data(surface);
    size_t stride = (size_t)cairo_image_surface_get_stride(surface);
    size_t width = (size_t)cairo_image_surface_get_width(surface);
    size_t height = (size_t)cairo_image_surface_get_height(surface);
    unsigned char *rgb = nqm_alloc(width * height, 3);
    if (!rgb)
        return nqm_fail_nomem(err, 3 * width * height);
    for (size_t i = 0; i < width * height; ++i) {
        uint32_t pixel;
        memcpy(&pixel, data + i / width * stride + 4 * (i % width), sizeof pixel);
        for (size_t k = 0; k < 3; ++k)
            rgb[3 * i + k] = (unsigned char)(pixel >> (16 - 8 * k));
    }
    nqm_status status = nqm_raster_write_png(path, &(nqm_raster){width, height, 3, NQM_RASTER_U8, rgb}, true, err);
    nqm_free(rgb);
    return status;
}

/* Vector surfaces write their last data when they are finished. */
static nqm_status draw_on(cairo_surface_t *surface, const char *path, const nqm_sheet *sheet, double scale,
                          nqm_error *err) {
    cairo_t *cr = cairo_create(surface);
    cairo_scale(cr, scale, scale);
    draw_sheet(cr, sheet);
    cairo_status_t drawn = cairo_status(cr);
    cairo_destroy(cr);
    if (drawn == CAIRO_STATUS_SUCCESS && cairo_surface_get_type(surface) != CAIRO_SURFACE_TYPE_IMAGE) {
        cairo_surface_finish(surface);
        drawn = cairo_surface_status(surface);
    }
    if (drawn == CAIRO_STATUS_SUCCESS)
        return NQM_OK;
    return nqm_fail(err, drawn == CAIRO_STATUS_WRITE_ERROR ? NQM_ERR_IO : NQM_ERR_NOMEM, -1,
                    "%s: the drawing failed: %s", path, cairo_status_to_string(drawn));
}

static nqm_status write_png(const char *path, const nqm_sheet *sheet, double scale, nqm_error *err) {
    int width = (int)ceil(scale * sheet->width), height = (int)ceil(scale * sheet->height);
    cairo_surface_t *surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height);
    nqm_status status = draw_on(surface, path, sheet, scale, err);
    if (status == NQM_OK)
        status = nqm_surface_write_png(path, surface, err);
    cairo_surface_destroy(surface);
    return status;
}

/* cairo counts the surfaces of a process in the names of groups, id="surface5". Nothing refers to these names; they all
 * become "surface0", so that a drawing does not depend on what the process drew before. */
static cairo_status_t take_svg(void *out, const unsigned char *data, unsigned int n) {
    static const char id[] = "id=\"surface";
    const nqm_outfile *file = out;
    const size_t n_id = sizeof id - 1;
    for (unsigned int i = 0; i < n;) {
        if (n - i > n_id && memcmp(data + i, id, n_id) == 0) {
            fputs("id=\"surface0", file->stream);
            for (i += (unsigned int)n_id; i < n && data[i] >= '0' && data[i] <= '9'; ++i) {
            }
        } else {
            fputc(data[i++], file->stream);
        }
    }
    return ferror(file->stream) ? CAIRO_STATUS_WRITE_ERROR : CAIRO_STATUS_SUCCESS;
}

static cairo_status_t take_pdf(void *out, const unsigned char *data, unsigned int n) {
    const nqm_outfile *file = out;
    return fwrite(data, 1, n, file->stream) == n ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_WRITE_ERROR;
}

static nqm_status write_vector(const char *path, bool svg, const nqm_sheet *sheet, nqm_error *err) {
    nqm_outfile out;
    nqm_status status = nqm_outfile_open(path, &out, err);
    if (status != NQM_OK)
        return status;
    const double points = svg ? 1 : 0.75; /* a CSS pixel is 3/4 point, the unit of PDF */
    cairo_surface_t *surface = (svg ? cairo_svg_surface_create_for_stream : cairo_pdf_surface_create_for_stream)(
        svg ? take_svg : take_pdf, &out, points * sheet->width, points * sheet->height);
    if (svg)
        cairo_svg_surface_set_document_unit(surface, CAIRO_SVG_UNIT_PX);
    else /* a fixed date: by default, cairo stores the time of day */
        cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATE_DATE, "2000-01-01T00:00:00Z");
    status = draw_on(surface, path, sheet, points, err);
    cairo_surface_destroy(surface);
    if (status == NQM_OK)
        return nqm_outfile_commit(&out, err);
    nqm_outfile_abort(&out);
    return status;
}

nqm_status nqm_sheet_write(const char *path, const nqm_sheet *sheet, const nqm_plot_options *options, nqm_error *err) {
    const nqm_plot_options o = options ? *options : nqm_plot_options_default();
    nqm_sheet sized = *sheet;
    sized.title = o.title ? o.title : sheet->title;
    sized.width = o.width > 0 ? o.width : sheet->width;
    sized.height = o.height > 0 ? o.height : sheet->height;
    if (!(sized.width >= 200 && sized.width <= 4000 && sized.height >= 200 && sized.height <= 4000))
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        "%s: width and height of a drawing must be 200 to 4000 pixels, not %g x %g", path, sized.width,
                        sized.height);
    if (!(o.scale >= 0.5 && o.scale <= 8))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: the scale of a drawing must be 0.5 to 8", path);
    if (nqm_name_ends_in(path, ".png"))
        return write_png(path, &sized, o.scale, err);
    if (nqm_name_ends_in(path, ".svg") || nqm_name_ends_in(path, ".pdf"))
        return write_vector(path, nqm_name_ends_in(path, ".svg"), &sized, err);
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: the name of a drawing must end in .svg, .pdf or .png", path);
}
