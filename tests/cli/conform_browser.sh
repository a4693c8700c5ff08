#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm conform with a GLSL shader, which a headless browser evaluates: the Fresnel factor has the angle of normal and viewer. Skipped
# without Chromium, and under sanitizers.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
examples=$NQM_SOURCE/examples/conform keys=base_color,metallic,roughness
[ -z "${NQM_SANITIZE:-}" ] || exit 77
command -v chromium >/dev/null || command -v chromium-browser >/dev/null || command -v google-chrome >/dev/null || exit 77
cd "$dir"
"$tool" conform gltf --keys $keys --shader kit.glsl 2>err
sh "$examples/run_glsl.sh" kit.glsl "$examples/shader.glsl" values.npy 2>err || {
    grep -q 'no WebGL 2' err && exit 77
    fail "the browser evaluates nothing"
}
run 1 conform gltf values.npy --keys $keys
grep -q '^Likely mistake: the Fresnel factor has the angle of normal and viewer' out || fail "another mistake: $(cat out)"
# Without the mistake, a shader in float32 passes.
sed 's/pow(1.0 - viewer.z, 5.0)/pow(1.0 - min(dot(viewer, h), 1.0), 5.0)/' "$examples/shader.glsl" >right.glsl
sh "$examples/run_glsl.sh" kit.glsl right.glsl values.npy 2>err || fail "the browser evaluates nothing"
run 0 conform gltf values.npy --keys $keys --fail-under 9.99
# A shader that does not compile says so.
echo 'vec3 nqm_brdf(nqm_set m, vec3 light, vec3 viewer) { return nothing; }' >bad.glsl
! sh "$examples/run_glsl.sh" kit.glsl bad.glsl values.npy 2>err || fail "a shader with a fault has values"
grep -q "nothing" err || fail "the fault is not told"
