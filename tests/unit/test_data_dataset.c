/* SPDX-License-Identifier: MIT
 *
 * Dataset files: written data are read back, datasets that break an invariant are refused, damage at any place of a
 * file is detected, splits belong to materials.
 */
#include "support/allocations.h"
#include "support/check.h"
#include "support/damage.h"
#include "support/toy_dataset.h"

static const char path[] = "test_train_dataset.safetensors";

static nqm_dataset *toy;

static int make_toy(void **state) {
    (void)state;
    toy_options o = toy_options_default();
    o.with_masks = o.with_transport = true;
    o.n_groups = 4;
    o.pairs_per_ref = 3;
    toy = toy_dataset(&o);
    return 0;
}

static int drop_toy(void **state) {
    (void)state;
    nqm_dataset_free(toy);
    unlink(path);
    return 0;
}

TEST(round_trip) {
    char sha256[65];
    nqm_dataset *d;
    assert_int_equal(nqm_dataset_write(toy, path, sha256, NULL), NQM_OK);
    assert_int_equal(nqm_dataset_load(path, NULL, NQM_SPLIT_ALL, &d, NULL), NQM_OK);
    nqm_dataset_info info = nqm_dataset_get_info(d);
    assert_int_equal(info.n_directions, 16);
    assert_int_equal(info.n_refs, 8);
    assert_int_equal(info.n_groups, 4);
    assert_int_equal(info.n_pairs, 24);
    assert_int_equal(info.n_pairs_in[NQM_SPLIT_TRAIN], 12);
    assert_int_equal(info.n_pairs_in[NQM_SPLIT_VALIDATION], 6);
    assert_int_equal(info.n_pairs_in[NQM_SPLIT_TEST], 6);
    assert_string_equal(info.sha256, sha256);
    assert_string_equal(info.manifest, toy->manifest);
    assert_string_equal(nqm_directions_id(info.directions), nqm_directions_id(toy->directions));
    assert_int_equal(nqm_dataset_get_info(d).n_kinds, 2);
    assert_string_equal(nqm_dataset_get_kind(d, 1).name, "gloss");
    assert_null(nqm_dataset_get_kind(d, 2).name);
    assert_string_equal(nqm_dataset_get_kind(d, 1).family, "encoding");
    assert_null(nqm_dataset_get_kind(d, 2).family);
    char before[65], after[65]; /* of all arrays */
    assert_int_equal(nqm_dataset_hash(toy, before, NULL), NQM_OK);
    assert_int_equal(nqm_dataset_hash(d, after, NULL), NQM_OK);
    assert_string_equal(before, after);
    assert_memory_equal(d->delta_e_error, toy->delta_e_error, info.n_pairs * sizeof *d->delta_e_error);
    assert_memory_equal(d->transport, toy->transport, 16 * 3 * NQM_TRANSPORT_POINTS * sizeof *d->transport);
    assert_memory_equal(d->transport_points, toy->transport_points,
                        3 * NQM_TRANSPORT_POINTS * sizeof *d->transport_points);
    for (size_t i = 0; i < info.n_pairs; ++i) {
        nqm_dataset_pair a = nqm_dataset_get_pair(toy, i), b = nqm_dataset_get_pair(d, i);
        assert_string_equal(a.ref, b.ref);
        assert_string_equal(a.group, b.group);
        assert_string_equal(a.test, b.test);
        assert_string_equal(a.kind, b.kind);
        assert_string_equal(a.family, b.family);
        assert_int_equal(a.split, b.split);
    }
    nqm_dataset_free(d);
}

/* Files of earlier versions have no families. */
TEST(families_may_be_missing) {
    nqm_dataset old = *toy, *d;
    old.kind_families = (nqm_names){0};
    assert_int_equal(nqm_dataset_write(&old, path, NULL, NULL), NQM_OK);
    assert_int_equal(nqm_dataset_load(path, NULL, NQM_SPLIT_ALL, &d, NULL), NQM_OK);
    assert_string_equal(nqm_dataset_get_kind(d, 1).family, "");
    nqm_dataset_free(d);
}

/* Datasets of older builds have no errors of labels: the hash of their content is that of a file without the array. */
TEST(errors_may_be_missing) {
    nqm_dataset old = *toy, *d;
    char with[65], without[65];
    old.delta_e_error = NULL;
    assert_int_equal(nqm_dataset_write(&old, path, NULL, NULL), NQM_OK);
    assert_int_equal(nqm_dataset_load(path, NULL, NQM_SPLIT_ALL, &d, NULL), NQM_OK);
    assert_null(d->delta_e_error);
    assert_int_equal(nqm_dataset_hash(toy, with, NULL), NQM_OK);
    assert_int_equal(nqm_dataset_hash(d, without, NULL), NQM_OK);
    assert_string_not_equal(with, without);
    nqm_dataset_free(d);
}

