/* SPDX-License-Identifier: MIT
 *
 * sample_cache.h - LRU cache of BRDFs, by name or values, sampled at a model's directions, with a limit in bytes.
 */
#ifndef NQM_SRC_METRIC_SAMPLE_CACHE_H
#define NQM_SRC_METRIC_SAMPLE_CACHE_H

#include "brdf/brdf.h"
#include "metric/metric.h"

/** Sample an opened BRDF into rgb (n_directions, 3) and flag (n_directions), which must outlive the member. */
nqm_member nqm_sample_member(const nqm_model *model, const nqm_brdf *brdf, nqm_invalid_policy policy, float *rgb,
                             uint8_t *flag, nqm_error *err);

/** A BRDF. `member` and `err` are set by nqm_sample_cache_fill(). */
typedef struct nqm_cached {
    nqm_member member; /* its status covers opening and sampling */
    nqm_error err;     /* error of opening or sampling */
    /* used by the cache only: */
    nqm_subject subject; /* with copies */
    float *rgb;
    uint8_t *flag;
    size_t n_bytes;       /* of the whole entry */
    bool filled, waiting; /* filled: sampled; waiting: the current nqm_sample_cache_fill() will sample it */
    struct nqm_cached *next_in_bucket, *newer, *older;
} nqm_cached;

typedef struct nqm_sample_cache nqm_sample_cache;

/** The model must outlive the cache. */
NQM_MUST_CHECK nqm_status nqm_sample_cache_create(const nqm_model *model, nqm_invalid_policy policy,
                                                  nqm_sample_cache **cache_ret, nqm_error *err);
void nqm_sample_cache_free(nqm_sample_cache *cache);

/** Find or create the entry of a BRDF and mark it as the most recently used; NULL when out of memory. The entry is
 *  valid until the next nqm_sample_cache_trim(). */
nqm_cached *nqm_sample_cache_get(nqm_sample_cache *cache, const nqm_subject *subject);
/** Open and sample, on all threads, those of n <= 2 NQM_SCORE_BLOCK entries that are not sampled yet. Returns NQM_OK or
 *  NQM_ERR_NOMEM; other failures are recorded in the entries. */
NQM_MUST_CHECK nqm_status nqm_sample_cache_fill(nqm_sample_cache *cache, size_t n, nqm_cached *const *entries,
                                                nqm_error *err);
/** Free the least recently used entries until the rest takes at most `max_bytes`. */
void nqm_sample_cache_trim(nqm_sample_cache *cache, size_t max_bytes);
/** Number of BRDFs opened so far. */
size_t nqm_sample_cache_n_opened(const nqm_sample_cache *cache);

#endif
