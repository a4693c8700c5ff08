/* SPDX-License-Identifier: MIT
 *
 * embedded.h - a file embedded in the library at build time (cmake/models.cmake).
 */
#ifndef NQM_SRC_BASE_EMBEDDED_H
#define NQM_SRC_BASE_EMBEDDED_H

typedef struct nqm_embedded_file {
    const char *name;           /**< the file's name without folder and extension; NULL ends a table */
    const unsigned char *begin; /**< the whole file, 64-byte aligned */
    const unsigned char *end;
} nqm_embedded_file;

#endif
