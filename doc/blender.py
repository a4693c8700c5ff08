# SPDX-License-Identifier: MIT
"""Materials of Blender (4.0 and later) for nqm, and back:

    blender -b scene.blend -P blender.py -- materials.json
    nqm score materials.json:Gold gltf:base_color=1,.77,.34

    nqm translate gold.mtlx --to blender -o materials.json
    blender -b [scene.blend] -P blender.py -- --import materials.json out.blend

The first writes the materials whose surface is a Principled BSDF; the last adds materials to a scene, or to an empty one. Run in Blender's
text editor, this asks for a file to import. Image textures are bitmaps, also one channel of them, with a Mapping, or as a Normal Map; other
links are named in the file, and nqm refuses them. What is lost otherwise is told on standard error."""
import json
import math
import os
import sys

import bpy
import numpy
from bpy_extras.io_utils import ImportHelper
from mathutils import Euler, Matrix

CHANNELS = {"Red": "r", "Green": "g", "Blue": "b", "Alpha": "a"}
WRAPS = {"REPEAT": "repeat", "MIRROR": "mirror", "EXTEND": "clamp"}
FLOATS = (".exr", ".hdr", ".pfm")  # linear without "raw"
remarks = []


def tell(name, text):
    remarks.append(f"{name}: {text}")
    print(remarks[-1], file=sys.stderr)


def numbers_of(value):
    """A number or colour of single precision with the fewest digits that give it."""
    numbers = [float(str(numpy.float32(v))) for v in (value if hasattr(value, "__len__") else [value])][:3]
    return numbers if hasattr(value, "__len__") else numbers[0]


def are_numbers(values, n):
    return isinstance(values, list) and len(values) == n and all(isinstance(v, (int, float)) for v in values)


# ---- export ----


def source(socket):
    """The output that feeds an input, or None."""
    while socket.is_linked:
        output = socket.links[0].from_socket
        if output.node.type != "REROUTE":
            return output
        socket = output.node.inputs[0]
    return None


def turned_over(m):
    """A transform (2, 3) of texture coordinates whose v points down, from one whose v points up, and back."""
    return [[m[0][0], -m[0][1], m[0][2] + m[0][1]], [-m[1][0], m[1][1], 1 - m[1][1] - m[1][2]]]


def placement_of(image):
    """The members of a bitmap that place an image node; None: its coordinates are others than those of the surface."""
    output, members = source(image.inputs["Vector"]), {}
    if image.extension not in WRAPS or image.projection != "FLAT":
        return None
    if image.extension != "REPEAT":
        members["wrap_mode"] = WRAPS[image.extension]
    if output and output.node.type == "MAPPING":
        place, rotate, scale = (output.node.inputs[name] for name in ("Location", "Rotation", "Scale"))
        if place.is_linked or rotate.is_linked or scale.is_linked or output.node.vector_type not in ("POINT", "TEXTURE"):
            return None
        m = Matrix.LocRotScale(place.default_value, Euler(rotate.default_value), scale.default_value)
        m = m if output.node.vector_type == "POINT" else m.inverted_safe()
        rows = turned_over([[row[0], row[1], row[3]] for row in m])
        members["to_uv"] = [*(numbers_of(rows[0]) + numbers_of(rows[1])), 0, 0, 1]
        output = source(output.node.inputs["Vector"])
        if not output:
            return None
    is_uv = not output or output.node.type == "UVMAP" or (output.node.type == "TEX_COORD" and output.name == "UV")
    return members if is_uv else None


def value_of(output, folder):
    """What feeds an input: a bitmap, or the name of the node, which nqm refuses."""
    other, channel = {"type": "node " + output.node.type}, None
    if output.node.type == "SEPARATE_COLOR" and output.node.mode == "RGB" and source(output.node.inputs[0]):
        channel, output = CHANNELS[output.name], source(output.node.inputs[0])
    if output.node.type != "TEX_IMAGE" or not output.node.image or output.node.image.source != "FILE":
        return other
    channel = "a" if output.name == "Alpha" else channel
    members, path = placement_of(output.node), bpy.path.abspath(output.node.image.filepath)
    space = output.node.image.colorspace_settings.name
    is_linear = space.startswith("Linear Rec.709")
    if members is None or not (is_linear or space in ("sRGB", "Non-Color", "Raw")):
        return other
    inside = os.path.relpath(path, folder)
    bitmap = {"type": "bitmap", "filename": path if inside.startswith("..") else inside,
              "raw": space in ("Non-Color", "Raw") or (is_linear and not path.lower().endswith(FLOATS)), **members}
    return {**bitmap, "channel": channel} if channel else bitmap


