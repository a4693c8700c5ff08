/* SPDX-License-Identifier: MIT
 *
 * PNG pictures for looking at: 8-bit RGB, marked as sRGB, packed as tightly as deflate can.
 */
#include "io/image_png.h"
#include "io/io.h"

#include <setjmp.h>

typedef struct png_output {
    FILE *stream;
    size_t width, height;
    const unsigned char *rgb; /* (height, width, 3) */
    char message[NQM_PNG_MESSAGE_SIZE];
    bool failed;
} png_output;

/* Everything that libpng may leave by longjmp. */
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
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, o.message, nqm_png_on_error, nqm_png_on_warning);
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
