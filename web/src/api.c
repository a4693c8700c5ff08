/* SPDX-License-Identifier: MIT
 *
 * The functions that JavaScript calls (web/nqm.js): BRDFs by number, results as JSON, pictures as pixels. Everything is computed by the
 * library and by the parts of the tool that have no command line.
 */
#include "base/embedded.h"
#include "brdf/brdf.h"
#include "figures/picture.h"
#include "fit/match.h"
#include "math/math.h"
#include "nqm/fit/translate.h"
#include "nqm/score/score.h"
#include "render/render.h"

#include <jansson.h>
#include <math.h>
#include <nqm/nqm.h>
#include <stdlib.h>

#define EXPORT(NAME) __attribute__((export_name(#NAME))) NAME

/* ---- results ----------------------------------------------------------------------------------------------------- */

static char *result; /* of the last call; freed by the next */

static const char *reply(json_t *json) {
    free(result);
    result = json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(17));
    json_decref(json);
    return result ? result : "{\"error\":\"out of memory\",\"status\":-6}";
}

static json_t *error_json(const nqm_error *err) {
    return json_pack("{s:s,s:i,s:I}", "error", err->message, "status", err->status, "byte", (json_int_t)err->byte_offset);
}

static json_t *number(double x) {
    return isfinite(x) ? json_real(x) : json_null();
}

static json_t *text(const char *s) {
    json_t *json = s ? json_string(s) : json_null();
    return json ? json : json_string("(no UTF-8)");
}

void *EXPORT(web_alloc)(size_t n) {
    return nqm_alloc(n, 1);
}

void EXPORT(web_free)(void *block) {
    nqm_free(block);
}

/* ---- models ------------------------------------------------------------------------------------------------------ */

enum { N_MODELS = 2 };
static struct {
    const char *const name;
    nqm_model *model;
    nqm_scorer *scorer;
} models[N_MODELS] = {{.name = "default"}, {.name = "transport"}};

static nqm_status use_model(int i, nqm_error *err) {
    nqm_score_options options = nqm_score_options_default();
    if (i < 0 || i >= N_MODELS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "there is no such model");
    nqm_status status = models[i].model ? NQM_OK : nqm_model_builtin(models[i].name, &models[i].model, err);
    if (status == NQM_OK && !models[i].scorer)
        status = nqm_scorer_create(models[i].model, &options, &models[i].scorer, err);
    return status;
}

/* The place of an embedded file, which JavaScript fills before the first call; NULL: there is none of this name. */
unsigned char *EXPORT(web_model_bytes)(const char *name) {
    for (const nqm_embedded_file *m = nqm_embedded_models; m->name; ++m)
        if (strcmp(m->name, name) == 0)
            return (unsigned char *)(uintptr_t)m->begin;
    return NULL;
}

/* ---- scores ------------------------------------------------------------------------------------------------------ */

static json_t *score_json(const char *ref, const char *test, const nqm_score_result *r, const nqm_error *err) {
    char words[NQM_LABEL_TEXT] = "";
    if (r->status != NQM_OK)
        return error_json(err);
    if (!isnan(r->parts.structure))
        nqm_label_describe(&r->parts, words);
    json_t *metrics = json_object();
    for (int m = 0; m < NQM_METRIC_COUNT; ++m)
        json_object_set_new(metrics, nqm_metric_name((nqm_metric)m), number(r->metrics[m]));
    (void)ref, (void)test;
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:s,s:[ooo],s:o,s:o,s:[ooo],s:o,s:b,s:o,s:I}", "jod", number(r->jod), "low",
                     number(r->jod_low), "high", number(r->jod_high), "delta_e", number(r->delta_e), "novelty", number(r->novelty),
                     "words", words, "shift", number(r->parts.shift[0]), number(r->parts.shift[1]), number(r->parts.shift[2]),
                     "contrast", number(r->parts.contrast), "structure", number(r->parts.structure), "apart",
                     number(r->similarity[0]), number(r->similarity[1]), number(r->similarity[2]), "anisotropy",
                     number(r->anisotropy), "identical", r->identical, "metrics", metrics, "n_valid", (json_int_t)r->n_valid);
}

/* pairs: an array of [reference, test], each a path or spec. The result is an array of scores and errors. */
const char *EXPORT(web_score_names)(int model, const char *pairs) {
    nqm_error err = {0};
    json_t *list = json_loads(pairs, 0, NULL), *scores = json_array();
    const size_t n = json_array_size(list);
    nqm_named_pair *named = nqm_alloc(n, sizeof *named);
    nqm_score_result *results = nqm_alloc(n, sizeof *results);
    nqm_error *errors = nqm_alloc(n, sizeof *errors);
    nqm_status status = use_model(model, &err);
    if (status == NQM_OK && !(named && results && errors))
        status = nqm_fail_nomem(&err, n * sizeof *results);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        json_t *pair = json_array_get(list, i);
        named[i] = (nqm_named_pair){json_string_value(json_array_get(pair, 0)), json_string_value(json_array_get(pair, 1))};
    }
    if (status == NQM_OK)
        status = nqm_scorer_run_named(models[model].scorer, n, named, results, errors, &err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        json_array_append_new(scores, score_json(named[i].ref, named[i].test, &results[i], &errors[i]));
    nqm_free(named);
    nqm_free(results);
    nqm_free(errors);
    json_decref(list);
    if (status != NQM_OK) {
        json_decref(scores);
        return reply(error_json(&err));
    }
    return reply(scores);
}
