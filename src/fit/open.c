/* SPDX-License-Identifier: MIT
 *
 * Opens BRDF arguments that are fitted when they are opened. "fit:SETTINGS;of=BRDF" is the result of nqm_fit(), or of one of the
 * variations of it with which corpora test a metric: a point on the path of the optimiser (steps), a network that overfits few
 * directions (at, own), a reciprocal table (model=table).
 */
#include "fit/fit.h"
#include "math/math.h"

#include <string.h>

enum { MAX_OVERFITTED = 100000 };

/* ---- settings of a fit ------------------------------------------------------------------------------------------- */

typedef struct settings {
    const char *model; /* in the text */
    nqm_fit_options options;
    size_t n_steps; /* SIZE_MAX: not given */
    size_t n_at;    /* overfit this many directions; 0: all */
    bool own;       /* of the caller */
} settings;

static nqm_status set_count(const char *key, const char *value, size_t low, size_t high, size_t *count_ret,
                            nqm_error *err) {
    const char *end;
    double number;
    if (!nqm_parse_double(value, &end, &number) || *end || !(number >= (double)low && number <= (double)high) ||
        number != (double)(size_t)number)
        return nqm_fail(err, NQM_ERR_ARG, -1, "fit: %s needs a whole number from %zu to %zu, not '%s'", key, low, high,
                        value);
    *count_ret = (size_t)number;
    return NQM_OK;
}

/* One "key=value"; options have the names of `nqm fit`. */
static nqm_status set_one(char *text, settings *s, nqm_error *err) {
    bool is_off = false;
    char *value = strchr(text, '=');
    if (!value)
        return nqm_fail(err, NQM_ERR_ARG, -1, "fit: '%.80s' is no setting; the form is fit:model=ggx;of=BRDF", text);
    *value++ = 0;
    if (strcmp(text, "model") == 0) {
        s->model = value;
        return NQM_OK;
    }
    if (strcmp(text, "steps") == 0)
        return set_count(text, value, 0, 1000, &s->n_steps, err);
    if (strcmp(text, "at") == 0 || strcmp(text, "own") == 0) {
        s->own = *text == 'o';
        return set_count(text, value, 1, MAX_OVERFITTED, &s->n_at, err);
    }
    const nqm_option *option = strcmp(text, "loss") == 0
                                   ? nqm_option_by_key(&nqm_fit_option_table, text)
                                   : nqm_option_by_name(&nqm_fit_option_table, text, strlen(text), &is_off);
    if (!option || option->kind == NQM_OPTION_BOOL || option->kind == NQM_OPTION_TEXT) {
        nqm_nearest nearest = nqm_nearest_begin(text);
        static const char *const keys[] = {"model", "loss", "seed", "samples", "starts", "steps", "at", "own"};
        for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i)
            nqm_nearest_add(&nearest, keys[i]);
        return nqm_fail(err, NQM_ERR_ARG, -1, "fit: there is no setting '%.80s'%s", text, nearest.advice);
    }
    return nqm_option_set(option, &s->options, value, err);
}

static nqm_status parse(char *text, settings *s, nqm_error *err) {
    nqm_status status = NQM_OK;
    *s = (settings){.options = nqm_fit_options_default(), .n_steps = SIZE_MAX};
    for (char *at = text; status == NQM_OK && *at;) {
        const size_t n = strcspn(at, ";");
        char *next = at + n + (at[n] == ';');
        at[n] = 0;
        status = set_one(at, s, err);
        at = next;
    }
    if (status == NQM_OK && !s->model)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "fit: a model is missing (fit:model=ggx;of=BRDF)");
    if (status == NQM_OK && s->n_at && strcmp(s->model, "nbrdf") != 0)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "fit: 'at' and 'own' belong to the model nbrdf, not to %s", s->model);
    return status == NQM_OK ? nqm_options_check(&nqm_fit_option_table, &s->options, err) : status;
}

/* ---- fits -------------------------------------------------------------------------------------------------------- */

