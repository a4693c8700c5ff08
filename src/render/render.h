/* SPDX-License-Identifier: MIT
 *
 * render.h - a lit shape: light maps, shapes and the rays that meet them, the points that a viewer sees, the directions
 * and weights of their quadrature, rendering of any BRDF. The public half (nqm_scene_*) is declared in <nqm/render.h>.
 *
 * World axes: y is up, the viewer is at infinity on +z (raised by the elevation), x is to the viewer's right. In a
 * latitude-longitude map the first row is up and the middle column is -z, what the viewer faces; columns run to the
 * right. A shape has axes of its own, which the turntable turns about y.
 */
#ifndef NQM_SRC_RENDER_H
#define NQM_SRC_RENDER_H

#include "base/base.h"
#include "io/io.h"

#include <nqm/render.h>

/* ---- light ------------------------------------------------------------------------------------------------------- */

enum { NQM_GLOW_WIDTH = 64, NQM_LIGHT_WIDTH = 256, NQM_LIGHT_STEP = 16, NQM_LIGHT_MAX_WIDTH = 4096 };

/** Light from all directions, as a map of cells that is read with bilinear interpolation. Immutable once made. */
typedef struct nqm_light {
    size_t width, height; /* height = width / 2 */
    double *rgb;          /* (height, width, 3) radiance at the centre of the cell, any unit */
    double *power;        /* (height, width) luminance of the interpolated map integrated over the cell */
    double *row_power;    /* (height + 1) its sum over the rows above each */
    double *solid_angle;  /* (height) of a cell of the row, sr */
    double *polar;        /* (height, 2) sine and cosine of the angle between +y and the row's centre */
    double *azimuth;      /* (width, 2) sine and cosine of the angle from -z to the column's centre */
    float *plane;         /* (4, height, width) power; R, G, B times solid angle: what is summed at every point */
} nqm_light;

/** World direction of a place in a latitude-longitude map; u, v in [0, 1] from its left and top. */
void nqm_map_direction(double u, double v, double *w);
/** Filter a picture to the cells of a map (area average), which also smooths it a little. width: a multiple of
 *  NQM_LIGHT_STEP. */
NQM_MUST_CHECK nqm_status nqm_light_create(const nqm_image *image, size_t width, nqm_light *light_ret, nqm_error *err);
/** Release what a light holds; a zeroed one is allowed. */
void nqm_light_clear(nqm_light *light);
/** Radiance from direction w (3). Returns the cell that w falls into. */
size_t nqm_light_eval(const nqm_light *light, const double *w, double *rgb);
/** A direction in a cell; u, v in [0, 1) move over it uniformly in solid angle. */
void nqm_light_direction(const nqm_light *light, size_t cell, double u, double v, double *w);

/** Draw the built-in sky into a new picture (nqm_free its rgb). */
NQM_MUST_CHECK nqm_status nqm_sky_draw(nqm_image *image_ret, nqm_error *err);

/* ---- shapes ------------------------------------------------------------------------------------------------------ */

/** A mesh that rays can be sent to (Embree). */
typedef struct nqm_tracer nqm_tracer;

/** Embree's version, "3.13.5"; NULL: this build has none, and nqm_tracer_create() says so. */
const char *nqm_tracer_version(void);
/** Build the hierarchy; positions are copied. */
NQM_MUST_CHECK nqm_status nqm_tracer_create(const nqm_mesh *mesh, nqm_tracer **tracer_ret, nqm_error *err);
void nqm_tracer_free(nqm_tracer *tracer);
/** The nearest triangle that a ray meets, and the weights of its three corners there. */
bool nqm_tracer_hit(const nqm_tracer *tracer, const double *origin, const double *direction, size_t *triangle,
                    double *corner_weight);
/** Whether a ray meets anything. */
bool nqm_tracer_blocked(const nqm_tracer *tracer, const double *origin, const double *direction);

/** A sphere, or a mesh: about the origin, in units of half a picture. Immutable once made. */
typedef struct nqm_shape {
    nqm_mesh mesh;
    nqm_tracer *tracer; /* NULL: the sphere */
    double radius;      /* of the sphere */
} nqm_shape;

/** Where a ray meets a shape, in the shape's axes. */
typedef struct nqm_hit {
    double origin[3]; /* of further rays: a little above the surface */
    double normal[3]; /* unit, interpolated between the corners, on the side that was met */
} nqm_hit;

/** Make the shape that a scene's options name, and fit it to the picture over a whole turn: half_width, half_height in
 *  units of half the picture's shorter side. */
NQM_MUST_CHECK nqm_status nqm_shape_create(const char *name, double elevation_rad, double half_width,
                                           double half_height, nqm_shape *shape_ret, nqm_error *err);
/** The same of a mesh in memory, which is taken over also on failure. */
NQM_MUST_CHECK nqm_status nqm_shape_from_mesh(nqm_mesh *mesh, double elevation_rad, double half_width,
                                              double half_height, nqm_shape *shape_ret, nqm_error *err);
