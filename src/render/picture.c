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
    const nqm_lobe *lobe; /* of an anisotropic BRDF; NULL: it is isotropic */
    double *rgb_cdm2;     /* (n, 3) of the scene */
    size_t stride;        /* as of nqm_scene_store() */
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
    const nqm_brdf *brdf;
    double grain[2];
} surface;

/* nqm_brdf_eval() of directions in the frame of the point, which become those of the surface. */
static void eval(const surface *s, size_t n, double *wi, double *wo, double *f) {
    for (size_t j = 0; !s->brdf->info.isotropic && j < n; ++j) {
        nqm_turn3(s->grain, wi + 3 * j, wi + 3 * j);
        nqm_turn3(s->grain, wo + 3 * j, wo + 3 * j);
    }
    nqm_brdf_eval(s->brdf, n, wi, wo, f, NULL);
}

/* Add the light of n rays that the surface reflects to wo. */
static void reflect(const surface *s, size_t n_rays, const nqm_ray *ray, const double *wo_one, double *sum) {
    double wi[3 * BLOCK], wo[3 * BLOCK], f[3 * BLOCK];
    for (size_t first = 0; first < n_rays; first += BLOCK) {
        size_t left = n_rays - first, n = left < BLOCK ? left : BLOCK;
        for (size_t j = 0; j < n; ++j) {
            from_float(ray[first + j].wi, wi + 3 * j);
            memcpy(wo + 3 * j, wo_one, 3 * sizeof *wo);
        }
        eval(s, n, wi, wo, f);
        for (size_t j = 0; j < n; ++j)
            for (size_t k = 0; k < 3; ++k)
                sum[k] += f[3 * j + k] * (double)ray[first + j].weight[k];
    }
}

static void reflect_bounce(const surface *s, const nqm_bounce *bounce, const double *wo, double *sum) {
    const surface met = {s->brdf, {(double)bounce->grain[0], (double)bounce->grain[1]}};
    double wi[3], from[3], to[3], f[3], radiance[3] = {0};
    from_float(bounce->wo, from);
    reflect(&met, bounce->n_rays, bounce->ray, from, radiance);
    from_float(bounce->wi, wi);
    memcpy(to, wo, sizeof to);
    eval(s, 1, wi, to, f);
    for (int k = 0; k < 3; ++k)
        sum[k] += f[k] * radiance[k] * (double)bounce->extent;
}

bool nqm_scene_reflect(const nqm_scene *scene, size_t i, const nqm_brdf *brdf, const nqm_lobe *lobe,
                       double half[2][3]) {
    nqm_surface_point made_point;
    const nqm_surface_point *point = nqm_scene_point(scene, i, &made_point);
    const surface s = {brdf, {point->grain[0], point->grain[1]}};
    nqm_incident made = {0};
    const bool is_kept = scene->kept && !lobe;
    memset(half, 0, 2 * sizeof *half);
    if (!is_kept && !nqm_incident_make(scene, i, lobe, &made, NULL))
        return false;
    const nqm_incident *incident = is_kept ? &scene->kept[i] : &made;
    reflect(&s, incident->n_first_rays, incident->ray, point->wo, half[0]);
    reflect(&s, incident->n_rays - incident->n_first_rays, incident->ray + incident->n_first_rays, point->wo, half[1]);
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
    if (!nqm_scene_reflect(r->scene, i, r->brdf, r->lobe, half))
        atomic_store(&r->out_of_memory, true);
    nqm_scene_store(r->scene, i, half, r->rgb_cdm2, r->stride);
}

static nqm_status render(const nqm_scene *scene, const nqm_brdf *brdf, nqm_ticker *ticker, double *rgb_cdm2,
                         size_t stride, nqm_error *err) {
    const bool is_anisotropic = nqm_brdf_anisotropy(brdf) > 0;
    const nqm_lobe lobe = is_anisotropic ? nqm_lobe_measure(brdf) : (nqm_lobe){.width = 0};
    rendering r = {scene, brdf, .lobe = is_anisotropic ? &lobe : NULL, .rgb_cdm2 = rgb_cdm2, .stride = stride};
    if (nqm_parallel_ticking(ticker, "render", scene->seen.n, render_point, &r))
        return nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted");
    if (atomic_load(&r.out_of_memory))
        return nqm_fail_nomem(err, scene->options.n_lights * sizeof(nqm_ray));
    for (size_t i = 0; i < 3 * scene->seen.n; ++i)
        if (!isfinite(rgb_cdm2[i]))
            return nqm_fail(err, NQM_ERR_NUMERIC, -1, "%s: the picture is not finite", nqm_brdf_get_info(brdf).name);
    return NQM_OK;
}

bool nqm_scene_tabulates(const nqm_scene *scene, const nqm_brdf *brdf) {
    const size_t n_nodes = nqm_table_picture.n_h * nqm_table_picture.n_d * nqm_table_picture.n_p;
    return !scene->options.exact && brdf->class_->is_costly &&
           scene->seen.n > n_nodes / scene->options.n_lights; /* fewer directions than nodes: a table would cost more */
}

static nqm_status render_all(const nqm_scene *scene, const nqm_brdf *brdf, double *rgb_cdm2, size_t stride,
                             nqm_error *err) {
    const nqm_scene_options *o = &scene->options;
    nqm_status status = NQM_OK;
    if (nqm_scene_tabulates(scene, brdf)) {
        nqm_ticker whole = {.fn = o->progress, .user = o->progress_user};
        nqm_brdf *table;
        nqm_status made = nqm_brdf_tabulate(brdf, nqm_table_picture, &whole, &table, err);
        made = made == NQM_OK ? render_all(scene, table, rgb_cdm2, stride, err) : made;
        nqm_brdf_free(table);
        return made;
    }
    for (size_t p = 0; status == NQM_OK && p < scene->n_parts; ++p) {
        nqm_scene_part place = {o, p, scene->n_parts};
        nqm_ticker ticker = nqm_scene_part_ticker(&place);
        status = render(scene->parts[p], brdf, &ticker, rgb_cdm2, stride, err);
        rgb_cdm2 += 3 * scene->parts[p]->seen.n;
    }
    return status;
}

nqm_status nqm_scene_render(const nqm_scene *scene, const nqm_brdf *brdf, double *rgb_cdm2, nqm_error *err) {
    NQM_REQUIRE(err, scene, brdf, rgb_cdm2);
    return render_all(scene, brdf, rgb_cdm2, 0, err);
}

nqm_status nqm_scene_render_halves(const nqm_scene *scene, const nqm_brdf *brdf, double *rgb_cdm2, nqm_error *err) {
    NQM_REQUIRE(err, scene, brdf, rgb_cdm2);
    return render_all(scene, brdf, rgb_cdm2, 3 * scene->seen.n, err);
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
