/* SPDX-License-Identifier: MIT
 *
 * Loads matio. NQM_MATIO_SONAME is the version that the build found (CMakeLists.txt).
 */
#include "io/mat_library.h"

#include "io/io.h"

static const char *const names[] = {NQM_MATIO_FUNCTIONS(NQM_LIBRARY_NAME)};
static nqm_matio functions;
static nqm_library library = NQM_LIBRARY(NQM_MATIO_SONAME, names, functions);

const char *nqm_matio_name(void) {
    return NQM_MATIO_SONAME;
}

nqm_status nqm_matio_get(const nqm_matio **matio_ret, nqm_error *err) {
    *matio_ret = nqm_library_get(&library) ? &functions : NULL;
    return *matio_ret ? NQM_OK
                      : nqm_fail(err, NQM_ERR_IO, -1, "MAT files need the library %s, which cannot be loaded",
                                 NQM_MATIO_SONAME);
}
