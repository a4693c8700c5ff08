/* SPDX-License-Identifier: MIT
 *
 * nqm - predicts how good a BRDF approximation looks compared with its reference. This file prepares the process and calls the
 * verb.
 */
#include "argument/argument.h"
#include "kernel/kernel.h"
#include "nqm/help.h"

#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

/* Open closed standard streams, in the direction in which using them fails as before. Otherwise a file that a verb opens gets the
 * number of standard error, and messages are written into it. */
static void reserve_standard_streams(void) {
    static const int modes[] = {O_WRONLY, O_RDONLY, O_RDONLY};
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd)
        if (fcntl(fd, F_GETFD) == -1 && open("/dev/null", modes[fd]) != fd)
            exit(EXIT_OPEN);
}

/* Some functions have arrays of 500 KB. Threads get the same limit as the process. */
static int check_stack(void) {
    enum { LEAST_KB = 1024 };
    struct rlimit limit;
    if (getrlimit(RLIMIT_STACK, &limit) != 0 || limit.rlim_cur >= (rlim_t)LEAST_KB * 1024)
        return EXIT_OK;
    fprintf(stderr, "nqm: the stack is limited to %lu KB and needs %d: ulimit -s %d\n",
            (unsigned long)(limit.rlim_cur / 1024), LEAST_KB, LEAST_KB);
    return EXIT_LIMIT;
}

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

static bool has_result; /* the exit code is that of a verb */

/* libgomp ends the process with exit code 1, which is that of a failed gate, when it cannot create a thread. */
static void report_lost_thread(int exit_code, void *unused) {
    (void)unused;
    if (exit_code != EXIT_FAILURE || has_result)
        return;
    abandon_outputs();
    report(EXIT_LIMIT, "a thread cannot be created: raise the limits (ulimit -v, ulimit -u), or set OMP_NUM_THREADS=1");
    _exit(EXIT_LIMIT);
}

int main(int argc, char **argv) {
    static char help[] = "help";
    on_exit(report_lost_thread, NULL);
    reserve_standard_streams();
    nqm_roles_enforce();
    nqm_argument_files_share();
    signal(SIGXFSZ, SIG_IGN); /* a file beyond `ulimit -f` is an error of writing, which is reported and cleans up */
    catch_interrupt();
    stop_without_json_memory();
    if (check_stack() != EXIT_OK)
        return EXIT_LIMIT;
    if (choose_kernels() != EXIT_OK)
        return EXIT_USAGE;
    if (argc < 2) {
        print_usage(stderr);
        return EXIT_USAGE;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)
        argv[1] = help;
    if (strcmp(argv[1], "--version") == 0) {
        print_version();
        return EXIT_OK;
    }
    --argc;
    ++argv;
    rename_former_verb(&argc, &argv);
    const verb *v = find_verb(argv[0]);
    if (!v)
        return report_no_verb(argv[0]);
    set_verb(v->name);
    const int exit_code = finish(v->run(argc, argv));
    has_result = true;
    return exit_code;
}
