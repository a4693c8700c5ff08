/* SPDX-License-Identifier: MIT
 *
 * Models from files and built-in models: opening, refusals that name the file, golden scores, the self-test.
 */
#include "metric/metric.h"
#include "percept/percept.h"
#include "support/check.h"
#include "support/predict.h"
#include "support/rows.h"
#include "support/scratch.h"

#include <nqm/train.h>

enum { N = 20 };

static struct nqm_model *make_model(void) {
    struct nqm_model *model = nqm_alloc(1, sizeof *model);
    const nqm_net_shape shape = {2, {9 * N, 5, 1}};
    assert_int_equal(nqm_params_create(&shape, &model->params, NULL), NQM_OK);
    nqm_params_init(&model->params, 8);
    nqm_directions_options options = nqm_directions_options_default();
    options.n = N;
    assert_int_equal(nqm_directions_create(&options, 0, NULL, &model->directions, NULL), NQM_OK);
    for (size_t k = 0; k < 3; ++k) {
        model->features.mean[k] = 0.4f;
        model->features.std[k] = 0.3f;
    }
    model->features.layout = NQM_LAYOUT_REF_DIFF_ABSDIFF;
    model->features.difference_scale = 3;
    model->output.mean = 8, model->output.std = 1;
    model->output.lo = -4, model->output.hi = 2;
    model->curve = nqm_curve_published;
    model->id = nqm_strdup("small");
    return model;
}

TEST(test_file_round_trip) {
    struct nqm_model *model = make_model();
    nqm_model *loaded;
    assert_int_equal(nqm_model_save(model, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &loaded, NULL), NQM_OK);
    nqm_model_info info = nqm_model_get_info(loaded);
    assert_string_equal(info.id, "small");
    assert_int_equal(strlen(info.sha256), 64);
    assert_string_equal(nqm_directions_id(info.directions), nqm_directions_id(nqm_model_get_info(model).directions));
    float ref[3 * N], test[3 * N];
    for (size_t i = 0; i < 3 * N; ++i) {
        ref[i] = 0.1f * (float)i;
        test[i] = 0.1f * (float)i + 0.01f;
    }
    double jod, again;
    predict_jod(model, 1, ref, test, &jod);
    predict_jod(loaded, 1, ref, test, &again);
    assert_near(jod, again, 0);
    nqm_model_free(loaded);
    nqm_model_free(model);
}

