/* SPDX-License-Identifier: MIT
 *
 * nqm reproduce - the paper's study on its authors' data: regression, trainings and evaluation with the same functions
 * as `nqm regress`, `nqm train` and `nqm eval`, and a table that compares the results with the published ones. All
 * results are stored in one JSON document, from which the text is printed.
 */
#include "nqm/judge/eval.h"
#include "nqm/train/train_tool.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { PATH_BYTES = 4096, MAX_RECIPES = 3, MAX_SEEDS = 20, PAPER_EPOCHS = 100 };

typedef struct training {
    const char *recipe;
    char id[40]; /* "paper-1": the model's id, and the prefix of its file names */
    nqm_model *model;
    json_t *json; /* its entry in "trainings" */
} training;

typedef struct study {
    const char *root, *output;
    const char *given[4]; /* paths of the authors' data, TRAIN_FOLDER and others; NULL: found below root */
    char path[4][PATH_BYTES];
    const char *recipes[MAX_RECIPES];
    uint64_t n_seeds, epochs;
    size_t n_recipes, n_trainings;
    nqm_dataset *train, *test;
    training trainings[MAX_RECIPES * MAX_SEEDS]; /* in the order of recipes, then seeds 1..n_seeds */
    nqm_agreement bars[MAX_RECIPES + NQM_METRIC_COUNT];
    json_t *json;
} study;

/* ---- the authors' folder ----------------------------------------------------------------------------------------- */

enum { TRAIN_FOLDER, TRAIN_LABELS, TEST_FOLDER, TEST_LABELS };
static const struct {
    const char *name, *option;
} parts[] = {{"uniform_rand_500", "--train FOLDER"},
             {"labels_balanced_train.csv", "--train-labels CSV"},
             {"test", "--test FOLDER"},
             {"labels_real.csv", "--test-labels CSV"}};

static bool exists(const char *path, bool folder) {
    struct stat st;
    return stat(path, &st) == 0 && (!folder || S_ISDIR(st.st_mode));
}

/* Find a part: the given path, else ROOT/NAME, else ROOT/data/NAME for a CSV. */
static int find_part(study *s, int part) {
    static const char *const below[] = {"ref", "model"};
    const bool folder = part == TRAIN_FOLDER || part == TEST_FOLDER;
    char *path = s->path[part], inner[PATH_BYTES + 8];
    snprintf(path, PATH_BYTES, s->given[part] ? "%s" : "%s/%s", s->given[part] ? s->given[part] : s->root,
             parts[part].name);
    if (!s->given[part] && !folder && !exists(path, false))
        snprintf(path, PATH_BYTES, "%s/data/%s", s->root, parts[part].name);
    if (!exists(path, folder))
        return report("reproduce", EXIT_OPEN, "%s: no such %s (%s names another)", path, folder ? "folder" : "file",
                      parts[part].option);
    for (size_t i = 0; folder && i < 2; ++i) {
        snprintf(inner, sizeof inner, "%s/%s", path, below[i]);
        if (!exists(inner, true))
            return report("reproduce", EXIT_OPEN, "%s: no such folder; it holds the .mat files of the %s", inner,
                          i ? "approximations" : "references");
    }
    return EXIT_OK;
}

/* Find all parts of the data; reports every missing one. */
static int find_data(study *s) {
    int exit_code = exists(s->root, true) ? EXIT_OK : report("reproduce", EXIT_OPEN, "%s: no such folder", s->root);
    const bool found = exit_code == EXIT_OK;
    for (int part = 0; found && part < 4; ++part) {
        int code = find_part(s, part);
        exit_code = exit_code == EXIT_OK ? code : exit_code;
    }
    if (exit_code == EXIT_OK && mkdir(s->output, 0777) != 0 && !(errno == EEXIST && exists(s->output, true)))
        exit_code = report("reproduce", EXIT_OPEN, "%s: cannot make this folder: %s", s->output, strerror(errno));
    return exit_code;
}

/* The materials of the human study are the test set, so that the training set must not contain them. */
static int check_disjoint(const study *s) {
    for (size_t i = 0; i < nqm_dataset_get_info(s->test).n_pairs; ++i) {
        const char *group = nqm_dataset_get_pair(s->test, i).group;
        for (size_t k = 0; k < nqm_dataset_get_info(s->train).n_pairs; ++k)
            if (strcmp(group, nqm_dataset_get_pair(s->train, k).group) == 0)
                return report("reproduce", EXIT_INCOMPATIBLE, "material '%s' is in both %s and %s", group,
                              s->path[TRAIN_LABELS], s->path[TEST_LABELS]);
    }
    return EXIT_OK;
}

