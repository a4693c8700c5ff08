/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: CSV files of directions (`sample`, `dataset`, `directions`). Accepted directions are inside of their ranges.
 */
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
    const size_t n = nqm_directions_get_info(directions).n;
    const double *degrees = nqm_directions_get_info(directions).degrees;
    must(n > 0);
    for (size_t i = 0; i < n; ++i)
        must(degrees[3 * i] >= 0 && degrees[3 * i] <= 90 && degrees[3 * i + 1] >= 0 && degrees[3 * i + 1] <= 90 &&
             fabs(degrees[3 * i + 2]) <= 360);
    nqm_directions_free(directions);
}

static int run_one(const uint8_t *data, size_t n_bytes) {
    char path[FUZZ_PATH];
    const int fd = fuzz_file(data, n_bytes, path);
    read_directions(path);
    close(fd);
    return 0;
}

static blob make_seed(void) {
    static const char text[] = "theta_h,theta_d,phi_d\n0,0,0\n20.5,40,-90\n90,90,360\n";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
