/* SPDX-License-Identifier: MIT
 *
 * Anisotropic measurements of UTIA (Filip and Vavra 2014, DOI 10.1111/cgf.12477; doc/files.md). Beyond 75 degrees the line through the
 * last two thetas continues, as in the authors' reader.
 */
#include "brdf/formats/format.h"
#include "brdf/formats/grid.h"

#include <float.h>
#include <math.h>

enum { N_THETA = 6, N_PHI = 48, N_DIRECTIONS = N_THETA * N_PHI, N_CHANNELS = 3 };
enum {
    N_VALUES = N_CHANNELS * N_DIRECTIONS * N_DIRECTIONS,
    VIEWER_BYTES = sizeof(float),
    PLANE_BYTES = N_DIRECTIONS * VIEWER_BYTES
};

/* One block. The grid is that of the first phi_i: theta_i, theta_v, phi_v. */
typedef struct utia {
    nqm_grid grid;
    double theta[N_THETA], phi[N_PHI];
    unsigned char value[N_VALUES * VIEWER_BYTES]; /* float32 in the order of the file */
} utia;

static void to_angles(const double *w, double *theta, double *phi) {
    *theta = atan2(hypot(w[0], w[1]), w[2]);
    *phi = atan2(w[1], w[0]);
}

static void utia_eval(const void *self, size_t n, const double *wi, const double *wo, double *rgb) {
    const utia *u = self;
    nqm_grid grid = u->grid;
    for (size_t i = 0; i < 3 * n; i += 3) {
        double at[3], phi_i, part[2][3];
        to_angles(wi + i, at, &phi_i);
        to_angles(wo + i, at + 1, at + 2);
        const double x = (phi_i < 0 ? phi_i + 2 * NQM_PI : phi_i) / (2 * NQM_PI / N_PHI), lower = floor(x);
        for (size_t k = 0; k < 2; ++k) {
            grid.value = u->value + ((size_t)lower + k) % N_PHI * PLANE_BYTES;
            nqm_grid_eval(&grid, 1, at, part[k]);
        }
        for (size_t c = 0; c < 3; ++c)
            rgb[i + c] = (1 - (x - lower)) * part[0][c] + (x - lower) * part[1][c];
    }
}

static const nqm_brdf_class utia_class = {.format = "utia", .anisotropic = true, .eval = utia_eval, .free = nqm_free};

/* Not the beginning of a text, an archive or a header with a length. */
static bool is_plausible(double value) {
    return value == 0 || !isfinite(value) || (fabs(value) > 1e-30 && fabs(value) < 1e30);
}

static bool probe(const nqm_map *map) {
    return map->n_bytes == N_VALUES * sizeof(double) && is_plausible(nqm_load_f64(map->data)) &&
           is_plausible(nqm_load_f64(map->data + sizeof(double)));
}

static void lay_out(utia *u) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (size_t i = 0; i < N_THETA; ++i)
        u->theta[i] = (double)i * NQM_PI / 12;
    for (size_t i = 0; i < N_PHI; ++i)
        u->phi[i] = (double)i * 2 * NQM_PI / N_PHI;
    u->grid = (nqm_grid){.n = {N_THETA, N_THETA, N_PHI},
                         .node = {u->theta, u->theta, u->phi},
                         .period = 2 * NQM_PI,
                         .extrapolates = true,
                         .stride = {N_PHI * PLANE_BYTES, N_PHI * VIEWER_BYTES, VIEWER_BYTES},
                         .n_channels = N_CHANNELS,
                         .channel_stride = N_DIRECTIONS * PLANE_BYTES,
                         .weights = identity};
}

static nqm_status open_file(nqm_map *map, const nqm_brdf_argument *argument, nqm_brdf **brdf_ret, nqm_error *err) {
    utia *u = nqm_alloc(1, sizeof *u);
    if (!u)
        return nqm_fail_nomem(err, sizeof *u);
    nqm_map_expect(map, true);
    lay_out(u);
    for (size_t i = 0; i < N_VALUES; ++i) {
        const double value = nqm_load_f64(map->data + i * sizeof value);
        if (!(fabs(value) <= (double)FLT_MAX)) {
            nqm_free(u);
            return nqm_fail(err, NQM_ERR_FORMAT, (int64_t)(i * sizeof value),
                            "%s: has the size of a UTIA measurement, but the value at byte %zu is not finite",
                            map->path, i * sizeof value);
        }
        nqm_store_f32(u->value + i * VIEWER_BYTES, (float)value);
    }
    const nqm_brdf_info info = {.name = argument->name,
                                .source_doi = "10.1111/cgf.12477",
                                .layout = "6 theta_i x 48 phi_i x 6 theta_v x 48 phi_v",
                                .n_values = N_VALUES};
    return nqm_brdf_wrap(&utia_class, u, &info, brdf_ret, err);
}

const nqm_brdf_format nqm_utia_format = {.files = "UTIA .bin", .probe = probe, .open = open_file};
