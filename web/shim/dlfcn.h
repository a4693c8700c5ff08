/* SPDX-License-Identifier: MIT
 *
 * A page has no shared libraries.
 */
#ifndef NQM_WEB_DLFCN_H
#define NQM_WEB_DLFCN_H
#define RTLD_NOW   0
#define RTLD_LOCAL 0
static inline void *dlopen(const char *name, int mode) {
    (void)name, (void)mode;
    return NULL;
}
static inline void *dlsym(void *library, const char *name) {
    (void)library, (void)name;
    return NULL;
}
#endif
