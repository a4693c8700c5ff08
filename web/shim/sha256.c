/* SPDX-License-Identifier: MIT
 *
 * SHA-256 (FIPS 180-4) in place of OpenSSL's.
 */
#include "base/base.h"

typedef struct state {
    uint32_t h[8], w[64];
    unsigned char block[64];
    uint64_t n_bytes;
} state;

static const uint32_t k[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

static uint32_t turn(uint32_t x, int n) {
    return x >> n | x << (32 - n);
}

static void add_block(state *s) {
    uint32_t v[8];
    memcpy(v, s->h, sizeof v);
    for (int i = 0; i < 64; ++i) {
        const uint32_t a = i < 16 ? 0 : s->w[i - 15], b = i < 16 ? 0 : s->w[i - 2];
        s->w[i] = i < 16 ? (uint32_t)nqm_load_integer(s->block + 4 * i, 4, true)
                         : s->w[i - 16] + (turn(a, 7) ^ turn(a, 18) ^ a >> 3) + s->w[i - 7] +
                               (turn(b, 17) ^ turn(b, 19) ^ b >> 10);
        const uint32_t t = v[7] + (turn(v[4], 6) ^ turn(v[4], 11) ^ turn(v[4], 25)) + ((v[4] & v[5]) ^ (~v[4] & v[6])) +
                           k[i] + s->w[i];
        const uint32_t u =
            (turn(v[0], 2) ^ turn(v[0], 13) ^ turn(v[0], 22)) + ((v[0] & v[1]) ^ (v[0] & v[2]) ^ (v[1] & v[2]));
        memmove(v + 1, v, 7 * sizeof *v);
        v[4] += t;
        v[0] = t + u;
    }
    for (int i = 0; i < 8; ++i)
        s->h[i] += v[i];
}

bool nqm_sha256_begin(nqm_sha256 *sha) {
    state *s = sha->context = nqm_alloc(1, sizeof *s);
    static const uint32_t start[8] = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    if (s)
        memcpy(s->h, start, sizeof start);
    return s != NULL;
}

void nqm_sha256_add(nqm_sha256 *sha, const void *data, size_t n_bytes) {
    state *s = sha->context;
    const unsigned char *p = data;
    while (n_bytes) {
        const size_t used = s->n_bytes % 64, n = nqm_smaller(64 - used, n_bytes);
        memcpy(s->block + used, p, n);
        s->n_bytes += n, p += n, n_bytes -= n;
        if (s->n_bytes % 64 == 0)
            add_block(s);
    }
}

void nqm_sha256_end(nqm_sha256 *sha, char hex[65]) {
    state *s = sha->context;
    const uint64_t n_bits = 8 * s->n_bytes;
    const unsigned char one = 0x80, zero = 0;
    unsigned char length[8];
    for (int i = 0; i < 8; ++i)
        length[i] = (unsigned char)(n_bits >> (56 - 8 * i));
    nqm_sha256_add(sha, &one, 1);
    while (s->n_bytes % 64 != 56)
        nqm_sha256_add(sha, &zero, 1);
    nqm_sha256_add(sha, length, 8);
    for (int i = 0; i < 8; ++i)
        snprintf(hex + 8 * i, 9, "%08x", s->h[i]);
    nqm_free(s);
    sha->context = NULL;
}
