/* SPDX-License-Identifier: MIT
 *
 * Derivatives of the PQ signal, of ITP, of the JOD curve and of labels of pictures: against central differences in double, and
 * the stated values where there is no derivative.
 */
#include "math/math.h"
#include "percept/percept.h"
#include "support/central.h"
#include "support/check.h"

TEST(pq) {
    for (double at = 0x1p-29; at < 9990; at *= 1.7) {
        double expected;
        CENTRAL_DIFFERENCE(expected, at, 1e-3 * at, nqm_pq_from_luminance(at));
        assert_relative(nqm_pq_slope(at), expected, 1e-8);
    }
    assert_true(nqm_pq_slope(10000) == 0 && nqm_pq_slope(1e9) == 0);
    assert_true(nqm_pq_slope(0) == nqm_pq_slope(0x1p-30) && isfinite(nqm_pq_slope(0)) && nqm_pq_slope(0) > 0);
}

/* The pieces of the interpolation follow the function, and meet. */
TEST(interpolated_pq) {
    double slope;
    for (double at = 0x1p-30; at < 9990; at *= 1.00371) {
        assert_relative(nqm_pq_interpolate(at, &slope), nqm_pq_from_luminance(at), 1e-9);
        assert_relative(slope, nqm_pq_slope(at), 1e-6);
    }
    for (double at = 0x1p-20; at < 8192; at *= 2)
        assert_relative(nqm_pq_interpolate(at * (1 - 1e-12), &slope), nqm_pq_interpolate(at, &slope), 1e-11);
    assert_true(nqm_pq_interpolate(0, &slope) == nqm_pq_from_luminance(0) && slope == nqm_pq_slope(0));
    assert_true(nqm_pq_interpolate(20000, &slope) == nqm_pq_from_luminance(20000) && slope == 0);
}

TEST(rgb) {
    static const double colours[][3] = {
        {100, 50, 20}, {0.01, 3, 700}, {1e-5, 2e-5, 1e-5}, {9000, 10, 9500}, {0.5, 0.5, 0.5}};
    static const double weights[][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-3, 0.5, 2}};
    for (size_t c = 0; c < 5; ++c)
        for (size_t w = 0; w < 4; ++w) {
            double by_rgb[3], expected[3], rounding[3], largest = 0;
            nqm_rgb_gradient(colours[c], weights[w], by_rgb);
            for (int k = 0; k < 3; ++k) {
                double at[3], itp[3];
                const double h = 1e-3 * colours[c][k];
                memcpy(at, colours[c], sizeof at);
                CENTRAL_DIFFERENCE(expected[k], at[k], h, (nqm_itp_from_rgb(at, itp), nqm_dot3(itp, weights[w])));
                rounding[k] = 1e-13 / h; /* PQ has a power of 79 */
                largest = fmax(largest, fabs(expected[k]));
            }
            for (int k = 0; k < 3; ++k)
                assert_near(by_rgb[k], expected[k], 3e-8 * largest + rounding[k]);
        }
}

/* Channels outside the range have no influence; the others keep theirs. */
TEST(clamped_rgb) {
    static const double clamped[] = {-1, 10000, 12000};
    const double by_itp[3] = {1, -2, 0.5};
    for (size_t i = 0; i < 3; ++i) {
        const double colour[3] = {50, clamped[i], 20}, edge[3] = {50, fmin(fmax(clamped[i], 0), 9999.999999), 20};
        double by_rgb[3], by_edge[3];
        nqm_rgb_gradient(colour, by_itp, by_rgb);
        nqm_rgb_gradient(edge, by_itp, by_edge);
        assert_true(by_rgb[1] == 0 && by_edge[1] != 0);
        assert_relative(by_rgb[0], by_edge[0], 1e-6);
        assert_relative(by_rgb[2], by_edge[2], 1e-6);
    }
    const double black[3] = {0, 0, 0};
    double by_rgb[3];
    nqm_rgb_gradient(black, by_itp, by_rgb);
    for (int k = 0; k < 3; ++k)
        assert_true(isfinite(by_rgb[k]) && by_rgb[k] != 0);
}

