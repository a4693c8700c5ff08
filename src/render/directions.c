/* SPDX-License-Identifier: MIT
 *
 * The light directions of one surface point: multiple importance sampling with the balance heuristic (Veach and Guibas
 * 1995, DOI 10.1145/218380.218498) over the light map times the cosine, a spiral of half vectors about the normal, and
 * the cosine. The spiral is what makes lobes of any width right without knowledge of the BRDF: its directions are
 * evenly spaced in the logarithm of tan(theta_h), in which a lobe of any width has the same smooth shape, and the
 * midpoint rule converges exponentially for smooth integrands (Trefethen and Weideman 2014, DOI 10.1137/130932132).
 * They are denser where the light map resolves a lobe, and continue to perfect mirrors, within whose lobes the light is
 * constant. The azimuth advances by the golden angle. For anisotropic BRDFs the spiral is stretched as their lobes are
 * (render/lobe.c).
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>
#include <string.h>

enum { SPIRAL = 0, LIGHT, COSINE, N_TECHNIQUES };

/* The spiral has the density (1 / (t + core) + 1 / (t + knee)) dt / range in t = tan(theta_h), up to t = most_tan:
 * logarithmic, twice as dense where the light varies over a lobe, and fading out below the narrowest lobe of any model,
 * whose width is 0.0001. */
static const double core = 3e-6, knee = 2e-3, most_tan = 8;

static double spiral_range(void) {
    return log1p(most_tan / core) + log1p(most_tan / knee);
}

enum { LANES = NQM_LIGHT_LANES };
typedef float lanes __attribute__((vector_size(LANES * sizeof(float)), aligned(4), may_alias));
typedef int32_t masks __attribute__((vector_size(LANES * sizeof(float))));

/* Sampling state of one point: cumulative importance of the rows of the light map, and of the cells of one row. */
typedef struct sampler {
    const nqm_light *light;
    const nqm_surface_point *point;
    bool flat;              /* importance without the cosine */
    double reach;           /* a little more than the sine of half the diagonal of a cell */
    double *across;         /* (width) across() of all columns */
    float *across_float;    /* (width) the same */
    double *rows;           /* (height + 1) cumulative importance of the rows, from 0; owns the block of the arrays */
    double *cells;          /* (width + 1) cumulative importance of the cells of `row` */
    double *importance;     /* (width) that of a row */
    double *wide;           /* (n_max) fraction of the density at each direction that is not of the spiral */
    size_t row;             /* SIZE_MAX: none */
    size_t n[N_TECHNIQUES]; /* number of directions of each technique */
    const nqm_lobe *lobe;   /* of the spiral; NULL: round */
    double range;           /* spiral_range() */
} sampler;

static bool open_sampler(const nqm_light *light, const nqm_surface_point *point, bool flat, size_t n_directions,
                         sampler *s) {
    *s = (sampler){.light = light, .point = point, .flat = flat, .row = SIZE_MAX};
    s->reach = 0.02 * NQM_LIGHT_WIDTH / (double)light->width;
    return nqm_alloc_arrays(
               NQM_ARRAYS({&s->rows, light->height + 1, sizeof(double)}, {&s->cells, light->width + 1, sizeof(double)},
                          {&s->across, light->width, sizeof(double)}, {&s->across_float, light->width, sizeof(float)},
                          {&s->importance, light->width, sizeof(double)}, {&s->wide, n_directions, sizeof(double)}),
               NULL) == NQM_OK;
}

/* Cosine between the point's normal and the centre of a cell: base + slope * across, across by column. */
static double across(const sampler *s, size_t x) {
    const double *normal = s->point->frame + 6, *azimuth = s->light->azimuth + 2 * x;
    return normal[0] * azimuth[0] - normal[2] * azimuth[1];
}

/* A cell whose centre is at or below the horizon may be partly above it and contain the sun. Such cells get a small
 * importance; otherwise the other techniques would sample them by chance with very large weights (fireflies). */
