/* SPDX-License-Identifier: MIT
 *
 * nqm translate - write materials as materials of another shading model: fit the target, write the file, and score what was
 * written. With --fail-under it is a gate.
 */
#include "base/options.h"
#include "base/os.h"
#include "brdf/brdf.h"
#include "material/material.h"
#include "nqm/score/score.h"
#include "nqm/show/report.h"
#include "nqm/textured.h"
#include <nqm/translate.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_TEXT = 4096 };

/* A material to translate, and its translation. */
typedef struct item {
    nqm_argument *source;
    const char *argument;   /* its text */
    char path[MAX_TEXT];    /* of the file to write; "": none */
    char written[MAX_TEXT]; /* what is scored: the path, or "FILE:NAME"; "": the spec */
    nqm_error err;          /* status NQM_OK: translated */
    nqm_translation result;
    nqm_score_result score, transport;
    bool is_textured;
    double seconds;
} item;

typedef struct translation {
    nqm_translate_model target;
    const char *path, *folder; /* -o and -d, or NULL */
    nqm_match_loss loss;
    nqm_fit_options fit;
    nqm_scorer *scorer, *transport;
    score_gate gate;
    size_t n, max_n;
    item *items;
} translation;

/* ---- inputs and outputs ------------------------------------------------------------------------------------------- */

static void add_item(translation *t, const char *file, const char *material) {
    t->items = must_have(nqm_grow(t->items, &t->max_n, t->n + 1, sizeof *t->items));
    char *given = join_with_colon(file, material);
    const char *taken = reflecting(given);
    nqm_argument *source = parse_argument(taken);
    t->items[t->n++] = (item){.source = source, .argument = source->text};
    if (taken != given)
        nqm_free((void *)(uintptr_t)taken);
    free(given);
}

/* A file with several materials, and a folder of files, become an item for each material. */
static void add_argument(translation *t, const char *argument) {
    refuse_model_name(argument);
    if (is_library(argument)) {
        nqm_library *of = open_library(1, &argument, NULL, NULL);
        for (size_t i = 0; i < of->n; ++i)
            add_item(t, of->members[i].argument, "");
        nqm_library_free(of);
        return;
    }
    nqm_argument *a = parse_argument(argument);
    const nqm_materials *materials = nqm_argument_library(a);
    for (size_t i = 0; materials && i < nqm_materials_count(materials); ++i)
        add_item(t, argument, nqm_materials_get(materials, i).name);
    if (!materials)
        add_item(t, argument, "");
    nqm_argument_free(a);
}

/* Part of an argument that names it: "gold" of "metals/gold.mtlx", "paints_red" of "paints.mtlx:red". */
static void short_stem(const char *argument, char *stem, size_t n_stem) {
    const char *slash = strrchr(argument, '/'), *begin = slash ? slash + 1 : argument;
    const char *colon = strchr(begin, ':');
    const size_t n_file = colon ? (size_t)(colon - begin) : strlen(begin);
    size_t n = 0;
    while (n < n_file && (begin[n] != '.' || !memchr(begin + n, '.', n_file - n) || n == 0))
        ++n;
    snprintf(stem, n_stem, "%.*s%s%.40s", (int)n, begin, colon ? "_" : "", colon ? colon + 1 : "");
    for (char *c = stem; *c; ++c)
        if (strchr("/:;=,() ", *c))
            *c = '_';
}

/* No output of this run replaces it. */
static void keep_file(void *user, const char *path) {
    nqm_file_info info;
    (void)user;
    if (nqm_os_get_info(path, &info))
        (void)!nqm_role_input(&info, path, NULL);
}

