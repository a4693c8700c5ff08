/* SPDX-License-Identifier: MIT
 *
 * A light map: filtered to cells, looked up bilinearly, sampled cell by cell.
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>

void nqm_map_direction(double u, double v, double *w) {
    double theta = NQM_PI * v, phi = 2 * NQM_PI * (u - 0.5);
    w[0] = sin(theta) * sin(phi);
    w[1] = cos(theta);
    w[2] = -sin(theta) * cos(phi);
}

void nqm_light_direction(const nqm_light *light, size_t cell, double u, double v, double *w) {
    size_t y = cell / light->width, x = cell % light->width;
    double height = (double)light->height;
    double top = cos(NQM_PI * (double)y / height), bottom = cos(NQM_PI * (double)(y + 1) / height);
    nqm_map_direction(((double)x + u) / (double)light->width, acos(top + (bottom - top) * v) / NQM_PI, w);
}

size_t nqm_light_eval(const nqm_light *light, const double *w, double *rgb) {
    size_t width = light->width, height = light->height;
    double row = atan2(hypot(w[0], w[2]), w[1]) / NQM_PI * (double)height;
    double column = (atan2(w[0], -w[2]) / (2 * NQM_PI) + 0.5) * (double)width;
    double y = fmin(fmax(row - 0.5, 0), (double)(height - 1)), x = column - 0.5;
    x = x < 0 ? x + (double)width : x;
    size_t y0 = (size_t)y, x0 = (size_t)x % width, y1 = y0 + 1 < height ? y0 + 1 : y0, x1 = (x0 + 1) % width;
    double fy = y - (double)y0, fx = x - floor(x);
    const double *top = light->rgb + 3 * y0 * width, *bottom = light->rgb + 3 * y1 * width;
    for (size_t k = 0; k < 3; ++k)
        rgb[k] = (1 - fy) * ((1 - fx) * top[3 * x0 + k] + fx * top[3 * x1 + k]) +
                 fy * ((1 - fx) * bottom[3 * x0 + k] + fx * bottom[3 * x1 + k]);
    size_t cell_y = (size_t)row, cell_x = (size_t)column;
    return (cell_y < height ? cell_y : height - 1) * width + (cell_x < width ? cell_x : 0);
}

/* Add the pixels of one row of the picture that a cell covers. `band`: solid angle of the covered part of the row, in an
 * arbitrary unit. */
static void add_pixels(const nqm_image *image, size_t row, double x_begin, double x_end, double band, double *rgb,
                       double *total) {
    for (size_t i = (size_t)x_begin; i < image->width && (double)i < x_end; ++i) {
        double weight = band * (fmin((double)(i + 1), x_end) - fmax((double)i, x_begin));
        const float *pixel = image->rgb + 3 * (row * image->width + i);
        for (int k = 0; k < 3; ++k)
            rgb[k] += weight * (double)pixel[k];
        *total += weight;
    }
}

/* Mean over the pixels covered by each cell of row y, weighted by solid angle. Sums of weights are stored in `power`, which is
 * not set yet. */
static void filter_row(const nqm_image *image, nqm_light *light, size_t y) {
    double w = (double)image->width, h = (double)image->height;
    double y_begin = (double)y / (double)light->height * h, y_end = (double)(y + 1) / (double)light->height * h;
    double *rgb = light->rgb + 3 * y * light->width, *total = light->power + y * light->width;
    for (size_t j = (size_t)y_begin; j < image->height && (double)j < y_end; ++j) {
        double top = fmax((double)j, y_begin) / h, bottom = fmin((double)(j + 1), y_end) / h;
        double band = cos(NQM_PI * top) - cos(NQM_PI * bottom);
        for (size_t x = 0; x < light->width; ++x)
            add_pixels(image, j, (double)x / (double)light->width * w, (double)(x + 1) / (double)light->width * w, band,
                       rgb + 3 * x, &total[x]);
    }
    for (size_t i = 0; i < 3 * light->width; ++i)
        rgb[i] = total[i / 3] > 0 ? rgb[i] / total[i / 3] : 0;
}

/* The integral of the bilinear map over a cell has the filter kernel (1, 6, 1)/8 along both axes. */
static double cell_luminance(const nqm_light *light, size_t y, size_t x) {
    static const double spread[3] = {0.125, 0.75, 0.125};
    double sum = 0;
    for (size_t j = 0; j < 3; ++j) {
        size_t row = y + j < 1 ? 0 : y + j - 1 < light->height ? y + j - 1 : light->height - 1;
        for (size_t i = 0; i < 3; ++i) {
            size_t column = (x + i + light->width - 1) % light->width;
            sum += spread[j] * spread[i] * nqm_luminance(light->rgb + 3 * (row * light->width + column));
        }
    }
    return sum;
}

static nqm_status alloc_light(size_t width, nqm_light *light, nqm_error *err) {
    size_t height = width / 2, n = width * height;
    *light = (nqm_light){.width = width, .height = height};
    return nqm_alloc_arrays(
        NQM_ARRAYS({&light->rgb, n, 3 * sizeof(double)}, {&light->power, n, sizeof(double)},
                   {&light->row_power, height + 1, sizeof(double)}, {&light->solid_angle, height, sizeof(double)},
                   {&light->polar, height, 2 * sizeof(double)}, {&light->azimuth, width, 2 * sizeof(double)},
                   {&light->summand, n, 4 * sizeof(float)}),
        err);
}

static void place_cells(nqm_light *light) {
    double height = (double)light->height, width = (double)light->width;
    for (size_t y = 0; y < light->height; ++y) {
        double theta = NQM_PI * ((double)y + 0.5) / height;
        light->polar[2 * y] = sin(theta);
        light->polar[2 * y + 1] = cos(theta);
        light->solid_angle[y] =
            2 * NQM_PI / width * (cos(NQM_PI * (double)y / height) - cos(NQM_PI * (double)(y + 1) / height));
    }
    for (size_t x = 0; x < light->width; ++x) {
        double phi = 2 * NQM_PI * (((double)x + 0.5) / width - 0.5);
        light->azimuth[2 * x] = sin(phi);
        light->azimuth[2 * x + 1] = cos(phi);
    }
}

static void weigh_cells(nqm_light *light) {
    for (size_t y = 0; y < light->height; ++y) {
        light->row_power[y + 1] = light->row_power[y];
        for (size_t x = 0; x < light->width; ++x) {
            size_t cell = y * light->width + x;
            light->power[cell] = cell_luminance(light, y, x) * light->solid_angle[y];
            light->row_power[y + 1] += light->power[cell];
            float *summand = light->summand + 4 * (cell - cell % NQM_LIGHT_LANES) + cell % NQM_LIGHT_LANES;
            summand[0] = (float)light->power[cell];
            for (size_t k = 0; k < 3; ++k)
                summand[(k + 1) * NQM_LIGHT_LANES] = (float)(light->rgb[3 * cell + k] * light->solid_angle[y]);
        }
    }
}

nqm_status nqm_light_create(const nqm_image *image, size_t width, nqm_light *light_ret, nqm_error *err) {
    nqm_light light;
    *light_ret = (nqm_light){0};
    nqm_status status = alloc_light(width, &light, err);
    if (status != NQM_OK)
        return status;
    place_cells(&light);
    for (size_t y = 0; y < light.height; ++y)
        filter_row(image, &light, y);
    weigh_cells(&light);
    *light_ret = light;
    return NQM_OK;
}
