/* SPDX-License-Identifier: MIT
 *
 * The training loop (paper, section 3.2): log-cosh loss, Adam with L2, two learning rates, dropout, plateau schedule.
 * The same dataset, options and seed give the same model, in one run or in several, on any number of threads.
 */
#include "train/train.h"
#include "io/json.h"
#include "math/math.h"
#include "metric/metric.h"
#include "percept/percept.h"
#include "train/calibrate.h"

#include <math.h>
#include <string.h>

/* State and buffers of one call of nqm_train(). */
typedef struct run {
    const nqm_dataset *dataset;
    const nqm_train_options *options;
    nqm_examples examples;
    nqm_training state;
    nqm_trainer *trainer;
    size_t *order;          /* (n_train); owns the arrays below and state.history */
    float *target, *z, *dz; /* (batch, n_outputs) */
    nqm_ticker ticker;
    nqm_output_bounds bounds[1 + NQM_LABEL_PARTS];
    size_t steps_per_epoch, epochs_resumed;
    uint64_t dropout_seed;
} run;

static nqm_net_shape shape_of(const nqm_train_options *o, size_t n_inputs, size_t n_outputs) {
    nqm_net_shape shape = {.n_layers = o->network.n_hidden + 1, .sizes = {n_inputs}};
    for (size_t i = 0; i < o->network.n_hidden; ++i)
        shape.sizes[i + 1] = o->network.hidden[i];
    shape.sizes[o->network.n_hidden + 1] = n_outputs;
    return shape;
}

static nqm_status alloc_run(run *r, nqm_error *err) {
    const nqm_train_options *o = r->options;
    nqm_net_shape shape = shape_of(o, r->examples.width, r->examples.n_outputs);
    const nqm_trainer_options options = {.precision = o->optimiser.precision, .max_batch = o->optimiser.batch};
    nqm_status status = nqm_params_create(&shape, &r->state.params, err);
    if (status == NQM_OK && o->run.checkpoint)
        status = nqm_adam_create(&shape, &r->state.adam, err);
    if (status == NQM_OK)
        status = nqm_trainer_create(&shape, &options, &r->trainer, err);
    if (status != NQM_OK)
        return status;
    const size_t batch = o->optimiser.batch, n_values = batch * r->examples.n_outputs;
    for (size_t i = 0; i < r->examples.n_outputs; ++i)
        r->bounds[i] =
            (nqm_output_bounds){r->examples.output[i].lo, r->examples.output[i].hi, i ? o->labels.parts_weight : 1};
    r->state.max_epochs = o->optimiser.epochs;
    return nqm_alloc_arrays(NQM_ARRAYS({&r->order, r->examples.n_train, sizeof *r->order},
                                       {&r->target, n_values, sizeof(float)}, {&r->z, n_values, sizeof(float)},
                                       {&r->dz, n_values, sizeof(float)},
                                       {&r->state.history, r->state.max_epochs, sizeof *r->state.history}),
                            err);
}

static void release(run *r) {
    nqm_examples_free(&r->examples);
    nqm_params_free(&r->state.params);
    nqm_adam_free(&r->state.adam);
    nqm_trainer_free(r->trainer);
    nqm_free(r->order);
}

static void begin_state(run *r) {
    const nqm_train_options *o = r->options;
    nqm_params_init(&r->state.params, nqm_hash_u64(o->optimiser.seed, NQM_STREAM_INIT));
    r->state.plateau = (nqm_plateau){
        .factor = o->optimiser.plateau_factor, .patience = o->optimiser.plateau_patience, .best = INFINITY};
    r->state.lr_first = o->optimiser.lr_first;
    r->state.lr_deeper = o->optimiser.lr_deeper;
    nqm_trainer_load(r->trainer, &r->state.params, NULL);
}

/* ---- epochs ------------------------------------------------------------------------------------------------------ */

/* Shuffle the examples; the order depends only on the seed and the epoch. */
static void shuffle(run *r) {
    for (size_t i = 0; i < r->examples.n_train; ++i)
        r->order[i] = i;
    nqm_rng rng = nqm_rng_make(nqm_hash_u64(r->options->optimiser.seed, NQM_STREAM_SHUFFLE), r->state.epoch);
    nqm_rng_shuffle(&rng, r->examples.n_train, r->order);
}

