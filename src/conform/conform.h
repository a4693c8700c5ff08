/* SPDX-License-Identifier: MIT
 *
 * conform.h - the kit of a shading model, and the mistakes that may explain the values of somebody's shader.
 */
#ifndef NQM_SRC_CONFORM_H
#define NQM_SRC_CONFORM_H

#include "base/base.h"
#include "schema/schema.h"
#include <nqm/conform.h>

#include <math.h>

/* ---- the kit (kit.c) --------------------------------------------------------------------------------------------- */

enum { NQM_CONFORM_AZIMUTHS = 3, NQM_CONFORM_MAX_SETS = 120 };
/** Degrees by which light and viewer of a set are rotated about the normal: the directions of the metric have one azimuth of the
 *  half vector, and anisotropic lobes have three. */
extern const double nqm_conform_azimuths_deg[NQM_CONFORM_AZIMUTHS];

/** A parameter set. */
typedef struct nqm_kit_set {
    nqm_values values; /* `given` has the keys that differ from their defaults */
    size_t azimuth;    /* of nqm_conform_azimuths_deg; 0 for isotropic sets */
    char *spec;
} nqm_kit_set;

struct nqm_conform_kit {
    const nqm_schema *schema;
    const nqm_model *metric;
    size_t n_directions, n_sets, n_columns;
    double *directions; /* (NQM_CONFORM_AZIMUTHS, 2, n_directions, 3) light and viewer */
    double *columns;    /* (NQM_CONFORM_MAX_SETS, n_columns) the values of the sets */
    char names[2048];   /* of the columns */
    uint64_t keys;      /* bit k: sets have values of key k; else its default */
    nqm_kit_set sets[NQM_CONFORM_MAX_SETS];
};

/** The directions of light (side 0) or viewer (1) at an azimuth, (n_directions, 3). */
static inline double *nqm_conform_directions(const nqm_conform_kit *kit, size_t azimuth, size_t side) {
    return kit->directions + 3 * (2 * azimuth + side) * kit->n_directions;
}

/** Write a kit (write.c): rows of all sets and directions as CSV, or arrays for shaders with the loop over them. format: "csv", "glsl",
 *  "hlsl" or "h" (C); NULL: by the ending of the path. NQM_ERR_ARG: another format; NQM_ERR_IO. */
NQM_MUST_CHECK nqm_status nqm_conform_kit_write(const nqm_conform_kit *kit, const char *format, const char *path,
                                                nqm_error *err);

/* ---- mistakes (mistakes.c) --------------------------------------------------------------------------------------- */

/** A mistake in a formula, in the use of a parameter, or of channels. */
typedef struct nqm_conform_flaw {
    size_t key;    /* of the schema; its n_keys: formulas and values */
    size_t how;    /* index of property_mistakes, or NQM_MISTAKE_..., and beyond them of channels */
    double amount; /* a limit, an exponent or a factor; 0: it has none */
} nqm_conform_flaw;

/** What a shader may do wrong; zeroed: nothing. */
typedef struct nqm_conform_suspect {
    size_t n_flaws;
    nqm_conform_flaw flaws[2];
    size_t kind; /* of suspects that differ in their amounts only; 0: no flaw */
    double left; /* mean absolute difference of log(f_r + 0.003) that remains */
} nqm_conform_suspect;

/** Whether a direction of a shader counts. */
static inline bool nqm_conform_is_value(const float rgb[3]) {
    return isfinite(rgb[0]) && isfinite(rgb[1]) && isfinite(rgb[2]);
}
/** Values of a set as a suspect makes them, at every `stride`-th direction. is_rounded: of inputs in float32. */
void nqm_conform_sample(const nqm_conform_kit *kit, size_t set, const nqm_conform_suspect *s, size_t stride,
                        bool is_rounded, float *rgb);
/** Fill the mistakes of a report, and `found` with their suspects, the best first; suspects with equal values are one, and those that
 *  leave nine tenths of the difference are none. None: values differ by no more than float32 does. Where one leaves a difference, two
 *  are tried. */
NQM_MUST_CHECK nqm_status nqm_conform_search(const nqm_conform_kit *kit, const float *values, const nqm_ticker *ticker,
                                             nqm_conform_suspect found[NQM_CONFORM_MISTAKES],
                                             nqm_conform_report *report, nqm_error *err);

/** What nqm_conform_prove() finds. */
typedef struct nqm_conform_proof {
    double lowest_jod;  /**< of the model's own values, of inputs in float32 */
    size_t n_mistakes;  /**< that the model can have */
    size_t n_first;     /**< of them: found from their values, before all others */
    size_t n_three;     /**< found among the first three */
    int passes;         /**< 1: the values pass, 90 % are first, and 98 % among three */
    char missed[10000]; /**< the texts of those that are not first, a line each */
} nqm_conform_proof;
/** Prove the kit: the model's own values pass, and each mistake that the model can have is found from its values. */
NQM_MUST_CHECK nqm_status nqm_conform_prove(const nqm_conform_kit *kit, nqm_progress_fn progress, void *user,
                                            nqm_conform_proof *proof, nqm_error *err);

#endif
