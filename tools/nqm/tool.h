/* SPDX-License-Identifier: MIT
 *
 * tool.h - shared by the verbs of the command line: option tables for parsing and help, exit codes, errors and progress on
 * standard error, Ctrl-C, JSON and CSV on standard output, output files.
 */
#ifndef NQM_TOOL_H
#define NQM_TOOL_H

#include "base/base.h"
#include "base/options.h"

#include <jansson.h>
#include <nqm/nqm.h>
#include <stdbool.h>
#include <stdio.h>

/** Exit codes: a stable contract (README). */
enum {
    EXIT_OK = 0,
    EXIT_GATE = 1,         /* --fail-under not reached, a check failed */
    EXIT_USAGE = 2,        /* bad option, spec or argument */
    EXIT_OPEN = 3,         /* cannot open, read or write */
    EXIT_MALFORMED = 4,    /* malformed input */
    EXIT_INCOMPATIBLE = 5, /* inputs do not fit together, too few valid samples */
    EXIT_MODEL = 6,        /* model missing or damaged */
    EXIT_LIMIT = 7,        /* memory or size limit */
    EXIT_NUMERIC = 8,      /* numeric failure */
    EXIT_PARTIAL = 9,      /* some items of a batch failed */
    EXIT_INTERRUPTED = 130
};

/* ---- options ----------------------------------------------------------------------------------------------------- */

typedef enum option_kind {
    OPTION_FLAG,   /* target: bool */
    OPTION_TEXT,   /* target: const char * */
    OPTION_NUMBER, /* target: double, within [min, max] */
    OPTION_COUNT   /* target: uint64_t, within [min, max] */
} option_kind;

typedef struct option {
    const char *name; /* without "--"; NULL ends the table */
    char letter;      /* short form, 0 for none */
    option_kind kind;
    void *target; /* holds the default when parsing begins; help prints it */
    const char *metavar;
    const char *help;
    double min, max; /* for numbers; both 0: any finite value */
} option;

/* Rows that several verbs share. */
#define OPTION_ROW_INVALID(target)                                                                                     \
    { "invalid", 0, OPTION_TEXT, (target), "POLICY", "where a BRDF has no value: drop, zero, nearest, error", 0, 0 }
#define OPTION_ROW_MIN_VALID(target)                                                                                   \
    {                                                                                                                  \
        "min-valid", 0, OPTION_NUMBER, (target), "F", "refuse pairs with fewer valid directions than this fraction",   \
            0, 1                                                                                                       \
    }
#define OPTION_ROW_PRECISION(target)                                                                                   \
    { "precision", 0, OPTION_TEXT, (target), "WORD", "of the network's products: f32, bf16 or int8", 0, 0 }

typedef struct command {
    const char *name;
    const char *usage;   /* behind the name: "REF TEST... [options]" */
    const char *about;   /* a paragraph; ends without newline */
    const char *example; /* full command lines, one a line */
    const option *options;
    const nqm_option_table *table; /* further options, set in the struct `table_target`; NULL: none */
    void *table_target;
    int min_arguments, max_arguments; /* positional; max < 0: any number */
} command;

/**
 * Parse argv (argv[0] is the verb). Positional arguments are moved to argv[0..n). Prints help or a usage error itself.
 * Returns true to go on with *n_arguments; false: return *exit_code.
 */
bool parse_arguments(const command *cmd, int argc, char **argv, int *n_arguments, int *exit_code);

/* ---- inputs ------------------------------------------------------------------------------------------------------ */

/** A file argument as a path: "-" is standard input. */
const char *input_path(const char *argument);
/** Open a model by the name of a built-in one or as a file; NULL is "default". EXIT_OK, or the fault is reported and
 *  its exit code returned. */
int open_model(const char *verb, const char *name_or_path, nqm_model **model_ret);
/** Open n BRDFs (0 is allowed); close_brdfs() them. On failure none is open. As open_model(). */
int open_brdfs(const char *verb, int n, char **arguments, nqm_brdf ***brdfs_ret);
void close_brdfs(int n, nqm_brdf **brdfs);
/** A text file of at most 1 MiB; free() it. As open_model(). */
int read_text(const char *verb, const char *path, char **text_ret);
/** Open directions from a CSV, from a model file or from a built-in model's name; NULL: those of the built-in model
 *  "default", or freshly made default ones when no model is built in. As open_model(). */
int open_directions(const char *verb, const char *name_or_path, nqm_directions **directions_ret);

/** Open a dataset: nqm's own file, or the folder of the authors' layout with its labels CSV (`labels`, else NULL),
 *  whose rows all get `split`. As open_model(). */
int open_dataset(const char *verb, const char *path, const char *labels, nqm_split split, nqm_dataset **dataset_ret);

/** Fit the JOD curve to a CSV with the columns DeltaE and JOD (any order, any case; others are ignored). As open_model(). */
int regress_csv(const char *verb, const char *path, nqm_regress_report *report_ret);

/** A word of an option and the value that it stands for; a NULL name ends the list. */
typedef struct choice {
    const char *name;
    int value;
} choice;
/** The value of `word`, or a usage error that lists the choices. EXIT_OK or EXIT_USAGE. */
int choose(const char *verb, const char *option_name, const choice *choices, const char *word, int *value_ret);
/** The name of a value. */
const char *choice_name(const choice *choices, int value);

