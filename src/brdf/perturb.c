/* SPDX-License-Identifier: MIT
 *
 * Distorted copies of any BRDF, with the faults that approximations have: a lobe that is too blunt or misplaced, a weak
 * or strong highlight, wrong behaviour toward grazing angles, colour casts, blur, noise, coarse steps. doc/brdf.md
 * defines each setting.
 *
 * Everything is done in half-vector coordinates with phi_d in [0, pi), so that the result is reciprocal whatever the
 * base is. First the place is changed where the base is read (shift, gloss, smooth), then the value (the other
 * settings, in the order of the keys below).
 */
#include "brdf/perturb.h"
#include "brdf/spec.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

enum {
    SHIFT,
    GLOSS,
    SMOOTH,
    CLAMP,
    PEAK,
    FRESNEL,
    MIX,
    DESATURATE,
    HUE,
    TINT,
    SCALE,
    RIPPLE,
    BANDS,
    NOISE,
    SEED,
    CELLS,
    QUANTISE,
    N_KEYS
};

static const nqm_spec_schema schema = {
    "perturb",
    N_KEYS,
    {[SHIFT] = {.name = "shift", .n = 1, .low = -45, .high = 45, .fallback = 0},
     [GLOSS] = {.name = "gloss", .n = 1, .low = 0.05, .high = 20, .fallback = 1},
     [SMOOTH] = {.name = "smooth", .n = 1, .low = 0.01, .high = 30, .fallback = 0},
     [CLAMP] = {.name = "clamp", .n = 1, .low = 0, .high = 1, .fallback = 0},
     [PEAK] = {.name = "peak", .n = 1, .low = 0, .high = 100, .fallback = 1},
     [FRESNEL] = {.name = "fresnel", .n = 1, .low = 0, .high = 100, .fallback = 1},
     [MIX] = {.name = "mix", .n = 1, .low = 0, .high = 1, .fallback = 0},
     [DESATURATE] = {.name = "desaturate", .n = 1, .low = -1, .high = 1, .fallback = 0},
     [HUE] = {.name = "hue", .n = 1, .low = -180, .high = 180, .fallback = 0},
     [TINT] = {.name = "tint", .n = 3, .low = 0, .high = 100, .fallback = 1},
     [SCALE] = {.name = "scale", .n = 1, .low = 0, .high = 1000, .fallback = 1},
     [RIPPLE] = {.name = "ripple", .n = 1, .low = 0, .high = 1, .fallback = 0},
     [BANDS] = {.name = "bands", .n = 1, .low = 1, .high = 1000, .fallback = 12},
     [NOISE] = {.name = "noise", .n = 1, .low = 0, .high = 5, .fallback = 0},
     [SEED] = {.name = "seed", .n = 1, .low = 0, .high = 9007199254740992.0, .whole = true, .fallback = 1},
     [CELLS] = {.name = "cells", .n = 1, .low = 1, .high = 64, .whole = true, .fallback = 16},
     [QUANTISE] = {.name = "quantise", .n = 1, .low = 0, .high = 1000, .fallback = 0}}};

enum { MAX_NESTED = 3 }; /* each level may multiply the work by NQM_SMOOTH_TAPS */

static void perturb_free(void *state) {
    nqm_perturbation *self = state;
    nqm_brdf_free(self->base);
    nqm_free(self->lattice);
    nqm_free(self);
}

static const nqm_brdf_class perturb_class = {
    .format = "perturb", .reciprocal = 1, .eval_half_diff = nqm_perturbation_eval, .free = perturb_free};

/* ---- opening ----------------------------------------------------------------------------------------------------- */

static float *make_lattice(size_t n_cells, uint64_t seed) {
    size_t n = 3 * (n_cells + 1) * (n_cells + 1) * (n_cells + 1);
    float *lattice = nqm_alloc(n, sizeof *lattice);
    nqm_rng rng = nqm_rng_make(seed, 0);
    for (size_t i = 0; lattice && i < n; ++i)
        lattice[i] = (float)nqm_rng_normal(&rng);
    return lattice;
}

/* What `clamp` is relative to: the largest channel of the base in the mirror direction, theta_d = 0 to 60 degrees. */
static double mirror_maximum(const nqm_brdf *base) {
    enum { N = 13 };
    double hd[3 * N] = {0}, rgb[3 * N], largest = 0;
    uint8_t flag[N];
    for (size_t i = 0; i < N; ++i)
        hd[3 * i + 1] = 5 * (double)i * NQM_PI / 180;
    nqm_brdf_eval_half_diff(base, N, hd, rgb, flag); /* 0 where there is no value */
    for (size_t i = 0; i < 3 * N; ++i)
        largest = fmax(largest, rgb[i]);
    return largest;
}

/* First row of the rotation by `angle` about (1, 1, 1). */
static void hue_row(double angle, double row[3]) {
    double c = cos(angle), s = sin(angle) / sqrt(3);
    row[0] = c + (1 - c) / 3;
    row[1] = (1 - c) / 3 - s;
    row[2] = (1 - c) / 3 + s;
}

