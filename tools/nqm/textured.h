/* SPDX-License-Identifier: MIT
 *
 * textured.h - which arguments of the command line are materials with image maps, and how pictures of them are made.
 */
#ifndef NQM_TOOL_TEXTURED_H
#define NQM_TOOL_TEXTURED_H

#include "argument/argument.h"
#include "label/textured.h"
#include "nqm/tool.h"
#include "texture/score.h"

/** Whether an argument is a folder or list of maps, or a material of a file with image maps. No image is read. */
bool is_textured(const char *argument);
/** Whether an argument is a folder that is no material itself: one of files. */
bool is_library(const char *argument);
/** Open any argument as a texture, with progress, and say on standard error what of it is not used. nqm_texture_free() it. */
nqm_status open_texture(nqm_argument *argument, nqm_texture **texture_ret, nqm_error *err);

/** Options of verbs that make pictures. */
typedef struct view_args {
    uint64_t tiles, texels;
} view_args;

/** The rows of these options. */
#define OPTION_ROW_TILES(args)                                                                                         \
    {                                                                                                                  \
        "tiles", 0, OPTION_COUNT, &(args)->tiles, "N",                                                                 \
            "repeat a textured material N times along each texture coordinate of the shape", 1, 1e6                    \
    }
#define OPTION_ROW_TEXELS(args)                                                                                        \
    {                                                                                                                  \
        "texels", 0, OPTION_COUNT, &(args)->texels, "N", "average N texels for each point of a textured material", 1,  \
            4096                                                                                                       \
    }
/** Their defaults; and the view that they describe. */
view_args view_args_begin(void);
nqm_texture_view view_of(const view_args *args);

#endif
