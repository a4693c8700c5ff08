/* SPDX-License-Identifier: MIT
 *
 * nqm nearest - the materials of a library that look most like one: those with the best estimates by pictures are
 * scored and ranked.
 */
#include "nqm/library/library.h"
#include "nqm/rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static score_run run;
static const char *model = "default", *among, *index_path;
static bool is_apart;
static uint64_t n_shown = 10;

typedef struct scan_job {
    const nqm_gallery *one; /* picture 0 is that of the material; the others are those of the library */
    const library *among;
    float *jod; /* (n) */
} scan_job;

enum { BLOCK = 1024 };

static void scan(void *user, size_t block) {
    const scan_job *job = user;
    const size_t first = block * BLOCK, n = nqm_smaller(job->among->n - first, BLOCK);
    nqm_gallery_jods(job->one, 0, job->among->gallery, first, n, is_apart, job->jod + first);
}

/* The numbers of the members, the best estimates first. free() them. */
static size_t *find_candidates(const nqm_gallery *one, const library *of) {
    scan_job job = {one, of, allocate(of->n, sizeof *job.jod)};
    double *keys = allocate(of->n, sizeof *keys);
    nqm_parallel_for(nqm_ceil_div(of->n, BLOCK), scan, &job);
    for (size_t i = 0; i < of->n; ++i)
        keys[i] = (double)job.jod[i];
    size_t *candidates = order_by(of->n, keys, -1);
    free(keys);
    free(job.jod);
    return candidates;
}

/* A score of textures takes a second: of candidates with one, twice as many are scored as are shown. Returns how many remain. */
static size_t leave_textured(const member *self, const library *of, size_t *candidates, size_t n) {
    size_t n_left = 0, n_textured = 0;
    for (size_t i = 0; i < n; ++i) {
        const bool is_textured = self->is_textured || of->members[candidates[i]].is_textured;
        if (!is_textured || n_textured++ < 2 * (size_t)n_shown)
            candidates[n_left++] = candidates[i];
    }
    return n_left;
}

static void score_candidates(const char *to, const library *of, const size_t *candidates, size_t n) {
    begin_rows(&run, n);
    run.near_only = true;
    for (size_t i = 0; i < n; ++i) {
        const char *argument = of->members[candidates[i]].argument;
        run.rows[i] = (scored_pair){.pair = {to, argument}, .name = argument};
    }
    make_scores(&run);
}

static const option options[] = {
    {"among", 0, OPTION_NEEDED, &among, "WHERE", "folder, or file of several materials", 0, 0},
    {"number", 'n', OPTION_COUNT, &n_shown, "N", "how many to print", 1, 1000},
    {"apart", 0, OPTION_FLAG, &is_apart, NULL, "by the similarity to people who do not see both at once", 0, 0},
    {"index", 0, OPTION_TEXT, &index_path, "FILE.index", "keep the pictures of WHERE here for later runs", 0, 0},
    OPTION_ROWS_MODEL(&model),
    OPTION_ROW_IGNORE,
    {"json", 0, OPTION_FORMAT, &run.format, NULL, "print JSON", FORMAT_JSON, 0},
    {"csv", 0, OPTION_FORMAT, &run.format, NULL, "print CSV", FORMAT_CSV, 0},
    {"quiet", 'q', OPTION_FORMAT, &run.format, NULL, "print the names only, most alike first", FORMAT_QUIET, 0},
    {0}};

static const command cmd = {
    .usage = "BRDF --among WHERE... [options]",
    .about = "The materials of folders or files that look most like BRDF, with their scores as of `nqm rank`. All are"
             " compared by pictures, and the best are scored. With --index a later run opens none but these.",
    .example =
        "nqm nearest sgd:nickel --among metals\nnqm nearest 'lambert:kd=.5,.2,.1' --among library.glb --apart -n 3",
    .options = options,
    .table = &nqm_score_option_table,
    .table_target = &run.options,
    .min_arguments = 1,
    .max_arguments = -1,
};

int cmd_nearest(int argc, char **argv) {
    enum { LEAST_SCORED = 128 };
    library of = {.path = NULL}, one = {.path = NULL};
    run.options = plain_score_options();
    const int n = parse_arguments(&cmd, argc, argv);
    refuse_model_name(argv[0]);
    run.model = open_model(model);
    nqm_scorer *scorer = open_scorer(run.model, &run.options);
    must(nqm_gallery_create(run.model, 1, NULL, &one.gallery, &fault));
    const member self = member_of(argv[0]);
    nqm_error err;
    draw_member(&self, run.model, scorer, one.gallery, 0, &err);
    if (err.status != NQM_OK)
        stop_error(&err);
    const char **where = (const char **)argv;
    where[0] = among;
    draw_library((size_t)n, where, run.model, scorer, index_path, &of);
    nqm_scorer_free(scorer);
    const size_t n_best = nqm_smaller(of.n, nqm_larger(LEAST_SCORED, 4 * (size_t)n_shown));
    size_t *candidates = find_candidates(one.gallery, &of);
    score_candidates(self.argument, &of, candidates, leave_textured(&self, &of, candidates, n_best));
    rank_rows(&run, is_apart);
    run.n_rows = nqm_smaller(run.n_rows, (size_t)n_shown);
    print_ranking(&run);
    const int exit_code = report_faults(&run);
    free(candidates);
    free_library(&one);
    free_scores(&run);
    const size_t n_failed = of.n_failed;
    free_library(&of);
    return exit_code == EXIT_OK && n_failed ? EXIT_PARTIAL : exit_code;
}
