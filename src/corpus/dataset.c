/* SPDX-License-Identifier: MIT
 *
 * Writes a finished corpus as a dataset file, and its manifest to a second file.
 */
#include "corpus/corpus.h"
#include "data/data.h"
#include "io/options_json.h"
#include "label/label.h"
#include "percept/percept.h"
#include "sample/node_grid.h"

#include <stdlib.h>
#include <string.h>

/* ---- filling ----------------------------------------------------------------------------------------------------- */

/* Number the kinds that occur: by family, then in the order of their first test. */
static nqm_status add_kinds(const nqm_corpus *c, nqm_dataset_builder *b, nqm_error *err) {
    nqm_status status = NQM_OK;
    uint32_t index = 0;
    for (int family = 0; family < NQM_FAMILY_COUNT; ++family)
        for (size_t i = 0; i < c->n_items; ++i) {
            const nqm_corpus_plan *plan = &c->items[i].plan;
            for (size_t k = 0; status == NQM_OK && k < plan->n_tests; ++k) {
                const nqm_corpus_kind *kind = &plan->tests[k].kind;
                if ((int)kind->family == family && nqm_corpus_is_pair(&c->items[i], k))
                    status = nqm_dataset_add_kind(b, kind->name, nqm_corpus_family_name(kind->family), &index, err);
            }
        }
    return status;
}

/* Move the samples of test `from` to pair `to` <= from. */
static void move_test(nqm_corpus *c, size_t from, size_t to) {
    size_t n = c->n_directions;
    if (from == to)
        return;
    memcpy(c->test_rgb + 3 * n * to, c->test_rgb + 3 * n * from, 3 * n * sizeof *c->test_rgb);
    memcpy(c->test_used + n * to, c->test_used + n * from, n);
}

/* The references and tests of item i; *test: the number of its first test, advanced past its last. */
static nqm_status add_item(nqm_corpus *c, size_t i, size_t *test, nqm_dataset_builder *b, nqm_error *err) {
    const nqm_curve curve = nqm_curve_default();
    const nqm_corpus_plan *plan = &c->items[i].plan;
    const nqm_corpus_group *group = &c->list.groups[plan->group];
    const size_t first_ref = b->dataset->n_refs;
    uint32_t index = 0, kind = 0;
    nqm_status status =
        nqm_dataset_add_group(b, group->name, strlen(group->name), (nqm_split)group->split, &index, err);
    for (size_t r = 0; status == NQM_OK && r < plan->n_refs; ++r)
        status = nqm_dataset_add_reference(b, c->list.refs[group->first_ref + r].name, index, err);
    for (size_t k = 0; status == NQM_OK && k < plan->n_tests; ++k, ++*test) {
        if (!nqm_corpus_is_pair(&c->items[i], k))
            continue;
        move_test(c, *test, b->dataset->n_pairs);
        const char *name = plan->tests[k].kind.name;
        status = nqm_dataset_add_kind(b, name, nqm_corpus_family_name(plan->tests[k].kind.family), &kind, err);
        if (status == NQM_OK)
            status = nqm_dataset_add_pair(b, (uint32_t)(first_ref + plan->tests[k].ref), c->names[*test], kind,
                                          c->label[*test].delta_e, nqm_curve_jod(&curve, c->label[*test].delta_e), err);
        if (status != NQM_OK)
            break;
        const size_t pair = b->dataset->n_pairs - 1;
        nqm_label_get_parts(&c->label[*test], b->dataset->parts + pair * NQM_LABEL_PARTS);
        b->dataset->delta_e_error[pair] = c->label[*test].error;
    }
    return status;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* The manifest with the checksum of the dataset, which the manifest inside the dataset cannot have. */
static char *manifest_with_checksum(const char *manifest, const char *sha256) {
    json_t *root;
    char *text = NULL;
    if (nqm_json_parse(manifest, &root, NULL) == NQM_OK &&
        json_object_set_new(root, "dataset_sha256", json_string(sha256)) == 0)
        text = json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17));
    json_decref(root);
    return text;
}

nqm_status nqm_corpus_manifest_open(const char *dataset_path, nqm_outfile *out_ret, nqm_error *err) {
    size_t n = strlen(dataset_path) + sizeof ".json";
    char *path = nqm_alloc(n, 1);
    if (!path)
        return nqm_fail_nomem(err, n);
    snprintf(path, n, "%s.json", dataset_path);
    nqm_status status = nqm_outfile_open(path, out_ret, err);
    nqm_free(path);
    return status;
}

static nqm_status write_manifest(const char *dataset_path, const char *manifest, const char *sha256, nqm_error *err) {
    char *text = manifest_with_checksum(manifest, sha256);
    nqm_outfile out = {0};
    nqm_status status =
        text ? nqm_corpus_manifest_open(dataset_path, &out, err) : nqm_fail_nomem(err, strlen(manifest));
    if (status == NQM_OK) {
        fprintf(out.stream, "%s\n", text);
        status = nqm_outfile_commit(&out, err);
    }
    free(text);
    return status;
}

/* Of 44 seeds of the standard scenes, the one whose points estimate labels of 110 pairs of training materials best
 * (studies/notes.md). */
enum { BETTER_POINTS = 2 };

nqm_status nqm_corpus_write(nqm_corpus *c, const char *path, nqm_error *err) {
    bool has_matrix; /* only the nodes of the grid have one */
    const nqm_status checked = nqm_node_grid_check(c->context.directions, &has_matrix, err);
    if (checked != NQM_OK)
        return checked;
    const nqm_dataset_limits limits = {.n_directions = c->n_directions,
                                       .directions_deg = nqm_directions_degrees(c->context.directions),
                                       .max_refs = c->n_refs,
                                       .max_pairs = c->n_tests,
                                       .has_parts = true,
                                       .has_errors = true,
                                       .has_transport = has_matrix,
                                       .borrows_samples = true};
    nqm_dataset_builder b;
    nqm_dataset *dataset = NULL;
    nqm_scene_options scene = c->context.options->scene;
    scene.n_lights = 0; /* the default of matrices, not that of the labels */
    scene.seed = BETTER_POINTS;
    char sha256[65], *manifest = nqm_corpus_manifest(&c->context, c->n_items, c->items);
    if (!manifest)
        return nqm_fail(err, NQM_ERR_ARG, -1, "manifest: a name is not UTF-8, or memory ran out");
    nqm_status status = nqm_dataset_begin(&limits, &b, err);
    if (status == NQM_OK) {
        size_t test = 0;
        b.dataset->ref_rgb = c->ref_rgb;
        b.dataset->ref_used = c->ref_used;
        b.dataset->test_rgb = c->test_rgb;
        b.dataset->test_used = c->test_used;
        if (has_matrix)
            status = nqm_transport_fill(&scene, NQM_TRANSPORT_POINTS, b.dataset->transport, b.dataset->transport_points,
                                        err);
        if (status == NQM_OK)
            status = add_kinds(c, &b, err);
        for (size_t i = 0; status == NQM_OK && i < c->n_items; ++i)
            status = add_item(c, i, &test, &b, err);
        status = nqm_dataset_finish(&b, status, manifest, NULL, &dataset, err);
    }
    if (status == NQM_OK)
        status = nqm_dataset_write(dataset, path, sha256, err);
    if (status == NQM_OK)
        status = write_manifest(path, manifest, sha256, err);
    nqm_dataset_free(dataset);
    nqm_free(manifest);
    return status;
}
