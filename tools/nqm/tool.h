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

/** Exit codes; a stable interface (README). */
enum {
    EXIT_OK = 0,
    EXIT_GATE = 1,         /* a score below --fail-under, a failed check */
    EXIT_USAGE = 2,        /* bad option, spec or argument */
    EXIT_OPEN = 3,         /* cannot open, read or write */
    EXIT_MALFORMED = 4,    /* malformed input */
    EXIT_INCOMPATIBLE = 5, /* inputs that do not match, too few valid samples */
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
    OPTION_NEEDED, /* an OPTION_TEXT that must be given */
    OPTION_NUMBER, /* target: double, within [min, max] */
    OPTION_COUNT,  /* target: uint64_t, within [min, max] */
    OPTION_FORMAT  /* target: result_format, which becomes `min`; at most one of these may be given */
} option_kind;

/** A word that the first argument may be: a benchmark, a shell. */
typedef struct choice {
    const char *name;      /* NULL ends the list */
    const char *arguments; /* arguments after the word: "REF TEST"; "": none */
    const char *help;
} choice;

/** The format of results: --json, --csv, --quiet, or none of them. */
typedef enum result_format { FORMAT_TEXT, FORMAT_JSON, FORMAT_CSV, FORMAT_QUIET } result_format;

typedef struct option {
    const char *name; /* without "--"; NULL ends the table */
    char letter;      /* short form, 0 for none */
    option_kind kind;
    void *target;        /* has the default before parsing, which help prints */
    const char *metavar; /* "FILE.csv|.json": an output; other names are refused, and files that cannot be written */
    const char *help;
    double min, max; /* limits of numbers; both 0: any finite value */
} option;

/** The words that the text of an option may be: help and completions show them, choose() checks them. */
typedef struct option_words {
    const char *name; /* name of the option; NULL ends the list */
    const char *const *words;
} option_words;

/** The rows of the model that scores. */
#define OPTION_ROWS_MODEL(target)                                                                                      \
    {"model", 'm', OPTION_TEXT, (target), "MODEL", "a built-in model's name or a model file", 0, 0}, {                 \
        "metric", 0, OPTION_TEXT, (target), "MODEL", "the same; a scalar metric is no model (score --metrics)", 0, 0   \
    }

/** --ignore: what of materials is left out; NULL: nothing. parse_arguments() applies reflecting() to all arguments. --within: the
 *  only folder of which files are read; NULL: all are. */
extern const char *ignored_words, *within;
#define OPTION_ROW_IGNORE                                                                                              \
    {"ignore",                                                                                                         \
     0,                                                                                                                \
     OPTION_TEXT,                                                                                                      \
     &ignored_words,                                                                                                   \
     "LIST",                                                                                                           \
     "take what reflects of materials that do more: any of "                                                           \
     "transmission,subsurface,emission,opacity,displacement,bump",                                                     \
     0,                                                                                                                \
     0},                                                                                                               \
    {                                                                                                                  \
        "within", 0, OPTION_TEXT, &within, "DIR",                                                                      \
            "read no file outside of DIR: for services, as materials may name any file as a map", 0, 0                 \
    }

/** A verb; its name is that of set_verb(). */
typedef struct command {
    const char *usage;   /* after the name: "REF TEST... [options]" */
    const char *about;   /* paragraphs, one a line, which help fills; ends without newline */
    const char *example; /* complete shell commands, one per line; an indented line continues the previous one */
    const option *options;
    const choice *choices;         /* words of the first argument, any other is refused; NULL: none */
    bool has_verbs;                /* they are the verbs of the tool */
    const option_words *words;     /* allowed words of options; NULL: none */
    const nqm_option_table *table; /* further options, set in the struct `table_target`; NULL: none */
    void *table_target;
    int min_arguments, max_arguments; /* positional; max 0: as many as min; max < 0: any number */
} command;

/** Parse argv, where argv[0] is the verb; positional arguments are moved to argv[0..n). Returns n; prints help or a usage error
 *  and exits where that is due. */
int parse_arguments(const command *cmd, int argc, char **argv);
/** Set the option `key` of a table that is not the command's own, from text. */
void set_option(const nqm_option_table *table, const char *key, void *target, const char *text);

