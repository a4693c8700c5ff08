/* SPDX-License-Identifier: MIT
 *
 * A generated dataset: random analytic materials and changed copies of them, labelled by the difference of their
 * logarithms. Training on it is as much work as on rendered labels, and converges. The JODs are uniform, as after the
 * paper's balancing: if nearly all labels are close to 10, its recipe predicts 10 everywhere.
 */
#include "bench/bench.h"
#include "math/math.h"
#include "train/train.h"

#include <math.h>
#include <string.h>

enum { SPEC_BYTES = 200, TESTS_PER_REF = 10, NAME_BYTES = 32 };

/* Parameters of a GGX material. */
enum { ALPHA, SPECULAR, RED, GREEN, BLUE, PARAMETERS };

static void random_material(nqm_rng *rng, double material[PARAMETERS]) {
    material[SPECULAR] = exp(4 * nqm_rng_uniform(rng) - 5);
    material[ALPHA] = exp(3 * nqm_rng_uniform(rng) - 3.5);
    for (size_t k = RED; k <= BLUE; ++k)
        material[k] = 0.7 * nqm_rng_uniform(rng);
}

/* A copy with a random amount of change, from hardly visible to very different. */
static void change(const double from[PARAMETERS], nqm_rng *rng, double to[PARAMETERS]) {
    const double amount = nqm_rng_uniform(rng) * nqm_rng_uniform(rng);
    for (size_t k = 0; k < PARAMETERS; ++k)
        to[k] = fmin(from[k] * exp((k < RED ? 1 : 0.5) * amount * nqm_rng_normal(rng)), 1);
}

static nqm_status sample_material(const double m[PARAMETERS], const nqm_directions *directions, float *rgb,
                                  nqm_error *err) {
    char spec[SPEC_BYTES];
    snprintf(spec, sizeof spec, "ggx:kd=%.17g,%.17g,%.17g;ks=%.17g;alpha=%.17g;f0=.5", m[RED], m[GREEN], m[BLUE],
             m[SPECULAR], m[ALPHA]);
    nqm_brdf *brdf;
    nqm_status status = nqm_brdf_open(spec, &brdf, err);
    if (status == NQM_OK)
        status = nqm_sample(brdf, directions, NQM_INVALID_ZERO, rgb, NULL, NULL, err);
    nqm_brdf_free(brdf);
    return status;
}

static double label_delta_e(size_t n, const float *ref, const float *test) {
    double sum = 0;
    for (size_t i = 0; i < n; ++i)
        sum += fabs(log((double)test[i] + 0.003) - log((double)ref[i] + 0.003));
    return 40 * sum / (double)n;
}

static nqm_status add_material(nqm_dataset_builder *b, size_t ref, nqm_rng *rng, nqm_error *err) {
    const nqm_dataset *d = b->dataset;
    const size_t width = 3 * d->n_directions;
    double material[PARAMETERS], changed[PARAMETERS];
    char name[NAME_BYTES];
    uint32_t group = 0, kind = 0;
    snprintf(name, sizeof name, "material %zu", ref);
    random_material(rng, material);
    nqm_status status = sample_material(material, d->directions, d->ref_rgb + ref * width, err);
    if (status == NQM_OK)
        status = nqm_dataset_add_group(b, name, strlen(name), NQM_SPLIT_TRAIN, &group, err);
    if (status == NQM_OK)
        status = nqm_dataset_add_reference(b, name, group, err);
    if (status == NQM_OK)
        status = nqm_dataset_add_kind(b, "random", NULL, &kind, err);
    for (size_t i = ref * TESTS_PER_REF; i < (ref + 1) * TESTS_PER_REF && status == NQM_OK; ++i) {
        float *test_rgb = d->test_rgb + i * width;
        change(material, rng, changed);
        status = sample_material(changed, d->directions, test_rgb, err);
        snprintf(name, sizeof name, "copy %zu", i);
        if (status == NQM_OK)
            status = nqm_dataset_add_pair(b, (uint32_t)ref, name, kind,
                                          label_delta_e(width, d->ref_rgb + ref * width, test_rgb), 0, err);
    }
    return status;
}

/* JODs from 10 to 0, uniform, in the order of Delta-E. */
static nqm_status spread_jods(const nqm_dataset *d, double *jod, nqm_error *err) {
    nqm_indexed *order = nqm_alloc(d->n_pairs, sizeof *order);
    if (!order)
        return nqm_fail_nomem(err, d->n_pairs * sizeof *order);
    nqm_ranks(d->n_pairs, d->delta_e, jod, order);
    for (size_t i = 0; i < d->n_pairs; ++i)
        jod[i] = 10 * (1 - jod[i] / (double)d->n_pairs);
    nqm_free(order);
    return NQM_OK;
}

nqm_status nqm_bench_pairs(size_t n_refs, const nqm_directions *directions, nqm_dataset **dataset_ret, nqm_error *err) {
    *dataset_ret = NULL;
    const nqm_dataset_limits limits = {.n_directions = nqm_directions_get_info(directions).n,
                                       .directions_deg = nqm_directions_get_info(directions).degrees,
                                       .max_refs = n_refs,
                                       .max_pairs = n_refs * TESTS_PER_REF};
    nqm_dataset_builder b;
    nqm_status status = nqm_dataset_begin(&limits, &b, err);
    if (status != NQM_OK)
        return status;
    nqm_rng rng = nqm_rng_make(1, 0);
    for (size_t ref = 0; ref < n_refs && status == NQM_OK; ++ref)
        status = add_material(&b, ref, &rng, err);
    if (status == NQM_OK)
        status = spread_jods(b.dataset, b.dataset->jod, err);
    return nqm_dataset_finish(&b, status, "{\"made_by\": \"nqm-bench\"}", NULL, dataset_ret, err);
}
