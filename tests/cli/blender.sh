#!/bin/sh
# SPDX-License-Identifier: MIT
# doc/blender.py: what Blender imports, it exports again with the same values, and what it cannot use is named. Needs Blender 4.
# shellcheck source=tests/support/cli.sh
. "${NQM_SOURCE:?}/tests/support/cli.sh"
version=$(blender --version 2>/dev/null | sed -n 's/^Blender \([0-9]*\).*/\1/p')
[ "${version:-0}" -ge 4 ] || {
    echo "needs Blender 4.0 or later (Debian 13: blender), found ${version:-none}"
    exit 77
}
script=$NQM_SOURCE/doc/blender.py
python3 "$NQM_SOURCE/examples/maps.py" "$dir" 8
cd "$dir"

# there_and_back NAME: import NAME.json, and export it to NAME-back.json.
there_and_back() {
    blender -b -P "$script" -- --import "$1.json" "$1.blend" >log 2>err || fail "import: $(cat log)"
    [ -s "$1.blend" ] || fail "no $1.blend: $(cat log)"
    blender -b "$1.blend" -P "$script" -- "$1-back.json" >log 2>>err || fail "export: $(cat log)"
}

# What translate writes.
run 0 translate 'open-pbr:base_color=.8,.3,.1;coat_weight=1;coat_roughness=.2' --to blender -o coat.json --samples 200 --loss log
there_and_back coat
! grep -q 'not used\|here, not' err || fail "lost"
run 0 score -q coat.json coat-back.json
[ "$(cat out)" = 10.0000 ] || fail "another material: $(cat out)"

# Every kind of value.
cat >all.json <<'END'
{"type": "scene",
 "plain": {"type": "blender-principled", "multiscatter": 0.0, "base_color": {"type": "rgb", "value": [0.59843, 0.1372, 0.039561]}, "metallic": 0.3,
  "roughness": 0.25527, "ior": 1.0445, "diffuse_roughness": 0.125, "specular_ior_level": 0.7, "specular_tint": {"type": "rgb", "value": [0.9, 0.7, 1.0]},
  "anisotropic": 0.7, "anisotropic_rotation": 0.1, "coat_weight": 1.0, "coat_roughness": 0.05, "coat_ior": 1.5998, "coat_tint": {"type": "rgb",
  "value": [0.1, 0.2, 0.3]}, "sheen_weight": 0.2, "sheen_roughness": 0.6, "sheen_tint": {"type": "rgb", "value": [1.0, 0.5, 0.25]},
  "thin_film_thickness": 450.0, "thin_film_ior": 1.7, "transmission_weight": 0.1, "subsurface_weight": 0.2, "emission_strength": 2.0, "alpha": 0.5},
 "few": {"type": "blender-principled"},
 "maps": {"type": "normalmap", "normalmap": {"type": "bitmap", "filename": "steel/steel_NormalGL.png", "raw": true, "to_uv": [2.0, 0.0, 0.25, 0.0, 3.0, 0.5, 0, 0, 1]},
  "bsdf": {"type": "blender-principled", "base_color": {"type": "bitmap", "filename": "steel/steel_Color.png", "raw": false,
    "to_uv": [2.0, 0.0, 0.25, 0.0, 3.0, 0.5, 0, 0, 1]},
   "roughness": {"type": "bitmap", "filename": "steel/steel_Color.png", "raw": true, "wrap_mode": "mirror", "channel": "g"},
   "metallic": {"type": "bitmap", "filename": "steel/steel_Color.png", "raw": true, "wrap_mode": "mirror", "channel": "b"},
   "sheen_weight": {"type": "bitmap", "filename": "steel/steel_Roughness.png", "raw": true, "wrap_mode": "clamp"},
   "coat_weight": {"type": "bitmap", "filename": "steel/steel_Color.png", "raw": true, "channel": "a"}}}}
END
there_and_back all
! grep -q 'not used\|here, not' err || fail "lost"
cat >compare.py <<'END'
import json
import sys


def compare(given, found, path):
    for key, value in given.items():
        if isinstance(value, dict):
            compare(value, found.get(key, {}), f"{path}/{key}")
        elif found.get(key) != value:
            sys.exit(f"{path}/{key} was {value}, is {found.get(key)}")


given, found = (json.load(open(name)) for name in sys.argv[1:])
compare(given, found, "")
if set(given) != set(found):
    sys.exit(f"{sorted(found)}")
END
python3 compare.py all.json all-back.json || fail "another value"
cp all-back.json again.json
there_and_back again
cmp all-back.json again-back.json || fail "other bytes"

# A turned map: the Mapping has its angle.
echo '{"type": "blender-principled", "base_color": {"type": "bitmap", "filename": "steel/steel_Color.png", "to_uv": [0, 2, 0, -1, 0, 1, 0, 0, 1]}}' >turned.json
there_and_back turned
run 0 score -q turned.json turned-back.json
[ "$(cat out)" = 10.0000 ] || fail "turned: $(cat out)"

