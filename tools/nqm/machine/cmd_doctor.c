/* SPDX-License-Identifier: MIT
 *
 * nqm doctor - checks that this installation works on this machine, and says what to do where it does not.
 */
#include "kernel/kernel.h"
#include "nqm/tool.h"
#include "render/render.h"

#include <errno.h>
#include <omp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <unistd.h>

typedef enum state { STATE_OK, STATE_NOTE, STATE_PROBLEM } state;
static const char *const state_names[] = {"ok", "note", "PROBLEM"};
static const char *const json_states[] = {"ok", "note", "problem"};

typedef struct examination {
    json_t *checks; /* NULL: print lines */
    int n_problems, n_notes;
    int n_passed, n_failed;   /* checks of the self-test */
    json_t *selftest;         /* these checks */
    nqm_status selftest_code; /* of all of them */
} examination;

/* Add a result. advice: what to do; NULL where nothing has to be done. */
__attribute__((format(printf, 5, 6))) static void add(examination *e, const char *name, state s, const char *advice,
                                                      const char *format, ...) {
    char found[400];
    va_list args;
    va_start(args, format);
    vsnprintf(found, sizeof found, format, args);
    va_end(args);
    e->n_problems += s == STATE_PROBLEM;
    e->n_notes += s == STATE_NOTE;
    if (e->checks) {
        json_array_append_new(e->checks, json_row("name:s state:s found:s advice:o", name, json_states[s], found,
                                                  advice ? json_name(advice) : json_null()));
        return;
    }
    printf("%-8s %-10s %s\n", state_names[s], name, found);
    if (advice)
        printf("%-19s -> %s\n", "", advice);
}

static void check_libraries(examination *e) {
    const char *embree = nqm_tracer_version();
    add(e, "build", STATE_OK, NULL, "nqm %s, compiler %s", nqm_version(), __VERSION__);
    add(e, "libraries", STATE_OK, NULL, "%s; %s", nqm_build_info(), tool_build_info());
    if (!embree)
        add(e, "Embree", STATE_NOTE, "build with -DNQM_EMBREE=ON to render meshes",
            "off in this build: the sphere is the only shape");
    else if (nqm_tracer_available())
        add(e, "Embree", STATE_OK, NULL, "loads");
    else
        add(e, "Embree", STATE_NOTE, "install Embree 3 (Debian: libembree3-3) to render meshes and the standard scenes",
            "cannot be loaded");
}

/* The processor's name by Linux, otherwise "unknown". */
static void read_processor(char name[120]) {
    char line[256];
    FILE *file = fopen("/proc/cpuinfo", "r");
    strcpy(name, "unknown");
    while (file && fgets(line, sizeof line, file) && sscanf(line, "model name%*[ \t]: %119[^\n]", name) != 1)
        ;
    if (file)
        fclose(file);
}

static void check_processor(examination *e) {
    char cpu[120];
    const int threads = omp_get_max_threads(), cores = omp_get_num_procs();
    read_processor(cpu);
    add(e, "processor", STATE_OK, NULL, "%s", cpu);
    const char *given = getenv("NQM_KERNELS"), *best = nqm_kernels_name(0);
    const char *selected = given && *given ? given : best;
    if (strcmp(selected, best) == 0)
        add(e, "kernels", STATE_OK, NULL, "%s", selected);
    else
        add(e, "kernels", STATE_NOTE, "unset NQM_KERNELS to use the latter", "%s; this processor also supports %s",
            selected, best);
    if (threads < cores)
        add(e, "threads", STATE_NOTE, "unset OMP_NUM_THREADS to use all processors", "%d of %d processors are used",
            threads, cores);
    else
        add(e, "threads", STATE_OK, NULL, "%d for %d processors", threads, cores);
}

/* The self-test: kernels against scalar loops; coordinates, the JOD curve and presets against stored values; the built-in models
 * against their checksums and stored scores. */
static void note_selftest(void *user, const char *name, int passed) {
    examination *e = user;
    e->n_passed += passed != 0;
    e->n_failed += !passed;
    json_array_append_new(e->selftest, json_row("name:s passed:b", name, passed));
    if (!passed)
        add(e, "self-test", STATE_PROBLEM, NULL, "failed: %s", name);
}

static void check_selftest(examination *e) {
    nqm_error err = {0};
    e->selftest_code = nqm_selftest(note_selftest, e, &err);
    if (e->selftest_code == NQM_OK)
        add(e, "self-test", STATE_OK, NULL, "%d checks pass", e->n_passed);
    else
        add(e, "self-test", STATE_PROBLEM,
            "install nqm again; if that does not help, report the output of `nqm doctor`", "%s", err.message);
}

