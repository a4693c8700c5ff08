/* SPDX-License-Identifier: MIT
 *
 * Inputs from arguments: models and directions (built in or from a file), BRDFs, datasets, short text files.
 */
#include "base/os.h"
#include "brdf/formats/listed.h"
#include "fit/fit.h"
#include "material/material.h"
#include "nqm/textured.h"
#include "nqm/tool.h"
#include "pairs/pairs.h"
#include "render/render.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

bool is_builtin(const char *name) {
    for (size_t i = 0; nqm_model_builtin_name(i); ++i)
        if (strcmp(nqm_model_builtin_name(i), name) == 0)
            return true;
    return false;
}

/* A word that names no file. */
static bool is_word(const char *argument) {
    return !strpbrk(argument, "/.") && !nqm_os_exists(argument);
}

static bool is_spec(const char *name) {
    const nqm_argument_kind kind = nqm_argument_kind_of(name);
    return kind == NQM_ARGUMENT_SPEC || kind == NQM_ARGUMENT_WRAPPER;
}

/* " (did you mean 'default'?)" for the nearest built-in model, or "". */
static nqm_nearest nearest_model(const char *word) {
    nqm_nearest nearest = nqm_nearest_begin(word);
    for (size_t i = 0; nqm_model_builtin_name(i); ++i)
        nqm_nearest_add(&nearest, nqm_model_builtin_name(i));
    return nearest;
}

static _Noreturn void stop_unknown_model(const char *name) {
    char known[256] = "";
    const nqm_nearest nearest = nearest_model(name);
    for (size_t i = 0, n = 0; nqm_model_builtin_name(i) && n < sizeof known; ++i)
        n += (size_t)snprintf(known + n, sizeof known - n, "%s%s", i ? ", " : "", nqm_model_builtin_name(i));
    bool is_all = strcmp(name, "all") == 0, is_metric = is_all;
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        is_metric |= strcmp(nqm_metric_get_info((nqm_metric)m).name, name) == 0;
    if (is_metric)
        stop(EXIT_MODEL,
             "there is no model '%s': it is %s, which --metrics %s adds to the results of score and batch; eval always "
             "has them",
             name, is_all ? "the word for all scalar metrics" : "a scalar metric", name);
    if (is_spec(name))
        stop(EXIT_MODEL, "'%s' is a BRDF, not a model: built in are %s; or give a model file", name, known);
    if (*known)
        stop(EXIT_MODEL, "there is no model '%s'%s: built in are %s; or give a model file", name, nearest.advice,
             known);
    stop(EXIT_MODEL,
         "there is no model '%s': this build has no built-in model; give a model file (`nqm train` makes one)", name);
}

void *allocate(size_t n, size_t size) {
    void *block = calloc(n ? n : 1, size);
    if (!block)
        stop(EXIT_LIMIT, "out of memory: %zu x %zu bytes", n, size);
    return block;
}

void *must_have(void *block) {
    if (!block)
        stop(EXIT_LIMIT, "out of memory");
    return block;
}

FILE *open_text(char **text, size_t *n) {
    return must_have(nqm_os_memory_stream(text, n));
}

void close_text(FILE *stream, char **text, size_t *n) {
    must_have(nqm_os_close_memory(stream, text, n) ? *text : NULL);
}

char *join_with_colon(const char *a, const char *b) {
    char *text = allocate(strlen(a) + strlen(b) + 2, 1);
    sprintf(text, "%s%s%s", a, *a && *b ? ":" : "", b);
    return text;
}

nqm_model *open_model(const char *name_or_path) {
    const char *name = name_or_path ? name_or_path : "default";
    nqm_model *model;
    if (!is_builtin(name) && (is_word(name) || (is_spec(name) && !nqm_os_exists(name))))
        stop_unknown_model(name);
    must(nqm_model_load(name, &model, &fault));
    return model;
}

nqm_scene *open_judge(const char *loss, const char *transport) {
    nqm_scene_options options = nqm_scene_options_default();
    nqm_match_sum sum;
    nqm_scene *scene = NULL;
    must(nqm_match_parse(loss, &sum, &fault));
    options.n_points = 1024; /* and few directions: fits are judged on rays that are drawn */
    options.n_lights = 16;
    if (sum.is_auto && strcmp(transport, "transport") == 0 && nqm_tracer_available())
        must(nqm_scene_create(&options, &scene, &fault));
    return scene;
}

