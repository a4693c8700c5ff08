/* SPDX-License-Identifier: MIT
 *
 * nqm/conform.h - does a shader implement its specification, and which mistake does it make? In libnqm-full only. Any thread.
 * NQM_EXPERIMENTAL.
 */
#ifndef NQM_CONFORM_H
#define NQM_CONFORM_H

#include <nqm/metric.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A kit: parameter sets of a shading model, and pairs of directions. Immutable; any thread. */
typedef struct nqm_conform_kit nqm_conform_kit;

/** Facts about a kit and one of its parameter sets; all belongs to the kit. */
typedef struct nqm_conform_info {
    const char *model; /**< "gltf" */
    size_t n_sets, n_directions;
    size_t n_columns; /**< values of a set */
    const char *
        columns; /**< their names, "base_color_r,base_color_g,...": _r, _g, _b of colours; _x, _y along tangent and bitangent */
    const char *spec;     /**< opens the BRDF of the set at the directions of the metric; NULL: there are fewer sets */
    const double *values; /**< (n_columns) */
    const double *light, *viewer; /**< (n_directions, 3) in the tangent frame: z is the normal, x the tangent */
} nqm_conform_info;

enum { NQM_CONFORM_MISTAKES = 3, NQM_CONFORM_TEXT = 400 };

/** A mistake that may explain values. */
typedef struct nqm_conform_mistake {
    char text[NQM_CONFORM_TEXT]; /**< "roughness is squared twice"; mistakes with equal values after "; or " */
    double lowest_jod;           /**< of the sets, if the reference has the mistake, too */
    double remaining;            /**< fraction of the difference that remains then */
} nqm_conform_mistake;

/** The value whose logarithm is farthest from the right one. */
typedef struct nqm_conform_largest {
    size_t set, direction, channel;
    double value, right;
    double angles_rad[4]; /**< theta_h, theta_d, and those of light and viewer with the normal */
} nqm_conform_largest;

/** What nqm_conform_compare() finds. */
typedef struct nqm_conform_report {
    size_t n_passed;   /**< sets with a JOD of NQM_CONFORM_PASS or more */
    double lowest_jod; /**< of all sets */
    double difference; /**< mean absolute difference of log(f_r + 0.003); 0: all sets pass, and the rest is rounding */
    size_t n_mistakes;
    nqm_conform_mistake mistakes[NQM_CONFORM_MISTAKES]; /**< the likeliest first */
    int is_named; /**< 1: the first mistake explains the difference; 0: it is only the nearest */
    /* Facts about the sets that fail, in words; "": there is none. */
    char sets[NQM_CONFORM_TEXT];   /**< which parameters they have in common */
    char angles[NQM_CONFORM_TEXT]; /**< at which angles most of the difference is */
    char most[NQM_CONFORM_TEXT];   /**< the largest difference; `largest` has its numbers */
    nqm_conform_largest largest;
} nqm_conform_report;

/** JOD from which on a set passes. */
#define NQM_CONFORM_PASS 9.99

/**
 * Make a kit: sweeps of each parameter, metals, and random combinations.
 *
 * @param model   "gltf", "open-pbr", ...: a shading model (nqm_translate_target()), or its other name
 * @param keys    parameters that the shader has, separated by commas; the others keep their defaults; NULL: all
 * @param metric  scores the sets, at its directions; must outlive the kit
 * @return NQM_ERR_ARG: there is no such model or parameter; NQM_ERR_NOMEM
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_conform_kit_create(const char *model, const char *keys, const nqm_model *metric,
                                                         nqm_conform_kit **kit_ret, nqm_error *err);
NQM_API void nqm_conform_kit_free(nqm_conform_kit *kit);
/** set: counted from 0. */
NQM_API nqm_conform_info nqm_conform_kit_get_info(const nqm_conform_kit *kit, size_t set);

/**
 * Score the values of a shader, and look for its mistake.
 *
 * @param values    (n_sets, n_directions, 3) f_r in 1/sr of linear red, green and blue, without the cosine. Directions with a channel
 *                  that is not finite are left out; negative values count as 0
 * @param progress  NULL: none
 * @param results   (n_sets) receives scores without scalar metrics; n_invalid and n_clamped of the test are counted
 * @return NQM_ERR_NOMEM, NQM_ERR_CANCELLED
 */
NQM_API NQM_MUST_CHECK nqm_status nqm_conform_compare(const nqm_conform_kit *kit, const float *values,
                                                      nqm_progress_fn progress, void *user, nqm_score_result *results,
                                                      nqm_conform_report *report, nqm_error *err);

#ifdef __cplusplus
}
#endif
#endif
