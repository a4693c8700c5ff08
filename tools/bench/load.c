/* SPDX-License-Identifier: MIT
 *
 * Loading a file to samples at a model's directions, and whole commands.
 */
#include "bench/bench.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct load_job {
    const char *path;
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

static nqm_status bench_file(nqm_bench *bench, load_job *job, nqm_error *err) {
    const char *slash = strrchr(job->path, '/');
    nqm_bench_entry entry = nqm_bench_entry_make("load", "to samples", run_load, job);
    nqm_bench_count(&entry, "threads", 1);
    nqm_bench_text(&entry, "subject", slash ? slash + 1 : job->path);
    nqm_status status = nqm_bench_race(bench, 1, &entry, err);
    if (status == NQM_OK && job->status != NQM_OK) {
        status = job->status;
        if (err)
            *err = job->err;
    }
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
        nqm_bench_entry entry = nqm_bench_entry_make("load", "start to end", run_command, &jobs[i]);
        nqm_bench_text(&entry, "subject", names[i]);
        status = nqm_bench_race(bench, 1, &entry, err);
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
    const size_t n = nqm_directions_count(directions);
    load_job job = {.directions = directions, .rgb = nqm_alloc(n, 3 * sizeof *job.rgb)};
    if (!job.rgb)
        status = nqm_fail_nomem(err, n * 3 * sizeof *job.rgb);
    for (size_t i = 0; i < bench->options.n_files && status == NQM_OK; ++i) {
        job.path = bench->options.files[i];
        status = bench_file(bench, &job, err);
    }
    nqm_free(job.rgb);
    nqm_directions_free(directions);
    return status == NQM_OK ? bench_commands(bench, err) : status;
}
