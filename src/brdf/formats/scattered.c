/* SPDX-License-Identifier: MIT
 *
 * A BRDF that is known at scattered directions: the value of the nearest one within a stated angle, none elsewhere, so that scores
 * use only directions that were measured. The nearest one is found in a vantage-point tree (Yianilos 1993, "Data structures and
 * algorithms for nearest neighbor search in general metric spaces"), in O(log n) also where all rows share a few lights.
 */
#include "brdf/formats/listed.h"

#include <math.h>
#include <stdlib.h>

/* A measured pair. */
typedef struct sample {
    double wi[3], wo[3];
    float rgb[3];
    bool is_exchanged; /* light and viewer are exchanged, by reciprocity */
} sample;

/* Allocated as one block; the arrays follow the struct. Node 0 of a tree of n samples is the vantage point; the next (n - 1) / 2 are
 * the tree of those at most `radius` away, the rest that of those at least so far. */
typedef struct scattered {
    size_t n;
    double reach;   /* largest distance, as a chord */
    bool turns;     /* isotropic: pairs are compared after a rotation */
    sample *sample; /* (n) */
    double *radius; /* (n) */
} scattered;

/* The real part of the product of complex numbers (x, y) and of the conjugate of another; and the imaginary part. */
static double product(const double *a, const double *b, double *imaginary) {
    *imaginary = a[1] * b[0] - a[0] * b[1];
    return a[0] * b[0] + a[1] * b[1];
}

/* Squared distance of two pairs of unit vectors; if it turns, minimal over rotations about the normal. */
static double squared_distance(bool turns, const sample *s, const double *wi, const double *wo) {
    double imaginary_i, imaginary_o;
    double real = product(wi, s->wi, &imaginary_i) + product(wo, s->wo, &imaginary_o);
    return 4 - 2 * (wi[2] * s->wi[2] + wo[2] * s->wo[2] + (turns ? hypot(real, imaginary_i + imaginary_o) : real));
}

/* A search: the pair, and the nearest sample so far with its squared distance; NULL: none is at most that far away. */
typedef struct search {
    const double *wi, *wo;
    const sample *nearest;
    double least;
} search;

/* Search the tree of n samples. The triangle inequality tells which half can have a nearer one; the half of the pair is searched first. */
static void search_tree(const scattered *t, size_t root, size_t n, search *s) {
    static const double slack = 1e-7; /* rounding of small distances */
    const size_t n_inner = (n - 1) / 2, inner = root + 1, outer = inner + n_inner;
    const double squared = squared_distance(t->turns, t->sample + root, s->wi, s->wo);
    const double distance = sqrt(fmax(squared, 0)), radius = t->radius[root];
    if (squared <= s->least) {
        s->least = fmax(squared, 0);
        s->nearest = t->sample + root;
    }
    for (int k = 0; k < 2; ++k) {
        const bool is_inner = (distance < radius) == (k == 0);
        const double beyond = is_inner ? distance - radius : radius - distance;
        const size_t n_half = is_inner ? n_inner : n - 1 - n_inner;
        if (n_half && beyond <= sqrt(s->least) + slack)
            search_tree(t, is_inner ? inner : outer, n_half, s);
    }
}

/* The nearest sample at most `reach` (a chord) away, and its distance; NULL: there is none. */
static const sample *find_nearest(const scattered *t, double reach, const double *wi, const double *wo,
                                  double *distance) {
    search s = {.wi = wi, .wo = wo, .least = reach * reach};
    search_tree(t, 0, t->n, &s);
    *distance = sqrt(s.least);
    return s.nearest;
}

static void scattered_eval(const void *self, size_t n, const double *wi, const double *wo, double *rgb) {
    const scattered *t = self;
    double distance;
    for (size_t i = 0; i < n; ++i) {
        const sample *s = find_nearest(t, t->reach, wi + 3 * i, wo + 3 * i, &distance);
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = s ? (double)s->rgb[c] : NAN;
    }
}

static const nqm_brdf_class scattered_class = {
    .format = "samples", .anisotropic = true, .eval = scattered_eval, .free = nqm_free};

static const scattered *table_of(const nqm_brdf *brdf) {
    return brdf->class_ == &scattered_class ? brdf->self : NULL;
}

size_t nqm_scattered_rows(const nqm_brdf *brdf, double *wi, double *wo) {
    const scattered *t = table_of(brdf);
    size_t n = 0;
    for (size_t i = 0; t && i < t->n; ++i) {
        const sample *s = &t->sample[i];
        if (s->is_exchanged)
            continue;
        if (wi) {
            memcpy(wi + 3 * n, s->wi, sizeof s->wi);
            memcpy(wo + 3 * n, s->wo, sizeof s->wo);
        }
        ++n;
    }
    return n;
}

