/* SPDX-License-Identifier: MIT
 *
 * Pictures of a surface whose BRDF varies: texture coordinates of the points, and the mean light of several positions of each.
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>
#include <stdatomic.h>

/* ---- texture coordinates ------------------------------------------------------------------------------------------- */

/* Side of the square of the picture that a point represents, in units of its position. Points of the spread sphere have
 * no position: their normals are on a sphere of radius 1. The points of a mesh cover about a disc of nine tenths of the
 * picture. */
static double footprint_side(const nqm_scene *scene, size_t i) {
    const nqm_scene_options *o = &scene->options;
    if (scene->seen.pixel)
        return 2 / (double)nqm_smaller(o->width, o->height);
    if (!scene->seen.weight)
        return sin(NQM_VIEW_MAX_DEG * NQM_PI / 180) * sqrt(NQM_PI / (double)scene->seen.n);
    return 0.9 * sqrt(NQM_PI * (double)o->n_frames * scene->seen.weight[i]);
}

void nqm_scene_texcoord(const nqm_scene *scene, size_t i, const double offset[2], double uv[2]) {
    nqm_surface_point made;
    const nqm_surface_point *point = nqm_scene_point(scene, i, &made);
    const double *normal = point->frame + 6, side = footprint_side(scene, i);
    const bool has_position = scene->seen.pixel || scene->seen.weight;
    double axes[9], step[3], at[3];
    nqm_view_axes(scene->options.elevation_rad, axes);
    for (int k = 0; k < 3; ++k)
        step[k] = side * (offset[0] * axes[k] + offset[1] * axes[3 + k]);
    const double depth = -nqm_dot3(step, normal) / nqm_dot3(axes + 6, normal);
    for (int k = 0; k < 3; ++k)
        step[k] += depth * axes[6 + k];
    nqm_shape_from_world(point->turn, step, step);
    nqm_shape_from_world(point->turn, normal, at);
    for (int k = 0; k < 3; ++k)
        at[k] = (has_position ? point->origin[k] : at[k]) + step[k];
    nqm_normalize3(at);
    uv[0] = 0.5 + atan2(at[0], at[2]) / (2 * NQM_PI);
    uv[1] = acos(fmin(fmax(at[1], -1), 1)) / NQM_PI;
}

/* ---- light --------------------------------------------------------------------------------------------------------- */

typedef struct rendering {
    const nqm_scene *scene;
    const nqm_scene_surfaces *surfaces;
    double *rgb_cdm2;
    size_t stride;
    atomic_size_t first_failed; /* point; SIZE_MAX: none so far */
} rendering;

/* Light of a BRDF with a normal of its own, whose lobe places the light directions. An isotropic one has its lobe at the normal.
 * Steeper normals than least_z, also those that point downwards, show hardly more than the horizon. */
static nqm_status reflect(const nqm_scene *scene, size_t i, nqm_brdf *of, double *normal, double half[2][3],
                          nqm_error *err) {
    static const double least_z = 0.05;
    const bool is_tilted = normal[0] != 0 || normal[1] != 0, is_anisotropic = nqm_brdf_anisotropy(of) > 0;
    nqm_brdf *tilted = NULL;
    normal[2] = fmax(normal[2], least_z);
    nqm_normalize3(normal);
    nqm_status status = is_tilted ? nqm_brdf_tilt(of, normal, &tilted, err) : NQM_OK;
    if (status != NQM_OK)
        return status;
    const nqm_brdf *shown = is_tilted ? tilted : of;
    const nqm_lobe lobe = is_anisotropic
                              ? nqm_lobe_measure(shown)
                              : (nqm_lobe){{normal[0] / normal[2], normal[1] / normal[2]}, {1, 0, 0, 1}, .width = 1};
    double light[2];
    if (!nqm_scene_reflect(scene, i, shown, NULL, is_tilted || is_anisotropic ? &lobe : NULL, half, light))
        status = nqm_fail_nomem(err, scene->options.n_lights * sizeof(nqm_ray));
    for (size_t k = 0; status == NQM_OK && k < 6; ++k)
        if (!isfinite(half[k / 3][k % 3]))
            status = nqm_fail(err, NQM_ERR_NUMERIC, -1, "%s: the picture is not finite", of->info.name);
    nqm_brdf_free(tilted);
    return status;
}

