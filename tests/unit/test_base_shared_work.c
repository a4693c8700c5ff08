/* SPDX-License-Identifier: MIT
 *
 * Work that processes share: claims exclude other processes until they are released or their process ends; every item is made
 * once by two processes, each of which may be killed; failures and stops.
 */
#include "base/memory_test.h"
#include "base/shared_work.h"
#include "support/check.h"
#include "support/scratch.h"

#include <signal.h>
#include <stdatomic.h>
#include <sys/wait.h>

TEST(claims_exclude) {
    char path[128];
    int first, second;
    snprintf(path, sizeof path, "%s", scratch_path("claimed"));
    assert_int_equal(nqm_claim(path, &first, NULL), NQM_OK);
    assert_true(first >= 0);
    assert_int_equal(nqm_claim(path, &second, NULL), NQM_OK);
    assert_int_equal(second, -1);
    nqm_claim_release(path, first);
    assert_int_not_equal(access(scratch_path("claimed.claim"), F_OK), 0);
    pid_t child = fork();
    if (child == 0) {
        bool claimed = nqm_claim(path, &first, NULL) == NQM_OK && first >= 0;
        raise(claimed ? SIGKILL : SIGTERM);
    }
    int end;
    assert_int_equal(waitpid(child, &end, 0), child);
    assert_int_equal(WTERMSIG(end), SIGKILL);
    assert_int_equal(access(scratch_path("claimed.claim"), F_OK), 0);
    assert_int_equal(nqm_claim(path, &second, NULL), NQM_OK);
    assert_true(second >= 0);
    nqm_claim_release(path, second);
    assert_int_equal(nqm_claim("/nowhere/x", &second, NULL), NQM_ERR_IO);
}

/* What another process does between the opening of a claim and its lock: it finishes and deletes the file. */
static void delete_locked(void) {
    assert_int_equal(unlink(scratch_path("locked.claim")), 0);
}

static int other_claim = -1;

/* The same, and a third process makes the file again and holds its lock. */
static void replace_locked(void) {
    delete_locked();
    assert_int_equal(nqm_claim(scratch_path("locked"), &other_claim, NULL), NQM_OK);
    assert_true(other_claim >= 0);
}

/* A lock on a deleted file would exclude nobody. */
TEST(locks_are_on_the_file_of_the_path) {
    int claim, second;
    char path[128];
    snprintf(path, sizeof path, "%s", scratch_path("locked"));
    nqm_lock_hook(delete_locked);
    assert_int_equal(nqm_claim(path, &claim, NULL), NQM_OK);
    assert_true(claim >= 0);
    assert_int_equal(access(scratch_path("locked.claim"), F_OK), 0); /* a new file, which is there */
    assert_int_equal(nqm_claim(path, &second, NULL), NQM_OK);
    assert_int_equal(second, -1);
    close(claim);
    nqm_lock_hook(replace_locked);
    assert_int_equal(nqm_claim(path, &claim, NULL), NQM_OK);
    assert_int_equal(claim, -1); /* the third process has it */
    close(other_claim);
    assert_int_equal(nqm_claim(path, &claim, NULL), NQM_OK);
    assert_true(claim >= 0);
    close(claim);
}

enum { N_ITEMS = 12 };

/* A job whose items append their number to a file and create their own. */
typedef struct job {
    const char *name;
    char path[N_ITEMS][128];
    bool has_files;
    int kill_at, fail_at;                /* items at which the process is killed, or that fail; -1: none */
    atomic_int n_made, n_loaded, n_left; /* n_left: items before it is stopped */
} job;

static job make_job(const char *name) {
    job j = {.name = name, .has_files = true, .kill_at = -1, .fail_at = -1, .n_left = 1000};
    for (int i = 0; i < N_ITEMS; ++i)
        snprintf(j.path[i], sizeof j.path[i], "%s-%d", scratch_path(name), i);
    return j;
}

static const char *path_of(void *user, size_t item) {
    job *j = user;
    return j->has_files ? j->path[item] : NULL;
}

static bool load(void *user, size_t item) {
    job *j = user;
    if (access(j->path[item], F_OK) != 0)
        return false;
    atomic_fetch_add(&j->n_loaded, 1);
    return true;
}

