/* SPDX-License-Identifier: MIT
 *
 * conform.h - the kit of `nqm conform`: parameter sets and directions of a shading model, values of somebody's shader, and the
 * mistakes that may explain them.
 */
#ifndef NQM_TOOL_CONFORM_H
#define NQM_TOOL_CONFORM_H

#include "brdf/core/mistakes.h"
#include "brdf/core/spec.h"
#include "nqm/score/batch.h"

/* ---- the kit (kit.c) --------------------------------------------------------------------------------------------- */

enum { KIT_TURNS = 3, KIT_MAX_SETS = 120 };
/** Degrees by which light and viewer of a set are turned about the normal: the model's directions have one azimuth of the half
 *  vector, and anisotropic lobes have three. */
extern const double kit_turns_deg[KIT_TURNS];

/** A parameter set. */
typedef struct kit_set {
    nqm_values values; /* `given` has the keys that differ from their defaults */
    size_t turn;       /* of kit_turns_deg; 0 for isotropic sets */
    char name[32];     /* "set 12" */
    char *spec;        /* opens the same BRDF in the frame of the directions */
} kit_set;

typedef struct conform_kit {
    const nqm_analytic_model *model;
    nqm_model *metric; /* the model that scores, whose directions these are */
    size_t n_directions, n_sets;
    double *directions; /* (KIT_TURNS, 2, n_directions, 3) light and viewer */
    uint64_t keys;      /* bit k: sets have values of key k; else its default */
    kit_set sets[KIT_MAX_SETS];
} conform_kit;

/** Make the kit of a shading model; keys: names with commas of those that the shader has, NULL: all. Free with free_kit(). */
conform_kit *make_kit(const char *model, const char *keys);
void free_kit(conform_kit *kit);
/** A copy with every `stride`-th direction, which borrows the specs of the sets. */
conform_kit *copy_kit(const conform_kit *kit, size_t stride);
void free_kit_copy(conform_kit *copy);
/** The directions of light (side 0) or viewer (1) at a turn, (n_directions, 3). */
static inline double *kit_directions(const conform_kit *kit, size_t turn, size_t side) {
    return kit->directions + 3 * (2 * turn + side) * kit->n_directions;
}

/* ---- files (kit_write.c) ----------------------------------------------------------------------------------------- */

/** One row for each set and direction, in this order: the number of the set, its parameters, light and viewer. */
void write_kit_rows(const conform_kit *kit, FILE *out);
/** Parameter sets and directions as arrays of GLSL, HLSL or C, by the ending of the path, with the loop over them. */
void write_kit_shader(const conform_kit *kit, const char *path);

/* ---- values (values.c): on failure, these report the error and exit ---------------------------------------------- */

/** Values of all sets, (n_sets, n_directions, 3) float; free() it. NaN where there is none. path: a CSV with the
 *  columns r, g, b, or an array of NumPy. */
float *read_results(const conform_kit *kit, const char *path);
/** The same from a command of the shell, which gets the rows of the kit and prints such a CSV. */
float *run_command(const conform_kit *kit, const char *line);

/* ---- mistakes (suspects.c) --------------------------------------------------------------------------------------- */

enum { MAX_SUSPECTS = 400, SUSPECT_TEXT = 400, MAX_FLAWS = 2 };

/** A mistake in a formula, in the use of a parameter, or of channels. */
typedef struct flaw {
    size_t key;    /* of the schema; its n_keys: formulas and values */
    size_t how;    /* index of property_mistakes, or NQM_MISTAKE_..., and beyond them of channels */
    double amount; /* a limit, an exponent or a factor; 0: it has none */
} flaw;

/** What a shader may do wrong. */
typedef struct suspect {
    size_t n_flaws;
    flaw flaws[MAX_FLAWS];
    size_t kind; /* of suspects that differ in their amounts only; 0: no flaw */
    char text[SUSPECT_TEXT];
    double left;   /* mean absolute difference of log(f_r + 0.003) that remains */
    double lowest; /* JOD of the worst set that remains; NaN: not computed */
} suspect;

/** All that the model can have with one flaw, some with several amounts, and first none: `n` of them; free() the array. */
suspect *list_suspects(const conform_kit *kit, size_t *n);
/** Write the text. */
void describe_suspect(const conform_kit *kit, suspect *s);
/** Values of a set as a suspect makes them. */
void sample_suspect(const conform_kit *kit, size_t set, const suspect *s, float *rgb);
/** Values that suspects are to explain. */
typedef struct suspect_targets {
    size_t n;
    const float *values;        /* one target: of all sets */
    const conform_kit *planted; /* instead of them: target i is suspect i with the inputs of this kit */
} suspect_targets;
/** left (targets->n, n) receives what remains of each target by each suspect. */
void compare_suspects(const conform_kit *kit, size_t n, const suspect *suspects, const suspect_targets *targets,
                      double *left);
/** The suspects that explain the values best, first the best; suspects with equal values are one, and those that leave
 *  nine tenths of the difference are none. found (n_found) receives them; their number is returned; `none`: what
 *  remains without a mistake. 0: values differ by no more than float32 does. Where one leaves a difference, two are tried. */
size_t find_suspects(const conform_kit *kit, const float *values, size_t n_found, suspect *found, double *none);

/* ---- facts (facts.c) --------------------------------------------------------------------------------------------- */

/** What is known of the sets that fail (n_sets): {"sets", "angles", "largest"}, each {"text", ..} if there is something to say. */
json_t *list_facts(const conform_kit *kit, const float *values, const bool *fails);

#endif
