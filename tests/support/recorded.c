/* SPDX-License-Identifier: MIT
 *
 * Reads the recorded pairs, and makes the matrices that the script makes too.
 */
#include "support/recorded.h"
#include "support/check.h"
#include "support/random_network.h"
#include "support/vectors.h"

nqm_directions *directions;

void get_recorded(const char *name, size_t n_bytes, void *to) {
    get_vector("metric_torch.safetensors", name, n_bytes, to);
}

int make_recorded_directions(void **state) {
    (void)state;
    double degrees[PAIR_VALUES];
    get_recorded("degrees", sizeof degrees, degrees);
    assert_int_equal(nqm_directions_from_degrees(PAIR_N, degrees, &directions, NULL), NQM_OK);
    return 0;
}

int free_recorded_directions(void **state) {
    (void)state;
    nqm_directions_free(directions);
    return 0;
}

gradient_pair recorded_pair(size_t number) {
    static float pairs[N_PAIRS_RECORDED][2][PAIR_VALUES];
    static uint8_t used[N_PAIRS_RECORDED][PAIR_N];
    gradient_pair p;
    get_recorded("pairs", sizeof pairs, pairs);
    get_recorded("used", sizeof used, used);
    memcpy(p.ref, pairs[number][0], sizeof p.ref);
    memcpy(p.test, pairs[number][1], sizeof p.test);
    memcpy(p.used, used[number], sizeof p.used);
    return p;
}

double check_slopes(const char *what, const float *gradient, const double *slopes, const float *only,
                    double tolerance) {
    double norm = 0, worst = 0;
    for (size_t i = 0; i < PAIR_VALUES; ++i)
        norm += !only || only[i] > 0 ? (double)gradient[i] * (double)gradient[i] : 0;
    for (size_t way = 0; way < N_WAYS; ++way) {
        double slope = 0;
        for (size_t i = 0; i < PAIR_VALUES; ++i)
            slope += !only || only[i] > 0 ? (double)gradient[i] * sin((double)((way + 1) * (i + 1))) : 0;
        worst = fmax(worst, fabs(slope - slopes[way]));
    }
    if (!(worst <= tolerance * sqrt(norm)))
        fail_msg("%s: slopes differ by %g of %g", what, worst, sqrt(norm));
    return norm > 0 ? worst / sqrt(norm) : 0;
}

nqm_transport make_transport(size_t n_points, size_t n_scenes, double peak_cdm2) {
    uint64_t seed = n_points + n_scenes;
    float *light = nqm_alloc(PAIR_VALUES, n_points * sizeof *light);
    double *points = nqm_alloc(n_points, 3 * sizeof *points);
    for (size_t i = 0; light && i < PAIR_VALUES * n_points; ++i)
        light[i] = random_unit(&seed) < 0.3 ? (float)(2000.0 / PAIR_N * random_unit(&seed)) : 0;
    for (size_t s = 0; points && s < n_scenes; ++s) {
        const size_t begin = n_points * s / n_scenes, end = n_points * (s + 1) / n_scenes;
        double sum = 0;
        for (size_t p = begin; p < end; ++p)
            sum += points[3 * p] = 0.1 + random_unit(&seed);
        for (size_t p = begin; p < end; ++p) {
            points[3 * p] /= sum;
            points[3 * p + 1] = (double)s;
            points[3 * p + 2] = peak_cdm2 * (double)(s + 1);
        }
    }
    return (nqm_transport){PAIR_N, light, {n_points, points}};
}

void drop_transport(nqm_transport *transport) {
    nqm_free((void *)(uintptr_t)transport->light);
    nqm_free((void *)(uintptr_t)transport->points.at);
}
