/* SPDX-License-Identifier: MIT
 *
 * authors_folder FOLDER [N]: write a made-up study in the layout of the paper's authors into an existing folder, with N
 * (default 500) directions: uniform_rand_500 (5 materials, one reference per row), test (20 materials, 180 rows, one
 * reference per material) and both CSVs. The encodings are perturbed presets; Delta-E is a function of their strength,
 * and JOD follows from the published curve, so that a regression gives the published coefficients.
 */
#include "percept/percept.h"
#include "sample/sample.h"
#include <errno.h>
#include <nqm/label.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { N_ENCODINGS = 9, N_TRAIN = 5, N_TEST = 20, MAX_DIRECTIONS = 1000 };

static const struct {
    const char *model;
    int level;
} encodings[N_ENCODINGS] = {{"ward", 0},  {"ggx", 0},   {"nbrdf", 0}, {"hbrdf", 0}, {"hbrdf", 1},
                            {"hbrdf", 2}, {"sbrdf", 0}, {"sbrdf", 1}, {"sbrdf", 2}};

typedef struct part {
    const char *root, *name, *csv;
    size_t first, n; /* presets */
    bool ref_per_row;
} part;

static nqm_directions *directions;
static nqm_error err;

static bool make_folder(const char *root, const char *name, const char *below) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s%s", root, name, below);
    return mkdir(path, 0777) == 0 || errno == EEXIST;
}

static bool save(const char *spec, const part *p, const char *below, const char *name) {
    static float rgb[3 * MAX_DIRECTIONS];
    char path[4096];
    nqm_brdf *brdf;
    snprintf(path, sizeof path, "%s/%s/%s/%s.mat", p->root, p->name, below, name);
    bool ok = nqm_brdf_open(spec, &brdf, &err) == NQM_OK &&
              nqm_sample(brdf, directions, NQM_INVALID_ERROR, rgb, NULL, NULL, &err) == NQM_OK &&
              nqm_samples_save_mat(directions, rgb, path, &err) == NQM_OK;
    nqm_brdf_free(brdf);
    return ok;
}

/* Distortion of encoding e of material m: 0.02 to about 0.5; the order of the encodings differs between materials. */
static double strength(size_t m, size_t e) {
    return 0.02 + 0.05 * (double)((e * (m % 4 + 2) + m) % 11 % N_ENCODINGS) + 0.003 * (double)m;
}

static bool write_row(const part *p, size_t m, size_t e, const char *preset, FILE *csv) {
    char spec[300], row[200];
    const char *material = strchr(preset, ':') + 1;
    double s = strength(m, e), delta_e = 2 + 90 * s;
    nqm_curve curve = nqm_curve_published;
    snprintf(row, sizeof row, "%.100s_%zu", material, e + 1);
    static const char *const forms[] = {"perturb:gloss=%g;of=%.100s", "perturb:tint=1,%g,1;of=%.100s",
                                        "perturb:scale=%g;of=%.100s"}; /* metrics rank these differently */
    snprintf(spec, sizeof spec, forms[e % 3], 1 + (e % 3 == 2 ? s : 2 * s), preset);
    fprintf(csv, "%s,%s,%d,%.15g,%.15g,%zu\n", row, encodings[e].model, encodings[e].level, delta_e,
            nqm_curve_jod(&curve, delta_e), e % 7);
    return save(spec, p, "model", row) && (!p->ref_per_row || save(preset, p, "ref", row));
}

static bool write_part(const part *p) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", p->root, p->csv);
    bool ok = make_folder(p->root, p->name, "") && make_folder(p->root, p->name, "/ref") &&
              make_folder(p->root, p->name, "/model");
    FILE *csv = ok ? fopen(path, "w") : NULL;
    if (!csv)
        return false;
    fputs("material,model,level,DeltaE,JOD,class\n", csv);
    for (size_t m = 0; ok && m < p->n; ++m) {
        const char *preset = nqm_brdf_preset_name(p->first + m);
        for (size_t e = 0; ok && e < N_ENCODINGS; ++e)
            ok = write_row(p, m, e, preset, csv);
        ok = ok && (p->ref_per_row || save(preset, p, "ref", strchr(preset, ':') + 1));
    }
    return fclose(csv) == 0 && ok;
}

int main(int argc, char **argv) {
    nqm_directions_options options = nqm_directions_options_default();
    options.n = argc > 2 ? strtoul(argv[2], NULL, 10) : 500;
    if (argc < 2 || options.n < 1 || options.n > MAX_DIRECTIONS) {
        fputs("usage: authors_folder FOLDER [N]\n", stderr);
        return 2;
    }
    size_t sgd = 0;
    while (strncmp(nqm_brdf_preset_name(sgd), "sgd:", 4) != 0)
        ++sgd;
    const part train = {argv[1], "uniform_rand_500", "labels_balanced_train.csv", sgd + N_TEST, N_TRAIN, true};
    const part test = {argv[1], "test", "labels_real.csv", sgd, N_TEST, false};
    bool ok = nqm_directions_create(&options, 0, NULL, &directions, &err) == NQM_OK && write_part(&train) &&
              write_part(&test);
    if (!ok)
        fprintf(stderr, "authors_folder: %s\n", err.message[0] ? err.message : strerror(errno));
    nqm_directions_free(directions);
    return !ok;
}
