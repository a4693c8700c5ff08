/* SPDX-License-Identifier: MIT
 *
 * The exponential and the logarithm of float for vectorised loops, against the C library.
 */
#include "math/exp_log.h"
#include "support/check.h"

TEST(exponential_and_logarithm) {
    for (int i = -87000; i <= 87000; ++i) {
        float x = (float)i / 1000, y = nqm_exp_core(x);
        double expected = exp((double)x);
        assert_relative((double)y, expected, 3e-7);
        double log_y = log((double)y);
        assert_near((double)nqm_log_core(y), log_y, 1e-7 * fmax(1, fabs(log_y)));
    }
    assert_true(nqm_exp_core(0) == 1 && nqm_log_core(1) == 0);
}
