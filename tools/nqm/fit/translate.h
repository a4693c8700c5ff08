/* SPDX-License-Identifier: MIT
 *
 * translate.h - parts of nqm translate: the targets, and the keys that two shading models share.
 */
#ifndef NQM_TOOL_TRANSLATE_H
#define NQM_TOOL_TRANSLATE_H

#include "argument/argument.h"
#include "brdf/core/spec.h"
#include "material/material.h"
#include "nqm/tool.h"
#include <nqm/match.h>
#include <nqm/texture.h>

/** What --to names. */
typedef struct translate_target {
    const char *word, *model;
    const char *extension; /* extension of the files that -d writes */
} translate_target;

/** The words that --to may be, after which NULL. */
const char *const *target_names(void);
/** Find a target by its word; if there is none, report the words and exit. */
const translate_target *find_target(const char *word);

/** A spec of the shading model `model` with the keys that mean the same in `spec`, a canonical spec of a shading model,
 *  moved into their ranges; free() it. NULL: `spec` is NULL or of another model, nothing is shared, or what is shared
 *  is no spec without other keys. */
char *copy_keys(const char *spec, const char *model);
/** The key that means the same as one of another model; n_keys: none. */
size_t find_same_key(const nqm_spec_key *key, size_t n_keys, const nqm_spec_key *keys);
/** The values of a property for a key: a number for all channels of a colour, the mean of a colour or of two widths for
 *  a number; moved into its range. */
void convert_values(const nqm_property *p, const nqm_spec_key *key, double v[3]);
/** The keys of such a spec with other values than their defaults that have no counterpart in `model`, separated by ", ". Keys
 *  of layers with weight 0 do not count. */
void list_dropped(const char *spec, const char *model, char *text, size_t n_text);

/** The translation of a textured material to glTF. */
typedef struct texture_translation {
    nqm_argument *source;
    const char *path; /* the file; maps are written beside it as PATH without ending, "_", texture, ".png" */
    const char *name; /* of the material in the file */
    const nqm_match_loss *loss;
    const nqm_fit_options *fit;
    /* results: */
    char dropped[300], spec[2048]; /* spec: of what does not vary */
    nqm_texture_result score;      /* of what was written, by the metric of the loss */
} texture_translation;
/** Whether maps can be written to such a file as this model. */
nqm_status check_texture_target(const char *model, const char *path, nqm_error *err);
/** Translate to a target that check_texture_target() allows. */
nqm_status translate_texture(texture_translation *t, nqm_error *err);

#endif
