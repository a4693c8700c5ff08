/* SPDX-License-Identifier: MIT
 *
 * nqm eval - compare models and the scalar metrics with the labels of a dataset. eval_print.c prints the tables.
 */
#include "base/os.h"
#include "io/io.h"
#include "nqm/judge/eval.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BY_KIND = 1, BY_RANGE = 2, BY_FAMILY = 4, BY_CLASS = 8, BY_SUBSET = 16, BY_SOURCE = 32, BY_ALL = 63 };
static const char *const by_words[] = {"none",   "kind",   "range", "family", "class",
                                       "subset", "source", "both",  "all",    NULL};
static const int by_masks[] = {0,         BY_KIND,   BY_RANGE,           BY_FAMILY, BY_CLASS,
                               BY_SUBSET, BY_SOURCE, BY_KIND | BY_RANGE, BY_ALL};

/* Labels above this value mean "hardly visible": the range in which a quality metric matters most and is least
 * accurate. */
static const double range_edge = 9.5;

/* ---- models ------------------------------------------------------------------------------------------------------ */

static const char *id_of(const eval_run *run, size_t model) {
    return nqm_model_get_info(run->models[model]).id;
}

static bool has_own_id(const eval_run *run, size_t model) {
    size_t n_equal = 0;
    for (size_t i = 0; i < run->n_models; ++i)
        n_equal += strcmp(id_of(run, i), id_of(run, model)) == 0;
    return n_equal == 1;
}

/* Open a list like "default,my.safetensors"; "none": only the scalar metrics. */
static void open_models(eval_run *run, const char *list) {
    size_t n = 1;
    for (const char *p = list; *p; ++p)
        n += *p == ',';
    run->models = allocate(n, sizeof *run->models);
    run->model_names = allocate(n, sizeof *run->model_names);
    run->model_list = allocate(strlen(list) + 1, 1);
    strcpy(run->model_list, list);
    for (char *name = strtok(run->model_list, ","); name; name = strtok(NULL, ","))
        if (strcmp(name, "none") != 0) {
            run->model_names[run->n_models] = name;
            run->models[run->n_models++] = open_model(name);
        }
    for (size_t i = 0; i < run->n_models; ++i)
        if (has_own_id(run, i))
            run->model_names[i] = id_of(run, i);
}

/* ---- selections -------------------------------------------------------------------------------------------------- */

/* Judge one selection and store its rows in run->selections, under "by_WORD" and `name`. A class, source or subset without
 * pairs is left out. */
static void judge_selection(const eval_run *run, const nqm_eval_options *o, const char *by, const char *name) {
    json_t *rows = json_array(), *key = json_name(name);
    judge_pairs(run, o, rows);
    if (!json_object_get(run->selections, by))
        json_object_set_new(run->selections, by, json_object());
    if (json_array_size(rows) || !(o->material_class || o->source || o->subset))
        json_object_set(json_object_get(run->selections, by), json_string_value(key), rows);
    json_decref(rows);
    json_decref(key);
}

/* The selections of a table by names, and the option that selects each. */
static const struct {
    int by;
    const char *key;
    size_t option;
} named_tables[] = {{BY_SUBSET, "by_subset", offsetof(nqm_eval_options, subset)},
                    {BY_FAMILY, "by_family", offsetof(nqm_eval_options, family)},
                    {BY_KIND, "by_kind", offsetof(nqm_eval_options, kind)},
                    {BY_CLASS, "by_class", offsetof(nqm_eval_options, material_class)},
                    {BY_SOURCE, "by_source", offsetof(nqm_eval_options, source)}};
enum { N_NAMED_TABLES = sizeof named_tables / sizeof *named_tables };

/* The name of selection i, "" if it is unknown; NULL: there are no more. Families and sources come again. */
static const char *selection_name(const nqm_dataset *dataset, int by, size_t i) {
    const nqm_dataset_info info = nqm_dataset_get_info(dataset);
    if (by == BY_SUBSET)
        return subset_words[i];
    if (by == BY_CLASS)
        return i < NQM_MATERIAL_CLASS_COUNT ? nqm_material_class_name(i) : NULL;
    if (by == BY_SOURCE)
        return i < info.n_refs ? nqm_dataset_ref_source(dataset, i) : NULL;
    if (i >= info.n_kinds)
        return NULL;
    const nqm_dataset_kind kind = nqm_dataset_get_kind(dataset, i);
    return by == BY_FAMILY ? kind.family : kind.name;
}

static void judge_named(const eval_run *run, nqm_eval_options o, size_t table) {
    const int by = named_tables[table].by;
    const char **name = (const char **)((char *)&o + named_tables[table].option);
    for (size_t i = 0; (*name = selection_name(run->dataset, by, i)); ++i) {
        size_t first = 0;
        while (strcmp(selection_name(run->dataset, by, first), *name) != 0)
            ++first;
        if (first == i && **name)
            judge_selection(run, &o, named_tables[table].key, *name);
    }
}

