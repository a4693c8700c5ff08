/* SPDX-License-Identifier: MIT
 *
 * nqm train - train a model on a dataset. The options begin as those of the recipe, so that --help shows what it does.
 */
#include "nqm/tool.h"

#include <errno.h>
#include <libgen.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const choice layouts[] = {
    {"ref_test", NQM_LAYOUT_REF_TEST}, {"ref_diff_absdiff", NQM_LAYOUT_REF_DIFF_ABSDIFF}, {0}};
static const choice targets[] = {{"jod", NQM_TARGET_JOD}, {"log_delta_e", NQM_TARGET_LOG_DELTA_E}, {0}};
static const choice schedules[] = {{"plateau", NQM_SCHEDULE_PLATEAU}, {"cosine", NQM_SCHEDULE_COSINE}, {0}};
static const choice whitenings[] = {{"channel", NQM_WHITEN_CHANNEL}, {"scalar", NQM_WHITEN_SCALAR}, {0}};
static const choice scale_copies[] = {
    {"pair", NQM_SCALE_PAIR_REFLECTANCE}, {"element", NQM_SCALE_ELEMENT_TRANSFORMED}, {"none", NQM_SCALE_NONE}, {0}};
static const choice precisions[] = {{"f32", NQM_PRECISION_F32}, {"bf16", NQM_PRECISION_BF16}, {0}};
static const choice splits[] = {{"group", 0}, {"pair", 1}, {0}};

/* What the command line says. Words and counts are kept as they are parsed and moved into `options` afterwards. */
typedef struct train_arguments {
    const char *recipe, *output, *labels, *log, *card, *hidden;
    const char *layout, *target, *schedule, *whitening, *scale_copy, *split, *precision;
    uint64_t epochs, batch, patience;
    bool balance, no_balance, freeze, no_freeze, scalars, no_scalars, resume, json;
    nqm_train_options options;
} train_arguments;

/* One run: what callbacks and the end need. */
typedef struct train_run {
    const train_arguments *arguments;
    nqm_dataset *dataset;
    nqm_model *model;
    nqm_train_report report;
    output_file log;
    char *card;
} train_run;

/* ---- options ----------------------------------------------------------------------------------------------------- */

/* The recipe decides what the other options begin with: it is looked for before they are parsed. */
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

static void begin_with_recipe(train_arguments *a, char *hidden, size_t n_hidden) {
    const nqm_train_options *o = &a->options;
    a->layout = choice_name(layouts, o->layout);
    a->target = choice_name(targets, o->target);
    a->schedule = choice_name(schedules, o->schedule);
    a->whitening = choice_name(whitenings, o->whitening);
    a->scale_copy = choice_name(scale_copies, o->scale_copy);
    a->split = choice_name(splits, o->split_by_pair);
    a->precision = choice_name(precisions, o->precision);
    a->epochs = o->epochs;
    a->batch = o->batch;
    a->patience = o->plateau_patience;
    hidden[0] = '\0';
    for (size_t i = 0, at = 0; i < o->n_hidden && at < n_hidden; ++i)
        at += (size_t)snprintf(hidden + at, n_hidden - at, "%s%zu", i ? "," : "", o->hidden[i]);
    a->hidden = hidden;
}

/* "1024,716,501" */
static bool parse_hidden(const char *text, nqm_train_options *o) {
    o->n_hidden = 0;
    for (const char *p = text;; ++p) {
        char *end;
        errno = 0;
        unsigned long width = strtoul(p, &end, 10);
        if (end == p || *p == '-' || errno || o->n_hidden == NQM_TRAIN_MAX_HIDDEN)
            return false;
        o->hidden[o->n_hidden++] = width;
        if (*end == '\0')
            return true;
        if (*end != ',')
            return false;
        p = end;
    }
}

