/* SPDX-License-Identifier: MIT
 *
 * Arguments: the parts of their texts, the files that they read, and material files that stay parsed.
 */
#include "argument/argument.h"
#include "base/memory_test.h"
#include "support/allocations.h"
#include "support/brdf_files.h"
#include "support/check.h"
#include "support/rows.h"

#include <sys/stat.h>

static const char *merl_path(void) {
    const char *path = scratch_path("table.binary");
    if (access(path, R_OK) != 0)
        blob_put(make_merl(), path);
    return path;
}

static const char *gltf_path(void) {
    char text[] = "{\"asset\":{\"version\":\"2.0\"},\"materials\":[{\"name\":\"a\"},{\"name\":\"b:c\"}]}";
    const char *path = scratch_path("two.gltf");
    blob_save(&(blob){(unsigned char *)text, sizeof text - 1}, path);
    return path;
}

/* ---- texts ------------------------------------------------------------------------------------------------------- */

TEST(texts_have_kinds) {
    static const char *const kinds[] = {
        [NQM_ARGUMENT_NOTHING] = "nothing", [NQM_ARGUMENT_SPEC] = "spec", [NQM_ARGUMENT_WRAPPER] = "wrapper",
        [NQM_ARGUMENT_FIT] = "fit",         [NQM_ARGUMENT_MAPS] = "maps", [NQM_ARGUMENT_FOLDER] = "folder"};
    EVERY_ROW(row, "kinds of arguments") {
        nqm_argument *a = nqm_argument_parse(row[0], NULL);
        char parts[400];
        snprintf(parts, sizeof parts, "%s %u %s", kinds[a->kind], a->ignored, a->settings ? a->settings : a->rest);
        assert_string_equal(parts, row[1]);
        snprintf(parts, sizeof parts, "%s+%s", a->with ? a->with : "", a->of ? a->of : "");
        assert_string_equal(parts, row[2]);
        assert_int_equal(nqm_argument_kind_of(row[0]) == NQM_ARGUMENT_NOTHING, !a->settings && a->path);
        assert_int_equal(nqm_argument_ignored(row[0]), a->ignored);
        nqm_argument_free(a);
    }
}

TEST(names_end_at_an_equals_sign) {
    assert_int_equal(nqm_argument_name_length("old=sgd:nickel"), 3);
    assert_int_equal(nqm_argument_name_length("old="), 0);
    assert_int_equal(nqm_argument_name_length("a/b=c"), 0);
    assert_int_equal(nqm_argument_name_length("ggx,alpha=.1"), 0);
}

/* Members may have colons in their names. */
TEST(materials_are_selected) {
    char text[300];
    nqm_material_info info;
    snprintf(text, sizeof text, "%s:b:c", gltf_path());
    nqm_argument *a = nqm_argument_parse(text, NULL), *library = nqm_argument_parse(gltf_path(), NULL);
    assert_int_equal(a->kind, NQM_ARGUMENT_MATERIAL);
    assert_string_equal(a->member, "b:c");
    assert_true(nqm_argument_material(a, &info) && !nqm_argument_library(a) && !nqm_argument_is_textured(a));
    assert_string_equal(info.name, "b:c");
    assert_false(nqm_argument_material(library, &info));
    assert_int_equal(nqm_materials_count(nqm_argument_library(library)), 2);
    assert_null(nqm_argument_reflecting(a, ~0U));
    nqm_argument_free(library);
    nqm_argument_free(a);
}

/* A file that stays parsed is not read again; without a list it is. */
TEST(files_stay_parsed) {
    nqm_argument_files *files = nqm_argument_files_create();
    nqm_argument *a = nqm_argument_parse(gltf_path(), files), *b = nqm_argument_parse(a->text, files);
    const nqm_materials *first = a->materials;
    assert_ptr_equal(b->materials, first);
    nqm_argument_free(a);
    nqm_argument_free(b);
    char other[300];
    for (int i = 0; i < 4; ++i) { /* the last used files remain */
        char text[] = "{\"asset\":{\"version\":\"2.0\"},\"materials\":[{}]}";
        blob_save(&(blob){(unsigned char *)text, sizeof text - 1}, strcpy(other, scratch_path("one.gltf")));
        a = nqm_argument_parse(other, files);
        assert_int_equal(a->kind, NQM_ARGUMENT_MATERIAL);
        nqm_argument_free(a);
    }
    a = nqm_argument_parse(gltf_path(), files);
    assert_ptr_equal(a->materials, first);
    nqm_argument_files_free(files);
    assert_int_equal(nqm_materials_count(a->materials), 2); /* held */
    nqm_argument_free(a);
}

