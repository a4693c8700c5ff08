/* SPDX-License-Identifier: MIT
 *
 * schema.h - what the keys of models are and mean: number of values, range, default, role and unit; the values of a model; and
 * their text, the spec `MODEL:key=value;key=red,green,blue`. Nothing here knows a formula.
 */
#ifndef NQM_SRC_SCHEMA_H
#define NQM_SRC_SCHEMA_H

#include "base/base.h"

/** What a key of a shading model means. Keys of one role mean the same in all models, up to their unit. The roles of a layer follow
 *  its weight. */
typedef enum nqm_role {
    NQM_ROLE_NONE, /**< has no counterpart in other models: switches, corrections */
    NQM_ROLE_BASE_WEIGHT,
    NQM_ROLE_BASE_COLOR,
    NQM_ROLE_DIFFUSE_ROUGHNESS,
    NQM_ROLE_METAL,
    NQM_ROLE_WIDTH,      /**< of the specular lobe of the base */
    NQM_ROLE_ANISOTROPY, /**< 0: isotropic */
    NQM_ROLE_AZIMUTH,    /**< of the wider axis of that lobe, from the tangent */
    NQM_ROLE_IOR,        /**< index of refraction of the dielectric base */
    NQM_ROLE_SPECULAR_WEIGHT,
    NQM_ROLE_SPECULAR_COLOR,
    NQM_ROLE_SPECULAR_TINT,  /**< how much of the base colour the specular reflection has */
    NQM_ROLE_SPECULAR_LEVEL, /**< reflectance at the normal, which the index sets, too */
    NQM_ROLE_METAL_ETA,      /**< complex index of refraction of a metal */
    NQM_ROLE_METAL_K,
    NQM_ROLE_COAT_WEIGHT,
    NQM_ROLE_COAT_COLOR,
    NQM_ROLE_COAT_WIDTH,
    NQM_ROLE_COAT_ANISOTROPY,
    NQM_ROLE_COAT_AZIMUTH,
    NQM_ROLE_COAT_IOR,
    NQM_ROLE_COAT_EFFECT, /**< on what is below it */
    NQM_ROLE_SHEEN_WEIGHT,
    NQM_ROLE_SHEEN_COLOR,
    NQM_ROLE_SHEEN_WIDTH,
    NQM_ROLE_SHEEN_TINT,
    NQM_ROLE_FILM_WEIGHT,
    NQM_ROLE_FILM_THICKNESS,
    NQM_ROLE_FILM_IOR
} nqm_role;

/** The unit of a value. alpha: the width parameter of microfacet distributions. */
typedef enum nqm_unit {
    NQM_UNIT_PLAIN,         /**< of widths: the roughness, whose square is alpha */
    NQM_UNIT_ALPHA,         /**< alpha itself */
    NQM_UNIT_ALPHA_SQUARED, /**< pbrt's roughness */
    NQM_UNIT_GLOSS,         /**< 1 - roughness */
    NQM_UNIT_RATIO, /**< of anisotropies a: the widths have the ratio 1 - a, and their product is that of equal widths */
    NQM_UNIT_RATIO_90,   /**< 1 - 0.9 a */
    NQM_UNIT_RATIO_MEAN, /**< 1 - a; the mean of the squares of the widths is that of equal widths: OpenPBR */
    NQM_UNIT_STRENGTH,   /**< one width grows with a^2 to 1: glTF */
    NQM_UNIT_RADIANS,
    NQM_UNIT_TURNS,
    NQM_UNIT_TURNS_CLOCKWISE,
    NQM_UNIT_NANOMETRES,
    NQM_UNIT_MICROMETRES
} nqm_unit;

/** One key of a model. */
typedef struct nqm_schema_key {
    const char *name;
    size_t n;         /**< values: 1, 2 along tangent and bitangent, or 3 for RGB; a single value means all */
    double low, high; /**< closed range of each value */
    bool required;
    bool whole;      /**< integers only */
    bool is_below;   /**< transmission takes the place of what this weighs */
    double fallback; /**< default of an optional key */
    nqm_role role;
    nqm_unit unit;
} nqm_schema_key;

enum { NQM_SCHEMA_MAX_KEYS = 24 };

/** The keys of one model, in the order of the canonical form. */
typedef struct nqm_schema {
    const char *model; /**< the word before the colon */
    size_t n_keys;
    nqm_schema_key keys[NQM_SCHEMA_MAX_KEYS];
    const char *alias; /**< another name on the command line; NULL: none */
    const char *about; /**< of shading models: "glTF 2.0 with ..." */
} nqm_schema;

/** The values of a model; those of a key with n < 3 repeat the last one. */
typedef struct nqm_values {
    const nqm_schema *schema;
    double v[NQM_SCHEMA_MAX_KEYS][3]; /**< (key, channel) */
    uint64_t given;                   /**< bit k: key k was in the text or file */
} nqm_values;

/* ---- schemas ------------------------------------------------------------------------------------------------------ */

