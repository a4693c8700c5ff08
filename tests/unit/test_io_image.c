/* SPDX-License-Identifier: MIT
 *
 * Light maps: the pixels of small pictures written byte by byte (vectors/images.py) are read correctly; truncated,
 * damaged and inconsistent files are refused with a message and without a large allocation.
 */
#include "io/io.h"
#include "support/allocations.h"
#include "support/check.h"
#include "support/vectors.h"

enum { WIDTH = 11, HEIGHT = 6, N_VALUES = 3 * WIDTH * HEIGHT };

typedef struct sample {
    const char *name, *pixels; /* file and array of images.py */
    unsigned char *data;
    size_t n_bytes;
} sample;

static sample samples[] = {
    {"rgbe.png", "png", NULL, 0},  {"flat.hdr", "hdr", NULL, 0},      {"newer.hdr", "hdr", NULL, 0},
    {"older.hdr", "hdr", NULL, 0}, {"float.exr", "exr", NULL, 0},     {"half.exr", "exr", NULL, 0},
    {"tiled.exr", "exr", NULL, 0}, {"grey.exr", "exr_grey", NULL, 0},
};
enum { N_SAMPLES = sizeof samples / sizeof *samples };

static int read_samples(void **state) {
    (void)state;
    for (size_t i = 0; i < N_SAMPLES; ++i) {
        const blob file = vector_picture(samples[i].name);
        samples[i].data = file.data;
        samples[i].n_bytes = file.n_bytes;
    }
    return 0;
}

static int free_samples(void **state) {
    (void)state;
    for (size_t i = 0; i < N_SAMPLES; ++i)
        free(samples[i].data);
    return 0;
}

static nqm_status decode(const sample *s, const unsigned char *data, size_t n_bytes, nqm_error *err) {
    const nqm_map map = {.data = data, .n_bytes = n_bytes, .path = s->name};
    nqm_image image;
    *err = (nqm_error){0};
    nqm_status status = nqm_image_parse(&map, &image, err);
    if (status != NQM_OK) {
        assert_null(image.rgb);
        assert_int_equal(err->status, status);
        assert_non_null(strstr(err->message, status == NQM_ERR_NOMEM ? "memory" : s->name));
    }
    nqm_free(image.rgb);
    return status;
}

