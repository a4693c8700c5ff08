/* SPDX-License-Identifier: MIT
 *
 * Scores of textures: means of the scores of their texels, whatever their order and the number of threads; samples
 * within their error; far scores; blame and mistakes by name; cancelling and lack of memory.
 */
#include "base/memory_test.h"
#include "metric/metric.h"
#include "support/check.h"
#include "texture/score.h"
#include "texture/texture.h"

#include <time.h>

enum { SIDE = 32, N = SIDE * SIDE };

static nqm_model *model;
static float colors[3 * N], rough[N], metal[N], normals[3 * N];

/* Smooth maps with details. */
static int setup(void **state) {
    (void)state;
    nqm_rng rng = nqm_rng_make(7, 0);
    for (size_t i = 0; i < N; ++i) {
        const float x = (float)(i % SIDE) / SIDE, y = (float)(i / SIDE) / SIDE;
        for (size_t c = 0; c < 3; ++c)
            colors[3 * i + c] = 0.1f + 0.6f * x * (float)(c + 1) / 3 + 0.1f * (float)nqm_rng_uniform(&rng);
        rough[i] = 0.15f + 0.6f * y + 0.1f * (float)nqm_rng_uniform(&rng);
        metal[i] = x > 0.3f && y > 0.4f ? 0.95f : 0.05f;
        normals[3 * i] = 0.3f * sinf(9 * x);
        normals[3 * i + 1] = 0.2f + 0.2f * cosf(7 * y);
        normals[3 * i + 2] = 1;
    }
    return nqm_model_builtin("default", &model, NULL) != NQM_OK;
}

static int teardown(void **state) {
    (void)state;
    nqm_model_free(model);
    return 0;
}

