/* SPDX-License-Identifier: MIT
 *
 * nqm train - trains a model on a dataset. The recipe sets the defaults of the options, so that --help shows its
 * values.
 */
#include "base/os.h"
#include "nqm/tool.h"
#include "train/train.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Values from the command line. */
typedef struct train_arguments {
    const char *output, *labels, *log, *card;
    bool json;
    nqm_train_options options;
} train_arguments;

/* ---- options ----------------------------------------------------------------------------------------------------- */

/* The recipe sets the defaults of the other options, so it is read before they are parsed. */
static const char *find_recipe(int argc, char **argv) {
    static const char name[] = "--recipe";
    const char *recipe = "nqm";
    for (int i = 1; i < argc && strcmp(argv[i], "--") != 0; ++i) {
        if (strcmp(argv[i], name) == 0 && i + 1 < argc)
            recipe = argv[i + 1];
        else if (strncmp(argv[i], name, sizeof name - 1) == 0 && argv[i][sizeof name - 1] == '=')
            recipe = argv[i] + sizeof name;
    }
    return recipe;
}

/* ---- checks before the training ---------------------------------------------------------------------------------- */

/* Check before hours of training that outputs can be written and that no checkpoint would be overwritten. */
static void check_places(const train_arguments *a) {
    const char *paths[] = {a->output, a->options.run.checkpoint, a->log};
    for (size_t i = 0; i < 3; ++i) {
        if (!paths[i] || strcmp(paths[i], "-") == 0)
            continue;
        char *folder = must_have(nqm_path_beside(paths[i], ""));
        int bad = nqm_os_is_folder(paths[i]) ? EISDIR : !nqm_os_is_writable(*folder ? folder : ".") ? errno : 0;
        nqm_free(folder);
        if (bad)
            stop(EXIT_OPEN, "%s: cannot write: %s", paths[i], strerror(bad));
    }
    const char *checkpoint = a->options.run.checkpoint;
    if (a->options.run.resume && !checkpoint)
        stop(EXIT_USAGE, "--resume needs --checkpoint FILE");
    if (checkpoint && !a->options.run.resume && nqm_os_exists(checkpoint))
        stop(EXIT_USAGE, "%s exists: continue from it with --resume, or remove it", checkpoint);
}

/* ---- training ---------------------------------------------------------------------------------------------------- */

typedef struct epoch_log {
    const char *id, *path;
    FILE *stream; /* NULL: none */
    bool is_file, has_head;
} epoch_log;

/* The log is written in place, so that it can be followed and a stopped training leaves it. An earlier log stays until the first
 * epoch; a resumed training writes the epochs of the checkpoint again, which are the same lines. */
static void open_log(epoch_log *log) {
    nqm_file_info info;
    log->stream = stdout;
    if (strcmp(log->path, "-") != 0) {
        const int fd = nqm_os_open(log->path, NQM_OPEN_CREATE);
        log->stream = fd < 0 ? NULL : nqm_os_stream(fd);
        if (!log->stream)
            stop(EXIT_OPEN, "%s: cannot write: %s", log->path, strerror(errno));
        log->is_file = nqm_os_get_info_of(fd, &info) && info.kind == NQM_FILE_REGULAR;
    }
}

/* Write what is buffered, and remove what an earlier training wrote further on. */
static bool flush_log(const epoch_log *log) {
    return fflush(log->stream) == 0 && (!log->is_file || nqm_os_truncate(log->stream));
}

static void close_log(epoch_log *log) {
    if (!log->stream)
        return;
    const bool is_complete = (!log->has_head || flush_log(log)) && !ferror(log->stream);
    if ((log->stream != stdout && fclose(log->stream) != 0) || !is_complete)
        stop(EXIT_OPEN, "%s: cannot write: %s", log->path, strerror(errno));
}

static void on_epoch(void *user, size_t epoch, double train_loss, double validation_loss, double lr_first) {
    epoch_log *log = user;
    note_progress("%.40s, epoch %zu: loss %.4f, validation %.4f", log->id, epoch, train_loss, validation_loss);
    if (!log->stream)
        return;
    if (!log->has_head)
        fputs("epoch,train_loss,validation_loss,lr_first\n", log->stream);
    log->has_head = true;
    fprintf(log->stream, "%zu,%.9g,%.9g,%.9g\n", epoch, train_loss, validation_loss, lr_first);
    flush_log(log); /* close_log() reports errors, when the model is saved */
}

/* Train with progress on the terminal, write the losses of each epoch (a->log) and the model, and load the written file;
 * NULL if it is standard output. */
