/* SPDX-License-Identifier: MIT
 *
 * Regression of the JOD curve on a CSV of human scores.
 */
#include "base/base.h"
#include "io/io.h"

#include <nqm/label.h>

static nqm_status read_column(const nqm_csv *csv, const char *path, const char *name, double *value, nqm_error *err) {
    int column = nqm_csv_column(csv, name);
    if (column < 0)
        return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: the header has no column %s", path, name);
    nqm_status status = NQM_OK;
    for (size_t row = 0; status == NQM_OK && row < nqm_csv_rows(csv); ++row)
        status = nqm_csv_number(csv, row, column, &value[row], err);
    return status;
}

nqm_status nqm_regress_csv(const char *path, nqm_regress_report *report_ret, nqm_error *err) {
    nqm_csv *csv = NULL;
    double *values = NULL;
    nqm_status status = nqm_csv_load(path, &csv, err);
    if (status != NQM_OK)
        goto fail;
    size_t n = nqm_csv_rows(csv);
    if (n < 4) {
        status =
            nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: %zu rows do not determine the curve, 4 are needed", path, n);
        goto fail;
    }
    values = nqm_alloc(n, 2 * sizeof *values);
    if (!values) {
        status = nqm_fail_nomem(err, n * 2 * sizeof *values);
        goto fail;
    }
    status = read_column(csv, path, "DeltaE", values, err);
    if (status == NQM_OK)
        status = read_column(csv, path, "JOD", values + n, err);
    if (status == NQM_OK)
        status = nqm_regress(n, values, values + n, report_ret, err);
fail:
    nqm_free(values);
    nqm_csv_free(csv);
    return status;
}
