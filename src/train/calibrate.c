/* SPDX-License-Identifier: MIT
 *
 * Copies of a model with added information: intervals, calibrated on validation materials that the model was not
 * trained on, or notes in the model card. The results of a calibration are stored in the metadata and in the card.
 */
#include "train/calibrate.h"
#include "io/json.h"
#include "metric/metric.h"

#include <math.h>
#include <string.h>

/* ---- metadata and card ------------------------------------------------------------------------------------------- */

static double rounded(double x) {
    return round(x * 1e4) / 1e4;
}

static char *calibration_text(const nqm_calibration *c, const char *dataset_sha256) {
    return nqm_json_text(json_pack("{s:f, s:I, s:I, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:s}", "level", 0.95,
                                   "materials", (json_int_t)c->n_materials, "pairs", (json_int_t)c->n_pairs, "coverage",
                                   rounded(c->coverage), "coverage_pairs", rounded(c->coverage_pairs),
                                   "coverage_lowest", rounded(c->coverage_lowest), "mean_width", rounded(c->mean_width),
                                   "novelty_growth", rounded(c->novelty_growth), "disagreement_growth",
                                   rounded(c->disagreement_growth), "peak_growth", rounded(c->peak_growth),
                                   "dataset_sha256", dataset_sha256),
                         9);
}

static const char section_head[] = "\n## Interval\n";
static const char novelty_note[] = " It is wider for pairs unlike the training pairs (`novelty`).";

/* Find the section on the interval in a card; both offsets are the card's length if it has none. */
static void find_section(const char *card, size_t *begin_ret, size_t *end_ret) {
    const char *begin = strstr(card, section_head);
    *begin_ret = *end_ret = strlen(card);
    if (!begin)
        return;
    const char *next = strstr(begin + sizeof section_head - 1, "\n## ");
    *begin_ret = (size_t)(begin - card);
    if (next)
        *end_ret = (size_t)(next - card);
}

char *nqm_card_with_interval(const char *card, const nqm_calibration *c, const char *dataset_sha256) {
    enum { NUMBER_BYTES = 32 };
    size_t begin, end;
    find_section(card, &begin, &end);
    char percent[3][NUMBER_BYTES], width[NUMBER_BYTES]; /* with a decimal point in any locale */
    const double shares[3] = {c->coverage, c->coverage_pairs, c->coverage_lowest};
    for (size_t i = 0; i < 3; ++i)
        nqm_format_double(percent[i], sizeof percent[i], round(1000 * shares[i]) / 10);
    nqm_format_double(width, sizeof width, round(100 * c->mean_width) / 100);
    return nqm_strdupf(
        "%.*s%s\nThe 95 %% interval of a JOD was calibrated on %zu validation pairs of %zu materials, which the model "
        "was\n"
        "not trained on (dataset `%.64s`).\nWith each material left out in turn, it held %s %% of that material's "
        "labels as the mean over materials\n(%s %% of all pairs; of the worst material %s %%); mean width %s JOD. It "
        "is "
        "about labels by rendering of\nmaterials and distortions like these, not about people.%s\n%s",
        (int)begin, card, section_head, c->n_pairs, c->n_materials, dataset_sha256, percent[0], percent[1], percent[2],
        width, c->novelty_growth > 0 ? novelty_note : "", card + end);
}

nqm_status nqm_model_set_interval(struct nqm_model *model, const nqm_dataset *dataset, bool trained_on,
                                  nqm_residuals *residuals, nqm_calibration *report, nqm_error *err) {
    double *table = nqm_alloc(NQM_INTERVAL_ROWS, 3 * sizeof *table);
    char *text = NULL;
    nqm_status status = table ? NQM_OK : nqm_fail_nomem(err, NQM_INTERVAL_ROWS * 3 * sizeof *table);
    if (status == NQM_OK && trained_on)
        status = nqm_novelty_choose(model, dataset, err);
    if (status == NQM_OK && residuals->n > 0)
        status = nqm_novelty_measure(model, dataset, residuals, err);
    if (status == NQM_OK)
        status = nqm_interval_fit(residuals, table, report, err);
    if (status == NQM_OK && !(text = calibration_text(report, dataset->sha256)))
        status = nqm_fail_nomem(err, 0);
    if (status != NQM_OK) {
        nqm_free(table);
        return status;
    }
    model->n_interval = NQM_INTERVAL_ROWS;
    model->interval = table;
    model->calibration = text;
    nqm_interval_find_floor(residuals, model->interval_floor);
    model->novelty_growth = report->novelty_growth;
    model->spread_growth[NQM_SPREAD_DISAGREEMENT] = report->disagreement_growth;
    model->spread_growth[NQM_SPREAD_PEAK] = report->peak_growth;
    return NQM_OK;
}

/* ---- calibration of a model -------------------------------------------------------------------------------------- */