static json_t *dataset_json(const study *s, int folder, const nqm_dataset *d) {
    nqm_dataset_info info = nqm_dataset_get_info(d);
    return json_pack("{s:o,s:o,s:I,s:I,s:I,s:s}", "path", json_name(s->path[folder]), "labels",
                     json_name(s->path[folder + 1]), "n", (json_int_t)info.n_pairs, "n_materials",
                     (json_int_t)info.n_groups, "n_directions", (json_int_t)info.n_directions, "sha256", info.sha256);
}

static int load_data(study *s) {
    nqm_regress_report r;
    int exit_code = regress_csv("reproduce", s->path[TEST_LABELS], &r);
    if (exit_code == EXIT_OK)
        exit_code = open_dataset("reproduce", s->path[TEST_FOLDER], s->path[TEST_LABELS], NQM_SPLIT_TEST, &s->test);
    if (exit_code == EXIT_OK)
        exit_code = open_dataset("reproduce", s->path[TRAIN_FOLDER], s->path[TRAIN_LABELS], NQM_SPLIT_ALL, &s->train);
    if (exit_code == EXIT_OK)
        exit_code = check_disjoint(s);
    if (exit_code == EXIT_OK)
        s->json = json_pack("{s:i,s:o,s:o,s:o,s:{s:o,s:o,s:o,s:o,s:o,s:I}}", "schema", 1, "tool", json_tool(), "train",
                            dataset_json(s, TRAIN_FOLDER, s->train), "test", dataset_json(s, TEST_FOLDER, s->test),
                            "regression", "b1", json_number(r.curve.b1), "b2", json_number(r.curve.b2), "b3",
                            json_number(r.curve.b3), "rmse", json_number(r.rmse), "spearman", json_number(r.spearman),
                            "n", (json_int_t)r.n);
    return exit_code == EXIT_OK && interrupted() ? report("reproduce", EXIT_INTERRUPTED, "interrupted") : exit_code;
}

/* ---- values in JSON ---------------------------------------------------------------------------------------------- */

/* The number at a path like "whitening.mean.0"; NaN if it does not exist. */
static double number_at(const json_t *json, const char *path) {
    char key[40];
    while (json && *path) {
        size_t n = strcspn(path, ".");
        snprintf(key, sizeof key, "%.*s", (int)n, path);
        json = json_is_array(json) ? json_array_get(json, strtoul(key, NULL, 10)) : json_object_get(json, key);
        path += n + (path[n] == '.');
    }
    return json_is_number(json) ? json_number_value(json) : (double)NAN;
}

/* Mean and standard deviation (divisor n - 1; NaN for n = 1) of a number over a recipe's trainings. Returns n. */
static size_t mean_at(const study *s, const char *recipe, const char *path, double *mean_ret, double *sd_ret) {
    double sum = 0, squares = 0;
    size_t n = 0;
    for (size_t i = 0; i < s->n_trainings; ++i)
        if (strcmp(s->trainings[i].recipe, recipe) == 0) {
            sum += number_at(s->trainings[i].json, path);
            ++n;
        }
    *mean_ret = n ? sum / (double)n : (double)NAN;
    for (size_t i = 0; i < s->n_trainings; ++i)
        if (strcmp(s->trainings[i].recipe, recipe) == 0)
            squares += pow(number_at(s->trainings[i].json, path) - *mean_ret, 2);
    *sd_ret = n > 1 ? sqrt(squares / (double)(n - 1)) : (double)NAN;
    return n;
}

static int write_json(const char *path, const json_t *json, size_t digits) {
    output_file out;
    int exit_code = open_output("reproduce", path, &out);
    if (exit_code != EXIT_OK)
        return exit_code;
    bool ok = json && json_dumpf(json, out.stream, JSON_INDENT(2) | JSON_REAL_PRECISION(digits)) == 0;
    fputc('\n', out.stream);
    exit_code = close_output("reproduce", &out, ok);
    return ok ? exit_code : report("reproduce", EXIT_LIMIT, "%s: cannot make the JSON", path);
}

/* ---- trainings --------------------------------------------------------------------------------------------------- */

static void path_of(const study *s, const training *t, const char *ending, char path[PATH_BYTES]) {
    snprintf(path, PATH_BYTES, "%s/%s%s", s->output, t->id, ending);
}