/* One optimiser step on n examples; returns their mean loss before the step. */
static double step(run *r, size_t n, const size_t *index) {
    const nqm_train_options *o = r->options;
    const nqm_dropout dropout = {
        .p = o->network.dropout, .seed = r->dropout_seed, .step = nqm_trainer_steps(r->trainer)};
    const nqm_step_rates rates = {.lr_first = r->state.lr_first,
                                  .lr_deeper = r->state.lr_deeper,
                                  .weight_decay = o->optimiser.weight_decay,
                                  .freeze_first_layernorm = o->network.freeze_first_layernorm != 0};
    nqm_examples_gather(&r->examples, n, index, 0, r->trainer, r->target);
    nqm_trainer_forward(r->trainer, n, &dropout, r->z);
    double loss = nqm_logcosh_loss(n, r->examples.n_outputs, r->bounds, r->z, r->target, r->dz);
    nqm_trainer_step(r->trainer, n, r->dz, &rates);
    return loss;
}

static nqm_status train_epoch(run *r, double *loss_ret, nqm_error *err) {
    size_t n_train = r->examples.n_train, batch = r->options->optimiser.batch;
    double sum = 0;
    shuffle(r);
    for (size_t first = 0, k = 1; first < n_train; first += batch, ++k) {
        size_t n = nqm_smaller(n_train - first, batch);
        double loss = step(r, n, r->order + first);
        if (!isfinite(loss))
            return nqm_fail(err, NQM_ERR_NUMERIC, -1,
                            "the loss stopped being finite in epoch %zu, step %zu; try a lower learning rate",
                            r->state.epoch + 1, k);
        sum += loss * (double)n;
        const double done = (double)r->state.epoch + (double)k / (double)r->steps_per_epoch;
        if (nqm_tick(&r->ticker, "train", done, (double)r->options->optimiser.epochs))
            return nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted in epoch %zu%s%s", r->state.epoch + 1,
                            r->options->run.checkpoint ? "; go on with the checkpoint " : "",
                            r->options->run.checkpoint ? r->options->run.checkpoint : "");
    }
    *loss_ret = sum / (double)n_train;
    return NQM_OK;
}

/* Mean loss of the validation examples; z_ret (n_validation, n_outputs) receives the network's outputs, NULL allowed. */
static double validate(run *r, float *z_ret) {
    size_t n_validation = r->examples.rows.n_validation, batch = r->options->optimiser.batch;
    double sum = 0;
    for (size_t first = 0; first < n_validation; first += batch) {
        size_t n = nqm_smaller(n_validation - first, batch);
        nqm_examples_gather(&r->examples, n, NULL, first, r->trainer, r->target);
        nqm_trainer_forward(r->trainer, n, NULL, r->z);
        sum += (double)n * nqm_logcosh_loss(n, r->examples.n_outputs, r->bounds, r->z, r->target, NULL);
        if (z_ret)
            memcpy(z_ret + first * r->examples.n_outputs, r->z, n * r->examples.n_outputs * sizeof *z_ret);
    }
    return sum / (double)n_validation;
}

static void report_epoch(const run *r, size_t epoch) {
    const nqm_train_options *o = r->options;
    const nqm_epoch *e = &r->state.history[epoch];
    if (o->run.epoch_done)
        o->run.epoch_done(o->run.epoch_user, epoch + 1, e->train_loss, e->validation_loss, e->lr_first);
}

static nqm_status run_epoch(run *r, nqm_error *err) {
    nqm_training *s = &r->state;
    const nqm_train_options *o = r->options;
    double loss = 0;
    if (o->optimiser.schedule == NQM_SCHEDULE_COSINE) {
        s->lr_first = o->optimiser.lr_first * nqm_cosine_factor(s->epoch, o->optimiser.epochs);
        s->lr_deeper = o->optimiser.lr_deeper * nqm_cosine_factor(s->epoch, o->optimiser.epochs);
    }
    nqm_status status = train_epoch(r, &loss, err);
    if (status != NQM_OK)
        return status;
    nqm_epoch *e = &s->history[s->epoch];
    *e = (nqm_epoch){.train_loss = loss, .validation_loss = validate(r, NULL), .lr_first = s->lr_first};
    if (!isfinite(e->validation_loss))
        return nqm_fail(err, NQM_ERR_NUMERIC, -1, "the validation loss stopped being finite in epoch %zu",
                        s->epoch + 1);
    if (o->optimiser.schedule == NQM_SCHEDULE_PLATEAU) {
        double factor = nqm_plateau_step(&s->plateau, e->validation_loss);
        s->lr_first = nqm_plateau_rate(s->lr_first, factor);
        s->lr_deeper = nqm_plateau_rate(s->lr_deeper, factor);
    }
    s->epoch++;
    if (o->run.checkpoint) {
        nqm_trainer_store(r->trainer, &s->params, &s->adam);
        status = nqm_checkpoint_write(s, o, r->dataset->sha256, err);
    }
    report_epoch(r, s->epoch - 1);
    return status;
}

