/* SPDX-License-Identifier: MIT
 *
 * Loads oneDNN. NQM_ONEDNN_SONAME is the shared library that CMakeLists.txt found at build time.
 */
#include "kernel/onednn.h"

static const char *const names[] = {NQM_ONEDNN_FUNCTIONS(NQM_LIBRARY_NAME)};
static nqm_onednn functions;
static nqm_library library = NQM_LIBRARY(NQM_ONEDNN_SONAME, names, functions);

const nqm_onednn *nqm_onednn_get(void) {
    return nqm_library_get(&library) ? &functions : NULL;
}
