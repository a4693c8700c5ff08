/* SPDX-License-Identifier: MIT
 *
 * scenes.h - checks of scenes whose creation must fail.
 */
#ifndef NQM_TESTS_SUPPORT_SCENES_H
#define NQM_TESTS_SUPPORT_SCENES_H

#include "render/render.h"

/** The options give no scene, the expected status and a message. */
void expect_no_scene(nqm_scene_options o, nqm_status expected);
/** Whichever allocation fails, creation fails without a leak; it makes fewer than `most` allocations. */
void check_scene_without_memory(const nqm_scene_options *o, long most);

#endif
