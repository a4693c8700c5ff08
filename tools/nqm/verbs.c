/* SPDX-License-Identifier: MIT
 *
 * The verbs of the tool, each in a file cmd_*.c.
 */
#include "io/io.h"
#include "nqm/help.h"
#include "nqm/tool.h"
#include "render/render.h"

#include <jpeglib.h>
#include <openexr.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>
#include <webp/decode.h>

const verb verbs[] = {
    {"score", "compare", cmd_score, "predict how good approximations look compared with their reference (JOD)"},
    {"batch", "compare", cmd_batch, "score a list of pairs; an interrupted run is continued"},
    {"rank", "compare", cmd_rank, "order approximations by their score"},
    {"diff", "compare", cmd_diff, "compare two versions of the materials of a file or folder"},
    {"report", "compare", cmd_report, "write a page with pictures, scores and differences"},
    {"dedup", "find", cmd_dedup, "find materials of a library that look the same"},
    {"nearest", "find", cmd_nearest, "find the materials of a library that look most like one"},
    {"info", "look into", cmd_info,
     "describe a BRDF, model, dataset or material file; `nqm info list` names the presets"},
    {"check", "look into", cmd_check, "test reciprocity, energy conservation and positivity of a BRDF"},
    {"sample", "look into", cmd_sample, "evaluate f_r of a BRDF at a list of directions, as CSV"},
    {"directions", "look into", cmd_directions, "make or print sampling directions"},
    {"render", "look into", cmd_render, "render pictures of a BRDF on a lit shape"},
    {"fit", "make for a renderer", cmd_fit, "fit an analytic model, a network or a table to a BRDF"},
    {"translate", "make for a renderer", cmd_translate,
     "write materials as another renderer's materials, and say what is lost"},
    {"convert", "make for a renderer", cmd_convert, "write a BRDF as a table, MERL .binary"},
    {"conform", "make for a renderer", cmd_conform, "test a shader against its specification, and name its mistake"},
    {"label", "your own metric", cmd_label, "compute Delta-E ITP and JOD of pairs by rendering"},
    {"dataset", "your own metric", cmd_dataset, "make a training corpus from a list of materials"},
    {"regress", "your own metric", cmd_regress, "fit the curve from Delta-E ITP to JOD to human scores"},
    {"transport", "your own metric", cmd_transport, "make a metric for a scene of your own, without training"},
    {"train", "your own metric", cmd_train, "train a model on a dataset"},
    {"calibrate", "your own metric", cmd_calibrate, "calibrate the intervals around the JOD of a model"},
    {"eval", "your own metric", cmd_eval, "compare a model and the baseline metrics with labels"},
    {"doctor", "this machine", cmd_doctor, "check this installation, and say what to do where it does not work"},
    {"help", "this machine", cmd_help, "print this text or the help of a verb; man pages and completions of shells"},
    {NULL, NULL, NULL, NULL},
};

bool begins_heading(const verb *v) {
    return v == verbs || strcmp(v->heading, v[-1].heading) != 0;
}

void print_usage(FILE *out) {
    fputs("usage: nqm VERB [arguments]\n\n"
          "Predicts how good a BRDF approximation looks compared with its reference, in JOD, without rendering.\n",
          out);
    for (const verb *v = verbs; v->name; ++v) {
        if (begins_heading(v))
            fprintf(out, "\n%s\n", v->heading);
        fprintf(out, "  %-11s %s\n", v->name, v->summary);
    }
    fputs("\n`nqm VERB --help` describes a verb, with an example; `nqm --version` lists the libraries of this build.\n"
          "example: nqm score sgd:nickel ward:nickel\n",
          out);
}

/* The text of a macro's value. */
#define TEXT(value)    #value
#define TEXT_OF(macro) TEXT(macro)

const char *tool_build_info(void) {
    static char line[256];
    const char *embree = nqm_tracer_version();
    const int webp = WebPGetDecoderVersion();
    int major, minor, patch;
    exr_get_library_version(&major, &minor, &patch, NULL);
    snprintf(line, sizeof line,
             "Embree %s%s, libjpeg-turbo %s, libpng %s, libwebp %d.%d.%d, OpenEXR %d.%d.%d, no MPI library",
             embree ? embree : "off", embree ? " when needed" : "", TEXT_OF(LIBJPEG_TURBO_VERSION),
             png_get_libpng_ver(NULL), webp >> 16, webp >> 8 & 255, webp & 255, major, minor, patch);
    return line;
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

/* Former names, with the first argument where only that one is meant; the first row that fits holds. */
static struct former {
    const char *name, *argument; /* argument: NULL: any, or none */
    const char *verb;            /* what replaces them */
    char option[12];             /* and an option, which parse_arguments() may change; "": none */
    const char *advice;          /* what to do instead; NULL: they are replaced */
} formers[] = {{"models", "show", "info", "", NULL},
               {"models", "list", "info", "--models", NULL},
               {"models", "annotate", NULL, "", "`nqm info MODEL --notes NOTES.md -o FILE` writes a copy with notes"},
               {"models", NULL, "info", "--models", NULL},
               {"selftest", NULL, "doctor", "", NULL},
               {"plot", NULL, NULL, "", "`python3 -m nqm.plot` draws"},
               {"learn", NULL, NULL, "", "studies/learn.py in the sources learns encodings"},
               {"bench", NULL, NULL, "", "build/nqm-bench, which the sources make, measures speed"}};

void rename_former_verb(int *argc, char ***argv) {
    char **words = *argv;
    for (struct former *f = formers; f < formers + sizeof formers / sizeof *formers; ++f) {
        if (find_verb(words[0]) || strcmp(f->name, words[0]) != 0 ||
            (f->argument && (*argc < 2 || strcmp(f->argument, words[1]) != 0)))
            continue;
        if (f->advice) {
            fprintf(stderr, "nqm: there is no verb '%s' any more: %s\n", f->name, f->advice);
            exit(EXIT_USAGE);
        }
        const int shift = (f->argument != NULL) - (*f->option != '\0'); /* -1: to the place of the program's name */
        *argc -= shift;
        *argv = words + shift;
        (*argv)[0] = (char *)(uintptr_t)f->verb;
        if (*f->option)
            (*argv)[1] = f->option;
        return;
    }
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