static int settle_options(train_arguments *a) {
    nqm_train_options *o = &a->options;
    int layout = 0, target = 0, schedule = 0, whitening = 0, scale_copy = 0, precision = 0;
    int exit_code = choose("train", "layout", layouts, a->layout, &layout);
    if (exit_code == EXIT_OK)
        exit_code = choose("train", "target", targets, a->target, &target);
    if (exit_code == EXIT_OK)
        exit_code = choose("train", "schedule", schedules, a->schedule, &schedule);
    if (exit_code == EXIT_OK)
        exit_code = choose("train", "whitening", whitenings, a->whitening, &whitening);
    if (exit_code == EXIT_OK)
        exit_code = choose("train", "scale-copy", scale_copies, a->scale_copy, &scale_copy);
    if (exit_code == EXIT_OK)
        exit_code = choose("train", "split", splits, a->split, &o->split_by_pair);
    if (exit_code == EXIT_OK)
        exit_code = choose("train", "precision", precisions, a->precision, &precision);
    if (exit_code != EXIT_OK)
        return exit_code;
    if (!parse_hidden(a->hidden, o))
        return report("train", EXIT_USAGE, "--hidden is a list of up to %d widths with commas, not '%s'",
                      NQM_TRAIN_MAX_HIDDEN, a->hidden);
    if ((a->balance && a->no_balance) || (a->freeze && a->no_freeze) || (a->scalars && a->no_scalars))
        return report("train", EXIT_USAGE, "an option and its opposite are both given");
    if (!a->output)
        return report("train", EXIT_USAGE, "where to? give the model file: -o FILE");
    o->layout = (nqm_layout)layout;
    o->precision = (nqm_precision)precision;
    o->target = (nqm_target)target;
    o->schedule = (nqm_schedule)schedule;
    o->whitening = (nqm_whitening)whitening;
    o->scale_copy = (nqm_scale_copy)scale_copy;
    o->balance = a->balance || (o->balance && !a->no_balance);
    o->freeze_first_layernorm = a->freeze || (o->freeze_first_layernorm && !a->no_freeze);
    o->scalars = a->scalars || (o->scalars && !a->no_scalars);
    o->epochs = (size_t)a->epochs;
    o->batch = (size_t)a->batch;
    o->plateau_patience = (size_t)a->patience;
    o->resume = a->resume;
    return EXIT_OK;
}

/* ---- before an hour is spent ------------------------------------------------------------------------------------- */

/* A folder that cannot be written, or a checkpoint that would be overwritten, is better known now. */
static int check_places(const train_arguments *a) {
    const char *paths[] = {a->output, a->options.checkpoint};
    for (size_t i = 0; i < 2; ++i) {
        char *copy = paths[i] && strcmp(paths[i], "-") != 0 ? strdup(paths[i]) : NULL;
        if (!copy)
            continue;
        struct stat st;
        bool is_folder = stat(paths[i], &st) == 0 && S_ISDIR(st.st_mode);
        int bad = is_folder ? EISDIR : access(dirname(copy), W_OK) != 0 ? errno : 0;
        free(copy);
        if (bad)
            return report("train", EXIT_OPEN, "%s: cannot write: %s", paths[i], strerror(bad));
    }
    const char *checkpoint = a->options.checkpoint;
    if (a->resume && !checkpoint)
        return report("train", EXIT_USAGE, "--resume needs --checkpoint FILE");
    if (checkpoint && !a->resume && access(checkpoint, F_OK) == 0)
        return report("train", EXIT_USAGE, "%s is there already: go on from it with --resume, or remove it",
                      checkpoint);
    return EXIT_OK;
}

static int open_log(const char *path, output_file *log) {
    int exit_code = open_output("train", path, log);
    if (exit_code == EXIT_OK)
        fputs("epoch,train_loss,validation_loss,lr_first\n", log->stream);
    return exit_code;
}

/* ---- the run ----------------------------------------------------------------------------------------------------- */

static void on_epoch(void *user, size_t epoch, double train_loss, double validation_loss, double lr_first) {
    train_run *run = user;
    note_progress("epoch %zu: loss %.4f, validation %.4f", epoch, train_loss, validation_loss);
    if (!run->log.stream)
        return;
    fprintf(run->log.stream, "%zu,%.9g,%.9g,%.9g\n", epoch, train_loss, validation_loss, lr_first);
    fflush(run->log.stream);
}

static int print_report(const train_run *run, const nqm_model_info *info) {
    const nqm_train_report *r = &run->report;
    const char *path = run->arguments->output;
    if (run->arguments->json)
        return print_json(json_pack("{s:i,s:o,s:{s:s,s:s,s:s,s:s,s:I},s:I,s:I,s:I,s:I,s:I,s:o,s:o,s:o,s:o,s:o}",
                                    "schema", 1, "tool", json_tool(), "model", "path", path, "id", info->id, "recipe",
                                    info->recipe, "sha256", info->sha256, "parameters", (json_int_t)info->n_parameters,
                                    "n_train", (json_int_t)r->n_train, "n_validation", (json_int_t)r->n_validation,
                                    "epochs", (json_int_t)r->epochs, "epochs_resumed", (json_int_t)r->epochs_resumed,
                                    "steps", (json_int_t)r->n_steps, "train_loss", json_number(r->train_loss),
                                    "validation_loss", json_number(r->validation_loss), "validation_spearman",
                                    json_number(r->validation_spearman), "calibration",
                                    calibration_json(&r->calibration), "seconds", json_number(r->seconds)));
    end_progress();
    printf("model       %s (id %s, recipe %s, %zu parameters)\n", path, info->id, info->recipe, info->n_parameters);
    printf("sha256      %s\n", info->sha256);
    printf("trained on  %zu examples, validated on %zu\n", r->n_train, r->n_validation);
    printf("epochs      %zu (%zu steps), %.1f s", r->epochs, r->n_steps, r->seconds);
    printf(r->epochs_resumed ? "; %zu of them from the checkpoint\n" : "\n", r->epochs_resumed);
    printf("loss        %.4f, validation %.4f\n", r->train_loss, r->validation_loss);
    if (isfinite(r->validation_spearman))
        printf("Spearman    %.3f with the labels of the validation pairs\n", r->validation_spearman);
    if (r->calibration.n_materials)
        print_calibration(&r->calibration);
    else
        printf("interval    none: %s\n", run->arguments->options.split_by_pair
                                             ? "the validation materials were trained on"
                                             : "too few validation pairs or materials");
    return EXIT_OK;
}

