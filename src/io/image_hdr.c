/* SPDX-License-Identifier: MIT
 *
 * Radiance HDR (.hdr, .pic; Ward, "Real Pixels", Graphics Gems II, 1991): a text header, a resolution line, then
 * scanlines of RGBE pixels, uncompressed or in one of two run-length encodings; linear rgb =
 * (r, g, b)/256 * 2^(e - 128). EXPOSURE lines are ignored: the scene has its own exposure. The writer rounds mantissas
 * to nearest and writes uncompressed rows; their pixels cannot look like a run, for the largest mantissa is at least 128.
 */
#include "io/io.h"

#include <math.h>
#include <string.h>

/* A run of the older encoding stores up to 255 pixels in 4 bytes (64 per byte), the newer encoding at most 16 pixels
 * per byte. Consecutive runs of the older encoding can store more; images that exceed 64 pixels per byte are
 * refused. */
static const double max_pixels_per_byte = 64;

typedef struct hdr_file {
    const nqm_map *map;
    size_t position;
    nqm_error *err;
} hdr_file;

static nqm_status fail_at(const hdr_file *file, const char *what) {
    return nqm_fail(file->err, NQM_ERR_FORMAT, (int64_t)file->position, "%s: Radiance HDR at byte %zu: %s",
                    file->map->path, file->position, what);
}

/* Copy the next line, without its newline, to `line` (n_line bytes); a longer line is truncated. */
static nqm_status read_line(hdr_file *file, char *line, size_t n_line) {
    const unsigned char *begin = file->map->data + file->position;
    size_t left = file->map->n_bytes - file->position;
    const unsigned char *end = left ? memchr(begin, '\n', left) : NULL;
    if (!end)
        return fail_at(file, "the header does not end");
    size_t n = (size_t)(end - begin);
    file->position += n + 1;
    n = n < n_line ? n : n_line - 1;
    memcpy(line, begin, n);
    line[n] = 0;
    return NQM_OK;
}

/* Parse `prefix` and a decimal number of at most 10 digits; returns the rest of the text, or NULL. */
static const char *parse_size(const char *text, const char *prefix, uint64_t *value) {
    size_t n = strlen(prefix), n_digits = 0;
    if (strncmp(text, prefix, n) != 0)
        return NULL;
    *value = 0;
    for (text += n; *text >= '0' && *text <= '9' && n_digits < 10; ++text, ++n_digits)
        *value = 10 * *value + (uint64_t)(*text - '0');
    return n_digits ? text : NULL;
}

/* Read the header and the size line after it. */
static nqm_status read_header(hdr_file *file, uint64_t *width, uint64_t *height) {
    char line[128];
    nqm_status status = read_line(file, line, sizeof line);
    if (status == NQM_OK && strcmp(line, "#?RADIANCE") != 0 && strcmp(line, "#?RGBE") != 0)
        return fail_at(file, "the first line is neither #?RADIANCE nor #?RGBE");
    while (status == NQM_OK && line[0]) {
        status = read_line(file, line, sizeof line);
        if (status == NQM_OK && strncmp(line, "FORMAT=", 7) == 0 && strcmp(line + 7, "32-bit_rle_rgbe") != 0)
            return fail_at(file, "only FORMAT=32-bit_rle_rgbe is read");
    }
    if (status == NQM_OK)
        status = read_line(file, line, sizeof line);
    if (status != NQM_OK)
        return status;
    const char *rest = parse_size(line, "-Y ", height);
    rest = rest ? parse_size(rest, " +X ", width) : NULL;
    return rest && !*rest ? NQM_OK : fail_at(file, "the size line is not '-Y HEIGHT +X WIDTH'");
}

/* Read one channel of a row in the newer encoding: a count n > 128 is followed by one value that is repeated n - 128
 * times, a count n <= 128 by n values. */
static nqm_status read_channel(hdr_file *file, unsigned char *row, size_t width) {
    const unsigned char *data = file->map->data;
    for (size_t x = 0; x < width;) {
        size_t left = file->map->n_bytes - file->position;
        size_t code = left ? data[file->position] : 0, n = code > 128 ? code - 128 : code;
        bool run = code > 128;
        if (n == 0 || left < 1 + (run ? 1 : n))
            return fail_at(file, left ? "a row is damaged or ends too early" : "the file ends too early");
        if (n > width - x)
            return fail_at(file, "a run passes the end of its row");
        for (size_t i = 0; i < n; ++i)
            row[4 * (x + i)] = data[file->position + 1 + (run ? 0 : i)];
        file->position += 1 + (run ? 1 : n);
        x += n;
    }
    return NQM_OK;
}

