/* SPDX-License-Identifier: MIT
 *
 * The public entry of fitting, the table of fit options, and the fit of an analytic model.
 */
#include "fit/shading.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

enum { MAX_TERMS = 8 };

/* ---- options ----------------------------------------------------------------------------------------------------- */

#define FIELD(name) .key = #name, .offset = offsetof(nqm_fit_options, name)

/* clang-format off */
static const nqm_option rows[] = {
    {FIELD(loss), .name = "", .kind = NQM_OPTION_ENUM, .metavar = "NAME", .words = nqm_fit_loss_words, .values = {"log"},
     .help = ""},
    {FIELD(n_directions), .name = "samples", .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 200, .max = 1000000,
     .values = {"6000"}, .help = "direction pairs of the fit"},
    {FIELD(max_polar_rad), .name = "max-polar", .metavar = "DEG", .min = 0.1, .max = 89.9,
     .scale = NQM_PI / 180, .values = {"80"}, .help = "largest polar angle of the fit"},
    {FIELD(highlight_fraction), .name = "", .min = 0, .max = 1, .values = {"0.05"}},
    {FIELD(n_starts), .name = "starts", .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 1, .max = 100, .values = {"12"},
     .help = "lobe widths to start from (analytic models)"},
    {FIELD(seed), .kind = NQM_OPTION_U64, .metavar = "N", .values = {"1"}, .help = "seed of the direction pairs"},
    {FIELD(n_random), .name = "random-starts", .kind = NQM_OPTION_SIZE, .metavar = "N", .min = 0, .max = 1000,
     .values = {"0"}, .help = "start from this many random values instead (analytic models)"},
    {FIELD(start_seed), .name = "start-seed", .kind = NQM_OPTION_U64, .metavar = "N", .values = {"1"},
     .help = "seed of the random starts"},
    {FIELD(simplify), .name = "simplify", .metavar = "X", .min = 0, .max = 1, .values = {"0.01"},
     .help = "fraction of the loss for which keys get their defaults (shading models)"},
    {FIELD(immediate), .kind = NQM_OPTION_BOOL, .off_name = "", .values = {"0"},
     .help = "random starts minimise the whole loss from the first step"},
};
/* clang-format on */

const nqm_option_table nqm_fit_option_table = {rows, sizeof rows / sizeof *rows, NULL};

nqm_fit_options nqm_fit_options_default(void) {
    nqm_fit_options options = {0};
    (void)!nqm_options_begin(&nqm_fit_option_table, NULL, &options, NULL); /* cannot fail without a recipe */
    return options;
}

/* ---- analytic models --------------------------------------------------------------------------------------------- */

/* Six significant digits: more than the data determine, and the spec stays readable. */
static void round_values(const nqm_fit_entry *model, nqm_fit_values *values) {
    const int n_digits = 6;
    for (size_t s = 0; s < model->n_shape; ++s)
        values->shape[s] = model->shape[s].scale == NQM_FIT_SCALE_LOG_REST
                               ? 1 - nqm_round_digits(1 - values->shape[s], n_digits)
                               : nqm_round_digits(values->shape[s], n_digits);
    for (size_t c = 0; c < 3; ++c) {
        values->kd[c] = nqm_round_digits(values->kd[c], n_digits);
        values->ks[c] = nqm_round_digits(values->ks[c], n_digits);
    }
}

void nqm_fit_write_spec(const nqm_fit_entry *model, const nqm_fit_values *v, char spec[512]) {
    char kd[3][32], ks[3][32], value[32];
    for (size_t c = 0; c < 3; ++c) {
        nqm_format_double(kd[c], sizeof kd[c], v->kd[c]);
        nqm_format_double(ks[c], sizeof ks[c], v->ks[c]);
    }
    int used = snprintf(spec, 512, "%s:kd=%s,%s,%s;ks=%s,%s,%s", model->name, kd[0], kd[1], kd[2], ks[0], ks[1], ks[2]);
    for (size_t s = 0; s < model->n_shape; ++s)
        used += snprintf(spec + used, 512 - (size_t)used, ";%s=%s", model->shape[s].key,
                         nqm_format_double(value, sizeof value, v->shape[s]));
}

static nqm_status check_terms(const nqm_fit_options *options, nqm_error *err) {
    if (options->n_terms > MAX_TERMS)
        return nqm_fail(err, NQM_ERR_ARG, -1, "a loss has at most %d terms", MAX_TERMS);
    for (size_t i = 0; i < options->n_terms; ++i) {
        const nqm_fit_term *term = &options->terms[i];
        if (!(term->weight > 0 && isfinite(term->weight)))
            return nqm_fail(err, NQM_ERR_ARG, -1, "the weight of a loss must be positive, not %g", term->weight);
        if (!term->visual && (unsigned)term->loss >= NQM_FIT_N_LOSSES)
            return nqm_fail(err, NQM_ERR_ARG, -1, "there is no loss %d", (int)term->loss);
        if (term->visual && (term->visual->n == 0 || !term->visual->eval))
            return nqm_fail(err, NQM_ERR_ARG, -1, "a visual loss needs directions and a function");
    }
    return NQM_OK;
}

