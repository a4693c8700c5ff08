/* SPDX-License-Identifier: MIT
 *
 * Shading models with mistakes: without one they have the bits of the models themselves, each mistake changes a model, and some are
 * what their words say, by formulas that are written here.
 */
#include "brdf/core/mistakes.h"

#include "brdf/core/spec.h"
#include "support/check.h"

enum { N = 40 };

#define GLTF_LAYERS                                                                                                    \
    ";specular=.7;specular_color=1,.6,.3;clearcoat=.6;clearcoat_roughness=.3;sheen_color=.4,.2,.6;sheen_roughness=.5"
static const char *const specs[] = {
    ("gltf:base_color=.8,.3,.1;metallic=.5;roughness=.4;anisotropy_strength=.6;ior=1.8" GLTF_LAYERS),
    "open-pbr:base_color=.8,.3,.1;base_metalness=.4;specular_roughness=.4;specular_ior=1.3;coat_weight=.6;fuzz_weight=."
    "5",
    "standard-surface:base_color=.8,.3,.1;metalness=.4;specular_roughness=.4;sheen=.5;coat=.6;coat_roughness=.3",
    "usd-preview:diffuseColor=.8,.3,.1;metallic=.4;roughness=.4;ior=1.8;clearcoat=.6;clearcoatRoughness=.3",
    "disney:baseColor=.8,.3,.1;metallic=.4;roughness=.4;sheen=.5;clearcoat=.6;clearcoatGloss=.6",
    "principled:base_color=.8,.3,.1;eta=1.8;metallic=.4;roughness=.4;clearcoat=.6",
    "blender-principled:base_color=.8,.3,.1;metallic=.4;roughness=.4;ior=1.8;coat_weight=.6;sheen_weight=.5",
    "rough-conductor:alpha=.4;eta=.2,.9,1.3;k=3.9,2.4,2.1",
    "rough-plastic:alpha=.3;diffuse_reflectance=.8,.3,.1",
    "pbrt-conductor:roughness=.2;eta=.2,.9,1.3;k=3.9,2.4,2.1",
};
enum { N_SPECS = sizeof specs / sizeof *specs };

/* Pairs of directions up to 75 degrees, in both orders of heights. */
static void make_pairs(double *wi, double *wo) {
    nqm_rng rng = nqm_rng_make(5, 0);
    for (size_t i = 0; i < 2 * N; ++i) {
        double *w = i % 2 ? wo + i / 2 * 3 : wi + i / 2 * 3;
        const double theta = 1.3 * nqm_rng_uniform(&rng), phi = 6.2 * nqm_rng_uniform(&rng);
        w[0] = sin(theta) * cos(phi);
        w[1] = sin(theta) * sin(phi);
        w[2] = cos(theta);
    }
}

static void evaluate_with(const char *spec, nqm_mistakes mistakes, const double *wi, const double *wo, float *rgb) {
    nqm_values values;
    assert_int_equal(nqm_values_parse_spec(spec, &values, NULL), NQM_OK);
    nqm_mistaken_eval(&values, &mistakes, N, wi, wo, rgb);
}

static void evaluate(const char *spec, uint64_t made, const double *wi, const double *wo, float *rgb) {
    const double amount = made == (uint64_t)1 << NQM_MISTAKE_CLAMPED ? 0.2 : 4;
    evaluate_with(spec, (nqm_mistakes){made, amount, NULL}, wi, wo, rgb);
}

TEST(models_without_mistakes_are_the_models) {
    double wi[3 * N], wo[3 * N], right[3 * N];
    float rgb[3 * N];
    make_pairs(wi, wo);
    for (size_t s = 0; s < N_SPECS; ++s) {
        nqm_brdf *brdf = must_open(specs[s]);
        nqm_brdf_eval(brdf, N, wi, wo, right, NULL);
        evaluate(specs[s], 0, wi, wo, rgb);
        for (size_t i = 0; i < 3 * N; ++i)
            assert_true(rgb[i] == (float)right[i]);
        nqm_brdf_free(brdf);
    }
}

/* And no two of a model with several lobes have the same values. */
TEST(each_mistake_changes_a_model) {
    static float rgb[NQM_N_MISTAKES + 1][3 * N];
    bool has_effect[NQM_N_MISTAKES] = {false};
    double wi[3 * N], wo[3 * N];
    make_pairs(wi, wo);
    for (size_t s = 0; s < N_SPECS; ++s) {
        for (size_t m = 0; m <= NQM_N_MISTAKES; ++m)
            evaluate(specs[s], m < NQM_N_MISTAKES ? (uint64_t)1 << m : 0, wi, wo, rgb[m]);
        for (size_t m = 0; m < NQM_N_MISTAKES; ++m) {
            if (memcmp(rgb[m], rgb[NQM_N_MISTAKES], sizeof rgb[m]) == 0)
                continue;
            has_effect[m] = true;
            for (size_t i = 0; i < 3 * N; ++i)
                assert_true(isfinite(rgb[m][i]) && rgb[m][i] >= 0);
            for (size_t k = 0; k < m; ++k)
                if (!strstr(specs[s], "conductor") && memcmp(rgb[m], rgb[k], sizeof rgb[m]) == 0)
                    fail_msg("%s: the same: %s; %s", specs[s], nqm_mistake_words(k), nqm_mistake_words(m));
        }
    }
    for (size_t m = 0; m < NQM_N_MISTAKES; ++m) {
        if (!has_effect[m])
            fail_msg("no model has: %s", nqm_mistake_words(m));
        assert_true(strlen(nqm_mistake_words(m)) > 10);
    }
}

