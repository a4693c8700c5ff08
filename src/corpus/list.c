/* SPDX-License-Identifier: MIT
 *
 * The material list of a corpus: references, their material groups and the split of each group.
 */
#include "brdf/brdf.h"
#include "corpus/corpus.h"

#include <string.h>
#include <sys/stat.h>

static const char *const split_names[] = {"train", "validation", "test"};

const char *nqm_corpus_split_name(nqm_split split) {
    return split_names[split];
}

bool nqm_corpus_in_part(const nqm_corpus_group *group, nqm_corpus_part part) {
    return (group->split == NQM_SPLIT_TEST) == (part == NQM_CORPUS_TEST);
}

/* ---- checksums of the files -------------------------------------------------------------------------------------- */

/* Length of the file path in a BRDF argument: all of it, or up to the colon before a member's name; 0 for specs. */
static size_t file_length(const char *path) {
    struct stat st;
    if (nqm_spec_probe(path))
        return 0;
    const char *colon = strrchr(path, ':');
    return stat(path, &st) == 0 || !colon ? strlen(path) : (size_t)(colon - path);
}

nqm_status nqm_corpus_hash_file(const char *path, const char *path_more, char hex[65], nqm_error *err) {
    nqm_map map = {0}, more = {0};
    nqm_sha256 sha;
    nqm_status status = nqm_map_open(path, &map, err);
    if (status == NQM_OK && path_more)
        status = nqm_map_open(path_more, &more, err);
    if (status == NQM_OK && !nqm_sha256_begin(&sha))
        status = nqm_fail(err, NQM_ERR_NOMEM, -1, "%s: out of memory", path);
    if (status == NQM_OK) {
        nqm_sha256_add(&sha, map.data, map.n_bytes);
        nqm_sha256_add(&sha, more.data, more.n_bytes);
        nqm_sha256_end(&sha, hex);
    }
    nqm_map_close(&map);
    nqm_map_close(&more);
    return status;
}

/* Consecutive references are often members of one archive: reuse the hash of the previous file. */
static nqm_status hash_ref(nqm_corpus_list *list, size_t i, nqm_error *err) {
    nqm_corpus_ref *ref = &list->refs[i];
    size_t n = file_length(ref->path);
    if (n == 0)
        return NQM_OK;
    char *file = nqm_strdup(ref->path);
    if (!file)
        return nqm_fail_nomem(err, n);
    file[n] = 0;
    char *more;
    nqm_status status = nqm_brdf_find_companion(file, ref->path[n] ? ref->path + n + 1 : NULL, &more, err);
    const nqm_corpus_ref *previous = i > 0 ? ref - 1 : NULL;
    if (status == NQM_OK && !more && previous && file_length(previous->path) == n &&
        strncmp(previous->path, ref->path, n) == 0)
        memcpy(ref->file_sha256, previous->file_sha256, sizeof ref->file_sha256);
    else if (status == NQM_OK)
        status = nqm_corpus_hash_file(file, more, ref->file_sha256, err);
    nqm_free(more);
    nqm_free(file);
    return status;
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

typedef struct columns {
    int name, group, brdf, source, split;
} columns;

static nqm_status find_columns(const nqm_csv *csv, const char *path, columns *c, nqm_error *err) {
    const struct {
        const char *name;
        int *column;
    } required[] = {
        {"name", &c->name}, {"group", &c->group}, {"brdf", &c->brdf}, {"source", &c->source}, {"split", &c->split}};
    for (size_t i = 0; i < sizeof required / sizeof *required; ++i) {
        *required[i].column = nqm_csv_column(csv, required[i].name);
        if (*required[i].column < 0)
            return nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: a material list needs a column '%s'", path, required[i].name);
    }
    return NQM_OK;
}

static nqm_status parse_split(const char *text, const char *path, const char *name, nqm_split *split_ret,
                              nqm_error *err) {
    for (int i = 0; i < 3; ++i)
        if (strcmp(text, split_names[i]) == 0) {
            *split_ret = (nqm_split)i;
            return NQM_OK;
        }
    return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: '%s' has split '%s'; it must be train, validation or test", path,
                    name, text);
}

