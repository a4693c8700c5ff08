/* SPDX-License-Identifier: MIT
 *
 * inference_work.h - the memory of rows on their way through a packed network, for the files that run it.
 */
#ifndef NQM_SRC_NET_INFERENCE_WORK_H
#define NQM_SRC_NET_INFERENCE_WORK_H

#include "net/inference_net.h"

struct nqm_inference_work {
    const nqm_inference_net *net;
    bool packed;                               /* the panels of floats are filled; of this call */
    size_t n_rows;                             /* of this call */
    size_t _Atomic taken;                      /* of them, by threads that go alone */
    size_t max_batch, n_multiplications;       /* the latter of a row */
    size_t n_slots;                            /* for max_batch rows, or one and a copy for each thread */
    size_t stride, rounded_stride, ref_stride; /* numbers from row to row */
    float *y[2];                               /* (n_slots, stride) of the layers in turn */
    uint32_t *rounded;                         /* (n_slots, rounded_stride) a layer's inputs as units */
    nqm_byte_scale *scale;                     /* (NQM_MAX_SEGMENTS, n_slots) what bytes stand for */
    float *difference;                         /* (n_slots, inputs of a reference) where the first layer wants it */
    /* References of this call: row i belongs to reference ref_of[i]; reference 0 is the last one of the call before. */
    size_t n_refs;              /* without that one */
    bool own_refs;              /* each row has one of its own: it is a segment as the others are */
    size_t *ref_of;             /* (max_batch) */
    uint8_t *begins;            /* (max_batch) whether a row's reference is another than that of the row before */
    uint32_t *ref;              /* (max_batch, ref_stride) inputs of references 1.. as units */
    nqm_byte_scale *ref_scale;  /* (max_batch) */
    float *part;                /* (1 + max_batch, stride) what references add to the first layer */
    float *kept;                /* (inputs of a reference) those of reference 0 */
    const nqm_kernels *kept_by; /* that computed its part; NULL: there is none */
};

#endif
