/* SPDX-License-Identifier: MIT
 *
 * nqm transport - makes the transport matrix of a scene, a model without a network.
 */
#include "model/model.h"
#include "nqm/label/scene.h"

#include <string.h>

/* Properties of the written file, which has a checksum; of the model, if the file is standard output. */
static json_t *written_model(const char *path, const nqm_model *model) {
    nqm_model *loaded = NULL;
    nqm_error err = {0};
    if (strcmp(path, "-") != 0)
        must(nqm_model_load(path, &loaded, &err), &err);
    json_t *document = json_model(loaded ? loaded : model);
    nqm_model_free(loaded);
    return document;
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static const char *path, *name = "transport";
static bool json;
static uint64_t n_rays;
static scene_args scene;

static const option options[] = {{"output", 'o', OPTION_NEEDED, &path, "FILE.safetensors", "the model to write", 0, 0},
                                 {"id", 0, OPTION_TEXT, &name, "NAME", "the model's name", 0, 0},
                                 {"rays", 0, OPTION_COUNT, &n_rays, "N",
                                  "instead of a matrix, N pairs of directions with azimuths: for anisotropic BRDFs", 64,
                                  100000},
                                 {"json", 0, OPTION_FLAG, &json, NULL, "print the model's properties as JSON", 0, 0},
                                 {0}};
static const choice choices[] = {{"make", "", "the only word so far"}, {0}};

static const command cmd = {
    .usage = "make -o FILE [options]",
    .about =
        "Make a metric for a scene of your own, without training: with fixed light, every point of a picture is\n"
        "linear in the BRDF, so a matrix makes small pictures from samples. The result is a model for --model, "
        "which\n"
        "predicts the Delta-E ITP and JOD of this scene. --points is a multiple of 32 (default 256, of all scenes\n"
        "together). --model transport has the standard scenes.",
    .example = "nqm transport make --light studio --shape sphere -o studio.safetensors\n"
               "nqm score sgd:nickel ward:nickel --model studio.safetensors",
    .options = options,
    .choices = choices,
    .table = &nqm_scene_option_table,
    .table_target = &scene.scene,
    .min_arguments = 1,
};

static nqm_model *make_matrix(void) {
    const size_t n_points = scene.scene.n_points ? scene.scene.n_points : NQM_TRANSPORT_POINTS;
    nqm_model *model;
    nqm_error err = {0};
    must(nqm_transport_create(&scene.scene, n_points, name, &model, &err), &err);
    return model;
}

static nqm_model *make_rays(void) {
    nqm_scene *made;
    nqm_rays rays;
    nqm_model *model;
    nqm_error err = {0};
    /* Lobes along and across the tangent are the most frequent. */
    const char *const specs[] = {"ggx:alpha=.1", "ggx:alpha=.1,.5", "ggx:alpha=.5,.1"};
    nqm_brdf *aims[3];
    for (size_t i = 0; i < 3; ++i)
        aims[i] = open_brdf(specs[i]);
    scene.scene.n_aims = 3;
    scene.scene.aims = (const nqm_brdf *const *)aims;
    scene.scene.n_points = scene.scene.n_points ? scene.scene.n_points : nqm_scene_options_default().n_points;
    must(nqm_scene_create(&scene.scene, &made, &err), &err);
    must(nqm_rays_draw(made, (size_t)n_rays, scene.scene.seed, &rays, &err), &err);
    must(nqm_rays_model(&rays, name, &model, &err), &err);
    nqm_rays_clear(&rays);
    for (size_t i = 0; i < 3; ++i)
        nqm_brdf_free(aims[i]);
    nqm_scene_free(made);
    return model;
}

int cmd_transport(int argc, char **argv) {
    scene = scene_args_begin();
    parse_arguments(&cmd, argc, argv);
    check_scene_files(&scene.scene);
    nqm_model *model = n_rays ? make_rays() : make_matrix();
    nqm_error err = {0};
    must(nqm_model_save(model, output_path(path), &err), &err);
    if (json)
        print_document(written_model(path, model));
    else
        report(EXIT_OK, "%s: %zu directions, %zu points", path, model->directions->n, model->n_points);
    nqm_model_free(model);
    return EXIT_OK;
}
