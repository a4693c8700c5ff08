/* SPDX-License-Identifier: MIT
 *
 * A dataset made on the spot: random analytic materials and changed copies of them, labelled by how far their logarithms
 * are apart. Training on it does the same work as training on rendered labels, and there is something to learn. The JODs
 * are spread evenly, as the paper's balancing leaves them: where nearly all labels stand at the upper end, its recipe
 * sticks there.
 */
#include "bench/inside.h"
#include "math/math.h"
#include "train/train.h"

#include <math.h>

enum { SPEC_BYTES = 200, TESTS_PER_REF = 10, NAME_BYTES = 32 };

typedef struct material {
    double diffuse[3], specular, alpha;
} material;

static material random_material(nqm_rng *rng) {
    material m = {.specular = exp(4 * nqm_rng_uniform(rng) - 5), .alpha = exp(3 * nqm_rng_uniform(rng) - 3.5)};
    for (size_t k = 0; k < 3; ++k)
        m.diffuse[k] = 0.7 * nqm_rng_uniform(rng);
    return m;
}

/* A copy that is off by something between hardly and very much. */
static material change(const material *from, nqm_rng *rng) {
    material m = *from;
    const double amount = nqm_rng_uniform(rng) * nqm_rng_uniform(rng);
    m.alpha *= exp(amount * nqm_rng_normal(rng));
    m.alpha = fmin(m.alpha, 1);
    m.specular *= exp(amount * nqm_rng_normal(rng));
    m.specular = fmin(m.specular, 1);
    for (size_t k = 0; k < 3; ++k)
        m.diffuse[k] = fmin(m.diffuse[k] * exp(0.5 * amount * nqm_rng_normal(rng)), 1);
    return m;
}

