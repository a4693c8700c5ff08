/* SPDX-License-Identifier: MIT
 *
 * Loads matio. NQM_MATIO_SONAME is the version that the build found (CMakeLists.txt).
 */
#include "io/mat_library.h"

#include "io/io.h"

#include <dlfcn.h>
#include <pthread.h>
#include <string.h>

static nqm_matio library;
static bool loaded;
static pthread_once_t once = PTHREAD_ONCE_INIT;

/* Look up a function and store its address. ISO C knows no conversion between both kinds of pointers, POSIX does. */
static bool find(void *handle, const char *name, void *function) {
    void *address = dlsym(handle, name);
    memcpy(function, &address, sizeof address);
    return address != NULL;
}

static void load(void) {
    void *handle = dlopen(NQM_MATIO_SONAME, RTLD_NOW | RTLD_LOCAL);
    loaded = handle != NULL;
#define FIND(name) loaded = loaded && find(handle, #name, &library.name);
    NQM_MATIO_FUNCTIONS(FIND)
#undef FIND
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
