/* SPDX-License-Identifier: MIT
 *
 * nqm - predicts how good a BRDF approximation looks compared with its reference. This file calls the verb; each is in a
 * file cmd_*.c.
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
    {"score", cmd_score, "predict how good approximations look compared with their reference (JOD)"},
    {"batch", cmd_batch, "score a list of pairs; an interrupted run is continued"},
    {"rank", cmd_rank, "order approximations by their score"},
    {"info", cmd_info, "describe a BRDF, model or dataset file; `nqm info list` names the presets"},
    {"check", cmd_check, "test reciprocity, energy conservation and positivity of a BRDF"},
    {"sample", cmd_sample, "evaluate f_r of a BRDF at a list of directions, as CSV"},
    {"directions", cmd_directions, "make or print sampling directions"},
    {"convert", cmd_convert, "write a BRDF as a table, MERL .binary"},
    {"fit", cmd_fit, "fit an analytic model, a network or a table to a BRDF"},
    {"learn", cmd_learn, "train the dictionary or hypernetwork that an encoding needs"},
    {"render", cmd_render, "render pictures of a BRDF on a lit shape"},
    {"label", cmd_label, "compute Delta-E ITP and JOD of pairs by rendering"},
    {"dataset", cmd_dataset, "make a training corpus from a list of materials"},
    {"regress", cmd_regress, "fit the curve from Delta-E ITP to JOD to human scores"},
    {"transport", cmd_transport, "make a metric for a scene of your own, without training"},
    {"train", cmd_train, "train a model on a dataset"},
    {"calibrate", cmd_calibrate, "calibrate the intervals around the JOD of a model"},
    {"eval", cmd_eval, "compare a model and the baseline metrics with labels"},
    {"report", cmd_report, "write a page with pictures, scores and differences"},
    {"plot", cmd_plot, "draw labels, evaluations, trainings, models and BRDFs"},
    {"models", cmd_models, "list and describe the built-in models"},
    {"bench", cmd_bench, "measure the speed of this build and the limits of this machine"},
    {"selftest", cmd_selftest, "check this build against stored values"},
    {NULL, NULL, NULL}};

static void print_usage(FILE *out) {
    fputs("usage: nqm VERB [arguments]\n\n"
          "Predicts how good a BRDF approximation looks compared with its reference, in JOD, without rendering.\n\n",
          out);
    for (const verb *v = verbs; v->name; ++v)
        fprintf(out, "  %-11s %s\n", v->name, v->summary);
    fputs("\n`nqm VERB --help` describes a verb, with an example; `nqm --version` lists the libraries of this build.\n"
          "example: nqm score sgd:nickel ward:nickel\n",
          out);
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
        if (strcmp(argv[1], v->name) == 0) {
            set_verb(v->name);
            return finish(v->run(argc - 1, argv + 1));
        }
    fprintf(stderr, "nqm: there is no verb '%s'; `nqm --help` lists them\n", argv[1]);
    return EXIT_USAGE;
}
