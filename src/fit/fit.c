/* SPDX-License-Identifier: MIT
 *
 * The public entry of fitting, the table of fit options, and the stages of a fit.
 */
#include "fit/fit.h"
#include "brdf/core/spec.h"
#include "math/math.h"

#include <math.h>

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
    {FIELD(simplify), .name = "simplify", .metavar = "X", .min = 0, .max = 1, .values = {"0.01"},
     .help = "fraction of the loss for which keys get their defaults (shading models)"},
};
/* clang-format on */

const nqm_option_table nqm_fit_option_table = {rows, sizeof rows / sizeof *rows, NULL};

NQM_OPTIONS_DEFAULT(nqm_fit_option, 0)

/* ---- models with a schema ----------------------------------------------------------------------------------------- */

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

/* The loss by whose squares a fit begins: that of the BRDF-space term with the largest weight. */
static nqm_fit_loss first_loss(const nqm_fit_options *options) {
    nqm_fit_loss loss = options->n_terms ? NQM_FIT_LOG : options->loss;
    double weight = 0;
    for (size_t i = 0; i < options->n_terms; ++i)
        if (!options->terms[i].visual && options->terms[i].weight > weight) {
            loss = options->terms[i].loss;
            weight = options->terms[i].weight;
        }
    return loss;
}

static bool has_visual(const nqm_fit_run *run) {
    bool has = false;
    for (size_t i = 0; i < run->n_terms; ++i)
        has |= run->terms[i].visual != NULL;
    return has;
}

/* Fit along the axes of the lobe, whose azimuth is measured. */
static void turn_model(nqm_fit_run *run) {
    const nqm_lobe lobe = nqm_lobe_measure(run->ref);
    run->is_turned = true;
    run->turn_deg = floor(atan2(lobe.axes[2], lobe.axes[0]) * (180 / NQM_PI) * 100 + 0.5) / 100;
    run->space.turn[0] = sin(-run->turn_deg * (NQM_PI / 180));
    run->space.turn[1] = cos(-run->turn_deg * (NQM_PI / 180));
}

/* Without a start, keys with two values are both free, and keys of anisotropy, which fits keep, have the values of the
 * lobe. A model that cannot turn its lobe is turned. */
static nqm_status make_space(nqm_fit_run *run, const nqm_fit_entry *entry) {
    nqm_fit_options options = *run->options;
    const nqm_schema *schema = entry->model->schema;
    const bool is_measured = !options.start, turns = nqm_fit_can_be_anisotropic(schema, true);
    char *lobe = is_measured ? nqm_fit_measure_anisotropy(run->ref, schema, !turns) : NULL;
    if (lobe)
        options.start = lobe;
    nqm_status status = nqm_fit_space_make(entry, &options, &run->space, run->err);
    if (status == NQM_OK && is_measured && nqm_brdf_anisotropy(run->ref) > 0 &&
        (nqm_fit_split(&run->space) || (lobe && !turns)))
        turn_model(run);
    nqm_free(lobe);
    return status;
}

nqm_status nqm_fit_begin(nqm_fit_run *run, const nqm_brdf *ref, const nqm_fit_entry *entry,
                         const nqm_fit_options *options, nqm_fit_loss loss, nqm_error *err) {
    *run = (nqm_fit_run){.ref = ref, .options = options, .err = err};
    run->ticker = (nqm_ticker){.fn = options->progress, .user = options->progress_user};
    run->only = (nqm_fit_term){.weight = 1, .loss = options->loss};
    run->n_terms = nqm_larger(options->n_terms, 1);
    run->terms = options->n_terms ? options->terms : &run->only;
    nqm_fit_options first = *options;
    first.loss = loss;
    nqm_status status = check_terms(options, err);
    if (status == NQM_OK)
        status = make_space(run, entry);
    if (status == NQM_OK)
        status = nqm_fit_target_make(run->ref, &first, &run->target, err);
    if (status == NQM_OK)
        status = nqm_fit_objective_make(&run->space, &run->target, run->n_terms, run->terms, &run->objective, err);
    return status;
}

void nqm_fit_end(nqm_fit_run *run) {
    nqm_fit_objective_free(run->objective);
    nqm_free(run->target.wi);
}

