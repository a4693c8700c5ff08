/* SPDX-License-Identifier: MIT
 *
 * nqm dedup - clusters of materials of a library that look like one of them.
 */
#include "nqm/rows.h"
#include "nqm/score/score.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

static void print_text(const nqm_library *of) {
    const bool is_calibrated = *nqm_model_get_info(run.model).calibration;
    printf("%zu materials, of which %zu are replaced and %zu remain (JOD %g, model %s)\n", of->n, run.n_rows,
           of->n - run.n_rows, jod, shown(nqm_model_get_info(run.model).id));
    for (size_t i = 0; i < run.n_rows; ++i) {
        const scored_pair *row = &run.rows[i];
        if (i == 0 || strcmp(row->pair.test, row[-1].pair.test) != 0)
            printf("\nkept       %s\n", shown(row->pair.test));
        print_jod(row, is_calibrated);
        printf("  %s\n", shown(row->pair.ref));
        if (!row->result.identical && !isnan(row->result.parts.structure))
            print_phrases(nqm_label_get_info(&row->result.parts).words);
    }
}

static void print_results(const nqm_library *of) {
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
    run.options = plain_score_options();
    const int n_where = parse_arguments(&cmd, argc, argv);
    run.model = open_model(model);
    nqm_library *of = open_library((size_t)n_where, (const char *const *)argv, &run, NULL);
    find_near(of, &(nqm_library_query){.jod = jod}, &run);
    if (map)
        write_map(map);
    print_results(of);
    return conclude_near(of, &run);
}
