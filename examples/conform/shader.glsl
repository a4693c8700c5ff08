// SPDX-License-Identifier: MIT
// A metallic-roughness shader of glTF in GLSL, for `nqm conform`; it has one mistake (doc/conform.md).
//   nqm conform gltf --keys base_color,metallic,roughness --shader kit.glsl
//   sh examples/conform/run_glsl.sh kit.glsl examples/conform/shader.glsl values.npy
//   nqm conform gltf values.npy --keys base_color,metallic,roughness
float visibility(float n_a, float n_b, float a2) {
    return n_a * sqrt(n_b * n_b * (1.0 - a2) + a2);
}

vec3 nqm_brdf(nqm_set m, vec3 light, vec3 viewer) {
    const float pi = 3.14159265;
    float alpha = m.roughness * m.roughness, a2 = alpha * alpha;
    vec3 h = normalize(light + viewer);
    float f = h.z * h.z * (a2 - 1.0) + 1.0, d = a2 / (pi * f * f);
    float v = 0.5 / (visibility(light.z, viewer.z, a2) + visibility(viewer.z, light.z, a2));
    float rise = pow(1.0 - viewer.z, 5.0), fresnel = 0.04 + 0.96 * rise;
    vec3 plain = (1.0 - fresnel) * m.base_color / pi + fresnel * d * v;
    vec3 metal = mix(m.base_color, vec3(1.0), rise) * d * v;
    return mix(plain, metal, m.metallic);
}
