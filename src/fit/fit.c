/* SPDX-License-Identifier: MIT
 *
 * Fits of analytic models: options, the result as a spec, and the fit of one.
 */
#include "fit/fit.h"
#include "math/math.h"

#include <string.h>

static const char *const loss_names[] = {"log", "log-cos", "cube-root", "linear"};

int nqm_fit_loss_parse(const char *text, nqm_fit_loss *loss_ret) {
    for (size_t i = 0; i < sizeof loss_names / sizeof *loss_names; ++i)
        if (strcmp(text, loss_names[i]) == 0) {
            *loss_ret = (nqm_fit_loss)i;
            return 1;
        }
    return 0;
}

const char *nqm_fit_loss_name(nqm_fit_loss loss) {
    return loss_names[loss];
}

nqm_fit_options nqm_fit_options_default(void) {
    return (nqm_fit_options){.loss = NQM_FIT_LOG,
                             .n_directions = 6000,
                             .max_polar_rad = 80 * NQM_PI / 180,
                             .highlight_fraction = 0.05,
                             .n_starts = 12,
                             .seed = 1};
}

void nqm_fit_round(const nqm_fit_model *model, nqm_fit_values *values) {
    const int n_digits = 6; /* more than a fit knows */
    for (size_t s = 0; s < model->n_shape; ++s)
        values->shape[s] = model->shape[s].scale == NQM_FIT_SCALE_LOG_REST
                               ? 1 - nqm_round_digits(1 - values->shape[s], n_digits)
                               : nqm_round_digits(values->shape[s], n_digits);
    for (size_t c = 0; c < 3; ++c) {
        values->kd[c] = nqm_round_digits(values->kd[c], n_digits);
        values->ks[c] = nqm_round_digits(values->ks[c], n_digits);
    }
}

static size_t append(char *text, size_t used, const char *key, size_t n, const double *values) {
    int added = snprintf(text + used, 512 - used, "%s=", key);
    used += (size_t)added;
    for (size_t i = 0; i < n; ++i) {
        char number[32];
        nqm_format_double(number, sizeof number, values[i]);
        used += (size_t)snprintf(text + used, 512 - used, "%s%s", i ? "," : "", number);
    }
    return used;
}

void nqm_fit_write_spec(const nqm_fit_model *model, const nqm_fit_values *values, char spec[512]) {
    size_t used = (size_t)snprintf(spec, 512, "%s:", model->name);
    used = append(spec, used, "kd", 3, values->kd);
    used = append(spec, used, ";ks", 3, values->ks);
    for (size_t s = 0; s < model->n_shape; ++s) {
        char key[16];
        snprintf(key, sizeof key, ";%s", model->shape[s].key);
        used = append(spec, used, key, 1, &values->shape[s]);
    }
}

nqm_status nqm_fit_check_options(const nqm_fit_options *o, nqm_error *err) {
    if (o->n_directions < 200 || o->n_directions > 1000000)
        return nqm_fail(err, NQM_ERR_ARG, -1, "a fit needs 200 to 1000000 directions, not %zu", o->n_directions);
    if (!(o->max_polar_rad > 0 && o->max_polar_rad < NQM_PI / 2))
        return nqm_fail(err, NQM_ERR_ARG, -1, "the largest polar angle of a fit must lie between 0 and 90 degrees");
    if (!(o->highlight_fraction >= 0 && o->highlight_fraction <= 1))
        return nqm_fail(err, NQM_ERR_ARG, -1, "the highlight fraction of a fit must lie between 0 and 1");
    if (o->n_starts < 1 || o->n_starts > 100)
        return nqm_fail(err, NQM_ERR_ARG, -1, "a fit takes 1 to 100 starts, not %zu", o->n_starts);
    if ((unsigned)o->loss > NQM_FIT_LINEAR)
        return nqm_fail(err, NQM_ERR_ARG, -1, "unknown loss %d", (int)o->loss);
    return NQM_OK;
}

nqm_status nqm_fit_analytic(const nqm_brdf *ref, const char *model_name, const nqm_fit_options *options,
                            nqm_fit_report *report, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_fit_model model = *nqm_fit_model_find(model_name);
    nqm_status status = nqm_fit_apply_bounds(options, &model, err);
    if (status != NQM_OK)
        return status;
    nqm_fit_target target;
    nqm_fit_values values;
    status = nqm_fit_target_make(ref, options, &target, err);
    if (status == NQM_OK)
        status = nqm_fit_solve(&model, &target, options, &values, &report->best_start, err);
    if (status == NQM_OK) {
        nqm_fit_round(&model, &values);
        nqm_fit_write_spec(&model, &values, report->spec);
        report->n_directions = target.n;
        report->n_numbers = 6 + model.n_shape;
        status = nqm_fit_loss_of_spec(&target, report->spec, &report->loss, err);
    }
    if (status == NQM_OK)
        status = nqm_brdf_open(report->spec, brdf_ret, err);
    nqm_fit_target_free(&target);
    return status;
}
