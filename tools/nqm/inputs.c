/* SPDX-License-Identifier: MIT
 *
 * Inputs from arguments: models and directions (built in or from a file), BRDFs, short text files.
 */
#include "nqm/tool.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static bool is_builtin(const char *name) {
    for (size_t i = 0; i < nqm_model_builtin_count(); ++i)
        if (strcmp(nqm_model_builtin_name(i), name) == 0)
            return true;
    return false;
}

static int report_unknown_model(const char *verb, const char *name) {
    if (nqm_model_builtin_count() == 0)
        return report(
            verb, EXIT_MODEL,
            "there is no model '%s': this build has no built-in model; give a model file (`nqm train` makes one)",
            name);
    char known[256] = "";
    for (size_t i = 0; i < nqm_model_builtin_count(); ++i) {
        size_t n = strlen(known);
        snprintf(known + n, sizeof known - n, "%s%s", i ? ", " : "", nqm_model_builtin_name(i));
    }
    return report(verb, EXIT_MODEL, "there is no model '%s': built in are %s; or give a model file", name, known);
}

int open_model(const char *verb, const char *name_or_path, nqm_model **model_ret) {
    *model_ret = NULL;
    const char *name = name_or_path ? name_or_path : "default";
    nqm_error err = {0};
    bool is_built_in = is_builtin(name);
    if (!is_built_in && !strpbrk(name, "/.") && access(name, F_OK) != 0)
        return report_unknown_model(verb, name);
    nqm_status status = is_built_in ? nqm_model_builtin(name, model_ret, &err) : nqm_model_load(name, model_ret, &err);
    return status == NQM_OK ? EXIT_OK : report_error(verb, &err);
}

int open_brdfs(const char *verb, int n, char **arguments, nqm_brdf ***brdfs_ret) {
    *brdfs_ret = NULL;
    nqm_error err = {0};
    nqm_brdf **brdfs = calloc((size_t)n + 1, sizeof *brdfs);
    if (!brdfs)
        return report(verb, EXIT_LIMIT, "out of memory");
    for (int i = 0; i < n; ++i)
        if (nqm_brdf_open(arguments[i], &brdfs[i], &err) != NQM_OK) {
            close_brdfs(i, brdfs);
            return report_error(verb, &err);
        }
    *brdfs_ret = brdfs;
    return EXIT_OK;
}

void close_brdfs(int n, nqm_brdf **brdfs) {
    for (int i = 0; i < n; ++i)
        nqm_brdf_free(brdfs[i]);
    free(brdfs);
}

int read_text(const char *verb, const char *path, char **text_ret) {
    enum { MAX_TEXT_BYTES = 1 << 20 };
    *text_ret = NULL;
    FILE *file = fopen(path, "rb");
    char *text = file ? calloc(MAX_TEXT_BYTES + 1, 1) : NULL;
    size_t n = text ? fread(text, 1, MAX_TEXT_BYTES, file) : 0;
    bool is_unread = !text || ferror(file);
    int reason = errno;
    bool is_binary = !is_unread && (memchr(text, '\0', n) || fgetc(file) != EOF);
    if (file)
        fclose(file);
    if (is_unread || is_binary) {
        free(text);
        return report(verb, is_unread ? EXIT_OPEN : EXIT_MALFORMED, "%s: cannot be read as text: %s", path,
                      is_unread ? strerror(reason) : "it has NUL bytes, or is larger than 1 MiB");
    }
    *text_ret = text;
    return EXIT_OK;
}

/* A model file is in safetensors format: eight bytes of length, then a JSON object. A CSV has no '{' there. */
static bool looks_like_model(const char *path) {
    FILE *file = fopen(path, "rb");
    if (!file)
        return false;
    char head[9] = {0};
    size_t n = fread(head, 1, sizeof head, file);
    fclose(file);
    return n == sizeof head && head[8] == '{';
}

int open_directions(const char *verb, const char *name_or_path, nqm_directions **directions_ret) {
    *directions_ret = NULL;
    nqm_error err = {0};
    nqm_status status;
    const char *name = name_or_path ? name_or_path : "default";
    if (is_builtin(name) || (name_or_path && looks_like_model(name))) {
        nqm_model *model;
        int exit_code = open_model(verb, name, &model);
        if (exit_code != EXIT_OK)
            return exit_code;
        const nqm_directions *borrowed = nqm_model_get_info(model).directions;
        status = nqm_directions_from_degrees(nqm_directions_count(borrowed), nqm_directions_degrees(borrowed),
                                             directions_ret, &err);
        nqm_model_free(model);
    } else if (name_or_path) {
        status = nqm_directions_load_csv(input_path(name), directions_ret, &err);
    } else {
        status = nqm_directions_create(NULL, 0, NULL, directions_ret, &err);
    }
    return status == NQM_OK ? EXIT_OK : report_error(verb, &err);
}
