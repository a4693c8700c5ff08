# SPDX-License-Identifier: MIT
"""The Principled BSDF as Cycles renders it: flat patches of all normals under one sun, without bounces, seen by an orthographic camera along
z. A pixel is f_r cos(theta_i). Needs Blender 4.3 (Debian 13):

    blender -b -P cycles_principled.py -- vectors    writes cycles_principled.csv: spec, wi, wo, r, g, b
    blender -b -P cycles_principled.py -- sheen      writes ../../presets/sheen_ltc.txt: 32 x 32 albedos, a and -b of the lobe"""
import csv
import os
import pathlib
import sys
import tempfile

import bpy
import numpy as np

SEED, SIDE, PIXELS = 5, 15, 4  # patches and pixels of a side; the inner ones see one patch only
HERE = pathlib.Path(__file__).parent
VIEWER = np.array([0, 0, 1.0])
rng = np.random.default_rng(SEED)


def color(*rgb):
    return (*rgb, 1)


MATERIALS = [
    {"Specular IOR Level": 0, "Base Color": color(.8, .4, .1)},
    {"Specular IOR Level": 0, "Diffuse Roughness": .7, "Base Color": color(.8, .4, .1)},
    {"Roughness": .15, "Base Color": color(.1, .4, .7)},
    {"Roughness": .9, "Base Color": color(.1, .4, .7)},
    {"Roughness": .4, "Base Color": color(.8, .4, .1), "GGX": True},
    {"Metallic": 1, "Roughness": .35, "Base Color": color(1, .77, .34)},
    {"Metallic": 1, "Roughness": .35, "Base Color": color(1, .77, .34), "GGX": True},
    {"Metallic": 1, "Roughness": .5, "Base Color": color(.9, .5, .3), "Specular Tint": color(.9, .7, 1)},
    {"Metallic": .5, "Roughness": .5, "Base Color": color(.6, .7, .2)},
    {"Metallic": 1, "Roughness": .4, "Base Color": color(.9, .8, .7), "Anisotropic": .7},
    {"Metallic": 1, "Roughness": .4, "Base Color": color(.9, .8, .7), "Anisotropic": .7, "Anisotropic Rotation": .1},
    {"IOR": 2.2, "Roughness": .3, "Base Color": color(.3, .3, .3)},
    {"Specular IOR Level": .9, "Roughness": .3, "Base Color": color(.3, .3, .3)},
    {"Specular Tint": color(.2, .9, .5), "Roughness": .3, "Base Color": color(.3, .3, .3)},
    {"Coat Weight": 1, "Coat Roughness": .1, "Roughness": .6, "Base Color": color(.5, .1, .1)},
    {"Coat Weight": .7, "Coat Roughness": .4, "Coat IOR": 1.8, "Coat Tint": color(.9, .6, .3), "Base Color": color(.5, .4, .3)},
    {"Coat Weight": .7, "Coat Roughness": .4, "Coat IOR": 1.8, "Specular IOR Level": 0, "Base Color": color(0, 0, 0)},
    {"Sheen Weight": 1, "Sheen Roughness": .4, "Specular IOR Level": 0, "Base Color": color(0, 0, 0)},
    {"Sheen Weight": 1, "Sheen Roughness": .2, "Base Color": color(.2, .1, .3), "Roughness": .8},
    {"Sheen Weight": .6, "Sheen Roughness": .8, "Sheen Tint": color(.3, .9, .6), "Base Color": color(.2, .1, .3)},
    {"Thin Film Thickness": 450., "Thin Film IOR": 1.5, "Roughness": .3, "Base Color": color(.05, .05, .05), "IOR": 1.8},
    {"Metallic": .3, "Roughness": .45, "Base Color": color(.7, .3, .2), "Coat Weight": .5, "Coat Roughness": .3, "Sheen Weight": .4,
     "Sheen Roughness": .5, "IOR": 1.6},
]


