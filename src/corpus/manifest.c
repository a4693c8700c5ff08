/* SPDX-License-Identifier: MIT
 *
 * The manifest of a corpus: the record of what a model was trained on, and the proof of what it was not trained on. File
 * names are given without folders.
 */
#include "corpus/corpus.h"
#include "io/json.h"
#include "math/math.h"
#include "percept/percept.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

static const char *base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static json_t *count(size_t n) {
    return json_integer((json_int_t)n);
}

/* The name of a built-in, or a file name with its checksum. */
static json_t *file_json(const char *name, const char *sha256) {
    return *sha256 ? json_pack("{s:s,s:s}", "file", base_name(name), "sha256", sha256)
                   : json_pack("{s:s}", "built_in", name);
}

static json_t *scene_json(const nqm_corpus *corpus) {
    const nqm_scene_options *scene = &corpus->options->scene;
    const double degrees = 180 / NQM_PI;
    json_t *light = file_json(scene->light ? scene->light : scene->shape ? "sun" : "standard", corpus->light_sha256);
    json_t *shape = file_json(scene->shape ? scene->shape : scene->light ? "sphere" : "standard", corpus->shape_sha256);
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:f,s:f,s:o,s:b,s:b,s:f,s:f,s:o}", "light", light, "light_width",
                     count(scene->light_width), "shape", shape, "width", count(scene->width), "height",
                     count(scene->height), "points", count(scene->width ? 0 : scene->n_points), "frames",
                     count(nqm_scene_n_frames(scene)), "turn_deg", scene->turn_rad * degrees, "elevation_deg",
                     scene->elevation_rad * degrees, "lights", count(nqm_scene_n_lights(scene)), "shadows",
                     scene->shadows, "interreflection", scene->interreflection, "exposure_cdm2", scene->exposure_cdm2,
                     "peak_cdm2", scene->peak_cdm2, "seed", count(scene->seed));
}

static json_t *encoders_json(const nqm_corpus *corpus) {
    json_t *encoders = json_object();
    for (size_t k = 0; k < 2; ++k)
        json_object_set_new(encoders, nqm_corpus_encoders[k],
                            *corpus->encoder_sha256[k] ? json_string(corpus->encoder_sha256[k]) : json_null());
    return encoders;
}

/* ---- counts ------------------------------------------------------------------------------------------------------ */

/* The member `name` of an object, created as `made` if missing. */
static json_t *member_or(json_t *object, const char *name, json_t *made) {
    json_t *found = json_object_get(object, name);
    if (found)
        json_decref(made);
    return found || json_object_set_new(object, name, made) != 0 ? found : made;
}

static json_t *member(json_t *object, const char *name) {
    return member_or(object, name, json_object());
}

static void add(json_t *object, const char *key, size_t n) {
    json_int_t before = json_integer_value(json_object_get(object, key));
    json_object_set_new(object, key, json_integer(before + (json_int_t)n));
}

/* Pairs per kind and per family. */
static void count_kinds(const nqm_corpus *c, json_t *kinds, json_t *families) {
    for (size_t i = 0; i < c->list.n_rows; ++i) {
        const nqm_corpus_row *row = &c->list.rows[i];
        if (!c->kept[i])
            continue;
        json_t *kind = member(kinds, row->kind);
        add(kind, "pairs", 1);
        json_object_set_new(kind, "family", json_string(row->family));
        add(families, row->family, 1);
    }
}

static json_t *unseen_json(const nqm_corpus_list *list) {
    json_t *unseen = json_array();
    for (size_t i = 0; i < list->n_unseen; ++i)
        json_array_append_new(unseen, json_string(list->unseen[i]));
    return unseen;
}

static nqm_split split_of(const nqm_corpus_list *list, size_t ref) {
    return list->groups[list->refs[ref].group].split;
}

