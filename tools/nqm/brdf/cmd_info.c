/* SPDX-License-Identifier: MIT
 *
 * nqm info - prints what a BRDF, model, dataset or material file contains; `nqm info list` prints the names of the presets.
 */
#include "io/io.h"
#include "material/material.h"
#include "metric/metric.h"
#include "nqm/help.h"
#include "nqm/textured.h"
#include "train/train.h"
#include <nqm/material.h>
#include <nqm/texture.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int print_brdf(const char *argument, bool json) {
    nqm_brdf *brdf = open_brdf(argument);
    const nqm_brdf_info info = nqm_brdf_get_info(brdf);
    double albedo[3];
    nqm_brdf_albedo(brdf, 0, 1, albedo);
    if (strcmp(info.format, "samples") == 0) /* unknown: most directions have no value */
        albedo[0] = albedo[1] = albedo[2] = NAN;
    json_t *members =
        json_row("kind:s format:s name:s spec:t source_doi:t layout:t remark:t n_values:z n_bytes:z "
                 "reciprocal:b isotropic:b albedo_normal:[fff]",
                 "brdf", info.format, info.name, info.spec, info.source_doi, info.layout, info.remark, info.n_values,
                 info.n_bytes, info.reciprocal, info.isotropic, albedo[0], albedo[1], albedo[2]);
    nqm_brdf_free(brdf);
    return json ? print_document(members) : print_members(members);
}

/* A material with image maps, which are decoded. */
static int print_texture(nqm_argument *argument, bool json) {
    nqm_texture *texture;
    must(nqm_texture_open_argument(argument, show_progress, NULL, &texture, &fault));
    end_progress();
    const nqm_texture_info info = nqm_texture_get_info(texture, NULL);
    json_t *members = json_row("kind:s name:s model:s width:z height:z n_images:z n_bytes:z varying:s remark:t",
                               "texture", info.name, info.model, info.width, info.height, info.n_images, info.n_bytes,
                               info.varying, *info.remark ? info.remark : NULL);
    nqm_texture_free(texture);
    return json ? print_document(members) : print_members(members);
}

/* Why a material cannot be opened: its refusal, or a value outside of its model's range, as a message in `err`. NULL: it can. */
static const char *obstacle(const nqm_material_info *info, nqm_error *err) {
    nqm_brdf *brdf = NULL;
    if (info->refusal)
        return info->refusal;
    if (strchr(info->spec, '=') && nqm_brdf_open(info->spec, &brdf, err) != NQM_OK)
        return err->message;
    nqm_brdf_free(brdf);
    return NULL;
}

static void print_material(const json_t *entry) {
    const char *refusal = json_string_value(json_object_get(entry, "refusal"));
    const char *remark = json_string_value(json_object_get(entry, "remark")), *why = refusal ? refusal : remark;
    const char *ignorable = json_string_value(json_object_get(entry, "ignorable"));
    const char *unused = json_string_value(json_object_get(entry, "unused"));
    const json_int_t n_maps = json_integer_value(json_object_get(entry, "n_maps"));
    printf("%s  %s  %s", shown(json_string_value(json_object_get(entry, "name"))),
           json_string_value(json_object_get(entry, "surface")), refusal ? "refused" : "accepted");
    if (n_maps)
        printf(": texture of %lld image%s", (long long)n_maps, n_maps > 1 ? "s" : "");
    if (why)
        printf(": %s", shown(why));
    if (unused)
        printf("; without effect: %s", shown(unused));
    if (ignorable)
        printf(refusal ? "; accepted with --ignore %s" : ": without %s, only what reflects", ignorable);
    putchar('\n');
}

/* A file of several materials: names, surfaces, and which are refused. */
static int print_materials(const char *path, const nqm_materials *materials, bool json) {
    json_t *list = json_array();
    size_t n_accepted = 0;
    for (size_t i = 0; i < nqm_materials_count(materials); ++i) {
        const nqm_material_info info = nqm_materials_reflecting(materials, i, ignored_set());
        nqm_error err = {0};
        const char *refusal = info.n_maps ? NULL : obstacle(&info, &err);
        n_accepted += !refusal;
        json_array_append_new(
            list, json_row("name:s surface:s spec:t refusal:t n_maps:z remark:t unused:t byte_offset:z ignorable:t",
                           info.name, info.surface, refusal ? NULL : info.spec, refusal, info.n_maps, info.remark,
                           info.unused, (size_t)info.byte_offset, info.ignorable));
    }
    json_t *members =
        json_row("kind:s name:s n_materials:z accepted:z", "materials", path, json_array_size(list), n_accepted);
    if (json) {
        json_object_set_new(members, "materials", list);
        return print_document(members);
    }
    print_members(members);
    size_t i;
    json_t *entry;
    json_array_foreach(list, i, entry) print_material(entry);
    json_decref(list);
    return EXIT_OK;
}

