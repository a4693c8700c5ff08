# SPDX-License-Identifier: MIT
"""doc/blender.py with objects in the place of Blender's: what it writes is read."""
import os
import runpy
import sys
import tempfile
import types
import unittest
from types import SimpleNamespace as Object

import nqm

INPUTS = {"Base Color": ("RGBA", [.8, .3, .1, 1]), "Metallic": ("VALUE", 0.), "Roughness": ("VALUE", .4), "IOR": ("VALUE", 1.5),
          "Alpha": ("VALUE", 1.), "Normal": ("VECTOR", [0, 0, 0]), "Weight": ("VALUE", 0.), "Subsurface Weight": ("VALUE", 0.),
          "Subsurface Radius": ("VECTOR", [1, .2, .1]), "Specular IOR Level": ("VALUE", .5), "Specular Tint": ("RGBA", [1] * 4),
          "Coat Weight": ("VALUE", .3), "Coat Normal": ("VECTOR", [0, 0, 0]), "Emission Color": ("RGBA", [1] * 4),
          "Emission Strength": ("VALUE", 0.), "Thin Film IOR": ("VALUE", 1.33)}


def socket(name, kind, value, node):
    return Object(name=name, type=kind, default_value=value, is_linked=node is not None, links=[Object(from_node=node)])


def material(name, links):
    shader = Object(type="BSDF_PRINCIPLED", distribution="MULTI_GGX",
                    inputs=[socket(key, *INPUTS[key], links.get(key)) for key in INPUTS])
    output = Object(inputs={"Surface": socket("Surface", "SHADER", None, shader)})
    return Object(name=name, node_tree=Object(get_output_node=lambda renderer: output))


class Blender(unittest.TestCase):
    def test_what_the_script_writes_is_read(self):
        image = Object(filepath="//wood.png", colorspace_settings=Object(name="sRGB"))
        texture = Object(type="TEX_IMAGE", image=image, inputs={"Vector": Object(is_linked=False)})
        bpy = types.ModuleType("bpy")
        bpy.path = Object(abspath=lambda name: "/maps/" + name.lstrip("/"))
        bpy.data = Object(materials=[material("Paint", {}), material("Wood", {"Base Color": texture}),
                                     material("Odd", {"Roughness": Object(type="MATH")}),
                                     material("Bump", {"Normal": Object(type="NORMAL_MAP")}),
                                     Object(name="Empty", node_tree=None)])
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "materials.json")
            sys.modules["bpy"], arguments = bpy, sys.argv
            sys.argv = ["blender", "--", path]
            try:
                runpy.run_path(os.path.join(os.environ["NQM_SOURCE"], "doc", "blender.py"))
            finally:
                sys.argv = arguments
                del sys.modules["bpy"]
            found = {m.name: m for m in nqm.materials(path)}
        self.assertEqual(list(found), ["Paint", "Wood", "Odd", "Bump"])
        self.assertIn("base_color=0.8,0.3,0.1", found["Paint"].spec)
        self.assertIn("coat_weight=0.3", found["Paint"].spec)
        self.assertIn("base_color is of type 'bitmap'", found["Wood"].refusal)
        self.assertIn("node MATH", found["Odd"].refusal)
        self.assertIn("normal", found["Bump"].refusal)


if __name__ == "__main__":
    unittest.main()
