/* SPDX-License-Identifier: MIT
 *
 * Pairs with a textured material in `nqm score` and its like: their scores, and what is said of them beside those of one BRDF.
 */
#include "figures/picture.h"
#include "io/io.h"
#include "nqm/score/score.h"
#include "nqm/textured.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- scores ------------------------------------------------------------------------------------------------------ */

/* A map of Delta-E that is to be written: the picture's format follows from its name. */
static void write_exr(const char *path, size_t width, size_t height, const float *delta_e) {
    nqm_image image = {width, height, allocate(3 * width * height, sizeof *image.rgb)};
    for (size_t i = 0; i < 3 * width * height; ++i)
        image.rgb[i] = delta_e[i / 3];
    must(nqm_image_write_exr(path, &image, &fault));
    free(image.rgb);
}

enum { LEAST_SIDE = 512, MOST_SIDE = 1024 };

/* Means over blocks of step x step texels, each as repeat x repeat pixels, so that the picture suits a screen: (*height, *width),
 * free() it. */
static double *resize(size_t *width, size_t *height, const float *delta_e) {
    const size_t longer = nqm_larger(*width, *height), step = nqm_ceil_div(longer, MOST_SIDE);
    const size_t repeat = nqm_larger(LEAST_SIDE / longer, 1), w = nqm_ceil_div(*width, step) * repeat,
                 h = nqm_ceil_div(*height, step) * repeat;
    double *mean = allocate(w * h, sizeof *mean);
    for (size_t y = 0; y < h; ++y)
        for (size_t x = 0; x < w; ++x) {
            const size_t left = x / repeat * step, upper = y / repeat * step;
            const size_t right = nqm_smaller(left + step, *width), lower = nqm_smaller(upper + step, *height);
            for (size_t i = upper; i < lower; ++i)
                for (size_t j = left; j < right; ++j)
                    mean[y * w + x] += (double)delta_e[i * *width + j];
            mean[y * w + x] /= (double)((right - left) * (lower - upper));
        }
    *width = w;
    *height = h;
    return mean;
}

double write_heat(const char *path, const nqm_texture_result *r, const float *delta_e) {
    size_t width = r->width, height = r->height;
    if (nqm_name_ends_in(path, ".exr")) {
        write_exr(path, width, height, delta_e);
        return NAN;
    }
    double *mean = resize(&width, &height, delta_e);
    double end;
    must(nqm_map_scale(1, (const double *const[]){mean}, width * height, &end, &fault));
    const nqm_panel panel = {.delta_e = mean};
    const nqm_figure figure = {
        .n_rows = 1, .n_columns = 1, .width = width, .height = height, .panels = &panel, .delta_e_max = end};
    must(nqm_figure_write(path, &figure, &fault));
    free(mean);
    return end;
}

void score_texture(const nqm_library_terms *terms, const nqm_named_pair *pair, nqm_library_kept *ref,
                   nqm_texture_result *t, nqm_score_result *result, float **heat, nqm_error *err) {
    *err = (nqm_error){0};
    err->status = nqm_library_score_texture(terms, pair, ref, t, result, heat, err);
    end_progress();
    if (err->status == NQM_ERR_CANCELLED)
        stop(EXIT_INTERRUPTED, "interrupted");
}

bool has_texture(const nqm_named_pair *pair) {
    return is_textured(pair->ref) || is_textured(pair->test);
}

void score_textures(score_run *run) {
    nqm_library_kept ref = {.name = NULL};
    const nqm_library_terms terms = {run->model,
                                     run->exact,
                                     run->map || run->keep_heat,
                                     run->near_only,
                                     (size_t)run->texels_per_pixel,
                                     show_progress,
                                     report_part,
                                     NULL};
    for (size_t i = 0; i < run->n_rows; ++i) {
        scored_pair *row = &run->rows[i];
        if (row->err.status == NQM_OK || !has_texture(&row->pair))
            continue;
        nqm_texture_result *t = allocate(1, sizeof *t);
        score_texture(&terms, &row->pair, &ref, t, &row->result, &row->heat, &row->err);
        row->heat_max = run->map && row->err.status == NQM_OK ? write_heat(run->map, t, row->heat) : NAN;
        if (!ref.texture && run->ref_path && strcmp(run->ref_path, row->pair.ref) == 0)
            stop_error(&row->err); /* the reference of all rows */
        row->texture = row->err.status == NQM_OK ? t : NULL;
        free(row->texture ? NULL : t);
    }
    nqm_texture_free(ref.texture);
}