static void judge_ranges(const eval_run *run, const nqm_eval_options *options) {
    for (int high = 0; high < 2; ++high) {
        nqm_eval_options o = *options;
        char name[40];
        *(high ? &o.jod_from : &o.jod_to) = range_edge;
        snprintf(name, sizeof name, "JOD %s %.1f", high ? ">=" : "<", range_edge);
        judge_selection(run, &o, "by_range", name);
    }
}

static void release(eval_run *run) {
    json_decref(run->results);
    json_decref(run->selections);
    nqm_evaluation_free(run->evaluation);
    for (size_t i = 0; i < run->n_models; ++i)
        nqm_model_free(run->models[i]);
    free(run->models);
    free(run->model_names);
    free(run->model_list);
    nqm_dataset_free(run->owned);
    for (size_t i = 0; run->humans && i < run->n_models; ++i)
        nqm_human_free(run->humans[i]);
    if (run->n_models == 0)
        nqm_human_free(run->human);
    free(run->humans);
    free(run->datasets);
}

typedef struct eval_arguments {
    const char *models, *labels, *by, *pairs, *root;
    bool human;
    result_format format;
    double margin; /* NaN: the default */
    nqm_eval_options options;
} eval_arguments;

/* The first model with the directions of a model. */
static size_t first_alike(const eval_run *run, size_t model) {
    const char *id = nqm_directions_id(nqm_model_get_info(run->models[model]).directions);
    size_t i = 0;
    while (strcmp(nqm_directions_id(nqm_model_get_info(run->models[i]).directions), id) != 0)
        ++i;
    return i;
}

/* The BRDFs at the directions of a model; NULL: at those of "default". */
static nqm_human *load_human(const eval_run *run, const char *root, const nqm_model *model) {
    nqm_human *human;
    const nqm_human_options o = {.root = list_root(root, run->dataset_path),
                                 .directions = model ? nqm_model_get_info(model).directions : NULL,
                                 .progress = show_progress};
    must(nqm_human_load(run->dataset_path, &o, &human, &fault));
    return human;
}

/* Read answers of people, and sample their BRDFs at the directions of the models; metrics are those of the first model's. */
static void open_human(eval_run *run, const char *root) {
    run->humans = allocate(run->n_models, sizeof(nqm_human *));
    run->datasets = allocate(run->n_models, sizeof(const nqm_dataset *));
    for (size_t i = 0; i < run->n_models; ++i) {
        const size_t first = first_alike(run, i);
        if (first == i)
            run->humans[i] = load_human(run, root, run->models[i]);
        run->datasets[i] = run->humans[first]->dataset;
    }
    run->human = run->n_models ? run->humans[0] : load_human(run, root, NULL);
    const nqm_human_kind kind = nqm_human_get_info(run->human).kind;
    run->dataset = run->human->dataset;
    run->is_jod = kind == NQM_HUMAN_JOD;
    run->is_choice = kind == NQM_HUMAN_CHOICE;
}

/* Answers of people are a CSV, too, which needs another option. */
static void require_dataset(const char *path) {
    nqm_csv *csv = NULL;
    if (nqm_os_is_folder(path) || looks_like_safetensors(path) || nqm_csv_load(path, &csv, NULL) != NQM_OK)
        return;
    if (nqm_csv_column(csv, "reference") >= 0)
        stop(EXIT_MALFORMED, "%s: is no dataset but a CSV with the column reference: answers of people need --human",
             path);
    nqm_csv_free(csv);
}

static void refuse_model(const char *path) {
    if (is_builtin(path) && !nqm_os_exists(path))
        stop(EXIT_OPEN, "'%s' is a model, not a dataset: models belong to --model (nqm eval DATASET --model %s)", path,
             path);
}

static void open_pairs(eval_run *run, const eval_arguments *a, nqm_eval_options *o) {
    refuse_model(run->dataset_path);
    if (a->human) {
        open_human(run, a->root);
    } else {
        require_dataset(run->dataset_path);
        run->owned = open_dataset(run->dataset_path, a->labels, NQM_SPLIT_TEST);
        run->dataset = run->owned;
        run->is_jod = true;
    }
    if (!run->is_jod)
        o->order_margin = 0; /* the scale is unknown */
    if (!isnan(a->margin))
        o->order_margin = a->margin;
    run->order_margin = o->order_margin;
}

/* Stop because the models or the split do not fit the dataset, and say which options select others. */
static _Noreturn void stop_incompatible(const eval_run *run, const nqm_eval_options *o, const char *message) {
    const nqm_dataset_info info = nqm_dataset_get_info(run->dataset);
    const bool is_empty = o->split == NQM_SPLIT_ALL ? info.n_pairs == 0 : info.n_pairs_in[o->split] == 0;
    stop(EXIT_INCOMPATIBLE, "%s: %s: %s", run->dataset_path, message,
         is_empty ? "--split selects another split, or all"
                  : "--model FILE judges a model with these directions, --model none the metrics alone");
}

