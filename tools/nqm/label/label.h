/* SPDX-License-Identifier: MIT
 *
 * label.h - a run of nqm label: groups of a reference and its tests, their renderings, and the output.
 */
#ifndef NQM_TOOL_LABEL_H
#define NQM_TOOL_LABEL_H

#include "nqm/label/scene.h"
#include "nqm/textured.h"

/** A BRDF of the command line, in its order; a group begins with its reference. */
typedef struct label_item {
    const char *name;       /* the argument */
    nqm_argument *argument; /* NULL: not parsed yet */
    const char *shown;      /* name in results: the argument, or the NAME of NAME=BRDF */
    nqm_texture *texture;   /* of a textured material; NULL: a BRDF */
    size_t reference;       /* index of the group's reference (of itself for a reference) */
    nqm_label label;        /* NaN for references and for tests that could not be rendered */
    double jod;             /* JOD of the label; NaN as there */
    double points_error;    /* the part of label.error that the choice of points makes */
    nqm_error err;
    bool is_done;     /* the label needs no more samples */
    rendered made;    /* of a BRDF; of a test, freed after it has been compared, unless keep_rgb */
    double *rgb_cdm2; /* (3, points, 3) with halves; NULL then, too */
    double valid;     /* the fraction of the light at directions where test and reference have a value */
} label_item;

typedef struct label_run {
    nqm_scene_options scene_options;
    nqm_scene *scene;
    nqm_texture_view view; /* of textured materials */
    size_t n_items, n_groups, n_done;
    label_item *items;
    result_format format;
    bool adds_samples; /* render again with more points and directions while the error of a label is large */
    bool keep_rgb;     /* keep the renderings of tests after the comparison, to draw them */
    /* figures; NULL: none */
    const char *map, *grid, *keep;
    size_t shrink;
    double *delta_e;    /* (n_items, points) of each test, by map_labels(); NULL: no maps */
    double delta_e_max; /* upper end of the colours of all maps */
} label_run;

/** For figures: average shrink x shrink rendered pixels into one. no_pictures: what to say where the scene has no pixels. */
void set_shrink(label_run *run, uint64_t shrink, const char *no_pictures);
/** Make the scene of run->scene_options, render the items and compare each test with its reference; errors of tests are
 *  stored in their items. On another failure, this and the functions below report the error and exit. */
void make_labels(label_run *run);
/** Compute the maps of the differences between each test and its reference, whose renderings were kept. */
void map_labels(label_run *run);
/** Free the items, the maps and the scene. */
void free_labels(label_run *run);

/** What `nqm label --json` prints. */
json_t *json_labels(const label_run *run);
/** The picture of an item that has one, (height, width, 3) of a canvas, and the map of a test, (height, width); NULL: there is none.
 *  free() them. */
double *item_picture(const label_run *run, size_t i, const canvas *c, backdrop kind);
double *item_map(const label_run *run, size_t i, const canvas *c);

#endif
