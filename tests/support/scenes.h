/* SPDX-License-Identifier: MIT
 *
 * scenes.h - scenes that must not be made.
 */
#ifndef NQM_TESTS_SUPPORT_SCENES_H
#define NQM_TESTS_SUPPORT_SCENES_H

#include "render/render.h"

/** The options give no scene, the expected status and a message. */
void expect_no_scene(nqm_scene_options o, nqm_status expected);
/** Wherever memory runs out there is no scene and nothing is lost; fewer than `most` blocks are asked for. */
void check_scene_without_memory(const nqm_scene_options *o, long most);

#endif
