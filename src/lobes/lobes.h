/* SPDX-License-Identifier: MIT
 *
 * lobes.h - small pictures of BRDFs of any shape, evaluated at half vectors that are placed by their lobes: for anisotropic BRDFs and
 * means of tilted ones.
 */
#ifndef NQM_SRC_LOBES_LOBES_H
#define NQM_SRC_LOBES_LOBES_H

#include "argument/argument.h"
#include "brdf/brdf.h"
#include "sample/slopes.h"

/** A BRDF, and its light at the points of a picture. */
typedef struct nqm_lobe_picture {
    const nqm_subject *subject; /* it is opened meanwhile; NULL: `brdf` is given */
    const nqm_brdf *brdf;
    size_t ref;    /* the picture with which it is compared: both have the same half vectors if their lobes are alike;
                          SIZE_MAX: none */
    double *light; /* (3, n) receives cd/m2 */
    nqm_status status; /* receives the status of nqm_brdf_open(), or NQM_ERR_NOMEM */
    nqm_brdf *opened;  /* workspace, like */
    nqm_lobe lobe;     /* this */
} nqm_lobe_picture;
/** Make n pictures on all threads. ticker: NULL, or its stage is "far". NQM_ERR_NOMEM, NQM_ERR_CANCELLED. */
NQM_MUST_CHECK nqm_status nqm_lobes_pictures(const nqm_slope_light *light, size_t n, nqm_lobe_picture *pictures,
                                             nqm_ticker *ticker, nqm_error *err);

#endif
