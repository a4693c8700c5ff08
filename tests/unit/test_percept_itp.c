/* SPDX-License-Identifier: MIT
 *
 * ITP and Delta-E ITP against values with 50 digits computed from the recommendations (vectors/percept.py), and against
 * published values of the PQ curve.
 */
#include "percept/percept.h"
#include "support/check.h"
#include "support/vectors.h"

enum { N_ITP = 40, N_PQ = 11 };

static double itp_vector[N_ITP][8], pq_vector[N_PQ][2];

static int read_vectors(void **state) {
    (void)state;
    get_vector("percept.safetensors", "itp", sizeof itp_vector, itp_vector);
    get_vector("percept.safetensors", "pq", sizeof pq_vector, pq_vector);
    return 0;
}

TEST(pq_signals) {
    for (size_t i = 0; i < N_PQ; ++i)
        assert_relative(nqm_pq_from_luminance(pq_vector[i][0]), pq_vector[i][1], 1e-13);
    assert_near(nqm_pq_from_luminance(100), 0.508078421517399, 1e-15); /* value from the literature */
    assert_true(nqm_pq_from_luminance(10000) == 1);
    assert_true(nqm_pq_from_luminance(1e9) == 1);
    assert_near(nqm_pq_from_luminance(0), 7.3095590257839665e-07, 1e-18); /* c1^m2 */
    assert_true(nqm_pq_from_luminance(-1) == nqm_pq_from_luminance(0));
}

TEST(colours) {
    for (size_t i = 0; i < N_ITP; ++i) {
        double itp[3];
        nqm_itp_from_rgb(itp_vector[i], itp);
        for (int k = 0; k < 3; ++k)
            assert_near(itp[k], itp_vector[i][3 + k], 1e-13);
    }
}

TEST(differences) {
    for (size_t i = 0; i < N_ITP; ++i) {
        const double *last = itp_vector[(i + N_ITP - 1) % N_ITP];
        double delta_e = nqm_delta_e_itp(last, itp_vector[i]);
        assert_near(delta_e, itp_vector[i][6], 1e-10);
        assert_near(delta_e, itp_vector[i][7], 0.02); /* four digits in the matrix change Delta-E invisibly little */
        assert_true(nqm_delta_e_itp(itp_vector[i], itp_vector[i]) == 0);
        assert_true(nqm_delta_e_itp(itp_vector[i], last) == delta_e);
    }
}

TEST(greys_have_no_colour) {
    for (double y = 1e-4; y < 2e4; y *= 1.7) {
        const double rgb[3] = {y, y, y};
        double itp[3];
        nqm_itp_from_rgb(rgb, itp);
        assert_near(itp[0], nqm_pq_from_luminance(y), 1e-12);
        assert_near(itp[1], 0, 1e-12);
        assert_near(itp[2], 0, 1e-12);
    }
}

TEST(out_of_range_is_clamped) {
    static const double wild[3] = {-5, 2e4, 7}, tame[3] = {0, 1e4, 7};
    assert_true(nqm_delta_e_itp(wild, tame) == 0);
}

TEST_FILE(read_vectors, NULL)