/* Load the model and the record of an earlier run if they match. Fails if the record has other data or options. */
static int load_finished(const study *s, training *t, const char *model_path, const char *record_path) {
    json_t *record = exists(record_path, false) ? json_load_file(record_path, 0, NULL) : NULL;
    const char *dataset = json_string_value(json_object_get(record, "dataset_sha256"));
    const char *recipe = json_string_value(json_object_get(record, "recipe"));
    const char *sha256 = json_string_value(json_object_get(record, "model_sha256"));
    int exit_code = EXIT_OK;
    if (record && (!dataset || strcmp(dataset, nqm_dataset_get_info(s->train).sha256) != 0 || !recipe ||
                   strcmp(recipe, t->recipe) != 0 || number_at(record, "epochs") != (double)s->epochs))
        exit_code =
            report("reproduce", EXIT_INCOMPATIBLE,
                   "%s is of a training on other data or with other options: choose another folder (-o)", record_path);
    else if (record && exists(model_path, false))
        exit_code = open_model("reproduce", model_path, &t->model);
    if (t->model && sha256 && strcmp(sha256, nqm_model_get_info(t->model).sha256) == 0) {
        t->json = record;
        return exit_code;
    }
    nqm_model_free(t->model);
    t->model = NULL;
    json_decref(record);
    return exit_code;
}

static int train_now(const study *s, training *t, uint64_t seed, const char *model_path, const char *record_path) {
    char checkpoint[PATH_BYTES], log_path[PATH_BYTES];
    nqm_error err = {0};
    nqm_train_options o;
    nqm_train_report r;
    if (nqm_train_options_recipe(t->recipe, &o, &err) != NQM_OK)
        return report_error("reproduce", &err);
    path_of(s, t, ".checkpoint", checkpoint);
    path_of(s, t, "-loss.csv", log_path);
    o.id = t->id;
    o.optimiser.seed = seed;
    o.optimiser.epochs = (size_t)s->epochs;
    o.run.checkpoint = checkpoint;
    o.run.resume = exists(checkpoint, false);
    int exit_code = train_and_save("reproduce", s->train, &o, model_path, log_path, &t->model, &r);
    if (exit_code == EXIT_INTERRUPTED)
        report("reproduce", exit_code, "the same command again continues from there");
    if (exit_code != EXIT_OK)
        return exit_code;
    const size_t n_timed = r.epochs - r.epochs_resumed;
    t->json =
        json_pack("{s:i,s:o,s:s,s:I,s:I,s:s,s:s,s:I,s:I,s:I,s:o,s:o,s:o,s:o}", "schema", 1, "tool", json_tool(),
                  "recipe", t->recipe, "seed", (json_int_t)seed, "epochs", (json_int_t)r.epochs, "dataset_sha256",
                  nqm_dataset_get_info(s->train).sha256, "model_sha256", nqm_model_get_info(t->model).sha256, "n_train",
                  (json_int_t)r.n_train, "n_validation", (json_int_t)r.n_validation, "steps", (json_int_t)r.n_steps,
                  "train_loss", json_number(r.train_loss), "validation_loss", json_number(r.validation_loss),
                  "validation_spearman", json_number(r.validation_spearman), "seconds_per_epoch",
                  json_number(n_timed ? r.seconds / (double)n_timed : (double)NAN)); /* unknown when all were resumed */
    exit_code = write_json(record_path, t->json, 17);
    if (exit_code == EXIT_OK)
        unlink(checkpoint);
    return exit_code;
}

