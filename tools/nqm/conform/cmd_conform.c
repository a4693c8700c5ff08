/* SPDX-License-Identifier: MIT
 *
 * nqm conform - does a shader implement its specification, and which mistake does it make?
 */
#include "nqm/conform/conform.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *junit, *markdown;

enum { N_NAMED = 3 };
/* The JOD from which on a set passes: the rest is rounding. */
static const double conform_pass = 9.99;
typedef struct conform_result {
    const conform_kit *kit;
    score_run run; /* a row for each set, in their order */
    size_t n_passed;
    double lowest; /* JOD */
    double none;   /* as suspect.left, without a mistake; 0: all sets pass */
    size_t n_named;
    suspect named[N_NAMED];
    json_t *facts;
    size_t n_shown; /* sets in tables */
} conform_result;

/* Rows for the results of the sets. */
static void make_rows(conform_result *r, const char *name, const nqm_score_result *results) {
    const conform_kit *kit = r->kit;
    r->run.model = kit->metric;
    r->run.n_rows = kit->n_sets;
    r->run.rows = allocate(kit->n_sets, sizeof *r->run.rows);
    r->run.ref_path = kit->model->schema->model;
    r->run.ref_name = name;
    r->run.terms = (remark_terms){kit->metric, NQM_INVALID_DROP};
    for (size_t set = 0; set < kit->n_sets; ++set) {
        scored_pair *row = &r->run.rows[set];
        const kit_set *of = &kit->sets[set];
        *row = (scored_pair){.pair = {of->spec, name}, .name = of->name, .result = results[set], .order = set};
        row->err.status = results[set].status;
        if (row->err.status != NQM_OK)
            snprintf(row->err.message, sizeof row->err.message, "set %zu: %zu of %zu values are not finite", set + 1,
                     results[set].n_invalid[1], kit->n_directions);
    }
}

/* ---- scores ------------------------------------------------------------------------------------------------------ */

/* Score values, (n_sets, n_directions, 3), against suspect `s`; results (n_sets). Returns the lowest JOD. */
static double score_values(const conform_kit *kit, const float *values, const suspect *s, nqm_score_result *results) {
    const nqm_score_options options = plain_score_options();
    nqm_scorer *scorer = open_scorer(kit->metric, &options);
    const size_t n = kit->n_directions;
    double lowest = 10;
    float *ref = allocate(3 * kit->n_sets * n, sizeof *ref), *test = allocate(3 * kit->n_sets * n, sizeof *test);
    uint8_t *used = allocate(kit->n_sets * n, 1);
    nqm_sample_pair *pairs = allocate(kit->n_sets, sizeof *pairs);
    for (size_t set = 0; set < kit->n_sets; ++set) {
        pairs[set] = (nqm_sample_pair){ref + 3 * set * n, test + 3 * set * n, used + set * n};
        sample_suspect(kit, set, s, ref + 3 * set * n);
    }
    for (size_t i = 0; i < kit->n_sets * n; ++i) {
        used[i] = (uint8_t)(isnan(values[3 * i]) == 0);
        for (size_t c = 0; c < 3; ++c)
            test[3 * i + c] = used[i] ? fmaxf(values[3 * i + c], 0) : 0;
    }
    must(nqm_scorer_run_samples(scorer, kit->n_sets, pairs, results, &fault));
    for (size_t set = 0; set < kit->n_sets; ++set) {
        lowest = fmin(lowest, results[set].jod); /* without NaN */
        for (size_t i = set * n; i < (set + 1) * n; ++i) {
            const float *v = values + 3 * i;
            results[set].n_invalid[1] += !used[i];
            results[set].n_clamped[1] += used[i] && (v[0] < 0 || v[1] < 0 || v[2] < 0);
        }
    }
    nqm_scorer_free(scorer);
    free(pairs);
    free(used);
    free(test);
    free(ref);
    return lowest;
}

/* ---- the likely mistake ------------------------------------------------------------------------------------------ */

/* All sets pass with it, or it leaves less than half of the difference (with an amount, which fits more, a tenth), and no worse
 * set than without it. */
static bool is_named(const conform_result *r) {
    const suspect *s = &r->named[0];
    const double most = s->flaws[0].amount != 0 || s->flaws[1].amount != 0 ? 0.1 : 0.5;
    return r->n_named && ((s->left < most * r->none && s->lowest > r->lowest - 0.01) ||
                          (r->lowest < conform_pass && s->lowest >= conform_pass));
}

