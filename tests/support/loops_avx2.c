/* SPDX-License-Identifier: MIT
 *
 * The loops of sample/loops.c for AVX2.
 */
#define NQM_ONE_VECTOR_WIDTH
#include "support/loops.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined __x86_64__ && !defined __clang__
#pragma GCC target("avx2")
#endif
#define WIDTH avx2
#include "support/loops_of_width.h"
