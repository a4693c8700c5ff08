/* SPDX-License-Identifier: MIT
 *
 * Predictions of models, of the nine scalar metrics and of light transport for the pairs of a dataset. evaluate_judge.c judges
 * selections of them.
 */
#include "judge/judge.h"
#include "kernel/kernel.h"
#include "metric/metric.h"

#include <math.h>
#include <string.h>

#define FIELD(name) .key = #name, .offset = offsetof(nqm_eval_options, name)

const char *const nqm_split_words[] = {"train", "validation", "test", "all", NULL};

/* clang-format off */
static const nqm_option rows[] = {
    {FIELD(split), .kind = NQM_OPTION_ENUM, .metavar = "WORD", .words = nqm_split_words, .values = {"all"},
     .help = "pairs to judge"},
    {FIELD(order_margin), .name = "", .min = 0, .max = 1e9, .values = {"0.25"}},
    {FIELD(n_bootstrap), .name = "bootstrap", .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 0, .max = 1e6,
     .values = {"1000"}, .help = "resamples of the materials for intervals; 0: none"},
    {FIELD(seed), .kind = NQM_OPTION_U64, .metavar = "N", .values = {"1"}, .help = "seed of the resampling"},
    {FIELD(apart), .kind = NQM_OPTION_BOOL, .off_name = "",
     .help = "with --human: judge models by the similarity of materials that are seen apart"},
};
/* clang-format on */

const nqm_option_table nqm_eval_option_table = {rows, sizeof rows / sizeof *rows, NULL};

NQM_OPTIONS_DEFAULT(nqm_eval_option, .jod_to = INFINITY)

/* ---- predictors -------------------------------------------------------------------------------------------------- */

typedef struct predict_run {
    nqm_evaluation *ev;
    bool apart;    /* judge by the similarity where a model has it */
    size_t n;      /* number of pairs to predict */
    size_t *pairs; /* (n) */
    nqm_ticker ticker;
    double done; /* progress: a pair counts once per model and once for all metrics */
} predict_run;

static nqm_status tick(void *user, size_t n, nqm_error *err) {
    predict_run *run = user;
    run->done += (double)n;
    if (nqm_tick(&run->ticker, "evaluate", run->done, (double)run->n * (double)(run->ev->n_models + 1)))
        return nqm_fail(err, NQM_ERR_CANCELLED, -1, "interrupted");
    return NQM_OK;
}

static nqm_status predict_model(predict_run *run, size_t model, nqm_error *err) {
    const nqm_evaluation *ev = run->ev;
    nqm_prediction *to = ev->predictions + model * ev->dataset->n_pairs;
    const nqm_dataset_prediction prediction = {.dataset = nqm_evaluation_samples(ev, model),
                                               .model = ev->models[model],
                                               .n = run->n,
                                               .pairs = run->pairs,
                                               .to = to,
                                               .batch_done = tick,
                                               .user = run};
    const nqm_status status = nqm_dataset_predict(&prediction, err);
    for (size_t i = 0; status == NQM_OK && i < run->n; ++i) {
        nqm_prediction *own = &to[run->pairs[i]];
        const size_t at = model * ev->dataset->n_pairs + run->pairs[i];
        if (run->apart && !isnan(own->similarity[0]))
            own->jod = own->similarity[0];
        ev->values[at] = own->jod;
        ev->labels[at] = own->label;
    }
    return status;
}

/* The scalar metrics and the estimate of a pair. */
static void keep_comparison(nqm_evaluation *ev, size_t pair, const nqm_comparison *c) {
    const size_t n_pairs = ev->dataset->n_pairs, first = ev->n_models * n_pairs + pair;
    if (ev->estimates) {
        ev->estimates[pair] = c->estimate;
        ev->values[first + NQM_METRIC_COUNT * n_pairs] = nqm_curve_jod(&nqm_curve_published, c->estimate.delta_e);
    }
    memcpy(ev->scalars + pair * NQM_SCALAR_COUNT, c->scalars, sizeof c->scalars);
    for (size_t m = 0; m < NQM_METRIC_COUNT; ++m)
        ev->values[first + m * n_pairs] = c->metrics[m];
}

static nqm_status predict_metrics(predict_run *run, nqm_error *err) {
    const nqm_dataset *d = run->ev->dataset;
    const nqm_transport transport = nqm_dataset_transport(d);
    nqm_comparison *to = nqm_alloc(NQM_PREDICT_BATCH, sizeof *to);
    nqm_status status = to ? NQM_OK : nqm_fail_nomem(err, NQM_PREDICT_BATCH * sizeof *to);
    for (size_t first = 0; status == NQM_OK && first < run->n; first += NQM_PREDICT_BATCH) {
        const size_t n = nqm_smaller(run->n - first, NQM_PREDICT_BATCH);
        status = nqm_dataset_compare(d, &transport, n, run->pairs + first, to, err);
        for (size_t i = 0; status == NQM_OK && i < n; ++i)
            keep_comparison(run->ev, run->pairs[first + i], &to[i]);
        if (status == NQM_OK)
            status = tick(run, n, err);
    }
    nqm_free(to);
    return status;
}

