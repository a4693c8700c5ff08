/* SPDX-License-Identifier: MIT
 *
 * scene_args.h - the options that say in which scene BRDFs are compared, for all verbs that render.
 */
#ifndef NQM_TOOL_SCENE_ARGS_H
#define NQM_TOOL_SCENE_ARGS_H

#include "nqm/tool.h"

/** What the options say, and the scene that follows. A verb may change the defaults between begin and table. */
typedef struct scene_args {
    nqm_scene_options scene; /**< complete after scene_args_end() */
    const char *size;        /**< "256" or "320x200" */
    uint64_t n_points;       /**< 0: a picture of `size` */
    uint64_t n_frames, n_lights, light_width;
    double turn_deg, elevation_deg;
    bool no_shadows, interreflection;
} scene_args;

enum { N_SCENE_OPTIONS = 14 };

/** The defaults: a picture of 256 x 256, all else as nqm_scene_options_default(). */
scene_args scene_args_begin(void);
/** Append the options to a table that has room for N_SCENE_OPTIONS more and the entry that ends it. */
void scene_args_table(scene_args *a, option *table);
/** After parsing: fill a->scene. EXIT_OK, or EXIT_USAGE with the fault reported. */
int scene_args_end(const char *verb, scene_args *a);
/** What a document says about the scene. */
json_t *json_scene(const nqm_scene_options *scene);

#endif
