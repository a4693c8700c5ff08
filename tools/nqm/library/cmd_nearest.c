/* SPDX-License-Identifier: MIT
 *
 * nqm nearest - the materials of a library that look most like one: those with the best estimates by pictures are
 * scored and ranked.
 */
#include "nqm/rows.h"
#include "nqm/score/score.h"
#include "nqm/textured.h"

static score_run run;
static const char *model = "default", *among, *index_path;
static bool is_apart;
static uint64_t n_shown = 10;

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

/* Before the library is read, which may take long. */
static void check_brdf(const char *argument) {
    nqm_brdf *brdf = NULL;
    refuse_model_name(argument);
    if (!is_textured(argument))
        must(nqm_brdf_open(argument, &brdf, &fault));
    nqm_brdf_free(brdf);
}

int cmd_nearest(int argc, char **argv) {
    run.options = plain_score_options();
    const int n = parse_arguments(&cmd, argc, argv);
    const char *to = argv[0];
    check_brdf(to);
    run.model = open_model(model);
    argv[0] = (char *)(uintptr_t)among;
    nqm_library *of = open_library((size_t)n, (const char *const *)argv, &run, index_path);
    find_near(of, &(nqm_library_query){.to = to, .n = (size_t)n_shown, .is_apart = is_apart}, &run);
    rank_rows(&run, is_apart);
    run.n_rows = nqm_smaller(run.n_rows, (size_t)n_shown);
    print_ranking(&run);
    return conclude_near(of, &run);
}
