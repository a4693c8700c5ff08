/* SPDX-License-Identifier: MIT
 *
 * Writes any BRDF as a table that other programs read.
 */
#include "brdf/brdf.h"

nqm_status nqm_brdf_write(const nqm_brdf *brdf, nqm_table_format format, const char *path, nqm_progress_fn progress,
                          void *progress_user, nqm_error *err) {
    NQM_REQUIRE(err, brdf, path);
    switch (format) {
    case NQM_TABLE_MERL:
        return nqm_merl_write(brdf, 180, path, progress, progress_user, err);
    case NQM_TABLE_MERL_360:
        return nqm_merl_write(brdf, 360, path, progress, progress_user, err);
    case NQM_TABLE_NPY:
        return nqm_npy_write_brdf(brdf, path, err);
    }
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: nqm_brdf_write: unknown format %d", path, (int)format);
}
