/* SPDX-License-Identifier: MIT
 *
 * models_table.h - the model files embedded into the library, generated into the build folder by cmake/models.cmake.
 */
#ifndef NQM_SRC_NET_MODELS_TABLE_H
#define NQM_SRC_NET_MODELS_TABLE_H

typedef struct nqm_embedded_model {
    const char *name;           /**< "default", "paper"; NULL ends the array */
    const unsigned char *begin; /**< a whole safetensors file, 64-byte aligned */
    const unsigned char *end;
} nqm_embedded_model;

extern const nqm_embedded_model nqm_embedded_models[];

#endif
