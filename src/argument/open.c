/* SPDX-License-Identifier: MIT
 *
 * Opens the BRDF of an argument.
 */
#include "argument/argument.h"
#include "base/os.h"

#include "brdf/core/spec.h"
#include <errno.h>

static nqm_status fail_absent(const char *path, nqm_error *err) {
    return nqm_fail(err, NQM_ERR_IO, -1, "%s: %s", path, strerror(nqm_os_exists(path) ? 0 : errno));
}

/* Neither a file nor a spec: is it a misspelt spec, or one without its colon or with another character there? */
static nqm_status fail_missing(const char *text, nqm_error *err) {
    char model[64];
    if (!*text)
        return nqm_fail(err, NQM_ERR_ARG, -1, "a BRDF argument is empty");
    if (!strchr(text, ':') && nqm_analytic_model_find(text, strlen(text)))
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: no such file; a spec of this model is '%s:key=value;...'", text,
                        text);
    const char *preset = nqm_preset_named(text);
    if (preset)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: no such file; a preset of this name is '%s'", text, preset);
    const size_t n_model = nqm_spec_lacks_colon(text);
    if (n_model)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%.150s: no such file; in a spec, ':' follows the model: '%.*s:%.150s'",
                        text, (int)n_model, text, text + n_model + 1);
    preset = nqm_preset_without_colon(text);
    if (preset)
        return nqm_fail(err, NQM_ERR_IO, -1, "%s: No such file or directory (did you mean '%s'?)", text, preset);
    snprintf(model, sizeof model, "%.*s", (int)strcspn(text, ":"), text);
    nqm_nearest nearest = nqm_nearest_begin(model);
    nqm_spec_nearest(&nearest);
    if (!strpbrk(text, ":/.")) { /* a word: also a preset without its table */
        nqm_preset_nearest(&nearest);
        return *nearest.advice ? nqm_fail(err, NQM_ERR_ARG, -1, "%.200s: there is no such file, model or preset%s",
                                          text, nearest.advice)
                               : fail_absent(text, err);
    }
    if (!strchr(text, ':') || (!*nearest.advice && strpbrk(model, "/.")))
        return fail_absent(text, err);
    return *nearest.advice
               ? nqm_fail(err, NQM_ERR_ARG, -1, "%.200s: no such file, and there is no model '%s'%s", text, model,
                          nearest.advice)
               : nqm_fail(err, NQM_ERR_IO, -1, "%.200s: No such file or directory, and no model '%s'", text, model);
}

static nqm_status open_base(void *user, const char *text, nqm_brdf **brdf_ret, bool *is_lent_ret, nqm_error *err) {
    (void)user;
    *is_lent_ret = false;
    return nqm_argument_open_text(text, text, NULL, brdf_ret, err);
}

nqm_status nqm_argument_wrap(const nqm_argument *a, const char *name, nqm_base_opener *open, void *user,
                             nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_between_bases bases = {.of = NULL};
    bool is_lent = false;
    nqm_values values;
    *brdf_ret = NULL;
    nqm_status status = nqm_wrapper_parse(a->wrapper, a->settings, &values, err); /* first: opening may take long */
    if (status == NQM_OK)
        status = open(user, a->of, &bases.of, &is_lent, err);
    bases.owns_of = !is_lent;
    if (status == NQM_OK && a->with)
        status = open(user, a->with, &bases.with, &is_lent, err);
    bases.owns_with = !is_lent;
    if (status == NQM_OK)
        return nqm_wrapper_make(a->wrapper, &values, &bases, name, brdf_ret, err);
    if (bases.owns_of)
        nqm_brdf_free(bases.of);
    return status;
}

/* A file that is no material, or that of a folder. */
static nqm_status open_file(nqm_argument *a, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    const char *path = a->network ? a->network : a->path;
    if (a->n_networks && !a->network)
        return nqm_fail_nomem(err, strlen(a->path));
    if (a->n_networks > 1)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: a folder of %zu networks; give one of their files, %s", a->path,
                        a->n_networks, a->network);
    if (!a->map.path) { /* it was opened before */
        nqm_status status = nqm_map_open_sparse(path, &a->map, err);
        if (status != NQM_OK)
            return status;
    }
    const nqm_brdf_argument of = {.name = name, .member = a->member};
    nqm_status status = nqm_brdf_open_file(a->format, &a->map, &of, brdf_ret, err);
    nqm_map_close(&a->map);
    return status;
}

static nqm_status open_as(nqm_argument *a, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    *brdf_ret = NULL;
    if (a->err.status != NQM_OK)
        return nqm_fail(err, a->err.status, a->err.byte_offset, "%s", a->err.message);
    switch (a->kind) {
    case NQM_ARGUMENT_SPEC:
        return nqm_spec_open(a->rest, name, brdf_ret, err);
    case NQM_ARGUMENT_WRAPPER: {
        nqm_status status = nqm_spec_check_nesting(a->text, err);
        return status == NQM_OK ? nqm_argument_wrap(a, name, open_base, NULL, brdf_ret, err) : status;
    }
    case NQM_ARGUMENT_MATERIAL:
        return nqm_argument_open_material(a, name, brdf_ret, err);
    case NQM_ARGUMENT_FILE:
    case NQM_ARGUMENT_NETWORKS:
        return open_file(a, name, brdf_ret, err);
    case NQM_ARGUMENT_MAPS:
    case NQM_ARGUMENT_FOLDER:
        return nqm_fail(err, NQM_ERR_IO, -1, "%.250s: %s, and a BRDF is that of one point" NQM_TEXTURE_ADVICE, a->text,
                        a->kind == NQM_ARGUMENT_MAPS ? "is a list of image maps"
                                                     : "is a directory of image maps or other files");
    case NQM_ARGUMENT_NOTHING:
    case NQM_ARGUMENT_FIT:
        break;
    }
    return fail_missing(a->rest, err);
}

nqm_status nqm_argument_open(nqm_argument *a, nqm_brdf **brdf_ret, nqm_error *err) {
    return open_as(a, a->text, brdf_ret, err);
}

nqm_status nqm_argument_open_text(const char *text, const char *name, nqm_argument_files *files, nqm_brdf **brdf_ret,
                                  nqm_error *err) {
    nqm_argument *a = nqm_argument_parse(text, files);
    *brdf_ret = NULL;
    nqm_status status = a ? open_as(a, name, brdf_ret, err) : nqm_fail_nomem(err, strlen(text) + 1);
    nqm_argument_free(a);
    return status;
}

nqm_status nqm_brdf_open(const char *path_or_spec, nqm_brdf **brdf_ret, nqm_error *err) {
    NQM_MAKE(err, brdf_ret, path_or_spec);
    return nqm_argument_open_text(path_or_spec, path_or_spec, NULL, brdf_ret, err);
}

nqm_status nqm_argument_open_below(const char *text, const char *root, nqm_brdf **brdf_ret, nqm_error *err) {
    char *path = nqm_argument_below(text, root);
    *brdf_ret = NULL;
    if (!path)
        return nqm_fail_nomem(err, strlen(text) + 1);
    nqm_status status = nqm_argument_open_text(path, path, NULL, brdf_ret, err);
    nqm_free(path);
    return status;
}
