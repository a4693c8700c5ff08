/* SPDX-License-Identifier: MIT
 *
 * score.h - computing, sorting and printing of scores, for `nqm score`, `nqm batch`, `nqm rank` and `nqm report`.
 */
#ifndef NQM_TOOL_SCORE_H
#define NQM_TOOL_SCORE_H

#include "library/library.h"
#include "metric/metric.h"
#include "nqm/rows.h"
#include "pairs/pairs.h"

/** The lowest JOD, and the lowest lower end of its 95 % interval, that pass; 0: any. */
typedef struct score_gate {
    double jod, jod_low;
} score_gate;

/** The rows of its options. */
#define OPTION_ROWS_GATE(gate)                                                                                         \
    {"fail-under", 0, OPTION_NUMBER, &(gate)->jod, "JOD", "exit with 1 when a score is below this", 0, 10}, {          \
        "fail-under-low", 0, OPTION_NUMBER, &(gate)->jod_low, "JOD",                                                   \
            "exit with 1 when the lower end of a 95 % interval is below this", 0, 10                                   \
    }

/** A pair and its score. */
typedef struct scored_pair {
    nqm_named_pair pair;
    const char *name; /* printed name of the test */
    nqm_score_result result;
    nqm_error err;                     /* status NQM_OK: scored */
    const nqm_texture_result *texture; /* of a pair with a textured material; NULL: of two BRDFs */
    float *heat;                       /* (height, width) Delta-E of the texels, with keep_heat; owned */
    double heat_max;                   /* upper end of the colours of its picture; NaN: there is none */
    size_t order;                      /* index in the arguments */
    nqm_brdf_difference difference;    /* set by compare_rows() */
    /* set by rank_rows(): */
    double quality;        /* sort key: the JOD or the similarity */
    size_t group;          /* index of the first pair with the same reference */
    size_t rank;           /* among the pairs with the same reference, from 1; equal scores share one; 0: no score */
    double over_next;      /* fraction of people who prefer it to the next; NaN: there is none */
    double best_preferred; /* fraction of people who prefer the best to it; NaN for the best itself */
} scored_pair;

/** Settings that remarks refer to. */
typedef struct remark_terms {
    const nqm_model *model;
    nqm_invalid_policy invalid;
} remark_terms;

typedef struct score_run {
    nqm_model *model;
    nqm_score_options options;
    bool metrics[NQM_METRIC_COUNT]; /* metrics to print */
    result_format format;
    score_gate gate; /* gate of `nqm score` */
    bool exact;      /* `nqm score` also compares values */
    double tolerance;
    bool keep_heat, near_only; /* of textures */
    uint64_t texels_per_pixel;
    const char *map; /* file for the map of Delta-E of the texels; NULL: none */
    double worst;    /* gate of the worst 5 % of texels, JOD; 0: none */
    size_t n_rows;
    scored_pair *rows;               /* (n_rows) */
    nqm_pairs *pairs;                /* the texts of the rows; NULL: others have them */
    const char *ref_path, *ref_name; /* the argument; the name to print */
    remark_terms terms;              /* set by make_scores() */
} score_run;

/* ---- shared (score_shared.c) ------------------------------------------------------------------------------------- */

/** Rows for the pairs of arguments[0] with each of the others, expanded. names: (n_arguments) to print, NULL
 *  where the argument itself is to be printed; NULL: there are none. */
void set_pairs(score_run *run, int n_arguments, char **arguments, const char *const *names);
/** The same for given pairs. */
void set_list_pairs(score_run *run, const nqm_pairs *list);
/** nqm_pairs_expand(), with --ignore; materials without a partner are reported. */
nqm_pairs *expand_pairs(const nqm_pairs *pairs);
/** Free with nqm_scorer_free(). */
nqm_scorer *open_scorer(const nqm_model *model, const nqm_score_options *options);
/** The defaults without scalar metrics. */
nqm_score_options plain_score_options(void);
/** Score the pairs of the rows; errors of single pairs are stored in their rows. On another failure, report the error and
 *  exit. */
void make_scores(score_run *run);
/** Whether two rows have the same reference. */
static inline bool has_reference_of(const scored_pair *row, const scored_pair *other) {
    return strcmp(row->pair.ref, other->pair.ref) == 0;
}
/** Free the rows and the model. */
void free_scores(score_run *run);
/** Report the errors of the rows. Returns the exit code of the first. */
int report_faults(const score_run *run);

/** Print the remarks on all rows on standard error, those about the reference once. */
void print_remarks(const score_run *run);
/** A JSON array of remarks on what of a pair is not used, and with a score on negative, missing and unusual values, which name
 *  the BRDFs `ref` (NULL: no remarks about the reference) and `test`. */
json_t *json_remarks(const remark_terms *terms, const nqm_named_pair *pair, const char *ref, const char *test,
                     const nqm_score_result *r);
/** Parse --metrics: names and "all", separated by commas. chosen: (NQM_METRIC_COUNT) */
void choose_metrics(const char *text, bool *chosen);
/** The "model" member of results: id, sha256, parameters. */
json_t *model_json(const nqm_model *model);

