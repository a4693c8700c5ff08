/* SPDX-License-Identifier: MIT
 *
 * Radiance HDR pictures: RGBE pixels, run-length coded channel by channel where the width allows it (Ward, "Real
 * Pixels", Graphics Gems II, 1991). The mantissas are rounded to nearest, since most readers take them as they are.
 */
#include "io/io.h"

#include <math.h>
#include <string.h>

enum { MIN_RUN = 4, MAX_RUN = 127, MAX_LITERAL = 128, MIN_RLE_WIDTH = 8, MAX_RLE_WIDTH = 32767 };

static void encode_pixel(const float *rgb, unsigned char *rgbe) {
    double brightest = fmax(fmax((double)rgb[0], (double)rgb[1]), (double)rgb[2]);
    int exponent;
    memset(rgbe, 0, 4);
    if (!(brightest > 1e-32))
        return;
    (void)frexp(brightest, &exponent);
    if (nearbyint(ldexp(brightest, 8 - exponent)) > 255)
        ++exponent;
    if (exponent > 127) { /* beyond what RGBE holds */
        memset(rgbe, 255, 4);
        return;
    }
    for (int k = 0; k < 3; ++k)
        rgbe[k] = (unsigned char)nearbyint(ldexp(fmax((double)rgb[k], 0), 8 - exponent));
    rgbe[3] = (unsigned char)(exponent + 128);
}

static size_t run_length(const unsigned char *values, size_t n) {
    size_t run = 1;
    while (run < n && run < MAX_RUN && values[4 * run] == values[0])
        ++run;
    return run;
}

/* One channel of a row: a count above 128 and the value of a run, or a count and so many values. */
static void write_channel(FILE *stream, const unsigned char *values, size_t width) {
    for (size_t x = 0; x < width;) {
        size_t run = run_length(values + 4 * x, width - x);
        if (run >= MIN_RUN) {
            fputc((int)(128 + run), stream);
            fputc(values[4 * x], stream);
            x += run;
            continue;
        }
        size_t n = 0;
        while (x + n < width && n < MAX_LITERAL && run_length(values + 4 * (x + n), width - x - n) < MIN_RUN)
            ++n;
        fputc((int)n, stream);
        for (size_t i = 0; i < n; ++i)
            fputc(values[4 * (x + i)], stream);
        x += n;
    }
}

static void write_row(FILE *stream, const unsigned char *row, size_t width) {
    if (width < MIN_RLE_WIDTH || width > MAX_RLE_WIDTH) {
        fwrite(row, 4, width, stream);
        return;
    }
    const unsigned char head[4] = {2, 2, (unsigned char)(width >> 8), (unsigned char)(width & 255)};
    fwrite(head, 1, sizeof head, stream);
    for (size_t channel = 0; channel < 4; ++channel)
        write_channel(stream, row + channel, width);
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
            write_row(out.stream, row, image->width);
        }
        status = nqm_outfile_commit(&out, err);
    }
    nqm_free(row);
    return status;
}
