/* SPDX-License-Identifier: MIT
 *
 * Sensitivity of a label to the seed, the resolution of the light, the exposure and the shape. The
 * comparison with the Stanford bunny under the paper's light needs the shared data.
 */
#include "math/math.h"
#include "render/render.h"
#include "support/check.h"
#include "support/rows.h"
#include "support/scenes.h"
#include <nqm/label.h>

enum { N_PAIRS = 20 };

static void label_all(const nqm_scene_options *o, double *delta_e) {
    nqm_scene *scene = make_scene(o);
    size_t n;
    const table_row *pair = table_rows("pairs with labels", &n);
    assert_int_equal(n, N_PAIRS);
    for (size_t i = 0; i < N_PAIRS; ++i) {
        delta_e[i] = label_specs(scene, pair[i][0], pair[i][1]).delta_e;
        assert_true(delta_e[i] > 0.1);
    }
    nqm_scene_free(scene);
}

static nqm_scene_options small_scene(const char *shape) {
    nqm_scene_options o = nqm_scene_options_default();
    o.shape = nqm_tracer_version() ? shape : "sphere";
    o.n_points = 768;
    o.n_lights = 64;
    o.n_frames = 4;
    return o;
}

TEST(seeds) {
    double one[N_PAIRS], two[N_PAIRS];
    nqm_scene_options o = nqm_scene_options_default();
    if (!nqm_tracer_version())
        skip(); /* the standard set has a blob */
    label_all(&o, one);
    o.seed = 2;
    label_all(&o, two);
    for (size_t i = 0; i < N_PAIRS; ++i)
        assert_near(two[i], one[i], 0.02 * fmax(one[i], 1)); /* differences below 1 are not visible */
}

TEST(width_of_the_light) {
    double filtered[N_PAIRS], full[N_PAIRS];
    nqm_scene_options o = small_scene("blob");
    label_all(&o, filtered);
    o.light_width = 512; /* the resolution of the built-in sky */
    label_all(&o, full);
    for (size_t i = 0; i < N_PAIRS; ++i)
        assert_near(full[i], filtered[i], 0.03 * fmax(filtered[i], 1));
}

TEST(exposures) {
    double dim[N_PAIRS], bright[N_PAIRS];
    nqm_scene_options o = small_scene("blob");
    o.exposure_cdm2 = 20;
    label_all(&o, dim);
    o.exposure_cdm2 = 200;
    label_all(&o, bright);
    assert_true(nqm_spearman(N_PAIRS, dim, bright) >= 0.98);
}

static void shapes(const char *light, const char *mesh, double least) {
    double sphere[N_PAIRS], other[N_PAIRS];
    nqm_scene_options o = small_scene("sphere");
    o.light = light;
    label_all(&o, sphere);
    o.shape = mesh;
    label_all(&o, other);
    double rank = nqm_spearman(N_PAIRS, sphere, other);
    if (!(rank >= least))
        fail_msg("Spearman of the sphere's labels with those of %s: %.4f", mesh, rank);
}

TEST(blob_and_sphere_rank_alike) {
    if (!nqm_tracer_version())
        skip();
    shapes(NULL, "blob", 0.97);
}

TEST(bunny_and_sphere_rank_alike) {
    char *light =
        shared_data("scene/pixar_campus_rgbe.png") ? nqm_strdup(shared_data("scene/pixar_campus_rgbe.png")) : NULL;
    const char *bunny = shared_data("scene/bunny.ply");
    if (!light || !bunny || !nqm_tracer_version()) {
        nqm_free(light);
        skip();
    }
    shapes(light, bunny, 0.97);
    nqm_free(light);
}
