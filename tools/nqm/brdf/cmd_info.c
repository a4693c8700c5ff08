/* SPDX-License-Identifier: MIT
 *
 * nqm info - prints what a BRDF, model or dataset file contains; `nqm info list` prints the names of the presets.
 */
#include "nqm/tool.h"

#include <stdlib.h>
#include <string.h>

/* ---- BRDFs ------------------------------------------------------------------------------------------------------- */

static json_t *json_text(const char *text) {
    return text && *text ? json_string(text) : json_null();
}

static int print_brdf_json(const nqm_brdf_info *info, const double *albedo) {
    json_t *root = json_pack("{s:i,s:o,s:s,s:s,s:o}", "schema", 1, "tool", json_tool(), "kind", "brdf", "format",
                             info->format, "name", json_name(info->name));
    json_object_set_new(root, "spec", json_text(info->spec));
    json_object_set_new(root, "source_doi", json_text(info->source_doi));
    json_object_set_new(root, "layout", json_text(info->layout));
    json_object_set_new(root, "n_values", json_integer((json_int_t)info->n_values));
    json_object_set_new(root, "n_bytes", json_integer((json_int_t)info->n_bytes));
    json_object_set_new(root, "reciprocal", json_boolean(info->reciprocal));
    json_object_set_new(root, "albedo_normal",
                        json_pack("[o,o,o]", json_number(albedo[0]), json_number(albedo[1]), json_number(albedo[2])));
    return print_json(root);
}

static int print_brdf(const nqm_brdf *brdf, bool json) {
    nqm_brdf_info info = nqm_brdf_get_info(brdf);
    double albedo[3];
    nqm_brdf_albedo(brdf, 0, 1, albedo);
    if (json)
        return print_brdf_json(&info, albedo);
    printf("%s\n  kind        BRDF\n  format      %s\n", info.name, info.format);
    if (info.layout)
        printf("  layout      %s\n", info.layout);
    printf("  values      %zu\n", info.n_values);
    if (info.n_bytes)
        printf("  bytes       %zu\n", info.n_bytes);
    if (info.source_doi)
        printf("  source      doi:%s\n", info.source_doi);
    if (info.spec)
        printf("  spec        %s\n", info.spec);
    printf("  reciprocal  %s\n", info.reciprocal ? "by construction" : "not by construction (`nqm check` measures it)");
    printf("  albedo      %.4f %.4f %.4f  (red, green, blue; light along the normal)\n", albedo[0], albedo[1],
           albedo[2]);
    return EXIT_OK;
}

static int info_brdf(const char *argument, bool json) {
    nqm_brdf *brdf = NULL;
    nqm_error err = {0};
    if (nqm_brdf_open(argument, &brdf, &err) != NQM_OK)
        return report_error("info", &err);
    int exit_code = print_brdf(brdf, json);
    nqm_brdf_free(brdf);
    return exit_code;
}

/* ---- models ------------------------------------------------------------------------------------------------------ */

static json_t *json_directions(const nqm_directions *directions) {
    return json_pack("{s:I,s:s}", "n", (json_int_t)nqm_directions_count(directions), "id",
                     nqm_directions_id(directions));
}

static int print_model_json(const nqm_model_info *info, const char *path) {
    json_t *root = json_pack("{s:i,s:o,s:s,s:s,s:s}", "schema", 1, "tool", json_tool(), "kind", "model", "name", path,
                             "id", info->id);
    json_object_set_new(root, "recipe", json_text(info->recipe));
    json_object_set_new(root, "sha256", json_text(info->sha256));
    json_object_set_new(root, "licence", json_text(info->licence));
    json_object_set_new(root, "manifest_sha256", json_text(info->manifest_sha256));
    json_object_set_new(root, "parameters", json_integer((json_int_t)info->n_parameters));
    json_t *layers = json_array();
    for (size_t i = 0; i <= info->n_layers; ++i)
        json_array_append_new(layers, json_integer((json_int_t)info->layer_sizes[i]));
    json_object_set_new(root, "layers", layers);
    json_object_set_new(root, "jod_range", json_pack("[o,o]", json_number(info->jod_min), json_number(info->jod_max)));
    json_object_set_new(root, "directions", json_directions(info->directions));
    json_object_set_new(root, "card", json_text(info->card));
    return print_json(root);
}

static int info_model(const char *path, bool json) {
    nqm_model *model = NULL;
    nqm_error err = {0};
    if (nqm_model_load(path, &model, &err) != NQM_OK)
        return report_error("info", &err);
    nqm_model_info info = nqm_model_get_info(model);
    int exit_code = EXIT_OK;
    if (json) {
        exit_code = print_model_json(&info, path);
    } else {
        printf("%s\n  kind        model\n  id          %s\n  recipe      %s\n  parameters  %zu\n  layers     ", path,
               info.id, info.recipe, info.n_parameters);
        for (size_t i = 0; i <= info.n_layers; ++i)
            printf(" %zu", info.layer_sizes[i]);
        printf("\n  JOD         %.2f to %.2f\n  directions  %zu, id %s\n  licence     %s\n  sha256      %s\n\n%s\n",
               info.jod_min, info.jod_max, nqm_directions_count(info.directions), nqm_directions_id(info.directions),
               info.licence, info.sha256, info.card);
    }
    nqm_model_free(model);
    return exit_code;
}

/* ---- datasets ---------------------------------------------------------------------------------------------------- */

