/* SPDX-License-Identifier: MIT
 *
 * The learning-rate schedule: torch.optim.lr_scheduler.ReduceLROnPlateau with its defaults mode min, relative threshold
 * 1e-4 and cooldown 0.
 */
#include "math/math.h"
#include "net/net.h"

#include <math.h>

double nqm_plateau_step(nqm_plateau *plateau, double loss) {
    if (loss < plateau->best * (1.0 - 1e-4)) {
        plateau->best = loss;
        plateau->bad_epochs = 0;
        return 1.0;
    }
    if (++plateau->bad_epochs <= plateau->patience)
        return 1.0;
    plateau->bad_epochs = 0;
    return plateau->factor;
}

double nqm_plateau_rate(double lr, double factor) {
    double reduced = lr * factor;
    return lr - reduced > 1e-8 ? reduced : lr;
}

double nqm_cosine_factor(size_t done, size_t all) {
    return 0.5 * (1 + cos(NQM_PI * (double)done / (double)all));
}