static void evaluate(eval_run *run, const eval_arguments *a, const nqm_eval_options *o, int by) {
    if (run->is_choice && by)
        stop(EXIT_USAGE, "--by: choices have one table only");
    run->results = json_array();
    run->selections = json_object();
    const nqm_status status = nqm_evaluation_create(run->dataset, run->n_models, (const nqm_model *const *)run->models,
                                                    run->datasets, o, &run->evaluation, &fault);
    if (status == NQM_ERR_INCOMPATIBLE)
        stop_incompatible(run, o, fault.message);
    must(status);
    run->n_predictors = run->evaluation->n_predictors;
    if (run->is_choice)
        judge_choices(run, o, run->results);
    else
        judge_pairs(run, o, run->results);
    for (size_t i = 0; i < N_NAMED_TABLES; ++i)
        if (by & named_tables[i].by)
            judge_named(run, *o, i);
    if ((by & BY_RANGE) && run->is_jod)
        judge_ranges(run, o);
    if (a->pairs)
        write_pairs(run, a->pairs);
    print_evaluation(run, a->format);
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static eval_arguments a = {.models = "default", .by = "none"};
static const option options[] = {
    {"model", 'm', OPTION_TEXT, &a.models, "LIST", "names or files with commas; none: metrics only", 0, 0},
    {"metric", 0, OPTION_TEXT, &a.models, "LIST", "the same; scalar metrics are always judged", 0, 0},
    {"by", 0, OPTION_TEXT, &a.by, "WORD",
     "further tables: by subset (near, far, rounding; seen, unseen), family or kind of distortion, class of the "
     "reference material, source of the reference (measured, neural, analytic, ...), JOD range; both (kind and "
     "range), all or none",
     0, 0},
    {"labels", 0, OPTION_TEXT, &a.labels, "CSV", "DATASET is a folder in the authors' layout; its labels", 0, 0},
    {"human", 0, OPTION_FLAG, &a.human, NULL,
     "DATASET is a CSV of what people said: reference, test and score, jod or distance; or reference, test_a, "
     "test_b and choice, or n_a and n_b",
     0, 0},
    {"root", 0, OPTION_TEXT, &a.root, "DIR", "with --human: folder of relative paths (default: the list's folder)", 0,
     0},
    {"margin", 0, OPTION_NUMBER, &a.margin, "X",
     "tests of one material whose labels differ by more than this have an order to be predicted (JOD: 0.25; other "
     "human scores: 0)",
     0, 1e9},
    {"pairs", 0, OPTION_TEXT, &a.pairs, "FILE.csv",
     "also write label, predictions, scalar features and parts of every pair", 0, 0},
    {"json", 0, OPTION_FORMAT, &a.format, NULL, "print JSON", FORMAT_JSON, 0},
    {"csv", 0, OPTION_FORMAT, &a.format, NULL, "print CSV", FORMAT_CSV, 0},
    {0}};

static const command cmd = {
    .usage = "DATASET [options]\n       nqm eval --human PAIRS.csv [options]",
    .about = "Compare models and the scalar metrics with the labels of DATASET (made by `nqm dataset`, or the "
             "authors' folder with --labels, whose pairs all count as test pairs). Prints correlations over all pairs"
             " and as the mean over materials, the fraction of tests in the right order and the errors of the models "
             "in JOD, with 95 % intervals, and compares each model with the best of the eight baselines, with the log"
             " difference and with the estimate by light transport; then how well models predict the parts of labels."
             " --human does the same for the scores of people, or prints the fraction of their choices that is "
             "predicted.",
    .example = "nqm eval corpus.safetensors --by both\n"
               "nqm eval corpus.safetensors --by subset\n"
               "nqm eval corpus.safetensors --model default,my.safetensors --split validation --json\n"
               "nqm eval test_brdfs --labels labels_real.csv --model paper\n"
               "nqm eval --human opinions.csv --root brdfs --model default,transport\n"
               "nqm eval --human choices.csv --root brdfs --apart",
    .options = options,
    .table = &nqm_eval_option_table,
    .table_target = &a.options,
    .min_arguments = 1,
};

int cmd_eval(int argc, char **argv) {
    a.margin = (double)NAN;
    a.options = nqm_eval_options_default();
    a.options.split = NQM_SPLIT_TEST;
    parse_arguments(&cmd, argc, argv);
    if (a.human ? a.labels != NULL : a.root != NULL)
        stop(EXIT_USAGE, a.human ? "--labels and --human exclude each other" : "--root needs --human");
    if (a.options.apart && !a.human)
        stop(EXIT_USAGE, "--apart needs --human");
    eval_run run = {.dataset_path = argv[0], .split_name = nqm_split_words[a.options.split]};
    const int by = by_masks[choose("by", by_words, a.by)];
    open_models(&run, a.models);
    a.options.progress = show_progress;
    open_pairs(&run, &a, &a.options);
    evaluate(&run, &a, &a.options, by);
    release(&run);
    return EXIT_OK;
}
