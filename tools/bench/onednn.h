/* SPDX-License-Identifier: MIT
 *
 * onednn.h - oneDNN, loaded at its first use, because most commands never use it.
 */
#ifndef NQM_SRC_KERNEL_ONEDNN_H
#define NQM_SRC_KERNEL_ONEDNN_H

#include "base/library.h"
#include <dnnl.h>

#define NQM_ONEDNN_FUNCTIONS(X)                                                                                        \
    X(dnnl_sgemm)                                                                                                      \
    X(dnnl_engine_create)                                                                                              \
    X(dnnl_engine_destroy)                                                                                             \
    X(dnnl_stream_create)                                                                                              \
    X(dnnl_stream_wait)                                                                                                \
    X(dnnl_stream_destroy)                                                                                             \
    X(dnnl_memory_desc_init_by_tag)                                                                                    \
    X(dnnl_memory_desc_get_size)                                                                                       \
    X(dnnl_memory_create)                                                                                              \
    X(dnnl_memory_destroy)                                                                                             \
    X(dnnl_matmul_desc_init)                                                                                           \
    X(dnnl_primitive_desc_create)                                                                                      \
    X(dnnl_primitive_desc_query_md)                                                                                    \
    X(dnnl_primitive_desc_destroy)                                                                                     \
    X(dnnl_primitive_create)                                                                                           \
    X(dnnl_primitive_execute)                                                                                          \
    X(dnnl_primitive_destroy)

/** Pointers to the functions of oneDNN that nqm uses, under their own names. */
typedef struct nqm_onednn {
    NQM_ONEDNN_FUNCTIONS(NQM_LIBRARY_MEMBER)
} nqm_onednn;

/** The functions of oneDNN, loaded by the first call; NULL when oneDNN is not installed. Any thread. */
const nqm_onednn *nqm_onednn_get(void);

#endif