static void check_models(examination *e) {
    if (!nqm_model_builtin_name(0))
        add(e, "models", STATE_PROBLEM, "build with the files of models/, or give --model FILE to every verb",
            "none is built in");
    for (size_t i = 0; nqm_model_builtin_name(i); ++i) {
        const char *name = nqm_model_builtin_name(i);
        nqm_model *model;
        nqm_error err = {0};
        if (nqm_model_load(name, &model, &err) != NQM_OK) {
            add(e, "model", STATE_PROBLEM, "install nqm again: this program is damaged", "%s", err.message);
            continue;
        }
        const nqm_model_info info = nqm_model_get_info(model);
        add(e, "model", STATE_OK, NULL, "%s, %zu parameters, sha256 %.16s", name, info.n_parameters, info.sha256);
        nqm_model_free(model);
    }
}

/* A folder in which files are written. */
static void check_folder(examination *e, const char *name, const char *path, state worst, const char *advice) {
    struct statvfs space;
    char file[1024];
    snprintf(file, sizeof file, "%.1000s/nqm-doctor-XXXXXX", path);
    const int descriptor = mkstemp(file);
    if (descriptor < 0) {
        add(e, name, worst, advice, "%s: cannot write: %s", path, strerror(errno));
        return;
    }
    close(descriptor);
    unlink(file);
    const double free_mb = statvfs(path, &space) == 0 ? 1e-6 * (double)space.f_bavail * (double)space.f_frsize : 0;
    if (free_mb < 100)
        add(e, name, STATE_NOTE, "free some space: datasets and tables need it", "%s: %.0f MB are free", path, free_mb);
    else
        add(e, name, STATE_OK, NULL, "%s is writable, %.1f GB are free", path, 1e-3 * free_mb);
}

static void check_python(examination *e) {
    char line[300] = "";
    /* a wheel's script says which Python has it */
    FILE *pipe =
        popen("\"${NQM_PYTHON:-python3}\" -c 'import nqm; print(nqm.__version__, nqm.__file__)' 2>/dev/null", "r");
    if (pipe && fgets(line, sizeof line, pipe))
        line[strcspn(line, "\n")] = '\0';
    const int code = pipe ? pclose(pipe) : -1;
    const size_t n_version = strcspn(line, " ");
    if (code != 0)
        add(e, "Python", STATE_NOTE,
            "to use nqm from Python, install python3-nqm (or pip install python/ of the sources)",
            "python3 finds no package nqm");
    else if (strlen(nqm_version()) != n_version || strncmp(line, nqm_version(), n_version) != 0)
        add(e, "Python", STATE_PROBLEM, "install the Python package of the same version",
            "the package is nqm %s, this is %s", line, nqm_version());
    else
        add(e, "Python", STATE_OK, NULL, "nqm %s", line);
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static bool json;

static const option options[] = {{"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0}, {0}};

static const command cmd = {
    .usage = "[options]",
    .about = "Check this installation on this machine: libraries that are loaded when needed, processor and kernels, "
             "threads, built-in models, the self-test, folders for files, and the Python package. Each problem comes "
             "with what to do. The self-test takes about a second: matrix kernels against scalar loops; coordinates, "
             "the JOD curve and presets against published or independently computed values; the built-in models "
             "against their checksums and stored scores. Exit code 8 when it fails, 1 when something else that is "
             "needed does not work; notes do not count.",
    .example = "nqm doctor\nnqm doctor --json",
    .options = options,
};

int cmd_doctor(int argc, char **argv) {
    const char *temporary = getenv("TMPDIR");
    parse_arguments(&cmd, argc, argv);
    examination e = {.checks = json ? json_array() : NULL, .selftest = json_array()};
    check_libraries(&e);
    check_processor(&e);
    check_models(&e);
    check_selftest(&e);
    check_folder(&e, "temporary", temporary && *temporary ? temporary : "/tmp", STATE_PROBLEM,
                 "set TMPDIR to a folder that you may write to");
    check_folder(&e, "folder", ".", STATE_NOTE, "change to a folder that you may write to, or give full paths to -o");
    check_python(&e);
    if (json)
        print_document(json_row("problems:i notes:i checks:o selftest:{passed:i failed:i checks:O}", e.n_problems,
                                e.n_notes, e.checks, e.n_passed, e.n_failed, e.selftest));
    else
        printf("\n%s; %d note%s\n", e.n_problems ? "nqm does not work here: see PROBLEM" : "all that nqm needs works",
               e.n_notes, e.n_notes == 1 ? "" : "s");
    json_decref(e.selftest);
    return e.selftest_code != NQM_OK ? exit_code_of(e.selftest_code) : e.n_problems ? EXIT_GATE : EXIT_OK;
}
