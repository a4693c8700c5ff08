/* SPDX-License-Identifier: MIT
 *
 * A BRDF between two others: the arithmetic or the geometric mean of their values, with the weight t of the second. It is
 * reciprocal if both are.
 */
#include "brdf/core/spec.h"

#include <math.h>
#include <string.h>

enum { T, LOG, N_KEYS };

static const nqm_spec_schema schema = {
    "between",
    N_KEYS,
    {[T] = {.name = "t", .n = 1, .low = 0, .high = 1, .required = true},
     [LOG] = {.name = "log", .n = 1, .low = 0, .high = 1, .whole = true, .fallback = 0}}};

typedef struct between {
    nqm_between_bases bases;
    double t;
    bool is_geometric;
} between;

static double mean(const between *self, double of, double with) {
    if (self->is_geometric) /* pow(0, 0) is 1, so that t = 0 and t = 1 give one of the two */
        return pow(of, 1 - self->t) * pow(with, self->t);
    return (1 - self->t) * of + self->t * with;
}

static void between_eval_half_diff(const void *state, size_t n, const double *hd, double *rgb) {
    enum { BLOCK = 128 };
    const between *self = state;
    double with[3 * BLOCK];
    uint8_t flag[2][BLOCK];
    for (size_t first = 0; first < n; first += BLOCK) {
        size_t m = nqm_smaller(n - first, BLOCK);
        double *out = rgb + 3 * first;
        nqm_brdf_eval_half_diff(self->bases.of, m, hd + 3 * first, out, flag[0]);
        nqm_brdf_eval_half_diff(self->bases.with, m, hd + 3 * first, with, flag[1]);
        for (size_t i = 0; i < 3 * m; ++i)
            out[i] = nqm_has_value(flag[0][i / 3]) && nqm_has_value(flag[1][i / 3]) ? mean(self, out[i], with[i]) : NAN;
    }
}

static void free_owned(const nqm_between_bases *bases) {
    if (bases->owns_of)
        nqm_brdf_free(bases->of);
    if (bases->owns_with)
        nqm_brdf_free(bases->with);
}

static void between_free(void *state) {
    between *self = state;
    free_owned(&self->bases);
    nqm_free(self);
}

/* Indexed by reciprocity. */
static const nqm_brdf_class between_classes[2] = {
    {.format = "between", .reciprocal = 0, .eval_half_diff = between_eval_half_diff, .free = between_free},
    {.format = "between", .reciprocal = 1, .eval_half_diff = between_eval_half_diff, .free = between_free}};

/* ---- opening ----------------------------------------------------------------------------------------------------- */

static const char *spec_of(const nqm_brdf *brdf) {
    return brdf->info.spec ? brdf->info.spec : brdf->info.name;
}

/* "between:t=0.3;with=(WITH);of=OF"; nqm_free(); NULL when out of memory. */
static char *canonical_spec(const nqm_spec_values *values, const nqm_brdf *of, const nqm_brdf *with) {
    char *own = nqm_spec_format(&schema, values);
    size_t n = own ? strlen(own) + strlen(spec_of(of)) + strlen(spec_of(with)) + sizeof ";with=();of=" : 0;
    char *spec = own ? nqm_alloc(n, 1) : NULL;
    if (spec)
        snprintf(spec, n, "%s;with=(%s);of=%s", own, spec_of(with), spec_of(of));
    nqm_free(own);
    return spec;
}

/* Owned bases are freed also on failure. */
static nqm_status wrap(const nqm_spec_values *values, const nqm_between_bases *bases, const char *name,
                       nqm_brdf **brdf_ret, nqm_error *err) {
    char layout[160];
    const nqm_brdf *of = bases->of, *with = bases->with;
    between *self = nqm_alloc(1, sizeof *self);
    char *spec = canonical_spec(values, of, with);
    if (!self || !spec) {
        nqm_free(self);
        nqm_free(spec);
        free_owned(bases);
        return nqm_fail_nomem(err, sizeof *self);
    }
    self->bases = *bases;
    self->t = values->v[T][0];
    self->is_geometric = values->v[LOG][0] != 0;
    const nqm_brdf_info info = {.name = name ? name : spec, .spec = spec, .layout = layout};
    snprintf(layout, sizeof layout, "of %s with %s", of->info.format, with->info.format);
    const bool reciprocal = of->class_->reciprocal && with->class_->reciprocal;
    nqm_status status = nqm_brdf_wrap(&between_classes[reciprocal], self, &info, brdf_ret, err);
    nqm_free(spec);
    return status;
}

nqm_status nqm_between_wrap(const char *settings, const nqm_between_bases *bases, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_spec_values values;
    *brdf_ret = NULL;
    nqm_status status = nqm_spec_parse(&schema, settings, &values, err);
    if (status == NQM_OK)
        return wrap(&values, bases, NULL, brdf_ret, err);
    free_owned(bases);
    return status;
}

/* The parenthesis that closes the one before `text`; NULL: there is none. */
static char *closing(char *text) {
    size_t open = 1;
    for (; *text; ++text) {
        open += *text == '(';
        open -= *text == ')';
        if (open == 0)
            return text;
    }
    return NULL;
}

/* Split "SETTINGS;with=(WITH);of=OF" in place; false: it has another form. */
static bool split(char *text, const char **with, const char **of) {
    static const char begin[] = ";with=(", middle[] = ";of=";
    char *at = strstr(text, begin), *end = at ? closing(at + strlen(begin)) : NULL;
    if (!end || strncmp(end + 1, middle, strlen(middle)) != 0)
        return false;
    *with = at + strlen(begin);
    *of = end + 1 + strlen(middle);
    *at = *end = 0;
    return true;
}

static nqm_status open_both(char *text, const char *name, nqm_brdf_opener *open, nqm_brdf **brdf_ret, nqm_error *err) {
    const char *of_text, *with_text;
    nqm_brdf *of, *with;
    nqm_spec_values values;
    if (!split(text, &with_text, &of_text))
        return nqm_fail(err, NQM_ERR_ARG, -1, "between: the form is between:t=0.5;with=(BRDF);of=BRDF");
    nqm_status status = nqm_spec_parse(&schema, text, &values, err);
    if (status == NQM_OK)
        status = open(of_text, of_text, &of, err);
    if (status != NQM_OK)
        return status;
    status = open(with_text, with_text, &with, err);
    if (status == NQM_OK)
        return wrap(&values, &(nqm_between_bases){of, with, true, true}, name, brdf_ret, err);
    nqm_brdf_free(of);
    return status;
}

static nqm_status open_between(const char *settings, const char *name, nqm_brdf_opener *open, nqm_brdf **brdf_ret,
                               nqm_error *err) {
    char *text = nqm_strdup(settings);
    if (!text)
        return nqm_fail_nomem(err, strlen(settings) + 1);
    nqm_status status = open_both(text, name, open, brdf_ret, err);
    nqm_free(text);
    return status;
}

const nqm_spec_wrapper nqm_between_wrapper = {"between", open_between};