def entry_of(shader, folder):
    entry = {"type": "blender-principled", "multiscatter": float(shader.distribution == "MULTI_GGX")}
    for socket in shader.inputs:
        output, key = source(socket), socket.name.lower().replace(" ", "_")
        if socket.name == "Tangent" and output and output.node.type == "TANGENT" and output.node.direction_type == "UV_MAP":
            continue
        if output:
            entry[key] = value_of(output, folder)
        elif socket.type == "RGBA" or "Radius" in socket.name:
            entry[key] = {"type": "rgb", "value": numbers_of(socket.default_value)}
        elif socket.type == "VALUE" and socket.name != "Weight":
            entry[key] = numbers_of(socket.default_value)
    normal = source(shader.inputs["Normal"])
    if normal and normal.node.type == "NORMAL_MAP" and normal.node.space == "TANGENT" and source(normal.node.inputs["Color"]):
        strength = normal.node.inputs["Strength"]
        bitmap = value_of(source(normal.node.inputs["Color"]), folder)
        if bitmap["type"] == "bitmap" and not strength.is_linked and strength.default_value == 1:
            del entry["normal"]
            return {"type": "normalmap", "normalmap": bitmap, "bsdf": entry}
    return entry


def export_file(path):
    scene = {"type": "scene"}
    for material in bpy.data.materials:
        if material.is_grease_pencil:
            continue
        output = material.use_nodes and material.node_tree.get_output_node("CYCLES")
        shader = output and source(output.inputs["Surface"])
        if not shader or shader.node.type != "BSDF_PRINCIPLED":
            tell(material.name, "not written, as its surface is no Principled BSDF")
            continue
        scene[material.name] = entry_of(shader.node, os.path.dirname(os.path.abspath(path)))
        for name in ("Volume", "Displacement"):
            if output.inputs[name].is_linked:
                tell(material.name, f"its {name.lower()} is not written")
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file, indent=1)


# ---- import ----


class Maker:
    """A material that is made from an entry of a file."""

    images = {}  # by path and raw: a picture of Blender has one colour space

    def __init__(self, name, folder):
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = self.material.use_fake_user = True
        self.nodes, self.links = self.material.node_tree.nodes, self.material.node_tree.links
        self.shader = next(node for node in self.nodes if node.type == "BSDF_PRINCIPLED")
        self.name, self.folder, self.made = name, folder, {}
        if self.material.name != name:
            tell(name, f"its name is '{self.material.name}' here")

    def node(self, kind, column, *key):
        """The node of a kind and a key, and whether it is new."""
        is_new = (kind, *key) not in self.made
        if is_new:
            node = self.made[(kind, *key)] = self.nodes.new("ShaderNode" + kind)
            node.location = (-300 * column, 300 - 300 * sum(kind == made[0] for made in self.made))
        return self.made[(kind, *key)], is_new

    def place(self, image, key, numbers):
        m = turned_over([numbers[:3], numbers[3:6]])
        angle = math.atan2(m[1][0], m[0][0]) if m[0][1] or m[1][0] else 0
        c, s = math.cos(angle), math.sin(angle)
        scale = (m[0][0] * c + m[1][0] * s, m[1][1] * c - m[0][1] * s, 1)
        if abs(m[0][0] * m[0][1] + m[1][0] * m[1][1]) > 1e-6 * abs(scale[0] * scale[1]):
            return tell(self.name, f"{key}.to_uv is not used: it shears")
        mapping, _ = self.node("Mapping", 5, tuple(numbers))
        for name, value in ("Location", (m[0][2], m[1][2], 0)), ("Rotation", (0, 0, angle)), ("Scale", scale):
            mapping.inputs[name].default_value = value
        self.links.new(self.node("TexCoord", 6)[0].outputs["UV"], mapping.inputs["Vector"])
        self.links.new(mapping.outputs["Vector"], image.inputs["Vector"])

    def bitmap(self, key, value):
        """The output of a bitmap, or None."""
        rest = {"raw": False, "wrap_mode": "repeat", "to_uv": None, "channel": None, **value}
        kind, file, raw, wrap, to_uv, channel = (rest.pop(k, "") for k in ("type", "filename", "raw", "wrap_mode", "to_uv", "channel"))
        if kind != "bitmap" or wrap not in WRAPS.values() or channel not in (None, *CHANNELS.values()) or not (to_uv is None or are_numbers(to_uv, 9)):
            return tell(self.name, f"{key} is not used: {json.dumps(value)}")
        path = os.path.normpath(os.path.join(self.folder, str(file)))
        for other in rest:
            tell(self.name, f"{key}.{other} is not used")
        if (path, raw) not in self.images:
            if not os.path.isfile(path):
                return tell(self.name, f"{key} is not used: there is no file {path}")
            image = self.images[path, raw] = bpy.data.images.load(path)
            image.alpha_mode = "CHANNEL_PACKED"
            if not image.size[0]:
                tell(self.name, f"{key}: Blender cannot read {path}")
            if raw or not path.lower().endswith(FLOATS):
                image.colorspace_settings.name = "Non-Color" if raw else "sRGB"
        node, is_new = self.node("TexImage", 4, path, raw, wrap, str(to_uv))
        if is_new:
            node.image, node.extension = self.images[path, raw], next(k for k, v in WRAPS.items() if v == wrap)
            if to_uv:
                self.place(node, key, to_uv)
        if channel in (None, "a"):
            return node.outputs["Alpha" if channel else "Color"]
        separate, _ = self.node("SeparateColor", 2, path, raw, wrap, str(to_uv))
        self.links.new(node.outputs["Color"], separate.inputs[0])
        return separate.outputs[next(k for k, v in CHANNELS.items() if v == channel)]

    def set(self, key, value):
        socket = {socket.name.lower().replace(" ", "_"): socket for socket in self.shader.inputs}.get(key)
        given = value.get("value") if isinstance(value, dict) and value.get("type") == "rgb" else value
        numbers, is_color = given if isinstance(given, list) else [given], socket and hasattr(socket.default_value, "__len__")
        if not socket:
            tell(self.name, f"{key} is not used: Blender {bpy.app.version_string} does not have it")
        elif isinstance(given, dict):
            output = self.bitmap(key, given)
            if output:
                self.links.new(output, socket)
        elif not are_numbers(numbers, 3 if is_color else 1):
            tell(self.name, f"{key} is not used: {json.dumps(value)}")
        else:
            socket.default_value = (numbers + [1])[:len(socket.default_value)] if is_color else numbers[0]
            if numbers_of(socket.default_value) != numbers_of(numbers if is_color else numbers[0]):
                tell(self.name, f"{key} is {numbers_of(socket.default_value)} here, not {given}")

    def fill(self, entry):
        entry = {"ior": 1.5, "multiscatter": 1, **entry}
        multiscatter = entry.pop("multiscatter")
        self.shader.distribution = "GGX" if multiscatter == 0 else "MULTI_GGX"
        if multiscatter not in (0, 1):
            tell(self.name, f"multiscatter is 1 here, not {json.dumps(multiscatter)}")
        for key, value in entry.items():
            self.set(key, value)
        if entry.get("anisotropic"):
            tangent, _ = self.node("Tangent", 1)
            tangent.direction_type = "UV_MAP"
            self.links.new(tangent.outputs[0], self.shader.inputs["Tangent"])

    def bend(self, value):
        output, (normal, _) = self.bitmap("normalmap", value), self.node("NormalMap", 1)
        if output:
            self.links.new(output, normal.inputs["Color"])
            self.links.new(normal.outputs[0], self.shader.inputs["Normal"])