static nqm_status make(void *user, size_t item, nqm_error *err) {
    job *j = user;
    if ((int)item == j->kill_at)
        raise(SIGKILL);
    if ((int)item == j->fail_at)
        return nqm_fail(err, NQM_ERR_NUMERIC, -1, "item %zu", item);
    atomic_fetch_add(&j->n_made, 1);
    atomic_fetch_sub(&j->n_left, 1);
    usleep(2000);
    FILE *file = j->has_files ? fopen(j->path[item], "wx") : NULL; /* fails if the item was made before */
    if (j->has_files && !file)
        return nqm_fail(err, NQM_ERR_IO, -1, "item %zu was made twice", item);
    return !file || fclose(file) == 0 ? NQM_OK : NQM_ERR_IO;
}

static bool is_stopped(void *user) {
    job *j = user;
    return atomic_load(&j->n_left) <= 0;
}

static nqm_status run_job(job *j, bool one_at_a_time, size_t first, nqm_error *err) {
    const nqm_shared_work work = {.n = N_ITEMS,
                                  .first = first,
                                  .one_at_a_time = one_at_a_time,
                                  .user = j,
                                  .path = path_of,
                                  .load = load,
                                  .make = make,
                                  .is_stopped = is_stopped};
    return nqm_shared_work_run(&work, err);
}

TEST(alone) {
    for (int one_at_a_time = 0; one_at_a_time < 2; ++one_at_a_time) {
        job j = make_job(one_at_a_time ? "single" : "threads");
        assert_int_equal(run_job(&j, one_at_a_time, 5, NULL), NQM_OK);
        assert_int_equal(j.n_made, N_ITEMS);
        char claim[160];
        snprintf(claim, sizeof claim, "%s.claim", j.path[3]);
        fclose(fopen(claim, "w")); /* a process was killed after it had saved the result */
        assert_int_equal(run_job(&j, one_at_a_time, 0, NULL), NQM_OK);
        assert_int_not_equal(access(claim, F_OK), 0);
        assert_int_equal(j.n_made, N_ITEMS);
        assert_int_equal(j.n_loaded, N_ITEMS);
        job unshared = make_job("unshared");
        unshared.has_files = false;
        assert_int_equal(run_job(&unshared, one_at_a_time, 0, NULL), NQM_OK);
        assert_int_equal(unshared.n_made, N_ITEMS);
        assert_int_equal(unshared.n_loaded, 0);
    }
}

/* Two processes; the second is killed in its third item, or not at all. Each item is made once. */
TEST(two_processes) {
    for (int killed = 0; killed < 2; ++killed) {
        job j = make_job(killed ? "killed" : "two");
        pid_t child = fork();
        if (child == 0) {
            j.kill_at = killed ? 8 : -1;
            _exit(run_job(&j, true, 6, NULL) == NQM_OK ? 0 : 1);
        }
        nqm_error err = {0};
        assert_int_equal(run_job(&j, true, 0, &err), NQM_OK);
        int end;
        assert_int_equal(waitpid(child, &end, 0), child);
        assert_true(killed || (WIFEXITED(end) && WEXITSTATUS(end) == 0));
        for (int i = 0; i < N_ITEMS; ++i)
            assert_int_equal(access(j.path[i], F_OK), 0);
    }
}

TEST(failures_and_stops) {
    nqm_limit_threads(2); /* fewer than items */
    for (int one_at_a_time = 0; one_at_a_time < 2; ++one_at_a_time) {
        nqm_error err = {0};
        job failing = make_job(one_at_a_time ? "failing1" : "failing");
        failing.fail_at = 3;
        assert_int_equal(run_job(&failing, one_at_a_time, 0, &err), NQM_ERR_NUMERIC);
        assert_string_equal(err.message, "item 3");
        job stopped = make_job(one_at_a_time ? "stopped1" : "stopped");
        stopped.n_left = 2;
        assert_int_equal(run_job(&stopped, one_at_a_time, 0, &err), NQM_ERR_CANCELLED);
        assert_in_range(stopped.n_made, 2, N_ITEMS - 1);
        stopped.n_left = 1000;
        assert_int_equal(run_job(&stopped, one_at_a_time, 0, &err), NQM_OK); /* goes on */
        assert_int_equal(stopped.n_made, N_ITEMS);
    }
}
