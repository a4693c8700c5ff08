/* SPDX-License-Identifier: MIT
 *
 * main() for fuzz targets built without libFuzzer. It runs the valid input, truncations of it, and random mutations of
 * it with a fixed seed and a limited number. With arguments it runs these files instead (a crash from libFuzzer).
 * With libFuzzer (NQM_FUZZ), whose main() runs the inputs, this file only adds `--seed FILE`, which writes the valid input.
 */
#include "fuzz.h"

#include "base/base.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef NQM_FUZZ
int LLVMFuzzerInitialize(int *argc, char ***argv);
/* libFuzzer calls it before it reads the arguments. */
int LLVMFuzzerInitialize(int *argc, char ***argv) {
    if (*argc == 3 && strcmp((*argv)[1], "--seed") == 0) {
        blob_put(fuzz_seed(), (*argv)[2]);
        exit(0);
    }
    return 0;
}
#else
enum { N_CUTS = 400, N_MUTATIONS = 10000, SEED = 1 };
static const double time_limit_s = 10; /* a slow (sanitized, emulated, busy) machine runs fewer mutations */

/* Apply 1 to 8 changes: flip a bit, replace a byte, or write a boundary value of 1 to 8 bytes. */
static void mutate(blob *b, nqm_rng *rng) {
    static const uint64_t limits[] = {0, 1, 0x7f, 0xff, 0x7fffffff, 0x80000000, 0xffffffff, INT64_MAX, UINT64_MAX};
    size_t n_changes = 1 + nqm_rng_below(rng, 8);
    /* Headers and tables of contents are in the first bytes: half of the inputs are changed only there. */
    size_t range = nqm_rng_below(rng, 2) && b->n_bytes > 512 ? 512 : b->n_bytes;
    for (size_t i = 0; i < n_changes; ++i) {
        size_t at = nqm_rng_below(rng, range);
        uint64_t limit = limits[nqm_rng_below(rng, sizeof limits / sizeof *limits)];
        size_t n = (size_t)1 << nqm_rng_below(rng, 4);
        switch (nqm_rng_below(rng, 3)) {
        case 0:
            b->data[at] ^= (unsigned char)(1U << nqm_rng_below(rng, 8));
            break;
        case 1:
            b->data[at] = (unsigned char)nqm_rng_below(rng, 256);
            break;
        default:
            for (size_t k = 0; k < n && at + k < b->n_bytes; ++k)
                b->data[at + k] = (unsigned char)(limit >> 8 * k);
        }
    }
}

/* Run one input in a heap block of exactly its size, so that sanitizers detect reads past its end. */
static void run_one(const unsigned char *data, size_t n_bytes) {
    unsigned char *copy = malloc(n_bytes ? n_bytes : 1);
    if (!copy)
        abort();
    memcpy(copy, data, n_bytes);
    LLVMFuzzerTestOneInput(copy, n_bytes);
    free(copy);
}

static void run_around(const blob *seed) {
    blob b = {.data = malloc(seed->n_bytes), .n_bytes = seed->n_bytes};
    if (!b.data)
        abort();
    run_one(seed->data, seed->n_bytes);
    for (size_t i = 0; i < N_CUTS; ++i)
        run_one(seed->data, seed->n_bytes * i / N_CUTS);
    double begin_s = nqm_clock_s();
    size_t n = 0;
    for (; n < N_MUTATIONS && nqm_clock_s() - begin_s < time_limit_s; ++n) {
        nqm_rng rng = nqm_rng_make(SEED, n);
        memcpy(b.data, seed->data, seed->n_bytes);
        mutate(&b, &rng);
        run_one(b.data, b.n_bytes);
    }
    printf("%d cuts and %zu mutations of %zu bytes, seed %d\n", N_CUTS, n, seed->n_bytes, SEED);
    blob_free(&b);
}

int main(int argc, char **argv) {
    for (int i = 1; i < argc; ++i) {
        blob b = blob_load(argv[i]);
        run_one(b.data, b.n_bytes);
        blob_free(&b);
    }
    if (argc == 1) {
        blob seed = fuzz_seed();
        run_around(&seed);
        blob_free(&seed);
    }
    return 0;
}
#endif