/* Save, and read back what was written: it must load. */
static int save_model(const train_run *run) {
    const char *path = run->arguments->output;
    nqm_error err = {0};
    nqm_model *written = NULL;
    nqm_status status = nqm_model_save(run->model, path, &err);
    if (status == NQM_OK && strcmp(path, "-") == 0)
        return EXIT_OK; /* the model itself is the result on standard output */
    if (status == NQM_OK)
        status = nqm_model_load(path, &written, &err);
    if (status != NQM_OK)
        return report_error("train", &err);
    nqm_model_info info = nqm_model_get_info(written);
    int exit_code = print_report(run, &info);
    nqm_model_free(written);
    return exit_code;
}

static int run_training(const train_arguments *a, const char *dataset_path) {
    train_run run = {.arguments = a};
    nqm_train_options o = a->options;
    nqm_error err = {0};
    int exit_code = check_places(a);
    if (exit_code == EXIT_OK && a->card)
        exit_code = read_text("train", a->card, &run.card);
    if (exit_code == EXIT_OK)
        exit_code = open_dataset("train", dataset_path, a->labels, NQM_SPLIT_ALL, &run.dataset);
    if (exit_code == EXIT_OK && a->log)
        exit_code = open_log(a->log, &run.log);
    if (exit_code == EXIT_OK) {
        o.card = run.card;
        o.progress = show_progress;
        o.epoch_done = on_epoch;
        o.epoch_user = &run;
        if (nqm_train(run.dataset, &o, &run.model, &run.report, &err) != NQM_OK)
            exit_code = report_error("train", &err);
    }
    if (exit_code == EXIT_OK)
        exit_code = save_model(&run);
    int log_code = close_output("train", &run.log, exit_code == EXIT_OK);
    exit_code = exit_code == EXIT_OK ? log_code : exit_code;
    nqm_model_free(run.model);
    nqm_dataset_free(run.dataset);
    free(run.card);
    return exit_code;
}

enum { MAX_OPTIONS = 40 };

