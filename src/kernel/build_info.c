/* SPDX-License-Identifier: MIT
 *
 * What this build holds, in one line: the libraries that compute or read files, and the instruction set that
 * oneDNN found, and OpenMP.
 */
#include <nqm/base.h>

#include <dnnl.h>
#include <pthread.h>
#include <stdio.h>
#include <zip.h>

static char line[256];
static pthread_once_t once = PTHREAD_ONCE_INIT;

static const char *isa_name(void) {
    switch (dnnl_get_effective_cpu_isa()) {
    case dnnl_cpu_isa_sse41:
        return "sse4.1";
    case dnnl_cpu_isa_avx:
        return "avx";
    case dnnl_cpu_isa_avx2:
        return "avx2";
    case dnnl_cpu_isa_avx2_vnni:
        return "avx2+vnni";
    case dnnl_cpu_isa_avx512_core:
        return "avx512";
    case dnnl_cpu_isa_avx512_core_vnni:
        return "avx512+vnni";
    case dnnl_cpu_isa_avx512_core_bf16:
        return "avx512+bf16";
    case dnnl_cpu_isa_avx512_core_amx:
        return "avx512+amx";
    default:
        return "generic";
    }
}

static void make_line(void) {
    const dnnl_version_t *dnnl = dnnl_version();
#ifdef _OPENMP
    const long openmp = _OPENMP;
#else
    const long openmp = 0;
#endif
    snprintf(line, sizeof line, "oneDNN %d.%d.%d (%s), libzip %s, OpenMP %ld", dnnl->major, dnnl->minor, dnnl->patch,
             isa_name(), zip_libzip_version(), openmp);
}

const char *nqm_build_info(void) {
    pthread_once(&once, make_line);
    return line;
}
