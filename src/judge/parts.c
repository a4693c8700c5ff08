/* SPDX-License-Identifier: MIT
 *
 * How well a model predicts the parts of labels, beside what light transport estimates and the scalar features that are closest
 * to each part by definition.
 */
#include "judge/judge.h"

#include <math.h>

enum { MAX_SCALARS = 2, MAX_PREDICTORS = 2 + MAX_SCALARS };
enum { LOG_DIFF = NQM_SCALAR_METRICS + NQM_METRIC_LOG_DIFF };

/* A part, and the scalar features that are its control. */
typedef struct part {
    const char *name;
    size_t n_scalars, scalars[MAX_SCALARS];
    double sign;           /* sign of their correlation with the part */
    double plain, noticed; /* sizes from which words describe a label's part, and from which a prediction agrees */
} part;

/* The parts of an array of NQM_LABEL_PARTS, then the JOD of adapted people. */
static const part parts[NQM_EVAL_PARTS] = {{"shift_i", 2, {NQM_SCALAR_BIAS, NQM_SCALAR_ENERGY}, 1, 3, 0},
                                           {"shift_t", 1, {NQM_SCALAR_CHROMA_B}, 1, 3, 0},
                                           {"shift_p", 1, {NQM_SCALAR_CHROMA_RG}, 1, 3, 0},
                                           {"contrast", 2, {NQM_SCALAR_PEAK, NQM_SCALAR_WIDTH}, 1, 0.1, 0},
                                           {"structure", 1, {NQM_SCALAR_SHAPE}, 1, 3, 1}, /* structure has no sign */
                                           {"adapted_jod", 1, {LOG_DIFF}, -1, INFINITY, 0}};

static double part_of(const nqm_label *label, size_t part_index) {
    double values[NQM_LABEL_PARTS];
    nqm_label_get_parts(label, values);
    return part_index < NQM_LABEL_PARTS ? values[part_index] : nqm_label_adapted_jod(label);
}

/* What is judged: the model, its controls, and last, if the dataset has it, the estimate. */
typedef struct work {
    const nqm_evaluation *ev;
    const nqm_label *model;
    nqm_selection s;
} work;

static void collect(const work *w, size_t part_index) {
    const nqm_evaluation *ev = w->ev;
    const part *p = &parts[part_index];
    const size_t n = w->s.n;
    for (size_t i = 0; i < n; ++i) {
        const size_t pair = w->s.pairs[i];
        nqm_label label = {.delta_e = NAN}; /* not used */
        nqm_label_set_parts(&label, ev->dataset->parts + pair * NQM_LABEL_PARTS);
        w->s.label[i] = part_of(&label, part_index);
        w->s.prediction[i] = part_of(&w->model[pair], part_index);
        for (size_t k = 0; k < p->n_scalars; ++k)
            w->s.prediction[(1 + k) * n + i] = p->sign * ev->scalars[pair * NQM_SCALAR_COUNT + p->scalars[k]];
        if (ev->estimates)
            w->s.prediction[(1 + p->n_scalars) * n + i] = part_of(&ev->estimates[pair], part_index);
    }
}

/* nqm_part_agreement.n_plain and .same_sign, of the labels and the model's predictions that collect() stored. */
static void count_signs(const work *w, const part *p, nqm_part_agreement *result) {
    size_t n_same = 0;
    for (size_t i = 0; i < w->s.n; ++i) {
        const double predicted = w->s.label[i] < 0 ? -w->s.prediction[i] : w->s.prediction[i];
        if (fabs(w->s.label[i]) <= p->plain)
            continue;
        ++result->n_plain;
        n_same += predicted > 0 && predicted >= p->noticed;
    }
    result->same_sign = (double)n_same / (double)result->n_plain; /* NaN for no pair */
}

static nqm_status judge_part(const work *w, const nqm_eval_options *o, size_t part_index, nqm_part_agreement *result,
                             nqm_error *err) {
    const part *p = &parts[part_index];
    const nqm_judgement j = {.n = w->s.n,
                             .n_groups = w->s.n_groups,
                             .n_predictors = 1 + p->n_scalars + (w->ev->estimates != NULL),
                             .group_begin = w->s.group_begin,
                             .label = w->s.label,
                             .prediction = w->s.prediction,
                             .without_kendall = true};
    nqm_agreement by[MAX_PREDICTORS];
    collect(w, part_index);
    nqm_status status = nqm_judge(&j, o->n_bootstrap, o->seed, by, err);
    if (status != NQM_OK)
        return status;
    size_t best = 1;
    for (size_t k = 2; k <= p->n_scalars; ++k)
        if (isnan(by[best].spearman.value) || by[k].spearman.value > by[best].spearman.value)
            best = k;
    *result = (nqm_part_agreement){.part = p->name,
                                   .n = j.n,
                                   .n_materials = j.n_groups,
                                   .model = by[0].spearman,
                                   .estimate = {NAN, {NAN, NAN}},
                                   .scalar = by[best].spearman,
                                   .scalar_name = nqm_scalar_name(p->scalars[best - 1])};
    count_signs(w, p, result);
    if (w->ev->estimates)
        result->estimate = by[1 + p->n_scalars].spearman;
    return NQM_OK;
}

nqm_status nqm_evaluation_judge_parts(const nqm_evaluation *evaluation, const nqm_eval_options *options, size_t model,
                                      nqm_part_agreement *results, nqm_error *err) {
    work w = {.ev = evaluation,
              .model = model < evaluation->n_models ? nqm_evaluation_labels(evaluation, model) : NULL};
    if (!w.model)
        return nqm_fail(err, NQM_ERR_ARG, -1, "predictor %zu is no model with parts", model);
    if (!evaluation->dataset->parts)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "the labels of the dataset have no parts");
    nqm_status status = nqm_selection_create(evaluation, options, MAX_PREDICTORS, &w.s, err);
    for (size_t i = 0; status == NQM_OK && i < NQM_EVAL_PARTS; ++i)
        status = judge_part(&w, options, i, &results[i], err);
    nqm_selection_free(&w.s);
    return status;
}
