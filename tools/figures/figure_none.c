/* SPDX-License-Identifier: MIT
 *
 * Stands in for cairo in a build without it: every drawing fails.
 */
#include "figures/sheet.h"

const char *nqm_cairo_version(void) {
    return NULL;
}

nqm_status nqm_figure_write(const char *path, const nqm_figure *figure, nqm_error *err) {
    (void)figure;
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: this build cannot draw figures (NQM_CAIRO is off)", path);
}

nqm_status nqm_sheet_write(const char *path, const nqm_sheet *sheet, const nqm_plot_options *options, nqm_error *err) {
    (void)sheet;
    (void)options;
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: this build cannot draw (NQM_CAIRO is off)", path);
}