static inline double cell_importance(const sampler *s, size_t y, size_t x) {
    double power = s->light->power[y * s->light->width + x];
    if (s->flat)
        return power;
    const double *polar = s->light->polar + 2 * y;
    double cosine = polar[0] * s->across[x] + polar[1] * s->point->frame[7];
    return cosine > -s->reach ? (cosine > s->reach ? cosine : s->reach) * power : 0;
}

/* cell_importance() of all cells of a row. Without vectors it takes a quarter of the time of a point. */
NQM_FOR_EACH_VECTOR_WIDTH
static void row_importance(const sampler *s, size_t y, double *importance) {
    const size_t n = s->light->width;
    const double *power = s->light->power + y * n, *columns = s->across, reach = s->reach;
    const double slope = s->light->polar[2 * y], base = s->light->polar[2 * y + 1] * s->point->frame[7];
#pragma omp simd
    for (size_t x = 0; x < n; ++x) {
        const double cosine = slope * columns[x] + base, raised = (cosine > reach ? cosine : reach) * power[x];
        importance[x] = cosine > -reach ? raised : 0;
    }
}

/* Sums over one row: sum[0] importance as above, sum[1..3] irradiance. In single precision and vectorised, because it runs
 * for every cell of the map at every point. */
NQM_FOR_EACH_VECTOR_WIDTH
static void sum_row(const sampler *s, size_t y, double *sum) {
    const nqm_light *light = s->light;
    const float base = (float)(light->polar[2 * y + 1] * s->point->frame[7]), slope = (float)light->polar[2 * y];
    const float reach = (float)s->reach;
    lanes lane[4] = {0};
    for (size_t x = 0; x < light->width / LANES; ++x) {
        const lanes *summand = (const lanes *)light->summand + 4 * (y * light->width / LANES + x);
        const lanes cosine = base + slope * ((const lanes *)s->across_float)[x], high = (lanes){0} + reach;
        const masks is_high = cosine > reach;
        const lanes raised = (lanes)(((masks)cosine & is_high) | ((masks)high & ~is_high));
        const lanes positive = (lanes)((masks)cosine & (cosine > 0));
        lane[0] += (lanes)((masks)raised & (cosine > -reach)) * summand[0];
        lane[1] += positive * summand[1];
        lane[2] += positive * summand[2];
        lane[3] += positive * summand[3];
    }
    for (size_t k = 0; k < 4; ++k) {
        sum[k] = 0;
        for (size_t l = 0; l < LANES; ++l)
            sum[k] += (double)lane[k][l];
    }
}

/* Sum the map over the hemisphere: cumulative importance of the rows, and the irradiance. */
static void gather_light(sampler *s, double *irradiance) {
    const nqm_light *light = s->light;
    for (size_t x = 0; x < light->width; ++x) {
        s->across[x] = across(s, x);
        s->across_float[x] = (float)s->across[x];
    }
    irradiance[0] = irradiance[1] = irradiance[2] = 0;
    for (size_t y = 0; y < light->height; ++y) {
        double sum[4];
        sum_row(s, y, sum);
        s->rows[y + 1] = s->rows[y] + sum[0];
        for (size_t k = 0; k < 3; ++k)
            irradiance[k] += sum[k + 1];
    }
}

/* The interval of a cumulative table (n + 1) that contains u times the total, and the position in it. */
static size_t find_step(const double *cumulative, size_t n, double u, double *within) {
    double target = u * cumulative[n];
    size_t low = nqm_last_not_above(cumulative, n, target); /* target < cumulative[low + 1], but for rounding */
    double width = cumulative[low + 1] - cumulative[low];
    *within = width > 0 ? fmin(fmax((target - cumulative[low]) / width, 0), 1 - 0x1p-53) : 0.5;
    return low;
}

/* Sample a row by u, then a cell by v, which preserves the stratification of (u, v). */
static void sample_light(sampler *s, double u, double v, double *wi) {
    const nqm_light *light = s->light;
    double world[3], in_row, in_cell;
    size_t row = find_step(s->rows, light->height, u, &in_row);
    const double *importance = s->flat ? light->power + row * light->width : s->importance;
    double sum = 0;
    if (row != s->row && !s->flat)
        row_importance(s, row, s->importance);
    for (size_t x = 0; row != s->row && x < light->width; ++x)
        s->cells[x + 1] = sum += importance[x];
    s->row = row;
    size_t column = find_step(s->cells, light->width, v, &in_cell);
    nqm_light_direction(light, row * light->width + column, in_cell, in_row, world);
    nqm_local_from_world(s->point, world, wi);
}

