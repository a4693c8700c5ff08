/* SPDX-License-Identifier: MIT
 *
 * The example materials of MaterialX and OpenPBR (shared data): accepted, or refused for the first input that an
 * independent reader of the files names (tests/vectors/material_examples.py). Accepted ones open, and reflect not much
 * more than white; textured ones have maps.
 */
#include "material/maps.h"
#include "support/check.h"
#include <nqm/material.h>

static void check_material(const char *path, const char *name, const char *surface, const char *verdict,
                           bool is_textured) {
    nqm_materials *materials = NULL;
    nqm_error err = {0};
    size_t i = 0;
    if (nqm_materials_open(path, &materials, &err) != NQM_OK)
        fail_msg("%s", err.message);
    while (i < nqm_materials_count(materials) && strcmp(nqm_materials_get(materials, i).name, name) != 0)
        ++i;
    assert_true(i < nqm_materials_count(materials));
    const nqm_material_info info = nqm_materials_get(materials, i);
    assert_string_equal(info.surface, surface);
    if (!nqm_materials_maps(materials, i, 0) == is_textured)
        fail_msg("%s:%s: %s", path, name, info.refusal);
    if (strcmp(verdict, "accepted") != 0) {
        if (!info.refusal || strncmp(info.refusal, verdict, strlen(verdict)) != 0)
            fail_msg("%s:%s: '%s' instead of '%s'", path, name, info.refusal ? info.refusal : "accepted", verdict);
    } else {
        double albedo[3];
        if (info.refusal)
            fail_msg("%s:%s: refused: %s", path, name, info.refusal);
        nqm_brdf *brdf = must_open(info.spec);
        nqm_brdf_albedo(brdf, 0.5, 1, albedo);
        assert_true(albedo[0] > 0 && albedo[0] < 1.1 && albedo[1] < 1.1 && albedo[2] < 1.1);
        nqm_brdf_free(brdf);
    }
    nqm_materials_free(materials);
}

TEST(test_examples) {
    nqm_csv *csv;
    size_t n_accepted = 0, n_textured = 0;
    if (!shared_data("materials"))
        skip();
    assert_int_equal(nqm_csv_load(test_vector("material_examples.csv"), &csv, NULL), NQM_OK);
    for (size_t row = 0; row < nqm_csv_rows(csv); ++row) {
        char relative[256], path[5000];
        const char *verdict = nqm_csv_text(csv, row, 3);
        snprintf(relative, sizeof relative, "materials/%s", nqm_csv_text(csv, row, 0));
        snprintf(path, sizeof path, "%s", shared_data(relative));
        const bool is_textured = *nqm_csv_text(csv, row, 4) == '1';
        nqm_materials *materials = NULL;
        if (strcmp(verdict, "no material") == 0) {
            nqm_error err = {0};
            assert_int_equal(nqm_materials_open(path, &materials, &err), NQM_ERR_FORMAT);
            assert_non_null(strstr(err.message, "includes"));
            continue;
        }
        check_material(path, nqm_csv_text(csv, row, 1), nqm_csv_text(csv, row, 2), verdict, is_textured);
        n_textured += is_textured;
        n_accepted += strcmp(verdict, "accepted") == 0;
    }
    assert_int_equal(n_accepted, 69);
    assert_int_equal(n_textured, 20); /* of 23 that have textures or computed values */
    nqm_csv_free(csv);
}
