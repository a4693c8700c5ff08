/* SPDX-License-Identifier: MIT
 *
 * Pictures of maps: every kind of PNG, JPEG, WebP and OpenEXR that is read has the values that were written; truncated, damaged and
 * inconsistent files, and other formats, are refused with a message that says what to do.
 */
#include "base/memory_test.h"
#include "io/raster.h"
#include "support/check.h"
#include "support/damage.h"
#include "support/pictures.h"
#include "support/vectors.h"

#include <zlib.h>

enum { WIDTH = 19, HEIGHT = 13, MAX_PIXEL = 8 };
static unsigned char random_bytes[WIDTH * HEIGHT * MAX_PIXEL];

static int make_noise(void **state) {
    (void)state;
    nqm_rng rng = nqm_rng_make(5, 0);
    for (size_t i = 0; i < sizeof random_bytes; ++i)
        random_bytes[i] = (unsigned char)nqm_rng_below(&rng, 256);
    return 0;
}

static nqm_raster decode(blob b) {
    nqm_raster raster;
    size_t width = 0, height = 0;
    nqm_error err = {0};
    if (nqm_raster_decode(b.data, b.n_bytes, "map", &raster, &err) != NQM_OK ||
        nqm_raster_size(b.data, b.n_bytes, "map", &width, &height, &err) != NQM_OK)
        fail_msg("%s", err.message);
    assert_int_equal(width, raster.width);
    assert_int_equal(height, raster.height);
    return raster;
}

/* Both functions return `expected`, and a message with the name and `words`. Frees the blob. */
static void refused(blob b, nqm_status expected, const char *words) {
    nqm_raster raster = {.width = 1};
    size_t width = 1, height = 1;
    for (int size_only = 0; size_only < 2; ++size_only) {
        nqm_error err = {0};
        assert_int_equal(size_only ? nqm_raster_size(b.data, b.n_bytes, "wood map", &width, &height, &err)
                                   : nqm_raster_decode(b.data, b.n_bytes, "wood map", &raster, &err),
                         expected);
        if (strncmp(err.message, "wood map: ", 10) != 0 || !strstr(err.message, words))
            fail_msg("'%s' without '%s'", err.message, words);
    }
    assert_true(!raster.data && !raster.width && !width && !height);
    blob_free(&b);
}

/* ---- PNG --------------------------------------------------------------------------------------------------------- */

/* Value i of a row of values with 1 to 16 bits, as PNG stores them. */
static unsigned packed(const unsigned char *row, size_t i, unsigned bits) {
    if (bits == 16)
        return (unsigned)row[2 * i] << 8 | row[2 * i + 1];
    return (unsigned)(row[i * bits / 8] >> (8 - bits - i * bits % 8)) & ((1u << bits) - 1);
}

/* The value of channel k of a pixel that nqm_raster_decode() must return. */
static unsigned expected_value(const unsigned char *row, size_t x, size_t k, int colour, unsigned bits,
                               size_t channels) {
    unsigned char rgb[3];
    if (colour != 3)
        return packed(row, channels * x + k, bits) * (bits < 8 ? 255 / ((1u << bits) - 1) : 1);
    palette_entry(packed(row, x, bits), rgb);
    return rgb[k];
}

static void check_png(int colour, unsigned bits, bool is_interlaced) {
    static const size_t channels_of[] = {1, 0, 3, 3, 2, 0, 4};
    const size_t channels = channels_of[colour];
    const size_t row_size = (WIDTH * (colour == 3 ? 1 : channels) * bits + 7) / 8;
    blob b = make_png(WIDTH, HEIGHT, colour, (int)bits, is_interlaced, random_bytes);
    nqm_raster raster = decode(b);
    assert_int_equal(raster.width, WIDTH);
    assert_int_equal(raster.height, HEIGHT);
    assert_int_equal(raster.channels, channels);
    assert_int_equal(raster.type, bits == 16 ? NQM_RASTER_U16 : NQM_RASTER_U8);
    for (size_t i = 0; i < WIDTH * HEIGHT * channels; ++i) {
        const unsigned value = bits == 16 ? ((uint16_t *)raster.data)[i] : ((unsigned char *)raster.data)[i];
        const size_t y = i / channels / WIDTH, x = i / channels % WIDTH;
        assert_int_equal(value, expected_value(random_bytes + row_size * y, x, i % channels, colour, bits, channels));
    }
    nqm_raster_clear(&raster);
    nqm_raster_clear(&raster);
    blob_free(&b);
}

