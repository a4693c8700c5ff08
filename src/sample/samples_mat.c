/* SPDX-License-Identifier: MIT
 *
 * Writes samples of a BRDF in the format of the paper's authors (doc/files.md): r, g, b and random_locations in MAT v5.
 */
#include "io/io.h"
#include "sample/sample.h"

nqm_status nqm_samples_save_mat(const nqm_directions *directions, const float *rgb, const char *path, nqm_error *err) {
    NQM_REQUIRE(err, directions, rgb, path);
    size_t n = nqm_directions_get_info(directions).n;
    double *planes = nqm_alloc(n, 3 * sizeof *planes);
    if (!planes)
        return nqm_fail_nomem(err, n * 3 * sizeof *planes);
    for (size_t i = 0; i < 3 * n; ++i)
        planes[i % 3 * n + i / 3] = (double)rgb[i];
    const nqm_mat_variable variables[] = {{"r", n, 1, planes},
                                          {"g", n, 1, planes + n},
                                          {"b", n, 1, planes + 2 * n},
                                          {"random_locations", n, 3, nqm_directions_get_info(directions).degrees}};
    nqm_status status = nqm_mat_write(path, sizeof variables / sizeof variables[0], variables, err);
    nqm_free(planes);
    return status;
}
