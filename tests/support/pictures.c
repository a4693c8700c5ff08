/* SPDX-License-Identifier: MIT
 *
 * Writes small PNG files with libpng and JPEG files with libjpeg, whose own handlers end the test if they fail, and WebP files
 * with libwebp.
 */
#include "support/pictures.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h>
#include <png.h>
#include <webp/encode.h>

void palette_entry(size_t i, unsigned char rgb[3]) {
    rgb[0] = (unsigned char)i;
    rgb[1] = (unsigned char)(255 - i);
    rgb[2] = (unsigned char)(7 * i);
}

static void append(png_structp png, png_bytep data, size_t n) {
    blob *b = png_get_io_ptr(png);
    b->data = realloc(b->data, b->n_bytes + n);
    if (!b->data)
        abort();
    memcpy(b->data + b->n_bytes, data, n);
    b->n_bytes += n;
}

blob make_png(size_t width, size_t height, int colour, int bits, bool is_interlaced, const unsigned char *rows) {
    blob b = {0};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(png, &b, append, NULL);
    png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, bits, colour,
                 is_interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_color palette[PALETTE_SIZE];
    unsigned char alpha[PALETTE_SIZE];
    memset(alpha, 128, sizeof alpha);
    for (size_t i = 0; i < PALETTE_SIZE; ++i) {
        unsigned char rgb[3];
        palette_entry(i, rgb);
        palette[i] = (png_color){rgb[0], rgb[1], rgb[2]};
    }
    if (colour == PNG_COLOR_TYPE_PALETTE) {
        png_set_PLTE(png, info, palette, 1 << bits);
        png_set_tRNS(png, info, alpha, 1 << bits, NULL);
    }
    png_set_gAMA(png, info, 0.25); /* a reader of raw values ignores it */
    png_bytep *row = calloc(height, sizeof *row);
    if (!row)
        abort();
    png_set_rows(png, info, row);
    for (size_t y = 0; y < height; ++y)
        row[y] = (png_bytep)(uintptr_t)rows + y * png_get_rowbytes(png, info);
    png_write_png(png, info, PNG_TRANSFORM_IDENTITY, NULL);
    free(row);
    png_destroy_write_struct(&png, &info);
    return b;
}

blob make_jpeg(size_t width, size_t height, int channels, jpeg_kind kind, const unsigned char *pixels) {
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr errors;
    unsigned char *data = NULL;
    unsigned long n_bytes = 0;
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &data, &n_bytes);
    jpeg.image_width = (JDIMENSION)width;
    jpeg.image_height = (JDIMENSION)height;
    jpeg.input_components = channels;
    jpeg.in_color_space = channels == 1 ? JCS_GRAYSCALE : channels == 3 ? JCS_RGB : JCS_CMYK;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 100, TRUE);
    jpeg.arith_code = kind == JPEG_ARITHMETIC;
    if (kind == JPEG_PROGRESSIVE)
        jpeg_simple_progression(&jpeg);
    jpeg_start_compress(&jpeg, TRUE);
    while (jpeg.next_scanline < jpeg.image_height) {
        JSAMPROW row = (JSAMPROW)(uintptr_t)pixels + jpeg.next_scanline * width * (size_t)channels;
        (void)jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    return (blob){.data = data, .n_bytes = n_bytes};
}

blob make_webp(size_t width, size_t height, size_t channels, bool is_lossless, const unsigned char *pixels) {
    const int w = (int)width, h = (int)height, stride = (int)(width * channels);
    unsigned char *data = NULL;
    const size_t n = is_lossless && channels == 3 ? WebPEncodeLosslessRGB(pixels, w, h, stride, &data)
                     : is_lossless                ? WebPEncodeLosslessRGBA(pixels, w, h, stride, &data)
                     : channels == 3              ? WebPEncodeRGB(pixels, w, h, stride, 90, &data)
                                                  : WebPEncodeRGBA(pixels, w, h, stride, 90, &data);
    blob b = {malloc(n), n}; /* blob_free() is no WebPFree() */
    if (!n || !b.data)
        abort();
    memcpy(b.data, data, n);
    WebPFree(data);
    return b;
}
