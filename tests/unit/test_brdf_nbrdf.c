/* SPDX-License-Identifier: MIT
 *
 * The two neural formats, NBRDF networks (as files and in zip archives) and neural processes: values against numpy
 * (tests/vectors/brdf.py), and broken files.
 */
#include "brdf/brdf.h"
#include "support/allocations.h"
#include "support/brdf_files.h"
#include "support/check.h"
#include "support/damage.h"
#include "support/vectors.h"

#include <nqm/brdf.h>
#include <sys/stat.h>

enum { N_PAIRS = VECTOR_PAIRS };

/* Compare with the network's output before clamping. Frees the BRDF. */
static void compare(nqm_brdf *brdf, const double (*expected)[3], double tolerance) {
    for (size_t i = 0; i < N_PAIRS; ++i) {
        double rgb[3], exchanged[3], by_angles[3], hd[3];
        uint8_t flag;
        const double *wi = pair_vector[i], *wo = wi + 3, *e = expected[i];
        nqm_brdf_eval(brdf, 1, wi, wo, rgb, &flag);
        nqm_brdf_eval(brdf, 1, wo, wi, exchanged, NULL);
        nqm_directions_to_half_diff(wi, wo, hd);
        nqm_brdf_eval_half_diff(brdf, 1, hd, by_angles, NULL);
        assert_int_equal(flag, e[0] < 0 || e[1] < 0 || e[2] < 0 ? NQM_VALUE_CLAMPED : NQM_VALUE_OK);
        for (size_t c = 0; c < 3; ++c) {
            assert_near(rgb[c], fmax(e[c], 0), tolerance * (1 + fabs(e[c])));
            assert_near(by_angles[c], rgb[c], 1e-12);
            assert_near(exchanged[c], rgb[c], 1e-5); /* equal up to the rounding of float inputs */
        }
    }
    nqm_brdf_free(brdf);
}

TEST(network_agrees_with_numpy) {
    const char *path = scratch_path("network.h5");
    blob_put(make_nbrdf(NBRDF_VALID), path);
    nqm_brdf *brdf = must_open(path);
    nqm_brdf_info info = nqm_brdf_get_info(brdf);
    assert_string_equal(info.format, "nbrdf");
    assert_string_equal(info.source_doi, "10.1111/cgf.14335");
    assert_int_equal(info.n_values, 675);
    assert_int_equal(info.reciprocal, 1);
    compare(brdf, rgb_vector("nbrdf"), 1e-12);
}

TEST(network_comes_out_of_a_zip) {
    const char *path = scratch_path("archive.zip");
    char argument[400];
    blob network = make_nbrdf(NBRDF_VALID);
    blob_put(make_zip("folder/gold-paint.h5", &network), path);
    blob_free(&network);
    snprintf(argument, sizeof argument, "%s:gold-paint", path);
    compare(must_open(argument), rgb_vector("nbrdf"), 1e-12);
    snprintf(argument, sizeof argument, "%s:gold-paint.h5", path);
    compare(must_open(argument), rgb_vector("nbrdf"), 1e-12);
}

/* Write the weights of the network as the six arrays of the authors' programs, "PREFIXfc1.npy" to "PREFIXb3.npy". */
static void save_parts(const char *folder, const char *prefix, bool in_columns) {
    static const struct {
        const char *name;
        size_t n_in, n_out;
    } parts[] = {{"fc1", 6, 21}, {"b1", 0, 21}, {"fc2", 21, 21}, {"b2", 0, 21}, {"fc3", 21, 3}, {"b3", 0, 3}};
    const char *path = scratch_path("network.h5");
    blob_put(make_nbrdf(NBRDF_VALID), path);
    nqm_brdf *network = must_open(path);
    const float *weights = nqm_nbrdf_weights(network);
    for (size_t k = 0; k < sizeof parts / sizeof *parts; ++k) {
        const size_t n_in = parts[k].n_in ? parts[k].n_in : 1, n_out = parts[k].n_out;
        char text[119], shape[40];
        float values[441];
        snprintf(shape, sizeof shape, parts[k].n_in ? "%zu, %zu" : "%.0zu%zu,", parts[k].n_in, n_out);
        snprintf(text, sizeof text, "{'descr': '<f4', 'fortran_order': %s, 'shape': (%s), }",
                 in_columns && parts[k].n_in ? "True" : "False", shape);
        for (size_t i = 0; i < n_in * n_out; ++i)
            values[in_columns ? i % n_out * n_in + i / n_out : i] = weights[i];
        weights += n_in * n_out;
        char file[400];
        snprintf(file, sizeof file, "%s/%s%s.npy", folder, prefix, parts[k].name);
        FILE *out = fopen(file, "wb");
        assert_non_null(out);
        fprintf(out, "\x93NUMPY%c%c%c%c%-117s\n", 1, 0, 118, 0, text);
        nqm_write_values(out, n_in * n_out, sizeof *values, values);
        assert_int_equal(fclose(out), 0);
    }
    nqm_brdf_free(network);
}

