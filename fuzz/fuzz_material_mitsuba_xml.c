/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: Mitsuba scenes in XML.
 */
#include "fuzz.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_material(data, n_bytes);
    return 0;
}

static blob make_seed(void) {
    static const char text[] =
        "<scene version=\"3.0.0\"><default name=\"a\" value=\".1\"/><bsdf type=\"twosided\" id=\"x\">"
        "<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"$a\"/><string name=\"material\" "
        "value=\"Au\"/><string name=\"distribution\" value=\"ggx\"/></bsdf></bsdf><texture type=\"bitmap\" "
        "id=\"t\"><string name=\"filename\" value=\"a\"/><transform name=\"to_uv\"><rotate z=\"1\" "
        "angle=\"9\"/></transform></texture><bsdf type=\"normalmap\"><ref name=\"normalmap\" id=\"t\"/><bsdf "
        "type=\"diffuse\"><ref name=\"reflectance\" id=\"t\"/></bsdf></bsdf></scene>";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
