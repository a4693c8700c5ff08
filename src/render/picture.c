/* SPDX-License-Identifier: MIT
 *
 * Pictures of a scene: the light reflected by a BRDF at every point, and the background.
 */
#include "brdf/brdf.h"
#include "math/math.h"
#include "render/render.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { BLOCK = 256 };

typedef struct rendering {
    const nqm_scene *scene;
    const nqm_brdf *brdf;
    const nqm_brdf *beside; /* where it has no value, the BRDF has none; NULL: none */
    const nqm_lobe *lobe;   /* of an anisotropic BRDF; NULL: it is isotropic */
    double *rgb_cdm2;       /* (n, 3) of the scene */
    double *light;          /* (n, 2) of the points: luminance of their light, and the part of it without a value */
    size_t stride;          /* as of nqm_scene_store() */
    atomic_bool out_of_memory;
} rendering;

/* Convert to double and normalise; after single precision one Newton step suffices. */
static void from_float(const float *f, double *v) {
    for (int k = 0; k < 3; ++k)
        v[k] = (double)f[k];
    double scale = 1.5 - 0.5 * nqm_dot3(v, v);
    for (int k = 0; k < 3; ++k)
        v[k] *= scale;
}

/* A BRDF in the frame of a point. */
typedef struct surface {
    const nqm_brdf *brdf, *beside;
    double tangent[2];
} surface;

/* nqm_brdf_eval() of directions in the frame of the point, which become those of the surface. */
static void eval(const surface *s, size_t n, double *wi, double *wo, double *f, uint8_t *flag) {
    const bool is_isotropic = s->brdf->info.isotropic && (!s->beside || s->beside->info.isotropic);
    for (size_t j = 0; !is_isotropic && j < n; ++j) {
        nqm_turn3(s->tangent, wi + 3 * j, wi + 3 * j);
        nqm_turn3(s->tangent, wo + 3 * j, wo + 3 * j);
    }
    nqm_brdf_eval(s->brdf, n, wi, wo, f, flag);
    if (!s->beside)
        return;
    double f_beside[3 * BLOCK];
    uint8_t flag_beside[BLOCK];
    nqm_brdf_eval(s->beside, n, wi, wo, f_beside, flag_beside);
    for (size_t j = 0; j < n; ++j)
        if (!nqm_has_value(flag_beside[j])) {
            flag[j] = NQM_VALUE_INVALID;
            f[3 * j] = f[3 * j + 1] = f[3 * j + 2] = 0;
        }
}

/* Add the light of n rays that the surface reflects to wo, and to light (2) what falls on it and the part without a value. */
static void reflect(const surface *s, size_t n_rays, const nqm_ray *ray, const double *wo_one, double *sum,
                    double *light) {
    double wi[3 * BLOCK], wo[3 * BLOCK], f[3 * BLOCK];
    uint8_t flag[BLOCK];
    for (size_t first = 0; first < n_rays; first += BLOCK) {
        size_t left = n_rays - first, n = left < BLOCK ? left : BLOCK;
        for (size_t j = 0; j < n; ++j) {
            from_float(ray[first + j].wi, wi + 3 * j);
            memcpy(wo + 3 * j, wo_one, 3 * sizeof *wo);
        }
        eval(s, n, wi, wo, f, flag);
        for (size_t j = 0; j < n; ++j) {
            const float *weight = ray[first + j].weight;
            const double y = nqm_luminance((double[3]){(double)weight[0], (double)weight[1], (double)weight[2]});
            light[0] += y;
            light[1] += nqm_has_value(flag[j]) ? 0 : y;
            for (size_t k = 0; k < 3; ++k)
                sum[k] += f[3 * j + k] * (double)weight[k];
        }
    }
}

static void reflect_bounce(const surface *s, const nqm_bounce *bounce, const double *wo, double *sum) {
    const surface met = {s->brdf, s->beside, {(double)bounce->tangent[0], (double)bounce->tangent[1]}};
    double wi[3], from[3], to[3], f[3], radiance[3] = {0}, light[2] = {0};
    uint8_t flag;
    from_float(bounce->wo, from);
    reflect(&met, bounce->n_rays, bounce->ray, from, radiance, light);
    from_float(bounce->wi, wi);
    memcpy(to, wo, sizeof to);
    eval(s, 1, wi, to, f, &flag);
    for (int k = 0; k < 3; ++k)
        sum[k] += f[k] * radiance[k] * (double)bounce->extent;
}

