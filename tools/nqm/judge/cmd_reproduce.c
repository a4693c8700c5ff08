/* SPDX-License-Identifier: MIT
 *
 * nqm reproduce - the paper's whole study on its authors' data: regression, trainings, test on the human scores, and
 * which of the published figures come out. reproduce_train.c trains, reproduce_figures.c compares, reproduce_print.c tells.
 */
#include "nqm/judge/reproduce.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

/* ---- the authors' folder ----------------------------------------------------------------------------------------- */

static bool is_folder(const char *path) {
    struct stat st;
    return stat(path, &st) == 0 && S_ISDIR(st.st_mode);
}

/* A folder with ref and model in it: as given, or ROOT/NAME. What is missing is reported. */
static int find_folder(const char *root, const char *given, const char *name, const char *option_name,
                       char path[STUDY_PATH_BYTES]) {
    char below[STUDY_PATH_BYTES + 8];
    if (given)
        snprintf(path, STUDY_PATH_BYTES, "%s", given);
    else
        snprintf(path, STUDY_PATH_BYTES, "%s/%s", root, name);
    if (!is_folder(path))
        return report("reproduce", EXIT_OPEN, "%s: no such folder (%s FOLDER names another)", path, option_name);
    static const char *const parts[] = {"ref", "model"};
    for (size_t i = 0; i < 2; ++i) {
        snprintf(below, sizeof below, "%s/%s", path, parts[i]);
        if (!is_folder(below))
            return report("reproduce", EXIT_OPEN, "%s: no such folder; it holds the .mat files of the %s", below,
                          i ? "approximations" : "references");
    }
    return EXIT_OK;
}

/* A CSV: as given, ROOT/NAME, or ROOT/data/NAME as in the authors' repository. */
static int find_labels(const char *root, const char *given, const char *name, const char *option_name,
                       char path[STUDY_PATH_BYTES]) {
    struct stat st;
    static const char *const places[] = {"", "data/"};
    for (size_t i = 0; !given && i < 2; ++i) {
        snprintf(path, STUDY_PATH_BYTES, "%s/%s%s", root, places[i], name);
        if (stat(path, &st) == 0)
            return EXIT_OK;
    }
    if (given)
        snprintf(path, STUDY_PATH_BYTES, "%s", given);
    if (given && stat(path, &st) == 0)
        return EXIT_OK;
    return report("reproduce", EXIT_OPEN, "%s: no such file (%s CSV names another)", path, option_name);
}

int study_find(study *s) {
    const study_options *o = s->options;
    if (!is_folder(o->root))
        return report("reproduce", EXIT_OPEN, "%s: no such folder", o->root);
    const int codes[] = {
        find_folder(o->root, o->train_folder, "uniform_rand_500", "--train", s->train_folder),
        find_labels(o->root, o->train_labels, "labels_balanced_train.csv", "--train-labels", s->train_labels),
        find_folder(o->root, o->test_folder, "test", "--test", s->test_folder),
        find_labels(o->root, o->test_labels, "labels_real.csv", "--test-labels", s->test_labels)};
    for (size_t i = 0; i < sizeof codes / sizeof codes[0]; ++i)
        if (codes[i] != EXIT_OK)
            return codes[i];
    return EXIT_OK;
}

static int make_output(const char *path) {
    if (mkdir(path, 0777) == 0 || (errno == EEXIST && is_folder(path)))
        return EXIT_OK;
    return report("reproduce", EXIT_OPEN, "%s: cannot make this folder: %s", path, strerror(errno));
}

/* ---- the study --------------------------------------------------------------------------------------------------- */

/* The human materials are the test set: none of them may be trained on. */
static int check_apart(const study *s) {
    size_t n_train = nqm_dataset_get_info(s->train).n_pairs, n_test = nqm_dataset_get_info(s->test).n_pairs;
    for (size_t i = 0; i < n_test; ++i) {
        const char *group = nqm_dataset_get_pair(s->test, i).group;
        if (i && strcmp(group, nqm_dataset_get_pair(s->test, i - 1).group) == 0)
            continue;
        for (size_t k = 0; k < n_train; ++k)
            if (strcmp(group, nqm_dataset_get_pair(s->train, k).group) == 0)
                return report("reproduce", EXIT_INCOMPATIBLE, "material '%s' is in both %s and %s", group,
                              s->train_labels, s->test_labels);
    }
    return EXIT_OK;
}

static int load_data(study *s) {
    int exit_code = regress_csv("reproduce", s->test_labels, &s->regression);
    if (exit_code == EXIT_OK)
        exit_code = open_dataset("reproduce", s->test_folder, s->test_labels, NQM_SPLIT_TEST, &s->test);
    if (exit_code == EXIT_OK)
        exit_code = open_dataset("reproduce", s->train_folder, s->train_labels, NQM_SPLIT_ALL, &s->train);
    if (exit_code == EXIT_OK)
        exit_code = check_apart(s);
    return exit_code == EXIT_OK && interrupted() ? report("reproduce", EXIT_INTERRUPTED, "interrupted") : exit_code;
}

