/* SPDX-License-Identifier: MIT
 *
 * Loads shared libraries.
 */
#include "base/base.h"

#include <dlfcn.h>

bool nqm_dynamic_load(const char *soname, size_t n, const char *const *names, void *functions) {
    void *handle = dlopen(soname, RTLD_NOW | RTLD_LOCAL);
    bool found = handle != NULL;
    for (size_t i = 0; i < n && found; ++i) {
        void *address = dlsym(handle, names[i]);
        /* ISO C has no conversion from void * to a function pointer; POSIX guarantees that the bytes are the same. */
        memcpy((char *)functions + i * sizeof address, &address, sizeof address);
        found = address != NULL;
    }
    return found;
}
