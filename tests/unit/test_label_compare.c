/* SPDX-License-Identifier: MIT
 *
 * Comparison of labels: ranks of known order, the two trivial predictors, the order of encodings, and bad files.
 */
#include "support/check.h"

#include <math.h>
#include <nqm/label.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static nqm_scene *scene;

static int make_scene(void **state) {
    (void)state;
    nqm_scene_options options = nqm_scene_options_default();
    options.n_points = 64;
    options.n_lights = 32;
    return nqm_scene_create(&options, &scene, NULL) == NQM_OK ? 0 : -1;
}

static int free_scene(void **state) {
    (void)state;
    nqm_scene_free(scene);
    return 0;
}

static nqm_status compare(const char *text, nqm_comparison *comparison, nqm_error *err) {
    char path[] = "/tmp/nqm-compare-XXXXXX";
    int fd = mkstemp(path);
    assert_true(fd >= 0 && write(fd, text, strlen(text)) == (ssize_t)strlen(text));
    close(fd);
    nqm_status status = nqm_compare_labels(path, NULL, scene, NULL, NULL, NULL, comparison, err);
    unlink(path);
    return status;
}

/* Brighter copies of grey differ more, and brighter greys are brighter: every order is known beforehand. */
static void ranks_are_those_of_known_order(void **state) {
    (void)state;
    nqm_comparison c;
    assert_int_equal(compare("reference,test,encoding,delta_e\n"
                             "lambert:kd=.1,lambert:kd=.11,ward,3\n"
                             "lambert:kd=.2,lambert:kd=.3,ward,2\n"
                             "lambert:kd=.3,lambert:kd=.9,ward,1\n"
                             "lambert:kd=.1,lambert:kd=.12,ggx,10\n"
                             "lambert:kd=.2,lambert:kd=.31,ggx,30\n"
                             "lambert:kd=.3,lambert:kd=.91,ggx,20\n",
                             &c, NULL),
                     NQM_OK);
    assert_true(c.n_encodings == 2 && c.rows[0].n == 3 && c.rows[1].n == 3 && c.pooled.n == 6);
    assert_string_equal(c.rows[0].encoding, "ward");
    assert_near(c.rows[0].spearman, -1, 1e-12);
    assert_near(c.rows[0].null_luminance, -1, 1e-12);
    assert_near(c.rows[1].spearman, 0.5, 1e-12);
    assert_near(c.rows[1].null_luminance, 0.5, 1e-12);
    /* The medians of the others: ward 1.5, 2, 2.5; ggx 25, 15, 20. Ranks 1 2 3 6 4 5 against 3 2 1 4 6 5. */
    assert_near(c.pooled_null_encoding, 1 - 6.0 * (4 + 0 + 4 + 4 + 4 + 0) / (6 * 35), 1e-12);
    assert_near(c.rows[0].median_theirs, 2, 0);
    assert_true(c.rows[0].spearman_ci95[0] <= c.rows[0].spearman_ci95[1]);
    assert_int_equal(c.n_triples, 0);
}

static void order_of_encodings(void **state) {
    (void)state;
    nqm_comparison c;
    assert_int_equal(compare("delta_e,encoding,reference,test\n"
                             "1,nbrdf,sgd:nickel,perturb:scale=1.1;of=sgd:nickel\n"
                             "2,ward,sgd:nickel,perturb:scale=2;of=sgd:nickel\n"
                             "3,ggx,sgd:nickel,perturb:scale=3;of=sgd:nickel\n"
                             "1,nbrdf,sgd:pearl-paint,perturb:scale=2.5;of=sgd:pearl-paint\n"
                             "2,ward,sgd:pearl-paint,perturb:scale=2;of=sgd:pearl-paint\n"
                             "3,ggx,sgd:pearl-paint,perturb:scale=3;of=sgd:pearl-paint\n"
                             "5,nbrdf,lambert:kd=.5,lambert:kd=.1\n",
                             &c, NULL),
                     NQM_OK);
    assert_int_equal(c.n_triples, 2);
    assert_int_equal(c.n_ordered, 1);
    assert_int_equal(c.n_ordered_theirs, 2);
}

static void own_fits_are_made(void **state) {
    (void)state;
    nqm_comparison c;
    const char *ward = "ward:kd=.1,.1,.1;ks=.05,.05,.05;alpha=.2";
    char text[600];
    snprintf(text, sizeof text, "reference,test,encoding,delta_e\n\"%s\",fit,ward,1\n\"%s\",lambert:kd=.2,other,2\n",
             ward, ward);
    assert_int_equal(compare(text, &c, NULL), NQM_OK);
    assert_true(c.rows[0].median_ours < 0.5); /* Ward's model fits itself */
    assert_true(c.rows[1].median_ours > 2);
    assert_true(isnan(c.rows[0].spearman));
}

static void faults_are_named(void **state) {
    (void)state;
    nqm_comparison c;
    nqm_error err = {0};
    assert_int_equal(compare("reference,test,delta_e\nlambert:,lambert:,1\n", &c, &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, "no column encoding"));
    assert_int_equal(compare("reference,test,encoding,delta_e\nlambert:,lambert:,a,1\n", &c, &err),
                     NQM_ERR_INCOMPATIBLE);
    assert_int_equal(
        compare("reference,test,encoding,delta_e\nlambert:,lambert:,a,1\nlambert:,lambert:,a,x\n", &c, &err),
        NQM_ERR_FORMAT);
    assert_int_equal(
        compare("reference,test,encoding,delta_e\nlambert:,fit,phong,1\nlambert:,lambert:,a,2\n", &c, &err),
        NQM_ERR_ARG);
    assert_int_equal(compare("reference,test,encoding,delta_e\n/nowhere,fit,ward,1\nlambert:,lambert:,a,2\n", &c, &err),
                     NQM_ERR_IO);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(ranks_are_those_of_known_order),
                                       cmocka_unit_test(order_of_encodings), cmocka_unit_test(own_fits_are_made),
                                       cmocka_unit_test(faults_are_named)};
    return cmocka_run_group_tests(tests, make_scene, free_scene);
}
