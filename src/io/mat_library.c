/* SPDX-License-Identifier: MIT
 *
 * Loads matio. NQM_MATIO_SONAME is the version that the build found (CMakeLists.txt).
 */
#include "io/mat_library.h"

#include "io/io.h"

#include <pthread.h>

static nqm_matio library;
static bool loaded;
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void load(void) {
    static const char *const names[] = {NQM_MATIO_FUNCTIONS(NQM_LIBRARY_NAME)};
    loaded = nqm_library_load(NQM_MATIO_SONAME, sizeof names / sizeof *names, names, &library);
}

const char *nqm_matio_name(void) {
    return NQM_MATIO_SONAME;
}

nqm_status nqm_matio_get(const nqm_matio **matio_ret, nqm_error *err) {
    pthread_once(&once, load);
    *matio_ret = loaded ? &library : NULL;
    return loaded ? NQM_OK
                  : nqm_fail(err, NQM_ERR_IO, -1, "MAT files need the library %s, which cannot be loaded",
                             NQM_MATIO_SONAME);
}
