/* SPDX-License-Identifier: MIT
 *
 * The checks of scenes.h.
 */
#include "support/scenes.h"
#include "base/memory_test.h"
#include "support/check.h"

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
