/* SPDX-License-Identifier: MIT
 *
 * Loading a file to samples at a model's directions, with its pages in memory and after they were dropped; and whole
 * commands.
 */
#include "bench/bench.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* ---- files ------------------------------------------------------------------------------------------------------- */

typedef struct load_job {
    const char *path;
    int fd; /* descriptor of the same file, to drop its pages; -1: not a file */
    const nqm_directions *directions;
    float *rgb; /* (n_directions, 3) */
    nqm_status status;
    nqm_error err;
} load_job;

static void run_load(void *user) {
    load_job *j = user;
    nqm_brdf *brdf;
    if (j->status != NQM_OK)
        return;
    j->status = nqm_brdf_open(j->path, &brdf, &j->err);
    if (j->status == NQM_OK)
        j->status = nqm_sample(brdf, j->directions, NQM_INVALID_DROP, j->rgb, NULL, NULL, &j->err);
    nqm_brdf_free(brdf);
}

static void drop_pages(void *user) {
    posix_fadvise(((const load_job *)user)->fd, 0, 0, POSIX_FADV_DONTNEED);
}

static nqm_status bench_file(nqm_bench *bench, load_job *job, const char *name, nqm_error *err) {
    struct stat facts;
    nqm_bench_entry entries[2] = {nqm_bench_entry_make("load", "warm"), nqm_bench_entry_make("load", "cold")};
    const nqm_bench_contender contenders[2] = {{run_load, job, NULL}, {run_load, job, drop_pages}};
    for (size_t i = 0; i < 2; ++i) {
        nqm_bench_count(&entries[i], "threads", 1);
        nqm_bench_text(&entries[i], "subject", name);
        if (job->fd >= 0 && fstat(job->fd, &facts) == 0)
            entries[i].megabytes = 1e-6 * (double)facts.st_size;
    }
    if (job->fd < 0)
        json_decref(entries[1].row);
    nqm_status status = nqm_bench_race(bench, job->fd >= 0 ? 2 : 1, contenders, entries, err);
    if (status == NQM_OK && job->status != NQM_OK) {
        status = job->status;
        if (err)
            *err = job->err;
    }
    return status;
}

/* ---- a MERL table ------------------------------------------------------------------------------------------------ */

static const char merl_spec[] = "ggx:kd=.2,.1,.05;ks=.5;alpha=.1;f0=.1";

/* Write a table, open it and remove its name: it is opened again by its path under /proc, and vanishes with this
 * process. */
static nqm_status make_merl(const char *folder, int *fd_ret, nqm_error *err) {
    *fd_ret = -1;
    const size_t n = strlen(folder) + 32;
    char *path = nqm_alloc(n, 1);
    nqm_brdf *brdf = NULL;
    if (!path)
        return nqm_fail_nomem(err, n);
    snprintf(path, n, "%s/nqm-bench-%ld.binary", folder, (long)getpid());
    nqm_status status = nqm_brdf_open(merl_spec, &brdf, err);
    if (status == NQM_OK)
        status = nqm_brdf_write(brdf, NQM_TABLE_MERL, path, NULL, NULL, err);
    if (status == NQM_OK) {
        *fd_ret = open(path, O_RDONLY | O_CLOEXEC);
        if (*fd_ret < 0)
            status = nqm_fail(err, NQM_ERR_IO, -1, "%s: %s", path, strerror(errno));
        unlink(path);
    }
    nqm_brdf_free(brdf);
    nqm_free(path);
    return status;
}

static nqm_status bench_merl(nqm_bench *bench, const load_job *like, const char *folder, nqm_error *err) {
    char path[64];
    load_job job = *like;
    nqm_status status = make_merl(folder, &job.fd, err);
    if (status != NQM_OK)
        return status;
    snprintf(path, sizeof path, "/proc/self/fd/%d", job.fd);
    job.path = path;
    status = bench_file(bench, &job, "MERL table", err);
    close(job.fd);
    return status;
}

static nqm_status bench_files(nqm_bench *bench, const nqm_directions *directions, nqm_error *err) {
    const nqm_bench_options *o = &bench->options;
    load_job job = {.directions = directions, .rgb = nqm_alloc(nqm_directions_count(directions), 3 * sizeof *job.rgb)};
    if (!job.rgb)
        return nqm_fail_nomem(err, nqm_directions_count(directions) * 3 * sizeof *job.rgb);
    nqm_status status = bench_merl(bench, &job, o->temporary, err);
    for (size_t i = 0; i < o->n_files && status == NQM_OK; ++i) {
        const char *slash = strrchr(o->files[i], '/');
        job.path = o->files[i];
        job.fd = open(job.path, O_RDONLY | O_CLOEXEC);
        status = bench_file(bench, &job, slash ? slash + 1 : job.path, err);
        if (job.fd >= 0)
            close(job.fd);
    }
    nqm_free(job.rgb);
    return status;
}

/* ---- commands ---------------------------------------------------------------------------------------------------- */

typedef struct command_job {
    const char *tool;    /* path of the program */
    const char *argv[6]; /* a NULL ends them */
    bool failed;
} command_job;

static void run_command(void *user) {
    command_job *j = user;
    extern char **environ;
    posix_spawn_file_actions_t actions;
    pid_t child;
    int how;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    bool ok = posix_spawn(&child, j->tool, &actions, NULL, (char *const *)(uintptr_t)j->argv, environ) == 0;
    posix_spawn_file_actions_destroy(&actions);
    while (ok && waitpid(child, &how, 0) < 0 && errno == EINTR)
        ;
    j->failed = j->failed || !ok || !WIFEXITED(how) || WEXITSTATUS(how) != 0;
}

/* The start of the tool in the folder of this program, and a first score; not on a system without /proc. */
static nqm_status bench_commands(nqm_bench *bench, nqm_error *err) {
    char tool[4096];
    const ssize_t n = readlink("/proc/self/exe", tool, sizeof tool - sizeof "/nqm");
    tool[n > 0 ? n : 0] = '\0';
    char *slash = strrchr(tool, '/');
    if (!slash)
        return NQM_OK;
    strcpy(slash, "/nqm"); /* has room for it */
    command_job jobs[] = {{tool, {"nqm", "--version"}, false},
                          {tool, {"nqm", "score", "sgd:nickel", "ward:nickel", "-q"}, false}};
    static const char *const names[] = {"nqm --version", "nqm score sgd:nickel ward:nickel"};
    nqm_status status = NQM_OK;
    for (size_t i = 0; i < 2 && status == NQM_OK; ++i) {
        nqm_bench_entry entry = nqm_bench_entry_make("load", "start to end");
        const nqm_bench_contender contender = {run_command, &jobs[i], NULL};
        nqm_bench_text(&entry, "subject", names[i]);
        status = nqm_bench_race(bench, 1, &contender, &entry, err);
        if (status == NQM_OK && jobs[i].failed)
            status =
                nqm_fail(err, NQM_ERR_IO, -1, "%s: '%s' failed: build the tool beside this program", tool, names[i]);
    }
    return status;
}

nqm_status nqm_bench_load(nqm_bench *bench, nqm_error *err) {
    nqm_directions *directions;
    nqm_status status = nqm_directions_create(NULL, 0, NULL, &directions, err);
    if (status != NQM_OK)
        return status;
    status = bench_files(bench, directions, err);
    nqm_directions_free(directions);
    return status == NQM_OK ? bench_commands(bench, err) : status;
}
