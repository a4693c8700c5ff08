/* SPDX-License-Identifier: MIT
 *
 * model_file.h - names used by both the reader and the writer of model files. doc/files.md describes the format.
 */
#ifndef NQM_SRC_MODEL_FILE_H
#define NQM_SRC_MODEL_FILE_H

#define NQM_MODEL_FORMAT "nqm-model"
#define NQM_MODEL_SCHEMA "1"

enum { NQM_LAYER_TENSORS = 4, NQM_LAYOUT_COUNT = 2, NQM_TARGET_COUNT = 2, NQM_TENSOR_NAME_MAX = 32 };
/** Suffixes of tensor names "layers.N.SUFFIX", in the order of nqm_layer: w, b, gamma, beta; the last layer has only
 *  the first two. */
extern const char *const nqm_layer_suffixes[NQM_LAYER_TENSORS];
/** Names of nqm_layout and nqm_target in the metadata, indexed by value. */
extern const char *const nqm_layout_names[NQM_LAYOUT_COUNT];
extern const char *const nqm_target_names[NQM_TARGET_COUNT];

#endif
