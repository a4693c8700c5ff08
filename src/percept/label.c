/* SPDX-License-Identifier: MIT
 *
 * Labels with parts: the similarity of pictures seen apart, and what differs in words.
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

double nqm_label_similarity(const nqm_label *label) {
    static const double noticed = 0.15; /* of the shift, by people who have adapted to it */
    const double left = hypot(label->structure, noticed * sqrt(nqm_dot3(label->shift, label->shift)));
    return isnan(left) ? left : nqm_curve_jod(&nqm_curve_published, left);
}

/* A part of the label, the words for either sign, and the sizes from which it is mentioned, plain and much. */
typedef struct part {
    double value;
    const char *above, *below;
    double mentioned, plain, much;
} part;

const char *nqm_label_describe(const nqm_label *label, char text[NQM_LABEL_TEXT]) {
    const part parts[] = {
        {label->shift[0], "brighter", "darker", 1, 3, 10},
        {label->shift[1], "bluer", "yellower", 1, 3, 10},
        {label->shift[2], "redder", "greener", 1, 3, 10},
        {label->contrast, "more contrast", "flatter", 0.03, 0.1, 0.35},
        {label->structure, "changed in highlights and shading", "", 1, 3, 10},
    };
    size_t n = 0;
    text[0] = 0;
    for (const part *p = parts; p < parts + sizeof parts / sizeof *parts; ++p) {
        const double size = fabs(p->value);
        const char *degree = size < p->plain ? "a little " : size > p->much ? "much " : "";
        if (size >= p->mentioned)
            n += (size_t)snprintf(text + n, NQM_LABEL_TEXT - n, "%s%s%s", n ? ", " : "", degree,
                                  p->value > 0 ? p->above : p->below);
    }
    if (n == 0)
        snprintf(text, NQM_LABEL_TEXT, "no visible difference");
    return text;
}
