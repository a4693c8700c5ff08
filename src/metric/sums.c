/* SPDX-License-Identifier: MIT
 *
 * Sums over the directions of pairs, and the way back from derivatives by sums to samples, in float. Each difference of
 * logarithms is the logarithm of a quotient, which takes half of the time and keeps the relative precision of small
 * differences.
 *
 * An image averages reflectance over many directions, so that random differences between directions are less visible
 * than systematic ones. Therefore some features compare sums over zones of directions, others single directions. A
 * direction that is not used is one where both members are 0: all differences are 0 there, and so are all scales.
 */
#include "metric/sums.h"
#include "kernel/kernel.h"
#include "math/math.h"
#include "sample/loops.h"

#include <math.h>
#include <string.h>

/* Directions that are processed together: their values on all scales stay in the L1 cache. */
enum { STRETCH = 128, VALUES = 3 * STRETCH, ROOM = VALUES + NQM_PANEL };

/* Larger samples count as this one: float has the range for its squares. Their roots are at most largest_root. */
static const float largest = 1e15F, largest_root = 1e5F;

static const float dark = (float)NQM_DARK;

/* ---- sets of directions ------------------------------------------------------------------------------------------ */

/* Upper ends of the zones, degrees. */
static const double zone_h_end[NQM_ZONES_H - 1] = {2, 5, 15, 35}, zone_d_end[NQM_ZONES_D - 1] = {30, 60};

static size_t zone_of(double degrees, size_t n_ends, const double *ends) {
    size_t zone = 0;
    while (zone < n_ends && degrees >= ends[zone])
        ++zone;
    return zone;
}

size_t nqm_cell_of(const double *degrees) {
    return zone_of(degrees[0], NQM_ZONES_H - 1, zone_h_end) * NQM_ZONES_D +
           zone_of(degrees[1], NQM_ZONES_D - 1, zone_d_end);
}

/* The limit is theta_d = 60 degrees at theta_h = 0. */
bool nqm_is_grazing(double cosines) {
    return cosines < 0.25;
}

/* ---- plans ------------------------------------------------------------------------------------------------------- */

/* What the sums need of a set of directions. */
struct nqm_sum_plan {
    const nqm_directions *directions;
    float *cosines, *roots,
        *inverse;                  /* (n + NQM_PANEL, 3) c = cos(theta_i) cos(theta_o), cbrt(c) and 1 / c, the same for
                                         all channels; 1 after the last direction */
    float ones[ROOM], darks[ROOM]; /* 1 and NQM_DARK */
    float luminance[3];            /* that of 1 in each channel */
    float *grazing;                /* (n) 1 where a direction counts as grazing, else 0 */
    uint8_t *cell;                 /* (n) */
    uint16_t *order;               /* (n) for each stretch, its directions in the order of their cells */
    uint16_t *end;                 /* (number of stretches, NQM_CELLS) end of each cell in that order */
    nqm_pair_sums *counts;         /* (1) of a pair whose directions are all used */
};

/* Set all numbers and weights of directions in the sums of a pair, which do not depend on its samples. */
static void count_directions(const nqm_directions *directions, const uint8_t *used, nqm_pair_sums *to) {
    nqm_scalar_sums *s = &to->scalars;
    memset(to, 0, sizeof *to);
    for (size_t i = 0; i < directions->n; ++i)
        if (!used || used[i]) {
            s->n += 1;
            s->grazing_n += nqm_is_grazing(directions->cosines[i]);
            s->cell[nqm_cell_of(directions->degrees + 3 * i)].n += 1;
            s->weighted.n += directions->cosines[i];
        }
    to->metrics.n = 3 * s->n;
}

/* Sort the directions of a stretch by cell. */
static void sort_stretch(const nqm_directions *directions, size_t first, size_t n, uint16_t *order, uint16_t *end) {
    size_t n_sorted = 0;
    for (size_t cell = 0; cell < NQM_CELLS; ++cell) {
        for (size_t i = 0; i < n; ++i)
            if (nqm_cell_of(directions->degrees + 3 * (first + i)) == cell)
                order[n_sorted++] = (uint16_t)i;
        end[cell] = (uint16_t)n_sorted;
    }
}

