/* SPDX-License-Identifier: MIT
 *
 * scenes.h - scenes, pictures and scores of tests, and checks that the creation of a scene fails.
 */
#ifndef NQM_TESTS_SUPPORT_SCENES_H
#define NQM_TESTS_SUPPORT_SCENES_H

#include "render/render.h"
#include <nqm/label.h>
#include <nqm/metric.h>

/** Create a scene; on failure the test fails with the library's message. */
nqm_scene *make_scene(const nqm_scene_options *o);
/** Render a BRDF: a new array (points, 3), nqm_free() it. */
double *render_scene(const nqm_scene *scene, const nqm_brdf *brdf);
double *render_spec(const nqm_scene *scene, const char *spec);
/** Render and compare two BRDFs. */
nqm_label label_specs(const nqm_scene *scene, const char *ref_spec, const char *test_spec);
/** A sphere in the studio. */
nqm_scene_options studio_scene(void);
/** The score of a pair, or its status. */
nqm_score_result score_specs(const nqm_model *model, const char *ref_spec, const char *test_spec);
/** Check that creating a scene from the options fails with the expected status and a message. */
void expect_no_scene(nqm_scene_options o, nqm_status expected);
/** Check that creation fails without a leak when any single allocation fails; it makes fewer than `most`
 * allocations. */
void check_scene_without_memory(const nqm_scene_options *o, long most);

#endif
