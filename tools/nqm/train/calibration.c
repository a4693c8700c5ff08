/* SPDX-License-Identifier: MIT
 *
 * Prints the calibration of a model's intervals, for the commands that make and show models, and the interval of a
 * score.
 */
#include "nqm/tool.h"

void print_calibration(const nqm_calibration *c) {
    printf(
        "interval    95 %%, from %zu pairs of %zu materials, mean width %.2f JOD; left out in turn, %.1f %% of their\n"
        "            labels lay inside (of all pairs %.1f %%, of the worst material %.1f %%)\n",
        c->n_pairs, c->n_materials, c->mean_width, 100 * c->coverage, 100 * c->coverage_pairs,
        100 * c->coverage_lowest);
}

json_t *calibration_json(const nqm_calibration *c) {
    if (c->n_materials == 0)
        return json_null();
    return json_pack("{s:I,s:I,s:o,s:o,s:o,s:o,s:o}", "materials", (json_int_t)c->n_materials, "pairs",
                     (json_int_t)c->n_pairs, "coverage", json_number(c->coverage), "coverage_pairs",
                     json_number(c->coverage_pairs), "coverage_lowest", json_number(c->coverage_lowest), "mean_width",
                     json_number(c->mean_width), "novelty_growth", json_number(c->novelty_growth));
}
