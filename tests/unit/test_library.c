/* SPDX-License-Identifier: MIT
 *
 * Libraries: pairs of materials that look alike, and of versions; what callbacks are told; cancellation; lack of memory.
 */
#include "support/allocations.h"
#include "support/check.h"
#include "support/scratch.h"
#include <nqm/library.h>

#define MATERIAL(NAME, ROUGHNESS)                                                                                      \
    "{\"name\": \"" NAME "\", \"pbrMetallicRoughness\": {\"roughnessFactor\": " ROUGHNESS "}}"
#define FILE_OF(MATERIALS) "{\"asset\": {\"version\": \"2.0\"}, \"materials\": [" MATERIALS "]}"

static const nqm_model *open_transport(void) {
    static nqm_model *model;
    if (!model)
        assert_int_equal(nqm_model_load("transport", &model, NULL), NQM_OK);
    return model;
}

static const char *old_file(void) {
    return scratch_text("old.gltf", FILE_OF(MATERIAL("a", "0.3") ", " MATERIAL("b", "0.301") ", " MATERIAL(
                                        "c", "0.6") ", " MATERIAL("gone", "0.9")));
}

static const char *new_file(void) {
    return scratch_text("new.gltf", FILE_OF(MATERIAL("a", "0.3") ", " MATERIAL("b", "0.4") ", " MATERIAL(
                                        "renamed", "0.6") ", " MATERIAL("new", "0.1")));
}

static nqm_library *open_one(const char *path, const nqm_library_options *options) {
    nqm_library *library;
    nqm_error err = {0};
    if (nqm_library_open(1, &path, open_transport(), options, &library, &err) != NQM_OK)
        fail_msg("%s", err.message);
    return library;
}

TEST(clusters_and_the_nearest) {
    const nqm_library_pair *pairs;
    size_t n;
    nqm_library *library = open_one(old_file(), NULL);
    assert_int_equal(library->n, 4);
    assert_string_equal(library->members[1].key, "b");
    assert_int_equal(nqm_library_near(library, &(nqm_library_query){.jod = 9.5}, &n, &pairs, NULL), NQM_OK);
    assert_int_equal(n, 1);
    assert_int_equal(pairs[0].ref, 1);
    assert_int_equal(pairs[0].test, 0);
    assert_true(pairs[0].result.jod >= 9.5 && !pairs[0].texture);
    const nqm_library_query query = {.to = library->members[2].argument, .n = 1};
    assert_int_equal(nqm_library_near(library, &query, &n, &pairs, NULL), NQM_OK);
    assert_int_equal(n, 4);
    assert_int_equal(pairs[0].ref, SIZE_MAX);
    assert_int_equal(pairs[0].test, 2);
    assert_true(pairs[0].result.identical && pairs[1].result.jod >= pairs[2].result.jod);
    assert_int_equal(nqm_library_near(library, &(nqm_library_query){.jod = 8}, &n, &pairs, NULL), NQM_ERR_ARG);
    nqm_library_free(library);
}

TEST(versions) {
    const nqm_library_pair *pairs;
    size_t n;
    nqm_library *before = open_one(old_file(), NULL), *after = open_one(new_file(), NULL);
    assert_int_equal(nqm_library_diff(before, after, &n, &pairs, NULL), NQM_OK);
    assert_int_equal(n, 5);
    assert_string_equal(after->members[pairs[0].test].key, "b"); /* worst first */
    assert_int_equal(pairs[0].n_changes, 1);
    assert_string_equal(pairs[0].changes[0].property, "roughness");
    assert_true(pairs[0].changes[0].before.v[0] == 0.301 && pairs[0].changes[0].after.v[0] == 0.4);
    assert_int_equal(pairs[2].ref, 2); /* renamed */
    assert_int_equal(pairs[2].test, 2);
    assert_true(pairs[3].ref == 3 && pairs[3].test == SIZE_MAX && pairs[4].ref == SIZE_MAX && pairs[4].test == 3);
    nqm_library_free(before);
    nqm_library_free(after);
}

static void note_status(void *user, nqm_status status, const char *message) {
    *(nqm_status *)user = *message ? status : NQM_OK;
}

static int stop_at_once(void *user, const char *stage, double done, double total) {
    (void)user, (void)stage, (void)done, (void)total;
    return 1;
}

TEST(faults) {
    nqm_library *library;
    nqm_error err = {0};
    nqm_status told = NQM_OK;
    const char *path = old_file(), *none = "/nowhere";
    assert_int_equal(nqm_library_open(1, &none, open_transport(), NULL, &library, &err), NQM_ERR_IO);
    assert_null(library);
    assert_int_equal(nqm_library_open(1, &path, NULL, &(nqm_library_options){.ignore = "glass"}, &library, &err),
                     NQM_ERR_ARG);
    assert_int_equal(
        nqm_library_open(1, &path, open_transport(), &(nqm_library_options){.index = path}, &library, &err),
        NQM_ERR_ARG);
    assert_int_equal(
        nqm_library_open(1, &path, open_transport(), &(nqm_library_options){.progress = stop_at_once}, &library, &err),
        NQM_ERR_CANCELLED);
    assert_null(library);
    const char *both[] = {path, scratch_text("broken.gltf", "{")};
    assert_int_equal(
        nqm_library_open(2, both, NULL, &(nqm_library_options){.report = note_status, .user = &told}, &library, &err),
        NQM_OK);
    assert_int_equal(told, NQM_ERR_FORMAT);
    assert_true(library->n == 4 && library->n_failed == 1);
    nqm_library_free(library);
}

static nqm_status find_all(const char *const *paths, const char *index, nqm_error *err) {
    nqm_library *libraries[2] = {NULL, NULL};
    const nqm_library_pair *pairs;
    const nqm_library_options options = {.index = index};
    size_t n;
    nqm_status status = nqm_library_open(1, &paths[0], open_transport(), &options, &libraries[0], err);
    if (status == NQM_OK)
        status = nqm_library_open(1, &paths[1], open_transport(), NULL, &libraries[1], err);
    if (status == NQM_OK)
        status = nqm_library_diff(libraries[0], libraries[1], &n, &pairs, err);
    if (status == NQM_OK)
        status = nqm_library_near(libraries[0], &(nqm_library_query){.jod = 9.5}, &n, &pairs, err);
    if (status == NQM_OK)
        status = nqm_library_near(libraries[0], &(nqm_library_query){.to = "sgd:nickel", .n = 1}, &n, &pairs, err);
    nqm_library_free(libraries[0]);
    nqm_library_free(libraries[1]);
    return status;
}

/* An allocation that fails while a material is opened is a fault of that material, as in scores by name. */
TEST(out_of_memory) {
    const char *paths[] = {old_file(), new_file()}, *index = scratch_path("file.index");
    nqm_error err = {0};
    assert_int_equal(find_all(paths, NULL, &err), NQM_OK);
    for (long n = 0; n < 400; n += 1 + n / 20) {
        nqm_alloc_fail_after(n);
        const nqm_status status = find_all(paths, n % 2 ? index : NULL, &err);
        nqm_alloc_fail_after(-1);
        assert_true(status == NQM_OK || status == NQM_ERR_NOMEM || status == NQM_ERR_FORMAT);
    }
    assert_int_equal(find_all(paths, index, &err), NQM_OK);
}
