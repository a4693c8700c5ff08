# SPDX-License-Identifier: MIT
"""Ten materials as Cycles renders what doc/blender.py imports, next to `nqm render`: a sphere under a light map, in linear light.

    NQM=build/nqm python3 studies/cycles.py FOLDER     writes the materials, the light and the pictures of nqm
    blender -b -P studies/cycles.py -- FOLDER          renders the same with Blender 4.3, prints the differences, and writes pairs.png (ours above)"""
import json
import os
import pathlib
import subprocess
import sys

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
SIZE, RADIUS, MAX_ANGLE = 128, .9, 80  # pixels; of the sphere in half pictures; degrees between normal and viewer that are compared


def rgb(*value):
    return {"type": "rgb", "value": value}


def image(name, **members):
    return {"type": "bitmap", "filename": f"steel/steel_{name}.png", "to_uv": [4, 0, .25, 0, 2, 0, 0, 0, 1], **members}


MATERIALS = {
    "white": {"base_color": rgb(1, 1, 1), "specular_ior_level": 0},
    "diffuse": {"base_color": rgb(.8, .4, .1), "specular_ior_level": 0, "diffuse_roughness": .6},
    "plastic": {"base_color": rgb(.1, .4, .7), "roughness": .25},
    "rough plastic": {"base_color": rgb(.6, .2, .2), "roughness": .8, "ior": 1.8},
    "gold": {"base_color": rgb(1, .77, .34), "metallic": 1, "roughness": .35},
    "GGX metal": {"base_color": rgb(.9, .5, .3), "metallic": 1, "roughness": .6, "multiscatter": 0, "specular_tint": rgb(.9, .7, 1)},
    "brushed metal": {"base_color": rgb(.9, .8, .7), "metallic": 1, "roughness": .4, "anisotropic": .7, "anisotropic_rotation": .1},
    "coat": {"base_color": rgb(.5, .05, .05), "roughness": .5, "coat_weight": 1, "coat_roughness": .1, "coat_tint": rgb(.9, .6, .3)},
    "sheen": {"base_color": rgb(.2, .1, .3), "roughness": .9, "sheen_weight": 1, "sheen_roughness": .4, "sheen_tint": rgb(.8, .9, .6)},
    "thin film": {"base_color": rgb(.05, .05, .05), "roughness": .3, "ior": 1.8, "thin_film_thickness": 450, "thin_film_ior": 1.5},
    "rusty steel": {"base_color": image("Color"), "roughness": image("Color", raw=True, channel="g"), "metallic": image("Metalness", raw=True)},
}


def path_of(folder, kind, name):
    return os.path.join(folder, f"{kind}-{name.replace(' ', '-')}.exr")


