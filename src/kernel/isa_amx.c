/* SPDX-License-Identifier: MIT
 *
 * Kernels for x86-64 with tile registers (AMX: TILE, BF16, INT8): those of AVX-512 with other products.
 */
#if defined __x86_64__
#include <cpuid.h>
#include <immintrin.h>
#include <pthread.h>
#include <sys/syscall.h>
#include <unistd.h>

#define TILE_CONFIGURE(from)     _tile_loadconfig(from)
#define TILE_CONFIGURATION(to)   _tile_storeconfig(to)
#define TILE_ZERO(t)             _tile_zero(t)
#define TILE_LOAD(t, from, step) _tile_loadd(t, from, step)
#define TILE_STORE(t, to, step)  _tile_stored(t, to, step)
#define TILE_BF16(c, a, b)       _tile_dpbf16ps(c, a, b)
#define TILE_INT8(c, a, b)       _tile_dpbusd(c, a, b)
#include "kernel/amx_products.h"

static bool is_permitted;

/* Linux lets a process use tile registers after it has asked once for all its threads (Documentation/arch/x86/xstate.rst).
 * CPUID, since Clang 14 does not know these units in __builtin_cpu_supports(). */
static void ask(void) {
    enum { AMX_BF16 = 1 << 22, AMX_TILE = 1 << 24, AMX_INT8 = 1 << 25, NEEDED = AMX_BF16 | AMX_TILE | AMX_INT8 };
    enum { ARCH_REQ_XCOMP_PERM = 0x1023, XFEATURE_XTILEDATA = 18 };
    unsigned a, b, c, d;
    is_permitted = __get_cpuid_count(7, 0, &a, &b, &c, &d) && (d & NEEDED) == NEEDED &&
                   syscall(SYS_arch_prctl, ARCH_REQ_XCOMP_PERM, XFEATURE_XTILEDATA) == 0;
}

bool nqm_has_amx(void) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, ask);
    return is_permitted;
}

const nqm_kernels *nqm_kernels_amx(void) {
    static nqm_kernels kernels;
    kernels = with_amx_products(&nqm_kernels_avx512_bf16, "avx512+amx");
    return &kernels;
}
#endif