TEST(png_kinds) {
    static const struct {
        int colour;
        unsigned bits;
    } kinds[] = {{0, 1}, {0, 2}, {0, 4}, {0, 8}, {0, 16}, {2, 8}, {2, 16}, {3, 1},
                 {3, 2}, {3, 4}, {3, 8}, {4, 8}, {4, 16}, {6, 8}, {6, 16}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
        check_png(kinds[i].colour, kinds[i].bits, false);
        check_png(kinds[i].colour, kinds[i].bits, true);
    }
}

/* ---- JPEG -------------------------------------------------------------------------------------------------------- */

static unsigned char smooth[WIDTH * HEIGHT * 4];

static void make_smooth(void) {
    for (size_t i = 0; i < sizeof smooth; ++i) /* slow in space: half of the chroma samples are dropped */
        smooth[i] = (unsigned char)(40 + 3 * (i / 4 % WIDTH) + 5 * (i / 4 / WIDTH) + 20 * (i % 4));
}

TEST(jpeg_kinds) {
    make_smooth();
    for (size_t channels = 1; channels <= 3; channels += 2) {
        unsigned char pixels[WIDTH * HEIGHT * 3];
        for (size_t i = 0; i < WIDTH * HEIGHT * channels; ++i)
            pixels[i] = smooth[i / channels * 4 + i % channels];
        blob plain = make_jpeg(WIDTH, HEIGHT, (int)channels, JPEG_PLAIN, pixels);
        blob progressive = make_jpeg(WIDTH, HEIGHT, (int)channels, JPEG_PROGRESSIVE, pixels);
        nqm_raster a = decode(plain), b = decode(progressive);
        assert_true(a.width == WIDTH && a.height == HEIGHT && a.channels == channels && a.type == NQM_RASTER_U8);
        for (size_t i = 0; i < WIDTH * HEIGHT * channels; ++i)
            assert_true(abs(((unsigned char *)a.data)[i] - pixels[i]) <= 3);
        assert_true(a.channels == b.channels && plain.n_bytes != progressive.n_bytes);
        assert_memory_equal(a.data, b.data, WIDTH * HEIGHT * channels);
        nqm_raster_clear(&a);
        nqm_raster_clear(&b);
        blob_free(&plain);
        blob_free(&progressive);
    }
}

static size_t find(blob b, const char *bytes, size_t n) {
    size_t at = 0;
    while (at + n <= b.n_bytes && memcmp(b.data + at, bytes, n) != 0)
        ++at;
    assert_true(at + n <= b.n_bytes);
    return at;
}

/* A JPEG file whose first scan is there n times. */
static blob repeat_scan(size_t n) {
    blob b = make_jpeg(WIDTH, HEIGHT, 1, JPEG_PROGRESSIVE, random_bytes), out = {0};
    const size_t begin = find(b, "\xff\xda", 2);
    const size_t n_scan = find((blob){b.data + begin + 2, b.n_bytes - begin - 2}, "\xff\xc4", 2) + 2;
    out.n_bytes = b.n_bytes + (n - 1) * n_scan;
    out.data = malloc(out.n_bytes);
    assert_non_null(out.data);
    memcpy(out.data, b.data, begin);
    for (size_t i = 0; i < n; ++i)
        memcpy(out.data + begin + i * n_scan, b.data + begin, n_scan);
    memcpy(out.data + begin + n * n_scan, b.data + begin + n_scan, b.n_bytes - begin - n_scan);
    blob_free(&b);
    return out;
}

static nqm_status decode_map(const nqm_map *map, nqm_error *err) {
    nqm_raster raster;
    const nqm_status status = nqm_raster_decode(map->data, map->n_bytes, map->path, &raster, err);
    nqm_raster_clear(&raster);
    return status;
}

static nqm_status decode_only(blob b, nqm_error *err) {
    return decode_map(&(nqm_map){.data = b.data, .n_bytes = b.n_bytes, .path = "map"}, err);
}

