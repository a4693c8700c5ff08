#!/bin/sh
# SPDX-License-Identifier: MIT
# studies/translation_graphs.py: a graph of our own with values computed by hand, and, with the shared data, a published one.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
command -v python3 >/dev/null || exit 77

# translate DEFINITIONS MATERIAL TARGET: the spec goes to out.
translate() { python3 "$NQM_SOURCE/studies/translation_graphs.py" "$@" >"$dir/out" 2>"$dir/err"; }
# has KEY=VALUE: of the spec in out.
has() { tr ':;' '[\n*]' <"$dir/out" | grep -qx "$1" || fail "no $1 in $(cat "$dir/out")"; }

cat >"$dir/standard_surface_to_usd.mtlx" <<'END'
<materialx version="1.39">
  <nodedef name="ND" node="n">
    <input name="base_color" type="color3" value="0.5, 0.5, 0.5"/>
    <input name="metalness" type="float" value="0"/>
    <input name="specular_roughness" type="float" value="0.1"/>
    <input name="coat" type="float" value="0"/>
    <input name="normal" type="vector3" defaultgeomprop="Nworld"/>
  </nodedef>
  <nodegraph name="NG" nodedef="ND">
    <power name="squared" type="color3">
      <input name="in1" type="color3" interfacename="base_color"/>
      <input name="in2" type="float" value="2"/>
    </power>
    <mix name="mixed" type="color3">
      <input name="fg" type="color3" nodename="squared"/>
      <input name="bg" type="color3" value="0.2, 0.4, 0.6"/>
      <input name="mix" type="float" interfacename="metalness"/>
    </mix>
    <divide name="infinite" type="float">
      <input name="in1" type="float" value="1"/>
      <input name="in2" type="float" interfacename="metalness"/>
    </divide>
    <ifgreater name="chosen" type="float">
      <input name="value1" type="float" interfacename="metalness"/>
      <input name="value2" type="float" value="0"/>
      <input name="in1" type="float" nodename="infinite"/>
      <input name="in2" type="float" interfacename="specular_roughness"/>
    </ifgreater>
    <roughness_anisotropy name="both" type="vector2">
      <input name="roughness" type="float" nodename="chosen"/>
      <input name="anisotropy" type="float" value="0.75"/>
    </roughness_anisotropy>
    <separate2 name="parts" type="multioutput"><input name="in" type="vector2" nodename="both"/></separate2>
    <add name="sum" type="float">
      <input name="in1" type="float" nodename="parts" output="outx"/>
      <input name="in2" type="float" nodename="parts" output="outy"/>
    </add>
    <luminance name="grey" type="color3"><input name="in" type="color3" value="1, 1, 1"/></luminance>
    <extract name="coat_out_of_range" type="float">
      <input name="in" type="color3" nodename="grey"/>
      <input name="index" type="integer" value="2"/>
    </extract>
    <add name="too_much" type="float">
      <input name="in1" type="float" nodename="coat_out_of_range"/>
      <input name="in2" type="float" interfacename="coat"/>
    </add>
    <invert name="less" type="float"><input name="in" type="float" interfacename="coat"/></invert>
    <dot name="normal" type="vector3"><input name="in" type="vector3" interfacename="normal"/></dot>
    <output name="diffuseColor_out" type="color3" nodename="mixed"/>
    <output name="roughness_out" type="float" nodename="sum"/>
    <output name="clearcoat_out" type="float" nodename="too_much"/>
    <output name="clearcoatRoughness_out" type="float" nodename="less"/>
    <output name="normal_out" type="vector3" nodename="normal"/>
  </nodegraph>
</materialx>
END
translate "$dir" "standard-surface:base_color=.5,.25,1;specular_roughness=.5;coat=.25" usd-preview || fail "no translation"
has usd-preview
has diffuseColor=0.2,0.4,0.6
# 0.5 squared is 0.25; the square root of 1 - 0.75 is 0.5: 0.5 and 0.125
has roughness=0.625
has clearcoat=1
has clearcoatRoughness=0.75
has ior=1.5
grep -q "clearcoat = (1.25,) becomes" "$dir/err" || fail "no note"
translate "$dir" "standard-surface:base_color=.5,.25,1;metalness=1" usd-preview || fail "no translation of a metal"
has diffuseColor=0.25,0.0625,1

translate "$dir" gltf: usd-preview && fail "a translation from glTF"
grep -q "no published translation from gltf to usd-preview" "$dir/err" || fail "no message"
sed 's/invert/unheard/g' "$dir/standard_surface_to_usd.mtlx" >"$dir/s" && mv "$dir/s" "$dir/standard_surface_to_usd.mtlx"
translate "$dir" standard-surface: usd-preview && fail "an unknown node"
grep -q "the node unheard is not known" "$dir/err" || fail "no message"

# Published: coat_color tints the base, and its mean scales the clear coat; sheen_roughness becomes its square root.
published=${NQM_DATA:-$NQM_SOURCE/../shared/data}/materials/definitions
[ -f "$published/standard_surface_to_gltf_pbr.mtlx" ] || skip_rest published_translation_graphs
translate "$published" "standard-surface:coat=1;coat_color=.5,.25,.75;base_color=.8,.4,.2;sheen=.5;sheen_roughness=.25" gltf || fail "$published"
has base_color=0.4,0.1,0.15000000000000002
has clearcoat=0.5
has sheen_color=0.5
has sheen_roughness=0.5
translate "$published" "open-pbr:base_color=.5;specular_roughness=.25" usd-preview || fail "two steps"
has diffuseColor=0.5
has roughness=0.25
