/* SPDX-License-Identifier: MIT
 *
 * A BRDF in another frame: turned about its normal (rotate), or with a tilted normal (tilt). A tilted BRDF is what
 * renderers make of a normal map: the surface still has the cosine of its own normal, so that light and viewer may not
 * be exchanged.
 */
#include "brdf/core/spec.h"

#include <math.h>

enum { DEG, AZIMUTH, BLOCK = 128 };
static const double DEGREE = NQM_PI / 180;

typedef struct frame {
    nqm_between_bases bases;
    double axes[9]; /* (axis, component): the frame of the base */
    bool is_base;   /* the result has the values of the base */
} frame;

static void mark_invalid(size_t n, const uint8_t *flag, double *rgb) {
    for (size_t i = 0; i < n; ++i)
        if (flag[i] == NQM_VALUE_INVALID)
            rgb[3 * i] = NAN;
}

static void frame_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    const frame *self = state;
    double in[3 * BLOCK], out[3 * BLOCK];
    uint8_t flag[BLOCK];
    for (size_t first = 0; first < n; first += BLOCK) {
        const size_t m = nqm_smaller(n - first, BLOCK), at = 3 * first;
        for (size_t k = 0; k < 3 * m; ++k) {
            in[k] = nqm_dot3(self->axes + 3 * (k % 3), wi + at + k - k % 3);
            out[k] = nqm_dot3(self->axes + 3 * (k % 3), wo + at + k - k % 3);
        }
        nqm_brdf_eval(self->bases.of, m, in, out, rgb + at, flag);
        for (size_t k = 0; k < 3 * m; ++k)
            rgb[at + k] *= in[k - k % 3 + 2] / wi[at + k - k % 3 + 2];
        mark_invalid(m, flag, rgb + at);
    }
}

/* A base that is a table or a network over these coordinates keeps its bits. */
static void frame_eval_half_diff(const void *state, size_t n, const double *hd, double *rgb) {
    const frame *self = state;
    double wi[3 * BLOCK], wo[3 * BLOCK];
    uint8_t flag[BLOCK];
    for (size_t first = 0; first < n; first += BLOCK) {
        const size_t m = nqm_smaller(n - first, BLOCK), at = 3 * first;
        if (self->is_base) {
            nqm_brdf_eval_half_diff(self->bases.of, m, hd + at, rgb + at, flag);
            mark_invalid(m, flag, rgb + at);
            continue;
        }
        for (size_t i = 0; i < m; ++i)
            nqm_half_diff_to_pair(hd + at + 3 * i, wi + 3 * i, wo + 3 * i);
        frame_eval(state, m, wi, wo, rgb + at);
    }
}

