/* SPDX-License-Identifier: MIT
 *
 * nqm reproduce, one training: files of a former run are used again when they belong to the same data and options. A
 * finished training leaves its model and a record, an interrupted one its checkpoint.
 */
#include "nqm/judge/reproduce.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

static void path_of(const study *s, const study_training *t, const char *ending, char path[STUDY_PATH_BYTES]) {
    snprintf(path, STUDY_PATH_BYTES, "%s/%s%s", s->options->output, t->id, ending);
}

/* ---- the record -------------------------------------------------------------------------------------------------- */

static int write_record(const study *s, const study_training *t, const char *path) {
    const nqm_train_report *r = &t->report;
    output_file out;
    int exit_code = open_output("reproduce", path, &out);
    if (exit_code != EXIT_OK)
        return exit_code;
    json_t *json =
        json_pack("{s:i,s:o,s:s,s:I,s:I,s:s,s:s,s:I,s:I,s:I,s:o,s:o,s:o,s:o}", "schema", 1, "tool", json_tool(),
                  "recipe", t->recipe, "seed", (json_int_t)t->seed, "epochs", (json_int_t)r->epochs, "dataset_sha256",
                  nqm_dataset_get_info(s->train).sha256, "model_sha256", nqm_model_get_info(t->model).sha256, "n_train",
                  (json_int_t)r->n_train, "n_validation", (json_int_t)r->n_validation, "steps", (json_int_t)r->n_steps,
                  "train_loss", json_number(r->train_loss), "validation_loss", json_number(r->validation_loss),
                  "validation_spearman", json_number(r->validation_spearman), "seconds_per_epoch",
                  json_number(t->seconds_per_epoch));
    bool ok = json && json_dumpf(json, out.stream, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) == 0;
    json_decref(json);
    if (!ok)
        report("reproduce", EXIT_OPEN, "%s: cannot write", path);
    exit_code = close_output("reproduce", &out, ok);
    return ok ? exit_code : EXIT_OPEN;
}

static double number_in(const json_t *json, const char *key) {
    const json_t *value = json_object_get(json, key);
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

static size_t count_in(const json_t *json, const char *key) {
    json_int_t value = json_integer_value(json_object_get(json, key));
    return value > 0 ? (size_t)value : 0;
}

static bool text_is(const json_t *json, const char *key, const char *expected) {
    const char *text = json_string_value(json_object_get(json, key));
    return text && strcmp(text, expected) == 0;
}

/* A finished training of a former run; *found tells. One of other data or options is not overwritten. */
static int load_finished(const study *s, study_training *t, const char *record_path, bool *found) {
    *found = false;
    json_error_t json_err;
    json_t *json = access(record_path, F_OK) == 0 ? json_load_file(record_path, 0, &json_err) : NULL;
    if (!json)
        return EXIT_OK;
    int exit_code = EXIT_OK;
    if (!text_is(json, "dataset_sha256", nqm_dataset_get_info(s->train).sha256) ||
        count_in(json, "epochs") != s->options->epochs || !text_is(json, "recipe", t->recipe))
        exit_code = report("reproduce", EXIT_INCOMPATIBLE,
                           "%s tells of a training on other data or with other options: choose another folder (-o)",
                           record_path);
    else if (access(t->model_path, F_OK) == 0)
        exit_code = open_model("reproduce", t->model_path, &t->model);
    if (t->model && text_is(json, "model_sha256", nqm_model_get_info(t->model).sha256)) {
        t->report = (nqm_train_report){.n_train = count_in(json, "n_train"),
                                       .n_validation = count_in(json, "n_validation"),
                                       .n_steps = count_in(json, "steps"),
                                       .epochs = count_in(json, "epochs"),
                                       .epochs_resumed = count_in(json, "epochs"),
                                       .train_loss = number_in(json, "train_loss"),
                                       .validation_loss = number_in(json, "validation_loss"),
                                       .validation_spearman = number_in(json, "validation_spearman")};
        t->seconds_per_epoch = number_in(json, "seconds_per_epoch");
        *found = true;
    } else {
        nqm_model_free(t->model);
        t->model = NULL;
    }
    json_decref(json);
    return exit_code;
}

/* ---- training ---------------------------------------------------------------------------------------------------- */

typedef struct epoch_log {
    const study_training *training;
    FILE *stream;
} epoch_log;

static void on_epoch(void *user, size_t epoch, double train_loss, double validation_loss, double lr_first) {
    epoch_log *log = user;
    note_progress("%s, epoch %zu: loss %.4f, validation %.4f", log->training->id, epoch, train_loss, validation_loss);
    fprintf(log->stream, "%zu,%.9g,%.9g,%.9g\n", epoch, train_loss, validation_loss, lr_first);
}

/* The model file, read back: what is judged is what was kept. */
static int keep_model(const study *s, study_training *t, nqm_model *trained, const char *record_path) {
    nqm_error err = {0};
    if (nqm_model_save(trained, t->model_path, &err) != NQM_OK)
        return report_error("reproduce", &err);
    int exit_code = open_model("reproduce", t->model_path, &t->model);
    return exit_code == EXIT_OK ? write_record(s, t, record_path) : exit_code;
}

static int train_now(const study *s, study_training *t, const char *record_path) {
    char checkpoint[STUDY_PATH_BYTES], log_path[STUDY_PATH_BYTES];
    nqm_error err = {0};
    nqm_train_options o;
    if (nqm_train_options_recipe(t->recipe, &o, &err) != NQM_OK)
        return report_error("reproduce", &err);
    path_of(s, t, ".checkpoint", checkpoint);
    path_of(s, t, "-loss.csv", log_path);
    output_file log;
    int exit_code = open_output("reproduce", log_path, &log);
    if (exit_code != EXIT_OK)
        return exit_code;
    fputs("epoch,train_loss,validation_loss,lr_first\n", log.stream);
    epoch_log epochs = {t, log.stream};
    o.id = t->id;
    o.optimiser.seed = t->seed;
    o.optimiser.epochs = (size_t)s->options->epochs;
    o.run.checkpoint = checkpoint;
    o.run.resume = access(checkpoint, F_OK) == 0;
    o.run.progress = show_progress;
    o.run.epoch_done = on_epoch;
    o.run.epoch_user = &epochs;
    nqm_model *trained = NULL;
    if (nqm_train(s->train, &o, &trained, &t->report, &err) != NQM_OK)
        exit_code = report_error("reproduce", &err);
    if (exit_code == EXIT_INTERRUPTED)
        report("reproduce", exit_code, "the same command again goes on from there");
    size_t n_timed = t->report.epochs - t->report.epochs_resumed;
    t->seconds_per_epoch = n_timed ? t->report.seconds / (double)n_timed : (double)NAN;
    if (exit_code == EXIT_OK)
        exit_code = keep_model(s, t, trained, record_path);
    nqm_model_free(trained);
    int log_code = close_output("reproduce", &log, exit_code == EXIT_OK);
    if (exit_code == EXIT_OK)
        unlink(checkpoint);
    return exit_code == EXIT_OK ? log_code : exit_code;
}

int study_train(study *s, study_training *t) {
    char record_path[STUDY_PATH_BYTES];
    bool found = false;
    snprintf(t->id, sizeof t->id, "%.20s-%d", t->recipe, (int)t->seed);
    path_of(s, t, ".safetensors", t->model_path);
    path_of(s, t, ".json", record_path);
    int exit_code = load_finished(s, t, record_path, &found);
    return exit_code == EXIT_OK && !found ? train_now(s, t, record_path) : exit_code;
}
