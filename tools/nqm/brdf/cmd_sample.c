/* SPDX-License-Identifier: MIT
 *
 * nqm sample - prints or saves f_r of a BRDF at a list of directions.
 */
#include "metric/metric.h"
#include "nqm/tool.h"

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

static int print_samples_csv(const sample_set *s) {
    const double *degrees = nqm_directions_degrees(s->directions);
    puts("theta_h,theta_d,phi_d,r,g,b");
    for (size_t i = 0; i < s->report.n; ++i) {
        printf("%.9g,%.9g,%.9g", degrees[3 * i], degrees[3 * i + 1], degrees[3 * i + 2]);
        for (size_t k = 0; k < 3; ++k) {
            putchar(',');
            print_csv_number(stdout, value_of(s, i, k));
        }
        putchar('\n');
    }
    return fflush(stdout) == 0 ? EXIT_OK : report("sample", EXIT_OPEN, "standard output: cannot write");
}

static int print_samples_json(const sample_set *s) {
    const double *degrees = nqm_directions_degrees(s->directions);
    json_t *samples = json_array();
    for (size_t i = 0; i < s->report.n; ++i)
        json_array_append_new(samples, json_pack("{s:f,s:f,s:f,s:o,s:o,s:o}", "theta_h", degrees[3 * i], "theta_d",
                                                 degrees[3 * i + 1], "phi_d", degrees[3 * i + 2], "r",
                                                 json_number(value_of(s, i, 0)), "g", json_number(value_of(s, i, 1)),
                                                 "b", json_number(value_of(s, i, 2))));
    return print_json(json_pack("{s:i,s:o,s:o,s:{s:s,s:I},s:I,s:I,s:o}", "schema", 1, "tool", json_tool(), "brdf",
                                json_name(s->brdf), "directions", "id", nqm_directions_id(s->directions), "n",
                                (json_int_t)s->report.n, "clamped", (json_int_t)s->report.n_clamped, "invalid",
                                (json_int_t)s->report.n_invalid, "samples", samples));
}

/* Write a MAT file. The authors' files have a value at every direction, so missing values are an error. */
static int write_samples(const sample_set *s) {
    nqm_error err = {0};
    if (s->policy == NQM_INVALID_DROP && s->report.n_invalid)
        return report(
            "sample", EXIT_INCOMPATIBLE,
            "%s: no value at %zu of %zu directions, but a MAT file needs one at each: --invalid zero or nearest",
            s->brdf, s->report.n_invalid, s->report.n);
    nqm_status status = nqm_samples_save_mat(s->directions, s->rgb, output_path(s->output), &err);
    return status == NQM_OK ? EXIT_OK : report_error("sample", &err);
}

static void report_holes(const sample_set *s) {
    if (s->report.n_clamped)
        fprintf(stderr, "nqm sample: %s: negative channel at %zu of %zu directions, taken as 0\n", s->brdf,
                s->report.n_clamped, s->report.n);
    if (s->report.n_invalid)
        fprintf(stderr, "nqm sample: %s: no value at %zu of %zu directions\n", s->brdf, s->report.n_invalid,
                s->report.n);
}

static int sample_and_print(sample_set *s, const nqm_brdf *brdf, bool json) {
    size_t n = nqm_directions_count(s->directions);
    s->rgb = malloc(3 * n * sizeof *s->rgb);
    s->flag = malloc(n);
    int exit_code;
    nqm_error err = {0};
    if (!s->rgb || !s->flag)
        exit_code = report("sample", EXIT_LIMIT, "out of memory");
    else if (nqm_sample(brdf, s->directions, s->policy, s->rgb, s->flag, &s->report, &err) != NQM_OK)
        exit_code = report_error("sample", &err);
    else {
        exit_code = s->output ? write_samples(s) : json ? print_samples_json(s) : print_samples_csv(s);
        report_holes(s);
    }
    free(s->rgb);
    free(s->flag);
    return exit_code;
}

int cmd_sample(int argc, char **argv) {
    bool json = false, csv = false;
    const char *directions_name = NULL, *policy_name = "drop", *output = NULL;
    const option options[] = {
        {"directions", 'd', OPTION_TEXT, &directions_name, "WHERE",
         "a CSV of directions, a model file, or the name of a built-in model; default: the default model's", 0, 0},
        {"invalid", 0, OPTION_TEXT, &policy_name, "POLICY",
         "where the BRDF has no value: drop (empty fields), zero, nearest, error", 0, 0},
        {"output", 'o', OPTION_TEXT, &output, "FILE.mat",
         "write a MAT v5 file in the authors' layout instead: r, g, b, random_locations", 0, 0},
        {"csv", 0, OPTION_FLAG, &csv, NULL, "print CSV (this is the default)", 0, 0},
        {"json", 0, OPTION_FLAG, &json, NULL, "print JSON", 0, 0},
        {0}};
    const command cmd = {
        .name = "sample",
        .usage = "BRDF [options]",
        .about = "Print f_r of a BRDF at a list of directions, one row a direction, in their order: theta_h, theta_d,\n"
                 "phi_d in degrees; r, g, b in 1/sr without the cosine, linear with BT.709 primaries.",
        .example = "nqm sample sgd:nickel --csv\nnqm sample nickel.binary --directions my-directions.csv --json\n"
                   "nqm sample sgd:nickel -o ref/nickel.mat",
        .options = options,
        .min_arguments = 1,
        .max_arguments = 1,
    };
    int n_arguments, exit_code;
    if (!parse_arguments(&cmd, argc, argv, &n_arguments, &exit_code))
        return exit_code;
    sample_set s = {.brdf = argv[0], .output = output};
    nqm_score_options score = {0};
    exit_code = set_option("sample", &nqm_score_option_table, "invalid", &score, policy_name);
    if (exit_code != EXIT_OK)
        return exit_code;
    s.policy = score.invalid;
    if (csv + json + (output != NULL) > 1)
        return report("sample", EXIT_USAGE, "--csv, --json and --output exclude each other");
    nqm_error err = {0};
    nqm_brdf *brdf;
    if (nqm_brdf_open(argv[0], &brdf, &err) != NQM_OK)
        return report_error("sample", &err);
    nqm_directions *directions;
    exit_code = open_directions("sample", directions_name, &directions);
    if (exit_code == EXIT_OK) {
        s.directions = directions;
        exit_code = sample_and_print(&s, brdf, json);
    }
    nqm_directions_free(directions);
    nqm_brdf_free(brdf);
    return exit_code;
}
