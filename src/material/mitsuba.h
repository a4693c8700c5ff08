/* SPDX-License-Identifier: MIT
 *
 * mitsuba.h - the BSDFs of a Mitsuba 3 scene, read from XML or from a JSON dictionary into one list of nodes, and their translation
 * to shadings.
 */
#ifndef NQM_SRC_MATERIAL_MITSUBA_H
#define NQM_SRC_MATERIAL_MITSUBA_H

#include "material/bsdf.h"

/** true when Mitsuba has a BSDF plugin of this name. */
bool nqm_mitsuba_is_bsdf(const char *type);
/** The plugin of a shading model, or NULL. */
const char *nqm_mitsuba_type_of(const char *model);
/** Append a material for each BSDF that is not inside of another one. path: of the scene. */
NQM_MUST_CHECK nqm_status nqm_mitsuba_translate(const nqm_bsdf_nodes *nodes, const char *path, nqm_materials *materials,
                                                nqm_error *err);

/** Write the BSDF as a JSON dictionary or as XML. */
nqm_status nqm_mitsuba_write(size_t n, const nqm_written_material *materials, const char *path, FILE *stream,
                             nqm_error *err);

#endif
