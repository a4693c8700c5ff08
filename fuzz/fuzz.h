/* SPDX-License-Identifier: MIT
 *
 * fuzz.h - what the fuzz targets share. Each target implements LLVMFuzzerTestOneInput(), and fuzz_seed() for driver.c.
 */
#ifndef NQM_FUZZ_H
#define NQM_FUZZ_H

#include "support/brdf_files.h"

#include <stdlib.h>
#include <string.h>

/** One input. The target checks what must hold for any bytes and aborts where it does not. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes);

/** A valid input to start from. */
blob fuzz_seed(void);

/** A copy of n bytes as one. */
static inline blob blob_of(size_t n, const char *bytes) {
    blob b = {.data = malloc(n), .n_bytes = n};
    if (!b.data)
        abort();
    memcpy(b.data, bytes, n);
    return b;
}

/**
 * Open the bytes as a BRDF file and, when they are one, evaluate it all over the hemisphere: values must be finite and
 * not negative, failures must leave no object and a message.
 *
 * @param n_file  size of the file; what goes beyond n_bytes are zeros
 * @param member  what follows behind the path (":steel"), or ""
 */
void fuzz_brdf(const uint8_t *data, size_t n_bytes, size_t n_file, const char *member);

/** Read the bytes as a mesh and check what must hold of any. */
void fuzz_mesh(const uint8_t *data, size_t n_bytes);

#endif
