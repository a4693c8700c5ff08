/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: PLY meshes. The reader detects the format from the bytes, so mutations can reach other formats. See
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
    static const char text[] = "ply\nformat binary_little_endian 1.0\ncomment x\nelement vertex 4\nproperty float x\n"
                               "property float y\nproperty float z\nproperty uchar red\nelement face 2\n"
                               "property list uchar int vertex_indices\nproperty list uchar short more\nend_header\n"
                               "\0\0\0\0\0\0\0\0\0\0\0\0a\0\0\x80?\0\0\0\0\0\0\0\0b\0\0\0\0\0\0\x80?\0\0\0\0c"
                               "\0\0\0\0\0\0\0\0\0\0\x80?d"
                               "\3\0\0\0\0\1\0\0\0\2\0\0\0\0"
                               "\4\0\0\0\0\1\0\0\0\2\0\0\0\3\0\0\0\2\1\2\3\4";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