static nqm_status fail_empty_split(const nqm_dataset *d, nqm_split split, nqm_error *err) {
    const nqm_dataset_info info = nqm_dataset_get_info(d);
    char text[120] = "";
    size_t used = 0;
    for (size_t s = NQM_SPLIT_TRAIN; s < NQM_SPLIT_ALL; ++s)
        if (info.n_pairs_in[s])
            used += (size_t)snprintf(text + used, sizeof text - used, "%s%zu in '%s'", used ? ", " : "",
                                     info.n_pairs_in[s], nqm_split_words[s]);
    return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "the dataset has no pair in the split '%s'; it has %s",
                    nqm_split_words[split], used ? text : "none at all");
}

static nqm_status predict_all(nqm_evaluation *ev, const nqm_eval_options *o, nqm_error *err) {
    const nqm_dataset *d = ev->dataset;
    predict_run run = {.ev = ev, .apart = o->apart, .pairs = nqm_alloc(d->n_pairs, sizeof *run.pairs)};
    run.ticker = (nqm_ticker){.fn = o->progress, .user = o->progress_user};
    nqm_status status = run.pairs ? NQM_OK : nqm_fail_nomem(err, d->n_pairs * sizeof *run.pairs);
    for (size_t i = 0; status == NQM_OK && i < d->n_pairs; ++i)
        if (nqm_evaluation_in_split(d, i, o->split))
            run.pairs[run.n++] = i;
    if (status == NQM_OK && run.n == 0)
        status = fail_empty_split(d, o->split, err);
    for (size_t m = 0; status == NQM_OK && m < ev->n_models; ++m)
        status = predict_model(&run, m, err);
    if (status == NQM_OK)
        status = predict_metrics(&run, err);
    nqm_free(run.pairs);
    return status;
}

static void clear(size_t n, double *values) {
    for (size_t i = 0; i < n; ++i)
        values[i] = NAN;
}

static void clear_labels(size_t n, nqm_label *labels) {
    for (size_t i = 0; i < n; ++i)
        labels[i] = (nqm_label){NAN, {NAN, NAN, NAN}, NAN, NAN, 0};
}

/* Nothing is predicted yet. */
static nqm_status begin(nqm_evaluation *ev, nqm_error *err) {
    const nqm_dataset *d = ev->dataset;
    clear(ev->n_predictors * d->n_pairs, ev->values);
    clear(NQM_SCALAR_COUNT * d->n_pairs, ev->scalars);
    clear_labels(ev->n_models * d->n_pairs, ev->labels);
    clear_labels(ev->estimates ? d->n_pairs : 0, ev->estimates);
    for (size_t i = 0; i < d->n_refs; ++i)
        ev->ref_class[i] = nqm_dataset_ref_class(d, i);
    const nqm_status status = nqm_dataset_unseen_kinds(d, ev->unseen, err);
    for (size_t i = 0; i < d->n_kinds; ++i)
        ev->has_unseen = ev->has_unseen || ev->unseen[i];
    for (size_t i = 0; i < ev->n_predictors; ++i)
        ev->names[i] = i < ev->n_models                      ? ev->models[i]->id
                       : i < ev->n_models + NQM_METRIC_COUNT ? nqm_metric_get_info((nqm_metric)(i - ev->n_models)).name
                                                             : "estimate";
    return status;
}

nqm_status nqm_evaluation_create(const nqm_dataset *dataset, size_t n_models, const nqm_model *const *models,
                                 const nqm_dataset *const *datasets, const nqm_eval_options *options,
                                 nqm_evaluation **evaluation_ret, nqm_error *err) {
    *evaluation_ret = NULL;
    const bool has_estimate = dataset->transport;
    const size_t n_predictors = n_models + NQM_METRIC_COUNT + has_estimate;
    nqm_evaluation made = {.dataset = dataset,
                           .datasets = datasets,
                           .n_models = n_models,
                           .n_predictors = n_predictors,
                           .models = models,
                           .split = options->split};
    nqm_evaluation *ev;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&ev, 1, sizeof *ev}, {&made.values, n_predictors, dataset->n_pairs * sizeof(double)},
                   {&made.predictions, n_models, dataset->n_pairs * sizeof *made.predictions},
                   {&made.labels, n_models, dataset->n_pairs * sizeof *made.labels},
                   {has_estimate ? &made.estimates : NULL, dataset->n_pairs, sizeof *made.estimates},
                   {&made.scalars, dataset->n_pairs, NQM_SCALAR_COUNT * sizeof(double)},
                   {&made.ref_class, dataset->n_refs, sizeof *made.ref_class},
                   {&made.unseen, dataset->n_kinds, sizeof *made.unseen},
                   {&made.names, n_predictors, sizeof *made.names}),
        err);
    if (status != NQM_OK)
        return status;
    *ev = made;
    status = begin(ev, err);
    if (status == NQM_OK)
        status = predict_all(ev, options, err);
    if (status == NQM_OK)
        *evaluation_ret = ev;
    else
        nqm_evaluation_free(ev);
    return status;
}

void nqm_evaluation_free(nqm_evaluation *ev) {
    nqm_free(ev); /* one block */
}

const nqm_label *nqm_evaluation_labels(const nqm_evaluation *ev, size_t i) {
    assert(ev);
    if (i < ev->n_models)
        return nqm_model_has_parts(ev->models[i]) ? ev->labels + i * ev->dataset->n_pairs : NULL;
    return i == ev->n_models + NQM_METRIC_COUNT ? ev->estimates : NULL;
}

const double *nqm_evaluation_values(const nqm_evaluation *ev, size_t i) {
    assert(ev);
    return ev->values + i * ev->dataset->n_pairs;
}
