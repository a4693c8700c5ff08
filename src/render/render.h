/* SPDX-License-Identifier: MIT
 *
 * render.h - a lit shape: light maps, shapes and ray intersection, visible points, light directions and their quadrature
 * weights, rendering of any BRDF. The public functions (nqm_scene_*) are declared in <nqm/render.h>.
 *
 * World axes: y is up, the viewer is at infinity on +z (raised by the elevation), x is to the viewer's right. In a
 * latitude-longitude map the first row is up and the middle column is -z, the viewing direction; columns run to the
 * right. The axes of a shape are rotated about y by the turntable.
 */
#ifndef NQM_SRC_RENDER_H
#define NQM_SRC_RENDER_H

#include "base/options.h"
#include "brdf/brdf.h"
#include "io/io.h"
#include <nqm/render.h>

extern const nqm_option_table nqm_scene_option_table;
/** Light directions per point: n_lights, or the value that 0 stands for. */
size_t nqm_scene_n_lights(const nqm_scene_options *options);
/** Views of the turntable in each scene: n_frames, or the value that 0 stands for. */
size_t nqm_scene_n_frames(const nqm_scene_options *options);
/** Whether the options name no light and no shape, and so the standard set of NQM_STANDARD_SCENES scenes. */
bool nqm_scene_is_standard(const nqm_scene_options *options);
/** Frames of all scenes of the options together, for pixel indices. */
size_t nqm_scene_frames(const nqm_scene_options *options);
/** The light map behind the shape in a frame, with a vertical field of view of 60 degrees: rgb_cdm2 (height, width, 3). Only
 *  for scenes with a width. */
void nqm_scene_background(const nqm_scene *scene, size_t frame, double *rgb_cdm2);

/** nqm_scene_render() with halves. beside: where this BRDF has no value, `brdf` counts as without one, too; NULL: none. */
NQM_MUST_CHECK nqm_status nqm_scene_render_halves(const nqm_scene *scene, const nqm_brdf *brdf, const nqm_brdf *beside,
                                                  double *rgb_cdm2, double *valid_ret, nqm_error *err);
/** Whether nqm_scene_render() makes the picture of this BRDF from a table of its values (nqm_table_picture). */
bool nqm_scene_tabulates(const nqm_scene *scene, const nqm_brdf *brdf);

/** Light that point i of a scene without parts reflects to the viewer, in the light's unit, by each half of its light directions.
 *  beside: as in nqm_scene_render_halves(). lobe: of an anisotropic BRDF; NULL: it is isotropic. light: luminance that falls on
 *  the point, and the part of it at directions without a value. false: out of memory, half is 0. */
bool nqm_scene_reflect(const nqm_scene *scene, size_t i, const nqm_brdf *brdf, const nqm_brdf *beside,
                       const nqm_lobe *lobe, double half[2][3], double light[2]);
/** Write it to point i of a picture in cd/m2. stride: from the picture to that of the first half, and from there to that of the
 *  second, in values; 0: the picture only. */
void nqm_scene_store(const nqm_scene *scene, size_t i, double half[2][3], double *rgb_cdm2, size_t stride);

/** BRDFs that vary over the surface. */
typedef struct nqm_scene_surfaces {
    /** Positions per point, whose mean radiance the point shows: 1 is the point itself, more are stratified over its footprint, a
     *  square of the picture: its pixel, or in a scene without pixels the area that the point represents. */
    size_t n_samples;
    uint64_t seed; /**< of the positions */
    /** The BRDF at texture coordinates (<nqm/render.h>), which the caller frees, and its unit normal: components along
     *  the tangent, the bitangent (upwards) and the normal of the surface. Any thread; equal arguments give equal
     *  results. */
    nqm_status (*open)(void *user, const double uv[2], nqm_brdf **brdf_ret, double normal[3], nqm_error *err);
    void *user;
} nqm_scene_surfaces;

/** nqm_scene_render_halves() with a BRDF for each point. Light directions are placed by the normal of the BRDF. Fails
 *  with the error of the first point that `open` refuses; NQM_ERR_ARG with interreflection. */
NQM_MUST_CHECK nqm_status nqm_scene_render_each(const nqm_scene *scene, const nqm_scene_surfaces *surfaces,
                                                double *rgb_cdm2, nqm_error *err);
/** Texture coordinates of what the viewer sees beside point i, `offset` (2) to the right and up in sides of its footprint; the
 *  surface is continued by its tangent plane. */
