/* SPDX-License-Identifier: MIT
 *
 * plot.h - from cd/m2 and Delta-E to pictures for people: tone mapping, a colour map, lettering, figures. The public half
 * is declared in <nqm/picture.h>.
 */
#ifndef NQM_SRC_PLOT_H
#define NQM_SRC_PLOT_H

#include "base/base.h"

#include "figures/picture.h"

/** cairo's version, "1.16.0"; NULL: this build has none, and draws neither figures nor sheets. */
const char *nqm_cairo_version(void);

/** Whether a file's name ends so, any case, and is not just that. */
bool nqm_name_ends_in(const char *path, const char *suffix);

/** What a display shows of a value in cd/m2: 0 to 1 of its white, linear in light. */
double nqm_tone_apply(const nqm_tone *tone, double value_cdm2);
/** Linear light in [0, 1] to a byte of sRGB (IEC 61966-2-1). */
unsigned char nqm_srgb_byte(double linear);
/** The inverse of the curve: sRGB in [0, 1] to linear light. */
double nqm_srgb_linear(double coded);

/** Tone-map a picture and average blocks of supersample x supersample pixels: rgb (height/supersample,
 *  width/supersample, 3) bytes of sRGB. */
void nqm_picture_bytes(const nqm_picture *picture, size_t supersample, const nqm_tone *tone, unsigned char *rgb);
/** The same for a map: colours from 0 to delta_e_max, NaN is white. */
void nqm_map_bytes(size_t width, size_t height, const double *delta_e, size_t supersample, double delta_e_max,
                   unsigned char *rgb);

/** The colour map at t in [0, 1]: linear light (3). */
void nqm_viridis(double t, double *rgb);

/** Where the ticks of a scale from 0 to `max` stand: multiples of 1, 2 or 5 times a power of ten, at most n_most
 *  steps. */
double nqm_tick_step(double max, size_t n_most);

#endif
