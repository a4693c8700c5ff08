/* SPDX-License-Identifier: MIT
 *
 * Rank and product-moment correlations, means and quantiles. Ties: mean ranks for Spearman's rho; tau-b for Kendall's
 * tau (Kendall 1945, DOI 10.1093/biomet/33.3.239), computed in O(n log n) by the method of Knight (1966,
 * DOI 10.1080/01621459.1966.10480879).
 */
#include "math/math.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- order ------------------------------------------------------------------------------------------------------- */

void nqm_sort_indexed(size_t n, const double *x, nqm_indexed *order) {
    for (size_t i = 0; i < n; ++i)
        order[i] = (nqm_indexed){x[i], i};
    qsort(order, n, sizeof *order, nqm_compare_indexed);
}

void nqm_ranks(size_t n, const double *x, double *rank, nqm_indexed *order) {
    nqm_sort_indexed(n, x, order);
    for (size_t begin = 0, end; begin < n; begin = end) {
        for (end = begin + 1; end < n && order[end].value == order[begin].value;)
            ++end;
        double mean_rank = 0.5 * ((double)begin + 1 + (double)end);
        for (size_t i = begin; i < end; ++i)
            rank[order[i].index] = mean_rank;
    }
}

int nqm_compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int nqm_compare_indexed(const void *a, const void *b) {
    const nqm_indexed *x = a, *y = b;
    int by_value = nqm_compare_doubles(&x->value, &y->value);
    return by_value ? by_value : (x->index > y->index) - (x->index < y->index);
}

double nqm_quantile(size_t n, double *x, double q) {
    if (n == 0)
        return NAN;
    qsort(x, n, sizeof *x, nqm_compare_doubles);
    double at = q * (double)(n - 1);
    size_t below = (size_t)at;
    if (below + 1 >= n)
        return x[n - 1];
    return x[below] + (at - (double)below) * (x[below + 1] - x[below]);
}

/* ---- mean and correlation ---------------------------------------------------------------------------------------- */

double nqm_mean(size_t n, const double *x) {
    double sum = 0;
    for (size_t i = 0; i < n; ++i)
        sum += x[i];
    return n ? sum / (double)n : NAN;
}

/* true when all values are equal or any value is NaN. Rounding can make the sum of squares of equal values > 0. */
static bool is_degenerate(size_t n, const double *x) {
    bool constant = true;
    for (size_t i = 0; i < n; ++i) {
        if (isnan(x[i]))
            return true;
        constant = constant && x[i] == x[0];
    }
    return constant;
}

double nqm_pearson(size_t n, const double *x, const double *y) {
    if (is_degenerate(n, x) || is_degenerate(n, y))
        return NAN;
    double mean_x = nqm_mean(n, x), mean_y = nqm_mean(n, y);
    double xx = 0, yy = 0, xy = 0;
    for (size_t i = 0; i < n; ++i) {
        double dx = x[i] - mean_x, dy = y[i] - mean_y;
        xx += dx * dx;
        yy += dy * dy;
        xy += dx * dy;
    }
    return fmax(-1, fmin(1, xy / sqrt(xx) / sqrt(yy)));
}

double nqm_spearman(size_t n, const double *x, const double *y) {
    if (is_degenerate(n, x) || is_degenerate(n, y))
        return NAN;
    double *rank;
    nqm_indexed *order;
    if (nqm_alloc_arrays(NQM_ARRAYS({&rank, 2 * n, sizeof *rank}, {&order, n, sizeof *order}), NULL) != NQM_OK)
        return NAN;
    nqm_ranks(n, x, rank, order);
    nqm_ranks(n, y, rank + n, order);
    const double rho = nqm_pearson(n, rank, rank + n);
    nqm_free(rank);
    return rho;
}

/* ---- Kendall ----------------------------------------------------------------------------------------------------- */

typedef struct point {
    double x, y;
} point;

static int compare_points(const void *a, const void *b) {
    const point *p = a, *q = b;
    int by_x = (p->x > q->x) - (p->x < q->x);
    return by_x ? by_x : (p->y > q->y) - (p->y < q->y);
}

/* Number of pairs of points with equal x (if by_x) and equal y (if by_y). Such points must be adjacent. */
static double tied_pairs(size_t n, const point *p, bool by_x, bool by_y) {
    double pairs = 0;
    for (size_t begin = 0, end; begin < n; begin = end) {
        for (end = begin + 1; end < n && (!by_x || p[end].x == p[begin].x) && (!by_y || p[end].y == p[begin].y);)
            ++end;
        double run = (double)(end - begin);
        pairs += 0.5 * run * (run - 1);
    }
    return pairs;
}

/* Sort by y (stable merge sort); returns the number of adjacent exchanges, which is the number of discordant pairs. */
static double sort_by_y(size_t n, point *p, point *scratch) {
    double exchanges = 0;
    for (size_t width = 1; width < n; width *= 2) {
        for (size_t begin = 0; begin < n; begin += 2 * width) {
            size_t middle = begin + width < n ? begin + width : n;
            size_t end = middle + width < n ? middle + width : n;
            size_t left = begin, right = middle;
            for (size_t k = begin; k < end; ++k) {
                bool take_right = right < end && (left == middle || p[right].y < p[left].y);
                exchanges += take_right ? (double)(middle - left) : 0;
                scratch[k] = p[take_right ? right++ : left++];
            }
        }
        memcpy(p, scratch, n * sizeof *p);
    }
    return exchanges;
}

double nqm_kendall(size_t n, const double *x, const double *y) {
    if (is_degenerate(n, x) || is_degenerate(n, y))
        return NAN;
    point *p = nqm_alloc(n, 2 * sizeof *p);
    if (!p)
        return NAN;
    for (size_t i = 0; i < n; ++i)
        p[i] = (point){x[i], y[i]};
    qsort(p, n, sizeof *p, compare_points);
    double all = 0.5 * (double)n * ((double)n - 1);
    double tied_x = tied_pairs(n, p, true, false);
    double tied_both = tied_pairs(n, p, true, true);
    double discordant = sort_by_y(n, p, p + n);
    double tied_y = tied_pairs(n, p, false, true);
    nqm_free(p);
    double concordant_minus_discordant = all - tied_x - tied_y + tied_both - 2 * discordant;
    return fmax(-1, fmin(1, concordant_minus_discordant / sqrt(all - tied_x) / sqrt(all - tied_y)));
}

double nqm_student95(double freedom) {
    double z = 1.6448536269514722, z3 = z * z * z, z5 = z3 * z * z;
    return z + (z3 + z) / (4 * freedom) + (5 * z5 + 16 * z3 + 3 * z) / (96 * freedom * freedom);
}
