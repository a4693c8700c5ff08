/* SPDX-License-Identifier: MIT
 *
 * nqm dataset - label a list of pairs of BRDFs for training. Started by mpirun or srun, all processes share the work and the first
 * writes the dataset.
 */
#include "corpus/corpus.h"
#include "nqm/label/scene.h"
#include "pairs/pairs.h"

#include <string.h>

/* Report the tests that failed; the dataset is valid without them. */
static void print_failures(const json_t *manifest) {
    const char *kind;
    json_t *row;
    json_object_foreach(json_object_get(manifest, "failures"), kind, row)
        fprintf(stderr, "nqm dataset: %zu pairs of kind %s have no label: %s\n",
                (size_t)json_integer_value(json_object_get(row, "pairs")), kind,
                json_string_value(json_object_get(row, "message")));
}

static void print_summary(const char *path, bool json) {
    nqm_dataset *dataset;
    must(nqm_dataset_load(path, NULL, NQM_SPLIT_ALL, &dataset, &fault));
    const nqm_dataset_info info = nqm_dataset_get_info(dataset);
    json_t *manifest = parse_json(info.manifest);
    end_progress();
    print_failures(manifest);
    if (json)
        print_document(json_pack("{s:s,s:s,s:O?}", "path", path, "sha256", info.sha256, "manifest", manifest));
    else
        printf("%s: %zu pairs of %zu references in %zu material groups (train %zu, validation %zu, test %zu pairs)\n"
               "sha256 %s\n",
               shown(path), info.n_pairs, info.n_refs, info.n_groups, info.n_pairs_in[NQM_SPLIT_TRAIN],
               info.n_pairs_in[NQM_SPLIT_VALIDATION], info.n_pairs_in[NQM_SPLIT_TEST], info.sha256);
    json_decref(manifest);
    nqm_dataset_free(dataset);
}

/* ---- options ----------------------------------------------------------------------------------------------------- */

enum { MAX_ROWS = 32 };

/* The rows of the corpus and those of its scene. */
static nqm_option_table corpus_and_scene(nqm_option rows[MAX_ROWS]) {
    nqm_option_table table = {.rows = rows};
    for (; table.n < nqm_corpus_option_table.n; ++table.n)
        rows[table.n] = nqm_corpus_option_table.rows[table.n];
    for (size_t i = 0; i < nqm_scene_option_table.n && table.n < MAX_ROWS; ++i, ++table.n) {
        rows[table.n] = nqm_scene_option_table.rows[i];
        rows[table.n].offset += offsetof(nqm_corpus_options, scene);
    }
    return table;
}

/* ---- the list ---------------------------------------------------------------------------------------------------- */

static nqm_split split_of(const char *list, size_t row, const char *word) {
    static const char *const words[] = {"train", "validation", "test"};
    for (int i = 0; i < 3; ++i)
        if (strcmp(word, words[i]) == 0)
            return (nqm_split)i;
    stop(EXIT_MALFORMED, "%s: row %zu has the split '%s'; it must be train, validation or test", list, row + 1, word);
}

/* A column that says something about a pair; others are ignored. */
static void set_column(const char *list, size_t row, const char *name, const char *text, nqm_corpus_pair *pair) {
    const struct {
        const char *name;
        const char **text;
    } columns[] = {{"name", &pair->name},     {"group", &pair->group}, {"material", &pair->group},
                   {"source", &pair->source}, {"kind", &pair->kind},   {"subset", &pair->kind},
                   {"family", &pair->family}, {"other", &pair->other}};
    if (nqm_equal_any_case(name, "split", SIZE_MAX) && *text)
        pair->split = split_of(list, row, text);
    for (size_t i = 0; i < sizeof columns / sizeof *columns; ++i)
        if (nqm_equal_any_case(name, columns[i].name, SIZE_MAX))
            *columns[i].text = text;
}

