/* SPDX-License-Identifier: MIT
 *
 * nqm dedup - clusters of materials of a library that look like one of them. Pairs whose pictures are alike are scored
 * in both orders; the materials with the most look-alikes are kept first, so that each other one looks like the one
 * that is kept for it, by its own score.
 */

#include "base/names.h"
#include "nqm/library/library.h"
#include "nqm/rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- look-alikes ------------------------------------------------------------------------------------------------- */

/* The members that look like a member in both orders, as lists after one another. */
typedef struct graph {
    size_t n, *begin; /* (n + 1) */
    size_t *to;
} graph;

/* Scores of both orders of the pairs; pairs below the JOD are removed. Returns how many remain. */
static size_t confirm(const library *of, const nqm_model *with, nqm_scorer *scorer, double jod, near_pair *pairs,
                      size_t n) {
    enum { BLOCK = NQM_SCORE_BLOCK / 2 };
    nqm_named_pair named[2 * BLOCK];
    nqm_score_result r[2 * BLOCK];
    size_t n_left = 0;
    for (size_t first = 0, n_block; first < n; first += n_block) {
        n_block = nqm_smaller(n - first, BLOCK);
        step_progress("score", first, n);
        for (size_t i = 0; i < n_block; ++i) {
            const near_pair *p = &pairs[first + i];
            named[2 * i] = (nqm_named_pair){of->members[p->a].argument, of->members[p->b].argument};
            named[2 * i + 1] = (nqm_named_pair){named[2 * i].test, named[2 * i].ref};
        }
        must(nqm_scorer_run_named(scorer, 2 * n_block, named, r, NULL, &fault));
        for (size_t i = 0; i < 2 * n_block; ++i) {
            const near_pair *p = &pairs[first + i / 2];
            if (of->members[p->a].is_textured || of->members[p->b].is_textured)
                r[i].jod = score_textured(&named[i], with);
        }
        for (size_t i = 0; i < n_block; ++i)
            if (r[2 * i].jod >= jod && r[2 * i + 1].jod >= jod) /* false for NaN */
                pairs[n_left++] = pairs[first + i];
    }
    end_progress();
    return n_left;
}

static graph make_graph(size_t n, const near_pair *pairs, size_t n_pairs) {
    graph g = {n, allocate(n + 2, sizeof *g.begin), allocate(2 * n_pairs, sizeof *g.to)};
    size_t *place = g.begin + 1;
    for (size_t i = 0; i < n_pairs; ++i) {
        ++g.begin[pairs[i].a + 2];
        ++g.begin[pairs[i].b + 2];
    }
    for (size_t i = 2; i < n + 2; ++i)
        g.begin[i] += g.begin[i - 1];
    for (size_t i = 0; i < n_pairs; ++i) { /* place[a] becomes begin[a + 1] */
        g.to[place[pairs[i].a]++] = pairs[i].b;
        g.to[place[pairs[i].b]++] = pairs[i].a;
    }
    return g;
}

/* ---- clusters ---------------------------------------------------------------------------------------------------- */