static nqm_status was_split_by_pair(const nqm_model *model, bool *by_pair, nqm_error *err) {
    json_t *training;
    const nqm_status status = nqm_json_parse(model->training, &training, err);
    *by_pair = json_is_true(json_object_get(json_object_get(training, "options"), "split_by_pair"));
    json_decref(training);
    return status;
}

static bool was_trained_on(const nqm_model *model, const nqm_dataset *dataset) {
    return model->manifest_sha256 && strcmp(model->manifest_sha256, dataset->sha256) == 0;
}

/* Refuse a dataset whose validation materials may have been used in training: the intervals would be too narrow. */
static nqm_status check_new(const nqm_model *model, const nqm_dataset *dataset, nqm_error *err) {
    if (!was_trained_on(model, dataset))
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                        "model '%s' was not trained on this dataset, so that its validation materials may have been "
                        "trained on",
                        model->id);
    bool by_pair;
    const nqm_status status = was_split_by_pair(model, &by_pair, err);
    if (by_pair)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                        "model '%s' was trained on the validation materials: its validation pairs were drawn over all "
                        "pairs",
                        model->id);
    return status;
}

/* Predictions and labels of the validation pairs. */
static nqm_status predict_validation(const nqm_model *model, const nqm_dataset *d, nqm_residuals *r, nqm_error *err) {
    nqm_prediction *to = nqm_alloc(d->n_pairs, sizeof *to);
    nqm_status status = nqm_residuals_create(d, d->n_pairs, r, err);
    if (status == NQM_OK && !to)
        status = nqm_fail_nomem(err, d->n_pairs * sizeof *to);
    for (size_t i = 0; status == NQM_OK && i < d->n_pairs; ++i)
        if (nqm_dataset_pair_split(d, i) == NQM_SPLIT_VALIDATION)
            nqm_residuals_add(r, d, i, 0);
    const nqm_dataset_prediction p = {.dataset = d, .model = model, .n = r->n, .pairs = r->pairs, .to = to};
    if (status == NQM_OK)
        status = r->n ? nqm_dataset_predict(&p, err)
                      : nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "the dataset has no validation pairs");
    for (size_t k = 0; status == NQM_OK && k < r->n; ++k)
        r->predicted[k] = to[r->pairs[k]].jod;
    nqm_free(to);
    return status;
}

/* Replace the intervals of `copy`, a copy of the model, by newly fitted ones. */
static nqm_status calibrate(const nqm_model *model, nqm_model *copy, const nqm_dataset *d, nqm_calibration *report,
                            nqm_error *err) {
    nqm_residuals residuals;
    nqm_status status = predict_validation(model, d, &residuals, err);
    nqm_free(copy->interval);
    nqm_free(copy->calibration);
    copy->interval = NULL;
    copy->calibration = NULL;
    if (status == NQM_OK)
        status = nqm_model_set_interval(copy, d, was_trained_on(model, d), &residuals, report, err);
    nqm_free(residuals.predicted);
    return status;
}

/* Takes ownership of `card`. NULL means that the caller ran out of memory. */
static nqm_status replace_card(nqm_model *model, char *card, nqm_error *err) {
    nqm_free(model->card);
    model->card = card;
    return card ? NQM_OK : nqm_fail_nomem(err, 0);
}

nqm_status nqm_model_calibrate(const nqm_model *model, const nqm_dataset *dataset, int materials_are_new,
                               nqm_model **model_ret, nqm_calibration *calibration, nqm_error *err) {
    NQM_MAKE(err, model_ret, model, dataset, calibration);
    nqm_model *copy = NULL;
    char *golden = NULL;
    nqm_status status = materials_are_new ? NQM_OK : check_new(model, dataset, err);
    if (status == NQM_OK)
        status = nqm_model_copy(model, &copy, err);
    if (status == NQM_OK)
        status = calibrate(model, copy, dataset, calibration, err);
    if (status == NQM_OK)
        status = replace_card(
            copy, nqm_card_with_interval(model->card ? model->card : "", calibration, dataset->sha256), err);
    if (status == NQM_OK)
        status = nqm_golden_make(copy, &golden, err);
    if (status != NQM_OK) {
        nqm_model_free(copy);
        return status;
    }
    nqm_free(copy->golden);
    copy->golden = golden;
    *model_ret = copy;
    return NQM_OK;
}

/* ---- notes ------------------------------------------------------------------------------------------------------- */

nqm_status nqm_model_annotate(const nqm_model *model, const char *markdown, nqm_model **model_ret, nqm_error *err) {
    NQM_MAKE(err, model_ret, model, markdown);
    const char *before = model->card ? model->card : "";
    nqm_model *copy;
    nqm_status status = nqm_model_copy(model, &copy, err);
    if (status != NQM_OK)
        return status;
    status = replace_card(copy, nqm_strdupf("%s%s%s", before, *before ? "\n" : "", markdown), err);
    if (status == NQM_OK)
        *model_ret = copy;
    else
        nqm_model_free(copy);
    return status;
}
