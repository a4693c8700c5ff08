/* SPDX-License-Identifier: MIT
 *
 * Reads the input as a material file, by way of a file in memory. Each material has either a refusal or a spec; a spec that is in
 * range gives a BRDF without NaN or negative values.
 */
#define _GNU_SOURCE /* memfd_create */
#include "material/material.h"
#include "brdf/brdf.h"
#include "fuzz.h"

#include <math.h>
#include <nqm/material.h>
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

static void need(bool ok, const char *what) {
    if (ok)
        return;
    fprintf(stderr, "broken: %s\n", what);
    abort();
}

static void check_material(nqm_material_info info, size_t n_bytes) {
    need(info.name && info.surface && (info.spec == NULL) != (info.refusal == NULL),
         "neither spec nor refusal, or both");
    need(info.byte_offset >= -1 && info.byte_offset <= (int64_t)n_bytes, "a position outside of the file");
    nqm_brdf *brdf = NULL;
    nqm_error err = {0};
    if (!info.spec || !nqm_spec_probe(info.spec))
        return;
    nqm_status status = nqm_brdf_open(info.spec, &brdf, &err);
    need(status == NQM_OK || (status == NQM_ERR_ARG && err.message[0]), "a spec that is not one of its model");
    for (uint32_t i = 0; brdf && i < 16; ++i) {
        const double hd[3] = {noise(i, 1) * noise(i, 1) * 1.5, noise(i, 2) * 1.5, noise(i, 3) * 3};
        double rgb[3];
        nqm_brdf_eval_half_diff(brdf, 1, hd, rgb, NULL);
        for (int c = 0; c < 3; ++c)
            need(isfinite(rgb[c]) && rgb[c] >= 0, "a value is negative or not finite");
    }
    nqm_brdf_free(brdf);
}

void fuzz_material(const uint8_t *data, size_t n_bytes) {
    char path[64];
    int fd = memfd_create("fuzz", MFD_CLOEXEC);
    need(fd >= 0 && write(fd, data, n_bytes) == (ssize_t)n_bytes, "memory file");
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    nqm_materials *materials = NULL;
    nqm_error err = {0};
    nqm_status status = nqm_materials_open(path, &materials, &err);
    close(fd);
    need((status == NQM_OK) == (materials != NULL), "object and status disagree");
    need(status == NQM_OK || (err.status == status && err.message[0]), "failure without a message");
    need(status != NQM_ERR_NOMEM, "more memory asked for than the bytes justify");
    for (size_t i = 0; materials && i < nqm_materials_count(materials); ++i)
        check_material(nqm_materials_get(materials, i), n_bytes);
    nqm_materials_free(materials);
}
