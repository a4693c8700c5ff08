/* SPDX-License-Identifier: MIT
 *
 * render.h - a lit smooth shape: light maps, the directions and weights of its quadrature, rendering of any BRDF. The
 * public half (nqm_scene_create, _free, _count, _render) is declared in <nqm/label.h>.
 *
 * World axes: y is up, the viewer is at infinity on +z, x is to the viewer's right. In a latitude-longitude map the
 * first row is up and the middle column is -z, what the viewer faces; columns run to the right.
 */
#ifndef NQM_SRC_RENDER_H
#define NQM_SRC_RENDER_H

#include "base/base.h"
#include "io/io.h"

#include <nqm/label.h>

/* ---- light ------------------------------------------------------------------------------------------------------- */

enum { NQM_LIGHT_WIDTH = 256, NQM_LIGHT_HEIGHT = 128, NQM_LIGHT_CELLS = NQM_LIGHT_WIDTH * NQM_LIGHT_HEIGHT };

/** Light from all directions, as a map of cells that is read with bilinear interpolation. Immutable once made. */
typedef struct nqm_light {
    double *rgb;       /* (NQM_LIGHT_HEIGHT, NQM_LIGHT_WIDTH, 3) radiance at the centre of the cell, any unit */
    double *direction; /* (NQM_LIGHT_HEIGHT, NQM_LIGHT_WIDTH, 3) unit vector to it */
    double *power; /* (NQM_LIGHT_HEIGHT, NQM_LIGHT_WIDTH) luminance of the interpolated map integrated over the cell */
    double solid_angle[NQM_LIGHT_HEIGHT]; /* of a cell of the row, sr */
} nqm_light;

/** World direction of a place in a latitude-longitude map; u, v in [0, 1] from its left and top. */
void nqm_map_direction(double u, double v, double *w);
/** Filter a picture to the cells of the map (area average), which also smooths it a little. */
NQM_MUST_CHECK nqm_status nqm_light_create(const nqm_image *image, nqm_light *light_ret, nqm_error *err);
/** Release what a light holds; a zeroed one is allowed. */
void nqm_light_clear(nqm_light *light);
/** Radiance from direction w (3). */
void nqm_light_eval(const nqm_light *light, const double *w, double *rgb);
/** The cell that direction w (3) falls into. */
size_t nqm_light_cell(const double *w);
/** A direction in a cell; u, v in [0, 1) move over it uniformly in solid angle. */
void nqm_light_direction(size_t cell, double u, double v, double *w);

/** Draw the built-in sky into a new picture (nqm_free its rgb). */
NQM_MUST_CHECK nqm_status nqm_sky_draw(nqm_image *image_ret, nqm_error *err);

/* ---- scene ------------------------------------------------------------------------------------------------------- */

/** One visible point of the shape with its local frame: third axis the normal, wo in the plane of first and third. */
typedef struct nqm_surface_point {
    double frame[9]; /* (3, 3) rows: tangent, bitangent, normal, in world axes */
    double wo[3];    /* local direction to the viewer */
} nqm_surface_point;

struct nqm_scene {
    size_t n_points, n_lights;
    double peak_cdm2;
    nqm_surface_point *point; /* (n_points) */
    size_t *n_used;           /* (n_points) directions above the horizon, <= n_lights */
    double *wi;               /* (n_points, n_lights, 3) local directions to the light, the first n_used are set */
    double *weight;           /* (n_points, n_lights, 3) radiance times cosine times solid angle, scaled to cd/m2 */
};

/** Light directions of one point and their weights: radiance times cosine times solid angle, in the light's unit. */
typedef struct nqm_direction_set {
    size_t n_max;         /* room for this many */
    size_t n_used;        /* of them above the horizon */
    double *wi;           /* (n_max, 3) local */
    double *weight;       /* (n_max, 3) */
    double irradiance[3]; /* the sum over all cells of the map; the weights sum to it */
} nqm_direction_set;

/** Fill a set whose n_max, wi and weight are given. The same seed gives the same directions; points that shall not
 * share their noise need seeds of their own. false when out of memory. */
bool nqm_choose_directions(const nqm_light *light, const nqm_surface_point *point, uint64_t seed,
                           nqm_direction_set *set);

#endif
