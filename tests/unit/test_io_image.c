/* SPDX-License-Identifier: MIT
 *
 * Light maps: the pixels of small pictures written byte by byte (vectors/images.py) are read correctly; truncated,
 * damaged and inconsistent files are refused with a message and without a large allocation.
 */
#include "io/io.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/damage.h"
#include "support/vectors.h"

enum { WIDTH = 11, HEIGHT = 6, N_VALUES = 3 * WIDTH * HEIGHT };

typedef struct sample {
    const char *name, *pixels; /* file and array of images.py */
    blob file;
} sample;

static sample samples[] = {
    {"rgbe.png", "png", {0}},  {"flat.hdr", "hdr", {0}}, {"newer.hdr", "hdr", {0}}, {"older.hdr", "hdr", {0}},
    {"float.exr", "exr", {0}}, {"half.exr", "exr", {0}}, {"tiled.exr", "exr", {0}}, {"grey.exr", "exr_grey", {0}},
};
enum { N_SAMPLES = sizeof samples / sizeof *samples };

static int read_samples(void **state) {
    (void)state;
    for (size_t i = 0; i < N_SAMPLES; ++i)
        samples[i].file = vector_picture(samples[i].name);
    return 0;
}

static int free_samples(void **state) {
    (void)state;
    for (size_t i = 0; i < N_SAMPLES; ++i)
        blob_free(&samples[i].file);
    return 0;
}

static nqm_map map_of(const char *name, blob b) {
    return (nqm_map){.data = b.data, .n_bytes = b.n_bytes, .path = name};
}

static nqm_status decode(const nqm_map *map, nqm_error *err) {
    nqm_image image;
    const nqm_status status = nqm_image_parse(map, &image, err);
    assert_true((status == NQM_OK) == (image.rgb != NULL));
    nqm_free(image.rgb);
    return status;
}

TEST(pixels) {
    for (size_t i = 0; i < N_SAMPLES; ++i) {
        const sample *s = &samples[i];
        const nqm_map map = map_of(s->name, s->file);
        nqm_image image;
        nqm_error err = {0};
        if (nqm_image_parse(&map, &image, &err) != NQM_OK)
            fail_msg("%s", err.message);
        assert_int_equal(image.width, WIDTH);
        assert_int_equal(image.height, HEIGHT);
        double expected[N_VALUES];
        get_vector("images.safetensors", s->pixels, sizeof expected, expected);
        for (size_t k = 0; k < N_VALUES; ++k)
            assert_relative((double)image.rgb[k], expected[k], 1e-7);
        nqm_free(image.rgb);
    }
}

TEST(damaged_anywhere) {
    for (size_t i = 0; i < N_SAMPLES; ++i) {
        refuse_cuts(samples[i].name, samples[i].file, 1, decode);
        survive_changes(samples[i].name, samples[i].file, 1, decode);
    }
}

/* The sample with `with` in place of `what` is refused. */
static void refuse_patched(const sample *s, const void *what, size_t n_what, const void *with) {
    blob b = vector_picture(s->name);
    size_t at = 0;
    while (at + n_what <= b.n_bytes && memcmp(b.data + at, what, n_what) != 0)
        ++at;
    assert_true(at + n_what <= b.n_bytes);
    memcpy(b.data + at, with, n_what);
    const nqm_map map = map_of(s->name, b);
    nqm_error err = {0};
    assert_int_equal(decode(&map, &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, s->name));
    blob_free(&b);
}

