/* SPDX-License-Identifier: MIT
 *
 * The light directions of one surface point: multiple importance sampling with the balance heuristic (Veach and Guibas
 * 1995, DOI 10.1145/218380.218498) over the light map times the cosine, five lobes of microfacets about the mirror
 * direction (GGX, Walter et al. 2007, DOI 10.2312/EGWR/EGSR07/195-206) and the plain cosine. The lobes' widths are
 * spaced so that a highlight of any width from 0.2 degrees up is met by one of them; which BRDF will be rendered need
 * not be known. Each technique takes a Hammersley set, shifted by a random amount at each point.
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>

static const double lobe_alpha[] = {0.002, 0.008, 0.03, 0.1, 0.3};
enum { N_LOBES = sizeof lobe_alpha / sizeof *lobe_alpha, LIGHT = N_LOBES, COSINE, N_TECHNIQUES };

/* One point's sampling state. */
typedef struct sampler {
    const nqm_light *light;
    const nqm_surface_point *point;
    double *cumulative;     /* (NQM_LIGHT_CELLS + 1) of power times cosine, from 0 */
    size_t n[N_TECHNIQUES]; /* directions by each technique */
} sampler;

static void to_world(const nqm_surface_point *point, const double *local, double *world) {
    for (int k = 0; k < 3; ++k)
        world[k] = local[0] * point->frame[k] + local[1] * point->frame[3 + k] + local[2] * point->frame[6 + k];
}

static void to_local(const nqm_surface_point *point, const double *world, double *local) {
    for (int k = 0; k < 3; ++k)
        local[k] = nqm_dot3(point->frame + 3 * k, world);
}

/* A cell is 1.4 degrees wide: one whose centre is at or below the horizon may still have a part above, and the sun may
 * stand there. Such cells get a small share; without it the other techniques would meet them by chance, with weights as
 * bright as fireflies. */
static double cell_importance(double cosine) {
    const double reach = 0.02; /* sine of the half diagonal of a cell, and a little more */
    return cosine > -reach ? fmax(cosine, reach) : 0;
}

/* Sum the map over the hemisphere: the table to draw cells from, and the irradiance. */
static void gather_light(sampler *s, double *irradiance) {
    const double *normal = s->point->frame + 6;
    irradiance[0] = irradiance[1] = irradiance[2] = 0;
    s->cumulative[0] = 0;
    for (size_t cell = 0; cell < NQM_LIGHT_CELLS; ++cell) {
        double cosine = nqm_dot3(normal, s->light->direction + 3 * cell);
        s->cumulative[cell + 1] = s->cumulative[cell] + cell_importance(cosine) * s->light->power[cell];
        double area = fmax(cosine, 0) * s->light->solid_angle[cell / NQM_LIGHT_WIDTH];
        for (size_t k = 0; k < 3; ++k)
            irradiance[k] += area * s->light->rgb[3 * cell + k];
    }
}

/* The step of a cumulative table (every stride-th entry, n steps) in which u falls, and where in it. */
static size_t find_step(const double *cumulative, size_t n, size_t stride, double u, double *within) {
    double target = cumulative[0] + u * (cumulative[n * stride] - cumulative[0]);
    size_t low = 0, high = n; /* cumulative[low] <= target < cumulative[high], but for rounding */
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if (cumulative[middle * stride] <= target)
            low = middle;
        else
            high = middle;
    }
    double begin = cumulative[low * stride], width = cumulative[(low + 1) * stride] - begin;
    *within = width > 0 ? fmin(fmax((target - begin) / width, 0), 1 - 0x1p-53) : 0.5;
    return low;
}

/* A row, then a cell of it: two coordinates, so that an even set in (u, v) stays even over the map. */
static void sample_light(const sampler *s, double u, double v, double *wi) {
    double world[3], in_row, in_cell;
    size_t row = find_step(s->cumulative, NQM_LIGHT_HEIGHT, NQM_LIGHT_WIDTH, u, &in_row);
    const double *cells = s->cumulative + row * NQM_LIGHT_WIDTH;
    size_t column = find_step(cells, NQM_LIGHT_WIDTH, 1, v, &in_cell);
    nqm_light_direction(row * NQM_LIGHT_WIDTH + column, in_cell, in_row, world);
    to_local(s->point, world, wi);
}

static void sample_cosine(double u, double v, double *wi) {
    wi[0] = sqrt(u) * cos(2 * NQM_PI * v);
    wi[1] = sqrt(u) * sin(2 * NQM_PI * v);
    wi[2] = sqrt(1 - u);
}

/* A half vector with density D(h) cos(theta_h), and the mirror of wo at it. */
static void sample_lobe(double alpha, const double *wo, double u, double v, double *wi) {
    double h[3];
    nqm_spherical(atan(alpha * sqrt(u / (1 - u))), 2 * NQM_PI * v, h);
    double d = nqm_dot3(wo, h);
    for (int k = 0; k < 3; ++k)
        wi[k] = 2 * d * h[k] - wo[k];
}

