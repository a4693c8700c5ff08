/* SPDX-License-Identifier: MIT
 *
 * A shading model with its properties, and its text: the spec "MODEL:key=value;key=red,green,blue;key=x,y".
 */
#include "material/material.h"

const nqm_property *nqm_shading_find(const nqm_shading *shading, const char *key) {
    for (size_t i = 0; i < shading->n; ++i)
        if (strcmp(shading->properties[i].key, key) == 0)
            return &shading->properties[i];
    return NULL;
}

void nqm_shading_set(nqm_shading *shading, const char *key, size_t n, const double *v) {
    nqm_property *p = (nqm_property *)nqm_shading_find(shading, key);
    if (!p) {
        if (shading->n == NQM_MAX_PROPERTIES || strlen(key) >= sizeof p->key)
            return;
        p = &shading->properties[shading->n++];
        *p = (nqm_property){.n = 0};
        strcpy(p->key, key);
    }
    p->n = n;
    for (size_t c = 0; c < 3; ++c)
        p->v[c] = v[nqm_smaller(c, n - 1)];
}

enum { NUMBER_SIZE = 32, PROPERTY_SIZE = sizeof(((nqm_property *)0)->key) + 3 * NUMBER_SIZE };

char *nqm_shading_spec(const nqm_shading *shading) {
    const size_t size = sizeof shading->model + 1 + shading->n * PROPERTY_SIZE;
    char *text = nqm_alloc(size, 1), numbers[3 * NUMBER_SIZE];
    if (!text)
        return NULL;
    size_t used = (size_t)snprintf(text, size, "%s:", shading->model);
    for (size_t i = 0; i < shading->n; ++i) {
        const nqm_property *p = &shading->properties[i];
        used += (size_t)snprintf(text + used, size - used, "%s%s=%s", i ? ";" : "", p->key,
                                 nqm_format_doubles(numbers, sizeof numbers, p->n, p->v, ","));
    }
    return text;
}

size_t nqm_parse_numbers(const char *text, size_t max_n, double *v) {
    static const char separators[] = " ,\t\r\n";
    size_t n = 0;
    for (text += strspn(text, separators); *text; text += strspn(text, separators)) {
        if (n == max_n || !nqm_parse_double(text, &text, &v[n]) || (*text && !strchr(separators, *text)))
            return 0;
        ++n;
    }
    return n;
}

static nqm_status fail_text(const char *spec, nqm_error *err) {
    return nqm_fail(err, NQM_ERR_ARG, -1, "%.200s: not a spec of a shading model (MODEL:key=value;...)", spec);
}

/* Parse "key=v", "key=v,v" or "key=v,v,v" at `text`; *end receives the end. */
static bool parse_property(const char *text, const char **end, nqm_shading *shading) {
    const size_t n_key = strcspn(text, "=;");
    char key[sizeof((nqm_property *)0)->key];
    double v[3];
    size_t n = 0;
    if (text[n_key] != '=' || n_key >= sizeof key)
        return false;
    memcpy(key, text, n_key);
    key[n_key] = 0;
    text += n_key;
    do {
        if (n == 3 || !nqm_parse_double(text + 1, &text, &v[n]))
            return false;
        ++n;
    } while (*text == ',');
    if (*text && *text != ';')
        return false;
    nqm_shading_set(shading, key, n, v);
    *end = text + (*text == ';');
    return true;
}

nqm_status nqm_shading_parse(const char *spec, nqm_shading *shading, nqm_error *err) {
    const size_t n_model = strcspn(spec, ":");
    *shading = (nqm_shading){.n = 0};
    if (!spec[n_model] || n_model >= sizeof shading->model)
        return fail_text(spec, err);
    memcpy(shading->model, spec, n_model);
    for (const char *text = spec + n_model + 1; *text;)
        if (!parse_property(text, &text, shading))
            return fail_text(spec, err);
    return NQM_OK;
}
