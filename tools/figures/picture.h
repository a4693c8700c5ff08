/* SPDX-License-Identifier: MIT
 *
 * nqm/picture.h - pictures to files: what a scene shows as OpenEXR, Radiance HDR or PNG, and figures that put pictures
 * and maps of their differences side by side. In libnqm-full only.
 */
#ifndef NQM_PICTURE_H
#define NQM_PICTURE_H

#include <nqm/base.h>

/** A linear RGB picture in cd/m2; lent by the caller. */
typedef struct nqm_picture {
    size_t width, height;   /**< pixels, 1 to 8192 x 4096 */
    const double *rgb_cdm2; /**< (height, width, 3), first row on top; finite, cd/m2 of each channel relative to a white
                                 of (1, 1, 1) that has 1 cd/m2 */
} nqm_picture;

/**
 * How cd/m2 become the 8-bit sRGB (IEC 61966-2-1) of a PNG. With x = value / white_cdm2, channel by channel: x up to the
 * shoulder s, and s + (1 - s)(1 - exp(-(x - s)/(1 - s))) above it, so that highlights bend towards white without an edge.
 */
typedef struct nqm_tone {
    double white_cdm2; /**< cd/m2, > 0; default 400: a white Lambert surface of the default scene shows at half of it */
    double shoulder;   /**< s in (0, 1]; 1 clips; default 0.6 */
} nqm_tone;

/** The defaults above. */
nqm_tone nqm_tone_default(void);

/**
 * Write a picture in the format that the name's end says: ".exr" (OpenEXR, float) and ".hdr" (Radiance RGBE, 1 %
 * precision) hold cd/m2, ".png" is tone-mapped. Every `supersample` x `supersample` pixels become one: the mean of cd/m2
 * or, for PNG, of what the display shows, so that edges of highlights are smooth.
 *
 * @param supersample  1 to 16; divides width and height
 * @param tone         for PNG; NULL: the default
 * @return NQM_ERR_ARG (another ending, sizes), NQM_ERR_IO
 */
NQM_MUST_CHECK nqm_status nqm_picture_write(const char *path, const nqm_picture *picture, size_t supersample,
                                            const nqm_tone *tone, nqm_error *err);

/**
 * The upper end of a scale for maps of differences: what 99 % of their values stay below, rounded up to a multiple of
 * 1, 2 or 5; at least 1.
 *
 * @param delta_e  (n_maps) maps of n values each; NaN: none
 */
NQM_MUST_CHECK nqm_status nqm_map_scale(size_t n_maps, const double *const *delta_e, size_t n, double *end_ret,
                                        nqm_error *err);

/**
 * Write a map of differences alone as PNG, in the colours of nqm_figure_write(), for those who draw the scale themselves.
 *
 * @param delta_e      (height, width) >= 0; NaN is white
 * @param delta_e_max  upper end of the scale, > 0; larger values have its colour
 * @return as nqm_picture_write(), whose limits hold; NQM_ERR_ARG unless the name ends in ".png"
 */
NQM_MUST_CHECK nqm_status nqm_map_write(const char *path, size_t width, size_t height, const double *delta_e,
                                        size_t supersample, double delta_e_max, nqm_error *err);

/** One place of a figure: a picture, or a map of differences, or nothing. All lent. */
typedef struct nqm_panel {
    const double *rgb_cdm2; /**< (height, width, 3), as in nqm_picture; NULL: no picture */
    const double *delta_e; /**< (height, width) Delta-E ITP, NaN where there is nothing; drawn where rgb_cdm2 is NULL */
    const char *caption;   /**< below the panel; UTF-8 (ASCII and a few more letters are drawn); NULL: none */
} nqm_panel;

/** A figure: a grid of panels of one size, with titles, and a scale where it holds maps. All lent. */
typedef struct nqm_figure {
    size_t n_rows, n_columns;         /**< 1 to 64 each */
    size_t width, height;             /**< of each panel's data, pixels */
    size_t supersample;               /**< so many pixels each way of the data become one of the figure; 0: 1 */
    const nqm_panel *panels;          /**< (n_rows, n_columns) */
    const char *const *row_titles;    /**< (n_rows), at the left; NULL or NULL entries: none */
    const char *const *column_titles; /**< (n_columns), on top; the same */
    double delta_e_max; /**< upper end of the scale; 0: what 99 % of the maps' pixels stay below, rounded up */
    nqm_tone tone;      /**< for the pictures; zeroed: the default */
} nqm_figure;

/**
 * Draw a figure as PNG on white: pictures tone-mapped, maps in the colours of viridis (dark is equal; brighter is more
 * different, also for colour-blind eyes and in grey). The same input gives the same bytes on one machine; fonts differ
 * between machines. Needs cairo (CMake option NQM_CAIRO).
 *
 * @return NQM_ERR_ARG (sizes, or a build without cairo), NQM_ERR_LIMIT (more than 16384 pixels a side), NQM_ERR_IO
 */
NQM_MUST_CHECK nqm_status nqm_figure_write(const char *path, const nqm_figure *figure, nqm_error *err);

#endif