/** The index of the text of an option in a list of words, which ends with NULL. */
int choose(const char *name, const char *const *words, const char *text);

/* ---- inputs: on failure, these report the error and exit --------------------------------------------------------- */

/** Zeroed memory; free() it. */
void *allocate(size_t n, size_t size);
/** The same block. */
void *must_have(void *block);
/** A stream that writes to memory. */
FILE *open_text(char **text, size_t *n);
/** Close it; free() *text. */
void close_text(FILE *stream, char **text, size_t *n);
/** "A:B", or one of them where the other is ""; free() it. */
char *join_with_colon(const char *a, const char *b);
/** Open a built-in model by name, or a model file; NULL: "default". */
nqm_model *open_model(const char *name_or_path);
/** The scene that judges fits by the loss `loss` ("auto": the standard scenes of the model "transport"); NULL: none does. Free with
 *  nqm_scene_free(). */
nqm_scene *open_judge(const char *loss, const char *transport);
/** Whether there is a built-in model of this name. */
bool is_builtin(const char *name);
nqm_brdf *open_brdf(const char *argument);
/** Say on standard error what of a file is not used. */
void report_remark(const nqm_brdf *brdf);
/** Stop when the argument, which is to be a BRDF, is the name of a built-in model or nearly so, and no file. open_brdf() and
 *  take_names() do. */
void refuse_model_name(const char *argument);
/** Stop when the argument is no file but like the word, which the verb has. */
void refuse_near_word(const char *argument, const char *word);
/** Open n BRDFs (0 is allowed); close_brdfs() them. */
nqm_brdf **open_brdfs(int n, char **arguments);
void close_brdfs(int n, nqm_brdf **brdfs);
/** Cut the names off n arguments "NAME=BRDF", which then are the BRDFs. Returns (n) names, NULL where there is none; free() it. A
 *  name with control characters is refused, and one that two BRDFs of a reference ("+" separates references) have; so are the names
 *  of models. */
const char **take_names(int n, char **arguments);
/** Whether a file begins with eight bytes of length and a JSON object. */
bool looks_like_safetensors(const char *path);
/** nqm_argument_free() it. */
struct nqm_argument *parse_argument(const char *text);
/** Whether both members are materials that nqm refuses for the same property, value and reason. */
bool has_same_refusal(const nqm_named_pair *pair);
/** NQM_IGNORE_... of --ignore; stops at other words. */
unsigned ignored_set(void);
/** The argument, or the name before it, with "ignore:WORDS:" before its file if it is a material that --ignore makes a
 *  BRDF or texture of; valid to the end of the program. */
const char *reflecting(const char *argument);
/** The folder at which relative paths of a list start: `root`, which must exist; NULL: the folder of the list, or the working
 *  folder for standard input and other lists that are not regular files. NULL: the working folder. Valid until the next call. */
const char *list_root(const char *root, const char *list_path);
/** Make list_root() the working folder. */
void enter_list_root(const char *root, const char *list_path);
/** A text file of at most 1 MiB; free() it. */
char *read_text(const char *path);
/** Open directions from a CSV, a model file or a built-in model; NULL: those of the built-in model "default", or generated
 *  default ones if there is no such model. */
nqm_directions *open_directions(const char *name_or_path);
/** Say how far the rows of a list of measured directions are from those of a model, where it is more than 0.1 degrees. */
void report_distance(const char *argument, const nqm_brdf *brdf, const nqm_directions *directions);
/** Open a dataset: a file of nqm (labels NULL), or a folder in the authors' layout with its labels CSV, whose rows all get
 *  `split`. */
nqm_dataset *open_dataset(const char *path, const char *labels, nqm_split split);

/* ---- several processes ------------------------------------------------------------------------------------------- */

/** Rank and number of the processes of a launcher (mpirun, srun); 0 of 1 without a launcher. */
typedef struct ranks {
    size_t rank, count;
} ranks;
ranks my_ranks(void);

/* ---- messages -------------------------------------------------------------------------------------------------- */

