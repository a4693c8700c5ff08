/* SPDX-License-Identifier: MIT
 *
 * Material files given as text, in the temporary file of temp_file.h.
 */
#include "support/material_text.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/temp_file.h"

static void write_file(const char *text) {
    FILE *f = fopen(temp_file, "wb");
    assert_non_null(f);
    fputs(text, f);
    fclose(f);
}

nqm_materials *open_text(const char *text) {
    nqm_materials *materials = NULL;
    nqm_error err = {0};
    write_file(text);
    if (nqm_materials_open(temp_file, &materials, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return materials;
}

void expect_spec(const char *text, const char *spec) {
    nqm_materials *materials = open_text(text);
    assert_int_equal(nqm_materials_count(materials), 1);
    const nqm_material_info info = nqm_materials_get(materials, 0);
    if (info.refusal)
        fail_msg("refused: %s", info.refusal);
    assert_string_equal(info.spec, spec);
    nqm_materials_free(materials);
}

void expect_refusal(const char *text, const char *reason) {
    nqm_materials *materials = open_text(text);
    assert_int_equal(nqm_materials_count(materials), 1);
    const nqm_material_info info = nqm_materials_get(materials, 0);
    assert_null(info.spec);
    if (!strstr(info.refusal, reason))
        fail_msg("'%s' does not contain '%s'", info.refusal, reason);
    nqm_materials_free(materials);
}

void expect_error(const char *text, nqm_status status, const char *reason) {
    nqm_materials *materials;
    nqm_error err;
    write_file(text);
    assert_int_equal(nqm_materials_open(temp_file, &materials, &err), status);
    assert_null(materials);
    if (!strstr(err.message, reason))
        fail_msg("'%s' does not contain '%s'", err.message, reason);
    assert_true(err.byte_offset >= 0);
}

void expect_same(const char *argument, const char *extension) {
    char path[300], with_name[320];
    snprintf(path, sizeof path, "%s.%s", temp_file, extension);
    snprintf(with_name, sizeof with_name, "%s:some_name", path);
    nqm_brdf *brdf = must_open(argument);
    nqm_error err = {0};
    if (nqm_material_write(nqm_brdf_get_info(brdf).spec, "some name", path, &err) != NQM_OK)
        fail_msg("%s", err.message);
    nqm_brdf *back = must_open(with_name);
    assert_string_equal(nqm_brdf_get_info(back).spec, nqm_brdf_get_info(brdf).spec);
    nqm_brdf_free(back);
    nqm_brdf_free(brdf);
    unlink(path);
}

void expect_survives_no_memory(const char *text) {
    nqm_status status = NQM_OK;
    long n = -1;
    write_file(text);
    EVERY_ALLOCATION(n, status, 0) {
        nqm_materials *materials;
        status = nqm_materials_open(temp_file, &materials, NULL);
        assert_true((status == NQM_OK) == (materials != NULL));
        nqm_materials_free(materials);
    }
}