bool nqm_scene_reflect(const nqm_scene *scene, size_t i, const nqm_brdf *brdf, const nqm_brdf *beside,
                       const nqm_lobe *lobe, double half[2][3], double light[2]) {
    nqm_surface_point made_point;
    const nqm_surface_point *point = nqm_scene_point(scene, i, &made_point);
    const surface s = {brdf, beside, {point->tangent[0], point->tangent[1]}};
    nqm_incident made = {0};
    const bool is_kept = scene->kept && !lobe;
    memset(half, 0, 2 * sizeof *half);
    memset(light, 0, 2 * sizeof *light);
    if (!is_kept && !nqm_incident_make(scene, i, lobe, &made, NULL))
        return false;
    const nqm_incident *incident = is_kept ? &scene->kept[i] : &made;
    reflect(&s, incident->n_first_rays, incident->ray, point->wo, half[0], light);
    reflect(&s, incident->n_rays - incident->n_first_rays, incident->ray + incident->n_first_rays, point->wo, half[1],
            light);
    for (size_t j = 0; j < incident->n_bounces; ++j)
        reflect_bounce(&s, &incident->bounce[j], point->wo, half[j >= incident->n_first_bounces]);
    nqm_free(made.ray);
    return true;
}

void nqm_scene_store(const nqm_scene *scene, size_t i, double half[2][3], double *rgb_cdm2, size_t stride) {
    for (size_t k = 0; k < 3; ++k) {
        rgb_cdm2[3 * i + k] = (half[0][k] + half[1][k]) * scene->exposure;
        for (size_t h = 0; h < 2 && stride; ++h)
            rgb_cdm2[(1 + h) * stride + 3 * i + k] = 2 * half[h][k] * scene->exposure;
    }
}

static void render_point(void *user, size_t i) {
    rendering *r = user;
    double half[2][3];
    if (!nqm_scene_reflect(r->scene, i, r->brdf, r->beside, r->lobe, half, r->light + 2 * i))
        atomic_store(&r->out_of_memory, true);
    nqm_scene_store(r->scene, i, half, r->rgb_cdm2, r->stride);
}

/* The fraction of the light on the points of a scene that falls at directions with a value. */
static double valid_fraction(const nqm_scene *scene, const double *light) {
    double all = 0, lost = 0;
    for (size_t i = 0; i < scene->seen.n; ++i) {
        const double weight = scene->seen.weight ? scene->seen.weight[i] : 1;
        all += weight * light[2 * i];
        lost += weight * light[2 * i + 1];
    }
    return all > 0 ? 1 - lost / all : 1;
}

static nqm_status check_picture(const rendering *r, nqm_error *err) {
    if (atomic_load(&r->out_of_memory))
        return nqm_fail_nomem(err, r->scene->options.n_lights * sizeof(nqm_ray));
    for (size_t i = 0; i < 3 * r->scene->seen.n; ++i)
        if (!isfinite(r->rgb_cdm2[i]))
            return nqm_fail(err, NQM_ERR_NUMERIC, -1, "%s: the picture is not finite", r->brdf->info.name);
    return NQM_OK;
}

static nqm_status render(rendering *r, nqm_ticker *ticker, double *valid, nqm_error *err) {
    const bool is_anisotropic = nqm_brdf_anisotropy(r->brdf) > 0;
    const nqm_lobe lobe = is_anisotropic ? nqm_lobe_measure(r->brdf) : (nqm_lobe){.width = 0};
    r->lobe = is_anisotropic ? &lobe : NULL;
    r->light = nqm_alloc(r->scene->seen.n, 2 * sizeof *r->light);
    if (!r->light)
        return nqm_fail_nomem(err, r->scene->seen.n * 2 * sizeof *r->light);
    const nqm_status status = nqm_parallel_ticking(ticker, "render", r->scene->seen.n, render_point, r)
                                  ? nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted")
                                  : check_picture(r, err);
    *valid = valid_fraction(r->scene, r->light);
    nqm_free(r->light);
    return status;
}

