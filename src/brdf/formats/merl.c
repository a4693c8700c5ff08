/* SPDX-License-Identifier: MIT
 *
 * MERL tables (Matusik et al. 2003, DOI 10.1145/882262.882343), also with 360 cells in phi_d: read and written in the layout of
 * doc/files.md. nqm_map_gather() reads the cells of about the first thousand pairs, because a page fault costs more than reading a
 * few bytes; later pairs are read from the mapping.
 */
#include "brdf/formats/format.h"

#include <math.h>
#include <stdatomic.h>

/* A line: the cells of one theta_h and theta_d, over phi_d. */
enum { N_THETA_H = 90, N_THETA_D = 90, N_LINES = N_THETA_H * N_THETA_D, N_PHI_HALF = 180, N_PHI_FULL = 360 };
enum { HEADER_BYTES = 12 };

static size_t count_cells(size_t n_phi) {
    return N_LINES * n_phi;
}

static size_t file_bytes(size_t n_phi) {
    return HEADER_BYTES + 3 * count_cells(n_phi) * sizeof(double);
}

static const double channel_scale[3] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};

static void make_header(size_t n_phi, unsigned char *header) {
    nqm_store_u32(header, N_THETA_H);
    nqm_store_u32(header + 4, N_THETA_D);
    nqm_store_u32(header + 8, (uint32_t)n_phi);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* N_GATHERED: pairs to read with nqm_map_gather() before evaluations use the mapping. */
enum { N_GATHERED = 1024, GATHER_BLOCK = 512 };

typedef struct merl {
    nqm_map map;
    size_t n_phi;
    atomic_int gathered;     /* remaining pairs to read with nqm_map_gather() */
    atomic_int *gather_left; /* &gathered: evaluations get a const table but decrement it */
} merl;

static size_t cell_index(double position, size_t n) {
    return position >= (double)n ? n - 1 : (size_t)fmax(position, 0);
}

/* Index of the cell that contains hd (3), within one channel. */
static size_t find_cell(size_t n_phi, const double *hd) {
    size_t h = cell_index(sqrt(hd[0] / (NQM_PI / 2)) * N_THETA_H, N_THETA_H);
    size_t d = cell_index(hd[1] / (NQM_PI / 2) * N_THETA_D, N_THETA_D);
    size_t p = cell_index(hd[2] / NQM_PI * N_PHI_HALF, n_phi);
    return (h * N_THETA_D + d) * n_phi + p;
}

static size_t cell_offset(size_t n_phi, size_t channel, size_t cell) {
    return HEADER_BYTES + 8 * (channel * count_cells(n_phi) + cell);
}

static double value_of(const unsigned char *stored, size_t channel) {
    double value = nqm_load_f64(stored);
    return value >= 0 ? value * channel_scale[channel] : NAN;
}

static void gather_block(const merl *table, size_t n, const double *hd, double *rgb) {
    unsigned char stored[3 * GATHER_BLOCK][8];
    nqm_piece pieces[3 * GATHER_BLOCK];
    for (size_t i = 0; i < n; ++i) {
        size_t cell = find_cell(table->n_phi, hd + 3 * i);
        for (size_t c = 0; c < 3; ++c)
            pieces[3 * i + c] = (nqm_piece){cell_offset(table->n_phi, c, cell), stored[3 * i + c]};
    }
    nqm_map_gather(&table->map, 3 * n, pieces, sizeof *stored);
    for (size_t i = 0; i < 3 * n; ++i)
        rgb[i] = value_of(stored[i], i % 3);
}

static void merl_eval_half_diff(const void *self, size_t n, const double *hd, double *rgb) {
    const merl *table = self;
    size_t i = 0;
    while (i < n && atomic_load_explicit(table->gather_left, memory_order_relaxed) > 0) {
        size_t n_block = n - i < GATHER_BLOCK ? n - i : GATHER_BLOCK;
        atomic_fetch_sub(table->gather_left, (int)n_block);
        gather_block(table, n_block, hd + 3 * i, rgb + 3 * i);
        i += n_block;
    }
    for (; i < n; ++i) {
        size_t cell = find_cell(table->n_phi, hd + 3 * i);
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = value_of(table->map.data + cell_offset(table->n_phi, c, cell), c);
    }
}

static void merl_free(void *self) {
    merl *table = self;
    nqm_map_close(&table->map);
    nqm_free(table);
}

static const nqm_brdf_class merl_class = {.format = "merl", .eval_half_diff = merl_eval_half_diff, .free = merl_free};

/* The number of phi_d that the header declares; 0: the header is not that of a MERL table. */
static size_t read_header(const nqm_map *map) {
    static const size_t accepted[] = {N_PHI_HALF, N_PHI_FULL};
    unsigned char header[HEADER_BYTES];
    for (size_t i = 0; map->n_bytes >= HEADER_BYTES && i < 2; ++i) {
        make_header(accepted[i], header);
        if (memcmp(map->data, header, HEADER_BYTES) == 0)
            return accepted[i];
    }
    return 0;
}

static bool probe(const nqm_map *map) {
    return read_header(map) || map->n_bytes == file_bytes(N_PHI_HALF) || map->n_bytes == file_bytes(N_PHI_FULL);
}

/* Detect files without finite values. It reads 16 cells at each of 16 positions, because reading all cells would load
 * the whole file. */
static bool any_cell_finite(const nqm_map *map, size_t n_phi) {
    enum { N_PAGES = 16, N_PER_PAGE = 16 };
    for (size_t page = 0; page < N_PAGES; ++page) {
        const unsigned char *cells = map->data + HEADER_BYTES + 8 * (page * (count_cells(n_phi) / N_PAGES));
        for (size_t k = 0; k < N_PER_PAGE; ++k)
            if (isfinite(nqm_load_f64(cells + 8 * k)))
                return true;
    }
    return false;
}

static nqm_status open_file(nqm_map *map, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    const size_t n_phi = read_header(map), expected = file_bytes(n_phi);
    if (!n_phi)
        return nqm_fail(err, NQM_ERR_FORMAT, 0,
                        "%s: has the size of a MERL table, but byte 0 does not begin 90 x 90 x 180 or 90 x 90 x 360",
                        map->path);
    if (map->n_bytes != expected) {
        size_t at = map->n_bytes < expected ? map->n_bytes : expected;
        return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)at,
                        "%s: a MERL table of 90 x 90 x %zu cells has %zu bytes, this file has %zu: %s at byte %zu",
                        map->path, n_phi, expected, map->n_bytes, at < expected ? "it ends" : "more follows", at);
    }
    if (!any_cell_finite(map, n_phi))
        return nqm_fail(err, NQM_ERR_FORMAT, HEADER_BYTES, "%s: no finite value in the cells looked at from byte %d on",
                        map->path, HEADER_BYTES);
    merl *table = nqm_alloc(1, sizeof *table);
    if (!table)
        return nqm_fail_nomem(err, sizeof *table);
    nqm_map_expect(map, false);
    table->map = *map;
    table->n_phi = n_phi;
    table->gathered = map->has_fd ? N_GATHERED : 0;
    table->gather_left = &table->gathered;
    *map = (nqm_map){0};
    const nqm_brdf_info info = {.name = argument->name,
                                .source_doi = "10.1145/882262.882343",
                                .layout = n_phi == N_PHI_HALF ? "90 x 90 x 180 cells" : "90 x 90 x 360 cells",
                                .n_values = 3 * count_cells(n_phi),
                                .reciprocal = n_phi == N_PHI_HALF};
    return nqm_brdf_wrap(&merl_class, table, &info, brdf_ret, err);
}

