/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: MaterialX documents. Accepted specs must parse; refusals and errors must have a byte of the file.
 */
#include "fuzz.h"
#include "material/material.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    const nqm_map map = {.data = data, .n_bytes = n_bytes, .path = "fuzz.mtlx"};
    nqm_materials *materials = NULL;
    nqm_error err = {0};
    if (!nqm_materialx_format.probe(&map))
        return 0;
    if (nqm_materials_read(&map, &materials, &err) != NQM_OK) {
        must(!materials && err.message[0] && err.byte_offset >= 0 && (size_t)err.byte_offset <= n_bytes);
        return 0;
    }
    for (size_t i = 0; i < nqm_materials_count(materials); ++i) {
        const nqm_material_info info = nqm_materials_get(materials, i);
        nqm_shading shading;
        must(info.name && info.surface && !info.spec == (info.refusal != NULL));
        must(info.byte_offset >= 0 && (size_t)info.byte_offset < n_bytes);
        must(!info.spec || nqm_shading_parse(info.spec, &shading, NULL) == NQM_OK);
    }
    nqm_materials_free(materials);
    fuzz_brdf(data, n_bytes, n_bytes, "");
    return 0;
}

blob fuzz_seed(void) {
    static const char text[] =
        "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\" colorspace=\"acescg\">\n"
        "<nodegraph name=\"g\"><input name=\"i\" type=\"float\" value=\".5\"/><constant name=\"c\" type=\"float\">"
        "<input name=\"value\" type=\"float\" interfacename=\"i\"/></constant>"
        "<output name=\"o\" type=\"float\" nodename=\"c\"/></nodegraph>\n"
        "<open_pbr_surface name=\"s\" type=\"surfaceshader\">\n"
        "<input name=\"base_color\" type=\"color3\" value=\"0.9, 0.7, 0.4\"/>\n"
        "<input name=\"coat_weight\" type=\"float\" nodegraph=\"g\" output=\"o\"/>\n"
        "<input name=\"fuzz_weight\" type=\"float\" value=\"0.5\"/>\n"
        "<input name=\"transmission_weight\" type=\"float\" value=\"0\"/></open_pbr_surface>\n"
        "<surfacematerial name=\"m\" type=\"material\">"
        "<input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"s\"/></surfacematerial>\n</materialx>\n";
    return blob_of(sizeof text - 1, text);
}