static nqm_status prepare(nqm_perturbation *self, const nqm_spec_values *values, nqm_error *err) {
    const double degree = NQM_PI / 180;
    self->shift_rad = values->v[SHIFT][0] * degree;
    self->gloss = values->v[GLOSS][0];
    self->smooth_rad = values->v[SMOOTH][0] * degree;
    self->n_taps = self->smooth_rad > 0 ? NQM_SMOOTH_TAPS : 1;
    self->peak = values->v[PEAK][0];
    self->n_rows = self->n_taps + (self->peak != 1);
    self->fresnel = values->v[FRESNEL][0];
    self->mix = values->v[MIX][0];
    self->desaturate = values->v[DESATURATE][0];
    double largest = values->v[CLAMP][0] > 0 ? mirror_maximum(self->base) : 0;
    self->ceiling = largest > 0 ? values->v[CLAMP][0] * largest : HUGE_VAL;
    hue_row(values->v[HUE][0] * degree, self->hue);
    self->ripple = values->v[RIPPLE][0];
    self->bands = values->v[BANDS][0];
    self->quantise = values->v[QUANTISE][0];
    self->sigma = values->v[NOISE][0];
    for (size_t c = 0; c < 3; ++c)
        self->colour[c] = values->v[TINT][c] * values->v[SCALE][0];
    if (self->mix > 0) {
        /* 45 degrees halves the hemisphere's projected solid angle. */
        nqm_brdf_albedo(self->base, NQM_PI / 4, 1, self->lambert);
        for (size_t c = 0; c < 3; ++c)
            self->lambert[c] /= NQM_PI;
    }
    if (self->sigma > 0) {
        self->n_cells = (size_t)values->v[CELLS][0];
        self->lattice = make_lattice(self->n_cells, (uint64_t)values->v[SEED][0]);
        if (!self->lattice)
            return nqm_fail_nomem(err, 12 * (self->n_cells + 1) * (self->n_cells + 1) * (self->n_cells + 1));
    }
    return NQM_OK;
}

/* Split "key=v;...;of=BASE": *base points at BASE; the settings before it are parsed. */
static nqm_status parse(const char *settings, const char **base, nqm_spec_values *values, nqm_error *err) {
    const char *of = strncmp(settings, "of=", 3) == 0 ? settings : strstr(settings, ";of=");
    if (!of)
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        "perturb: 'of=' and a BRDF are missing at the end (perturb:scale=2;of=BRDF)");
    *base = of + (*of == ';') + 3;
    char *head = nqm_strdup(settings);
    if (!head)
        return nqm_fail_nomem(err, strlen(settings) + 1);
    head[of - settings] = 0;
    nqm_status status = nqm_spec_parse(&schema, head, values, err);
    nqm_free(head);
    if (status == NQM_OK && !(values->given & ~(1u << BANDS | 1u << SEED | 1u << CELLS)))
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        "perturb: nothing is changed: give scale, tint, gloss, peak, ... before 'of='");
    return status;
}

/* The canonical text: ours, then that of the base, or its name when it is a file. nqm_free(); NULL when out of
 * memory. */
static char *canonical_spec(const nqm_spec_values *values, const nqm_brdf *base) {
    const char *of = base->spec ? base->spec : base->name;
    char *own = nqm_spec_format(&schema, values);
    size_t n = own ? strlen(own) + strlen(";of=") + strlen(of) + 1 : 0;
    char *spec = own ? nqm_alloc(n, 1) : NULL;
    if (spec)
        snprintf(spec, n, "%s;of=%s", own, of);
    nqm_free(own);
    return spec;
}

static size_t nested_levels(const char *base) {
    size_t n = 0;
    while ((base = strstr(base, "perturb:")) != NULL) {
        ++n;
        base += strlen("perturb:");
    }
    return n;
}

/* Make the BRDF of `values` over `base`, which it takes over. */
static nqm_status wrap(const nqm_spec_values *values, nqm_brdf *base, const char *name, nqm_brdf **brdf_ret,
                       nqm_error *err) {
    char layout[128];
    char *spec = NULL;
    nqm_perturbation *self = nqm_alloc(1, sizeof *self);
    if (!self) {
        nqm_brdf_free(base);
        return nqm_fail_nomem(err, sizeof *self);
    }
    self->base = base;
    nqm_status status = prepare(self, values, err);
    if (status != NQM_OK)
        goto fail;
    spec = canonical_spec(values, base);
    if (!spec) {
        status = nqm_fail_nomem(err, strlen(base->name));
        goto fail;
    }
    const char *doi = base->source_doi;
    snprintf(layout, sizeof layout, "over %s, %.100s", base->class_->format, base->layout ? base->layout : "");
    status = nqm_brdf_wrap(&perturb_class, self, name ? name : spec, spec, layout, brdf_ret, err);
    nqm_free(spec);
    if (status == NQM_OK)
        (*brdf_ret)->source_doi = doi;
    return status;
fail:
    perturb_free(self);
    return status;
}

nqm_status nqm_perturb_open(const char *settings, const char *name, nqm_brdf **brdf_ret, nqm_error *err) {
    *brdf_ret = NULL;
    const char *of = NULL;
    nqm_spec_values values;
    nqm_brdf *base;
    nqm_status status = parse(settings, &of, &values, err);
    if (status != NQM_OK)
        return status;
    if (nested_levels(of) >= MAX_NESTED)
        return nqm_fail(err, NQM_ERR_LIMIT, -1, "perturb: at most %d perturbations may be nested", MAX_NESTED);
    status = nqm_brdf_open(of, &base, err);
    return status == NQM_OK ? wrap(&values, base, name, brdf_ret, err) : status;
}

nqm_status nqm_perturb_wrap(const char *settings, nqm_brdf *base, nqm_brdf **brdf_ret, nqm_error *err) {
    *brdf_ret = NULL;
    nqm_spec_values values;
    nqm_status status = nqm_spec_parse(&schema, settings, &values, err);
    if (status != NQM_OK) {
        nqm_brdf_free(base);
        return status;
    }
    return wrap(&values, base, NULL, brdf_ret, err);
}
