/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: glTF materials as JSON, the same bytes as the JSON of a binary file, and binary files with a damaged header.
 * Accepted specs must parse; refusals and errors must have a byte of the file. Images in the file itself must be inside of it, and nodes
 * must use earlier ones.
 */
#include "base/base.h"
#include "fuzz.h"
#include "material/maps.h"

static void check_maps(const nqm_textured *t, const nqm_map *map) {
    for (size_t i = 0; i < t->n_images; ++i) {
        const nqm_map_image *image = &t->images[i];
        must(image->name && !image->path == (image->data != NULL));
        if (image->path && image->n_bytes && strcmp(image->path, map->path) == 0)
            must(image->at <= map->n_bytes && image->n_bytes <= map->n_bytes - image->at);
    }
    for (size_t i = 0; i < t->n_outputs; ++i)
        must(t->outputs[i].node < t->n_nodes);
    for (size_t i = 0; i < t->n_nodes; ++i)
        must(t->nodes[i].op != NQM_MAP_IMAGE || t->nodes[i].image < t->n_images);
    must(t->normal == NQM_NO_NODE || t->normal < t->n_nodes);
}

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
        nqm_values values;
        nqm_error fault; /* of a value beyond its range */
        must(info.name && info.surface && !info.spec == (info.refusal != NULL));
        must(info.byte_offset >= 0 && (size_t)info.byte_offset < n_bytes);
        if (nqm_materials_maps(materials, i, 0))
            check_maps(nqm_materials_maps(materials, i, 0), &map);
        must(!info.spec ||
             (nqm_values_parse_spec(info.spec, &values, &fault) == NQM_OK || strstr(fault.message, " needs ")));
    }
    nqm_materials_free(materials);
}

static int run_one(const uint8_t *data, size_t n_bytes) {
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

static blob make_seed(void) {
    static const char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":[],\"materials\":[{\"name\":\"a\",\"alphaMode\":"
        "\"MASK\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,5e-1,0,1],\"metallicFactor\":0,\"roughnessFactor\":"
        "0.25},\"extensions\":{\"KHR_materials_ior\":{\"ior\":1.4},\"KHR_materials_sheen\":{\"sheenColorFactor\":"
        "[1,1,0],\"sheenRoughnessFactor\":0.3}}},{\"emissiveFactor\":[0,0,0],\"normalTexture\":{\"index\":0,\"scale\":"
        "2}},"
        "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":1,\"extensions\":{\"KHR_texture_transform\":"
        "{\"offset\":[0,1],\"rotation\":1}}},\"metallicRoughnessTexture\":{\"index\":2}}}],\"textures\":[{\"source\":0}"
        ","
        "{\"source\":1,\"sampler\":0},{\"source\":2}],\"samplers\":[{\"wrapS\":33071}],\"images\":[{\"uri\":\"a%20."
        "png\"},"
        "{\"uri\":\"data:image/"
        "png;base64,MDEyMzQ1\"},{\"bufferView\":0}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":2,"
        "\"byteOffset\":1}],\"buffers\":[{\"byteLength\":3,\"uri\":\"data:;base64,MDEy\"}]}";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
