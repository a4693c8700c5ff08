/* SPDX-License-Identifier: MIT
 *
 * Results of `nqm conform`: the sets, worst first, and the likely mistake; the same as JSON, JUnit and Markdown by the writers of
 * `nqm score` and `nqm batch`.
 */
#include "nqm/conform/conform.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- scores ------------------------------------------------------------------------------------------------------ */

void score_values(const conform_kit *kit, nqm_scorer *scorer, const float *values, const suspect *s,
                  nqm_score_result *results) {
    const size_t n = kit->n_directions;
    float *ref = allocate(3 * kit->n_sets * n, sizeof *ref), *test = allocate(3 * kit->n_sets * n, sizeof *test);
    uint8_t *used = allocate(kit->n_sets * n, 1);
    nqm_sample_pair *pairs = allocate(kit->n_sets, sizeof *pairs);
    nqm_error err = {0};
    for (size_t set = 0; set < kit->n_sets; ++set) {
        pairs[set] = (nqm_sample_pair){ref + 3 * set * n, test + 3 * set * n, used + set * n};
        sample_suspect(kit, set, s, ref + 3 * set * n);
    }
    for (size_t i = 0; i < kit->n_sets * n; ++i) {
        used[i] = (uint8_t)(isnan(values[3 * i]) == 0);
        for (size_t c = 0; c < 3; ++c)
            test[3 * i + c] = used[i] ? fmaxf(values[3 * i + c], 0) : 0;
    }
    must(nqm_scorer_run_samples(scorer, kit->n_sets, pairs, results, &err), &err);
    for (size_t set = 0; set < kit->n_sets; ++set)
        for (size_t i = set * n; i < (set + 1) * n; ++i) {
            const float *v = values + 3 * i;
            results[set].n_invalid[1] += !used[i];
            results[set].n_clamped[1] += used[i] && (v[0] < 0 || v[1] < 0 || v[2] < 0);
        }
    free(pairs);
    free(used);
    free(test);
    free(ref);
}

/* ---- the likely mistake ------------------------------------------------------------------------------------------ */

static double lowest_jod(const conform_result *r) {
    double jod = 10;
    for (size_t i = 0; i < r->run.n_rows; ++i)
        jod = fmin(jod, r->run.rows[i].result.jod); /* without NaN */
    return jod;
}

/* It leaves less than half of the difference, or none that is visible. */
bool is_named(const conform_result *r) {
    return r->n_named &&
           (r->named[0].left < 0.5 * r->none || (lowest_jod(r) < conform_pass && r->named[0].lowest >= conform_pass));
}

/* A mistake, what JOD the worst set has with it, and how much of the difference remains. */
static void put_suspect(FILE *out, const conform_result *r, const suspect *s) {
    fprintf(out, "%s (with it: lowest JOD %.2f, and %.1f %% of the difference remains)", s->text, s->lowest,
            100 * s->left / r->none);
}

static void put_mistakes(FILE *out, const conform_result *r, const char *between) {
    if (!r->n_named) {
        fputs(r->none > 0 ? "No mistake of the list explains the difference.\n"
                          : "No difference that a mistake has to explain.\n",
              out);
        return;
    }
    fputs(is_named(r) ? lowest_jod(r) < conform_pass ? "Likely mistake: " : "Likely mistake, which is not visible: "
                      : "No mistake of the list explains most of the difference. The nearest: ",
          out);
    for (size_t i = 0; i < r->n_named; ++i) {
        fputs(i == 0 ? "" : i == 1 ? between : "; ", out);
        fputs(i == 1 ? "Next: " : "", out);
        put_suspect(out, r, &r->named[i]);
    }
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
    char verdict[VERDICT_TEXT], words[NQM_LABEL_TEXT];
    const score_run *run = &r->run;
    size_t n_passed = 0;
    for (size_t i = 0; i < run->n_rows; ++i)
        n_passed += run->rows[i].result.jod >= conform_pass;
    printf("values     %s\nmodel      %s, %zu sets of %zu directions\n\n    JOD  %s%-20s  %sset\n",
           shown(run->ref_name), shown(run->ref_path), run->n_rows, r->kit->n_directions, "[95 %]          ", "verdict",
           has_gate(&run->gate) ? "gate  " : "");
    for (size_t i = 0; i < s->summary.n_shown; ++i) {
        const scored_pair *row = &run->rows[s->summary.order[i]];
        print_jod(row, true);
        printf("  %-20s", row->err.status == NQM_OK ? verdict_words(&row->result, verdict) : "no score");
        if (has_gate(&run->gate))
            printf("  %-4s", gate_mark(&run->gate, &row->result));
        printf("  %s\n", row->name);
        if (row->err.status == NQM_OK && !isnan(row->result.parts.structure))
            print_phrases(nqm_label_describe(&row->result.parts, words));
        print_phrases(row->pair.ref);
    }
    if (s->summary.n_shown < run->n_rows)
        printf("  ... %zu more sets\n", run->n_rows - s->summary.n_shown);
    printf("\n%zu of %zu sets pass: JOD %g or more. Lowest JOD %.2f.\n", n_passed, run->n_rows, conform_pass,
           lowest_jod(r));
    put_mistakes(stdout, r, "\n");
}

void print_conform(const conform_result *r) {
    if (r->run.format == FORMAT_JSON) {
        json_t *document = json_scores(&r->run);
        json_object_set_new(document, "lowest_jod", json_number(lowest_jod(r)));
        json_object_set_new(document, "mistakes", json_mistakes(r));
        print_json(document);
        return;
    }
    if (r->run.format == FORMAT_QUIET)
        puts(is_named(r) ? r->named[0].text : r->none > 0 ? "unknown" : "none");
    if (r->run.format != FORMAT_TEXT)
        return;
    row_summary s;
    summarise_rows(&r->run, r->run.ref_name, r->n_shown, &s);
    print_text(r, &s);
    free_row_summary(&s);
}

void write_conform_reports(const conform_result *r, const char *junit, const char *markdown) {
    row_summary s;
    output_file out;
    summarise_rows(&r->run, r->run.ref_name, r->n_shown, &s);
    write_batch_summary(&s.summary, junit, print_batch_junit);
    if (markdown) {
        open_output(markdown, &out);
        print_batch_markdown(&s.summary, out.stream);
        fputc('\n', out.stream);
        put_mistakes(out.stream, r, "\n\n");
        close_output(&out);
    }
    free_row_summary(&s);
}