def make_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.blur_glossy = 1, 0
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.max_bounces = 0
    scene.cycles.pixel_filter_type = "BOX"
    scene.render.resolution_x = scene.render.resolution_y = SIDE * PIXELS
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale, camera.clip_end = "ORTHO", SIDE, 3000
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location = (0, 0, 1000)
    light = bpy.data.lights.new("sun", "SUN")
    light.energy, light.angle, light.use_shadow = 1, 0, False
    sun = bpy.data.objects.new("sun", light)
    for thing in (scene.camera, sun):
        scene.collection.objects.link(thing)
    return scene, sun


def make_material(values):
    material = bpy.data.materials.new("material")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    shader, output, tangent = (nodes.new(f"ShaderNode{n}") for n in ("BsdfPrincipled", "OutputMaterial", "Tangent"))
    tangent.direction_type, tangent.uv_map = "UV_MAP", "uv"
    links.new(shader.outputs[0], output.inputs["Surface"])
    links.new(tangent.outputs[0], shader.inputs["Tangent"])
    shader.distribution = "GGX" if values.get("GGX") else "MULTI_GGX"
    for name, value in values.items():
        if name != "GGX":
            shader.inputs[name].default_value = value
    return material


def make_patches(scene, normals, material):
    """Squares in the picture; u runs along x."""
    corners = ((-.5, -.5), (.5, -.5), (.5, .5), (-.5, .5))
    points, faces = [], []
    for k, n in enumerate(normals):
        x, y = k % SIDE + .5 - SIDE / 2, k // SIDE + .5 - SIDE / 2
        points += [(x + dx, y + dy, -(n[0] * dx + n[1] * dy) / n[2]) for dx, dy in corners]
        faces.append(range(4 * k, 4 * k + 4))
    mesh = bpy.data.meshes.new("patches")
    mesh.from_pydata(points, [], [list(f) for f in faces])
    uv = mesh.uv_layers.new(name="uv")
    for i in range(len(points)):
        uv.data[i].uv = (corners[i % 4][0] + .5, corners[i % 4][1] + .5)
    mesh.materials.append(material)
    patches = bpy.data.objects.new("patches", mesh)
    scene.collection.objects.link(patches)
    return patches