/* A network as six arrays: by its folder or by one of the files, in rows or in columns. */
TEST(network_is_read_from_arrays) {
    char folder[300], file[400];
    snprintf(folder, sizeof folder, "%s", scratch_path("arrays"));
    assert_int_equal(mkdir(folder, 0777), 0);
    for (int in_columns = 0; in_columns < 2; ++in_columns) {
        save_parts(folder, "_", in_columns);
        compare(must_open(folder), rgb_vector("nbrdf"), 1e-12);
        snprintf(file, sizeof file, "%s/_b2.npy", folder);
        compare(must_open(file), rgb_vector("nbrdf"), 1e-12);
    }
    assert_true(check_brdf_allocations(folder) >= 4);
    snprintf(file, sizeof file, "%s/_b2.npy", folder);
    blob part = blob_load(file);
    refuse_cuts(file, part, 13, read_brdf);
    blob_put(part, file);
    save_parts(folder, "gold_", false);
    must_refuse(folder, NQM_ERR_ARG, "a folder of 2 networks; give one of their files, ");
    snprintf(file, sizeof file, "%s/gold_fc2.npy", folder);
    compare(must_open(file), rgb_vector("nbrdf"), 1e-12);
    char copy[400];
    snprintf(copy, sizeof copy, "%s/gold_fc3.npy", folder);
    blob_put(blob_load(file), copy);
    must_refuse(copy, NQM_ERR_FORMAT, "weights of an NBRDF (header at byte 10) of another shape than 21 x 3");
    remove(copy);
    nqm_brdf *brdf;
    nqm_error err = {0};
    assert_int_equal(nqm_brdf_open(file, &brdf, &err), NQM_ERR_IO);
    assert_non_null(strstr(err.message, copy));
}

TEST(zip_faults_are_told) {
    const char *path = scratch_path("archive.zip");
    char argument[400];
    blob network = make_nbrdf(NBRDF_VALID), zip = make_zip("steel.h5", &network);
    blob_save(&zip, path);
    must_refuse(path, NQM_ERR_ARG, "steel");
    snprintf(argument, sizeof argument, "%s:", path);
    must_refuse(argument, NQM_ERR_IO, "no member");
    snprintf(argument, sizeof argument, "%s:gold", path);
    must_refuse(argument, NQM_ERR_IO, "no member 'gold.h5'");
    snprintf(argument, sizeof argument, "%s:stele", path);
    must_refuse(argument, NQM_ERR_IO, "no member 'stele.h5' (did you mean 'steel.h5'?)");
    snprintf(argument, sizeof argument, "%s:steel", path);
    refuse_cuts(argument, zip, 13, read_brdf);    /* the central directory of a zip file is at its end */
    zip.data[30 + strlen("steel.h5") + 300] ^= 1; /* inside the compressed data */
    blob_save(&zip, path);
    must_refuse(argument, NQM_ERR_FORMAT, "steel.h5");
    blob_free(&zip);
    blob text = {network.data, 100};
    blob_put(make_zip("readme.txt", &text), path);
    must_refuse(path, NQM_ERR_FORMAT, "no NBRDF");
    blob_put(make_zip("net/data.pkl", &text), path);
    must_refuse(path, NQM_ERR_FORMAT, "a PyTorch file; save the weights");
    blob_put(make_zip("rgb.npy", &text), path);
    must_refuse(path, NQM_ERR_FORMAT, "an .npz archive of NumPy; save one table");
    blob_put(make_zip("steel.h5", &text), path);
    must_refuse(argument, NQM_ERR_FORMAT, argument);
    blob_free(&network);
}

TEST(refuses_a_member_that_is_too_large) {
    const char *path = scratch_path("archive.zip");
    char argument[400];
    const char *large_path = scratch_path("large.h5");
    blob network = make_nbrdf(NBRDF_VALID);
    blob_save_sparse(&network, 5 << 20, large_path);
    blob_free(&network);
    must_refuse(large_path, NQM_ERR_LIMIT, large_path);
    blob large = blob_load(large_path);
    blob_put(make_zip("large.h5", &large), path); /* compresses to a few kilobytes */
    blob_free(&large);
    snprintf(argument, sizeof argument, "%s:large", path);
    must_refuse(argument, NQM_ERR_LIMIT, "large.h5");
    unsigned char *data;
    size_t n_bytes;
    nqm_map map;
    assert_int_equal(nqm_map_open(path, &map, NULL), NQM_OK);
    assert_int_equal(nqm_zip_read(&map, "large.h5", (5 << 20) - 1, &data, &n_bytes, NULL), NQM_ERR_LIMIT);
    assert_int_equal(nqm_zip_read(&map, "large.h5", 5 << 20, &data, &n_bytes, NULL), NQM_OK);
    nqm_map_close(&map);
    assert_int_equal(n_bytes, 5 << 20);
    nqm_free(data);
}

