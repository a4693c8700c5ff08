/* SPDX-License-Identifier: MIT
 *
 * The list of all models and wrappers, and BRDFs from specs "MODEL:key=value;..." and "TABLE:PRESET".
 */
#include "brdf/core/spec.h"

#define POINTER_TO(NAME)         &(NAME),
#define SHADING_MODEL(NAME, ...) &nqm_##NAME##_model,
static const nqm_analytic_model *const models[] = {NQM_ANALYTIC_MODELS(POINTER_TO) NQM_SHADING_SCHEMAS(SHADING_MODEL)
                                                       NQM_SLOW_SCHEMAS(SHADING_MODEL) NULL};

static const nqm_spec_wrapper *const wrappers[] = {&nqm_perturb_wrapper, &nqm_between_wrapper, &nqm_rotate_wrapper,
                                                   &nqm_tilt_wrapper, NULL};
enum { MAX_NESTED = 3 };

const nqm_analytic_model *nqm_analytic_model_find(const char *name, size_t n) {
    const nqm_analytic_model *const *m = models;
    while (*m && !(strncmp((*m)->schema->model, name, n) == 0 && (*m)->schema->model[n] == 0))
        ++m;
    return *m;
}

/* The wrapper of the first n characters of `name`, or NULL. */
static const nqm_spec_wrapper *find_wrapper(const char *name, size_t n) {
    const nqm_spec_wrapper *const *w = wrappers;
    while (*w && !(strncmp((*w)->schema.model, name, n) == 0 && (*w)->schema.model[n] == 0))
        ++w;
    return *w;
}

const nqm_spec_wrapper *nqm_spec_wrapper_of(const char *text) {
    const size_t n = strcspn(text, ":");
    return text[n] == ':' ? find_wrapper(text, n) : NULL;
}

/* Whether specs begin with the first n characters of `name`. */
static bool begins_specs(const char *name, size_t n) {
    return find_wrapper(name, n) || nqm_analytic_model_find(name, n) || nqm_preset_table_find(name, n);
}

bool nqm_spec_probe(const char *text) {
    size_t n = strcspn(text, ":");
    return text[n] == ':' && begins_specs(text, n);
}

size_t nqm_spec_lacks_colon(const char *text) {
    const size_t n = strcspn(text, ";=, ");
    const char *rest = text[n] ? text + n + 1 : "";
    const bool is_setting = rest[strcspn(rest, ":/.=")] == '=';
    return (text[n] == ';' || is_setting) && begins_specs(text, n) ? n : 0;
}

void nqm_spec_nearest(nqm_nearest *nearest) {
    for (const nqm_analytic_model *const *m = models; *m; ++m)
        nqm_nearest_add(nearest, (*m)->schema->model);
    for (const nqm_preset_table *t = nqm_preset_tables; t->name; ++t)
        nqm_nearest_add(nearest, t->name);
    for (const nqm_spec_wrapper *const *w = wrappers; *w; ++w)
        nqm_nearest_add(nearest, (*w)->schema.model);
}

const char *nqm_brdf_preset_name(size_t i) {
    return i < nqm_preset_name_count ? nqm_preset_names[i] : NULL;
}

/* "kd (RGB), ks (RGB), alpha (x, y)" */
static size_t describe(const nqm_schema *schema, char *layout, size_t n_layout) {
    size_t n_values = 0, used = 0;
    for (size_t k = 0; k < schema->n_keys; ++k) {
        const nqm_schema_key *key = &schema->keys[k];
        if (used < n_layout)
            used += (size_t)snprintf(layout + used, n_layout - used, "%s%s%s", k ? ", " : "", key->name,
                                     key->n == 3   ? " (RGB)"
                                     : key->n == 2 ? " (x, y)"
                                                   : "");
        n_values += key->n;
    }
    return n_values;
}

static nqm_status wrap(const nqm_analytic_model *model, const nqm_values *values, nqm_brdf_info info,
                       nqm_brdf **brdf_ret, nqm_error *err) {
    void *state = nqm_alloc(1, model->state_size);
    if (!state)
        return nqm_fail_nomem(err, model->state_size);
    if (model->class_.jacobian == nqm_spec_jacobian)
        *(nqm_spec_state *)state = (nqm_spec_state){model, *values};
    model->prepare(values, state);
    info.isotropic = nqm_values_are_isotropic(values);
    return nqm_brdf_wrap(&model->class_, state, &info, brdf_ret, err);
}

nqm_status nqm_brdf_of_values(const nqm_values *values, nqm_brdf **brdf_ret, nqm_error *err) {
    const nqm_analytic_model *const *m = models;
    while ((*m)->schema != values->schema)
        ++m;
    *brdf_ret = NULL;
    return wrap(*m, values, (nqm_brdf_info){.name = values->schema->model}, brdf_ret, err);
}

static nqm_status open_analytic(const nqm_analytic_model *model, nqm_values *values, const char *name, const char *doi,
                                nqm_brdf **brdf_ret, nqm_error *err) {
    char layout[1024];
    size_t n_values = describe(model->schema, layout, sizeof layout);
    values->given = UINT64_MAX; /* the canonical form names every key, so that it does not depend on defaults */
    char *spec = nqm_values_spec(values);
    if (!spec)
        return nqm_fail_nomem(err, sizeof layout);
    const nqm_brdf_info info = {.name = name, .spec = spec, .source_doi = doi, .layout = layout, .n_values = n_values};
    nqm_status status = wrap(model, values, info, brdf_ret, err);
    nqm_free(spec);
    return status;
}

nqm_status nqm_spec_check_nesting(const char *spec, nqm_error *err) {
    size_t n = 0;
    for (const char *at = spec; *at; ++at)
        for (const nqm_spec_wrapper *const *w = wrappers; *w; ++w)
            n += strncmp(at, (*w)->schema.model, strlen((*w)->schema.model)) == 0 &&
                 at[strlen((*w)->schema.model)] == ':';
    return n > MAX_NESTED
               ? nqm_fail(err, NQM_ERR_LIMIT, -1,
                          "a spec may contain at most %d of perturb:, between:, rotate: and tilt:", MAX_NESTED)
               : NQM_OK;
}

nqm_status nqm_spec_open(const char *spec, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    const size_t n_name = strcspn(spec, ":");
    const char *settings = spec + n_name + 1;
    const nqm_preset_table *table = nqm_preset_table_find(spec, n_name);
    const nqm_analytic_model *model = nqm_analytic_model_find(spec, n_name);
    const bool is_preset = table && !strchr(settings, '=');
    if (!is_preset && !model)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%.*s: names presets, and takes no parameters; %s: does", (int)n_name,
                        spec, table->model);
    nqm_values values;
    if (is_preset)
        model = nqm_analytic_model_find(table->model, strlen(table->model));
    nqm_status status = is_preset ? nqm_preset_find(table, model->schema, settings, &values, err)
                                  : nqm_values_parse(model->schema, settings, &values, err);
    return status == NQM_OK ? open_analytic(model, &values, name, is_preset ? table->doi : model->doi, brdf_ret, err)
                            : status;
}