def shoot(scene, sun, normals, theta):
    """The direction of the light, and f_r (n, 3)."""
    light = np.array([np.sin(theta), 0, np.cos(theta)])
    sun.rotation_euler = (0, theta, 0)
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = os.path.join(folder, "picture.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.array(image.pixels[:], float).reshape(SIDE * PIXELS, SIDE * PIXELS, -1)
        bpy.data.images.remove(image)
    k = np.arange(len(normals))
    return light, pixels[k // SIDE * PIXELS + 1, k % SIDE * PIXELS + 1, :3] / np.maximum(normals @ light, 1e-9)[:, None]


def in_frames(normals, w):
    """A direction in the frame of each patch."""
    t = np.stack([np.ones(len(normals)), np.zeros(len(normals)), -normals[:, 0] / normals[:, 2]], 1)
    t /= np.linalg.norm(t, axis=1)[:, None]
    return np.stack([t @ w, np.cross(normals, t) @ w, normals @ w], 1)


def spec_of(values):
    parts = ["multiscatter=0"] if values.get("GGX") else []
    for name, value in values.items():
        if name != "GGX":
            numbers = value[:3] if isinstance(value, tuple) else (value,)
            parts.append(name.lower().replace(" ", "_") + "=" + ",".join(f"{x:g}" for x in numbers))
    return "blender-principled:" + ";".join(parts)


def vectors():
    scene, sun = make_scene()
    with open(HERE / "cycles_principled.csv", "w", newline="") as file:
        file.write(f"# made by cycles_principled.py: Cycles of Blender {bpy.app.version_string}, float32, seed {SEED}\n")
        out = csv.writer(file, lineterminator="\n", quoting=csv.QUOTE_NONNUMERIC)
        file.write("spec,wix,wiy,wiz,wox,woy,woz,r,g,b\n")
        for values in MATERIALS:
            material = make_material(values)
            for theta in (.2, .9, 1.3):
                light = np.array([np.sin(theta), 0, np.cos(theta)])
                normals = rng.normal(size=(5000, 3))
                normals /= np.linalg.norm(normals, axis=1)[:, None]
                normals = normals[(normals[:, 2] > .08) & (normals @ light > .08)][:5]
                patches = make_patches(scene, normals, material)
                light, f = shoot(scene, sun, normals, theta)
                bpy.data.objects.remove(patches)
                for row in np.hstack([in_frames(normals, light), in_frames(normals, VIEWER), f]):
                    out.writerow([spec_of(values), *(float(f"{x:.9g}") for x in row)])


def lobe(x, y2, z, f):
    """Albedo A, a and b of f = A a^2 / (pi ((a x + b z)^2 + a^2 y^2 + z^2)^2): 1 / sqrt(pi f) is linear in x^2 + y^2, x z and z^2."""
    used = f > 1e-7
    if used.sum() < 6:
        return np.full(3, np.nan)
    scale = np.sqrt(np.pi * f[used])[:, None]
    (p, q, r), *_ = np.linalg.lstsq(np.stack([x * x + y2, x * z, z * z], 1)[used] * scale, np.ones(used.sum()), rcond=None)
    a2 = 1 / (r / p - (q / p)**2 / 4)
    return np.array([a2 / p**2, np.sqrt(a2), np.sqrt(a2) * q / (2 * p)])


def sheen():
    """Cycles interpolates linearly between cosines k / 31: two cosines before 1 / 31 give the values at 0."""
    turns, cosines = 6, np.array([.25 / 31, .5 / 31, *np.arange(1, 31) / 31, 0.999999])
    normals = np.array([[np.sqrt(1 - c * c) * np.cos(phi), np.sqrt(1 - c * c) * np.sin(phi), c] for c in cosines
                        for phi in 2 * np.pi * (np.arange(turns) + .35 * c) / turns])
    scene, sun = make_scene()
    material = make_material({"Sheen Weight": 1, "Base Color": color(0, 0, 0), "Specular IOR Level": 0})
    shader = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    make_patches(scene, normals, material)
    table = np.empty((3, 32, 32))
    for i in range(32):
        shader.inputs["Sheen Roughness"].default_value = i / 31
        shots = [shoot(scene, sun, normals, theta) for theta in (0, .4, .8, 1.2, 1.45)]
        found = []
        for k in range(len(cosines)):
            n = normals[k * turns:][:turns]
            z = np.concatenate([n @ light for light, _ in shots])
            along = VIEWER - n * n[:, 2:]
            along /= np.linalg.norm(along, axis=1)[:, None]
            x = np.concatenate([along @ light for light, _ in shots])
            f = np.concatenate([f[k * turns:][:turns, 0] for _, f in shots])
            lit = z > .05
            found.append(lobe(x[lit], (1 - z * z - x * x)[lit], z[lit], f[lit]))
        found = np.array(found).T
        table[:, i, 0], table[:, i, 1:] = 2 * found[:, 0] - found[:, 1], found[:, 2:]
        table[:, i, 1] = np.where(np.isnan(table[:, i, 1]), 3 * found[:, 1] - 2 * found[:, 0], table[:, i, 1])
    table[0, 0] -= .032 * (table[0, 1] - table[0, 0])  # Cycles has a roughness of at least 0.001
    for i, k in zip(*np.where(np.isnan(table[0]))):  # no light
        table[:, i, k] = 0, table[1, i, k - 1], table[2, i, k - 1]
    table[2] *= -1
    with open(HERE / "../../presets/sheen_ltc.txt", "w") as file:
        file.write("# The sheen of Zeltner, Burley and Chiang 2022 as Cycles 4.3 interpolates it, measured by tests/vectors/cycles_principled.py:\n"
                   "# albedo, a and -b, each 32 rows of roughness from 0 to 1 with 32 cosines of the viewer from 0 to 1. Unit 1/50000.\n")
        for row in np.maximum(np.rint(50000 * table), 0).astype(int).reshape(-1, 32):
            file.write(",".join(map(str, row)) + "\n")


{"vectors": vectors, "sheen": sheen}[sys.argv[sys.argv.index("--") + 1]]()
