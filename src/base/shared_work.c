/* SPDX-License-Identifier: MIT
 *
 * Work that processes share (shared_work.h). The result of an item must not depend on who makes it.
 */
#include "base/shared_work.h"
#include "base/memory_test.h"
#include "base/os.h"

#include <errno.h>
#include <stdatomic.h>

/* ---- claims ------------------------------------------------------------------------------------------------------ */

/* A claim is a lock on a file next to the result. The system releases the locks of a process that ends in any way, so no clock or
 * heartbeat is needed. */
static char *claim_path(const char *path) {
    return nqm_strdupf("%s.claim", path);
}

static void (*lock_hook)(void);

void nqm_lock_hook(void (*hook)(void)) {
    lock_hook = hook;
}

static void call_lock_hook(void) {
    void (*hook)(void) = lock_hook;
    lock_hook = NULL;
    if (hook)
        hook();
}

/* Open and lock the file, which is created if it does not exist: *fd_ret is -1 if another process holds the lock. If the file was
 * deleted or replaced before it was locked, the new one is opened. On file systems without locks it is opened without one. */
static nqm_status open_locked(const char *path, int *fd_ret, nqm_error *err) {
    for (;;) {
        const int fd = *fd_ret = nqm_os_open(path, NQM_OPEN_CREATE);
        if (fd < 0)
            return nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot be written: %s", path, strerror(errno));
        call_lock_hook();
        const nqm_lock lock = nqm_os_lock(fd, path);
        if (lock == NQM_LOCK_TAKEN || lock == NQM_LOCK_UNSUPPORTED)
            return NQM_OK;
        nqm_os_close(fd);
        *fd_ret = -1;
        if (lock == NQM_LOCK_HELD)
            return NQM_OK;
    }
}

nqm_status nqm_claim(const char *path, int *claim_ret, nqm_error *err) {
    *claim_ret = -1;
    char *name = claim_path(path);
    if (!name)
        return nqm_fail_nomem(err, strlen(path));
    const nqm_status status = open_locked(name, claim_ret, err);
    nqm_free(name);
    return status;
}

/* Remove before unlocking: open_locked() takes no lock on a deleted file. */
void nqm_claim_release(const char *path, int claim) {
    char *name = claim_path(path);
    if (name)
        nqm_os_remove(name);
    nqm_free(name);
    nqm_os_close(claim);
}

/* Remove the claim of a process that was killed between saving the result and releasing its claim. */
static void remove_abandoned_claim(const char *path) {
    char *name = claim_path(path);
    int claim;
    if (name && nqm_os_exists(name) && nqm_claim(path, &claim, NULL) == NQM_OK && claim >= 0)
        nqm_claim_release(path, claim);
    nqm_free(name);
}

/* ---- items ------------------------------------------------------------------------------------------------------- */

enum { ITEM_OPEN = 0, ITEM_SKIPPED /* another process has claimed it */, ITEM_ACTIVE, ITEM_DONE };

typedef struct run {
    const nqm_shared_work *work;
    atomic_int *state; /* (n) */
    atomic_size_t n_done;
    atomic_bool failed;
    pthread_mutex_t mutex; /* guards status and *err */
    nqm_status status;
    nqm_error *err;
} run;

static size_t item_at(const nqm_shared_work *work, size_t i) {
    return work->order ? work->order[i] : (work->first + i) % work->n;
}

static bool is_stopped(run *r) {
    return atomic_load(&r->failed) || r->work->is_stopped(r->work->user);
}

/* Keep the first failure; items that stop because of it are cancelled, perhaps before it is kept. */
static void keep_failure(run *r, nqm_status status, const nqm_error *err) {
    pthread_mutex_lock(&r->mutex);
    if (r->status == NQM_OK || (r->status == NQM_ERR_CANCELLED && status != NQM_ERR_CANCELLED)) {
        r->status = status;
        if (r->err)
            *r->err = *err;
    }
    pthread_mutex_unlock(&r->mutex);
    atomic_store(&r->failed, true);
}

/* Make the item unless another process has claimed it. Look for its file again after the claim: another process may have
 * finished it meanwhile. */
static nqm_status make(const nqm_shared_work *work, size_t item, bool *made_ret, nqm_error *err) {
    const char *path = work->path(work->user, item);
    int claim = -1;
    *made_ret = false;
    nqm_status status = path ? nqm_claim(path, &claim, err) : NQM_OK;
    if (status != NQM_OK || (path && claim < 0))
        return status;
    *made_ret = path && work->load(work->user, item);
    if (!*made_ret) {
        status = work->make(work->user, item, err);
        *made_ret = status == NQM_OK;
    }
    if (path)
        nqm_claim_release(path, claim);
    return status;
}

static bool take(run *r, size_t item, int state) {
    return atomic_compare_exchange_strong(&r->state[item], &state, ITEM_ACTIVE);
}

/* Load an item, or make it if `may_make`. */
static void visit(run *r, size_t item, bool may_make) {
    const nqm_shared_work *work = r->work;
    nqm_error err = {0};
    if (atomic_load(&r->failed) || (!take(r, item, ITEM_SKIPPED) && !(may_make && take(r, item, ITEM_OPEN))))
        return;
    const char *path = work->path(work->user, item);
    bool done = path && work->load(work->user, item);
    if (done)
        remove_abandoned_claim(path);
    const nqm_status status = done || !may_make ? NQM_OK : make(work, item, &done, &err);
    if (status != NQM_OK)
        keep_failure(r, status, &err);
    if (done)
        atomic_fetch_add(&r->n_done, 1);
    atomic_store(&r->state[item], done ? ITEM_DONE : ITEM_SKIPPED);
}

/* First load the skipped items that other processes have finished, so that progress counts them. */
static void work_on(void *user, size_t i) {
    run *r = user;
    for (size_t k = 0; k < i && !r->work->one_at_a_time; ++k)
        visit(r, item_at(r->work, k), false);
    if (!is_stopped(r))
        visit(r, item_at(r->work, i), true);
}

nqm_status nqm_shared_work_run(const nqm_shared_work *work, nqm_error *err) {
    run r = {.work = work, .err = err, .state = nqm_alloc(work->n + 1, sizeof *r.state)};
    if (!r.state)
        return nqm_fail_nomem(err, work->n * sizeof *r.state);
    pthread_mutex_init(&r.mutex, NULL);
    for (;;) {
        if (!work->one_at_a_time)
            nqm_parallel_for(work->n, work_on, &r);
        for (size_t i = 0; work->one_at_a_time && i < work->n && !is_stopped(&r); ++i)
            work_on(&r, i);
        if (atomic_load(&r.n_done) == work->n || is_stopped(&r))
            break;
        nqm_os_sleep(0.2); /* wait for the other processes */
    }
    pthread_mutex_destroy(&r.mutex);
    nqm_free(r.state);
    if (r.status == NQM_OK && atomic_load(&r.n_done) < work->n)
        return nqm_fail(err, NQM_ERR_CANCELLED, -1, "stopped");
    return r.status;
}