double nqm_scattered_distance(const nqm_brdf *brdf, const double *wi, const double *wo) {
    const scattered *t = table_of(brdf);
    double distance = 0;
    if (t)
        find_nearest(t, 9, wi, wo, &distance);
    return 2 * asin(fmin(distance / 2, 1));
}

nqm_status nqm_scattered_distances(const nqm_brdf *brdf, size_t n, const double *wi, const double *wo,
                                   double quantile_deg[2], nqm_error *err) {
    double *distance = nqm_alloc(n, sizeof *distance);
    if (!distance)
        return nqm_fail_nomem(err, n * sizeof *distance);
    for (size_t i = 0; i < n; ++i)
        distance[i] = nqm_scattered_distance(brdf, wi + 3 * i, wo + 3 * i);
    quantile_deg[0] = nqm_quantile(n, distance, 0.5) * 180 / NQM_PI;
    quantile_deg[1] = nqm_quantile(n, distance, 0.95) * 180 / NQM_PI;
    nqm_free(distance);
    return NQM_OK;
}

/* The n_used pairs with a value above the horizon, each also exchanged if the list is reciprocal; returns the number of all. */
static size_t expand(const nqm_list *l, sample *out, size_t *n_used, size_t *n_below) {
    size_t n_out = 0;
    for (size_t i = 0; i < l->n; ++i) {
        sample s = {.is_exchanged = false};
        nqm_listed row = l->rows[i];
        if (l->has_pairs && !l->is_anisotropic && fmin(row.at[0], row.at[1]) < 1e-9)
            row.at[2] = 0; /* about the normal all azimuths are one direction */
        nqm_listed_pair(l, &row, s.wi, s.wo);
        for (size_t k = 0; k < 3; ++k) { /* -0 is 0: directions are compared by their bytes */
            s.wi[k] += 0.0;
            s.wo[k] += 0.0;
        }
        memcpy(s.rgb, l->rows[i].rgb, sizeof s.rgb);
        const bool has_value = !isnan(s.rgb[0]), is_above = s.wi[2] > 0 && s.wo[2] > 0;
        *n_below += has_value && !is_above;
        if (!has_value || !is_above)
            continue;
        ++*n_used;
        out[n_out++] = s;
        if (!l->is_reciprocal || memcmp(s.wi, s.wo, sizeof s.wi) == 0)
            continue;
        out[n_out] = s;
        out[n_out].is_exchanged = true;
        memcpy(out[n_out].wi, s.wo, sizeof s.wo);
        memcpy(out[n_out++].wo, s.wi, sizeof s.wi);
    }
    return n_out;
}

/* Sort by direction, equal ones in the order of the list, which is sorted. */
static int compare_samples(const void *a, const void *b) {
    const sample *x = *(sample *const *)a, *y = *(sample *const *)b;
    const int order = memcmp(x, y, offsetof(sample, rgb));
    return order ? order : (x > y) - (x < y);
}

/* Replace samples of one direction (by exchange, too) by the first, with their mean value. sorted: scratch (n). Returns the number
 * of those that stay, in their order; *n_repeated grows by the rows that do not. */
static size_t merge_repeated(size_t n, sample *list, sample **sorted, size_t *n_repeated) {
    size_t n_kept = 0;
    for (size_t i = 0; i < n; ++i)
        sorted[i] = list + i;
    qsort(sorted, n, sizeof *sorted, compare_samples);
    for (size_t i = 0, m; i < n; i += m) {
        double sum[3] = {0};
        for (m = 0; i + m < n && memcmp(sorted[i], sorted[i + m], offsetof(sample, rgb)) == 0; ++m) {
            for (size_t c = 0; c < 3; ++c)
                sum[c] += (double)sorted[i + m]->rgb[c];
            *n_repeated += m && !sorted[i + m]->is_exchanged && !sorted[i]->is_exchanged;
            sorted[i]->is_exchanged &= sorted[i + m]->is_exchanged;
            sorted[i + m]->rgb[0] = m ? NAN : sorted[i]->rgb[0];
        }
        for (size_t c = 0; c < 3 && m > 1; ++c)
            sorted[i]->rgb[c] = (float)(sum[c] / (double)m);
    }
    for (size_t i = 0; i < n; ++i)
        if (!isnan(list[i].rgb[0]))
            list[n_kept++] = list[i];
    return n_kept;
}

