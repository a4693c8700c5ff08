/* SPDX-License-Identifier: MIT
 *
 * Common to all BRDFs: skipping pairs below the horizon, clamping and flagging values, and conversion between direction pairs and
 * half-vector coordinates (Rusinkiewicz 1998, DOI 10.1007/978-3-7091-6453-2_2).
 */
#include "brdf/brdf.h"

#include <math.h>

nqm_status nqm_brdf_wrap(const nqm_brdf_class *class_, void *self, const nqm_brdf_info *info, nqm_brdf **brdf_ret,
                         nqm_error *err) {
    nqm_brdf_info copy = *info;
    enum { N_TEXTS = 4 };
    const char **texts[N_TEXTS] = {&copy.name, &copy.spec, &copy.layout, &copy.remark};
    nqm_array arrays[1 + N_TEXTS] = {{brdf_ret, 1, sizeof(nqm_brdf)}};
    char *texts_of_copy[N_TEXTS];
    if (copy.remark && !*copy.remark)
        copy.remark = NULL;
    for (size_t i = 0; i < N_TEXTS; ++i)
        arrays[1 + i] = (nqm_array){&texts_of_copy[i], *texts[i] ? strlen(*texts[i]) + 1 : 0, 1};
    nqm_status status = nqm_alloc_arrays(1 + N_TEXTS, arrays, err);
    if (status != NQM_OK) {
        class_->free(self);
        return status;
    }
    for (size_t i = 0; i < N_TEXTS; ++i)
        if (*texts[i])
            *texts[i] = memcpy(texts_of_copy[i], *texts[i], arrays[1 + i].n);
    copy.format = class_->format;
    copy.reciprocal = info->reciprocal || class_->reciprocal;
    copy.isotropic = info->isotropic || !class_->anisotropic;
    **brdf_ret = (nqm_brdf){class_, self, copy};
    return NQM_OK;
}

nqm_status nqm_brdf_remark(nqm_brdf **brdf, const char *remark, nqm_error *err) {
    nqm_brdf *old = *brdf;
    nqm_brdf_info info = old->info;
    char text[NQM_REMARK_SIZE] = "";
    nqm_remark_add(text, sizeof text, "%s", remark);
    if (info.remark)
        nqm_remark_add(text, sizeof text, "%s", info.remark);
    info.remark = text;
    nqm_status status = nqm_brdf_wrap(old->class_, old->self, &info, brdf, err);
    nqm_free(old);
    return status;
}

void nqm_brdf_free(nqm_brdf *brdf) {
    if (brdf)
        brdf->class_->free(brdf->self);
    nqm_free(brdf);
}

nqm_brdf_info nqm_brdf_get_info(const nqm_brdf *brdf) {
    assert(brdf);
    return brdf->info;
}

/* ---- evaluation -------------------------------------------------------------------------------------------------- */

/* Pairs per block. A block contains the pairs above the horizon in dense arrays on the stack, so that evaluation
 * allocates nothing. */
enum { BLOCK = 512 };

/* Clamp and flag one raw value; rgb (3), in and out. */
static nqm_value_flag clamp_value(double *rgb) {
    if (!isfinite(rgb[0]) || !isfinite(rgb[1]) || !isfinite(rgb[2])) {
        rgb[0] = rgb[1] = rgb[2] = 0;
        return NQM_VALUE_INVALID;
    }
    nqm_value_flag flag = NQM_VALUE_OK;
    for (int c = 0; c < 3; ++c) {
        if (rgb[c] < 0) {
            rgb[c] = 0;
            flag = NQM_VALUE_CLAMPED;
        }
    }
    return flag;
}

/* Clamp, flag and store m raw values. place: (m) indices of their pairs; raw: (m, 3); rgb: (n, 3); flag: (n) or
 * NULL. */
static void scatter(size_t m, const size_t *place, double *raw, double *rgb, uint8_t *flag) {
    for (size_t k = 0; k < m; ++k) {
        nqm_value_flag f = clamp_value(raw + 3 * k);
        memcpy(rgb + 3 * place[k], raw + 3 * k, 3 * sizeof *rgb);
        if (flag)
            flag[place[k]] = (uint8_t)f;
    }
}

