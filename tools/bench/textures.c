/* SPDX-License-Identifier: MIT
 *
 * The near score of two textured materials whose maps are in memory; the limit is the reading of all maps once.
 */
#include "bench/bench.h"
#include <nqm/texture.h>

#include <math.h>

typedef struct texture_job {
    const nqm_model *model;
    nqm_texture *ref, *test;
    nqm_status status;
    nqm_error err;
} texture_job;

static void run_near(void *user) {
    texture_job *j = user;
    nqm_texture_options options = nqm_texture_options_default();
    nqm_texture_result result;
    options.blame = options.far = 0;
    if (j->status == NQM_OK)
        j->status = nqm_texture_score(j->model, j->ref, j->test, &options, &result, NULL, &j->err);
}

/* Smooth colours and roughness with grain that differs by the seed. */
static nqm_status make_texture(size_t side, uint64_t seed, nqm_texture **texture_ret, nqm_error *err) {
    const size_t n = side * side;
    float *colour, *rough;
    *texture_ret = NULL;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&colour, n, 3 * sizeof *colour}, {&rough, n, sizeof *rough}), err);
    if (status != NQM_OK)
        return status;
    for (size_t i = 0; i < n; ++i) {
        const double x = (double)(i % side) / (double)side, y = (double)(i / side) / (double)side;
        const double grain = (double)(nqm_hash_u64(seed, i) >> 56) / 256;
        for (size_t c = 0; c < 3; ++c)
            colour[3 * i + c] = (float)(0.3 + 0.2 * sin(6 * x + (double)c) + 0.1 * grain);
        rough[i] = (float)(0.4 + 0.2 * cos(9 * y) + 0.1 * grain);
    }
    const nqm_texture_map maps[] = {{"base_color", side, side, 3, colour}, {"roughness", side, side, 1, rough}};
    status = nqm_texture_create("gltf:metallic=1", 2, maps, texture_ret, err);
    nqm_free(colour);
    return status;
}

nqm_status nqm_bench_textures(nqm_bench *bench, const nqm_model *model, nqm_error *err) {
    const size_t side = bench->options.quick ? 128 : 2048;
    texture_job job = {.model = model};
    const nqm_bench_contender contender = {run_near, &job, NULL};
    nqm_status status = make_texture(side, 1, &job.ref, err);
    if (status == NQM_OK)
        status = make_texture(side, 2, &job.test, err);
    nqm_bench_entry entry = nqm_bench_entry_make("score", "texels of two materials, near");
    nqm_bench_text(&entry, "model", "default");
    nqm_bench_count(&entry, "pairs", side * side);
    nqm_bench_entry_reading(bench, &entry, 2 * side * side * 4 * sizeof(float));
    if (status == NQM_OK)
        status = nqm_bench_race(bench, 1, &contender, &entry, err);
    else
        json_decref(entry.row);
    if (status == NQM_OK && job.status != NQM_OK) {
        status = job.status;
        if (err)
            *err = job.err;
    }
    nqm_texture_free(job.ref);
    nqm_texture_free(job.test);
    return status;
}
