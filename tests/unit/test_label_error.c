/* SPDX-License-Identifier: MIT
 *
 * The standard error of a label by the choice of points: that of smooth pictures, and of pictures that differ in small
 * spots, against the spread of the labels of several seeds.
 */
#include "support/check.h"
#include "support/scenes.h"
#include <nqm/label.h>

enum { N_SEEDS = 10 };

/* The spread of the labels, relative to the error that they state. */
static double spread_by_error(const char *ref, const char *test) {
    double sum = 0, squares = 0, errors = 0;
    for (size_t seed = 1; seed <= N_SEEDS; ++seed) {
        nqm_scene_options o = nqm_scene_options_default();
        o.light = "studio";
        o.shape = "blob";
        o.n_points = 512;
        o.n_lights = 192;
        o.seed = seed;
        nqm_scene *scene = make_scene(&o);
        double *a = render_spec(scene, ref), *b = render_spec(scene, test);
        const nqm_label label = nqm_scene_compare(scene, a, b, NULL);
        nqm_free(a);
        nqm_free(b);
        nqm_scene_free(scene);
        sum += label.delta_e;
        squares += label.delta_e * label.delta_e;
        errors += label.error * label.error;
    }
    const double spread = sqrt((squares - sum * sum / N_SEEDS) / (N_SEEDS - 1)), error = sqrt(errors / N_SEEDS);
    print_message("%s: spread %g, stated %g, ratio %g\n", ref, spread, error, spread / error);
    return spread / error;
}

/* The difference of a smooth picture converges faster than the groups can show: its error may be overstated by much. */
TEST(test_smooth_differences) {
    const double ratio = spread_by_error("lambert:kd=.8,.5,.2", "lambert:kd=.7,.5,.3");
    assert_true(ratio > 0.15 && ratio < 1.3);
}

TEST(test_spots) {
    const double wide = spread_by_error("ggx:kd=.2,.15,.1;ks=1,1,1;alpha=.4;f0=.04",
                                        "ggx:kd=.2,.15,.1;ks=1,1,1;alpha=.5;f0=.04"),
                 narrow = spread_by_error("ggx:kd=.2,.15,.1;ks=1,1,1;alpha=.05;f0=.9",
                                          "ggx:kd=.2,.15,.1;ks=1,1,1;alpha=.07;f0=.9");
    assert_true(wide > 0.3 && wide < 1.3);
    assert_true(narrow > 0.4 && narrow < 1.3);
}