void nqm_scene_texcoord(const nqm_scene *scene, size_t i, const double offset[2], double uv[2]);

/* ---- light ------------------------------------------------------------------------------------------------------- */

enum {
    NQM_GLOW_WIDTH = 64,
    NQM_LIGHT_WIDTH = 256,
    NQM_LIGHT_STEP = 16,
    NQM_LIGHT_MAX_WIDTH = 4096,
    NQM_LIGHT_LANES = 8
};

/** Light from all directions: a map of cells, interpolated bilinearly. Immutable; `rgb` owns the block of all arrays. */
typedef struct nqm_light {
    size_t width, height; /* height = width / 2 */
    double *rgb;          /* (height, width, 3) radiance at the centre of the cell, in an arbitrary unit */
    double *power;        /* (height, width) luminance of the interpolated map integrated over the cell */
    double *row_power;    /* (height + 1) sum of power over all previous rows */
    double *solid_angle;  /* (height) of a cell of the row, sr */
    double *polar;        /* (height, 2) sine and cosine of the angle between +y and the row's centre */
    double *azimuth;      /* (width, 2) sine and cosine of the angle from -z to the column's centre */
    float *summand;       /* (height, width / NQM_LIGHT_LANES, 4, NQM_LIGHT_LANES) power; R, G, B times solid angle */
} nqm_light;

/** World direction of the position (u, v) in a latitude-longitude map, in [0, 1] from the left and the top. */
void nqm_map_direction(double u, double v, double *w);
/** Filter a picture to the cells of a map (area average). width: a multiple of NQM_LIGHT_STEP. Free with
 *  nqm_free(light_ret->rgb). */
NQM_MUST_CHECK nqm_status nqm_light_create(const nqm_image *image, size_t width, nqm_light *light_ret, nqm_error *err);
/** Radiance from direction w (3). Returns the cell that w falls into. */
size_t nqm_light_eval(const nqm_light *light, const double *w, double *rgb);
/** A direction in a cell, uniform in solid angle for uniform u, v in [0, 1). */
void nqm_light_direction(const nqm_light *light, size_t cell, double u, double v, double *w);

/** Whether `name` is a built-in light: "sun", "overcast", "studio" or "interior". */
bool nqm_light_is_builtin(const char *name);
/** Draw a built-in light into a new picture (nqm_free its rgb). */
NQM_MUST_CHECK nqm_status nqm_light_draw(const char *name, nqm_image *image_ret, nqm_error *err);

/* ---- shapes ------------------------------------------------------------------------------------------------------ */

/** A mesh for ray intersection (Embree). */
typedef struct nqm_tracer nqm_tracer;

/** Embree's version, "3.13.5"; NULL: a build without Embree, where nqm_tracer_create() fails. */
const char *nqm_tracer_version(void);
/** Whether Embree can be loaded; false in a build without it. Loads it. */
bool nqm_tracer_available(void);
/** Build the hierarchy; positions are copied. */
NQM_MUST_CHECK nqm_status nqm_tracer_create(const nqm_mesh *mesh, nqm_tracer **tracer_ret, nqm_error *err);
void nqm_tracer_free(nqm_tracer *tracer);
/** The nearest triangle on a ray, and the barycentric coordinates (3) of the intersection. */
bool nqm_tracer_hit(const nqm_tracer *tracer, const double *origin, const double *direction, size_t *triangle,
                    double *corner_weight);
/** Whether anything is on a ray. */
bool nqm_tracer_blocked(const nqm_tracer *tracer, const double *origin, const double *direction);

/** A sphere or a mesh centred at the origin, in units of half the picture. Immutable. */
typedef struct nqm_shape {
    nqm_mesh mesh;
    nqm_tracer *tracer; /* NULL: the sphere */
    double radius;      /* radius of the sphere */
} nqm_shape;

/** The intersection of a ray with a shape, in the shape's axes. */
typedef struct nqm_hit {
    double origin[3]; /* origin of further rays, slightly above the surface */
    double normal[3]; /* unit, interpolated between the corners, facing the ray */
} nqm_hit;

/** Create the shape named by a scene's options and scale it to fit the picture during a whole turn: half_width and
 *  half_height in units of half the picture's shorter side. */
NQM_MUST_CHECK nqm_status nqm_shape_create(const char *name, double elevation_rad, double half_width,
                                           double half_height, nqm_shape *shape_ret, nqm_error *err);
