/* SPDX-License-Identifier: MIT
 *
 * nqm_brdf_jacobian(): every analytic model against fourth-order central differences of opened specs, at random parameters
 * and directions and at the kinks that the header names; values against nqm_brdf_eval(); BRDFs without parameters.
 */
#include "base/base.h"
#include "brdf/core/spec.h"
#include "math/math.h"
#include "support/check.h"
#include "support/rows.h"

#define POINTER_TO(NAME) &(NAME),
static const nqm_analytic_model *const models[] = {NQM_ANALYTIC_MODELS(POINTER_TO) NULL};

enum { MAX_PARAMETERS = 33, N_PAIRS = 150 };

/* ---- random specs and directions --------------------------------------------------------------------------------- */

/* Ranges in which lobes have values at most random directions, and sgd's shadowing does not reach 0 (a kink). */
static const struct {
    const char *key;
    double low, high;
} ranges[] = {{"kd", 0.05, 0.9}, {"ks", 0.05, 2},    {"alpha", 0.03, 0.8}, {"f0", 0.02, 0.95},   {"n", 0.5, 1000},
              {"cxy", 0.3, 2},   {"cz", 0.3, 2},     {"eta", 1.02, 5},     {"B", 1, 1e5},        {"C", 0.1, 3},
              {"p", 0.1, 2},     {"f1", 0.005, 0.1}, {"K", 0.5, 50},       {"lambda", 0.1, 0.5}, {"c", 0.02, 0.25},
              {"k", 0.5, 3},     {"theta0", 0.05, 1}};

static double random_value(const char *key, nqm_rng *rng) {
    size_t i = 0;
    while (strcmp(ranges[i].key, key) != 0)
        ++i;
    double v = ranges[i].low * pow(ranges[i].high / ranges[i].low, nqm_rng_uniform(rng)); /* log-uniform */
    return strcmp(key, "cxy") == 0 ? -v : v;
}

/* is_isotropic: both values of a key with two are equal. */
static nqm_values random_values(const nqm_schema *schema, bool is_isotropic, nqm_rng *rng) {
    nqm_values values = {.given = UINT64_MAX};
    for (size_t k = 0; k < schema->n_keys; ++k) {
        for (size_t c = 0; c < schema->keys[k].n; ++c)
            values.v[k][c] = random_value(schema->keys[k].name, rng);
        if (is_isotropic && schema->keys[k].n == 2)
            values.v[k][1] = values.v[k][0];
    }
    return values;
}

static nqm_brdf *open_values(const nqm_schema *schema, const nqm_values *values) {
    nqm_values copy = *values;
    copy.schema = schema;
    for (size_t k = 0; k < schema->n_keys; ++k)
        if (schema->keys[k].n == 1)
            copy.v[k][1] = copy.v[k][2] = copy.v[k][0];
    char *spec = nqm_values_spec(&copy);
    assert_non_null(spec);
    nqm_brdf *brdf = must_open(spec);
    nqm_free(spec);
    return brdf;
}

/* Pairs above the horizon at any azimuth, most of them in or near the highlight. */
static void draw_pairs(size_t n, nqm_rng *rng, double *wi, double *wo) {
    for (size_t i = 0; i < n;) {
        double u = nqm_rng_uniform(rng);
        const double hd[3] = {1.5 * u * u, 1.5 * nqm_rng_uniform(rng), NQM_PI * nqm_rng_uniform(rng)};
        const double angle = 2 * NQM_PI * nqm_rng_uniform(rng), turn[2] = {sin(angle), cos(angle)};
        nqm_half_diff_to_directions(hd, wi + 3 * i, wo + 3 * i);
        nqm_turn3(turn, wi + 3 * i, wi + 3 * i);
        nqm_turn3(turn, wo + 3 * i, wo + 3 * i);
        i += wi[3 * i + 2] > 0.02 && wo[3 * i + 2] > 0.02;
    }
}

/* ---- central differences ----------------------------------------------------------------------------------------- */