static double now_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int compare_times(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Time of a score in ms per pair: the median of 7 runs over as many sampled pairs as the test set has, including
 * transform, whitening and network, as in the paper. The time does not depend on the values of the samples. */
static int time_scoring(const study *s, const nqm_model *model, double *ms_ret) {
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
        status = nqm_scorer_create(model, &options, &scorer, &err);
    for (size_t run = 0; status == NQM_OK && run < N_RUNS; ++run) {
        double begin = now_s();
        status = nqm_scorer_run_samples(scorer, n, pairs, results, &err);
        times[run] = now_s() - begin;
    }
    nqm_scorer_free(scorer);
    qsort(times, N_RUNS, sizeof times[0], compare_times);
    *ms_ret = 1000 * times[N_RUNS / 2] / (double)n;
    free(rgb);
    free(pairs);
    free(results);
    return status == NQM_OK ? EXIT_OK : report_error("reproduce", &err);
}

/* Add properties of the model and the time of a score to the training's JSON entry. */
static int describe_training(const study *s, training *t, const char *model_path) {
    const nqm_model_info m = nqm_model_get_info(t->model);
    double ms = 0;
    int exit_code = time_scoring(s, t->model, &ms);
    if (exit_code != EXIT_OK)
        return exit_code;
    const double *mean = m.whitening_mean, *std = m.whitening_std;
    return json_object_update_new(
               t->json, json_pack("{s:s,s:{s:o,s:s,s:I,s:f},s:o,s:f,s:{s:[f,f,f],s:[f,f,f]},s:{s:f,s:f,s:f,s:f}}", "id",
                                  t->id, "model", "path", json_name(model_path), "sha256", m.sha256, "parameters",
                                  (json_int_t)m.n_parameters, "megabytes",
                                  (double)m.n_parameters * sizeof(float) / (1 << 20), "training_seconds",
                                  json_number(number_at(t->json, "seconds_per_epoch") * number_at(t->json, "epochs")),
                                  "ms_per_pair", ms, "whitening", "mean", mean[0], mean[1], mean[2], "std", std[0],
                                  std[1], std[2], "targets", "mean", m.target_mean, "std", m.target_std, "jod_min",
                                  m.jod_min, "jod_max", m.jod_max)) == 0
               ? EXIT_OK
               : report("reproduce", EXIT_LIMIT, "out of memory");
}

static int train_all(study *s) {
    int exit_code = EXIT_OK;
    for (size_t i = 0; exit_code == EXIT_OK && i < s->n_recipes * s->n_seeds; ++i) {
        training *t = &s->trainings[s->n_trainings++];
        const uint64_t seed = 1 + i % s->n_seeds;
        char model_path[PATH_BYTES], record_path[PATH_BYTES];
        t->recipe = s->recipes[i / s->n_seeds];
        snprintf(t->id, sizeof t->id, "%.20s-%d", t->recipe, (int)seed);
        path_of(s, t, ".safetensors", model_path);
        path_of(s, t, ".json", record_path);
        exit_code = load_finished(s, t, model_path, record_path);
        if (exit_code == EXIT_OK && !t->json)
            exit_code = train_now(s, t, seed, model_path, record_path);
        if (exit_code == EXIT_OK)
            exit_code = describe_training(s, t, model_path);
    }
    return exit_code;
}

/* ---- evaluation -------------------------------------------------------------------------------------------------- */

/* Add one training to the bar of its recipe: the mean over the seeds of every value and interval end. */
static void add_to_bar(nqm_agreement *bar, nqm_agreement result, double n_seeds) {
    bar->n = result.n;
    bar->n_materials = result.n_materials;
    bar->n_ordered = result.n_ordered;
    for (size_t i = 0; i < N_STATISTICS; ++i) {
        nqm_estimate *sum = statistic_of(bar, i), *one = statistic_of(&result, i);
        sum->value += one->value / n_seeds;
        for (size_t k = 0; k < 2; ++k)
            sum->ci95[k] += one->ci95[k] / n_seeds;
    }
}

static int evaluate_all(study *s) {
    nqm_error err = {0};
    nqm_eval_options o = nqm_eval_options_default();
    const nqm_model *models[MAX_RECIPES * MAX_SEEDS];
    nqm_agreement results[MAX_RECIPES * MAX_SEEDS + NQM_METRIC_COUNT], *metrics = results + s->n_trainings;
    nqm_evaluation *evaluation = NULL;
    double best = -1;
    o.progress = show_progress;
    for (size_t i = 0; i < s->n_trainings; ++i)
        models[i] = s->trainings[i].model;
    nqm_status status = nqm_evaluation_create(s->test, s->n_trainings, models, &o, &evaluation, &err);
    if (status == NQM_OK)
        status = nqm_evaluation_judge(evaluation, &o, results, &err);
    nqm_evaluation_free(evaluation);
    if (status != NQM_OK)
        return report_error("reproduce", &err);
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m) {
        if (nqm_metric_get_info((nqm_metric)m).is_baseline)
            best = fmax(best, metrics[m].spearman_mean_by_material.value);
        s->bars[s->n_recipes + m] = metrics[m];
    }
    for (size_t i = 0; i < s->n_trainings; ++i) {
        training *t = &s->trainings[i];
        json_t *test = agreement_json(&results[i]);
        json_object_set_new(test, "lead", json_number(results[i].spearman_mean_by_material.value - best));
        json_object_set_new(t->json, "test", test);
        nqm_agreement *bar = &s->bars[i / s->n_seeds];
        bar->name = t->recipe;
        add_to_bar(bar, results[i], (double)s->n_seeds);
    }
    return EXIT_OK;
}