/** Free the contents; a zeroed shape is allowed. */
void nqm_shape_clear(nqm_shape *shape);
bool nqm_shape_hit(const nqm_shape *shape, const double *origin, const double *direction, nqm_hit *hit);
bool nqm_shape_blocked(const nqm_shape *shape, const double *origin, const double *direction);
/** Tessellate the built-in blob. */
NQM_MUST_CHECK nqm_status nqm_blob_create(nqm_mesh *mesh_ret, nqm_error *err);

/* ---- points ------------------------------------------------------------------------------------------------------ */

/** One visible point of the shape with its local frame: third axis the normal, wo in the plane of first and third.
 *  Anisotropic BRDFs are evaluated in the axes of the surface, whose first is the tangent. It is horizontal, as on a
 *  turned workpiece: cross(up, normal), and the x axis where the normal is vertical; smooth elsewhere. */
typedef struct nqm_surface_point {
    double frame[9];   /* (3, 3) rows: the axes, in world axes */
    double tangent[2]; /* sine and cosine of the rotation (nqm_turn3) from the frame to the axes of the surface */
    double wo[3];      /* local direction to the viewer */
    double origin[3];  /* origin of shadow rays, in the shape's axes */
    double turn[2];    /* sine and cosine of the turntable's angle */
} nqm_surface_point;

/** The point at a hit, seen from world direction `towards` (3). Interpolated normals at more than 85 degrees from it are
 *  rotated to 85 degrees. */
void nqm_surface_point_make(const nqm_hit *hit, const double *turn, const double *towards, nqm_surface_point *point);
/** Convert a vector between the point's frame, world axes and the shape's axes. */
void nqm_world_from_local(const nqm_surface_point *point, const double *local, double *world);
void nqm_local_from_world(const nqm_surface_point *point, const double *world, double *local);
void nqm_shape_from_world(const double *turn, const double *world, double *in_shape);

/** The visible points of a shape. */
typedef struct nqm_seen {
    size_t n;
    void *block;              /* of all arrays */
    nqm_surface_point *point; /* (n); NULL for large pictures: nqm_scene_point() computes them from their pixels */
    size_t *pixel;            /* (n) (frame * height + y) * width + x; NULL unless the options have a width */
    double *weight;           /* (n) fraction of the picture that the point represents, summing to 1; NULL: 1/n */
} nqm_seen;

/** The pixels of a picture that show the shape. seen: zeroed; free seen->block, also after a failure. */
NQM_MUST_CHECK nqm_status nqm_view_pixels(const nqm_shape *shape, const nqm_scene_options *options, nqm_seen *seen,
                                          nqm_error *err);
/** Without a picture: points whose normals are distributed as those of the pixels; else as nqm_view_pixels(). glow: the light map
 *  at NQM_GLOW_WIDTH, which predicts where highlights may be; unused for spheres. */
NQM_MUST_CHECK nqm_status nqm_spread_points(const nqm_shape *shape, const nqm_light *glow,
                                            const nqm_scene_options *options, nqm_seen *seen, nqm_error *err);
/** Axes of the viewer in world coordinates: axes (3, 3), rows right, up and towards the viewer. */
void nqm_view_axes(double elevation_rad, double *axes);

/* ---- directions -------------------------------------------------------------------------------------------------- */

/** Light directions of one point and their weights: radiance times cosine times solid angle, in the light's unit. */
typedef struct nqm_direction_set {
    size_t n_max;         /* capacity */
    size_t n_used;        /* directions above the horizon */
    size_t n_first;       /* number in the first half: every second direction of each technique */
    double *wi;           /* (n_max, 3) local */
    double *weight;       /* (n_max, 3) */
    double *extent;       /* (n_max) cosine times solid angle; may be NULL */
    double irradiance[3]; /* sum over all cells of the map, and of the weights */
} nqm_direction_set;

/** Fill a set whose n_max and arrays are given. lobe: of the BRDF; NULL: round. Directions are a function of the seed; use
 *  a different seed for each point to decorrelate their noise. false: out of memory. */
bool nqm_choose_directions(const nqm_light *light, const nqm_surface_point *point, const nqm_lobe *lobe, uint64_t seed,
                           nqm_direction_set *set);