/** The schema of a model of material files: a shading model or "lambert"; NULL: there is none of the first n characters of `name`. */
const nqm_schema *nqm_schema_find(const char *name, size_t n);
/** Shading model i of those to which others are fitted; NULL: there are fewer. */
const nqm_schema *nqm_schema_shading(size_t i);
/** The one of a name or its other name. NQM_ERR_ARG: there is none; the message has all names. */
NQM_MUST_CHECK nqm_status nqm_schema_find_shading(const char *name, const nqm_schema **schema_ret, nqm_error *err);
/** The key of a name, of its first n characters; n_keys: there is none. */
size_t nqm_schema_key_named(const nqm_schema *schema, const char *name, size_t n);
/** The first key of a role; n_keys: there is none. */
size_t nqm_schema_key_of(const nqm_schema *schema, nqm_role role);
/** Whether a key is the amount of a coat or of sheen: 0 means that there is no such layer. */
bool nqm_schema_is_layer(const nqm_schema *schema, size_t key);
/** The key of the amount of the coat or sheen that a key describes; the key itself: it belongs to no layer. */
size_t nqm_schema_layer_of(const nqm_schema *schema, size_t key);
/** Whether a key is the width of a lobe, in any unit; whether it is an anisotropy or azimuth, which is 0 in isotropic models. */
bool nqm_schema_is_width(nqm_role role);
bool nqm_schema_is_anisotropic(nqm_role role);
bool nqm_schema_is_azimuth(nqm_role role);
bool nqm_schema_is_film(nqm_role role);

/* ---- values ------------------------------------------------------------------------------------------------------- */

/** A value in another unit of the same role: widths, angles and lengths. Bits stay where the units are equal. */
double nqm_schema_convert(double v, nqm_unit from, nqm_unit to);

/** The defaults of a model; none is given, and required keys are 0. */
nqm_values nqm_values_of(const nqm_schema *schema);
/** Give a key n = 1 or all of its values; the last is repeated. A name that the model lacks is ignored: readers set keys of tables
 *  only. */
void nqm_values_set(nqm_values *values, const char *key, size_t n, const double *v);
/** The values (3) of a key; NULL: it is not given. */
const double *nqm_values_given(const nqm_values *values, const char *key);
/** Whether f_r of a model with these values does not depend on the azimuth. */
bool nqm_values_are_isotropic(const nqm_values *values);

/* ---- text --------------------------------------------------------------------------------------------------------- */

/** Parse `key=value;...` (what follows the colon). NQM_ERR_ARG names the key at fault and its range. */
NQM_MUST_CHECK nqm_status nqm_values_parse(const nqm_schema *schema, const char *text, nqm_values *values,
                                           nqm_error *err);
/** The same of a whole spec. NQM_ERR_ARG also of a model that nqm_schema_find() lacks. */
NQM_MUST_CHECK nqm_status nqm_values_parse_spec(const char *spec, nqm_values *values, nqm_error *err);
/** Whether the given values are in their ranges and all required ones are given: NQM_OK, or the error of their text. */
NQM_MUST_CHECK nqm_status nqm_values_check(const nqm_values *values, nqm_error *err);
/** The canonical text, "MODEL:key=value;...", of the given keys; parses back to the same bits. nqm_free(); NULL when
 * out of memory. */
char *nqm_values_spec(const nqm_values *values);

/* ---- published values ---------------------------------------------------------------------------------------------- */

/** A table of presets/, embedded by cmake/presets.cmake. */
typedef struct nqm_preset_table {
    const char *name;  /**< file name without ending: "sgd", "low-cook-torrance-e1"; NULL ends the array */
    const char *model; /**< the model of the rows; their parameters are in the order of its schema */
    const char *doi;   /**< DOI of the publication of the parameters */
    const char *text;  /**< the CSV: '#' lines, a header, rows of a name and values; no quoting */
} nqm_preset_table;

extern const nqm_preset_table nqm_preset_tables[];

/** Every row as "TABLE:NAME", in the order of the tables. */
extern const char *const nqm_preset_names[];
extern const size_t nqm_preset_name_count;

/** "sgd:nickel" for "nickel": a preset of this material, of the table sgd if it is there; NULL: none. */
const char *nqm_preset_named(const char *material);
/** "ward:nickel" for "ward-nickel", "ward_nickel", "ward.nickel" or "ward nickel"; NULL: the text is no such preset. */
const char *nqm_preset_without_colon(const char *text);
/** Offer the materials of all presets, without their tables. */
void nqm_preset_nearest(nqm_nearest *nearest);
/** A table of presets, or NULL. */
const nqm_preset_table *nqm_preset_table_find(const char *name, size_t n_name);
/** Values of a published material in a table of `schema`'s model; NQM_ERR_ARG suggests similar names. */
NQM_MUST_CHECK nqm_status nqm_preset_find(const nqm_preset_table *table, const nqm_schema *schema, const char *material,
                                          nqm_values *values, nqm_error *err);

#endif