static nqm_status sample_material(const material *m, const nqm_directions *directions, float *rgb, nqm_error *err) {
    char spec[SPEC_BYTES], number[5][32];
    const double values[5] = {m->diffuse[0], m->diffuse[1], m->diffuse[2], m->specular, m->alpha};
    for (size_t i = 0; i < 5; ++i)
        nqm_format_double(number[i], sizeof number[i], values[i]);
    snprintf(spec, sizeof spec, "ggx:kd=%s,%s,%s;ks=%s;alpha=%s;f0=.5", number[0], number[1], number[2], number[3],
             number[4]);
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

/* Memory of a dataset while it is filled; the dataset's own pointers are to constants. */
typedef struct arrays {
    float *ref_rgb, *test_rgb;
    uint32_t *pair_ref, *ref_group;
    double *delta_e, *jod;
    const char **ref_names, **pair_names;
    char *text;
} arrays;

static bool allocate(nqm_dataset *d, arrays *a) {
    const size_t width = 3 * d->n_directions * sizeof(float);
    d->ref_rgb = a->ref_rgb = nqm_dataset_alloc(d, d->n_refs, width);
    d->test_rgb = a->test_rgb = nqm_dataset_alloc(d, d->n_pairs, width);
    d->pair_ref = a->pair_ref = nqm_dataset_alloc(d, d->n_pairs, sizeof(uint32_t));
    d->ref_group = a->ref_group = nqm_dataset_alloc(d, d->n_refs, sizeof(uint32_t));
    d->delta_e = a->delta_e = nqm_dataset_alloc(d, d->n_pairs, sizeof(double));
    d->jod = a->jod = nqm_dataset_alloc(d, d->n_pairs, sizeof(double));
    d->pair_kind = nqm_dataset_alloc(d, d->n_pairs, sizeof(uint32_t));
    d->group_split = nqm_dataset_alloc(d, d->n_groups, 1);
    a->ref_names = nqm_dataset_alloc(d, d->n_refs, sizeof(char *));
    a->pair_names = nqm_dataset_alloc(d, d->n_pairs, sizeof(char *));
    a->text = nqm_dataset_alloc(d, d->n_refs + d->n_pairs, NAME_BYTES);
    d->ref_names = d->group_names = a->ref_names;
    d->pair_names = a->pair_names;
    return a->ref_rgb && a->test_rgb && a->pair_ref && a->ref_group && a->delta_e && a->jod && d->pair_kind &&
           d->group_split && a->ref_names && a->pair_names && a->text;
}

static nqm_status fill_reference(const nqm_dataset *d, arrays *a, size_t ref, nqm_rng *rng, nqm_error *err) {
    const size_t width = 3 * d->n_directions;
    const material m = random_material(rng);
    float *ref_rgb = a->ref_rgb + ref * width;
    a->ref_group[ref] = (uint32_t)ref;
    a->ref_names[ref] = a->text + ref * NAME_BYTES;
    snprintf(a->text + ref * NAME_BYTES, NAME_BYTES, "material %zu", ref);
    nqm_status status = sample_material(&m, d->directions, ref_rgb, err);
    for (size_t i = ref * TESTS_PER_REF; i < (ref + 1) * TESTS_PER_REF && status == NQM_OK; ++i) {
        const material changed = change(&m, rng);
        float *test_rgb = a->test_rgb + i * width;
        status = sample_material(&changed, d->directions, test_rgb, err);
        a->pair_ref[i] = (uint32_t)ref;
        a->delta_e[i] = label_delta_e(width, ref_rgb, test_rgb);
        a->pair_names[i] = a->text + (d->n_refs + i) * NAME_BYTES;
        snprintf(a->text + (d->n_refs + i) * NAME_BYTES, NAME_BYTES, "copy %zu", i);
    }
    return status;
}

/* From 10 down to 0, in the order of Delta-E. */
static nqm_status spread_jods(const nqm_dataset *d, double *jod, nqm_error *err) {
    size_t *order = nqm_alloc(d->n_pairs, sizeof *order);
    if (!order)
        return nqm_fail_nomem(err, d->n_pairs * sizeof *order);
    nqm_ranks(d->n_pairs, d->delta_e, jod, order);
    for (size_t i = 0; i < d->n_pairs; ++i)
        jod[i] = 10 * (1 - jod[i] / (double)d->n_pairs);
    nqm_free(order);
    return NQM_OK;
}

static nqm_status fill(nqm_dataset *d, const nqm_directions *directions, nqm_error *err) {
    static const char *const kinds[] = {"random"};
    arrays a;
    nqm_status status = nqm_directions_from_degrees(nqm_directions_count(directions),
                                                    nqm_directions_degrees(directions), &d->directions, err);
    if (status != NQM_OK)
        return status;
    d->n_directions = nqm_directions_count(d->directions);
    d->directions_deg = nqm_directions_degrees(d->directions);
    d->kind_names = kinds;
    d->manifest = "{\"made_by\": \"nqm bench\"}";
    if (!allocate(d, &a))
        return nqm_fail_nomem(err, d->n_pairs * 3 * d->n_directions * sizeof(float));
    nqm_rng rng = nqm_rng_make(1, 0);
    for (size_t ref = 0; ref < d->n_refs && status == NQM_OK; ++ref)
        status = fill_reference(d, &a, ref, &rng, err);
    if (status == NQM_OK)
        status = spread_jods(d, a.jod, err);
    return status == NQM_OK ? nqm_dataset_hash(d, d->sha256, err) : status;
}

nqm_status nqm_bench_pairs(size_t n_refs, const nqm_directions *directions, nqm_dataset **dataset_ret, nqm_error *err) {
    *dataset_ret = NULL;
    nqm_dataset *d = nqm_alloc(1, sizeof *d);
    if (!d)
        return nqm_fail_nomem(err, sizeof *d);
    d->n_refs = d->n_groups = n_refs;
    d->n_pairs = n_refs * TESTS_PER_REF;
    d->n_kinds = 1;
    nqm_status status = fill(d, directions, err);
    if (status == NQM_OK)
        *dataset_ret = d;
    else
        nqm_dataset_free(d);
    return status;
}
