/* SPDX-License-Identifier: MIT
 *
 * Generates a direction set (paper, section 3.1) in two steps.
 *
 * 1. Candidates: points (u, v, w) of the Halton sequence in the bases 2, 3, 5 (Halton 1960, DOI 10.1007/BF01386213)
 * with a random shift that depends on the seed give theta_h = max u^power, theta_d = max v, phi_d = 180 w degrees. The
 * angles are truncated to 1e-6 degree, so that their text is short and their identity does not depend on the last bit
 * of pow(). Candidates with theta_i or theta_o above max are rejected. Accepted points are therefore uniform in
 * (u, v, w) over the admissible region.
 *
 * 2. With references: oversampling * n candidates are sorted by theta_h and divided into strata, each of which yields
 * about ten directions. Directions are drawn from each stratum without replacement (Efraimidis and Spirakis 2006,
 * DOI 10.1016/j.ipl.2005.11.003) with probability proportional to the significance of the candidate: the sum over the
 * references of the cube root of the luminance, divided by its mean over the candidates. Taking the most significant
 * candidates instead would select grazing theta_d for nearly every material and leave the rest of the domain unsampled.
 *
 * The set is sorted by theta_h.
 */
#include "math/math.h"
#include "sample/node_grid.h"

#include <math.h>
#include <stdlib.h>

enum { KEPT_PER_STRATUM = 10 };

typedef struct candidate {
    double hd_deg[3];
    double significance;
    double key; /* key of the weighted draw; the candidates with the largest keys are drawn */
} candidate;

/* ---- options ----------------------------------------------------------------------------------------------------- */

#define FIELD(name) .key = #name, .offset = offsetof(nqm_directions_options, name)

/* clang-format off */
static const nqm_option rows[] = {
    {FIELD(n), .name = "", .kind = NQM_OPTION_SIZE, .min = 1, .max = 100000, .values = {"500"}},
    {FIELD(seed), .kind = NQM_OPTION_U64, .metavar = "S", .values = {"1"}, .help = "seed of the set"},
    {FIELD(max_polar_rad), .name = "max-polar", .metavar = "DEG", .min = 1, .max = 90, .scale = NQM_PI / 180,
     .values = {"75"}, .help = "largest angle of light and viewer with the normal", .unit = "degrees"},
    {FIELD(theta_h_power), .name = "power", .metavar = "P", .min = 0.1, .max = 100, .values = {"2"},
     .help = "theta_h = max u^P: above 1 is denser toward 0"},
    {FIELD(grid), .kind = NQM_OPTION_BOOL,
     .help = "instead, the nodes of the grid of light transport: the directions of model 'default'"},
    {FIELD(oversampling), .metavar = "K", .min = 1, .max = 100, .values = {"4"},
     .help = "candidates for each direction kept, with references"},
};
/* clang-format on */

const nqm_option_table nqm_directions_option_table = {rows, sizeof rows / sizeof *rows, NULL};

NQM_OPTIONS_DEFAULT(nqm_directions_option, 0)

static double fraction(double x) {
    return x - floor(x);
}

static bool is_admissible(const double *hd_deg, double max_polar_rad) {
    double hd[3], wi[3], wo[3];
    for (int k = 0; k < 3; ++k)
        hd[k] = hd_deg[k] * (NQM_PI / 180);
    nqm_half_diff_to_pair(hd, wi, wo);
    double lowest = cos(max_polar_rad);
    return wi[2] >= lowest && wo[2] >= lowest;
}

static void make_candidates(const nqm_directions_options *options, size_t n, candidate *candidates) {
    static const size_t bases[3] = {2, 3, 5};
    const double max_deg = options->max_polar_rad * (180 / NQM_PI);
    nqm_rng rng = nqm_rng_make(options->seed, 0);
    double shift[3];
    for (int k = 0; k < 3; ++k)
        shift[k] = nqm_rng_uniform(&rng);
    size_t made = 0;
    for (size_t i = 0; made < n; ++i) {
        double u[3];
        for (int k = 0; k < 3; ++k)
            u[k] = fraction(shift[k] + nqm_radical_inverse(i, bases[k]));
        candidate c = {.hd_deg = {max_deg * pow(u[0], options->theta_h_power), max_deg * u[1], 180 * u[2]}};
        for (int k = 0; k < 3; ++k)
            c.hd_deg[k] = floor(c.hd_deg[k] * 1e6) / 1e6;
        if (is_admissible(c.hd_deg, options->max_polar_rad))
            candidates[made++] = c;
    }
}

