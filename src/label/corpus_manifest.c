/* SPDX-License-Identifier: MIT
 *
 * The manifest of a corpus: everything needed to say what a model was trained on, and to prove what it was not. File
 * names stand without their folders.
 */
#include "label/corpus.h"

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

static json_t *options_json(const nqm_corpus_context *context) {
    const nqm_scene_options *scene = &context->scene_options;
    json_t *fits = json_array();
    for (size_t k = 0; k < NQM_CORPUS_N_FITS; ++k)
        json_array_append_new(fits, json_pack("{s:s,s:s}", "model", nqm_corpus_fits[k].model, "loss",
                                              nqm_fit_loss_name(nqm_corpus_fits[k].loss)));
    return json_pack("{s:o,s:o,s:o,s:{s:o,s:o,s:f,s:f,s:o}}", "seed", count(context->options->seed), "perturbations",
                     count(context->options->n_perturbations), "fits", fits, "scene", "points", count(scene->n_points),
                     "lights", count(scene->n_lights), "exposure_cdm2", scene->exposure_cdm2, "peak_cdm2",
                     scene->peak_cdm2, "seed", count(scene->seed));
}

/* Pairs per kind, and the kinds that training must not see. */
static json_t *kinds_json(size_t n_items, const nqm_corpus_item *items) {
    size_t n[NQM_KIND_COUNT] = {0};
    for (size_t i = 0; i < n_items; ++i)
        for (size_t t = 0; t < items[i].plan.n_tests; ++t)
            ++n[items[i].plan.tests[t].kind];
    json_t *kinds = json_object();
    for (int k = 0; k < NQM_KIND_COUNT; ++k)
        if (n[k])
            json_object_set_new(kinds, nqm_corpus_kind_name((nqm_corpus_kind)k), count(n[k]));
    return kinds;
}

static json_t *unseen_json(void) {
    json_t *unseen = json_array();
    for (int k = 0; k < NQM_KIND_COUNT; ++k)
        if (nqm_corpus_kind_unseen((nqm_corpus_kind)k))
            json_array_append_new(unseen, json_string(nqm_corpus_kind_name((nqm_corpus_kind)k)));
    return unseen;
}

static json_t *references_json(const nqm_corpus_list *list, size_t n_items, const nqm_corpus_item *items) {
    json_t *references = json_array();
    for (size_t i = 0; i < n_items; ++i) {
        const nqm_corpus_plan *plan = &items[i].plan;
        const nqm_corpus_group *group = &list->groups[plan->group];
        for (size_t r = 0; r < plan->n_refs; ++r) {
            const nqm_corpus_ref *ref = &list->refs[group->first_ref + r];
            size_t n_pairs = 0;
            for (size_t t = 0; t < plan->n_tests; ++t)
                n_pairs += plan->tests[t].ref == r;
            json_t *row = json_pack("{s:s,s:s,s:s,s:s,s:s,s:s,s:o}", "name", ref->name, "group", group->name, "split",
                                    nqm_corpus_split_name(group->split), "source", ref->source, "brdf",
                                    base_name(ref->brdf), "file_sha256", ref->file_sha256, "pairs", count(n_pairs));
            if (json_array_append_new(references, row) != 0) { /* a manifest that leaves one out proves nothing */
                json_decref(references);
                return NULL;
            }
        }
    }
    return references;
}

static json_t *splits_json(const nqm_corpus_list *list, size_t n_items, const nqm_corpus_item *items) {
    struct {
        size_t groups, refs, pairs;
    } n[3] = {0};
    for (size_t i = 0; i < n_items; ++i) {
        int split = (int)list->groups[items[i].plan.group].split;
        ++n[split].groups;
        n[split].refs += items[i].plan.n_refs;
        n[split].pairs += items[i].plan.n_tests;
    }
    json_t *splits = json_object();
    for (int k = 0; k < 3; ++k)
        if (n[k].groups)
            json_object_set_new(splits, nqm_corpus_split_name((nqm_split)k),
                                json_pack("{s:o,s:o,s:o}", "groups", count(n[k].groups), "references", count(n[k].refs),
                                          "pairs", count(n[k].pairs)));
    return splits;
}

static json_t *labels_json(void) {
    nqm_curve curve = nqm_curve_default();
    return json_pack("{s:s,s:[f,f,f]}", "made_by", "Delta-E ITP of direct-light renderings, JOD by the curve", "curve",
                     curve.b1, curve.b2, curve.b3);
}

static json_t *light_json(const nqm_corpus_context *context) {
    const char *light = context->options->light;
    return light ? json_pack("{s:s,s:s}", "file", base_name(light), "sha256", context->light_sha256)
                 : json_pack("{s:s}", "built_in", "sky");
}

/* json_pack() refuses NULL: one part that fails fails all. */
char *nqm_corpus_manifest(const nqm_corpus_context *context, size_t n_items, const nqm_corpus_item *items) {
    const char *part = context->options->part == NQM_CORPUS_TEST ? "test" : "train,validation";
    json_t *root =
        json_pack("{s:i,s:{s:s,s:s},s:s,s:o,s:o,s:o,s:s,s:o,s:o,s:o,s:o}", "schema", 1, "tool", "name", "nqm",
                  "version", nqm_version(), "part", part, "labels", labels_json(), "options", options_json(context),
                  "light", light_json(context), "directions", nqm_directions_id(context->directions), "splits",
                  splits_json(context->list, n_items, items), "kinds", kinds_json(n_items, items), "unseen_kinds",
                  unseen_json(), "references", references_json(context->list, n_items, items));
    char *text = root ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(root);
    char *copy = text ? nqm_strdup(text) : NULL;
    free(text);
    return copy;
}
