/* SPDX-License-Identifier: MIT
 *
 * nqm/encode.h - learn what nqm_fit() (nqm/fit.h) encodes with: the dictionary of sparse codes, or the hypernetwork. In
 * libnqm-full only. The functions may be called from several threads.
 */
#ifndef NQM_ENCODE_H
#define NQM_ENCODE_H

#include <nqm/brdf.h>

#ifdef __cplusplus
extern "C" {
#endif

/** What can be learned from a set of BRDFs. The library embeds one of each, learned from training materials only. */
typedef enum nqm_encoder {
    NQM_ENCODER_SPARSE = 0, /**< the dictionary of "sparse-*" */
    NQM_ENCODER_HYPER       /**< the hypernetwork of "hyper-*" */
} nqm_encoder;

typedef struct nqm_learn_options {
    size_t n_steps; /**< steps of the optimiser; 0 (default): 40 for the dictionary, 16000 for the hypernetwork */
    uint64_t seed;  /**< default 1 */
    nqm_progress_fn progress; /**< NULL: silent */
    void *progress_user;
} nqm_learn_options;

/** The defaults above. */
NQM_API nqm_learn_options nqm_learn_options_default(void);

/**
 * Learn an encoder from BRDFs and write it as a safetensors file. Deterministic: the same bytes for any number of threads.
 *
 * @param n      number of BRDFs
 * @param refs   (n)
 * @param names  (n) UTF-8, stored in the file's metadata "references" (a JSON list): the record of what it has been learned
 *               from
 * @return NQM_ERR_ARG (n = 0, a name is not UTF-8), NQM_ERR_INCOMPATIBLE (a BRDF has too few values), NQM_ERR_NUMERIC,
 *         NQM_ERR_CANCELLED, NQM_ERR_IO, NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_learn(nqm_encoder what, size_t n, const nqm_brdf *const *refs,
                                            const char *const *names, const nqm_learn_options *options,
                                            const char *path, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
