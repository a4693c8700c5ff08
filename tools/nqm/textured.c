/* SPDX-License-Identifier: MIT
 *
 * The implementation of textured.h.
 */
#include "nqm/textured.h"

#include "library/library.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool is_textured(const char *argument) {
    nqm_argument *a = parse_argument(argument);
    const bool is = nqm_argument_is_textured(a);
    nqm_argument_free(a);
    return is;
}

bool is_library(const char *argument) {
    nqm_argument *a = parse_argument(argument);
    const nqm_textured *maps;
    nqm_textured *owned = NULL;
    const bool is = a->kind == NQM_ARGUMENT_FOLDER && nqm_argument_maps(a, &maps, &owned, NULL) != NQM_OK;
    nqm_textured_free(owned);
    nqm_argument_free(a);
    return is;
}

nqm_status open_texture(nqm_argument *argument, nqm_texture **texture_ret, nqm_error *err) {
    const nqm_library_terms terms = {.progress = show_progress, .report = report_part};
    return nqm_library_open_texture(&terms, argument, texture_ret, err);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

view_args view_args_begin(void) {
    const nqm_texture_view v = nqm_scene_texture_view_default();
    return (view_args){(uint64_t)v.tiles, v.n_samples};
}

nqm_texture_view view_of(const view_args *args) {
    nqm_texture_view v = nqm_scene_texture_view_default();
    v.tiles = (double)args->tiles;
    v.n_samples = (size_t)args->texels;
    return v;
}