/* rgb (n, 3) with the parameter (key, channel) moved by `step`. */
static void eval_moved(const nqm_schema *schema, const nqm_values *values, size_t key, size_t channel, double step,
                       size_t n, const double *wi, const double *wo, double *rgb) {
    nqm_values moved = *values;
    moved.v[key][channel] += step;
    nqm_brdf *brdf = open_values(schema, &moved);
    nqm_brdf_eval(brdf, n, wi, wo, rgb, NULL);
    nqm_brdf_free(brdf);
}

/* (8 (f(h) - f(-h)) - (f(2h) - f(-2h))) / 12h. numeric: (n, 3) */
static void differences(const nqm_schema *schema, const nqm_values *values, size_t key, size_t channel, size_t n,
                        const double *wi, const double *wo, double *numeric) {
    static const double at[4] = {-2, -1, 1, 2}, weight[4] = {1, -8, 8, -1};
    double rgb[3 * N_PAIRS];
    const double h = 2e-5 * fabs(values->v[key][channel]);
    memset(numeric, 0, 3 * n * sizeof *numeric);
    for (size_t s = 0; s < 4; ++s) {
        eval_moved(schema, values, key, channel, at[s] * h, n, wi, wo, rgb);
        for (size_t i = 0; i < 3 * n; ++i)
            numeric[i] += weight[s] * rgb[i] / (12 * h);
    }
}

/* sgd: differences over theta = theta0, where the shadowing begins, are not derivatives. */
static bool is_near_kink(const nqm_schema *schema, const nqm_values *values, size_t channel, const double *wi,
                         const double *wo) {
    const size_t last = schema->n_keys - 1;
    const double theta0 = values->v[last][channel];
    return strcmp(schema->keys[last].name, "theta0") == 0 &&
           (fabs(acos(wi[2]) - theta0) < 0.03 || fabs(acos(wo[2]) - theta0) < 0.03);
}

/* Compare all rows. The size of a row is the largest of its entries times their parameters, and the value. */
static void check_rows(const nqm_schema *schema, const nqm_values *values, size_t n, const double *wi,
                       const double *wo) {
    static double jacobian[N_PAIRS * 3 * MAX_PARAMETERS], numeric[MAX_PARAMETERS][3 * N_PAIRS];
    double rgb[3 * N_PAIRS], expected[3 * N_PAIRS], scale[MAX_PARAMETERS];
    nqm_brdf *brdf = open_values(schema, values);
    const size_t n_parameters = nqm_brdf_get_info(brdf).n_values;
    assert_int_equal(nqm_brdf_jacobian(brdf, n, wi, wo, rgb, jacobian, NULL), NQM_OK);
    nqm_brdf_eval(brdf, n, wi, wo, expected, NULL);
    assert_memory_equal(rgb, expected, 3 * n * sizeof *rgb);
    size_t p = 0;
    for (size_t key = 0; key < schema->n_keys; ++key)
        for (size_t c = 0; c < schema->keys[key].n; ++c, ++p) {
            scale[p] = fabs(values->v[key][c]);
            differences(schema, values, key, c, n, wi, wo, numeric[p]);
        }
    assert_int_equal(p, n_parameters);
    for (size_t i = 0; i < 3 * n; ++i) {
        if (is_near_kink(schema, values, i % 3, wi + i - i % 3, wo + i - i % 3))
            continue;
        const double *row = jacobian + i * n_parameters;
        double size = rgb[i];
        for (p = 0; p < n_parameters; ++p)
            size = fmax(size, fabs(row[p]) * scale[p]);
        for (p = 0; p < n_parameters; ++p)
            assert_near(row[p], numeric[p][i], 1e-7 * fabs(row[p]) + 1e-9 * size / scale[p]);
    }
    nqm_brdf_free(brdf);
}

