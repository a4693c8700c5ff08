/* SPDX-License-Identifier: MIT
 *
 * scenes.h - checks that the creation of a scene fails.
 */
#ifndef NQM_TESTS_SUPPORT_SCENES_H
#define NQM_TESTS_SUPPORT_SCENES_H

#include "render/render.h"

/** Check that creating a scene from the options fails with the expected status and a message. */
void expect_no_scene(nqm_scene_options o, nqm_status expected);
/** Check that creation fails without a leak when any single allocation fails; it makes fewer than `most`
 * allocations. */
void check_scene_without_memory(const nqm_scene_options *o, long most);

#endif
