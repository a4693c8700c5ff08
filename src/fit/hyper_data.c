/* SPDX-License-Identifier: MIT
 *
 * Training examples of the hypernetwork. A few hundred references are few: each is sampled once more with another gloss
 * and highlight, two of them may be mixed, channels are exchanged and scaled.
 */
#include "brdf/brdf.h"
#include "fit/hyper.h"
#include "fit/nbrdf_net.h"

#include <math.h>
#include <string.h>

/* ---- sampling the references ------------------------------------------------------------------------------------- */

/* A BRDF lent to a perturbation, which would own and free it. */
static void lent_eval_half_diff(const void *self, size_t n, const double *hd, double *rgb) {
    uint8_t flag[256];
    for (size_t from = 0; from < n; from += sizeof flag) {
        size_t count = n - from < sizeof flag ? n - from : sizeof flag;
        nqm_brdf_eval_half_diff(self, count, hd + 3 * from, rgb + 3 * from, flag);
        for (size_t i = 0; i < count; ++i)
            if (flag[i] == NQM_VALUE_INVALID)
                rgb[3 * (from + i)] = (double)NAN;
    }
}

static void keep(void *self) {
    (void)self;
}

static const nqm_brdf_class lent_class = {.format = "lent", .eval_half_diff = lent_eval_half_diff, .free = keep};

/* `ref` with a lobe of another width and height. */
static nqm_status perturb(const nqm_brdf *ref, uint64_t seed, size_t i, nqm_brdf **brdf_ret, nqm_error *err) {
    const double most = 0.5; /* in log units */
    nqm_rng rng = nqm_rng_make(seed, i);
    double gloss = exp(most * (2 * nqm_rng_uniform(&rng) - 1)), peak = exp(most * (2 * nqm_rng_uniform(&rng) - 1));
    char settings[80], number[2][32];
    nqm_format_double(number[0], sizeof number[0], nqm_round_digits(gloss, 3));
    nqm_format_double(number[1], sizeof number[1], nqm_round_digits(peak, 3));
    snprintf(settings, sizeof settings, "gloss=%s;peak=%s", number[0], number[1]);
    nqm_brdf *lent;
    nqm_status status = nqm_brdf_wrap(&lent_class, (void *)(uintptr_t)ref, "lent", NULL, NULL, &lent, err);
    return status == NQM_OK ? nqm_perturb_wrap(settings, lent, brdf_ret, err) : status;
}

/* Values of `brdf` at the places hd; too few are refused, so that examples can be drawn by trial. */
static nqm_status sample(const nqm_brdf *brdf, size_t n, const double *hd, const char *name, float *rgb,
                         nqm_error *err) {
    double *values = nqm_alloc(n, 3 * sizeof *values);
    uint8_t *flag = nqm_alloc(n, 1);
    nqm_status status = NQM_OK;
    if (!values || !flag) {
        status = nqm_fail_nomem(err, 3 * n * sizeof *values);
    } else {
        size_t n_valid = 0;
        nqm_brdf_eval_half_diff(brdf, n, hd, values, flag);
        for (size_t i = 0; i < n; ++i) {
            bool valid = flag[i] == NQM_VALUE_OK || flag[i] == NQM_VALUE_CLAMPED;
            n_valid += valid;
            for (size_t c = 0; c < 3; ++c)
                rgb[3 * i + c] = valid ? (float)values[3 * i + c] : NAN;
        }
        if (n_valid < n - n / 4)
            status =
                nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: values at only %zu of %zu directions", name, n_valid, n);
    }
    nqm_free(values);
    nqm_free(flag);
    return status;
}

static nqm_status sample_both(const nqm_brdf *ref, const double *hd, uint64_t seed, size_t i, nqm_hyper_data *data,
                              nqm_error *err) {
    const char *name = nqm_brdf_get_info(ref).name;
    float *rgb = data->rgb + 2 * i * 3 * data->n_places;
    nqm_brdf *glossier = NULL;
    nqm_status status = sample(ref, data->n_places, hd, name, rgb, err);
    if (status == NQM_OK)
        status = perturb(ref, seed, i, &glossier, err);
    if (status == NQM_OK)
        status = sample(glossier, data->n_places, hd, name, rgb + 3 * data->n_places, err);
    nqm_brdf_free(glossier);
    return status;
}

static void draw_places(uint64_t seed, nqm_hyper_data *data, double *hd) {
    nqm_rng rng = nqm_rng_make(seed, 0);
    for (size_t i = 0; i < data->n_places; ++i) {
        if (i < data->n_places / 2)
            nqm_hyper_draw_dense(&rng, hd + 3 * i);
        else
            nqm_hyper_draw_uniform(&rng, hd + 3 * i);
        nqm_hyper_place(hd + 3 * i, data->place + NQM_HYPER_PLACE * i);
    }
    nqm_nbrdf_inputs(data->n_places, hd, data->input, data->weight);
}

