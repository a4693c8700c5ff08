/* SPDX-License-Identifier: MIT
 *
 * nqm calibrate - adds intervals around the predicted JOD to an existing model.
 */
#include "nqm/tool.h"

#include <string.h>

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
    return json_pack("{s:I,s:I,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "materials", (json_int_t)c->n_materials, "pairs",
                     (json_int_t)c->n_pairs, "coverage", json_number(c->coverage), "coverage_pairs",
                     json_number(c->coverage_pairs), "coverage_lowest", json_number(c->coverage_lowest), "mean_width",
                     json_number(c->mean_width), "novelty_growth", json_number(c->novelty_growth),
                     "disagreement_growth", json_number(c->disagreement_growth), "peak_growth",
                     json_number(c->peak_growth));
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static const char *output;
static bool new_materials, json;

static const option options[] = {
    {"output", 'o', OPTION_NEEDED, &output, "FILE.safetensors", "the model file to write", 0, 0},
    {"new-materials", 0, OPTION_FLAG, &new_materials, NULL,
     "DATASET is not that of the training, but the model was not trained on its validation materials", 0, 0},
    {"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0},
    {0}};

static const command cmd = {
    .usage = "MODEL DATASET -o FILE [options]",
    .about = "Write a copy of MODEL with a 95 % interval around each JOD: for 95 % of the pairs of new materials, the\n"
             "label is inside the interval. The intervals are calibrated on the validation pairs of DATASET, which\n"
             "must be the dataset on which the model was trained; their coverage is measured with each material left\n"
             "out in turn. `nqm train` does the same after training.",
    .example = "nqm calibrate my.safetensors corpus.safetensors -o my-calibrated.safetensors",
    .options = options,
    .min_arguments = 2,
};

int cmd_calibrate(int argc, char **argv) {
    parse_arguments(&cmd, argc, argv);
    nqm_model *model = open_model(argv[0]), *calibrated;
    nqm_dataset *dataset = open_dataset(argv[1], NULL, NQM_SPLIT_ALL);
    nqm_calibration calibration;
    nqm_error err = {0};
    must(nqm_model_calibrate(model, dataset, new_materials, &calibrated, &calibration, &err), &err);
    must(nqm_model_save(calibrated, output_path(output), &err), &err);
    if (strcmp(output, "-") != 0) { /* otherwise standard output contains the model */
        nqm_model *written = open_model(output);
        const nqm_model_info info = nqm_model_get_info(written);
        if (json) {
            print_document(json_pack("{s:{s:o,s:s,s:s},s:o}", "model", "path", json_name(output), "id", info.id,
                                     "sha256", info.sha256, "calibration", calibration_json(&calibration)));
        } else {
            printf("model       %s (id %s)\nsha256      %s\n", shown(output), shown(info.id), info.sha256);
            print_calibration(&calibration);
        }
        nqm_model_free(written);
    }
    nqm_dataset_free(dataset);
    nqm_model_free(model);
    nqm_model_free(calibrated);
    return EXIT_OK;
}
