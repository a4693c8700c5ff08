/* SPDX-License-Identifier: MIT
 *
 * Colour spaces: a curve, then a matrix. The matrix of ACEScg (AP1, white of ACES) adapts the white with Bradford's transform
 * (CTL of ACES 1.0, also in MaterialX's libraries/cmlib), as that of ACES2065-1 (AP0); the others have the white of BT.709.
 */
#include "material/material.h"

#include <math.h>

double nqm_srgb_to_linear(double v) {
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

double nqm_linear_to_srgb(double v) {
    return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
}

typedef const double matrix[3][3];
static matrix ap1 = {{1.705050992658, -0.621792120657, -0.083258872001},
                     {-0.130256417507, 1.140804736575, -0.010548319068},
                     {-0.024003356805, -0.128968976065, 1.15297233287}};
static matrix display_p3 = {{1.2249401762805598, -0.2249401762805598, 0},
                            {-0.0420569547096882, 1.0420569547096882, 0},
                            {-0.0196375545903344, -0.0786360455506319, 1.0982736001409663}};
static matrix adobe = {{1.39835574, -0.39835574, 0}, {0, 1, 0}, {0, -0.04292899, 1.04292899}};

static matrix ap0 = {{2.52168618674, -1.13413098824, -0.387555198504},
                     {-0.27647991423, 1.37271908767, -0.0962391734383},
                     {-0.015378064966, -0.152975335867, 1.16835340083}};
static matrix rec2020 = {{1.66049100211, -0.587641138789, -0.0728498633199},
                         {-0.124550474522, 1.13289989713, -0.00834942260437},
                         {-0.0181507633549, -0.100578898008, 1.11872966136}};
static matrix xyz = {{3.2409699419, -1.53738317757, -0.498610760293},
                     {-0.969243636281, 1.87596750151, 0.0415550574072},
                     {0.055630079697, -0.203976958889, 1.05697151424}};

enum { LINEAR = 0, SRGB = -1 }; /* else the exponent */
static const struct {
    const char *names; /* of MaterialX and OpenUSD */
    double curve;
    matrix *to_rec709; /* NULL: BT.709 already */
} spaces[] = {
    {"lin_rec709 lin_rec709_scene lin_srgb none raw data identity", LINEAR, NULL},
    {"srgb_texture srgb_rec709_scene srgb_rec709_display srgb", SRGB, NULL},
    {"g18_rec709 g18_rec709_scene", 1.8, NULL},
    {"g22_rec709 g22_rec709_scene g22_rec709_display", 2.2, NULL},
    {"rec709_display g24_rec709_display", 2.4, NULL},
    {"acescg lin_ap1 lin_ap1_scene", LINEAR, &ap1},
    {"srgb_ap1_scene", SRGB, &ap1},
    {"g18_ap1 g18_ap1_scene", 1.8, &ap1},
    {"g22_ap1 g22_ap1_scene", 2.2, &ap1},
    {"aces2065-1 lin_ap0 lin_ap0_scene", LINEAR, &ap0},
    {"lin_rec2020 lin_rec2020_scene", LINEAR, &rec2020},
    {"lin_displayp3 lin_p3d65_scene", LINEAR, &display_p3},
    {"srgb_displayp3 srgb_p3d65_scene srgb_p3d65_display", SRGB, &display_p3},
    {"g26_p3d65_display", 2.6, &display_p3},
    {"lin_adobergb lin_adobergb_scene", LINEAR, &adobe},
    {"adobergb g22_adobergb_scene g22_adobergb_display", 563.0 / 256, &adobe},
    {"ciexyz lin_ciexyzd65_scene", LINEAR, &xyz},
};
enum { N_SPACES = sizeof spaces / sizeof *spaces };

bool nqm_color_to_rec709(const char *space, double *rgb) {
    size_t s = 0;
    if (!space || !*space)
        return true;
    while (s < N_SPACES && !nqm_contains_word(spaces[s].names, space, true))
        ++s;
    if (s == N_SPACES)
        return false;
    for (size_t c = 0; c < 3 && spaces[s].curve != LINEAR; ++c)
        rgb[c] = spaces[s].curve == SRGB ? nqm_srgb_to_linear(rgb[c]) : pow(fmax(rgb[c], 0), spaces[s].curve);
    const double in[3] = {rgb[0], rgb[1], rgb[2]};
    for (size_t c = 0; c < 3 && spaces[s].to_rec709; ++c) {
        const double *row = (*spaces[s].to_rec709)[c];
        /* The matrices have about 10 digits; white must not become 1 + 2e-16. */
        rgb[c] = nqm_round_digits(row[0] * in[0] + row[1] * in[1] + row[2] * in[2], 9);
    }
    return true;
}