/* Sample k of n in the unit square about 0: strata along the first axis, a golden-ratio lattice along the second. */
static void place_sample(size_t k, size_t n, uint64_t seed, double offset[2]) {
    const double golden = 0.6180339887498949 * (double)k + nqm_random_unit(seed, n);
    offset[0] = n > 1 ? ((double)k + nqm_random_unit(seed, k)) / (double)n - 0.5 : 0;
    offset[1] = n > 1 ? golden - floor(golden) - 0.5 : 0;
}

static nqm_status render_point(const rendering *r, size_t i, nqm_error *err) {
    const nqm_scene *scene = r->scene;
    const size_t n = r->surfaces->n_samples;
    const uint64_t seed = nqm_hash_u64(nqm_hash_u64(r->surfaces->seed, scene->options.seed), i);
    double mean[2][3] = {{0}};
    nqm_status status = NQM_OK;
    for (size_t k = 0; status == NQM_OK && k < n; ++k) {
        double offset[2], uv[2], normal[3], half[2][3];
        nqm_brdf *brdf;
        place_sample(k, n, seed, offset);
        nqm_scene_texcoord(scene, i, offset, uv);
        status = r->surfaces->open(r->surfaces->user, uv, &brdf, normal, err);
        if (status != NQM_OK)
            break;
        status = reflect(scene, i, brdf, normal, half, err);
        nqm_brdf_free(brdf);
        for (size_t j = 0; status == NQM_OK && j < 6; ++j) /* of equal samples, exactly their value */
            mean[j / 3][j % 3] += (half[j / 3][j % 3] - mean[j / 3][j % 3]) / (double)(k + 1);
    }
    nqm_scene_store(scene, i, mean, r->rgb_cdm2, r->stride);
    return status;
}

/* The first failure is that of the smallest index for any number of threads: only points after a failed one are left out. */
static void try_point(void *user, size_t i) {
    rendering *r = user;
    size_t failed = atomic_load(&r->first_failed);
    if (i > failed || render_point(r, i, NULL) == NQM_OK)
        return;
    while (i < failed && !atomic_compare_exchange_weak(&r->first_failed, &failed, i)) {
    }
}

static nqm_status render(rendering *r, nqm_ticker *ticker, nqm_error *err) {
    atomic_store(&r->first_failed, SIZE_MAX);
    if (nqm_parallel_ticking(ticker, "render", r->scene->seen.n, try_point, r))
        return nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted");
    const size_t failed = atomic_load(&r->first_failed);
    if (failed == SIZE_MAX)
        return NQM_OK;
    nqm_status status = render_point(r, failed, err); /* again, for the message */
    return status == NQM_OK ? nqm_fail_nomem(err, r->scene->options.n_lights * sizeof(nqm_ray)) : status;
}

nqm_status nqm_scene_render_each(const nqm_scene *scene, const nqm_scene_surfaces *surfaces, double *rgb_cdm2,
                                 nqm_error *err) {
    const nqm_scene_options *o = &scene->options;
    rendering r = {.scene = scene, .surfaces = surfaces, .rgb_cdm2 = rgb_cdm2, .stride = 3 * scene->seen.n};
    if (o->interreflection)
        return nqm_fail(err, NQM_ERR_ARG, -1, "a textured material has no picture with interreflection: leave it out");
    nqm_status status = NQM_OK;
    for (size_t p = 0; status == NQM_OK && p < scene->n_parts; ++p) {
        nqm_scene_part place = {o, p, scene->n_parts};
        nqm_ticker ticker = nqm_scene_part_ticker(&place);
        r.scene = scene->parts[p];
        status = render(&r, &ticker, err);
        r.rgb_cdm2 += 3 * r.scene->seen.n;
    }
    return status;
}
