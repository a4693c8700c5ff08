/* SPDX-License-Identifier: MIT
 *
 * Fuzz target: USD as text.
 */
#include "fuzz.h"

static int run_one(const uint8_t *data, size_t n_bytes) {
    fuzz_material(data, n_bytes);
    return 0;
}

static blob make_seed(void) {
    static const char text[] =
        "#usda 1.0\n( doc = \"\"\"x\"\"\" )\ndef Scope \"L\" {\n def Material \"m\" (kind = 'a') {\n  float inputs:w = "
        ".25\n"
        "  token outputs:surface.connect = </L/m/s.outputs:out>\n  def Shader \"s\" {\n"
        "   uniform token info:id = \"ND_standard_surface_surfaceshader\"\n   color3f inputs:base_color.connect = "
        "</L/m/g.outputs:c>\n   float inputs:metalness.connect = </L/m.inputs:w>\n   float inputs:coat = 1 # x\n   "
        "token "
        "outputs:out\n  }\n  def NodeGraph \"g\" {\n   color3f outputs:c.connect = </L/m/g/t.outputs:rgb>\n   def "
        "Shader "
        "\"t\" {\n    uniform token info:id = \"UsdUVTexture\"\n    asset inputs:file = @a.png@ (colorSpace = "
        "\"sRGB\")\n  "
        "  float4 inputs:scale = (1, 1, 1, 1)\n    float3 outputs:rgb\n   }\n  }\n }\n variantSet \"v\" = { \"a\" { } "
        "}\n"
        " float x.timeSamples = { 0: 1 }\n}\n";
    return blob_of(sizeof text - 1, text);
}

FUZZ_TARGET(run_one, make_seed)