/* ---- the published values ---------------------------------------------------------------------------------------- */

/* Conditions that must be as in the paper for a comparison to be meaningful. */
enum { HUMAN_DATA = 1, TRAINING_DATA = 2, EPOCHS = 4, ALL = 7, MACHINE = 8 };
/* doc/reproduce.md says where the tolerances come from. */
static const struct {
    const char *name, *recipe, *source, *path; /* recipe "": the path starts at "regression" */
    double published, tolerance;
    int needs;
    bool at_least; /* reproduced if our value is larger */
} published[] = {
    {"JOD curve, b1", "", "label files", "b1", -14.11197, 0.005, HUMAN_DATA, false},
    {"JOD curve, b2", "", "label files", "b2", -0.47364, 0.0005, HUMAN_DATA, false},
    {"JOD curve, b3", "", "label files", "b3", -0.21480, 0.0005, HUMAN_DATA, false},
    {"training examples", "paper", "paper", "n_train", 5344, 2, TRAINING_DATA, false},
    {"validation examples", "paper", "paper", "n_validation", 668, 1, TRAINING_DATA, false},
    {"whitening, mean", "notebook", "train_info.mat", "whitening.mean.0", 0.69127, 0.05, TRAINING_DATA, false},
    {"whitening, std", "notebook", "train_info.mat", "whitening.std.0", 0.55376, 0.05, TRAINING_DATA, false},
    {"training labels, mean", "notebook", "train_info.mat", "targets.mean", 6.67318, 0.1, TRAINING_DATA, false},
    {"training labels, std", "notebook", "train_info.mat", "targets.std", 1.96393, 0.1, TRAINING_DATA, false},
    {"parameters", "paper", "paper", "model.parameters", 4171125, 0, 0, false},
    {"model size, MB", "paper", "paper", "model.megabytes", 15.91, 0.005, 0, false},
    {"Spearman, mean over materials", "paper", "paper", "test.spearman_mean_by_material", 0.67, 0.03, ALL, false},
    {"Spearman, all pairs", "paper", "paper", "test.spearman", 0.67, 0.03, ALL, false},
    {"lead over the best of the 8", "paper", "paper", "test.lead", 0, 0, ALL, true},
    {"MAE, JOD", "notebook", "notebook", "test.mae", 1.137, 0.1, ALL, false},
    {"RMSE, JOD", "notebook", "notebook", "test.rmse", 1.575, 0.1, ALL, false},
    {"R2", "notebook", "notebook", "test.r2", 0.326, 0.1, ALL, false},
    {"training, s", "paper", "paper", "training_seconds", 36, 0, MACHINE, false},
    {"score, ms a pair", "paper", "paper", "ms_per_pair", 0.04, 0, MACHINE, false},
};
enum { N_PUBLISHED = sizeof published / sizeof published[0] };

static json_t *compare_published(const study *s, size_t i) {
    double here = number_at(json_object_get(s->json, "regression"), published[i].path), sd = (double)NAN;
    size_t n = 1;
    if (*published[i].recipe)
        n = mean_at(s, published[i].recipe, published[i].path, &here, &sd);
    const int needs = published[i].needs;
    const bool other_data = ((needs & HUMAN_DATA) &&
                             (number_at(s->json, "test.n") != 180 || number_at(s->json, "test.n_materials") != 20)) ||
                            ((needs & TRAINING_DATA) && number_at(s->json, "train.n") != 3339);
    const bool is_same = published[i].at_least ? here > published[i].published
                                               : fabs(here - published[i].published) <= published[i].tolerance;
    char verdict[48];
    if (n && !(needs & MACHINE) && !other_data && (needs & EPOCHS) && s->epochs != PAPER_EPOCHS)
        snprintf(verdict, sizeof verdict, "not comparable: %d epochs", (int)s->epochs);
    else
        snprintf(verdict, sizeof verdict, "%s",
                 n == 0            ? "not run"
                 : needs & MACHINE ? "not comparable: other machine"
                 : other_data      ? "not comparable: other data"
                 : is_same         ? "reproduced"
                                   : "not reproduced");
    return json_pack("{s:s,s:s,s:s,s:f,s:f,s:b,s:o,s:o,s:s}", "name", published[i].name, "recipe", published[i].recipe,
                     "source", published[i].source, "published", published[i].published, "tolerance",
                     published[i].tolerance, "at_least", published[i].at_least, "here", json_number(here), "sd",
                     json_number(sd), "verdict", verdict);
}

