/* SPDX-License-Identifier: MIT
 *
 * Tables over half-vector coordinates: values at nodes, linear interpolation, periodic phi_d, missing values, limits, phi_h.
 */
#include "brdf/brdf.h"
#include "math/math.h"
#include "support/brdf_files.h"
#include "support/check.h"

#include <nqm/brdf.h>

enum { H = 9, D = 7, P = 6, N = H * D * P };

static void node_numbers(size_t i, size_t *h, size_t *d, size_t *p) {
    *h = i / (D * P);
    *d = i / P % D;
    *p = i % P;
}

static nqm_brdf *make_table(const float *rgb) {
    nqm_brdf *brdf;
    assert_int_equal(nqm_table_create((nqm_table_size){H, D, P, 1}, rgb, "table", &brdf, NULL), NQM_OK);
    return brdf;
}

/* Call the class's function directly, which does not test for the horizon. */
static void raw(const nqm_brdf *brdf, double theta_h, double theta_d, double phi_d, double *rgb) {
    brdf->class_->eval_turned(brdf->self, 1, (double[3]){theta_h, theta_d, phi_d}, NULL, rgb);
}

TEST(nodes_keep_their_values) {
    float values[3 * N];
    for (uint32_t i = 0; i < 3 * N; ++i)
        values[i] = (float)noise(i, 1);
    nqm_brdf *brdf = make_table(values);
    for (size_t i = 0; i < N; ++i) {
        size_t h, d, p;
        double hd[3], rgb[3];
        node_numbers(i, &h, &d, &p);
        nqm_table_node(H, D, P, h, d, p, hd);
        assert_near(hd[0], NQM_PI / 2 * (double)(h * h) / ((H - 1) * (H - 1)), 1e-14);
        assert_near(hd[1], NQM_PI / 2 * (double)d / (D - 1), 1e-14);
        assert_near(hd[2], NQM_PI * (double)p / P, 1e-14);
        raw(brdf, hd[0], hd[1], hd[2], rgb);
        for (size_t c = 0; c < 3; ++c)
            assert_near(rgb[c], (double)values[3 * i + c], 1e-12);
    }
    nqm_brdf_info info = nqm_brdf_get_info(brdf);
    assert_string_equal(info.format, "table");
    assert_string_equal(info.layout, "9x7x6 nodes");
    assert_int_equal(info.n_values, 3 * N);
    assert_int_equal(info.reciprocal, 1);
    nqm_brdf_free(brdf);
}

/* The three channels are linear in sqrt(theta_h), in theta_d, and in phi_d up to the last node. */
TEST(linear_between_nodes) {
    float values[3 * N];
    for (size_t i = 0; i < N; ++i) {
        size_t h, d, p;
        node_numbers(i, &h, &d, &p);
        values[3 * i] = (float)h + 1;
        values[3 * i + 1] = (float)d + 2;
        values[3 * i + 2] = (float)p + 3;
    }
    nqm_brdf *brdf = make_table(values);
    for (uint32_t i = 0; i < 500; ++i) {
        double u = noise(i, 1), v = noise(i, 2), w = noise(i, 3) * (P - 1), rgb[3];
        raw(brdf, u * u * NQM_PI / 2, v * NQM_PI / 2, w / P * NQM_PI, rgb);
        assert_near(rgb[0], 1 + u * (H - 1), 1e-12);
        assert_near(rgb[1], 2 + v * (D - 1), 1e-12);
        assert_near(rgb[2], 3 + w, 1e-12);
    }
    nqm_brdf_free(brdf);
}

TEST(phi_closes_on_itself) {
    float values[3 * N];
    for (uint32_t i = 0; i < 3 * N; ++i)
        values[i] = (float)noise(i, 1);
    nqm_brdf *brdf = make_table(values);
    double last[3], first[3], half_way[3], at_pi[3];
    raw(brdf, 0.3, 0.4, NQM_PI * (P - 1) / P, last);
    raw(brdf, 0.3, 0.4, 0, first);
    raw(brdf, 0.3, 0.4, NQM_PI * (P - 0.5) / P, half_way);
    raw(brdf, 0.3, 0.4, nextafter(NQM_PI, 0), at_pi);
    for (size_t c = 0; c < 3; ++c) {
        assert_near(half_way[c], (last[c] + first[c]) / 2, 1e-12);
        assert_near(at_pi[c], first[c], 1e-12);
    }
    for (uint32_t i = 0; i < 100; ++i) { /* exchange of light and viewer */
        const double hd[3] = {noise(i, 1) * 0.7, noise(i, 2) * 0.7, noise(i, 3) * 6};
        double wi[3], wo[3], there[3], back[3];
        nqm_half_diff_to_directions(hd, wi, wo);
        nqm_brdf_eval(brdf, 1, wi, wo, there, NULL);
        nqm_brdf_eval(brdf, 1, wo, wi, back, NULL);
        for (size_t c = 0; c < 3; ++c)
            assert_near(back[c], there[c], 1e-9);
    }
    nqm_brdf_free(brdf);
}