def write_light(path, width=256):
    """A sky over a brown floor, with a wide sun; Radiance HDR."""
    theta, phi = np.meshgrid((np.arange(width // 2) + .5) / (width // 2) * np.pi, (np.arange(width) + .5) / width * 2 * np.pi - np.pi, indexing="ij")
    w = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)], -1)
    sun = np.exp(40 * (w @ (np.array([-2, 2, 2.5]) / np.sqrt(14.25)) - 1))[..., None] * [12, 11, 9]
    lamp = np.exp(90 * (w @ (np.array([3, 1, 1.5]) / 3.5) - 1))[..., None] * [4, 7, 10]
    up = 1 / (1 + np.exp(-12 * w[..., 1:2]))
    light = sun + lamp + up * [.4, .6, 1] + (1 - up) * [.25, .18, .1]
    e = np.ceil(np.log2(light.max(-1)))
    rgbe = np.concatenate([light / 2**e[..., None] * 255.99, e[..., None] + 128], -1).astype(np.uint8)
    with open(path, "wb") as file:
        file.write(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {width // 2} +X {width}\n".encode() + rgbe.tobytes())


def make(folder):
    subprocess.run([sys.executable, HERE / "../examples/maps.py", folder, "128"], check=True)
    scene = {"type": "scene"}
    for name, values in MATERIALS.items():
        scene[name] = {"type": "blender-principled", **values}
    normal = image("NormalGL", raw=True)
    scene["rusty steel"] = {"type": "normalmap", "normalmap": normal, "bsdf": scene["rusty steel"]}
    with open(os.path.join(folder, "materials.json"), "w", encoding="utf-8") as file:
        json.dump(scene, file, indent=1)
    write_light(os.path.join(folder, "light.hdr"))
    for name in MATERIALS:
        points, lights = ("2", "128") if name == "rusty steel" else ("3", "512")
        subprocess.run([os.environ["NQM"], "render", f"{folder}/materials.json:{name}", "-o", path_of(folder, "nqm", name), "--shape", "sphere",
                        "--light", f"{folder}/light.hdr", "--size", str(SIZE), "--supersample", points, "--lights", lights, "--texels", "8"], check=True)


# ---- in Blender ----


def make_scene(bpy, folder):
    """x to the right, y up, z to the viewer, as in nqm."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.blur_glossy, scene.cycles.pixel_filter_type = 1024, 0, "BOX"
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.render.film_transparent = True
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", 2
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location = (0, 0, 10)
    scene.collection.objects.link(scene.camera)
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    place, split, join, light = (nodes.new(f"ShaderNode{n}") for n in ("TexCoord", "SeparateXYZ", "CombineXYZ", "TexEnvironment"))
    light.image = bpy.data.images.load(os.path.join(folder, "light.hdr"))
    links.new(place.outputs["Generated"], split.inputs[0])
    for k, (axis, sign) in enumerate((("Z", -1), ("X", -1), ("Y", 1))):  # the middle column of the map is behind the sphere
        turn = nodes.new("ShaderNodeMath")
        turn.operation, turn.inputs[1].default_value = "MULTIPLY", sign
        links.new(split.outputs[axis], turn.inputs[0])
        links.new(turn.outputs[0], join.inputs[k])
    links.new(join.outputs[0], light.inputs[0])
    links.new(light.outputs[0], next(n for n in nodes if n.type == "BACKGROUND").inputs["Color"])
    return scene


def make_sphere(bpy, scene, columns=512, rows=256):
    """With texture coordinates as nqm has them; v of Blender points up."""
    v, u = (grid.ravel() for grid in np.meshgrid(np.arange(rows + 1) / rows, np.arange(columns + 1) / columns, indexing="ij"))
    theta, phi = np.pi * v, 2 * np.pi * (u - .5)
    points = RADIUS * np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], 1)
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    faces = np.stack([corner, corner + columns + 1, corner + columns + 2, corner + 1], 1)
    mesh = bpy.data.meshes.new("sphere")
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    layer = mesh.uv_layers.new(name="uv")
    layer.data.foreach_set("uv", np.stack([u, 1 - v], 1)[faces.ravel()].ravel())
    mesh.normals_split_custom_set_from_vertices((points / RADIUS).tolist())
    thing = bpy.data.objects.new("sphere", mesh)
    scene.collection.objects.link(thing)
    return mesh


def pixels_of(bpy, path):
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    return np.array(image.pixels[:], float).reshape(SIZE, SIZE, -1)[..., :3]


def compare(folder):
    import bpy
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    sys.argv = ["blender", "--", "--import", f"{folder}/materials.json", f"{folder}/materials.blend"]
    exec(compile((HERE.parent / "doc/blender.py").read_text(), "blender.py", "exec"), {"__name__": "blender"})
    scene = make_scene(bpy, folder)
    mesh = make_sphere(bpy, scene)
    at = (np.arange(SIZE) + .5) / SIZE * 2 - 1
    seen = np.hypot(*np.meshgrid(at, at)) < RADIUS * np.sin(np.radians(MAX_ANGLE))
    scale, rows = None, []
    for name in MATERIALS:
        mesh.materials.clear()
        mesh.materials.append(bpy.data.materials[name])
        scene.render.filepath = path_of(folder, "cycles", name)
        bpy.ops.render.render(write_still=True)
        ours, theirs = (pixels_of(bpy, path_of(folder, kind, name)) for kind in ("nqm", "cycles"))
        scale = scale or ours[seen].mean() / theirs[seen].mean()
        difference = np.abs(ours - scale * theirs)[seen].mean(1) / ours[seen].mean(1)
        print(f"{name:14} mean {100 * (ours[seen].mean() / theirs[seen].mean() / scale - 1):+6.2f} %   mean of differences {100 * difference.mean():5.2f} %   "
              f"99 % below {100 * np.percentile(difference, 99):5.2f} %   worst {100 * difference.max():5.2f} %", flush=True)
        rows.append(np.vstack([theirs, ours / scale]))  # from the bottom
    shown = np.clip(np.hstack(rows) / 2, 0, 1)**(1 / 2.2)
    picture = bpy.data.images.new("pairs", shown.shape[1], shown.shape[0])
    picture.colorspace_settings.name = "Non-Color"
    picture.pixels = np.concatenate([shown, np.ones_like(shown[..., :1])], -1).ravel().tolist()
    picture.filepath_raw, picture.file_format = f"{folder}/pairs.png", "PNG"
    picture.save()


if "--" in sys.argv:
    compare(os.path.abspath(sys.argv[sys.argv.index("--") + 1]))
else:
    make(sys.argv[1])
