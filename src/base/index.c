/* SPDX-License-Identifier: MIT
 *
 * A hash table of values that have names (base.h, nqm_index), so that files with many names are read in linear time.
 */
#include "base/base.h"

/* The slot of the key, or the empty one where it belongs. */
static const void **find_slot(const nqm_index *index, const nqm_index_key *key) {
    uint64_t hash = (uint64_t)(uintptr_t)key->scope;
    for (const char *c = key->name; *c; ++c)
        hash = (hash ^ (unsigned char)*c) * 0x100000001b3u; /* FNV-1a */
    size_t i = (size_t)nqm_hash_mix(hash) & (index->n_slots - 1);
    for (; index->slots[i]; i = (i + 1) & (index->n_slots - 1)) {
        const nqm_index_key k = index->key_of(index->slots[i]);
        if (k.scope == key->scope && strcmp(k.name, key->name) == 0)
            break;
    }
    return &index->slots[i];
}

nqm_status nqm_index_create(size_t max_n, nqm_index_key (*key_of)(const void *value), nqm_index *index_ret,
                            nqm_error *err) {
    size_t n = 64;
    while (n / 2 < max_n)
        n *= 2;
    *index_ret = (nqm_index){.slots = nqm_alloc(n, sizeof *index_ret->slots), .n_slots = n, .key_of = key_of};
    return index_ret->slots ? NQM_OK : nqm_fail_nomem(err, n * sizeof *index_ret->slots);
}

void nqm_index_add(nqm_index *index, const void *value) {
    const nqm_index_key key = index->key_of(value);
    const void **slot = find_slot(index, &key);
    if (!*slot)
        *slot = value;
}

nqm_status nqm_index_reserve(nqm_index *index, size_t n, nqm_error *err) {
    nqm_index larger;
    if (n <= index->n_slots / 2)
        return NQM_OK;
    nqm_status status = nqm_index_create(n, index->key_of, &larger, err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < index->n_slots; ++i)
        if (index->slots[i])
            nqm_index_add(&larger, index->slots[i]);
    nqm_index_free(index);
    *index = larger;
    return NQM_OK;
}

const void *nqm_index_find(const nqm_index *index, nqm_index_key key) {
    return *find_slot(index, &key);
}

void nqm_index_free(nqm_index *index) {
    nqm_free(index->slots);
    *index = (nqm_index){0};
}
