/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: glTF materials as JSON, the same bytes as the JSON of a binary file, and binary files with a damaged header.
 * Accepted specs must parse; refusals and errors must have a byte of the file.
 */
#include "base/base.h"
#include "fuzz.h"
#include "material/material.h"

static void read_bytes(const uint8_t *data, size_t n_bytes) {
    const nqm_map map = {.data = data, .n_bytes = n_bytes, .path = "fuzz.gltf"};
    nqm_materials *materials = NULL;
    nqm_error err = {0};
    if (!nqm_gltf_format.probe(&map))
        return;
    if (nqm_materials_read(&map, &materials, &err) != NQM_OK) {
        must(!materials && err.message[0] && err.byte_offset >= 0 && (size_t)err.byte_offset <= n_bytes);
        return;
    }
    for (size_t i = 0; i < nqm_materials_count(materials); ++i) {
        const nqm_material_info info = nqm_materials_get(materials, i);
        nqm_shading shading;
        must(info.name && info.surface && !info.spec == (info.refusal != NULL));
        must(info.byte_offset >= 0 && (size_t)info.byte_offset < n_bytes);
        must(!info.spec || nqm_shading_parse(info.spec, &shading, NULL) == NQM_OK);
    }
    nqm_materials_free(materials);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n_bytes) {
    enum { HEADER = 20 };
    blob glb = {.data = malloc(HEADER + n_bytes), .n_bytes = HEADER + n_bytes};
    must(glb.data != NULL);
    memcpy(glb.data, "glTF\2\0\0\0....", 12);
    nqm_store_u32(glb.data + 8, (uint32_t)glb.n_bytes);
    nqm_store_u32(glb.data + 12, (uint32_t)n_bytes);
    memcpy(glb.data + 16, "JSON", 4);
    memcpy(glb.data + HEADER, data, n_bytes);
    read_bytes(data, n_bytes);
    read_bytes(glb.data, glb.n_bytes);
    memcpy(glb.data + 4, data, n_bytes < 16 ? n_bytes : 16);
    read_bytes(glb.data, glb.n_bytes);
    free(glb.data);
    return 0;
}

blob fuzz_seed(void) {
    static const char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":[],\"materials\":[{\"name\":\"a\",\"alphaMode\":"
        "\"MASK\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,5e-1,0,1],\"metallicFactor\":0,\"roughnessFactor\":"
        "0.25},\"extensions\":{\"KHR_materials_ior\":{\"ior\":1.4},\"KHR_materials_sheen\":{\"sheenColorFactor\":"
        "[1,1,0],\"sheenRoughnessFactor\":0.3}}},{\"emissiveFactor\":[0,0,0],\"normalTexture\":{\"index\":0}}]}";
    return blob_of(sizeof text - 1, text);
}
