/* SPDX-License-Identifier: MIT
 *
 * Little-endian loads and stores at any alignment, on any host.
 */
#include "base/base.h"

#include <string.h>

uint16_t nqm_load_u16(const unsigned char *p) {
    return (uint16_t)(p[0] | p[1] << 8);
}

uint32_t nqm_load_u32(const unsigned char *p) {
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

uint64_t nqm_load_u64(const unsigned char *p) {
    return (uint64_t)nqm_load_u32(p) | (uint64_t)nqm_load_u32(p + 4) << 32;
}

float nqm_load_f32(const unsigned char *p) {
    uint32_t bits = nqm_load_u32(p);
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

double nqm_load_f64(const unsigned char *p) {
    uint64_t bits = nqm_load_u64(p);
    double v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

void nqm_store_u32(unsigned char *p, uint32_t v) {
    for (int i = 0; i < 4; ++i)
        p[i] = (unsigned char)(v >> 8 * i);
}

void nqm_store_u64(unsigned char *p, uint64_t v) {
    for (int i = 0; i < 8; ++i)
        p[i] = (unsigned char)(v >> 8 * i);
}

void nqm_store_f32(unsigned char *p, float v) {
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    nqm_store_u32(p, bits);
}

void nqm_store_f64(unsigned char *p, double v) {
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    nqm_store_u64(p, bits);
}