/* Sources are those of the manifest, if it lists all references under their names. */
TEST(sources_of_references) {
    static const char *const words[] = {"rgl", "rgl-unfolded", "merl", "nbrdf", "nps", "sgd", "renderer", "rglx"};
    static const char *const groups[] = {"measured", "measured", "measured", "neural",
                                         "neural",   "analytic", "renderer", "rglx"};
    char manifest[1000];
    for (int turn = 0; turn < 3; ++turn) {
        nqm_dataset made = *toy, *d;
        size_t n = (size_t)snprintf(manifest, sizeof manifest, "{\"references\": [");
        for (size_t r = 0; r < 8 - (turn == 1); ++r)
            n += (size_t)snprintf(manifest + n, sizeof manifest - n,
                                  "%s{\"name\": \"reference %zu\", \"source\": \"%s\"}", r ? ", " : "",
                                  turn == 2 ? 7 - r : r, words[r]);
        snprintf(manifest + n, sizeof manifest - n, "]}");
        made.manifest = manifest;
        assert_int_equal(nqm_dataset_write(&made, path, NULL, NULL), NQM_OK);
        assert_int_equal(nqm_dataset_load(path, NULL, NQM_SPLIT_ALL, &d, NULL), NQM_OK);
        for (size_t i = 0; i < d->n_pairs; ++i)
            assert_string_equal(nqm_dataset_get_pair(d, i).source, turn ? "" : groups[d->pair_ref[i]]);
        nqm_dataset_free(d);
    }
    assert_string_equal(nqm_dataset_get_pair(toy, 0).source, "");
}

/* All references of a material must be in the same split. */
TEST(splits_belong_to_materials) {
    for (size_t i = 0; i < toy->n_pairs; ++i)
        for (size_t k = 0; k < toy->n_pairs; ++k) {
            nqm_dataset_pair a = nqm_dataset_get_pair(toy, i), b = nqm_dataset_get_pair(toy, k);
            if (strcmp(a.group, b.group) == 0)
                assert_int_equal(a.split, b.split);
        }
}

/* A dataset with one invalid array must be refused with a message that contains `words`. */
static void refuse(const nqm_dataset *broken, const char *words) {
    nqm_error err = {0};
    nqm_status status = nqm_dataset_validate(broken, "toy", &err);
    assert_true(status == NQM_ERR_FORMAT || status == NQM_ERR_LIMIT);
    assert_non_null(strstr(err.message, words));
    assert_non_null(strstr(err.message, "toy"));
}

TEST(broken_promises) {
    assert_int_equal(nqm_dataset_validate(toy, "toy", NULL), NQM_OK);
    float *rgb = malloc(toy->n_refs * toy->n_directions * 3 * sizeof *rgb);
    assert_non_null(rgb);
    const float bad[] = {-INFINITY, INFINITY, NAN};
    for (size_t i = 0; i < 3; ++i) {
        memcpy(rgb, toy->ref_rgb, toy->n_refs * toy->n_directions * 3 * sizeof *rgb);
        rgb[17] = bad[i];
        nqm_dataset d = *toy;
        d.ref_rgb = rgb;
        refuse(&d, "direction 5");
    }
    free(rgb);
    uint32_t index[24] = {[23] = 8};
    nqm_dataset d = *toy;
    d.pair_ref = index;
    refuse(&d, "pair_ref[23]");
    d = *toy;
    d.pair_kind = index;
    refuse(&d, "pair_kind[23]");
    d = *toy;
    d.n_groups = 3;
    refuse(&d, "ref_group");
    double label[24] = {[3] = 11.5};
    d = *toy;
    d.jod = label;
    refuse(&d, "JOD of pair 3");
    label[3] = -1;
    d = *toy;
    d.delta_e = label;
    refuse(&d, "Delta-E of pair 3");
    const double bad_errors[] = {-1, INFINITY, NAN};
    d = *toy;
    d.delta_e_error = label;
    for (size_t i = 0; i < 3; ++i) {
        label[3] = bad_errors[i];
        refuse(&d, "delta_e_error of pair 3");
    }
    uint8_t split[4] = {0, 1, 3, 0};
    d = *toy;
    d.group_split = split;
    refuse(&d, "group_split[2]");
    uint8_t none[24 * 16] = {1};
    d = *toy;
    d.test_used = none;
    refuse(&d, "pair 1 has no direction");
    none[5] = 2;
    refuse(&d, "test_used[5]");
    d = *toy;
    d.n_pairs = 0;
    refuse(&d, "no pairs");
}

