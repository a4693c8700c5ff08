/* SPDX-License-Identifier: MIT
 *
 * Labels of BRDFs that have no value at some directions: what has a value is compared, what has none is counted.
 */
#include "label/label.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/scenes.h"

typedef struct limits {
    double least_wi, least_wo; /* cosines; no value below */
    bool is_brushed;
} limits;

static void eval(void *user, size_t n, const double *wi, const double *wo, double *rgb) {
    const limits *l = user;
    for (size_t i = 0; i < n; ++i) {
        const bool has_value = wi[3 * i + 2] >= l->least_wi && wo[3 * i + 2] >= l->least_wo;
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] =
                has_value ? 0.1 + 0.05 * (double)c + (l->is_brushed ? 0.1 * wi[3 * i] * wi[3 * i] : 0) : (double)NAN;
    }
}

static nqm_brdf *make(limits *l) {
    nqm_brdf *brdf;
    assert_int_equal(nqm_brdf_create(&(nqm_brdf_callbacks){.eval = eval, .user = l, .name = "holes"}, &brdf, NULL),
                     NQM_OK);
    return brdf;
}

static nqm_scene_picture picture_of(const nqm_scene *scene, limits *l) {
    nqm_scene_picture p = {.brdf = make(l)};
    double *rgb = nqm_alloc(nqm_scene_get_info(scene).n_points, 9 * sizeof *rgb);
    assert_int_equal(nqm_scene_render(scene, p.brdf, 1, rgb, &p.valid, NULL), NQM_OK);
    p.rgb_cdm2 = rgb;
    return p;
}

static void clear(nqm_scene_picture *p) {
    nqm_brdf_free((nqm_brdf *)(uintptr_t)p->brdf);
    nqm_free((void *)(uintptr_t)p->rgb_cdm2);
}

static nqm_scene *scene_of(double min_valid) {
    nqm_scene_options o = nqm_scene_options_default();
    o.n_points = 300;
    o.n_lights = 64;
    o.min_valid = min_valid;
    return make_scene(&o);
}

/* By random rays: another quadrature of the same light. */
static double expected_fraction(const nqm_scene *scene, const limits *l) {
    nqm_rays rays;
    double valid = 0;
    assert_int_equal(nqm_rays_draw(scene, 100000, 1, &rays, NULL), NQM_OK);
    double part_all[4] = {0}, part_valid[4] = {0};
    for (size_t i = 0; i < rays.n; ++i) {
        const double *w = rays.weight + 3 * i, y = 0.2126 * w[0] + 0.7152 * w[1] + 0.0722 * w[2];
        const size_t part = (size_t)rays.points[3 * rays.point[i] + 1];
        part_all[part] += y;
        part_valid[part] += rays.wi[3 * i + 2] >= l->least_wi && rays.wo[3 * i + 2] >= l->least_wo ? y : 0;
    }
    for (size_t p = 0; p < 4; ++p)
        valid += part_valid[p] / part_all[p] / 4;
    nqm_rays_clear(&rays);
    return valid;
}

TEST(what_has_values_is_compared) {
    limits whole = {0}, high_sun = {.least_wi = 0.3}, steep_view = {.least_wo = 0.3},
           brushed = {.least_wi = 0.3, .is_brushed = true}, whole_brushed = {.is_brushed = true};
    limits *pairs[][2] = {{&whole, &high_sun},      {&high_sun, &whole},        {&steep_view, &whole},
                          {&high_sun, &steep_view}, {&brushed, &whole_brushed}, {&high_sun, &high_sun}};
    nqm_scene *scene = scene_of(0.3);
    double *map = nqm_alloc(nqm_scene_get_info(scene).n_points, sizeof *map);
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; ++i) {
        nqm_scene_picture ref = picture_of(scene, pairs[i][0]), test = picture_of(scene, pairs[i][1]);
        const limits both = {fmax(pairs[i][0]->least_wi, pairs[i][1]->least_wi),
                             fmax(pairs[i][0]->least_wo, pairs[i][1]->least_wo), false};
        nqm_label label;
        double valid;
        assert_int_equal(nqm_scene_label(scene, &ref, &test, &label, map, &valid, NULL), NQM_OK);
        /* the light directions of brushed ones follow their lobes, which are measured where they have values */
        assert_true(label.delta_e <= (pairs[i][0]->is_brushed ? 0.05 : 0));
        for (size_t p = 0; p < nqm_scene_get_info(scene).n_points; ++p)
            assert_true(map[p] == 0 || pairs[i][0]->is_brushed);
        assert_true(valid < 1 && valid <= fmin(ref.valid, test.valid));
        assert_near(valid, expected_fraction(scene, &both), 0.025);
        clear(&ref);
        clear(&test);
    }
    nqm_free(map);
    nqm_scene_free(scene);
}

