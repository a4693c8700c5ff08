/* SPDX-License-Identifier: MIT
 *
 * The work on all groups of a corpus: by the threads of this process, each on a group of its own, and together with
 * other processes that share the folder of work files. Groups with most tests come first, so that none is left running
 * alone at the end. What is made does not depend on who makes it.
 */
#include "label/corpus.h"

#include <pthread.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

typedef struct run {
    nqm_corpus *corpus;
    size_t *order;        /* (n_items) in which they are begun */
    atomic_size_t n_done; /* tests, in finished items and in hand */
    atomic_size_t n_items_done;
    atomic_bool stopped;
    pthread_mutex_t mutex; /* guards status and *err */
    nqm_status status;
    nqm_error *err;
    pthread_t caller; /* the only thread that may report progress */
    nqm_ticker ticker;
} run;

/* Count finished tests; from the caller's thread, report them. true: stop. */
static bool advance(void *user, size_t n_tests) {
    run *r = user;
    size_t done = atomic_fetch_add(&r->n_done, n_tests) + n_tests;
    if (pthread_equal(pthread_self(), r->caller) &&
        nqm_tick(&r->ticker, "corpus", (double)done, (double)r->corpus->n_tests))
        atomic_store(&r->stopped, true);
    return atomic_load(&r->stopped);
}

/* The first failure counts, and stops the others. */
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

/* Make the item unless another process is at it. Between looking for its file and the claim it may have been
 * finished: looked for again. */
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
    return atomic_compare_exchange_strong(&item->state, &state, NQM_ITEM_IN_HAND);
}

/* Load an item, or, if it `may_make`, make it. */
static void visit(run *r, nqm_corpus_item *item, bool may_make) {
    nqm_error err = {0};
    if (atomic_load(&r->stopped))
        return;
    if (!take(item, NQM_ITEM_PASSED_BY) && !(may_make && take(item, NQM_ITEM_OPEN)))
        return;
    bool done = load(r, item);
    nqm_status status = done || !may_make ? NQM_OK : make(r, item, &done, &err);
    if (status != NQM_OK)
        keep_failure(r, status, &err);
    if (done)
        atomic_fetch_add(&r->n_items_done, 1);
    atomic_store(&item->state, done ? NQM_ITEM_DONE : NQM_ITEM_PASSED_BY);
}

/* First see what others have finished of what was passed by, so that progress counts it. */
static void work_on(void *user, size_t i) {
    run *r = user;
    for (size_t k = 0; k < i; ++k)
        visit(r, &r->corpus->items[r->order[k]], false);
    visit(r, &r->corpus->items[r->order[i]], true);
}

static int compare_sizes(const void *a, const void *b) {
    const size_t *x = a, *y = b; /* size, index */
    if (x[0] != y[0])
        return x[0] < y[0] ? 1 : -1;
    return x[1] < y[1] ? -1 : 1;
}

/* Largest first. */
static bool make_order(run *r) {
    const nqm_corpus *c = r->corpus;
    size_t *sizes = nqm_alloc(c->n_items, 2 * sizeof *sizes);
    r->order = nqm_alloc(c->n_items, sizeof *r->order);
    for (size_t i = 0; sizes && i < c->n_items; ++i) {
        sizes[2 * i] = c->items[i].plan.n_tests;
        sizes[2 * i + 1] = i;
    }
    if (sizes)
        qsort(sizes, c->n_items, 2 * sizeof *sizes, compare_sizes);
    for (size_t i = 0; sizes && r->order && i < c->n_items; ++i)
        r->order[i] = sizes[2 * i + 1];
    nqm_free(sizes);
    return sizes && r->order;
}

nqm_status nqm_corpus_run(nqm_corpus *corpus, nqm_error *err) {
    const nqm_corpus_options *options = corpus->context.options;
    run r = {.corpus = corpus,
             .err = err,
             .caller = pthread_self(),
             .ticker = {.fn = options->progress, .user = options->progress_user}};
    if (!make_order(&r)) {
        nqm_free(r.order);
        return nqm_fail_nomem(err, 3 * corpus->n_items * sizeof *r.order);
    }
    corpus->context.step = advance;
    corpus->context.step_user = &r;
    pthread_mutex_init(&r.mutex, NULL);
    for (;;) {
        nqm_parallel_for(corpus->n_items, work_on, &r);
        if (atomic_load(&r.n_items_done) == corpus->n_items || advance(&r, 0))
            break;
        /* The rest is in the hands of other processes. */
        nanosleep(&(struct timespec){.tv_nsec = 200000000}, NULL);
    }
    pthread_mutex_destroy(&r.mutex);
    nqm_free(r.order);
    if (r.status == NQM_OK && atomic_load(&r.stopped))
        return nqm_fail(err, NQM_ERR_CANCELLED, -1, "corpus: stopped");
    return r.status;
}
