/* SPDX-License-Identifier: MIT
 *
 * A finished corpus as a dataset file, and its manifest beside it.
 */
#include "data/data.h"
#include "label/corpus.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

/* Index tables and names of the dataset, in one place to free them. */
typedef struct tables {
    size_t n_pairs; /* tests that could be made */
    uint32_t *pair_ref, *pair_kind, *ref_group;
    uint8_t *group_split;
    double *jod;
    const char **ref_names, **group_names, **pair_names;
    const nqm_corpus_kind **kinds; /* (n_kinds) by family, then in the order of their first test */
    const char **kind_names, **kind_families;
    size_t n_kinds;
    char *manifest;
} tables;

static nqm_status alloc_tables(const nqm_corpus *c, tables *t, nqm_error *err) {
    t->pair_ref = nqm_alloc(c->n_tests, sizeof *t->pair_ref);
    t->pair_kind = nqm_alloc(c->n_tests, sizeof *t->pair_kind);
    t->jod = nqm_alloc(c->n_tests, sizeof *t->jod);
    t->pair_names = nqm_alloc(c->n_tests, sizeof *t->pair_names);
    t->kinds = nqm_alloc(c->n_tests, sizeof *t->kinds);
    t->kind_names = nqm_alloc(c->n_tests, sizeof *t->kind_names);
    t->kind_families = nqm_alloc(c->n_tests, sizeof *t->kind_families);
    t->ref_group = nqm_alloc(c->n_refs, sizeof *t->ref_group);
    t->ref_names = nqm_alloc(c->n_refs, sizeof *t->ref_names);
    t->group_split = nqm_alloc(c->n_items, sizeof *t->group_split);
    t->group_names = nqm_alloc(c->n_items, sizeof *t->group_names);
    t->manifest = nqm_corpus_manifest(&c->context, c->n_items, c->items);
    if (!t->pair_ref || !t->pair_kind || !t->jod || !t->pair_names || !t->kinds || !t->kind_names ||
        !t->kind_families || !t->ref_group || !t->ref_names || !t->group_split || !t->group_names)
        return nqm_fail_nomem(err, 48 * c->n_tests);
    if (!t->manifest)
        return nqm_fail(err, NQM_ERR_ARG, -1, "manifest: a name is not UTF-8, or memory is short");
    return NQM_OK;
}

static void free_tables(tables *t) {
    nqm_free(t->pair_ref);
    nqm_free(t->pair_kind);
    nqm_free(t->jod);
    nqm_free(t->pair_names);
    nqm_free(t->kinds);
    nqm_free(t->kind_names);
    nqm_free(t->kind_families);
    nqm_free(t->ref_group);
    nqm_free(t->ref_names);
    nqm_free(t->group_split);
    nqm_free(t->group_names);
    nqm_free(t->manifest);
}

/* ---- filling ----------------------------------------------------------------------------------------------------- */

static size_t find_kind(const tables *t, const char *name) {
    size_t k = 0;
    while (k < t->n_kinds && strcmp(t->kinds[k]->name, name) != 0)
        ++k;
    return k;
}

/* Number the kinds that occur. */
static void fill_kinds(const nqm_corpus *c, tables *t) {
    for (int family = 0; family < NQM_FAMILY_COUNT; ++family)
        for (size_t i = 0; i < c->n_items; ++i) {
            const nqm_corpus_plan *plan = &c->items[i].plan;
            for (size_t k = 0; k < plan->n_tests; ++k) {
                const nqm_corpus_kind *kind = &plan->tests[k].kind;
                if ((int)kind->family == family && !c->items[i].failures[k] && find_kind(t, kind->name) == t->n_kinds)
                    t->kinds[t->n_kinds++] = kind;
            }
        }
    for (size_t k = 0; k < t->n_kinds; ++k) {
        t->kind_names[k] = t->kinds[k]->name;
        t->kind_families[k] = nqm_corpus_family_name(t->kinds[k]->family);
    }
}