bool nqm_scene_tabulates(const nqm_scene *scene, const nqm_brdf *brdf) {
    const size_t n_nodes = nqm_table_picture.n_h * nqm_table_picture.n_d * nqm_table_picture.n_p;
    return !scene->options.exact && brdf->class_->is_costly &&
           scene->seen.n > n_nodes / scene->options.n_lights; /* fewer directions than nodes: a table would cost more */
}

/* r: BRDFs, picture and stride; *valid: of the scenes with the same weight. */
static nqm_status render_all(const nqm_scene *scene, rendering r, double *valid, nqm_error *err) {
    const nqm_scene_options *o = &scene->options;
    nqm_status status = NQM_OK;
    *valid = 1;
    if (nqm_scene_tabulates(scene, r.brdf)) {
        nqm_ticker whole = {.fn = o->progress, .user = o->progress_user};
        nqm_brdf *table;
        nqm_status made = nqm_brdf_tabulate(r.brdf, nqm_table_picture, &whole, &table, err);
        r.brdf = table;
        made = made == NQM_OK ? render_all(scene, r, valid, err) : made;
        nqm_brdf_free(table);
        return made;
    }
    for (size_t p = 0; status == NQM_OK && p < scene->n_parts; ++p) {
        nqm_scene_part place = {o, p, scene->n_parts};
        nqm_ticker ticker = nqm_scene_part_ticker(&place);
        double valid_part = 1;
        r.scene = scene->parts[p];
        status = render(&r, &ticker, &valid_part, err);
        *valid -= (1 - valid_part) / (double)scene->n_parts;
        r.rgb_cdm2 += 3 * r.scene->seen.n;
    }
    return status;
}

static nqm_status render_checked(const nqm_scene *scene, rendering r, double *valid_ret, nqm_error *err) {
    double valid;
    nqm_status status = render_all(scene, r, &valid, err);
    if (status == NQM_OK && valid < scene->options.min_valid)
        status = nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                          "%s%s%s: values at directions of %.1f %% of the light of the scene, and %g %% are required "
                          "(--min-valid, min_valid)",
                          r.brdf->info.name, r.beside ? " and " : "", r.beside ? r.beside->info.name : "", 100 * valid,
                          100 * scene->options.min_valid);
    if (valid_ret)
        *valid_ret = valid;
    return status;
}

nqm_status nqm_scene_render(const nqm_scene *scene, const nqm_brdf *brdf, int with_halves, double *rgb_cdm2,
                            double *valid_ret, nqm_error *err) {
    NQM_REQUIRE(err, scene, brdf, rgb_cdm2);
    if (with_halves)
        return nqm_scene_render_halves(scene, brdf, NULL, rgb_cdm2, valid_ret, err);
    return render_checked(scene, (rendering){.brdf = brdf, .rgb_cdm2 = rgb_cdm2}, valid_ret, err);
}

nqm_status nqm_scene_render_halves(const nqm_scene *scene, const nqm_brdf *brdf, const nqm_brdf *beside,
                                   double *rgb_cdm2, double *valid_ret, nqm_error *err) {
    const rendering r = {.brdf = brdf, .beside = beside, .rgb_cdm2 = rgb_cdm2, .stride = 3 * scene->seen.n};
    return render_checked(scene, r, valid_ret, err);
}

void nqm_scene_background(const nqm_scene *scene, size_t frame, double *rgb_cdm2) {
    scene = scene->parts[frame / scene->options.n_frames];
    const double half = tan(NQM_PI / 6); /* 60 degrees high */
    double height = (double)scene->options.height, width = (double)scene->options.width, axes[9];
    nqm_view_axes(scene->options.elevation_rad, axes);
    for (size_t y = 0; y < scene->options.height; ++y)
        for (size_t x = 0; x < scene->options.width; ++x) {
            double right = (2 * (double)x + 1 - width) / height * half, up = (1 - (2 * (double)y + 1) / height) * half;
            double w[3], *rgb = rgb_cdm2 + 3 * (y * scene->options.width + x);
            for (int k = 0; k < 3; ++k)
                w[k] = right * axes[k] + up * axes[3 + k] - axes[6 + k];
            nqm_normalize3(w);
            nqm_light_eval(&scene->light, w, rgb);
            for (int k = 0; k < 3; ++k)
                rgb[k] *= scene->exposure;
        }
}
