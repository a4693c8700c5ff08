/* SPDX-License-Identifier: MIT
 *
 * nqm calibrate - adds intervals around the predicted JOD to an existing model.
 */
#include "nqm/tool.h"

#include <string.h>

typedef struct calibrate_arguments {
    const char *model, *dataset, *output;
    bool new_materials, json;
} calibrate_arguments;

static int print_result(const calibrate_arguments *a, const nqm_calibration *c) {
    nqm_model *written;
    nqm_error err = {0};
    if (strcmp(a->output, "-") == 0)
        return EXIT_OK; /* standard output contains the model */
    if (nqm_model_load(a->output, &written, &err) != NQM_OK)
        return report_error("calibrate", &err);
    nqm_model_info info = nqm_model_get_info(written);
    int exit_code = EXIT_OK;
    if (a->json) {
        exit_code = print_json(json_pack("{s:i,s:o,s:{s:o,s:s,s:s},s:o}", "schema", 1, "tool", json_tool(), "model",
                                         "path", json_name(a->output), "id", info.id, "sha256", info.sha256,
                                         "calibration", calibration_json(c)));
    } else {
        printf("model       %s (id %s)\nsha256      %s\n", a->output, info.id, info.sha256);
        print_calibration(c);
    }
    nqm_model_free(written);
    return exit_code;
}

static int run_calibration(const calibrate_arguments *a) {
    nqm_model *model = NULL, *calibrated = NULL;
    nqm_dataset *dataset = NULL;
    nqm_calibration calibration;
    nqm_error err = {0};
    int exit_code = open_model("calibrate", a->model, &model);
    if (exit_code == EXIT_OK)
        exit_code = open_dataset("calibrate", a->dataset, NULL, NQM_SPLIT_ALL, &dataset);
    if (exit_code == EXIT_OK &&
        (nqm_model_calibrate(model, dataset, a->new_materials, &calibrated, &calibration, &err) != NQM_OK ||
         nqm_model_save(calibrated, output_path(a->output), &err) != NQM_OK))
        exit_code = report_error("calibrate", &err);
    if (exit_code == EXIT_OK)
        exit_code = print_result(a, &calibration);
    nqm_dataset_free(dataset);
    nqm_model_free(model);
    nqm_model_free(calibrated);
    return exit_code;
}

int cmd_calibrate(int argc, char **argv) {
    calibrate_arguments a = {0};
    const option options[] = {
        {"output", 'o', OPTION_TEXT, &a.output, "FILE", "the model file to write", 0, 0},
        {"new-materials", 0, OPTION_FLAG, &a.new_materials, NULL,
         "DATASET is not that of the training, but the model was not trained on its validation materials", 0, 0},
        {"json", 0, OPTION_FLAG, &a.json, NULL, "print JSON", 0, 0},
        {0}};
    const command cmd = {
        .name = "calibrate",
        .usage = "MODEL DATASET -o FILE [options]",
        .about =
            "Write a copy of MODEL with a 95 % interval around each JOD: for 95 % of the pairs of new materials, the\n"
            "label is inside the interval. The intervals are calibrated on the validation pairs of DATASET, which\n"
            "must be the dataset on which the model was trained; their coverage is measured with each material left\n"
            "out in turn. `nqm train` does the same after training.",
        .example = "nqm calibrate my.safetensors corpus.safetensors -o my-calibrated.safetensors",
        .options = options,
        .min_arguments = 2,
        .max_arguments = 2,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    if (!a.output)
        return report("calibrate", EXIT_USAGE, "give the model file to write: -o FILE");
    a.model = argv[0];
    a.dataset = argv[1];
    return run_calibration(&a);
}