/** Name the verb in all messages (main does). */
void set_verb(const char *name);
const char *verb_name(void);
/** "nqm VERB: message" on standard error, and the exit code for the status. */
int report_error(const nqm_error *err);
/** A message of the library on a part that is left out (status), or on what is not used (NQM_OK). */
void report_part(void *user, nqm_status status, const char *message);
/** The same for an error that the tool found; returns exit_code. */
__attribute__((format(printf, 2, 3))) int report(int exit_code, const char *format, ...);
int exit_code_of(nqm_status status);
/** The same, then exit: unfinished output files are removed, memory is left to the system. */
_Noreturn void stop_error(const nqm_error *err);
__attribute__((format(printf, 2, 3))) _Noreturn void stop(int exit_code, const char *format, ...);
/** The error of calls that must succeed: must(nqm_brdf_open(name, &brdf, &fault)). Of the main thread. */
extern nqm_error fault;
/** stop_error(&fault) unless the status is NQM_OK. */
void must(nqm_status status);
/** From here on a failed allocation of jansson ends the tool: jansson leaves out values, and no result may lack one. */
void stop_without_json_memory(void);
/** The value of a text; NULL if it is no JSON. */
json_t *parse_json(const char *text);
/** Write what is buffered for standard output. Returns exit_code, or reports a failure and returns EXIT_OPEN. */
int finish(int exit_code);

/** What show_progress() prints to standard error: a line that it overwrites, if that is a terminal; else nothing, or a new line
 *  for each percent. */
typedef enum progress_style { PROGRESS_ON_TERMINAL = 0, PROGRESS_LOG, PROGRESS_NONE } progress_style;
void set_progress(progress_style style);
/** A progress callback. Returns nonzero after Ctrl-C. */
int show_progress(void *user, const char *stage, double done, double total);
/** Set a note that the progress line shows from now on. */
__attribute__((format(printf, 1, 2))) void note_progress(const char *format, ...);
/** Clear the progress line, if there is one. */
void end_progress(void);
/** Show that `done` of `total` items are done; Ctrl-C ends the run. */
void step_progress(const char *stage, size_t done, size_t total);
/** Install the Ctrl-C handler (main does). */
void catch_interrupt(void);
/** The verb saves work for a later run after Ctrl-C: give it more time for that. */
void save_when_interrupted(void);
/** A group of processes that is killed when this one ends at once; 0: none. */
void note_child(int group);
/** Whether Ctrl-C was pressed. */
bool interrupted(void);

/** A name as it is printed for people: control characters, which could move the cursor or break a table, become '?'. Valid to the
 *  end of the program. Messages are printed so, too. */
const char *shown(const char *text);
/** Print a JSON value with a final newline, and release it. Returns EXIT_OK. Store numbers that may be NaN with
 *  json_number(). */
int print_json(json_t *value);
/** The same for an object whose first members become "schema" and "tool". */
int print_document(json_t *members);
/** Print the members of an object for people, one per line, without null and empty ones, and release it. Returns EXIT_OK. */
int print_members(json_t *members);
/** A JSON string of a file name or a message. In texts that are not UTF-8, bytes that are not ASCII become '?'. */
json_t *json_name(const char *text);
/** A JSON real, or null when not finite. */
json_t *json_number(double value);
/** An object of members "key:letter key:letter", with a value for each letter: s text, as json_name() (NULL: null); t the same, and ""
 *  is null; f double, as json_number(); z size_t; i int; b bool; o a value, which is taken (NULL: no member); O one that is not. [ff] is a
 *  list, {key:f key:s} an object. */
