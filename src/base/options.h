/* SPDX-License-Identifier: MIT
 *
 * options.h - tables that describe the fields of an options struct: name, help, unit, range, words, default of each
 * recipe. One table drives the defaults, the range checks, the command line, --help, JSON and checkpoints. A new option
 * needs a field, a table row and the code that uses it.
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
    NQM_OPTION_TEXT,  /* const char *, owned by the caller */
    NQM_OPTION_SIZES, /* size_t n, followed by size_t values[max_sizes] */
} nqm_option_kind;

/** Whether an option is written to stored options (JSON). */
typedef enum nqm_option_storage {
    NQM_STORED = 0,
    NQM_STORED_UNLESS_ZERO, /* an option added later: 0 is not written, and a missing key means 0 */
    NQM_NOT_STORED
} nqm_option_storage;

enum { NQM_OPTION_RECIPES = 4, NQM_OPTION_TEXT_MAX = 200 };

/** One option. Members that are 0 or NULL may be left out of the initialiser. */
typedef struct nqm_option {
    const char *key;  /* key in JSON and checkpoints: "plateau_factor" */
    const char *name; /* on the command line, without "--"; NULL: the key with '-' for '_'; "": not available there */
    const char *off_name; /* name that sets a bool to 0; NULL: "no-" and the name; "": none */
    const char *metavar;  /* "N" in "--batch N"; NULL for a bool without words */
    const char *help;     /* one line, without unit, range and default */
    const char *unit;     /* "1/sr"; NULL: none */
    nqm_option_kind kind;
    nqm_option_storage storage;
    size_t offset;   /* position of the field in the struct, bytes */
    double min, max; /* range of a number, inclusive; both 0: any finite value */
    double scale; /* double: field = scale * value (pi / 180 for degrees); 0: 1. Range, default and text are values */
    const char *const
        *words;       /* indexed by value, NULL-terminated; "": not a value of this option. A bool with words takes
                                 one of two words */
    size_t max_sizes; /* maximum length of a list */
    const char
        *values[NQM_OPTION_RECIPES]; /* default of each recipe, as text; NULL: that of the first recipe; all NULL: 0 */
} nqm_option;

/** The options of a struct. */
typedef struct nqm_option_table {
    const nqm_option *rows; /* (n) */
    size_t n;
    const char *const
        *recipes; /* NULL-terminated names, in the order of nqm_option.values; NULL: a single set of defaults */
} nqm_option_table;

/** Set the fields that the table describes to the defaults of a recipe (NULL: the first). Other fields are unchanged.
 *  NQM_ERR_ARG: the recipe does not exist. */
NQM_MUST_CHECK nqm_status nqm_options_begin(const nqm_option_table *table, const char *recipe, void *options,
                                            nqm_error *err);
/** Define NAME##s_default(), which returns NAME##s with the defaults of NAME##_table; the variadic arguments initialise
 *  the fields that the table does not describe. */
#define NQM_OPTIONS_DEFAULT(NAME, ...)                                                                                 \
    NAME##s NAME##s_default(void) {                                                                                    \
        NAME##s options = {__VA_ARGS__};                                                                               \
        (void)!nqm_options_begin(&NAME##_table, NULL, &options, NULL); /* cannot fail without a recipe */              \
        return options;                                                                                                \
    }
/** Check all ranges. NQM_ERR_ARG: the message gives the first option outside its range, its value and the range. */
NQM_MUST_CHECK nqm_status nqm_options_check(const nqm_option_table *table, const void *options, nqm_error *err);
/** The row with this key; NULL when there is none. */
const nqm_option *nqm_option_by_key(const nqm_option_table *table, const char *key);
/** The row with this name on the command line (n_name bytes, without "--"); NULL when there is none. *is_off_ret: the
 *  name is the one that sets the bool to 0. */
const nqm_option *nqm_option_by_name(const nqm_option_table *table, const char *name, size_t n_name, bool *is_off_ret);
/** Whether the option takes no value on the command line. */
bool nqm_option_is_flag(const nqm_option *option);
/** Store the name on the command line in `text` (NQM_OPTION_TEXT_MAX bytes), "" when there is none, and return `text`;
 *  so do the next two functions. */
char *nqm_option_name(const nqm_option *option, char *text);
/** The allowed values: "a whole number from 1 to 65536", "jod or log_delta_e". */
char *nqm_option_allowed(const nqm_option *option, char *text);
/** The current value: "0.1", "jod", "1024,716,501"; "" for a TEXT option that is NULL. */
char *nqm_option_format(const nqm_option *option, const void *options, char *text);
/** Set one option from text in the format of nqm_option_format(). A word may be abbreviated at an underscore if that is
 *  unambiguous: "pair" for "pair_reflectance". A TEXT option keeps the pointer. NQM_ERR_ARG: "batch needs a whole
 *  number from 1 to 65536, not '0'". */
NQM_MUST_CHECK nqm_status nqm_option_set(const nqm_option *option, void *options, const char *text, nqm_error *err);

#endif
