/* SPDX-License-Identifier: MIT
 *
 * Scores of sampled pairs with their gradients by the samples of the test: forward through features, estimate and network, then
 * back through each of them.
 */
#include "kernel/panel.h"
#include "math/math.h"
#include "metric/sums.h"
#include "net/input_gradient.h"

#include <math.h>
#include <string.h>

struct nqm_gradients {
    const nqm_model *model;
    nqm_transport transport; /* of the model; `light` NULL: none */
    size_t samples_width;    /* number of inputs that come from samples */
    size_t stride;           /* floats from one row of x to the next */
    size_t n_outputs;
    nqm_gradient_net *net; /* NULL: the model has no network */
    nqm_gradient_work *work;
    float *t;                          /* (max_batch, 2, n_directions, 3) transformed reference and test */
    float *x, *dx;                     /* (max_batch, stride) network inputs, and the gradient by them */
    float *z, *dz;                     /* (max_batch, n_outputs) */
    nqm_pair_sums *sums;               /* (max_batch) of the scalar features */
    double *scalars;                   /* (max_batch, NQM_SCALAR_COUNT) */
    nqm_label *estimate, *by_estimate; /* (max_batch) by light transport, and the gradient by it */
    double *rgb, *scratch; /* (max_batch, 2, 3, n_points) light of reference and test; scratch of half the size */
    double *seen;          /* (max_batch, 2, 3, n_points) ITP of reference and test */
    double *sum;           /* (max_batch, 2, n_directions, 3) gradients by f_r: sum and one summand */
};

nqm_status nqm_gradients_create(const nqm_model *model, size_t max_batch, nqm_gradients **gradients_ret,
                                nqm_error *err) {
    *gradients_ret = NULL;
    const size_t n = 3 * model->directions->n, n_outputs = nqm_model_n_outputs(model);
    const nqm_transport transport = nqm_model_transport(model);
    const size_t samples_width = nqm_features_width(model->features.layout, model->directions->n);
    const size_t stride = nqm_row_stride(samples_width + nqm_model_n_scalars(model));
    nqm_gradients *g, made = {.model = model,
                              .transport = transport,
                              .samples_width = samples_width,
                              .stride = stride,
                              .n_outputs = n_outputs};
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&g, 1, sizeof *g}, {&made.t, max_batch, 2 * n * sizeof *made.t},
                   {&made.x, max_batch, stride * sizeof *made.x}, {&made.dx, max_batch, stride * sizeof *made.dx},
                   {&made.z, max_batch, n_outputs * sizeof *made.z}, {&made.dz, max_batch, n_outputs * sizeof *made.dz},
                   {&made.sums, max_batch, sizeof *made.sums},
                   {&made.scalars, max_batch, NQM_SCALAR_COUNT * sizeof *made.scalars},
                   {&made.estimate, max_batch, sizeof *made.estimate},
                   {&made.by_estimate, max_batch, sizeof *made.by_estimate},
                   {&made.rgb, max_batch, 6 * transport.n_points * sizeof *made.rgb},
                   {&made.scratch, max_batch, 3 * transport.n_points * sizeof *made.scratch},
                   {&made.seen, max_batch, 6 * transport.n_points * sizeof *made.seen},
                   {&made.sum, max_batch, 2 * n * sizeof *made.sum}),
        err);
    if (status != NQM_OK)
        return status;
    *g = made;
    if (nqm_model_has_network(model))
        status = nqm_gradient_net_create(&model->params, &g->net, err);
    if (status == NQM_OK && g->net)
        status = nqm_gradient_work_create(g->net, max_batch, &g->work, err);
    if (status == NQM_OK)
        *gradients_ret = g;
    else
        nqm_gradients_free(g);
    return status;
}

void nqm_gradients_free(nqm_gradients *g) {
    if (!g)
        return;
    nqm_gradient_work_free(g->work);
    nqm_gradient_net_free(g->net);
    nqm_free(g);
}

/* ---- one pair ---------------------------------------------------------------------------------------------------- */

typedef struct run {
    nqm_gradients *g;
    nqm_score_quantity of;
    const nqm_sample_pair *pairs;
    double *values;
    float *out;
} run;

static void estimate(const nqm_gradients *g, const nqm_sample_pair *pair, size_t i) {
    const size_t n = 3 * g->transport.n_points;
    double *seen = g->seen + 2 * i * n;
    nqm_transport_see(&g->transport, pair->ref, pair->test, pair->used, g->rgb + 2 * i * n, seen);
    g->estimate[i] = nqm_transport_label(&g->transport, seen, seen + n);
}

static nqm_comparison comparison_of(const nqm_gradients *g, const nqm_sample_pair *pair, size_t i) {
    return (nqm_comparison){.directions = g->model->directions,
                            .ref = pair->ref,
                            .n = 1,
                            .test = &pair->test,
                            .used = pair->used,
                            .estimate = g->transport.light ? &g->estimate[i] : NULL};
}

