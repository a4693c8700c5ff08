/* SPDX-License-Identifier: MIT
 *
 * The functions of scenes.h.
 */
#include "support/scenes.h"
#include "base/memory_test.h"
#include "support/check.h"

nqm_scene *make_scene(const nqm_scene_options *o) {
    nqm_scene *scene;
    nqm_error err = {0};
    if (nqm_scene_create(o, &scene, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return scene;
}

double *render_scene(const nqm_scene *scene, const nqm_brdf *brdf) {
    double *rgb = nqm_alloc(nqm_scene_get_info(scene).n_points, 3 * sizeof *rgb);
    assert_non_null(rgb);
    assert_int_equal(nqm_scene_render(scene, brdf, 0, rgb, NULL, NULL), NQM_OK);
    return rgb;
}

double *render_spec(const nqm_scene *scene, const char *spec) {
    nqm_brdf *brdf = must_open(spec);
    double *rgb = render_scene(scene, brdf);
    nqm_brdf_free(brdf);
    return rgb;
}

nqm_label label_specs(const nqm_scene *scene, const char *ref_spec, const char *test_spec) {
    double *ref = render_spec(scene, ref_spec), *test = render_spec(scene, test_spec);
    nqm_label label = nqm_scene_compare(scene, ref, test, NULL);
    nqm_free(ref);
    nqm_free(test);
    return label;
}

nqm_scene_options studio_scene(void) {
    nqm_scene_options o = nqm_scene_options_default();
    o.light = "studio";
    o.shape = "sphere";
    return o;
}

nqm_score_result score_specs(const nqm_model *model, const char *ref_spec, const char *test_spec) {
    nqm_brdf *ref = must_open(ref_spec), *test = must_open(test_spec);
    const nqm_brdf *tests[] = {test};
    nqm_score_result result;
    assert_int_equal(nqm_score(model, ref, 1, tests, NULL, &result, NULL), NQM_OK);
    nqm_brdf_free(ref);
    nqm_brdf_free(test);
    return result;
}

void expect_no_scene(nqm_scene_options o, nqm_status expected) {
    nqm_scene *scene = (nqm_scene *)&o; /* anything but NULL */
    nqm_error err = {0};
    assert_int_equal(nqm_scene_create(&o, &scene, &err), expected);
    assert_null(scene);
    assert_true(err.message[0] != 0);
}

void check_scene_without_memory(const nqm_scene_options *o, long most) {
    nqm_status status = NQM_ERR_NOMEM;
    for (long n = 0; status != NQM_OK; ++n) {
        nqm_scene *scene;
        nqm_alloc_fail_after(n);
        status = nqm_scene_create(o, &scene, NULL);
        nqm_alloc_fail_after(-1);
        assert_true(status == NQM_OK || (status == NQM_ERR_NOMEM && !scene));
        assert_true(n < most);
        nqm_scene_free(scene);
    }
}
