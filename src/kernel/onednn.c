/* SPDX-License-Identifier: MIT
 *
 * Loads oneDNN. NQM_ONEDNN_SONAME is the version that the build found (CMakeLists.txt).
 */
#include "kernel/onednn.h"

#include <pthread.h>

static nqm_onednn library;
static bool loaded;
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void load(void) {
    static const char *const names[] = {NQM_ONEDNN_FUNCTIONS(NQM_LIBRARY_NAME)};
    loaded = nqm_library_load(NQM_ONEDNN_SONAME, sizeof names / sizeof *names, names, &library);
}

const nqm_onednn *nqm_onednn_get(void) {
    pthread_once(&once, load);
    return loaded ? &library : NULL;
}
