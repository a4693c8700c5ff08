/* SPDX-License-Identifier: MIT
 *
 * Novelty of a pair: the distance between its scalar features and the nearest of a set of training pairs in the model
 * file, which train/novelty_fit.c selects to cover all training pairs. The features are decorrelated first: many of
 * them are strongly correlated over the training distortions, and a pair that breaks these correlations has a new kind
 * of distortion.
 */
#include "model/model.h"

#include <math.h>
#include <string.h>

/* Vectors of four floats: all supported processors have registers of this size. */
enum { LANES = 4, N_VECTORS = 4 };
_Static_assert(LANES *N_VECTORS == NQM_NOVELTY_BLOCK, "a block is four times four");
typedef float lanes __attribute__((vector_size(LANES * sizeof(float)), aligned(4), may_alias));

/* Squared distances between y (NQM_SCALAR_COUNT) and a block of NQM_NOVELTY_BLOCK points. */
static void square_distances(const float *points, const float *y, lanes square[N_VECTORS]) {
    lanes s0 = {0}, s1 = {0}, s2 = {0}, s3 = {0}; /* separate variables, so that they stay in registers */
    for (size_t k = 0; k < NQM_SCALAR_COUNT; ++k) {
        const lanes *p = (const lanes *)(points + k * NQM_NOVELTY_BLOCK);
        const lanes d0 = p[0] - y[k], d1 = p[1] - y[k], d2 = p[2] - y[k], d3 = p[3] - y[k];
        s0 += d0 * d0, s1 += d1 * d1, s2 += d2 * d2, s3 += d3 * d3;
    }
    square[0] = s0, square[1] = s1, square[2] = s2, square[3] = s3;
}

void nqm_novelty_features(const nqm_model *model, const double *scalars, float *y) {
    nqm_scalar_whitening whitening = model->scalars;
    whitening.scale = 1;
    float x[NQM_SCALAR_COUNT];
    nqm_scalars_whiten(&whitening, scalars, x);
    memset(y, 0, sizeof x);
    for (size_t k = 0; k < NQM_SCALAR_COUNT; ++k)
        for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
            y[i] += x[k] * model->novelty_map[k * NQM_SCALAR_COUNT + i];
}

double nqm_model_novelty(const nqm_model *model, const double *scalars) {
    float y[NQM_SCALAR_COUNT], nearest[LANES] = {INFINITY, INFINITY, INFINITY, INFINITY};
    if (model->n_novelty == 0)
        return NAN;
    nqm_novelty_features(model, scalars, y);
    for (size_t b = 0; b < model->n_novelty; ++b) {
        lanes square[N_VECTORS];
        square_distances(model->novelty_points + b * NQM_SCALAR_COUNT * NQM_NOVELTY_BLOCK, y, square);
        for (size_t i = 0; i < NQM_NOVELTY_BLOCK; ++i) {
            float d = square[i / LANES][i % LANES];
            nearest[i % LANES] = d < nearest[i % LANES] ? d : nearest[i % LANES];
        }
    }
    float least = fminf(fminf(nearest[0], nearest[1]), fminf(nearest[2], nearest[3]));
    return sqrt((double)least) / model->novelty_unit;
}
