/* SPDX-License-Identifier: MIT
 *
 * nqm sample - prints or saves f_r of a BRDF at a list of directions.
 */
#include "metric/metric.h"
#include "nqm/tool.h"
#include "sample/sample.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Samples of a BRDF and their directions. */
typedef struct sample_set {
    const char *brdf;
    const nqm_directions *directions;
    nqm_invalid_policy policy;
    const char *output; /* a MAT file; NULL: print */
    float *rgb;         /* (n, 3) */
    uint8_t *flag;      /* (n) */
    nqm_sample_report report;
} sample_set;

/* NaN where the BRDF has no value and the policy does not fill it. */
static double value_of(const sample_set *s, size_t i, size_t channel) {
    bool hole = !nqm_has_value(s->flag[i]);
    return hole && s->policy == NQM_INVALID_DROP ? (double)NAN : (double)s->rgb[3 * i + channel];
}

static void print_samples_csv(const sample_set *s) {
    const double *degrees = nqm_directions_get_info(s->directions).degrees;
    puts("theta_h,theta_d,phi_d,r,g,b");
    for (size_t i = 0; i < s->report.n; ++i, degrees += 3) {
        printf("%.9g,%.9g,%.9g", degrees[0], degrees[1], degrees[2]);
        print_csv_numbers(stdout, 3, (double[]){value_of(s, i, 0), value_of(s, i, 1), value_of(s, i, 2)});
        putchar('\n');
    }
}

static void print_samples_json(const sample_set *s) {
    const double *degrees = nqm_directions_get_info(s->directions).degrees;
    json_t *samples = json_array();
    for (size_t i = 0; i < s->report.n; ++i, degrees += 3)
        json_array_append_new(samples, json_row("theta_h:f theta_d:f phi_d:f r:f g:f b:f", degrees[0], degrees[1],
                                                degrees[2], value_of(s, i, 0), value_of(s, i, 1), value_of(s, i, 2)));
    print_document(json_row("brdf:s directions:{id:s n:z} clamped:z invalid:z samples:o", s->brdf,
                            nqm_directions_id(s->directions), s->report.n, s->report.n_clamped, s->report.n_invalid,
                            samples));
}

/* Write a MAT file. The authors' files have a value at every direction, so missing values are an error. */
static void write_samples(const sample_set *s) {
    if (s->policy == NQM_INVALID_DROP && s->report.n_invalid)
        stop(EXIT_INCOMPATIBLE,
             "%s: no value at %zu of %zu directions, but a MAT file needs one at each: --invalid zero or nearest",
             s->brdf, s->report.n_invalid, s->report.n);
    must(nqm_samples_save_mat(s->directions, s->rgb, output_path(s->output), &fault));
}

static void report_holes(const sample_set *s) {
    if (s->report.n_clamped)
        report(EXIT_OK, "%s: negative channel at %zu of %zu directions, taken as 0", s->brdf, s->report.n_clamped,
               s->report.n);
    if (s->report.n_invalid)
        report(EXIT_OK, "%s: no value at %zu of %zu directions", s->brdf, s->report.n_invalid, s->report.n);
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static result_format format;
static const char *directions_name, *policy_name = "drop", *output;

static const option options[] = {
    {"directions", 'd', OPTION_TEXT, &directions_name, "WHERE",
     "a CSV of directions, a model file, or the name of a built-in model; default: the default model's", 0, 0},
    {"invalid", 0, OPTION_TEXT, &policy_name, "POLICY",
     "where the BRDF has no value: drop (empty fields), zero, nearest, error", 0, 0},
    {"output", 'o', OPTION_TEXT, &output, "FILE.mat",
     "write a MAT v5 file in the authors' layout instead: r, g, b, random_locations", 0, 0},
    {"csv", 0, OPTION_FORMAT, &format, NULL, "print CSV (this is the default)", FORMAT_CSV, 0},
    {"json", 0, OPTION_FORMAT, &format, NULL, "print JSON", FORMAT_JSON, 0},
    OPTION_ROW_IGNORE,
    {0}};

static const command cmd = {
    .usage = "BRDF [options]",
    .about = "Print f_r of a BRDF at a list of directions, one row a direction, in their order: theta_h, theta_d, "
             "phi_d in degrees; r, g, b in 1/sr without the cosine, linear with BT.709 primaries.",
    .example = "nqm sample sgd:nickel --csv\nnqm sample nickel.binary --directions my-directions.csv --json\n"
               "nqm sample sgd:nickel -o ref/nickel.mat",
    .options = options,
    .min_arguments = 1,
};

int cmd_sample(int argc, char **argv) {
    parse_arguments(&cmd, argc, argv);
    nqm_score_options score = {0};
    set_option(&nqm_score_option_table, "invalid", &score, policy_name);
    if (output && format != FORMAT_TEXT)
        stop(EXIT_USAGE, "--csv, --json and --output exclude each other");
    nqm_brdf *brdf = open_brdf(argv[0]);
    report_remark(brdf);
    nqm_directions *directions = open_directions(directions_name);
    const size_t n = nqm_directions_get_info(directions).n;
    sample_set s = {.brdf = argv[0],
                    .directions = directions,
                    .policy = score.invalid,
                    .output = output,
                    .rgb = allocate(3 * n, sizeof *s.rgb),
                    .flag = allocate(n, 1)};
    must(nqm_sample(brdf, directions, s.policy, s.rgb, s.flag, &s.report, &fault));
    if (output)
        write_samples(&s);
    else
        (format == FORMAT_JSON ? print_samples_json : print_samples_csv)(&s);
    report_holes(&s);
    free(s.rgb);
    free(s.flag);
    nqm_directions_free(directions);
    nqm_brdf_free(brdf);
    return EXIT_OK;
}