static void name_outputs(translation *t) {
    if (t->path && t->folder)
        stop(EXIT_USAGE, "-o FILE and -d FOLDER exclude each other");
    if (t->folder)
        require_folder_name("-d", t->folder, ".mtlx|.gltf|.glb|.xml|.json|.pbrt", "the materials");
    for (size_t i = 0; i < t->n && (t->path || t->folder); ++i) {
        item *it = &t->items[i];
        char stem[256];
        short_stem(it->argument, stem, sizeof stem);
        const int used = t->path ? snprintf(it->path, MAX_TEXT, "%s", t->path)
                                 : snprintf(it->path, MAX_TEXT, "%s/%s%s", t->folder, stem, t->target.extension);
        if (used < 0 || used >= MAX_TEXT)
            stop(EXIT_USAGE, "%.80s...: the path of the output is too long", it->path);
        must(nqm_material_check(t->target.name, it->path, &fault));
        for (size_t k = 0; t->folder && k < i; ++k)
            if (strcmp(t->items[k].path, it->path) == 0)
                stop(EXIT_USAGE, "'%s' and '%s' would both be written to %s", t->items[k].argument, it->argument,
                     it->path);
    }
    if (t->folder)
        make_folder(t->folder);
    for (size_t i = 0; i < t->n; ++i) { /* all are known as inputs before an output replaces what a later item reads */
        nqm_brdf *brdf = NULL;
        if (nqm_argument_open(t->items[i].source, &brdf, NULL) == NQM_OK)
            nqm_brdf_free(brdf);
        nqm_argument_visit_files(t->items[i].source, keep_file, NULL);
    }
    for (size_t i = 0; i < (t->path ? 1 : t->n); ++i)
        if (t->items[i].path[0])
            require_output(t->items[i].path);
}

/* ---- results ------------------------------------------------------------------------------------------------------ */

static size_t count_refused(const translation *t) {
    size_t n = 0;
    for (size_t i = 0; i < t->n; ++i)
        n += t->items[i].err.status != NQM_OK;
    return n;
}

static size_t count_failed(const translation *t) {
    size_t n = 0;
    for (size_t i = 0; i < t->n; ++i)
        n += t->items[i].err.status == NQM_OK && fails_gate(&t->gate, &t->items[i].score);
    return n;
}

static void print_item(const translation *t, const item *it) {
    if (it->err.status != NQM_OK) {
        const bool is_named = strncmp(it->err.message, it->argument, strlen(it->argument)) == 0;
        printf("refused  %s%s%s\n", is_named ? "" : shown(it->argument), is_named ? "" : ": ", shown(it->err.message));
        return;
    }
    printf("JOD %5.2f", it->score.jod);
    if (!isnan(it->score.jod_low))
        printf(" [%.2f, %.2f]", it->score.jod_low, it->score.jod_high);
    printf("  %s %5.2f  %s -> %s", it->is_textured ? "from afar" : "transport",
           it->is_textured ? it->result.texture.far_jod[0] : it->transport.jod, shown(it->argument),
           shown(it->written[0] ? it->written : it->result.match.fit.spec));
    if (it->result.dropped[0])
        printf("  dropped: %s", it->result.dropped);
    if (has_gate(&t->gate))
        printf("  %s", gate_mark(&t->gate, &it->score));
    putchar('\n');
    fflush(stdout);
}

static json_t *item_json(const translation *t, const item *it) {
    if (it->err.status != NQM_OK)
        return json_row("input:s spec:o error:s", it->argument, json_null(), it->err.message);
    return json_row("input:s output:t spec:s jod:f jod_low:f jod_high:f transport_jod:f dropped:s selected:s seconds:f "
                    "far_jod:o pass:o",
                    it->argument, it->written, it->result.match.fit.spec, it->score.jod, it->score.jod_low,
                    it->score.jod_high, it->transport.jod, it->result.dropped, it->result.match.selected, it->seconds,
                    it->is_textured ? json_number(it->result.texture.far_jod[0]) : NULL,
                    has_gate(&t->gate) ? json_boolean(!fails_gate(&t->gate, &it->score)) : NULL);
}

/* How many translated materials have lost each property. */
static json_t *count_dropped(const translation *t) {
    json_t *counts = json_object();
    for (size_t i = 0; i < t->n; ++i) {
        const item *it = &t->items[i];
        for (const char *key = it->result.dropped; it->err.status == NQM_OK && *key;) {
            const size_t n = strcspn(key, ",");
            char name[64];
            snprintf(name, sizeof name, "%.*s", (int)n, key);
            json_object_set_new(counts, name, json_integer(1 + json_integer_value(json_object_get(counts, name))));
            key += n + strspn(key + n, ", ");
        }
    }
    return counts;
}

static void print_as_json(const translation *t) {
    json_t *results = json_array();
    for (size_t i = 0; i < t->n; ++i)
        json_array_append_new(results, item_json(t, &t->items[i]));
    print_document(json_row("model:s results:o failed:z refused:z dropped:o", t->target.name, results, count_failed(t),
                            count_refused(t), count_dropped(t)));
}

