/* SPDX-License-Identifier: MIT
 *
 * picture.h - rendered pictures and maps of colour differences to files: tone mapping, a colour map, OpenEXR, Radiance HDR,
 * PNG, and grids of pictures and maps. Arrays are borrowed.
 */
#ifndef NQM_FIGURES_PICTURE_H
#define NQM_FIGURES_PICTURE_H

#include "base/base.h"

/** A picture in linear RGB, or a map of colour differences. */
typedef struct nqm_picture {
    size_t width, height; /**< pixels, 1 to 8192 x 4096 */
    const double
        *rgb_cdm2; /**< (height, width, 3), top row first; finite; cd/m2, where (1, 1, 1) is a white of 1 cd/m2 */
    const double *delta_e; /**< (height, width) Delta-E ITP, drawn where rgb_cdm2 is NULL: viridis, white for NaN */
    double delta_e_max;    /**< upper end of the colours of delta_e, > 0 */
} nqm_picture;

/**
 * Tone curve from cd/m2 to the 8-bit sRGB (IEC 61966-2-1) of a PNG. With x = value / white_cdm2, channel by channel: x up to
 * the shoulder s, and s + (1 - s)(1 - exp(-(x - s)/(1 - s))) above it, so that highlights approach white smoothly.
 */
typedef struct nqm_tone {
    double white_cdm2; /**< cd/m2, > 0; default 400: a white Lambert surface of the default scene has half of it */
    double shoulder;   /**< s in (0, 1]; 1 clips; default 0.6 */
} nqm_tone;

/** The defaults above. */
nqm_tone nqm_tone_default(void);
/** The tone curve: cd/m2 to linear light in [0, 1]. */
double nqm_tone_apply(const nqm_tone *tone, double value_cdm2);
/** Linear light in [0, 1] to a byte of sRGB. */
unsigned char nqm_srgb_byte(double linear);
/** sRGB in [0, 1] to linear light. */
double nqm_srgb_linear(double coded);
/** The colour map viridis at t in [0, 1]: linear light (3). */
void nqm_viridis(double t, double *rgb);

/**
 * Write a picture in the format of the file name: ".exr" (OpenEXR, float) and ".hdr" (Radiance RGBE, 1 % precision)
 * contain cd/m2, ".png" is tone-mapped; a map can be written as ".png" only. Blocks of `supersample` x `supersample`
 * pixels are averaged: in cd/m2 or, for PNG, after tone mapping, so that edges of highlights are smooth.
 *
 * @param supersample  1 to 16; divides width and height
 * @param tone         for PNG; NULL: the default
 * @return NQM_ERR_ARG (file name, sizes), NQM_ERR_IO
 */
NQM_MUST_CHECK nqm_status nqm_picture_write(const char *path, const nqm_picture *picture, size_t supersample,
                                            const nqm_tone *tone, nqm_error *err);

/** Upper end of a colour scale for n_maps maps of n differences each (NaN: no value): their 99th percentile, rounded up to a
 *  multiple of 1, 2 or 5 times a power of ten; at least 1. */
NQM_MUST_CHECK nqm_status nqm_map_scale(size_t n_maps, const double *const *delta_e, size_t n, double *end_ret,
                                        nqm_error *err);

/** A cell of a figure: a picture, a map of differences, or empty. */
typedef struct nqm_panel {
    const double *rgb_cdm2; /**< (height, width, 3), as in nqm_picture; NULL: no picture */
    const double *delta_e;  /**< (height, width) Delta-E ITP, NaN: no value; drawn where rgb_cdm2 is NULL */
} nqm_panel;

/** A grid of panels of one size and, if there are maps, a bar with the colours from 0 (below) to delta_e_max. */
typedef struct nqm_figure {
    size_t n_rows, n_columns; /**< 1 to 64 each */
    size_t width, height;     /**< size of each panel's data, pixels */
    size_t supersample;       /**< blocks of so many pixels each way become one; 0: 1 */
    const nqm_panel *panels;  /**< (n_rows, n_columns) */
    double delta_e_max;       /**< upper end of the colours of all maps: nqm_map_scale() */
    nqm_tone tone;            /**< tone curve of the pictures; zeroed: the default */
} nqm_figure;

/**
 * Draw a figure as PNG on white: pictures tone-mapped, maps in viridis, which colour-blind readers and grey prints keep
 * apart.
 *
 * @return NQM_ERR_ARG (sizes), NQM_ERR_LIMIT (more than 16384 pixels a side), NQM_ERR_IO, NQM_ERR_NOMEM
 */
NQM_MUST_CHECK nqm_status nqm_figure_write(const char *path, const nqm_figure *figure, nqm_error *err);

#endif
