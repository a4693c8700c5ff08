/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: BSDF tables of Zemax.
 */
#include "fuzz.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_brdf(data, n_bytes, n_bytes, n_bytes % 2 ? ":20" : "");
    return 0;
}

static blob make_seed(void) {
    static const char text[] =
        "#x\nSource Measured\nSymmetry PlaneSymmetrical\nSpectralContent Monochrome\nScatterType BRDF\n"
        "SampleRotation 1\n0\nAngleOfIncidence 2\n0 30\nScatterAzimuth 5\n0 45 90 135 180\n"
        "ScatterRadial 2\n0 20\nMonochrome\nDataBegin\nTIS .5\n1 2\n1 2\n1 2\n1 2\n1 2\nTIS .5\n3 4\n3 4\n"
        "3 4\n3 4\n3 4\nDataEnd\n";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