TEST(curve) {
    static const nqm_curve other = {-9, -0.3, -0.4};
    const nqm_curve *const curves[] = {&nqm_curve_published, &other};
    for (size_t c = 0; c < 2; ++c) {
        for (double at = 0.01; at < 2000; at *= 1.5) {
            const double h = 1e-3 * at;
            double expected;
            CENTRAL_DIFFERENCE(expected, at, h, nqm_curve_jod(curves[c], at));
            assert_near(nqm_curve_slope(curves[c], at), expected, 1e-8 * fabs(expected) + 1e-13 / h);
        }
        assert_true(nqm_curve_slope(curves[c], 0) == 0 && nqm_curve_slope(curves[c], -1) == 0);
        assert_true(isfinite(nqm_curve_slope(curves[c], 1e-300)));
    }
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

enum { POINTS = 40 };

typedef struct pictures {
    double weight[POINTS], ref[POINTS][3], test[POINTS][3];
} pictures;

static pictures make_pictures(double difference) {
    pictures p;
    double sum = 0;
    for (size_t i = 0; i < POINTS; ++i) {
        sum += p.weight[i] = 1 + sin((double)i);
        for (size_t k = 0; k < 3; ++k) {
            p.ref[i][k] = 100 * sin((double)(3 * i + k));
            p.test[i][k] = p.ref[i][k] + difference * (1 + cos((double)(7 * i + 2 * k)));
        }
    }
    for (size_t i = 0; i < POINTS; ++i)
        p.weight[i] /= sum;
    return p;
}

static nqm_picture_sums sums_of(const pictures *p) {
    nqm_picture_sums sums = {0};
    for (size_t i = 0; i < POINTS; ++i)
        nqm_picture_sums_add(&sums, p->weight[i], p->ref[i], p->test[i]);
    return sums;
}

static double weighted_label(const pictures *p, const nqm_label *weights) {
    const nqm_picture_sums sums = sums_of(p);
    const nqm_label label = nqm_picture_sums_label(&sums);
    return weights->delta_e * label.delta_e + nqm_dot3(weights->shift, label.shift) +
           weights->contrast * label.contrast + weights->structure * label.structure;
}

static void check_picture_gradient(pictures *p, const nqm_label *weights) {
    const nqm_picture_sums sums = sums_of(p);
    double largest = 0, gradient[POINTS][3], expected[POINTS][3];
    for (size_t i = 0; i < POINTS; ++i) {
        nqm_picture_gradient(&sums, weights, p->weight[i], p->ref[i], p->test[i], gradient[i]);
        for (size_t k = 0; k < 3; ++k) {
            CENTRAL_DIFFERENCE(expected[i][k], p->test[i][k], 1e-3, weighted_label(p, weights));
            largest = fmax(largest, fabs(expected[i][k]));
        }
    }
    for (size_t i = 0; i < POINTS; ++i)
        for (size_t k = 0; k < 3; ++k)
            assert_near(gradient[i][k], expected[i][k], 1e-8 * largest);
}

TEST(picture_gradients) {
    static const nqm_label weights[] = {{.delta_e = 1},  {.shift = {1, 0, 0}}, {.shift = {0, -1, 2}},
                                        {.contrast = 1}, {.structure = 1},     {1, {0.5, -2, 0.3}, 7, -1, 0}};
    for (size_t w = 0; w < 6; ++w)
        for (double difference = 1; difference < 200; difference *= 12) {
            pictures p = make_pictures(difference);
            check_picture_gradient(&p, &weights[w]);
        }
}

/* Equal pictures, pictures that differ by a shift, and a test of one value: the roots without a derivative add 0. */
TEST(roots_of_zero) {
    static const nqm_label all = {1, {0, 0, 0}, 1, 1, 0}, shift = {.shift = {1, 2, 3}};
    pictures p = make_pictures(0);
    double gradient[3];
    for (size_t i = 0; i < POINTS; ++i)
        memset(p.test[i], 0, sizeof p.test[i]);
    memcpy(p.ref, p.test, sizeof p.ref);
    nqm_picture_sums sums = sums_of(&p);
    nqm_picture_gradient(&sums, &all, 0.5, p.ref[3], p.test[3], gradient);
    assert_true(gradient[0] == 0 && gradient[1] == 0 && gradient[2] == 0);
    nqm_picture_gradient(&sums, &shift, 0.5, p.ref[3], p.test[3], gradient);
    assert_true(gradient[0] == 0.5 && gradient[1] == 1 && gradient[2] == 1.5);
    for (size_t i = 0; i < POINTS; ++i)
        p.test[i][0] = 4;
    sums = sums_of(&p);
    nqm_picture_gradient(&sums, &(nqm_label){.delta_e = 1}, 1, p.ref[0], p.test[0], gradient);
    assert_true(gradient[0] == 1 && gradient[1] == 0 && gradient[2] == 0);
}
