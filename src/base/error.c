/* SPDX-License-Identifier: MIT
 *
 * Status texts, the library version and the one way to fail with a message.
 */
#include "base/base.h"

#include <stdarg.h>

#define TEXT_OF(x) #x
#define TEXT(x)    TEXT_OF(x)

const char *nqm_version(void) {
    return TEXT(NQM_VERSION_MAJOR) "." TEXT(NQM_VERSION_MINOR) "." TEXT(NQM_VERSION_PATCH);
}

const char *nqm_status_text(nqm_status status) {
    switch (status) {
    case NQM_OK:
        return "success";
    case NQM_ERR_ARG:
        return "invalid argument";
    case NQM_ERR_IO:
        return "cannot open, read or write a file";
    case NQM_ERR_FORMAT:
        return "malformed input";
    case NQM_ERR_INCOMPATIBLE:
        return "inputs do not fit together";
    case NQM_ERR_MODEL:
        return "model missing or damaged";
    case NQM_ERR_NOMEM:
        return "out of memory";
    case NQM_ERR_LIMIT:
        return "size limit exceeded";
    case NQM_ERR_NUMERIC:
        return "numeric failure";
    case NQM_ERR_CANCELLED:
        return "interrupted";
    }
    return "unknown status";
}

/* What base.h makes of them for clang-tidy. */
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
    return nqm_fail(err, NQM_ERR_NOMEM, -1, "out of memory: %zu bytes were asked for", n_bytes);
}
