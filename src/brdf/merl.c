/* SPDX-License-Identifier: MIT
 *
 * MERL tables (Matusik et al. 2003, DOI 10.1145/882262.882343): a measured BRDF as 90 x 90 x 180 cells in half-vector
 * coordinates, read and written. nqm_map_gather() reads the cells of about the first thousand pairs, because a page
 * fault costs more than reading a few bytes; later pairs are read from the mapping. The value of a pair is that of the
 * cell that contains it, without interpolation, as in the database's own reader. DTU tables (Nielsen et al. 2015, DOI
 * 10.1145/2816795.2818085) have the same layout.
 *
 * File, little-endian: int32 dimensions (90, 90, 180); double cells (3 channels, 90 theta_h, 90 theta_d, 180 phi_d).
 * theta_h is spaced by its square root, denser towards the highlight; negative cells have no measurement.
 */
#include "brdf/brdf.h"

#include "math/math.h"
#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { N_THETA_H = 90, N_THETA_D = 90, N_PHI_D = 180, N_CELLS = N_THETA_H * N_THETA_D * N_PHI_D };
enum { HEADER_BYTES = 12, FILE_BYTES = HEADER_BYTES + 3 * N_CELLS * 8 };

static const double channel_scale[3] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};

static const unsigned char header[HEADER_BYTES] = {N_THETA_H, 0, 0, 0, N_THETA_D, 0, 0, 0, N_PHI_D, 0, 0, 0};

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* N_GATHERED: pairs to read with nqm_map_gather() before evaluations use the mapping. */
enum { N_GATHERED = 1024, GATHER_BLOCK = 512 };

typedef struct merl {
    nqm_map map;
    atomic_int gathered;     /* remaining pairs to read with nqm_map_gather() */
    atomic_int *gather_left; /* &gathered: evaluations get a const table but decrement it */
} merl;

static size_t cell_index(double position, size_t n) {
    return position >= (double)n ? n - 1 : (size_t)fmax(position, 0);
}

/* Index of the cell that contains hd (3), within one channel. */
static size_t find_cell(const double *hd) {
    size_t h = cell_index(sqrt(hd[0] / (NQM_PI / 2)) * N_THETA_H, N_THETA_H);
    size_t d = cell_index(hd[1] / (NQM_PI / 2) * N_THETA_D, N_THETA_D);
    size_t p = cell_index(hd[2] / NQM_PI * N_PHI_D, N_PHI_D);
    return (h * N_THETA_D + d) * N_PHI_D + p;
}

static size_t cell_offset(size_t channel, size_t cell) {
    return HEADER_BYTES + 8 * (channel * N_CELLS + cell);
}

static double settle(const unsigned char *stored, size_t channel) {
    double value = nqm_load_f64(stored);
    return value >= 0 ? value * channel_scale[channel] : NAN;
}

static void gather_block(const nqm_map *map, size_t n, const double *hd, double *rgb) {
    unsigned char stored[3 * GATHER_BLOCK][8];
    nqm_piece pieces[3 * GATHER_BLOCK];
    for (size_t i = 0; i < n; ++i) {
        size_t cell = find_cell(hd + 3 * i);
        for (size_t c = 0; c < 3; ++c)
            pieces[3 * i + c] = (nqm_piece){cell_offset(c, cell), stored[3 * i + c]};
    }
    nqm_map_gather(map, 3 * n, pieces, sizeof *stored);
    for (size_t i = 0; i < 3 * n; ++i)
        rgb[i] = settle(stored[i], i % 3);
}

static void merl_eval_half_diff(const void *self, size_t n, const double *hd, double *rgb) {
    const merl *table = self;
    size_t i = 0;
    while (i < n && atomic_load_explicit(table->gather_left, memory_order_relaxed) > 0) {
        size_t n_block = n - i < GATHER_BLOCK ? n - i : GATHER_BLOCK;
        atomic_fetch_sub(table->gather_left, (int)n_block);
        gather_block(&table->map, n_block, hd + 3 * i, rgb + 3 * i);
        i += n_block;
    }
    for (; i < n; ++i) {
        size_t cell = find_cell(hd + 3 * i);
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = settle(table->map.data + cell_offset(c, cell), c);
    }
}

static void merl_free(void *self) {
    merl *table = self;
    nqm_map_close(&table->map);
    nqm_free(table);
}

static const nqm_brdf_class merl_class = {
    .format = "merl", .reciprocal = 1, .eval_half_diff = merl_eval_half_diff, .free = merl_free};

bool nqm_merl_probe(const nqm_map *map) {
    bool header_right = map->n_bytes >= HEADER_BYTES && memcmp(map->data, header, HEADER_BYTES) == 0;
    return header_right || map->n_bytes == FILE_BYTES;
}

/* Detect files without finite values. It reads 16 cells at each of 16 positions, because reading all cells would load
 * the whole file. */