# What is not used is named.
cat >odd.json <<'END'
{"type": "scene", "mitsuba": {"type": "diffuse", "reflectance": 0.5}, "short": 1,
 "odd": {"type": "blender-principled", "emission_color": [-1, 0, 0], "clearcoat": 1, "metallic": {"type": "bitmap", "filename": "gone.png"}, "multiscatter": {"type": "bitmap"},
  "base_color": {"type": "bitmap", "filename": "steel/steel_Color.png", "filter_type": "nearest", "to_uv": [1, 1, 0, 0, 1, 0, 0, 0, 1]},
  "coat_tint": 0.5, "sheen_weight": [1, 2, 3], "coat_weight": "much", "alpha": {"type": "bitmap", "filename": "steel/steel_Color.png", "channel": "x"}}}
END
there_and_back odd
for words in "mitsuba: not read, as it is no blender-principled but 'diffuse'" "short: not read" 'odd: emission_color is .0.0, 0.0, 0.0. here, not .-1, 0, 0.' 'odd: clearcoat is not used' \
    'odd: metallic is not used: there is no file .*gone.png' 'odd: base_color.filter_type is not used' 'odd: base_color.to_uv is not used: it shears' \
    'odd: coat_tint is not used: 0.5' 'odd: sheen_weight is not used' 'odd: coat_weight is not used: "much"' 'odd: alpha is not used' 'odd: multiscatter is 1 here'; do
    grep -q "$words" err || fail "no '$words'"
done
for name in gone bad; do
    [ $name = gone ] || echo '[1' >bad.json
    blender -b -P "$script" -- --import $name.json no.blend >log 2>err && fail "$name.json was imported"
    grep -q "^$name.json: " err && [ ! -e no.blend ] || fail "$name.json"
done

# Nodes that are not written are named in the file, and nqm refuses them.
cat >nodes.py <<'END'
import os

import bpy

bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
picture = bpy.data.images.load(os.path.abspath("steel/steel_Color.png"))


def make(name, build):
    material = bpy.data.materials.new(name)
    material.use_nodes = material.use_fake_user = True
    nodes = material.node_tree.nodes
    build(nodes, material.node_tree.links.new, next(n for n in nodes if n.type == "BSDF_PRINCIPLED"))


def image(nodes):
    node = nodes.new("ShaderNodeTexImage")
    node.image = picture
    return node


def inverted(nodes, link, shader):
    node = nodes.new("ShaderNodeInvert")
    link(image(nodes).outputs[0], node.inputs["Color"])
    link(node.outputs[0], shader.inputs["Base Color"])


def rerouted(nodes, link, shader):
    node = nodes.new("NodeReroute")
    link(image(nodes).outputs[0], node.inputs[0])
    link(node.outputs[0], shader.inputs["Base Color"])


def generated(nodes, link, shader):
    node = image(nodes)
    link(nodes.new("ShaderNodeTexCoord").outputs["Generated"], node.inputs[0])
    link(node.outputs[0], shader.inputs["Base Color"])


def weak(nodes, link, shader):
    node = nodes.new("ShaderNodeNormalMap")
    node.inputs["Strength"].default_value = .5
    link(image(nodes).outputs[0], node.inputs["Color"])
    link(node.outputs[0], shader.inputs["Normal"])


def placed(nodes, link, shader):
    node, mapping = image(nodes), nodes.new("ShaderNodeMapping")
    mapping.vector_type = "TEXTURE"
    mapping.inputs["Scale"].default_value = .5, .25, 1
    link(nodes.new("ShaderNodeTexCoord").outputs["UV"], mapping.inputs[0])
    link(mapping.outputs[0], node.inputs[0])
    link(node.outputs[0], shader.inputs["Base Color"])


def glowing(nodes, link, shader):
    link(nodes.new("ShaderNodeEmission").outputs[0], next(n for n in nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"])


for build in (inverted, rerouted, generated, weak, placed, glowing):
    make(build.__name__, build)
bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("nodes.blend"))
END
blender -b -P nodes.py >log 2>&1
blender -b nodes.blend -P "$script" -- nodes.json >log 2>err || fail "export: $(cat log)"
grep -q 'glowing: not written, as its surface is no Principled BSDF' err || fail "not named"
for pair in 'inverted:node INVERT' 'generated:node TEX_IMAGE' 'weak:normal'; do
    run 4 info "nodes.json:${pair%%:*}"
    grep -q "${pair#*:}" err || fail "${pair%%:*}: no '${pair#*:}'"
done
echo '{"type": "blender-principled", "base_color": {"type": "bitmap", "filename": "steel/steel_Color.png"}}' >plain.json
run 0 score -q plain.json nodes.json:rerouted
[ "$(cat out)" = 10.0000 ] || fail "rerouted: $(cat out)"
python3 - <<'END' || fail 'the placement of a Mapping is another'
import json
to_uv = json.load(open("nodes.json"))["placed"]["base_color"]["to_uv"]
assert to_uv == [2, 0, 0, 0, 4, -3, 0, 0, 1], to_uv
END
