/* SPDX-License-Identifier: MIT
 *
 * Makes all groups of a corpus: one group per thread, together with other processes that share the checkpoint folder. Groups
 * with the most tests come first, so that no large group is left at the end. The result does not depend on which thread
 * or process makes a group.
 */
#include "base/shared_work.h"
#include "corpus/corpus.h"

#include <pthread.h>
#include <stdatomic.h>

typedef struct run {
    nqm_corpus *corpus;
    size_t *order; /* (n_items) order of processing */
    size_t n_units;
    atomic_size_t n_done; /* finished units */
    atomic_bool stopped;
    pthread_t caller; /* the only thread that reports progress */
    nqm_ticker ticker;
} run;

/* Units of work of a group. */
static size_t units_of(const nqm_corpus *corpus, const nqm_corpus_item *item) {
    return item->plan.n_tests + item->plan.n_refs * corpus->context.models.n * NQM_CORPUS_FIT_UNITS;
}

/* Count finished units and, on the caller's thread, report them as tests. true: stop. */
static bool advance(void *user, size_t n_units) {
    run *r = user;
    const size_t done = atomic_fetch_add(&r->n_done, n_units) + n_units;
    const double n_tests = (double)r->corpus->n_tests;
    if (pthread_equal(pthread_self(), r->caller) &&
        nqm_tick(&r->ticker, "corpus", n_tests * (double)done / (double)r->n_units, n_tests))
        atomic_store(&r->stopped, true);
    return atomic_load(&r->stopped);
}

static bool is_stopped(void *user) {
    return advance(user, 0);
}

static const char *path_of(void *user, size_t item) {
    const run *r = user;
    return r->corpus->items[item].path;
}

static bool load(void *user, size_t item) {
    run *r = user;
    nqm_corpus_item *it = &r->corpus->items[item];
    if (!it->is_done && nqm_corpus_item_load(r->corpus->n_directions, it)) {
        it->is_done = true;
        advance(r, units_of(r->corpus, it));
    }
    return it->is_done;
}

static nqm_status make(void *user, size_t i, nqm_error *err) {
    run *r = user;
    nqm_corpus_item *item = &r->corpus->items[i];
    nqm_status status = nqm_corpus_item_make(&r->corpus->context, item, err);
    if (status == NQM_OK && item->path)
        status = nqm_corpus_item_save(r->corpus->n_directions, item, item->plan.n_tests, err);
    if (status != NQM_OK)
        atomic_store(&r->stopped, true); /* stops the groups of the other threads, too */
    return status;
}

/* Indices of the items, those with the most tests first, ties in order (insertion sort: some hundred items). */
static void make_order(run *r) {
    const nqm_corpus_item *items = r->corpus->items;
    for (size_t i = 0; i < r->corpus->n_items; ++i) {
        size_t at = i;
        for (; at > 0 && items[r->order[at - 1]].plan.n_tests < items[i].plan.n_tests; --at)
            r->order[at] = r->order[at - 1];
        r->order[at] = i;
    }
}

nqm_status nqm_corpus_run(nqm_corpus *corpus, nqm_error *err) {
    const nqm_corpus_options *options = corpus->context.options;
    run r = {.corpus = corpus,
             .caller = pthread_self(),
             .order = nqm_alloc(corpus->n_items, sizeof *r.order),
             .ticker = {.fn = options->progress, .user = options->progress_user}};
    if (!r.order)
        return nqm_fail_nomem(err, corpus->n_items * sizeof *r.order);
    make_order(&r);
    for (size_t i = 0; i < corpus->n_items; ++i)
        r.n_units += units_of(corpus, &corpus->items[i]);
    corpus->context.step = advance;
    corpus->context.step_user = &r;
    const nqm_shared_work work = {.n = corpus->n_items,
                                  .order = r.order,
                                  .user = &r,
                                  .path = path_of,
                                  .load = load,
                                  .make = make,
                                  .is_stopped = is_stopped};
    atomic_store(&r.n_done, 0);
    for (size_t i = 0; i < corpus->n_items; ++i) /* first, so that the estimate of the time left begins with new work */
        if (corpus->items[i].path)
            load(&r, i);
    const nqm_status status = nqm_shared_work_run(&work, err);
    nqm_free(r.order);
    return status;
}