nqm_status nqm_sum_plan_create(const nqm_directions *directions, nqm_sum_plan **plan_ret, nqm_error *err) {
    const size_t n = directions->n, n_stretches = (n + STRETCH - 1) / STRETCH;
    const double least = 1e-30; /* of c, so that its inverse is finite */
    nqm_sum_plan *plan, made = {.directions = directions};
    *plan_ret = NULL;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&plan, 1, sizeof *plan}, {&made.counts, 1, sizeof *made.counts},
                   {&made.cosines, n + NQM_PANEL, 3 * sizeof *made.cosines},
                   {&made.roots, n + NQM_PANEL, 3 * sizeof *made.roots},
                   {&made.inverse, n + NQM_PANEL, 3 * sizeof *made.inverse}, {&made.grazing, n, sizeof *made.grazing},
                   {&made.cell, n, sizeof *made.cell}, {&made.order, n, sizeof *made.order},
                   {&made.end, n_stretches, NQM_CELLS * sizeof *made.end}),
        err);
    if (status != NQM_OK)
        return status;
    *plan = made;
    count_directions(directions, NULL, plan->counts);
    for (size_t i = 0; i < 3 * (n + NQM_PANEL); ++i) {
        const double c = i < 3 * n ? directions->cosines[i / 3] : 1;
        plan->cosines[i] = (float)c;
        plan->roots[i] = (float)cbrt(c);
        plan->inverse[i] = (float)(1 / fmax(c, least));
    }
    for (size_t i = 0; i < ROOM; ++i) {
        plan->ones[i] = 1;
        plan->darks[i] = dark;
    }
    for (size_t k = 0; k < 3; ++k)
        plan->luminance[k] = (float)nqm_luminance((double[3]){k == 0, k == 1, k == 2});
    for (size_t i = 0; i < n; ++i)
        plan->grazing[i] = nqm_is_grazing(directions->cosines[i]),
        plan->cell[i] = (uint8_t)nqm_cell_of(directions->degrees + 3 * i);
    for (size_t first = 0; first < n; first += STRETCH)
        sort_stretch(directions, first, nqm_smaller(n - first, STRETCH), plan->order + first,
                     plan->end + first / STRETCH * NQM_CELLS);
    *plan_ret = plan;
    return NQM_OK;
}

void nqm_sum_plan_free(nqm_sum_plan *plan) {
    nqm_free(plan);
}

/* ---- members ----------------------------------------------------------------------------------------------------- */

/* Directions [first, first + n) of a plan. */
typedef struct stretch {
    const nqm_sum_plan *plan;
    size_t first, n;
    size_t n_values; /* 3 n and the zeros that follow, up to a multiple of NQM_PANEL */
} stretch;

/* A stretch of one BRDF. Values after the last direction are 0. */
typedef struct member {
    float f[ROOM], root[ROOM]; /* f and cbrt(f) */
    float luminance[STRETCH];
    double peak, light[3]; /* the largest luminance; sums of c f */
} member;

/* Compute luminances, the largest one and the sums of light. */
static void sum_member(const stretch *s, member *to) {
    const float red = s->plan->luminance[0], green = s->plan->luminance[1], blue = s->plan->luminance[2];
    const float *f = to->f, *cosines = s->plan->cosines + 3 * s->first;
    float *luminance = to->luminance, most = 0, sum_r = 0, sum_g = 0, sum_b = 0;
#pragma omp simd reduction(max : most) reduction(+ : sum_r, sum_g, sum_b)
    for (size_t i = 0; i < s->n; ++i) {
        const float c = cosines[3 * i], r = f[3 * i], g = f[3 * i + 1], b = f[3 * i + 2];
        const float y = red * r + green * g + blue * b;
        luminance[i] = y;
        most = y > most ? y : most;
        sum_r += c * r;
        sum_g += c * g;
        sum_b += c * b;
    }
    to->peak = (double)most;
    to->light[0] = (double)sum_r;
    to->light[1] = (double)sum_g;
    to->light[2] = (double)sum_b;
}

