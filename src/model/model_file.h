/* SPDX-License-Identifier: MIT
 *
 * model_file.h - what reader and writer of model files share: names, and values in 16 bits (IEEE 754 binary16: 11 bits of
 * precision). doc/files.md describes the file.
 */
#ifndef NQM_SRC_MODEL_FILE_H
#define NQM_SRC_MODEL_FILE_H

#include <stddef.h>
#include <stdint.h>

#define NQM_MODEL_FORMAT "nqm-model"
#define NQM_MODEL_SCHEMA "1"

enum { NQM_LAYER_TENSORS = 4, NQM_LAYOUT_COUNT = 2, NQM_TARGET_COUNT = 2, NQM_TENSOR_NAME_MAX = 32 };
/** "layers.N.SUFFIX", in the order of nqm_layer: w, b, gamma, beta; the last layer has the first two only. */
extern const char *const nqm_layer_suffixes[NQM_LAYER_TENSORS];
/** Names of nqm_layout and nqm_target in the metadata, by value. */
extern const char *const nqm_layout_names[NQM_LAYOUT_COUNT];
extern const char *const nqm_target_names[NQM_TARGET_COUNT];

/** n finite binary16 values at any address to floats, exactly. */
void nqm_half_to_float(size_t n, const void *half, float *x);
/** n finite floats to binary16, to nearest, ties to even; magnitudes from 65520 on become infinite. */
void nqm_half_from_float(size_t n, const float *x, uint16_t *half);

#endif