/* D G F / (4 cos cos) of pbrt's conductor with one factor changed. */
TEST(mistakes_are_what_they_say) {
    const char *spec = specs[N_SPECS - 1];
    double wi[3 * N], wo[3 * N];
    float right[3 * N], wrong[3 * N];
    make_pairs(wi, wo);
    evaluate(spec, 0, wi, wo, right);
    const struct {
        int mistake;
        double factor, by_i, by_o; /* times cos_i^by_i cos_o^by_o */
    } cases[] = {{NQM_MISTAKE_DISTRIBUTION_WITHOUT_PI, NQM_PI, 0, 0},
                 {NQM_MISTAKE_FOUR_LEFT_OUT, 4, 0, 0},
                 {NQM_MISTAKE_FOUR_COSINES_LEFT_OUT, 4, 1, 1},
                 {NQM_MISTAKE_FOUR_COSINES_TWICE, 0.25, -1, -1},
                 {NQM_MISTAKE_FOUR_IS_PI, 4 / NQM_PI, 0, 0},
                 {NQM_MISTAKE_COSINE_INCLUDED, 1, 1, 0},
                 {NQM_MISTAKE_COSINE_OF_VIEWER, 1, 0, 1},
                 {NQM_MISTAKE_DIVIDED_BY_PI, 1 / NQM_PI, 0, 0}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        evaluate(spec, (uint64_t)1 << cases[k].mistake, wi, wo, wrong);
        for (size_t i = 0; i < N; ++i) {
            const double factor =
                cases[k].factor * pow(wi[3 * i + 2], cases[k].by_i) * pow(wo[3 * i + 2], cases[k].by_o);
            assert_near((double)wrong[3 * i] / (double)right[3 * i], factor, 1e-5 * factor);
        }
    }
    const double alpha2 = 0.2;
    evaluate(spec, (uint64_t)1 << NQM_MISTAKE_SHADOWING_SEPARABLE, wi, wo, wrong);
    for (size_t i = 0; i < N; ++i) {
        double lambda[2];
        for (size_t side = 0; side < 2; ++side) {
            const double c = (side ? wo : wi)[3 * i + 2];
            lambda[side] = (sqrt(1 + alpha2 * (1 / (c * c) - 1)) - 1) / 2;
        }
        const double factor = (1 + lambda[0] + lambda[1]) / ((1 + lambda[0]) * (1 + lambda[1]));
        assert_near((double)wrong[3 * i] / (double)right[3 * i], factor, 1e-5 * factor);
    }
    evaluate(spec, (uint64_t)1 << NQM_MISTAKE_CLAMPED, wi, wo, wrong);
    for (size_t i = 0; i < 3 * N; ++i)
        assert_true(wrong[i] == fminf(right[i], 0.2F));
    /* Two at once. */
    evaluate_with(spec, (nqm_mistakes){(uint64_t)1 << NQM_MISTAKE_TIMES_PI, 0, "bgr"}, wi, wo, wrong);
    for (size_t i = 0; i < 3 * N; ++i)
        assert_near((double)wrong[i], NQM_PI * (double)right[i / 3 * 3 + 2 - i % 3], 1e-5 * (double)wrong[i]);
}

/* Where each channel is from, and which one leaks into which. */
TEST(wrong_channels) {
    static const char *const channels[] = {"bgr", "rrb", "gbr", "rg", "rb", "gr", "gb", "br", "bg"};
    double wi[3 * N], wo[3 * N];
    float right[3 * N], wrong[3 * N];
    make_pairs(wi, wo);
    evaluate(specs[0], 0, wi, wo, right);
    for (size_t k = 0; k < sizeof channels / sizeof *channels; ++k) {
        const char *of = channels[k];
        size_t at[3] = {0};
        for (size_t c = 0; c < strlen(of); ++c)
            at[c] = of[c] == 'r' ? 0 : of[c] == 'g' ? 1 : 2;
        evaluate_with(specs[0], (nqm_mistakes){0, 0.5, of}, wi, wo, wrong);
        for (size_t i = 0; i < 3 * N; ++i) {
            const float *v = right + i / 3 * 3, leak = strlen(of) == 2 && at[0] == i % 3 ? 0.5F * v[at[1]] : 0;
            const float expected = strlen(of) == 3 ? v[at[i % 3]] : v[i % 3] + leak;
            assert_near((double)wrong[i], (double)expected, 1e-5 * (double)expected);
        }
    }
}

/* f = (F0 + (1 - F0) (1 - cos)^p) times the lobe of a metal. */
TEST(exponent_of_schlick) {
    const char *spec = "gltf:base_color=.8,.3,.1;roughness=.4";
    double wi[3 * N], wo[3 * N];
    float right[3 * N], constant[3 * N], wrong[3 * N];
    make_pairs(wi, wo);
    evaluate(spec, 0, wi, wo, right);
    evaluate(spec, (uint64_t)1 << NQM_MISTAKE_FRESNEL_CONSTANT, wi, wo, constant);
    evaluate(spec, (uint64_t)1 << NQM_MISTAKE_SCHLICK_EXPONENT, wi, wo, wrong);
    for (size_t i = 0; i < 3 * N; ++i) {
        const double *in = wi + i / 3 * 3, *out = wo + i / 3 * 3;
        const double cos_d = sqrt(0.5 * (1 + in[0] * out[0] + in[1] * out[1] + in[2] * out[2]));
        assert_near((double)(wrong[i] - constant[i]) * (1 - cos_d), (double)(right[i] - constant[i]),
                    1e-6 * (1 + (double)right[i]));
    }
}
