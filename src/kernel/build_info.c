/* SPDX-License-Identifier: MIT
 *
 * One line about this build: versions of its libraries and of OpenMP, and the best kernels that this processor can run.
 */
#include "base/os.h"
#include "kernel/kernel.h"

#include <stdio.h>
#include <zip.h>

static char line[256];
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void make_line(void) {
#ifdef _OPENMP
    const long openmp = _OPENMP;
#else
    const long openmp = 0;
#endif
    snprintf(line, sizeof line, "libzip %s, OpenMP %ld, kernels %s", zip_libzip_version(), openmp,
             nqm_kernels_at(0)->name);
}

const char *nqm_build_info(void) {
    pthread_once(&once, make_line);
    return line;
}
