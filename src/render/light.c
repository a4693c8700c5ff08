/* SPDX-License-Identifier: MIT
 *
 * A light map: filtered to fixed cells, looked up bilinearly, sampled cell by cell.
 */
#include "math/math.h"
#include "render/render.h"

#include <math.h>

enum { WIDTH = NQM_LIGHT_WIDTH, HEIGHT = NQM_LIGHT_HEIGHT };

void nqm_map_direction(double u, double v, double *w) {
    double theta = NQM_PI * v, phi = 2 * NQM_PI * (u - 0.5);
    w[0] = sin(theta) * sin(phi);
    w[1] = cos(theta);
    w[2] = -sin(theta) * cos(phi);
}

/* The inverse, in cells. */
static void position_of(const double *w, double *row, double *column) {
    *row = atan2(hypot(w[0], w[2]), w[1]) / NQM_PI * HEIGHT;
    *column = (atan2(w[0], -w[2]) / (2 * NQM_PI) + 0.5) * WIDTH;
}

size_t nqm_light_cell(const double *w) {
    double row, column;
    position_of(w, &row, &column);
    size_t y = (size_t)row, x = (size_t)column;
    return (y < HEIGHT ? y : HEIGHT - 1) * WIDTH + (x < WIDTH ? x : 0);
}

void nqm_light_direction(size_t cell, double u, double v, double *w) {
    size_t y = cell / WIDTH, x = cell % WIDTH;
    double top = cos(NQM_PI * (double)y / HEIGHT), bottom = cos(NQM_PI * (double)(y + 1) / HEIGHT);
    nqm_map_direction(((double)x + u) / WIDTH, acos(top + (bottom - top) * v) / NQM_PI, w);
}

/* The cells about a continuous position, wrapped in x and clamped in y, with their bilinear weights. */
typedef struct quad {
    size_t cell[4];
    double weight[4];
} quad;

static quad quad_at(double row, double column) {
    double y = fmin(fmax(row - 0.5, 0), HEIGHT - 1), x = column - 0.5;
    x = x < 0 ? x + WIDTH : x;
    size_t y0 = (size_t)y, x0 = (size_t)x % WIDTH;
    size_t y1 = y0 + 1 < HEIGHT ? y0 + 1 : y0, x1 = (x0 + 1) % WIDTH;
    double fy = y - (double)y0, fx = x - floor(x);
    return (quad){{y0 * WIDTH + x0, y0 * WIDTH + x1, y1 * WIDTH + x0, y1 * WIDTH + x1},
                  {(1 - fy) * (1 - fx), (1 - fy) * fx, fy * (1 - fx), fy * fx}};
}

void nqm_light_eval(const nqm_light *light, const double *w, double *rgb) {
    double row, column;
    position_of(w, &row, &column);
    quad q = quad_at(row, column);
    for (size_t k = 0; k < 3; ++k) {
        rgb[k] = 0;
        for (int i = 0; i < 4; ++i)
            rgb[k] += q.weight[i] * light->rgb[3 * q.cell[i] + k];
    }
}

/* Mean over the part of the picture that a cell covers; rows count by their solid angle. */
static void filter_cell(const nqm_image *image, size_t y, size_t x, double *rgb) {
    double w = (double)image->width, h = (double)image->height;
    double x_begin = (double)x / WIDTH * w, x_end = (double)(x + 1) / WIDTH * w;
    double y_begin = (double)y / HEIGHT * h, y_end = (double)(y + 1) / HEIGHT * h;
    double sum[3] = {0}, total = 0;
    for (size_t j = (size_t)y_begin; j < image->height && (double)j < y_end; ++j) {
        double top = fmax((double)j, y_begin) / h, bottom = fmin((double)(j + 1), y_end) / h;
        double band = cos(NQM_PI * top) - cos(NQM_PI * bottom);
        for (size_t i = (size_t)x_begin; i < image->width && (double)i < x_end; ++i) {
            double weight = band * (fmin((double)(i + 1), x_end) - fmax((double)i, x_begin));
            const float *pixel = image->rgb + 3 * (j * image->width + i);
            for (int k = 0; k < 3; ++k)
                sum[k] += weight * (double)pixel[k];
            total += weight;
        }
    }
    for (int k = 0; k < 3; ++k)
        rgb[k] = total > 0 ? sum[k] / total : 0;
}

/* Integrating the bilinear map over a cell spreads each cell by (1, 6, 1)/8 along both axes. */
static double cell_luminance(const nqm_light *light, size_t y, size_t x) {
    static const double spread[3] = {0.125, 0.75, 0.125};
    double sum = 0;
    for (size_t j = 0; j < 3; ++j) {
        size_t row = y + j < 1 ? 0 : y + j - 1 < HEIGHT ? y + j - 1 : HEIGHT - 1;
        for (size_t i = 0; i < 3; ++i) {
            size_t column = (x + i + WIDTH - 1) % WIDTH;
            sum += spread[j] * spread[i] * nqm_luminance(light->rgb + 3 * (row * WIDTH + column));
        }
    }
    return sum;
}

nqm_status nqm_light_create(const nqm_image *image, nqm_light *light_ret, nqm_error *err) {
    nqm_light light = {.rgb = nqm_alloc(NQM_LIGHT_CELLS, 3 * sizeof(double)),
                       .direction = nqm_alloc(NQM_LIGHT_CELLS, 3 * sizeof(double)),
                       .power = nqm_alloc(NQM_LIGHT_CELLS, sizeof(double))};
    *light_ret = (nqm_light){0};
    if (!light.rgb || !light.direction || !light.power) {
        nqm_light_clear(&light);
        return nqm_fail_nomem(err, NQM_LIGHT_CELLS * 7 * sizeof(double));
    }
    for (size_t y = 0; y < HEIGHT; ++y) {
        light.solid_angle[y] =
            2 * NQM_PI / WIDTH * (cos(NQM_PI * (double)y / HEIGHT) - cos(NQM_PI * (double)(y + 1) / HEIGHT));
        for (size_t x = 0; x < WIDTH; ++x) {
            filter_cell(image, y, x, light.rgb + 3 * (y * WIDTH + x));
            nqm_map_direction(((double)x + 0.5) / WIDTH, ((double)y + 0.5) / HEIGHT,
                              light.direction + 3 * (y * WIDTH + x));
        }
    }
    for (size_t y = 0; y < HEIGHT; ++y)
        for (size_t x = 0; x < WIDTH; ++x)
            light.power[y * WIDTH + x] = cell_luminance(&light, y, x) * light.solid_angle[y];
    *light_ret = light;
    return NQM_OK;
}

void nqm_light_clear(nqm_light *light) {
    nqm_free(light->rgb);
    nqm_free(light->direction);
    nqm_free(light->power);
    *light = (nqm_light){0};
}
