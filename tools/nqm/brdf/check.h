/* SPDX-License-Identifier: MIT
 *
 * check.h - parts of nqm check: what of a material with image maps is checked.
 */
#ifndef NQM_TOOL_CHECK_H
#define NQM_TOOL_CHECK_H

#include "nqm/textured.h"

enum { MAX_CHECKED_TEXELS = 32 };
/** Texels that represent all. */
typedef struct checked_texels {
    size_t n, width;                 /* width: of the texture */
    size_t at[MAX_CHECKED_TEXELS];   /* row by row */
    char *specs[MAX_CHECKED_TEXELS]; /* nqm_free() */
} checked_texels;
nqm_status choose_checked_texels(const nqm_texture *texture, checked_texels *texels, nqm_error *err);
/** Remarks on maps: those that are constant, and normals that lean or whose green is flipped. A new array of strings. */
nqm_status suspect_maps(const nqm_texture *texture, json_t **remarks_ret, nqm_error *err);

#endif
