/* SPDX-License-Identifier: MIT
 *
 * amx_emulated.h - Intel's tile registers (AMX) in plain C, one set for each thread: what the instructions do by the Software
 * Developer's Manual, volume 2, for palette 1. What would be an exception of the processor ends the program with a message.
 */
#ifndef NQM_TESTS_AMX_EMULATED_H
#define NQM_TESTS_AMX_EMULATED_H

#include <stddef.h>

/** LDTILECFG and STTILECFG; 64 bytes: the palette, the first row, 14 reserved, (16) uint16_t bytes of a row, (16) uint8_t rows. */
void amx_configure(const void *from);
void amx_configuration(void *to);
void amx_zero(size_t t);
/** Rows of tile register t from and to memory, `step` bytes from row to row. */
void amx_load(size_t t, const void *from, size_t step);
void amx_store(size_t t, void *to, size_t step);
/** TDPBF16PS: c += a b of bfloat16. */
void amx_bf16(size_t c, size_t a, size_t b);
/** TDPBUSD: c += a b of unsigned and signed bytes. */
void amx_int8(size_t c, size_t a, size_t b);

#endif
