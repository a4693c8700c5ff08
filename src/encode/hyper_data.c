/* SPDX-License-Identifier: MIT
 *
 * Input samples and training examples of the hypernetwork. Direction pairs are dense around the mirror direction, because few
 * samples would otherwise miss narrow lobes, and values are on two logarithmic scales, one that resolves dark bases and one
 * for bright highlights. A few hundred references are too few, so they are augmented: copies with another
 * gloss and highlight, mixtures of two references, exchanged and scaled channels.
 */
#include "brdf/brdf.h"
#include "encode/hyper.h"
#include "encode/nbrdf_net.h"
#include "math/math.h"

#include <math.h>
#include <string.h>

/* ---- input samples ----------------------------------------------------------------------------------------------- */

static const double max_polar_rad = 80 * NQM_PI / 180; /* measurements at larger angles are often extrapolated */

/* theta_d and phi_d uniform up to 90 and 180 degrees. */
static void draw_dense(nqm_rng *rng, double *hd) {
    nqm_encode_draw_dense(rng, max_polar_rad, NQM_PI / 2, NQM_PI, hd);
}

void nqm_hyper_place(const double *hd, float *feature) {
    double wi[3], wo[3], difference[3];
    nqm_half_diff_to_pair(hd, wi, wo);
    nqm_spherical(hd[1], hd[2], difference);
    feature[0] = (float)sin(hd[0]);
    feature[1] = (float)cos(hd[0]);
    for (size_t k = 0; k < 3; ++k)
        feature[2 + k] = (float)difference[k];
    feature[5] = (float)(2 * sqrt(hd[0] / (NQM_PI / 2)) - 1);
    feature[6] = (float)(2 * wi[2] * wo[2] - 1);
}

void nqm_hyper_value(const float *rgb, float *feature) {
    const float dark = 1e-3f, centre = 2, spread = 0.5f;
    for (size_t c = 0; c < 3; ++c) {
        feature[c] = spread * (logf(rgb[c] + dark) + centre);
        feature[3 + c] = log1pf(rgb[c]);
    }
}

nqm_status nqm_hyper_sample(const nqm_brdf *ref, size_t n, nqm_rng *rng, double *hd, double *rgb, nqm_error *err) {
    const size_t kept = nqm_encode_sample(ref, n, draw_dense, rng, hd, rgb);
    return kept == n ? NQM_OK
                     : nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: values at only %zu of %zu directions",
                                nqm_brdf_get_info(ref).name, kept, n);
}

/* ---- sampling the references ------------------------------------------------------------------------------------- */

/* `ref` with a lobe of another width and height. */
static nqm_status perturb(const nqm_brdf *ref, uint64_t seed, size_t i, nqm_brdf **brdf_ret, nqm_error *err) {
    const double range = 0.5; /* range of the logarithm */
    nqm_rng rng = nqm_rng_make(seed, i);
    double gloss = exp(range * (2 * nqm_rng_uniform(&rng) - 1)), peak = exp(range * (2 * nqm_rng_uniform(&rng) - 1));
    char settings[80], number[2][32];
    nqm_format_double(number[0], sizeof number[0], nqm_round_digits(gloss, 3));
    nqm_format_double(number[1], sizeof number[1], nqm_round_digits(peak, 3));
    snprintf(settings, sizeof settings, "gloss=%s;peak=%s", number[0], number[1]);
    return nqm_wrapper_make(nqm_spec_wrapper_of("perturb:"), settings,
                            &(nqm_between_bases){.of = (nqm_brdf *)(uintptr_t)ref}, brdf_ret, err);
}

