/* SPDX-License-Identifier: MIT
 *
 * Direction sets: construction from angles, identity (a hash), CSV files. directions_create.c generates new sets.
 */
#include "base/os.h"
#include "io/io.h"
#include "math/math.h"
#include "sample/sample.h"

#include <math.h>
#include <string.h>

enum { MAX_DIRECTIONS = 100000 };

static void compute_id(nqm_directions *directions) {
    nqm_sha256 sha;
    if (!nqm_sha256_begin(&sha))
        return;
    nqm_sha256_add_values(&sha, 3 * directions->n, sizeof *directions->degrees, directions->degrees);
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

nqm_status nqm_directions_from_degrees(size_t n, const double *hd_deg, nqm_directions **directions_ret,
                                       nqm_error *err) {
    NQM_MAKE(err, directions_ret, hd_deg);
    if (n < 1 || n > MAX_DIRECTIONS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%zu directions: 1 to %d are possible", n, MAX_DIRECTIONS);
    for (size_t i = 0; i < n; ++i)
        if (!in_range(hd_deg + 3 * i))
            return nqm_fail(err, NQM_ERR_ARG, -1,
                            "direction %zu: theta_h %g, theta_d %g, phi_d %g degrees: outside 0..90, 0..90, -360..360",
                            i + 1, hd_deg[3 * i], hd_deg[3 * i + 1], hd_deg[3 * i + 2]);
    nqm_directions *directions;
    double *degrees, *wi, *wo, *cosines;
    uint32_t *twin;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&directions, 1, sizeof *directions}, {&degrees, n, 3 * sizeof *degrees}, {&wi, n, 3 * sizeof *wi},
                   {&wo, n, 3 * sizeof *wo}, {&cosines, n, sizeof *cosines}, {&twin, n, sizeof *twin}),
        err);
    if (status != NQM_OK)
        return status;
    *directions = (nqm_directions){.n = n, .degrees = degrees, .wi = wi, .wo = wo, .cosines = cosines, .twin = twin};
    for (size_t i = 0; i < 3 * n; ++i)
        degrees[i] = hd_deg[i] + 0.0; /* -0 becomes 0, so that equal directions have equal bytes */
    for (size_t i = 0; i < n; ++i) {
        const double hd[3] = {degrees[3 * i] * (NQM_PI / 180), degrees[3 * i + 1] * (NQM_PI / 180),
                              degrees[3 * i + 2] * (NQM_PI / 180)};
        nqm_half_diff_to_pair(hd, wi + 3 * i, wo + 3 * i);
        cosines[i] = fmax(wi[3 * i + 2], 0) * fmax(wo[3 * i + 2], 0);
        twin[i] = (uint32_t)find_twin(degrees, i);
    }
    *directions_ret = directions;
    return NQM_OK;
}

void nqm_directions_free(nqm_directions *directions) {
    nqm_free(directions);
}

nqm_directions_info nqm_directions_get_info(const nqm_directions *directions) {
    assert(directions);
    return (nqm_directions_info){directions->n, directions->degrees, directions->wi, directions->wo};
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

static const char *const column_names[3] = {"theta_h", "theta_d", "phi_d"};

static nqm_status read_degrees(const nqm_csv *csv, const char *path, double *degrees, nqm_error *err) {
    for (int k = 0; k < 3; ++k) {
        int column = nqm_csv_column(csv, column_names[k]);
        if (column < 0)
            return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: there is no column '%s'", path, column_names[k]);
        for (size_t i = 0; i < nqm_csv_rows(csv); ++i) {
            nqm_status status = nqm_csv_number(csv, i, column, &degrees[3 * i + (size_t)k], err);
            if (status != NQM_OK)
                return status;
        }
    }
    return NQM_OK;
}

nqm_status nqm_directions_load_csv(const char *path, nqm_directions **directions_ret, nqm_error *err) {
    NQM_MAKE(err, directions_ret, path);
    nqm_csv *csv;
    nqm_status status = nqm_csv_load(path, &csv, err);
    if (status != NQM_OK)
        return status;
    size_t n = nqm_csv_rows(csv);
    double *degrees = nqm_alloc(n, 3 * sizeof *degrees);
    status = degrees ? read_degrees(csv, path, degrees, err) : nqm_fail_nomem(err, 3 * n * sizeof *degrees);
    if (status == NQM_OK) {
        nqm_error inner = {0};
        status = nqm_directions_from_degrees(n, degrees, directions_ret, &inner);
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
    fprintf(out.stream, "%s,%s,%s\n", column_names[0], column_names[1], column_names[2]);
    for (size_t i = 0; i < directions->n; ++i) {
        char text[100];
        fprintf(out.stream, "%s\n", nqm_format_doubles(text, sizeof text, 3, directions->degrees + 3 * i, ","));
    }
    return nqm_outfile_commit(&out, err);
}
