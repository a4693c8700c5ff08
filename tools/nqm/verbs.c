/* SPDX-License-Identifier: MIT
 *
 * The verbs of the tool, each in a file cmd_*.c.
 */
#include "base/names.h"
#include "nqm/help.h"

#include <string.h>

const verb verbs[] = {
    {"score", cmd_score, "predict how good approximations look compared with their reference (JOD)"},
    {"batch", cmd_batch, "score a list of pairs; an interrupted run is continued"},
    {"rank", cmd_rank, "order approximations by their score"},
    {"diff", cmd_diff, "compare two versions of the materials of a file or folder"},
    {"dedup", cmd_dedup, "find materials of a library that look the same"},
    {"nearest", cmd_nearest, "find the materials of a library that look most like one"},
    {"info", cmd_info, "describe a BRDF, model or dataset file; `nqm info list` names the presets"},
    {"check", cmd_check, "test reciprocity, energy conservation and positivity of a BRDF"},
    {"sample", cmd_sample, "evaluate f_r of a BRDF at a list of directions, as CSV"},
    {"directions", cmd_directions, "make or print sampling directions"},
    {"conform", cmd_conform, "test a shader against its specification, and name its mistake"},
    {"convert", cmd_convert, "write a BRDF as a table, MERL .binary"},
    {"fit", cmd_fit, "fit an analytic model, a network or a table to a BRDF"},
    {"translate", cmd_translate, "write materials as another renderer's materials, and say what is lost"},
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
    {"selftest", cmd_selftest, "check this build against stored values"},
    {"doctor", cmd_doctor, "check this installation, and say what to do where it does not work"},
    {"help", cmd_help, "print this text or the help of a verb; man pages and completions of shells"},
    {NULL, NULL, NULL},
};

void print_usage(FILE *out) {
    fputs("usage: nqm VERB [arguments]\n\n"
          "Predicts how good a BRDF approximation looks compared with its reference, in JOD, without rendering.\n\n",
          out);
    for (const verb *v = verbs; v->name; ++v)
        fprintf(out, "  %-11s %s\n", v->name, v->summary);
    fputs("\n`nqm VERB --help` describes a verb, with an example; `nqm --version` lists the libraries of this build.\n"
          "example: nqm score sgd:nickel ward:nickel\n",
          out);
}

void print_version(void) {
    printf("nqm %s\n%s\n%s\n", nqm_version(), nqm_build_info(), tool_build_info());
}

const verb *find_verb(const char *name) {
    const verb *v = verbs;
    while (v->name && strcmp(v->name, name) != 0)
        ++v;
    return v->name ? v : NULL;
}

int report_no_verb(const char *name) {
    nqm_nearest nearest = nqm_nearest_begin(name);
    for (const verb *v = verbs; v->name; ++v)
        nqm_nearest_add(&nearest, v->name);
    nqm_nearest_add(&nearest, "--version");
    nqm_nearest_add(&nearest, "--help");
    fprintf(stderr, "nqm: there is no verb '%s'%s; `nqm --help` lists them\n", shown(name), nearest.advice);
    return EXIT_USAGE;
}