/* Values of `brdf` at hd (n, 3). At least three quarters must be valid, because examples are drawn by rejection. */
static nqm_status sample(const nqm_brdf *brdf, size_t n, const double *hd, const char *name, float *rgb,
                         nqm_error *err) {
    double *values;
    uint8_t *flag;
    size_t n_valid = 0;
    nqm_status status = nqm_alloc_arrays(NQM_ARRAYS({&values, n, 3 * sizeof(double)}, {&flag, n, 1}), err);
    if (status != NQM_OK)
        return status;
    nqm_brdf_eval_half_diff(brdf, n, hd, values, flag);
    for (size_t i = 0; i < n; ++i) {
        bool valid = nqm_has_value(flag[i]);
        n_valid += valid;
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = valid ? (float)values[3 * i + c] : NAN;
    }
    nqm_free(values);
    return n_valid >= n - n / 4
               ? NQM_OK
               : nqm_fail(err, NQM_ERR_INCOMPATIBLE, -1, "%s: values at only %zu of %zu directions", name, n_valid, n);
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
    double wi[3], wo[3];
    for (size_t i = 0; i < data->n_places; ++i) {
        if (i < data->n_places / 2) {
            draw_dense(&rng, hd + 3 * i);
        } else {
            nqm_encode_draw_uniform(&rng, max_polar_rad, wi, wo);
            nqm_half_diff_from_pair(wi, wo, hd + 3 * i);
        }
        nqm_hyper_place(hd + 3 * i, data->place + NQM_HYPER_PLACE * i);
    }
    nqm_nbrdf_inputs(data->n_places, hd, data->input, data->weight);
}

nqm_status nqm_hyper_data_create(size_t n, const nqm_brdf *const *refs, size_t n_places, uint64_t seed,
                                 nqm_ticker *ticker, nqm_hyper_data *data_ret, nqm_error *err) {
    *data_ret = (nqm_hyper_data){.n_refs = 2 * n, .n_places = n_places};
    double *hd;
    nqm_status status = nqm_alloc_arrays(
        NQM_ARRAYS({&data_ret->place, n_places, NQM_HYPER_PLACE * sizeof(float)}, {&hd, n_places, 3 * sizeof(double)},
                   {&data_ret->input, n_places, 6 * sizeof(float)}, {&data_ret->weight, n_places, sizeof(float)},
                   {&data_ret->rgb, 2 * n, 3 * n_places * sizeof(float)}),
        err);
    if (status == NQM_OK)
        draw_places(seed, data_ret, hd);
    for (size_t i = 0; status == NQM_OK && i < n; ++i) {
        status = sample_both(refs[i], hd, seed, i, data_ret, err);
        if (status == NQM_OK && nqm_tick(ticker, "sample", (double)(i + 1), (double)n))
            status = nqm_fail(err, NQM_ERR_CANCELLED, -1, "stopped");
    }
    return status;
}

/* ---- drawing examples -------------------------------------------------------------------------------------------- */

/* A synthetic material: a mixture of two references with permuted and scaled channels. */
typedef struct material {
    const float *rgb[2];
    float weight[2], scale[3];
    size_t channel[3];
} material;

static material draw_material(const nqm_hyper_data *data, nqm_rng *rng) {
    const double p_mix = 0.3, p_exchange = 0.5, p_scale = 0.7, common = 0.4, apart = 0.25;
    material m = {.weight = {1, 0}, .scale = {1, 1, 1}, .channel = {0, 1, 2}};
    for (size_t k = 0; k < 2; ++k)
        m.rgb[k] = data->rgb + 3 * data->n_places * nqm_rng_below(rng, data->n_refs);
    if (nqm_rng_uniform(rng) < p_mix) {
        m.weight[1] = (float)nqm_rng_uniform(rng);
        m.weight[0] = 1 - m.weight[1];
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

/* Draw one of the n places from `first` where the material has a value; rgb (3) receives it. */
static size_t draw_place(const material *m, nqm_rng *rng, size_t first, size_t n, float *rgb) {
    for (;;) {
        size_t i = first + nqm_rng_below(rng, n);
        for (size_t c = 0; c < 3; ++c) {
            size_t from = 3 * i + m->channel[c];
            rgb[c] = m->scale[c] *
                     (m->weight[0] * m->rgb[0][from] + (m->weight[1] > 0 ? m->weight[1] * m->rgb[1][from] : 0));
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
        bool dense = i % 4 == 0; /* most of a picture shows no highlight */
        size_t at = draw_place(&m, rng, dense ? 0 : n_dense, n_dense, rgb);
        for (size_t k = 0; k < 6; ++k)
            example->input[k * n + i] = data->input[k * data->n_places + at];
        example->weight[i] = data->weight[at];
        for (size_t c = 0; c < 3; ++c)
            example->goal[c * n + i] = log1pf(data->weight[at] * rgb[c]);
    }
}
