/* SPDX-License-Identifier: MIT
 *
 * nqm selftest - checks this build against stored values.
 */
#include "nqm/tool.h"

typedef struct check_output {
    json_t *checks; /* NULL: print lines */
    int n_passed, n_failed;
} check_output;

static void add_check(void *user, const char *name, int passed) {
    check_output *t = user;
    t->n_passed += passed != 0;
    t->n_failed += passed == 0;
    if (t->checks)
        json_array_append_new(t->checks, json_pack("{s:s,s:b}", "name", name, "passed", passed));
    else
        printf("%-6s  %s\n", passed ? "ok" : "FAILED", name);
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static bool json;

static const option options[] = {{"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0}, {0}};

static const command cmd = {
    .usage = "[options]",
    .about = "Check this build on this machine in about a second: matrix kernels against scalar loops; coordinates, "
             "the\n"
             "JOD curve and presets against published or independently computed values; the built-in models against\n"
             "their checksums and stored scores. Exit code 8 if a check fails.",
    .example = "nqm selftest",
    .options = options,
};

int cmd_selftest(int argc, char **argv) {
    parse_arguments(&cmd, argc, argv);
    check_output t = {.checks = json ? json_array() : NULL};
    double begin = nqm_clock_s();
    nqm_error err = {0};
    nqm_status status = nqm_selftest(add_check, &t, &err);
    const int exit_code = status == NQM_OK ? EXIT_OK : report_error(&err);
    if (json)
        print_document(json_pack("{s:i,s:i,s:o}", "passed", t.n_passed, "failed", t.n_failed, "checks", t.checks));
    else
        printf("\n%d passed, %d failed, %.1f s; nqm %s, %s\n", t.n_passed, t.n_failed, nqm_clock_s() - begin,
               nqm_version(), nqm_build_info());
    return exit_code;
}