/* Maps of the size SIDE x height; NULL: none. */
static nqm_texture *make_of(size_t width, size_t height, const float *color, const float *roughness,
                            const float *metallic, const float *normal) {
    nqm_texture_map maps[4];
    size_t n = 0;
    nqm_texture *texture;
    nqm_error err = {0};
    if (color)
        maps[n++] = (nqm_texture_map){"base_color", height, width, 3, color};
    if (roughness)
        maps[n++] = (nqm_texture_map){"roughness", height, width, 1, roughness};
    if (metallic)
        maps[n++] = (nqm_texture_map){"metallic", height, width, 1, metallic};
    if (normal)
        maps[n++] = (nqm_texture_map){"normal", height, width, 3, normal};
    if (nqm_texture_create("gltf:base_color=.5,.4,.3;metallic=0;roughness=.3", n, maps, &texture, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return texture;
}

static nqm_texture *make(const float *color, const float *roughness, const float *metallic, const float *normal) {
    return make_of(SIDE, SIDE, color, roughness, metallic, normal);
}

static nqm_texture_options options_of(int blame, int far) {
    nqm_texture_options options = nqm_texture_options_default();
    options.blame = blame;
    options.far = far;
    return options;
}

static nqm_texture_result score(nqm_texture *ref, nqm_texture *test, const nqm_texture_options *options, float *map) {
    nqm_texture_result result;
    nqm_error err = {0};
    if (nqm_texture_score(model, ref, test, options, &result, map, &err) != NQM_OK)
        fail_msg("%s", err.message);
    nqm_texture_free(ref);
    nqm_texture_free(test);
    return result;
}

static nqm_score_result score_specs(const char *ref, const char *test) {
    nqm_brdf *brdf[2] = {must_open(ref), must_open(test)};
    nqm_score_result result;
    assert_int_equal(nqm_score(model, brdf[0], 1, (const nqm_brdf *const *)&brdf[1], NULL, &result, NULL), NQM_OK);
    nqm_brdf_free(brdf[0]);
    nqm_brdf_free(brdf[1]);
    return result;
}

static nqm_texture *open_texture(const char *argument) {
    nqm_texture *texture;
    nqm_error err = {0};
    if (nqm_texture_open(argument, NULL, NULL, &texture, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return texture;
}

TEST(constants_have_the_score_of_their_brdfs) {
    static const char ref[] = "gltf:base_color=.5,.4,.3;metallic=0;roughness=.25";
    static const char test[] = "gltf:base_color=.5,.4,.3;metallic=0;roughness=.5";
    const nqm_score_result expected = score_specs(ref, test);
    const float quarter[6] = {.25f, .25f, .25f, .25f, .25f, .25f}, half[6] = {.5f, .5f, .5f, .5f, .5f, .5f};
    const nqm_texture_result maps =
        score(make_of(3, 2, NULL, quarter, NULL, NULL), make_of(3, 2, NULL, half, NULL, NULL), NULL, NULL);
    const nqm_texture_result specs = score(open_texture(ref), open_texture(test), NULL, NULL);
    const nqm_texture_result *each[2] = {&maps, &specs};
    for (size_t k = 0; k < 2; ++k) {
        assert_true(each[k]->jod == expected.jod && each[k]->delta_e == expected.delta_e);
        assert_true(each[k]->jod_low == expected.jod_low && each[k]->jod_high == expected.jod_high);
        assert_true(each[k]->median == expected.jod && each[k]->worst == expected.jod && each[k]->error == 0);
        assert_near(each[k]->far_jod[0], expected.jod, 1e-4);
        assert_int_equal(each[k]->n_different, 1);
        assert_int_equal(each[k]->n_blame, 1);
        assert_string_equal(each[k]->blame[0].key, "roughness");
        assert_true(each[k]->blame[0].jod == expected.jod);
        assert_near(each[k]->parts.shift[0], expected.parts.shift[0], 1e-12);
    }
    assert_int_equal(maps.width, 3);
    assert_int_equal(maps.height, 2);
    /* A mixture of models, and a BRDF that is none of a shading model. */
    const nqm_texture_result mixed =
        score(open_texture("rotate:deg=5;of=ggx:kd=.2;alpha=.2"), open_texture(test), NULL, NULL);
    assert_true(mixed.jod == score_specs("rotate:deg=5;of=ggx:kd=.2;alpha=.2", test).jod && mixed.n_blame == 0);
}

TEST(halves_are_averaged) {
    const float ref[8] = {.25f, .25f, .25f, .25f, .25f, .25f, .25f, .25f};
    const float test[8] = {.25f, .25f, .5f, .5f, .25f, .25f, .5f, .5f};
    float map[8];
    const nqm_texture_options options = options_of(0, 1);
    const nqm_texture_result r =
        score(make_of(4, 2, NULL, ref, NULL, NULL), make_of(4, 2, NULL, test, NULL, NULL), &options, map);
    const nqm_score_result worse = score_specs("gltf:base_color=.5,.4,.3;metallic=0;roughness=.25",
                                               "gltf:base_color=.5,.4,.3;metallic=0;roughness=.5");
    assert_near(r.delta_e, worse.delta_e / 2, 1e-12);
    assert_near(r.jod, nqm_curve_jod(&nqm_curve_published, worse.delta_e / 2), 1e-12);
    assert_true(r.jod_low < r.jod && r.jod < r.jod_high);
    assert_near(r.below[0], worse.jod < 9 ? 0.5 : 0, 1e-12);
    assert_true(r.worst == worse.jod);
    assert_int_equal(r.n_different, 2);
    for (size_t i = 0; i < 8; ++i)
        assert_near((double)map[i], i % 4 < 2 ? 0 : worse.delta_e, 1e-4);
    /* From afar the test is the mean of both BRDFs. */
    const nqm_score_result far = score_specs("gltf:base_color=.5,.4,.3;metallic=0;roughness=.25",
                                             "between:t=.5;with=(gltf:base_color=.5,.4,.3;metallic=0;roughness=.5);of="
                                             "gltf:base_color=.5,.4,.3;metallic=0;roughness=.25");
    assert_near(r.far_jod[0], far.jod, 1e-3);
}

/* Pixels of equal texels are these, and a pixel of all texels is seen from afar. */
TEST(pixels_are_between_near_and_far) {
    const float ref[8] = {.25f, .25f, .25f, .25f, .25f, .25f, .25f, .25f};
    const float test[8] = {.25f, .25f, .5f, .5f, .25f, .25f, .5f, .5f};
    nqm_texture_result r[3];
    for (size_t k = 0; k < 3; ++k) {
        nqm_texture_options options = options_of(0, 1);
        options.texels_per_pixel = (size_t)1 << k;
        r[k] = score(make_of(4, 2, NULL, ref, NULL, NULL), make_of(4, 2, NULL, test, NULL, NULL), &options, NULL);
        assert_int_equal(r[k].texels_per_pixel, 1 << k);
    }
    assert_near(r[1].delta_e, r[0].delta_e, 1e-9);
    assert_near(r[2].jod, r[0].far_jod[0], 1e-3);
    /* With normals: two texels that lean to opposite sides by 20 degrees beside one that does not. */
    const float lean[6] = {.342f, 0, .94f, -.342f, 0, .94f}, flat[6] = {0, 0, 1, 0, 0, 1};
    nqm_texture_options options = options_of(0, 1);
    options.texels_per_pixel = 2;
    const nqm_texture_result t =
        score(make_of(2, 1, NULL, NULL, NULL, flat), make_of(2, 1, NULL, NULL, NULL, lean), &options, NULL);
    assert_near(t.jod, t.far_jod[0], 0.02);
}

/* Few texels with other normals and the regression, beside all texels. */
TEST(regression_is_within_its_error) {
    enum { FEW = 8 };
    float test[3 * N], small[2][3 * FEW * FEW], roughness[FEW * FEW];
    for (size_t i = 0; i < 3 * N; ++i)
        test[i] = i % 3 == 1 ? -normals[i] : normals[i];
    for (size_t i = 0; i < (size_t)FEW * FEW; ++i) {
        const size_t at = i / FEW * 4 * SIDE + i % FEW * 4;
        roughness[i] = rough[at];
        memcpy(&small[0][3 * i], &normals[3 * at], 3 * sizeof(float));
        memcpy(&small[1][3 * i], &test[3 * at], 3 * sizeof(float));
    }
    nqm_texture_result r[2];
    for (int exact = 0; exact < 2; ++exact) {
        nqm_texture_options options = options_of(0, 0);
        options.exact = exact;
        options.n_texels = 32;
        r[exact] = score(make_of(FEW, FEW, NULL, roughness, NULL, small[0]),
                         make_of(FEW, FEW, NULL, roughness, NULL, small[1]), &options, NULL);
    }
    assert_true(r[0].error > 0 && r[0].n_scored == 32 && r[1].error == 0);
    assert_near(r[0].jod, r[1].jod, fmax(3 * r[0].error, 0.02));
    assert_true(r[0].error < 0.5);
}

/* Of a plane with noise that no slope explains; then of covariates that say the same, and of constants. */
TEST(slopes_by_covariates) {
    enum { N_SAMPLES = 8 };
    nqm_texel_sample y[N_SAMPLES] = {0};
    nqm_covariates x[N_SAMPLES];
    double slope[2];
    for (size_t i = 0; i < N_SAMPLES; ++i) { /* bits of i, and their product as noise, are orthogonal */
        const double a = (double)(i & 1), b = (double)(i >> 1 & 1), c = (double)(i >> 2 & 1);
        x[i] = (nqm_covariates){{5 + 2 * a, a + 0.1 * b}};
        y[i].delta_e = 3 + 1.5 * x[i].x[0] - 4 * x[i].x[1] + 0.7 * (2 * c - 1);
    }
    nqm_covariate_slopes(N_SAMPLES, y, x, slope);
    assert_near(slope[0], 1.5, 1e-9);
    assert_near(slope[1], -4, 1e-9);
    for (size_t i = 0; i < N_SAMPLES; ++i)
        x[i].x[1] = 3 * x[i].x[0]; /* says nothing more */
    nqm_covariate_slopes(N_SAMPLES, y, x, slope);
    assert_near(slope[0], 1.5 - 2, 1e-9);
    assert_true(slope[1] == 0);
    for (size_t i = 0; i < N_SAMPLES; ++i)
        x[i] = (nqm_covariates){{1, (double)(i & 1)}};
    nqm_covariate_slopes(N_SAMPLES, y, x, slope);
    assert_true(slope[0] == 0);
    assert_near(slope[1], 3 - 4, 1e-9);
    for (size_t i = 0; i < N_SAMPLES; ++i)
        x[i] = (nqm_covariates){{1, 2}};
    nqm_covariate_slopes(N_SAMPLES, y, x, slope);
    assert_true(slope[0] == 0 && slope[1] == 0);
}

TEST(order_does_not_matter) {
    float test[N], moved[2][N];
    nqm_texture_options options = options_of(0, 0);
    options.exact = 1;
    for (size_t i = 0; i < N; ++i) {
        test[i] = rough[i] * 0.9f;
        moved[0][i] = rough[i * 7 % N];
        moved[1][i] = rough[i * 7 % N] * 0.9f;
    }
    const nqm_texture_result a = score(make(NULL, rough, NULL, NULL), make(NULL, test, NULL, NULL), &options, NULL);
    const nqm_texture_result b =
        score(make(NULL, moved[0], NULL, NULL), make(NULL, moved[1], NULL, NULL), &options, NULL);
    assert_near(a.delta_e, b.delta_e, 1e-9);
    assert_near(a.worst, b.worst, 1e-9);
}

TEST(samples_are_within_their_error) {
    float tests[2][3 * N];
    for (size_t i = 0; i < 3 * N; ++i) {
        tests[0][i] = colors[i] * 0.85f;
        tests[1][i] = i < N ? rough[i] * 1.2f : 0;
    }
    nqm_texture_options options = options_of(0, 0);
    options.exact = 1;
    const nqm_texture_result exact =
        score(make(colors, rough, metal, NULL), make(tests[0], tests[1], metal, NULL), &options, NULL);
    assert_int_equal(exact.n_scored, exact.n_different);
    assert_true(exact.error == 0);
    size_t n_outside = 0;
    double squares = 0;
    for (uint64_t seed = 1; seed <= 8; ++seed) {
        options.exact = 0;
        options.seed = seed;
        options.n_texels = 128;
        const nqm_texture_result r =
            score(make(colors, rough, metal, NULL), make(tests[0], tests[1], metal, NULL), &options, NULL);
        assert_int_equal(r.n_scored, 128);
        assert_true(r.error > 0 && r.error < 0.1);
        squares += (r.jod - exact.jod) * (r.jod - exact.jod);
        n_outside += fabs(r.jod - exact.jod) > 3 * r.error;
    }
    assert_int_equal(n_outside, 0);
    assert_true(sqrt(squares / 8) < 0.06);
}

TEST(equal_materials_are_perfect) {
    float map[N];
    const nqm_texture_result r =
        score(make(colors, rough, metal, normals), make(colors, rough, metal, normals), NULL, map);
    assert_true(r.jod == 10 && r.jod_low == 10 && r.jod_high == 10 && r.delta_e == 0 && r.far_jod[0] == 10);
    assert_true(r.median == 10 && r.worst == 10 && r.below[0] == 0 && r.error == 0);
    assert_int_equal(r.n_blame, 0);
    for (size_t i = 0; i < N; ++i)
        assert_true(map[i] == 0);
}

TEST(equal_normals_change_nothing) {
    float test[N];
    nqm_texture_options options = options_of(1, 0);
    options.n_texels = 128;
    for (size_t i = 0; i < N; ++i)
        test[i] = rough[i] * 0.8f;
    const nqm_texture_result flat = score(make(NULL, rough, NULL, NULL), make(NULL, test, NULL, NULL), &options, NULL);
    const nqm_texture_result bumpy =
        score(make(NULL, rough, NULL, normals), make(NULL, test, NULL, normals), &options, NULL);
    assert_true(flat.delta_e == bumpy.delta_e && flat.jod == bumpy.jod);
    assert_int_equal(bumpy.n_blame, 1);
}

TEST(tilts_are_scored) {
    const float up[3] = {0, 0, 2}, leaning[3] = {0.17364818f, 0, 0.98480775f};
    const nqm_texture_options options = options_of(1, 1);
    const nqm_texture_result r =
        score(make_of(1, 1, NULL, NULL, NULL, up), make_of(1, 1, NULL, NULL, NULL, leaning), &options, NULL);
    const nqm_score_result expected = score_specs("gltf:base_color=.5,.4,.3;metallic=0;roughness=.3",
                                                  "tilt:deg=10;of=gltf:base_color=.5,.4,.3;metallic=0;roughness=.3");
    assert_near(r.jod, expected.jod, 1e-3);
    assert_near(r.far_jod[0], expected.jod, 1e-3);
    assert_int_equal(r.n_blame, 1);
    assert_string_equal(r.blame[0].key, "normal");
    assert_near(r.blame[0].jod, expected.jod, 1e-3);
    /* Seen from the frame of the reference's normal. */
    const nqm_texture_result back =
        score(make_of(1, 1, NULL, NULL, NULL, leaning), make_of(1, 1, NULL, NULL, NULL, up), &options, NULL);
    const nqm_score_result other = score_specs("gltf:base_color=.5,.4,.3;metallic=0;roughness=.3",
                                               "tilt:deg=10;azimuth=180;of=gltf:base_color=.5,.4,.3;metallic=0;"
                                               "roughness=.3");
    assert_near(back.jod, other.jod, 1e-3);
    /* The mean of many that are alike is one of them, and so are the means of their halves. */
    float all_up[3 * N], all_leaning[3 * N];
    for (size_t i = 0; i < 3 * N; ++i) {
        all_up[i] = up[i % 3];
        all_leaning[i] = leaning[i % 3];
    }
    const nqm_texture_result many =
        score(make(NULL, NULL, NULL, all_up), make(NULL, NULL, NULL, all_leaning), &options, NULL);
    assert_near(many.far_jod[0], expected.jod, 1e-3);
    assert_near(many.far_delta_e, r.far_delta_e, 1e-3);
}

/* ---- blame ------------------------------------------------------------------------------------------------------- */

static void check_blame(const nqm_texture_result *r, const char *key, const char *mistake) {
    assert_true(r->n_blame > 0);
    assert_string_equal(r->blame[0].key, key);
    assert_string_equal(r->blame[0].mistake, mistake);
    assert_true(r->blame[0].jod < 10);
}

static float encode(float x) {
    return x <= 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1 / 2.4f) - 0.055f;
}

static float decode(float x) {
    return x <= 0.04045f ? x / 12.92f : powf((x + 0.055f) / 1.055f, 2.4f);
}

/* The test's normal seen from the reference's: turned by the rotation that takes that one to (0, 0, 1) (Rodrigues). */
TEST(tilts_are_relative_to_the_reference) {
    static const float maps[2][3] = {{0.3f, -0.2f, 1}, {-0.1f, 0.4f, 0.8f}};
    nqm_texture_job job = {.n_columns = 0};
    nqm_texture *sides[2];
    const float *rows[2];
    double n[2][3], tilt[3], along;
    for (size_t s = 0; s < 2; ++s) {
        const double zero = 0;
        sides[s] = make_of(1, 1, NULL, NULL, NULL, maps[s]);
        float *values = nqm_alloc((size_t)sides[s]->n_rows * NQM_TEXEL_BLOCK, sizeof *values);
        nqm_texture_evaluate(sides[s], 1, &zero, &zero, values);
        nqm_texture_normal(sides[s], values, 0, n[s]);
        job.side[s] = sides[s];
        rows[s] = values;
    }
    nqm_texels_tilt(&job, rows, 0, tilt);
    const double sine = hypot(n[0][0], n[0][1]), cosine = n[0][2], axis[2] = {n[0][1] / sine, -n[0][0] / sine};
    along = axis[0] * n[1][0] + axis[1] * n[1][1];
    const double expected[3] = {n[1][0] * cosine + axis[1] * n[1][2] * sine + axis[0] * along * (1 - cosine),
                                n[1][1] * cosine - axis[0] * n[1][2] * sine + axis[1] * along * (1 - cosine),
                                n[1][2] * cosine + (axis[0] * n[1][1] - axis[1] * n[1][0]) * sine};
    for (size_t c = 0; c < 3; ++c)
        assert_near(tilt[c], expected[c], 1e-12);
    for (size_t s = 0; s < 2; ++s) {
        nqm_free((void *)(uintptr_t)rows[s]);
        nqm_texture_free(sides[s]);
    }
}

TEST(mistakes_are_named) {
    nqm_texture_options options = options_of(1, 0);
    options.n_texels = 128;
    static const char *const texts[] = {"roughness is squared", "roughness is the square root",
                                        "roughness is decoded from sRGB", "roughness is inverted", ""};
    float test[3 * N];
    for (size_t k = 0; k < 5; ++k) {
        for (size_t i = 0; i < N; ++i) {
            const float x = rough[i], results[] = {x * x, sqrtf(x), decode(x), 1 - x, x * 0.9f};
            test[i] = nearbyintf(results[k] * 255) / 255;
        }
        const nqm_texture_result r =
            score(make(colors, rough, metal, NULL), make(colors, test, metal, NULL), &options, NULL);
        check_blame(&r, "roughness", texts[k]);
        assert_int_equal(r.n_blame, 1);
    }
    for (size_t i = 0; i < 3 * N; ++i)
        test[i] = encode(colors[i]);
    nqm_texture_result r = score(make(colors, rough, metal, NULL), make(test, rough, metal, NULL), &options, NULL);
    check_blame(&r, "base_color", "base_color is not decoded from sRGB");
    r = score(make(colors, rough, metal, NULL), make(colors, metal, rough, NULL), &options, NULL);
    check_blame(&r, r.blame[0].key, "metallic and roughness are exchanged");
    assert_int_equal(r.n_blame, 2);
    assert_string_equal(r.blame[1].mistake, "metallic and roughness are exchanged");
    for (size_t i = 0; i < 3 * N; ++i)
        test[i] = i % 3 == 1 ? -normals[i] : normals[i];
    options.n_texels = 32; /* other normals take 20 times as long */
    r = score(make(colors, rough, metal, normals), make(colors, rough, metal, test), &options, NULL);
    check_blame(&r, "normal", "the green channel of the normal map is flipped");
    assert_int_equal(r.n_blame, 1);
}

TEST(the_worst_map_is_first) {
    nqm_texture_options options = options_of(1, 0);
    options.n_texels = 128;
    float test[2][3 * N];
    for (size_t i = 0; i < 3 * N; ++i)
        test[0][i] = colors[i] * 0.98f;
    for (size_t i = 0; i < N; ++i)
        test[1][i] = rough[i] * 0.6f;
    const nqm_texture_result r =
        score(make(colors, rough, NULL, NULL), make(test[0], test[1], NULL, NULL), &options, NULL);
    assert_int_equal(r.n_blame, 2);
    assert_string_equal(r.blame[0].key, "roughness");
    assert_string_equal(r.blame[1].key, "base_color");
    assert_true(r.blame[0].jod < r.blame[1].jod && r.jod < r.blame[1].jod);
}

/* ---- conditions -------------------------------------------------------------------------------------------------- */

TEST(threads_give_the_same) {
    float test[3 * N];
    nqm_texture_options options = options_of(1, 1);
    options.n_texels = 16;
    nqm_texture_result r[2];
    for (size_t i = 0; i < 3 * N; ++i)
        test[i] = normals[i] * (i % 3 == 0 ? 0.8f : 1);
    const int before = nqm_limit_threads(1);
    for (int k = 0; k < 2; ++k) {
        nqm_limit_threads(k + 1);
        memset(&r[k], 0, sizeof r[k]);
        r[k] = score(make_of(8, 8, colors, rough, NULL, normals), make_of(8, 8, colors, metal, NULL, test), &options,
                     NULL);
    }
    nqm_limit_threads(before);
    assert_true(r[0].jod == r[1].jod && r[0].delta_e == r[1].delta_e && r[0].error == r[1].error);
    assert_true(r[0].far_jod[0] == r[1].far_jod[0] && r[0].jod_low == r[1].jod_low);
    assert_int_equal(r[0].n_blame, r[1].n_blame);
    for (size_t k = 0; k < r[0].n_blame; ++k)
        assert_true(r[0].blame[k].jod == r[1].blame[k].jod);
}

/* Calls are 0.2 s apart: one that takes longer is followed by that of the next stage. */
static int stop(void *user, const char *stage, double done, double total) {
    (void)done, (void)total;
    const struct timespec pause = {.tv_nsec = 210000000};
    nanosleep(&pause, NULL);
    return strcmp(stage, user) == 0;
}

TEST(callers_can_stop) {
    static char stages[][8] = {"texels", "near", "blame", "far"};
    for (size_t k = 0; k < 5; ++k) {
        const size_t stage = k < 4 ? k : 3; /* twice from afar: means without and with normals */
        const float *normal = k < 4 ? NULL : normals;
        nqm_texture *ref = make(NULL, rough, NULL, NULL), *test = make(NULL, metal, NULL, normal);
        nqm_texture_options options = options_of(1, 1);
        nqm_texture_result result = {.jod = -1};
        options.n_texels = 16;
        options.progress = stop;
        options.progress_user = stages[stage];
        assert_int_equal(nqm_texture_score(model, ref, test, &options, &result, NULL, NULL), NQM_ERR_CANCELLED);
        assert_true(result.jod < 0);
        nqm_texture_free(ref);
        nqm_texture_free(test);
    }
}

TEST(memory_runs_out) {
    const float each[2][4] = {{.2f, .3f, .4f, .5f}, {.3f, .3f, .4f, .6f}};
    nqm_status status = NQM_ERR_NOMEM;
    const int before = nqm_limit_threads(1);
    long n = 0;
    for (; status != NQM_OK; n += n < 60 ? 1 : 7) {
        nqm_texture *ref = make_of(2, 2, NULL, each[0], NULL, NULL), *test = make_of(2, 2, NULL, each[1], NULL, NULL);
        nqm_texture_result result;
        nqm_error err = {0};
        nqm_alloc_fail_after(n);
        status = nqm_texture_score(model, ref, test, NULL, &result, NULL, &err);
        nqm_alloc_fail_after(-1);
        if (status != NQM_OK && status != NQM_ERR_NOMEM)
            fail_msg("allocation %ld: %s", n, err.message);
        nqm_texture_free(ref);
        nqm_texture_free(test);
    }
    nqm_limit_threads(before);
    assert_true(n > 20);
}

TEST(options_are_checked) {
    nqm_texture *t = make(NULL, rough, NULL, NULL);
    nqm_texture_options options = nqm_texture_options_default();
    nqm_texture_result result;
    options.n_texels = 15;
    assert_int_equal(nqm_texture_score(model, t, t, &options, &result, NULL, NULL), NQM_ERR_ARG);
    options.n_texels = 16;
    options.texels_per_pixel = 0;
    assert_int_equal(nqm_texture_score(model, t, t, &options, &result, NULL, NULL), NQM_ERR_ARG);
    nqm_texture_free(t);
}

TEST_FILE(setup, teardown)
