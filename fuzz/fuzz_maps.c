/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: lists of maps, as the argument "maps:key=file;...".
 */
#include "base/base.h"
#include "fuzz.h"
#include "material/maps.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    char *text = malloc(n_bytes + 6);
    nqm_textured *t = NULL;
    nqm_error err = {0};
    must(text != NULL);
    memcpy(text, "maps:", 5);
    memcpy(text + 5, data, n_bytes);
    text[n_bytes + 5] = 0;
    if (nqm_maps_open(text, &t, &err) != NQM_OK)
        must(!t && err.message[0]);
    else
        must(t->n_images > 0);
    nqm_textured_free(t);
    free(text);
    return 0;
}

static blob make_seed(void) {
    static const char text[] = "base_color=a.png;roughness=b.png:g;metallic=0.5;normal=c.exr:dx;model=gltf;ior=1.5";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
