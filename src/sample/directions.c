/* SPDX-License-Identifier: MIT
 *
 * Direction sets: construction from angles, identity (a hash), CSV files. directions_create.c generates new sets.
 */
#include "io/io.h"
#include "math/math.h"
#include "sample/sample.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

enum { MAX_DIRECTIONS = 100000 };

static void compute_id(nqm_directions *directions) {
    nqm_sha256 sha;
    if (!nqm_sha256_begin(&sha))
        return;
    nqm_sha256_add_values(&sha, 3 * directions->n, sizeof *directions->degrees, directions->degrees);
    if (directions->phi_h_deg)
        nqm_sha256_add_values(&sha, directions->n, sizeof *directions->phi_h_deg, directions->phi_h_deg);
    char hex[65];
    nqm_sha256_end(&sha, hex);
    memcpy(directions->id, hex, sizeof directions->id - 1);
}

static bool in_range(const double *hd_deg) {
    return hd_deg[0] >= 0 && hd_deg[0] <= 90 && hd_deg[1] >= 0 && hd_deg[1] <= 90 && fabs(hd_deg[2]) <= 360;
}

/* Exchanging light and viewer adds half a turn to phi_d. Grids have such directions close to each other. */
static size_t find_twin(const double *degrees, size_t i) {
    enum { NEAR = 8 };
    const double *own = degrees + 3 * i;
    for (size_t j = i > NEAR ? i - NEAR : 0; j < i; ++j) {
        const double *other = degrees + 3 * j;
        if (other[0] == own[0] && other[1] == own[1] && fabs(own[2] - other[2] - 180) < 1e-9)
            return j;
    }
    return i;
}

/* Fill direction i from its angles. */
static void place(nqm_directions *d, size_t i) {
    const double *degrees = d->degrees + 3 * i, degree = NQM_PI / 180;
    const double hd[3] = {degrees[0] * degree, degrees[1] * degree, degrees[2] * degree};
    double *wi = d->wi + 3 * i, *wo = d->wo + 3 * i;
    nqm_half_diff_to_pair(hd, wi, wo);
    if (d->phi_h_deg) {
        const double turn[2] = {sin(d->phi_h_deg[i] * degree), cos(d->phi_h_deg[i] * degree)};
        nqm_turn3(turn, wi, wi);
        nqm_turn3(turn, wo, wo);
    }
    d->cosines[i] = fmax(wi[2], 0) * fmax(wo[2], 0);
    d->twin[i] = (uint32_t)(d->phi_h_deg ? i : find_twin(d->degrees, i));
}

nqm_status nqm_directions_make(size_t n, const double *hd_deg, const double *phi_h_deg, nqm_directions **directions_ret,
                               nqm_error *err) {
    NQM_MAKE(err, directions_ret, hd_deg);
    if (n < 1 || n > MAX_DIRECTIONS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%zu directions: 1 to %d are possible", n, MAX_DIRECTIONS);
    for (size_t i = 0; i < n; ++i)
        if (!in_range(hd_deg + 3 * i))
            return nqm_fail(err, NQM_ERR_ARG, -1,
                            "direction %zu: theta_h %g, theta_d %g, phi_d %g degrees: outside 0..90, 0..90, -360..360",
                            i + 1, hd_deg[3 * i], hd_deg[3 * i + 1], hd_deg[3 * i + 2]);
    for (size_t i = 0; phi_h_deg && i < n; ++i)
        if (!(fabs(phi_h_deg[i]) <= 360))
            return nqm_fail(err, NQM_ERR_ARG, -1, "direction %zu: phi_h %g degrees: outside -360..360", i + 1,
                            phi_h_deg[i]);
    nqm_directions *directions;
    double *degrees, *phi_h, *wi, *wo, *cosines;
    uint32_t *twin;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&directions, 1, sizeof *directions}, {&degrees, n, 3 * sizeof *degrees},
                                    {&phi_h, phi_h_deg ? n : 0, sizeof *phi_h}, {&wi, n, 3 * sizeof *wi},
                                    {&wo, n, 3 * sizeof *wo}, {&cosines, n, sizeof *cosines}, {&twin, n, sizeof *twin}),
                         err);
    if (status != NQM_OK)
        return status;
    *directions = (nqm_directions){.n = n,
                                   .degrees = degrees,
                                   .phi_h_deg = phi_h_deg ? phi_h : NULL,
                                   .wi = wi,
                                   .wo = wo,
                                   .cosines = cosines,
                                   .twin = twin};
    for (size_t i = 0; i < 3 * n; ++i)
        degrees[i] = hd_deg[i] + 0.0; /* -0 becomes 0, so that equal directions have equal bytes */
    for (size_t i = 0; phi_h_deg && i < n; ++i)
        phi_h[i] = phi_h_deg[i] + 0.0;
    for (size_t i = 0; i < n; ++i)
        place(directions, i);
    *directions_ret = directions;
    return NQM_OK;
}

nqm_status nqm_directions_from_degrees(size_t n, const double *hd_deg, nqm_directions **directions_ret,
                                       nqm_error *err) {
    return nqm_directions_make(n, hd_deg, NULL, directions_ret, err);
}

nqm_status nqm_directions_copy(const nqm_directions *d, nqm_directions **copy_ret, nqm_error *err) {
    return nqm_directions_make(d->n, d->degrees, d->phi_h_deg, copy_ret, err);
}

bool nqm_directions_equal(const nqm_directions *a, const nqm_directions *b) {
    return a->n == b->n && !a->phi_h_deg == !b->phi_h_deg &&
           memcmp(a->degrees, b->degrees, 3 * a->n * sizeof *a->degrees) == 0 &&
           (!a->phi_h_deg || memcmp(a->phi_h_deg, b->phi_h_deg, a->n * sizeof *a->phi_h_deg) == 0);
}

