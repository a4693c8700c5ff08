/* SPDX-License-Identifier: MIT
 *
 * Properties of materials by rules: see rules.h.
 */
#include "material/rules.h"

#include <stdarg.h>

static void give_reason(nqm_reading *r, nqm_reason *reason, const void *property, const char *format,
                        va_list arguments) {
    if (*reason->text)
        return;
    vsnprintf(reason->text, sizeof reason->text, format, arguments);
    reason->byte_offset = r->source->byte_of(r, property);
}

bool nqm_refuse(nqm_reading *r, const void *property, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    give_reason(r, &r->refusal, property, format, arguments);
    va_end(arguments);
    return false;
}

bool nqm_vary(nqm_reading *r, const void *property, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    give_reason(r, &r->varies, property, format, arguments);
    va_end(arguments);
    return true;
}

bool nqm_reading_begin(nqm_reading *r, const nqm_rule_source *source) {
    *r = (nqm_reading){.source = source, .textured = nqm_textured_create()};
    return r->textured != NULL;
}

const nqm_rule *nqm_rule_find(const nqm_rule *rules, const char *name) {
    for (const nqm_rule *rule = rules; name && rule->name; ++rule)
        if (nqm_contains_word(rule->name, name, false))
            return rule;
    return NULL;
}

/* The property is 0, or missing with the default 0. */
static bool is_zero(nqm_reading *r, const char *name) {
    const nqm_rule *rule = nqm_rule_find(r->rules, name);
    const void *property = r->source->find(r, name);
    double v[4] = {rule->value};
    size_t n = 1;
    if (property && !r->source->read(r, rule, property, v, &n))
        return false;
    for (size_t c = 0; c < n; ++c)
        if (v[c] != 0)
            return false;
    return true;
}

/* The properties that a gate names are 0. */
static bool is_off(nqm_reading *r, const char *gate) {
    char name[48];
    for (size_t n; *gate; gate += n + strspn(gate + n, " ")) {
        n = strcspn(gate, " ");
        snprintf(name, sizeof name, "%.*s", (int)n, gate);
        if (!is_zero(r, name))
            return false;
    }
    return true;
}

bool nqm_rules_apply(nqm_reading *r, const char *name, const void *property) {
    const nqm_rule *rule = nqm_rule_find(r->rules, name);
    if (!rule)
        return nqm_refuse(r, property, "%s has no %s '%.40s'", r->owner, r->source->term, name ? name : "");
    const uint64_t bit = (uint64_t)1 << (rule - r->rules);
    if (r->given & bit && rule->read != nqm_rule_ignore)
        return nqm_refuse(r, property, "%s is given twice", name);
    r->given |= bit;
    return (rule->gate && is_off(r, rule->gate)) || rule->read(r, rule, property);
}

bool nqm_rule_set(nqm_reading *r, const nqm_rule *rule, const void *property) {
    double v[4];
    size_t n;
    if (!r->source->read(r, rule, property, v, &n))
        return false;
    nqm_shading_set(&r->shading, rule->key, n, v);
    return true;
}

bool nqm_rule_neutral(nqm_reading *r, const nqm_rule *rule, const void *property) {
    const size_t n_before = strlen(r->refusal.text);
    const bool shows = r->source->shows_owner;
    char number[32];
    double v[4];
    size_t n;
    if (!r->source->read(r, rule, property, v, &n)) {
        const size_t n_refusal = strlen(r->refusal.text);
        if (n_refusal > n_before)
            snprintf(r->refusal.text + n_refusal, sizeof r->refusal.text - n_refusal, " (%s)", rule->why);
        return false;
    }
    for (size_t c = 0; c < n; ++c)
        if (v[c] != rule->value)
            return nqm_refuse(r, property, "%s%s%s is %s: %s", shows ? r->owner : "", shows ? "." : "", rule->name,
                              nqm_format_double(number, sizeof number, v[c]), rule->why);
    return true;
}

bool nqm_rule_ignore(nqm_reading *r, const nqm_rule *rule, const void *property) {
    (void)r;
    (void)rule;
    (void)property;
    return true;
}

bool nqm_rule_later(nqm_reading *r, const nqm_rule *rule, const void *property) {
    return nqm_rule_ignore(r, rule, property);
}

nqm_status nqm_reading_add(nqm_reading *r, const char *name, const char *surface, int64_t byte_offset,
                           nqm_materials *materials, nqm_error *err) {
    nqm_textured *t = r->textured;
    if (!t)
        return nqm_fail_nomem(err, sizeof *t);
    const bool is_refused = *r->refusal.text, varies = !is_refused && (t->n_outputs || t->normal != NQM_NO_NODE);
    const bool has_brdf = !is_refused && !varies;
    const nqm_reason *reason = is_refused ? &r->refusal : &r->varies;
    char *spec = has_brdf && !r->file ? nqm_shading_spec(&r->shading) : NULL;
    const nqm_material_info info = {.name = name,
                                    .surface = surface,
                                    .spec = has_brdf && r->file ? r->file : spec,
                                    .refusal = has_brdf ? NULL : reason->text,
                                    .remark = is_refused || r->file ? NULL : r->shading.remark,
                                    .byte_offset = has_brdf ? byte_offset : reason->byte_offset};
    nqm_status status =
        info.spec || info.refusal ? nqm_materials_add(materials, &info, err) : nqm_fail_nomem(err, sizeof r->shading);
    if (status == NQM_OK && varies) {
        nqm_textured_prune(t);
        t->shading = r->shading;
        t->shading.remark = NULL; /* it may belong to the reader; that of the list is a copy */
        nqm_materials_attach(materials, t, true);
    } else
        nqm_textured_free(t);
    r->textured = NULL;
    nqm_free(spec);
    return status;
}
