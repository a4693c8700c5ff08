/* SPDX-License-Identifier: MIT
 *
 * Checksums of the files that a list of pairs names.
 */
#include "argument/argument.h"
#include "corpus/corpus.h"

#include <string.h>

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
    char *text = nqm_argument_below(base, list->root), *more = NULL;
    nqm_argument *of = text ? nqm_argument_parse(text, NULL) : NULL;
    nqm_status status = of ? NQM_OK : nqm_fail_nomem(err, strlen(base));
    *hex = 0;
    if (of && of->path)
        status = nqm_argument_companion(of, &more, err);
    if (status == NQM_OK && of->path)
        status = nqm_corpus_hash_file(of->path, more, hex, err);
    nqm_free(more);
    nqm_argument_free(of);
    nqm_free(text);
    return status;
}

nqm_status nqm_corpus_hash_refs(nqm_corpus_list *list, nqm_error *err) {
    nqm_status status = NQM_OK;
    for (size_t i = 0; status == NQM_OK && i < list->n_refs; ++i)
        if (nqm_argument_kind_of(list->refs[i].brdf) != NQM_ARGUMENT_FIT)
            status = nqm_corpus_hash_content(list, list->refs[i].brdf, list->refs[i].file_sha256, err);
    return status;
}
