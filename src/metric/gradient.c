/* SPDX-License-Identifier: MIT
 *
 * Scores of sampled pairs with their gradients by the samples of the test: forward through features, estimate and network, then
 * back through each of them. Consecutive pairs of one reference are a run, which shares the work on the reference.
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
    double *sum, *summand; /* (max_batch, n_directions, 3) gradients by f_r */
    size_t *runs;          /* (max_batch + 1) first pair of each run, and the end of the last */
};

/* Pairs in a run: enough to share work, few enough to occupy all threads. */
enum { RUN = NQM_COMPARE_MAX / 2 };

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
                   {&made.sum, max_batch, n * sizeof *made.sum}, {&made.summand, max_batch, n * sizeof *made.summand},
                   {&made.runs, max_batch + 1, sizeof *made.runs}),
        err);
    if (status != NQM_OK)
        return status;
    *g = made;
    if (nqm_model_has_network(model))
        status = nqm_gradient_net_create(&model->params, n, &g->net, err);
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

/* ---- one run of pairs -------------------------------------------------------------------------------------------- */

typedef struct run {
    nqm_gradients *g;
    nqm_score_quantity of;
    const nqm_sample_pair *pairs;
    double *values;
    float *out;
} run;

/* Cut pairs into runs of one reference; pairs with dropped directions are alone. Returns the number of runs. */
static size_t find_runs(const nqm_gradients *g, size_t n, const nqm_sample_pair *pairs) {
    size_t n_runs = 0;
    for (size_t begin = 0, end; begin < n; begin = end) {
        end = begin + 1;
        while (end < n && end - begin < RUN && pairs[end].ref == pairs[begin].ref && !pairs[end].used &&
               !pairs[begin].used)
            ++end;
        g->runs[n_runs++] = begin;
    }
    g->runs[n_runs] = n;
    return n_runs;
}

/* Light and ITP of the reference of a run that begins at pair i, and of the test of pair i. */
static double *picture_of(const nqm_gradients *g, double *pictures, size_t i, bool of_test) {
    return pictures + (2 * i + of_test) * 3 * g->transport.n_points;
}

static void estimate(const nqm_gradients *g, const nqm_sample_pair *pairs, size_t begin, size_t end) {
    nqm_transport_samples samples[1 + RUN] = {{.rgb = pairs[begin].ref}};
    double *rgb[1 + RUN] = {picture_of(g, g->rgb, begin, false)};
    double *seen[1 + RUN] = {picture_of(g, g->seen, begin, false)};
    for (size_t i = begin; i < end; ++i) {
        samples[1 + i - begin] =
            (nqm_transport_samples){.rgb = pairs[i].test, .instead = pairs[i].ref, .used = pairs[i].used};
        rgb[1 + i - begin] = picture_of(g, g->rgb, i, true);
        seen[1 + i - begin] = picture_of(g, g->seen, i, true);
    }
    nqm_transport_see(&g->transport, 1 + end - begin, samples, rgb, seen);
    for (size_t i = begin; i < end; ++i)
        g->estimate[i] = nqm_transport_label(&g->transport, seen[0], seen[1 + i - begin]);
}

/* The comparison of a run; tests: (RUN) receives those of the pairs. */
static nqm_comparison comparison_of(const nqm_gradients *g, const nqm_sample_pair *pairs, size_t begin, size_t end,
                                    const float **tests) {
    for (size_t i = begin; i < end; ++i)
        tests[i - begin] = pairs[i].test;
    return (nqm_comparison){.directions = g->model->directions,
                            .ref = pairs[begin].ref,
                            .n = end - begin,
                            .test = tests,
                            .used = pairs[begin].used,
                            .estimate = g->transport.light ? &g->estimate[begin] : NULL};
}

static void compose_scalars(const nqm_gradients *g, const nqm_sample_pair *pairs, size_t begin, size_t end) {
    const float *tests[RUN];
    const nqm_comparison c = comparison_of(g, pairs, begin, end, tests);
    nqm_compare_sums(&c, true, &g->sums[begin]);
    nqm_compare_finish(&c, &g->sums[begin], NULL, g->scalars + begin * NQM_SCALAR_COUNT);
    for (size_t i = begin; i < end; ++i)
        nqm_scalars_whiten(&g->model->scalars, g->scalars + i * NQM_SCALAR_COUNT,
                           g->x + i * g->stride + g->samples_width);
}

