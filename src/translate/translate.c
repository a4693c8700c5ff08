/* SPDX-License-Identifier: MIT
 *
 * Translation of a BRDF to a shading model: what both models share is copied, and a fit starts there.
 */
#include "translate/translate.h"

#include "base/options.h"
#include "brdf/brdf.h"
#include "fit/fit.h"
#include "material/material.h"
#include <nqm/metric.h>

#include <string.h>

nqm_translate_model nqm_translate_target(size_t i) {
    const nqm_schema *schema = nqm_schema_shading(i);
    nqm_translate_model m = {.name = NULL};
    if (schema) {
        const char *all = nqm_material_extensions(schema->model);
        m = (nqm_translate_model){.name = schema->model, .alias = schema->alias, .about = schema->about};
        snprintf(m.extension, sizeof m.extension, "%.*s", (int)strcspn(all, " "), all);
    }
    return m;
}

/* Where a model cannot look like the reference, values and rays may lead a fit past what its properties say. */
static nqm_status keep_better(const nqm_brdf *ref, const nqm_brdf *fit, const nqm_match_loss *loss, nqm_translation *t,
                              nqm_error *err) {
    nqm_brdf *copy = NULL;
    nqm_score_result result[2];
    nqm_score_options options = nqm_score_options_default();
    options.metrics = 0;
    nqm_status status = nqm_brdf_open(t->copied, &copy, err);
    const nqm_brdf *tests[] = {fit, copy};
    if (status == NQM_OK)
        status = nqm_score(loss->metric, ref, 2, tests, &options, result, err);
    if (status == NQM_OK && result[1].jod > result[0].jod) {
        snprintf(t->match.fit.spec, sizeof t->match.fit.spec, "%s", t->copied);
        snprintf(t->match.selected, sizeof t->match.selected, "the keys of both models");
    }
    nqm_brdf_free(copy);
    return status;
}

/* Copy what both models share; false: out of memory. */
static bool copy_values(const nqm_brdf *ref, const nqm_schema *schema, nqm_translation *t) {
    const char *spec = nqm_brdf_get_info(ref).spec;
    nqm_values from, to = nqm_values_of(schema);
    if (!spec || nqm_values_parse_spec(spec, &from, NULL) != NQM_OK)
        return true;
    nqm_translate_list_dropped(&from, schema, t->dropped, sizeof t->dropped);
    nqm_translate_values(&from, &to);
    char *copied = to.given ? nqm_values_spec(&to) : NULL;
    snprintf(t->copied, sizeof t->copied, "%s", copied ? copied : "");
    nqm_free(copied);
    return copied || !to.given;
}

nqm_status nqm_translate(const nqm_brdf *ref, const char *model, const char *path, const char *name,
                         const nqm_match_loss *loss, const nqm_fit_options *options, nqm_translation *result,
                         nqm_error *err) {
    NQM_REQUIRE(err, ref, model, loss, result);
    NQM_REQUIRE(err, loss->text, loss->metric);
    nqm_fit_options fit = options ? *options : nqm_fit_options_default();
    const nqm_schema *schema;
    nqm_brdf *brdf = NULL;
    *result = (nqm_translation){.dropped = ""};
    nqm_status status = nqm_schema_find_shading(model, &schema, err);
    if (status == NQM_OK && path)
        status = nqm_material_check(schema->model, path, err);
    if (status != NQM_OK)
        return status;
    if (!copy_values(ref, schema, result))
        return nqm_fail_nomem(err, sizeof result->copied);
    char *lobe = *result->copied ? NULL : nqm_fit_measure_anisotropy(ref, schema, false);
    if (strncmp(loss->text, "auto", 4) == 0) /* other losses would begin there only */
        fit.start = lobe ? lobe : *result->copied ? result->copied : NULL;
    status = nqm_match(ref, schema->model, loss, &fit, &result->match, &brdf, err);
    nqm_free(lobe);
    if (status == NQM_OK && *result->copied)
        status = keep_better(ref, brdf, loss, result, err);
    if (status == NQM_OK && path)
        status = nqm_material_write(result->match.fit.spec, name ? name : "material", path, err);
    nqm_brdf_free(brdf);
    return status;
}