const nqm_brdf_format nqm_merl_format = {
    .files = "MERL .binary (90x90x180, 90x90x360)", .probe = probe, .open = open_file};

/* ---- writing ----------------------------------------------------------------------------------------------------- */

typedef struct fill_job {
    const nqm_brdf *brdf;
    double *cells; /* (3, N_LINES, n_phi), as stored */
    size_t n_phi;
} fill_job;

static void fill_line(void *user, size_t line) {
    const fill_job *job = user;
    const size_t n_phi = job->n_phi;
    /* NOLINTNEXTLINE(bugprone-integer-division): the integer quotient is the index of theta_h */
    double root_h = ((double)(line / N_THETA_D) + 0.5) / N_THETA_H;
    double hd[3 * N_PHI_FULL] = {0}, rgb[3 * N_PHI_FULL];
    uint8_t flag[N_PHI_FULL];
    for (size_t p = 0; p < n_phi; ++p) {
        hd[3 * p] = root_h * root_h * NQM_PI / 2;
        hd[3 * p + 1] = ((double)(line % N_THETA_D) + 0.5) / N_THETA_D * NQM_PI / 2;
        hd[3 * p + 2] = ((double)p + 0.5) / N_PHI_HALF * NQM_PI;
    }
    nqm_brdf_eval_half_diff(job->brdf, n_phi, hd, rgb, flag);
    for (size_t p = 0; p < n_phi; ++p) {
        bool empty = !nqm_has_value(flag[p]);
        for (size_t c = 0; c < 3; ++c)
            job->cells[(c * N_LINES + line) * n_phi + p] = empty ? -1 : rgb[3 * p + c] / channel_scale[c];
    }
}

nqm_status nqm_brdf_write_merl(const nqm_brdf *brdf, size_t n_phi, const char *path, nqm_progress_fn progress,
                               void *progress_user, nqm_error *err) {
    const size_t n_values = 3 * count_cells(n_phi);
    double *cells = nqm_alloc(n_values, sizeof *cells);
    if (!cells)
        return nqm_fail_nomem(err, n_values * sizeof *cells);
    nqm_ticker ticker = {.fn = progress, .user = progress_user};
    nqm_outfile out;
    fill_job job = {.brdf = brdf, .cells = cells, .n_phi = n_phi};
    nqm_status status = nqm_parallel_ticking(&ticker, "convert", N_LINES, fill_line, &job)
                            ? nqm_fail(err, NQM_ERR_CANCELLED, -1, "%s: interrupted, nothing was written", path)
                            : nqm_outfile_open(path, &out, err);
    if (status == NQM_OK) {
        unsigned char header[HEADER_BYTES];
        make_header(n_phi, header);
        fwrite(header, 1, sizeof header, out.stream);
        nqm_write_values(out.stream, n_values, sizeof *cells, cells);
        status = nqm_outfile_commit(&out, err); /* checks the stream's error flag */
    }
    nqm_free(cells);
    return status;
}