/* Mistakes, what JOD the worst set has with each, and how much of the difference remains; and facts where no mistake explains all. */
static void put_mistakes(FILE *out, const conform_result *r, const char *between) {
    const char *name;
    json_t *fact;
    fputs(!r->n_named && r->none == 0 ? "No difference that a mistake has to explain."
          : !r->n_named               ? "No mistake of the list explains the difference."
          : !is_named(r)              ? "No mistake of the list explains the difference. The nearest: "
          : r->lowest < conform_pass  ? "Likely mistake: "
                                      : "Likely mistake, which is not visible: ",
          out);
    for (size_t i = 0; i < r->n_named; ++i) {
        const suspect *s = &r->named[i];
        fprintf(out, "%s%s%s (with it: lowest JOD %.2f, and %.1f %% of the difference remains)",
                i == 0   ? ""
                : i == 1 ? between
                         : "; ",
                i == 1 ? "Next: " : "", s->text, s->lowest, 100 * s->left / r->none);
    }
    if (!is_named(r) || r->named[0].lowest < conform_pass)
        json_object_foreach(r->facts, name, fact)
            fprintf(out, "%s%s", between, json_string_value(json_object_get(fact, "text")));
    fputc('\n', out);
}

static json_t *json_mistakes(const conform_result *r) {
    json_t *list = json_array();
    for (size_t i = 0; i < r->n_named; ++i)
        json_array_append_new(list, json_pack("{s:s,s:o,s:o}", "mistake", r->named[i].text, "lowest_jod",
                                              json_number(r->named[i].lowest), "remaining",
                                              json_number(r->named[i].left / r->none)));
    return list;
}

/* ---- the sets ---------------------------------------------------------------------------------------------------- */