/* Compute the inputs of the pairs of a run. */
static void compose(void *user, size_t k) {
    const run *r = user;
    const nqm_gradients *g = r->g;
    const nqm_model *m = g->model;
    const size_t begin = g->runs[k], end = g->runs[k + 1], n_directions = m->directions->n, n = 3 * n_directions;
    float *ref_t = g->t + 2 * begin * n;
    if (g->transport.light)
        estimate(g, r->pairs, begin, end);
    if (!g->net)
        return;
    nqm_features_transform(n, r->pairs[begin].ref, ref_t);
    for (size_t i = begin; i < end; ++i) {
        float *test_t = g->t + (2 * i + 1) * n;
        nqm_features_transform(n, r->pairs[i].test, test_t);
        nqm_features_compose(&m->features, n_directions, ref_t, test_t, r->pairs[i].used, g->x + i * g->stride);
    }
    if (nqm_model_n_scalars(m) > 0)
        compose_scalars(g, r->pairs, begin, end);
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

/* Add the gradients through the scalar features of a run, and set those by the estimates. */
static void add_scalars_gradient(const nqm_gradients *g, const nqm_sample_pair *pairs, size_t begin, size_t end) {
    const size_t n = 3 * g->model->directions->n;
    const float *tests[RUN];
    double by_scalars[RUN * NQM_SCALAR_COUNT];
    for (size_t i = begin; i < end; ++i)
        nqm_scalars_whiten_back(&g->model->scalars, g->scalars + i * NQM_SCALAR_COUNT,
                                g->dx + i * g->stride + g->samples_width, by_scalars + (i - begin) * NQM_SCALAR_COUNT);
    const nqm_comparison c = comparison_of(g, pairs, begin, end, tests);
    nqm_compare_gradient(&c, &g->sums[begin], NULL, by_scalars, g->summand + begin * n);
    for (size_t k = begin * n; k < end * n; ++k)
        g->sum[k] += g->summand[k];
    for (size_t i = begin; g->transport.light && i < end; ++i)
        nqm_estimate_gradient(&g->estimate[i], by_scalars + (i - begin) * NQM_SCALAR_COUNT + NQM_SCALAR_ESTIMATE,
                              &g->by_estimate[i]);
}

/* Add the gradient of pair i through the estimate; begin: first pair of its run. */
static void add_estimate_gradient(const nqm_gradients *g, const nqm_sample_pair *pair, size_t begin, size_t i) {
    const size_t n = 3 * g->model->directions->n;
    double *sum = g->sum + i * n, *summand = g->summand + i * n;
    nqm_transport_gradient(&g->transport, &g->by_estimate[i], picture_of(g, g->seen, begin, false),
                           picture_of(g, g->seen, i, true), picture_of(g, g->rgb, i, true), pair->used,
                           g->scratch + i * 3 * g->transport.n_points, summand);
    for (size_t k = 0; k < n; ++k)
        sum[k] += summand[k];
}

/* The gradients of a run by f_r, from those by the network's inputs and by the estimates. */
static void differentiate(void *user, size_t run_of_pairs) {
    const run *r = user;
    const nqm_gradients *g = r->g;
    const nqm_model *m = g->model;
    const size_t begin = g->runs[run_of_pairs], end = g->runs[run_of_pairs + 1], n = 3 * m->directions->n;
    memset(g->sum + begin * n, 0, (end - begin) * n * sizeof *g->sum);
    for (size_t i = begin; g->net && i < end; ++i)
        nqm_features_gradient(&m->features, m->directions->n, r->pairs[i].test, r->pairs[i].used, g->x + i * g->stride,
                              g->dx + i * g->stride, g->sum + i * n);
    if (g->net && nqm_model_n_scalars(m) > 0)
        add_scalars_gradient(g, r->pairs, begin, end);
    for (size_t i = begin; i < end; ++i) {
        if (is_bounded(r, i, r->out + i * n))
            continue;
        if (g->transport.light)
            add_estimate_gradient(g, &r->pairs[i], begin, i);
        for (size_t k = 0; k < n; ++k)
            r->out[i * n + k] = (float)g->sum[i * n + k];
    }
}

/* ---- entry ------------------------------------------------------------------------------------------------------- */

void nqm_gradients_run(nqm_gradients *g, nqm_score_quantity of, size_t n, const nqm_sample_pair *pairs, double *values,
                       float *out) {
    run r = {g, of, pairs, values, out};
    const size_t n_runs = find_runs(g, n, pairs);
    nqm_parallel_for(n_runs, compose, &r);
    if (g->net)
        nqm_gradient_forward(g->work, n, g->x, g->z);
    for (size_t i = 0; i < n; ++i)
        conclude(&r, i);
    if (g->net)
        nqm_gradient_backward(g->work, n, g->dz, g->dx);
    nqm_parallel_for(n_runs, differentiate, &r);
}
