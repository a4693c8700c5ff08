# SPDX-License-Identifier: MIT
"""doc/blender.py with objects in the place of Blender's: what it writes is read."""
import io
import os
import runpy
import sys
import tempfile
import types
import unittest
from types import SimpleNamespace as Object
from unittest import mock

import nqm

INPUTS = {"Base Color": ("RGBA", [.8, .3, .1, 1]), "Metallic": ("VALUE", 0.), "Roughness": ("VALUE", .4), "IOR": ("VALUE", 1.5),
          "Alpha": ("VALUE", 1.), "Normal": ("VECTOR", [0, 0, 0]), "Weight": ("VALUE", 0.), "Subsurface Weight": ("VALUE", 0.),
          "Subsurface Radius": ("VECTOR", [1, .2, .1]), "Specular IOR Level": ("VALUE", .5), "Specular Tint": ("RGBA", [1] * 4),
          "Coat Weight": ("VALUE", .3), "Coat Normal": ("VECTOR", [0, 0, 0]), "Emission Color": ("RGBA", [1] * 4),
          "Emission Strength": ("VALUE", 0.), "Thin Film IOR": ("VALUE", 1.33)}


class Sockets(list):
    """Sockets by number and by name."""

    def __getitem__(self, key):
        return next(s for s in self if s.name == key) if isinstance(key, str) else super().__getitem__(key)


def socket(name, kind, value, node):
    return Object(name=name, type=kind, default_value=value, is_linked=node is not None, links=[Object(from_socket=Object(name="Color", node=node))])


def sockets(**nodes):
    return Sockets(socket(name, "RGBA", None, node) for name, node in nodes.items())


def material(name, links):
    shader = Object(type="BSDF_PRINCIPLED", distribution="MULTI_GGX",
                    inputs=Sockets(socket(key, *INPUTS[key], links.get(key)) for key in INPUTS))
    output = Object(inputs=sockets(Surface=shader, Volume=None, Displacement=None))
    return Object(name=name, use_nodes=True, is_grease_pencil=False, node_tree=Object(get_output_node=lambda renderer: output))


class Blender(unittest.TestCase):
    def test_what_the_script_writes_is_read(self):
        image = Object(filepath="//wood.png", source="FILE", colorspace_settings=Object(name="sRGB"))
        texture = Object(type="TEX_IMAGE", image=image, extension="REPEAT", projection="FLAT", inputs=sockets(Vector=None))
        normal = Object(type="NORMAL_MAP", space="TANGENT", inputs=sockets(Color=None))
        modules = {name: types.ModuleType(name) for name in ("bpy", "bpy_extras", "bpy_extras.io_utils", "mathutils")}
        modules["bpy_extras.io_utils"].ImportHelper = type("ImportHelper", (), {})
        modules["mathutils"].Euler = modules["mathutils"].Matrix = None
        bpy = modules["bpy"]
        bpy.app, bpy.types = Object(version=(4, 2, 0), background=True), Object(Operator=type("Operator", (), {}))
        bpy.path = Object(abspath=lambda name: "/maps/" + name.lstrip("/"))
        bpy.data = Object(materials=[material("Paint", {}), material("Wood", {"Base Color": texture}),
                                     material("Odd", {"Roughness": Object(type="MATH")}), material("Bump", {"Normal": normal}),
                                     Object(name="Empty", use_nodes=False, is_grease_pencil=False)])
        with tempfile.TemporaryDirectory() as folder, mock.patch.dict(sys.modules, modules):
            path = os.path.join(folder, "materials.json")
            with mock.patch.object(sys, "argv", ["blender", "--", path]), mock.patch.object(sys, "stderr", io.StringIO()) as err:
                runpy.run_path(os.path.join(os.environ["NQM_SOURCE"], "doc", "blender.py"))
            found = {m.name: m for m in nqm.materials(path)}
        self.assertEqual(err.getvalue(), "Empty: not written, as its surface is no Principled BSDF\n")
        self.assertEqual(list(found), ["Paint", "Wood", "Odd", "Bump"])
        self.assertIn("base_color=0.8,0.3,0.1", found["Paint"].spec)
        self.assertIn("coat_weight=0.3", found["Paint"].spec)
        self.assertIn("base_color is of type 'bitmap'", found["Wood"].refusal)
        self.assertIn("node MATH", found["Odd"].refusal)
        self.assertIn("normal", found["Bump"].refusal)


if __name__ == "__main__":
    unittest.main()
