/* SPDX-License-Identifier: MIT
 *
 * nqm conform - does a shader implement its specification, and which mistake does it make?
 */
#include "conform/conform.h"
#include "io/io.h"
#include "nqm/score/batch.h"
#include <nqm/translate.h>

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static const char *junit, *markdown;

typedef struct conform_result {
    nqm_conform_info kit;
    score_run run; /* a row for each set, in their order */
    nqm_conform_report report;
} conform_result;

/* Rows for the results of the sets. */
static void make_rows(conform_result *r, const nqm_conform_kit *kit, const char *name,
                      const nqm_score_result *results) {
    r->run.n_rows = r->kit.n_sets;
    r->run.rows = allocate(r->kit.n_sets, sizeof *r->run.rows);
    r->run.ref_path = r->kit.model;
    r->run.ref_name = name;
    r->run.terms = (remark_terms){r->run.model, NQM_INVALID_DROP};
    for (size_t set = 0; set < r->kit.n_sets; ++set) {
        scored_pair *row = &r->run.rows[set];
        char text[32];
        snprintf(text, sizeof text, "set %zu", set + 1);
        *row = (scored_pair){.pair = {nqm_conform_kit_get_info(kit, set).spec, name},
                             .name = must_have(strdup(text)),
                             .result = results[set],
                             .order = set};
        row->err.status = results[set].status;
        if (row->err.status != NQM_OK)
            snprintf(row->err.message, sizeof row->err.message, "set %zu: %zu of %zu values are not finite", set + 1,
                     results[set].n_invalid[1], r->kit.n_directions);
    }
}

/* ---- the likely mistake ------------------------------------------------------------------------------------------ */

/* Mistakes, what JOD the worst set has with each, and how much of the difference remains; and facts where no mistake explains all. */
static void put_mistakes(FILE *out, const nqm_conform_report *r, const char *between) {
    const char *const facts[] = {r->sets, r->angles, r->most};
    fputs(!r->n_mistakes && r->difference == 0 ? "No difference that a mistake has to explain."
          : !r->n_mistakes                     ? "No mistake of the list explains the difference."
          : !r->is_named                       ? "No mistake of the list explains the difference. The nearest: "
          : r->lowest_jod < NQM_CONFORM_PASS   ? "Likely mistake: "
                                               : "Likely mistake, which is not visible: ",
          out);
    for (size_t i = 0; i < r->n_mistakes; ++i) {
        const nqm_conform_mistake *m = &r->mistakes[i];
        fprintf(out, "%s%s%s (with it: lowest JOD %.2f, and %.1f %% of the difference remains)",
                i == 0   ? ""
                : i == 1 ? between
                         : "; ",
                i == 1 ? "Next: " : "", m->text, m->lowest_jod, 100 * m->remaining);
    }
    for (size_t i = 0; i < 3; ++i)
        if (*facts[i] && (!r->is_named || r->mistakes[0].lowest_jod < NQM_CONFORM_PASS))
            fprintf(out, "%s%s", between, facts[i]);
    fputc('\n', out);
}

static json_t *json_mistakes(const nqm_conform_report *r) {
    json_t *list = json_array();
    for (const nqm_conform_mistake *m = r->mistakes; m < r->mistakes + r->n_mistakes; ++m)
        json_array_append_new(list,
                              json_row("mistake:s lowest_jod:f remaining:f", m->text, m->lowest_jod, m->remaining));
    return list;
}

static json_t *json_facts(const nqm_conform_report *r, size_t n_directions) {
    static const char *const names[] = {"red", "green", "blue"};
    const nqm_conform_largest *l = &r->largest;
    const double pi = 3.14159265358979323846;
    double deg[4];
    json_t *facts = json_object();
    for (size_t a = 0; a < 4; ++a)
        deg[a] = l->angles_rad[a] * 180 / pi;
    if (*r->sets)
        json_set(facts, "sets:{text:s}", r->sets);
    if (*r->angles)
        json_set(facts, "angles:{text:s}", r->angles);
    if (*r->most)
        json_set(facts, "largest:{text:s set:z row:z channel:s ratio:f value:f right:f angles_deg:[ffff]}", r->most,
                 l->set + 1, l->set * n_directions + l->direction + 1, names[l->channel], l->value / l->right, l->value,
                 l->right, deg[0], deg[1], deg[2], deg[3]);
    return facts;
}

/* ---- the sets ---------------------------------------------------------------------------------------------------- */

