/* SPDX-License-Identifier: MIT
 *
 * Scores of sampled pairs with their gradients by the samples of the test: forward through inputs, estimate and network, then
 * back through each of them. Pairs are processed in the tasks of compose.h.
 */
#include "metric/compose.h"
#include "net/input_gradient.h"
#include "sample/loops.h"

#include <string.h>

struct nqm_gradients {
    const nqm_model *model;
    nqm_transport transport; /* of the model; `light` NULL: none */
    nqm_composer *inputs;
    nqm_gradient_net *net; /* NULL: the model has no network */
    size_t n_outputs;
    float *dx;              /* (max_batch, stride) gradient by the network's inputs */
    float *z, *dz;          /* (max_batch, n_outputs) */
    bool *is_bounded;       /* (max_batch) the bound on Delta-E is the value */
    nqm_label *by_estimate; /* (max_batch) gradient by the estimate */
    nqm_shown_pair *shown;  /* (max_batch) */
    double *pictures;       /* (max_batch, 3, 3, n_points) of `shown` */
    float *by_light;        /* (max_batch, 3, n_points) gradient by the light of the test */
};

nqm_status nqm_gradients_create(const nqm_model *model, size_t max_batch, nqm_gradients **gradients_ret,
                                nqm_error *err) {
    *gradients_ret = NULL;
    const nqm_transport transport = nqm_model_transport(model);
    nqm_composer *inputs;
    nqm_status status = nqm_composer_create(model, max_batch, &inputs, err);
    if (status != NQM_OK)
        return status;
    const bool has_network = nqm_model_has_network(model);
    const size_t n_picture = 3 * transport.points.n, n_outputs = nqm_model_n_outputs(model);
    nqm_gradients *g, made = {.model = model, .transport = transport, .inputs = inputs, .n_outputs = n_outputs};
    status = nqm_alloc_arrays(
        NQM_ARRAYS({&g, 1, sizeof *g}, {&made.dx, has_network ? max_batch : 0, inputs->stride * sizeof *made.dx},
                   {&made.z, max_batch, n_outputs * sizeof *made.z}, {&made.dz, max_batch, n_outputs * sizeof *made.dz},
                   {&made.is_bounded, max_batch, sizeof *made.is_bounded},
                   {&made.by_estimate, max_batch, sizeof *made.by_estimate},
                   {&made.shown, max_batch, sizeof *made.shown},
                   {&made.pictures, max_batch, 3 * n_picture * sizeof *made.pictures},
                   {&made.by_light, max_batch, n_picture * sizeof *made.by_light}),
        err);
    if (status != NQM_OK) {
        nqm_composer_free(inputs);
        return status;
    }
    *g = made;
    if (has_network)
        status = nqm_gradient_net_create(&model->params, 3 * model->directions->n, max_batch, &g->net, err);
    if (status == NQM_OK)
        *gradients_ret = g;
    else
        nqm_gradients_free(g);
    return status;
}

void nqm_gradients_free(nqm_gradients *g) {
    if (!g)
        return;
    nqm_gradient_net_free(g->net);
    nqm_composer_free(g->inputs);
    nqm_free(g);
}

/* ---- forward ----------------------------------------------------------------------------------------------------- */

typedef struct gradient_job {
    nqm_gradients *g;
    nqm_score_quantity of;
    const nqm_sample_pair *pairs;
    size_t n, n_at_once; /* pairs, and those per task */
    double *values;
    float *out;
} gradient_job;

/* Estimate pairs [first, first + n), and keep their pictures. */
static void estimate(const gradient_job *job, size_t first, size_t n) {
    nqm_gradients *g = job->g;
    const size_t n_picture = 3 * g->transport.points.n;
    for (size_t i = first; i < first + n; ++i) {
        double *own = g->pictures + i * 3 * n_picture;
        const bool is_shared = i > first && job->pairs[i].ref == job->pairs[i - 1].ref;
        g->shown[i] = (nqm_shown_pair){is_shared ? g->shown[i - 1].ref : own, own + n_picture, own + 2 * n_picture};
    }
    nqm_transport_see(&g->transport, n, job->pairs + first, g->shown + first);
    for (size_t i = first; i < first + n; ++i)
        g->inputs->estimate[i] = nqm_picture_label(&g->transport.points, g->shown[i].ref, g->shown[i].test);
}

static void compose(void *user, size_t task) {
    const gradient_job *job = user;
    const nqm_gradients *g = job->g;
    const size_t first = task * job->n_at_once, n = nqm_smaller(job->n_at_once, job->n - first);
    if (g->transport.light)
        estimate(job, first, n);
    nqm_compose_samples(g->inputs, task, first, n, job->pairs + first, false);
    nqm_compose_scalars(g->inputs, first, n, NULL);
}

/* Value of pair i, and the gradients by the network's output and by the estimate: 0 if the bound on Delta-E is the value. */
static void conclude(const gradient_job *job, size_t i) {
    const nqm_gradients *g = job->g;
    const nqm_model *m = g->model;
    const nqm_label *estimated = g->transport.light ? &g->inputs->estimate[i] : NULL;
    const double z = (double)g->z[i * g->n_outputs];
    double delta_e, by_z = 0, jod = nqm_model_jod(m, z, estimated, &delta_e);
    g->by_estimate[i] = (nqm_label){.delta_e = 0};
    g->is_bounded[i] = nqm_bound_score(m, g->inputs->bound[i], &jod, &delta_e);
    if (!g->is_bounded[i])
        nqm_model_slopes(m, z, estimated, job->of == NQM_SCORE_JOD, &by_z, &g->by_estimate[i].delta_e);
    g->dz[i * g->n_outputs] = (float)by_z;
    job->values[i] = job->of == NQM_SCORE_JOD ? jod : delta_e;
}