/* Datasets without a transport matrix are valid; half of it, or impossible values are not. */
TEST(broken_transport) {
    nqm_dataset d = *toy, *loaded;
    d.transport = NULL;
    refuse(&d, "need each other");
    d.transport_points = NULL;
    assert_int_equal(nqm_dataset_write(&d, path, NULL, NULL), NQM_OK);
    assert_int_equal(nqm_dataset_load(path, NULL, NQM_SPLIT_ALL, &loaded, NULL), NQM_OK);
    assert_null(nqm_dataset_transport(loaded).light);
    nqm_dataset_free(loaded);
    d.transport = toy->transport;
    refuse(&d, "need each other");
    const float bad[] = {-INFINITY, INFINITY, NAN};
    float light[16 * 3 * NQM_TRANSPORT_POINTS];
    d = *toy;
    d.transport = light;
    for (size_t i = 0; i < 3; ++i) {
        memcpy(light, toy->transport, sizeof light);
        light[sizeof light / sizeof *light - 1] = bad[i];
        refuse(&d, "finite");
    }
    double points[3 * NQM_TRANSPORT_POINTS];
    memcpy(points, toy->transport_points, sizeof points);
    d = *toy;
    d.transport_points = points;
    points[1] = 1;
    refuse(&d, "number its scenes");
    points[1] = 0;
    points[2] = INFINITY;
    refuse(&d, "peak luminance");
    points[2] = NAN;
    refuse(&d, "peak luminance");
    /* files: a matrix of other directions, points of another shape */
    nqm_tensor tensors[NQM_DATASET_ARRAYS];
    static const char *const keys[] = {"format", "schema", "ref_names", "group_names", "kind_names", "pair_names"};
    nqm_meta meta[6];
    nqm_safetensors *st;
    nqm_map map;
    assert_int_equal(nqm_dataset_write(toy, path, NULL, NULL), NQM_OK);
    assert_int_equal(nqm_map_open(path, &map, NULL), NQM_OK);
    assert_int_equal(nqm_safetensors_parse(map.data, map.n_bytes, path, &st, NULL), NQM_OK);
    for (size_t i = 0; i < 6; ++i)
        meta[i] = (nqm_meta){keys[i], nqm_safetensors_meta(st, keys[i])};
    for (size_t wrong = NQM_DATASET_ARRAYS - 2; wrong < NQM_DATASET_ARRAYS; ++wrong) {
        for (size_t i = 0; i < NQM_DATASET_ARRAYS; ++i)
            tensors[i] = nqm_dataset_array(toy, i);
        tensors[wrong].n_bytes -= tensors[wrong].n_bytes / tensors[wrong].dims[0];
        tensors[wrong].dims[0] -= 1;
        nqm_error err = {0};
        assert_int_equal(nqm_safetensors_write("misshapen.tmp", NQM_DATASET_ARRAYS, tensors, 6, meta, NULL, NULL),
                         NQM_OK);
        assert_int_equal(nqm_dataset_load("misshapen.tmp", NULL, NQM_SPLIT_ALL, &loaded, &err), NQM_ERR_FORMAT);
        assert_non_null(strstr(err.message, tensors[wrong].name));
        assert_non_null(strstr(err.message, "type and shape"));
    }
    unlink("misshapen.tmp");
    nqm_safetensors_free(st);
    nqm_map_close(&map);
}

static nqm_status read_dataset(const nqm_map *map, nqm_error *err) {
    nqm_dataset *d;
    const nqm_status status = nqm_dataset_parse(map->data, map->n_bytes, map->path, true, &d, err);
    assert_true((status == NQM_OK) == (d != NULL));
    nqm_dataset_free(d);
    return status;
}

/* A change of any byte and truncation at any byte must be detected: the checksum covers the whole file. */
TEST(damage_is_noticed) {
    assert_int_equal(nqm_dataset_write(toy, path, NULL, NULL), NQM_OK);
    blob b = blob_load(path);
    const size_t step = b.n_bytes / 300 + 1;
    refuse_cuts("cut", b, step, read_dataset);
    for (size_t at = 0; at < b.n_bytes; at += step) {
        b.data[at] ^= 0x10;
        assert_int_not_equal(read_dataset(&(nqm_map){.data = b.data, .n_bytes = b.n_bytes, .path = "changed"}, NULL),
                             NQM_OK);
        b.data[at] ^= 0x10;
    }
    assert_int_equal(read_dataset(&(nqm_map){.data = b.data, .n_bytes = b.n_bytes, .path = "whole"}, NULL), NQM_OK);
    blob_free(&b);
}

TEST(foreign_files) {
    nqm_dataset *d;
    nqm_error err = {0};
    assert_int_equal(nqm_dataset_load("no such file", NULL, NQM_SPLIT_ALL, &d, &err), NQM_ERR_IO);
    assert_non_null(strstr(err.message, "no such file"));
    assert_int_equal(nqm_dataset_load("/", NULL, NQM_SPLIT_ALL, &d, &err), NQM_ERR_IO);
    assert_int_equal(nqm_dataset_load(test_vector("net.safetensors"), NULL, NQM_SPLIT_ALL, &d, &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, "no nqm dataset"));
    assert_null(d);
}

TEST(memory_runs_out) {
    assert_int_equal(nqm_dataset_write(toy, path, NULL, NULL), NQM_OK);
    nqm_status status = NQM_OK;
    long n = -1;
    EVERY_ALLOCATION(n, status, 0) {
        nqm_dataset *d;
        status = nqm_dataset_load(path, NULL, NQM_SPLIT_ALL, &d, NULL);
        assert_true((status == NQM_OK) == (d != NULL));
        nqm_dataset_free(d);
    }
}

TEST_FILE(make_toy, drop_toy)
