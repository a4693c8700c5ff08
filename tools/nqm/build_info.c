/* SPDX-License-Identifier: MIT
 *
 * One line about the libraries of this build that nqm_build_info() does not list.
 */
#include "io/io.h"
#include "nqm/tool.h"
#include "render/render.h"

#include <jpeglib.h>
#include <openexr.h>
#include <png.h>
#include <pthread.h>

/* The text of a macro's value. */
#define TEXT(value)    #value
#define TEXT_OF(macro) TEXT(macro)

static char line[256];
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void make_line(void) {
    const char *embree = nqm_tracer_version();
    int major, minor, patch;
    exr_get_library_version(&major, &minor, &patch, NULL);
    snprintf(line, sizeof line,
             "Embree %s%s, libjpeg-turbo %s, libpng %s, OpenEXR %d.%d.%d, no "
             "MPI library",
             embree ? embree : "off", embree ? " when needed" : "", TEXT_OF(LIBJPEG_TURBO_VERSION),
             png_get_libpng_ver(NULL), major, minor, patch);
}

const char *tool_build_info(void) {
    pthread_once(&once, make_line);
    return line;
}
