/* SPDX-License-Identifier: MIT
 *
 * nqm - how good a BRDF approximation looks beside its reference. This file finds the verb; each is a cmd_*.c file.
 */
#include "nqm/tool.h"

#include <stdlib.h>
#include <string.h>

typedef struct verb {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *summary;
} verb;

static const verb verbs[] = {
    {"score", cmd_score, "how good approximations look beside their reference (JOD)"},
    {"batch", cmd_batch, "scores of a list of pairs; goes on where it was stopped"},
    {"rank", cmd_rank, "order approximations by how good they look"},
    {"info", cmd_info, "what a BRDF, model or dataset file holds; `nqm info list` names the presets"},
    {"check", cmd_check, "reciprocity, energy conservation and positivity of a BRDF"},
    {"sample", cmd_sample, "f_r of a BRDF at a list of directions, as CSV"},
    {"directions", cmd_directions, "make or show the sampling directions"},
    {"convert", cmd_convert, "write a BRDF as a MERL .binary table"},
    {"fit", cmd_fit, "fit an analytic model to a BRDF"},
    {"learn", cmd_learn, "learn what an encoding leans on: a dictionary or a hypernetwork"},
    {"render", cmd_render, "pictures of a BRDF on a lit shape"},
    {"label", cmd_label, "Delta-E ITP and JOD of a pair by rendering"},
    {"dataset", cmd_dataset, "make a training corpus from a list of materials"},
    {"regress", cmd_regress, "fit the curve from Delta-E ITP to JOD to human scores"},
    {"train", cmd_train, "train a model on a dataset"},
    {"calibrate", cmd_calibrate, "give a model the intervals around its JOD"},
    {"eval", cmd_eval, "compare a model and the baseline metrics with labels"},
    {"reproduce", cmd_reproduce, "the paper's study on its authors' data: which of its figures come out"},
    {"report", cmd_report, "one page with pictures, scores and differences, for people to read"},
    {"plot", cmd_plot, "drawings of labels, evaluations, trainings, models and BRDFs"},
    {"models", cmd_models, "the models that are built in"},
    {"bench", cmd_bench, "how fast this build is on this machine, beside what the machine can do"},
    {"selftest", cmd_selftest, "check this build against golden values"},
    {NULL, NULL, NULL}};

static void print_usage(FILE *out) {
    fputs("usage: nqm VERB [arguments]\n\n"
          "How good does a BRDF approximation look beside its reference? Scores in JOD, no rendering.\n\n",
          out);
    for (const verb *v = verbs; v->name; ++v)
        fprintf(out, "  %-11s %s\n", v->name, v->summary);
    fputs("\n`nqm VERB --help` explains a verb, with an example; `nqm --version` says what is in this build.\n"
          "example: nqm score sgd:nickel ward:nickel\n",
          out);
}

/* Results that did not arrive (a full disk) are a failure, whatever the verb. */
static int settle(int exit_code) {
    if (fflush(stdout) == 0 && !ferror(stdout))
        return exit_code;
    if (exit_code != EXIT_OK)
        return exit_code; /* the verb has said why */
    fputs("nqm: standard output: cannot write\n", stderr);
    return EXIT_OPEN;
}

/* NQM_KERNELS=NAME: one way to compute instead of the best one, for tests and comparisons. */
static int choose_kernels(void) {
    nqm_error err = {0};
    const char *name = getenv("NQM_KERNELS");
    if (!name || !*name || nqm_kernels_select(name, &err) == NQM_OK)
        return EXIT_OK;
    fprintf(stderr, "nqm: NQM_KERNELS: %s; there are:", err.message);
    for (size_t i = 0; nqm_kernels_name(i); ++i)
        fprintf(stderr, " %s", nqm_kernels_name(i));
    fputc('\n', stderr);
    return EXIT_USAGE;
}

int main(int argc, char **argv) {
    static char help_option[] = "--help";
    catch_interrupt();
    if (choose_kernels() != EXIT_OK)
        return EXIT_USAGE;
    if (argc < 2) {
        print_usage(stderr);
        return EXIT_USAGE;
    }
    if (argc == 3 && strcmp(argv[1], "help") == 0) { /* nqm help VERB is nqm VERB --help */
        argv[1] = argv[2];
        argv[2] = help_option;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 || strcmp(argv[1], "help") == 0) {
        print_usage(stdout);
        return EXIT_OK;
    }
    if (strcmp(argv[1], "--version") == 0) {
        printf("nqm %s\n%s\n%s\n", nqm_version(), nqm_build_info(), tool_build_info());
        return EXIT_OK;
    }
    for (const verb *v = verbs; v->name; ++v)
        if (strcmp(argv[1], v->name) == 0)
            return settle(v->run(argc - 1, argv + 1));
    fprintf(stderr, "nqm: there is no verb '%s'; `nqm --help` lists them\n", argv[1]);
    return EXIT_USAGE;
}
