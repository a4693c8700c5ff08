#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm conform with an HLSL shader: glslangValidator compiles the kits of all models. That of one is evaluated in a headless browser, through
# spirv-cross: its diffuse part lacks 1 / pi. Skipped without these programs, and under sanitizers.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
examples=$NQM_SOURCE/examples/conform keys=base_color,metallic,roughness
[ -z "${NQM_SANITIZE:-}" ] || exit 77
command -v glslangValidator >/dev/null || exit 77
cd "$dir"

# compile STAGE ENTRY FILE.hlsl: to shader.spv.
compile() { glslangValidator -D -S "$1" -e "$2" -V "$3" -o shader.spv >err 2>&1 || fail "$3 does not compile"; }

models=$("$tool" conform --help | sed -n "/the same as/d; s/^  \([a-z-]*\) \[VALUES\].*/\1/p")
[ "$(echo "$models" | wc -l)" -ge 9 ] || fail "models: $models"
for model in $models; do
    run 0 conform "$model" --shader kit.hlsl
    { cat kit.hlsl && echo 'float3 nqm_brdf(nqm_set m, float3 light, float3 viewer) { return light * viewer.z; }'; } >"$model.hlsl"
    compile comp nqm_main "$model.hlsl"
done

# The compute shader as it is; for the browser, its kernel is called for each texel.
run 0 conform gltf --keys $keys --shader kit.hlsl
cat kit.hlsl "$examples/shader.hlsl" >whole.hlsl
compile comp nqm_main whole.hlsl
command -v spirv-cross >/dev/null || skip_rest conform_hlsl_values
command -v chromium >/dev/null || command -v chromium-browser >/dev/null || command -v google-chrome >/dev/null || skip_rest conform_hlsl_values
# values_of SHADER.hlsl: to values.npy
values_of() {
    {
        sed -e 's/^RWStructuredBuffer.*/static float3 nqm_result;/' -e 's/nqm_values\[id.x\] =/nqm_result =/' -e 's/^\[numthreads([^)]*)\] //' \
            -e 's/ : SV_DispatchThreadID//' kit.hlsl
        cat "$1"
        echo 'float4 nqm_draw(float4 at : SV_Position) : SV_Target {
            nqm_main(uint3(uint(at.y) * nqm_n_directions + uint(at.x), 0, 0));
            return float4(nqm_result, 1.0);
        }'
    } >draw.hlsl
    compile frag nqm_draw draw.hlsl
    spirv-cross shader.spv --version 300 --es --output draw.glsl
    sed -n 's/^static \(const int nqm_n_sets = .*\)/\1/p' kit.hlsl >size.glsl
    sed -e '/^#version/d' -e '/^precision/d' draw.glsl >shader.glsl
    sh "$examples/run_glsl.sh" size.glsl shader.glsl values.npy 2>err && return
    grep -q 'no WebGL 2' err && skip_rest conform_hlsl_values
    fail "the browser evaluates nothing"
}
values_of "$examples/shader.hlsl"
run 1 conform gltf values.npy --keys $keys
grep -q '^Likely mistake: the diffuse part lacks 1 / pi' out || fail "another mistake: $(cat out)"
# Without the mistake, a shader in float32 passes.
sed 's/m.base_color + fresnel/m.base_color \/ pi + fresnel/' "$examples/shader.hlsl" >right.hlsl
values_of right.hlsl
run 0 conform gltf values.npy --keys $keys --fail-under 9.99
