/* SPDX-License-Identifier: MIT
 *
 * Labels: how the pictures of two BRDFs in a scene differ, as a mean, in parts, and at every point.
 */
#include "label/label.h"
#include "math/math.h"
#include "percept/percept.h"

#include <math.h>

/* ITP of a point on the display of the scene, in units of Delta-E. */
static void see(const nqm_scene *scene, const double *rgb_cdm2, double *itp) {
    double shown[3];
    for (int k = 0; k < 3; ++k)
        shown[k] = fmin(rgb_cdm2[k], scene->options.peak_cdm2);
    nqm_itp_from_rgb(shown, itp);
    for (int k = 0; k < 3; ++k)
        itp[k] *= NQM_ITP_UNIT;
}

/* The points are dealt out to MANY interleaved groups, each of which estimates the label, and so does each of FEW
 * unions of them. */
enum { FEW = 4, MANY = 16 };

/* Standard deviation of the estimates of n groups. sum, weight (n): Delta-E times weight, and weights; groups without points are
 * left out. */
static double spread_of(size_t n, const double *sum, const double *weight, double mean) {
    double squares = 0;
    for (size_t g = 0; g < n && weight[g] > 0; ++g)
        squares += pow(sum[g] / weight[g] - mean, 2);
    return sqrt(squares / (double)(n - 1));
}

/* Standard error of the mean over all points. It falls as n^-p with the number of points: p is 1 where the difference
 * is smooth over the picture, since points are evenly spread, and 1/2 where it is small spots. The groups of both sizes
 * show p. */
static double points_error(const double sum[MANY], const double weight[MANY], double mean) {
    double union_sum[FEW] = {0}, union_weight[FEW] = {0};
    for (size_t g = 0; g < MANY; ++g) {
        union_sum[g % FEW] += sum[g];
        union_weight[g % FEW] += weight[g];
    }
    const double of_many = spread_of(MANY, sum, weight, mean), of_few = spread_of(FEW, union_sum, union_weight, mean);
    const double ratio = of_few > 0 ? of_many / of_few : 2; /* (MANY / FEW)^p */
    return of_few / fmin(fmax(ratio, 2), 4);
}

static nqm_label compare_one(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2) {
    const double *weights = scene->seen.weight;
    nqm_picture_sums sums = {0};
    double group_weight[MANY] = {0}, group_sum[MANY] = {0};
    for (size_t i = 0; i < scene->seen.n; ++i) {
        const double weight = weights ? weights[i] : 1 / (double)scene->seen.n, before = sums.delta_e;
        double ref[3], test[3];
        see(scene, ref_cdm2 + 3 * i, ref);
        see(scene, test_cdm2 + 3 * i, test);
        nqm_picture_sums_add(&sums, weight, ref, test);
        group_weight[i % MANY] += weight;
        group_sum[i % MANY] += sums.delta_e - before;
    }
    nqm_label label = nqm_picture_sums_label(&sums);
    label.error = points_error(group_sum, group_weight, label.delta_e);
    return label;
}

static void map_differences(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2, double *delta_e) {
    for (size_t i = 0; i < scene->seen.n; ++i) {
        double ref[3], test[3];
        see(scene, ref_cdm2 + 3 * i, ref);
        see(scene, test_cdm2 + 3 * i, test);
        double d[3] = {test[0] - ref[0], test[1] - ref[1], test[2] - ref[2]};
        delta_e[i] = sqrt(nqm_dot3(d, d));
    }
}

nqm_label nqm_scene_compare(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2, double *delta_e) {
    assert(scene && ref_cdm2 && test_cdm2);
    if (delta_e)
        map_differences(scene, ref_cdm2, test_cdm2, delta_e);
    nqm_label mean = {.delta_e = 0};
    for (size_t p = 0; p < scene->n_parts; ++p) {
        const nqm_label label = compare_one(scene->parts[p], ref_cdm2, test_cdm2);
        nqm_label_add(&mean, 1 / (double)scene->n_parts, &label);
        ref_cdm2 += 3 * scene->parts[p]->seen.n;
        test_cdm2 += 3 * scene->parts[p]->seen.n;
    }
    return mean;
}

nqm_label nqm_scene_compare_halves(const nqm_scene *scene, const double *ref_cdm2, const double *test_cdm2) {
    assert(scene && ref_cdm2 && test_cdm2);
    /* The bias falls as n^-1.3 with the number of directions (doc/labels.md): 1 / (2^1.3 - 1) of what half of them add. */
    static const double share = 0.68;
    const size_t n = 3 * scene->seen.n;
    const nqm_label whole = nqm_scene_compare(scene, ref_cdm2, test_cdm2, NULL);
    nqm_label label = {.delta_e = 0};
    nqm_label_add(&label, 1 + share, &whole);
    for (size_t h = 1; h <= 2; ++h) {
        const nqm_label half = nqm_scene_compare(scene, ref_cdm2 + h * n, test_cdm2 + h * n, NULL);
        nqm_label_add(&label, -0.5 * share, &half);
    }
    label.error = hypot(whole.error, 0.5 * (label.delta_e - whole.delta_e));
    label.delta_e = fmax(label.delta_e, 0);
    label.structure = fmax(label.structure, 0);
    return label;
}

nqm_status nqm_scene_label(const nqm_scene *scene, const nqm_scene_picture *ref, const nqm_scene_picture *test,
                           nqm_label *label_ret, double *delta_e, double *valid_ret, nqm_error *err) {
    NQM_REQUIRE(err, scene, ref, test, label_ret);
    const size_t n = nqm_scene_get_info(scene).n_points;
    const double *ref_cdm2 = ref->rgb_cdm2, *test_cdm2 = test->rgb_cdm2;
    double valid = fmin(ref->valid, test->valid), *both = NULL;
    nqm_status status = NQM_OK;
    if (valid < 1 && ref->brdf && test->brdf) {
        both = nqm_alloc(18 * n, sizeof *both);
        status = both ? nqm_scene_render_halves(scene, ref->brdf, test->brdf, both, &valid, err)
                      : nqm_fail_nomem(err, 18 * n * sizeof *both);
        if (status == NQM_OK)
            status = nqm_scene_render_halves(scene, test->brdf, ref->brdf, both + 9 * n, NULL, err);
        ref_cdm2 = both;
        test_cdm2 = both + 9 * n;
    }
    if (status == NQM_OK) {
        *label_ret = nqm_scene_compare_halves(scene, ref_cdm2, test_cdm2);
        if (delta_e)
            map_differences(scene, ref_cdm2, test_cdm2, delta_e);
    }
    if (valid_ret)
        *valid_ret = valid;
    nqm_free(both);
    return status;
}