TEST(test_central_differences) {
    static double wi[3 * N_PAIRS], wo[3 * N_PAIRS];
    nqm_rng rng = nqm_rng_make(13, 0);
    for (const nqm_analytic_model *const *model = models; *model; ++model)
        for (int repeat = 0; repeat < 12; ++repeat) {
            const nqm_values values = random_values((*model)->schema, repeat % 4 == 0, &rng);
            draw_pairs(N_PAIRS, &rng, wi, wo);
            check_rows((*model)->schema, &values, N_PAIRS, wi, wo);
        }
}

/* ---- branches ---------------------------------------------------------------------------------------------------- */

/* The Jacobian (3, *n_ret) of one pair; valid until the next call. */
static const double *jacobian_at(const char *spec, const double *wi, const double *wo, double *rgb, size_t *n_ret) {
    static double jacobian[3 * MAX_PARAMETERS];
    nqm_brdf *brdf = must_open(spec);
    *n_ret = nqm_brdf_get_info(brdf).n_values;
    assert_int_equal(nqm_brdf_jacobian(brdf, 1, wi, wo, rgb, jacobian, NULL), NQM_OK);
    for (size_t i = 0; i < 3 * *n_ret; ++i)
        assert_true(isfinite(jacobian[i]));
    nqm_brdf_free(brdf);
    return jacobian;
}

/* A unit vector of azimuth 0 (cosine with the x axis positive) or pi. */
static void direction(double theta, int sign, double *w) {
    w[0] = sign * sin(theta);
    w[1] = 0;
    w[2] = cos(theta);
}

TEST(test_lafortune_branches) {
    double wi[3], wo[3], rgb[3];
    size_t n;
    direction(1.2, 1, wi);
    direction(1.2, 1, wo); /* back towards the light: the generalised cosine is negative */
    const double *j = jacobian_at("lafortune:kd=.3;ks=.2;cz=.5;n=3", wi, wo, rgb, &n);
    assert_int_equal(n, 9);
    for (size_t i = 0; i < 3 * n; ++i)
        assert_true(j[i] == (i % n == i / n ? 1 / NQM_PI : 0));

    direction(0.5, 1, wi);
    direction(0.8, -1, wo);
    double on_tie[9];
    memcpy(on_tie, jacobian_at("lafortune:ks=.2;cxy=-.7;cz=.7;n=30", wi, wo, rgb, &n), sizeof on_tie);
    j = jacobian_at("lafortune:ks=.2;cxy=-.7000000001;cz=.7;n=30", wi, wo, rgb, &n);
    for (size_t i = 0; i < 9; ++i)
        assert_near(on_tie[i], j[i], 1e-6 * fabs(j[i]) + 1e-12);
    j = jacobian_at("lafortune:ks=.2;cxy=-.6999999999;cz=.7;n=30", wi, wo, rgb, &n);
    assert_true(fabs(on_tie[6] - j[6]) > 0.1 * fabs(j[6])); /* the other branch differs */
}

TEST(test_eta_of_one_at_grazing) {
    static const char *const specs[] = {"low-cook-torrance:ks=.2;alpha=.3;eta=1", "abc:ks=.2;B=10;C=1;eta=1",
                                        "low-ashikhmin-shirley:ks=.2;n=10;eta=1", "smooth:ks=.2;B=10;C=1;eta=1"};
    double wi[3], wo[3], rgb[3];
    size_t n;
    direction(NQM_PI / 2 - 1e-9, 1, wi); /* eta^2 + cos^2 - 1 rounds to 0 */
    direction(NQM_PI / 2 - 1e-9, -1, wo);
    for (size_t i = 0; i < sizeof specs / sizeof *specs; ++i) {
        const double *j = jacobian_at(specs[i], wi, wo, rgb, &n);
        assert_true(j[n - 1] == 0); /* eta is the last key */
    }
}

#define SGD "sgd:kd=.1;ks=.4;alpha=.1;p=.6;K=9;lambda=2;c=.9;k=3"