/* ---- results ----------------------------------------------------------------------------------------------------- */

static const struct {
    const char *key, *title, *path;
} means[] = {{"spearman", "Spearman", "test.spearman"},
             {"spearman_mean_by_material", "by material", "test.spearman_mean_by_material"},
             {"mae", "MAE", "test.mae"},
             {"rmse", "RMSE", "test.rmse"},
             {"r2", "R2", "test.r2"},
             {"training_seconds", "training s", "training_seconds"},
             {"ms_per_pair", "ms a pair", "ms_per_pair"}};
enum { N_MEANS = sizeof means / sizeof means[0] };

/* Complete and write the JSON document, and write bars.csv with the columns of `nqm eval --csv`. */
static int write_results(study *s) {
    char path[PATH_BYTES];
    output_file out;
    json_t *trainings = json_array(), *recipes = json_array(), *results = json_array(), *list = json_array();
    snprintf(path, sizeof path, "%s/bars.csv", s->output);
    int exit_code = open_output("reproduce", path, &out);
    if (exit_code == EXIT_OK)
        fprintf(out.stream, "%s,best_of_family\n", agreement_columns);
    for (size_t i = 0; i < s->n_trainings; ++i)
        json_array_append(trainings, s->trainings[i].json);
    for (size_t r = 0; r < s->n_recipes; ++r) {
        json_t *recipe = json_pack("{s:s,s:I}", "recipe", s->recipes[r], "seeds", (json_int_t)s->n_seeds);
        for (size_t k = 0; k < N_MEANS; ++k) {
            double mean, sd;
            mean_at(s, s->recipes[r], means[k].path, &mean, &sd);
            json_object_set_new(recipe, means[k].key,
                                json_pack("{s:o,s:o}", "mean", json_number(mean), "sd", json_number(sd)));
        }
        json_array_append_new(recipes, recipe);
    }
    for (size_t i = 0; i < s->n_recipes + NQM_METRIC_COUNT; ++i) {
        const char *type = i < s->n_recipes ? "model" : "metric";
        json_t *bar = agreement_json(&s->bars[i]);
        json_object_update_new(bar, json_pack("{s:s,s:b}", "type", type, "best_of_family", s->bars[i].best_of_family));
        json_array_append_new(results, bar);
        if (exit_code == EXIT_OK) {
            print_csv_agreement(out.stream, "all", "all", type, &s->bars[i]);
            fprintf(out.stream, ",%d\n", s->bars[i].best_of_family);
        }
    }
    for (size_t i = 0; i < N_PUBLISHED; ++i)
        json_array_append_new(list, compare_published(s, i));
    json_object_update_new(s->json, json_pack("{s:o,s:o,s:o,s:o}", "trainings", trainings, "recipes", recipes,
                                              "results", results, "figures", list));
    if (exit_code == EXIT_OK)
        exit_code = close_output("reproduce", &out, true);
    snprintf(path, sizeof path, "%s/reproduce.json", s->output);
    return exit_code == EXIT_OK ? write_json(path, s->json, 9) : exit_code;
}

/* ---- text -------------------------------------------------------------------------------------------------------- */

static void print_cell(double value, int width, const char *format) {
    char text[32] = "-";
    if (isfinite(value))
        snprintf(text, sizeof text, format, value);
    printf(" %*s", width, text);
}

static void print_trainings(const study *s) {
    static const char *const whitening[] = {"whitening.mean.0", "whitening.mean.1", "whitening.mean.2",
                                            "whitening.std.0",  "whitening.std.1",  "whitening.std.2"};
    printf("\n%-12s %6s %9s %7s %10s %10s %9s  %s\n", "training", "epochs", "examples", "loss", "validation",
           "training s", "ms a pair", "whitening mean R G B, std R G B");
    for (size_t i = 0; i < s->n_trainings; ++i) {
        const json_t *t = s->trainings[i].json;
        printf("%-12s", s->trainings[i].id);
        print_cell(number_at(t, "epochs"), 6, "%.0f");
        print_cell(number_at(t, "n_train"), 9, "%.0f");
        print_cell(number_at(t, "train_loss"), 7, "%.4f");
        print_cell(number_at(t, "validation_loss"), 10, "%.4f");
        print_cell(number_at(t, "training_seconds"), 10, "%.1f");
        print_cell(number_at(t, "ms_per_pair"), 9, "%.4f");
        for (size_t k = 0; k < 6; ++k)
            print_cell(number_at(t, whitening[k]), k ? 6 : 7, "%.4f");
        putchar('\n');
    }
}