nqm_status nqm_hyper_data_create(size_t n, const nqm_brdf *const *refs, size_t n_places, uint64_t seed,
                                 nqm_ticker *ticker, nqm_hyper_data *data_ret, nqm_error *err) {
    *data_ret = (nqm_hyper_data){.n_refs = 2 * n, .n_places = n_places};
    data_ret->place = nqm_alloc(n_places, NQM_HYPER_PLACE * sizeof(float));
    data_ret->input = nqm_alloc(n_places, 6 * sizeof(float));
    data_ret->weight = nqm_alloc(n_places, sizeof(float));
    data_ret->rgb = nqm_alloc(2 * n, 3 * n_places * sizeof(float));
    double *hd = nqm_alloc(n_places, 3 * sizeof *hd);
    nqm_status status = NQM_OK;
    if (!data_ret->place || !data_ret->input || !data_ret->weight || !data_ret->rgb || !hd)
        status = nqm_fail_nomem(err, 2 * n * 3 * n_places * sizeof(float));
    else
        draw_places(seed, data_ret, hd);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        status = sample_both(refs[i], hd, seed, i, data_ret, err);
        if (status == NQM_OK && nqm_tick(ticker, "sample", (double)(i + 1), (double)n))
            status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "stopped");
    }
    nqm_free(hd);
    return status;
}

void nqm_hyper_data_free(nqm_hyper_data *data) {
    nqm_free(data->place);
    nqm_free(data->input);
    nqm_free(data->weight);
    nqm_free(data->rgb);
    *data = (nqm_hyper_data){0};
}

/* ---- drawing examples -------------------------------------------------------------------------------------------- */

/* A material that does not exist: two references mixed, their channels exchanged, then scaled. */
typedef struct material {
    const float *rgb[2];
    float share[2], scale[3];
    size_t channel[3];
} material;

static material draw_material(const nqm_hyper_data *data, nqm_rng *rng) {
    const double p_mix = 0.3, p_exchange = 0.5, p_scale = 0.7, common = 0.4, apart = 0.25;
    material m = {.share = {1, 0}, .scale = {1, 1, 1}, .channel = {0, 1, 2}};
    for (size_t k = 0; k < 2; ++k)
        m.rgb[k] = data->rgb + 3 * data->n_places * nqm_rng_below(rng, data->n_refs);
    if (nqm_rng_uniform(rng) < p_mix) {
        m.share[1] = (float)nqm_rng_uniform(rng);
        m.share[0] = 1 - m.share[1];
    }
    if (nqm_rng_uniform(rng) < p_exchange)
        nqm_rng_shuffle(rng, 3, m.channel);
    if (nqm_rng_uniform(rng) < p_scale) {
        double all = common * nqm_rng_normal(rng);
        for (size_t c = 0; c < 3; ++c)
            m.scale[c] = (float)exp(all + apart * nqm_rng_normal(rng));
    }
    return m;
}

/* A place among `n` from `first` where the material has a value. */
static size_t draw_place(const material *m, nqm_rng *rng, size_t first, size_t n, float *rgb) {
    for (;;) {
        size_t i = first + nqm_rng_below(rng, n);
        for (size_t c = 0; c < 3; ++c) {
            size_t from = 3 * i + m->channel[c];
            rgb[c] =
                m->scale[c] * (m->share[0] * m->rgb[0][from] + (m->share[1] > 0 ? m->share[1] * m->rgb[1][from] : 0));
        }
        if (!isnan(rgb[0]))
            return i;
    }
}

void nqm_hyper_draw_example(const nqm_hyper_data *data, nqm_rng *rng, const nqm_hyper_example *example) {
    material m = draw_material(data, rng);
    size_t n_dense = data->n_places / 2, n = example->n_queries;
    float rgb[3];
    for (size_t i = 0; i < example->n_samples; ++i) {
        float *feature = example->samples + i * NQM_HYPER_FEATURES;
        size_t at = draw_place(&m, rng, 0, n_dense, rgb);
        memcpy(feature, data->place + at * NQM_HYPER_PLACE, NQM_HYPER_PLACE * sizeof *feature);
        nqm_hyper_value(rgb, feature + NQM_HYPER_PLACE);
    }
    for (size_t i = 0; i < n; ++i) {
        bool dense = i % 4 == 0; /* most of a picture is away from the highlight */
        size_t at = draw_place(&m, rng, dense ? 0 : n_dense, n_dense, rgb);
        for (size_t k = 0; k < 6; ++k)
            example->input[k * n + i] = data->input[k * data->n_places + at];
        example->weight[i] = data->weight[at];
        for (size_t c = 0; c < 3; ++c)
            example->goal[c * n + i] = log1pf(data->weight[at] * rgb[c]);
    }
}
