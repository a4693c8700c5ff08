/* SPDX-License-Identifier: MIT
 *
 * Pictures of many BRDFs: the JODs of pairs are those of a model without a network, those of materials that are seen
 * apart are upper bounds, and neither depends on the threads or on what is drawn with a picture.
 */
#include "metric/metric.h"
#include "support/check.h"

#include <nqm/metric.h>
#include <omp.h>

enum { N = 6 };
static const char *const names[N] = {"lambert:kd=.5", "lambert:kd=.52,.5,.5",           "sgd:nickel",
                                     "ward:nickel",   "ggx:kd=.1;ks=1;alpha=.1;f0=.04", "sgd:blue-acrylic"};

/* nqm_scorer_draw() of names. */
static nqm_status draw_names(nqm_scorer *scorer, size_t n, const char *const *of, nqm_gallery *gallery, size_t first,
                             nqm_error *errors, nqm_error *err) {
    nqm_subject subjects[N];
    for (size_t i = 0; i < n; ++i)
        subjects[i] = (nqm_subject){.name = of[i]};
    return nqm_scorer_draw(scorer, n, subjects, gallery, first, errors, err);
}

static nqm_gallery *draw(nqm_scorer *scorer, const nqm_model *model) {
    nqm_gallery *gallery;
    nqm_error errors[N], err = {0};
    assert_int_equal(nqm_gallery_create(model, N, NULL, &gallery, &err), NQM_OK);
    assert_int_equal(draw_names(scorer, 2, names, gallery, 0, errors, &err), NQM_OK);
    assert_int_equal(draw_names(scorer, N - 2, names + 2, gallery, 2, errors + 2, &err), NQM_OK);
    for (size_t i = 0; i < N; ++i)
        assert_int_equal(errors[i].status, NQM_OK);
    return gallery;
}

TEST(compare_with_scores) {
    nqm_model *model;
    nqm_scorer *scorer;
    nqm_error err = {0};
    assert_int_equal(nqm_model_builtin("transport", &model, &err), NQM_OK);
    assert_int_equal(nqm_scorer_create(model, NULL, &scorer, &err), NQM_OK);
    nqm_gallery *gallery = draw(scorer, model);
    for (size_t a = 0; a < N; ++a) {
        float jod[N], apart[N];
        nqm_gallery_jods(gallery, a, gallery, 0, N, false, jod);
        nqm_gallery_jods(gallery, a, gallery, 0, N, true, apart);
        for (size_t b = 0; b < N; ++b) {
            const nqm_named_pair pair = {names[a], names[b]};
            nqm_score_result r;
            assert_int_equal(nqm_scorer_run_named(scorer, 1, &pair, &r, NULL, &err), NQM_OK);
            assert_true(fabs(r.jod - (double)jod[b]) < 1e-3);
            assert_true((double)apart[b] > r.similarity[0] - 1e-3);
        }
    }
    nqm_gallery_free(gallery);
    nqm_scorer_free(scorer);
    nqm_model_free(model);
}

TEST(threads_and_groups) {
    nqm_model *model;
    nqm_scorer *scorer;
    nqm_gallery *gallery[2], *again;
    nqm_error err = {0}, fault;
    float jod[2][N];
    assert_int_equal(nqm_model_builtin("transport", &model, &err), NQM_OK);
    for (int k = 0; k < 2; ++k) {
        omp_set_num_threads(1 + k);
        assert_int_equal(nqm_scorer_create(model, NULL, &scorer, &err), NQM_OK);
        gallery[k] = draw(scorer, model);
        nqm_gallery_jods(gallery[k], 2, gallery[0], 0, N, k, jod[k]);
        assert_int_equal(draw_names(scorer, 1, &names[3], gallery[k], 3, &fault, &err), NQM_OK);
        nqm_scorer_free(scorer);
    }
    assert_memory_equal(nqm_gallery_pictures(gallery[0]), nqm_gallery_pictures(gallery[1]),
                        N * nqm_gallery_size(model) * sizeof(float));
    assert_int_equal(nqm_gallery_create(model, N, nqm_gallery_pictures(gallery[0]), &again, &err), NQM_OK);
    nqm_gallery_jods(again, 2, gallery[0], 0, N, true, jod[0]);
    assert_memory_equal(jod[0], jod[1], sizeof jod[0]);
    nqm_gallery_free(again);
    nqm_gallery_free(gallery[0]);
    nqm_gallery_free(gallery[1]);
    nqm_model_free(model);
}

TEST(faults) {
    nqm_model *model, *paper;
    nqm_scorer *scorer;
    nqm_gallery *gallery;
    nqm_error err = {0}, errors[2];
    const char *const wrong[] = {"lambert:kd=-1", "lambert:kd=.5"};
    assert_int_equal(nqm_model_builtin("transport", &model, &err), NQM_OK);
    assert_int_equal(nqm_model_builtin("paper", &paper, &err), NQM_OK);
    assert_int_equal(nqm_gallery_create(paper, 1, NULL, &gallery, &err), NQM_ERR_MODEL);
    assert_null(gallery);
    assert_int_equal(nqm_gallery_create(model, 2, NULL, &gallery, &err), NQM_OK);
    assert_int_equal(nqm_scorer_create(model, NULL, &scorer, &err), NQM_OK);
    assert_int_equal(draw_names(scorer, 2, wrong, gallery, 0, errors, &err), NQM_OK);
    assert_int_equal(errors[0].status, NQM_ERR_ARG);
    assert_int_equal(errors[1].status, NQM_OK);
    nqm_scorer_free(scorer);
    nqm_gallery_free(gallery);
    nqm_model_free(paper);
    nqm_model_free(model);
}