TEST(pixels) {
    for (size_t i = 0; i < N_SAMPLES; ++i) {
        const sample *s = &samples[i];
        const nqm_map map = {.data = s->data, .n_bytes = s->n_bytes, .path = s->name};
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

/* A file truncated at any byte is malformed; the copy has the exact size, so that ASan detects a read past the end. */
TEST(cut_anywhere) {
    for (size_t i = 0; i < N_SAMPLES; ++i)
        for (size_t n = 0; n < samples[i].n_bytes; ++n) {
            unsigned char *copy = malloc(n ? n : 1);
            assert_non_null(copy);
            memcpy(copy, samples[i].data, n);
            nqm_error err;
            assert_int_equal(decode(&samples[i], copy, n, &err), NQM_ERR_FORMAT);
            free(copy);
        }
}

TEST(spoilt_anywhere) {
    static const unsigned char spoil[] = {0xff, 0x80, 0x01};
    for (size_t i = 0; i < N_SAMPLES; ++i)
        for (size_t n = 0; n < samples[i].n_bytes; ++n)
            for (size_t k = 0; k < sizeof spoil; ++k) {
                unsigned char *copy = malloc(samples[i].n_bytes);
                assert_non_null(copy);
                memcpy(copy, samples[i].data, samples[i].n_bytes);
                copy[n] ^= spoil[k];
                nqm_error err;
                nqm_status status = decode(&samples[i], copy, samples[i].n_bytes, &err);
                assert_true(status == NQM_OK || status == NQM_ERR_FORMAT || status == NQM_ERR_LIMIT);
                free(copy);
            }
}

/* Decode a copy of the sample in which `with` replaces `what`; the decoder must return `expected`. */
static void decode_patched(const sample *s, const void *what, size_t n_what, const void *with, nqm_status expected) {
    unsigned char *copy = malloc(s->n_bytes);
    assert_non_null(copy);
    memcpy(copy, s->data, s->n_bytes);
    size_t at = 0;
    while (at + n_what <= s->n_bytes && memcmp(copy + at, what, n_what) != 0)
        ++at;
    assert_true(at + n_what <= s->n_bytes);
    memcpy(copy + at, with, n_what);
    nqm_error err;
    assert_int_equal(decode(s, copy, s->n_bytes, &err), expected);
    free(copy);
}

TEST(lying_sizes) {
    decode_patched(&samples[0], "IHDR\0\0\0\x0b\0\0\0\x06", 12, "IHDR\x7f\xff\xff\xff\x7f\xff\xff\xff", NQM_ERR_FORMAT);
    decode_patched(&samples[1], "-Y 6 +X 11\n", 11, "-Y 9 +X999\n", NQM_ERR_FORMAT);
    static const char huge[] = "#?RGBE\n\n-Y 2147483648 +X 2147483648\nxxxx";
    const sample lie = {.name = "huge.hdr"};
    nqm_error err;
    assert_int_equal(decode(&lie, (const unsigned char *)huge, sizeof huge - 1, &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, "2147483648 x 2147483648"));
    /* The EXR's data window: from (-3, 7) to (7, 12). */
    static const unsigned char window[16] = {253, 255, 255, 255, 7, 0, 0, 0, 7, 0, 0, 0, 12, 0, 0, 0};
    static const unsigned char wide[16] = {0, 0, 0, 128, 0, 0, 0, 128, 255, 255, 255, 127, 255, 255, 255, 127};
    static const unsigned char upside_down[16] = {253, 255, 255, 255, 12, 0, 0, 0, 7, 0, 0, 0, 7, 0, 0, 0};
    decode_patched(&samples[4], window, 16, wide, NQM_ERR_FORMAT);
    decode_patched(&samples[4], window, 16, upside_down, NQM_ERR_FORMAT);
}

TEST(over_the_limit) {
    nqm_error err = {0};
    nqm_image image;
    const nqm_map map = {.data = samples[0].data, .n_bytes = (size_t)1 << 30, .path = "large.exr"};
    assert_int_equal(nqm_image_alloc(&map, NQM_IMAGE_MAX_WIDTH + 1, 4, 1, &image, &err), NQM_ERR_LIMIT);
    assert_int_equal(nqm_image_alloc(&map, 4, NQM_IMAGE_MAX_HEIGHT + 1, 1, &image, &err), NQM_ERR_LIMIT);
    assert_int_equal(nqm_image_alloc(&map, 0, 4, 1, &image, &err), NQM_ERR_FORMAT);
}

static void write_file(const char *path, const void *data, size_t n_bytes) {
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(data, 1, n_bytes, f), n_bytes);
    assert_int_equal(fclose(f), 0);
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
    char dir[] = "/tmp/nqm-image-XXXXXX", path[64];
    assert_non_null(mkdtemp(dir));
    snprintf(path, sizeof path, "%s/picture", dir);
    nqm_image image;
    nqm_error err;
    for (size_t i = 0; i < N_SAMPLES; ++i) { /* the format is detected from the content, not from the name */
        write_file(path, samples[i].data, samples[i].n_bytes);
        assert_int_equal(load(path, &image, &err), NQM_OK);
        nqm_free(image.rgb);
    }
    /* 0.25 becomes NaN, infinity, -1 in turn. */
    static const unsigned char quarter[4] = {0, 0, 0x80, 0x3e};
    static const unsigned char bad[3][4] = {{0, 0, 0xc0, 0x7f}, {0, 0, 0x80, 0x7f}, {0, 0, 0x80, 0xbf}};
    const sample *s = &samples[4];
    unsigned char copy[2000];
    for (int i = 0; i < 3; ++i) {
        memcpy(copy, s->data, s->n_bytes);
        size_t at = s->n_bytes - 4;
        while (memcmp(copy + at, quarter, 4) != 0)
            --at;
        memcpy(copy + at, bad[i], 4);
        write_file(path, copy, s->n_bytes);
        assert_int_equal(load(path, &image, &err), i < 2 ? NQM_ERR_FORMAT : NQM_OK);
        for (size_t k = 0; i == 2 && k < N_VALUES; ++k)
            assert_true(image.rgb[k] >= 0);
        nqm_free(image.rgb);
    }
    write_file(path, "", 0);
    assert_int_equal(load(path, &image, &err), NQM_ERR_FORMAT);
    write_file(path, "no picture", 10);
    assert_int_equal(load(path, &image, &err), NQM_ERR_FORMAT);
    unlink(path);
    assert_int_equal(load(path, &image, &err), NQM_ERR_IO);
    assert_int_equal(load(dir, &image, &err), NQM_ERR_IO);
    rmdir(dir);
}

TEST(out_of_memory) {
    for (size_t i = 0; i < N_SAMPLES; ++i) {
        nqm_status status = NQM_OK;
        nqm_error err;
        long n = -1;
        EVERY_ALLOCATION(n, status, 0)
        status = decode(&samples[i], samples[i].data, samples[i].n_bytes, &err);
        assert_true(n < 10);
    }
}

TEST_FILE(read_samples, free_samples)