static bool any_cell_finite(const nqm_map *map) {
    enum { N_PAGES = 16, N_PER_PAGE = 16 };
    for (size_t page = 0; page < N_PAGES; ++page) {
        const unsigned char *cells = map->data + HEADER_BYTES + 8 * (page * (N_CELLS / N_PAGES));
        for (size_t k = 0; k < N_PER_PAGE; ++k)
            if (isfinite(nqm_load_f64(cells + 8 * k)))
                return true;
    }
    return false;
}

nqm_status nqm_merl_open(nqm_map *map, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    if (map->n_bytes < HEADER_BYTES || memcmp(map->data, header, HEADER_BYTES) != 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0,
                        "%s: has the size of a MERL table, but byte 0 does not begin 90 x 90 x 180", map->path);
    if (map->n_bytes != FILE_BYTES) {
        size_t at = map->n_bytes < FILE_BYTES ? map->n_bytes : FILE_BYTES;
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)at,
                        "%s: a MERL table has %d bytes, this file has %zu: %s at byte %zu", map->path, FILE_BYTES,
                        map->n_bytes, at < FILE_BYTES ? "it ends" : "more follows", at);
    }
    if (!any_cell_finite(map))
        return nqm_fail(err, NQM_ERR_FORMAT, HEADER_BYTES, "%s: no finite value in the cells looked at from byte %d on",
                        map->path, HEADER_BYTES);
    merl *table = nqm_alloc(1, sizeof *table);
    if (!table)
        return nqm_fail_nomem(err, sizeof *table);
    nqm_map_expect(map, false);
    table->map = *map;
    table->gathered = map->has_fd ? N_GATHERED : 0;
    table->gather_left = &table->gathered;
    *map = (nqm_map){0};
    const nqm_brdf_info info = {.name = name,
                                .source_doi = "10.1145/882262.882343",
                                .layout = "90 x 90 x 180 cells",
                                .n_values = 3 * (size_t)N_CELLS,
                                .n_bytes = FILE_BYTES};
    return nqm_brdf_wrap(&merl_class, table, &info, brdf_ret, err);
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

enum { N_LINES = N_THETA_H * N_THETA_D }; /* a line: the cells of one theta_h and theta_d, over phi_d */

typedef struct fill_job {
    const nqm_brdf *brdf;
    double *cells; /* (3, N_LINES, N_PHI_D), as stored */
    size_t first_line;
} fill_job;

static void fill_line(void *user, size_t i) {
    const fill_job *job = user;
    size_t line = job->first_line + i;
    /* NOLINTNEXTLINE(bugprone-integer-division): the integer quotient is the index of theta_h */
    double root_h = ((double)(line / N_THETA_D) + 0.5) / N_THETA_H;
    double hd[3 * N_PHI_D], rgb[3 * N_PHI_D];
    uint8_t flag[N_PHI_D];
    for (size_t p = 0; p < N_PHI_D; ++p) {
        hd[3 * p] = root_h * root_h * NQM_PI / 2;
        hd[3 * p + 1] = ((double)(line % N_THETA_D) + 0.5) / N_THETA_D * NQM_PI / 2;
        hd[3 * p + 2] = ((double)p + 0.5) / N_PHI_D * NQM_PI;
    }
    nqm_brdf_eval_half_diff(job->brdf, N_PHI_D, hd, rgb, flag);
    for (size_t p = 0; p < N_PHI_D; ++p) {
        bool empty = !nqm_has_value(flag[p]);
        for (size_t c = 0; c < 3; ++c)
            job->cells[c * N_CELLS + line * N_PHI_D + p] = empty ? -1 : rgb[3 * p + c] / channel_scale[c];
    }
}

nqm_status nqm_brdf_write_merl(const nqm_brdf *brdf, const char *path, nqm_progress_fn progress, void *progress_user,
                               nqm_error *err) {
    enum { LINES_PER_STEP = N_LINES / 15 }; /* lines between two calls of the progress callback */
    double *cells = nqm_alloc(3 * (size_t)N_CELLS, sizeof *cells);
    if (!cells)
        return nqm_fail_nomem(err, 3 * (size_t)N_CELLS * sizeof *cells);
    nqm_ticker ticker = {.fn = progress, .user = progress_user};
    nqm_outfile out;
    nqm_status status = NQM_OK;
    for (size_t line = 0; line < N_LINES && status == NQM_OK; line += LINES_PER_STEP) {
        fill_job job = {.brdf = brdf, .cells = cells, .first_line = line};
        nqm_parallel_for(LINES_PER_STEP, fill_line, &job);
        if (nqm_tick(&ticker, "convert", (double)(line + LINES_PER_STEP), N_LINES))
            status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "%s: interrupted, nothing was written", path);
    }
    if (status == NQM_OK)
        status = nqm_outfile_open(path, &out, err);
    if (status == NQM_OK) {
        fwrite(header, 1, sizeof header, out.stream);
        fwrite(cells, sizeof *cells, 3 * (size_t)N_CELLS, out.stream);
        status = nqm_outfile_commit(&out, err); /* checks the stream's error flag */
    }
    nqm_free(cells);
    return status;
}
