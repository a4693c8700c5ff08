/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: Mitsuba scenes in XML.
 */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    fuzz_material(data, n_bytes);
    return 0;
}

blob fuzz_seed(void) {
    static const char text[] =
        "<scene version=\"3.0.0\"><default name=\"a\" value=\".1\"/><bsdf type=\"twosided\" id=\"x\">"
        "<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"$a\"/><string name=\"material\" "
        "value=\"Au\"/><string name=\"distribution\" value=\"ggx\"/></bsdf></bsdf></scene>";
    return blob_of(sizeof text - 1, text);
}