static nqm_model *train_and_save(const train_arguments *a, const nqm_dataset *dataset, nqm_train_report *report_ret) {
    nqm_model *trained, *loaded = NULL;
    nqm_train_options o = a->options;
    epoch_log log = {.id = o.id, .path = a->log};
    if (a->log)
        open_log(&log);
    if (o.run.checkpoint)
        save_when_interrupted();
    o.run.progress = show_progress;
    o.run.epoch_done = on_epoch;
    o.run.epoch_user = &log;
    must(nqm_train(dataset, &o, &trained, report_ret, &fault));
    must(nqm_model_save(trained, output_path(a->output), &fault));
    nqm_model_free(trained);
    if (strcmp(a->output, "-") != 0)
        must(nqm_model_load(a->output, &loaded, &fault));
    close_log(&log);
    return loaded;
}

static void print_report(const train_arguments *a, const nqm_train_report *r, const nqm_model_info *info) {
    const char *path = a->output;
    if (a->json) {
        print_document(json_row(
            "model:{path:s id:s recipe:s sha256:s parameters:z} n_train:z n_validation:z epochs:z epochs_resumed:z "
            "steps:z precision:s train_loss:f validation_loss:f validation_spearman:f calibration:o seconds:f",
            path, info->id, info->recipe, info->sha256, info->n_parameters, r->n_train, r->n_validation, r->epochs,
            r->epochs_resumed, r->n_steps, nqm_precision_words[a->options.optimiser.precision], r->train_loss,
            r->validation_loss, r->validation_spearman, calibration_json(info->calibration), r->seconds));
        return;
    }
    end_progress();
    printf("model       %s (id %s, recipe %s, %zu parameters)\n", shown(path), info->id, info->recipe,
           info->n_parameters);
    printf("sha256      %s\n", info->sha256);
    printf("trained on  %zu examples, validated on %zu\n", r->n_train, r->n_validation);
    printf("epochs      %zu (%zu steps), %.1f s, %s", r->epochs, r->n_steps, r->seconds,
           nqm_precision_words[a->options.optimiser.precision]);
    printf(r->epochs_resumed ? "; %zu of them from the checkpoint\n" : "\n", r->epochs_resumed);
    printf("loss        %.4f, validation %.4f\n", r->train_loss, r->validation_loss);
    if (isfinite(r->validation_spearman))
        printf("Spearman    %.3f with the labels of the validation pairs\n", r->validation_spearman);
    if (*info->calibration)
        print_calibration(info->calibration);
    else
        printf("interval    none: %s\n", a->options.split.by_pair ? "the validation materials were trained on"
                                                                  : "too few validation pairs or materials");
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static train_arguments a;

static const option options[] = {
    {"output", 'o', OPTION_NEEDED, &a.output, "FILE.safetensors", "the model file to write", 0, 0},
    {"labels", 0, OPTION_TEXT, &a.labels, "CSV", "DATASET is a folder in the authors' layout; its labels", 0, 0},
    {"log", 0, OPTION_TEXT, &a.log, "FILE.csv",
     "write the losses of each epoch as it ends (tail -f); a stopped training leaves them, a resumed one continues "
     "them",
     0, 0},
    {"card", 0, OPTION_TEXT, &a.card, "FILE", "Markdown to append to the model card", 0, 0},
    {"json", 0, OPTION_FLAG, &a.json, NULL, "print JSON", 0, 0},
    {0}};

static const command cmd = {
    .usage = "DATASET -o MODEL [options]",
    .about = "Train a model on the labelled pairs of DATASET (made by `nqm dataset`, or the authors' folder with "
             "--labels). Test pairs are never used. The same dataset, options and seed give the same model, to the "
             "bit, also when interrupted (Ctrl-C) and resumed. Defaults shown are those of the recipe; "
             "doc/training.md explains them.",
    .example = "nqm train corpus.safetensors -o my.safetensors --checkpoint my.checkpoint --log loss.csv\n"
               "nqm train corpus.safetensors -o my.safetensors --checkpoint my.checkpoint --log loss.csv --resume\n"
               "nqm train uniform_rand_500 --labels labels_balanced_train.csv --recipe paper -o paper.safetensors",
    .options = options,
    .table = &nqm_train_option_table,
    .table_target = &a.options,
    .min_arguments = 1,
};

int cmd_train(int argc, char **argv) {
    must(nqm_train_options_recipe(find_recipe(argc, argv), &a.options, &fault));
    parse_arguments(&cmd, argc, argv);
    check_places(&a);
    char *card = a.card ? read_text(a.card) : NULL;
    nqm_dataset *dataset = open_dataset(argv[0], a.labels, NQM_SPLIT_ALL);
    nqm_train_report training;
    a.options.card = card;
    nqm_model *model = train_and_save(&a, dataset, &training);
    if (model) { /* otherwise standard output contains the model */
        const nqm_model_info info = nqm_model_get_info(model);
        print_report(&a, &training, &info);
    }
    nqm_model_free(model);
    nqm_dataset_free(dataset);
    free(card);
    return EXIT_OK;
}