void refuse_model_name(const char *argument) {
    if (!is_word(argument))
        return;
    if (is_builtin(argument))
        stop(EXIT_USAGE, "'%s' is a model, not a BRDF: models belong to --model (nqm score REF TEST --model %s)",
             argument, argument);
    const nqm_nearest nearest = nearest_model(argument);
    if (*nearest.advice)
        stop(EXIT_OPEN, "there is no file '%s'%s", argument, nearest.advice);
}

void refuse_near_word(const char *argument, const char *word) {
    nqm_nearest nearest = nqm_nearest_begin(argument);
    nqm_nearest_add(&nearest, word);
    if (*nearest.advice && is_word(argument))
        stop(EXIT_USAGE, "there is no file '%s'%s", argument, nearest.advice);
}

void report_remark(const nqm_brdf *brdf) {
    const nqm_brdf_info info = nqm_brdf_get_info(brdf);
    if (info.remark)
        report(EXIT_OK, "%s: %s", shown(info.name), info.remark);
}

nqm_brdf *open_brdf(const char *argument) {
    nqm_brdf *brdf;
    refuse_model_name(argument);
    must(nqm_fit_open(argument, NULL, &brdf, &fault));
    return brdf;
}

nqm_brdf **open_brdfs(int n, char **arguments) {
    nqm_brdf **brdfs = allocate((size_t)n, sizeof *brdfs);
    for (int i = 0; i < n; ++i)
        brdfs[i] = open_brdf(arguments[i]);
    return brdfs;
}

void close_brdfs(int n, nqm_brdf **brdfs) {
    for (int i = 0; i < n; ++i)
        nqm_brdf_free(brdfs[i]);
    free(brdfs);
}

char *read_text(const char *path) {
    enum { MAX_TEXT_BYTES = 1 << 20 };
    nqm_file_info info;
    FILE *file = nqm_os_open_text(path);
    if (file && nqm_os_get_info(path, &info))
        must(nqm_role_input(&info, path, &fault));
    char *text = allocate(MAX_TEXT_BYTES + 1, 1);
    size_t n = file ? fread(text, 1, MAX_TEXT_BYTES, file) : 0;
    if (!file || ferror(file))
        stop(EXIT_OPEN, "%s: cannot be read as text: %s", path, strerror(errno));
    if (memchr(text, '\0', n) || fgetc(file) != EOF)
        stop(EXIT_MALFORMED, "%s: cannot be read as text: it has NUL bytes, or is larger than 1 MiB", path);
    fclose(file);
    return text;
}

const char **take_names(int n, char **arguments) {
    const char **names = allocate((size_t)n, sizeof *names);
    nqm_pairs_name *given = allocate((size_t)n, sizeof *given);
    size_t n_given = 0, group = 0;
    for (int i = 0; i < n; ++i) {
        const size_t n_name = nqm_argument_name_length(arguments[i]);
        size_t n_stream;
        const char *stream = stream_name(arguments[i], &n_stream);
        if (*stream && arguments[i][n_stream] == '\0')
            names[i] = stream;
        group += strcmp(arguments[i], "+") == 0;
        if (n_name) {
            arguments[i][n_name] = '\0';
            names[i] = arguments[i];
            given[n_given++] = (nqm_pairs_name){group, 0, "", names[i]};
            arguments[i] += n_name + 1;
        }
        refuse_model_name(arguments[i]);
    }
    must(nqm_pairs_check_names(n_given, given, NULL, &fault));
    free(given);
    return names;
}

nqm_argument *parse_argument(const char *text) {
    return must_have(nqm_argument_parse(text, NULL));
}

/* ---- what materials do besides reflecting ------------------------------------------------------------------------ */

const char *ignored_words, *within;

bool has_same_refusal(const nqm_named_pair *pair) {
    return nqm_pairs_refused_alike(NULL, pair);
}

unsigned ignored_set(void) {
    unsigned ignored = 0;
    if (ignored_words && !nqm_ignore_parse(ignored_words, strlen(ignored_words), &ignored))
        must(nqm_ignore_refuse(ignored_words, &fault));
    return ignored;
}

