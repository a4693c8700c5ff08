// SPDX-License-Identifier: MIT
// A metallic-roughness shader of glTF in HLSL, for `nqm conform`; it has one mistake (doc/conform.md).
//   nqm conform gltf --keys base_color,metallic,roughness --shader kit.hlsl
//   cat kit.hlsl examples/conform/shader.hlsl >shader.hlsl
//   glslangValidator -D -S comp -e nqm_main -V shader.hlsl -o shader.spv
float visibility(float n_a, float n_b, float a2) {
    return n_a * sqrt(n_b * n_b * (1.0 - a2) + a2);
}

float3 nqm_brdf(nqm_set m, float3 light, float3 viewer) {
    const float pi = 3.14159265;
    float alpha = m.roughness * m.roughness, a2 = alpha * alpha;
    float3 h = normalize(light + viewer);
    float f = h.z * h.z * (a2 - 1.0) + 1.0, d = a2 / (pi * f * f);
    float v = 0.5 / (visibility(light.z, viewer.z, a2) + visibility(viewer.z, light.z, a2));
    float rise = pow(1.0 - min(dot(viewer, h), 1.0), 5.0), fresnel = 0.04 + 0.96 * rise;
    float3 plain = (1.0 - fresnel) * m.base_color + fresnel * d * v;
    float3 metal = lerp(m.base_color, float3(1.0, 1.0, 1.0), rise) * d * v;
    return lerp(plain, metal, m.metallic);
}
