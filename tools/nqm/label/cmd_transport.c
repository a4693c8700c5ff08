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
    if (strcmp(path, "-") != 0)
        must(nqm_model_load(path, &loaded, &fault));
    json_t *document = json_model(loaded ? loaded : model);
    nqm_model_free(loaded);
    return document;
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

static const char *path, *name = "transport";
static bool json, slopes;
static scene_args scene;

static const option options[] = {
    {"output", 'o', OPTION_NEEDED, &path, "FILE.safetensors", "the model to write", 0, 0},
    {"id", 0, OPTION_TEXT, &name, "NAME", "the model's name", 0, 0},
    {"anisotropic", 0, OPTION_FLAG, &slopes, NULL, "make a model for anisotropic BRDFs (default 128 points)", 0, 0},
    {"json", 0, OPTION_FLAG, &json, NULL, "print the model's properties as JSON", 0, 0},
    {0}};
static const choice choices[] = {{"make", "", "the only word so far"}, {0}};

static const command cmd = {
    .usage = "make -o FILE [options]",
    .about = "Make a metric for a scene of your own, without training: with fixed light, every point of a picture is "
             "linear in the BRDF, so a matrix makes small pictures from samples. The result is a model for --model, "
             "which predicts the Delta-E ITP and JOD of this scene. --points is a multiple of 32 (default 256, of all"
             " scenes together). --model transport has the standard scenes.",
    .example = "nqm transport make --light studio --shape sphere -o studio.safetensors\n"
               "nqm score sgd:nickel ward:nickel --model studio.safetensors",
    .options = options,
    .choices = choices,
    .table = &nqm_scene_option_table,
    .table_target = &scene.scene,
    .min_arguments = 1,
};

int cmd_transport(int argc, char **argv) {
    scene = scene_args_begin();
    parse_arguments(&cmd, argc, argv);
    check_scene_files(&scene.scene);
    const size_t usual = slopes ? NQM_TRANSPORT_POINTS / 2 : NQM_TRANSPORT_POINTS;
    const size_t n_points = scene.scene.n_points ? scene.scene.n_points : usual;
    nqm_model *model;
    must(nqm_transport_create(&scene.scene, slopes, n_points, name, &model, &fault));
    must(nqm_model_save(model, output_path(path), &fault));
    if (json)
        print_document(written_model(path, model));
    else
        report(EXIT_OK, "%s: %zu directions, %zu points", path,
               nqm_directions_get_info(nqm_model_get_info(model).directions).n, n_points);
    nqm_model_free(model);
    return EXIT_OK;
}
