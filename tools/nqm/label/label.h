/* SPDX-License-Identifier: MIT
 *
 * label.h - a run of nqm label: groups of a reference and its tests, what was rendered, and its forms of output.
 */
#ifndef NQM_TOOL_LABEL_H
#define NQM_TOOL_LABEL_H

#include "nqm/label/frames.h"
#include "nqm/label/scene_args.h"

/** A BRDF of the command line. Items stand in its order; a group begins with its reference. */
typedef struct label_item {
    const char *name;
    size_t reference;    /* index of the group's reference; its own for a reference */
    double delta_e, jod; /* NaN where the test could not be rendered, and for references */
    nqm_error err;
    double *rgb_cdm2; /* (points, 3); NULL once it is of no further use */
} label_item;

typedef struct label_run {
    nqm_scene_options scene_options;
    nqm_scene *scene;
    size_t n_items, n_groups;
    label_item *items;
    result_format format;
    bool keep_rgb; /* for pictures; else what was rendered is freed at once */
    /* figures; NULL: not wanted */
    const char *map, *grid, *keep;
    const char *rows, *columns; /* titles, separated by commas */
    size_t shrink;
} label_run;

/** Make the scene of run->scene_options, render the items and compare each test with its reference; faults of tests stand
 *  in their items. EXIT_OK, or the fault is reported and its exit code returned. free_labels() in any case. */
int make_labels(const char *verb, label_run *run);
/** Free the items and the scene. */
void free_labels(label_run *run);

/** What `nqm label --json` prints. */
json_t *json_labels(const label_run *run);
/** Results on standard output. */
int print_labels(const label_run *run);
/** Draw the figures and keep the renders that were asked for. */
int draw_labels(const label_run *run);

#endif