/** A faster variant for few directions: importance of the light map without the cosine; irradiance is not set. */
bool nqm_choose_few_directions(const nqm_light *light, const nqm_surface_point *point, uint64_t seed,
                               nqm_direction_set *set);
/** Irradiance of a point without shadows, as in the set. rgb: (3). false: out of memory. */
bool nqm_irradiance(const nqm_light *light, const nqm_surface_point *point, double *rgb);

/* ---- incident light ---------------------------------------------------------------------------------------------- */

/** Light from one direction with nonzero weight. */
typedef struct nqm_ray {
    float wi[3];     /* local, towards the light */
    float weight[3]; /* radiance times cosine times solid angle, in the light's unit */
} nqm_ray;

/** Unit vector to the light of a ray, and its light in cd/m2 times cosine times solid angle. */
void nqm_ray_light(const nqm_ray *ray, double exposure, double wi[3], double light[3]);

enum { NQM_BOUNCE_LIGHTS = 12 };

/** Light reflected by another part of the shape. */
typedef struct nqm_bounce {
    float wi[3], extent; /* as in nqm_direction_set */
    float wo[3];         /* direction towards the point, in the frame of that part */
    float tangent[2];    /* of that part, as in nqm_surface_point */
    uint32_t n_rays;
    nqm_ray ray[NQM_BOUNCE_LIGHTS]; /* light that reaches that part */
} nqm_bounce;

/** Incident light of one point; `ray` owns the block of both arrays. */
typedef struct nqm_incident {
    size_t n_rays, n_bounces;
    size_t n_first_rays, n_first_bounces; /* numbers in the first half of the directions */
    nqm_ray *ray;                         /* (n_rays) */
    nqm_bounce *bounce;                   /* (n_bounces) */
} nqm_incident;

enum { NQM_STANDARD_SCENES = 4 };

/** One scene, which is its only part, or several: then the points of the parts follow each other, and of the fields
 *  below `parts` only weight and pixel are used. */
struct nqm_scene {
    nqm_scene_options options; /* n_lights and n_frames filled in; strings NULL */
    size_t n_parts;            /* at least 1 */
    nqm_scene *parts[NQM_STANDARD_SCENES];
    nqm_light light;
    nqm_shape shape;
    nqm_seen seen;
    nqm_incident *kept; /* (seen.n); NULL: too large to store, computed again for every picture */
    double exposure;    /* cd/m2 for one unit of the light */
};

/** Point i, stored or computed into `made`. Not for a scene of several parts. */
const nqm_surface_point *nqm_scene_point(const nqm_scene *scene, size_t i, nqm_surface_point *made);

/** Place of a scene among n parts, and the options of the whole. */
typedef struct nqm_scene_part {
    const nqm_scene_options *options;
    size_t index, n;
} nqm_scene_part;
/** A ticker of the callback of the options, which reports percent of all parts if there are several. */
nqm_ticker nqm_scene_part_ticker(nqm_scene_part *part);

/** Incident light of point i, from directions for a lobe as in nqm_choose_directions(); free with
 *  nqm_free(incident->ray). irradiance: (3) without shadows; may be NULL. false: out of memory. */
bool nqm_incident_make(const nqm_scene *scene, size_t i, const nqm_lobe *lobe, nqm_incident *incident,
                       double *irradiance);

/* ---- the viewer's rays in one frame of the turntable (view.c, spread.c) ------------------------------------------ */

#define NQM_VIEW_MAX_DEG 85.0 /* BRDFs are unreliable at larger angles; less than 1 % of the picture of a sphere */

/** Uniform in [0, 1), from a hash. */
static inline double nqm_random_unit(uint64_t seed, uint64_t counter) {
    return (double)(nqm_hash_u64(seed, counter) >> 11) * 0x1p-53;
}

/** The viewer and one frame of the turntable. */
typedef struct nqm_view {
    const nqm_shape *shape;
    double axes[9];
    double distance; /* distance of the rays' origins, outside the shape */
    double turn[2];
} nqm_view;

nqm_view nqm_view_make(const nqm_shape *shape, const nqm_scene_options *o, size_t frame);
/** The visible point at (x, y), in units of half the picture's shorter side from its centre, right and up; false: none. */
bool nqm_view_look(const nqm_view *view, double x, double y, nqm_surface_point *point);

/** Fill point (n_points) evenly over the picture of a sphere. */
void nqm_spread_sphere(const nqm_scene_options *o, nqm_surface_point *point);

#endif