/* A network that is trained at few directions, random ones or some of the caller's. */
static nqm_status overfit(const nqm_brdf *ref, const settings *s, const nqm_fit_context *context, nqm_brdf **brdf_ret,
                          nqm_error *err) {
    const double degree = NQM_PI / 180;
    const size_t n_own = s->own ? context->n_own : 0, n = s->own ? nqm_smaller(s->n_at, n_own) : s->n_at;
    nqm_rng rng = nqm_rng_make(s->options.seed, 0);
    double *hd;
    size_t *own;
    if (n == 0)
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        "fit: 'own' means directions of a dataset, and there are none here; use 'at'");
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&hd, n, 3 * sizeof *hd}, {&own, n_own, sizeof *own}), err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < n_own; ++i)
        own[i] = i;
    nqm_rng_shuffle(&rng, n_own, own);
    for (size_t i = 0; i < n; ++i)
        if (!s->own)
            nqm_encode_draw_dense(&rng, 80 * degree, NQM_PI / 2, NQM_PI, hd + 3 * i);
        else
            for (size_t k = 0; k < 3; ++k)
                hd[3 * i + k] = context->own_deg[3 * own[i] + k] * degree;
    status = nqm_encode_nbrdf_at(ref, n, hd, s->options.seed, brdf_ret, err);
    nqm_free(hd);
    return status;
}

static nqm_status fit(const nqm_brdf *ref, char *text, const nqm_fit_context *context, nqm_brdf **brdf_ret,
                      nqm_error *err) {
    settings s;
    nqm_fit_report report = {.spec = ""};
    nqm_ticker ticker = {.fn = context->progress, .user = context->progress_user};
    nqm_status status = parse(text, &s, err);
    if (status != NQM_OK)
        return status;
    s.options.progress = context->progress;
    s.options.progress_user = context->progress_user;
    if (strcmp(s.model, "table") == 0)
        return nqm_brdf_tabulate(ref, nqm_table_general, &ticker, brdf_ret, err);
    if (s.n_at)
        return overfit(ref, &s, context, brdf_ret, err);
    if (s.n_steps == SIZE_MAX)
        return nqm_fit(ref, s.model, &s.options, &report, brdf_ret, err);
    status = nqm_fit_path(ref, s.model, &s.options, s.options.seed, s.n_steps, report.spec, err);
    return status == NQM_OK ? nqm_brdf_open(report.spec, brdf_ret, err) : status;
}

/* ---- opening ----------------------------------------------------------------------------------------------------- */

static nqm_status open_base(void *user, const char *text, nqm_brdf **brdf_ret, bool *is_lent, nqm_error *err) {
    const nqm_fit_context *context = user;
    *is_lent = false;
    *brdf_ret = NULL;
    return context->open ? context->open(context->user, text, brdf_ret, is_lent, err)
                         : nqm_fit_open(text, context, brdf_ret, err);
}

static nqm_status open_fit(const nqm_argument *a, const nqm_fit_context *context, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_brdf *of = NULL;
    bool is_lent = false;
    nqm_status status = open_base((void *)(uintptr_t)context, a->of, &of, &is_lent, err);
    if (status != NQM_OK)
        return status;
    status = fit(of, (char *)(uintptr_t)a->settings, context, brdf_ret, err);
    if (!is_lent)
        nqm_brdf_free(of);
    return status;
}

nqm_status nqm_fit_open(const char *argument, const nqm_fit_context *context_or_null, nqm_brdf **brdf_ret,
                        nqm_error *err) {
    const nqm_fit_context none = {0}, *context = context_or_null ? context_or_null : &none;
    NQM_MAKE(err, brdf_ret, argument);
    nqm_argument *a = nqm_argument_parse(argument, NULL);
    if (!a)
        return nqm_fail_nomem(err, strlen(argument) + 1);
    const bool is_made = a->err.status == NQM_OK && (context->open || strstr(argument, "fit:"));
    nqm_status status = is_made && a->kind == NQM_ARGUMENT_FIT ? open_fit(a, context, brdf_ret, err)
                        : is_made && a->kind == NQM_ARGUMENT_WRAPPER
                            ? nqm_argument_wrap(a, NULL, open_base, (void *)(uintptr_t)context, brdf_ret, err)
                            : nqm_argument_open(a, brdf_ret, err);
    nqm_argument_free(a);
    return status;
}
