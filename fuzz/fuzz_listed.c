/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: CSV files of directions and values.
 */
#include "fuzz.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_brdf(data, n_bytes, n_bytes, n_bytes % 2 ? ":20" : "");
    return 0;
}

static blob make_seed(void) {
    static const char text[] =
        "# a grid of 2 x 2 x 2\ntheta_h,theta_d,phi_d,r,g,b\n0,0,0,1,.5,.25\n0,40,0,2,1,1\n20,0,0,.1,.2,.3\n"
        "20,40,0,3,2,1\n0,0,90,1,.5,.25\n0,40,90,2,1,1\n20,0,90,,,\n20,40,90,3,-2,1\n";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