static int print_dataset(const char *path, bool json) {
    nqm_dataset *dataset;
    must(nqm_dataset_load(path, NULL, NQM_SPLIT_ALL, &dataset, &fault));
    const nqm_dataset_info info = nqm_dataset_get_info(dataset);
    json_t *members = json_row("kind:s name:s sha256:s references:z groups:z pairs:z pairs_in:{train:z validation:z "
                               "test:z} directions:{n:z id:s}",
                               "dataset", path, info.sha256, info.n_refs, info.n_groups, info.n_pairs,
                               info.n_pairs_in[NQM_SPLIT_TRAIN], info.n_pairs_in[NQM_SPLIT_VALIDATION],
                               info.n_pairs_in[NQM_SPLIT_TEST], nqm_directions_get_info(info.directions).n,
                               nqm_directions_id(info.directions));
    if (json)
        json_object_set_new(members, "manifest", parse_json(info.manifest));
    nqm_dataset_free(dataset);
    return json ? print_document(members) : print_members(members);
}

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
    json_t *layers = json_array();
    for (size_t l = 0; info.n_layers > 0 && l <= info.n_layers; ++l)
        json_array_append_new(layers, json_integer((json_int_t)info.layer_sizes[l]));
    return json_row("id:s recipe:s parameters:z sha256:s layers:o directions:{n:z id:s} jod_range:[ff] calibration:o "
                    "licence:s manifest_sha256:s card:s",
                    info.id, info.recipe, info.n_parameters, info.sha256, layers,
                    nqm_directions_get_info(info.directions).n, nqm_directions_id(info.directions), info.jod_min,
                    info.jod_max, calibration_json(info.calibration), info.licence, info.manifest_sha256, info.card);
}

json_t *calibration_json(const char *stored) {
    json_t *json = parse_json(stored); /* NULL for "" */
    return json ? json : json_null();
}

