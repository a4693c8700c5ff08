/* SPDX-License-Identifier: MIT
 *
 * rules.h - how the properties of a material in a file become the values of a schema. Each shading model of each file
 * format has a list with one rule for each property that a file may give; any other property refuses the material. What
 * differs between the formats is how a property is found and its numbers are read: nqm_rule_source.
 */
#ifndef NQM_SRC_MATERIAL_RULES_H
#define NQM_SRC_MATERIAL_RULES_H

#include "material/maps.h"

typedef struct nqm_rule nqm_rule;
typedef struct nqm_reading nqm_reading;

/** Read one property; its type is that of the format. false: the material is refused. */
typedef bool nqm_rule_read(nqm_reading *r, const nqm_rule *rule, const void *property);

struct nqm_rule {
    const char *name;    /**< in the file, one or more, separated by blanks; NULL ends a list */
    nqm_rule_read *read; /**< NULL: the properties have no effect on a BRDF */
    const char *key;     /**< of the shading, if the rule sets one */
    size_t n;            /**< values: 1, 3 for a colour, 4 for a colour with alpha */
    double value; /**< of every channel of a missing property; of nqm_rule_neutral(), the only one that is accepted */
    const char *why;  /**< nqm_rule_neutral(): why other values are refused */
    const char *gate; /**< the property has no effect where those of these names are 0; NULL: it always has */
    const char *type; /**< of the values in the file, in formats that name it */
    unsigned
        ignorable;  /**< nqm_rule_neutral(): NQM_IGNORE_... of other values, which refuse it unless that is ignored */
    bool is_weight; /**< of transmission or subsurface scattering, in the place of the diffuse reflection */
};

/** Set the key of the model. */
nqm_rule_read nqm_rule_set;
/** Refuse values other than that of the rule. */
nqm_rule_read nqm_rule_neutral;
/** Code for the whole material reads the properties, because others change their meaning. */
nqm_rule_read nqm_rule_later;

/** Rules that several formats have. */
#define NQM_RULE_IGNORED(NAMES)                                                                                        \
    { .name = (NAMES) }
#define NQM_RULE_LATER(NAMES)                                                                                          \
    { .name = (NAMES), .read = nqm_rule_later }
#define NQM_RULE_WEIGHT(NAME, WHY, IGNORABLE)                                                                          \
    { .name = (NAME), .read = nqm_rule_neutral, .n = 1, .why = (WHY), .ignorable = (IGNORABLE), .is_weight = true }
#define NQM_RULE_ASIDE(NAME, WHY, IGNORABLE)                                                                           \
    { .name = (NAME), .read = nqm_rule_neutral, .n = 1, .why = (WHY), .ignorable = (IGNORABLE) }

/** What a file format implements. */
typedef struct nqm_rule_source {
    const char *term; /**< what the format calls a property, for messages */
    bool shows_owner; /**< as part of names: "KHR_materials_ior.ior" */
    /** The property of the material, or NULL. */
    const void *(*find)(nqm_reading *r, const char *name);
    /** The numbers of a property: *n is rule->n, or 1 if the format allows a number for a colour. false: refused. */
    bool (*read)(nqm_reading *r, const nqm_rule *rule, const void *property, double v[4], size_t *n);
    /** The node of a property, or NQM_NO_NODE; NULL: its properties are constant. */
    uint16_t (*node)(nqm_reading *r, const nqm_rule *rule, const void *property);
    /** The position of a property in the file. */
    int64_t (*byte_of)(const nqm_reading *r, const void *property);
} nqm_rule_source;

/** Why a material is refused, or has no BRDF; "": it is not. */
typedef struct nqm_reason {
    char text[400];
    int64_t byte_offset; /**< of the property */
} nqm_reason;

/** A material that is being read: its shading or file, or why it is refused. Formats begin a struct of their own with it. */
struct nqm_reading {
    const nqm_rule_source *source;
    const nqm_rule *rules;
    const char *owner;            /**< what has the properties, for messages */
    nqm_values values;            /**< schema NULL: of a measured file */
    const char *file;             /**< of a measured material; NULL: the shading is the result */
    char unused[NQM_REMARK_SIZE]; /**< nqm_material_info.unused */
    nqm_textured
        *textured; /**< what is computed; the material varies over the surface if that has outputs or a normal */
    nqm_reason refusal, varies;
    unsigned ignorable;        /**< NQM_IGNORE_... of properties that refuse the material unless they are ignored */
    nqm_reason aside;          /**< the first of these */
    uint16_t weights[2];       /**< nodes of the weights of transmission and subsurface scattering; NQM_NO_NODE: none */
    uint16_t subsurface_color; /**< albedo of the subsurface scattering; NQM_NO_NODE: that of the base */
    char *metal; /**< spec of the part that is a metal, beside what `shading` then is; NULL: there is no such part */
    double metal_share;
    char *mixture; /**< spec of a mixture of materials, in the place of the shading; NULL: it is none */
};

/** Begin to read a material; false: memory is short, and nqm_reading_add() will fail. */
NQM_MUST_CHECK bool nqm_reading_begin(nqm_reading *r, const nqm_rule_source *source);
/** Refuse the material, unless it is refused already; false, so that readers can return it. */
__attribute__((format(printf, 3, 4))) bool nqm_refuse(nqm_reading *r, const void *property, const char *format, ...);
/** Say, if it is the first one, which property varies over the surface, so that the material has no BRDF; true. */
__attribute__((format(printf, 3, 4))) bool nqm_vary(nqm_reading *r, const void *property, const char *format, ...);
/** Say which property refuses the material unless `ignorable` is ignored; true. */
__attribute__((format(printf, 4, 5))) bool nqm_set_aside(nqm_reading *r, unsigned ignorable, const void *property,
                                                         const char *format, ...);
/** Let the diffuse reflection of the shading and its maps be what transmission and subsurface scattering leave of it (ignore.c). */
void nqm_reading_reflect(nqm_reading *r);
/** Name a property that has no effect; true. */
bool nqm_reading_unused(nqm_reading *r, const char *name);
/** Apply the rule for a property; is_repeated: there is one of this name before it. false: the material is refused. */
bool nqm_rules_apply(nqm_reading *r, const char *name, const void *property, bool is_repeated);
/** The rule for a name, or NULL. */
const nqm_rule *nqm_rule_find(const nqm_rule *rules, const char *name);
/** Let the material be the mixture (1 - t) of + t with; each is a constant material, or what of it reflects. t: 0 to 1. false: refused. */
bool nqm_reading_mix(nqm_reading *r, const void *property, nqm_material_info of, nqm_material_info with, double t);
/** Append what has been read: the shading, with the maps, the file or the refusal. byte_offset: of a material that is
 *  accepted. Takes the maps; a reading that is given up frees them by nqm_textured_free(). */
NQM_MUST_CHECK nqm_status nqm_reading_add(nqm_reading *r, const char *name, const char *surface, int64_t byte_offset,
                                          nqm_materials *materials, nqm_error *err);

#endif