/** COLUMNS_... of the parts that a model predicts. */
static inline unsigned score_groups(const nqm_model *model) {
    return nqm_model_has_parts(model) ? COLUMNS_PARTS | COLUMNS_SIMILARITY : 0;
}
/** "  8.93  [8.71, 9.15]", the interval only if the model is calibrated; dashes for a pair without a score. */
void print_jod(const scored_pair *row, bool calibrated);
/** What `nqm score` and `nqm batch` say of a pair: scores, metrics, parts, gate, remarks, and the error of one without a score. */
json_t *json_result(const remark_terms *terms, const nqm_named_pair *pair, const bool *metrics, const score_gate *gate,
                    const nqm_score_result *result, const nqm_error *err);
/** A row as JSON. */
typedef json_t *row_maker(const score_run *run, const scored_pair *row);
/** All rows as a list, and as CSV with columns that are freed; `reference`, `test`, `name` and `error` are those of the row. */
json_t *json_rows(const score_run *run, row_maker *make);
void print_csv_rows(const score_run *run, char *columns, row_maker *make);
/** What `nqm score --csv` prints. */
void print_csv_scores(const score_run *run);
/** The JSON document of `nqm score --json`. */
json_t *json_scores(const score_run *run);
enum { ANISOTROPY_TEXT = 120 };
/** What of the stretch of highlights an anisotropic pair changes, "; stretched ...; rotated by ..." or "". */
char *describe_anisotropy(const scored_pair *row, char text[ANISOTROPY_TEXT]);

/** The gates of scores. */
bool has_gate(const score_gate *gate);
/** Report an error and exit when the gate needs intervals and the model has none. */
void check_gate(const score_gate *gate, const nqm_model *model);
/** Whether a pair fails. A pair without a score does not: it is an error of its own. Identical BRDFs pass every gate. */
bool fails_gate(const score_gate *gate, const nqm_score_result *result);
/** "FAIL", "pass", or "" without a score. */
const char *gate_mark(const score_gate *gate, const nqm_score_result *result);

enum { GATE_TEXT = 96 };
/** What fails: "JOD below 9", "lower end of the interval below 8.5", or both. Returns text. */
const char *gate_words(const score_gate *gate, char text[GATE_TEXT]);
/** Print "nqm VERB: 2 of 7 pairs FAIL: JOD below 9" on standard error if there is a gate. Returns the exit code, or
 *  EXIT_GATE in place of EXIT_OK if a pair failed. */
int report_gate(const score_gate *gate, size_t n_failed, size_t n_pairs, int exit_code);
/** The same, of the rows. */
int apply_gate(const score_run *run, int exit_code);

/* ---- textured materials (textures.c) ----------------------------------------------------------------------------- */

/** Whether a member of a pair that has no score as one of BRDFs is a textured material. */
bool has_texture(const nqm_named_pair *pair);
/** Score such a pair; err->status is that of the result. heat: as of nqm_library_score_texture(). Ctrl-C ends the run. */
void score_texture(const nqm_library_terms *terms, const nqm_named_pair *pair, nqm_library_kept *ref,
                   nqm_texture_result *t, nqm_score_result *result, float **heat, nqm_error *err);
/** Write the map of Delta-E as a picture, or as OpenEXR; returns the upper end of its colours (NaN: OpenEXR has none). */
double write_heat(const char *path, const nqm_texture_result *t, const float *heat);
/** The same for the rows of make_scores(). */
void score_textures(score_run *run);
/** Lines below the row of such a pair. */
void print_texture(const scored_pair *row);
/** The member "texture" of such a row. */
void set_texture(json_t *object, const scored_pair *row);
/** Whether there is such a row; then CSVs have more columns. */
bool has_textures(const score_run *run);
/** The columns of textures: as numbers, NaN without a texture, and as members of an object. */
enum { TEXTURE_NUMBERS = 7 };
typedef struct texture_numbers {
    double v[TEXTURE_NUMBERS];
} texture_numbers;
texture_numbers texture_numbers_of(const nqm_texture_result *texture);
void set_texture_numbers(json_t *object, const texture_numbers *numbers);
/* ---- values -------------------------------------------------------------------------------------------- */

/** With --exact, compare the values of the pairs that have a score. */
void compare_rows(score_run *run);
/** Lines below the row of the pair. */
void print_exact(const score_run *run, const scored_pair *row);
/** Say how many pairs are not equal; whether there are any. */
bool report_unequal(const score_run *run);

/* ---- libraries (library/open.c) ---------------------------------------------------------------------------------- */

/** Open n files and folders as nqm_library_open(), with the model and options of a run; NULL: they are only listed. */
nqm_library *open_library(size_t n, const char *const *where, const score_run *run, const char *index);
/** Rows for pairs of a library, which has their texts and textures; tests: has the tests. */
void set_library_rows(score_run *run, size_t n, const nqm_library_pair *pairs, const nqm_library *tests);
/** The same for the pairs of nqm_library_near(). */
void find_near(nqm_library *library, const nqm_library_query *query, score_run *run);
/** Report faults, and free the library, the rows and the model. Returns the exit code. */
int conclude_near(nqm_library *library, score_run *run);

/* ---- sorting (cmd_rank.c) ---------------------------------------------------------------------------------------- */

/** Sort the rows by reference, then best first, those without a score last, and rank them. */
void rank_rows(score_run *run, bool by_similarity);
/** Print them as `nqm rank` does. */
void print_ranking(const score_run *run);

#endif
