/* SPDX-License-Identifier: MIT
 *
 * Random numbers with explicit state, seeded by splitmix64 (Steele, Lea and Flood 2014, DOI 10.1145/2660193.2660195).
 */
#include "base/base.h"

#include <math.h>

uint64_t nqm_hash_u64(uint64_t seed, uint64_t counter) {
    return nqm_hash_mix(nqm_hash_key(seed) + (counter + 1) * NQM_GOLDEN);
}

nqm_rng nqm_rng_make(uint64_t seed, uint64_t stream) {
    nqm_rng rng;
    uint64_t base = nqm_hash_u64(seed, stream);
    for (uint64_t i = 0; i < 4; ++i)
        rng.s[i] = nqm_hash_u64(base, i);
    return rng;
}

static uint64_t rotate_left(uint64_t x, int k) {
    return x << k | x >> (64 - k);
}

uint64_t nqm_rng_u64(nqm_rng *rng) {
    uint64_t *s = rng->s;
    uint64_t result = rotate_left(s[1] * 5, 7) * 9;
    uint64_t t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = rotate_left(s[3], 45);
    return result;
}

double nqm_rng_uniform(nqm_rng *rng) {
    return (double)(nqm_rng_u64(rng) >> 11) * 0x1p-53;
}

double nqm_rng_normal(nqm_rng *rng) {
    double u = 1.0 - nqm_rng_uniform(rng); /* in (0, 1], so that the logarithm is finite */
    double v = nqm_rng_uniform(rng);
    return sqrt(-2.0 * log(u)) * cos(6.283185307179586 * v);
}

uint64_t nqm_rng_below(nqm_rng *rng, uint64_t n) {
    uint64_t limit = UINT64_MAX - UINT64_MAX % n; /* a multiple of n, so that all results are equally likely */
    uint64_t v;
    do
        v = nqm_rng_u64(rng);
    while (v >= limit);
    return v % n;
}

void nqm_rng_shuffle(nqm_rng *rng, size_t n, size_t *idx) {
    for (size_t i = n; i > 1; --i) {
        size_t j = (size_t)nqm_rng_below(rng, i);
        size_t t = idx[i - 1];
        idx[i - 1] = idx[j];
        idx[j] = t;
    }
}
