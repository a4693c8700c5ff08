/* SPDX-License-Identifier: MIT
 *
 * Makes all groups of a corpus: one group per thread, together with other processes that share the checkpoint folder. Groups
 * with the most tests come first, so that no large group is left at the end. The result does not depend on which thread
 * or process makes a group.
 */
#include "label/corpus.h"

#include <pthread.h>
#include <time.h>
#include <unistd.h>

typedef struct run {
    nqm_corpus *corpus;
    size_t *order;        /* (n_items) order of processing */
    atomic_size_t n_done; /* finished tests */
    atomic_size_t n_items_done;
    atomic_bool stopped;
    pthread_mutex_t mutex; /* guards status and *err */
    nqm_status status;
    nqm_error *err;
    pthread_t caller; /* the only thread that reports progress */
    nqm_ticker ticker;
} run;

/* Count finished tests and, on the caller's thread, report progress. true: stop. */
static bool advance(void *user, size_t n_tests) {
    run *r = user;
    size_t done = atomic_fetch_add(&r->n_done, n_tests) + n_tests;
    if (pthread_equal(pthread_self(), r->caller) &&
        nqm_tick(&r->ticker, "corpus", (double)done, (double)r->corpus->n_tests))
        atomic_store(&r->stopped, true);
    return atomic_load(&r->stopped);
}

/* Keep the first failure and stop the other threads. */
static void keep_failure(run *r, nqm_status status, const nqm_error *err) {
    pthread_mutex_lock(&r->mutex);
    if (r->status == NQM_OK) {
        r->status = status;
        if (r->err)
            *r->err = *err;
    }
    pthread_mutex_unlock(&r->mutex);
    atomic_store(&r->stopped, true);
}

static bool load(run *r, nqm_corpus_item *item) {
    if (!item->path || access(item->path, R_OK) != 0 || !nqm_corpus_item_load(r->corpus->n_directions, item))
        return false;
    advance(r, item->plan.n_tests);
    return true;
}

/* Make the item unless another process has claimed it. Look for its file again after the claim: another process may have
 * finished it meanwhile. */
static nqm_status make(run *r, nqm_corpus_item *item, bool *made_ret, nqm_error *err) {
    int claim = -1;
    *made_ret = false;
    nqm_status status = item->path ? nqm_corpus_claim(item->path, &claim, err) : NQM_OK;
    if (status != NQM_OK || (item->path && claim < 0))
        return status;
    *made_ret = load(r, item);
    if (!*made_ret) {
        status = nqm_corpus_item_make(&r->corpus->context, item, err);
        if (status == NQM_OK && item->path)
            status = nqm_corpus_item_save(r->corpus->n_directions, item, err);
        *made_ret = status == NQM_OK;
    }
    if (item->path)
        nqm_corpus_release(item->path, claim);
    return status;
}

static bool take(nqm_corpus_item *item, int state) {
    return atomic_compare_exchange_strong(&item->state, &state, NQM_ITEM_ACTIVE);
}

/* Load an item, or make it if `may_make`. */
static void visit(run *r, nqm_corpus_item *item, bool may_make) {
    nqm_error err = {0};
    if (atomic_load(&r->stopped))
        return;
    if (!take(item, NQM_ITEM_SKIPPED) && !(may_make && take(item, NQM_ITEM_OPEN)))
        return;
    bool done = load(r, item);
    nqm_status status = done || !may_make ? NQM_OK : make(r, item, &done, &err);
    if (status != NQM_OK)
        keep_failure(r, status, &err);
    if (done)
        atomic_fetch_add(&r->n_items_done, 1);
    atomic_store(&item->state, done ? NQM_ITEM_DONE : NQM_ITEM_SKIPPED);
}

/* First load the skipped items that other processes have finished, so that progress counts them. */
static void work_on(void *user, size_t i) {
    run *r = user;
    for (size_t k = 0; k < i; ++k)
        visit(r, &r->corpus->items[r->order[k]], false);
    visit(r, &r->corpus->items[r->order[i]], true);
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
             .err = err,
             .caller = pthread_self(),
             .order = nqm_alloc(corpus->n_items, sizeof *r.order),
             .ticker = {.fn = options->progress, .user = options->progress_user}};
    if (!r.order)
        return nqm_fail_nomem(err, corpus->n_items * sizeof *r.order);
    make_order(&r);
    corpus->context.step = advance;
    corpus->context.step_user = &r;
    pthread_mutex_init(&r.mutex, NULL);
    for (;;) {
        nqm_parallel_for(corpus->n_items, work_on, &r);
        if (atomic_load(&r.n_items_done) == corpus->n_items || advance(&r, 0))
            break;
        /* wait for the other processes */
        nanosleep(&(struct timespec){.tv_nsec = 200000000}, NULL);
    }
    pthread_mutex_destroy(&r.mutex);
    nqm_free(r.order);
    if (r.status == NQM_OK && atomic_load(&r.stopped))
        return nqm_fail(err, NQM_ERR_CANCELLED, -1, "corpus: stopped");
    return r.status;
}
