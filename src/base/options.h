/* SPDX-License-Identifier: MIT
 *
 * options.h - tables that describe the fields of an options struct: name, help, unit, range, words, default of each recipe. One
 * table drives the defaults, the range checks, the command line, --help, JSON and checkpoints, so that a new option is a
 * field, a row and the code that uses it.
 */
#ifndef NQM_SRC_BASE_OPTIONS_H
#define NQM_SRC_BASE_OPTIONS_H

#include "base/base.h"

/** The type of the field that a row describes. */
typedef enum nqm_option_kind {
    NQM_OPTION_DOUBLE,
    NQM_OPTION_SIZE,  /* size_t */
    NQM_OPTION_U64,   /* uint64_t */
    NQM_OPTION_BOOL,  /* int, 0 or 1 */
    NQM_OPTION_ENUM,  /* an enum, counted from 0 */
    NQM_OPTION_TEXT,  /* const char *, borrowed */
    NQM_OPTION_SIZES, /* size_t n, followed by size_t values[max_sizes] */
} nqm_option_kind;

/** Whether an option is part of the stored options (JSON). */
typedef enum nqm_option_storage {
    NQM_STORED = 0,
    NQM_STORED_UNLESS_ZERO, /* for options that came later: files without the key have 0 */
    NQM_NOT_STORED
} nqm_option_storage;

enum { NQM_OPTION_RECIPES = 4, NQM_OPTION_TEXT_MAX = 200 };

/** One option. Zeroed members need not be named. */
typedef struct nqm_option {
    const char *key;      /* in JSON and checkpoints: "plateau_factor" */
    const char *name;     /* on the command line, without "--"; NULL: the key with '-' for '_'; "": not there */
    const char *off_name; /* name that sets a bool to 0; NULL: "no-" and the name; "": none */
    const char *metavar;  /* "N" in "--batch N"; NULL for a bool without words */
    const char *help;     /* one line, without unit, range and default */
    const char *unit;     /* "1/sr"; NULL: none */
    nqm_option_kind kind;
    nqm_option_storage storage;
    size_t offset;   /* of the field in the struct, bytes */
    double min, max; /* of numbers, both included; both 0: any finite value */
    double
        scale; /* of a double: field = scale * value (pi / 180 for degrees); 0: 1. Range, defaults and text are values */
    const char *const *words; /* by value, NULL-terminated. Of a bool: it takes one of two words on the command line */
    size_t max_sizes;         /* of a list */
    const char
        *values[NQM_OPTION_RECIPES]; /* default of each recipe, as text; NULL: that of the first; all NULL: zeros */
} nqm_option;

/** The options of a struct. */
typedef struct nqm_option_table {
    const nqm_option *rows; /* (n) */
    size_t n;
    const char *const
        *recipes; /* names, NULL-terminated, in the order of nqm_option.values; NULL: one set of defaults */
} nqm_option_table;

/** Fill the fields that the table describes with the defaults of a recipe (NULL: the first). Other fields are untouched.
 *  NQM_ERR_ARG: no such recipe. */
NQM_MUST_CHECK nqm_status nqm_options_begin(const nqm_option_table *table, const char *recipe, void *options,
                                            nqm_error *err);
/** NQM_ERR_ARG names the first option that is outside its range, its value and the range. */
NQM_MUST_CHECK nqm_status nqm_options_check(const nqm_option_table *table, const void *options, nqm_error *err);
/** The row with that key; NULL: none. */
const nqm_option *nqm_option_by_key(const nqm_option_table *table, const char *key);
/** The row with that name on the command line (n_name bytes, without "--"); NULL: none. *is_off_ret: the name was the one that
 *  sets a bool to 0. */
const nqm_option *nqm_option_by_name(const nqm_option_table *table, const char *name, size_t n_name, bool *is_off_ret);
/** Whether the option is given without a value on the command line. */
bool nqm_option_is_flag(const nqm_option *option);
/** Name on the command line; returns `text` (NQM_OPTION_TEXT_MAX bytes), as do the next two. "" when there is none. */
char *nqm_option_name(const nqm_option *option, char *text);
/** What may be given: "a whole number from 1 to 65536", "jod or log_delta_e". */
char *nqm_option_allowed(const nqm_option *option, char *text);
/** The value of an option: "0.1", "jod", "1024,716,501"; "" for a text that is NULL. */
char *nqm_option_format(const nqm_option *option, const void *options, char *text);
/** Set one option from text, in the form of nqm_option_format(). A word may be cut at an underscore where that leaves one
 *  choice: "pair" for "pair_reflectance". A TEXT option keeps the pointer. NQM_ERR_ARG: "batch needs a whole number from 1 to
 *  65536, not '0'". */
NQM_MUST_CHECK nqm_status nqm_option_set(const nqm_option *option, void *options, const char *text, nqm_error *err);

#endif