#define json_row(...) json_set(json_object(), __VA_ARGS__)
/** Set members of an object, likewise. Returns it. */
json_t *json_set(json_t *object, const char *format, ...);
/** {"name":"nqm","version":"..."} for the "tool" member. */
json_t *json_tool(void);
/** Versions of the libraries for ray tracing and pictures, or "off"; does not load them. Static. */
const char *tool_build_info(void);
/** Print phrases with commas or semicolons below a row of a table, on lines of at most 80 columns. */
void print_phrases(const char *text);
/** Print what is stored about the intervals of a model, nqm_model_info.calibration; the same as JSON, null without intervals. */
void print_calibration(const char *stored);
json_t *calibration_json(const char *stored);
/** All properties of a model as JSON. */
json_t *json_model(const nqm_model *model);
/** A CSV field, quoted if necessary. */
void print_csv_text(FILE *out, const char *text);
/** The same after a comma. */
void print_csv_field(FILE *out, const char *text);
/** A number with 9 digits, or nothing if it is not finite. */
void print_csv_number(FILE *out, double value);
/** n numbers, each after a comma. */
void print_csv_numbers(FILE *out, size_t n, const double *values);

/* ---- output files ------------------------------------------------------------------------------------------------ */

/** A file that gets its final name when it is complete; zeroed: none. */
typedef struct output_file {
    FILE *stream;
    nqm_outfile file; /* zeroed: standard output */
    struct output_file *next;
} output_file;

/** The absolute path of `path` with `suffix`, for use after the working folder has changed; "-" remains. free() it. */
char *absolute_path(const char *path, const char *suffix);
/** Open; "-" is standard output. On failure, report the error and exit. */
void open_output(const char *path, output_file *out);
/** Report an error and exit if open_output() would: before long work. */
void require_output(const char *path);
/** The same, and a usage error unless the path has one of the endings: ".png|.svg", or ".mat|DIR/" where a folder is allowed too;
 *  "-" and devices are allowed. parse_arguments() calls it for all options whose metavar is FILE with endings. */
void require_named_output(const char *name, const char *path, const char *endings);
/** Whether two outputs are one file, however their paths are spelt; never for "-" and devices. */
bool is_same_output(const char *a, const char *b);
/** A usage error for the path of a folder that does not exist and has one of the endings, ".csv|.json". contents: what
 *  is written to it, "the results of several models". */
void require_folder_name(const char *name, const char *path, const char *endings, const char *contents);
/** Close, and rename to the final name; a zeroed file is allowed. On failure, report the error and exit. */
void close_output(output_file *out);
/** Remove the temporary files of all open outputs (stop() does). */
void abandon_outputs(void);
/** Create a folder of outputs unless it exists, or end the run; `path` lives as long as the run. */
void make_folder(const char *path);
/** Remove the folder that this run made, if it is empty. May be called in a signal handler. */
void remove_empty_folder(void);

/** Paths for the library, which does not know "-": as an input "-" or a pipe gives a file with its content, as an output
 *  a file that flush_output_path() copies to standard output. Other paths and NULL are returned as they are. */
const char *input_path(const char *path);
const char *output_path(const char *path);
/** At the end of a verb; false when standard output cannot be written. */
bool flush_output_path(void);
/** For messages that begin with such a path: the stream's name, and the length of the path. "" and 0 for others. */
const char *stream_name(const char *message, size_t *n_prefix);

/* ---- verbs ------------------------------------------------------------------------------------------------------- */

typedef int verb_fn(int argc, char **argv);
typedef struct verb {
    const char *name, *heading; /* heading: of a run of verbs in lists of all */
    verb_fn *run;
    const char *summary;
} verb;
extern const verb verbs[]; /* the last one has no name */
/** Whether the verb is the first one under its heading. */
bool begins_heading(const verb *v);
/** NULL when there is no such verb. */
const verb *find_verb(const char *name);
/** Replace a former name of a verb, the first of *argc words, before which is that of the program; if what it did is no verb any
 *  more, say what to do instead and exit. Other words remain. */
void rename_former_verb(int *argc, char ***argv);
/** Print that there is no such verb, and the nearest one. Returns EXIT_USAGE. */
int report_no_verb(const char *name);

verb_fn cmd_batch, cmd_calibrate, cmd_check, cmd_conform, cmd_convert, cmd_dataset, cmd_dedup, cmd_diff, cmd_directions,
    cmd_doctor, cmd_eval, cmd_fit, cmd_help, cmd_info, cmd_label, cmd_nearest, cmd_rank, cmd_regress, cmd_render,
    cmd_report, cmd_sample, cmd_score, cmd_train, cmd_translate, cmd_transport;

#endif
