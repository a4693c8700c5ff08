/* SPDX-License-Identifier: MIT
 *
 * Compares pairs of a dataset, and predicts their JOD, novelty and parts of the label with a model, in batches.
 */
#include "data/data.h"

#include <math.h>
#include <string.h>

typedef struct compare_job {
    const nqm_dataset *dataset;
    const nqm_transport *transport;
    const size_t *pairs;
    nqm_comparison *to;
    nqm_sum_plan *plan;
    uint8_t *used; /* (n, n_directions) */
} compare_job;

static void compare_pair(void *user, size_t i) {
    const compare_job *job = user;
    const nqm_dataset *d = job->dataset;
    nqm_comparison *to = &job->to[i];
    const nqm_sample_pair samples = nqm_dataset_samples(d, job->pairs[i], job->used + i * d->n_directions);
    nqm_compare_samples(job->plan, job->transport, &samples, to->metrics, &to->estimate, to->scalars);
}

nqm_status nqm_dataset_compare(const nqm_dataset *d, const nqm_transport *transport, size_t n, const size_t *pairs,
                               nqm_comparison *to, nqm_error *err) {
    compare_job job = {d, transport, pairs, to, NULL, nqm_alloc(n, d->n_directions)};
    nqm_status status = job.used ? NQM_OK : nqm_fail_nomem(err, n * d->n_directions);
    if (status == NQM_OK)
        status = nqm_sum_plan_create(d->directions, &job.plan, err);
    if (status == NQM_OK)
        nqm_parallel_for(n, compare_pair, &job);
    nqm_sum_plan_free(job.plan);
    nqm_free(job.used);
    return status;
}

/* ---- predictions ------------------------------------------------------------------------------------------------- */

static bool is_finite(const nqm_label *label) {
    double parts[NQM_LABEL_PARTS];
    bool finite = true;
    nqm_label_get_parts(label, parts);
    for (size_t k = 0; k < NQM_LABEL_PARTS; ++k)
        finite = finite && isfinite(parts[k]);
    return finite;
}

static nqm_status predict_batch(const nqm_dataset_prediction *p, nqm_predictor *predictor, size_t n,
                                const size_t *pairs, uint8_t *used, nqm_error *err) {
    const nqm_dataset *d = p->dataset;
    nqm_sample_pair batch[NQM_PREDICT_BATCH];
    nqm_prediction to[NQM_PREDICT_BATCH];
    for (size_t i = 0; i < n; ++i)
        batch[i] = nqm_dataset_samples(d, pairs[i], used + i * d->n_directions);
    nqm_predictor_run(predictor, n, batch, to, NULL);
    for (size_t i = 0; i < n; ++i) {
        if (!isfinite(to[i].jod) || (nqm_model_has_parts(p->model) && !is_finite(&to[i].label)))
            return nqm_fail(err, NQM_ERR_NUMERIC, -1, "model '%s' gives no finite JOD or parts for pair %zu",
                            p->model->id, pairs[i]);
        p->to[pairs[i]] = to[i];
    }
    return p->batch_done ? p->batch_done(p->user, n, err) : NQM_OK;
}

/* Models for anisotropic BRDFs have no use for samples: the BRDFs are opened by their names. */
static nqm_status predict_named(const nqm_dataset_prediction *p, nqm_error *err) {
    nqm_named_pair named[NQM_SCORE_BLOCK];
    nqm_score_result results[NQM_SCORE_BLOCK];
    nqm_error why[NQM_SCORE_BLOCK];
    nqm_scorer *scorer;
    nqm_status status = nqm_scorer_create(p->model, NULL, &scorer, err);
    for (size_t first = 0, n; status == NQM_OK && first < p->n; first += n) {
        const size_t *pairs = p->pairs + first;
        n = nqm_smaller(p->n - first, NQM_SCORE_BLOCK);
        for (size_t i = 0; i < n; ++i) {
            const nqm_dataset_pair pair = nqm_dataset_get_pair(p->dataset, pairs[i]);
            named[i] = (nqm_named_pair){pair.ref, pair.test};
        }
        status = nqm_scorer_run_named(scorer, n, named, results, why, err);
        for (size_t i = 0; status == NQM_OK && i < n; ++i) {
            if (results[i].status != NQM_OK)
                status = nqm_fail(err, why[i].status, -1, "pair %zu: %s", pairs[i], why[i].message);
            p->to[pairs[i]] = (nqm_prediction){.jod = results[i].jod,
                                               .delta_e = results[i].delta_e,
                                               .bound = INFINITY,
                                               .novelty = NAN,
                                               .label = results[i].parts,
                                               .similarity = {NAN, NAN, NAN}};
        }
        if (status == NQM_OK && p->batch_done)
            status = p->batch_done(p->user, n, err);
    }
    nqm_scorer_free(scorer);
    return status;
}

nqm_status nqm_dataset_predict(const nqm_dataset_prediction *p, nqm_error *err) {
    const nqm_dataset *d = p->dataset;
    const nqm_model *m = p->model;
    nqm_predictor *predictor = NULL;
    if (m->slopes)
        return predict_named(p, err);
    const nqm_status isotropic = nqm_dataset_check_isotropic(d, err);
    if (isotropic != NQM_OK)
        return isotropic;
    if (m->directions->n != d->n_directions ||
        memcmp(m->directions->degrees, d->directions->degrees, 3 * d->n_directions * sizeof(double)) != 0)
        return nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1,
                        "model '%s' uses %zu directions (identity %s), the dataset %zu other ones (identity %s)", m->id,
                        m->directions->n, nqm_directions_id(m->directions), d->n_directions,
                        nqm_directions_id(d->directions));
    uint8_t *used = nqm_alloc(NQM_PREDICT_BATCH, d->n_directions);
    nqm_status status = used ? nqm_predictor_create(m, NQM_PREDICT_BATCH, &predictor, err)
                             : nqm_fail_nomem(err, NQM_PREDICT_BATCH * d->n_directions);
    for (size_t first = 0; status == NQM_OK && first < p->n; first += NQM_PREDICT_BATCH)
        status = predict_batch(p, predictor, nqm_smaller(p->n - first, NQM_PREDICT_BATCH), p->pairs + first, used, err);
    nqm_predictor_free(predictor);
    nqm_free(used);
    return status;
}
