/* SPDX-License-Identifier: MIT */
#include "support/toy_dataset.h"
#include "math/math.h"
#include "metric/metric.h"
#include "support/predict.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

toy_options toy_options_default(void) {
    return (toy_options){.n_directions = 16,
                         .n_groups = 24,
                         .pairs_per_ref = 12,
                         .splits = true,
                         .families = {"perturbation", "encoding"},
                         .seed = 1};
}

static void must(nqm_status status) {
    if (status != NQM_OK)
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

static void fill_mask(size_t n_rows, size_t n_directions, nqm_rng *rng, uint8_t *used) {
    for (size_t i = 0; i < n_rows * n_directions; ++i)
        used[i] = i % n_directions == 0 || nqm_rng_uniform(rng) > 0.1;
}

/* Light from random directions on two scenes of different size. */
static void fill_transport(nqm_dataset *d, nqm_rng *rng) {
    const size_t n_first = 40;
    for (size_t i = 0; i < d->n_directions * 3 * NQM_TRANSPORT_POINTS; ++i)
        d->transport[i] = nqm_rng_uniform(rng) < 0.5 ? (float)(20 * nqm_rng_uniform(rng)) : 0;
    for (size_t i = 0; i < NQM_TRANSPORT_POINTS; ++i) {
        const bool is_first = i < n_first;
        d->transport_points[3 * i] = 1 / (double)(is_first ? n_first : NQM_TRANSPORT_POINTS - n_first);
        d->transport_points[3 * i + 1] = is_first ? 0 : 1;
        d->transport_points[3 * i + 2] = 1000;
    }
}

/* Add one test: a copy of the reference's lobe that is scaled (gain) or has another width (gloss). */
static void add_test(nqm_dataset *d, const toy_options *o, size_t ref, lobe l, nqm_rng *rng) {
    const size_t p = d->n_pairs, n = 3 * d->n_directions;
    const bool is_gloss = p % 2;
    const double amount = exp(1.5 * nqm_rng_uniform(rng) * nqm_rng_uniform(rng) - 0.1);
    uint32_t kind;
    char name[32];
    snprintf(name, sizeof name, "test %zu", p);
    if (is_gloss)
        l.width *= amount;
    for (size_t k = 0; k < 3; ++k)
        l.albedo[k] *= is_gloss ? 1 : amount;
    sample_lobe(d, &l, d->test_rgb + p * n);
    const double delta_e = label_delta_e(n, d->ref_rgb + ref * n, d->test_rgb + p * n);
    must(nqm_dataset_add_kind(d, is_gloss ? "gloss" : "gain", o->families[is_gloss], &kind, NULL));
    must(nqm_dataset_add_pair(d, (uint32_t)ref, name, kind, delta_e, nqm_curve_jod(&nqm_curve_published, delta_e),
                              NULL));
}

/* Parts of labels; then the matrix is changed a little, so that its estimates are not exact. */
static void fill_parts(nqm_dataset *d, nqm_rng *rng) {
    const size_t n = 3 * d->n_directions;
    const nqm_transport transport = nqm_dataset_transport(d);
    for (size_t p = 0; p < d->n_pairs; ++p) {
        const nqm_label label =
            transport_estimate(&transport, d->ref_rgb + d->pair_ref[p] * n, d->test_rgb + p * n, NULL);
        nqm_label_get_parts(&label, d->parts + p * NQM_LABEL_PARTS);
        d->delta_e_error[p] = 0.01 * label.delta_e;
    }
    for (size_t i = 0; i < d->n_directions * 3 * NQM_TRANSPORT_POINTS; ++i)
        d->transport[i] *= (float)(0.8 + 0.4 * nqm_rng_uniform(rng));
}

nqm_dataset *toy_dataset(const toy_options *o) {
    const size_t n_refs = 2 * o->n_groups;
    nqm_rng rng = nqm_rng_make(o->seed, 0);
    double *degrees = nqm_alloc(o->n_directions, 3 * sizeof *degrees);
    lobe *lobes = nqm_alloc(n_refs, sizeof *lobes);
    nqm_dataset *d, *dataset;
    if (!degrees || !lobes)
        abort();
    for (size_t i = 0; i < o->n_directions; ++i) {
        degrees[3 * i] = 60 * pow(nqm_rng_uniform(&rng), 2);
        degrees[3 * i + 1] = 30 * nqm_rng_uniform(&rng);
        degrees[3 * i + 2] = 180 * nqm_rng_uniform(&rng);
    }
    const nqm_dataset_limits limits = {.n_directions = o->n_directions,
                                       .directions_deg = degrees,
                                       .max_refs = n_refs,
                                       .max_pairs = n_refs * o->pairs_per_ref,
                                       .has_masks = o->with_masks,
                                       .has_parts = o->with_transport,
                                       .has_transport = o->with_transport};
    must(nqm_dataset_begin(&limits, &d, NULL));
    for (size_t r = 0; r < n_refs; ++r) {
        char name[32];
        uint32_t group;
        const size_t g = r / 2;
        snprintf(name, sizeof name, "material %zu", g);
        must(nqm_dataset_add_group(d, name, strlen(name),
                                   o->splits && g % 4 == 1   ? NQM_SPLIT_VALIDATION
                                   : o->splits && g % 4 == 3 ? NQM_SPLIT_TEST
                                                             : NQM_SPLIT_TRAIN,
                                   &group, NULL));
        snprintf(name, sizeof name, "reference %zu", r);
        lobes[r] = random_lobe(&rng);
        sample_lobe(d, &lobes[r], d->ref_rgb + r * 3 * o->n_directions);
        must(nqm_dataset_add_reference(d, name, group, NULL));
    }
    for (size_t r = 0; r < n_refs; ++r)
        for (size_t i = 0; i < o->pairs_per_ref; ++i)
            add_test(d, o, r, lobes[r], &rng);
    if (o->with_masks) {
        fill_mask(n_refs, o->n_directions, &rng, d->ref_used);
        fill_mask(limits.max_pairs, o->n_directions, &rng, d->test_used);
    }
    if (o->with_transport) {
        fill_transport(d, &rng);
        fill_parts(d, &rng);
    }
    char manifest[100] = "{\"made_by\": \"toy_dataset\"}";
    if (o->unseen)
        snprintf(manifest, sizeof manifest, "{\"unseen_kinds\": [\"%s\"]}", o->unseen);
    must(nqm_dataset_finish(d, NQM_OK, manifest, NULL, &dataset, NULL));
    nqm_free(degrees);
    nqm_free(lobes);
    return dataset;
}