static void list_options(train_arguments *a, option options[MAX_OPTIONS]) {
    nqm_train_options *o = &a->options;
    const option list[] = {
        {"output", 'o', OPTION_TEXT, &a->output, "FILE", "the model file to write", 0, 0},
        {"recipe", 0, OPTION_TEXT, &a->recipe, "NAME", "paper, notebook or nqm: where the others begin", 0, 0},
        {"id", 0, OPTION_TEXT, &o->id, "NAME", "id of the model", 0, 0},
        {"licence", 0, OPTION_TEXT, &o->licence, "SPDX", "licence of the model", 0, 0},
        {"labels", 0, OPTION_TEXT, &a->labels, "CSV", "DATASET is a folder in the authors' layout; its labels", 0, 0},
        {"epochs", 0, OPTION_COUNT, &a->epochs, "N", "passes over the training pairs", 1, 1e6},
        {"batch", 0, OPTION_COUNT, &a->batch, "N", "pairs a step", 1, 65536},
        {"precision", 0, OPTION_TEXT, &a->precision, "WORD", "of the factors of all products: f32 or bf16", 0, 0},
        {"seed", 0, OPTION_COUNT, &o->seed, "N", "of weights, split, augmentation, order and dropout", 0, 0},
        {"layout", 0, OPTION_TEXT, &a->layout, "WORD", "input: ref_test or ref_diff_absdiff", 0, 0},
        {"difference-scale", 0, OPTION_NUMBER, &o->difference_scale, "S", "times the differences", 1e-6, 1e6},
        {"scalars", 0, OPTION_FLAG, &a->scalars, NULL, "scalar features of the pair as further inputs (nqm)", 0, 0},
        {"no-scalars", 0, OPTION_FLAG, &a->no_scalars, NULL, "samples only (paper, notebook)", 0, 0},
        {"scalar-scale", 0, OPTION_NUMBER, &o->scalar_scale, "S", "times the scalar features", 1e-6, 1e6},
        {"hidden", 0, OPTION_TEXT, &a->hidden, "LIST", "widths of the hidden layers", 0, 0},
        {"target", 0, OPTION_TEXT, &a->target, "WORD", "what is learnt: jod or log_delta_e", 0, 0},
        {"min-delta-e", 0, OPTION_NUMBER, &o->min_delta_e, "E", "smaller labels count as this (log_delta_e)", 1e-6, 10},
        {"whitening", 0, OPTION_TEXT, &a->whitening, "WORD", "channel or scalar", 0, 0},
        {"scale-copy", 0, OPTION_TEXT, &a->scale_copy, "WORD", "copies scaled by 0.95..1.05: pair, element or none", 0,
         0},
        {"split", 0, OPTION_TEXT, &a->split, "WORD", "validation by group (of material) or by pair", 0, 0},
        {"validation", 0, OPTION_NUMBER, &o->validation_fraction, "F", "fraction, if the dataset has no such split",
         0.001, 0.9},
        {"balance", 0, OPTION_FLAG, &a->balance, NULL, "fill rare label bins by noisy copies", 0, 0},
        {"no-balance", 0, OPTION_FLAG, &a->no_balance, NULL, "do not", 0, 0},
        {"balance-sigma", 0, OPTION_NUMBER, &o->balance_sigma, "S", "of that noise, 1/sr", 0, 10},
        {"dropout", 0, OPTION_NUMBER, &o->dropout, "P", "probability", 0, 0.9},
        {"lr-first", 0, OPTION_NUMBER, &o->lr_first, "R", "learning rate of the first layer", 0, 1},
        {"lr", 0, OPTION_NUMBER, &o->lr_deeper, "R", "learning rate of the others", 0, 1},
        {"weight-decay", 0, OPTION_NUMBER, &o->weight_decay, "W", "L2, added to the gradient", 0, 1},
        {"schedule", 0, OPTION_TEXT, &a->schedule, "WORD", "how the rates fall: plateau or cosine", 0, 0},
        {"plateau-factor", 0, OPTION_NUMBER, &o->plateau_factor, "F", "the rates' when validation stagnates", 0.001, 1},
        {"plateau-patience", 0, OPTION_COUNT, &a->patience, "N", "epochs without progress before that", 0, 1e6},
        {"freeze-norm", 0, OPTION_FLAG, &a->freeze, NULL, "leave the first LayerNorm as it begins (notebook)", 0, 0},
        {"train-norm", 0, OPTION_FLAG, &a->no_freeze, NULL, "train it (paper, nqm)", 0, 0},
        {"checkpoint", 0, OPTION_TEXT, &o->checkpoint, "FILE", "rewritten after each epoch", 0, 0},
        {"resume", 0, OPTION_FLAG, &a->resume, NULL, "go on from the checkpoint", 0, 0},
        {"log", 0, OPTION_TEXT, &a->log, "CSV", "losses of each epoch", 0, 0},
        {"card", 0, OPTION_TEXT, &a->card, "FILE", "Markdown to add to the model card", 0, 0},
        {"json", 0, OPTION_FLAG, &a->json, NULL, "print JSON", 0, 0},
        {0}};
    _Static_assert(sizeof list / sizeof list[0] <= MAX_OPTIONS, "all options fit");
    memcpy(options, list, sizeof list);
}

int cmd_train(int argc, char **argv) {
    char hidden[200];
    train_arguments a = {.recipe = find_recipe(argc, argv)};
    nqm_error err = {0};
    if (nqm_train_options_recipe(a.recipe, &a.options, &err) != NQM_OK)
        return report_error("train", &err);
    begin_with_recipe(&a, hidden, sizeof hidden);
    option options[MAX_OPTIONS];
    list_options(&a, options);
    const command cmd = {
        .name = "train",
        .usage = "DATASET -o MODEL [options]",
        .about =
            "Train a model on the labelled pairs of DATASET (made by `nqm dataset`, or the authors' folder with "
            "--labels).\n"
            "Test pairs are never touched. The same dataset, options and seed give the same model, to the bit, also "
            "when\n"
            "interrupted (Ctrl-C) and resumed. Defaults shown are those of the recipe; doc/training.md explains them.",
        .example = "nqm train corpus.safetensors -o my.safetensors --checkpoint my.checkpoint --log loss.csv\n"
                   "nqm train corpus.safetensors -o my.safetensors --checkpoint my.checkpoint --log loss.csv --resume\n"
                   "nqm train uniform_rand_500 --labels labels_balanced_train.csv --recipe paper -o paper.safetensors",
        .options = options,
        .min_arguments = 1,
        .max_arguments = 1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    exit_code = settle_options(&a);
    return exit_code == EXIT_OK ? run_training(&a, argv[0]) : exit_code;
}
