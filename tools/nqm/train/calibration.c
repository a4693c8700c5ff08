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

json_t *stored_calibration_json(const nqm_model_info *info) {
    json_t *json = json_loads(info->calibration, 0, NULL); /* NULL for "" */
    return json ? json : json_null();
}

void print_stored_calibration(const nqm_model_info *info) {
    json_t *json = json_loads(info->calibration, 0, NULL);
    nqm_calibration c = {0};
    json_int_t n_pairs = 0, n_materials = 0;
    if (json && json_unpack(json, "{s:I,s:I,s:F,s:F,s:F,s:F}", "materials", &n_materials, "pairs", &n_pairs, "coverage",
                            &c.coverage, "coverage_pairs", &c.coverage_pairs, "coverage_lowest", &c.coverage_lowest,
                            "mean_width", &c.mean_width) == 0) {
        c.n_pairs = (size_t)n_pairs;
        c.n_materials = (size_t)n_materials;
        print_calibration(&c);
    } else {
        printf("interval    %s\n", *info->calibration ? "95 %" : "none: not calibrated");
    }
    json_decref(json);
}

const char *interval_text(const nqm_score_result *r, char text[INTERVAL_TEXT]) {
    snprintf(text, INTERVAL_TEXT, "[%.2f, %.2f]", r->jod_low, r->jod_high);
    return text;
}