/* Compute the inputs of pair i. */
static void compose(void *user, size_t i) {
    const run *r = user;
    const nqm_gradients *g = r->g;
    const nqm_sample_pair *pair = &r->pairs[i];
    const nqm_model *m = g->model;
    const size_t n_directions = m->directions->n, n = 3 * n_directions;
    float *ref_t = g->t + 2 * i * n, *test_t = ref_t + n, *x = g->x + i * g->stride;
    double *scalars = g->scalars + i * NQM_SCALAR_COUNT;
    if (g->transport.light)
        estimate(g, pair, i);
    if (!g->net)
        return;
    nqm_features_transform(n, pair->ref, ref_t);
    nqm_features_transform(n, pair->test, test_t);
    nqm_features_compose(&m->features, n_directions, ref_t, test_t, pair->used, x);
    if (nqm_model_n_scalars(m) == 0)
        return;
    const nqm_comparison c = comparison_of(g, pair, i);
    nqm_compare_sums(&c, true, &g->sums[i]);
    nqm_compare_finish(&c, &g->sums[i], NULL, scalars);
    nqm_scalars_whiten(&m->scalars, scalars, x + g->samples_width);
}

/* Value of pair i, and the gradients by the network's output and by the estimate. */
static void conclude(const run *r, size_t i) {
    const nqm_gradients *g = r->g;
    const nqm_model *m = g->model;
    const nqm_label *estimated = g->transport.light ? &g->estimate[i] : NULL;
    const double z = (double)g->z[i * g->n_outputs];
    double delta_e, by_z;
    const double jod = nqm_model_jod(m, z, estimated, &delta_e);
    g->by_estimate[i] = (nqm_label){.delta_e = 0};
    nqm_model_slopes(m, z, estimated, r->of == NQM_SCORE_JOD, &by_z, &g->by_estimate[i].delta_e);
    g->dz[i * g->n_outputs] = (float)by_z;
    r->values[i] = r->of == NQM_SCORE_JOD ? jod : delta_e;
}

/* The gradient of pair i is that of the bound if it is below the model's Delta-E. */
static bool is_bounded(const run *r, size_t i, float *out) {
    const nqm_gradients *g = r->g;
    const nqm_sample_pair *p = &r->pairs[i];
    const size_t n = g->model->directions->n;
    const double bound = nqm_delta_e_bound(n, p->ref, p->test, p->used);
    double delta_e;
    (void)nqm_model_jod(g->model, (double)g->z[i * g->n_outputs], g->transport.light ? &g->estimate[i] : NULL,
                        &delta_e);
    if (!(delta_e > bound)) /* true for NaN: models that predict no Delta-E */
        return false;
    size_t at;
    const bool of_jod = r->of == NQM_SCORE_JOD;
    const double slope = nqm_delta_e_bound_slope(n, p->ref, p->test, p->used, &at);
    memset(out, 0, 3 * n * sizeof *out);
    out[at] = (float)(of_jod ? slope * nqm_curve_slope(&g->model->curve, bound) : slope);
    r->values[i] = of_jod ? nqm_curve_jod(&g->model->curve, bound) : bound;
    return true;
}

static void add_inputs_gradient(const nqm_gradients *g, const nqm_sample_pair *pair, size_t i, double *sum,
                                double *summand) {
    const nqm_model *m = g->model;
    const size_t n_directions = m->directions->n, n = 3 * n_directions;
    const float *x = g->x + i * g->stride, *dx = g->dx + i * g->stride;
    double by_scalars[NQM_SCALAR_COUNT];
    nqm_features_gradient(&m->features, n_directions, pair->test, pair->used, x, dx, sum);
    if (nqm_model_n_scalars(m) == 0)
        return;
    nqm_scalars_whiten_back(&m->scalars, g->scalars + i * NQM_SCALAR_COUNT, dx + g->samples_width, by_scalars);
    const nqm_comparison c = comparison_of(g, pair, i);
    nqm_compare_gradient(&c, &g->sums[i], NULL, by_scalars, summand);
    for (size_t k = 0; k < n; ++k)
        sum[k] += summand[k];
    if (g->transport.light)
        nqm_estimate_gradient(&g->estimate[i], by_scalars + NQM_SCALAR_ESTIMATE, &g->by_estimate[i]);
}

/* The gradient of pair i by f_r, from those by the network's inputs and by the estimate. */
static void differentiate(void *user, size_t i) {
    const run *r = user;
    const nqm_gradients *g = r->g;
    const nqm_sample_pair *pair = &r->pairs[i];
    const size_t n = 3 * g->model->directions->n, n_points = 3 * g->transport.n_points;
    double *sum = g->sum + 2 * i * n, *summand = sum + n;
    float *out = r->out + i * n;
    if (is_bounded(r, i, out))
        return;
    memset(sum, 0, n * sizeof *sum);
    if (g->net)
        add_inputs_gradient(g, pair, i, sum, summand);
    if (g->transport.light) {
        const double *ref = g->seen + 2 * i * n_points;
        nqm_transport_gradient(&g->transport, &g->by_estimate[i], ref, ref + n_points, g->rgb + (2 * i + 1) * n_points,
                               pair->used, g->scratch + i * n_points, summand);
        for (size_t k = 0; k < n; ++k)
            sum[k] += summand[k];
    }
    for (size_t k = 0; k < n; ++k)
        out[k] = (float)sum[k];
}

/* ---- entry ------------------------------------------------------------------------------------------------------- */

void nqm_gradients_run(nqm_gradients *g, nqm_score_quantity of, size_t n, const nqm_sample_pair *pairs, double *values,
                       float *out) {
    run r = {g, of, pairs, values, out};
    nqm_parallel_for(n, compose, &r);
    if (g->net)
        nqm_gradient_forward(g->work, n, g->x, g->z);
    for (size_t i = 0; i < n; ++i)
        conclude(&r, i);
    if (g->net)
        nqm_gradient_backward(g->work, n, g->dz, g->dx);
    nqm_parallel_for(n, differentiate, &r);
}