static void print_text(const conform_result *r, const row_summary *s) {
    char verdict[NQM_VERDICT_TEXT];
    const score_run *run = &r->run;
    printf("values     %s\nmodel      %s, %zu sets of %zu directions\n\n    JOD  %s%-20s  %sset\n",
           shown(run->ref_name), shown(run->ref_path), run->n_rows, r->kit.n_directions, "[95 %]          ", "verdict",
           has_gate(&run->gate) ? "gate  " : "");
    for (size_t i = 0; i < s->summary.n_shown; ++i) {
        const scored_pair *row = &run->rows[s->summary.order[i]];
        print_jod(row, true);
        printf("  %-20s", row->err.status == NQM_OK ? nqm_verdict(&row->result, verdict) : "no score");
        if (has_gate(&run->gate))
            printf("  %-4s", gate_mark(&run->gate, &row->result));
        printf("  %s\n", row->name);
        if (row->err.status == NQM_OK && !isnan(row->result.parts.structure))
            print_phrases(nqm_label_get_info(&row->result.parts).words);
        print_phrases(row->pair.ref);
    }
    if (s->summary.n_shown < run->n_rows)
        printf("  ... %zu more sets\n", run->n_rows - s->summary.n_shown);
    printf("\n%zu of %zu sets pass: JOD %g or more. Lowest JOD %.2f.\n", r->report.n_passed, run->n_rows,
           NQM_CONFORM_PASS, r->report.lowest_jod);
    put_mistakes(stdout, &r->report, "\n");
}

static void print_conform(const conform_result *r, const row_summary *s) {
    if (r->run.format == FORMAT_JSON) {
        json_t *document = json_scores(&r->run);
        json_object_set_new(document, "lowest_jod", json_number(r->report.lowest_jod));
        json_object_set_new(document, "mistakes", json_mistakes(&r->report));
        json_object_set_new(document, "facts", json_facts(&r->report, r->kit.n_directions));
        print_json(document);
        return;
    }
    if (r->run.format == FORMAT_QUIET)
        puts(r->report.is_named ? r->report.mistakes[0].text : r->report.difference > 0 ? "unknown" : "none");
    if (r->run.format == FORMAT_TEXT)
        print_text(r, s);
}

/* Write JUnit and Markdown where a path is given. */
static void write_conform_reports(const conform_result *r, const row_summary *s) {
    output_file out;
    write_batch_summary(&s->summary, junit, print_batch_junit);
    if (!markdown)
        return;
    open_output(markdown, &out);
    print_batch_markdown(&s->summary, out.stream);
    fputc('\n', out.stream);
    put_mistakes(out.stream, &r->report, "\n\n");
    close_output(&out);
}

