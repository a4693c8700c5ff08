/* SPDX-License-Identifier: MIT
 *
 * Opens the input as a BRDF file, by way of a file in memory and the public interface.
 */
#define _GNU_SOURCE /* memfd_create */
#include "fuzz.h"

#include <math.h>
#include <nqm/brdf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static void need(bool ok, const char *what) {
    if (ok)
        return;
    fprintf(stderr, "broken: %s\n", what);
    abort();
}

enum { N = 64 };

static void check_values(const double *rgb, const uint8_t *flag) {
    for (size_t i = 0; i < 3 * N; ++i) {
        need(isfinite(rgb[i]) && rgb[i] >= 0, "a value is negative or not finite");
        need(flag[i / 3] <= NQM_VALUE_CLAMPED || rgb[i] == 0, "a value where there is none");
    }
}

static void evaluate(const nqm_brdf *brdf) {
    double hd[3 * N], rgb[3 * N], wi[3 * N], wo[3 * N];
    uint8_t flag[N];
    for (uint32_t i = 0; i < N; ++i) {
        hd[3 * i] = noise(i, 1) * noise(i, 1) * 1.5707963;
        hd[3 * i + 1] = noise(i, 2) * 1.5707963;
        hd[3 * i + 2] = noise(i, 3) * 6.2831853;
    }
    hd[0] = hd[4] = hd[8] = 0;
    nqm_brdf_eval_half_diff(brdf, N, hd, rgb, flag);
    check_values(rgb, flag);
    for (size_t i = 0; i < 3 * N; i += 3) {
        nqm_half_diff_to_directions(hd + i, wi + i, wo + i);
        for (size_t k = 0; k < 2; ++k) { /* a turn about the normal by i */
            double *w = k ? wo + i : wi + i, x = w[0];
            w[0] = cos((double)i) * x - sin((double)i) * w[1];
            w[1] = sin((double)i) * x + cos((double)i) * w[1];
        }
    }
    nqm_brdf_eval(brdf, N, wi, wo, rgb, flag);
    check_values(rgb, flag);
}

int fuzz_file(const uint8_t *data, size_t n_bytes, char path[FUZZ_PATH]) {
    int fd = memfd_create("fuzz", MFD_CLOEXEC);
    need(fd >= 0 && write(fd, data, n_bytes) == (ssize_t)n_bytes, "memory file");
    snprintf(path, FUZZ_PATH, "/proc/self/fd/%d", fd);
    return fd;
}

void fuzz_brdf(const uint8_t *data, size_t n_bytes, size_t n_file, const char *member) {
    char argument[FUZZ_PATH + 32], path[FUZZ_PATH];
    const int fd = fuzz_file(data, n_bytes, path);
    need(n_file <= n_bytes || ftruncate(fd, (off_t)n_file) == 0, "memory file");
    snprintf(argument, sizeof argument, "%s%s", path, member);
    nqm_brdf *brdf = NULL;
    nqm_error err = {0};
    nqm_status status = nqm_brdf_open(argument, &brdf, &err);
    close(fd);
    need((status == NQM_OK) == (brdf != NULL), "object and status disagree");
    need(status == NQM_OK || (err.status == status && err.message[0]), "failure without a message");
    need(status != NQM_ERR_NOMEM, "more memory asked for than the bytes justify");
    if (brdf)
        evaluate(brdf);
    nqm_brdf_free(brdf);
}
