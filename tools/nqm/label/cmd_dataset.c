/* SPDX-License-Identifier: MIT
 *
 * nqm dataset - make a training corpus from a list of materials. Started by mpirun or
 * srun, all ranks work and the first writes the dataset.
 */
#include "nqm/label/scene_args.h"

#include <string.h>
#include <time.h>
#include <unistd.h>

typedef struct arguments {
    const char *output, *directions, *only;
    bool json;
    size_t count; /* of processes */
} arguments;

/* Name what could not be made: a corpus without it is still one, but its maker must know. */
static void print_failures(const json_t *manifest) {
    const char *kind;
    json_t *row;
    json_object_foreach(json_object_get(manifest, "failures"), kind, row) fprintf(
        stderr, "nqm dataset: no %s for %zu tests: %s\n", kind,
        (size_t)json_integer_value(json_object_get(row, "pairs")), json_string_value(json_object_get(row, "message")));
}

static int print_summary(const char *path, const arguments *a) {
    nqm_error err = {0};
    nqm_dataset *dataset;
    if (nqm_dataset_load(path, &dataset, &err) != NQM_OK)
        return report_error("dataset", &err);
    nqm_dataset_info info = nqm_dataset_get_info(dataset);
    end_progress();
    json_t *manifest = json_loads(info.manifest, 0, NULL);
    print_failures(manifest);
    if (a->json) {
        json_t *root = json_pack("{s:i,s:o,s:s,s:s,s:o}", "schema", 1, "tool", json_tool(), "path", path, "sha256",
                                 info.sha256, "manifest", manifest ? manifest : json_null());
        nqm_dataset_free(dataset);
        return print_json(root);
    }
    json_decref(manifest);
    printf("%s: %zu pairs of %zu references in %zu material groups (train %zu, validation %zu, test %zu pairs)\n", path,
           info.n_pairs, info.n_refs, info.n_groups, info.n_pairs_in[NQM_SPLIT_TRAIN],
           info.n_pairs_in[NQM_SPLIT_VALIDATION], info.n_pairs_in[NQM_SPLIT_TEST]);
    printf("sha256 %s\n", info.sha256);
    nqm_dataset_free(dataset);
    return EXIT_OK;
}

static int parse_part(const char *text, nqm_corpus_part *part) {
    *part = strcmp(text, "test") == 0 ? NQM_CORPUS_TEST : NQM_CORPUS_TRAINING;
    return strcmp(text, "test") == 0 || strcmp(text, "train,validation") == 0;
}

static int build(const char *materials, const arguments *a, const nqm_corpus_options *corpus) {
    nqm_error err = {0};
    nqm_directions *directions;
    if (nqm_directions_load_csv(a->directions, &directions, &err) != NQM_OK)
        return report_error("dataset", &err);
    nqm_status status = nqm_corpus_build(materials, directions, corpus, a->output, &err);
    nqm_directions_free(directions);
    if (status == NQM_ERR_CANCELLED && corpus->checkpoint)
        return report("dataset", EXIT_INTERRUPTED, "stopped; the same command goes on from %s", corpus->checkpoint);
    if (status != NQM_OK)
        return report_error("dataset", &err);
    if (corpus->work_only)
        return EXIT_OK;
    return print_summary(a->output, a);
}

static int run(const char *argument, const arguments *a, const nqm_corpus_options *corpus) {
    if (!a->output)
        return report("dataset", EXIT_USAGE, "say where the corpus goes: -o FILE");
    if (!a->directions)
        return report("dataset", EXIT_USAGE, "say where to sample: --directions FILE (`nqm directions` makes one)");
    if (a->count > 1 && !corpus->checkpoint)
        return report("dataset", EXIT_USAGE, "%zu processes need a folder to share: --work DIR", a->count);
    return build(argument, a, corpus);
}

/* ---- progress ---------------------------------------------------------------------------------------------------- */

typedef struct log_state {
    bool begun;
    time_t begin;
    double first; /* done before this run */
    int percent;
} log_state;

/* For a log file: a line every percent, with the time left at the pace of this run. */
static int log_progress(void *user, const char *stage, double done, double total) {
    log_state *log = user;
    int now = total > 0 ? (int)(100 * done / total) : 0;
    if (isatty(STDERR_FILENO))
        return show_progress(NULL, stage, done, total);
    if (!log->begun)
        *log = (log_state){.begun = true, .begin = time(NULL), .first = done, .percent = -1};
    if (now != log->percent) {
        double pace = difftime(time(NULL), log->begin) / (done > log->first ? done - log->first : 1);
        fprintf(stderr, "%s: %d %% (%.0f of %.0f), %.0f s left\n", stage, now, done, total, pace * (total - done));
    }
    log->percent = now;
    return interrupted();
}

