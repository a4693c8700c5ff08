/* SPDX-License-Identifier: MIT
 *
 * The manifest of a corpus: the record of what a model was trained on, and the proof of what it was not trained on. File
 * names are given without folders.
 */
#include "corpus/corpus.h"
#include "fit/fit.h"
#include "io/options_json.h"
#include "math/math.h"

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

static json_t *scene_json(const nqm_corpus_context *context) {
    const nqm_scene_options *scene = &context->options->scene;
    const double degrees = 180 / NQM_PI;
    json_t *light = file_json(scene->light ? scene->light : scene->shape ? "sun" : "standard", context->light_sha256);
    json_t *shape = file_json(scene->shape   ? scene->shape
                              : scene->light ? "sphere"
                                             : "standard",
                              context->shape_sha256);
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:f,s:f,s:o,s:b,s:b,s:f,s:f,s:o}", "light", light, "light_width",
                     count(scene->light_width), "shape", shape, "width", count(scene->width), "height",
                     count(scene->height), "points", count(scene->width ? 0 : scene->n_points), "frames",
                     count(nqm_scene_n_frames(scene)), "turn_deg", scene->turn_rad * degrees, "elevation_deg",
                     scene->elevation_rad * degrees, "lights", count(nqm_scene_n_lights(scene)), "shadows",
                     scene->shadows, "interreflection", scene->interreflection, "exposure_cdm2", scene->exposure_cdm2,
                     "peak_cdm2", scene->peak_cdm2, "seed", count(scene->seed));
}

static json_t *encoders_json(const nqm_corpus_context *context) {
    json_t *encoders = json_object();
    for (size_t k = 0; k < 2; ++k)
        json_object_set_new(encoders, nqm_corpus_encoders[k],
                            *context->encoder_sha256[k] ? json_string(context->encoder_sha256[k]) : json_null());
    return encoders;
}

/* ---- counts ------------------------------------------------------------------------------------------------------ */

/* The object `name` in an object, created if missing. */
static json_t *member(json_t *object, const char *name) {
    json_t *found = json_object_get(object, name);
    if (!found && json_object_set_new(object, name, json_object()) == 0)
        found = json_object_get(object, name);
    return found;
}

static void add(json_t *object, const char *key, size_t n) {
    json_int_t before = json_integer_value(json_object_get(object, key));
    json_object_set_new(object, key, json_integer(before + (json_int_t)n));
}

/* Pairs per kind of test and per family, with the mean loss of encodings. */
static void count_kinds(size_t n_items, const nqm_corpus_item *items, json_t *kinds, json_t *families) {
    for (size_t i = 0; i < n_items; ++i)
        for (size_t t = 0; t < items[i].plan.n_tests; ++t) {
            const nqm_corpus_kind *kind = &items[i].plan.tests[t].kind;
            const char *family = nqm_corpus_family_name(kind->family);
            if (!nqm_corpus_is_pair(&items[i], t))
                continue;
            json_t *row = member(kinds, kind->name);
            add(row, "pairs", 1);
            json_object_set_new(row, "family", json_string(family));
            if (kind->family == NQM_FAMILY_ENCODING) {
                double sum = json_real_value(json_object_get(row, "mean_fit_loss"));
                json_object_set_new(row, "mean_fit_loss", json_real(sum + items[i].fit_loss[t]));
            }
            add(families, family, 1);
        }
    const char *name;
    json_t *row;
    json_object_foreach(kinds, name, row) {
        json_t *sum = json_object_get(row, "mean_fit_loss");
        if (sum)
            json_real_set(sum, json_real_value(sum) / (double)json_integer_value(json_object_get(row, "pairs")));
    }
}

static json_t *unseen_json(void) {
    json_t *unseen = json_array();
    for (size_t i = 0; nqm_corpus_perturbation(i); ++i)
        if (nqm_corpus_kind_unseen(nqm_corpus_perturbation(i)))
            json_array_append_new(unseen, json_string(nqm_corpus_perturbation(i)));
    for (size_t i = 0; nqm_corpus_far_kind(i); ++i)
        if (nqm_corpus_far_unseen(nqm_corpus_far_kind(i)))
            json_array_append_new(unseen, json_string(nqm_corpus_far_kind(i)));
    return unseen;
}

/* By split, the names of the references that are other materials in pairs of the split. */
static json_t *others_json(const nqm_corpus_list *list, size_t n_items, const nqm_corpus_item *items) {
    json_t *splits = json_object();
    for (size_t i = 0; i < n_items; ++i)
        for (size_t t = 0; t < items[i].plan.n_tests; ++t) {
            const nqm_corpus_test *test = &items[i].plan.tests[t];
            if (!nqm_corpus_uses_other(test) || !nqm_corpus_is_pair(&items[i], t))
                continue;
            const char *split = nqm_corpus_split_name(list->groups[items[i].plan.group].split);
            add(member(splits, split), list->refs[test->which].name, 1);
        }
    return splits;
}

