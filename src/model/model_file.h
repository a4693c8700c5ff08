/* SPDX-License-Identifier: MIT
 *
 * model_file.h - what a model file contains, for its reader, its writer and copies of models; doc/model-format.md has the format.
 */
#ifndef NQM_SRC_MODEL_FILE_H
#define NQM_SRC_MODEL_FILE_H

#include "io/io.h"
#include "model/model.h"

#define NQM_MODEL_FORMAT "nqm-model"
#define NQM_MODEL_SCHEMA "1"

enum { NQM_LAYER_TENSORS = 4, NQM_MODEL_TEXTS = 11, NQM_MODEL_ARRAYS = 21, NQM_TENSOR_NAME_MAX = 32 };
/** Suffixes of tensor names "layers.N.SUFFIX", in the order of nqm_layer: w, b, gamma, beta; the last layer has only
 *  the first two. */
extern const char *const nqm_layer_suffixes[NQM_LAYER_TENSORS];

/** Parts of a model that not every file has. */
typedef enum nqm_model_part {
    NQM_PART_ALWAYS,
    NQM_PART_GOLDEN,
    NQM_PART_SCALARS,
    NQM_PART_INTERVAL,
    NQM_PART_NOVELTY,
    NQM_PART_LABEL,
    NQM_PART_TRANSPORT,
    NQM_PART_SLOPES,
    NQM_PART_SPREAD,
    NQM_PART_SIMILARITY,
    NQM_PART_COUNT
} nqm_model_part;

/** A member of struct nqm_model that is stored in the metadata: a string, or an enum with a word for each value. */
typedef struct nqm_model_text {
    const char *key;
    nqm_model_part part;
    size_t offset;
    const char *const *words; /* NULL-terminated; NULL: the member is an owned string */
} nqm_model_text;
extern const nqm_model_text nqm_model_texts[NQM_MODEL_TEXTS];

/** Members of struct nqm_model that are stored as one tensor each; the network and the directions are not among them. */
typedef struct nqm_model_array {
    const char *name;
    nqm_model_part part;
    nqm_dtype dtype;
    size_t rows, cols; /* as nqm_model_extent() takes them; rows 0: a vector of length `cols` */
    size_t offset;     /* position of the first value */
    size_t
        n_offset; /* if it is not 0, the values are in an owned block, whose address is at `offset`, and the number of
                          rows (a size_t) is at n_offset */
} nqm_model_array;
extern const nqm_model_array nqm_model_arrays[NQM_MODEL_ARRAYS];

/** The address of a member. */
static inline void *nqm_model_at(const nqm_model *model, size_t offset) {
    return (char *)(uintptr_t)model + offset;
}
/** A member that is a pointer: to a string or to an owned block. */
static inline void **nqm_model_block(const nqm_model *model, size_t offset) {
    return nqm_model_at(model, offset);
}
/** Rows or columns that depend on the model: three for each point of its transport matrix, one or NQM_NOVELTY_BLOCK for each scalar
 *  feature. */
#define NQM_EXTENT_POINTS  SIZE_MAX
#define NQM_EXTENT_SCALARS (SIZE_MAX - 1)
#define NQM_EXTENT_BLOCKS  (SIZE_MAX - 2)
#define NQM_EXTENT_SLOPES  (SIZE_MAX - 3) /* three for each point of `slopes` */
static inline size_t nqm_model_extent(const nqm_model *model, size_t extent) {
    return extent == NQM_EXTENT_POINTS    ? 3 * model->n_points
           : extent == NQM_EXTENT_SLOPES  ? 3 * model->n_slope_points
           : extent == NQM_EXTENT_SCALARS ? model->scalars.n
           : extent == NQM_EXTENT_BLOCKS  ? model->scalars.n * NQM_NOVELTY_BLOCK
                                          : extent;
}
/** The number of rows of an array; 0: a vector. */
static inline size_t nqm_model_rows(const nqm_model *model, const nqm_model_array *array) {
    return array->n_offset ? *(const size_t *)nqm_model_at(model, array->n_offset)
                           : nqm_model_extent(model, array->rows);
}

#endif