static int print_dataset_json(const nqm_dataset_info *info, const char *path) {
    json_t *manifest = json_loads(info->manifest, 0, NULL);
    json_t *root = json_pack("{s:i,s:o,s:s,s:s}", "schema", 1, "tool", json_tool(), "kind", "dataset", "name", path);
    json_object_set_new(root, "sha256", json_text(info->sha256));
    json_object_set_new(root, "references", json_integer((json_int_t)info->n_refs));
    json_object_set_new(root, "groups", json_integer((json_int_t)info->n_groups));
    json_object_set_new(root, "pairs", json_integer((json_int_t)info->n_pairs));
    json_object_set_new(root, "pairs_in",
                        json_pack("{s:I,s:I,s:I}", "train", (json_int_t)info->n_pairs_in[0], "validation",
                                  (json_int_t)info->n_pairs_in[1], "test", (json_int_t)info->n_pairs_in[2]));
    json_object_set_new(root, "directions", json_directions(info->directions));
    json_object_set_new(root, "manifest", manifest ? manifest : json_null());
    return print_json(root);
}

static int info_dataset(const char *path, bool json) {
    nqm_dataset *dataset = NULL;
    nqm_error err = {0};
    if (nqm_dataset_load(path, &dataset, &err) != NQM_OK)
        return report_error("info", &err);
    nqm_dataset_info info = nqm_dataset_get_info(dataset);
    int exit_code = EXIT_OK;
    if (json)
        exit_code = print_dataset_json(&info, path);
    else
        printf("%s\n  kind        dataset\n  pairs       %zu: %zu train, %zu validation, %zu test\n"
               "  references  %zu, in %zu groups\n  directions  %zu, id %s\n  sha256      %s\n",
               path, info.n_pairs, info.n_pairs_in[0], info.n_pairs_in[1], info.n_pairs_in[2], info.n_refs,
               info.n_groups, nqm_directions_count(info.directions), nqm_directions_id(info.directions), info.sha256);
    nqm_dataset_free(dataset);
    return exit_code;
}

/* ---- kind of a file ---------------------------------------------------------------------------------------------- */

typedef enum file_kind { KIND_BRDF, KIND_MODEL, KIND_DATASET } file_kind;

/* Read the JSON header of a safetensors file, which follows a length of eight bytes; NULL when it is not readable.
 * *like_one is set to true when the file starts like a safetensors file. */
static json_t *read_header(FILE *in, bool *like_one) {
    enum { MAX_HEADER = 1 << 26 };
    unsigned char start[9];
    if (fread(start, 1, sizeof start, in) != sizeof start || start[8] != '{')
        return NULL;
    *like_one = true;
    uint64_t n = 0;
    for (int i = 7; i >= 0; --i)
        n = n << 8 | start[i];
    if (fseek(in, 0, SEEK_END) != 0 || n > MAX_HEADER || ftell(in) < (long)n + 8 || fseek(in, 8, SEEK_SET) != 0)
        return NULL;
    char *text = malloc(n);
    json_t *header = text && fread(text, 1, n, in) == n ? json_loadb(text, n, 0, NULL) : NULL;
    free(text);
    return header;
}

/* Models, datasets, networks and tables are safetensors files; __metadata__.format distinguishes them. */
static file_kind kind_of(const char *path) {
    FILE *in = fopen(path, "rb");
    if (!in)
        return KIND_BRDF;
    bool safetensors = false;
    json_t *header = read_header(in, &safetensors);
    fclose(in);
    const char *format = json_string_value(json_object_get(json_object_get(header, "__metadata__"), "format"));
    bool dataset = format && strcmp(format, "nqm-dataset") == 0;
    bool brdf = format && (strcmp(format, "nqm-nbrdf") == 0 || strcmp(format, "nqm-table") == 0);
    json_decref(header);
    if (dataset)
        return KIND_DATASET;
    return safetensors && !brdf ? KIND_MODEL : KIND_BRDF; /* the model reader has the best message for a damaged file */
}

static int info_list(bool json) {
    size_t n = nqm_brdf_preset_count();
    if (!json) {
        for (size_t i = 0; i < n; ++i)
            puts(nqm_brdf_preset_name(i));
        return EXIT_OK;
    }
    json_t *presets = json_array();
    for (size_t i = 0; i < n; ++i) {
        const char *name = nqm_brdf_preset_name(i);
        size_t n_model = strcspn(name, ":");
        json_array_append_new(presets, json_pack("{s:s,s:s#,s:s}", "name", name, "model", name, (int)n_model,
                                                 "material", name + n_model + 1));
    }
    return print_json(json_pack("{s:i,s:o,s:o}", "schema", 1, "tool", json_tool(), "presets", presets));
}

int cmd_info(int argc, char **argv) {
    bool json = false;
    const option options[] = {
        {.name = "json", .kind = OPTION_FLAG, .target = &json, .help = "print the result as JSON"}, {0}};
    const command cmd = {
        .name = "info",
        .usage = "FILE|SPEC|list [options]",
        .about = "What a BRDF (file, spec or preset), model file or dataset file holds. `list` names the presets: "
                 "published\n"
                 "fits of measured materials. For BRDFs the albedo at normal incidence is computed too.",
        .example = "nqm info sgd:nickel\nnqm info 'ggx:kd=.2,.1,.05;ks=1;alpha=.1;f0=.04' --json\nnqm info list",
        .options = options,
        .min_arguments = 1,
        .max_arguments = 1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    if (strcmp(argv[0], "list") == 0)
        return info_list(json);
    switch (kind_of(argv[0])) {
    case KIND_MODEL:
        return info_model(argv[0], json);
    case KIND_DATASET:
        return info_dataset(argv[0], json);
    case KIND_BRDF:
        break;
    }
    return info_brdf(argv[0], json);
}