/* The loss of the rounded result. */
static nqm_status measure(const nqm_fit_entry *model, const nqm_fit_target *target, const nqm_fit_options *options,
                          const nqm_fit_values *values, double *loss, nqm_error *err) {
    nqm_fit_term only = {.weight = 1, .loss = options->loss};
    nqm_fit_objective objective;
    nqm_status status = nqm_fit_objective_make(model, target, options->n_terms ? options->n_terms : 1,
                                               options->n_terms ? options->terms : &only, &objective, err);
    if (status == NQM_OK)
        status = nqm_fit_objective_eval(&objective, true, values, loss, NULL, err);
    nqm_fit_objective_free(&objective);
    return status;
}

static nqm_status fit_analytic(const nqm_brdf *ref, const nqm_fit_entry *entry, const nqm_fit_options *options,
                               nqm_fit_report *report, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_fit_entry model = *entry;
    nqm_fit_target target = {0};
    nqm_fit_candidate found;
    nqm_fit_options first = *options;
    nqm_status status = nqm_fit_apply_bounds(options, &model, err);
    first.loss = nqm_fit_first_loss(options);
    if (status == NQM_OK)
        status = nqm_fit_target_make(ref, &first, &target, err);
    if (status == NQM_OK)
        status = nqm_fit_minimise(&model, &target, options, &found, err);
    if (status == NQM_OK) {
        round_values(&model, &found.values);
        nqm_fit_write_spec(&model, &found.values, report->spec);
        report->n_directions = target.n;
        report->best_start = found.start;
        report->n_numbers = 6 + model.n_shape;
        status = measure(&model, &target, options, &found.values, &report->loss, err);
    }
    if (status == NQM_OK)
        status = nqm_brdf_open(report->spec, brdf_ret, err);
    nqm_free(target.wi);
    return status;
}

nqm_status nqm_fit_path(const nqm_brdf *ref, const char *model, const nqm_fit_options *options, uint64_t seed,
                        size_t n_steps, char spec[512], nqm_error *err) {
    const nqm_fit_entry *entry;
    nqm_fit_target target = {0};
    nqm_fit_values values;
    nqm_status status = nqm_fit_entry_find(model, &entry, err);
    if (status == NQM_OK && (entry->encode || entry->shading))
        status = nqm_fail(err, NQM_ERR_ARG, -1, "%s is not an analytic model", model);
    if (status == NQM_OK)
        status = nqm_fit_target_make(ref, options, &target, err);
    if (status == NQM_OK)
        status = nqm_fit_follow(entry, &target, seed, n_steps, &values, err);
    if (status == NQM_OK) {
        round_values(entry, &values);
        nqm_fit_write_spec(entry, &values, spec);
    }
    nqm_free(target.wi);
    return status;
}

static nqm_status encode(const nqm_brdf *ref, const nqm_fit_entry *entry, const nqm_fit_options *options,
                         nqm_fit_report *report, nqm_brdf **brdf_ret, nqm_error *err) {
    const nqm_encode_options asked = {.n_directions = options->n_directions,
                                      .seed = options->seed,
                                      .n = entry->n_code,
                                      .step = entry->step,
                                      .name = entry->name,
                                      .progress = options->progress,
                                      .progress_user = options->progress_user};
    nqm_encode_report found = {0};
    nqm_status status = entry->encode(ref, &asked, &found, brdf_ret, err);
    report->loss = found.loss;
    report->n_directions = found.n_directions;
    report->best_start = found.best_start;
    report->n_numbers = found.n_numbers;
    return status;
}

/* ---- public entry ------------------------------------------------------------------------------------------------ */

nqm_status nqm_fit(const nqm_brdf *ref, const char *model, const nqm_fit_options *options_or_null,
                   nqm_fit_report *report_ret, nqm_brdf **brdf_ret, nqm_error *err) {
    if (brdf_ret)
        *brdf_ret = NULL;
    NQM_REQUIRE(err, ref, model, report_ret);
    const nqm_fit_options options = options_or_null ? *options_or_null : nqm_fit_options_default();
    nqm_fit_report report = {0};
    nqm_brdf *brdf = NULL;
    const nqm_fit_entry *entry;
    nqm_status status = nqm_fit_entry_find(model, &entry, err);
    if (status == NQM_OK)
        status = nqm_options_check(&nqm_fit_option_table, &options, err);
    if (status == NQM_OK && !entry->encode)
        status = check_terms(&options, err);
    if (status == NQM_OK && entry->encode)
        status = encode(ref, entry, &options, &report, &brdf, err);
    else if (status == NQM_OK)
        status = (entry->shading ? nqm_fit_shading_model : fit_analytic)(ref, entry, &options, &report, &brdf, err);
    if (status != NQM_OK)
        return status;
    *report_ret = report;
    if (brdf_ret)
        *brdf_ret = brdf;
    else
        nqm_brdf_free(brdf);
    return NQM_OK;
}
