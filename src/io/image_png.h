/* SPDX-License-Identifier: MIT
 *
 * image_png.h - what reading and writing PNG share: libpng's messages. Internal to the module.
 */
#ifndef NQM_SRC_IO_IMAGE_PNG_H
#define NQM_SRC_IO_IMAGE_PNG_H

#include <png.h>

enum { NQM_PNG_MESSAGE_SIZE = 120 };

/** libpng's error function: keep the message in libpng's error pointer, a char[NQM_PNG_MESSAGE_SIZE], and jump. */
void nqm_png_on_error(png_structp png, png_const_charp message);
/** libpng's warning function: the library does not print. */
void nqm_png_on_warning(png_structp png, png_const_charp message);

#endif
