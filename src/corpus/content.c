/* SPDX-License-Identifier: MIT
 *
 * Checksums of the files that a list of pairs names.
 */
#include "brdf/brdf.h"
#include "corpus/corpus.h"

#include <string.h>

/* Length of the file path in a BRDF argument: all of it, or up to the colon before a member's name; 0 for specs. */
static size_t file_length(const char *path) {
    if (nqm_spec_probe(path))
        return 0;
    const char *colon = nqm_member_colon(path);
    return colon ? (size_t)(colon - path) : strlen(path);
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

nqm_status nqm_corpus_hash_content(const nqm_corpus_list *list, const char *base, char hex[65], nqm_error *err) {
    const char *root = list->root;
    char *path = nqm_brdf_path_below(base, root, root ? strlen(root) : 0), *more = NULL;
    const size_t n = path ? file_length(path) : 0;
    nqm_status status = path ? NQM_OK : nqm_fail_nomem(err, strlen(base));
    *hex = 0;
    if (n > 0) {
        const char *member = path[n] ? path + n + 1 : NULL;
        path[n] = 0;
        status = nqm_brdf_find_companion(path, member, &more, err);
        if (status == NQM_OK)
            status = nqm_corpus_hash_file(path, more, hex, err);
    }
    nqm_free(more);
    nqm_free(path);
    return status;
}

nqm_status nqm_corpus_hash_refs(nqm_corpus_list *list, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < list->n_refs; ++i)
        if (strncmp(list->refs[i].brdf, "fit:", 4) != 0)
            status = nqm_corpus_hash_content(list, list->refs[i].brdf, list->refs[i].file_sha256, err);
    return status;
}