/* "dropped: coat_weight in 2 materials, sheen_color in 1" */
static void print_dropped(const translation *t, FILE *out) {
    json_t *counts = count_dropped(t), *value;
    const char *key, *separator = "dropped: ", *unit = NULL;
    json_object_foreach(counts, key, value) {
        const json_int_t n = json_integer_value(value);
        fprintf(out, "%s%s in %lld%s", separator, key, (long long)n, unit ? "" : n == 1 ? " material" : " materials");
        separator = ", ";
        unit = "";
    }
    fputs(unit ? "\n" : "", out);
    json_decref(counts);
}

/* "3 materials, 1 FAIL: JOD below 9, 1 refused" */
static void print_summary(const translation *t, FILE *out) {
    char words[GATE_TEXT];
    if (t->n > 1)
        print_dropped(t, out);
    fprintf(out, "%zu material%s", t->n, t->n == 1 ? "" : "s");
    if (has_gate(&t->gate))
        fprintf(out, ", %zu failed (%s)", count_failed(t), gate_words(&t->gate, words));
    fprintf(out, ", %zu refused\n", count_refused(t));
}

/* The source, its keys copied, and its translation. */
static void write_page(const translation *t, const char *metric, output_file *out) {
    const item *it = t->items;
    char title[300], name[NAME_SIZE];
    page_item items[3] = {{it->argument, ""}, {it->result.copied, "keys copied"}};
    const int n = *it->result.copied ? 2 : 1;
    items[n].argument = it->written[0] ? it->written : it->result.match.fit.spec;
    snprintf(items[n].name, NAME_SIZE, "%s, translated", t->target.name);
    short_name(it->argument, name, sizeof name);
    snprintf(title, sizeof title, "Translation of %s to %s", name, t->target.name);
    write_fit_page(title, n + 1, items, metric, out);
}

/* ---- one translation ---------------------------------------------------------------------------------------------- */

static nqm_status fit_item(const translation *t, item *it, nqm_error *err) {
    nqm_brdf *ref = NULL;
    nqm_status status = nqm_argument_open(it->source, &ref, err);
    if (status != NQM_OK)
        return status;
    report_remark(ref);
    status = nqm_translate(ref, t->target.name, NULL, NULL, &t->loss, &t->fit, &it->result, err);
    nqm_brdf_free(ref);
    return status;
}

/* The name in a file of its own: "paints_red"; in one of all materials: "red". */
static void name_in_file(const translation *t, const item *it, char *name, size_t n_name) {
    const char *material = it->source->member;
    if (t->n > 1 && t->path && material)
        snprintf(name, n_name, "%s", material);
    else
        short_stem(it->argument, name, n_name);
}

/* Fit, write and score a material with image maps. */
static nqm_status translate_maps(const translation *t, item *it, nqm_error *err) {
    char name[64];
    nqm_texture *ref = NULL;
    if (t->path && t->n > 1)
        return nqm_fail(err, NQM_ERR_ARG, -1, "a material with image maps needs a file of its own: -d FOLDER");
    if (strcmp(t->target.name, "gltf") != 0 || !nqm_name_ends_in(it->path, ".gltf"))
        return nqm_fail(err, NQM_ERR_ARG, -1,
                        "a material with image maps is written as glTF with PNG files beside it only: "
                        "--to gltf, with -o FILE.gltf or -d FOLDER");
    name_in_file(t, it, name, sizeof name);
    nqm_status status = open_texture(it->source, &ref, err);
    if (status == NQM_OK)
        status = nqm_translate_texture(ref, it->path, name, &t->loss, &t->fit, &it->result, err);
    nqm_texture_free(ref);
    if (status != NQM_OK)
        return status;
    it->score = nqm_library_texture_result(&it->result.texture);
    it->transport = (nqm_score_result){.jod = NAN};
    snprintf(it->written, sizeof it->written, "%s", it->path);
    return NQM_OK;
}

/* What was written, or the spec. */
static nqm_status score_item(const translation *t, item *it, nqm_error *err) {
    nqm_brdf *ref = NULL, *brdf = NULL;
    nqm_status status = nqm_argument_open(it->source, &ref, err);
    if (status == NQM_OK)
        status = nqm_brdf_open(it->written[0] ? it->written : it->result.match.fit.spec, &brdf, err);
    const nqm_brdf *test = brdf;
    if (status == NQM_OK)
        status = nqm_scorer_run(t->scorer, ref, 1, &test, &it->score, err);
    if (status == NQM_OK)
        status = nqm_scorer_run(t->transport, ref, 1, &test, &it->transport, err);
    nqm_brdf_free(ref);
    nqm_brdf_free(brdf);
    return status;
}