TEST(test_sgd_branches) {
    enum { LAMBDA = 3 * 7, N = 33 };
    double wi[3], wo[3], rgb[3];
    size_t n;
    direction(0.3, 1, wi);
    direction(0.4, -1, wo); /* both below theta0: G = 1 */
    const double *j = jacobian_at(SGD ";f0=.2;f1=.01;theta0=.6", wi, wo, rgb, &n);
    assert_int_equal(n, N);
    assert_true(rgb[0] > 0.1);
    for (size_t i = 0; i < 3 * n; ++i)
        assert_true(i % n < LAMBDA || j[i] == 0);

    direction(1.5, -1, wo); /* G = 0 */
    j = jacobian_at(SGD ";f0=.2;f1=.01;theta0=.1", wi, wo, rgb, &n);
    for (size_t i = 0; i < 3 * n; ++i)
        assert_true(j[i] == (i % n == i / n ? 1 / NQM_PI : 0));

    direction(0.4, -1, wo); /* F negative, so that green is negative and is replaced by 0 */
    j = jacobian_at(SGD ";f0=.2;f1=.01,9,.01;theta0=.6", wi, wo, rgb, &n);
    assert_true(rgb[0] > 0 && rgb[1] == 0 && rgb[2] > 0);
    for (size_t i = 0; i < n; ++i)
        assert_true(j[n + i] == 0);
    assert_true(j[0] == 1 / NQM_PI && j[2 * n + 2] == 1 / NQM_PI);
}

/* Parameters at the ends of their ranges give finite derivatives. */
TEST(test_ends_of_ranges) {
    static double wi[3 * N_PAIRS], wo[3 * N_PAIRS];
    double rgb[3];
    size_t n;
    nqm_rng rng = nqm_rng_make(14, 0);
    draw_pairs(N_PAIRS, &rng, wi, wo);
    direction(0, 1, wi);
    direction(0, 1, wo);
    EVERY_ROW(row, "ends of the ranges of parameters") {
        for (size_t i = 0; i < N_PAIRS; ++i)
            jacobian_at(row[0], wi + 3 * i, wo + 3 * i, rgb, &n);
    }
}

/* Many pairs in one call, some below the horizon: each row is that of the pair alone. */
TEST(test_horizon_between_pairs) {
    static double wi[3 * N_PAIRS], wo[3 * N_PAIRS], rgb[3 * N_PAIRS], jacobian[3 * 11 * N_PAIRS];
    const char *spec = "ggx:kd=.1,.2,.3;ks=.5;alpha=.2;f0=.1,.2,.4";
    nqm_rng rng = nqm_rng_make(15, 0);
    draw_pairs(N_PAIRS, &rng, wi, wo);
    static const size_t below[] = {0, 5, 6, 70, N_PAIRS - 1};
    for (size_t k = 0; k < sizeof below / sizeof *below; ++k)
        wo[3 * below[k] + 2] *= k % 2 ? 0 : -1;
    memset(rgb, 1, sizeof rgb);
    memset(jacobian, 1, sizeof jacobian);
    nqm_brdf *brdf = must_open(spec);
    assert_int_equal(nqm_brdf_jacobian(brdf, N_PAIRS, wi, wo, rgb, jacobian, NULL), NQM_OK);
    for (size_t i = 0; i < N_PAIRS; ++i) {
        double rgb_of_one[3];
        size_t n;
        const double *alone = jacobian_at(spec, wi + 3 * i, wo + 3 * i, rgb_of_one, &n);
        assert_memory_equal(jacobian + 3 * n * i, alone, 3 * n * sizeof *alone);
        assert_memory_equal(rgb + 3 * i, rgb_of_one, sizeof rgb_of_one);
        if (wo[3 * i + 2] <= 0)
            for (size_t k = 0; k < 3 * n; ++k)
                assert_true(alone[k] == 0 && rgb_of_one[k / n] == 0);
    }
    nqm_brdf_free(brdf);
}

/* ---- which BRDFs have parameters --------------------------------------------------------------------------------- */

