/* SPDX-License-Identifier: MIT
 *
 * Labels with parts: their definition by sums over two pictures, the JOD of people who adapt to a shift, and what differs in
 * words.
 */
#include "math/math.h"
#include "percept/percept.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void nqm_label_get_parts(const nqm_label *label, double parts[NQM_LABEL_PARTS]) {
    memcpy(parts, label->shift, sizeof label->shift);
    parts[3] = label->contrast;
    parts[4] = label->structure;
}

void nqm_label_set_parts(nqm_label *label, const double parts[NQM_LABEL_PARTS]) {
    memcpy(label->shift, parts, sizeof label->shift);
    label->contrast = parts[3];
    label->structure = parts[4];
}

/* ---- from pictures ----------------------------------------------------------------------------------------------- */

void nqm_picture_sums_add(nqm_picture_sums *s, double weight, const double ref[3], const double test[3]) {
    double square = 0;
    for (int k = 0; k < 3; ++k) {
        double d = test[k] - ref[k];
        s->shift[k] += weight * d;
        square += d * d;
    }
    s->delta_e += weight * sqrt(square);
    s->squares += weight * square;
    s->ref += weight * ref[0];
    s->ref_squares += weight * ref[0] * ref[0];
    s->test += weight * test[0];
    s->test_squares += weight * test[0] * test[0];
}

static double standard_deviation(double mean, double mean_of_squares) {
    return sqrt(fmax(mean_of_squares - mean * mean, 0));
}

nqm_label nqm_picture_sums_label(const nqm_picture_sums *s) {
    nqm_label label = {.delta_e = s->delta_e};
    memcpy(label.shift, s->shift, sizeof label.shift);
    label.structure = sqrt(fmax(s->squares - nqm_dot3(s->shift, s->shift), 0));
    label.contrast =
        log((1 + standard_deviation(s->test, s->test_squares)) / (1 + standard_deviation(s->ref, s->ref_squares)));
    return label;
}

void nqm_picture_gradient(const nqm_picture_sums *s, const nqm_label *weights, double weight, const double ref[3],
                          const double test[3], double gradient[3]) {
    const double structure = sqrt(fmax(s->squares - nqm_dot3(s->shift, s->shift), 0));
    const double deviation = standard_deviation(s->test, s->test_squares);
    const double d[3] = {test[0] - ref[0], test[1] - ref[1], test[2] - ref[2]}, length = sqrt(nqm_dot3(d, d));
    for (int k = 0; k < 3; ++k) {
        gradient[k] = weights->shift[k];
        gradient[k] += length > 0 ? weights->delta_e * d[k] / length : 0;
        gradient[k] += structure > 0 ? weights->structure * (d[k] - s->shift[k]) / structure : 0;
    }
    gradient[0] += deviation > 0 ? weights->contrast * (test[0] - s->test) / (deviation * (1 + deviation)) : 0;
    for (int k = 0; k < 3; ++k)
        gradient[k] *= weight;
}

void nqm_label_add(nqm_label *mean, double share, const nqm_label *label) {
    mean->delta_e += share * label->delta_e;
    for (int k = 0; k < 3; ++k)
        mean->shift[k] += share * label->shift[k];
    mean->contrast += share * label->contrast;
    mean->structure += share * label->structure;
    mean->error = hypot(mean->error, share * label->error);
}

/* ---- what it says ------------------------------------------------------------------------------------------------ */

double nqm_label_adapted_jod(const nqm_label *label) {
    static const double noticed = 0.15; /* part of the shift that adapted people still notice */
    const double left = hypot(label->structure, noticed * sqrt(nqm_dot3(label->shift, label->shift)));
    return isnan(left) ? left : nqm_curve_jod(&nqm_curve_published, left);
}

/* A part of the label, the words for either sign, and the sizes from which it is mentioned, plain and much. */
typedef struct part {
    double value;
    const char *above, *below;
    double mentioned, plain, much;
} part;

static void describe(const nqm_label *label, char text[NQM_LABEL_TEXT]) {
    const part parts[] = {
        {label->shift[0], "brighter", "darker", 1, 3, 10},
        {label->shift[1], "bluer", "yellower", 1, 3, 10},
        {label->shift[2], "redder", "greener", 1, 3, 10},
        {label->contrast, "more contrast", "flatter", 0.03, 0.1, 0.35},
        {label->structure, "changed in highlights and shading", "", 1, 3, 10},
    };
    /* A plain "darker" would contradict the verdict "practically the same" (JOD 9.5), "much" also "hardly visible" (9).
     * Delta-E 0: not known. */
    const double jod = label->delta_e > 0 ? nqm_curve_jod(&nqm_curve_published, label->delta_e) : 0;
    size_t n = 0;
    text[0] = 0;
    for (const part *p = parts; p < parts + sizeof parts / sizeof *parts; ++p) {
        const double size = fabs(p->value);
        const char *degree = jod >= 9.5 || size < p->plain ? "a little " : jod >= 9 || size <= p->much ? "" : "much ";
        if (size >= p->mentioned)
            n += (size_t)snprintf(text + n, NQM_LABEL_TEXT - n, "%s%s%s", n ? ", " : "", degree,
                                  p->value > 0 ? p->above : p->below);
    }
    if (n == 0)
        snprintf(text, NQM_LABEL_TEXT, "no visible difference");
}

nqm_label_info nqm_label_get_info(const nqm_label *label) {
    assert(label);
    nqm_label_info info = {.curve = nqm_curve_published, .adapted_jod = nqm_label_adapted_jod(label)};
    info.jod_error = 0.5 * (nqm_curve_jod(&nqm_curve_published, label->delta_e - label->error) -
                            nqm_curve_jod(&nqm_curve_published, label->delta_e + label->error));
    describe(label, info.words);
    return info;
}
