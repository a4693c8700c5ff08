/* SPDX-License-Identifier: MIT
 *
 * Novelty of a pair: the distance between its scalar features and the nearest of a set of training pairs in the model
 * file, which train/novelty_fit.c selects to cover all training pairs. The features are decorrelated first: many of
 * them are strongly correlated over the training distortions, and a pair that breaks these correlations has a new kind
 * of distortion.
 */
#include "model/model.h"
#include "sample/loops.h"

#include <math.h>
#include <string.h>

_Static_assert((int)NQM_NOVELTY_BLOCK == (int)NQM_POINTS, "model files have the blocks of the loop");

void nqm_novelty_features(const nqm_model *model, const double *scalars, float *y) {
    nqm_scalar_whitening whitening = model->scalars;
    whitening.scale = 1;
    float x[NQM_SCALAR_COUNT];
    const size_t n = whitening.n;
    nqm_scalars_whiten(&whitening, scalars, x);
    memset(y, 0, n * sizeof *y);
    for (size_t k = 0; k < n; ++k)
        for (size_t i = 0; i < n; ++i)
            y[i] += x[k] * model->novelty_map[k * n + i];
}

double nqm_model_novelty(const nqm_model *model, const double *scalars) {
    float y[NQM_SCALAR_COUNT];
    if (model->n_novelty == 0)
        return NAN;
    nqm_novelty_features(model, scalars, y);
    const float square = nqm_sample_nearest(model->scalars.n, model->n_novelty, model->novelty_points, y);
    return sqrt((double)square) / model->novelty_unit;
}