/* Write n items that are fitted into the file of the first; a file of several is opened by the names that they got. */
static nqm_status write_items(const translation *t, size_t n, item *const *items, nqm_error *err) {
    char(*name)[64] = allocate(n, sizeof *name);
    const char **specs = allocate(2 * n, sizeof *specs), **names = specs + n, *path = items[0]->path;
    nqm_materials *written = NULL;
    for (size_t i = 0; i < n; ++i) {
        name_in_file(t, items[i], name[i], sizeof name[i]);
        specs[i] = items[i]->result.match.fit.spec;
        names[i] = name[i];
    }
    nqm_status status = nqm_brdf_write_materials(n, specs, names, path, err);
    if (status == NQM_OK && n > 1)
        status = nqm_materials_open(path, &written, err);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        const int used = snprintf(items[i]->written, MAX_TEXT, "%s%s%s", path, written ? ":" : "",
                                  written ? nqm_materials_get(written, i).name : "");
        if (used < 0 || used >= MAX_TEXT)
            status = nqm_fail(err, NQM_ERR_ARG, -1, "%.80s...: the path of the output is too long", path);
    }
    nqm_materials_free(written);
    free(specs);
    free(name);
    return status;
}

/* Refusals are stored and do not stop the others. */
static void take_failure(const translation *t, item *it, const nqm_error *err) {
    if (err->status == NQM_ERR_CANCELLED || t->n == 1)
        stop_error(err);
    it->err = *err;
}

static void finish_item(const translation *t, item *it, bool with_rows) {
    nqm_error err = {0};
    if (it->err.status == NQM_OK && !it->is_textured && score_item(t, it, &err) != NQM_OK)
        take_failure(t, it, &err);
    end_progress();
    if (with_rows)
        print_item(t, it);
}

/* Into one file when all of them are fitted. */
static void write_all(const translation *t) {
    nqm_error err = {0};
    size_t n = 0;
    item **fitted = allocate(t->n, sizeof(item *));
    for (size_t i = 0; i < t->n; ++i)
        if (t->items[i].err.status == NQM_OK)
            fitted[n++] = &t->items[i];
    if (n && write_items(t, n, fitted, &err) != NQM_OK)
        stop_error(&err);
    free(fitted);
}

static void translate_all(translation *t, bool with_rows) {
    const bool in_one = t->path && t->n > 1;
    for (size_t i = 0; i < t->n; ++i) {
        item *it = &t->items[i];
        nqm_error err = {0};
        note_progress("%s (%zu of %zu)", shown(it->argument), i + 1, t->n);
        it->is_textured = nqm_argument_is_textured(it->source);
        const double begin = nqm_clock_s();
        nqm_status status = it->is_textured ? translate_maps(t, it, &err) : fit_item(t, it, &err);
        it->seconds = nqm_clock_s() - begin;
        if (status == NQM_OK && !it->is_textured && it->path[0] && !in_one)
            status = write_items(t, 1, &it, &err);
        if (status != NQM_OK)
            take_failure(t, it, &err);
        if (!in_one)
            finish_item(t, it, with_rows);
    }
    if (!in_one)
        return;
    write_all(t);
    for (size_t i = 0; i < t->n; ++i)
        finish_item(t, &t->items[i], with_rows);
}

/* ---- the verb ----------------------------------------------------------------------------------------------------- */

static translation t;
static const char *to, *loss = "auto", *metric = "default", *transport = "transport", *page;
static uint64_t samples = 2000;
static bool json;