static void print_tested(const char *name, bool is_best, const json_t *test) {
    static const char *const rows[2][2] = {{"spearman", "ci95"},
                                           {"spearman_mean_by_material", "ci95_mean_by_material"}};
    printf("%-12s%-2s", name, is_best ? "*" : "");
    for (size_t k = 0; k < 2; ++k) {
        const json_t *ci95 = json_object_get(test, rows[k][1]);
        print_interval(&(nqm_estimate){number_at(test, rows[k][0]), {number_at(ci95, "0"), number_at(ci95, "1")}});
    }
    print_number(number_at(test, "mae"));
    print_number(number_at(test, "rmse"));
    print_number(number_at(test, "r2"));
    putchar('\n');
}

static int print_study(const study *s) {
    end_progress();
    printf("training  %s, %s: %.0f rows of %.0f materials\n", s->path[TRAIN_FOLDER], s->path[TRAIN_LABELS],
           number_at(s->json, "train.n"), number_at(s->json, "train.n_materials"));
    printf("test      %s, %s: %.0f human scores of %.0f materials, %.0f directions\n", s->path[TEST_FOLDER],
           s->path[TEST_LABELS], number_at(s->json, "test.n"), number_at(s->json, "test.n_materials"),
           number_at(s->json, "test.n_directions"));
    const json_t *r = json_object_get(s->json, "regression");
    printf("curve     b1 %.5f, b2 %.5f, b3 %.5f; RMSE %.4f JOD, Spearman of Delta-E with JOD %.4f, n %.0f\n",
           number_at(r, "b1"), number_at(r, "b2"), number_at(r, "b3"), number_at(r, "rmse"), number_at(r, "spearman"),
           number_at(r, "n"));
    print_trainings(s);
    printf("\n%-14s  %-22s  %-22s %7s %7s %7s\n", "test", "Spearman [95 %]", "mean over materials", "MAE", "RMSE",
           "R2");
    for (size_t i = 0; i < s->n_trainings; ++i)
        print_tested(s->trainings[i].id, false, json_object_get(s->trainings[i].json, "test"));
    for (size_t i = s->n_recipes; i < s->n_recipes + NQM_METRIC_COUNT; ++i)
        print_tested(s->bars[i].name, s->bars[i].best_of_family,
                     json_array_get(json_object_get(s->json, "results"), i));
    printf("* best of its family\n\n%-12s %5s", "mean (sd)", "seeds");
    for (size_t k = 0; k < N_MEANS; ++k)
        printf(" %16s", means[k].title);
    for (size_t i = 0; i < s->n_recipes; ++i) {
        printf("\n%-12s %5zu", s->recipes[i], (size_t)s->n_seeds);
        for (size_t k = 0; k < N_MEANS; ++k) {
            double mean, sd;
            char text[48];
            mean_at(s, s->recipes[i], means[k].path, &mean, &sd);
            snprintf(text, sizeof text, isfinite(sd) ? "%.4g (%.2g)" : "%.4g", mean, sd);
            printf(" %16s", isfinite(mean) ? text : "-");
        }
    }
    printf("\n\n%-30s %-9s %-15s %10s %9s %10s  %s\n", "published", "recipe", "source", "value", "tolerance", "here",
           "verdict");
    for (size_t i = 0; i < N_PUBLISHED; ++i) {
        const json_t *row = json_array_get(json_object_get(s->json, "figures"), i);
        const double here = number_at(row, "here");
        printf("%-30s %-9s %-15s", published[i].name, published[i].recipe, published[i].source);
        print_cell(published[i].published, 10, published[i].at_least ? "> %g" : "%.7g");
        print_cell(published[i].tolerance > 0 ? published[i].tolerance : (double)NAN, 9, "%g");
        print_cell(here, 10, fabs(here) >= 1e4 ? "%.0f" : "%.6g");
        printf("  %s\n", json_string_value(json_object_get(row, "verdict")));
    }
    printf("\n%s: models, losses, bars.csv, reproduce.json\n", s->output);
    return fflush(stdout) == 0 ? EXIT_OK : report("reproduce", EXIT_OPEN, "standard output: %s", strerror(errno));
}

