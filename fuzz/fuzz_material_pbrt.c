/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: pbrt-v4 scenes.
 */
#include "fuzz.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_material(data, n_bytes);
    return 0;
}

static blob make_seed(void) {
    static const char text[] =
        "LookAt 0 0 5 0 0 0 0 1 0 # camera\nMaterial \"conductor\" \"float roughness\" [ 0.2 ] \"rgb eta\" [ .1 "
        ".4 1.4 ] \"spectrum k\" \"metal-Au-k\"\nMakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"rgb "
        "reflectance\" [ .5 .2 .1 ]\nMaterial \"conductor\" \"rgb reflectance\" [ .9 .8 .7 ] \"float "
        "roughness\" 0.4 \"bool remaproughness\" false\nTexture \"t\" \"spectrum\" \"imagemap\" \"string filename\" "
        "\"a.png\" \"float uscale\" 2\nTexture \"m\" \"spectrum\" \"mix\" \"texture tex1\" \"t\" \"float amount\" "
        ".3\nMaterial \"diffuse\" \"texture reflectance\" \"m\" \"string normalmap\" \"n.png\"\n";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
