/* SPDX-License-Identifier: MIT
 *
 * A name that ends like a drawing, for a device that discards it: the drawing is written in place, without a temporary file.
 */
#include "fuzz.h"

#include <unistd.h>

const char *fuzz_drawing(void) {
    static const char *path;
    if (!path) {
        path = scratch_path("drawing.svg");
        if (symlink("/dev/null", path) != 0)
            abort();
    }
    return path;
}
