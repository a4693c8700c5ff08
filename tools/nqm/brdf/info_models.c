/* SPDX-License-Identifier: MIT
 *
 * Models for `nqm info`: the list of the built-in ones, the properties of a model, and copies with notes or 16-bit weights.
 */
#include "metric/metric.h"
#include "nqm/brdf/info.h"
#include "nqm/help.h"

#include <stdlib.h>
#include <string.h>

/* "1500-1024-716-501-1" */
static const char *layers_text(const nqm_model_info *info, char *text, size_t n_text) {
    size_t at = 0;
    snprintf(text, n_text, "no network");
    for (size_t l = 0; info->n_layers > 0 && l <= info->n_layers && at < n_text; ++l)
        at += (size_t)snprintf(text + at, n_text - at, "%s%zu", l ? "-" : "", info->layer_sizes[l]);
    return text;
}

json_t *json_model(const nqm_model *model) {
    const nqm_model_info info = nqm_model_get_info(model);
    json_t *layers = json_array(), *calibration = parse_json(info.calibration); /* NULL for "" */
    for (size_t l = 0; info.n_layers > 0 && l <= info.n_layers; ++l)
        json_array_append_new(layers, json_integer((json_int_t)info.layer_sizes[l]));
    return json_pack("{s:s,s:s,s:I,s:s,s:o,s:{s:I,s:s},s:[o,o],s:o,s:s,s:s,s:s}", "id", info.id, "recipe", info.recipe,
                     "parameters", (json_int_t)info.n_parameters, "sha256", info.sha256, "layers", layers, "directions",
                     "n", (json_int_t)nqm_directions_count(info.directions), "id", nqm_directions_id(info.directions),
                     "jod_range", json_number(info.jod_min), json_number(info.jod_max), "calibration",
                     calibration ? calibration : json_null(), "licence", info.licence, "manifest_sha256",
                     info.manifest_sha256, "card", info.card);
}

static void print_stored_calibration(const char *stored) {
    json_t *json = parse_json(stored);
    nqm_calibration c = {0};
    json_int_t n_pairs = 0, n_materials = 0;
    if (json && json_unpack(json, "{s:I,s:I,s:F,s:F,s:F,s:F}", "materials", &n_materials, "pairs", &n_pairs, "coverage",
                            &c.coverage, "coverage_pairs", &c.coverage_pairs, "coverage_lowest", &c.coverage_lowest,
                            "mean_width", &c.mean_width) == 0) {
        c.n_pairs = (size_t)n_pairs;
        c.n_materials = (size_t)n_materials;
        print_calibration(&c);
    } else {
        printf("interval    %s\n", *stored ? "95 %" : "none: not calibrated");
    }
    json_decref(json);
}

/* Lines may end as on Windows. */
static void print_card_line(const char *line, size_t n) {
    n -= n && line[n - 1] == '\r';
    char *text = allocate(n + 1, 1);
    for (size_t i = 0; i < n; ++i)
        text[i] = line[i] == '\t' ? ' ' : line[i];
    puts(shown(text));
    free(text);
}

void print_model_text(const nqm_model *model) {
    const nqm_model_info info = nqm_model_get_info(model);
    char layers[200];
    printf("id          %s\nrecipe      %s\nparameters  %zu\nlayers      %s\n", shown(info.id), shown(info.recipe),
           info.n_parameters, layers_text(&info, layers, sizeof layers));
    printf("directions  %zu, id %s\nJOD range   %.2f to %.2f\n", nqm_directions_count(info.directions),
           nqm_directions_id(info.directions), info.jod_min, info.jod_max);
    print_stored_calibration(info.calibration);
    printf("licence     %s\nsha256      %s\n", shown(info.licence), info.sha256);
    if (nqm_model_transport(model).light)
        printf("similarity  %s\n",
               model->similarity[NQM_APART] > 0
                   ? "fitted to other answers of people"
                   : "six constants, fitted to answers of Lagunas et al. 2019 (GPL-2.0; not included)");
    if (*info.manifest_sha256)
        printf("trained on  %s (sha256 of the dataset)\n", shown(info.manifest_sha256));
    if (*info.card)
        putchar('\n');
    each_line(info.card, print_card_line);
}

int annotate_model(const char *name, const char *notes_path, bool half, const char *output) {
    nqm_error err = {0};
    nqm_model *model = open_model(name), *annotated;
    char *notes = read_text(notes_path);
    if (half) { /* 16-bit weights in the hidden layers, with newly computed golden scores */
        nqm_model *original = model;
        must(nqm_model_copy(original, &model, &err), &err);
        nqm_model_free(original);
        must(nqm_model_round_to_half(model, &err), &err);
        nqm_free(model->golden);
        must(nqm_golden_make(model, &model->golden, &err), &err);
    }
    must(nqm_model_annotate(model, notes, &annotated, &err), &err);
    must(nqm_model_save(annotated, output, &err), &err);
    free(notes);
    nqm_model_free(model);
    nqm_model_free(annotated);
    return EXIT_OK;
}

int list_models(bool json) {
    json_t *list = json ? json_array() : NULL;
    if (!json && nqm_model_builtin_count() == 0)
        report(EXIT_OK, "none is built in; `nqm train` makes model files");
    else if (!json)
        printf("%-15s %-10s %10s  %-24s %s\n", "model", "recipe", "parameters", "layers", "sha256");
    for (size_t i = 0; i < nqm_model_builtin_count(); ++i) {
        nqm_model *model = open_model(nqm_model_builtin_name(i));
        const nqm_model_info info = nqm_model_get_info(model);
        char layers[200];
        if (json)
            json_array_append_new(list, json_model(model));
        else
            printf("%-15s %-10s %10zu  %-24s %.16s...\n", info.id, info.recipe, info.n_parameters,
                   layers_text(&info, layers, sizeof layers), info.sha256);
        nqm_model_free(model);
    }
    return json ? print_document(json_pack("{s:o}", "models", list)) : EXIT_OK;
}