/* Add one reference to the significance of every candidate. hd, rgb: scratch (n, 3). */
static void add_reference(const nqm_brdf *ref, size_t n, candidate *candidates, const double *hd, double *rgb) {
    nqm_brdf_eval_half_diff(ref, n, hd, rgb, NULL); /* 0 where there is no value, so that it adds no significance */
    double sum = 0;
    for (size_t i = 0; i < n; ++i) {
        rgb[i] = cbrt(nqm_luminance(rgb + 3 * i)); /* the result overwrites the front of the array */
        sum += rgb[i];
    }
    if (!(sum > 0))
        return;
    for (size_t i = 0; i < n; ++i)
        candidates[i].significance += rgb[i] * ((double)n / sum);
}

static nqm_status measure_significance(const nqm_directions_options *options, size_t n_refs,
                                       const nqm_brdf *const *refs, size_t n, candidate *candidates, nqm_error *err) {
    double *hd = nqm_alloc(n, 6 * sizeof *hd);
    if (!hd)
        return nqm_fail_nomem(err, 6 * n * sizeof *hd);
    for (size_t i = 0; i < n; ++i)
        for (size_t k = 0; k < 3; ++k)
            hd[3 * i + k] = candidates[i].hd_deg[k] * (NQM_PI / 180);
    nqm_ticker ticker = {.fn = options->progress, .user = options->progress_user};
    nqm_status status = NQM_OK;
    for (size_t r = 0; r < n_refs && status == NQM_OK; ++r) {
        add_reference(refs[r], n, candidates, hd, hd + 3 * n);
        if (nqm_tick(&ticker, "references", (double)(r + 1), (double)n_refs))
            status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted after %zu of %zu references", r + 1, n_refs);
    }
    nqm_free(hd);
    return status;
}

static int compare_angles(const void *a, const void *b) {
    const candidate *p = a, *q = b;
    for (int k = 0; k < 3; ++k)
        if (p->hd_deg[k] != q->hd_deg[k])
            return p->hd_deg[k] < q->hd_deg[k] ? -1 : 1;
    return 0;
}

static int compare_keys(const void *a, const void *b) {
    const candidate *p = a, *q = b;
    return (p->key < q->key) - (p->key > q->key);
}

/* Move n of the m candidates, drawn stratum by stratum, to the front of the array. The input is sorted by theta_h. */
static void draw(uint64_t seed, size_t n, size_t m, candidate *candidates) {
    nqm_rng rng = nqm_rng_make(seed, 1);
    for (size_t i = 0; i < m; ++i)
        candidates[i].key = log(1 - nqm_rng_uniform(&rng)) / candidates[i].significance; /* -inf for significance 0 */
    size_t n_strata = (n + KEPT_PER_STRATUM - 1) / KEPT_PER_STRATUM;
    size_t kept = 0;
    for (size_t s = 0; s < n_strata; ++s) {
        size_t begin = s * m / n_strata, end = (s + 1) * m / n_strata;
        size_t share = (s + 1) * n / n_strata - s * n / n_strata;
        qsort(candidates + begin, end - begin, sizeof *candidates, compare_keys);
        for (size_t i = 0; i < share; ++i)
            candidates[kept++] = candidates[begin + i];
    }
}

nqm_status nqm_directions_create(const nqm_directions_options *options, size_t n_refs, const nqm_brdf *const *refs,
                                 nqm_directions **directions_ret, nqm_error *err) {
    NQM_REQUIRE(err, directions_ret);
    *directions_ret = NULL;
    NQM_REQUIRE_IF(n_refs, err, refs);
    nqm_directions_options defaults = nqm_directions_options_default();
    const nqm_directions_options *o = options ? options : &defaults;
    nqm_status status = nqm_options_check(&nqm_directions_option_table, o, err);
    if (status != NQM_OK)
        return status;
    if (o->grid)
        return nqm_node_grid_directions(directions_ret, err);
    size_t m = n_refs ? (size_t)ceil((double)o->n * o->oversampling) : o->n;
    candidate *candidates;
    double *degrees;
    status =
        nqm_alloc_arrays(NQM_ARRAYS({&candidates, m, sizeof *candidates}, {&degrees, o->n, 3 * sizeof *degrees}), err);
    if (status != NQM_OK)
        return status;
    make_candidates(o, m, candidates);
    qsort(candidates, m, sizeof *candidates, compare_angles);
    if (n_refs)
        status = measure_significance(o, n_refs, refs, m, candidates, err);
    if (n_refs && status == NQM_OK) {
        draw(o->seed, o->n, m, candidates);
        qsort(candidates, o->n, sizeof *candidates, compare_angles);
    }
    for (size_t i = 0; i < o->n; ++i)
        for (size_t k = 0; k < 3; ++k)
            degrees[3 * i + k] = candidates[i].hd_deg[k];
    if (status == NQM_OK)
        status = nqm_directions_from_degrees(o->n, degrees, directions_ret, err);
    nqm_free(candidates);
    return status;
}