static int train_all(study *s) {
    const study_options *o = s->options;
    int exit_code = EXIT_OK;
    for (size_t r = 0; r < o->n_recipes; ++r)
        for (uint64_t seed = 1; exit_code == EXIT_OK && seed <= o->n_seeds; ++seed) {
            study_training *t = &s->trainings[s->n_trainings++];
            *t = (study_training){.recipe = o->recipes[r], .seed = seed};
            exit_code = study_train(s, t);
        }
    return exit_code;
}

static int test_all(study *s) {
    nqm_error err = {0};
    nqm_eval_options o = nqm_eval_options_default();
    const nqm_model *models[STUDY_MAX_RECIPES * STUDY_MAX_SEEDS];
    nqm_agreement results[STUDY_MAX_RECIPES * STUDY_MAX_SEEDS + NQM_METRIC_COUNT];
    nqm_evaluation *evaluation = NULL;
    o.progress = show_progress;
    for (size_t i = 0; i < s->n_trainings; ++i)
        models[i] = s->trainings[i].model;
    nqm_status status = nqm_evaluation_create(s->test, s->n_trainings, models, &o, &evaluation, &err);
    if (status == NQM_OK)
        status = nqm_evaluation_judge(evaluation, &o, results, &err);
    for (size_t i = 0; status == NQM_OK && i < s->n_trainings; ++i) {
        s->trainings[i].result = results[i];
        s->trainings[i].result.name = s->trainings[i].id;
    }
    for (size_t i = 0; status == NQM_OK && i < NQM_METRIC_COUNT; ++i) {
        s->metrics[i] = results[s->n_trainings + i];
        s->metrics[i].name = nqm_metric_name((nqm_metric)i);
    }
    nqm_evaluation_free(evaluation);
    return status == NQM_OK ? EXIT_OK : report_error("reproduce", &err);
}

/* ---- the time of a score ----------------------------------------------------------------------------------------- */

