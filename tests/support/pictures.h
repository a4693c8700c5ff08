/* SPDX-License-Identifier: MIT
 *
 * pictures.h - writes small PNG, JPEG and WebP files, for tests of what reads maps of materials.
 */
#ifndef NQM_TESTS_SUPPORT_PICTURES_H
#define NQM_TESTS_SUPPORT_PICTURES_H

#include "support/brdf_files.h"

/** The palette of make_png(): entry i is (i, 255 - i, 7 i mod 256), and half transparent. */
enum { PALETTE_SIZE = 256 };
void palette_entry(size_t i, unsigned char rgb[3]);

/** A PNG file. colour: colour type of PNG (0 grey, 2 RGB, 3 palette, 4 grey and alpha, 6 RGBA); rows: as PNG stores them, (height,
 *  ceil(width * channels * bits / 8)). */
blob make_png(size_t width, size_t height, int colour, int bits, bool is_interlaced, const unsigned char *rows);

typedef enum jpeg_kind { JPEG_PLAIN, JPEG_PROGRESSIVE, JPEG_ARITHMETIC } jpeg_kind;
/** A JPEG file of quality 100. channels: 1, 3 or 4 (CMYK); pixels: (height, width, channels). */
blob make_jpeg(size_t width, size_t height, int channels, jpeg_kind kind, const unsigned char *pixels);

/** A WebP file. channels: 3 or 4; is_lossless: the pixels are stored exactly where alpha is not 0, otherwise with quality 90. */
blob make_webp(size_t width, size_t height, size_t channels, bool is_lossless, const unsigned char *pixels);

#endif
