/* SPDX-License-Identifier: MIT
 *
 * Checked, zeroed and aligned allocation.
 */
#include "base/base.h"
#include "base/memory_test.h"
#include "base/os.h"

#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>

enum { ALIGNMENT = 64 }; /* bytes of a cache line, and of the widest vector register */

static _Atomic long countdown = -1, count;

void nqm_alloc_fail_after(long n) {
    atomic_store(&countdown, n);
}

long nqm_alloc_count(void) {
    return atomic_load(&count);
}

/* Counts an allocation; true when nqm_alloc_fail_after() makes it fail. */
static bool told_to_fail(void) {
    atomic_fetch_add_explicit(&count, 1, memory_order_relaxed);
    return atomic_load_explicit(&countdown, memory_order_relaxed) >= 0 && atomic_fetch_sub(&countdown, 1) == 0;
}

bool nqm_mul_size(size_t a, size_t b, size_t *product) {
    return !__builtin_mul_overflow(a, b, product);
}

void *nqm_alloc(size_t n, size_t size) {
    size_t n_bytes;
    if (!nqm_mul_size(n, size, &n_bytes) || n_bytes > SIZE_MAX - ALIGNMENT)
        return NULL;
    if (told_to_fail())
        return NULL;
    n_bytes = (n_bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    void *block = nqm_os_alloc(ALIGNMENT, n_bytes ? n_bytes : ALIGNMENT);
    if (block)
        memset(block, 0, n_bytes);
    return block;
}

void nqm_free(void *block) {
    nqm_os_free(block);
}

nqm_status nqm_alloc_arrays(size_t n_arrays, const nqm_array *arrays, nqm_error *err) {
    size_t n_bytes = 0, n_array;
    unsigned char *at = NULL;
    bool ok = true;
    for (size_t i = 0; ok && i < n_arrays; ++i) {
        if (!arrays[i].pointer)
            continue;
        ok = nqm_mul_size(arrays[i].n, arrays[i].size, &n_array) && n_array <= SIZE_MAX / 2 - n_bytes;
        n_bytes += ok ? (n_array + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT : 0;
    }
    if (ok)
        at = nqm_alloc(n_bytes, 1);
    for (size_t i = 0; i < n_arrays; ++i) {
        if (!arrays[i].pointer)
            continue;
        memcpy(arrays[i].pointer, &at, sizeof at);
        if (at)
            at += (arrays[i].n * arrays[i].size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    }
    return at ? NQM_OK : nqm_fail_nomem(err, n_bytes);
}

enum { MIN_PAGES = 1 << 20 }; /* bytes; for smaller blocks mapping costs more than it saves */

void *nqm_alloc_pages(size_t n, size_t size) {
    size_t n_bytes;
    if (!nqm_mul_size(n, size, &n_bytes) || n_bytes < MIN_PAGES)
        return nqm_alloc(n, size);
    return told_to_fail() ? NULL : nqm_os_alloc_pages(n_bytes);
}

void nqm_free_pages(void *block, size_t n, size_t size) {
    if (n * size < MIN_PAGES)
        nqm_free(block);
    else if (block)
        nqm_os_free_pages(block, n * size);
}

void *nqm_grow(void *block, size_t *max_n, size_t n, size_t size) {
    enum { MIN_ELEMENTS = 64 };
    size_t n_bytes;
    if (n <= *max_n)
        return block;
    const size_t max = nqm_larger(nqm_larger(n, 2 * *max_n), MIN_ELEMENTS);
    if (!nqm_mul_size(max, size, &n_bytes) || told_to_fail())
        return NULL;
    /* Large blocks move without a copy; pages behind the elements are not used yet. */
    void *larger = nqm_os_realloc(block, n_bytes);
    if (larger)
        *max_n = max;
    return larger;
}

char *nqm_strdup(const char *text) {
    size_t n = strlen(text) + 1;
    char *copy = nqm_alloc(n, 1);
    if (copy)
        memcpy(copy, text, n);
    return copy;
}

char *nqm_strdupf(const char *format, ...) {
    va_list args;
    va_start(args, format);
    const int length = vsnprintf(NULL, 0, format, args);
    va_end(args);
    char *text = length < 0 ? NULL : nqm_alloc((size_t)length + 1, 1);
    va_start(args, format);
    if (text)
        vsnprintf(text, (size_t)length + 1, format, args);
    va_end(args);
    return text;
}

char *nqm_path_beside(const char *path, const char *name) {
    const char *slash = *name == '/' ? NULL : strrchr(path, '/');
    return nqm_strdupf("%.*s%s", slash ? (int)(slash - path) + 1 : 0, path, name);
}