TEST(lying_sizes) {
    refuse_patched(&samples[0], "IHDR\0\0\0\x0b\0\0\0\x06", 12, "IHDR\x7f\xff\xff\xff\x7f\xff\xff\xff");
    refuse_patched(&samples[1], "-Y 6 +X 11\n", 11, "-Y 9 +X999\n");
    unsigned char huge[] = "#?RGBE\n\n-Y 2147483648 +X 2147483648\nxxxx";
    const nqm_map lie = map_of("huge.hdr", (blob){huge, sizeof huge - 1});
    nqm_error err = {0};
    assert_int_equal(decode(&lie, &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, "2147483648 x 2147483648"));
    /* The EXR's data window: from (-3, 7) to (7, 12). */
    static const unsigned char window[16] = {253, 255, 255, 255, 7, 0, 0, 0, 7, 0, 0, 0, 12, 0, 0, 0};
    static const unsigned char wide[16] = {0, 0, 0, 128, 0, 0, 0, 128, 255, 255, 255, 127, 255, 255, 255, 127};
    static const unsigned char upside_down[16] = {253, 255, 255, 255, 12, 0, 0, 0, 7, 0, 0, 0, 7, 0, 0, 0};
    refuse_patched(&samples[4], window, 16, wide);
    refuse_patched(&samples[4], window, 16, upside_down);
}

TEST(over_the_limit) {
    nqm_error err = {0};
    nqm_image image;
    const nqm_map map = {.data = samples[0].file.data, .n_bytes = (size_t)1 << 30, .path = "large.exr"};
    assert_int_equal(nqm_image_alloc(&map, NQM_IMAGE_MAX_WIDTH + 1, 4, 1, &image, &err), NQM_ERR_LIMIT);
    assert_int_equal(nqm_image_alloc(&map, 4, NQM_IMAGE_MAX_HEIGHT + 1, 1, &image, &err), NQM_ERR_LIMIT);
    assert_int_equal(nqm_image_alloc(&map, 0, 4, 1, &image, &err), NQM_ERR_FORMAT);
}

static nqm_status load(const char *path, nqm_image *image, nqm_error *err) {
    *err = (nqm_error){0};
    nqm_status status = nqm_image_load(path, image, err);
    if (status != NQM_OK) {
        assert_null(image->rgb);
        assert_non_null(strstr(err->message, path));
    }
    return status;
}

TEST(loading) {
    const char *path = scratch_path("picture");
    nqm_image image;
    nqm_error err;
    for (size_t i = 0; i < N_SAMPLES; ++i) { /* the format is detected from the content, not from the name */
        blob_save(&samples[i].file, path);
        assert_int_equal(load(path, &image, &err), NQM_OK);
        nqm_free(image.rgb);
    }
    /* 0.25 becomes NaN, infinity, -1 in turn. */
    static const unsigned char quarter[4] = {0, 0, 0x80, 0x3e};
    static const unsigned char bad[3][4] = {{0, 0, 0xc0, 0x7f}, {0, 0, 0x80, 0x7f}, {0, 0, 0x80, 0xbf}};
    for (int i = 0; i < 3; ++i) {
        blob b = vector_picture(samples[4].name);
        size_t at = b.n_bytes - 4;
        while (memcmp(b.data + at, quarter, 4) != 0)
            --at;
        memcpy(b.data + at, bad[i], 4);
        blob_put(b, path);
        assert_int_equal(load(path, &image, &err), i < 2 ? NQM_ERR_FORMAT : NQM_OK);
        for (size_t k = 0; i == 2 && k < N_VALUES; ++k)
            assert_true(image.rgb[k] >= 0);
        nqm_free(image.rgb);
    }
    unsigned char text[] = "no picture";
    blob_save(&(blob){text, 0}, path);
    assert_int_equal(load(path, &image, &err), NQM_ERR_FORMAT);
    blob_save(&(blob){text, sizeof text - 1}, path);
    assert_int_equal(load(path, &image, &err), NQM_ERR_FORMAT);
    unlink(path);
    assert_int_equal(load(path, &image, &err), NQM_ERR_IO);
    assert_int_equal(load("/", &image, &err), NQM_ERR_IO);
}

TEST(out_of_memory) {
    for (size_t i = 0; i < N_SAMPLES; ++i) {
        const nqm_map map = map_of(samples[i].name, samples[i].file);
        nqm_status status = NQM_OK;
        long n = -1;
        EVERY_ALLOCATION(n, status, 0)
        status = decode(&map, &(nqm_error){0});
        assert_true(n < 10);
    }
}

TEST_FILE(read_samples, free_samples)