void print_calibration(const char *stored) {
    json_int_t n_pairs, n_materials;
    double coverage, of_pairs, lowest, width;
    json_t *json = calibration_json(stored);
    if (json_unpack(json, "{s:I,s:I,s:F,s:F,s:F,s:F}", "materials", &n_materials, "pairs", &n_pairs, "coverage",
                    &coverage, "coverage_pairs", &of_pairs, "coverage_lowest", &lowest, "mean_width", &width) == 0)
        printf(
            "interval    95 %%, from %lld pairs of %lld materials, mean width %.2f JOD; left out in turn, %.1f %% of "
            "their\n            labels lay inside (of all pairs %.1f %%, of the worst material %.1f %%)\n",
            (long long)n_pairs, (long long)n_materials, width, 100 * coverage, 100 * of_pairs, 100 * lowest);
    else
        printf("interval    %s\n", *stored ? "95 %" : "none: not calibrated");
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

static void print_model_text(const nqm_model *model) {
    const nqm_model_info info = nqm_model_get_info(model);
    char layers[200];
    printf("id          %s\nrecipe      %s\nparameters  %zu\nlayers      %s\n", shown(info.id), shown(info.recipe),
           info.n_parameters, layers_text(&info, layers, sizeof layers));
    printf("directions  %zu, id %s\nJOD range   %.2f to %.2f\n", nqm_directions_get_info(info.directions).n,
           nqm_directions_id(info.directions), info.jod_min, info.jod_max);
    print_calibration(info.calibration);
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

/* Write a copy of a model whose card ends with a text; `half` also rounds the weights of its hidden layers to 16 bits. */
static int annotate_model(const char *name, const char *notes_path, bool half, const char *output) {
    nqm_model *model = open_model(name), *annotated;
    char *notes = read_text(notes_path);
    if (half) { /* 16-bit weights in the hidden layers, with newly computed golden scores */
        nqm_model *original = model;
        must(nqm_model_copy(original, &model, &fault));
        nqm_model_free(original);
        must(nqm_model_round_to_half(model, &fault));
        nqm_free(model->golden);
        must(nqm_golden_make(model, &model->golden, &fault));
    }
    must(nqm_model_annotate(model, notes, &annotated, &fault));
    must(nqm_model_save(annotated, output, &fault));
    free(notes);
    nqm_model_free(model);
    nqm_model_free(annotated);
    return EXIT_OK;
}

/* A table of the built-in models, or as JSON all that json_model() has. */
static int list_models(bool json) {
    json_t *list = json ? json_array() : NULL;
    if (!json && !nqm_model_builtin_name(0))
        report(EXIT_OK, "none is built in; `nqm train` makes model files");
    else if (!json)
        printf("%-15s %-10s %10s  %-24s %s\n", "model", "recipe", "parameters", "layers", "sha256");
    for (size_t i = 0; nqm_model_builtin_name(i); ++i) {
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
    return json ? print_document(json_row("models:o", list)) : EXIT_OK;
}

static int print_model(const char *path, bool json) {
    nqm_model *model = open_model(path);
    json_t *members = json_row("kind:s name:s", "model", path);
    if (json) {
        json_object_update_new(members, json_model(model));
        print_document(members);
    } else {
        print_members(members);
        print_model_text(model);
    }
    nqm_model_free(model);
    return EXIT_OK;
}

/* Datasets, models, networks and tables are safetensors files; a value of their metadata distinguishes them. */
static int print_file(const char *path, bool json) {
    enum { MAX_FORMAT = 32 };
    char format[MAX_FORMAT] = "";
    nqm_map map;
    nqm_safetensors *tensors = NULL;
    if (nqm_map_open(path, &map, NULL) == NQM_OK) {
        if (nqm_safetensors_parse(map.data, map.n_bytes, path, &tensors, NULL) == NQM_OK)
            snprintf(format, sizeof format, "%s",
                     nqm_safetensors_meta(tensors, "format") ? nqm_safetensors_meta(tensors, "format") : "");
        nqm_safetensors_free(tensors);
        nqm_map_close(&map);
    }
    if (strcmp(format, "nqm-dataset") == 0)
        return print_dataset(path, json);
    if (strcmp(format, "nqm-nbrdf") == 0 || strcmp(format, "nqm-table") == 0)
        return print_brdf(path, json);
    return print_model(path, json); /* the reader of models has the best message for a damaged file */
}

/* The presets whose names contain `word`. */
static int print_presets(const char *word, bool json) {
    json_t *presets = json ? json_array() : NULL;
    size_t n = 0;
    for (size_t i = 0; nqm_brdf_preset_name(i); ++i) {
        const char *name = nqm_brdf_preset_name(i);
        size_t n_model = strcspn(name, ":");
        if (!strstr(name, word))
            continue;
        ++n;
        if (json)
            json_array_append_new(presets, json_pack("{s:s,s:s#,s:s}", "name", name, "model", name, (int)n_model,
                                                     "material", name + n_model + 1));
        else
            puts(name);
    }
    if (n == 0)
        return report(EXIT_USAGE, "no preset has '%s' in its name; `nqm info list` prints all", word);
    return json ? print_document(json_row("presets:o", presets)) : EXIT_OK;
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static bool json, models, half;
static const char *notes, *output;

static const option options[] = {
    {"models", 0, OPTION_FLAG, &models, NULL, "list the built-in models", 0, 0},
    OPTION_ROW_IGNORE,
    {"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0},
    {"notes", 0, OPTION_TEXT, &notes, "NOTES.md", "with -o: write a copy of the model with this text added to its card",
     0, 0},
    {"output", 'o', OPTION_TEXT, &output, "FILE.safetensors", "with --notes: the model file to write", 0, 0},
    {"half", 0, OPTION_FLAG, &half, NULL, "with --notes: store hidden layers' weights in 16 bits", 0, 0},
    {0}};

static const command cmd = {
    .usage = "FILE|SPEC|MODEL|list [WORD] [options]",
    .about = "What a BRDF (file, spec or preset), built-in model, model file, dataset file or file of several "
             "materials contains. `list` prints the presets, or those with WORD in their names: published fits of "
             "measured materials. For BRDFs the albedo at normal incidence is computed too. Of a model: size, "
             "checksum, directions and the card, which describes training data, results and limits. --notes writes a "
             "copy of a model with a text added to its card, such as results on a test set; --half also rounds the "
             "weights of the hidden layers to 16 bits, which halves the file.",
    .example = "nqm info sgd:nickel\nnqm info 'ggx:kd=.2,.1,.05;ks=1;alpha=.1;f0=.04' --json\nnqm info list nickel\n"
               "nqm info --models\nnqm info default\n"
               "nqm info my.safetensors --notes results.md -o my-judged.safetensors",
    .options = options,
    .max_arguments = 2,
};

int cmd_info(int argc, char **argv) {
    const int n_arguments = parse_arguments(&cmd, argc, argv);
    if ((n_arguments == 0) != models)
        stop(EXIT_USAGE, models ? "--models takes no argument: it lists the built-in models"
                                : "the argument is missing: a file, a spec, a model, or `list`; or --models");
    if (!notes != !output || (half && !notes))
        stop(EXIT_USAGE, "a copy of a model needs both: --notes NOTES.md -o FILE");
    if (models)
        return list_models(json);
    if (strcmp(argv[0], "list") == 0)
        return print_presets(n_arguments > 1 ? argv[1] : "", json);
    if (n_arguments > 1)
        refuse_near_word(argv[0], "list");
    if (n_arguments > 1)
        stop(EXIT_USAGE, "%s: too many arguments; info describes one file or spec", argv[1]);
    refuse_near_word(argv[0], "list");
    if (notes)
        return annotate_model(argv[0], notes, half, output);
    if (is_builtin(argv[0]))
        return print_model(argv[0], json);
    nqm_argument *argument = parse_argument(argv[0]);
    const nqm_materials *several = nqm_argument_library(argument);
    const int code = nqm_argument_is_textured(argument) ? print_texture(argument, json)
                     : several                          ? print_materials(argv[0], several, json)
                     : looks_like_safetensors(argv[0])  ? print_file(argv[0], json)
                                                        : print_brdf(argv[0], json);
    nqm_argument_free(argument);
    return code;
}
