/* SPDX-License-Identifier: MIT
 *
 * embedded.h - files embedded in the library at build time (cmake/models.cmake).
 */
#ifndef NQM_SRC_BASE_EMBEDDED_H
#define NQM_SRC_BASE_EMBEDDED_H

typedef struct nqm_embedded_file {
    const char *name;           /**< the file's name without folder and extension; NULL ends a table */
    const unsigned char *begin; /**< the whole file, 64-byte aligned */
    const unsigned char *end;
} nqm_embedded_file;

/** "default" in libnqm, "default" and "paper" in libnqm-full and the tool. */
extern const nqm_embedded_file nqm_embedded_models[];

#endif