/** Release what a shape holds; a zeroed one is allowed. */
void nqm_shape_clear(nqm_shape *shape);
bool nqm_shape_hit(const nqm_shape *shape, const double *origin, const double *direction, nqm_hit *hit);
bool nqm_shape_blocked(const nqm_shape *shape, const double *origin, const double *direction);
/** Tessellate the built-in blob. */
NQM_MUST_CHECK nqm_status nqm_blob_create(nqm_mesh *mesh_ret, nqm_error *err);

/* ---- points ------------------------------------------------------------------------------------------------------ */

/** One visible point of the shape with its local frame: third axis the normal, wo in the plane of first and third. */
typedef struct nqm_surface_point {
    double frame[9];  /* (3, 3) rows: tangent, bitangent, normal, in world axes */
    double wo[3];     /* local direction to the viewer */
    double origin[3]; /* of shadow rays, in the shape's axes */
    double turn[2];   /* sine and cosine of the turntable's angle */
} nqm_surface_point;

/** The point at a hit, seen from world direction `towards` (3). A normal that leans more than 85 degrees from it, as
 *  interpolation can give, is bent back to 85. */
void nqm_surface_point_make(const nqm_hit *hit, const double *turn, const double *towards, nqm_surface_point *point);
/** A vector in the point's frame, in world axes, in the shape's axes. */
void nqm_world_from_local(const nqm_surface_point *point, const double *local, double *world);
void nqm_local_from_world(const nqm_surface_point *point, const double *world, double *local);
void nqm_shape_from_world(const double *turn, const double *world, double *in_shape);

/** What the viewer sees of a shape. */
typedef struct nqm_seen {
    size_t n;
    nqm_surface_point *point; /* (n) */
    size_t *pixel;            /* (n) (frame * height + y) * width + x; NULL unless the options have a width */
    double *share;            /* (n) of the whole picture, summing to 1; NULL: all alike */
} nqm_seen;

/** glow: the light map at NQM_GLOW_WIDTH, which says where highlights may be; unused for pictures and spheres. */
NQM_MUST_CHECK nqm_status nqm_view_points(const nqm_shape *shape, const nqm_light *glow,
                                          const nqm_scene_options *options, nqm_seen *seen_ret, nqm_error *err);
/** Release what it holds; a zeroed one is allowed. */
void nqm_seen_clear(nqm_seen *seen);
/** Axes of the viewer in world axes: axes (3, 3) rows to the right, up, towards the viewer. */
void nqm_view_axes(double elevation_rad, double *axes);

/* ---- directions -------------------------------------------------------------------------------------------------- */

/** Light directions of one point and their weights: radiance times cosine times solid angle, in the light's unit. */
typedef struct nqm_direction_set {
    size_t n_max;         /* room for this many */
    size_t n_used;        /* of them above the horizon */
    double *wi;           /* (n_max, 3) local */
    double *weight;       /* (n_max, 3) */
    double *extent;       /* (n_max) cosine times solid angle; NULL: not wanted */
    double irradiance[3]; /* the sum over all cells of the map; the weights sum to it */
} nqm_direction_set;

/** Fill a set whose n_max and arrays are given. The same seed gives the same directions; points that shall not share
 *  their noise need seeds of their own. false when out of memory. */
bool nqm_choose_directions(const nqm_light *light, const nqm_surface_point *point, uint64_t seed,
                           nqm_direction_set *set);
/** A quicker way for few directions: the light map is drawn from without the cosine; irradiance is not set. */
bool nqm_choose_few_directions(const nqm_light *light, const nqm_surface_point *point, uint64_t seed,
                               nqm_direction_set *set);
/** Irradiance of a point without shadows, as in the set. rgb: (3). false when out of memory. */
bool nqm_irradiance(const nqm_light *light, const nqm_surface_point *point, double *rgb);

/* ---- incident light ---------------------------------------------------------------------------------------------- */

/** Light from one direction; zero weights are not kept. */
typedef struct nqm_ray {
    float wi[3];     /* local, towards the light */
    float weight[3]; /* radiance times cosine times solid angle, in the light's unit */
} nqm_ray;

enum { NQM_BOUNCE_LIGHTS = 12 };

/** Light from a part of the shape that stands in the way. */
typedef struct nqm_bounce {
    float wi[3], extent; /* as in nqm_direction_set */
    float wo[3];         /* local to the part that is met, towards the point */
    uint32_t n_rays;
    nqm_ray ray[NQM_BOUNCE_LIGHTS]; /* what reaches it */
} nqm_bounce;

/** All that reaches one point. */
typedef struct nqm_incident {
    size_t n_rays, n_bounces;
    nqm_ray *ray;       /* (n_rays) */
    nqm_bounce *bounce; /* (n_bounces) */
} nqm_incident;

struct nqm_scene {
    nqm_scene_options options; /* n_lights filled in; strings NULL */
    nqm_light light;
    nqm_shape shape;
    nqm_seen seen;
    nqm_incident *kept; /* (seen.n); NULL: too much to keep, made anew for every picture */
    double exposure;    /* cd/m2 for one unit of the light */
};

/** What reaches point i. irradiance: (3) without shadows; NULL: not wanted. false when out of memory. */
bool nqm_incident_make(const nqm_scene *scene, size_t i, nqm_incident *incident, double *irradiance);
void nqm_incident_clear(nqm_incident *incident);

#endif