static void exchange(nqm_indexed *a, nqm_indexed *b) {
    const nqm_indexed first = *a;
    *a = *b;
    *b = first;
}

/* Move the k + 1 smallest values to the front, the largest of them to x[k] (Hoare's selection). */
static void select_smallest(nqm_indexed *x, size_t n, size_t k) {
    size_t low = 0, high = n - 1;
    while (low < high) {
        const double pivot = x[low + nqm_hash_u64(n, low) % (high - low + 1)].value;
        size_t i = low, j = high;
        for (;; ++i, --j) {
            while (x[i].value < pivot)
                ++i;
            while (x[j].value > pivot)
                --j;
            if (i >= j)
                break;
            exchange(x + i, x + j);
        }
        if (i <= k && k <= j)
            return;
        if (k < i)
            high = i - 1;
        else
            low = j + 1;
    }
}

/* Order n samples as a tree. order: their indices; radius: (n). */
static void make_tree(const scattered *t, size_t n, const sample *unsorted, nqm_indexed *order, double *radius) {
    const size_t n_inner = (n - 1) / 2;
    exchange(order, order + n / 2);
    const sample *vantage = unsorted + order[0].index;
    radius[0] = 0;
    if (n < 2)
        return;
    for (size_t i = 1; i < n; ++i) {
        const double squared = squared_distance(t->turns, unsorted + order[i].index, vantage->wi, vantage->wo);
        order[i].value = sqrt(fmax(squared, 0));
    }
    select_smallest(order + 1, n - 1, n_inner);
    radius[0] = order[1 + n_inner].value;
    if (n_inner)
        make_tree(t, n_inner, unsorted, order + 1, radius + 1);
    make_tree(t, n - 1 - n_inner, unsorted, order + 1 + n_inner, radius + 1 + n_inner);
}

nqm_status nqm_scattered_create(const nqm_list *list, double tolerance, const char *name, nqm_brdf **brdf_ret,
                                nqm_error *err) {
    const size_t most = list->is_reciprocal ? 2 * list->n : list->n;
    size_t n_used = 0, n_below = 0, n_repeated = list->n_repeated;
    scattered *t;
    double *radius;
    sample *sorted, *unsorted, **repeated;
    nqm_indexed *order;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&t, 1, sizeof *t}, {&radius, most, sizeof *radius}, {&sorted, most, sizeof *sorted}), err);
    if (status != NQM_OK)
        return status;
    status = nqm_alloc_arrays(NQM_ARRAYS({&unsorted, most, sizeof *unsorted}, {&order, most, sizeof *order},
                                         {&repeated, most, sizeof *repeated}),
                              err);
    if (status == NQM_OK) {
        *t = (scattered){
            .reach = 2 * sin(tolerance / 2), .turns = !list->is_anisotropic, .sample = sorted, .radius = radius};
        t->n = expand(list, unsorted, &n_used, &n_below);
        t->n = merge_repeated(t->n, unsorted, repeated, &n_repeated);
        for (size_t i = 0; i < t->n; ++i)
            order[i].index = i;
        if (t->n)
            make_tree(t, t->n, unsorted, order, radius);
        for (size_t i = 0; i < t->n; ++i)
            sorted[i] = unsorted[order[i].index];
        nqm_free(unsorted);
        if (t->n == 0)
            status = nqm_fail(err, NQM_ERR_FORMAT, 0, "%s: no direction above the horizon has a value (from byte 0 on)",
                              name);
    }
    if (status != NQM_OK) {
        nqm_free(t);
        return status;
    }
    char layout[160], remark[NQM_REMARK_SIZE];
    snprintf(layout, sizeof layout, "%zu directions%s, values within %g degrees of them",
             n_used - (n_repeated - list->n_repeated), list->is_anisotropic ? " with azimuths" : "",
             tolerance * 180 / NQM_PI);
    memcpy(remark, list->remark, sizeof remark);
    if (n_repeated)
        nqm_remark_add(remark, sizeof remark, NQM_REPEATED_ROWS, n_repeated);
    if (n_below)
        nqm_remark_add(remark, sizeof remark, "rows at the horizon or below it: %zu", n_below);
    nqm_brdf_info info = {
        .name = name, .layout = layout, .n_values = 3 * n_used, .remark = remark, .reciprocal = list->is_reciprocal};
    info.isotropic = !list->is_anisotropic;
    return nqm_brdf_wrap(&scattered_class, t, &info, brdf_ret, err);
}