TEST(jpeg_refusals) {
    refused(make_jpeg(WIDTH, HEIGHT, 4, JPEG_PLAIN, random_bytes), NQM_ERR_FORMAT,
            "CMYK colours are not read: convert it to RGB");
    refused(make_jpeg(WIDTH, HEIGHT, 3, JPEG_ARITHMETIC, random_bytes), NQM_ERR_FORMAT,
            "arithmetic coding is not read");
    nqm_error err = {0};
    blob few = repeat_scan(20), many = repeat_scan(200);
    assert_int_equal(decode_only(few, &err), NQM_OK);
    assert_int_equal(decode_only(many, &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, "more than 100 scans"));
    blob_free(&few);
    blob_free(&many);
}

/* ---- WebP -------------------------------------------------------------------------------------------------------- */

/* Lossless: the values that were written, which a PNG has, too. */
TEST(webp_kinds) {
    make_smooth();
    for (size_t channels = 3; channels <= 4; ++channels) {
        const size_t n = WIDTH * HEIGHT * channels;
        unsigned char noise[sizeof random_bytes], pixels[sizeof smooth];
        for (size_t i = 0; i < n; ++i) {
            const bool is_alpha = channels == 4 && i % 4 == 3;
            noise[i] = is_alpha && random_bytes[i] == 0 ? 1 : random_bytes[i];
            pixels[i] = is_alpha ? 200 : smooth[i / channels * 4 + i % channels];
        }
        blob lossless = make_webp(WIDTH, HEIGHT, channels, true, noise);
        blob lossy = make_webp(WIDTH, HEIGHT, channels, false, pixels);
        blob png = make_png(WIDTH, HEIGHT, channels == 4 ? 6 : 2, 8, false, noise);
        nqm_raster a = decode(lossless), b = decode(lossy), c = decode(png);
        assert_true(a.width == WIDTH && a.height == HEIGHT && a.channels == channels && a.type == NQM_RASTER_U8);
        assert_true(a.channels == c.channels && b.channels == c.channels);
        assert_memory_equal(a.data, noise, n);
        assert_memory_equal(a.data, c.data, n);
        for (size_t i = 0; i < n; ++i)
            assert_true(abs(((unsigned char *)b.data)[i] - pixels[i]) <= 12);
        nqm_raster_clear(&a);
        nqm_raster_clear(&b);
        nqm_raster_clear(&c);
        blob_free(&lossless);
        blob_free(&lossy);
        blob_free(&png);
    }
}

static const char animation[] = "RIFF\x22\0\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0\x0f\0\0\x0f\0\0"
                                "ANIM\x06\0\0\0\0\0\0\0\0\0";

static blob copy_of(const char *bytes, size_t n) {
    blob b = {malloc(n), n};
    assert_non_null(b.data);
    memcpy(b.data, bytes, n);
    return b;
}

TEST(webp_refusals) {
    refused(copy_of(animation, sizeof animation - 1), NQM_ERR_FORMAT, "an animated WebP picture, which is not read");
    refused(copy_of("RIFF\x20\0\0\0WEBP", 12), NQM_ERR_FORMAT, "WebP: the file ends too early");
    refused(copy_of("RIFF\x16\0\0\0WEBPVP8L\x09\0\0\0none of it", 30), NQM_ERR_FORMAT,
            "WebP: the data are damaged (byte 0)");
}

/* ---- OpenEXR ----------------------------------------------------------------------------------------------------- */

