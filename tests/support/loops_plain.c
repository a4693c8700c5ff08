/* SPDX-License-Identifier: MIT
 *
 * The loops of sample/loops.c without a choice: vectors of 16 bytes.
 */
#define NQM_ONE_VECTOR_WIDTH
#include "support/loops.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#define WIDTH plain
#include "support/loops_of_width.h"
