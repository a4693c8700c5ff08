#!/bin/sh
# SPDX-License-Identifier: MIT
# nqm translate: what fits under its visual loss reach: starts, anisotropy, lobes that are measured, thin films.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"

# The fit begins at the keys that both models have: without that start this is JOD 9.96.
layers='open-pbr:base_color=0.26,0.67,0.78;specular_roughness=0.78;coat_weight=0.54;coat_roughness=0.43;coat_color=0.7,0.67,0.59;fuzz_weight=0.22;fuzz_roughness=0.4;base_metalness=0.92'
"$tool" translate "$layers" --to openpbr --samples 200 >"$dir/out"
grep -q '^JOD 10.00' "$dir/out" || fail "the start: $(cat "$dir/out")"

# Anisotropy keeps its widths and direction, in the keys of the target.
brushed='standard-surface:metalness=1;specular_roughness=.4;specular_anisotropy=.6;specular_rotation=.25'
"$tool" translate "$brushed" --to gltf --samples 200 -o "$dir/brushed.gltf" >"$dir/out"
grep -q '"anisotropyStrength": 0.41095' "$dir/brushed.gltf" || fail "strength: $(cat "$dir/brushed.gltf")"
grep -q '"anisotropyRotation": -1.5708' "$dir/brushed.gltf" || fail "rotation: $(cat "$dir/brushed.gltf")"
for pair in rough-conductor=alpha=0.1,0.3 pbrt-conductor=roughness=0.00999; do
    "$tool" translate 'rough-conductor:alpha=.1,.3;distribution=1' --to ${pair%%=*} --samples 200 >"$dir/out"
    grep -q "JOD *10.00.*-> ${pair%%=*}:${pair#*=}" "$dir/out" || fail "${pair%%=*}: $(cat "$dir/out")"
done
# The wider direction of this one is across the tangent, where OpenPBR cannot have it.
"$tool" translate 'rough-conductor:alpha=.1,.3;distribution=1' --to open-pbr --samples 200 >"$dir/out"
grep -q anisotropy "$dir/out" && fail "anisotropy in the wrong direction: $(cat "$dir/out")"
# A lobe without such keys is measured.
"$tool" translate 'rotate:deg=30;of=ggx:kd=.1;ks=.3;alpha=.4,.1;f0=.5' --to blender --samples 500 -o "$dir/turned.json" >"$dir/out"
grep -q '^JOD *\(10.00\|9.9\)' "$dir/out" || fail "a measured lobe: $(cat "$dir/out")"
grep -q '"anisotropic_rotation": 0.08' "$dir/turned.json" || fail "its azimuth: $(cat "$dir/turned.json")"
# A model without anisotropy is not worse by a fit than by the keys.
"$tool" translate 'open-pbr:base_color=.912,.914,.92;base_metalness=1;specular_roughness=.2;specular_roughness_anisotropy=.9' --to usd --samples 500 >"$dir/out"
grep -q '^JOD *8.[3-9]' "$dir/out" || fail "brushed metal without anisotropy: $(cat "$dir/out")"

# Thin films are copied, in nm.
"$tool" translate 'open-pbr:base_metalness=1;thin_film_weight=.5;thin_film_thickness=.3;thin_film_ior=1.8' --to gltf --samples 200 >"$dir/out"
grep -q 'iridescence=0.5;iridescence_ior=1.8;iridescence_thickness=300' "$dir/out" || fail "a thin film: $(cat "$dir/out")"
