/* SPDX-License-Identifier: MIT
 *
 * nqm models - lists the built-in models, shows the properties of a model, and writes copies with notes or 16-bit
 * weights.
 */
#include "metric/metric.h"
#include "nqm/tool.h"

#include <stdlib.h>
#include <string.h>

/* "1500-1024-716-501-1" */
static const char *layers_text(const nqm_model_info *info, char *text, size_t n_text) {
    size_t at = 0;
    text[0] = '\0';
    for (size_t l = 0; l <= info->n_layers && at < n_text; ++l)
        at += (size_t)snprintf(text + at, n_text - at, "%s%zu", l ? "-" : "", info->layer_sizes[l]);
    return text;
}

static json_t *model_json(const nqm_model *model) {
    nqm_model_info info = nqm_model_get_info(model);
    json_t *layers = json_array();
    for (size_t l = 0; l <= info.n_layers; ++l)
        json_array_append_new(layers, json_integer((json_int_t)info.layer_sizes[l]));
    return json_pack("{s:s,s:s,s:I,s:s,s:o,s:{s:I,s:s},s:[o,o],s:o,s:s,s:s,s:s}", "id", info.id, "recipe", info.recipe,
                     "parameters", (json_int_t)info.n_parameters, "sha256", info.sha256, "layers", layers, "directions",
                     "n", (json_int_t)nqm_directions_count(info.directions), "id", nqm_directions_id(info.directions),
                     "jod_range", json_number(info.jod_min), json_number(info.jod_max), "calibration",
                     stored_calibration_json(&info), "licence", info.licence, "manifest_sha256", info.manifest_sha256,
                     "card", info.card);
}

static int show_model(const char *name, bool json) {
    nqm_model *model;
    int exit_code = open_model("models", name, &model);
    if (exit_code != EXIT_OK)
        return exit_code;
    if (json) {
        json_t *object = json_pack("{s:i,s:o}", "schema", 1, "tool", json_tool());
        json_object_update_new(object, model_json(model));
        exit_code = print_json(object);
    } else {
        nqm_model_info info = nqm_model_get_info(model);
        char layers[200];
        printf("id          %s\nrecipe      %s\nparameters  %zu\nlayers      %s\n", info.id, info.recipe,
               info.n_parameters, layers_text(&info, layers, sizeof layers));
        printf("directions  %zu, id %s\nJOD range   %.2f to %.2f\n", nqm_directions_count(info.directions),
               nqm_directions_id(info.directions), info.jod_min, info.jod_max);
        print_stored_calibration(&info);
        printf("licence     %s\nsha256      %s\n", info.licence, info.sha256);
        if (*info.manifest_sha256)
            printf("trained on  %s (sha256 of the dataset)\n", info.manifest_sha256);
        if (*info.card)
            printf("\n%s%s", info.card, info.card[strlen(info.card) - 1] == '\n' ? "" : "\n");
    }
    nqm_model_free(model);
    return exit_code;
}

/* Replace a model by a copy whose hidden layers have 16-bit weights, with newly computed golden scores. */
static int round_model(nqm_model **model) {
    nqm_model *half;
    nqm_error err = {0};
    nqm_status status = nqm_model_copy(*model, &half, &err);
    if (status == NQM_OK)
        status = nqm_model_round_to_half(half, &err);
    if (status == NQM_OK) {
        nqm_free(half->golden);
        status = nqm_golden_make(half, &half->golden, &err);
    }
    nqm_model_free(*model);
    *model = half;
    return status == NQM_OK ? EXIT_OK : report_error("models", &err);
}

static int annotate_model(const char *name, const char *notes_path, bool half, const char *output) {
    nqm_model *model, *annotated = NULL;
    char *notes = NULL;
    nqm_error err = {0};
    if (!output)
        return report("models", EXIT_USAGE, "annotate needs -o FILE");
    int exit_code = open_model("models", name, &model);
    if (exit_code == EXIT_OK)
        exit_code = read_text("models", notes_path, &notes);
    if (exit_code == EXIT_OK && half)
        exit_code = round_model(&model);
    if (exit_code == EXIT_OK && (nqm_model_annotate(model, notes, &annotated, &err) != NQM_OK ||
                                 nqm_model_save(annotated, output, &err) != NQM_OK))
        exit_code = report_error("models", &err);
    free(notes);
    nqm_model_free(model);
    nqm_model_free(annotated);
    return exit_code;
}

static int list_models(bool json) {
    json_t *list = json_array();
    if (!json && nqm_model_builtin_count() == 0)
        fputs("nqm models: none is built in; `nqm train` makes model files\n", stderr);
    else if (!json)
        printf("%-12s %-10s %10s  %-24s %s\n", "model", "recipe", "parameters", "layers", "sha256");
    for (size_t i = 0; i < nqm_model_builtin_count(); ++i) {
        nqm_model *model;
        int exit_code = open_model("models", nqm_model_builtin_name(i), &model);
        if (exit_code != EXIT_OK) {
            json_decref(list);
            return exit_code;
        }
        nqm_model_info info = nqm_model_get_info(model);
        char layers[200];
        if (json)
            json_array_append_new(list, model_json(model));
        else
            printf("%-12s %-10s %10zu  %-24s %.16s...\n", info.id, info.recipe, info.n_parameters,
                   layers_text(&info, layers, sizeof layers), info.sha256);
        nqm_model_free(model);
    }
    if (json)
        return print_json(json_pack("{s:i,s:o,s:o}", "schema", 1, "tool", json_tool(), "models", list));
    json_decref(list);
    return EXIT_OK;
}

int cmd_models(int argc, char **argv) {
    bool json = false, half = false;
    const char *output = NULL;
    const option options[] = {
        {"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0},
        {"output", 'o', OPTION_TEXT, &output, "FILE", "annotate: the model file to write", 0, 0},
        {"half", 0, OPTION_FLAG, &half, NULL, "annotate: store hidden layers' weights in 16 bits", 0, 0},
        {0}};
    const command cmd = {
        .name = "models",
        .usage = "[show MODEL | annotate MODEL NOTES.md -o FILE] [options]",
        .about =
            "List the built-in models, or show one of them or a model file: size, checksum, directions and the model\n"
            "card, which describes training data, results and limits. annotate writes a copy of a model with a text\n"
            "added to its card, such as results on a test set; --half also rounds the weights of the hidden layers\n"
            "to 16 bits, which halves the file.",
        .example = "nqm models\nnqm models show default\nnqm models show my.safetensors --json\n"
                   "nqm models annotate my.safetensors results.md -o my-judged.safetensors",
        .options = options,
        .min_arguments = 0,
        .max_arguments = 3,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    if (n_arguments == 0)
        return list_models(json);
    if (n_arguments == 1 && strcmp(argv[0], "list") == 0)
        return list_models(json);
    if (n_arguments == 2 && strcmp(argv[0], "show") == 0)
        return show_model(argv[1], json);
    if (n_arguments == 3 && strcmp(argv[0], "annotate") == 0)
        return annotate_model(argv[1], argv[2], half, output);
    return report("models", EXIT_USAGE,
                  "say `nqm models` `nqm models show MODEL` or `nqm models annotate MODEL NOTES.md -o FILE`");
}
