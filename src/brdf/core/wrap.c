/* SPDX-License-Identifier: MIT
 *
 * BRDFs made of other BRDFs: "WRAPPER:SETTINGS;of=OF" and "WRAPPER:SETTINGS;with=(WITH);of=OF".
 */
#include "brdf/core/spec.h"

static void free_owned(const nqm_between_bases *bases) {
    if (bases->owns_of)
        nqm_brdf_free(bases->of);
    if (bases->owns_with)
        nqm_brdf_free(bases->with);
}

void nqm_wrapper_free(void *state) {
    free_owned(state);
    nqm_free(state);
}

/* The spec of a base, or its name when it is a file. */
static const char *spec_of(const nqm_brdf *brdf) {
    return brdf->info.spec ? brdf->info.spec : brdf->info.name;
}

/* nqm_free(); NULL when out of memory. */
static char *canonical_spec(const nqm_values *values, const nqm_between_bases *bases) {
    const char *of = spec_of(bases->of), *with = bases->with ? spec_of(bases->with) : "";
    char *own = nqm_values_spec(values);
    char *spec = own ? nqm_strdupf("%s%s%s%s;of=%s", own, *with ? ";with=(" : "", with, *with ? ")" : "", of) : NULL;
    nqm_free(own);
    return spec;
}

/* name NULL: the spec. Owned bases are freed also on failure. */
static nqm_status wrap(const nqm_spec_wrapper *w, const nqm_values *values, const nqm_between_bases *bases,
                       const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    const nqm_brdf_info *of = &bases->of->info, *with = bases->with ? &bases->with->info : NULL;
    char layout[160], remark[NQM_REMARK_SIZE] = "", *spec = canonical_spec(values, bases);
    nqm_brdf_info info = {.name = name ? name : spec, .spec = spec, .layout = layout, .remark = remark};
    info.source_doi = with ? NULL : of->source_doi;
    info.reciprocal = of->reciprocal && (!with || with->reciprocal);
    info.isotropic = of->isotropic && (!with || with->isotropic);
    if (with)
        snprintf(layout, sizeof layout, "of %s with %s", of->format, with->format);
    else
        snprintf(layout, sizeof layout, "over %s, %.100s", of->format, of->layout ? of->layout : "");
    for (size_t i = 0; i < 2; ++i)
        if ((i ? with : of) && (i ? with : of)->remark)
            nqm_remark_add(remark, sizeof remark, "%s", (i ? with : of)->remark);
    void *state = NULL;
    nqm_status status = spec ? w->create(values, bases, &info, &state, err) : nqm_fail_nomem(err, sizeof layout);
    if (status == NQM_OK) {
        *(nqm_between_bases *)state = *bases;
        status = nqm_brdf_wrap(&w->class_, state, &info, brdf_ret, err);
    } else {
        free_owned(bases);
    }
    nqm_free(spec);
    return status;
}

static nqm_status parse(const nqm_spec_wrapper *w, const char *settings, nqm_values *values, nqm_error *err) {
    nqm_status status = nqm_values_parse(&w->schema, settings, values, err);
    if (status == NQM_OK && !(values->given & ~w->idle))
        status = nqm_fail(err, NQM_ERR_ARG, -1,
                          "%s: nothing is changed: give scale, tint, gloss, peak, ... before 'of='", w->schema.model);
    return status;
}

nqm_status nqm_wrapper_check(const nqm_spec_wrapper *w, const char *settings, nqm_error *err) {
    nqm_values values;
    return parse(w, settings, &values, err);
}

nqm_status nqm_wrapper_make(const nqm_spec_wrapper *w, const char *settings, const char *name,
                            const nqm_between_bases *bases, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_values values;
    *brdf_ret = NULL;
    nqm_status status = parse(w, settings, &values, err);
    if (status == NQM_OK)
        return wrap(w, &values, bases, name, brdf_ret, err);
    free_owned(bases);
    return status;
}