/* By split, the names of the references that are other materials in pairs of the split. */
static json_t *others_json(const nqm_corpus *c) {
    json_t *splits = json_object();
    for (size_t i = 0; i < c->list.n_rows; ++i) {
        const nqm_corpus_row *row = &c->list.rows[i];
        if (c->kept[i] && *row->other)
            add(member(splits, nqm_corpus_split_name(split_of(&c->list, row->ref))), row->other, 1);
    }
    return splits;
}

/* Failed pairs by kind, with the first message of each kind. */
static json_t *failures_json(const nqm_corpus *c) {
    json_t *failures = json_object();
    for (size_t i = 0; i < c->list.n_rows; ++i) {
        const nqm_corpus_row *row = &c->list.rows[i];
        if (!c->failures[i])
            continue;
        json_t *kind = member(failures, row->kind);
        member_or(kind, "message", json_string(c->failures[i]));
        json_array_append_new(member_or(kind, "tests", json_array()),
                              json_pack("[s,s]", c->list.refs[row->ref].name, row->test));
        add(kind, "pairs", 1);
    }
    return failures;
}

/* References and, by split and source, numbers of groups, references and pairs. */
static json_t *references_json(const nqm_corpus *c, json_t *splits, json_t *sources) {
    json_t *references = json_array();
    size_t last_group = SIZE_MAX;
    for (size_t r = 0; r < c->list.n_refs; ++r) {
        const nqm_corpus_ref *ref = &c->list.refs[r];
        size_t n_pairs = 0;
        for (size_t row = ref->first_row; row < ref->first_row + ref->n_rows; ++row)
            n_pairs += c->kept[row];
        if (n_pairs == 0)
            continue;
        const char *split = nqm_corpus_split_name(split_of(&c->list, r));
        add(member(splits, split), "groups", ref->group != last_group);
        last_group = ref->group;
        json_t *counts[2] = {member(splits, split), member(sources, ref->source)};
        for (size_t i = 0; i < 2; ++i) {
            add(counts[i], "references", 1);
            add(counts[i], "pairs", n_pairs);
        }
        json_t *row = json_pack("{s:s,s:s,s:s,s:s,s:s,s:s,s:o}", "name", ref->name, "group",
                                c->list.groups[ref->group].name, "split", split, "source", ref->source, "brdf",
                                base_name(ref->brdf), "file_sha256", ref->file_sha256, "pairs", count(n_pairs));
        if (json_array_append_new(references, row) != 0) { /* an incomplete manifest proves nothing */
            json_decref(references);
            return NULL;
        }
    }
    return references;
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

static json_t *labels_json(void) {
    nqm_curve curve = nqm_curve_published;
    return json_pack("{s:s,s:s,s:[s],s:[f,f,f]}", "made_by", "nqm: Delta-E ITP of its own renderings, JOD by the curve",
                     "of", "this program, not of people", "authors_data_used",
                     "the curve from Delta-E to JOD (Kavoosighafi et al. 2025), in full precision", "curve", curve.b1,
                     curve.b2, curve.b3);
}

/* json_pack() fails if any part is NULL. */
char *nqm_corpus_manifest(const nqm_corpus *c) {
    const nqm_corpus_options *options = c->options;
    json_t *kinds = json_object(), *families = json_object(), *splits = json_object(), *sources = json_object();
    count_kinds(c, kinds, families);
    json_t *references = references_json(c, splits, sources);
    json_t *root = json_pack(
        "{s:i,s:{s:s,s:s},s:s,s:o,s:s?,s:b,s:o,s:o,s:s,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "schema", 3, "tool", "name",
        "nqm", "version", nqm_version(), "part", options->part == NQM_CORPUS_TEST ? "test" : "train,validation",
        "labels", labels_json(), "keep", options->keep, "anisotropic", options->anisotropic, "scene", scene_json(c),
        "encoders", encoders_json(c), "directions", nqm_directions_id(c->directions), "splits", splits, "sources",
        sources, "families", families, "kinds", kinds, "unseen_kinds", unseen_json(&c->list), "other_materials",
        others_json(c), "failures", failures_json(c), "references", references);
    char *text = root ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(root);
    char *copy = text ? nqm_strdup(text) : NULL;
    free(text);
    return copy;
}