/* kept (n) receives the member that is kept for each. Returns how many are replaced. */
static size_t make_clusters(const graph *g, size_t *kept) {
    double *n_alike = allocate(g->n, sizeof *n_alike);
    size_t n_replaced = 0;
    for (size_t i = 0; i < g->n; ++i) {
        n_alike[i] = (double)(g->begin[i + 1] - g->begin[i]);
        kept[i] = SIZE_MAX;
    }
    size_t *order = order_by(g->n, n_alike, -1);
    for (size_t k = 0; k < g->n; ++k) {
        const size_t keep = order[k];
        if (kept[keep] != SIZE_MAX)
            continue;
        kept[keep] = keep;
        for (size_t e = g->begin[keep]; e < g->begin[keep + 1]; ++e)
            if (kept[g->to[e]] == SIZE_MAX) {
                kept[g->to[e]] = keep;
                ++n_replaced;
            }
    }
    free(order);
    free(n_alike);
    return n_replaced;
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static score_run run;
static const char *model = "default", *map;
static double jod = 9.5;

static const option options[] = {
    {"jod", 0, OPTION_NUMBER, &jod, "JOD", "the least score at which a material is replaced", 9, 10},
    {"map", 0, OPTION_TEXT, &map, "FILE.csv|.json", "write which material replaces which: old, new", 0, 0},
    OPTION_ROWS_MODEL(&model),
    OPTION_ROW_IGNORE,
    {"json", 0, OPTION_FORMAT, &run.format, NULL, "print JSON", FORMAT_JSON, 0},
    {0}};

static const command cmd = {
    .usage = "WHERE... [options]",
    .about = "Which materials of folders and files look the same as another one of them, so that one "
             "of them is enough, and what is lost. Each replaced material scores at least --jod next to the one that "
             "is kept for it.",
    .example = "nqm dedup materials --jod 9.5\nnqm dedup scene.glb --map replace.json\n"
               "nqm dedup *.mtlx shared/metals.gltf",
    .options = options,
    .table = &nqm_score_option_table,
    .table_target = &run.options,
    .min_arguments = 1,
    .max_arguments = -1,
};

/* The pairs of a replaced material and the one that is kept for it, clusters after one another. */
static void score_replaced(const library *of, const size_t *kept, size_t n) {
    size_t *first = allocate(of->n + 1, sizeof *first);
    begin_rows(&run, n);
    for (size_t i = 0; i < of->n; ++i)
        first[kept[i] + 1] += kept[i] != i;
    for (size_t i = 1; i <= of->n; ++i)
        first[i] += first[i - 1];
    for (size_t i = 0; i < of->n; ++i)
        if (kept[i] != i) {
            const member *keep = &of->members[kept[i]];
            run.rows[first[kept[i]]++] =
                (scored_pair){.pair = {of->members[i].argument, keep->argument}, .name = keep->key};
        }
    make_scores(&run);
    free(first);
}

static void write_map(const char *path) {
    output_file out;
    open_output(path, &out);
    json_t *object = json_object();
    const bool is_json = nqm_name_ends_in(path, ".json");
    if (!is_json)
        fputs("old,new,jod\n", out.stream);
    for (size_t i = 0; i < run.n_rows; ++i) {
        const nqm_named_pair *p = &run.rows[i].pair;
        json_t *old = json_name(p->ref);
        json_object_set_new(object, json_string_value(old), json_name(p->test));
        json_decref(old);
        if (is_json)
            continue;
        print_csv_text(out.stream, p->ref);
        print_csv_field(out.stream, p->test);
        fprintf(out.stream, ",%.4f\n", run.rows[i].result.jod);
    }
    if (is_json) {
        json_dumpf(object, out.stream, JSON_INDENT(1));
        fputc('\n', out.stream);
    }
    json_decref(object);
    close_output(&out);
}

static void print_text(const library *of) {
    const bool is_calibrated = *nqm_model_get_info(run.model).calibration;
    char words[NQM_LABEL_TEXT];
    printf("%zu materials, of which %zu are replaced and %zu remain (JOD %g, model %s)\n", of->n, run.n_rows,
           of->n - run.n_rows, jod, shown(nqm_model_get_info(run.model).id));
    for (size_t i = 0; i < run.n_rows; ++i) {
        const scored_pair *row = &run.rows[i];
        if (i == 0 || strcmp(row->pair.test, row[-1].pair.test) != 0)
            printf("\nkept       %s\n", shown(row->pair.test));
        print_jod(row, is_calibrated);
        printf("  %s\n", shown(row->pair.ref));
        if (!row->result.identical && !isnan(row->result.parts.structure))
            print_phrases(nqm_label_describe(&row->result.parts, words));
    }
}

static void print_results(const library *of) {
    if (run.format == FORMAT_JSON) {
        run.ref_path = of->path;
        json_t *document = json_scores(&run), *row;
        size_t i;
        json_array_foreach(json_object_get(document, "results"), i, row) {
            json_set(row, "old:s new:s", run.rows[i].pair.ref, run.rows[i].pair.test);
        }
        print_json(json_set(document, "jod:f n_materials:z n_replaced:z", jod, of->n, run.n_rows));
    } else {
        print_text(of);
    }
}

int cmd_dedup(int argc, char **argv) {
    library of = {.path = NULL};
    near_pair *pairs;
    run.options = plain_score_options();
    const int n_where = parse_arguments(&cmd, argc, argv);
    run.model = open_model(model);
    nqm_scorer *scorer = open_scorer(run.model, &run.options);
    draw_library((size_t)n_where, (const char *const *)argv, run.model, scorer, NULL, &of);
    size_t n = find_near_pairs(&of, jod, &pairs);
    n = confirm(&of, run.model, scorer, jod, pairs, n);
    nqm_scorer_free(scorer);
    graph g = make_graph(of.n, pairs, n);
    size_t *kept = allocate(of.n, sizeof *kept);
    score_replaced(&of, kept, make_clusters(&g, kept));
    if (map)
        write_map(map);
    print_results(&of);
    const int exit_code = report_faults(&run);
    free(pairs);
    free(kept);
    free(g.begin);
    free(g.to);
    free_scores(&run);
    const size_t n_failed = of.n_failed;
    free_library(&of);
    return exit_code == EXIT_OK && n_failed ? EXIT_PARTIAL : exit_code;
}
