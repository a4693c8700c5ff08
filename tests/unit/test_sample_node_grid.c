/* SPDX-License-Identifier: MIT
 *
 * The grid of sampling directions: lobes of any width have the right energy from the samples alone, smooth BRDFs are interpolated
 * between the nodes, both orders of light and viewer are in the set, and reciprocal BRDFs have equal samples in both.
 */
#include "brdf/brdf.h"
#include "math/math.h"
#include "sample/node_grid.h"
#include "support/check.h"

static nqm_node_grid grid;
static nqm_directions *directions;

static int make_grid(void **state) {
    (void)state;
    grid = nqm_node_grid_make();
    assert_int_equal(nqm_node_grid_directions(&directions, NULL), NQM_OK);
    assert_int_equal(nqm_directions_get_info(directions).n, grid.n);
    return 0;
}

static int drop_grid(void **state) {
    (void)state;
    nqm_directions_free(directions);
    return 0;
}

static float *sample(const char *spec) {
    nqm_brdf *brdf;
    float *rgb = nqm_alloc(nqm_directions_get_info(directions).n, 3 * sizeof *rgb);
    assert_non_null(rgb);
    assert_int_equal(nqm_brdf_open(spec, &brdf, NULL), NQM_OK);
    assert_int_equal(nqm_sample(brdf, directions, NQM_INVALID_ZERO, rgb, NULL, NULL, NULL), NQM_OK);
    nqm_brdf_free(brdf);
    return rgb;
}

static double interpolate(const float *rgb, const double *hd) {
    size_t node[NQM_GRID_NEAR];
    double weight[NQM_GRID_NEAR], sum = 0, wi[3], wo[3];
    nqm_half_diff_to_pair(hd, wi, wo);
    nqm_node_grid_interpolate(&grid, wi, wo, node, weight);
    for (size_t i = 0; i < NQM_GRID_NEAR; ++i)
        sum += weight[i] * (double)rgb[3 * node[i]];
    return sum;
}

/* A lobe at a node or a direction: GGX's distribution, or a BRDF. */
typedef struct lobe {
    double alpha;
    const nqm_brdf *brdf; /* NULL: the distribution */
    const float *rgb;     /* samples; NULL: exact values */
} lobe;

static double distribution(double alpha, double theta_h) {
    const double x = tan(theta_h) / alpha, c2 = pow(cos(theta_h), 2);
    return 1 / (NQM_PI * alpha * alpha * c2 * c2 * pow(1 + x * x, 2));
}

static double value_at(const lobe *l, const double *hd) {
    double value[3] = {distribution(l->alpha, hd[0])};
    if (l->brdf)
        nqm_brdf_eval_half_diff(l->brdf, 1, hd, value, NULL);
    return l->rgb ? interpolate(l->rgb, hd) : value[0];
}

/* The light of a lobe: its integral over theta_h at the theta_d and phi_d given, up to 1 radian. */
static double energy(const lobe *l, double theta_d, double phi_d) {
    enum { STEPS = 1000 };
    const double low = log(1e-6), step = (log(1.0) - low) / STEPS;
    double sum = 0;
    for (size_t i = 0; i < STEPS; ++i) {
        const double hd[3] = {exp(low + ((double)i + 0.5) * step), theta_d, phi_d};
        sum += value_at(l, hd) * sin(hd[0]) * hd[0] * step;
    }
    return sum;
}

static void check_energy(lobe exact, const float *rgb, double tolerance) {
    static const double angles[] = {0.1, 0.4, 0.7};
    lobe sampled = exact;
    sampled.rgb = rgb;
    for (size_t i = 0; i < sizeof angles / sizeof *angles; ++i)
        assert_relative(energy(&sampled, angles[i], 1), energy(&exact, angles[i], 1), tolerance);
}

TEST(energy_of_lobes) {
    float *rgb = nqm_alloc(directions->n, 3 * sizeof *rgb);
    assert_non_null(rgb);
    for (double alpha = 0.0001; alpha < 1; alpha *= 1.4) {
        for (size_t i = 0; i < directions->n; ++i)
            rgb[3 * i] = (float)distribution(alpha, directions->degrees[3 * i] * NQM_PI / 180);
        check_energy((lobe){.alpha = alpha}, rgb, 0.01);
    }
    nqm_free(rgb);
    for (double alpha = 0.001; alpha < 0.6; alpha *= 1.6) { /* with Fresnel term, shadowing and cosines */
        char spec[64];
        snprintf(spec, sizeof spec, "ggx:ks=1,1,1;alpha=%.6g;f0=1", alpha);
        float *samples = sample(spec);
        lobe exact = {.alpha = alpha};
        nqm_brdf *brdf;
        assert_int_equal(nqm_brdf_open(spec, &brdf, NULL), NQM_OK);
        exact.brdf = brdf;
        check_energy(exact, samples, 0.03);
        nqm_brdf_free(brdf);
        nqm_free(samples);
    }
}

TEST(smooth_brdfs_are_interpolated) {
    static const char *const specs[] = {"lambert:kd=.5", "ggx:kd=.1;ks=.5;alpha=.3;f0=.04"};
    for (size_t s = 0; s < sizeof specs / sizeof *specs; ++s) {
        float *rgb = sample(specs[s]);
        nqm_brdf *brdf;
        assert_int_equal(nqm_brdf_open(specs[s], &brdf, NULL), NQM_OK);
        for (size_t i = 0; i < 500; ++i) {
            const double hd[3] = {0.9 * nqm_radical_inverse(i, 2), 0.7 * nqm_radical_inverse(i, 3),
                                  6.2 * nqm_radical_inverse(i, 5)};
            double value[3];
            nqm_brdf_eval_half_diff(brdf, 1, hd, value, NULL);
            if (value[0] > 0)
                assert_relative(interpolate(rgb, hd), value[0], 0.05);
        }
        nqm_brdf_free(brdf);
        nqm_free(rgb);
    }
}

TEST(both_orders) {
    float *rgb = sample("sgd:nickel");
    size_t n_twins = 0;
    for (size_t i = 0; i < directions->n; ++i) {
        const size_t j = directions->twin[i];
        n_twins += j != i;
        assert_memory_equal(rgb + 3 * i, rgb + 3 * j, 3 * sizeof *rgb);
        for (size_t k = 0; k < 3 && j != i; ++k) {
            assert_near(directions->wi[3 * i + k], directions->wo[3 * j + k], 1e-9);
            assert_near(directions->wo[3 * i + k], directions->wi[3 * j + k], 1e-9);
        }
    }
    assert_int_equal(2 * n_twins, directions->n);
    nqm_free(rgb);
}

TEST(a_list_is_recognised) {
    nqm_directions *other;
    bool is_grid = false;
    assert_int_equal(nqm_node_grid_check(directions, &is_grid, NULL), NQM_OK);
    assert_true(is_grid);
    assert_int_equal(nqm_directions_create(NULL, 0, NULL, &other, NULL), NQM_OK);
    assert_int_equal(nqm_node_grid_check(other, &is_grid, NULL), NQM_OK);
    assert_false(is_grid);
    nqm_directions_free(other);
}

TEST_FILE(make_grid, drop_grid)