TEST(test_parameter_counts) {
    const double up[3] = {0, 0, 1};
    EVERY_ROW(row, "numbers of parameters") {
        double rgb[3], jacobian[3 * MAX_PARAMETERS];
        nqm_error err;
        nqm_brdf *brdf = must_open(row[0]);
        if ((size_t)atoi(row[1]))
            assert_int_equal(nqm_brdf_get_info(brdf).n_values, (size_t)atoi(row[1]));
        nqm_status status = nqm_brdf_jacobian(brdf, 1, up, up, rgb, jacobian, &err);
        assert_int_equal(status, (size_t)atoi(row[1]) ? NQM_OK : NQM_ERR_ARG);
        if (status != NQM_OK)
            assert_non_null(strstr(err.message, "analytic"));
        nqm_brdf_free(brdf);
    }
}

/* ---- derivatives by differences ---------------------------------------------------------------------------------- */

/* f = a^2 wi.z + c^2 of the channel + b_x^2 b_y, with a in [0, 1]. */
typedef struct sample_model {
    nqm_spec_state spec;
    double a, c[3], b[2];
} sample_model;

static void sample_prepare(const nqm_values *values, void *state) {
    sample_model *self = state;
    self->a = values->v[0][0];
    memcpy(self->c, values->v[1], sizeof self->c);
    memcpy(self->b, values->v[2], sizeof self->b);
}

static void sample_eval(const void *state, size_t n, const double *wi, const double *wo, double *rgb) {
    const sample_model *self = state;
    (void)wo;
    for (size_t i = 0; i < 3 * n; ++i)
        rgb[i] = self->a * self->a * wi[i - i % 3 + 2] + self->c[i % 3] * self->c[i % 3] +
                 self->b[0] * self->b[0] * self->b[1];
}

static const nqm_schema sample_schema = {
    .model = "sample",
    .n_keys = 4,
    .keys = {{.name = "a", .n = 1, .high = 1},
             {.name = "c", .n = 3, .high = 5},
             {.name = "b", .n = NQM_KEY_N("float2"), .high = 5},
             {.name = "azimuth", .n = 1, .low = -1, .high = 1, .role = NQM_ROLE_AZIMUTH}}};
static const nqm_analytic_model sample = {
    .schema = &sample_schema,
    .class_ = {.format = "sample", .eval = sample_eval, .jacobian = nqm_spec_jacobian},
    .state_size = sizeof(sample_model),
    .prepare = sample_prepare,
};

TEST(test_differences) {
    enum { N = 3, COLUMNS = 7 };
    const double at[] = {0, 0.3, 1};
    double wi[3 * N] = {0, 0, 1, 0.6, 0, 0.8, 0.8, 0, 0.6}, rgb[3 * N];
    for (size_t i = 0; i < 3; ++i) {
        double jacobian[3 * N * COLUMNS] = {0};
        sample_model self = {
            .spec = {&sample, {.schema = &sample_schema, .v = {{at[i], at[i], at[i]}, {0, 2, 5}, {2, 3, 3}}}}};
        sample_prepare(&self.spec.values, &self);
        nqm_spec_jacobian(&self, N, wi, wi, rgb, jacobian);
        for (size_t row = 0; row < 3 * N; ++row) {
            assert_near(jacobian[COLUMNS * row], 2 * at[i] * wi[row - row % 3 + 2], 1e-8);
            for (size_t c = 0; c < 3; ++c)
                assert_near(jacobian[COLUMNS * row + 1 + c], c == row % 3 ? 2 * self.c[c] : 0, 1e-8);
            assert_near(jacobian[COLUMNS * row + 4], 12, 1e-7);
            assert_near(jacobian[COLUMNS * row + 5], 4, 1e-7);
        }
    }
}

TEST(test_what_makes_anisotropic) {
    const nqm_schema *s = &sample_schema;
    assert_true(nqm_values_are_isotropic(&(nqm_values){s, .v = {{1}, {1, 2, 3}, {2, 2, 2}}}));
    assert_false(nqm_values_are_isotropic(&(nqm_values){s, .v = {{1}, {1, 2, 3}, {2, 3, 3}}}));
    assert_false(nqm_values_are_isotropic(&(nqm_values){s, .v = {{1}, {1, 2, 3}, {2, 2, 2}, {-0.5}}}));
}
