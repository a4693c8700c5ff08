/* SPDX-License-Identifier: MIT
 *
 * Files that a verb writes itself: base's atomic output files, with faults reported.
 */
#include "base/os.h"
#include "nqm/tool.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

static output_file *open_outputs; /* linked by `next` */
static const char *made_folder;   /* folder that this run made; removed at its end if nothing was written to it */

char *absolute_path(const char *path, const char *suffix) {
    const bool is_complete = *path == '/' || strcmp(path, "-") == 0;
    char *folder = is_complete ? NULL : nqm_os_real_path(".");
    if (!folder && !is_complete)
        stop(EXIT_OPEN, "the working folder has no path: %s", strerror(errno));
    const size_t n = (folder ? strlen(folder) : 0) + strlen(path) + strlen(suffix) + 2;
    char *full = allocate(n, 1);
    snprintf(full, n, "%s%s%s%s", folder ? folder : "", folder ? "/" : "", path, suffix);
    free(folder);
    return full;
}

void open_output(const char *path, output_file *out) {
    *out = (output_file){.stream = stdout};
    if (strcmp(path, "-") == 0)
        return;
    must(nqm_outfile_open(path, &out->file, &fault));
    out->stream = out->file.stream;
    out->next = open_outputs;
    open_outputs = out;
}

void require_output(const char *path) {
    nqm_outfile file;
    if (strcmp(path, "-") == 0)
        return;
    must(nqm_outfile_open(path, &file, &fault));
    nqm_outfile_abort(&file);
}

/* The ending of the last name in a path: ".csv", or "". A number after a dot ("model-1.2") is part of a name. */
static const char *ending_of(const char *path) {
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    return dot && !isdigit((unsigned char)dot[1]) ? dot : "";
}

/* Whether an ending is in a list like ".png|.svg". */
static bool is_listed(const char *ending, const char *endings) {
    bool fits = false;
    for (const char *at = endings; *at; at += strspn(at, "|")) {
        const size_t n = strcspn(at, "|");
        fits = fits || (n == strlen(ending) && nqm_equal_any_case(at, ending, n));
        at += n;
    }
    return fits;
}

void require_folder_name(const char *name, const char *path, const char *endings, const char *contents) {
    char *bare = absolute_path(path, "");
    size_t n = strlen(bare);
    while (n && bare[n - 1] == '/')
        bare[--n] = '\0';
    const char *ending = ending_of(bare);
    if (*ending && is_listed(ending, endings) && !nqm_os_is_folder(path))
        stop(EXIT_USAGE, "%s %s: %s are written to a folder; leave out '%s'", name, path, contents, ending);
    free(bare);
}

void require_named_output(const char *name, const char *path, const char *endings) {
    const size_t n = strlen(path);
    if (strcmp(path, "-") == 0 || nqm_os_is_device(path))
        return;
    if (strstr(endings, "DIR/") && ((n && path[n - 1] == '/') || nqm_os_is_folder(path)))
        return;
    const char *ending = ending_of(path); /* a single one may be left out; several of them choose the format */
    if (*ending ? !is_listed(ending, endings) : strstr(endings, "|.") != NULL)
        stop(EXIT_USAGE, "%s writes FILE%s, and '%s' names another kind of file%s", name, endings, path,
             is_listed(ending, ".mtlx|.gltf|.glb|.pbrt") ? "; 'nqm translate' writes materials" : "");
    require_output(path);
}

/* The path of an output without links, "." and ".."; free() it. NULL: its folder does not exist. */
static char *real_output(const char *path) {
    char *real = nqm_os_real_path(path), *full = real ? NULL : absolute_path(path, "");
    char *slash = full ? strrchr(full, '/') : NULL;
    if (slash)
        *slash = '\0';
    char *folder = slash ? nqm_os_real_path(*full ? full : "/") : NULL;
    if (folder) {
        real = allocate(strlen(folder) + strlen(slash + 1) + 2, 1);
        sprintf(real, "%s/%s", folder, slash + 1);
    }
    free(folder);
    free(full);
    return real;
}

bool is_same_output(const char *a, const char *b) {
    if (strcmp(a, "-") == 0 || strcmp(b, "-") == 0 || nqm_os_is_device(a))
        return false;
    char *x = real_output(a), *y = real_output(b);
    const bool is_same = x && y && strcmp(x, y) == 0;
    free(x);
    free(y);
    return is_same;
}