/* A model is refused by the name that the caller gives, and where its bytes end too early. */
TEST(test_parse_refusals) {
    struct nqm_model *model = make_model();
    nqm_model *loaded;
    nqm_map map;
    nqm_error err = {0};
    assert_int_equal(nqm_golden_make(model, &model->golden, NULL), NQM_OK);
    assert_int_equal(nqm_model_save(model, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_map_open(scratch_path("model"), &map, NULL), NQM_OK);
    assert_int_equal(nqm_model_parse(map.data, map.n_bytes, "here", true, &loaded, NULL), NQM_OK);
    assert_int_equal(nqm_golden_check(loaded, NULL), NQM_OK);
    nqm_model_free(loaded);
    assert_int_equal(nqm_model_parse(map.data, map.n_bytes - 1, "here", true, &loaded, &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, "here"));
    assert_null(loaded);
    assert_int_equal(nqm_model_parse(NULL, 0, "here", true, &loaded, NULL), NQM_ERR_FORMAT);
    nqm_map_close(&map);
    nqm_model_free(model);
}

TEST(test_golden_scores) {
    struct nqm_model *model = make_model();
    nqm_model *loaded;
    nqm_error err = {0};
    assert_int_equal(nqm_golden_check(model, &err), NQM_ERR_MODEL);
    assert_non_null(strstr(err.message, "no golden scores"));
    assert_int_equal(nqm_golden_make(model, &model->golden, NULL), NQM_OK);
    assert_int_equal(nqm_model_save(model, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &loaded, NULL), NQM_OK);
    assert_int_equal(nqm_golden_check(loaded, NULL), NQM_OK);
    assert_non_null(strstr(loaded->golden, "\"jod\":"));
    /* the check must detect a change of any step from samples to JOD */
    loaded->features.std[1] *= 1.05f;
    assert_int_equal(nqm_golden_check(loaded, &err), NQM_ERR_NUMERIC);
    assert_non_null(strstr(err.message, "stored is"));
    loaded->features.std[1] = model->features.std[1];
    assert_int_equal(nqm_golden_check(loaded, NULL), NQM_OK);
    loaded->features.difference_scale = 3.1;
    assert_int_equal(nqm_golden_check(loaded, NULL), NQM_ERR_NUMERIC);
    nqm_model_free(loaded);
    nqm_model_free(model);
}

TEST(test_refusals_name_the_file) {
    nqm_model *model;
    nqm_error err = {0};
    assert_int_equal(nqm_model_load("/nowhere/m.safetensors", &model, &err), NQM_ERR_IO);
    assert_non_null(strstr(err.message, "/nowhere/m.safetensors"));
    assert_null(model);
    struct nqm_model *bad = make_model();
    bad->directions->degrees[4] = 95;
    assert_int_equal(nqm_model_save(bad, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &model, &err), NQM_ERR_MODEL);
    assert_non_null(strstr(err.message, scratch_path("model")));
    assert_non_null(strstr(err.message, "direction 2"));
    assert_null(model);
    nqm_model_free(bad);
}

/* A model with these scalar features, whose weights, moments and novelty do not depend on their order. Features that are not
 * in `kept` have no influence. */
static struct nqm_model *make_with_scalars(const char *names, const char *kept) {
    struct nqm_model *m = make_model();
    nqm_params_free(&m->params);
    assert_int_equal(nqm_scalars_select(names, &m->scalars, NULL), NQM_OK);
    const size_t n = m->scalars.n, width = 9 * N + n;
    assert_int_equal(nqm_params_create(&(nqm_net_shape){2, {width, 5, 1}}, &m->params, NULL), NQM_OK);
    nqm_scalar_whitening selected;
    bool has_influence[NQM_SCALAR_COUNT] = {false};
    assert_int_equal(nqm_scalars_select(kept, &selected, NULL), NQM_OK);
    for (size_t k = 0; k < selected.n; ++k)
        has_influence[selected.feature[k]] = true;
    nqm_rng rng = nqm_rng_make(4, 0);
    float shared[5][9 * N], of_feature[5][NQM_SCALAR_COUNT];
    for (size_t row = 0; row < 5; ++row) {
        for (size_t i = 0; i < 9 * N; ++i)
            shared[row][i] = 0.1f * (float)nqm_rng_normal(&rng);
        for (size_t i = 0; i < NQM_SCALAR_COUNT; ++i)
            of_feature[row][i] = (float)nqm_rng_normal(&rng);
    }
    m->novelty_points = nqm_alloc(n * NQM_NOVELTY_BLOCK, sizeof *m->novelty_points);
    for (size_t k = 0; k < n; ++k) {
        const size_t i = m->scalars.feature[k];
        const bool is_kept = has_influence[i];
        for (size_t row = 0; row < 5; ++row)
            m->params.layer[0].w[row * width + 9 * N + k] = is_kept ? of_feature[row][i] : 0;
        m->scalars.mean[k] = 0.01f * (float)i;
        m->scalars.std[k] = is_kept ? 1 + (float)i : 1e20f;
        m->novelty_map[k * n + k] = 1;
        m->novelty_points[k * NQM_NOVELTY_BLOCK + i % NQM_NOVELTY_BLOCK] = is_kept;
    }
    for (size_t row = 0; row < 5; ++row) {
        memcpy(m->params.layer[0].w + row * width, shared[row], sizeof shared[row]);
        m->params.layer[1].w[row] = row % 2 ? 1.0f : -0.5f;
        m->params.layer[0].gamma[row] = 1;
    }
    m->scalars.scale = 1;
    m->scalar_names = names ? nqm_strdup(names) : nqm_scalar_names();
    m->interval = nqm_alloc(6, sizeof *m->interval);
    memcpy(m->interval, (const double[]){0, 0, 1, 10, 9, 10}, 6 * sizeof *m->interval);
    m->n_interval = 2, m->n_novelty = 1, m->novelty_unit = 1;
    m->calibration = nqm_strdup("{}");
    return m;
}

/* What a version with more features, or with others before them, makes of a file: features are found by their names. Novelty is
 * the distance in the features that the model has. */
TEST(test_named_scalars) {
    static const char some[] = "bias_grazing,log_ma_loge,ref_peak,peak,log_rmse";
    struct nqm_model *all = make_with_scalars(NULL, some), *few = make_with_scalars(some, some);
    nqm_model *loaded;
    assert_int_equal(nqm_model_save(few, scratch_path("model"), NULL), NQM_OK);
    assert_int_equal(nqm_model_load(scratch_path("model"), &loaded, NULL), NQM_OK);
    assert_int_equal(loaded->scalars.n, 5);
    assert_string_equal(loaded->scalar_names, some);
    float ref[3 * N], test[3 * N];
    double jod[2], scalars[NQM_SCALAR_COUNT], first = 0;
    for (int round = 0; round < 3; ++round) {
        for (size_t i = 0; i < 3 * N; ++i) {
            ref[i] = 0.1f * (float)(i % 11);
            test[i] = ref[i] + 0.3f * (float)round * (float)(i % 7);
        }
        predict_jod(all, 1, ref, test, &jod[0]);
        predict_jod(loaded, 1, ref, test, &jod[1]);
        assert_near(jod[0], jod[1], 1e-5);
        first = round ? first : jod[0];
        compute_scalars(all->directions, NULL, ref, test, NULL, scalars);
        assert_relative(nqm_model_novelty(loaded, scalars), nqm_model_novelty(all, scalars), 1e-5);
    }
    assert_true(fabs(jod[0] - first) > 1e-3);
    nqm_model_free(loaded);
    nqm_model_free(all);
    nqm_model_free(few);
}

/* A model with a scalar feature that is unknown to this library, or occurs twice, is refused. */
TEST(test_other_scalars) {
    EVERY_ROW(row, "unknown scalars") {
        struct nqm_model *model = make_with_scalars("ref_peak,log_rmse", "ref_peak");
        nqm_model *loaded;
        nqm_error err = {0};
        nqm_free(model->scalar_names);
        model->scalar_names = nqm_alloc(64, 1);
        snprintf(model->scalar_names, 64, "ref_peak,%s", row[0]);
        assert_int_equal(nqm_model_save(model, scratch_path("model"), NULL), NQM_OK);
        assert_int_equal(nqm_model_load(scratch_path("model"), &loaded, &err), NQM_ERR_MODEL);
        assert_null(loaded);
        assert_non_null(strstr(err.message, row[1]));
        assert_non_null(strstr(err.message, scratch_path("model")));
        nqm_model_free(model);
    }
}

TEST(test_builtin_models) {
    nqm_model *model;
    nqm_error err = {0};
    assert_int_equal(nqm_model_builtin("no such model", &model, &err), NQM_ERR_MODEL);
    assert_null(model);
    assert_non_null(strstr(err.message, "no such model"));
    for (size_t i = 0; nqm_model_builtin_name(i); ++i) {
        const char *name = nqm_model_builtin_name(i);
        if (nqm_model_builtin(name, &model, &err) != NQM_OK)
            fail_msg("%s", err.message);
        nqm_model_info info = nqm_model_get_info(model);
        assert_string_equal(info.id, name);
        assert_int_equal(nqm_directions_get_info(info.directions).n, strcmp(name, "paper") == 0 ? 500 : 1872);
        if (strcmp(name, "paper") == 0)
            assert_int_equal(info.n_parameters, 4171125);
        nqm_model_free(model);
    }
}

typedef struct tally {
    size_t n, n_failed;
} tally;

static void count_check(void *user, const char *name, int passed) {
    tally *t = user;
    ++t->n;
    if (!passed) {
        ++t->n_failed;
        print_message("self-test failed: %s\n", name);
    }
}

TEST(test_selftest) {
    tally t = {0};
    nqm_error err = {0};
    nqm_status status = nqm_selftest(count_check, &t, &err);
    if (status != NQM_OK)
        fail_msg("%s", err.message);
    size_t n_expected = 3;
    for (size_t i = 0; nqm_model_builtin_name(i); ++i) {
        nqm_model *model;
        assert_int_equal(nqm_model_builtin(nqm_model_builtin_name(i), &model, NULL), NQM_OK);
        n_expected += nqm_model_get_info(model).n_layers > 0 ? 3 : 2;
        nqm_model_free(model);
    }
    assert_int_equal(t.n, n_expected);
    assert_int_equal(t.n_failed, 0);
    assert_int_equal(nqm_selftest(NULL, NULL, NULL), NQM_OK);
}