/* Test `from` of all becomes pair `to` <= from. */
static void move_test(nqm_corpus *c, size_t from, size_t to) {
    size_t n = c->n_directions;
    if (from == to)
        return;
    memcpy(c->test_rgb + 3 * n * to, c->test_rgb + 3 * n * from, 3 * n * sizeof *c->test_rgb);
    memcpy(c->test_used + n * to, c->test_used + n * from, n);
    c->delta_e[to] = c->delta_e[from];
}

static void fill_tables(nqm_corpus *c, tables *t) {
    nqm_curve curve = nqm_curve_default();
    size_t ref = 0, test = 0;
    fill_kinds(c, t);
    for (size_t i = 0; i < c->n_items; ++i) {
        const nqm_corpus_plan *plan = &c->items[i].plan;
        const nqm_corpus_group *group = &c->list.groups[plan->group];
        t->group_names[i] = group->name;
        t->group_split[i] = (uint8_t)group->split;
        for (size_t k = 0; k < plan->n_tests; ++k, ++test) {
            if (c->failures[test])
                continue;
            size_t pair = t->n_pairs++;
            move_test(c, test, pair);
            t->pair_names[pair] = c->names[test];
            t->pair_ref[pair] = (uint32_t)(ref + plan->tests[k].ref);
            t->pair_kind[pair] = (uint32_t)find_kind(t, plan->tests[k].kind.name);
            t->jod[pair] = nqm_curve_jod(&curve, c->delta_e[pair]);
        }
        for (size_t r = 0; r < plan->n_refs; ++r, ++ref) {
            t->ref_names[ref] = c->list.refs[group->first_ref + r].name;
            t->ref_group[ref] = (uint32_t)i;
        }
    }
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* The manifest with the checksum of the dataset, which the one inside it cannot hold. */
static char *sealed_manifest(const char *manifest, const char *sha256) {
    json_t *root = json_loads(manifest, 0, NULL);
    char *text = NULL;
    if (json_object_set_new(root, "dataset_sha256", json_string(sha256)) == 0)
        text = json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17));
    json_decref(root);
    return text;
}

static nqm_status write_manifest(const char *dataset_path, const char *manifest, const char *sha256, nqm_error *err) {
    size_t n = strlen(dataset_path) + 8;
    char *path = nqm_alloc(n, 1), *text = sealed_manifest(manifest, sha256);
    nqm_outfile out = {0};
    nqm_status status = NQM_ERR_NOMEM;
    if (path && text) {
        snprintf(path, n, "%s.json", dataset_path);
        status = nqm_outfile_open(path, &out, err);
    } else {
        status = nqm_fail_nomem(err, strlen(manifest));
    }
    if (status == NQM_OK) {
        fprintf(out.stream, "%s\n", text);
        status = nqm_outfile_commit(&out, err);
    }
    nqm_free(path);
    free(text);
    return status;
}

nqm_status nqm_corpus_write(nqm_corpus *c, const char *path, nqm_error *err) {
    tables t = {0};
    char sha256[65];
    nqm_status status = alloc_tables(c, &t, err);
    if (status == NQM_OK) {
        fill_tables(c, &t);
        nqm_dataset dataset = {
            .n_directions = c->n_directions,
            .n_refs = c->n_refs,
            .n_groups = c->n_items,
            .n_kinds = t.n_kinds,
            .n_pairs = t.n_pairs,
            .directions_deg = nqm_directions_degrees(c->context.directions),
            .ref_rgb = c->ref_rgb,
            .test_rgb = c->test_rgb,
            .ref_used = c->ref_used,
            .test_used = c->test_used,
            .pair_ref = t.pair_ref,
            .pair_kind = t.pair_kind,
            .delta_e = c->delta_e,
            .jod = t.jod,
            .ref_group = t.ref_group,
            .group_split = t.group_split,
            .ref_names = t.ref_names,
            .group_names = t.group_names,
            .kind_names = t.kind_names,
            .kind_families = t.kind_families,
            .pair_names = t.pair_names,
            .manifest = t.manifest,
        };
        status = nqm_dataset_write(&dataset, path, sha256, err);
    }
    if (status == NQM_OK)
        status = write_manifest(path, t.manifest, sha256, err);
    free_tables(&t);
    return status;
}
