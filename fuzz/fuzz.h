/* SPDX-License-Identifier: MIT
 *
 * fuzz.h - shared by the fuzz targets, which are all in one program (driver.c). Each file fuzz_NAME.c is one target.
 */
#ifndef NQM_FUZZ_H
#define NQM_FUZZ_H

#include "support/brdf_files.h"

#include <stdlib.h>
#include <string.h>

/**
 * The target of this file.
 *
 * @param run   runs one input; it aborts when a property that must hold for any bytes is violated, and returns 0
 * @param seed  makes a valid input to start from
 */
#define FUZZ_TARGET(run, seed)                                                                                         \
    __attribute__((constructor)) static void register_target(void) {                                                   \
        fuzz_add(__FILE__, run, seed);                                                                                 \
    }
void fuzz_add(const char *file, int (*run)(const uint8_t *data, size_t n_bytes), blob (*seed)(void));

/** Abort unless a property holds. */
static inline void must(bool holds) {
    if (!holds)
        abort();
}

/** A blob with a copy of n bytes. */
static inline blob blob_of(size_t n, const char *bytes) {
    blob b = {.data = malloc(n), .n_bytes = n};
    if (!b.data)
        abort();
    memcpy(b.data, bytes, n);
    return b;
}

enum { FUZZ_PATH = 32 };
/** Write the bytes to a file in memory. Returns its descriptor, which the caller closes. */
int fuzz_file(const uint8_t *data, size_t n_bytes, char path[FUZZ_PATH]);

/**
 * Open the bytes as a BRDF file and, if that succeeds, evaluate it at directions of the whole hemisphere: values must
 * be finite and not negative; a failure must create no object and set a message.
 *
 * @param n_file  size of the file; bytes from n_bytes on are zero
 * @param member  suffix of the path (":steel"), or ""
 */
void fuzz_brdf(const uint8_t *data, size_t n_bytes, size_t n_file, const char *member);

/** Read the bytes as a material file, and check and evaluate its materials. */
void fuzz_material(const uint8_t *data, size_t n_bytes);

/** Read the bytes as a mesh and check an accepted mesh. */
void fuzz_mesh(const uint8_t *data, size_t n_bytes);

/** A copy of the bytes in which the checksum of a safetensors file is correct. */
blob fuzz_with_checksum(const uint8_t *data, size_t n_bytes);

/** Read the bytes as a picture of light. */
void fuzz_image(const uint8_t *data, size_t n_bytes);

/** Read the bytes as a picture of a map. */
void fuzz_raster(const uint8_t *data, size_t n_bytes);

/** Read the bytes as a model file, with and without its checksum, and score with an accepted model. */
void fuzz_model(const uint8_t *data, size_t n_bytes);
/** A model without a network, two scenes of few points at two directions; and a model's file, which frees it. */
struct nqm_model *fuzz_model_make(void);
blob fuzz_model_save(struct nqm_model *model);

#endif