/* root: (n_directions, 3) cube roots; NULL: they are computed. */
static void read_member(const stretch *s, const float *rgb, const float *root, const uint8_t *used, member *to) {
    const size_t n = 3 * s->n, n_filled = (s->n_values - n) * sizeof *rgb;
    const float *from = rgb + 3 * s->first;
    float *f = to->f, *own_root = to->root, logs[ROOM]; /* logs are not used */
    nqm_sample_limit(n, largest, from, f);
    if (!root)
        nqm_sample_logs(n, from, own_root, logs);
    nqm_sample_limit(n, largest_root, root ? root + 3 * s->first : own_root, own_root);
    for (size_t i = 0; used && i < n; ++i)
        if (!used[s->first + i / 3])
            f[i] = own_root[i] = 0;
    memset(f + n, 0, n_filled + sizeof *f); /* add_cells() reads one more */
    memset(own_root + n, 0, n_filled);
    sum_member(s, to);
}

/* A stretch of a reference, and log((x + NQM_DARK) / NQM_DARK) of x = f and x = luminance. */
typedef struct reference {
    member is;
    float log[ROOM], log_luminance[STRETCH];
} reference;

static void read_reference(const stretch *s, const float *rgb, const float *root, const uint8_t *used, reference *to) {
    static const float zeros[ROOM];
    read_member(s, rgb, root, used, &to->is);
    nqm_sample_log_ratios(3 * s->n, s->plan->darks, zeros, to->is.f, to->log);
    nqm_sample_log_ratios(s->n, s->plan->darks, zeros, to->is.luminance, to->log_luminance);
}

/* ---- sums -------------------------------------------------------------------------------------------------------- */

/* Differences of all values on each scale. Since c is the same for both members, log(1 + c f) differs like log(1 / c + f). */
typedef float differences[NQM_SCALES][ROOM];

static void find_differences(const stretch *s, const member *ref, const member *test, differences by) {
    const nqm_sum_plan *plan = s->plan;
    const size_t n = s->n_values;
    float magnitude[ROOM];
    nqm_sample_differences(n, 1, ref->f, test->f, by[NQM_SCALE_F], magnitude);
    nqm_sample_root_differences(n, plan->roots + 3 * s->first, ref->f, test->f, ref->root, test->root,
                                by[NQM_SCALE_CBRT_CF]);
    nqm_sample_log_ratios(n, plan->ones, ref->f, test->f, by[NQM_SCALE_LOG1P_F]);
    nqm_sample_log_ratios(n, plan->inverse + 3 * s->first, ref->f, test->f, by[NQM_SCALE_LOG1P_CF]);
    nqm_sample_log_ratios(n, plan->darks, ref->f, test->f, by[NQM_SCALE_LOG_F]);
}

/* Sums of l, log ratios of luminance. Variances are differences of l and l2, which are therefore in double. */
static void add_luminance(const stretch *s, const float *by_luminance, nqm_scalar_sums *to) {
    const float *grazing = s->plan->grazing + s->first;
    double l = 0, l2 = 0;
    float l4 = 0, root_l = 0, max_l = 0, grazing_l = 0, grazing_l2 = 0;
#pragma omp simd reduction(+ : l, l2, l4, root_l, grazing_l, grazing_l2) reduction(max : max_l)
    for (size_t i = 0; i < s->n; ++i) {
        const float x = by_luminance[i], size = fabsf(x), square = x * x;
        l += (double)x;
        l2 += (double)x * (double)x;
        l4 += square * square;
        root_l += sqrtf(size);
        max_l = size > max_l ? size : max_l;
        grazing_l += grazing[i] * x;
        grazing_l2 += grazing[i] * square;
    }
    to->l += l;
    to->l2 += l2;
    to->l4 += (double)l4;
    to->root_l += (double)root_l;
    to->max_l = fmax(to->max_l, (double)max_l);
    to->grazing_l += (double)grazing_l;
    to->grazing_l2 += (double)grazing_l2;
}

/* Sums of the opponent channels of log ratios. */
static void add_colour(size_t n, const float *by_log, nqm_scalar_sums *to) {
    float u = 0, v = 0, uv2 = 0;
#pragma omp simd reduction(+ : u, v, uv2)
    for (size_t i = 0; i < n; ++i) {
        const float r = by_log[3 * i], g = by_log[3 * i + 1];
        const float own_u = r - g, own_v = by_log[3 * i + 2] - 0.5F * (r + g);
        u += own_u;
        v += own_v;
        uv2 += own_u * own_u + own_v * own_v;
    }
    to->u += (double)u;
    to->v += (double)v;
    to->uv2 += (double)uv2;
}