void close_output(output_file *out) {
    output_file **link = &open_outputs;
    while (*link && *link != out)
        link = &(*link)->next;
    if (*link) {
        *link = out->next;
        must(nqm_outfile_commit(&out->file, &fault));
    }
    *out = (output_file){0};
}

void make_folder(const char *path) {
    if (nqm_os_make_folder(path))
        made_folder = path;
    else if (!nqm_os_is_folder(path))
        stop(EXIT_OPEN, "%s: cannot create the folder: %s", path, strerror(errno));
}

void remove_empty_folder(void) {
    if (made_folder)
        (void)nqm_os_remove_folder(made_folder);
}

void abandon_outputs(void) {
    for (; open_outputs; open_outputs = open_outputs->next)
        nqm_outfile_abort(&open_outputs->file);
    remove_empty_folder();
}

/* ---- "-" as a file name ------------------------------------------------------------------------------------------ */

static FILE *input, *output;
static char input_name[NQM_TEMPORARY_PATH], output_name[NQM_TEMPORARY_PATH];

/* Open the file once; `fallback` when there is no place for temporary files. */
static const char *path_of(FILE **file, char *name, const char *fallback) {
    if (!*file)
        *file = nqm_os_temporary(name);
    return *file ? name : fallback;
}

static bool copy(FILE *from, FILE *to) {
    char block[1 << 16];
    size_t n;
    while ((n = fread(block, 1, sizeof block, from)) > 0)
        if (fwrite(block, 1, n, to) != n)
            break;
    return !ferror(from) && fflush(to) == 0 && !ferror(to);
}

/* A file with the content of a pipe, which the shell makes of <(COMMAND); another path itself. The file stays until the run ends. */
static const char *pipe_path(const char *path) {
    nqm_file_info info;
    const bool is_pipe = path && nqm_os_get_info(path, &info) && info.kind == NQM_FILE_PIPE;
    FILE *file = NULL, *from = is_pipe ? nqm_os_open_text(path) : NULL;
    char *name = from ? allocate(NQM_TEMPORARY_PATH, 1) : NULL;
    const bool is_copied = name && path_of(&file, name, path) == name && copy(from, file);
    if (interrupted())
        stop(EXIT_INTERRUPTED, "interrupted");
    if (from)
        fclose(from);
    return is_copied ? name : path;
}

const char *input_path(const char *path) {
    bool is_read = input != NULL;
    if (!path || strcmp(path, "-") != 0)
        return pipe_path(path);
    const char *name = path_of(&input, input_name, "/dev/stdin");
    const bool is_copied = !input || is_read || copy(stdin, input);
    if (interrupted())
        stop(EXIT_INTERRUPTED, "interrupted");
    return is_copied ? name : "/dev/stdin";
}

const char *output_path(const char *path) {
    return path && strcmp(path, "-") == 0 ? path_of(&output, output_name, "/dev/stdout") : path;
}

bool flush_output_path(void) {
    if (!output)
        return true;
    rewind(output);
    return copy(output, stdout);
}

const char *stream_name(const char *message, size_t *n_prefix) {
    const char *const names[] = {input_name, output_name};
    for (size_t i = 0; i < 2; ++i) {
        *n_prefix = strlen(names[i]);
        if (*n_prefix && strncmp(message, names[i], *n_prefix) == 0)
            return i ? "standard output" : "standard input";
    }
    *n_prefix = 0;
    return "";
}

/* ---- several processes ------------------------------------------------------------------------------------------- */

static bool number_of(const char *variable, size_t *value_ret) {
    const char *text = getenv(variable);
    char *end;
    if (!text || *text < '0' || *text > '9')
        return false;
    *value_ret = strtoul(text, &end, 10);
    return *end == 0;
}

ranks my_ranks(void) {
    static const char *const launchers[][2] = {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
                                               {"PMI_RANK", "PMI_SIZE"},
                                               {"SLURM_PROCID", "SLURM_STEP_NUM_TASKS"}};
    for (size_t i = 0; i < sizeof launchers / sizeof *launchers; ++i) {
        ranks r;
        if (number_of(launchers[i][0], &r.rank) && number_of(launchers[i][1], &r.count) && r.rank < r.count)
            return r;
    }
    return (ranks){0, 1};
}
