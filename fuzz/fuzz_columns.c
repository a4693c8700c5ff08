/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: CSV files of which a verb reads columns: directions (`sample`, `dataset`, `plot directions`) and points (`regress`,
 * `plot`). Accepted directions are inside of their ranges; accepted points are finite.
 */
#include "figures/plot_shared.h"
#include "fuzz.h"

#include <math.h>
#include <nqm/samples.h>
#include <unistd.h>

static void read_directions(const char *path) {
    nqm_directions *directions;
    nqm_error err = {0};
    if (nqm_directions_load_csv(path, &directions, &err) != NQM_OK) {
        must(!directions && err.message[0]);
        return;
    }
    const size_t n = nqm_directions_count(directions);
    const double *degrees = nqm_directions_degrees(directions);
    must(n > 0);
    for (size_t i = 0; i < n; ++i)
        must(degrees[3 * i] >= 0 && degrees[3 * i] <= 90 && degrees[3 * i + 1] >= 0 && degrees[3 * i + 1] <= 90 &&
             fabs(degrees[3 * i + 2]) <= 360);
    nqm_directions_free(directions);
}

static void read_points(const char *path) {
    nqm_points points;
    nqm_error err = {0};
    if (nqm_points_load(path, "theta_h", "theta_d", "group", &points, &err) != NQM_OK) {
        must(err.message[0]);
        return;
    }
    size_t n = 0;
    for (size_t i = 0; i < points.n_series; ++i)
        n += points.series[i].n;
    must(points.n > 0 && n == points.n && points.n_series <= NQM_MAX_GROUPS);
    for (size_t i = 0; i < n; ++i)
        must(isfinite(points.x[i]) && isfinite(points.y[i]));
    nqm_points_free(&points);
}

static int run_one(const uint8_t *data, size_t n_bytes) {
    char path[FUZZ_PATH];
    const int fd = fuzz_file(data, n_bytes, path);
    read_directions(path);
    read_points(path);
    close(fd);
    return 0;
}

static blob make_seed(void) {
    static const char text[] = "theta_h,theta_d,phi_d,group\n0,0,0,a\n20.5,40,-90,b\n90,90,360,a\n";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
