/* SPDX-License-Identifier: MIT
 *
 * Scores of pairs with textures, by name, in the form of those of BRDFs.
 */
#include "library/library.h"

#include <math.h>
#include <stdarg.h>

void nqm_library_report(const nqm_library_terms *terms, nqm_status status, const char *format, ...) {
    enum { MOST = 4096 };
    char message[MOST];
    va_list args;
    if (!terms->report)
        return;
    va_start(args, format);
    vsnprintf(message, sizeof message, format, args);
    va_end(args);
    terms->report(terms->user, status, message);
}

nqm_score_result nqm_library_texture_result(const nqm_texture_result *t) {
    nqm_score_result r = nqm_no_score(NQM_OK);
    r.jod = t->jod;
    r.delta_e = t->delta_e;
    r.jod_low = t->jod_low;
    r.jod_high = t->jod_high;
    r.parts = t->parts;
    r.identical = t->n_different > 0 && t->delta_e == 0 && t->n_blame == 0;
    return r;
}

nqm_status nqm_library_open_texture(const nqm_library_terms *terms, nqm_argument *argument, nqm_texture **texture_ret,
                                    nqm_error *err) {
    const nqm_status status = nqm_texture_open_argument(argument, terms->progress, terms->user, texture_ret, err);
    if (status == NQM_OK && *nqm_texture_get_info(*texture_ret, NULL).remark)
        nqm_library_report(terms, NQM_OK, "%s: %s", argument->text, nqm_texture_get_info(*texture_ret, NULL).remark);
    return status;
}

/* Open unless it is. */
static nqm_status open_once(const nqm_library_terms *terms, nqm_library_kept *at, const char *name, nqm_error *err) {
    if (at->name && strcmp(at->name, name) == 0)
        return NQM_OK;
    nqm_texture_free(at->texture);
    *at = (nqm_library_kept){.name = NULL};
    nqm_argument *a = nqm_argument_parse(name, NULL);
    const nqm_status status =
        a ? nqm_library_open_texture(terms, a, &at->texture, err) : nqm_fail_nomem(err, strlen(name));
    nqm_argument_free(a);
    if (status == NQM_OK)
        at->name = name;
    return status;
}

static nqm_status compare(const nqm_library_terms *terms, const nqm_texture *ref, const nqm_texture *test,
                          nqm_texture_result *t, float **heat, nqm_error *err) {
    nqm_texture_options options = nqm_texture_options_default();
    const nqm_texture_info size = nqm_texture_get_info(ref, test);
    options.exact = terms->exact;
    options.far = options.blame = !terms->near_only;
    options.texels_per_pixel = nqm_larger(terms->texels_per_pixel, 1);
    options.progress = terms->progress;
    options.progress_user = terms->user;
    if (terms->keep_heat && !(*heat = nqm_alloc(size.width * size.height, sizeof **heat)))
        return nqm_fail_nomem(err, size.width * size.height * sizeof **heat);
    return nqm_texture_score(terms->model, ref, test, &options, t, terms->keep_heat ? *heat : NULL, err);
}

nqm_status nqm_library_score_texture(const nqm_library_terms *terms, const nqm_named_pair *pair, nqm_library_kept *ref,
                                     nqm_texture_result *t, nqm_score_result *result, float **heat, nqm_error *err) {
    nqm_library_kept test = {.name = NULL};
    nqm_status status = open_once(terms, ref, pair->ref, err);
    if (status == NQM_OK)
        status = open_once(terms, &test, pair->test, err);
    if (status == NQM_OK)
        status = compare(terms, ref->texture, test.texture, t, heat, err);
    nqm_texture_free(test.texture);
    if (status == NQM_OK)
        *result = nqm_library_texture_result(t);
    result->status = status;
    return status;
}
