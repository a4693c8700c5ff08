/* SPDX-License-Identifier: MIT
 *
 * nqm calibrate - adds intervals around the predicted JOD to an existing model, or a similarity fitted to answers of people.
 */
#include "judge/judge.h"
#include "nqm/tool.h"
#include "train/train.h"

#include <string.h>

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static const char *output, *model_name = "default", *root;
static bool new_materials, human, json;
static nqm_eval_options eval_options;

static const option options[] = {
    {"output", 'o', OPTION_NEEDED, &output, "FILE.safetensors", "the model file to write", 0, 0},
    {"new-materials", 0, OPTION_FLAG, &new_materials, NULL,
     "DATASET is not that of the training, but the model was not trained on its validation materials", 0, 0},
    {"human", 0, OPTION_FLAG, &human, NULL,
     "fit the similarity to ANSWERS.csv of people, which is as for eval --human; exit code 1 and no file if nothing is "
     "gained",
     0, 0},
    {"model", 'm', OPTION_TEXT, &model_name, "MODEL", "with --human: the model to copy", 0, 0},
    {"root", 0, OPTION_TEXT, &root, "DIR", "with --human: folder of relative paths (default: the list's folder)", 0, 0},
    {"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0},
    {0}};

static const command cmd = {
    .usage =
        "MODEL DATASET -o FILE [options]\n       nqm calibrate --human ANSWERS.csv --model MODEL -o FILE [options]",
    .about = "Write a copy of MODEL with a 95 % interval around each JOD: for 95 % of the pairs of new materials, the"
             " label is inside the interval. The intervals are calibrated on the validation pairs of DATASET, which "
             "must be the dataset on which the model was trained; their coverage is measured with each material left "
             "out in turn. `nqm train` does the same after training.\n"
             "--human: the copy's similarity has weights of Delta-E, shifts, contrast, structure and the built-in "
             "distance that predict the answers; the gain is that on materials which are left out in turn.",
    .example = "nqm calibrate my.safetensors corpus.safetensors -o my-calibrated.safetensors\n"
               "nqm calibrate --human answers.csv --model default -o mine.safetensors",
    .options = options,
    .min_arguments = 1,
    .max_arguments = 2,
};

static json_t *readout_json(const nqm_readout *r) {
    json_t *weights = json_object();
    for (size_t k = 0; k < NQM_APART; ++k)
        json_object_set_new(
            weights, nqm_apart_names[k],
            json_pack("[o,o,o]", json_number(r->weight[k]), json_number(r->ci95[k][0]), json_number(r->ci95[k][1])));
    return json_row("materials:z choices:f agreement_jod:f agreement_similarity:f agreement:f gain:[fff] weights:o",
                    r->n_materials, r->n_choices, r->jod, r->similarity, r->fitted, r->gain.value, r->gain.ci95[0],
                    r->gain.ci95[1], weights);
}

static void print_readout(const nqm_readout *r) {
    printf("answers     %.0f choices, %zu materials\n"
           "agreement   JOD %.3f, similarity %.3f; fitted to the other materials %.3f\n"
           "gain        %+.3f [%+.3f, %+.3f]\n"
           "weights     of a choice, per Delta-E [95 %%]\n",
           r->n_choices, r->n_materials, r->jod, r->similarity, r->fitted, r->gain.value, r->gain.ci95[0],
           r->gain.ci95[1]);
    for (size_t k = 0; k < NQM_APART; ++k)
        printf("  %-10s %.3g [%.3g, %.3g]\n", nqm_apart_names[k], r->weight[k], r->ci95[k][0], r->ci95[k][1]);
}

static int calibrate_human(const char *answers) {
    nqm_model *model = open_model(model_name), *fitted;
    nqm_human *people;
    nqm_readout r;
    const nqm_human_options o = {.root = list_root(root, answers),
                                 .directions = nqm_model_get_info(model).directions,
                                 .progress = show_progress};
    must(nqm_human_load(answers, &o, &people, &fault));
    must(nqm_human_fit_readout(people, model, &eval_options, &r, &fault));
    const bool gains = r.gain.ci95[0] > 0;
    if (gains) {
        char note[400];
        snprintf(note, sizeof note,
                 "## Similarity\n\nFitted to %.0f answers of people about %zu materials (nqm calibrate --human): "
                 "agreement %.3f on materials left out, %+.3f more than before.\n",
                 r.n_choices, r.n_materials, r.fitted, r.gain.value);
        must(nqm_model_annotate(model, note, &fitted, &fault));
        nqm_readout_set(&r, fitted);
        must(nqm_model_save(fitted, output_path(output), &fault));
        nqm_model_free(fitted);
    }
    if (json)
        print_document(json_row("output:o human:o", gains ? json_name(output) : json_null(), readout_json(&r)));
    else if (strcmp(output, "-") != 0)
        print_readout(&r);
    if (!gains)
        report(EXIT_GATE, "%s: the answers do not show a gain, so that nothing was written", answers);
    nqm_human_free(people);
    nqm_model_free(model);
    return gains ? EXIT_OK : EXIT_GATE;
}

int cmd_calibrate(int argc, char **argv) {
    eval_options = nqm_eval_options_default();
    eval_options.n_bootstrap = 200;
    argc = parse_arguments(&cmd, argc, argv);
    if (human ? argc != 1 : argc != 2)
        stop(EXIT_USAGE, human ? "--human needs one file of answers" : "calibrate needs MODEL and DATASET");
    if (human)
        return calibrate_human(argv[0]);
    nqm_model *model = open_model(argv[0]), *calibrated;
    nqm_dataset *dataset = open_dataset(argv[1], NULL, NQM_SPLIT_ALL);
    nqm_calibration calibration;
    must(nqm_model_calibrate(model, dataset, new_materials, &calibrated, &calibration, &fault));
    must(nqm_model_save(calibrated, output_path(output), &fault));
    if (strcmp(output, "-") != 0) { /* otherwise standard output contains the model */
        nqm_model *written = open_model(output);
        const nqm_model_info info = nqm_model_get_info(written);
        if (json) {
            print_document(json_row("model:{path:s id:s sha256:s} calibration:o", output, info.id, info.sha256,
                                    calibration_json(info.calibration)));
        } else {
            printf("model       %s (id %s)\nsha256      %s\n", shown(output), shown(info.id), info.sha256);
            print_calibration(info.calibration);
        }
        nqm_model_free(written);
    }
    nqm_dataset_free(dataset);
    nqm_model_free(model);
    nqm_model_free(calibrated);
    return EXIT_OK;
}