TEST(exr_kinds) {
    static const struct {
        const char *name;
        size_t channels;
    } files[] = {{"float.exr", 3}, {"half.exr", 3},       {"tiled.exr", 3},     {"grey.exr", 1},
                 {"rgba.exr", 4},  {"rgba-float.exr", 4}, {"grey-alpha.exr", 2}};
    for (size_t f = 0; f < sizeof files / sizeof *files; ++f) {
        const size_t n = files[f].channels;
        enum { EXR_WIDTH = 11, EXR_HEIGHT = 6 };
        double pixels[3 * EXR_WIDTH * EXR_HEIGHT];
        get_vector("images.safetensors", n < 3 ? "exr_grey" : "exr", sizeof pixels, pixels);
        blob file = vector_picture(files[f].name);
        nqm_raster raster = decode(file);
        blob_free(&file);
        assert_true(raster.width == EXR_WIDTH && raster.height == EXR_HEIGHT && raster.channels == n);
        assert_int_equal(raster.type, NQM_RASTER_F32);
        for (size_t i = 0; i < EXR_WIDTH * EXR_HEIGHT * n; ++i) {
            const size_t pixel = i / n, k = i % n;
            const double value = ((float *)raster.data)[i];
            if (n % 2 == 0 && k == n - 1)
                assert_relative(value, (double)pixel / 64, 0);
            else
                assert_relative(value, pixels[3 * pixel + k], 1e-9);
        }
        nqm_raster_clear(&raster);
    }
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

enum { N_SAMPLES = 7 };

static blob sample(size_t i) {
    return i == 4   ? vector_picture("rgba.exr")
           : i > 4  ? make_webp(WIDTH, HEIGHT, 4, i == 5, random_bytes)
           : i == 0 ? make_png(WIDTH, HEIGHT, 3, 4, true, random_bytes)
           : i == 1 ? make_png(WIDTH, HEIGHT, 6, 16, false, random_bytes)
                    : make_jpeg(WIDTH, HEIGHT, 3, i == 2 ? JPEG_PLAIN : JPEG_PROGRESSIVE, random_bytes);
}

TEST(damaged_anywhere) {
    for (size_t i = 0; i < N_SAMPLES; ++i) {
        blob b = sample(i);
        refuse_cuts("map", b, 1, decode_map);
        survive_changes("map", b, 1, decode_map);
        blob_free(&b);
    }
}

/* A JPEG file with a bad code in its data, which libjpeg only warns of. */
TEST(damaged_jpeg) {
    blob b = make_jpeg(WIDTH, HEIGHT, 3, JPEG_PLAIN, random_bytes);
    const size_t at = find(b, "\xff\xda", 2) + 60;
    for (size_t i = 0; i < 40; ++i) /* a long run of ones is no Huffman code */
        b.data[at + i] = i % 2 ? 0 : 0xff;
    nqm_error err = {0};
    assert_int_equal(decode_only(b, &err), NQM_ERR_FORMAT);
    assert_non_null(strstr(err.message, "map: JPEG at byte "));
    assert_in_range(err.byte_offset, 1, b.n_bytes);
    blob_free(&b);
}

static void big_endian(unsigned char *out, size_t n, size_t value) {
    for (size_t i = 0; i < n; ++i)
        out[i] = (unsigned char)(value >> 8 * (n - 1 - i));
}

static blob png_of_size(size_t width, size_t height) {
    blob b = make_png(WIDTH, HEIGHT, 0, 8, false, random_bytes);
    big_endian(b.data + 16, 4, width);
    big_endian(b.data + 20, 4, height);
    big_endian(b.data + 29, 4, crc32(0, b.data + 12, 17));
    return b;
}

static blob jpeg_of_size(size_t width, size_t height) {
    blob b = make_jpeg(WIDTH, HEIGHT, 1, JPEG_PLAIN, random_bytes);
    const size_t frame = find(b, "\xff\xc0", 2);
    big_endian(b.data + frame + 5, 2, height);
    big_endian(b.data + frame + 7, 2, width);
    return b;
}

TEST(lying_sizes) {
    const char *claims = "the header claims 16384 x 16384 pixels, more than";
    refused(png_of_size(16384, 16384), NQM_ERR_FORMAT, claims);
    refused(jpeg_of_size(16384, 16384), NQM_ERR_FORMAT, claims);
    refused(png_of_size(0x7fffffff, 0x7fffffff), NQM_ERR_FORMAT, "the header claims 2147483647 x");
    refused(png_of_size(0, 9), NQM_ERR_FORMAT, "PNG at byte");
    refused(jpeg_of_size(0, 9), NQM_ERR_FORMAT, "JPEG at byte");
    refused(png_of_size(NQM_RASTER_MAX_SIDE + 1, 2), NQM_ERR_LIMIT, "16385 x 2 pixels; at most 16384 x 16384");
    refused(jpeg_of_size(2, NQM_RASTER_MAX_SIDE + 1), NQM_ERR_LIMIT, "2 x 16385 pixels; at most 16384 x 16384");
    blob exr = sample(4);
    const size_t at = find(exr, "dataWindow", 10) + 21;
    static const unsigned char wide[16] = {1, 0, 0, 0, 2, 0, 0, 0, 0, 64, 0, 0, 1, 64, 0, 0};
    memcpy(exr.data + at, wide, sizeof wide);
    memcpy(exr.data + find(exr, "displayWindow", 13) + 24, wide, sizeof wide);
    refused(exr, NQM_ERR_FORMAT, claims);
}

/* Pictures are counted before their pixels are allocated, which fails here. */
static nqm_status begin_large(nqm_raster *raster, nqm_error *err) {
    const nqm_map map = {.path = "map", .n_bytes = (size_t)1 << 30};
    *raster = (nqm_raster){.width = NQM_RASTER_MAX_SIDE, .height = NQM_RASTER_MAX_SIDE, .channels = 3};
    nqm_alloc_fail_after(0);
    const nqm_status status = nqm_raster_begin(&map, 1, false, raster, err);
    nqm_alloc_fail_after(-1);
    return status;
}

TEST(all_pictures_together_are_limited) {
    enum { N = (int)(NQM_RASTER_MAX_BYTES / ((uint64_t)3 * NQM_RASTER_MAX_SIDE * NQM_RASTER_MAX_SIDE)) };
    nqm_raster rasters[N + 1];
    nqm_error err = {0};
    assert_true(N == 4 || N == 1); /* of 64 and of 32 bits */
    for (size_t i = 0; i < N; ++i)
        assert_int_equal(begin_large(&rasters[i], NULL), NQM_ERR_NOMEM);
    assert_int_equal(begin_large(&rasters[N], &err), NQM_ERR_LIMIT);
    char expected[160];
    snprintf(
        expected, sizeof expected,
        "map: 16384 x 16384 pixels are 768 MiB, besides %d MiB of other pictures; all may have %d: give smaller ones",
        768 * N, (int)(NQM_RASTER_MAX_BYTES >> 20));
    assert_string_equal(err.message, expected);
    nqm_raster_clear(&rasters[0]);
    assert_int_equal(begin_large(&rasters[0], NULL), NQM_ERR_NOMEM);
    for (size_t i = 0; i < N; ++i)
        nqm_raster_clear(&rasters[i]);
}

TEST(other_formats) {
    static const struct {
        const char *bytes, *words;
        size_t n;
    } files[] = {
        {"\xabKTX 20\xbb\r\n\x1a\n\0\0", "a KTX2 picture, which is not read: convert it to PNG", 14},
        {"\xabKTX 11\xbb\r\n\x1a\n\0\0", "a KTX picture, which", 14},
        {"DDS |\0\0\0\x07\x10\0\0", "a DDS picture, which is not read: convert it to PNG", 12},
        {"II*\0\x08\0\0\0", "a TIFF picture, which", 8},
        {"GIF89a\x01\0\x01\0", "a GIF picture, which", 10},
        {"BM\x46\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0", "a BMP picture, which", 18},
        {"sB\x13\0\x4d\0\0\0", "a Basis Universal picture, which", 8},
        {"\0\0\0\x1c"
         "ftypavif\0\0\0\0",
         "an AVIF picture, which", 16},
        {"{\"asset\": 1}", "neither PNG, JPEG, WebP nor OpenEXR but JSON", 12},
        {"version https://git-lfs.github.com/spec/v1\n", "git lfs pull", 43},
        {"\1\2\3\4", "neither PNG, JPEG, WebP nor OpenEXR (byte 0)", 4},
        {"", "neither PNG, JPEG, WebP nor OpenEXR (byte 0)", 0},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        blob b = {malloc(files[i].n + 1), files[i].n};
        assert_non_null(b.data);
        memcpy(b.data, files[i].bytes, files[i].n);
        refused(b, NQM_ERR_FORMAT, files[i].words);
    }
}

TEST(out_of_memory) {
    for (size_t i = 0; i < N_SAMPLES; ++i) {
        blob b = sample(i);
        nqm_error err = {0};
        nqm_alloc_fail_after(0);
        assert_int_equal(decode_only(b, &err), NQM_ERR_NOMEM);
        nqm_alloc_fail_after(-1);
        blob_free(&b);
    }
}

TEST_FILE(make_noise, NULL)