TEST(an_argument_is_opened_again) {
    nqm_argument *a = nqm_argument_parse(merl_path(), NULL);
    for (int i = 0; i < 2; ++i) {
        nqm_brdf *brdf;
        assert_int_equal(nqm_argument_open(a, &brdf, NULL), NQM_OK);
        assert_string_equal(nqm_brdf_get_info(brdf).name, merl_path());
        nqm_brdf_free(brdf);
    }
    nqm_argument_free(a);
}

static void note_file(void *user, const char *path) {
    const char *slash = strrchr(path, '/');
    strcat(strcat(user, slash ? slash + 1 : path), " ");
}

TEST(files_of_nested_arguments_are_visited) {
    char text[900], visited[300] = "";
    snprintf(text, sizeof text, "between:t=.5;with=(%s:a);of=perturb:gloss=.8;of=%s", gltf_path(), merl_path());
    nqm_argument *a = nqm_argument_parse(text, NULL);
    nqm_argument_visit_files(a, note_file, visited);
    nqm_argument_free(a);
    a = nqm_argument_parse("maps:base_color=x/a.png;roughness=b.png", NULL);
    nqm_argument_visit_files(a, note_file, visited);
    nqm_argument_free(a);
    a = nqm_argument_parse("perturb:;of=maps:base_color=a.png", NULL); /* it cannot be opened */
    nqm_argument_visit_files(a, note_file, visited);
    nqm_argument_free(a);
    assert_string_equal(visited, "two.gltf table.binary a.png b.png ");
}

TEST(failed_allocations_are_told) {
    char text[300];
    snprintf(text, sizeof text, "%s:a", gltf_path());
    assert_true(check_brdf_allocations(text) > 10);
}

/* ---- names in lists ---------------------------------------------------------------------------------------------- */

TEST(relative_paths_start_at_the_root) {
    EVERY_ROW(row, "paths below a root") {
        char *path = nqm_argument_below(row[0], row[1]);
        assert_string_equal(path, row[2]);
        nqm_free(path);
    }
    const char *merl = merl_path(), *slash = strrchr(merl, '/');
    char folder[4096];
    nqm_brdf *brdf;
    assert_true((size_t)snprintf(folder, sizeof folder, "%.*s", (int)(slash - merl), merl) < sizeof folder);
    assert_int_equal(nqm_argument_open_below(slash + 1, folder, &brdf, NULL), NQM_OK);
    nqm_brdf_free(brdf);
    assert_int_equal(nqm_argument_open_below(slash + 1, NULL, &brdf, NULL), NQM_ERR_IO);
    assert_null(brdf);
}

static void check_companion(const char *file, const char *member, nqm_status expected, const char *beside) {
    char text[500], *companion;
    snprintf(text, sizeof text, "%s%s%s", file, member ? ":" : "", member ? member : "");
    nqm_argument *a = nqm_argument_parse(text, NULL);
    assert_int_equal(nqm_argument_companion(a, &companion, NULL), expected);
    assert_true(beside ? strcmp(companion, beside) == 0 : !companion);
    nqm_free(companion);
    nqm_argument_free(a);
}

TEST(companions_are_in_the_folder_of_the_file) {
    static const struct {
        const char *path, *name, *beside;
    } cases[] = {{"data/m.xml", "a.bsdf", "data/a.bsdf"},
                 {"/m.xml", "a.bsdf", "/a.bsdf"},
                 {"m.xml", "b/a.bsdf", "b/a.bsdf"},
                 {"data/m.xml", "/a.bsdf", "/a.bsdf"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char *path = nqm_path_beside(cases[i].path, cases[i].name);
        assert_string_equal(path, cases[i].beside);
        nqm_free(path);
    }
    const char *file = scratch_path("measured.xml");
    FILE *stream = fopen(file, "w");
    fputs(
        "<scene version=\"3.0.0\"><bsdf type=\"measured\" id=\"a\"><string name=\"filename\" value=\"a.bsdf\"/></bsdf>"
        "<bsdf type=\"diffuse\" id=\"b\"/></scene>",
        stream);
    assert_int_equal(fclose(stream), 0);
    check_companion(file, "a", NQM_OK, scratch_path("a.bsdf"));
    check_companion(file, "b", NQM_OK, NULL);
    check_companion(file, "c", NQM_ERR_ARG, NULL);
    check_companion(merl_path(), NULL, NQM_OK, NULL);
}