/* ---- text -------------------------------------------------------------------------------------------------------- */

enum { MOST_BLAMED = 4 };
static const double blameless = 9.95;

static void print_blame(const nqm_texture_result *t) {
    char text[600];
    int n = 0;
    for (size_t i = 0; i < nqm_smaller(t->n_blame, MOST_BLAMED) && (t->blame[i].jod < blameless || i == 0); ++i) {
        const nqm_texture_blame *b = &t->blame[i];
        n += snprintf(text + n, sizeof text - (size_t)n, "%s%s alone: %.2f%s%s%s", n ? "; " : "", b->key, b->jod,
                      *b->mistake ? " (" : "", b->mistake, *b->mistake ? ")" : "");
    }
    if (n)
        print_phrases(text);
}

void print_texture(const scored_pair *row) {
    const nqm_texture_result *t = row->texture;
    char text[300], unit[80] = "texels";
    const size_t side = t->texels_per_pixel;
    if (side > 1)
        snprintf(unit, sizeof unit, "pixels of %zu x %zu texels", side, side);
    int n = snprintf(text, sizeof text, "%s: median %.2f, worst 5 %% below %.2f; %.1f %% below 9, %.1f %% below 8",
                     unit, t->median, t->worst, 100 * t->below[0], 100 * t->below[1]);
    if (!isnan(t->far_jod[0]))
        n += snprintf(text + n, sizeof text - (size_t)n, "; from afar %.2f [%.2f, %.2f]", t->far_jod[0], t->far_jod[1],
                      t->far_jod[2]);
    print_phrases(text);
    print_blame(t);
    if (t->error > 0 && side > 1)
        snprintf(text, sizeof text, "%zu pixels, standard error %.3f", t->n_scored, t->error);
    else
        snprintf(text, sizeof text, "%zu of %zu different pairs of %zu x %zu texels, standard error %.3f", t->n_scored,
                 t->n_different, t->width, t->height, t->error);
    if (t->error > 0)
        print_phrases(text);
    snprintf(text, sizeof text, "colours of the map: Delta-E 0 (dark) to %.6g and above (bright)", row->heat_max);
    if (!isnan(row->heat_max))
        print_phrases(text);
}

/* ---- JSON ------------------------------------------------------------------------------------------------ */

static json_t *json_blame(const nqm_texture_result *t) {
    json_t *list = json_array();
    for (size_t i = 0; i < t->n_blame; ++i)
        json_array_append_new(list, json_row("property:s jod:f mistake:o", t->blame[i].key, t->blame[i].jod,
                                             *t->blame[i].mistake ? json_string(t->blame[i].mistake) : json_null()));
    return list;
}

void set_texture(json_t *object, const scored_pair *row) {
    const nqm_texture_result *t = row->texture;
    json_set(object,
             "texture:{texels:[zz] different:z scored:z texels_per_pixel:z error:f far_delta_e_itp:f blame:o "
             "delta_e_max:o}",
             t->width, t->height, t->n_different, t->n_scored, t->texels_per_pixel, t->error, t->far_delta_e,
             json_blame(t), isnan(row->heat_max) ? NULL : json_number(row->heat_max));
    set_columns(object, COLUMNS_TEXTURE, NULL, &row->result, t);
}

bool has_textures(const score_run *run) {
    for (size_t i = 0; i < run->n_rows; ++i)
        if (run->rows[i].texture)
            return true;
    return false;
}

texture_numbers texture_numbers_of(const nqm_texture_result *t) {
    texture_numbers numbers;
    nqm_column c;
    for (size_t i = 0, k = 0; (c = nqm_pairs_column(i, NULL, t)).name; ++i)
        if (c.group == NQM_COLUMN_TEXTURE && k < TEXTURE_NUMBERS)
            numbers.v[k++] = c.number;
    return numbers;
}

void set_texture_numbers(json_t *object, const texture_numbers *numbers) {
    nqm_column c;
    for (size_t i = 0, k = 0; (c = nqm_pairs_column(i, NULL, NULL)).name; ++i)
        if (c.group == NQM_COLUMN_TEXTURE && k < TEXTURE_NUMBERS)
            json_object_set_new(object, c.name, json_number(numbers->v[k++]));
}
