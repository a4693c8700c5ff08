/* SPDX-License-Identifier: MIT
 *
 * Pairs whose members are files of several materials: such a file means all of its materials, and two such files the materials of
 * the same names.
 */
#include "nqm/score/expand.h"

#include "material/material.h"

#include <stdlib.h>
#include <string.h>

/* "FILE:NAME", also for a material that the file does not have: opening it says so. */
static char *member(const char *file, const char *name) {
    char *text = allocate(strlen(file) + strlen(name) + 2, 1);
    strcat(strcat(strcpy(text, file), ":"), name);
    return text;
}

/* "ignore:...:FILE" with --ignore, which is owned. */
static void reflect(const char **argument, bool *is_owned) {
    const char *taken = reflecting(*argument);
    if (taken == *argument)
        return;
    if (*is_owned)
        free((void *)(uintptr_t)*argument);
    *argument = taken;
    *is_owned = true;
}

static void add_pair(expansion *e, nqm_named_pair pair, const char *name, size_t origin, bool is_made) {
    e->pairs = must_have(nqm_grow(e->pairs, &e->max_n, e->n + 1, sizeof *e->pairs));
    expanded_pair *added = &e->pairs[e->n++];
    *added = (expanded_pair){pair, name, origin, is_made, {is_made, is_made}};
    reflect(&added->pair.ref, &added->is_owned[0]);
    reflect(&added->pair.test, &added->is_owned[1]);
}

static bool has_material(const nqm_materials *library, const char *name) {
    size_t n;
    nqm_materials_named(library, name, &n);
    return n > 0;
}

/* The materials of a file of several; NULL: it is another argument. */
static const nqm_materials *read_library(const char *argument) {
    const nqm_materials *materials = parsed_materials(argument);
    return materials && nqm_materials_count(materials) > 1 ? materials : NULL;
}

static void add_materials(expansion *e, const nqm_named_pair *pair, const char *name, size_t origin,
                          const nqm_materials *ref, const nqm_materials *test) {
    const nqm_materials *named = ref ? ref : test;
    for (size_t i = 0; i < nqm_materials_count(named); ++i) {
        const char *material = nqm_materials_get(named, i).name;
        char *test_member = member(pair->test, material);
        char *ref_member = ref ? member(pair->ref, material) : must_have(strdup(pair->ref));
        add_pair(e, (nqm_named_pair){ref_member, test_member}, name ? member(name, material) : NULL, origin, true);
    }
    for (size_t i = 0; ref && i < nqm_materials_count(test); ++i)
        if (!has_material(ref, nqm_materials_get(test, i).name))
            report(EXIT_OK, "%s:%s is not compared: %s has no material of this name", pair->test,
                   nqm_materials_get(test, i).name, pair->ref);
}

void expand_pairs(size_t n, const nqm_named_pair *pairs, const char *const *names, expansion *e) {
    *e = (expansion){0};
    for (size_t i = 0; i < n; ++i) {
        const nqm_materials *ref = read_library(pairs[i].ref), *test = read_library(pairs[i].test);
        if (test)
            add_materials(e, &pairs[i], names ? names[i] : NULL, i, ref, test);
        else
            add_pair(e, pairs[i], names ? names[i] : NULL, i, false);
    }
}

void free_expansion(expansion *e) {
    for (size_t i = 0; i < e->n; ++i) {
        const expanded_pair *p = &e->pairs[i];
        if (p->is_owned[0])
            free((void *)(uintptr_t)p->pair.ref);
        if (p->is_owned[1])
            free((void *)(uintptr_t)p->pair.test);
        if (p->is_made)
            free((void *)(uintptr_t)p->name);
    }
    nqm_free(e->pairs);
    *e = (expansion){0};
}

void expand_list(const nqm_pair_list *list, const char *const *names, expanded_list *x) {
    expand_pairs(list->n_rows, list->pair, names, &x->expansion);
    const size_t n = x->expansion.n;
    x->names = allocate(n, sizeof *x->names);
    x->pair = allocate(n, sizeof *x->pair);
    for (size_t i = 0; i < n; ++i) {
        const expanded_pair *p = &x->expansion.pairs[i];
        x->names[i] = p->name;
        x->pair[i] = p->pair;
    }
    x->list = *list;
    x->list.n_rows = n;
    x->list.pair = x->pair;
    x->list.expanded = x->expansion.pairs;
}

void free_expanded_list(expanded_list *x) {
    free(x->names);
    free(x->pair);
    free_expansion(&x->expansion);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

bool has_same_refusal(const nqm_named_pair *pair) {
    nqm_material_info ref, test;
    return find_material(pair->ref, &ref) && find_material(pair->test, &test) && ref.refusal && test.refusal &&
           strcmp(ref.refusal, test.refusal) == 0;
}
