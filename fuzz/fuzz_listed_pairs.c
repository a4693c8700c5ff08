/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: CSV files of light, viewer and values, which may be anisotropic.
 */
#include "fuzz.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_brdf(data, n_bytes, n_bytes, n_bytes % 2 ? ":20" : "");
    return 0;
}

static blob make_seed(void) {
    static const char text[] =
        "theta_i,phi_i,theta_o,phi_o,r,g,b\n20,0,40,180,1,1,1\n20,90,40,270,2,1,1\n20,-90,40,90,,,\n"
        "20,180,40,360,3,2,1\n0,0,40,0,1,1,1\n0,90,40,0,2,2,2\n20,0,40,90,1,1,1\n";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
