/* SPDX-License-Identifier: MIT
 *
 * Predictions of a model: its network, packed at the first use, and the conversion of the network's output to JOD.
 */
#include "base/os.h"
#include "model/model.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

/* About as many units of asinh for a contrast as for a shift that looks as large (label.c mentions 0.03 and 1). */
static const double contrast_unit = 30;

void nqm_parts_to_targets(const double parts[NQM_LABEL_PARTS], double min_structure, double targets[NQM_LABEL_PARTS]) {
    for (size_t k = 0; k < 3; ++k)
        targets[k] = asinh(parts[k]);
    targets[3] = asinh(contrast_unit * parts[3]);
    targets[4] = log(fmax(parts[4], min_structure));
}

static void parts_from_targets(const double targets[NQM_LABEL_PARTS], double parts[NQM_LABEL_PARTS]) {
    for (size_t k = 0; k < 3; ++k)
        parts[k] = sinh(targets[k]);
    parts[3] = sinh(targets[3]) / contrast_unit;
    parts[4] = exp(targets[4]);
}

static double target_of(const nqm_output_range *o, double z) {
    return o->mean + o->std * (o->lo + (o->hi - o->lo) * nqm_sigmoid(z));
}

/* Whether the fractions of the points of every scene sum to 1, scenes are numbered from 0, and displays have a peak. */
const char *nqm_transport_points_fault(const nqm_picture_points *points) {
    double scene = 0, sum = 0;
    for (const double *p = points->at; p < points->at + 3 * points->n; p += 3) {
        const bool is_next = p > points->at && p[1] == scene + 1;
        if (!(p[0] >= 0 && p[0] <= 1))
            return "tensor 'transport.points' has a fraction outside 0 to 1";
        if (!is_next && p[1] != scene)
            return "tensor 'transport.points' does not number its scenes 0, 1, ... in ascending order";
        if (!(p[2] > 0 && isfinite(p[2])))
            return "tensor 'transport.points' has a peak luminance that is not positive and finite";
        if (is_next && fabs(sum - 1) > 1e-6)
            break;
        sum = (is_next ? 0 : sum) + p[0];
        scene = p[1];
    }
    return fabs(sum - 1) > 1e-6 ? "tensor 'transport.points' has fractions of a scene that do not sum to 1" : NULL;
}

const char *nqm_transport_fault(const nqm_transport *t, bool verify) {
    if (!t->light && !t->points.at)
        return NULL;
    if (!t->light || !t->points.at)
        return "tensors 'transport' and 'transport.points' need each other";
    if (t->points.n % NQM_TRANSPORT_STEP || t->points.n > NQM_TRANSPORT_MAX_POINTS)
        return "tensor 'transport.points' has a number of points that is no multiple of 32 up to 4096";
    for (size_t i = 0; verify && i < t->n_directions * 3 * t->points.n; ++i)
        if (!isfinite(t->light[i]))
            return "tensor 'transport' has a value that is not finite";
    return nqm_transport_points_fault(&t->points);
}

static const double least = 0.05; /* Delta-E: nobody sees less */

void nqm_estimate_targets(const nqm_label *estimate, double targets[1 + NQM_LABEL_PARTS]) {
    double parts[NQM_LABEL_PARTS];
    memset(targets, 0, (1 + NQM_LABEL_PARTS) * sizeof *targets);
    if (!estimate)
        return;
    nqm_label_get_parts(estimate, parts);
    targets[0] = log(fmax(estimate->delta_e, least));
    nqm_parts_to_targets(parts, least, targets + 1);
}

nqm_label nqm_model_label(const struct nqm_model *model, const float *z, const nqm_label *estimate) {
    double targets[1 + NQM_LABEL_PARTS], parts[NQM_LABEL_PARTS];
    nqm_label label = {.delta_e = 0};
    nqm_estimate_targets(estimate, targets);
    for (size_t k = 0; k < NQM_LABEL_PARTS; ++k)
        targets[1 + k] += target_of(&model->parts[k], (double)z[1 + k]);
    parts_from_targets(targets + 1, parts);
    nqm_label_set_parts(&label, parts);
    (void)nqm_model_jod(model, (double)z[0], estimate, &label.delta_e);
    return label;
}

double nqm_model_jod(const struct nqm_model *model, double z, const nqm_label *estimate, double *delta_e_ret) {
    double base[1 + NQM_LABEL_PARTS];
    nqm_estimate_targets(estimate, base);
    double target = base[0] + target_of(&model->output, z);
    double delta_e = model->target == NQM_TARGET_LOG_DELTA_E ? exp(target) : (double)NAN;
    if (delta_e_ret)
        *delta_e_ret = delta_e;
    return model->target == NQM_TARGET_LOG_DELTA_E ? nqm_curve_jod(&model->curve, delta_e) : target;
}

void nqm_model_slopes(const struct nqm_model *model, double z, const nqm_label *estimate, bool of_jod, double *by_z,
                      double *by_delta_e) {
    const nqm_output_range *o = &model->output;
    const double s = nqm_sigmoid(z);
    double delta_e, by_target = 1;
    (void)nqm_model_jod(model, z, estimate, &delta_e);
    if (model->target == NQM_TARGET_LOG_DELTA_E)
        by_target = delta_e * (of_jod ? nqm_curve_slope(&model->curve, delta_e) : 1);
    *by_z = by_target * o->std * (o->hi - o->lo) * s * (1 - s);
    *by_delta_e = estimate && estimate->delta_e > least ? by_target / estimate->delta_e : 0;
}

void nqm_estimate_gradient(const nqm_label *estimate, const double *weights, nqm_label *gradient) {
    const double contrast = contrast_unit * estimate->contrast;
    gradient->delta_e += estimate->delta_e > least ? weights[0] / estimate->delta_e : 0;
    for (int k = 0; k < 3; ++k)
        gradient->shift[k] += weights[1 + k] / sqrt(1 + estimate->shift[k] * estimate->shift[k]);
    gradient->contrast += weights[4] * contrast_unit / sqrt(1 + contrast * contrast);
    gradient->structure += estimate->structure > least ? weights[5] / estimate->structure : 0;
}

static pthread_mutex_t inference_lock =
    PTHREAD_MUTEX_INITIALIZER; /* locked while the network of any model is created */

nqm_status nqm_model_inference(const struct nqm_model *model, const nqm_inference_net **net_ret, nqm_error *err) {
    nqm_inference_net *_Atomic *place = &((struct nqm_model *)(uintptr_t)model)->inference;
    nqm_inference_net *net = atomic_load_explicit(place, memory_order_acquire);
    nqm_status status = NQM_OK;
    if (!net) {
        pthread_mutex_lock(&inference_lock);
        net = atomic_load_explicit(place, memory_order_acquire);
        if (!net) { /* no other thread created it in the meantime */
            status = nqm_inference_net_create(&model->params, 3 * model->directions->n, &net, err);
            atomic_store_explicit(place, net, memory_order_release);
        }
        pthread_mutex_unlock(&inference_lock);
    }
    *net_ret = net;
    return status;
}