/* Sums of the reference itself. */
static void add_reference(const stretch *s, const reference *ref, nqm_scalar_sums *to) {
    nqm_scalar_sums colour = {0};
    const float *log_luminance = ref->log_luminance;
    double sum = 0, squares = 0;
#pragma omp simd reduction(+ : sum, squares)
    for (size_t i = 0; i < s->n; ++i) {
        sum += (double)log_luminance[i];
        squares += (double)log_luminance[i] * (double)log_luminance[i];
    }
    add_colour(s->n, ref->log, &colour);
    to->ref_log += sum;
    to->ref_log2 += squares;
    to->ref_colour2 += colour.uv2;
}

/* Four neighbours, the last of which is not used: a type of GCC and Clang, as in the kernels. */
typedef float rgb_sum __attribute__((vector_size(16), aligned(4), may_alias));

/* Sums over cells and zones. by_luminance as in add_luminance(). */
static void add_cells(const stretch *s, const member *ref, const member *test, const float *by_luminance,
                      nqm_scalar_sums *to) {
    const uint16_t *order = s->plan->order + s->first, *end = s->plan->end + s->first / STRETCH * NQM_CELLS;
    for (size_t cell = 0, k = 0; cell < NQM_CELLS; ++cell) {
        rgb_sum a = {0}, b = {0};
        float l2 = 0;
        for (; k < end[cell]; ++k) {
            const size_t i = order[k];
            a += *(const rgb_sum *)(ref->f + 3 * i);
            b += *(const rgb_sum *)(test->f + 3 * i);
            l2 += by_luminance[i] * by_luminance[i];
        }
        for (size_t c = 0; c < 3; ++c) {
            to->cell[cell].ref[c] += (double)a[c];
            to->cell[cell].test[c] += (double)b[c];
        }
        to->zone_l2[cell / NQM_ZONES_D] += (double)l2;
    }
}

/* Add a stretch of a pair. */
static void add_stretch(const stretch *s, const reference *ref, const member *test, bool with_scalars,
                        nqm_pair_sums *to) {
    differences by;
    float by_luminance[STRETCH];
    nqm_scalar_sums *scalars = &to->scalars;
    find_differences(s, &ref->is, test, by);
    for (size_t k = 0; k < NQM_SCALES; ++k) {
        float magnitudes, squares;
        nqm_sample_sums(s->n_values, by[k], &magnitudes, &squares);
        to->metrics.magnitudes[k] += (double)magnitudes;
        to->metrics.squares[k] += (double)squares;
    }
    scalars->peak_ref = fmax(scalars->peak_ref, ref->is.peak);
    scalars->peak_test = fmax(scalars->peak_test, test->peak);
    if (!with_scalars)
        return;
    scalars->squares = to->metrics.squares[NQM_SCALE_LOG_F];
    nqm_sample_log_ratios(s->n, s->plan->darks, ref->is.luminance, test->luminance, by_luminance);
    add_reference(s, ref, scalars);
    add_luminance(s, by_luminance, scalars);
    add_colour(s->n, by[NQM_SCALE_LOG_F], scalars);
    for (size_t k = 0; k < 3; ++k) {
        scalars->weighted.ref[k] += ref->is.light[k];
        scalars->weighted.test[k] += test->light[k];
    }
    add_cells(s, &ref->is, test, by_luminance, scalars);
}

/* Sums of logarithms of the reference, from those of log((x + NQM_DARK) / NQM_DARK). */
static void move_logs(nqm_scalar_sums *s) {
    const double by = log(NQM_DARK);
    s->ref_log2 += by * (2 * s->ref_log + s->n * by);
    s->ref_log += s->n * by;
}

/* The mask of a pair; NULL: all directions are used. */
static const uint8_t *used_of(const nqm_sum_plan *plan, const nqm_sample_pair *pair) {
    return pair->used && memchr(pair->used, 0, plan->directions->n) ? pair->used : NULL;
}

static stretch stretch_at(const nqm_sum_plan *plan, size_t first) {
    const size_t n = nqm_smaller(plan->directions->n - first, STRETCH);
    return (stretch){plan, first, n, (3 * n + NQM_PANEL - 1) / NQM_PANEL * NQM_PANEL};
}