/* Find or add the group of a row. */
static nqm_status place_in_group(nqm_corpus_list *list, size_t i, const char *group, nqm_split split, const char *path,
                                 nqm_error *err) {
    for (size_t g = 0; g < list->n_groups; ++g) {
        if (strcmp(list->groups[g].name, group) != 0)
            continue;
        if (list->groups[g].split != split)
            return nqm_fail(err, NQM_ERR_FORMAT, -1,
                            "%s: group '%s' is in '%s' and in '%s'; all forms of a material belong to one split", path,
                            group, split_names[list->groups[g].split], split_names[split]);
        list->refs[i].group = g;
        return NQM_OK;
    }
    list->refs[i].group = list->n_groups;
    list->groups[list->n_groups++] = (nqm_corpus_group){.name = group, .split = split};
    return NQM_OK;
}

static nqm_status read_row(nqm_corpus_list *list, size_t i, const columns *c, const char *path, nqm_error *err) {
    nqm_corpus_ref *ref = &list->refs[i];
    ref->name = nqm_csv_text(list->csv, i, c->name);
    ref->brdf = nqm_csv_text(list->csv, i, c->brdf);
    ref->source = nqm_csv_text(list->csv, i, c->source);
    const char *group = nqm_csv_text(list->csv, i, c->group);
    if (!*ref->name || !*ref->brdf || !*group)
        return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: row %zu has no name, group or BRDF", path, i + 1);
    for (size_t k = 0; k < i; ++k)
        if (strcmp(list->refs[k].name, ref->name) == 0)
            return nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: the name '%s' is not unique", path, ref->name);
    nqm_split split = NQM_SPLIT_TRAIN;
    nqm_status status = parse_split(nqm_csv_text(list->csv, i, c->split), path, ref->name, &split, err);
    return status == NQM_OK ? place_in_group(list, i, group, split, path, err) : status;
}

/* Bring the references of each group together. */
static nqm_status sort_by_group(nqm_corpus_list *list, nqm_error *err) {
    nqm_corpus_ref *sorted = nqm_alloc(list->n_refs, sizeof *sorted);
    if (!sorted)
        return nqm_fail_nomem(err, list->n_refs * sizeof *sorted);
    for (size_t i = 0; i < list->n_refs; ++i)
        ++list->groups[list->refs[i].group].n_refs;
    for (size_t g = 1; g < list->n_groups; ++g)
        list->groups[g].first_ref = list->groups[g - 1].first_ref + list->groups[g - 1].n_refs;
    for (size_t g = 0; g < list->n_groups; ++g)
        list->groups[g].n_refs = 0;
    for (size_t i = 0; i < list->n_refs; ++i) {
        nqm_corpus_group *group = &list->groups[list->refs[i].group];
        sorted[group->first_ref + group->n_refs++] = list->refs[i];
    }
    memcpy(list->refs, sorted, list->n_refs * sizeof *sorted);
    nqm_free(sorted);
    return NQM_OK;
}

static nqm_status read_rows(nqm_corpus_list *list, const char *path, const char *root, nqm_error *err) {
    columns c;
    size_t n = nqm_csv_rows(list->csv);
    nqm_status status = find_columns(list->csv, path, &c, err);
    if (status == NQM_OK && n == 0)
        status = nqm_fail(err, NQM_ERR_FORMAT, -1, "%s: lists no material", path);
    if (status == NQM_OK)
        status = nqm_alloc_arrays(
            NQM_ARRAYS({&list->groups, n, sizeof *list->groups}, {&list->refs, n, sizeof *list->refs}), err);
    const char *slash = strrchr(path, '/');
    size_t n_root = root ? strlen(root) : slash ? (size_t)(slash - path) : 0;
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        status = read_row(list, i, &c, path, err);
        if (status != NQM_OK)
            return status;
        list->refs[i].path = nqm_brdf_path_below(list->refs[i].brdf, root ? root : path, n_root);
        list->n_refs = i + 1;
        status = list->refs[i].path ? hash_ref(list, i, err) : nqm_fail_nomem(err, strlen(list->refs[i].brdf));
    }
    return status == NQM_OK ? sort_by_group(list, err) : status;
}

nqm_status nqm_corpus_list_load(const char *materials_csv, const char *root, nqm_corpus_list *list_ret,
                                nqm_error *err) {
    *list_ret = (nqm_corpus_list){0};
    nqm_status status = nqm_csv_load(materials_csv, &list_ret->csv, err);
    if (status != NQM_OK)
        return status;
    status = read_rows(list_ret, materials_csv, root, err);
    if (status != NQM_OK)
        nqm_corpus_list_free(list_ret);
    return status;
}

void nqm_corpus_list_free(nqm_corpus_list *list) {
    for (size_t i = 0; i < list->n_refs; ++i)
        nqm_free(list->refs[i].path);
    nqm_free(list->groups);
    nqm_csv_free(list->csv);
    *list = (nqm_corpus_list){0};
}
