/* SPDX-License-Identifier: MIT
 *
 * Makes all units of a corpus: one per thread, together with other processes that share the checkpoint folder. Units with the most
 * rows come first, so that no large one is left at the end. The result does not depend on which thread or process makes a
 * unit.
 */
#include "base/os.h"
#include "base/shared_work.h"
#include "corpus/corpus.h"

#include <stdatomic.h>

typedef struct run {
    nqm_corpus *corpus;
    size_t *order;        /* (n_units) order of processing */
    atomic_size_t n_done; /* finished rows */
    atomic_bool stopped;
    pthread_t caller; /* the only thread that reports progress */
    nqm_ticker ticker;
} run;

/* Count finished rows and, on the caller's thread, report them. true: stop. */
static bool advance(void *user, size_t n_rows) {
    run *r = user;
    const size_t done = atomic_fetch_add(&r->n_done, n_rows) + n_rows;
    if (pthread_equal(pthread_self(), r->caller) &&
        nqm_tick(&r->ticker, "corpus", (double)done, (double)r->corpus->list.n_rows))
        atomic_store(&r->stopped, true);
    return atomic_load(&r->stopped);
}

static bool is_stopped(void *user) {
    return advance(user, 0);
}

static const char *path_of(void *user, size_t item) {
    const run *r = user;
    return r->corpus->units[item].path;
}

static bool load(void *user, size_t item) {
    run *r = user;
    nqm_corpus_unit *it = &r->corpus->units[item];
    if (!it->is_done && nqm_corpus_unit_load(r->corpus->n_directions, it)) {
        it->is_done = true;
        advance(r, it->n_rows);
    }
    return it->is_done;
}

static nqm_status make(void *user, size_t i, nqm_error *err) {
    run *r = user;
    nqm_corpus_unit *unit = &r->corpus->units[i];
    nqm_status status = nqm_corpus_unit_make(r->corpus, unit, err);
    if (status == NQM_OK && unit->path)
        status = nqm_corpus_unit_save(r->corpus->n_directions, unit, unit->n_rows, err);
    if (status != NQM_OK)
        atomic_store(&r->stopped, true); /* also the units of the other threads */
    return status;
}

/* Indices of the units, those with the most rows first, ties in order (insertion sort: some hundred units). */
static void make_order(run *r) {
    const nqm_corpus_unit *units = r->corpus->units;
    for (size_t i = 0; i < r->corpus->n_units; ++i) {
        size_t at = i;
        for (; at > 0 && units[r->order[at - 1]].n_rows < units[i].n_rows; --at)
            r->order[at] = r->order[at - 1];
        r->order[at] = i;
    }
}

nqm_status nqm_corpus_run(nqm_corpus *corpus, nqm_error *err) {
    const nqm_corpus_options *options = corpus->options;
    run r = {.corpus = corpus,
             .caller = pthread_self(),
             .order = nqm_alloc(corpus->n_units, sizeof *r.order),
             .ticker = {.fn = options->progress, .user = options->progress_user}};
    if (!r.order)
        return nqm_fail_nomem(err, corpus->n_units * sizeof *r.order);
    make_order(&r);
    corpus->step = advance;
    corpus->step_user = &r;
    const nqm_shared_work work = {.n = corpus->n_units,
                                  .order = r.order,
                                  .user = &r,
                                  .path = path_of,
                                  .load = load,
                                  .make = make,
                                  .is_stopped = is_stopped};
    atomic_store(&r.n_done, 0);
    for (size_t i = 0; i < corpus->n_units; ++i) /* first, so that the estimate of the time left begins with new work */
        if (corpus->units[i].path)
            load(&r, i);
    const nqm_status status = nqm_shared_work_run(&work, err);
    nqm_free(r.order);
    return status;
}
