/* SPDX-License-Identifier: MIT
 *
 * nqm agree - our labels beside somebody else's for the same pairs.
 */
#include "nqm/label/scene_args.h"

static json_t *row_json(const nqm_compare_row *r) {
    return json_pack("{s:o,s:I,s:o,s:[oo],s:o,s:o,s:o,s:o}", "encoding", json_name(r->encoding), "n", (json_int_t)r->n,
                     "spearman", json_number(r->spearman), "ci95", json_number(r->spearman_ci95[0]),
                     json_number(r->spearman_ci95[1]), "null_luminance", json_number(r->null_luminance),
                     "median_theirs", json_number(r->median_theirs), "median_ours", json_number(r->median_ours),
                     "median_ratio", json_number(r->median_ratio));
}

static int print_agreement_json(const nqm_comparison *c) {
    json_t *rows = json_array(), *root = json_pack("{s:i,s:o}", "schema", 1, "tool", json_tool());
    for (size_t i = 0; i < c->n_encodings; ++i)
        json_array_append_new(rows, row_json(&c->rows[i]));
    json_object_set_new(root, "results", rows);
    json_object_set_new(root, "pooled", row_json(&c->pooled));
    json_object_set_new(root, "pooled_null_encoding", json_number(c->pooled_null_encoding));
    json_object_set_new(root, "order",
                        json_pack("{s:I,s:I,s:I}", "references", (json_int_t)c->n_triples, "ours",
                                  (json_int_t)c->n_ordered, "theirs", (json_int_t)c->n_ordered_theirs));
    return print_json(root);
}

static void print_row(const nqm_compare_row *r) {
    printf("| %s | %zu | %.2f [%.2f, %.2f] | %.2f | %.1f | %.1f | %.2f |\n", r->encoding, r->n, r->spearman,
           r->spearman_ci95[0], r->spearman_ci95[1], r->null_luminance, r->median_theirs, r->median_ours,
           r->median_ratio);
}

static void print_agreement_text(const nqm_comparison *c) {
    printf(
        "| encoding | n | Spearman of ours with theirs [95 %%] | of the reference's luminance | median of theirs | of "
        "ours | median ratio |\n|---|---|---|---|---|---|---|\n");
    for (size_t i = 0; i < c->n_encodings; ++i)
        print_row(&c->rows[i]);
    print_row(&c->pooled);
    printf("\nOver all pairs, the encoding's name alone reaches %.2f.\n", c->pooled_null_encoding);
    if (c->n_triples)
        printf("nbrdf below both ward and ggx: %zu of %zu references (theirs: %zu).\n", c->n_ordered, c->n_triples,
               c->n_ordered_theirs);
}

static int agree(const char *pairs_csv, const char *root, const nqm_scene_options *options, const nqm_fit_options *fit,
                 bool json) {
    nqm_error err = {0};
    nqm_scene *scene;
    nqm_comparison comparison;
    nqm_status status = nqm_scene_create(options, &scene, &err);
    if (status == NQM_OK)
        status = nqm_compare_labels(pairs_csv, root, scene, fit, show_progress, NULL, &comparison, &err);
    end_progress();
    nqm_scene_free(scene);
    if (status != NQM_OK)
        return report_error("agree", &err);
    if (json)
        return print_agreement_json(&comparison);
    print_agreement_text(&comparison);
    return EXIT_OK;
}

int cmd_agree(int argc, char **argv) {
    bool json = false;
    const char *root = NULL, *loss = "log";
    scene_args scene = scene_args_begin();
    nqm_fit_options fit = nqm_fit_options_default();
    scene.n_points = scene.scene.n_points; /* points, not a picture: quick */
    option options[3 + N_SCENE_OPTIONS + 1] = {
        {"root", 0, OPTION_TEXT, &root, "DIR", "folder at which relative paths of PAIRS.csv start", 0, 0},
        {"loss", 0, OPTION_TEXT, &loss, "NAME", "of own fits: log, log-cos, cube-root, linear", 0, 0},
        {"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0}};
    scene_args_table(&scene, options);
    const command cmd = {
        .name = "agree",
        .usage = "PAIRS.csv [options]",
        .about = "Label pairs that somebody else has labelled, and compare: the rank correlation of our Delta-E with\n"
                 "theirs over references, for each encoding, beside what the reference's mean luminance and the\n"
                 "encoding's name reach by themselves. PAIRS.csv has the columns reference, test, encoding, delta_e;\n"
                 "a test `fit` is our own fit of the model that the encoding names.",
        .example = "nqm agree pairs.csv --root data --shape bunny.ply --light probe.exr",
        .options = options,
        .min_arguments = 1,
        .max_arguments = 1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    if (!nqm_fit_loss_parse(loss, &fit.loss))
        return report("agree", EXIT_USAGE, "--loss: '%s' is none of log, log-cos, cube-root, linear", loss);
    exit_code = scene_args_end("agree", &scene);
    return exit_code == EXIT_OK ? agree(argv[0], root, &scene.scene, &fit, json) : exit_code;
}
