/* SPDX-License-Identifier: MIT
 *
 * What the manifest of a corpus says: kinds of distortion that its training part does not have, sources of references, and whether
 * these may be anisotropic.
 */
#include "data/data.h"
#include "io/json.h"

#include <string.h>

nqm_status nqm_dataset_unseen_kinds(const nqm_dataset *d, bool *unseen, nqm_error *err) {
    json_t *manifest;
    const nqm_status status = nqm_json_parse(d->manifest, &manifest, err);
    const json_t *names = json_object_get(manifest, "unseen_kinds");
    for (size_t kind = 0; kind < d->n_kinds; ++kind) {
        unseen[kind] = false;
        for (size_t i = 0; i < json_array_size(names); ++i) {
            const char *name = json_string_value(json_array_get(names, i));
            unseen[kind] = unseen[kind] || (name && strcmp(name, nqm_name(&d->kind_names, kind)) == 0);
        }
    }
    json_decref(manifest);
    return status;
}

/* ---- sources ----------------------------------------------------------------------------------------------------- */

/* Words of manifests, also as the beginning of words like "rgl-unfolded", and the groups that they belong to. */
static const struct {
    const char *word, *group;
} sources[] = {{"rgl", "measured"}, {"merl", "measured"}, {"nbrdf", "neural"}, {"nps", "neural"}, {"sgd", "analytic"}};

static const char *group_of(const char *source) {
    const size_t n = strcspn(source, "-");
    for (size_t i = 0; i < sizeof sources / sizeof *sources; ++i)
        if (strlen(sources[i].word) == n && strncmp(source, sources[i].word, n) == 0)
            return sources[i].group;
    return source;
}

nqm_status nqm_dataset_set_manifest(nqm_dataset *d, const char *text, nqm_error *err) {
    json_t *manifest;
    d->manifest = text ? nqm_strdup(text) : NULL;
    if (text && !d->manifest)
        return nqm_fail_nomem(err, strlen(text));
    nqm_status status = nqm_json_parse(d->manifest, &manifest, err);
    if (status != NQM_OK)
        return status;
    const json_t *references = json_object_get(manifest, "references");
    d->is_anisotropic = json_is_true(json_object_get(manifest, "anisotropic"));
    bool is_listed = json_array_size(references) == d->n_refs;
    for (size_t i = 0; is_listed && status == NQM_OK && i < d->n_refs; ++i) {
        const json_t *row = json_array_get(references, i), *source = json_object_get(row, "source");
        const char *name = json_string_value(json_object_get(row, "name"));
        is_listed = name && json_is_string(source) && strcmp(name, nqm_name(&d->ref_names, i)) == 0;
        if (is_listed)
            status = nqm_names_add(&d->ref_sources, json_string_value(source), json_string_length(source), err);
    }
    json_decref(manifest);
    if (!is_listed)
        nqm_names_free(&d->ref_sources);
    return status;
}

nqm_status nqm_dataset_check_isotropic(const nqm_dataset *d, nqm_error *err) {
    return d->is_anisotropic
               ? nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                          "its pairs are anisotropic and its samples of one azimuth; the model 'anisotropic' opens the "
                          "BRDFs themselves")
               : NQM_OK;
}

const char *nqm_dataset_ref_source(const nqm_dataset *d, size_t ref) {
    return d->ref_sources.n ? group_of(nqm_name(&d->ref_sources, ref)) : "";
}
