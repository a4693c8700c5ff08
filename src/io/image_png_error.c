/* SPDX-License-Identifier: MIT
 *
 * What happens to libpng's messages.
 */
#include "io/image_png.h"

#include <setjmp.h>
#include <stdio.h>

void nqm_png_on_error(png_structp png, png_const_charp message) {
    snprintf(png_get_error_ptr(png), NQM_PNG_MESSAGE_SIZE, "%s", message);
    longjmp(png_jmpbuf(png), 1);
}

void nqm_png_on_warning(png_structp png, png_const_charp message) {
    (void)png;
    (void)message;
}