static nqm_status run_epochs(run *r, nqm_error *err) {
    const nqm_train_options *o = r->options;
    nqm_status status = NQM_OK;
    if (o->run.resume)
        status = nqm_checkpoint_read(&r->state, o, r->dataset->sha256, err);
    if (status == NQM_OK && o->run.resume)
        nqm_trainer_load(r->trainer, &r->state.params, &r->state.adam);
    r->epochs_resumed = r->state.epoch;
    for (size_t i = 0; status == NQM_OK && i < r->state.epoch; ++i)
        report_epoch(r, i);
    while (status == NQM_OK && r->state.epoch < o->optimiser.epochs)
        status = run_epoch(r, err);
    return status;
}

/* ---- the model --------------------------------------------------------------------------------------------------- */

/* Set all members of the model except the texts. The parameters are moved from the run to the model. */
static nqm_status fill_model(run *r, struct nqm_model *m, nqm_error *err) {
    const nqm_examples *e = &r->examples;
    const nqm_directions *directions = r->dataset->directions;
    nqm_trainer_store(r->trainer, &r->state.params, NULL);
    m->params = r->state.params;
    r->state.params = (nqm_params){0};
    m->features = e->features;
    m->scalars = e->scalar_whitening;
    m->target = r->options->labels.target;
    m->output = e->output[0];
    memcpy(m->parts, e->output + 1, (e->n_outputs - 1) * sizeof *m->parts);
    m->curve = nqm_curve_published;
    if (e->estimate) {
        const nqm_transport transport = nqm_dataset_transport(r->dataset);
        nqm_status status = nqm_model_set_transport(m, &transport, err);
        if (status != NQM_OK)
            return status;
    }
    m->scalar_names = r->options->input.scalars ? nqm_scalar_names() : NULL;
    if (r->options->input.scalars && !m->scalar_names)
        return nqm_fail_nomem(err, NQM_SCALAR_COUNT);
    return nqm_directions_from_degrees(directions->n, directions->degrees, &m->directions, err);
}

/* Evaluate the outputs z of the validation examples without noisy copies: Spearman of the predicted JOD with the
 * labels, and the intervals, if the materials were not used in training and there are enough of them. */
static nqm_status judge_validation(const run *r, struct nqm_model *m, const float *z, nqm_train_report *report,
                                   nqm_error *err) {
    const nqm_rows *rows = &r->examples.rows;
    const nqm_dataset *d = r->dataset;
    nqm_residuals residuals;
    nqm_status status = nqm_residuals_create(d, rows->n_validation, &residuals, err);
    for (size_t i = 0; status == NQM_OK && i < rows->n_validation; ++i) {
        const nqm_row *row = &rows->row[rows->n_train + i];
        const nqm_label *estimate = r->examples.estimate ? &r->examples.estimate[row->pair] : NULL;
        if (!row->copy)
            nqm_residuals_add(&residuals, d, row->pair,
                              nqm_model_jod(m, (double)z[i * r->examples.n_outputs], estimate, NULL));
    }
    if (status == NQM_OK)
        report->validation_spearman = nqm_spearman(residuals.n, residuals.predicted, residuals.label);
    if (status == NQM_OK && !r->options->split.by_pair && nqm_residuals_suffice(&residuals, NULL))
        status = nqm_model_set_interval(m, d, true, &residuals, &report->calibration, err);
    nqm_free(residuals.predicted);
    return status;
}