/* The texts belong to the list; free() the result. */
static nqm_corpus_pair *take_pairs(const char *path, const nqm_pairs *list) {
    nqm_corpus_pair *pairs = allocate(list->n, sizeof *pairs);
    nqm_pairs_cell cell;
    for (size_t row = 0; row < list->n; ++row) {
        pairs[row] = (nqm_corpus_pair){.reference = list->pairs[row].ref, .test = list->pairs[row].test};
        for (size_t i = 0; nqm_pairs_get_cell(list, row, i, &cell); ++i)
            set_column(path, row, list->columns[cell.column], cell.text, &pairs[row]);
    }
    return pairs;
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

typedef struct dataset_args {
    nqm_corpus_options corpus;
    const char *output, *directions;
    scene_args scene;
    bool log, json;
    ranks ranks;
} dataset_args;

static void parse(int argc, char **argv, dataset_args *a) {
    nqm_option rows[MAX_ROWS];
    const nqm_option_table table = corpus_and_scene(rows);
    const option options[] = {
        {"output", 'o', OPTION_NEEDED, &a->output, "FILE.safetensors",
         "the dataset to write; its manifest is written to FILE.json", 0, 0},
        {"directions", 0, OPTION_NEEDED, &a->directions, "CSV", "sampling directions, from `nqm directions`", 0, 0},
        {"log", 0, OPTION_FLAG, &a->log, NULL, "progress as lines on standard error, for log files", 0, 0},
        {"json", 0, OPTION_FLAG, &a->json, NULL, "print the manifest as JSON", 0, 0},
        OPTION_ROW_SIZE(&a->scene, "pixels of a frame: label pictures instead of points"),
        {0}};
    const command cmd = {
        .usage = "PAIRS.csv --directions CSV -o FILE [options]",
        .about = "Label a list of pairs by rendering, for `nqm train`. PAIRS is a CSV, or JSON Lines, with the "
                 "columns reference and test, which may be fits of the reference (fit:model=ggx;of=REFERENCE), and "
                 "any of name (of the reference), group (its material), source, split (train, validation, test), "
                 "kind, family, other. Test materials are written to a separate file (--only test). Started by "
                 "mpirun, all processes share the work; all of them need access to the --work folder.",
        .example = "models/plan.py materials.csv --root data > pairs.csv\n"
                   "nqm dataset pairs.csv --root data --directions directions.csv -o corpus.safetensors --work work\n"
                   "nqm dataset pairs.csv --root data --directions directions.csv --only test -o test.safetensors\n"
                   "mpirun -n 8 nqm dataset pairs.csv --directions directions.csv -o corpus.safetensors --work work",
        .options = options,
        .table = &table,
        .table_target = &a->corpus,
        .min_arguments = 1,
    };
    parse_arguments(&cmd, argc, argv);
    a->scene.scene = a->corpus.scene;
    if (a->scene.size) /* a picture instead of points */
        a->scene.scene.n_points = 0;
    scene_args_end(&a->scene);
    a->corpus.scene = a->scene.scene;
    a->corpus.work_only = a->ranks.rank > 0;
    a->corpus.progress = show_scene_progress;
    set_progress(a->ranks.rank > 0 ? PROGRESS_NONE : a->log ? PROGRESS_LOG : PROGRESS_ON_TERMINAL);
    if (strcmp(a->output, "-") == 0)
        stop(EXIT_USAGE, "a dataset cannot be written to standard output, because its manifest is a second file; give "
                         "a file name");
    if (a->ranks.count > 1 && !a->corpus.checkpoint)
        stop(EXIT_USAGE, "%zu processes need a shared folder: --work DIR", a->ranks.count);
}

int cmd_dataset(int argc, char **argv) {
    dataset_args a = {.corpus = nqm_corpus_options_default(), .ranks = my_ranks()};
    nqm_directions *directions;
    nqm_pairs *list;
    parse(argc, argv, &a);
    if (a.corpus.checkpoint)
        save_when_interrupted();
    must(nqm_directions_load_csv(input_path(a.directions), &directions, &fault));
    must(nqm_pairs_read(input_path(argv[0]), &list, &fault));
    a.corpus.root = list_root(a.corpus.root, argv[0]);
    nqm_corpus_pair *pairs = take_pairs(argv[0], list);
    const nqm_status status = nqm_corpus_build(list->n, pairs, directions, &a.corpus, a.output, &fault);
    if (status == NQM_ERR_CANCELLED && a.corpus.checkpoint)
        stop(EXIT_INTERRUPTED, "stopped; the same command continues from %s", a.corpus.checkpoint);
    must(status);
    free(pairs);
    nqm_pairs_free(list);
    nqm_directions_free(directions);
    if (!a.corpus.work_only)
        print_summary(a.output, a.json);
    return EXIT_OK;
}
