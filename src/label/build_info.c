/* SPDX-License-Identifier: MIT
 *
 * What the full library holds beside the core, in one line.
 */
#include "io/io.h"
#include "plot/plot.h"
#include "render/render.h"

#include <nqm/label.h>
#include <openexr.h>
#include <png.h>
#include <pthread.h>

static char line[256];
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void make_line(void) {
    const char *cairo = nqm_cairo_version(), *embree = nqm_tracer_version();
    int major, minor, patch;
    exr_get_library_version(&major, &minor, &patch, NULL);
    snprintf(line, sizeof line, "cairo %s, Embree %s%s, libpng %s, OpenEXR %d.%d.%d, %s when needed, no MPI library",
             cairo ? cairo : "off", embree ? embree : "off", embree ? " when needed" : "", png_get_libpng_ver(NULL),
             major, minor, patch, nqm_matio_name());
}

const char *nqm_full_build_info(void) {
    pthread_once(&once, make_line);
    return line;
}
