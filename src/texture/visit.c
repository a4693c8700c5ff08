/* SPDX-License-Identifier: MIT
 *
 * One texture texel by texel: some that represent all, and pictures of its values.
 */
#include "texture/score.h"

#include <stdatomic.h>

nqm_status nqm_texture_visit(const nqm_texture *texture, size_t max_n, nqm_texels_visitor *visit, void *user,
                             nqm_error *err) {
    nqm_texel_sample *samples = nqm_alloc(max_n, sizeof *samples);
    nqm_texture_job job = {.options = nqm_texture_options_default(), .side = {texture, texture}};
    if (!samples)
        return nqm_fail_nomem(err, max_n * sizeof *samples);
    for (size_t axis = 0; axis < 2; ++axis)
        job.period[axis] = 1 / (double)nqm_texture_tiles(texture, texture, axis, axis ? &job.height : &job.width);
    nqm_status status = nqm_texels_compare(&job, err);
    if (status == NQM_OK) {
        const size_t n = nqm_texels_choose(&job.order, max_n, 1, samples);
        status = nqm_texels_visit(&job, NULL, n, samples, visit, user, err);
    }
    nqm_free(job.order.texels);
    nqm_free(samples);
    return status;
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

typedef struct picture_job {
    const nqm_texture *texture;
    const size_t *tiles;
    nqm_texel_writer *write;
    void *user;
    nqm_raster *picture;
    atomic_bool has_failed; /* out of memory */
} picture_job;

static void write_row(void *user, size_t y) {
    enum { BLOCK = NQM_TEXEL_BLOCK };
    picture_job *job = user;
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

nqm_status nqm_texture_write(const nqm_texture *texture, const size_t tiles[2], nqm_texel_writer *write, void *user,
                             nqm_ticker *ticker, nqm_raster *picture, nqm_error *err) {
    const size_t n = picture->width * picture->height * picture->channels;
    picture_job job = {texture, tiles, write, user, picture, false};
    picture->data = nqm_alloc(n, 1);
    if (!picture->data)
        return nqm_fail_nomem(err, n);
    memset(picture->data, 255, n);
    if (nqm_parallel_ticking(ticker, "maps", picture->height, write_row, &job))
        return nqm_fail(err, NQM_ERR_CANCELLED, -1, "cancelled");
    return atomic_load(&job.has_failed) ? nqm_fail_nomem(err, n) : NQM_OK;
}