double nqm_round_degrees(double rad) {
    return floor(rad * (180 / NQM_PI) * 1e9 + 0.5) / 1e9;
}

/* Angles of a pair in degrees: hd (3), and the azimuth of the half vector. */
static double angles_of(const double *wi, const double *wo, double *hd) {
    const double phi_h = atan2(wi[1] + wo[1], wi[0] + wo[0]), back[2] = {-sin(phi_h), cos(phi_h)};
    double in[3], out[3], exact[3];
    nqm_turn3(back, wi, in);
    nqm_turn3(back, wo, out);
    nqm_half_diff_full_from_pair(in, out, exact);
    for (size_t k = 0; k < 3; ++k)
        hd[k] = nqm_round_degrees(exact[k]);
    return nqm_round_degrees(phi_h);
}

nqm_status nqm_directions_from_pairs(size_t n, const double *wi, const double *wo, nqm_directions **directions_ret,
                                     nqm_error *err) {
    double *degrees, *phi_h;
    nqm_status status =
        nqm_alloc_arrays(NQM_ARRAYS({&degrees, n, 3 * sizeof *degrees}, {&phi_h, n, sizeof *phi_h}), err);
    *directions_ret = NULL;
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < n; ++i)
        phi_h[i] = angles_of(wi + 3 * i, wo + 3 * i, degrees + 3 * i);
    status = nqm_directions_make(n, degrees, phi_h, directions_ret, err);
    nqm_free(degrees);
    return status;
}

void nqm_directions_free(nqm_directions *directions) {
    nqm_free(directions);
}

size_t nqm_directions_count(const nqm_directions *directions) {
    assert(directions);
    return directions->n;
}

const double *nqm_directions_degrees(const nqm_directions *directions) {
    assert(directions);
    return directions->degrees;
}

const double *nqm_directions_wi(const nqm_directions *directions) {
    assert(directions);
    return directions->wi;
}

const double *nqm_directions_wo(const nqm_directions *directions) {
    assert(directions);
    return directions->wo;
}

static pthread_mutex_t naming = PTHREAD_MUTEX_INITIALIZER; /* locked while the identity of any set is computed */

/* Computed at the first call, because scores do not need it and initialising OpenSSL takes a millisecond. */
const char *nqm_directions_id(const nqm_directions *directions) {
    assert(directions);
    pthread_mutex_lock(&naming);
    if (!directions->id[0])
        compute_id((nqm_directions *)(uintptr_t)directions);
    pthread_mutex_unlock(&naming);
    return directions->id;
}

/* ---- CSV --------------------------------------------------------------------------------------------------------- */

static const char *const column_names[4] = {"theta_h", "theta_d", "phi_d", "phi_h"};

/* Column k: value i to values[i stride]. */
static nqm_status read_column(const nqm_csv *csv, const char *path, size_t k, size_t stride, double *values,
                              nqm_error *err) {
    const int column = nqm_csv_column(csv, column_names[k]);
    nqm_status status = NQM_OK;
    if (column < 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: there is no column '%s'", path, column_names[k]);
    for (size_t i = 0; status == NQM_OK && i < nqm_csv_rows(csv); ++i)
        status = nqm_csv_number(csv, i, column, &values[i * stride], err);
    return status;
}

nqm_status nqm_directions_load_csv(const char *path, nqm_directions **directions_ret, nqm_error *err) {
    NQM_MAKE(err, directions_ret, path);
    nqm_csv *csv;
    nqm_status status = nqm_csv_load(path, &csv, err);
    if (status != NQM_OK)
        return status;
    size_t n = nqm_csv_rows(csv);
    const bool has_azimuths = nqm_csv_column(csv, column_names[3]) >= 0;
    double *degrees = nqm_alloc(n, 4 * sizeof *degrees), *phi_h = degrees + 3 * n;
    status = degrees ? NQM_OK : nqm_fail_nomem(err, 4 * n * sizeof *degrees);
    for (size_t k = 0; status == NQM_OK && k < 3; ++k)
        status = read_column(csv, path, k, 3, degrees + k, err);
    if (status == NQM_OK && has_azimuths)
        status = read_column(csv, path, 3, 1, phi_h, err);
    if (status == NQM_OK) {
        nqm_error inner = {0};
        status = nqm_directions_make(n, degrees, has_azimuths ? phi_h : NULL, directions_ret, &inner);
        if (status == NQM_ERR_ARG) /* the fault is in the file, not in an argument */
            status = NQM_ERR_FORMAT;
        if (status != NQM_OK)
            nqm_fail(err, status, -1, "%s: %s", path, inner.message);
    }
    nqm_free(degrees);
    nqm_csv_free(csv);
    return status;
}

nqm_status nqm_directions_save_csv(const nqm_directions *directions, const char *path, nqm_error *err) {
    NQM_REQUIRE(err, directions, path);
    nqm_outfile out;
    nqm_status status = nqm_outfile_open(path, &out, err);
    if (status != NQM_OK)
        return status;
    const size_t n_columns = directions->phi_h_deg ? 4 : 3;
    for (size_t k = 0; k < n_columns; ++k)
        fprintf(out.stream, "%s%c", column_names[k], k + 1 < n_columns ? ',' : '\n');
    for (size_t i = 0; i < directions->n; ++i)
        for (size_t k = 0; k < n_columns; ++k) {
            char text[32];
            nqm_format_double(text, sizeof text, k < 3 ? directions->degrees[3 * i + k] : directions->phi_h_deg[i]);
            fprintf(out.stream, "%s%c", text, k + 1 < n_columns ? ',' : '\n');
        }
    return nqm_outfile_commit(&out, err);
}