/* Failed tests by kind, with the first message of each kind. */
static json_t *failures_json(const nqm_corpus_list *list, size_t n_items, const nqm_corpus_item *items) {
    json_t *failures = json_object();
    for (size_t i = 0; i < n_items; ++i)
        for (size_t t = 0; t < items[i].plan.n_tests; ++t) {
            const nqm_corpus_test *test = &items[i].plan.tests[t];
            if (!items[i].failures[t])
                continue;
            json_t *row = member(failures, test->kind.name);
            const nqm_corpus_group *group = &list->groups[items[i].plan.group];
            if (!json_object_get(row, "message"))
                json_object_set_new(row, "message", json_string(items[i].failures[t]));
            json_t *references = json_object_get(row, "references");
            if (!references && json_object_set_new(row, "references", json_array()) == 0)
                references = json_object_get(row, "references");
            json_array_append_new(references, json_string(list->refs[group->first_ref + test->ref].name));
            add(row, "pairs", 1);
        }
    return failures;
}

static size_t count_pairs(const nqm_corpus_item *item, size_t ref) {
    size_t n = 0;
    for (size_t t = 0; t < item->plan.n_tests; ++t)
        n += item->plan.tests[t].ref == ref && nqm_corpus_is_pair(item, t);
    return n;
}

static json_t *references_json(const nqm_corpus_list *list, size_t n_items, const nqm_corpus_item *items) {
    json_t *references = json_array();
    for (size_t i = 0; i < n_items; ++i) {
        const nqm_corpus_plan *plan = &items[i].plan;
        const nqm_corpus_group *group = &list->groups[plan->group];
        for (size_t r = 0; r < plan->n_refs; ++r) {
            const nqm_corpus_ref *ref = &list->refs[group->first_ref + r];
            json_t *row =
                json_pack("{s:s,s:s,s:s,s:s,s:s,s:s,s:o}", "name", ref->name, "group", group->name, "split",
                          nqm_corpus_split_name(group->split), "source", ref->source, "brdf", base_name(ref->brdf),
                          "file_sha256", ref->file_sha256, "pairs", count(count_pairs(&items[i], r)));
            if (json_array_append_new(references, row) != 0) { /* an incomplete manifest proves nothing */
                json_decref(references);
                return NULL;
            }
        }
    }
    return references;
}

/* References, pairs and groups per split, and references and pairs per source. */
static void count_splits(const nqm_corpus_list *list, size_t n_items, const nqm_corpus_item *items, json_t *splits,
                         json_t *sources) {
    for (size_t i = 0; i < n_items; ++i) {
        const nqm_corpus_group *group = &list->groups[items[i].plan.group];
        json_t *split = member(splits, nqm_corpus_split_name(group->split));
        add(split, "groups", 1);
        for (size_t r = 0; r < group->n_refs; ++r) {
            size_t n_pairs = count_pairs(&items[i], r);
            json_t *source = member(sources, list->refs[group->first_ref + r].source);
            add(split, "references", 1);
            add(split, "pairs", n_pairs);
            add(source, "references", 1);
            add(source, "pairs", n_pairs);
        }
    }
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

static json_t *labels_json(void) {
    nqm_curve curve = nqm_curve_default();
    return json_pack("{s:s,s:s,s:[s],s:[f,f,f]}", "made_by", "nqm: Delta-E ITP of its own renderings, JOD by the curve",
                     "of", "this program, not of people", "authors_data_used",
                     "the curve from Delta-E to JOD (Kavoosighafi et al. 2025), in full precision", "curve", curve.b1,
                     curve.b2, curve.b3);
}

static json_t *options_json(const nqm_corpus_options *options) {
    const size_t n_far = nqm_corpus_far_kept(options);
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "seed", count(options->seed), "perturbations",
                     count(options->n_perturbations), "variants", count(options->n_variants), "far", count(n_far),
                     "far_candidates", count(nqm_corpus_candidates(n_far)), "roundings", count(options->n_roundings),
                     "every", count(options->every));
}

static json_t *fit_json(const nqm_corpus_models *used) {
    nqm_fit_options fit = nqm_fit_options_default();
    json_t *models = json_array();
    for (size_t k = 0; k < used->n; ++k)
        json_array_append_new(models, json_string(used->name[k]));
    return json_pack("{s:o,s:s,s:o,s:o}", "models", models, "loss_of_analytic_models", nqm_fit_loss_words[fit.loss],
                     "directions", count(fit.n_directions), "starts", count(fit.n_starts));
}

/* json_pack() fails if any part is NULL; a count that found no memory is missing. */
char *nqm_corpus_manifest(const nqm_corpus_context *context, size_t n_items, const nqm_corpus_item *items) {
    const nqm_corpus_options *options = context->options;
    nqm_json_watch();
    json_t *kinds = json_object(), *families = json_object(), *splits = json_object(), *sources = json_object();
    count_kinds(n_items, items, kinds, families);
    count_splits(context->list, n_items, items, splits, sources);
    json_t *root = json_pack(
        "{s:i,s:{s:s,s:s},s:s,s:o,s:o,s:o,s:o,s:o,s:s,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "schema", 2, "tool", "name",
        "nqm", "version", nqm_version(), "part", options->part == NQM_CORPUS_TEST ? "test" : "train,validation",
        "labels", labels_json(), "options", options_json(options), "scene", scene_json(context), "fits",
        fit_json(&context->models), "encoders", encoders_json(context), "directions",
        nqm_directions_id(context->directions), "splits", splits, "sources", sources, "families", families, "kinds",
        kinds, "unseen_kinds", unseen_json(), "other_materials", others_json(context->list, n_items, items), "failures",
        failures_json(context->list, n_items, items), "references", references_json(context->list, n_items, items));
    char *text = root ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(root);
    char *copy = text && !nqm_json_has_failed() ? nqm_strdup(text) : NULL;
    free(text);
    return copy;
}