/* Say where values are not finite or negative. */
static void report_values(const score_run *run) {
    size_t n_invalid = 0, n_clamped = 0;
    for (size_t i = 0; i < run->n_rows; ++i) {
        n_invalid += run->rows[i].result.n_invalid[1];
        n_clamped += run->rows[i].result.n_clamped[1];
    }
    if (n_invalid)
        report(EXIT_OK, "%zu values are not finite, and are left out", n_invalid);
    if (n_clamped)
        report(EXIT_OK, "%zu values have a negative channel, which counts as 0", n_clamped);
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

static size_t count_rows(const nqm_conform_info *kit) {
    return kit->n_sets * kit->n_directions;
}

static _Noreturn void stop_count(const nqm_conform_info *kit, const char *name, size_t n) {
    stop(EXIT_INCOMPATIBLE,
         "%s has %zu values, and the kit has %zu rows: %zu sets of %zu directions; give the same --keys", name, n,
         count_rows(kit), kit->n_sets, kit->n_directions);
}

/* A field as shaders print it: also nan, inf and -nan(ind), which are no value. */
static float read_field(const nqm_csv *csv, size_t row, int column) {
    const char *text = nqm_csv_text(csv, row, column);
    const char *word = text + (*text == '-' || *text == '+');
    double value;
    const bool is_nan = nqm_equal_any_case(word, "nan", 3) && (!word[3] || word[3] == '(');
    if (is_nan || nqm_equal_any_case(word, "inf", SIZE_MAX) || nqm_equal_any_case(word, "infinity", SIZE_MAX))
        return NAN;
    must(nqm_csv_number(csv, row, column, &value, &fault));
    return (float)value;
}

static void read_csv(const nqm_conform_info *kit, const nqm_map *map, const char *name, float *values) {
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

static void read_npy(const nqm_conform_info *kit, const nqm_map *map, float *values) {
    nqm_tensor tensor;
    must(nqm_npy_parse(map, &tensor, &fault));
    const size_t n = nqm_tensor_count(&tensor), n_each = nqm_dtype_size(tensor.dtype);
    const unsigned char *data = tensor.data;
    if (n != 3 * count_rows(kit) || tensor.n_dims < 2 || tensor.dims[tensor.n_dims - 1] != 3)
        stop_count(kit, map->path, n / 3);
    for (size_t i = 0; i < n; ++i)
        values[i] = n_each == 4 ? nqm_load_f32(data + 4 * i) : (float)nqm_load_f64(data + 8 * i);
}

static float *read_file(const nqm_conform_info *kit, const char *path, const char *name) {
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

/* Values of all sets, (n_sets, n_directions, 3) float; free() it. path: a CSV with the columns r, g, b, or an array of NumPy. */
static float *read_results(const nqm_conform_info *kit, const char *path) {
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

/* The same from a command of the shell, which gets the rows of the kit and prints such a CSV. */
static float *run_command(const nqm_conform_kit *kit, const nqm_conform_info *info, const char *line) {
    FILE *in = tmpfile(), *out = tmpfile();
    char path[32];
    if (!in || !out)
        stop(EXIT_OPEN, "--command needs a folder for temporary files: %s", strerror(errno));
    snprintf(path, sizeof path, "/dev/fd/%d", fileno(in));
    must(nqm_conform_kit_write(kit, "csv", path, &fault));
    const pid_t child = start(line, in, out);
    if (child < 0)
        stop(EXIT_LIMIT, "the command cannot be started: %s", strerror(errno));
    const int status = await(child, out, count_rows(info));
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        stop(EXIT_INCOMPATIBLE, "the command '%s' ended with %s %d", line, WIFEXITED(status) ? "exit code" : "signal",
             WIFEXITED(status) ? WEXITSTATUS(status) : WTERMSIG(status));
    snprintf(path, sizeof path, "/dev/fd/%d", fileno(out));
    float *values = read_file(info, path, "the output of the command");
    fclose(in);
    fclose(out);
    return values;
}

/* ---- --self ------------------------------------------------------------------------------------------------------ */

/* Print the proof of the kit. Returns the exit code. */
static int prove_kit(const nqm_conform_kit *kit, const nqm_conform_info *info, result_format format) {
    nqm_conform_proof proof;
    must(nqm_conform_prove(kit, show_progress, NULL, &proof, &fault));
    end_progress();
    json_t *missed = json_array();
    for (char *line = strtok(proof.missed, "\n"); line; line = strtok(NULL, "\n"))
        json_array_append_new(missed, json_string(line));
    json_t *document = json_row("model:s sets:z directions:z lowest_jod:f mistakes:z named_first:z named_in_three:z "
                                "not_first:o passes:b",
                                info->model, info->n_sets, info->n_directions, proof.lowest_jod, proof.n_mistakes,
                                proof.n_first, proof.n_three, missed, proof.passes);
    if (format == FORMAT_JSON)
        print_document(document);
    else
        print_members(document);
    return proof.passes ? EXIT_OK : EXIT_GATE;
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static choice models[32]; /* name_models() fills it */

static const char *keys, *rows, *shader, *shell;
static bool is_self;
static uint64_t n_worst = 10;
static conform_result result = {.run.gate.jod = 9.99}; /* below it, a difference can be seen */

static const option options[] = {
    {"directions", 'd', OPTION_TEXT, &rows, "FILE.csv", "write the kit: a row for each set and direction", 0, 0},
    {"shader", 0, OPTION_TEXT, &shader, "FILE.glsl|.hlsl|.h", "write the kit as arrays, with the loop over them", 0, 0},
    {"command", 'c', OPTION_TEXT, &shell, "COMMAND",
     "instead of VALUES: a command of the shell that reads the rows and prints r,g,b", 0, 0},
    {"keys", 'k', OPTION_TEXT, &keys, "LIST",
     "parameters that the shader has, with commas; the others keep their defaults. Of the kit and of its VALUES alike",
     0, 0},
    {"self", 0, OPTION_FLAG, &is_self, NULL, "prove the kit: nqm's own values, and those of each mistake", 0, 0},
    {"worst", 0, OPTION_COUNT, &n_worst, "N", "sets to print; 0: all", 0, 1000},
    OPTION_ROWS_GATE(&result.run.gate),
    {"junit", 0, OPTION_TEXT, &junit, "FILE.xml", "also write a JUnit report: one test case per set", 0, 0},
    {"markdown", 0, OPTION_TEXT, &markdown, "FILE.md", "also write a table in Markdown, worst first; -: stdout", 0, 0},
    {"json", 0, OPTION_FORMAT, &result.run.format, NULL, "print JSON", FORMAT_JSON, 0},
    {"quiet", 'q', OPTION_FORMAT, &result.run.format, NULL, "print the likely mistake only, or none", FORMAT_QUIET, 0},
    {0}};

static const command cmd = {
    .usage = "MODEL [VALUES] [options]",
    .about = "Does a shader implement its specification? The kit is a list of parameter sets and directions. VALUES "
             "are the shader's f_r there, in the order of the kit: a CSV with the columns r, g, b, or an array of "
             "NumPy (sets, directions, 3). Each set gets a JOD, and the mistake that explains the difference is "
             "named, or what failing sets have in common. The exit code is 1 when a set is below 9.99, or below "
             "--fail-under; --fail-under 0 only looks. MODEL "
             "is one of:",
    .example = "nqm conform gltf --shader kit.h\nnqm conform gltf --directions kit.csv\n"
               "nqm conform gltf values.csv --junit conform.xml\n"
               "nqm conform open-pbr --command 'python3 my_openpbr.py'\nnqm conform rough-conductor --self",
    .options = options,
    .choices = models,
    .min_arguments = 1,
    .max_arguments = 2,
};

static void check_usage(int n_arguments) {
    const bool is_kit = rows || shader;
    if ((n_arguments == 2) + (shell != NULL) + is_self + is_kit != 1)
        stop(EXIT_USAGE, "give VALUES or --command, or write the kit with --directions or --shader, or --self");
}

/* The shading models, and their other names. */
static void name_models(void) {
    nqm_translate_model m = nqm_translate_target(0);
    for (size_t i = 0, n = 0; m.name; m = nqm_translate_target(++i)) {
        models[n++] = (choice){m.name, "[VALUES]", m.about};
        if (m.alias)
            models[n++] = (choice){m.alias, "[VALUES]", must_have(nqm_strdupf("the same as %s", m.name))};
    }
}

/* Compare the values, which have a name, print what is found and write reports. Returns the exit code. */
static int compare(const nqm_conform_kit *kit, const char *name, const float *values) {
    conform_result *r = &result;
    row_summary s;
    nqm_score_result *results = allocate(r->kit.n_sets, sizeof *results);
    must(nqm_conform_compare(kit, values, show_progress, NULL, results, &r->report, &fault));
    end_progress();
    r->run.options = plain_score_options();
    make_rows(r, kit, name, results);
    summarise_rows(&r->run, name, n_worst ? (size_t)n_worst : r->kit.n_sets, &s);
    print_conform(r, &s);
    write_conform_reports(r, &s);
    report_values(&r->run);
    const int exit_code = apply_gate(&r->run, report_faults(&r->run));
    free_row_summary(&s);
    free(results);
    return exit_code;
}

int cmd_conform(int argc, char **argv) {
    name_models();
    const int n_arguments = parse_arguments(&cmd, argc, argv);
    check_usage(n_arguments);
    nqm_conform_kit *kit;
    int exit_code = EXIT_OK;
    result.run.model = open_model(NULL);
    must(nqm_conform_kit_create(argv[0], keys, result.run.model, &kit, &fault));
    const nqm_conform_info *info = &result.kit;
    result.kit = nqm_conform_kit_get_info(kit, 0);
    if (rows)
        must(nqm_conform_kit_write(kit, "csv", output_path(rows), &fault));
    if (shader)
        must(nqm_conform_kit_write(kit, strrchr(shader, '.') ? NULL : "glsl", output_path(shader), &fault));
    if (is_self)
        exit_code = prove_kit(kit, info, result.run.format);
    if (shell || n_arguments == 2) {
        float *values = shell ? run_command(kit, info, shell) : read_results(info, input_path(argv[1]));
        exit_code = compare(kit, shell ? shell : argv[1], values);
        free(values);
    }
    if (rows || shader)
        report(EXIT_OK, "%zu sets of %zu directions: %zu values", info->n_sets, info->n_directions, count_rows(info));
    nqm_conform_kit_free(kit);
    nqm_model_free(result.run.model);
    return exit_code;
}
