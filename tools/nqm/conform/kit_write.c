/* SPDX-License-Identifier: MIT
 *
 * The files of a kit: rows for programs, as CSV; arrays for shaders, as GLSL, HLSL or C, with the loop over them.
 */
#include "nqm/conform/conform.h"

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

/* ---- CSV --------------------------------------------------------------------------------------------------------- */

static void put_number(FILE *out, double v) {
    char text[32];
    fprintf(out, ",%s", nqm_format_double(text, sizeof text, v));
}

void write_kit_rows(const conform_kit *kit, FILE *out) {
    const nqm_schema *schema = kit->model->schema;
    fputs("set", out);
    for (size_t k = 0; k < schema->n_keys; ++k)
        for (size_t c = 0; c < schema->keys[k].n; ++c)
            fprintf(out, schema->keys[k].n > 1 ? ",%s_%c" : ",%s", schema->keys[k].name,
                    (schema->keys[k].n == 3 ? "rgb" : "xy")[c]);
    fputs(",light_x,light_y,light_z,viewer_x,viewer_y,viewer_z\n", out);
    for (size_t s = 0; s < kit->n_sets; ++s) {
        const kit_set *set = &kit->sets[s];
        char *head = NULL;
        size_t n_head;
        FILE *parameters = open_text(&head, &n_head);
        for (size_t k = 0; k < schema->n_keys; ++k)
            for (size_t c = 0; c < schema->keys[k].n; ++c)
                put_number(parameters, set->values.v[k][c]);
        fclose(parameters);
        for (size_t i = 0; i < kit->n_directions; ++i) {
            const double *wi = kit_directions(kit, set->turn, 0) + 3 * i,
                         *wo = kit_directions(kit, set->turn, 1) + 3 * i;
            fprintf(out, "%zu%s,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", s + 1, head, wi[0], wi[1], wi[2], wo[0], wo[1],
                    wo[2]);
        }
        free(head);
    }
}

/* ---- shaders ----------------------------------------------------------------------------------------------------- */

typedef struct language {
    const char *ending, *vector; /* "vec": vec2, vec3 */
    const char *constant, *head, *loop;
    bool is_glsl; /* constructors instead of braces */
} language;

static const language languages[] = {
    {".glsl", "vec", "const ",
     "// GLSL 3.00 ES or 3.30 and later: put `#version` and `precision highp float;` before this file.\n",
     "// Define this function after this file: f_r in 1/sr of linear red, green and blue, without the cosine.\n"
     "vec3 nqm_brdf(nqm_set m, vec3 light, vec3 viewer);\n\n"
     "vec3 nqm_turned(vec3 d, vec2 turn) {\n"
     "    return vec3(turn.x * d.x - turn.y * d.y, turn.y * d.x + turn.x * d.y, d.z);\n}\n"
     "vec3 nqm_value(int set, int direction) {\n"
     "    nqm_set m = nqm_sets[set];\n"
     "    return nqm_brdf(m, nqm_turned(nqm_light[direction], m.turn), nqm_turned(nqm_viewer[direction], "
     "m.turn));\n}\n\n"
     "// Fragment shader: draw into nqm_n_directions x nqm_n_sets texels of 32-bit floats and read them back, the "
     "first row first.\n"
     "out vec4 nqm_color;\n"
     "void main() {\n"
     "    nqm_color = vec4(nqm_value(int(gl_FragCoord.y), int(gl_FragCoord.x)), 1.0);\n}\n",
     true},
    {".hlsl", "float", "static const ", "",
     "// Define this function: f_r in 1/sr of linear red, green and blue, without the cosine.\n"
     "float3 nqm_brdf(nqm_set m, float3 light, float3 viewer);\n\n"
     "float3 nqm_turned(float3 d, float2 turn) {\n"
     "    return float3(turn.x * d.x - turn.y * d.y, turn.y * d.x + turn.x * d.y, d.z);\n}\n\n"
     "// Compute shader: dispatch nqm_n_sets * nqm_n_directions / 64 groups, rounded up, and read the buffer back.\n"
     "RWStructuredBuffer<float3> nqm_values : register(u0);\n"
     "[numthreads(64, 1, 1)] void nqm_main(uint3 id : SV_DispatchThreadID) {\n"
     "    if (id.x >= nqm_n_sets * nqm_n_directions)\n        return;\n"
     "    nqm_set m = nqm_sets[id.x / nqm_n_directions];\n"
     "    uint d = id.x % nqm_n_directions;\n"
     "    nqm_values[id.x] = nqm_brdf(m, nqm_turned(nqm_light[d], m.turn), nqm_turned(nqm_viewer[d], m.turn));\n}\n",
     false},
    {".h", "nqm_float", "static const ",
     "#include <stdio.h>\n\ntypedef struct nqm_set nqm_set;\n"
     "typedef float nqm_float2[2], nqm_float3[3];\n\n",
     "/* f_r in 1/sr of linear red, green and blue, without the cosine. */\n"
     "typedef void nqm_brdf(const nqm_set *m, const float light[3], const float viewer[3], float rgb[3]);\n\n"
     "static inline void nqm_turn(const float d[3], const float turn[2], float to[3]) {\n"
     "    to[0] = turn[0] * d[0] - turn[1] * d[1];\n    to[1] = turn[1] * d[0] + turn[0] * d[1];\n    to[2] = "
     "d[2];\n}\n\n"
     "/* Print the values of all sets and directions. */\n"
     "static inline void nqm_print_values(FILE *out, nqm_brdf *brdf) {\n"
     "    fputs(\"r,g,b\\n\", out);\n"
     "    for (int s = 0; s < nqm_n_sets; ++s)\n"
     "        for (int d = 0; d < nqm_n_directions; ++d) {\n"
     "            float light[3], viewer[3], rgb[3];\n"
     "            nqm_turn(nqm_light[d], nqm_sets[s].turn, light);\n"
     "            nqm_turn(nqm_viewer[d], nqm_sets[s].turn, viewer);\n"
     "            brdf(&nqm_sets[s], light, viewer, rgb);\n"
     "            fprintf(out, \"%.9g,%.9g,%.9g\\n\", (double)rgb[0], (double)rgb[1], (double)rgb[2]);\n"
     "        }\n}\n",
     false},
};