TEST(refuses_broken_networks) {
    static const char *const words[NBRDF_KINDS] = {[NBRDF_MISSING] = "missing",
                                                   [NBRDF_SHAPE] = "shape",
                                                   [NBRDF_DOUBLE] = "float32",
                                                   [NBRDF_NAN] = "not finite",
                                                   [NBRDF_CHUNKED] = "compressed, chunked",
                                                   [NBRDF_EXTERNAL_LINK] = "missing",
                                                   [NBRDF_EXTERNAL_STORAGE] = "compressed, chunked"};
    const char *path = scratch_path("broken.h5");
    for (int kind = NBRDF_MISSING; kind < NBRDF_KINDS; ++kind) {
        blob_put(make_nbrdf((nbrdf_kind)kind), path);
        nqm_error err = must_refuse(path, NQM_ERR_FORMAT, words[kind]);
        assert_non_null(strstr(err.message, path));
        assert_non_null(strstr(err.message, "dense_3/dense_3/kernel:0"));
        if (kind == NBRDF_NAN) {
            blob b = blob_load(path);
            assert_true(isnan(nqm_load_f32(b.data + err.byte_offset)));
            blob_free(&b);
        }
    }
}

TEST(refuses_truncated_files) {
    blob b = make_nbrdf(NBRDF_VALID);
    refuse_cuts(scratch_path("short.h5"), b, 29, read_brdf_ends);
    blob_free(&b);
}

TEST(refuses_odd_superblocks) {
    static const struct {
        size_t at;
        unsigned char value;
    } changes[] = {{8, 4}, {13, 4}, {14, 2}, {24, 1}, {46, 1}};
    const char *path = scratch_path("broken.h5");
    for (size_t i = 0; i < sizeof changes / sizeof *changes; ++i) {
        blob b = make_nbrdf(NBRDF_VALID);
        b.data[changes[i].at] = changes[i].value;
        blob_put(b, path);
        must_refuse(path, NQM_ERR_FORMAT, path);
    }
}

TEST(processes_agree_with_numpy) {
    const char *path = scratch_path("decoder.bin");
    char argument[400];
    blob_put(make_nps_decoder(), path);
    blob_put(make_nps_latents(), scratch_path("nps_latents.csv"));
    snprintf(argument, sizeof argument, "%s:second", path);
    nqm_brdf *brdf = must_open(argument);
    nqm_brdf_info info = nqm_brdf_get_info(brdf);
    assert_string_equal(info.format, "nps");
    assert_string_equal(info.source_doi, "10.1145/3490385");
    assert_int_equal(info.n_values, 808010);
    compare(brdf, rgb_vector("nps"), 1e-4); /* seven layers in float32 */
}

TEST(process_faults_are_told) {
    const char *path = scratch_path("decoder.bin"), *latents = scratch_path("nps_latents.csv");
    char argument[400];
    blob decoder = make_nps_decoder();
    blob_save(&decoder, path);
    blob_put(make_nps_latents(), latents);
    must_refuse(path, NQM_ERR_ARG, "name one material");
    snprintf(argument, sizeof argument, "%s:third", path);
    must_refuse(argument, NQM_ERR_IO, "no material 'third'");
    snprintf(argument, sizeof argument, "%s:frist", path);
    must_refuse(argument, NQM_ERR_IO, "no material 'frist' (did you mean 'first'?)");
    memset(decoder.data + 4000, 0xff, 4);
    blob_save(&decoder, path);
    snprintf(argument, sizeof argument, "%s:first", path);
    assert_int_equal(must_refuse(argument, NQM_ERR_FORMAT, "byte 4000").byte_offset, 4000);
    remove(latents);
    must_refuse(argument, NQM_ERR_IO, latents);
    decoder.n_bytes -= 4;
    blob_put(decoder, path);
    must_refuse(argument, NQM_ERR_FORMAT, "neither a zip nor a decoder");
}

TEST(survives_failing_allocations) {
    char arguments[2][400];
    blob network = make_nbrdf(NBRDF_VALID);
    blob_put(make_zip("steel.h5", &network), scratch_path("archive.zip"));
    blob_free(&network);
    blob_put(make_nps_decoder(), scratch_path("decoder.bin"));
    blob_put(make_nps_latents(), scratch_path("nps_latents.csv"));
    snprintf(arguments[0], sizeof arguments[0], "%s:steel", scratch_path("archive.zip"));
    snprintf(arguments[1], sizeof arguments[1], "%s:first", scratch_path("decoder.bin"));
    for (size_t k = 0; k < 2; ++k)
        assert_true(check_brdf_allocations(arguments[k]) >= 4);
}

TEST_FILE(read_pair_vector, NULL)