const char *reflecting(const char *argument) {
    const unsigned ignored = ignored_set();
    const size_t n_name = nqm_argument_name_length(argument), at = n_name ? n_name + 1 : 0;
    nqm_argument *a = ignored ? parse_argument(argument + at) : NULL;
    char *taken = a ? nqm_argument_reflecting(a, ignored) : NULL;
    nqm_argument_free(a);
    if (!taken || !at)
        return taken ? taken : argument;
    char *text = must_have(nqm_strdupf("%.*s%s", (int)at, argument, taken));
    nqm_free(taken);
    return text;
}

static char *list_folder; /* the last result of list_root() */

const char *list_root(const char *root, const char *list_path) {
    nqm_file_info info;
    if (root && !nqm_os_is_folder(root))
        stop(EXIT_OPEN, "--root: there is no folder '%s'", root);
    if (root)
        return root;
    const char *slash = strrchr(list_path, '/');
    if (nqm_os_is_device(list_path) || !slash || !nqm_os_get_info(list_path, &info) || info.kind != NQM_FILE_REGULAR)
        return NULL;
    const size_t n = slash == list_path ? 1 : (size_t)(slash - list_path);
    free(list_folder);
    list_folder = allocate(n + 1, 1);
    memcpy(list_folder, list_path, n);
    return list_folder;
}

void enter_list_root(const char *root, const char *list_path) {
    const char *folder = list_root(root, list_path);
    if (folder && !nqm_os_enter_folder(folder))
        stop(EXIT_OPEN, "%s: cannot be entered: %s", folder, strerror(errno));
}

bool looks_like_safetensors(const char *path) {
    nqm_map map;
    const bool is_json = nqm_map_open_own(path, &map, NULL) == NQM_OK && map.n_bytes > 8 && map.data[8] == '{';
    nqm_map_close(&map);
    return is_json;
}

nqm_directions *open_directions(const char *name_or_path) {
    nqm_directions *directions;
    const char *name = name_or_path ? name_or_path : "default";
    if (is_builtin(name) || (name_or_path && looks_like_safetensors(name))) {
        nqm_model *model = open_model(name);
        const nqm_directions *borrowed = nqm_model_get_info(model).directions;
        must(nqm_directions_from_degrees(nqm_directions_get_info(borrowed).n, nqm_directions_get_info(borrowed).degrees,
                                         &directions, &fault));
        nqm_model_free(model);
    } else if (name_or_path) {
        const nqm_nearest nearest = nearest_model(name);
        if (is_word(name) && *nearest.advice)
            stop(EXIT_OPEN, "there is no file and no model '%s'%s", name, nearest.advice);
        must(nqm_directions_load_csv(input_path(name), &directions, &fault));
    } else {
        nqm_directions_options grid = nqm_directions_options_default();
        grid.grid = 1;
        must(nqm_directions_create(&grid, 0, NULL, &directions, &fault));
    }
    return directions;
}

void report_distance(const char *argument, const nqm_brdf *brdf, const nqm_directions *directions) {
    const size_t n = nqm_directions_get_info(directions).n;
    double apart[2];
    must(nqm_scattered_distances(brdf, n, nqm_directions_get_info(directions).wi,
                                 nqm_directions_get_info(directions).wo, apart, &fault));
    char text[400];
    if (nqm_pairs_describe_distance(argument, apart, sizeof text, text))
        report(EXIT_OK, "%s", text);
}

nqm_dataset *open_dataset(const char *path, const char *labels, nqm_split split) {
    nqm_dataset *dataset;
    const bool folder = nqm_os_is_folder(path);
    if (folder && !labels)
        stop(EXIT_USAGE, "%s: a folder (the authors' layout) needs its labels: --labels CSV", path);
    if (!folder && labels)
        stop(nqm_os_exists(path) ? EXIT_USAGE : EXIT_OPEN, "%s: %s", path,
             nqm_os_exists(path) ? "--labels is for a folder (the authors' layout), not for a dataset file"
                                 : strerror(errno));
    must(nqm_dataset_load(path, labels ? input_path(labels) : NULL, split, &dataset, &fault));
    return dataset;
}