/* For all processes but the first. */
static int quiet_progress(void *user, const char *stage, double done, double total) {
    (void)user, (void)stage, (void)done, (void)total;
    return interrupted();
}

/* ---- options ----------------------------------------------------------------------------------------------------- */

int cmd_dataset(int argc, char **argv) {
    nqm_corpus_options corpus = nqm_corpus_options_default();
    arguments a = {.only = "train,validation"};
    ranks r = my_ranks();
    scene_args scene = scene_args_begin();
    const char *default_size = scene.size;
    uint64_t n_perturbations = corpus.n_perturbations;
    log_state state = {0};
    bool log = false;
    scene.n_points = scene.scene.n_points;
    option options[11 + N_SCENE_OPTIONS] = {
        {.name = "output",
         .letter = 'o',
         .kind = OPTION_TEXT,
         .target = &a.output,
         .metavar = "FILE",
         .help = "the dataset to write; FILE.json gets its manifest"},
        {.name = "directions",
         .kind = OPTION_TEXT,
         .target = &a.directions,
         .metavar = "CSV",
         .help = "where to sample, from `nqm directions`"},
        {.name = "only",
         .kind = OPTION_TEXT,
         .target = &a.only,
         .metavar = "SPLITS",
         .help = "'train,validation' or 'test'"},
        {.name = "root",
         .kind = OPTION_TEXT,
         .target = &corpus.root,
         .metavar = "DIR",
         .help = "where relative paths start (default: the list's folder)"},
        {.name = "work",
         .kind = OPTION_TEXT,
         .target = &corpus.checkpoint,
         .metavar = "DIR",
         .help = "keep finished material groups here, and go on from them; processes that share it share the work"},
        {.name = "models",
         .kind = OPTION_TEXT,
         .target = &corpus.models,
         .metavar = "NAMES",
         .help = "encode references by these models of `nqm fit` only, with commas (default: all)"},
        {.name = "perturbations",
         .kind = OPTION_COUNT,
         .target = &n_perturbations,
         .metavar = "N",
         .help = "perturbed copies a reference",
         .min = 0,
         .max = 1000},
        {.name = "seed",
         .kind = OPTION_COUNT,
         .target = &corpus.seed,
         .metavar = "N",
         .help = "of the perturbations and of the fits"},
        {.name = "log",
         .kind = OPTION_FLAG,
         .target = &log,
         .help = "progress as lines on standard error, for log files"},
        {.name = "json", .kind = OPTION_FLAG, .target = &a.json, .help = "print the manifest as JSON"},
        {0}};
    const command cmd = {
        .name = "dataset",
        .usage = "MATERIALS.csv --directions CSV -o FILE [options]",
        .about =
            "Make a dataset for `nqm train`: encodings, published fits, other forms of the same material and\n"
            "perturbations of every reference, labelled by rendering. MATERIALS.csv has the columns name, group, "
            "brdf,\n"
            "source and split. Test materials go to a file of their own (--only test). Started by mpirun, all ranks\n"
            "work on it; they must see the same --work folder.",
        .example =
            "models/scan.py data > materials.csv\n"
            "nqm dataset materials.csv --root data --directions directions.csv -o corpus.safetensors --work work\n"
            "nqm dataset materials.csv --root data --directions directions.csv --only test -o test.safetensors\n"
            "mpirun -n 8 nqm dataset materials.csv --directions directions.csv -o corpus.safetensors --work work",
        .options = options,
        .min_arguments = 1,
        .max_arguments = 1,
    };
    int n_arguments, exit_code;
    scene_args_table(&scene, options);
    for (option *o = options; o->name; ++o) /* --seed is that of the corpus */
        if (o->target == &scene.scene.seed)
            o->name = "scene-seed";
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    if (!parse_part(a.only, &corpus.part))
        return report("dataset", EXIT_USAGE, "--only takes 'train,validation' or 'test', not '%s'", a.only);
    if (scene.size != default_size) /* a picture instead of points */
        scene.n_points = 0;
    exit_code = scene_args_end("dataset", &scene);
    if (exit_code != EXIT_OK)
        return exit_code;
    corpus.scene = scene.scene;
    corpus.n_perturbations = (size_t)n_perturbations;
    corpus.work_only = r.rank > 0;
    corpus.progress = r.rank > 0 ? quiet_progress : log ? log_progress : show_progress;
    corpus.progress_user = &state;
    a.count = r.count;
    return run(argv[0], &a, &corpus);
}
