/* SPDX-License-Identifier: MIT
 *
 * The implementation of textured.h.
 */
#include "nqm/textured.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

bool is_textured(const char *argument) {
    nqm_argument *a = parse_argument(argument);
    const bool is = nqm_argument_is_textured(a);
    nqm_argument_free(a);
    return is;
}

bool is_library(const char *argument) {
    nqm_argument *a = parse_argument(argument);
    const nqm_textured *maps;
    nqm_textured *owned = NULL;
    const bool is = a->kind == NQM_ARGUMENT_FOLDER && nqm_argument_maps(a, &maps, &owned, NULL) != NQM_OK;
    nqm_textured_free(owned);
    nqm_argument_free(a);
    return is;
}

nqm_status explain_texture(const char *argument, nqm_status status, nqm_error *err) {
    if (status != NQM_OK && is_library(argument))
        snprintf(err->message, sizeof err->message,
                 "%.300s: a folder of files; this verb needs one BRDF: name one of them, or translate the folder",
                 argument);
    else if (status != NQM_OK && is_textured(argument))
        snprintf(
            err->message, sizeof err->message,
            "%.300s: a material with image maps; this verb needs the BRDF of one point. score, batch, rank, report, "
            "info, check, label, render and translate take textures (doc/textures.md)",
            argument);
    return status;
}

nqm_status open_texture(nqm_argument *argument, nqm_texture **texture_ret, nqm_error *err) {
    const nqm_status status = nqm_texture_open_argument(argument, show_progress, NULL, texture_ret, err);
    if (status == NQM_OK && *nqm_texture_get_info(*texture_ret, NULL).remark)
        report(EXIT_OK, "%s: %s", shown(argument->text), nqm_texture_get_info(*texture_ret, NULL).remark);
    return status;
}

nqm_status open_texture_named(const char *argument, nqm_texture **texture_ret, nqm_error *err) {
    nqm_argument *a = parse_argument(argument);
    const nqm_status status = open_texture(a, texture_ret, err);
    nqm_argument_free(a);
    return status;
}

/* ---- texels ------------------------------------------------------------------------------------------------------ */

nqm_status visit_texels(const nqm_texture *texture, size_t max_n, nqm_texels_visitor *visit, void *user,
                        nqm_error *err) {
    nqm_texel_sample *samples = allocate(max_n, sizeof *samples);
    nqm_texture_job job = {.options = nqm_texture_options_default(), .side = {texture, texture}};
    for (size_t axis = 0; axis < 2; ++axis)
        job.period[axis] = 1 / (double)nqm_texture_tiles(texture, texture, axis, axis ? &job.height : &job.width);
    nqm_status status = nqm_texels_compare(&job, err);
    if (status == NQM_OK) {
        const size_t n = nqm_texels_choose(&job.order, max_n, 1, samples);
        status = nqm_texels_visit(&job, NULL, n, samples, visit, user, err);
    }
    nqm_free(job.order.texels);
    free(samples);
    return status;
}

/* ---- pictures of maps -------------------------------------------------------------------------------------------- */

typedef struct texel_job {
    const nqm_texture *texture;
    const size_t *tiles;
    texel_writer *write;
    void *user;
    nqm_raster *picture;
    atomic_bool has_failed; /* out of memory */
} texel_job;

static void write_row(void *user, size_t y) {
    enum { BLOCK = NQM_TEXEL_BLOCK };
    texel_job *job = user;
    const nqm_raster *r = job->picture;
    double u[BLOCK], v[BLOCK];
    float *rows = nqm_alloc((size_t)job->texture->n_rows * BLOCK, sizeof *rows);
    if (!rows)
        atomic_store(&job->has_failed, true);
    for (size_t first = 0, n; rows && first < r->width; first += n) {
        n = nqm_smaller(r->width - first, BLOCK);
        for (size_t i = 0; i < n; ++i) {
            u[i] = ((double)(first + i) + 0.5) / (double)(r->width * job->tiles[0]);
            v[i] = ((double)y + 0.5) / (double)(r->height * job->tiles[1]);
        }
        nqm_texture_evaluate(job->texture, n, u, v, rows);
        for (size_t i = 0; i < n; ++i)
            job->write(job->user, rows, i, (unsigned char *)r->data + r->channels * (y * r->width + first + i));
    }
    nqm_free(rows);
}

nqm_status write_texels(const nqm_texture *texture, const size_t tiles[2], texel_writer *write, void *user,
                        nqm_raster *picture, nqm_error *err) {
    const size_t n = picture->width * picture->height * picture->channels;
    texel_job job = {texture, tiles, write, user, picture, false};
    nqm_ticker ticker = {.fn = show_progress};
    picture->data = nqm_alloc(n, 1);
    if (!picture->data)
        return nqm_fail_nomem(err, n);
    memset(picture->data, 255, n);
    if (nqm_parallel_ticking(&ticker, "maps", picture->height, write_row, &job))
        return nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
    return atomic_load(&job.has_failed) ? nqm_fail_nomem(err, n) : NQM_OK;
}

unsigned char unit_byte(double v) {
    return (unsigned char)(fmin(fmax(v, 0), 1) * 255 + 0.5);
}

view_args view_args_begin(void) {
    const nqm_texture_view v = nqm_scene_texture_view_default();
    return (view_args){(uint64_t)v.tiles, v.n_samples};
}

nqm_texture_view view_of(const view_args *args) {
    nqm_texture_view v = nqm_scene_texture_view_default();
    v.tiles = (double)args->tiles;
    v.n_samples = (size_t)args->texels;
    return v;
}