static void mark_horizon(size_t i, double *rgb, uint8_t *flag) {
    rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = 0;
    if (flag)
        flag[i] = NQM_VALUE_HORIZON;
}

/* Written so that NaN counts as below. */
static bool is_above_horizon(const double *wi, const double *wo) {
    return wi[2] > 0 && wo[2] > 0;
}

/* Sine and cosine of phi_h; 0 and 1 for the normal. */
static void half_turn(const double *wi, const double *wo, double *turn) {
    const double x = wi[0] + wo[0], y = wi[1] + wo[1], r = hypot(x, y);
    turn[0] = r > 0 ? y / r : 0;
    turn[1] = r > 0 ? x / r : 1;
}

static void eval_coordinates(const nqm_brdf *brdf, size_t m, const double *hd, const double *turn, double *raw) {
    if (brdf->class_->eval_turned)
        brdf->class_->eval_turned(brdf->self, m, hd, turn, raw);
    else /* NOLINTNEXTLINE(clang-analyzer-core.CallAndMessage): a class has one of the three */
        brdf->class_->eval_half_diff(brdf->self, m, hd, raw);
}

static void eval_block(const nqm_brdf *brdf, size_t m, const double *wi, const double *wo, double *raw) {
    if (brdf->class_->eval) {
        brdf->class_->eval(brdf->self, m, wi, wo, raw);
        return;
    }
    double hd[3 * BLOCK], turn[2 * BLOCK];
    void (*convert)(const double *, const double *, double *) =
        brdf->info.reciprocal ? nqm_half_diff_from_pair : nqm_half_diff_full_from_pair;
    for (size_t k = 0; k < m; ++k)
        convert(wi + 3 * k, wo + 3 * k, hd + 3 * k);
    for (size_t k = 0; k < m && !brdf->info.isotropic; ++k)
        half_turn(wi + 3 * k, wo + 3 * k, turn + 2 * k);
    eval_coordinates(brdf, m, hd, brdf->info.isotropic ? NULL : turn, raw);
}

void nqm_brdf_eval(const nqm_brdf *brdf, size_t n, const double *wi, const double *wo, double *rgb, uint8_t *flag) {
    assert(brdf);
    double in[3 * BLOCK], out[3 * BLOCK], raw[3 * BLOCK];
    size_t place[BLOCK];
    for (size_t i = 0; i < n;) {
        size_t m = 0;
        for (; i < n && m < BLOCK; ++i) {
            if (!is_above_horizon(wi + 3 * i, wo + 3 * i)) {
                mark_horizon(i, rgb, flag);
                continue;
            }
            memcpy(in + 3 * m, wi + 3 * i, 3 * sizeof *in);
            memcpy(out + 3 * m, wo + 3 * i, 3 * sizeof *out);
            place[m++] = i;
        }
        if (m)
            eval_block(brdf, m, in, out, raw);
        scatter(m, place, raw, rgb, flag);
    }
}

/* Map phi_d to [0, period): pi for a reciprocal BRDF, because exchanging light and viewer adds pi; otherwise 2 pi. */
static double fold_phi(double phi, double period) {
    double folded = fmod(phi, period);
    if (folded < 0)
        folded += period;
    return folded < period ? folded : 0;
}

static void eval_native(const nqm_brdf *brdf, size_t n, const double *hd, double *rgb, uint8_t *flag) {
    double native[3 * BLOCK], raw[3 * BLOCK];
    const double period = brdf->info.reciprocal ? NQM_PI : 2 * NQM_PI;
    size_t place[BLOCK];
    for (size_t i = 0; i < n;) {
        size_t m = 0;
        for (; i < n && m < BLOCK; ++i) {
            const double *c = hd + 3 * i;
            double mean_z = cos(c[0]) * cos(c[1]), swing_z = fabs(sin(c[0]) * sin(c[1]) * cos(c[2]));
            if (!(mean_z - swing_z > 0)) { /* minimum of wi.z and wo.z */
                mark_horizon(i, rgb, flag);
                continue;
            }
            native[3 * m] = c[0];
            native[3 * m + 1] = c[1];
            native[3 * m + 2] = fold_phi(c[2], period);
            place[m++] = i;
        }
        eval_coordinates(brdf, m, native, NULL, raw);
        scatter(m, place, raw, rgb, flag);
    }
}