static void print_text(const conform_result *r, const row_summary *s) {
    char verdict[NQM_VERDICT_TEXT];
    const score_run *run = &r->run;
    printf("values     %s\nmodel      %s, %zu sets of %zu directions\n\n    JOD  %s%-20s  %sset\n",
           shown(run->ref_name), shown(run->ref_path), run->n_rows, r->kit->n_directions, "[95 %]          ", "verdict",
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
    printf("\n%zu of %zu sets pass: JOD %g or more. Lowest JOD %.2f.\n", r->n_passed, run->n_rows, conform_pass,
           r->lowest);
    put_mistakes(stdout, r, "\n");
}

static void print_conform(const conform_result *r, const row_summary *s) {
    if (r->run.format == FORMAT_JSON) {
        json_t *document = json_scores(&r->run);
        json_object_set_new(document, "lowest_jod", json_number(r->lowest));
        json_object_set_new(document, "mistakes", json_mistakes(r));
        json_object_set(document, "facts", r->facts);
        print_json(document);
        return;
    }
    if (r->run.format == FORMAT_QUIET)
        puts(is_named(r) ? r->named[0].text : r->none > 0 ? "unknown" : "none");
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
    put_mistakes(out.stream, r, "\n\n");
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

/* The result; name: of the values. */
static void compare(conform_result *r, const char *name, const float *values) {
    const suspect none = {.n_flaws = 0};
    const conform_kit *kit = r->kit;
    nqm_score_result *results = allocate(kit->n_sets, sizeof *results);
    bool fails[KIT_MAX_SETS];
    r->run.options = plain_score_options();
    r->lowest = score_values(kit, values, &none, results);
    make_rows(r, name, results);
    for (size_t set = 0; set < kit->n_sets; ++set) {
        fails[set] = !(results[set].jod >= conform_pass);
        r->n_passed += !fails[set];
    }
    r->n_named = find_suspects(kit, values, N_NAMED, r->named, &r->none);
    for (size_t i = 0; i < r->n_named; ++i)
        r->named[i].lowest = score_values(kit, values, &r->named[i], results);
    if (r->n_passed == kit->n_sets && !is_named(r)) { /* rounding */
        r->n_named = 0;
        r->none = 0;
    }
    r->facts = list_facts(kit, values, fails);
    free(results);
}

/* ---- --self ------------------------------------------------------------------------------------------------------ */

/* A copy whose inputs are rounded to float32. */
static conform_kit *round_kit(const conform_kit *kit) {
    conform_kit *rounded = copy_kit(kit, 1);
    for (size_t i = 0; i < 6 * KIT_TURNS * kit->n_directions; ++i)
        rounded->directions[i] = (double)(float)kit->directions[i];
    for (size_t set = 0; set < kit->n_sets; ++set)
        for (size_t k = 0; k < kit->model->schema->n_keys; ++k)
            for (size_t c = 0; c < 3; ++c)
                rounded->sets[set].values.v[k][c] = (double)(float)kit->sets[set].values.v[k][c];
    return rounded;
}

/* Prove the kit: the model's own values, from directions and parameters in float32 as a shader gets them, pass, and each mistake is
 * named from its values. Returns the exit code. */
static int prove_kit(const conform_kit *kit, result_format format) {
    const double noticed = 1e-4;
    size_t n, n_seen = 0, n_first = 0, n_three = 0;
    suspect *list = list_suspects(kit, &n);
    conform_kit *rounded = round_kit(kit);
    double *left = allocate(n * n, sizeof *left);
    json_t *missed = json_array();
    float *values = allocate(3 * kit->n_sets * kit->n_directions, sizeof *values);
    nqm_score_result *results = allocate(kit->n_sets, sizeof *results);
    for (size_t set = 0; set < kit->n_sets; ++set)
        sample_suspect(rounded, set, &list[0], values + 3 * set * kit->n_directions);
    const double lowest = score_values(kit, values, &list[0], results);
    compare_suspects(kit, n, list, &(suspect_targets){.n = n, .planted = rounded}, left);
    for (size_t t = 1; t < n; ++t) {
        if (left[t * n] < noticed) /* this model does not have it */
            continue;
        size_t rank = 0; /* those with equal values (to float32) count as itself */
        for (size_t other = 0; other < n; ++other)
            rank += left[t * n + other] < left[t * n + t] - 1e-6;
        ++n_seen;
        n_first += rank == 0;
        n_three += rank < 3;
        describe_suspect(kit, &list[t]);
        if (rank)
            json_array_append_new(missed, json_string(list[t].text));
    }
    const bool passes = lowest >= conform_pass && 10 * n_first >= 9 * n_seen && 100 * n_three >= 98 * n_seen;
    json_t *document =
        json_pack("{s:s,s:I,s:I,s:o,s:I,s:I,s:I,s:o,s:b}", "model", kit->model->schema->model, "sets",
                  (json_int_t)kit->n_sets, "directions", (json_int_t)kit->n_directions, "lowest_jod",
                  json_number(lowest), "mistakes", (json_int_t)n_seen, "named_first", (json_int_t)n_first,
                  "named_in_three", (json_int_t)n_three, "not_first", missed, "passes", passes);
    if (format == FORMAT_JSON)
        print_document(document);
    else
        print_members(document);
    free_kit_copy(rounded);
    free(results);
    free(values);
    free(left);
    free(list);
    return passes ? EXIT_OK : EXIT_GATE;
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static const choice models[] = {{"gltf", "[VALUES]", "glTF 2.0 with specular, ior, anisotropy, sheen, clearcoat"},
                                {"open-pbr", "[VALUES]", "OpenPBR Surface 1.1 by MaterialX"},
                                {"standard-surface", "[VALUES]", "Autodesk Standard Surface by MaterialX"},
                                {"usd-preview", "[VALUES]", "UsdPreviewSurface by MaterialX"},
                                {"disney", "[VALUES]", "Disney Principled by MaterialX"},
                                {"principled", "[VALUES]", "Mitsuba 3's principled"},
                                {"rough-conductor", "[VALUES]", "Mitsuba 3's roughconductor"},
                                {"rough-plastic", "[VALUES]", "Mitsuba 3's roughplastic"},
                                {"pbrt-conductor", "[VALUES]", "pbrt-v4's conductor"},
                                {0}};

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
    {"worst", 0, OPTION_COUNT, &n_worst, "N", "sets to print; 0: all", 0, KIT_MAX_SETS},
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

int cmd_conform(int argc, char **argv) {
    const int n_arguments = parse_arguments(&cmd, argc, argv);
    check_usage(n_arguments);
    conform_kit *kit = make_kit(argv[0], keys);
    int exit_code = EXIT_OK;
    if (rows) {
        output_file out;
        open_output(rows, &out);
        write_kit_rows(kit, out.stream);
        close_output(&out);
    }
    if (shader)
        write_kit_shader(kit, shader);
    if (is_self)
        exit_code = prove_kit(kit, result.run.format);
    if (shell || n_arguments == 2) {
        float *values = shell ? run_command(kit, shell) : read_results(kit, input_path(argv[1]));
        result.kit = kit;
        result.n_shown = n_worst ? (size_t)n_worst : KIT_MAX_SETS;
        compare(&result, shell ? shell : argv[1], values);
        row_summary s;
        summarise_rows(&result.run, result.run.ref_name, result.n_shown, &s);
        print_conform(&result, &s);
        write_conform_reports(&result, &s);
        free_row_summary(&s);
        report_values(&result.run);
        exit_code = apply_gate(&result.run, report_faults(&result.run));
        free(result.run.rows);
        json_decref(result.facts);
        free(values);
    } else if (!is_self)
        report(EXIT_OK, "%zu sets of %zu directions: %zu values", kit->n_sets, kit->n_directions,
               kit->n_sets * kit->n_directions);
    free_kit(kit);
    return exit_code;
}
