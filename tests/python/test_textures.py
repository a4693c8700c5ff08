# SPDX-License-Identifier: MIT
"""Textured materials in Python: arrays and files, heat maps, blame, errors."""
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

import nqm
from support import run_tool

SOURCE = Path(__file__).resolve().parent.parent.parent


def plate(side=16):
    y, x = np.mgrid[:side, :side] / side
    colour = np.stack([0.3 + 0.5 * x, 0.2 + 0.1 * y, 0.1 + 0 * x], axis=2)
    normal = np.stack([0.1 * np.sin(6 * x), 0.1 * np.cos(6 * y), 1 + 0 * x], axis=2)
    return {"base_color": colour, "roughness": 0.3 + 0.4 * y, "normal": normal}


class Textures(unittest.TestCase):
    def test_maps(self):
        maps = plate()
        test = dict(maps, roughness=maps["roughness"] ** 2)
        s = nqm.score_maps(maps, test, heat=True, far=False)
        self.assertEqual(s.blame[0].property, "roughness")
        self.assertEqual(s.blame[0].mistake, "roughness is squared")
        self.assertEqual(s.heat.shape, (16, 16))
        self.assertAlmostEqual(float(s.heat.mean()), s.delta_e, delta=0.01 * s.delta_e)
        self.assertTrue(s.jod_low <= s.jod <= s.jod_high < 10)
        self.assertTrue(np.isnan(s.far_jod))
        self.assertIn("JOD", str(s))

    def test_same(self):
        s = nqm.score_maps(plate(), plate())
        self.assertEqual((s.jod, s.far_jod, s.delta_e, s.blame), (10, 10, 0, ()))

    def test_constant(self):
        """Maps of one value are the BRDF."""
        s = nqm.score_maps({"roughness": np.full((4, 4), 0.2)}, "gltf:roughness=.5", exact=True)
        self.assertAlmostEqual(s.jod, nqm.score("gltf:roughness=.2", "gltf:roughness=.5").jod, places=4)

    def test_pixels(self):
        maps = {"roughness": np.full((4, 4), 0.2)}
        s = nqm.score_maps(maps, "gltf:roughness=.5", texels_per_pixel=2, far=False)
        self.assertAlmostEqual(s.jod, nqm.score("gltf:roughness=.2", "gltf:roughness=.5").jod, places=3)

    def test_as_the_tool(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, str(SOURCE / "examples/maps.py"), folder, "16"], check=True)
            steel, export = folder + "/steel", folder + "/export"
            row = json.loads(run_tool("score", steel, export, "--json"))["results"][0]
            s = nqm.score_maps(steel, export)
            self.assertEqual("%.9g" % s.jod, "%.9g" % row["jod"])
            self.assertEqual("%.9g" % s.far_jod, "%.9g" % row["texture"]["far_jod"])
            self.assertEqual([b.property for b in s.blame], [b["property"] for b in row["texture"]["blame"]])
            table = nqm.batch([(steel, export), (steel, "sgd:nickel"), ("sgd:nickel", steel + "/gone")], metrics=True)
            self.assertEqual("%.9g" % table["jod"][0], "%.9g" % row["jod"])
            self.assertEqual(table["status"].tolist(), [0, 0, nqm.Status.IO])
            self.assertTrue(table["jod"][1] < table["jod"][0] and np.isnan(table["rmse"][0]) and table["n_valid"][0] == 0)
            with open(folder + "/list.csv", "w", encoding="utf-8") as file:
                file.write("reference,test\n%s,%s\n" % (steel, steel))
            self.assertEqual(nqm.batch(folder + "/list.csv")[["jod", "identical"]].tolist(), [(10, True)])
            info = nqm.Material.open(steel).info
            self.assertEqual((info.width, info.height, info.n_images, info.model), (16, 16, 4, "gltf"))
            self.assertEqual(info.varying, ("base_color", "roughness", "metallic", "normal"))

    def test_integers_are_as_in_pictures(self):
        rng = np.random.default_rng(1)
        colour, rough = rng.integers(0, 256, (8, 8, 3), dtype=np.uint8), rng.integers(60, 256, (8, 8), dtype=np.uint8)
        normal = np.full((8, 8, 3), (140, 120, 250), np.uint8)
        unit = colour / 255
        linear = np.where(unit > 0.04045, ((unit + 0.055) / 1.055) ** 2.4, unit / 12.92)
        floats = {"base_color": linear, "roughness": rough / 255, "normal": 2 * (normal / 255) - 1}
        bytes_ = {"base_color": colour, "roughness": rough, "normal": normal}
        words = {"base_color": colour.astype(np.uint16) * 257, "roughness": rough.astype(np.uint16) * 257, "normal": normal}
        for maps in (bytes_, words):
            s = nqm.score_maps(floats, maps, exact=True)
            self.assertTrue(s.jod > 9.999 and s.delta_e < 1e-4, s)
        with self.assertRaisesRegex(ValueError, "'roughness' is of int64: give floats"):
            nqm.Material.from_maps({"roughness": np.ones((4, 4), np.int64)})

    def test_errors(self):
        with self.assertRaisesRegex(nqm.Error, "no property 'shine'"):
            nqm.Material.from_maps({"shine": np.zeros((2, 2))})
        with self.assertRaisesRegex(ValueError, "shape"):
            nqm.Material.from_maps({"roughness": np.zeros(4)})
        with self.assertRaises(nqm.Error):
            nqm.Material.open("maps:base_color=gone.png")

        def stop(stage, done, total):
            raise KeyError("stop")
        with self.assertRaisesRegex(KeyError, "stop"):
            nqm.score_maps(plate(), {"roughness": np.random.default_rng(1).random((64, 64))}, progress=stop)


if __name__ == "__main__":
    unittest.main()