/* Where both have values, differences count; a BRDF without holes keeps its bits beside another without. */
TEST(differences_count) {
    limits whole = {0}, brushed = {.is_brushed = true}, high_sun = {.least_wi = 0.3};
    nqm_scene *scene = scene_of(0.3);
    nqm_scene_picture a = picture_of(scene, &whole), b = picture_of(scene, &brushed), c = picture_of(scene, &high_sun);
    nqm_label plain, common;
    double valid;
    assert_true(a.valid == 1 && b.valid == 1);
    assert_int_equal(nqm_scene_label(scene, &a, &b, &plain, NULL, &valid, NULL), NQM_OK);
    assert_true(valid == 1);
    const nqm_label expected = nqm_scene_compare_halves(scene, a.rgb_cdm2, b.rgb_cdm2);
    assert_memory_equal(&plain, &expected, sizeof plain);
    assert_int_equal(nqm_scene_label(scene, &c, &b, &common, NULL, &valid, NULL), NQM_OK);
    assert_true(common.delta_e > 0.5 * plain.delta_e && common.delta_e < 2 * plain.delta_e);
    /* a picture that cannot be rendered again is compared as it is */
    nqm_brdf_free((nqm_brdf *)(uintptr_t)c.brdf);
    c.brdf = NULL;
    nqm_scene_picture again = picture_of(scene, &high_sun);
    assert_int_equal(nqm_scene_label(scene, &c, &a, &common, NULL, &valid, NULL), NQM_OK);
    assert_true(valid == again.valid && common.delta_e > 0);
    clear(&a);
    clear(&b);
    clear(&c);
    clear(&again);
    nqm_scene_free(scene);
}

TEST(too_few_values_are_refused) {
    limits nothing = {.least_wi = 2}, high_sun = {.least_wi = 0.3}, steep_view = {.least_wo = 0.3};
    nqm_scene *scene = scene_of(0.9);
    double *rgb = nqm_alloc(nqm_scene_get_info(scene).n_points, 9 * sizeof *rgb), valid = -1;
    nqm_brdf *brdf = make(&nothing);
    nqm_error err = {0};
    assert_int_equal(nqm_scene_render(scene, brdf, 0, rgb, &valid, &err), NQM_ERR_INCOMPATIBLE);
    assert_true(valid == 0);
    assert_non_null(strstr(err.message, "holes: values at directions of 0.0 % of the light of the scene, and 90 %"));
    assert_int_equal(nqm_scene_render(scene, brdf, 1, rgb, NULL, &err), NQM_ERR_INCOMPATIBLE);
    nqm_brdf_free(brdf);
    /* each has enough, both together do not */
    nqm_scene_picture a = picture_of(scene, &high_sun), b = picture_of(scene, &steep_view);
    nqm_label label;
    assert_int_equal(nqm_scene_label(scene, &a, &b, &label, NULL, &valid, &err), NQM_ERR_INCOMPATIBLE);
    assert_true(valid < 0.9 && fmin(a.valid, b.valid) >= 0.9);
    assert_non_null(strstr(err.message, "holes and holes: values at directions of"));
    assert_int_equal(nqm_scene_label(NULL, &a, &b, &label, NULL, NULL, NULL), NQM_ERR_ARG);
    assert_int_equal(nqm_scene_label(scene, &a, &b, NULL, NULL, NULL, NULL), NQM_ERR_ARG);
    clear(&a);
    clear(&b);
    nqm_free(rgb);
    nqm_scene_free(scene);
}

TEST(memory_runs_out) {
    limits whole = {0}, high_sun = {.least_wi = 0.3};
    nqm_scene *scene = scene_of(0.9);
    nqm_scene_picture a = picture_of(scene, &whole), b = picture_of(scene, &high_sun);
    nqm_label label;
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 0)
    status = nqm_scene_label(scene, &a, &b, &label, NULL, NULL, NULL);
    assert_true(n >= 3 && label.delta_e == 0);
    clear(&a);
    clear(&b);
    nqm_scene_free(scene);
}
