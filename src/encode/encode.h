/* SPDX-License-Identifier: MIT
 *
 * encode.h - the encodings that are not analytic: a network trained for one BRDF, sparse codes in a learned dictionary,
 * networks predicted by a learned hypernetwork. The room `fit` lists them as models.
 */
#ifndef NQM_SRC_ENCODE_H
#define NQM_SRC_ENCODE_H

#include "io/io.h"
#include <nqm/brdf.h>

/** What an encoder is asked for. */
typedef struct nqm_encode_options {
    size_t n_directions; /* as nqm_fit_options.n_directions */
    uint64_t seed;
    size_t n;   /* atoms of a sparse code; samples that the hypernetwork reads */
    float step; /* coefficients of the atoms, or the latent vector, are rounded to multiples of it; 0: they are not */
    const char *name;         /* name of the predicted network */
    nqm_progress_fn progress; /* NULL: silent */
    void *progress_user;
} nqm_encode_options;

/** As in nqm_fit_report. */
typedef struct nqm_encode_report {
    double loss;
    size_t n_directions, best_start, n_numbers;
} nqm_encode_report;

typedef nqm_status (*nqm_encode_fn)(const nqm_brdf *ref, const nqm_encode_options *options, nqm_encode_report *report,
                                    nqm_brdf **brdf_ret, nqm_error *err);

/** Train a network for `ref` (nbrdf_fit.c). */
NQM_MUST_CHECK nqm_status nqm_encode_nbrdf(const nqm_brdf *ref, const nqm_encode_options *options,
                                           nqm_encode_report *report, nqm_brdf **brdf_ret, nqm_error *err);
/** Train a network at n half-vector coordinates hd (n, 3) only, for so long that it overfits them. NQM_ERR_INCOMPATIBLE: no
 *  direction has a value. */
NQM_MUST_CHECK nqm_status nqm_encode_nbrdf_at(const nqm_brdf *ref, size_t n, const double *hd, uint64_t seed,
                                              nqm_brdf **brdf_ret, nqm_error *err);
/** Compute a sparse code of `ref` in the embedded dictionary (sparse.c). */
NQM_MUST_CHECK nqm_status nqm_encode_sparse(const nqm_brdf *ref, const nqm_encode_options *options,
                                            nqm_encode_report *report, nqm_brdf **brdf_ret, nqm_error *err);
/** Predict a network for `ref` by the embedded hypernetwork (hyper.c). */
NQM_MUST_CHECK nqm_status nqm_encode_hyper(const nqm_brdf *ref, const nqm_encode_options *options,
                                           nqm_encode_report *report, nqm_brdf **brdf_ret, nqm_error *err);

/** Draw a direction pair uniform by solid angle, both polar angles at most max_polar. */
void nqm_encode_draw_uniform(nqm_rng *rng, double max_polar, double *wi, double *wo);
/** Draw half-vector coordinates hd (3): theta_h = max_theta u^2 with uniform u, as in MERL's tables; theta_d uniform up to
 *  max_theta, phi_d up to max_phi; both polar angles at most max_polar. */
void nqm_encode_draw_dense(nqm_rng *rng, double max_polar, double max_theta, double max_phi, double *hd);

/** Move the rows of hd and rgb (n, 3) that have a value to the front; returns their number. */
size_t nqm_encode_keep_valid(size_t n, const uint8_t *flag, double *hd, double *rgb);
enum { NQM_ENCODE_MAX_TRIES = 16 };
/** Draw directions until n of them have a value: hd, rgb (n, 3); returns fewer than n if hardly one in NQM_ENCODE_MAX_TRIES has. */
size_t nqm_encode_sample(const nqm_brdf *ref, size_t n, void (*draw)(nqm_rng *rng, double *hd), nqm_rng *rng,
                         double *hd, double *rgb);

/* ---- files of learned encoders (doc/files.md), which studies/learn.py writes ------------------------------------- */

/** The files of models/encoders. */
extern const nqm_embedded_file nqm_embedded_encoders[];

/** The bytes of an embedded encoder file ("sparse", "hyper"; models/encoders/NAME.safetensors); NULL when this build has
 *  none. */
const unsigned char *nqm_encoder_bytes(const char *name, size_t *n_bytes_ret);

/** Parse an encoder file; NQM_ERR_MODEL if data is NULL (nqm_encoder_bytes() found none), and unless it is of this kind,
 *  its checksum is correct and all values are finite. `name` is for messages. Free with nqm_safetensors_free(). */
NQM_MUST_CHECK nqm_status nqm_encoder_parse(const unsigned char *data, size_t n_bytes, const char *name,
                                            const char *kind, nqm_safetensors **st_ret, nqm_error *err);

#endif