/* ---- command ----------------------------------------------------------------------------------------------------- */

static int run_study(study *s, bool as_json) {
    int (*const steps[])(study *) = {find_data, load_data, train_all, evaluate_all, write_results};
    int exit_code = EXIT_OK;
    for (size_t i = 0; exit_code == EXIT_OK && i < sizeof steps / sizeof *steps; ++i)
        exit_code = steps[i](s);
    if (exit_code == EXIT_OK)
        exit_code = as_json ? print_json(json_incref(s->json)) : print_study(s);
    for (size_t i = 0; i < s->n_trainings; ++i) {
        nqm_model_free(s->trainings[i].model);
        json_decref(s->trainings[i].json);
    }
    json_decref(s->json);
    nqm_dataset_free(s->train);
    nqm_dataset_free(s->test);
    return exit_code;
}

/* Parse a list like "paper,notebook" without repetitions. Modifies the list. */
static int parse_recipes(char *list, study *s) {
    for (char *name = strtok(list, ","); name; name = strtok(NULL, ",")) {
        nqm_train_options unused;
        nqm_error err = {0};
        if (nqm_train_options_recipe(name, &unused, &err) != NQM_OK)
            return report_error("reproduce", &err);
        for (size_t i = 0; i < s->n_recipes; ++i)
            if (strcmp(s->recipes[i], name) == 0)
                return report("reproduce", EXIT_USAGE, "recipe '%s' is named twice", name);
        s->recipes[s->n_recipes++] = name; /* distinct names of recipes: at most MAX_RECIPES */
    }
    return s->n_recipes ? EXIT_OK : report("reproduce", EXIT_USAGE, "--recipes names no recipe");
}

int cmd_reproduce(int argc, char **argv) {
    study *s = calloc(1, sizeof *s);
    if (!s)
        return report("reproduce", EXIT_LIMIT, "out of memory");
    const char *recipes = "paper,notebook";
    bool json = false;
    s->output = "reproduce";
    s->n_seeds = 3;
    s->epochs = PAPER_EPOCHS;
    const option options[] = {
        {"output", 'o', OPTION_TEXT, &s->output, "DIR", "folder for models, checkpoints and results", 0, 0},
        {"recipes", 0, OPTION_TEXT, &recipes, "LIST", "paper, notebook, nqm, with commas", 0, 0},
        {"seeds", 0, OPTION_COUNT, &s->n_seeds, "N", "trainings of each recipe, with seeds 1 to N", 1, MAX_SEEDS},
        {"epochs", 0, OPTION_COUNT, &s->epochs, "N", "of each training; 100 in the paper", 1, 100000},
        {"train", 0, OPTION_TEXT, &s->given[TRAIN_FOLDER], "FOLDER", "training samples, if not DIR/uniform_rand_500", 0,
         0},
        {"train-labels", 0, OPTION_TEXT, &s->given[TRAIN_LABELS], "CSV",
         "their labels, if not labels_balanced_train.csv in DIR or DIR/data", 0, 0},
        {"test", 0, OPTION_TEXT, &s->given[TEST_FOLDER], "FOLDER", "test samples, if not DIR/test", 0, 0},
        {"test-labels", 0, OPTION_TEXT, &s->given[TEST_LABELS], "CSV",
         "the human scores, if not labels_real.csv in DIR or DIR/data", 0, 0},
        {"json", 0, OPTION_FLAG, &json, NULL, "print JSON (it is also written to reproduce.json)", 0, 0},
        {0}};
    const command cmd = {
        .name = "reproduce",
        .usage = "DIR [options]",
        .about =
            "Run the whole study of the paper on the data of its authors (DIR, in their layout: doc/reproduce.md):\n"
            "the JOD curve from the human scores, trainings of each recipe, their test on the human scores with\n"
            "the metrics, and a table that compares the results with the published ones. After an interruption\n"
            "(Ctrl-C) the same command continues.",
        .example = "nqm reproduce authors-data -o study\nnqm reproduce authors-data --seeds 5 --recipes paper --json",
        .options = options,
        .min_arguments = 1,
        .max_arguments = 1,
    };
    int n_arguments, exit_code;
    if (parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code)) {
        s->root = argv[0];
        char *list = strdup(recipes);
        exit_code = list ? parse_recipes(list, s) : report("reproduce", EXIT_LIMIT, "out of memory");
        if (exit_code == EXIT_OK)
            exit_code = run_study(s, json);
        free(list);
    }
    free(s);
    return exit_code;
}
