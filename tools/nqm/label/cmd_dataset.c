/* SPDX-License-Identifier: MIT
 *
 * nqm dataset - make a training corpus from a list of materials. Started by mpirun or
 * srun, all processes share the work and the first writes the dataset.
 */
#include "corpus/corpus.h"
#include "nqm/label/scene.h"

#include <string.h>

/* Report the tests that failed; the dataset is valid without them. */
static void print_failures(const json_t *manifest) {
    const char *kind;
    json_t *row;
    json_object_foreach(json_object_get(manifest, "failures"), kind, row) fprintf(
        stderr, "nqm dataset: no %s for %zu tests: %s\n", kind,
        (size_t)json_integer_value(json_object_get(row, "pairs")), json_string_value(json_object_get(row, "message")));
}

static void print_summary(const char *path, bool json) {
    nqm_error err = {0};
    nqm_dataset *dataset;
    must(nqm_dataset_load(path, &dataset, &err), &err);
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

/* The rows of the corpus and those of its scene; --seed is the seed of the corpus. */
static nqm_option_table corpus_and_scene(nqm_option rows[MAX_ROWS]) {
    nqm_option_table table = {.rows = rows};
    for (; table.n < nqm_corpus_option_table.n; ++table.n)
        rows[table.n] = nqm_corpus_option_table.rows[table.n];
    for (size_t i = 0; i < nqm_scene_option_table.n && table.n < MAX_ROWS; ++i, ++table.n) {
        rows[table.n] = nqm_scene_option_table.rows[i];
        rows[table.n].offset += offsetof(nqm_corpus_options, scene);
        if (strcmp(rows[table.n].key, "seed") == 0)
            rows[table.n].name = "scene-seed";
    }
    return table;
}

int cmd_dataset(int argc, char **argv) {
    nqm_corpus_options corpus = nqm_corpus_options_default();
    const char *output = NULL, *directions_path = NULL;
    ranks r = my_ranks();
    scene_args scene = {0};
    bool log = false, json = false;
    nqm_option rows[MAX_ROWS];
    const nqm_option_table table = corpus_and_scene(rows);
    const option options[] = {
        {"output", 'o', OPTION_NEEDED, &output, "FILE.safetensors",
         "the dataset to write; its manifest is written to FILE.json", 0, 0},
        {"directions", 0, OPTION_NEEDED, &directions_path, "CSV", "sampling directions, from `nqm directions`", 0, 0},
        {"log", 0, OPTION_FLAG, &log, NULL, "progress as lines on standard error, for log files", 0, 0},
        {"json", 0, OPTION_FLAG, &json, NULL, "print the manifest as JSON", 0, 0},
        OPTION_ROW_SIZE(&scene, "pixels of a frame: label pictures instead of points"),
        {0}};
    const command cmd = {
        .usage = "MATERIALS.csv --directions CSV -o FILE [options]",
        .about =
            "Make a dataset for `nqm train`: encodings, published fits, other forms of the same material,\n"
            "perturbations of every reference and BRDFs that really differ, among them other materials; labelled by\n"
            "rendering. MATERIALS.csv has the columns name, group, brdf, source and split. Test materials are\n"
            "written to a separate file (--only test). Started by mpirun, all processes share the work; all of them\n"
            "need access to the --work folder.",
        .example =
            "models/scan.py data > materials.csv\n"
            "nqm dataset materials.csv --root data --directions directions.csv -o corpus.safetensors --work work\n"
            "nqm dataset materials.csv --root data --directions directions.csv --only test -o test.safetensors\n"
            "mpirun -n 8 nqm dataset materials.csv --directions directions.csv -o corpus.safetensors --work work",
        .options = options,
        .table = &table,
        .table_target = &corpus,
        .min_arguments = 1,
    };
    parse_arguments(&cmd, argc, argv);
    scene.scene = corpus.scene;
    if (scene.size) /* a picture instead of points */
        scene.scene.n_points = 0;
    scene_args_end(&scene);
    corpus.scene = scene.scene;
    corpus.work_only = r.rank > 0;
    corpus.progress = show_scene_progress;
    set_progress(r.rank > 0 ? PROGRESS_NONE : log ? PROGRESS_LOG : PROGRESS_ON_TERMINAL);
    if (strcmp(output, "-") == 0)
        stop(EXIT_USAGE, "a dataset cannot be written to standard output, because its manifest is a second file; give "
                         "a file name");
    if (r.count > 1 && !corpus.checkpoint)
        stop(EXIT_USAGE, "%zu processes need a shared folder: --work DIR", r.count);
    if (!corpus.root && !list_root(NULL, argv[0]))
        corpus.root = "."; /* a list without a folder, such as standard input */
    if (corpus.checkpoint)
        save_when_interrupted();
    nqm_error err = {0};
    nqm_directions *directions;
    must(nqm_directions_load_csv(input_path(directions_path), &directions, &err), &err);
    const nqm_status status = nqm_corpus_build(argv[0], directions, &corpus, output, &err);
    if (status == NQM_ERR_CANCELLED && corpus.checkpoint)
        stop(EXIT_INTERRUPTED, "stopped; the same command continues from %s", corpus.checkpoint);
    must(status, &err);
    nqm_directions_free(directions);
    if (!corpus.work_only)
        print_summary(output, json);
    return EXIT_OK;
}
