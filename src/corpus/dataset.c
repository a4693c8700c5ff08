/* SPDX-License-Identifier: MIT
 *
 * Writes a finished corpus as a dataset file, and its manifest to a second file.
 */
#include "corpus/corpus.h"
#include "data/data.h"
#include "io/json.h"
#include "label/label.h"
#include "percept/percept.h"
#include "sample/node_grid.h"

#include <stdlib.h>
#include <string.h>

/* ---- filling ----------------------------------------------------------------------------------------------------- */

/* Move values (n_each) of row `from` to row `to` <= from. */
static void move_values(size_t n, float *rgb, uint8_t *used, size_t from, size_t to) {
    if (from == to)
        return;
    memcpy(rgb + 3 * n * to, rgb + 3 * n * from, 3 * n * sizeof *rgb);
    memcpy(used + n * to, used + n * from, n);
}

static nqm_status add_row(nqm_corpus *c, size_t row, nqm_dataset *d, nqm_error *err) {
    const nqm_curve curve = nqm_curve_published;
    const nqm_corpus_row *r = &c->list.rows[row];
    const size_t pair = d->n_pairs;
    uint32_t kind = 0;
    nqm_status status = nqm_dataset_add_kind(d, r->kind, r->family, &kind, err);
    if (status == NQM_OK)
        status = nqm_dataset_add_pair(d, (uint32_t)d->n_refs - 1, c->names[row], kind, c->label[row].delta_e,
                                      nqm_curve_jod(&curve, c->label[row].delta_e), err);
    if (status != NQM_OK)
        return status;
    move_values(c->n_directions, c->test_rgb, c->test_used, row, pair);
    nqm_label_get_parts(&c->label[row], d->parts + pair * NQM_LABEL_PARTS);
    d->delta_e_error[pair] = c->label[row].error;
    return NQM_OK;
}

/* The references that have a pair, with their pairs. A unit that is the first of its reference has the samples of that. */
static nqm_status add_all(nqm_corpus *c, nqm_dataset *d, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t i = 0, added = SIZE_MAX; i < c->n_units; ++i) {
        const nqm_corpus_unit *unit = &c->units[i];
        const nqm_corpus_ref *ref = &c->list.refs[unit->ref];
        const nqm_corpus_group *group = &c->list.groups[ref->group];
        for (size_t row = unit->first_row; status == NQM_OK && row < unit->first_row + unit->n_rows; ++row) {
            uint32_t index = 0;
            if (!c->kept[row])
                continue;
            if (added != unit->ref) {
                move_values(c->n_directions, c->ref_rgb, c->ref_used, i, d->n_refs);
                status = nqm_dataset_add_group(d, group->name, strlen(group->name), group->split, &index, err);
                if (status == NQM_OK)
                    status = nqm_dataset_add_reference(d, ref->name, index, err);
                added = unit->ref;
            }
            if (status == NQM_OK)
                status = add_row(c, row, d, err);
        }
    }
    if (status == NQM_OK && d->n_pairs == 0)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "no pair could be labelled: %s", c->failures[0]);
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
    char *path = nqm_strdupf("%s.json", dataset_path);
    if (!path)
        return nqm_fail_nomem(err, strlen(dataset_path));
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

/* Seed of the points: the best of 44 by the error of estimated labels on 110 training pairs (studies/notes.md). */
enum { BETTER_POINTS = 2 };

nqm_status nqm_corpus_write(nqm_corpus *c, const char *path, nqm_error *err) {
    bool has_matrix; /* only the nodes of the grid have one */
    const nqm_status checked = nqm_node_grid_check(c->directions, &has_matrix, err);
    if (checked != NQM_OK)
        return checked;
    const nqm_dataset_limits limits = {.n_directions = c->n_directions,
                                       .directions_deg = nqm_directions_get_info(c->directions).degrees,
                                       .max_refs = c->list.n_refs,
                                       .max_pairs = c->list.n_rows,
                                       .has_parts = true,
                                       .has_transport = has_matrix,
                                       .borrows_samples = true};
    nqm_dataset *d, *dataset = NULL;
    nqm_scene_options scene = c->options->scene;
    scene.n_lights = 0; /* the default of matrices, not that of the labels */
    scene.seed = BETTER_POINTS;
    char sha256[65], *manifest = nqm_corpus_manifest(c);
    if (!manifest)
        return nqm_fail(err, NQM_ERR_ARG, -1, "manifest: a name is not UTF-8, or memory ran out");
    nqm_status status = nqm_dataset_begin(&limits, &d, err);
    if (status == NQM_OK) {
        d->ref_rgb = c->ref_rgb;
        d->ref_used = c->ref_used;
        d->test_rgb = c->test_rgb;
        d->test_used = c->test_used;
        if (has_matrix)
            status = nqm_transport_fill(&scene, NQM_TRANSPORT_POINTS, d->transport, d->transport_points, err);
        if (status == NQM_OK)
            status = add_all(c, d, err);
        status = nqm_dataset_finish(d, status, manifest, NULL, &dataset, err);
    }
    if (status == NQM_OK)
        status = nqm_dataset_write(dataset, path, sha256, err);
    if (status == NQM_OK)
        status = write_manifest(path, manifest, sha256, err);
    nqm_dataset_free(dataset);
    nqm_free(manifest);
    return status;
}