def import_entry(name, entry, folder):
    members = {**entry} if isinstance(entry, dict) else {}
    kind, name = members.pop("type", ""), members.pop("id", name)
    normal = members.pop("normalmap", None) if kind == "normalmap" else None
    if normal and len(members) == 1:
        members = {**next(iter(members.values()))}
        kind = members.pop("type", "")
    if kind != "blender-principled":
        tell(name, f"not read, as it is no blender-principled but '{kind}'; nqm translate FILE --to blender writes what is read")
        return
    maker = Maker(name, folder)
    maker.fill(members)
    if normal:
        maker.bend(normal)


def import_file(path):
    with open(path, encoding="utf-8") as file:
        scene = json.load(file)
    if not isinstance(scene, dict):
        raise ValueError("no materials")
    if scene.get("type") != "scene":
        scene = {os.path.splitext(os.path.basename(path))[0]: scene}
    for name, entry in scene.items():
        if name != "type" or isinstance(entry, dict):
            import_entry(name, entry, os.path.dirname(os.path.abspath(path)))


class ImportMaterials(bpy.types.Operator, ImportHelper):
    bl_idname, bl_label, filename_ext = "import_scene.nqm_materials", "Import materials of nqm", ".json"

    def execute(self, _):
        remarks.clear()
        import_file(self.filepath)
        for remark in remarks:
            self.report({"WARNING"}, remark)
        return {"FINISHED"}


def main(arguments):
    if bpy.app.version < (4, 0):
        error = "Blender 4.0 or later is needed"
        raise SystemExit(error) if bpy.app.background else RuntimeError(error)
    if len(arguments) == 1 and not arguments[0].startswith("-"):
        export_file(arguments[0])
    elif len(arguments) == 3 and arguments[0] == "--import":
        if not bpy.data.filepath:
            bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        try:
            import_file(arguments[1])
        except (OSError, ValueError) as error:
            sys.exit(f"{arguments[1]}: {error}")
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(arguments[2]))
    elif arguments or bpy.app.background:
        sys.exit(__doc__)
    else:
        bpy.utils.register_class(ImportMaterials)
        bpy.ops.import_scene.nqm_materials("INVOKE_DEFAULT")


main(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