static void sample_cosine(double u, double v, double *wi) {
    wi[0] = sqrt(u) * cos(2 * NQM_PI * v);
    wi[1] = sqrt(u) * sin(2 * NQM_PI * v);
    wi[2] = sqrt(1 - u);
}

/* Move a half vector of the round spiral into the lobe. */
static void stretch(const sampler *s, double *h) {
    const nqm_lobe *lobe = s->lobe;
    const double x = h[0] / h[2], y = h[1] / h[2], *axes = lobe->axes;
    const double back[2] = {-s->point->tangent[0], s->point->tangent[1]};
    h[0] = lobe->center[0] + axes[0] * x + axes[1] * y;
    h[1] = lobe->center[1] + axes[2] * x + axes[3] * y;
    h[2] = 1;
    nqm_turn3(back, h, h);
    nqm_normalize3(h);
}

/* Tan(theta_h) at which the spiral of the lobe has the half vector h. */
static double position_in(const sampler *s, const double *h) {
    const nqm_lobe *lobe = s->lobe;
    double in[3];
    nqm_turn3(s->point->tangent, h, in);
    const double x = in[0] / in[2] - lobe->center[0], y = in[1] / in[2] - lobe->center[1], *axes = lobe->axes;
    return hypot(axes[3] * x - axes[1] * y, axes[0] * y - axes[2] * x);
}

/* Reflect wo at a half vector of the spiral: (1 + t / core) (1 + t / knee) = exp(u range). */
static void sample_spiral(const sampler *s, double u, double v, double *wi) {
    const double grown = expm1(u * spiral_range()), sum = core + knee, product = core * knee, *wo = s->point->wo;
    double h[3];
    nqm_spherical(atan(2 * product * grown / (sum + sqrt(sum * sum + 4 * product * grown))), 2 * NQM_PI * v, h);
    if (s->lobe)
        stretch(s, h);
    double d = nqm_dot3(wo, h);
    for (int k = 0; k < 3; ++k)
        wi[k] = 2 * d * h[k] - wo[k];
}

/* Expected number of directions per steradian at wi of the spiral. The sine of theta_h is computed from x and y because 1 - cos^2
 * would cancel. */
