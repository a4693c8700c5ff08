/* SPDX-License-Identifier: MIT
 *
 * Loads shared libraries.
 */
#include "base/dynamic.h"

#include <dlfcn.h>
#include <pthread.h>
#include <string.h>

static bool load(const nqm_dynamic *library) {
    void *handle = dlopen(library->soname, RTLD_NOW | RTLD_LOCAL);
    bool found = handle != NULL;
    for (size_t i = 0; i < library->n && found; ++i) {
        void *address = dlsym(handle, library->names[i]);
        /* ISO C has no conversion from void * to a function pointer; POSIX guarantees that the bytes are the same. */
        memcpy((char *)library->functions + i * sizeof address, &address, sizeof address);
        found = address != NULL;
    }
    return found;
}

static pthread_mutex_t loading = PTHREAD_MUTEX_INITIALIZER; /* locked while any library is being loaded */

bool nqm_dynamic_get(nqm_dynamic *library) {
    pthread_mutex_lock(&loading);
    if (!library->tried)
        library->loaded = load(library);
    library->tried = true;
    const bool loaded = library->loaded;
    pthread_mutex_unlock(&loading);
    return loaded;
}
