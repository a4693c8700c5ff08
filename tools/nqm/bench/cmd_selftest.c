/* SPDX-License-Identifier: MIT
 *
 * nqm selftest - check this build against golden values.
 */
#include "nqm/tool.h"

#include <time.h>

/* Lines as they come, or collected for JSON. */
typedef struct talk {
    json_t *checks; /* NULL: print */
    int n_passed, n_failed;
} talk;

static void take_check(void *user, const char *name, int passed) {
    talk *t = user;
    t->n_passed += passed != 0;
    t->n_failed += passed == 0;
    if (t->checks)
        json_array_append_new(t->checks, json_pack("{s:s,s:b}", "name", name, "passed", passed));
    else
        printf("%-6s  %s\n", passed ? "ok" : "FAILED", name);
}

static double now_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int cmd_selftest(int argc, char **argv) {
    bool json = false;
    const option options[] = {{"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0}, {0}};
    const command cmd = {
        .name = "selftest",
        .usage = "[options]",
        .about = "Check this build on this machine, in about a second: matrix kernels against plain loops, "
                 "coordinates, the\n"
                 "JOD curve and presets against published or independently computed values, and the built-in models "
                 "against\n"
                 "their checksums and the scores that were stored when they were made. Exit code 8 when a check fails.",
        .example = "nqm selftest",
        .options = options,
        .min_arguments = 0,
        .max_arguments = 0,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    talk t = {.checks = json ? json_array() : NULL};
    double begin = now_s();
    nqm_error err = {0};
    nqm_status status = nqm_selftest(take_check, &t, &err);
    if (status != NQM_OK)
        exit_code = report_error("selftest", &err);
    else
        exit_code = EXIT_OK;
    if (json)
        print_json(json_pack("{s:i,s:o,s:i,s:i,s:o}", "schema", 1, "tool", json_tool(), "passed", t.n_passed, "failed",
                             t.n_failed, "checks", t.checks));
    else
        printf("\n%d passed, %d failed, %.1f s; nqm %s, %s\n", t.n_passed, t.n_failed, now_s() - begin, nqm_version(),
               nqm_build_info());
    return exit_code;
}
