/* SPDX-License-Identifier: MIT
 *
 * Classifies a reference material from its samples: gloss is the ratio of the luminance near the mirror direction to
 * that far from it, and colour is the deviation of the channels far from it. Evaluations report results per class; the
 * class is not used in training.
 */
#include "data/data.h"
#include "math/math.h"
#include "math/values.h"

#include <math.h>

static const char *const class_names[NQM_MATERIAL_CLASS_COUNT] = {
    "matte grey",      "matte coloured",   "satin grey",           "satin coloured", "glossy grey",
    "glossy coloured", "mirror-like grey", "mirror-like coloured", "unclassified"};
enum { UNCLASSIFIED = NQM_MATERIAL_CLASS_COUNT - 1 };

const char *nqm_material_class_name(size_t i) {
    return i < NQM_MATERIAL_CLASS_COUNT ? class_names[i] : NULL;
}

/* Degrees: theta_h below near_theta_h is the specular lobe, from far_theta_h on the body. Directions from most_theta_d
 * on are ignored, because Fresnel reflection dominates there. */
static const double near_theta_h = 3, far_theta_h = 25, most_theta_d = 60;
static const double gloss_edges[3] = {3, 20, 200}; /* ratio of luminance near to far: satin, glossy, mirror-like */
static const double colour_edge = 0.4;             /* largest |log of a channel - mean log of the three channels| */

size_t nqm_dataset_ref_class(const nqm_dataset *d, size_t ref) {
    double near = 0, far = 0, n_near = 0, n_far = 0, body[3] = {0};
    for (size_t i = 0; i < d->n_directions; ++i) {
        const double *degrees = d->directions_deg + 3 * i;
        const float *rgb = d->ref_rgb + 3 * (ref * d->n_directions + i);
        if ((d->ref_used && !d->ref_used[ref * d->n_directions + i]) || degrees[1] >= most_theta_d)
            continue;
        double f[3] = {(double)rgb[0], (double)rgb[1], (double)rgb[2]}, level = log(nqm_luminance(f) + NQM_DARK);
        if (degrees[0] < near_theta_h) {
            near += level;
            n_near += 1;
        } else if (degrees[0] >= far_theta_h) {
            far += level;
            n_far += 1;
            for (int k = 0; k < 3; ++k)
                body[k] += f[k];
        }
    }
    if (n_near == 0 || n_far == 0)
        return UNCLASSIFIED;
    double gloss = near / n_near - far / n_far, mean = 0, colour = 0;
    for (int k = 0; k < 3; ++k) {
        body[k] = log(body[k] / n_far + NQM_DARK);
        mean += body[k] / 3;
    }
    for (int k = 0; k < 3; ++k)
        colour = fmax(colour, fabs(body[k] - mean));
    size_t shine = 0;
    while (shine < 3 && gloss >= log(gloss_edges[shine]))
        ++shine;
    return 2 * shine + (colour > colour_edge);
}