static double spiral_density(const sampler *s, const double *wi) {
    const double *wo = s->point->wo;
    const double h[3] = {wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
    const double length = sqrt(nqm_dot3(h, h)); /* twice wo.h of the unit vector */
    const double cosine = h[2] / length;
    const double t = fmax(s->lobe ? position_in(s, h) : hypot(h[0], h[1]) / h[2], 1e-12);
    if (!(t <= most_tan))
        return 0;
    const double by_tan = (double)s->n[SPIRAL] * (1 / (t + core) + 1 / (t + knee)) / s->range;
    return by_tan / (2 * NQM_PI * t * cosine * cosine * cosine * 2 * length);
}

/* The same of the other techniques; `cell` of the map contains wi. */
static double wide_density(const sampler *s, const double *wi, size_t cell) {
    size_t y = cell / s->light->width, x = cell % s->light->width;
    double probability = cell_importance(s, y, x) / s->rows[s->light->height];
    return (double)s->n[LIGHT] * probability / s->light->solid_angle[y] + (double)s->n[COSINE] * wi[2] / NQM_PI;
}

static void divide_directions(sampler *s, size_t n) {
    s->n[LIGHT] = n / 4;
    s->n[COSINE] = n / 8;
    s->n[SPIRAL] = n - s->n[LIGHT] - s->n[COSINE];
    s->range = spiral_range();
}

static double shifted(double x, uint64_t random) {
    double sum = x + (double)(random >> 11) * 0x1p-53;
    return sum < 1 ? sum : sum - 1;
}

static void sample(sampler *s, size_t technique, double u, double v, double *wi) {
    if (technique == LIGHT)
        sample_light(s, u, v, wi);
    else if (technique == COSINE)
        sample_cosine(u, v, wi);
    else
        sample_spiral(s, u, v, wi);
}

/* Correct the sum of the weights to the exact irradiance: this removes the noise common to all surfaces (1 % at 384
 * directions). Directions that only the spiral makes keep their weights, so that narrow lobes do not receive noise of
 * the whole sky. */
static void calibrate(const double *wide, nqm_direction_set *set) {
    double sum[3] = {0}, movable[3] = {0};
    for (size_t i = 0; i < 3 * set->n_used; ++i) {
        sum[i % 3] += set->weight[i];
        movable[i % 3] += wide[i / 3] * set->weight[i];
    }
    for (size_t i = 0; i < 3 * set->n_used; ++i) {
        const size_t k = i % 3;
        if (movable[k] > 0)
            set->weight[i] *= fmax(1 + wide[i / 3] * (set->irradiance[k] - sum[k]) / movable[k], 0);
    }
}

/* The second coordinate of direction i: a lattice, of which every second point is one, too. */
static double second(size_t i) {
    const double golden = 0.6180339887498949 * (double)i;
    return golden - floor(golden);
}

/* Append the even (half 0) or odd (half 1) directions of a technique. */
static void add_technique(sampler *s, size_t technique, size_t half, uint64_t seed, nqm_direction_set *set) {
    size_t n = s->n[technique];
    uint64_t shift_u = nqm_hash_u64(seed, 2 * technique), shift_v = nqm_hash_u64(seed, 2 * technique + 1);
    for (size_t i = half; i < n; i += 2) {
        double *wi = set->wi + 3 * set->n_used, *weight = set->weight + 3 * set->n_used, world[3];
        double u = shifted(((double)i + 0.5) / (double)n, shift_u);
        sample(s, technique, u, shifted(second(i), shift_v), wi);
        if (!(wi[2] > 0))
            continue;
        nqm_world_from_local(s->point, wi, world);
        size_t cell = nqm_light_eval(s->light, world, weight);
        const double wide = wide_density(s, wi, cell), all = wide + spiral_density(s, wi), extent = wi[2] / all;
        s->wide[set->n_used] = wide / all;
        for (int k = 0; k < 3; ++k)
            weight[k] *= extent;
        if (set->extent)
            set->extent[set->n_used] = extent;
        ++set->n_used;
    }
}

static void add_techniques(sampler *s, uint64_t seed, nqm_direction_set *set) {
    divide_directions(s, set->n_max);
    set->n_used = set->n_first = 0;
    for (size_t half = 0; half < 2 && s->rows[s->light->height] > 0; ++half) { /* 0: the point receives no light */
        for (size_t t = 0; t < N_TECHNIQUES; ++t)
            add_technique(s, t, half, seed, set);
        set->n_first = half ? set->n_first : set->n_used;
    }
}

bool nqm_choose_directions(const nqm_light *light, const nqm_surface_point *point, const nqm_lobe *lobe, uint64_t seed,
                           nqm_direction_set *set) {
    sampler s;
    if (!open_sampler(light, point, false, set->n_max, &s))
        return false;
    s.lobe = lobe;
    gather_light(&s, set->irradiance);
    add_techniques(&s, seed, set);
    calibrate(s.wide, set);
    nqm_free(s.rows);
    return true;
}

bool nqm_choose_few_directions(const nqm_light *light, const nqm_surface_point *point, uint64_t seed,
                               nqm_direction_set *set) {
    sampler s;
    if (!open_sampler(light, point, true, set->n_max, &s))
        return false;
    memcpy(s.rows, light->row_power, (light->height + 1) * sizeof *s.rows);
    add_techniques(&s, seed, set);
    nqm_free(s.rows);
    return true;
}

bool nqm_irradiance(const nqm_light *light, const nqm_surface_point *point, double *rgb) {
    sampler s;
    if (!open_sampler(light, point, false, 0, &s))
        return false;
    gather_light(&s, rgb);
    nqm_free(s.rows);
    return true;
}