static nqm_status make(const double *axes, bool is_base, void **state_ret, nqm_error *err) {
    static const double same[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    frame *self = *state_ret = nqm_alloc(1, sizeof *self);
    if (!self)
        return nqm_fail_nomem(err, sizeof *self);
    memcpy(self->axes, is_base ? same : axes, sizeof same);
    self->is_base = is_base;
    return NQM_OK;
}

static nqm_status create_rotated(const nqm_values *values, const nqm_between_bases *bases, nqm_brdf_info *info,
                                 void **state_ret, nqm_error *err) {
    const double angle = DEGREE * values->v[DEG][0], s = sin(angle), c = cos(angle);
    (void)bases;
    return make((double[9]){c, s, 0, -s, c, 0, 0, 0, 1}, info->isotropic || angle == 0, state_ret, err);
}

/* The smallest rotation that takes the normal to the new one takes the tangent along: rows of its axes, for a new
 * normal of polar angle asin(s) = acos(c) and azimuth atan2(y, x). */
static void tilted_axes(double x, double y, double s, double c, double axes[9]) {
    const double d = 1 - c;
    const double rows[9] = {1 - d * x * x, -d * x * y, -s * x, -d * x * y, 1 - d * y * y, -s * y, s * x, s * y, c};
    memcpy(axes, rows, sizeof rows);
}

static nqm_status create_tilted(const nqm_values *values, const nqm_between_bases *bases, nqm_brdf_info *info,
                                void **state_ret, nqm_error *err) {
    const double angle = DEGREE * values->v[DEG][0], azimuth = DEGREE * values->v[AZIMUTH][0];
    double axes[9];
    (void)bases;
    if (angle > 0)
        info->reciprocal = info->isotropic = 0;
    tilted_axes(cos(azimuth), sin(azimuth), sin(angle), cos(angle), axes);
    return make(axes, angle == 0, state_ret, err);
}

#define FRAME_CLASS(NAME)                                                                                              \
    {                                                                                                                  \
        .format = NAME, .anisotropic = true, .eval = frame_eval, .eval_half_diff = frame_eval_half_diff,               \
        .free = nqm_wrapper_free                                                                                       \
    }

const nqm_spec_wrapper nqm_rotate_wrapper = {
    .schema = {"rotate", 1, {[DEG] = {.name = "deg", .n = 1, .low = -360, .high = 360, .required = true}}},
    .form = "rotate: 'of=' and a BRDF are missing at the end (rotate:deg=30;of=BRDF)",
    .class_ = FRAME_CLASS("rotate"),
    .create = create_rotated,
};

const nqm_spec_wrapper nqm_tilt_wrapper = {
    .schema = {"tilt",
               2,
               {[DEG] = {.name = "deg", .n = 1, .low = 0, .high = 60, .required = true},
                [AZIMUTH] = {.name = "azimuth", .n = 1, .low = -360, .high = 360, .fallback = 0}}},
    .form = "tilt: 'of=' and a BRDF are missing at the end (tilt:deg=5;azimuth=90;of=BRDF)",
    .class_ = FRAME_CLASS("tilt"),
    .create = create_tilted,
};

void nqm_brdf_frame_normal(const nqm_brdf *brdf, double normal[3]) {
    double inner[3];
    normal[0] = normal[1] = 0;
    normal[2] = 1;
    if (brdf->class_->eval != frame_eval)
        return;
    const frame *self = brdf->self;
    nqm_brdf_frame_normal(self->bases.of, inner);
    for (size_t k = 0; k < 3; ++k)
        normal[k] = inner[0] * self->axes[k] + inner[1] * self->axes[3 + k] + inner[2] * self->axes[6 + k];
}

nqm_status nqm_brdf_tilt(nqm_brdf *of, const double *normal, nqm_brdf **brdf_ret, nqm_error *err) {
    const double s = hypot(normal[0], normal[1]);
    const nqm_brdf_info info = {.name = of->info.name,
                                .isotropic = s > 0 ? 0 : of->info.isotropic,
                                .reciprocal = s > 0 ? 0 : of->info.reciprocal};
    double axes[9];
    void *state;
    tilted_axes(s > 0 ? normal[0] / s : 1, s > 0 ? normal[1] / s : 0, s, normal[2], axes);
    *brdf_ret = NULL;
    nqm_status status = make(axes, s == 0, &state, err);
    if (status != NQM_OK)
        return status;
    *(nqm_between_bases *)state = (nqm_between_bases){.of = of};
    return nqm_brdf_wrap(&nqm_tilt_wrapper.class_, state, &info, brdf_ret, err);
}

nqm_status nqm_brdf_tilt_degrees(nqm_brdf *of, double deg, double azimuth_deg, nqm_brdf **brdf_ret, nqm_error *err) {
    const nqm_between_bases bases = {.of = of, .owns_of = true};
    const nqm_values values = {.v = {[DEG] = {deg}, [AZIMUTH] = {azimuth_deg}}};
    nqm_brdf_info info = {.name = of->info.name, .isotropic = of->info.isotropic, .reciprocal = of->info.reciprocal};
    void *state;
    nqm_status status = create_tilted(&values, &bases, &info, &state, err);
    if (status != NQM_OK) {
        nqm_brdf_free(of);
        return status;
    }
    *(nqm_between_bases *)state = bases;
    return nqm_brdf_wrap(&nqm_tilt_wrapper.class_, state, &info, brdf_ret, err);
}
