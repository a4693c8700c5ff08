/* SPDX-License-Identifier: MIT
 *
 * The kernels by tile registers, compiled for their emulation.
 */
#include "support/tables.h"
#include "support/amx_emulated.h"

#include <pthread.h>

#define TILE_CONFIGURE(from)     amx_configure(from)
#define TILE_CONFIGURATION(to)   amx_configuration(to)
#define TILE_ZERO(t)             amx_zero(t)
#define TILE_LOAD(t, from, step) amx_load(t, from, step)
#define TILE_STORE(t, to, step)  amx_store(t, to, step)
#define TILE_BF16(c, a, b)       amx_bf16(c, a, b)
#define TILE_INT8(c, a, b)       amx_int8(c, a, b)
#include "kernel/amx_products.h"

static nqm_kernels emulated;
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void make_emulated(void) {
    emulated = with_amx_products(nqm_kernels_at(0), "amx (emulated)");
}

const nqm_kernels *emulated_kernels(void) {
    pthread_once(&once, make_emulated);
    return &emulated;
}

const nqm_kernels *every_table(size_t i) {
    if (nqm_kernels_at(i) == &nqm_kernels_scalar)
        return emulated_kernels();
    return i > 0 && nqm_kernels_at(i - 1) == &nqm_kernels_scalar ? &nqm_kernels_scalar : nqm_kernels_at(i);
}