void nqm_compare_sums(const nqm_sum_plan *plan, size_t n, const nqm_sample_pair *pairs, const float *roots,
                      bool with_scalars, nqm_pair_sums *sums) {
    const size_t n_directions = plan->directions->n;
    const uint8_t *used[NQM_COMPARE_MAX];
    for (size_t k = 0; k < n; ++k) {
        used[k] = used_of(plan, &pairs[k]);
        sums[k] = *plan->counts;
        if (used[k])
            count_directions(plan->directions, used[k], &sums[k]);
    }
    for (size_t first = 0; first < n_directions; first += STRETCH) {
        const stretch s = stretch_at(plan, first);
        reference ref;
        member test;
        for (size_t k = 0; k < n; ++k) {
            if (k == 0 || used[k] || used[k - 1])
                read_reference(&s, pairs[k].ref, roots, used[k], &ref);
            read_member(&s, pairs[k].test, roots ? roots + (1 + k) * 3 * n_directions : NULL, used[k], &test);
            add_stretch(&s, &ref, &test, with_scalars, &sums[k]);
        }
    }
    for (size_t k = 0; k < n; ++k)
        move_logs(&sums[k].scalars);
}

/* ---- derivatives ------------------------------------------------------------------------------------------------- */

/* Derivative by log luminance of one direction. by->max_l becomes 0 where it is used up: the first direction that
 * attains the maximum takes it. */
static double by_log_luminance(const nqm_scalar_sums *s, double l, size_t zone, double grazing, nqm_scalar_sums *by) {
    const double sign = (l > 0) - (l < 0), large = fmax(fabs(l), NQM_SMALL_ROOT);
    double slope = by->l + 2 * l * (by->l2 + by->zone_l2[zone]) + 4 * l * l * l * by->l4;
    slope += by->root_l * 0.5 * l / (large * sqrt(large));
    slope += grazing * (by->grazing_l + 2 * l * by->grazing_l2);
    if (fabs(l) >= s->max_l) {
        slope += sign * by->max_l;
        by->max_l = 0;
    }
    return slope;
}

/* A stretch of a pair on the way back. */
typedef struct way_back {
    stretch s;
    const uint8_t *used; /* (n) NULL: all are */
    member ref, test;
    differences d;
    float by_f[ROOM], by_log[ROOM]; /* derivatives by f, and by log(f + NQM_DARK) */
} way_back;

/* Set by_f and by_log to the derivatives of the features of whole directions. by->max_l and by->peak_test are used up. */
static void find_direction_slopes(way_back *w, const nqm_scalar_sums *sums, nqm_scalar_sums *by) {
    const nqm_sum_plan *plan = w->s.plan;
    const float *d = w->d[NQM_SCALE_LOG_F];
    float l[STRETCH];
    nqm_sample_log_ratios(w->s.n, plan->darks, w->ref.luminance, w->test.luminance, l);
    for (size_t i = 0; i < w->s.n; ++i) {
        const size_t direction = w->s.first + i, cell = plan->cell[direction];
        const double c = (double)plan->cosines[3 * direction], luminance = (double)w->test.luminance[i];
        const double u = (double)d[3 * i] - (double)d[3 * i + 1];
        const double v = (double)d[3 * i + 2] - 0.5 * ((double)d[3 * i] + (double)d[3 * i + 1]);
        const double by_u = by->u + 2 * u * by->uv2, by_v = by->v + 2 * v * by->uv2;
        const double opponents[3] = {by_u - 0.5 * by_v, -by_u - 0.5 * by_v, by_v};
        if (w->used && !w->used[i])
            continue;
        double by_luminance =
            by_log_luminance(sums, (double)l[i], cell / NQM_ZONES_D, (double)plan->grazing[direction], by) /
            (luminance + NQM_DARK);
        if (luminance >= sums->peak_test) {
            by_luminance += by->peak_test;
            by->peak_test = 0;
        }
        for (size_t k = 0; k < 3; ++k) {
            w->by_log[3 * i + k] = (float)opponents[k];
            w->by_f[3 * i + k] =
                (float)(by->cell[cell].test[k] + c * by->weighted.test[k] + by_luminance * (double)plan->luminance[k]);
        }
    }
}

