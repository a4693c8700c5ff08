/* SPDX-License-Identifier: MIT
 *
 * Status texts, the library version and error reporting.
 */
#include "base/base.h"

#include <stdarg.h>

#define TEXT_OF(x) #x
#define TEXT(x)    TEXT_OF(x)

const char *nqm_version(void) {
    return TEXT(NQM_VERSION_MAJOR) "." TEXT(NQM_VERSION_MINOR) "." TEXT(NQM_VERSION_PATCH);
}

const char *nqm_status_text(nqm_status status) {
    static const char *const texts[] = {
        "success",         "invalid argument",           "cannot open, read or write a file",
        "malformed input", "inputs do not fit together", "model missing or damaged",
        "out of memory",   "size limit exceeded",        "numeric failure",
        "interrupted"};
    return status <= NQM_OK && status >= NQM_ERR_CANCELLED ? texts[-status] : "unknown status";
}

/* base.h defines macros of these names for clang-tidy. */
#undef nqm_fail
#undef nqm_fail_nomem

nqm_status nqm_fail(nqm_error *err, nqm_status status, int64_t byte_offset, const char *format, ...) {
    if (err) {
        err->status = status;
        err->byte_offset = byte_offset;
        va_list args;
        va_start(args, format);
        vsnprintf(err->message, sizeof err->message, format, args);
        va_end(args);
    }
    return status;
}

nqm_status nqm_fail_nomem(nqm_error *err, size_t n_bytes) {
    return nqm_fail(err, NQM_ERR_NOMEM, -1, "out of memory: cannot allocate %zu bytes", n_bytes);
}

nqm_status nqm_require(nqm_error *err, const char *function, const char *names, size_t n, const void *const *pointers) {
    for (size_t i = 0; i < n; ++i) {
        const size_t length = strcspn(names, ",");
        if (!pointers[i])
            return nqm_fail(err, NQM_ERR_ARG, -1, "%s: the argument %.*s is NULL", function, (int)length, names);
        names += length + strspn(names + length, ", ");
    }
    return NQM_OK;
}

/* Whether the remark has this text, which may also be a part of another one. */
static bool has_remark(const char *remark, const char *text) {
    const size_t n = strlen(text);
    for (const char *at = remark; (at = strstr(at, text)) != NULL; ++at)
        if ((at == remark || (at - remark >= 2 && strncmp(at - 2, "; ", 2) == 0)) && (!at[n] || at[n] == ';'))
            return true;
    return false;
}

void nqm_remark_add(char *remark, size_t size, const char *format, ...) {
    const size_t n = strlen(remark);
    char text[NQM_REMARK_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (!*text || has_remark(remark, text))
        return;
    if (snprintf(remark + n, size - n, "%s%s", n ? "; " : "", text) >= (int)(size - n))
        snprintf(remark + size - 4, 4, "...");
}
