/* SPDX-License-Identifier: MIT
 *
 * Loading a file to samples at a model's directions.
 */
#include "bench/bench.h"

#include <string.h>

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

nqm_status nqm_bench_load(nqm_bench *bench, nqm_error *err) {
    nqm_directions *directions;
    nqm_status status = nqm_directions_create(NULL, 0, NULL, &directions, err);
    if (status != NQM_OK)
        return status;
    const size_t n = nqm_directions_get_info(directions).n;
    load_job job = {.directions = directions, .rgb = nqm_alloc(n, 3 * sizeof *job.rgb)};
    if (!job.rgb)
        status = nqm_fail_nomem(err, n * 3 * sizeof *job.rgb);
    for (size_t i = 0; i < bench->options.n_files && status == NQM_OK; ++i) {
        job.path = bench->options.files[i];
        status = bench_file(bench, &job, err);
    }
    nqm_free(job.rgb);
    nqm_directions_free(directions);
    return status;
}
