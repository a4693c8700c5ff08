/* SPDX-License-Identifier: MIT
 *
 * nqm - predicts how good a BRDF approximation looks compared with its reference. This file calls the verb.
 */
#include "nqm/help.h"

#include <stdlib.h>
#include <string.h>

/* NQM_KERNELS=NAME selects the kernels, instead of the best ones, for tests and comparisons. */
static int choose_kernels(void) {
    nqm_error err = {0};
    const char *name = getenv("NQM_KERNELS");
    if (!name || !*name || nqm_kernels_select(name, &err) == NQM_OK)
        return EXIT_OK;
    fprintf(stderr, "nqm: NQM_KERNELS: %s; choose one of:", err.message);
    for (size_t i = 0; nqm_kernels_name(i); ++i)
        fprintf(stderr, " %s", nqm_kernels_name(i));
    fputc('\n', stderr);
    return EXIT_USAGE;
}

int main(int argc, char **argv) {
    static char help[] = "help";
    catch_interrupt();
    if (choose_kernels() != EXIT_OK)
        return EXIT_USAGE;
    if (argc < 2) {
        print_usage(stderr);
        return EXIT_USAGE;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)
        argv[1] = help;
    if (strcmp(argv[1], "--version") == 0) {
        printf("nqm %s\n%s\n%s\n", nqm_version(), nqm_build_info(), tool_build_info());
        return EXIT_OK;
    }
    const verb *v = find_verb(argv[1]);
    if (!v)
        return report_no_verb(argv[1]);
    set_verb(v->name);
    return finish(v->run(argc - 1, argv + 1));
}
