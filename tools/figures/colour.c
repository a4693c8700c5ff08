/* SPDX-License-Identifier: MIT
 *
 * Colours: the display's curve with a shoulder, sRGB, and viridis as a map from numbers to colours.
 */
#include "figures/tone.h"

#include <math.h>

nqm_tone nqm_tone_default(void) {
    return (nqm_tone){.white_cdm2 = 400, .shoulder = 0.6};
}

double nqm_tone_apply(const nqm_tone *tone, double value_cdm2) {
    double x = fmax(value_cdm2, 0) / tone->white_cdm2, s = tone->shoulder;
    if (x <= s)
        return x;
    return s < 1 ? s - (1 - s) * expm1(-(x - s) / (1 - s)) : 1;
}

unsigned char nqm_srgb_byte(double linear) {
    double coded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
    return (unsigned char)nearbyint(255 * fmin(fmax(coded, 0), 1));
}

double nqm_srgb_linear(double coded) {
    return coded <= 0.04045 ? coded / 12.92 : pow((coded + 0.055) / 1.055, 2.4);
}

void nqm_viridis(double t, double *rgb) {
    /* Every eighth of the 256 sRGB colours of viridis (S. van der Walt and N. Smith 2015, CC0); linear between them. */
    static const unsigned char table[33][3] = {
        {68, 1, 84},    {71, 13, 96},   {72, 24, 106},  {72, 35, 116},  {71, 45, 123},  {69, 55, 129},  {66, 64, 134},
        {62, 73, 137},  {59, 82, 139},  {55, 91, 141},  {51, 99, 141},  {47, 107, 142}, {44, 114, 142}, {41, 122, 142},
        {38, 130, 142}, {35, 137, 142}, {33, 145, 140}, {31, 152, 139}, {31, 160, 136}, {34, 167, 133}, {40, 174, 128},
        {50, 182, 122}, {63, 188, 115}, {78, 195, 107}, {94, 201, 98},  {112, 207, 87}, {132, 212, 75}, {152, 216, 62},
        {173, 220, 48}, {194, 223, 35}, {216, 226, 25}, {236, 229, 27}, {253, 231, 37}};
    double at = 32 * fmin(fmax(t, 0), 1);
    size_t i = at < 31 ? (size_t)at : 31;
    for (size_t k = 0; k < 3; ++k)
        rgb[k] = nqm_srgb_linear((table[i][k] + (at - (double)i) * (table[i + 1][k] - table[i][k])) / 255);
}