/* ---- back -------------------------------------------------------------------------------------------------------- */

/* Add the gradient of pair i through the scalar features to `out`, and set that by the estimate. */
static void add_scalars_gradient(const gradient_job *job, size_t i, const float *ref_root, const float *test_root,
                                 float *out) {
    const nqm_gradients *g = job->g;
    const nqm_composer *c = g->inputs;
    double by_scalars[NQM_SCALAR_COUNT];
    nqm_scalars_whiten_back(&g->model->scalars, c->scalars + i * NQM_SCALAR_COUNT,
                            g->dx + i * c->stride + c->samples_width, by_scalars);
    nqm_compare_gradient(&(nqm_compared_pair){c->plan, job->pairs[i], ref_root, test_root, &c->sums[i]}, by_scalars,
                         out);
    if (g->transport.light)
        nqm_estimate_gradient(&c->estimate[i], by_scalars + NQM_SCALAR_ESTIMATE, &g->by_estimate[i]);
}

/* Set the gradient of pair i through the network's inputs. root: (2, n_directions, 3) cube roots, of which the first is that of the
 * reference; scratch: (n_directions, 3). */
static void differentiate_inputs(const gradient_job *job, size_t i, float *root, float *scratch, float *out) {
    const nqm_gradients *g = job->g;
    const nqm_composer *c = g->inputs;
    const size_t n_directions = g->model->directions->n, n = 3 * n_directions;
    const nqm_sample_pair *p = &job->pairs[i];
    nqm_sample_logs(n, p->test, root + n, scratch);
    nqm_features_gradient(&g->model->features, n_directions, root + n, p->used, c->x + i * c->stride,
                          g->dx + i * c->stride, out);
    if (g->model->scalars.n > 0)
        add_scalars_gradient(job, i, root, root + n, out);
}

/* Where the bound decided: its gradient. */
static void set_bound_gradient(const gradient_job *job, size_t i, float *out) {
    const nqm_model *m = job->g->model;
    const size_t n = m->directions->n;
    size_t at;
    const double slope = nqm_delta_e_bound_slope(n, &job->pairs[i], &at);
    memset(out, 0, 3 * n * sizeof *out);
    out[at] = (float)(job->of == NQM_SCORE_JOD ? slope * nqm_curve_slope(&m->curve, job->g->inputs->bound[i]) : slope);
}

/* Add the gradients of pairs [first, first + n) through the estimates. */
static void add_estimate_gradients(const gradient_job *job, size_t first, size_t n) {
    const nqm_gradients *g = job->g;
    const size_t n_picture = 3 * g->transport.points.n;
    double by_light[3 * NQM_TRANSPORT_MAX_POINTS];
    for (size_t i = first; i < first + n; ++i) {
        nqm_picture_light_gradient(&g->transport.points, &g->by_estimate[i], &g->shown[i], by_light);
        for (size_t k = 0; k < n_picture; ++k)
            g->by_light[i * n_picture + k] = (float)by_light[k];
    }
    nqm_transport_gradient(&g->transport, n, job->pairs + first, g->by_light + first * n_picture,
                           job->out + first * 3 * g->model->directions->n);
}

/* The gradients of a task's pairs by f_r, from those by the network's inputs and by the estimates. */
static void differentiate(void *user, size_t task) {
    const gradient_job *job = user;
    const nqm_gradients *g = job->g;
    const size_t first = task * job->n_at_once, end = nqm_smaller(first + job->n_at_once, job->n);
    const size_t n = 3 * g->model->directions->n;
    float *root = nqm_composer_root(g->inputs, task), *scratch = root + 2 * n;
    memset(job->out + first * n, 0, (end - first) * n * sizeof *job->out);
    for (size_t i = first; g->net && i < end; ++i) {
        if (i == first || job->pairs[i].ref != job->pairs[i - 1].ref)
            nqm_sample_logs(n, job->pairs[i].ref, root, scratch);
        differentiate_inputs(job, i, root, scratch, job->out + i * n);
    }
    if (g->transport.light)
        add_estimate_gradients(job, first, end - first);
    for (size_t i = first; i < end; ++i)
        if (g->is_bounded[i])
            set_bound_gradient(job, i, job->out + i * n);
}

void nqm_gradients_run(nqm_gradients *g, nqm_score_quantity of, size_t n, const nqm_sample_pair *pairs, double *values,
                       float *out) {
    gradient_job job = {g, of, pairs, n, nqm_composer_task(g->inputs, n), values, out};
    const size_t n_tasks = nqm_ceil_div(n, job.n_at_once);
    nqm_parallel_for(n_tasks, compose, &job);
    if (g->net)
        nqm_gradient_forward(g->net, n, g->inputs->x, g->z);
    for (size_t i = 0; i < n; ++i)
        conclude(&job, i);
    if (g->net)
        nqm_gradient_backward(g->net, n, g->dz, g->dx);
    nqm_parallel_for(n_tasks, differentiate, &job);
}
