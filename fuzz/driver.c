/* SPDX-License-Identifier: MIT
 *
 * The program of all fuzz targets: `nqm-fuzz fuzz_spec` runs the valid input of one target, truncations of it, and random
 * mutations of it with a fixed seed and a limited number; `nqm-fuzz fuzz_spec FILE...` runs these files instead (a crash from
 * libFuzzer). With libFuzzer (NQM_FUZZ), whose main() runs the inputs, the name of the target comes first as well, and
 * `nqm-fuzz fuzz_spec --seed FILE` writes the valid input.
 */
#include "fuzz.h"

#include "base/base.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_TARGETS = 64 };

static struct fuzz_target {
    const char *file;
    int (*run)(const uint8_t *data, size_t n_bytes);
    blob (*seed)(void);
} targets[MAX_TARGETS], target;
static size_t n_targets;

void fuzz_add(const char *file, int (*run)(const uint8_t *data, size_t n_bytes), blob (*seed)(void)) {
    if (n_targets == MAX_TARGETS)
        abort();
    const char *slash = strrchr(file, '/');
    targets[n_targets++] = (struct fuzz_target){slash ? slash + 1 : file, run, seed};
}

/* Select the target whose file is named `name`.c. Exits if there is none. */
static void select_target(const char *name) {
    for (size_t i = 0; name && i < n_targets; ++i)
        if (strncmp(targets[i].file, name, strlen(name)) == 0 && strcmp(targets[i].file + strlen(name), ".c") == 0) {
            target = targets[i];
            return;
        }
    fprintf(stderr, "usage: nqm-fuzz TARGET [FILE...], where TARGET is a file of fuzz/, for example fuzz_spec\n");
    exit(2);
}

#ifdef NQM_FUZZ
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    return target.run(data, n_bytes);
}

int LLVMFuzzerInitialize(int *argc, char ***argv);
/* libFuzzer calls it before it reads the arguments, from which the name of the target is taken out. */
int LLVMFuzzerInitialize(int *argc, char ***argv) {
    select_target((*argv)[1]);
    if (*argc == 4 && strcmp((*argv)[2], "--seed") == 0) {
        blob_put(target.seed(), (*argv)[3]);
        exit(0);
    }
    for (int i = 1; i < *argc; ++i)
        (*argv)[i] = (*argv)[i + 1];
    --*argc;
    return 0;
}
#else
enum { N_CUTS = 400, N_MUTATIONS = 2000, SEED = 1 };
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
    target.run(copy, n_bytes);
    free(copy);
}

static void run_around(const blob *seed) {
    blob b = {.data = malloc(seed->n_bytes), .n_bytes = seed->n_bytes};
    if (!b.data)
        abort();
    run_one(seed->data, seed->n_bytes);
    for (size_t i = 0; i < N_CUTS; ++i)
        run_one(seed->data, seed->n_bytes * i / N_CUTS);
    const char *wanted = getenv("NQM_FUZZ_MUTATIONS"); /* ./dev test all: more of them */
    const size_t n_mutations = wanted ? strtoul(wanted, NULL, 10) : N_MUTATIONS;
    double begin_s = nqm_clock_s();
    size_t n = 0;
    for (; n < n_mutations && nqm_clock_s() - begin_s < time_limit_s; ++n) {
        nqm_rng rng = nqm_rng_make(SEED, n);
        memcpy(b.data, seed->data, seed->n_bytes);
        mutate(&b, &rng);
        run_one(b.data, b.n_bytes);
    }
    printf("%d cuts and %zu mutations of %zu bytes, seed %d\n", N_CUTS, n, seed->n_bytes, SEED);
    blob_free(&b);
}

int main(int argc, char **argv) {
    select_target(argv[1]);
    for (int i = 2; i < argc; ++i) {
        blob b = blob_load(argv[i]);
        run_one(b.data, b.n_bytes);
        blob_free(&b);
    }
    if (argc == 2) {
        blob seed = target.seed();
        run_around(&seed);
        blob_free(&seed);
    }
    return 0;
}
#endif