/* Options and results of the training as JSON, without times, so that equal trainings give equal files. */
static char *training_text(const run *r, const nqm_train_report *report) {
    json_t *json = json_pack("{s:s, s:o, s:I, s:I, s:I, s:I, s:f, s:f, s:s}", "nqm", nqm_version(), "options",
                             nqm_train_options_json(r->options), "epochs", (json_int_t)report->epochs, "steps",
                             (json_int_t)report->n_steps, "n_train", (json_int_t)report->n_train, "n_validation",
                             (json_int_t)report->n_validation, "train_loss", report->train_loss, "validation_loss",
                             report->validation_loss, "dataset_sha256", r->dataset->sha256);
    if (json && isfinite(report->validation_spearman) &&
        json_object_set_new(json, "validation_spearman", json_real(report->validation_spearman)) != 0) {
        json_decref(json);
        return NULL;
    }
    return nqm_json_text(json, 9);
}

static nqm_status name_model(const run *r, struct nqm_model *m, const nqm_train_report *report, nqm_error *err) {
    const nqm_train_options *o = r->options;
    m->id = nqm_strdup(o->id);
    m->recipe = nqm_strdup(o->recipe);
    m->licence = nqm_strdup(o->licence ? o->licence : "");
    m->manifest_sha256 = nqm_strdup(r->dataset->sha256);
    m->training = training_text(r, report);
    char *card = m->id && m->recipe ? nqm_model_card(r->dataset, o, report, m) : NULL;
    bool calibrated = report->calibration.n_materials > 0;
    m->card = card && calibrated ? nqm_card_with_interval(card, &report->calibration, r->dataset->sha256) : card;
    if (calibrated)
        nqm_free(card);
    bool ok = m->licence && m->manifest_sha256 && m->training && m->card;
    return ok ? NQM_OK : nqm_fail_nomem(err, 0);
}

static nqm_status conclude(run *r, nqm_train_report *report, nqm_model **model_ret, nqm_error *err) {
    struct nqm_model *m = nqm_alloc(1, sizeof *m);
    float *z = nqm_alloc(r->examples.rows.n_validation, r->examples.n_outputs * sizeof *z);
    nqm_status status = m && z ? NQM_OK : nqm_fail_nomem(err, sizeof *m);
    if (status == NQM_OK) {
        validate(r, z);
        status = fill_model(r, m, err);
    }
    if (status == NQM_OK) {
        const nqm_epoch *last = &r->state.history[r->state.epoch - 1];
        report->n_train = r->examples.n_train;
        report->n_validation = r->examples.rows.n_validation;
        report->n_steps = (size_t)nqm_trainer_steps(r->trainer);
        report->epochs = r->state.epoch;
        report->epochs_resumed = r->epochs_resumed;
        report->train_loss = last->train_loss;
        report->validation_loss = last->validation_loss;
        status = judge_validation(r, m, z, report, err);
    }
    if (status == NQM_OK)
        status = name_model(r, m, report, err);
    if (status == NQM_OK)
        status = nqm_golden_make(m, &m->golden, err);
    nqm_free(z);
    if (status == NQM_OK)
        *model_ret = m;
    else if (m)
        nqm_model_free(m);
    return status;
}

nqm_status nqm_train(const nqm_dataset *dataset, const nqm_train_options *options, nqm_model **model_ret,
                     nqm_train_report *report_ret, nqm_error *err) {
    NQM_MAKE(err, model_ret, dataset, options);
    double begin_s = nqm_clock_s();
    nqm_status status = nqm_train_options_check(options, err);
    if (status == NQM_OK)
        status = nqm_dataset_check_isotropic(dataset, err);
    if (status != NQM_OK)
        return status;
    run r = {.dataset = dataset, .options = options};
    nqm_train_report report = {0};
    r.ticker = (nqm_ticker){.fn = options->run.progress, .user = options->run.progress_user};
    r.dropout_seed = nqm_hash_u64(options->optimiser.seed, NQM_STREAM_DROPOUT);
    status = nqm_examples_create(dataset, options, options->optimiser.batch, &r.examples, err);
    if (status == NQM_OK)
        status = alloc_run(&r, err);
    if (status == NQM_OK) {
        r.steps_per_epoch = (r.examples.n_train + options->optimiser.batch - 1) / options->optimiser.batch;
        begin_state(&r);
        status = run_epochs(&r, err);
    }
    if (status == NQM_OK)
        status = conclude(&r, &report, model_ret, err);
    release(&r);
    report.seconds = nqm_clock_s() - begin_s;
    if (status == NQM_OK && report_ret)
        *report_ret = report;
    return status;
}