static void put_vector(const language *l, FILE *out, size_t n, const double *v) {
    if (n > 1 && l->is_glsl)
        fprintf(out, "%s%zu(", l->vector, n);
    else if (n > 1)
        fputc('{', out);
    for (size_t c = 0; c < n; ++c) {
        char text[32];
        snprintf(text, sizeof text, "%.9g", v[c]);
        fprintf(out, "%s%s%sf", c ? ", " : "", text, strpbrk(text, ".e") ? "" : ".0");
    }
    fputs(n == 1 ? "" : l->is_glsl ? ")" : "}", out);
}

/* "const vec3 name[9] = vec3[9](", or with braces. */
static void begin_array(const language *l, FILE *out, const char *type, const char *name, size_t n) {
    fprintf(out, "%s%s %s[%zu] = ", l->constant, type, name, n);
    if (l->is_glsl)
        fprintf(out, "%s[%zu](\n", type, n);
    else
        fputs("{\n", out);
}

static void put_directions(const language *l, FILE *out, const char *name, size_t n, const double *d) {
    char type[16];
    snprintf(type, sizeof type, "%s3", l->vector);
    begin_array(l, out, type, name, n);
    for (size_t i = 0; i < n; ++i) {
        fputs(i ? ",\n    " : "    ", out);
        put_vector(l, out, 3, d + 3 * i);
    }
    fputs(l->is_glsl ? ");\n\n" : "};\n\n", out);
}

static void put_sets(const language *l, FILE *out, const conform_kit *kit) {
    const nqm_schema *schema = kit->model->schema;
    fputs("struct nqm_set {\n", out);
    fprintf(out, "    %s2 turn;\n", l->vector);
    for (const nqm_schema_key *key = schema->keys; key < schema->keys + schema->n_keys; ++key)
        if (key->n == 1)
            fprintf(out, "    float %s;\n", key->name);
        else
            fprintf(out, "    %s%zu %s;\n", l->vector, key->n, key->name);
    fputs("};\n", out);
    begin_array(l, out, "nqm_set", "nqm_sets", kit->n_sets);
    for (size_t s = 0; s < kit->n_sets; ++s) {
        const double angle = kit_turns_deg[kit->sets[s].turn] * NQM_PI / 180;
        fputs(l->is_glsl ? "    nqm_set(" : "    {", out);
        put_vector(l, out, 2, (double[]){cos(angle), sin(angle)});
        for (size_t k = 0; k < schema->n_keys; ++k) {
            fputs(", ", out);
            put_vector(l, out, schema->keys[k].n, kit->sets[s].values.v[k]);
        }
        fprintf(out, "%s%s // set %zu\n", l->is_glsl ? ")" : "}", s + 1 < kit->n_sets ? "," : "", s + 1);
    }
    fputs(l->is_glsl ? ");\n\n" : "};\n\n", out);
}

void write_kit_shader(const conform_kit *kit, const char *path) {
    const char *ending = strrchr(path, '.');
    const language *l = languages;
    while (ending && l < &languages[2] && strcasecmp(ending, l->ending) != 0)
        ++l;
    output_file out;
    open_output(path, &out);
    fprintf(out.stream,
            "// Parameter sets and directions of `nqm conform %s`, nqm %s. Angles and turns are of the tangent frame:\n"
            "// z is the normal, x the tangent; unit vectors away from the surface. `turn` is a cosine and a sine.\n",
            kit->model->schema->model, nqm_version());
    fprintf(out.stream, "%s%sint nqm_n_sets = %zu, nqm_n_directions = %zu;\n\n", l->head, l->constant, kit->n_sets,
            kit->n_directions);
    put_sets(l, out.stream, kit);
    put_directions(l, out.stream, "nqm_light", kit->n_directions, kit_directions(kit, 0, 0));
    put_directions(l, out.stream, "nqm_viewer", kit->n_directions, kit_directions(kit, 0, 1));
    fputs(l->loop, out.stream);
    close_output(&out);
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

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
    double value;
    const bool is_nan = strncasecmp(word, "nan", 3) == 0 && (!word[3] || word[3] == '(');
    if (is_nan || strcasecmp(word, "inf") == 0 || strcasecmp(word, "infinity") == 0)
        return NAN;
    must(nqm_csv_number(csv, row, column, &value, &fault));
    return (float)value;
}

static void read_csv(const conform_kit *kit, const nqm_map *map, const char *name, float *values) {
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

static void read_npy(const conform_kit *kit, const nqm_map *map, float *values) {
    nqm_tensor tensor;
    must(nqm_npy_parse(map, &tensor, &fault));
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
    float *values = allocate(3 * count_rows(kit), sizeof *values);
    must(nqm_map_open(path, &map, &fault));
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

float *run_command(const conform_kit *kit, const char *line) {
    FILE *in = tmpfile(), *out = tmpfile();
    char path[32];
    if (!in || !out)
        stop(EXIT_OPEN, "--command needs a folder for temporary files: %s", strerror(errno));
    write_kit_rows(kit, in);
    if (fflush(in) != 0 || ferror(in))
        stop(EXIT_OPEN, "the rows of the kit cannot be written to a temporary file: %s", strerror(errno));
    rewind(in);
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