TEST(missing_values_are_left_out) {
    float values[3 * N];
    for (uint32_t i = 0; i < 3 * N; ++i)
        values[i] = (float)noise(i, 1) + 1;
    size_t row = 3 * D * P; /* values of one theta_h node */
    for (size_t i = 0; i < row; ++i)
        values[5 * row + i] = values[6 * row + i] = NAN;
    nqm_brdf *brdf = make_table(values);
    double beside[3], at_node[3], between[3];
    uint8_t flag;
    const double u = 4.9 / (H - 1), node = 4.0 / (H - 1), gap = 5.5 / (H - 1);
    raw(brdf, u * u * NQM_PI / 2, 0.3, 0.2, beside);
    raw(brdf, node * node * NQM_PI / 2, 0.3, 0.2, at_node);
    for (size_t c = 0; c < 3; ++c)
        assert_near(beside[c], at_node[c], 1e-12); /* only neighbours with a value contribute */
    const double hd[3] = {gap * gap * NQM_PI / 2, 0.3, 0.2};
    nqm_brdf_eval_half_diff(brdf, 1, hd, between, &flag);
    assert_int_equal(flag, NQM_VALUE_INVALID);
    assert_true(between[0] == 0);
    nqm_brdf_free(brdf);
}

TEST(sizes_have_limits) {
    static const size_t bad[][3] = {{1, 2, 1}, {2, 1, 1}, {2, 2, 0}, {4096, 4096, 2}, {SIZE_MAX, SIZE_MAX, 2}};
    static const size_t bad_phi_h[] = {0, SIZE_MAX, 1 << 23};
    float values[12] = {0};
    nqm_brdf *brdf;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        nqm_error err = {0};
        assert_int_equal(
            nqm_table_create((nqm_table_size){bad[i][0], bad[i][1], bad[i][2], 1}, values, "t", &brdf, &err),
            NQM_ERR_LIMIT);
        assert_null(brdf);
        assert_non_null(strstr(err.message, "nodes"));
    }
    for (size_t i = 0; i < sizeof bad_phi_h / sizeof *bad_phi_h; ++i)
        assert_int_equal(nqm_table_create((nqm_table_size){2, 2, 1, bad_phi_h[i]}, values, "t", &brdf, NULL),
                         NQM_ERR_LIMIT);
    assert_int_equal(nqm_table_create((nqm_table_size){2, 2, 1, 1}, values, "t", &brdf, NULL), NQM_OK);
    nqm_brdf_free(brdf);
}

enum { M = 4, TURNED = H * D * P * M };

static nqm_brdf *make_turned(const float *rgb) {
    nqm_brdf *brdf;
    assert_int_equal(nqm_table_create((nqm_table_size){H, D, P, M}, rgb, "table", &brdf, NULL), NQM_OK);
    return brdf;
}

/* The pair of a node, turned about the normal by phi_h; false: below the horizon. */
static bool turned_pair(const double *hd, double phi_h, double *wi, double *wo) {
    const double turn[2] = {sin(phi_h), cos(phi_h)};
    nqm_half_diff_to_pair(hd, wi, wo);
    nqm_turn3(turn, wi, wi);
    nqm_turn3(turn, wo, wo);
    return wi[2] > 1e-9 && wo[2] > 1e-9;
}

/* With phi_h: nodes keep their values for directions, and phi_h is linear and periodic between them. */
TEST(phi_h_is_an_axis) {
    static float values[3 * TURNED];
    for (uint32_t i = 0; i < 3 * TURNED; ++i)
        values[i] = (float)noise(i, 1);
    nqm_brdf *brdf = make_turned(values);
    size_t n_used = 0;
    for (size_t i = 0; i < TURNED; ++i) {
        size_t h, d, p, m = i % M;
        double hd[3], wi[3], wo[3], rgb[3];
        node_numbers(i / M, &h, &d, &p);
        nqm_table_node(H, D, P, h, d, p, hd);
        if (h == 0 || d == 0) /* where an angle means nothing */
            continue;
        const float *next = values + 3 * (i - m + (m + 1) % M);
        for (int k = 0; k < 2; ++k) {
            if (!turned_pair(hd, 2 * NQM_PI * ((double)m + 0.25 * k) / M, wi, wo))
                continue;
            nqm_brdf_eval(brdf, 1, wi, wo, rgb, NULL);
            assert_near(rgb[1],
                        k ? 0.75 * (double)values[3 * i + 1] + 0.25 * (double)next[1] : (double)values[3 * i + 1],
                        1e-6);
            nqm_brdf_eval(brdf, 1, wo, wi, rgb, NULL); /* reciprocal */
            assert_near(rgb[1],
                        k ? 0.75 * (double)values[3 * i + 1] + 0.25 * (double)next[1] : (double)values[3 * i + 1],
                        1e-6);
            ++n_used;
        }
        if (m == 0 && turned_pair(hd, 0, wi, wo)) {
            nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, NULL);
            assert_near(rgb[2], (double)values[3 * i + 2], 1e-6);
        }
    }
    assert_true(n_used > 1000);
    nqm_brdf_info info = nqm_brdf_get_info(brdf);
    assert_string_equal(info.layout, "9x7x6x4 nodes");
    assert_int_equal(info.reciprocal, 1);
    assert_int_equal(info.isotropic, 0);
    nqm_brdf_free(brdf);
}