static const option options[] = {
    {"to", 't', OPTION_NEEDED, &to, "MODEL", "the shading model", 0, 0},
    {"output", 'o', OPTION_TEXT, &t.path, "FILE",
     "the file to write, with all materials; its extension selects the format: .mtlx .gltf .glb .xml .json .pbrt", 0,
     0},
    {"folder", 'd', OPTION_TEXT, &t.folder, "FOLDER", "write a file for each material, named as the input", 0, 0},
    {"loss", 0, OPTION_TEXT, &loss, "SUM|auto", "as in nqm fit", 0, 0},
    {"metric", 'm', OPTION_TEXT, &metric, "MODEL", "the model of the JOD and of the loss nqm", 0, 0},
    {"transport", 0, OPTION_TEXT, &transport, "MODEL", "the model of the loss transport", 0, 0},
    {"samples", 0, OPTION_COUNT, &samples, "N", "direction pairs of the fit", 200, 1000000},
    {"simplify", 0, OPTION_NUMBER, &t.fit.simplify, "X", "fraction of the loss for which keys get their defaults", 0,
     1},
    {"report", 0, OPTION_TEXT, &page, "FILE.html", "write a page with pictures, of one material", 0, 0},
    OPTION_ROWS_GATE(&t.gate),
    {"json", 0, OPTION_FLAG, &json, NULL, "print the result as JSON", 0, 0},
    OPTION_ROW_IGNORE,
    {0}};

static option_words target_words[] = {{"to", NULL}, {0}};

static const command cmd = {
    .usage = "BRDF... --to MODEL [-o FILE|-d FOLDER] [options]",
    .about = "Write materials, or any BRDFs, as materials of another renderer: fit the shading model MODEL, write the"
             " file, read it back and score what was written. Without -o and -d the spec of the result is printed. A "
             "file with several materials, or a folder of files, is translated material by material. Materials that "
             "cannot be read are "
             "reported and do not stop the others.",
    .example = "nqm translate 'open-pbr:base_color=.8,.3,.1;coat_weight=1' --to gltf\n"
               "nqm translate gold.mtlx --to gltf -o gold.gltf --report gold.html\n"
               "nqm translate materials/*.mtlx --to gltf -o all.gltf\n"
               "nqm translate materials/*.mtlx --to gltf -d gltf --fail-under 9",
    .options = options,
    .words = target_words,
    .min_arguments = 1,
    .max_arguments = -1,
};

/* The models and their other names, after which NULL. */
static const char *const *target_names(void) {
    enum { MOST = 64 };
    static const char *names[MOST + 1];
    nqm_translate_model m;
    for (size_t i = 0, n = 0; (m = nqm_translate_target(i)).name && n + 2 < MOST; ++i) {
        names[n++] = m.name;
        if (m.alias)
            names[n++] = m.alias;
    }
    return names;
}

static nqm_translate_model find_target(const char *word) {
    const char *name = target_names()[choose("to", target_names(), word)];
    size_t i = 0;
    nqm_translate_model m = nqm_translate_target(0);
    while (strcmp(m.name, name) != 0 && !(m.alias && strcmp(m.alias, name) == 0))
        m = nqm_translate_target(++i);
    return m;
}

int cmd_translate(int argc, char **argv) {
    t = (translation){.fit = nqm_fit_options_default()};
    target_words[0].words = target_names();
    const int n_arguments = parse_arguments(&cmd, argc, argv);
    t.target = find_target(to);
    t.fit.progress = show_progress;
    t.fit.n_directions = samples;
    nqm_scene *judge = open_judge(loss, transport);
    for (int i = 0; i < n_arguments; ++i)
        add_argument(&t, argv[i]);
    if (page && t.n != 1)
        stop(EXIT_USAGE, "--report shows one material, not %zu", t.n);
    nqm_model *metric_model = open_model(metric), *transport_model = open_model(transport);
    check_gate(&t.gate, metric_model);
    name_outputs(&t);
    output_file page_file = {0};
    if (page)
        open_page("--report", page, &page_file);
    t.loss = (nqm_match_loss){loss, metric_model, transport_model, judge};
    const nqm_score_options options_of_scores = plain_score_options();
    t.scorer = open_scorer(metric_model, &options_of_scores);
    t.transport = open_scorer(transport_model, &options_of_scores);
    translate_all(&t, !json);
    if (json)
        print_as_json(&t);
    else
        print_summary(&t, stdout);
    if (page)
        write_page(&t, metric, &page_file);
    const size_t n_refused = count_refused(&t), n_failed = count_failed(&t);
    nqm_scorer_free(t.scorer);
    nqm_scorer_free(t.transport);
    nqm_model_free(metric_model);
    nqm_model_free(transport_model);
    nqm_scene_free(judge);
    for (size_t i = 0; i < t.n; ++i)
        nqm_argument_free(t.items[i].source);
    nqm_free(t.items);
    return n_refused ? EXIT_PARTIAL : n_failed ? EXIT_GATE : EXIT_OK;
}
