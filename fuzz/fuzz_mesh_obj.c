/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: OBJ meshes. The reader detects the format from the bytes, so mutations can reach other formats. See
 * fuzz_mesh().
 */
#include "fuzz.h"

#include <stdlib.h>
#include <string.h>

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_mesh(data, n_bytes);
    return 0;
}

static blob make_seed(void) {
    static const char text[] = "# seed\nv 0 0 0\nv 1 0 0 1\nv 0 1e0 -0.5\nv 1 1 0\r\nvn 0 0 1\nvn 0 1 1\nvt .5 .5\n"
                               "o it\nf 1//1 2//1 3//2\nf 1/1/1 2/1/2 4/1/2 3//-1\nf -1//-1 -2//-2 \\\n 1//1\ns off\n";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