nqm_status nqm_fit_write_report(nqm_fit_run *run, nqm_fit_point *point, nqm_fit_report *report) {
    report->n_directions = run->target.n;
    report->best_start = point->start;
    report->n_numbers = run->space.n + run->is_turned;
    const int n =
        run->turn_deg != 0 ? snprintf(report->spec, sizeof report->spec, "rotate:deg=%g;of=", run->turn_deg) : 0;
    return nqm_fit_write_spec(&run->space, &point->values, report->spec + n, sizeof report->spec - (size_t)n, run->err);
}

/* From the given start: visual terms may have been minimised there, from which least squares would lead away. */
static nqm_status begin_at_start(nqm_fit_run *run, nqm_fit_point *point) {
    enum { STEPS = 50 };
    nqm_status status = nqm_fit_read_spec(&run->space, run->options->start, &point->values, run->err);
    if (status == NQM_OK && !has_visual(run))
        status = nqm_fit_refine(&run->space, &run->target, STEPS, &run->ticker, point, run->err);
    return status;
}

static nqm_status minimise(nqm_fit_run *run, nqm_fit_point *best) {
    nqm_fit_point points[NQM_FIT_MAX_POINTS] = {{.loss = 0}};
    size_t n = 1;
    const bool is_square = run->n_terms == 1 && !has_visual(run) && nqm_fit_losses[run->target.loss].power == 2;
    nqm_status status = run->options->start ? begin_at_start(run, points) : nqm_fit_search(run, points, &n);
    for (size_t i = 0; status == NQM_OK && !is_square && i < n; ++i)
        status = nqm_fit_descend(run->objective, &run->space, NQM_FIT_STEPS, &run->ticker, &points[i], run->err);
    size_t winner = 0;
    for (size_t i = 1; i < n; ++i)
        winner = points[i].loss < points[winner].loss ? i : winner;
    *best = points[winner];
    return status == NQM_OK ? nqm_fit_simplify(run, best) : status;
}

static nqm_status fit_model(const nqm_brdf *ref, const nqm_fit_entry *entry, const nqm_fit_options *options,
                            nqm_fit_report *report, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_fit_run run;
    nqm_fit_point best;
    nqm_status status = nqm_fit_begin(&run, ref, entry, options, first_loss(options), err);
    if (status == NQM_OK)
        status = minimise(&run, &best);
    if (status == NQM_OK)
        status = nqm_fit_write_report(&run, &best, report);
    if (status == NQM_OK)
        status = nqm_fit_objective_value(run.objective, &best.values, &report->loss, err);
    if (status == NQM_OK)
        status = nqm_brdf_open(report->spec, brdf_ret, err);
    nqm_fit_end(&run);
    return status;
}

nqm_status nqm_fit_path(const nqm_brdf *ref, const char *model, const nqm_fit_options *options, uint64_t seed,
                        size_t n_steps, char spec[512], nqm_error *err) {
    const nqm_fit_entry *entry;
    nqm_fit_run run = {.ref = ref};
    nqm_fit_point point = {.loss = 0};
    nqm_rng rng = nqm_rng_make(seed, 0);
    nqm_status status = nqm_fit_entry_find(model, &entry, err);
    if (status == NQM_OK && entry->n_shape == 0)
        status = nqm_fail(err, NQM_ERR_ARG, -1, "%s is not an analytic model", model);
    if (status == NQM_OK)
        status = nqm_fit_begin(&run, ref, entry, options, options->loss, err);
    if (status == NQM_OK)
        status = nqm_fit_random(&run.space, &run.target, &rng, &point.values, err);
    if (status == NQM_OK)
        status = nqm_fit_refine(&run.space, &run.target, n_steps, NULL, &point, err);
    if (status == NQM_OK)
        status = nqm_fit_write_spec(&run.space, &point.values, spec, 512, err);
    nqm_fit_end(&run);
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
    if (status == NQM_OK)
        status = (entry->encode ? encode : fit_model)(ref, entry, &options, &report, &brdf, err);
    if (status != NQM_OK)
        return status;
    *report_ret = report;
    if (brdf_ret)
        *brdf_ret = brdf;
    else
        nqm_brdf_free(brdf);
    return NQM_OK;
}
