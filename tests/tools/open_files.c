/* SPDX-License-Identifier: MIT
 *
 * open_files - reads lines "KIND<tab>FILE" from standard input, opens each file with the reader of its kind, and writes
 * "CODE<tab>MESSAGE" for each: the exit code that the tool would end with, 0 for a file that was accepted. The kind
 * `spec` is a file with the text of a BRDF argument. A BRDF is also evaluated, and must give finite values.
 */
#include "data/data.h"
#include "encode/encode.h"
#include "io/raster.h"
#include "nqm/tool.h"
#include "pairs/pairs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static nqm_status open_brdf_file(const char *path, nqm_error *err) {
    nqm_brdf *brdf;
    const nqm_status status = nqm_brdf_open(path, &brdf, err);
    const double hd[6] = {0.1, 0.2, 0.3, 0.5, 0.6, 1.5};
    double rgb[6] = {0};
    if (status == NQM_OK)
        nqm_brdf_eval_half_diff(brdf, 2, hd, rgb, NULL);
    for (size_t i = 0; i < 6; ++i)
        if (!isfinite(rgb[i]))
            abort();
    nqm_brdf_free(brdf);
    return status;
}

static nqm_status open_spec(const char *path, nqm_error *err) {
    char text[1 << 16];
    FILE *file = fopen(path, "rb");
    const size_t n = file ? fread(text, 1, sizeof text - 1, file) : 0;
    if (file)
        fclose(file);
    text[n] = '\0';
    return open_brdf_file(text, err);
}

static nqm_status open_model_file(const char *path, nqm_error *err) {
    nqm_model *model;
    const nqm_status status = nqm_model_load(path, &model, err);
    nqm_model_free(model);
    return status;
}

static nqm_status open_dataset_file(const char *path, nqm_error *err) {
    nqm_dataset *dataset;
    const nqm_status status = nqm_dataset_load(path, NULL, NQM_SPLIT_ALL, &dataset, err);
    nqm_dataset_free(dataset);
    return status;
}

static nqm_status open_directions_file(const char *path, nqm_error *err) {
    nqm_directions *directions;
    const nqm_status status = nqm_directions_load_csv(path, &directions, err);
    nqm_directions_free(directions);
    return status;
}

static nqm_status open_list(const char *path, nqm_error *err) {
    nqm_pairs *list;
    const nqm_status status = nqm_pairs_read(path, &list, err);
    nqm_pairs_free(list);
    return status;
}

static nqm_status open_human(const char *path, nqm_error *err) {
    nqm_human *human;
    const nqm_status status = nqm_human_load(path, &(nqm_human_options){0}, &human, err);
    nqm_human_free(human);
    return status;
}

static nqm_status open_mesh(const char *path, nqm_error *err) {
    nqm_mesh mesh;
    const nqm_status status = nqm_mesh_load(path, &mesh, err);
    nqm_mesh_free(&mesh);
    return status;
}

static nqm_status open_image(const char *path, nqm_error *err) {
    nqm_image image;
    const nqm_status status = nqm_image_load(path, &image, err);
    if (status == NQM_OK)
        nqm_free(image.rgb);
    return status;
}

static nqm_status open_map(const char *path, nqm_error *err) {
    nqm_map map;
    nqm_raster raster = {0};
    nqm_status status = nqm_map_open(path, &map, err);
    if (status == NQM_OK)
        status = nqm_raster_decode(map.data, map.n_bytes, path, &raster, err);
    nqm_raster_clear(&raster);
    nqm_map_close(&map);
    return status;
}

/* The variable "r" of 4 x 1. */
static nqm_status open_mat(const char *path, nqm_error *err) {
    nqm_mat *mat;
    double r[4];
    nqm_status status = nqm_mat_open(path, &mat, err);
    if (status == NQM_OK)
        status = nqm_mat_read(mat, "r", 4, 1, r, err);
    nqm_mat_close(mat);
    return status;
}

static nqm_status open_encoder(const char *path, nqm_error *err) {
    nqm_map map;
    nqm_hyper hyper = {0};
    nqm_status status = nqm_map_open(path, &map, err);
    if (status == NQM_OK)
        status = nqm_hyper_read(map.n_bytes ? map.data : (const unsigned char *)"", map.n_bytes, path, &hyper, err);
    nqm_free(hyper.block);
    nqm_map_close(&map);
    return status;
}

static const struct {
    const char *kind;
    nqm_status (*open)(const char *path, nqm_error *err);
} readers[] = {{"brdf", open_brdf_file},   {"spec", open_spec},
               {"model", open_model_file}, {"dataset", open_dataset_file},
               {"list", open_list},        {"directions", open_directions_file},
               {"human", open_human},      {"mesh", open_mesh},
               {"image", open_image},      {"mat", open_mat},
               {"encoder", open_encoder},  {"map", open_map}};

static void open_line(char *line) {
    char *path = strchr(line, '\t');
    nqm_error err = {0};
    line[strcspn(line, "\n")] = '\0';
    if (path)
        *path++ = '\0';
    for (size_t i = 0; path && i < sizeof readers / sizeof *readers; ++i)
        if (strcmp(readers[i].kind, line) == 0) {
            const nqm_status status = readers[i].open(path, &err);
            for (char *p = err.message; *p; ++p)
                *p = *p == '\n' || *p == '\t' ? ' ' : *p;
            printf("%d\t%s\n", exit_code_of(status), err.message);
            fflush(stdout);
            return;
        }
    fprintf(stderr, "open_files: no reader for '%s'\n", line);
    exit(2);
}

int main(void) {
    char *line = NULL;
    size_t room = 0;
    while (getline(&line, &room, stdin) > 0)
        open_line(line);
    free(line);
    return 0;
}
