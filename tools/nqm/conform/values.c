/* SPDX-License-Identifier: MIT
 *
 * Values of a shader: from a file, or from a command that reads the rows of the kit.
 */
#include "nqm/conform/conform.h"

#include "io/io.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static size_t count_rows(const nqm_conform_kit *kit) {
    const nqm_conform_info info = nqm_conform_kit_get_info(kit);
    return info.n_sets * info.n_directions;
}

static _Noreturn void stop_count(const nqm_conform_kit *kit, const char *name, size_t n) {
    const nqm_conform_info info = nqm_conform_kit_get_info(kit);
    stop(EXIT_INCOMPATIBLE,
         "%s has %zu values, and the kit has %zu rows: %zu sets of %zu directions; give the same --keys", name, n,
         count_rows(kit), info.n_sets, info.n_directions);
}

/* A field as shaders print it: also nan, inf and -nan(ind), which are no value. */
static float read_field(const nqm_csv *csv, size_t row, int column) {
    const char *text = nqm_csv_text(csv, row, column);
    const char *word = text + (*text == '-' || *text == '+');
    double value;
    const bool is_nan = strncasecmp(word, "nan", 3) == 0 && (!word[3] || word[3] == '(');
    if (is_nan || strcasecmp(word, "inf") == 0 || strcasecmp(word, "infinity") == 0)
        return NAN;
    must(nqm_csv_number(csv, row, column, &value, &fault));
    return (float)value;
}

static void read_csv(const nqm_conform_kit *kit, const nqm_map *map, const char *name, float *values) {
    nqm_csv *csv;
    must(nqm_csv_parse((const char *)map->data, map->n_bytes, name, &csv, &fault));
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

static void read_npy(const nqm_conform_kit *kit, const nqm_map *map, float *values) {
    nqm_tensor tensor;
    must(nqm_npy_parse(map, &tensor, &fault));
    const size_t n = nqm_tensor_count(&tensor), n_each = nqm_dtype_size(tensor.dtype);
    const unsigned char *data = tensor.data;
    if (n != 3 * count_rows(kit) || tensor.n_dims < 2 || tensor.dims[tensor.n_dims - 1] != 3)
        stop_count(kit, map->path, n / 3);
    for (size_t i = 0; i < n; ++i)
        values[i] = n_each == 4 ? nqm_load_f32(data + 4 * i) : (float)nqm_load_f64(data + 8 * i);
}

static float *read_file(const nqm_conform_kit *kit, const char *path, const char *name) {
    nqm_map map;
    float *values = allocate(3 * count_rows(kit), sizeof *values);
    must(nqm_map_open(path, &map, &fault));
    if (nqm_npy_probe(&map))
        read_npy(kit, &map, values);
    else
        read_csv(kit, &map, name, values);
    nqm_map_close(&map);
    return values;
}

float *read_results(const nqm_conform_kit *kit, const char *path) {
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

/* Wait for a command, and end it at Ctrl-C, or when its output is longer than any list of values. A command that does not end when it
 * is asked to is killed. Returns its status. */
static int await(pid_t child, FILE *out, size_t n_rows) {
    enum { STEP_NS = 10000000, PATIENCE = 15 };
    const off_t most = (off_t)(1 << 20) + (off_t)n_rows * 256;
    size_t n_asked = 0;
    int status = 0;
    struct stat st;
    note_child(child);
    while (waitpid(child, &status, WNOHANG) == 0) { /* any thread may get the signal of Ctrl-C */
        const bool is_long = fstat(fileno(out), &st) == 0 && st.st_size > most;
        if (interrupted() || is_long)
            kill(-child, n_asked++ < PATIENCE ? SIGTERM : SIGKILL);
        nanosleep(&(struct timespec){.tv_nsec = STEP_NS}, NULL);
    }
    note_child(0);
    if (interrupted())
        stop(EXIT_INTERRUPTED, "interrupted");
    if (fstat(fileno(out), &st) == 0 && st.st_size > most)
        stop(EXIT_LIMIT, "the command has printed more than %lld bytes, and %zu rows of r,g,b are wanted",
             (long long)most, n_rows);
    return status;
}

float *run_command(const nqm_conform_kit *kit, const char *line) {
    FILE *in = tmpfile(), *out = tmpfile();
    char path[32];
    if (!in || !out)
        stop(EXIT_OPEN, "--command needs a folder for temporary files: %s", strerror(errno));
    snprintf(path, sizeof path, "/dev/fd/%d", fileno(in));
    must(nqm_conform_kit_write(kit, "csv", path, &fault));
    const pid_t child = start(line, in, out);
    if (child < 0)
        stop(EXIT_LIMIT, "the command cannot be started: %s", strerror(errno));
    const int status = await(child, out, count_rows(kit));
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        stop(EXIT_INCOMPATIBLE, "the command '%s' ended with %s %d", line, WIFEXITED(status) ? "exit code" : "signal",
             WIFEXITED(status) ? WEXITSTATUS(status) : WTERMSIG(status));
    snprintf(path, sizeof path, "/dev/fd/%d", fileno(out));
    float *values = read_file(kit, path, "the output of the command");
    fclose(in);
    fclose(out);
    return values;
}