/* A diffuse lobe and one that is narrow along the tangent, turned by the angle at `user`. */
static void brushed(void *user, size_t n, const double *wi, const double *wo, double *rgb) {
    const double turn = user ? *(const double *)user : 0;
    for (size_t i = 0; i < 3 * n; i += 3) {
        const double h[3] = {wi[i] + wo[i], wi[i + 1] + wo[i + 1], wi[i + 2] + wo[i + 2]};
        const double x = (cos(turn) * h[0] + sin(turn) * h[1]) / h[2], y = (cos(turn) * h[1] - sin(turn) * h[0]) / h[2];
        rgb[i] = rgb[i + 1] = rgb[i + 2] = 0.1 + (user ? exp(-x * x / 0.04 - y * y / 0.25) : exp(-x * x - y * y));
    }
}

/* An anisotropic BRDF becomes a table with phi_h, which a file keeps; MERL tables are refused. Others have no phi_h. */
TEST(anisotropic_brdfs_get_phi_h) {
    static double turn = 0.5;
    const char *path = scratch_path("brushed.npy"), *saved = scratch_path("brushed.safetensors");
    nqm_brdf *brdf, *table;
    nqm_error err = {0};
    assert_int_equal(nqm_brdf_create(&(nqm_brdf_callbacks){.eval = brushed, .user = &turn}, &brdf, NULL), NQM_OK);
    assert_int_equal(nqm_brdf_write(brdf, NQM_FILE_MERL, NULL, scratch_path("x.binary"), NULL, NULL, &err),
                     NQM_ERR_ARG);
    assert_non_null(strstr(err.message, "is anisotropic"));
    assert_int_equal(nqm_brdf_write(brdf, NQM_FILE_MERL_360, NULL, scratch_path("x.binary"), NULL, NULL, NULL),
                     NQM_ERR_ARG);
    assert_int_equal(nqm_brdf_write(brdf, NQM_FILE_NPY, NULL, path, NULL, NULL, NULL), NQM_OK);
    table = must_open(path);
    assert_string_equal(nqm_brdf_get_info(table).layout, "90x46x24x48 nodes");
    assert_true(nqm_brdf_get_info(table).n_bytes < 64 << 20);
    assert_int_equal(nqm_brdf_save(table, saved, NULL), NQM_OK);
    nqm_brdf *again = must_open(saved);
    nqm_rng rng = nqm_rng_make(1, 0);
    for (int i = 0; i < 2000; ++i) {
        const double hd[3] = {0.8 * nqm_rng_uniform(&rng), 0.6 * nqm_rng_uniform(&rng), 7 * nqm_rng_uniform(&rng)};
        double wi[3], wo[3], a[3], b[3], c[3];
        if (!turned_pair(hd, 7 * nqm_rng_uniform(&rng), wi, wo))
            continue;
        nqm_brdf_eval(brdf, 1, wi, wo, a, NULL);
        nqm_brdf_eval(table, 1, wi, wo, b, NULL);
        nqm_brdf_eval(again, 1, wi, wo, c, NULL);
        assert_near(b[0], a[0], 0.012); /* the resolution of the table; the lobe is 1 high */
        assert_memory_equal(b, c, sizeof b);
    }
    nqm_brdf_free(again);
    nqm_brdf_free(table);
    nqm_brdf_free(brdf);
    assert_int_equal(nqm_brdf_create(&(nqm_brdf_callbacks){.eval = brushed}, &brdf, NULL), NQM_OK);
    assert_int_equal(nqm_brdf_write(brdf, NQM_FILE_NPY, NULL, path, NULL, NULL, NULL), NQM_OK);
    table = must_open(path);
    assert_string_equal(nqm_brdf_get_info(table).layout, "90x46x24 nodes");
    nqm_brdf_free(table);
    assert_int_equal(nqm_brdf_tabulate(brdf, (nqm_table_size){4, 3, 2, 0}, NULL, &table, NULL), NQM_OK);
    assert_string_equal(nqm_brdf_get_info(table).layout, "4x3x2x48 nodes"); /* not known to be isotropic */
    nqm_brdf_free(table);
    nqm_brdf_free(brdf);
}
