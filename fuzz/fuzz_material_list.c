/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: lists of materials for `nqm dataset`. The files that a list names are hashed if they exist, below an empty folder.
 * In an accepted list every reference belongs to one group.
 */
#include "corpus/corpus.h"
#include "fuzz.h"

#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    char path[FUZZ_PATH];
    nqm_corpus_list list;
    nqm_error err = {0};
    if (memchr(data, '/', n_bytes)) /* names a file of this machine */
        return 0;
    const int fd = fuzz_file(data, n_bytes, path);
    if (nqm_corpus_list_load(path, "/var/empty", &list, &err) != NQM_OK) {
        must(!list.csv && !list.refs && err.message[0]);
    } else {
        size_t n = 0;
        for (size_t g = 0; g < list.n_groups; ++g)
            for (size_t i = 0; i < list.groups[g].n_refs; ++i, ++n)
                must(list.refs[list.groups[g].first_ref + i].group == g);
        must(n == list.n_refs && n > 0);
        nqm_corpus_list_free(&list);
    }
    close(fd);
    return 0;
}

blob fuzz_seed(void) {
    static const char text[] = "name,group,brdf,source,split\nm-sgd,brass,sgd:brass,sgd,train\n"
                               "n-ggx,n,ggx:kd=0.2;alpha=0.3,ggx,validation\no-ggx,o,ggx:kd=.1;alpha=.1,ggx,test\n";
    return blob_of(sizeof text - 1, text);
}
