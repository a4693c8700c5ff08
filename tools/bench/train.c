/* SPDX-License-Identifier: MIT
 *
 * nqm_train() on as many pairs as the paper's: 3,340, of which a fifth is for validation and the rest is doubled by
 * scaled copies: 5,344 and 668. The peaks are sampled between the epochs, outside of the timings.
 */
#include "train/train.h"
#include "bench/bench.h"
#include "math/math.h"

#include <omp.h>

enum { N_REFS = 334, N_REFS_QUICK = 12 };

/* Operations of an epoch: a multiply-add for each parameter and pair, forward; and for training pairs in both gradients, but
 * layer 1 needs no gradient of its input. */
static double epoch_flop(const nqm_net_shape *shape, const nqm_train_report *report) {
    const double forward = (double)nqm_params_count(shape), first = (double)shape->sizes[0] * (double)shape->sizes[1];
    return 2 * ((double)report->n_train * (3 * forward - first) + (double)report->n_validation * forward);
}

/* Times of the epochs, without those of the samples in between. */
typedef struct watch {
    nqm_bench *bench;
    nqm_bench_entry *entry;
    double last_s, sampling_s, sampling_cpu_s;
    double *epoch_s; /* (epochs) */
} watch;

static void end_epoch(void *user, size_t epoch, double train_loss, double validation_loss, double lr_first) {
    (void)train_loss, (void)validation_loss, (void)lr_first;
    watch *w = user;
    const double now = nqm_clock_s(), cpu = nqm_bench_process_clock_s();
    w->epoch_s[epoch - 1] = now - w->last_s;
    nqm_bench_sample(w->bench, w->entry->peak);
    w->last_s = nqm_clock_s();
    w->sampling_s += w->last_s - now;
    w->sampling_cpu_s += nqm_bench_process_clock_s() - cpu;
}

static void fill_entry(nqm_bench_entry *entry, const nqm_train_options *o, const nqm_train_report *report, watch *w,
                       double seconds, double cpu_s) {
    const size_t epochs = o->optimiser.epochs;
    const double n = (double)epochs, threads = omp_get_max_threads();
    entry->best = seconds;
    entry->median = n * nqm_quantile(epochs, w->epoch_s, 0.5); /* sorts */
    entry->cpu = cpu_s / threads;
    entry->cpu_share = cpu_s / seconds / threads;
    nqm_bench_text(entry, "model", o->recipe);
    nqm_bench_count(entry, "batch", o->optimiser.batch);
    nqm_bench_count(entry, "epochs", epochs);
    nqm_bench_count(entry, "seed", (size_t)o->optimiser.seed);
    nqm_bench_count(entry, "pairs", report->n_train);
    nqm_bench_number(entry, "best_epoch_seconds", w->epoch_s[0]);
    nqm_bench_number(entry, "validation_loss", report->validation_loss);
}

static nqm_status train_once(nqm_bench *bench, const nqm_dataset *dataset, nqm_train_options *o, nqm_error *err) {
    nqm_bench_entry entry = nqm_bench_entry_make("train", "training", NULL, NULL);
    watch w = {.bench = bench, .entry = &entry, .epoch_s = nqm_alloc(o->optimiser.epochs, sizeof(double))};
    if (!w.epoch_s)
        return nqm_fail_nomem(err, o->optimiser.epochs * sizeof(double));
    nqm_bench_entry_work(bench, &entry, o->optimiser.precision, 0);
    o->run.epoch_done = end_epoch;
    o->run.epoch_user = &w;
    nqm_model *model;
    nqm_train_report report;
    nqm_bench_release_memory(bench);
    nqm_bench_reset_peak_memory();
    const double cpu_begin = nqm_bench_process_clock_s(), begin = nqm_clock_s();
    w.last_s = begin;
    nqm_status status = nqm_train(dataset, o, &model, &report, err);
    const double seconds = nqm_clock_s() - begin - w.sampling_s,
                 cpu_s = nqm_bench_process_clock_s() - cpu_begin - w.sampling_cpu_s;
    nqm_bench_number(&entry, "max_rss_mb", nqm_bench_peak_memory_mb());
    if (status == NQM_OK) {
        entry.gflop = 1e-9 * (double)o->optimiser.epochs * epoch_flop(&model->params.shape, &report);
        fill_entry(&entry, o, &report, &w, seconds, cpu_s);
        status = nqm_bench_add(bench, &entry, err);
    } else {
        json_decref(entry.row);
    }
    nqm_model_free(model);
    nqm_free(w.epoch_s);
    return status;
}

nqm_status nqm_bench_train(nqm_bench *bench, nqm_error *err) {
    const nqm_bench_options *options = &bench->options;
    nqm_train_options o;
    nqm_directions *directions;
    nqm_dataset *dataset = NULL;
    nqm_status status = nqm_train_options_recipe(options->recipe, &o, err);
    if (status == NQM_OK)
        status = nqm_directions_create(NULL, 0, NULL, &directions, err);
    if (status != NQM_OK)
        return status;
    status = nqm_bench_pairs(options->quick ? N_REFS_QUICK : N_REFS, directions, &dataset, err);
    nqm_directions_free(directions);
    if (status != NQM_OK)
        return status;
    o.augmentation.balance = 0;
    o.optimiser.epochs = options->epochs ? options->epochs : o.optimiser.epochs;
    for (o.optimiser.seed = 1; o.optimiser.seed <= options->seeds && status == NQM_OK; ++o.optimiser.seed)
        for (o.optimiser.precision = NQM_PRECISION_F32; o.optimiser.precision <= NQM_PRECISION_BF16 && status == NQM_OK;
             ++o.optimiser.precision)
            if (nqm_bench_has_precision(bench, o.optimiser.precision))
                status = train_once(bench, dataset, &o, err);
    nqm_dataset_free(dataset);
    return status;
}