/* Read a row that is uncompressed or in the older encoding: (1, 1, 1, n) repeats the previous pixel n times; in a
 * sequence of such runs, the counts have the factors 1, 256, 256^2 and so on. */
static nqm_status read_flat_row(hdr_file *file, unsigned char *row, size_t width) {
    unsigned shift = 0;
    for (size_t x = 0; x < width;) {
        if (file->map->n_bytes - file->position < 4)
            return fail_at(file, "the file ends too early");
        const unsigned char *pixel = file->map->data + file->position;
        bool run = pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1;
        size_t n = run ? (size_t)pixel[3] << shift : 1;
        if (run && (x == 0 || n > width - x))
            return fail_at(file, "a run has no pixel before it or passes the end of its row");
        for (size_t i = 0; i < n; ++i)
            memcpy(row + 4 * (x + i), run ? row + 4 * (x - 1) : pixel, 4);
        file->position += 4;
        shift = run ? (shift < 24 ? shift + 8 : shift) : 0;
        x += n;
    }
    return NQM_OK;
}

static nqm_status read_row(hdr_file *file, unsigned char *row, size_t width) {
    const unsigned char *p = file->map->data + file->position;
    bool newer = file->map->n_bytes - file->position >= 4 && width >= 8 && width < 32768 && p[0] == 2 && p[1] == 2 &&
                 (size_t)(p[2] << 8 | p[3]) == width;
    if (!newer)
        return read_flat_row(file, row, width);
    file->position += 4;
    nqm_status status = NQM_OK;
    for (size_t channel = 0; status == NQM_OK && channel < 4; ++channel)
        status = read_channel(file, row + channel, width);
    return status;
}

nqm_status nqm_image_decode_hdr(const nqm_map *map, nqm_image *image, nqm_error *err) {
    hdr_file file = {.map = map, .err = err};
    uint64_t width = 0, height = 0;
    nqm_status status = read_header(&file, &width, &height);
    if (status == NQM_OK)
        status = nqm_image_alloc(map, width, height, max_pixels_per_byte, image, err);
    if (status != NQM_OK)
        return status;
    unsigned char *row = nqm_alloc(image->width, 4); /* (width, 4) */
    if (!row)
        return nqm_fail_nomem(err, image->width * 4);
    float *rgb = image->rgb;
    for (size_t y = 0; status == NQM_OK && y < image->height; ++y) {
        status = read_row(&file, row, image->width);
        for (size_t x = 0; status == NQM_OK && x < image->width; ++x) {
            double unit = row[4 * x + 3] ? ldexp(1.0 / 256, row[4 * x + 3] - 128) : 0;
            for (size_t k = 0; k < 3; ++k)
                *rgb++ = (float)(row[4 * x + k] * unit);
        }
    }
    nqm_free(row);
    return status;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static void encode_pixel(const float *rgb, unsigned char *rgbe) {
    double brightest = fmax(fmax((double)rgb[0], (double)rgb[1]), (double)rgb[2]);
    int exponent;
    memset(rgbe, 0, 4);
    if (!(brightest > 1e-32))
        return;
    (void)frexp(brightest, &exponent);
    if (nearbyint(ldexp(brightest, 8 - exponent)) > 255)
        ++exponent;
    if (exponent > 127) { /* larger than RGBE can represent */
        memset(rgbe, 255, 4);
        return;
    }
    for (int k = 0; k < 3; ++k)
        rgbe[k] = (unsigned char)nearbyint(ldexp(fmax((double)rgb[k], 0), 8 - exponent));
    rgbe[3] = (unsigned char)(exponent + 128);
}

nqm_status nqm_image_write_hdr(const char *path, const nqm_image *image, nqm_error *err) {
    nqm_outfile out;
    unsigned char *row = nqm_alloc(image->width, 4);
    if (!row)
        return nqm_fail_nomem(err, 4 * image->width);
    nqm_status status = nqm_outfile_open(path, &out, err);
    if (status == NQM_OK) {
        fprintf(out.stream, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %zu +X %zu\n", image->height, image->width);
        for (size_t y = 0; y < image->height; ++y) {
            for (size_t x = 0; x < image->width; ++x)
                encode_pixel(image->rgb + 3 * (y * image->width + x), row + 4 * x);
            fwrite(row, 4, image->width, out.stream);
        }
        status = nqm_outfile_commit(&out, err);
    }
    nqm_free(row);
    return status;
}
