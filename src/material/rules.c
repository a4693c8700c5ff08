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

bool nqm_set_aside(nqm_reading *r, unsigned ignorable, const void *property, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    give_reason(r, &r->aside, property, format, arguments);
    va_end(arguments);
    r->ignorable |= ignorable;
    return true;
}

bool nqm_reading_begin(nqm_reading *r, const nqm_rule_source *source) {
    *r = (nqm_reading){.source = source,
                       .textured = nqm_textured_create(),
                       .weights = {NQM_NO_NODE, NQM_NO_NODE},
                       .subsurface_color = NQM_NO_NODE};
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

bool nqm_reading_unused(nqm_reading *r, const char *name) {
    nqm_remark_add(r->unused, sizeof r->unused, "%s", name);
    return true;
}

bool nqm_rules_apply(nqm_reading *r, const char *name, const void *property, bool is_repeated) {
    const nqm_rule *rule = nqm_rule_find(r->rules, name);
    if (!rule)
        return nqm_refuse(r, property, "%s has no %s '%.40s'", r->owner, r->source->term, name ? name : "");
    if (is_repeated && rule->read)
        return nqm_refuse(r, property, "%s is given twice", name);
    if (!rule->read || (rule->gate && is_off(r, rule->gate)))
        return nqm_reading_unused(r, name);
    return rule->read(r, rule, property);
}

bool nqm_rule_set(nqm_reading *r, const nqm_rule *rule, const void *property) {
    double v[4];
    size_t n;
    if (!r->source->read(r, rule, property, v, &n))
        return false;
    nqm_values_set(&r->values, rule->key, n, v);
    return true;
}

/* The weight of transmission or subsurface scattering; two of one kind leave what each leaves of the other. */
static bool add_weight(nqm_reading *r, const nqm_rule *rule, const void *property, uint16_t node) {
    uint16_t *weight = &r->weights[rule->ignorable == NQM_IGNORE_SUBSURFACE];
    if (*weight != NQM_NO_NODE)
        node = nqm_graph_compute(r->textured, NQM_MAP_MIX, 1, *weight, nqm_graph_number(r->textured, 1), node);
    *weight = node;
    return node != NQM_NO_NODE ||
           nqm_refuse(r, property, "%s: out of memory, or more than %d nodes", rule->name, NQM_MAX_MAP_NODES);
}

/* A property that is no constant: where maps are read, it can be ignored. */
static bool neutral_map(nqm_reading *r, const nqm_rule *rule, const void *property) {
    nqm_reason reason = r->refusal;
    if (!*reason.text)
        return false; /* the file is damaged */
    r->refusal = (nqm_reason){.byte_offset = 0};
    const uint16_t node = rule->ignorable && r->source->node ? r->source->node(r, rule, property) : NQM_NO_NODE;
    r->refusal = (nqm_reason){.byte_offset = 0};
    if (node == NQM_NO_NODE)
        return nqm_refuse(r, property, "%.300s (%s)", reason.text, rule->why);
    nqm_set_aside(r, rule->ignorable, property, "%.300s (%s)", reason.text, rule->why);
    return !rule->is_weight || add_weight(r, rule, property, node);
}

bool nqm_rule_neutral(nqm_reading *r, const nqm_rule *rule, const void *property) {
    const bool shows = r->source->shows_owner, was_refused = *r->refusal.text;
    const char *owner = shows ? r->owner : "", *dot = shows ? "." : "";
    char number[32];
    double v[4];
    size_t n;
    if (!r->source->read(r, rule, property, v, &n))
        return !was_refused && neutral_map(r, rule, property);
    for (size_t c = 0; c < n; ++c) {
        if (v[c] == rule->value)
            continue;
        nqm_format_double(number, sizeof number, v[c]);
        if (!rule->ignorable)
            return nqm_refuse(r, property, "%s%s%s is %s: %s", owner, dot, rule->name, number, rule->why);
        nqm_set_aside(r, rule->ignorable, property, "%s%s%s is %s: %s", owner, dot, rule->name, number, rule->why);
        return !rule->is_weight || add_weight(r, rule, property, nqm_graph_value(r->textured, 1, v));
    }
    return true;
}

bool nqm_rule_later(nqm_reading *r, const nqm_rule *rule, const void *property) {
    (void)r, (void)rule, (void)property;
    return true;
}

enum { MAX_MIXTURE = 8000 }; /* characters of its parts; each level of mixtures may double them */

bool nqm_reading_mix(nqm_reading *r, const void *property, nqm_material_info of, nqm_material_info with, double t) {
    const char *specs[2] = {NULL, NULL};
    if (r->textured->normal != NQM_NO_NODE)
        return nqm_refuse(r, property, "a normal map of a mixture is not supported");
    for (size_t i = 0; i < 2; ++i) {
        const nqm_material_info *part = i ? &with : &of;
        unsigned ignorable = 0;
        if (t == (i ? 0 : 1))
            continue; /* it has no weight */
        specs[i] = part->spec ? part->spec : part->reflection;
        if (part->n_maps || !specs[i] || strcmp(part->surface, "measured") == 0)
            return nqm_refuse(r, property, "'%.40s' is part of a mixture and %s%.200s", part->name,
                              part->n_maps ? "has maps"
                              : specs[i]   ? "measured"
                                           : "refused: ",
                              part->n_maps || specs[i] ? "; mixtures of constant materials are read" : part->refusal);
        if (!part->spec && nqm_ignore_parse(part->ignorable, strlen(part->ignorable), &ignorable))
            nqm_set_aside(r, ignorable, property, "'%.40s' is part of a mixture: %.200s", part->name, part->refusal);
        if (part->remark)
            nqm_textured_remark(r->textured, part->remark);
        if (part->unused)
            nqm_reading_unused(r, part->unused);
    }
    if (specs[0] && specs[1] && strlen(specs[0]) + strlen(specs[1]) > MAX_MIXTURE)
        return nqm_refuse(r, property, "its mixture is nested too deep");
    r->mixture = specs[0] && specs[1] ? nqm_strdupf("between:t=%.17g;with=(%s);of=%s", t, specs[1], specs[0])
                                      : nqm_strdup(specs[0] ? specs[0] : specs[1]);
    return r->mixture || nqm_refuse(r, property, "memory is short");
}

nqm_status nqm_reading_add(nqm_reading *r, const char *name, const char *surface, int64_t byte_offset,
                           nqm_materials *materials, nqm_error *err) {
    nqm_textured *t = r->textured;
    if (!t)
        return nqm_fail_nomem(err, sizeof *t);
    if (!*r->refusal.text && r->ignorable)
        nqm_reading_reflect(r);
    bool varies = !*r->refusal.text && (t->n_outputs || t->normal != NQM_NO_NODE);
    if (!nqm_materials_reserve(materials, varies ? nqm_textured_bytes(t) : t->n_nodes * sizeof *t->nodes) && varies) {
        r->refusal = (nqm_reason){NQM_MATERIALS_FULL, byte_offset};
        varies = false;
    }
    const bool is_refused = *r->refusal.text;
    const bool has_brdf = !is_refused && !varies, is_aside = !is_refused && r->ignorable;
    const nqm_reason *reason = is_refused ? &r->refusal : is_aside ? &r->aside : &r->varies;
    char *spec = r->mixture ? r->mixture : has_brdf && !r->file ? nqm_values_spec(&r->values) : NULL;
    char words[NQM_IGNORE_SIZE];
    if (spec && r->metal) {
        char *mixture = nqm_strdupf("between:t=%.17g;with=(%s);of=%s", r->metal_share, r->metal, spec);
        nqm_free(spec);
        spec = mixture;
    }
    nqm_free(r->metal);
    r->metal = NULL;
    const char *brdf = !has_brdf ? NULL : r->file ? r->file : spec;
    const nqm_material_info info = {.name = name,
                                    .surface = surface,
                                    .spec = is_aside ? NULL : brdf,
                                    .refusal = has_brdf && !is_aside ? NULL : reason->text,
                                    .remark = is_refused || r->file || !*t->remark ? NULL : t->remark,
                                    .unused = is_refused || !*r->unused ? NULL : r->unused,
                                    .byte_offset = has_brdf && !is_aside ? byte_offset : reason->byte_offset,
                                    .ignorable = is_aside ? nqm_ignore_words(r->ignorable, words) : NULL,
                                    .reflection = is_aside ? brdf : NULL};
    nqm_status status =
        brdf || !has_brdf ? nqm_materials_add(materials, &info, err) : nqm_fail_nomem(err, sizeof r->values);
    if (status == NQM_OK && varies) {
        nqm_textured_prune(t);
        t->values = r->values;
        nqm_materials_attach(materials, t, true);
    } else
        nqm_textured_free(t);
    r->textured = NULL;
    nqm_free(spec);
    return status;
}