/* Density of sample_lobe() in wi, 1/sr. h: (3) unit half vector; its sin^2 from x and y, as 1 - cos^2 would cancel. */
static double lobe_density(double alpha, const double *wo, const double *h) {
    double sin2 = h[0] * h[0] + h[1] * h[1], a2 = alpha * alpha;
    double t = h[2] * h[2] * a2 + sin2;
    double d = a2 / (NQM_PI * t * t);
    return d * h[2] / (4 * fmax(nqm_dot3(wo, h), 1e-9));
}

/* Expected number of directions a steradian about wi, over all techniques. */
static double density(const sampler *s, const double *wi, const double *world) {
    size_t cell = nqm_light_cell(world);
    double share = (s->cumulative[cell + 1] - s->cumulative[cell]) / s->cumulative[NQM_LIGHT_CELLS];
    double sum = (double)s->n[LIGHT] * share / s->light->solid_angle[cell / NQM_LIGHT_WIDTH];
    sum += (double)s->n[COSINE] * wi[2] / NQM_PI;
    const double *wo = s->point->wo;
    double h[3] = {wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
    nqm_normalize3(h);
    for (size_t i = 0; i < N_LOBES; ++i)
        sum += (double)s->n[i] * lobe_density(lobe_alpha[i], wo, h);
    return sum;
}

static void share_out(sampler *s, size_t n) {
    s->n[LIGHT] = n / 3;
    s->n[COSINE] = n - n / 3;
    for (size_t i = 0; i < N_LOBES; ++i) {
        s->n[i] = n / 10;
        s->n[COSINE] -= s->n[i];
    }
}

/* Van der Corput: the bits of i behind the binary point, reversed. */
static double radical_inverse(size_t i) {
    double value = 0;
    for (double digit = 0.5; i; i >>= 1, digit /= 2)
        value += (i & 1) ? digit : 0;
    return value;
}

static double shifted(double x, uint64_t random) {
    double sum = x + (double)(random >> 11) * 0x1p-53;
    return sum < 1 ? sum : sum - 1;
}

static void sample(const sampler *s, size_t technique, double u, double v, double *wi) {
    if (technique == LIGHT)
        sample_light(s, u, v, wi);
    else if (technique == COSINE)
        sample_cosine(u, v, wi);
    else
        sample_lobe(lobe_alpha[technique], s->point->wo, u, v, wi);
}

/* Scale each channel so that a Lambert surface receives its exact irradiance: that removes the noise (1 % at 384
 * directions) which all surfaces share. */
static void calibrate(nqm_direction_set *set) {
    double sum[3] = {0};
    for (size_t i = 0; i < 3 * set->n_used; ++i)
        sum[i % 3] += set->weight[i];
    for (size_t i = 0; i < 3 * set->n_used; ++i)
        set->weight[i] *= sum[i % 3] > 0 ? set->irradiance[i % 3] / sum[i % 3] : 1;
}

/* Append the directions of one technique. */
static void add_technique(const sampler *s, size_t technique, uint64_t seed, nqm_direction_set *set) {
    size_t n = s->n[technique];
    uint64_t shift_u = nqm_hash_u64(seed, 2 * technique), shift_v = nqm_hash_u64(seed, 2 * technique + 1);
    for (size_t i = 0; i < n; ++i) {
        double *wi = set->wi + 3 * set->n_used, *weight = set->weight + 3 * set->n_used, world[3];
        double u = shifted(((double)i + 0.5) / (double)n, shift_u);
        sample(s, technique, u, shifted(radical_inverse(i), shift_v), wi);
        if (!(wi[2] > 0))
            continue;
        to_world(s->point, wi, world);
        nqm_light_eval(s->light, world, weight);
        double scale = wi[2] / density(s, wi, world);
        for (int k = 0; k < 3; ++k)
            weight[k] *= scale;
        ++set->n_used;
    }
}

bool nqm_choose_directions(const nqm_light *light, const nqm_surface_point *point, uint64_t seed,
                           nqm_direction_set *set) {
    sampler s = {.light = light, .point = point, .cumulative = nqm_alloc(NQM_LIGHT_CELLS + 1, sizeof(double))};
    if (!s.cumulative)
        return false;
    share_out(&s, set->n_max);
    gather_light(&s, set->irradiance);
    set->n_used = 0;
    if (s.cumulative[NQM_LIGHT_CELLS] > 0) /* else no light reaches the point */
        for (size_t t = 0; t < N_TECHNIQUES; ++t)
            add_technique(&s, t, seed, set);
    nqm_free(s.cumulative);
    calibrate(set);
    return true;
}
