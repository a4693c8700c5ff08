# SPDX-License-Identifier: MIT
"""Write the materials of a Blender file whose surface is a Principled BSDF (Blender 4.0 and later), for nqm:

    blender -b scene.blend -P blender.py -- materials.json
    nqm info materials.json
    nqm score materials.json:Gold gltf:base_color=1,.77,.34

Inputs that an image texture feeds directly become bitmaps; other links are named, and nqm refuses them."""
import json
import sys

import bpy


def value_of(socket):
    if not socket.is_linked:
        value = socket.default_value
        return {"type": "rgb", "value": list(value)[:3]} if hasattr(value, "__len__") else float(value)
    node = socket.links[0].from_node
    if node.type == "TEX_IMAGE" and node.image and not node.inputs["Vector"].is_linked:
        return {"type": "bitmap", "filename": bpy.path.abspath(node.image.filepath),
                "raw": node.image.colorspace_settings.name == "Non-Color"}
    return {"type": "node " + node.type}


def shader_of(material):
    output = material.node_tree and material.node_tree.get_output_node("CYCLES")
    link = output and output.inputs["Surface"].is_linked and output.inputs["Surface"].links[0]
    return link and link.from_node.type == "BSDF_PRINCIPLED" and link.from_node


def main(path):
    scene = {"type": "scene"}
    for material in bpy.data.materials:
        shader = shader_of(material)
        if not shader:
            continue
        entry = scene[material.name] = {"type": "blender-principled",
                                        "multiscatter": float(shader.distribution == "MULTI_GGX")}
        for socket in shader.inputs:
            is_vector = socket.type == "VECTOR" and "Radius" not in socket.name
            if socket.type in ("VALUE", "RGBA", "VECTOR") and (socket.is_linked or not is_vector) and socket.name != "Weight":
                entry[socket.name.lower().replace(" ", "_")] = value_of(socket)
    with open(path, "w") as file:
        json.dump(scene, file, indent=1)


main(sys.argv[sys.argv.index("--") + 1])