/** The form of results: a verb's --json, --csv and --quiet, or none of them. */
typedef enum result_format { FORMAT_TEXT, FORMAT_JSON, FORMAT_CSV, FORMAT_QUIET } result_format;
/** EXIT_OK, or a usage error when there is more than one. */
int choose_result_format(const char *verb, bool json, bool csv, bool quiet, result_format *format_ret);

/* ---- several processes ------------------------------------------------------------------------------------------- */

/** This process among those that one launcher (mpirun, srun) started; 0 of 1 when started alone. */
typedef struct ranks {
    size_t rank, count;
} ranks;
ranks my_ranks(void);

/* ---- talking ----------------------------------------------------------------------------------------------------- */

/** "nqm VERB: message" on standard error, and the exit code for the status. */
int report_error(const char *verb, const nqm_error *err);
/** The same for a fault found by the tool itself. */
__attribute__((format(printf, 3, 4))) int report(const char *verb, int exit_code, const char *format, ...);
int exit_code_of(nqm_status status);

/** A progress callback: one line rewritten on standard error when that is a terminal; nonzero once Ctrl-C was
 *  pressed. */
int show_progress(void *user, const char *stage, double done, double total);
/** A few words that the progress line shows from now on. */
__attribute__((format(printf, 1, 2))) void note_progress(const char *format, ...);
/** End the progress line, if there is one. */
void end_progress(void);
/** Install the Ctrl-C handler (main does). */
void catch_interrupt(void);
/** true once Ctrl-C was pressed. */
bool interrupted(void);

/** Print a JSON value with a final newline and release it. NaN must have been stored through json_number(). */
int print_json(json_t *value);
/** A JSON string of a file's name or a message. Where it is not UTF-8, bytes that are not ASCII become '?'. */
json_t *json_name(const char *text);
/** A JSON real, or null when not finite. */
json_t *json_number(double value);
/** {"name":"nqm","version":"..."} for the "tool" member. */
json_t *json_tool(void);
/** The libraries of this build that draw, trace rays and read pictures, with their versions or "off"; nothing is loaded to
 *  say so. Static storage. */
const char *tool_build_info(void);
/** What a JOD below 10 means, in words; doc/cli.md has the table. */
const char *jod_words(double jod);
/** Two lines on the intervals of a model, as made now and as its file has them; JSON of the same, null when there are
 *  none. */
void print_calibration(const nqm_calibration *calibration);
void print_stored_calibration(const nqm_model_info *info);
json_t *calibration_json(const nqm_calibration *calibration);
json_t *stored_calibration_json(const nqm_model_info *info);
enum { INTERVAL_TEXT = 32, INTERVAL_WIDTH = 14 };
/** "[3.62, 4.47]", at most INTERVAL_WIDTH characters, for a result that has an interval. */
const char *interval_text(const nqm_score_result *result, char text[INTERVAL_TEXT]);
/** One CSV field on standard output, quoted when needed. */
void print_csv_text(FILE *out, const char *text);
/** A number with 9 digits, or nothing when it is not finite. */
void print_csv_number(FILE *out, double value);
/** n of them, with a comma before each. */
void print_csv_numbers(FILE *out, size_t n, const double *values);
/** Begin a row on a predictor with the columns of agreement_columns. */
void print_csv_agreement(FILE *out, const char *by, const char *selection, const char *type, const nqm_agreement *a);
extern const char agreement_columns[];

/* ---- files that a verb writes itself ----------------------------------------------------------------------------- */

/** A file that gets its final name when it is complete; zeroed: none. */
typedef struct output_file {
    FILE *stream;
    nqm_outfile file; /* zeroed: standard output */
} output_file;

/** Open ("-": standard output); EXIT_OK, or the fault is reported and its exit code returned. */
int open_output(const char *verb, const char *path, output_file *out);
/** Close, and rename to the final name or, without `keep`, remove what was written. A zeroed file is allowed. */
int close_output(const char *verb, output_file *out, bool keep);

/* ---- verbs ------------------------------------------------------------------------------------------------------- */

int cmd_batch(int argc, char **argv);
int cmd_bench(int argc, char **argv);
int cmd_calibrate(int argc, char **argv);
int cmd_check(int argc, char **argv);
int cmd_convert(int argc, char **argv);
int cmd_dataset(int argc, char **argv);
int cmd_directions(int argc, char **argv);
int cmd_eval(int argc, char **argv);
int cmd_fit(int argc, char **argv);
int cmd_info(int argc, char **argv);
int cmd_label(int argc, char **argv);
int cmd_learn(int argc, char **argv);
int cmd_models(int argc, char **argv);
int cmd_plot(int argc, char **argv);
int cmd_rank(int argc, char **argv);
int cmd_regress(int argc, char **argv);
int cmd_render(int argc, char **argv);
int cmd_report(int argc, char **argv);
int cmd_reproduce(int argc, char **argv);
int cmd_sample(int argc, char **argv);
int cmd_score(int argc, char **argv);
int cmd_selftest(int argc, char **argv);
int cmd_train(int argc, char **argv);

/* clang-tidy sees one file at a time: tell it that this never returns EXIT_OK. */
#ifdef __clang_analyzer__
#define report(verb, exit_code, ...) (report((verb), (exit_code), __VA_ARGS__), (exit_code))
#endif

#endif
