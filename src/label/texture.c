/* SPDX-License-Identifier: MIT
 *
 * Pictures of textured materials, from which labels are made as from those of a BRDF.
 */
#include "texture/texture.h"
#include "label/textured.h"
#include "render/render.h"

#include <math.h>

nqm_texture_view nqm_scene_texture_view_default(void) {
    return (nqm_texture_view){.tiles = 1, .n_samples = 4, .seed = 1};
}

typedef struct shown {
    const nqm_texture *texture;
    double tiles, size[2]; /* texels between the coordinates 0 and 1 */
} shown;

/* The centre of the nearest texel: between centres, interpolated properties would vary less than the texels do. */
static nqm_status open_texel(void *user, const double uv[2], nqm_brdf **brdf_ret, double normal[3], nqm_error *err) {
    const shown *s = user;
    double at[2];
    for (size_t k = 0; k < 2; ++k)
        at[k] = (floor(uv[k] * s->tiles * s->size[k]) + 0.5) / s->size[k];
    return nqm_texture_at(s->texture, at[0] - floor(at[0]), at[1] - floor(at[1]), brdf_ret, normal, err);
}

nqm_status nqm_scene_render_texture(const nqm_scene *scene, const nqm_texture *texture, const nqm_texture_view *view,
                                    double *rgb_cdm2, nqm_error *err) {
    NQM_REQUIRE(err, scene, texture, rgb_cdm2);
    const nqm_texture_view v = view ? *view : nqm_scene_texture_view_default();
    if (!(v.tiles > 0 && v.tiles <= 1e6) || v.n_samples < 1 || v.n_samples > 4096)
        return nqm_fail(err, NQM_ERR_ARG, -1, "texture: tiles %g must be in (0, 10^6], samples %zu in [1, 4096]",
                        v.tiles, v.n_samples);
    shown s = {.texture = texture, .tiles = v.tiles};
    for (size_t k = 0; k < 2; ++k) {
        size_t n_texels; /* of each of the equal parts into which both textures divide this axis */
        const size_t n_parts = nqm_texture_tiles(texture, v.beside ? v.beside : texture, k, &n_texels);
        s.size[k] = (double)(n_parts * n_texels);
    }
    const nqm_scene_surfaces surfaces = {v.n_samples, v.seed, open_texel, &s};
    return nqm_scene_render_each(scene, &surfaces, rgb_cdm2, err);
}
