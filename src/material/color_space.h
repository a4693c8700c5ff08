/* SPDX-License-Identifier: MIT
 *
 * color_space.h - colours of files to linear BT.709.
 */
#ifndef NQM_SRC_MATERIAL_COLOR_SPACE_H
#define NQM_SRC_MATERIAL_COLOR_SPACE_H

#include "base/base.h"

/** Convert rgb (3) from the colour space of this name (those of MaterialX; NULL, "" and "none": no conversion). false: no such
 *  space. Values may leave 0 to 1 where the space is larger than BT.709. */
bool nqm_color_to_rec709(const char *space, double *rgb);
/** The component with sRGB's curve to linear (IEC 61966-2-1). */
double nqm_srgb_to_linear(double v);
/** The inverse. */
double nqm_linear_to_srgb(double v);

#endif
