/* SPDX-License-Identifier: MIT
 *
 * Values of a shader: from a CSV, an array of NumPy, or a command of the shell.
 */
#include "nqm/conform/conform.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static size_t count_rows(const conform_kit *kit) {
    return kit->n_sets * kit->n_directions;
}

static _Noreturn void stop_count(const conform_kit *kit, const char *name, size_t n) {
    stop(EXIT_INCOMPATIBLE,
         "%s has %zu values, and the kit has %zu rows: %zu sets of %zu directions; give the same --keys", name, n,
         count_rows(kit), kit->n_sets, kit->n_directions);
}

/* A field as shaders print it: also nan, inf and -nan(ind), which are no value. */
static float read_field(const nqm_csv *csv, size_t row, int column) {
    const char *text = nqm_csv_text(csv, row, column);
    const char *word = text + (*text == '-' || *text == '+');
    nqm_error err = {0};
    double value;
    if (strncasecmp(word, "nan", 3) == 0 || strncasecmp(word, "inf", 3) == 0)
        return NAN;
    must(nqm_csv_number(csv, row, column, &value, &err), &err);
    return (float)value;
}

static void read_csv(const conform_kit *kit, const nqm_map *map, const char *name, float *values) {
    nqm_csv *csv;
    nqm_error err = {0};
    must(nqm_csv_parse((const char *)map->data, map->n_bytes, name, &csv, &err), &err);
    const int column[3] = {nqm_csv_column(csv, "r"), nqm_csv_column(csv, "g"), nqm_csv_column(csv, "b")};
    if (column[0] < 0 || column[1] < 0 || column[2] < 0)
        stop(EXIT_MALFORMED, "%s: line 1 must name the columns r, g and b", name);
    if (nqm_csv_rows(csv) != count_rows(kit))
        stop_count(kit, name, nqm_csv_rows(csv));
    for (size_t row = 0; row < count_rows(kit); ++row)
        for (size_t c = 0; c < 3; ++c)
            values[3 * row + c] = read_field(csv, row, column[c]);
    nqm_csv_free(csv);
}

static void read_npy(const conform_kit *kit, const nqm_map *map, float *values) {
    nqm_tensor tensor;
    nqm_error err = {0};
    must(nqm_npy_parse(map, &tensor, &err), &err);
    const size_t n = nqm_tensor_count(&tensor), n_each = nqm_dtype_size(tensor.dtype);
    const unsigned char *data = tensor.data;
    if (n != 3 * count_rows(kit) || tensor.n_dims < 2 || tensor.dims[tensor.n_dims - 1] != 3)
        stop_count(kit, map->path, n / 3);
    for (size_t i = 0; i < n; ++i)
        values[i] = n_each == 4 ? nqm_load_f32(data + 4 * i) : (float)nqm_load_f64(data + 8 * i);
}

/* A value with a channel that is not finite is none. */
static float *read_file(const conform_kit *kit, const char *path, const char *name) {
    nqm_map map;
    nqm_error err = {0};
    float *values = allocate(3 * count_rows(kit), sizeof *values);
    must(nqm_map_open(path, &map, &err), &err);
    if (nqm_npy_probe(&map))
        read_npy(kit, &map, values);
    else
        read_csv(kit, &map, name, values);
    nqm_map_close(&map);
    for (size_t i = 0; i < count_rows(kit); ++i) {
        float *v = values + 3 * i;
        if (!isfinite(v[0]) || !isfinite(v[1]) || !isfinite(v[2]))
            v[0] = v[1] = v[2] = NAN;
    }
    return values;
}

float *read_results(const conform_kit *kit, const char *path) {
    const char *stream = stream_name(path, &(size_t){0});
    return read_file(kit, path, *stream ? stream : path);
}

/* ---- a command --------------------------------------------------------------------------------------------------- */

static pid_t start(const char *line, FILE *in, FILE *out) {
    const pid_t child = fork();
    if (child > 0)
        setpgid(child, child);
    if (child != 0)
        return child;
    setpgid(0, 0); /* Ctrl-C ends all that the shell has started */
    dup2(fileno(in), STDIN_FILENO);
    dup2(fileno(out), STDOUT_FILENO);
    execl("/bin/sh", "sh", "-c", line, (char *)NULL);
    _exit(127);
}

float *run_command(const conform_kit *kit, const char *line) {
    FILE *in = tmpfile(), *out = tmpfile();
    char path[32];
    int status = 0;
    if (!in || !out)
        stop(EXIT_OPEN, "--command needs a folder for temporary files: %s", strerror(errno));
    write_kit_rows(kit, in);
    if (fflush(in) != 0 || ferror(in))
        stop(EXIT_OPEN, "the rows of the kit cannot be written to a temporary file: %s", strerror(errno));
    rewind(in);
    const pid_t child = start(line, in, out);
    if (child < 0)
        stop(EXIT_LIMIT, "the command cannot be started: %s", strerror(errno));
    while (waitpid(child, &status, WNOHANG) == 0) { /* any thread may get the signal of Ctrl-C */
        if (interrupted())
            kill(-child, SIGTERM);
        nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
    }
    if (interrupted())
        stop(EXIT_INTERRUPTED, "interrupted");
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        stop(EXIT_INCOMPATIBLE, "the command '%s' ended with %s %d", line, WIFEXITED(status) ? "exit code" : "signal",
             WIFEXITED(status) ? WEXITSTATUS(status) : WTERMSIG(status));
    snprintf(path, sizeof path, "/dev/fd/%d", fileno(out));
    float *values = read_file(kit, path, "the output of the command");
    fclose(in);
    fclose(out);
    return values;
}
