/* SPDX-License-Identifier: MIT
 *
 * BRDFs that are not open yet: names, and values of a texel with its normal.
 */
#include "argument/argument.h"

#include <math.h>

void nqm_subject_tilt(nqm_subject *subject, const double normal[3]) {
    const double sine = hypot(normal[0], normal[1]), degrees = atan2(sine, normal[2]) * 180 / NQM_PI;
    const bool is_tilted = !(degrees < 1e-3);
    subject->tilt_deg = is_tilted ? fmin(degrees, 60) : 0;
    subject->azimuth_deg = is_tilted ? atan2(normal[1], normal[0]) * 180 / NQM_PI : 0;
}

static size_t values_size(const nqm_values *values) {
    return values->schema->n_keys * sizeof *values->v;
}

bool nqm_subjects_equal(const nqm_subject *a, const nqm_subject *b) {
    if (a->tilt_deg != b->tilt_deg || a->azimuth_deg != b->azimuth_deg || !a->name != !b->name)
        return false;
    return a->name ? strcmp(a->name, b->name) == 0
                   : a->values->schema == b->values->schema &&
                         memcmp(a->values->v, b->values->v, values_size(a->values)) == 0;
}

/* FNV-1a. */
static uint64_t add_bytes(uint64_t hash, const void *bytes, size_t n) {
    for (const unsigned char *b = bytes; n--; ++b)
        hash = (hash ^ *b) * 1099511628211u;
    return hash;
}

uint64_t nqm_subject_hash(const nqm_subject *s) {
    const double tilt[2] = {s->tilt_deg, s->azimuth_deg};
    const uint64_t hash = add_bytes(14695981039346656037u, tilt, sizeof tilt);
    return s->name ? add_bytes(hash, s->name, strlen(s->name)) : add_bytes(hash, s->values->v, values_size(s->values));
}

nqm_status nqm_subject_open(const nqm_subject *s, nqm_argument_files *files, nqm_brdf **brdf_ret, nqm_error *err) {
    nqm_brdf *of = NULL;
    *brdf_ret = NULL;
    nqm_status status =
        s->name ? nqm_argument_open_text(s->name, s->name, files, &of, err) : nqm_brdf_of_values(s->values, &of, err);
    if (status == NQM_OK && s->tilt_deg > 0)
        return nqm_brdf_tilt_degrees(of, s->tilt_deg, s->azimuth_deg, brdf_ret, err);
    *brdf_ret = of;
    return status;
}
