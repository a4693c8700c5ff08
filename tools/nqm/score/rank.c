/* SPDX-License-Identifier: MIT
 *
 * Sorting and output of `nqm rank`.
 */
#include "nqm/score/rank.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Scores that differ by less share a rank. The limit is ten times the rounding differences between groupings of
 * pairs. */
static const double tie_jod = 1e-4;

/* ---- sorting ----------------------------------------------------------------------------------------------------- */

static bool has_score(const rank_row *row) {
    return row->result.status == NQM_OK;
}

static int by_quality(const void *a, const void *b) {
    const rank_row *x = a, *y = b;
    if (x->group != y->group)
        return x->group < y->group ? -1 : 1;
    if (has_score(x) != has_score(y))
        return has_score(x) ? -1 : 1;
    if (has_score(x) && x->result.jod != y->result.jod)
        return x->result.jod > y->result.jod ? -1 : 1;
    return x->order < y->order ? -1 : 1;
}

static int by_order(const void *a, const void *b) {
    const rank_row *x = a, *y = b;
    return x->order < y->order ? -1 : 1;
}

static int by_reference(const void *a, const void *b) {
    const rank_row *x = a, *y = b;
    int difference = strcmp(x->pair.ref, y->pair.ref);
    return difference ? difference : by_order(a, b);
}

/* Number the references by their first appearance. */
static void number_groups(ranking *r) {
    qsort(r->rows, r->n_rows, sizeof *r->rows, by_reference);
    size_t first = 0;
    for (size_t i = 0; i < r->n_rows; ++i) {
        bool new_one = i == 0 || strcmp(r->rows[i].pair.ref, r->rows[i - 1].pair.ref) != 0;
        first = new_one ? r->rows[i].order : first;
        r->rows[i].group = first; /* only the order of the numbers matters */
    }
}

static bool same_group(const ranking *r, size_t i, size_t k) {
    return k < r->n_rows && r->rows[i].group == r->rows[k].group;
}

void rank_rows(ranking *r) {
    number_groups(r);
    qsort(r->rows, r->n_rows, sizeof *r->rows, by_quality);
    size_t best = 0, leader = 0; /* first row of the reference; first row with an equal score */
    for (size_t i = 0; i < r->n_rows; ++i) {
        rank_row *row = &r->rows[i];
        row->over_next = row->best_preferred = (double)NAN;
        if (i == 0 || !same_group(r, i - 1, i))
            best = leader = i;
        if (!has_score(row))
            continue;
        double jod = row->result.jod;
        if (r->rows[leader].result.jod - jod >= tie_jod)
            leader = i;
        row->rank = leader - best + 1;
        if (i != best)
            row->best_preferred = nqm_jod_preference(r->rows[best].result.jod, jod);
        if (same_group(r, i, i + 1) && has_score(&r->rows[i + 1]))
            row->over_next = nqm_jod_preference(jod, r->rows[i + 1].result.jod);
    }
}

/* ---- output ------------------------------------------------------------------------------------------------------ */

static void print_percent(double share) {
    if (isfinite(share))
        printf("  %7.0f %%", 100 * share);
    else
        printf("  %9s", "-");
}

static void print_text(const ranking *r) {
    char text[INTERVAL_TEXT];
    bool calibrated = *nqm_model_get_info(r->model).calibration;
    printf("model      %s\n", nqm_model_get_info(r->model).id);
    for (size_t i = 0; i < r->n_rows; ++i) {
        const rank_row *row = &r->rows[i];
        if (i == 0 || !same_group(r, i - 1, i))
            printf("%sreference  %s\n\n  %4s  %5s%s  %9s  %9s  test\n", i ? "\n" : "", row->pair.ref, "rank", "JOD",
                   calibrated ? "  [95 %]        " : "", "over next", "best over");
        if (has_score(row))
            printf("  %4zu  %5.2f", row->rank, row->result.jod);
        else
            printf("  %4s  %5s", "-", "-");
        if (calibrated)
            printf("  %-*s", INTERVAL_WIDTH, has_score(row) ? interval_text(&row->result, text) : "-");
        print_percent(row->over_next);
        print_percent(row->best_preferred);
        printf("  %s\n", row->pair.test);
    }
    puts("\nover next: people who would prefer it to the one below; best over: who would prefer the best to it\n"
         "(50 % is guessing; one JOD is 75 %).");
}

static void print_csv(const ranking *r) {
    puts("reference,rank,test,jod,jod_low,jod_high,over_next,best_preferred,error");
    for (size_t i = 0; i < r->n_rows; ++i) {
        const rank_row *row = &r->rows[i];
        print_csv_text(stdout, row->pair.ref);
        putchar(',');
        if (row->rank)
            printf("%zu", row->rank);
        putchar(',');
        print_csv_text(stdout, row->pair.test);
        const double numbers[] = {row->result.jod, row->result.jod_low, row->result.jod_high, row->over_next,
                                  row->best_preferred};
        for (size_t k = 0; k < sizeof numbers / sizeof *numbers; ++k) {
            putchar(',');
            print_csv_number(stdout, numbers[k]);
        }
        putchar(',');
        print_csv_text(stdout, has_score(row) ? "" : row->err->message);
        putchar('\n');
    }
}

static int print_ranking_json(const ranking *r) {
    json_t *results = json_array();
    for (size_t i = 0; i < r->n_rows; ++i) {
        const rank_row *row = &r->rows[i];
        json_t *object =
            json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:b,s:o,s:o}", "reference", json_name(row->pair.ref), "rank",
                      row->rank ? json_integer((json_int_t)row->rank) : json_null(), "test", json_name(row->pair.test),
                      "jod", json_number(row->result.jod), "jod_low", json_number(row->result.jod_low), "jod_high",
                      json_number(row->result.jod_high), "identical", row->result.identical, "over_next",
                      json_number(row->over_next), "best_preferred", json_number(row->best_preferred));
        if (!has_score(row))
            json_object_set_new(object, "error", json_name(row->err->message));
        json_array_append_new(results, object);
    }
    return print_json(json_pack("{s:i,s:o,s:o,s:o}", "schema", 1, "tool", json_tool(), "model",
                                model_json(r->model, r->precision), "results", results));
}

static void print_names(const ranking *r) {
    for (size_t i = 0; i < r->n_rows; ++i)
        if (has_score(&r->rows[i]))
            puts(r->rows[i].pair.test);
}

int print_ranking(const ranking *r) {
    switch (r->format) {
    case FORMAT_JSON:
        return print_ranking_json(r);
    case FORMAT_CSV:
        print_csv(r);
        break;
    case FORMAT_QUIET:
        print_names(r);
        break;
    case FORMAT_TEXT:
        print_text(r);
        break;
    }
    return fflush(stdout) == 0 ? EXIT_OK : report("rank", EXIT_OPEN, "standard output: cannot write");
}
