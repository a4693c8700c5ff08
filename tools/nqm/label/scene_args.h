/* SPDX-License-Identifier: MIT
 *
 * scene_args.h - the scene options of the verbs that render: nqm_scene_option_table, and --size.
 */
#ifndef NQM_TOOL_SCENE_ARGS_H
#define NQM_TOOL_SCENE_ARGS_H

#include "nqm/tool.h"
#include "render/render.h"

/** Scene options of the command line: the target of nqm_scene_option_table, and the size of the picture. */
typedef struct scene_args {
    nqm_scene_options scene; /**< complete after scene_args_end() */
    const char *size;        /**< "256" or "320x200", of a picture if n_points is 0 */
} scene_args;

/** A picture of 256 x 256 unless --points is given; otherwise the defaults of the library. */
scene_args scene_args_begin(void);
/** The row of --size, for the options of a verb. */
#define OPTION_ROW_SIZE(args)                                                                                          \
    { "size", 0, OPTION_TEXT, &(args)->size, "N|WxH", "picture in pixels", 0, 0 }
/** After parsing: set width and height, or report the error and exit. */
void scene_args_end(scene_args *a);
/** The scene in JSON documents. */
json_t *json_scene(const nqm_scene_options *scene);

#endif