static double now_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int compare_times(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Milliseconds a pair, the median of some predictions of as many sampled pairs as the test set has: transform, whitening
 * and network, as behind the paper's figure. What the samples are does not matter. */
static int time_scoring(const study *s, study_training *t) {
    enum { N_RUNS = 7 };
    size_t n = nqm_dataset_get_info(s->test).n_pairs, width = 3 * nqm_dataset_get_info(s->test).n_directions;
    float *rgb = malloc(n * width * sizeof *rgb);
    nqm_sample_pair *pairs = calloc(n, sizeof *pairs);
    nqm_score_result *results = malloc(n * sizeof *results);
    double times[N_RUNS] = {0};
    nqm_score_options options = nqm_score_options_default();
    options.metrics = 0;
    nqm_scorer *scorer = NULL;
    nqm_error err = {.status = NQM_ERR_NOMEM};
    nqm_status status = rgb && pairs && results ? NQM_OK : NQM_ERR_NOMEM;
    for (size_t i = 0; status == NQM_OK && i < n * width; ++i)
        rgb[i] = 0.01f * (float)(i % 97);
    for (size_t i = 0; status == NQM_OK && i < n; ++i)
        pairs[i].ref = pairs[i].test = rgb + i * width;
    if (status == NQM_OK)
        status = nqm_scorer_create(t->model, &options, &scorer, &err);
    for (size_t run = 0; status == NQM_OK && run < N_RUNS; ++run) {
        double begin = now_s();
        status = nqm_scorer_run_samples(scorer, n, pairs, results, &err);
        times[run] = now_s() - begin;
    }
    nqm_scorer_free(scorer);
    qsort(times, N_RUNS, sizeof times[0], compare_times);
    t->ms_per_pair = 1000 * times[N_RUNS / 2] / (double)n;
    free(rgb);
    free(pairs);
    free(results);
    return status == NQM_OK ? EXIT_OK : report_error("reproduce", &err);
}

/* ---- results ----------------------------------------------------------------------------------------------------- */

static int write_results(const study *s, json_t *json) {
    char path[STUDY_PATH_BYTES];
    output_file out;
    snprintf(path, sizeof path, "%s/bars.csv", s->options->output);
    int exit_code = open_output("reproduce", path, &out);
    if (exit_code == EXIT_OK) {
        study_write_bars(s, out.stream);
        exit_code = close_output("reproduce", &out, true);
    }
    snprintf(path, sizeof path, "%s/reproduce.json", s->options->output);
    if (exit_code == EXIT_OK)
        exit_code = open_output("reproduce", path, &out);
    if (exit_code != EXIT_OK)
        return exit_code;
    bool ok = json && json_dumpf(json, out.stream, JSON_INDENT(2) | JSON_REAL_PRECISION(9)) == 0;
    fputc('\n', out.stream);
    exit_code = close_output("reproduce", &out, ok);
    return ok ? exit_code : report("reproduce", EXIT_LIMIT, "%s: no JSON can be made", path);
}

static int run_study(study *s, bool print_as_json) {
    int exit_code = study_find(s);
    if (exit_code == EXIT_OK)
        exit_code = make_output(s->options->output);
    if (exit_code == EXIT_OK)
        exit_code = load_data(s);
    if (exit_code == EXIT_OK)
        exit_code = train_all(s);
    if (exit_code == EXIT_OK)
        exit_code = test_all(s);
    for (size_t i = 0; exit_code == EXIT_OK && i < s->n_trainings; ++i)
        exit_code = time_scoring(s, &s->trainings[i]);
    if (exit_code != EXIT_OK)
        return exit_code;
    json_t *json = study_json(s);
    exit_code = write_results(s, json);
    if (exit_code == EXIT_OK && print_as_json)
        return print_json(json);
    json_decref(json);
    return exit_code == EXIT_OK ? study_print(s) : exit_code;
}

static void release(study *s) {
    for (size_t i = 0; i < s->n_trainings; ++i)
        nqm_model_free(s->trainings[i].model);
    nqm_dataset_free(s->train);
    nqm_dataset_free(s->test);
}

/* "paper,notebook", cut up in place; each once. */
static int parse_recipes(char *list, study_options *o) {
    for (char *name = strtok(list, ","); name; name = strtok(NULL, ",")) {
        nqm_train_options unused;
        nqm_error err = {0};
        if (nqm_train_options_recipe(name, &unused, &err) != NQM_OK)
            return report_error("reproduce", &err);
        for (size_t i = 0; i < o->n_recipes; ++i)
            if (strcmp(o->recipes[i], name) == 0)
                return report("reproduce", EXIT_USAGE, "recipe '%s' is named twice", name);
        o->recipes[o->n_recipes++] = name; /* there are no more than fit */
    }
    return o->n_recipes ? EXIT_OK : report("reproduce", EXIT_USAGE, "--recipes names none");
}

int cmd_reproduce(int argc, char **argv) {
    study_options o = {.output = "reproduce", .n_seeds = 3, .epochs = 100};
    const char *recipes = "paper,notebook";
    bool json = false;
    const option options[] = {
        {"output", 'o', OPTION_TEXT, &o.output, "DIR", "folder for models, checkpoints and results", 0, 0},
        {"recipes", 0, OPTION_TEXT, &recipes, "LIST", "paper, notebook, nqm, with commas", 0, 0},
        {"seeds", 0, OPTION_COUNT, &o.n_seeds, "N", "trainings of each recipe, with the seeds 1 to N", 1,
         STUDY_MAX_SEEDS},
        {"epochs", 0, OPTION_COUNT, &o.epochs, "N", "of each training; the paper's are 100", 1, 100000},
        {"train", 0, OPTION_TEXT, &o.train_folder, "FOLDER", "training samples, if not DIR/uniform_rand_500", 0, 0},
        {"train-labels", 0, OPTION_TEXT, &o.train_labels, "CSV",
         "their labels, if not labels_balanced_train.csv in DIR or DIR/data", 0, 0},
        {"test", 0, OPTION_TEXT, &o.test_folder, "FOLDER", "test samples, if not DIR/test", 0, 0},
        {"test-labels", 0, OPTION_TEXT, &o.test_labels, "CSV",
         "the human scores, if not labels_real.csv in DIR or DIR/data", 0, 0},
        {"json", 0, OPTION_FLAG, &json, NULL, "print JSON (it is also written to reproduce.json)", 0, 0},
        {0}};
    const command cmd = {
        .name = "reproduce",
        .usage = "DIR [options]",
        .about =
            "Do the whole study of the paper on the data of its authors (DIR, in their layout: doc/reproduce.md): "
            "the\n"
            "JOD curve from the human scores, trainings of each recipe, their test on the human scores beside the\n"
            "metrics, and a table of the published figures that says which come out. Interrupted (Ctrl-C), the "
            "same\n"
            "command goes on where it was.",
        .example = "nqm reproduce authors-data -o study\nnqm reproduce authors-data --seeds 5 --recipes paper --json",
        .options = options,
        .min_arguments = 1,
        .max_arguments = 1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    o.root = argv[0];
    char *list = strdup(recipes);
    study *s = calloc(1, sizeof *s);
    exit_code = list && s ? parse_recipes(list, &o) : report("reproduce", EXIT_LIMIT, "out of memory");
    if (exit_code == EXIT_OK) {
        s->options = &o;
        exit_code = run_study(s, json);
        release(s);
    }
    free(s);
    free(list);
    return exit_code;
}
