/* SPDX-License-Identifier: MIT
 *
 * Figures in a build without cairo: there are none.
 */
#include "plot/plot.h"

nqm_status nqm_figure_write(const char *path, const nqm_figure *figure, nqm_error *err) {
    (void)figure;
    return nqm_fail(err, NQM_ERR_ARG, -1, "%s: this build draws no figures (NQM_CAIRO is off)", path);
}
