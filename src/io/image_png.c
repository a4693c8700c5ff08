/* SPDX-License-Identifier: MIT
 *
 * PNG images with libpng. Reading: RGBE stored in 8-bit RGBA, linear rgb = (r, g, b)/255 * 2^(a - 128). Writing: 8-bit
 * RGB with an sRGB chunk, at the highest compression level.
 */
#include "io/io.h"

#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <string.h>

/* Deflate expands one byte to at most 1032 bytes; a pixel has four bytes. */
static const double max_pixels_per_byte = 1032 / 4;

enum { MESSAGE_SIZE = 120 };

/* Error handler of libpng, which must not return: copies the message to the error pointer, a char[MESSAGE_SIZE]. */
static void on_error(png_structp png, png_const_charp message) {
    snprintf(png_get_error_ptr(png), MESSAGE_SIZE, "%s", message);
    longjmp(png_jmpbuf(png), 1);
}

/* Ignores warnings: libpng's default handler prints them, and the library must not print. */
static void on_warning(png_structp png, png_const_charp message) {
    (void)png;
    (void)message;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

typedef struct png_file {
    const nqm_map *map;
    size_t position;
    char message[MESSAGE_SIZE];
    nqm_image *image;
    unsigned char *rgba; /* (height, width, 4) */
    nqm_status status;
    nqm_error *err;
} png_file;

static void on_read(png_structp png, png_bytep out, size_t n) {
    png_file *file = png_get_io_ptr(png);
    if (n > file->map->n_bytes - file->position)
        png_error(png, "the file ends too early");
    memcpy(out, file->map->data + file->position, n);
    file->position += n;
}

/* All calls that libpng may leave by longjmp(). Values that are needed after the jump are members of `file`, not local
 * variables. */
static void read_png(png_structp png, png_infop info, png_file *file) {
    if (setjmp(png_jmpbuf(png))) {
        if (file->status == NQM_OK)
            file->status = nqm_fail(file->err, NQM_ERR_FORMAT, (int64_t)file->position, "%s: PNG at byte %zu: %s",
                                    file->map->path, file->position, file->message);
        return;
    }
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX); /* nqm_image_alloc() limits the size */
    png_set_chunk_malloc_max(png, 1 << 20);
    png_set_chunk_cache_max(png, 64);
    png_read_info(png, info);
    if (png_get_bit_depth(png, info) != 8 || png_get_color_type(png, info) != PNG_COLOR_TYPE_RGB_ALPHA) {
        file->status =
            nqm_fail(file->err, NQM_ERR_FORMAT, 24,
                     "%s: a light map in a PNG has RGBE pixels in 8-bit RGBA; this one has not", file->map->path);
        return;
    }
    size_t width = png_get_image_width(png, info), height = png_get_image_height(png, info);
    file->status = nqm_image_alloc(file->map, width, height, max_pixels_per_byte, file->image, file->err);
    if (file->status != NQM_OK)
        return;
    file->rgba = nqm_alloc(width * height, 4);
    if (!file->rgba) {
        file->status = nqm_fail_nomem(file->err, width * height * 4);
        return;
    }
    int n_passes = png_set_interlace_handling(png);
    png_read_update_info(png, info);
    for (int pass = 0; pass < n_passes; ++pass)
        for (size_t y = 0; y < height; ++y)
            png_read_row(png, file->rgba + 4 * width * y, NULL);
    png_read_end(png, NULL);
}

nqm_status nqm_image_decode_png(const nqm_map *map, nqm_image *image, nqm_error *err) {
    png_file file = {.map = map, .image = image, .err = err};
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, file.message, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (info) {
        png_set_read_fn(png, &file, on_read);
        read_png(png, info, &file);
    } else {
        file.status = nqm_fail_nomem(err, sizeof(void *));
    }
    png_destroy_read_struct(&png, &info, NULL);
    for (size_t i = 0; file.status == NQM_OK && i < image->width * image->height; ++i) {
        double unit = ldexp(1.0 / 255, file.rgba[4 * i + 3] - 128);
        for (size_t k = 0; k < 3; ++k)
            image->rgb[3 * i + k] = (float)(file.rgba[4 * i + k] * unit);
    }
    nqm_free(file.rgba);
    return file.status;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

typedef struct png_output {
    FILE *stream;
    size_t width, height;
    const unsigned char *rgb; /* (height, width, 3) */
    char message[MESSAGE_SIZE];
    bool failed;
} png_output;

/* All calls that libpng may leave by longjmp(). */
static void write_png(png_structp png, png_infop info, png_output *o) {
    if (setjmp(png_jmpbuf(png))) {
        o->failed = true;
        return;
    }
    png_init_io(png, o->stream);
    png_set_compression_level(png, 9);
    png_set_IHDR(png, info, (png_uint_32)o->width, (png_uint_32)o->height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png, info);
    for (size_t y = 0; y < o->height; ++y)
        png_write_row(png, o->rgb + 3 * o->width * y);
    png_write_end(png, NULL);
}

nqm_status nqm_image_write_png(const char *path, size_t width, size_t height, const unsigned char *rgb,
                               nqm_error *err) {
    nqm_outfile out;
    nqm_status status = nqm_outfile_open(path, &out, err);
    if (status != NQM_OK)
        return status;
    png_output o = {.stream = out.stream, .width = width, .height = height, .rgb = rgb, .message = "out of memory"};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, o.message, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (info)
        write_png(png, info, &o);
    else
        o.failed = true;
    png_destroy_write_struct(&png, &info);
    if (!o.failed)
        return nqm_outfile_commit(&out, err);
    nqm_outfile_abort(&out);
    return nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write PNG: %s", path, o.message);
}