/* Add to by_f the derivatives by log(f + NQM_DARK) and those of the sums of differences on all scales, as derivatives by f. */
NQM_FOR_EACH_VECTOR_WIDTH
static void add_value_slopes(way_back *w, const nqm_metric_sums *by) {
    const nqm_sum_plan *plan = w->s.plan;
    const float *c = plan->cosines + 3 * w->s.first, *root_c = plan->roots + 3 * w->s.first;
    const float *inverse = plan->inverse + 3 * w->s.first, *a = w->ref.f, *f = w->test.f, *root_f = w->test.root;
    const float *by_log = w->by_log, least = (float)cbrt(NQM_CUBE_ROOT_FLOOR);
    float *by_f = w->by_f, (*d)[ROOM] = w->d, square[NQM_SCALES], magnitude[NQM_SCALES];
    for (size_t k = 0; k < NQM_SCALES; ++k) {
        square[k] = (float)(2 * by->squares[k]);
        magnitude[k] = (float)by->magnitudes[k];
    }
#pragma omp simd
    for (size_t i = 0; i < 3 * w->s.n; ++i) {
        const float sign = (f[i] > a[i] ? 1.0F : 0.0F) - (f[i] < a[i] ? 1.0F : 0.0F), cf_root = root_c[i] * root_f[i];
        const float root = cf_root > least ? cf_root : least;
#define SLOPE(k) (square[k] * d[k][i] + magnitude[k] * sign)
        by_f[i] += SLOPE(NQM_SCALE_F) + SLOPE(NQM_SCALE_CBRT_CF) * c[i] / (3 * root * root) +
                   SLOPE(NQM_SCALE_LOG1P_F) / (1 + f[i]) + SLOPE(NQM_SCALE_LOG1P_CF) / (inverse[i] + f[i]) +
                   (SLOPE(NQM_SCALE_LOG_F) + by_log[i]) / (f[i] + dark);
#undef SLOPE
    }
}

static void sum_light(const nqm_sum_plan *plan, const nqm_sample_pair *pair, nqm_scalar_sums *to) {
    for (size_t i = 0; i < plan->directions->n; ++i) {
        nqm_light_sum *cell = &to->cell[plan->cell[i]], *weighted = &to->weighted;
        const double c = plan->directions->cosines[i];
        for (size_t k = 3 * i; (!pair->used || pair->used[i]) && k < 3 * i + 3; ++k) {
            cell->ref[k % 3] += (double)pair->ref[k];
            cell->test[k % 3] += (double)pair->test[k];
            weighted->ref[k % 3] += c * (double)pair->ref[k];
            weighted->test[k % 3] += c * (double)pair->test[k];
        }
    }
}

nqm_pair_sums nqm_exact_sums(const nqm_compared_pair *p) {
    nqm_pair_sums sums = *p->sums;
    for (size_t i = 0; i <= NQM_CELLS; ++i) {
        nqm_light_sum *light = i < NQM_CELLS ? &sums.scalars.cell[i] : &sums.scalars.weighted;
        *light = (nqm_light_sum){.n = light->n};
    }
    sum_light(p->plan, &p->pair, &sums.scalars);
    return sums;
}

void nqm_sums_gradient(const nqm_compared_pair *p, nqm_pair_sums by, float *gradient) {
    const nqm_sum_plan *plan = p->plan;
    const uint8_t *used = used_of(plan, &p->pair);
    way_back w = {.used = NULL};
    by.metrics.squares[NQM_SCALE_LOG_F] += by.scalars.squares;
    for (size_t first = 0; first < plan->directions->n; first += STRETCH) {
        w.s = stretch_at(plan, first);
        w.used = used ? used + first : NULL;
        read_member(&w.s, p->pair.ref, p->ref_root, used, &w.ref);
        read_member(&w.s, p->pair.test, p->test_root, used, &w.test);
        find_differences(&w.s, &w.ref, &w.test, w.d);
        find_direction_slopes(&w, &p->sums->scalars, &by.scalars);
        add_value_slopes(&w, &by.metrics);
        for (size_t i = 0; i < 3 * w.s.n; ++i)
            if (!w.used || w.used[i / 3])
                gradient[3 * first + i] += w.by_f[i];
    }
}