void nqm_brdf_eval_half_diff(const nqm_brdf *brdf, size_t n, const double *hd, double *rgb, uint8_t *flag) {
    assert(brdf);
    nqm_brdf_eval_turned(brdf, n, hd, NULL, rgb, flag);
}

void nqm_brdf_eval_turned(const nqm_brdf *brdf, size_t n, const double *hd, const double *turn, double *rgb,
                          uint8_t *flag) {
    if (brdf->info.isotropic)
        turn = NULL;
    if (!turn && (brdf->class_->eval_half_diff || brdf->class_->eval_turned)) {
        eval_native(brdf, n, hd, rgb, flag);
        return;
    }
    double wi[3 * BLOCK], wo[3 * BLOCK];
    for (size_t i = 0; i < n; i += BLOCK) {
        size_t m = n - i < BLOCK ? n - i : BLOCK;
        for (size_t k = 0; k < m; ++k)
            nqm_half_diff_to_pair(hd + 3 * (i + k), wi + 3 * k, wo + 3 * k);
        for (size_t k = 0; k < m && turn; ++k) {
            nqm_turn3(turn + 2 * (i + k), wi + 3 * k, wi + 3 * k);
            nqm_turn3(turn + 2 * (i + k), wo + 3 * k, wo + 3 * k);
        }
        nqm_brdf_eval(brdf, m, wi, wo, rgb + 3 * i, flag ? flag + i : NULL);
    }
}

/* ---- derivatives by the parameters ------------------------------------------------------------------------------- */

/* Clamp a raw value as eval does; channels that eval replaces by 0 have the derivatives 0. jacobian: (3, n_parameters). */
static void clamp_derivatives(size_t n_parameters, double *rgb, double *jacobian) {
    const double raw[3] = {rgb[0], rgb[1], rgb[2]};
    const nqm_value_flag flag = clamp_value(rgb);
    for (size_t c = 0; flag != NQM_VALUE_OK && c < 3; ++c)
        if (flag == NQM_VALUE_INVALID || raw[c] < 0)
            memset(jacobian + c * n_parameters, 0, n_parameters * sizeof *jacobian);
}

nqm_status nqm_brdf_jacobian(const nqm_brdf *brdf, size_t n, const double *wi, const double *wo, double *rgb,
                             double *jacobian, nqm_error *err) {
    NQM_REQUIRE(err, brdf);
    NQM_REQUIRE_IF(n, err, wi, wo, rgb, jacobian);
    enum { RUN = 64 }; /* pairs per call: their rows stay in the L1 cache between memset() and the last change */
    const size_t n_parameters = brdf->info.n_values, row = 3 * n_parameters;
    if (!brdf->class_->jacobian)
        return nqm_fail(err, NQM_ERR_ARG, -1, "%s: only analytic models have derivatives by their parameters, not '%s'",
                        brdf->info.name, brdf->info.format);
    for (size_t i = 0, m; i < n; i += m) {
        const size_t most = n - i < RUN ? n - i : RUN;
        size_t n_above = 0;
        while (n_above < most && is_above_horizon(wi + 3 * (i + n_above), wo + 3 * (i + n_above)))
            ++n_above;
        m = n_above ? n_above : 1;
        memset(jacobian + row * i, 0, row * m * sizeof *jacobian);
        if (n_above)
            brdf->class_->jacobian(brdf->self, m, wi + 3 * i, wo + 3 * i, rgb + 3 * i, jacobian + row * i);
        else
            mark_horizon(i, rgb, NULL);
        for (size_t k = i; k < i + n_above; ++k)
            clamp_derivatives(n_parameters, rgb + 3 * k, jacobian + row * k);
    }
    return NQM_OK;
}

void nqm_half_diff_to_directions(const double *hd, double *wi, double *wo) {
    assert(hd && wi && wo);
    nqm_half_diff_to_pair(hd, wi, wo);
}

void nqm_directions_to_half_diff(const double *wi, const double *wo, double *hd) {
    assert(wi && wo && hd);
    nqm_half_diff_from_pair(wi, wo, hd);
}
