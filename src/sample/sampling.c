/* SPDX-License-Identifier: MIT
 *
 * Samples a BRDF at a direction set, with a policy for directions at which the BRDF has no value; and samples as files of the
 * paper's authors (doc/files.md): r, g, b and random_locations in MAT v5.
 */
#include "brdf/brdf.h"
#include "io/io.h"
#include "math/math.h"
#include "sample/sample.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { AT_ONCE = 512 }; /* directions per call: few enough for the stack, enough to batch the reads of a format */

const char *const nqm_invalid_words[] = {"drop", "zero", "nearest", "error", NULL};

static double square_distance(const double *a, const double *b) {
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return nqm_dot3(d, d);
}

/* Squared distance between two pairs of directions, the smaller of both orders of light and viewer (reciprocity). */
static double pair_distance(const nqm_directions *directions, size_t i, size_t j) {
    const double *wi = directions->wi + 3 * i, *wo = directions->wo + 3 * i;
    const double *other_wi = directions->wi + 3 * j, *other_wo = directions->wo + 3 * j;
    return fmin(square_distance(wi, other_wi) + square_distance(wo, other_wo),
                square_distance(wi, other_wo) + square_distance(wo, other_wi));
}

/* Copy the nearest valid value to every direction without one; at least one direction must have a value. */
static void fill_from_nearest(const nqm_directions *directions, const uint8_t *flag, float *rgb) {
    const size_t n = directions->n;
    for (size_t i = 0; i < n; ++i) {
        if (nqm_has_value(flag[i]))
            continue;
        size_t nearest = i;
        double least = INFINITY;
        for (size_t j = 0; j < n; ++j) {
            double distance = nqm_has_value(flag[j]) ? pair_distance(directions, i, j) : INFINITY;
            if (distance < least) {
                least = distance;
                nearest = j;
            }
        }
        memcpy(rgb + 3 * i, rgb + 3 * nearest, 3 * sizeof *rgb);
    }
}

static nqm_sample_report count_flags(size_t n, const uint8_t *flag) {
    nqm_sample_report counts = {.n = n};
    for (size_t i = 0; i < n; ++i) {
        counts.n_clamped += flag[i] == NQM_VALUE_CLAMPED;
        counts.n_invalid += !nqm_has_value(flag[i]);
    }
    return counts;
}

/* Apply the policy to directions without a value, which are already 0. */
static nqm_status apply_policy(const nqm_brdf *brdf, const nqm_directions *directions, nqm_invalid_policy policy,
                               const uint8_t *flag, float *rgb, nqm_error *err) {
    nqm_sample_report counts = count_flags(directions->n, flag);
    if (counts.n_invalid == 0)
        return NQM_OK;
    if (counts.n_invalid == counts.n)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: no value at any of the %zu directions", brdf->info.name,
                        counts.n);
    if (policy == NQM_INVALID_ERROR)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: no value at %zu of %zu directions", brdf->info.name,
                        counts.n_invalid, counts.n);
    if (policy == NQM_INVALID_NEAREST)
        fill_from_nearest(directions, flag, rgb);
    return NQM_OK;
}

/* Sample up to AT_ONCE directions from `next` on; returns the first that is left. A reciprocal BRDF has the value of the twin. */
static size_t sample_some(const nqm_brdf *brdf, const nqm_directions *directions, size_t next, float *rgb,
                          uint8_t *flag) {
    double wi[3 * AT_ONCE] = {0}, wo[3 * AT_ONCE] = {0}, values[3 * AT_ONCE];
    uint8_t flags[AT_ONCE];
    size_t place[AT_ONCE], m = 0, end = next;
    const uint32_t *twin = directions->twin;
    for (; end < directions->n && m < AT_ONCE; ++end) {
        if (brdf->info.reciprocal && twin[end] != end)
            continue;
        memcpy(wi + 3 * m, directions->wi + 3 * end, 3 * sizeof *wi);
        memcpy(wo + 3 * m, directions->wo + 3 * end, 3 * sizeof *wo);
        place[m++] = end;
    }
    nqm_brdf_eval(brdf, m, wi, wo, values, flags);
    for (size_t k = 0; k < 3 * m; ++k)
        rgb[3 * place[k / 3] + k % 3] = (float)fmin(values[k], FLT_MAX);
    for (size_t k = 0; k < m; ++k)
        flag[place[k]] = flags[k];
    for (size_t i = next; i < end; ++i)
        if (brdf->info.reciprocal && twin[i] != i) {
            memcpy(rgb + 3 * i, rgb + 3 * twin[i], 3 * sizeof *rgb);
            flag[i] = flag[twin[i]];
        }
    return end;
}

nqm_status nqm_sample(const nqm_brdf *brdf, const nqm_directions *directions, nqm_invalid_policy policy, float *rgb,
                      uint8_t *flag, nqm_sample_report *report, nqm_error *err) {
    NQM_REQUIRE(err, brdf, directions, rgb);
    size_t n = directions->n;
    uint8_t *own = flag ? NULL : nqm_alloc(n, sizeof *own), *flags = flag ? flag : own;
    if (!flags)
        return nqm_fail_nomem(err, n * sizeof *own);
    for (size_t next = 0; next < n;)
        next = sample_some(brdf, directions, next, rgb, flags);
    nqm_status status = apply_policy(brdf, directions, policy, flags, rgb, err);
    if (report)
        *report = count_flags(n, flags);
    nqm_free(own);
    return status;
}

nqm_status nqm_samples_save_mat(const nqm_directions *directions, const float *rgb, const char *path, nqm_error *err) {
    NQM_REQUIRE(err, directions, rgb, path);
    size_t n = directions->n;
    double *planes = nqm_alloc(n, 3 * sizeof *planes);
    if (!planes)
        return nqm_fail_nomem(err, n * 3 * sizeof *planes);
    for (size_t i = 0; i < 3 * n; ++i)
        planes[i % 3 * n + i / 3] = (double)rgb[i];
    const nqm_mat_variable variables[] = {{"r", n, 1, planes},
                                          {"g", n, 1, planes + n},
                                          {"b", n, 1, planes + 2 * n},
                                          {"random_locations", n, 3, directions->degrees}};
    nqm_status status = nqm_mat_write(path, sizeof variables / sizeof variables[0], variables, err);
    nqm_free(planes);
    return status;
}
