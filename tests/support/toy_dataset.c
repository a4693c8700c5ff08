/* SPDX-License-Identifier: MIT */
#include "support/toy_dataset.h"
#include "percept/percept.h"

#include "math/math.h"

#include <math.h>
#include <stdlib.h>

toy_options toy_options_default(void) {
    return (toy_options){.n_directions = 16, .n_groups = 24, .pairs_per_ref = 12, .splits = true, .seed = 1};
}

static void *take(nqm_dataset *d, size_t n, size_t size) {
    void *block = nqm_dataset_alloc(d, n, size);
    if (!block)
        abort();
    return block;
}

static const char **numbered_names(nqm_dataset *d, const char *stem, size_t n) {
    enum { NAME_BYTES = 32 };
    const char **names = take(d, n, sizeof *names);
    char *text = take(d, n, NAME_BYTES);
    for (size_t i = 0; i < n; ++i) {
        snprintf(text + i * NAME_BYTES, NAME_BYTES, "%s %zu", stem, i);
        names[i] = text + i * NAME_BYTES;
    }
    return names;
}

static void fill_directions(nqm_dataset *d, nqm_rng *rng) {
    double *degrees = take(d, d->n_directions, 3 * sizeof *degrees);
    for (size_t i = 0; i < d->n_directions; ++i) {
        degrees[3 * i] = 60 * pow(nqm_rng_uniform(rng), 2);
        degrees[3 * i + 1] = 30 * nqm_rng_uniform(rng);
        degrees[3 * i + 2] = 180 * nqm_rng_uniform(rng);
    }
    d->directions_deg = degrees;
    if (nqm_directions_from_degrees(d->n_directions, degrees, &d->directions, NULL) != NQM_OK)
        abort();
}

/* f_r = albedo / pi + strength exp(-(theta_h / width)^2), width in degrees. */
typedef struct lobe {
    double albedo[3], strength, width;
} lobe;

static lobe random_lobe(nqm_rng *rng) {
    lobe l = {.strength = exp(3 * nqm_rng_uniform(rng) - 2), .width = 5 + 25 * nqm_rng_uniform(rng)};
    for (int k = 0; k < 3; ++k)
        l.albedo[k] = 0.05 + 0.7 * nqm_rng_uniform(rng);
    return l;
}

static void sample_lobe(const nqm_dataset *d, const lobe *l, float *rgb) {
    for (size_t i = 0; i < d->n_directions; ++i) {
        double x = d->directions_deg[3 * i] / l->width, spec = l->strength * exp(-x * x);
        for (size_t k = 0; k < 3; ++k)
            rgb[3 * i + k] = (float)(l->albedo[k] / NQM_PI + spec);
    }
}

static double label_delta_e(size_t n, const float *ref, const float *test) {
    double sum = 0;
    for (size_t i = 0; i < n; ++i)
        sum += fabs(log((double)test[i] + 0.003) - log((double)ref[i] + 0.003));
    return 40 * sum / (double)n;
}

static uint8_t *make_mask(nqm_dataset *d, size_t n_rows, nqm_rng *rng) {
    uint8_t *used = take(d, n_rows, d->n_directions);
    for (size_t i = 0; i < n_rows * d->n_directions; ++i)
        used[i] = i % d->n_directions == 0 || nqm_rng_uniform(rng) > 0.1;
    return used;
}

static void fill_pairs(nqm_dataset *d, const lobe *lobes, size_t per_ref, nqm_rng *rng) {
    size_t n = 3 * d->n_directions;
    float *test_rgb = take(d, d->n_pairs, n * sizeof *test_rgb);
    uint32_t *pair_ref = take(d, d->n_pairs, sizeof *pair_ref), *pair_kind = take(d, d->n_pairs, sizeof *pair_kind);
    double *delta_e = take(d, d->n_pairs, sizeof *delta_e), *jod = take(d, d->n_pairs, sizeof *jod);
    for (size_t p = 0; p < d->n_pairs; ++p) {
        size_t ref = p / per_ref;
        lobe l = lobes[ref];
        double amount = exp(1.5 * nqm_rng_uniform(rng) * nqm_rng_uniform(rng) - 0.1);
        pair_ref[p] = (uint32_t)ref;
        pair_kind[p] = p % 2;
        if (pair_kind[p])
            l.width *= amount;
        for (size_t k = 0; k < 3; ++k)
            l.albedo[k] *= pair_kind[p] ? 1 : amount;
        sample_lobe(d, &l, test_rgb + p * n);
        delta_e[p] = label_delta_e(n, d->ref_rgb + ref * n, test_rgb + p * n);
        jod[p] = nqm_curve_jod(&nqm_curve_published, delta_e[p]);
    }
    d->test_rgb = test_rgb;
    d->pair_ref = pair_ref;
    d->pair_kind = pair_kind;
    d->delta_e = delta_e;
    d->jod = jod;
}

nqm_dataset *toy_dataset(const toy_options *o) {
    nqm_dataset *d = nqm_alloc(1, sizeof *d);
    nqm_rng rng = nqm_rng_make(o->seed, 0);
    if (!d)
        abort();
    d->n_directions = o->n_directions;
    d->n_groups = o->n_groups;
    d->n_refs = 2 * o->n_groups;
    d->n_kinds = 2;
    d->n_pairs = d->n_refs * o->pairs_per_ref;
    fill_directions(d, &rng);
    lobe *lobes = take(d, d->n_refs, sizeof *lobes);
    float *ref_rgb = take(d, d->n_refs, 3 * d->n_directions * sizeof *ref_rgb);
    uint32_t *ref_group = take(d, d->n_refs, sizeof *ref_group);
    uint8_t *group_split = take(d, d->n_groups, 1);
    for (size_t r = 0; r < d->n_refs; ++r) {
        lobes[r] = random_lobe(&rng);
        sample_lobe(d, &lobes[r], ref_rgb + r * 3 * d->n_directions);
        ref_group[r] = (uint32_t)(r / 2);
    }
    for (size_t g = 0; o->splits && g < d->n_groups; ++g)
        group_split[g] = g % 4 == 1 ? NQM_SPLIT_VALIDATION : g % 4 == 3 ? NQM_SPLIT_TEST : NQM_SPLIT_TRAIN;
    d->ref_rgb = ref_rgb;
    d->ref_group = ref_group;
    d->group_split = group_split;
    fill_pairs(d, lobes, o->pairs_per_ref, &rng);
    if (o->with_masks) {
        d->ref_used = make_mask(d, d->n_refs, &rng);
        d->test_used = make_mask(d, d->n_pairs, &rng);
    }
    d->ref_names = numbered_names(d, "reference", d->n_refs);
    d->group_names = numbered_names(d, "material", d->n_groups);
    d->pair_names = numbered_names(d, "test", d->n_pairs);
    static const char *const kinds[] = {"gain", "gloss"};
    static const char *const families[] = {"perturbation", "encoding"};
    d->kind_names = kinds;
    d->kind_families = families;
    d->manifest = "{\"made_by\": \"toy_dataset\"}";
    if (nqm_dataset_hash(d, d->sha256, NULL) != NQM_OK)
        abort();
    return d;
}
