/* SPDX-License-Identifier: MIT
 *
 * LRU cache of sampled BRDFs: a hash table, and a doubly linked list of its entries in order of last use. A BRDF is
 * closed as soon as it is sampled, because the samples of 500 directions take 7 KB, and a measured table 35 MB. The
 * last material files stay parsed: each of their materials is an entry.
 */
#include "metric/sample_cache.h"
#include "argument/argument.h"

#include <string.h>

enum { N_BUCKETS = 1 << 14 };

struct nqm_sample_cache {
    const nqm_model *model;
    nqm_invalid_policy policy;
    nqm_cached *newest, *oldest; /* by last use */
    size_t n_bytes, n_opened;
    nqm_argument_files *files;
    nqm_cached *bucket[N_BUCKETS];
};

nqm_status nqm_sample_cache_create(const nqm_model *model, nqm_invalid_policy policy, nqm_sample_cache **cache_ret,
                                   nqm_error *err) {
    *cache_ret = NULL;
    nqm_sample_cache *cache = nqm_alloc(1, sizeof *cache);
    if (!cache)
        return nqm_fail_nomem(err, sizeof *cache);
    cache->model = model;
    cache->policy = policy;
    cache->files = nqm_argument_files_create();
    if (cache->files)
        *cache_ret = cache;
    else
        nqm_free(cache);
    return *cache_ret ? NQM_OK : nqm_fail_nomem(err, sizeof *cache);
}

static size_t bucket_of(const nqm_subject *subject) {
    return (size_t)(nqm_subject_hash(subject) >> 32) % N_BUCKETS;
}

/* ---- list in order of last use ----------------------------------------------------------------------------------- */

static void unlink_use(nqm_sample_cache *cache, nqm_cached *entry) {
    *(entry->newer ? &entry->newer->older : &cache->newest) = entry->older;
    *(entry->older ? &entry->older->newer : &cache->oldest) = entry->newer;
    entry->newer = entry->older = NULL;
}

static void link_newest(nqm_sample_cache *cache, nqm_cached *entry) {
    entry->older = cache->newest;
    *(cache->newest ? &cache->newest->newer : &cache->oldest) = entry;
    cache->newest = entry;
}

/* ---- entries ----------------------------------------------------------------------------------------------------- */

/* The entry, its values, samples, flags and name are one block. */
static nqm_cached *make_entry(const nqm_subject *subject, size_t n_directions) {
    const size_t n_name = subject->name ? strlen(subject->name) + 1 : 0;
    const size_t n_values = subject->name ? 0 : sizeof *subject->values;
    const size_t n_bytes =
        sizeof(nqm_cached) + n_values + n_directions * (3 * sizeof(float) + sizeof(uint8_t)) + n_name;
    nqm_cached *entry = nqm_alloc(n_bytes, 1);
    if (!entry)
        return NULL;
    nqm_values *values = (nqm_values *)(entry + 1);
    entry->rgb = (float *)((char *)values + n_values);
    entry->flag = (uint8_t *)(entry->rgb + 3 * n_directions);
    entry->subject = *subject;
    if (subject->name) {
        entry->subject.name = memcpy(entry->flag + n_directions, subject->name, n_name);
    } else {
        *values = *subject->values;
        entry->subject.values = values;
    }
    entry->n_bytes = n_bytes;
    return entry;
}

static void drop(nqm_sample_cache *cache, nqm_cached *entry) {
    nqm_cached **place = &cache->bucket[bucket_of(&entry->subject)];
    while (*place != entry)
        place = &(*place)->next_in_bucket;
    *place = entry->next_in_bucket;
    unlink_use(cache, entry);
    cache->n_bytes -= entry->n_bytes;
    nqm_free(entry);
}

nqm_cached *nqm_sample_cache_get(nqm_sample_cache *cache, const nqm_subject *subject) {
    nqm_cached **bucket = &cache->bucket[bucket_of(subject)], *entry = *bucket;
    while (entry && !nqm_subjects_equal(&entry->subject, subject))
        entry = entry->next_in_bucket;
    if (entry) {
        unlink_use(cache, entry);
    } else {
        entry = make_entry(subject, cache->model->directions->n);
        if (!entry)
            return NULL;
        entry->next_in_bucket = *bucket;
        *bucket = entry;
        cache->n_bytes += entry->n_bytes;
    }
    link_newest(cache, entry);
    return entry;
}

void nqm_sample_cache_trim(nqm_sample_cache *cache, size_t max_bytes) {
    while (cache->oldest && cache->n_bytes > max_bytes)
        drop(cache, cache->oldest);
}

void nqm_sample_cache_free(nqm_sample_cache *cache) {
    if (!cache)
        return;
    nqm_sample_cache_trim(cache, 0);
    nqm_argument_files_free(cache->files);
    nqm_free(cache);
}

size_t nqm_sample_cache_n_opened(const nqm_sample_cache *cache) {
    return cache->n_opened;
}

/* ---- sampling ---------------------------------------------------------------------------------------------------- */

typedef struct fill_job {
    const nqm_sample_cache *cache;
    nqm_cached **entries;
} fill_job;

static void fill_entry(void *user, size_t i) {
    const fill_job *job = user;
    const nqm_model *model = job->cache->model;
    nqm_cached *entry = job->entries[i];
    nqm_brdf *brdf = NULL;
    entry->err = (nqm_error){0};
    nqm_status status = nqm_subject_open(&entry->subject, job->cache->files, &brdf, &entry->err);
    entry->member = (nqm_member){.status = status, .rgb = entry->rgb};
    if (status == NQM_OK)
        entry->member = nqm_sample_member(model, brdf, job->cache->policy, entry->rgb, entry->flag, &entry->err);
    nqm_brdf_free(brdf);
    status = entry->err.status = entry->member.status;
    if (status != NQM_OK)
        entry->member.flag = NULL;
    entry->filled = status != NQM_ERR_NOMEM; /* retry after out of memory */
}

nqm_status nqm_sample_cache_fill(nqm_sample_cache *cache, size_t n, nqm_cached *const *entries, nqm_error *err) {
    nqm_cached *fresh[2 * NQM_SCORE_BLOCK];
    size_t n_fresh = 0;
    for (size_t i = 0; i < n; ++i)
        if (!entries[i]->filled && !entries[i]->waiting) {
            entries[i]->waiting = true; /* the same entry may occur twice */
            fresh[n_fresh++] = entries[i];
        }
    fill_job job = {cache, fresh};
    nqm_parallel_for(n_fresh, fill_entry, &job);
    cache->n_opened += n_fresh;
    nqm_status status = NQM_OK;
    for (size_t i = 0; i < n_fresh; ++i) {
        fresh[i]->waiting = false;
        if (!fresh[i]->filled && status == NQM_OK)
            status = nqm_fail(err, NQM_ERR_NOMEM, -1, "%s", fresh[i]->err.message);
    }
    return status;
}
