/* SPDX-License-Identifier: MIT
 *
 * The bound on Delta-E from ratios of samples holds for every pixel: of albedos from 1e-5 to 1, any colour, under any light, and for
 * changes in any direction, down to what is invisible.
 */
#include "metric/metric.h"
#include "percept/percept.h"
#include "render/render.h"
#include "support/check.h"

static double even_log(uint64_t i, uint64_t k, double low, double high) {
    return low * pow(high / low, nqm_random_unit(i, k));
}

TEST(no_pixel_exceeds_it) {
    static const double invisible = 0.05, peak = 1000; /* Delta-E; cd/m2 of the display */
    double largest = 0;
    size_t n_bounded = 0;
    for (uint64_t i = 0; i < 200000; ++i) {
        float f[3], g[3];
        double seen[2][3];
        const double f_all = even_log(i, 0, 1e-5, 1) / 3.14159265358979, size = even_log(i, 1, 1e-4, 0.5),
                     light = 200 * 3.14159265358979 * even_log(i, 2, 0.1, 20); /* of the standard exposure */
        const int is_grey = i % 3 == 0, is_one_way = i % 5 == 0;
        for (size_t c = 0; c < 3; ++c) {
            const double change = is_one_way ? 1 : nqm_random_unit(i, 6 + c) < 0.5 ? -1 : 1;
            f[c] = (float)(f_all * (is_grey ? 1 : even_log(i, 3 + c, 0.05, 1)));
            g[c] = (float)((double)f[c] * exp(size * change));
            seen[0][c] = fmin(light * (double)f[c], peak);
            seen[1][c] = fmin(light * (double)g[c], peak);
        }
        const double bound = nqm_delta_e_bound(1, &(nqm_sample_pair){f, g, NULL});
        const double delta_e = nqm_delta_e_itp(seen[0], seen[1]);
        if (delta_e > bound + invisible)
            fail_msg("Delta-E %g, bound %g of f %g, %g, %g and %g, %g, %g", delta_e, bound, (double)f[0], (double)f[1],
                     (double)f[2], (double)g[0], (double)g[1], (double)g[2]);
        n_bounded += isfinite(bound);
        largest = isfinite(bound) && delta_e > 1 ? fmax(largest, delta_e / bound) : largest;
    }
    assert_true(n_bounded > 190000);
    assert_true(largest > 0.9 && largest < 1); /* it is no larger than it must be */
}

/* Pairs whose score was that of a much smaller difference: the label of the first is 7.21. */
TEST(dark_pairs_are_not_bounded) {
    assert_true(isinf(nqm_delta_e_bound(
        1, &(nqm_sample_pair){(float[]){3.2e-4F, 3.2e-4F, 3.2e-4F}, (float[]){6.4e-4F, 6.4e-4F, 6.4e-4F}, NULL})));
    assert_true(isinf(
        nqm_delta_e_bound(1, &(nqm_sample_pair){(float[]){0, 0, 0}, (float[]){3.2e-4F, 3.2e-4F, 3.2e-4F}, NULL})));
    assert_true(nqm_delta_e_bound(1, &(nqm_sample_pair){(float[]){0, 0, 0}, (float[]){0, 0, 0}, NULL}) == 0);
}
