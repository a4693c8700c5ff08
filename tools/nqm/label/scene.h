/* SPDX-License-Identifier: MIT
 *
 * scene.h - shared by the verbs that render: the scene options (nqm_scene_option_table and --size), pictures of the frames of a
 * scene from its points, and short names of BRDFs.
 */
#ifndef NQM_TOOL_SCENE_H
#define NQM_TOOL_SCENE_H

#include "argument/argument.h"
#include "figures/picture.h"
#include "nqm/tool.h"
#include "render/render.h"

/** Scene options of the command line: the target of nqm_scene_option_table, and the size of the picture. */
typedef struct scene_args {
    nqm_scene_options scene; /**< complete after scene_args_end() */
    const char *size;        /**< "256" or "320x200", of a frame if --points is not given; NULL: see `side` */
    size_t side;             /**< without `size`: of the picture of all frames, in pixels; 0: points */
} scene_args;

/** A progress callback that shows the two stages of making a scene ("view" takes a hundredth of the time) as one. */
int show_scene_progress(void *user, const char *stage, double done, double total);
/** The defaults of the library; set `size` or `side` for the default size of a picture. */
scene_args scene_args_begin(void);
/** The row of --size, for the options of a verb. */
#define OPTION_ROW_SIZE(args, help)                                                                                    \
    { "size", 0, OPTION_TEXT, &(args)->size, "N|WxH", help, 0, 0 }
/** Stop when the shape or the light is neither built in nor a file. scene_args_end() does. */
void check_scene_files(const nqm_scene_options *scene);
/** After parsing: set width, height and n_frames, or report the error and exit. */
void scene_args_end(scene_args *a);
/** The scene in JSON documents. */
json_t *json_scene(const nqm_scene_options *scene);

typedef enum backdrop { BACKDROP_WHITE, BACKDROP_BLACK, BACKDROP_LIGHT } backdrop;

/** A picture of one frame, or of all frames of a scene, or of the scenes of the standard set, in a grid. */
typedef struct canvas {
    size_t first, n_columns, n_rows; /**< the first frame, and the grid of it and the frames after it */
    size_t width, height;            /**< size of the grid, pixels */
} canvas;

canvas one_frame(const nqm_scene_options *o, size_t frame);
/** Arrange the frames of a scene in a grid with as many columns as rows, or one more. */
canvas all_frames(const nqm_scene_options *o);

/** A picture: (height, width, 3) cd/m2; free() it. White is 10000 cd/m2, which every tone curve maps to white; BACKDROP_LIGHT: of one
 *  frame. rgb_cdm2: (points, 3). */
double *draw_picture(const nqm_scene *scene, const canvas *c, backdrop kind, const double *rgb_cdm2);
/** The same for one value per point: map (height, width), NaN outside the shape. */
void draw_map(const nqm_scene *scene, const canvas *c, const double *values, double *map);

/** A BRDF that was rendered. */
typedef struct rendered {
    nqm_brdf *brdf;    /* nqm_brdf_free() it */
    double valid;      /* the fraction of the light at directions where it has a value */
    bool is_tabulated; /* the picture was made from a table of its values, which is said once on standard error */
} rendered;
/** Open a BRDF and render it: rgb_cdm2 (points, 3), or (3, points, 3) with the halves of nqm_scene_render(). */
nqm_status render_brdf(const nqm_scene *scene, nqm_argument *argument, bool with_halves, double *rgb_cdm2, rendered *r,
                       nqm_error *err);
/** A tone curve whose white is twice the exposure. */
nqm_tone tone_of(const nqm_scene_options *o);

/** A short name of a BRDF argument: a file's name without folders and ending, the material in an archive, a preset, or the model
 *  of a spec. */
void short_name(const char *argument, char *name, size_t n_name);

#endif
