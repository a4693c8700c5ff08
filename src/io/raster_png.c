/* SPDX-License-Identifier: MIT
 *
 * PNG pictures with libpng. Reading: all kinds, with the values of the file. Writing: 8-bit RGB, or RGB and alpha, at the highest
 * compression level.
 */
#include "io/raster.h"

#include <png.h>
#include <setjmp.h>

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
    bool header_only;
    char message[MESSAGE_SIZE];
    nqm_raster *raster;
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

/* Read the header, and choose the conversions of the pixels. */
static nqm_status read_header(png_structp png, png_infop info, png_file *file) {
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX); /* nqm_raster_begin() limits the size */
    /* Profiles, texts and gamma, which are not used, are skipped. */
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, NULL, -1);
    png_read_info(png, info);
    const bool is_palette = png_get_color_type(png, info) == PNG_COLOR_TYPE_PALETTE;
    const size_t bits = png_get_bit_depth(png, info), channels = is_palette ? 3 : png_get_channels(png, info);
    *file->raster = (nqm_raster){.width = png_get_image_width(png, info),
                                 .height = png_get_image_height(png, info),
                                 .channels = channels,
                                 .type = bits == 16 ? NQM_RASTER_U16 : NQM_RASTER_U8};
    const double bits_per_pixel = (double)(bits * png_get_channels(png, info));
    if (is_palette) {
        png_set_palette_to_rgb(png);
        png_set_strip_alpha(png); /* of the palette */
    } else if (bits < 8) {
        png_set_expand_gray_1_2_4_to_8(png);
    }
    if (bits == 16 && !NQM_BIG_ENDIAN)
        png_set_swap(png);
    return nqm_raster_begin(file->map, NQM_DEFLATE_MAX * 8 / bits_per_pixel, file->header_only, file->raster,
                            file->err);
}

/* All calls that libpng may leave by longjmp(). Values that are needed after the jump are members of `file`, not local
 * variables. */
static void read_png(png_structp png, png_infop info, png_file *file) {
    if (setjmp(png_jmpbuf(png))) {
        file->status = nqm_fail(file->err, NQM_ERR_FORMAT, (int64_t)file->position, "%s: PNG at byte %zu: %s",
                                file->map->path, file->position, file->message);
        return;
    }
    file->status = read_header(png, info, file);
    if (file->status != NQM_OK || file->header_only)
        return;
    const int n_passes = png_set_interlace_handling(png);
    png_read_update_info(png, info);
    const size_t row_size = png_get_rowbytes(png, info);
    for (int pass = 0; pass < n_passes; ++pass)
        for (size_t y = 0; y < file->raster->height; ++y)
            png_read_row(png, (png_bytep)file->raster->data + row_size * y, NULL);
    png_read_end(png, NULL);
}

nqm_status nqm_raster_decode_png(const nqm_map *map, bool header_only, nqm_raster *raster, nqm_error *err) {
    png_file file = {.map = map, .header_only = header_only, .raster = raster, .err = err};
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, file.message, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (info) {
        png_set_read_fn(png, &file, on_read);
        read_png(png, info, &file);
    } else {
        file.status = nqm_fail_nomem(err, sizeof(void *));
    }
    png_destroy_read_struct(&png, &info, NULL);
    return file.status;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

typedef struct png_output {
    FILE *stream;
    const nqm_raster *raster;
    bool is_srgb;
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
    const nqm_raster *r = o->raster;
    png_set_compression_level(png, r->width * r->height > 1 << 20 ? 6 : 9); /* 9 takes seconds then */
    png_set_IHDR(png, info, (png_uint_32)r->width, (png_uint_32)r->height, 8,
                 r->channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (o->is_srgb)
        png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png, info);
    for (size_t y = 0; y < r->height; ++y)
        png_write_row(png, (const unsigned char *)r->data + r->channels * r->width * y);
    png_write_end(png, NULL);
}

nqm_status nqm_raster_write_png(const char *path, const nqm_raster *raster, bool is_srgb, nqm_outset *set,
                                nqm_error *err) {
    nqm_outfile out;
    nqm_status status = nqm_outfile_open(path, &out, err);
    if (status != NQM_OK)
        return status;
    png_output o = {.stream = out.stream, .raster = raster, .is_srgb = is_srgb, .message = "out of memory"};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, o.message, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (info)
        write_png(png, info, &o);
    else
        o.failed = true;
    png_destroy_write_struct(&png, &info);
    if (!o.failed)
        return nqm_outfile_keep(&out, set, err);
    nqm_outfile_abort(&out);
    return nqm_fail(err, NQM_ERR_IO, -1, "%s: cannot write PNG: %s", path, o.message);
}
