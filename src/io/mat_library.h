/* SPDX-License-Identifier: MIT
 *
 * mat_library.h - matio, loaded when the first MAT file is read or written. It stands on HDF5, which stands on curl and
 * 30 further libraries: linked in, they would double the start-up time of programs that hardly ever see a MAT file
 * (doc/performance.md).
 */
#ifndef NQM_SRC_IO_MAT_LIBRARY_H
#define NQM_SRC_IO_MAT_LIBRARY_H

#include "base/library.h"
#include <matio.h>

#define NQM_MATIO_FUNCTIONS(X)                                                                                         \
    X(Mat_Open)                                                                                                        \
    X(Mat_CreateVer)                                                                                                   \
    X(Mat_Close)                                                                                                       \
    X(Mat_GetVersion)                                                                                                  \
    X(Mat_VarReadInfo)                                                                                                 \
    X(Mat_VarReadDataLinear)                                                                                           \
    X(Mat_VarCreate)                                                                                                   \
    X(Mat_VarWrite)                                                                                                    \
    X(Mat_VarFree)

/** The functions of matio that are used here, under their own names. */
typedef struct nqm_matio {
    NQM_MATIO_FUNCTIONS(NQM_LIBRARY_MEMBER)
} nqm_matio;

/** The library, loaded once and for good. NQM_ERR_IO where it is not installed. Thread-safe. */
NQM_MUST_CHECK nqm_status nqm_matio_get(const nqm_matio **matio_ret, nqm_error *err);

#endif
