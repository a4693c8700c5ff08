# SPDX-License-Identifier: MIT
"""Fits, labels, pictures, metrics, datasets and the tool in Python, beside what the tool prints."""
import csv
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import threading
import unittest
import unittest.mock

import numpy as np

import nqm
from support import run_tool

BUILD = os.environ["NQM_BUILD"]
QUICK = {"n_directions": 500, "n_starts": 2}


def press_ctrl_c(delay, caught):
    """Again after a minute: Python drops an exception that a signal raises inside a finalizer, here of the fit before."""
    while not caught.wait(delay):
        os.kill(os.getpid(), signal.SIGINT)
        delay = 60


class Conform(unittest.TestCase):
    @staticmethod
    def metal(p, light, viewer, power=4):
        h = light + viewer
        h /= np.linalg.norm(h, axis=1, keepdims=True)
        a2, l, v, n_h = p["roughness"]**power, light[:, 2:], viewer[:, 2:], h[:, 2:]
        d = a2 / (np.pi * (n_h * n_h * (a2 - 1) + 1)**2)
        g = .5 / (l * np.sqrt(v * v * (1 - a2) + a2) + v * np.sqrt(l * l * (1 - a2) + a2))
        return (p["base_color"] + (1 - p["base_color"]) * (1 - (viewer * h).sum(axis=1, keepdims=True))**5) * d * g

    def test_right(self):
        found = nqm.conform("gltf", self.metal, ["base_color", "roughness"])
        self.assertTrue(found.passes)
        self.assertEqual((found.mistake, found.mistakes, found.facts, len(found.jod)), (None, (), (), len(found.specs)))
        self.assertGreater(found.jod.min(), 9.99)
        self.assertRegex(str(found), r"^(\d+) of \1 sets pass, lowest JOD 10.00$")

    def test_wrong(self):
        """As the tool says of the same values."""
        rows = []

        def shader(p, light, viewer):
            rows.append(self.metal(p, light, viewer, 8))
            return rows[-1]

        found = nqm.conform("gltf", shader, "base_color,roughness")
        self.assertFalse(found.passes)
        self.assertEqual((found.mistake, found.mistakes[0].text), ("roughness is squared twice",) * 2)
        self.assertIn("likely mistake: roughness is squared twice", str(found))
        with tempfile.TemporaryDirectory() as folder:
            np.save(folder + "/values.npy", np.array(rows, np.float32))
            again = nqm.conform("gltf", np.load(folder + "/values.npy"), "base_color,roughness")
            printed = json.loads(run_tool("conform", "gltf", folder + "/values.npy", "--keys", "base_color,roughness", "--fail-under", "0", "--json"))
        np.testing.assert_allclose([r["jod"] for r in printed["results"]], found.jod, rtol=1e-8)
        self.assertEqual([r["reference"] for r in printed["results"]], list(found.specs))
        self.assertEqual([m["mistake"] for m in printed["mistakes"]], [m.text for m in found.mistakes])
        self.assertEqual([f["text"] for f in printed["facts"].values()], list(found.facts))
        np.testing.assert_array_equal(again.jod, found.jod)

    def test_faults(self):
        def broken(p, light, viewer):
            raise ZeroDivisionError

        def stop(stage, done, total):
            raise KeyboardInterrupt

        for error, words, arguments in ((nqm.Error, "'ggx' is no shading model; there are", ("ggx", broken)), (ZeroDivisionError, "", ("gltf", broken)),
                                        (nqm.Error, "gltf has no 'gloss'; it has base_color", ("gltf", broken, "gloss")),
                                        (ValueError, "the kit has", ("gltf", np.zeros((2, 2, 3))))):
            with self.assertRaisesRegex(error, words):
                nqm.conform(*arguments)
        with self.assertRaises(KeyboardInterrupt):
            nqm.conform("gltf", self.metal, progress=stop)
        self.assertIn("sets have no score", str(nqm.conform("gltf", lambda p, light, viewer: light * np.nan, "base_color")))


class Fits(unittest.TestCase):
    def test_exact(self):
        found = nqm.fit("ggx:kd=.2,.1,.05;ks=.3;alpha=.2;f0=.8", "ggx", loss="log", **QUICK)
        self.assertLess(found.loss, 1e-4)
        self.assertEqual(nqm.BRDF.open(found.spec).info.spec, found.brdf.info.spec)
        self.assertGreater(nqm.score("ggx:kd=.2,.1,.05;ks=.3;alpha=.2;f0=.8", found.brdf).jod, 9.9)
        self.assertTrue(math.isfinite(found.difference))

    def test_function(self):
        def lambert(wi, wo):
            return np.full(wi.shape, .2 / np.pi)

        found = nqm.fit(lambert, "ggx", loss="log", bounds={"alpha": (.3, .5)}, **QUICK)
        np.testing.assert_allclose(found.brdf.albedo(), .2, rtol=.05)

    def test_visual_loss(self):
        start = "ggx:kd=.1;ks=.3;alpha=.2;f0=.8"
        found = nqm.fit("ggx:kd=.2;ks=.3;alpha=.2;f0=.8", "ggx", loss="nqm", start=start, **QUICK)
        self.assertLess(found.loss, nqm.score("ggx:kd=.2;ks=.3;alpha=.2;f0=.8", start).delta_e)

    def test_stop(self):
        def interrupt(stage, done, total):
            signal.raise_signal(signal.SIGINT)

        for options in ({"loss": "log"}, {"loss": "auto"}):
            with self.assertRaises(KeyboardInterrupt):
                nqm.fit("sgd:nickel", "ggx", progress=interrupt, **options)

    def test_interrupt(self):
        """Ctrl-C at any moment ends a call with KeyboardInterrupt, and the handler is the same afterwards."""
        def lambert(wi, wo):
            return np.full(wi.shape, .2 / np.pi)

        for delay, ref in ((.01, "sgd:nickel"), (.1, "sgd:nickel"), (.13, "sgd:nickel"), (.1, lambert), (.2, lambert)):
            caught = threading.Event()
            user = threading.Thread(target=press_ctrl_c, args=(delay, caught))
            user.start()
            with self.assertRaises(KeyboardInterrupt):
                while True:
                    nqm.fit(ref, "ggx")
            caught.set()
            user.join()
            self.assertIs(signal.getsignal(signal.SIGINT), signal.default_int_handler)

    def test_exception(self):
        def fails(wi, wo):
            raise ZeroDivisionError

        with self.assertRaises(ZeroDivisionError):
            nqm.fit(fails, "ggx", loss="log", **QUICK)

    def test_errors(self):
        self.assertIn("nbrdf", nqm.fit_models())
        for options, message in (({"model": "frog"}, "frog"), ({"loss": "frog"}, "frog"), ({"bounds": {"frog": (0, 1)}}, "frog"),
                                 ({"start": "frog:"}, "frog")):
            with self.assertRaisesRegex(nqm.Error, message) as caught:
                nqm.fit("sgd:nickel", **options)
            self.assertEqual(caught.exception.code, 2)
        with self.assertRaises(TypeError):
            nqm.fit("sgd:nickel", frog=1)


class Materials(unittest.TestCase):
    def test_files(self):
        spec = "gltf:base_color=.5,.2,.1;metallic=0;roughness=.4"
        with tempfile.TemporaryDirectory() as folder:
            path = folder + "/paint.gltf"
            nqm.BRDF.open(spec).save_material(path, "paint")
            (material,) = nqm.materials(path)
            self.assertEqual((material.name, material.refusal), ("paint", None))
            self.assertEqual(nqm.BRDF.open(material.spec).info.spec, nqm.BRDF.open(spec).info.spec)
            self.assertTrue(nqm.score(spec, path + ":paint").identical)
            with self.assertRaises(nqm.Error):
                nqm.BRDF.open("sgd:nickel").save_material(path)
            with self.assertRaises(ValueError):
                nqm.BRDF.from_function(lambda wi, wo: wi).save_material(path)
            with self.assertRaises(nqm.Error) as caught:
                nqm.materials(folder)
            self.assertEqual(caught.exception.code, 3)


    def test_within(self):
        with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as other:
            nqm.BRDF.open("gltf:roughness=.4").save_material(folder + "/a.gltf")
            nqm.files_within(other)
            try:
                with self.assertRaisesRegex(nqm.Error, "no file inside of"):
                    nqm.materials(folder + "/a.gltf")
            finally:
                nqm.files_within(None)
            self.assertEqual(len(nqm.materials(folder + "/a.gltf")), 1)
            with self.assertRaises(nqm.Error):
                nqm.files_within(folder + "/gone")


class Scenes(unittest.TestCase):
    def test_label(self):
        row = json.loads(run_tool("label", "sgd:nickel", "ward:nickel", "--light", "sun", "--shape", "sphere", "--points", "300",
                                  "--json"))["results"][0]
        scene = nqm.Scene("sun", "sphere", n_points=300)
        found = nqm.label("sgd:nickel", ["ward:nickel", "sgd:nickel"], scene=scene)
        self.assertEqual("%.9g %.9g" % (found[0].jod, found[0].delta_e), "%.9g %.9g" % (row["jod"], row["delta_e_itp"]))
        self.assertEqual((found[1].jod, found[1].delta_e), (10, 0))
        delta_e = scene.delta_e_map("sgd:nickel", "ward:nickel")
        self.assertAlmostEqual(float(delta_e @ scene.weights), found[0].delta_e, delta=.01 * found[0].delta_e)
        self.assertEqual(found[0].valid, 1)
        holes = nqm.BRDF.from_function(lambda wi, wo: np.where(wi[:, 2:] > .2, [.2, .2, .2], np.nan))
        whole = nqm.BRDF.from_function(lambda wi, wo: np.full(wi.shape, .2))
        seen = nqm.Scene("sun", n_points=50).label(whole, [holes, whole])
        self.assertEqual((seen[0].delta_e, seen[1].delta_e, seen[1].valid), (0, 0, 1))
        self.assertTrue(.9 < seen[0].valid < 1)
        self.assertFalse(nqm.Scene("sun", n_points=50).delta_e_map(whole, holes).any())
        with self.assertWarnsRegex(UserWarning, "no value for directions of"):
            nqm.Scene("sun", n_points=50).points(holes)
        with self.assertRaisesRegex(nqm.Error, "values at directions of 0.0 %"):
            nqm.Scene("sun", n_points=50).label(whole, nqm.BRDF.from_function(lambda wi, wo: np.full(wi.shape, np.nan)))
        small = nqm.Scene("sun", n_points=50).label("sgd:nickel", "ward:nickel")
        self.assertEqual(float(nqm.label("sgd:nickel", "ward:nickel", light="sun", n_points=50)), small.jod)

    def test_picture(self):
        image = nqm.render("lambert:kd=.5", width=16, background=-1)
        self.assertEqual(image.shape, (16, 16, 3))
        self.assertEqual(image[0, 0].tolist(), [-1] * 3)
        self.assertTrue((image[8, 8] > 0).all())
        np.testing.assert_allclose(nqm.render("lambert:kd=.25", width=16)[8, 8], image[8, 8] / 2, rtol=1e-9)
        self.assertEqual(nqm.render("lambert:kd=.5", width=12, height=8, n_frames=2).shape, (2, 8, 12, 3))
        self.assertEqual(nqm.srgb([[0, 400, 4000]]).tolist(), [[0, 255, 255]])

    def test_function(self):
        def fails(wi, wo):
            raise ZeroDivisionError

        with self.assertRaises(ZeroDivisionError):
            nqm.render(fails, width=8)

    def test_stop(self):
        def interrupt(stage, done, total):
            signal.raise_signal(signal.SIGINT)

        with self.assertRaises(KeyboardInterrupt):
            nqm.render("sgd:nickel", width=32, progress=interrupt)

    def test_errors(self):
        with self.assertRaises(nqm.Error):
            nqm.Scene("no-such-light.exr")
        with self.assertRaises(ValueError):
            nqm.Scene("sun", n_points=20).render("sgd:nickel")


class Rays(unittest.TestCase):
    def test_gradient(self):
        rays = nqm.Rays(512, 3)
        self.assertEqual((len(rays), 3), rays.weight.shape)
        np.testing.assert_allclose(np.linalg.norm(rays.wo, axis=1), 1)
        ref, test = rays.eval("sgd:nickel"), rays.eval("ward:nickel")
        value, gradient = rays.delta_e_grad(ref, test)
        self.assertEqual(rays.delta_e_grad(ref, ref)[0], 0)
        step = 1e-4 * test * np.random.default_rng(1).random(test.shape)
        change = rays.delta_e_grad(ref, test + step)[0] - rays.delta_e_grad(ref, test - step)[0]
        self.assertAlmostEqual(change / (2 * np.sum(gradient * step)), 1, places=4)
        self.assertAlmostEqual(nqm.Rays(512, 3).delta_e_grad(ref, test)[0], value, places=12)

    def test_mean(self):
        scene = nqm.Scene("studio", "sphere", n_points=400)
        label = scene.label("sgd:nickel", "ward:nickel").delta_e
        values = [r.delta_e_grad(r.eval("sgd:nickel"), r.eval("ward:nickel"))[0] for r in (nqm.Rays(4096, i, scene=scene) for i in range(20))]
        self.assertLess(abs(np.mean(values) / label - 1), .05)

    def test_errors(self):
        with self.assertRaisesRegex(nqm.Error, "64"):
            nqm.Rays(63)
        rays = nqm.Rays(64)
        with self.assertRaisesRegex(ValueError, "shape"):
            rays.delta_e_grad(np.ones((3, 3)), np.ones((3, 3)))
        with self.assertRaisesRegex(nqm.Error, "test has no finite value at ray 0"):
            rays.delta_e_grad(rays.wi, np.nan * rays.wi)


class Metrics(unittest.TestCase):
    def test_names(self):
        self.assertEqual([n for n in nqm.metrics() if not nqm.Metric(n).lower_better], ["jod", "similarity"])
        with self.assertRaisesRegex(ValueError, "rmse"):
            nqm.Metric("frog")

    def test_values(self):
        score = nqm.score("sgd:nickel", "ward:nickel")
        self.assertEqual(nqm.Metric("jod")("sgd:nickel", "ward:nickel"), score.jod)
        self.assertEqual(nqm.Metric("similarity")("sgd:nickel", "ward:nickel"), score.similarity)
        self.assertEqual(nqm.Metric("rmse")("sgd:nickel", ["ward:nickel", "sgd:nickel"]).tolist(), [score.metrics["rmse"], 0])
        ref, test = (nqm.BRDF.open(n).sample(nqm.Model.open().directions)[0] for n in ("sgd:nickel", "ward:nickel"))
        self.assertEqual(nqm.Metric("log_diff").samples(ref, test), score.metrics["log_diff"])

    def test_batch(self):
        pairs = [("sgd:nickel", "ward:nickel"), ("sgd:nickel", "/nowhere"), ("sgd:nickel", "sgd:nickel")]
        table = nqm.batch(pairs, metrics=True)
        score = nqm.score("sgd:nickel", "ward:nickel")
        self.assertEqual((table["jod"][0], table["high"][0], table["rmse"][0]), (score.jod, score.high, score.metrics["rmse"]))
        self.assertEqual(table["status"].tolist(), [0, -2, 0])
        self.assertTrue(math.isnan(table["jod"][1]) and table["identical"][2])
        with tempfile.TemporaryDirectory() as folder:
            with open(folder + "/pairs.csv", "w", newline="") as file:
                csv.writer(file).writerows([("test", "note", "reference"), *[(b, "x", a) for a, b in pairs]])
            self.assertEqual(nqm.batch(folder + "/pairs.csv")["jod"][0], score.jod)
            for text, faulty in (("\ufeff# a list\nReference; test;note\n\n sgd:nickel ;ward:nickel;1,5\n", "sgd:nickel\n"),
                                 ('{"test": "ward:nickel", "reference": "sgd:nickel", "note": [1]}\n', '{"reference": "sgd:nickel"}\n')):
                for added in ("", faulty):
                    with open(folder + "/list", "w", encoding="utf-8") as file:
                        file.write(text + added)
                    if added:
                        with self.assertRaisesRegex(nqm.Error, "list: line [0-9]+, byte [0-9]+: "):
                            nqm.batch(folder + "/list")
                    else:
                        table = nqm.batch(folder + "/list")
                        self.assertEqual((len(table), table["jod"][0], table["status"][0]), (1, score.jod, 0))
            with open(folder + "/other.csv", "w") as file:
                file.write("a,b\n")
            with self.assertRaises(nqm.Error) as caught:
                nqm.batch(folder + "/other.csv")
            self.assertEqual(caught.exception.code, 4)

    def test_ignored(self):
        with tempfile.TemporaryDirectory() as folder:
            path = folder + "/glass.gltf"
            with open(path, "w") as file:
                json.dump({"asset": {"version": "2.0"}, "materials": [{
                    "name": "glass", "pbrMetallicRoughness": {"metallicFactor": 0},
                    "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.5}}}]}, file)
            (material,) = nqm.materials(path)
            self.assertEqual((material.spec, material.ignorable), (None, "transmission"))
            self.assertIn("base_color=0.5", material.reflection)
            with self.assertRaisesRegex(nqm.Error, "--ignore transmission"):
                nqm.BRDF.open(path)
            brdf = nqm.BRDF.open(path, ignore="transmission,opacity")
            self.assertEqual(nqm.score(brdf, "ignore:transmission:" + path).jod, 10)
            self.assertEqual(nqm.Material.open(path, ignore="transmission").info.model, "gltf")
            with self.assertRaises(nqm.Error):
                nqm.BRDF.open(path, ignore="glass")

    def test_batch_of_materials(self):
        with tempfile.TemporaryDirectory() as folder:
            old, new = folder + "/old.gltf", folder + "/new.gltf"
            for path, names in ((old, ("red", "gone", "gold")), (new, ("gold", "red", "added"))):
                with open(path, "w") as file:
                    json.dump({"asset": {"version": "2.0"}, "materials": [{"name": n} for n in names]}, file)
            with open(folder + "/pairs.csv", "w") as file:
                file.write("reference,test\n%s,%s\nsgd:nickel,%s\nsgd:nickel,%s:red\n" % (old, new, new, new))
            with self.assertWarnsRegex(UserWarning, "new.gltf:added is not compared: .*old.gltf has no material of this name"):
                table = nqm.batch(folder + "/pairs.csv")
            with self.assertWarns(UserWarning):
                pairs = nqm.expand_pairs([(old, new), ("sgd:nickel", new), ("sgd:nickel", new + ":red")])
            self.assertEqual(pairs, [(old + ":" + n, new + ":" + n) for n in ("red", "gone", "gold")] +
                             [("sgd:nickel", new + ":" + n) for n in ("gold", "red", "added", "red")])
            self.assertEqual((table["status"] != 0).tolist(), [False, True, False, False, False, False, False])
            self.assertTrue(table["identical"][0] and table["identical"][2] and table["jod"][4] == table["jod"][6])


class Datasets(unittest.TestCase):
    def test_arrays(self):
        with tempfile.TemporaryDirectory() as folder:
            path = folder + "/tiny.safetensors"
            maker = BUILD + "/tests/tiny_dataset"
            if not os.path.exists(maker):
                self.skipTest("tests/tiny_dataset is not built")
            subprocess.run([maker, path, "1", "4", "parts"], check=True)
            data = nqm.Dataset.open(path)
            n, m = len(data), len(data.directions)
            self.assertEqual([len(getattr(data, k)) for k in ("jod", "delta_e", "split", "ref", "test", "group", "kind", "family",
                                                             "material_class", "source")], [n] * 10)
            self.assertEqual((data.ref_samples().shape, data.test_samples(0).shape), ((n, m, 3), (m, 3)))
            self.assertEqual((data.used(slice(2)).shape, data.parts([0, 1, 2]).shape), ((2, m), (3, 5)))
            masks = {"test_rgb": np.zeros((3, 2, 3)), "pair_ref": np.array([1, 0, 1]), "ref_used": np.array([[1, 0], [0, 1]]),
                     "test_used": np.array([[1, 1], [1, 1], [1, 0]])}  # the dataset above has none
            with unittest.mock.patch.object(data, "_tensors", masks):
                self.assertEqual(data.used().tolist(), [[False, True], [True, False], [False, False]])
                self.assertEqual(data.used(1).tolist(), [True, False])
            self.assertTrue(set(data.split) <= {"train", "validation", "test"})
            self.assertTrue(np.isfinite(data.jod).all() and len(data.sha256) == 64)
            with self.assertRaises(AttributeError):
                data.frog
            with open(path, "r+b") as file:
                file.seek(-1, os.SEEK_END)
                file.write(b"\xff")
            del data
            with self.assertRaises(nqm.Error) as caught:
                nqm.Dataset.open(path)
            self.assertEqual(caught.exception.code, 4)


class Tool(unittest.TestCase):
    def test_module(self):
        environment = dict(os.environ, NQM_LIBRARY=BUILD)
        del environment["NQM_TOOL"]
        run = subprocess.run([sys.executable, "-m", "nqm", "score", "-q", "sgd:nickel", "sgd:nickel"], stdout=subprocess.PIPE,
                             text=True, env=environment)
        self.assertEqual((run.returncode, run.stdout), (0, "10.0000\n"))
        missing = subprocess.run([sys.executable, "-m", "nqm", "score"], stderr=subprocess.PIPE, text=True,
                                 env=dict(environment, NQM_TOOL="/nowhere"))
        self.assertIn("/nowhere", missing.stderr)


if __name__ == "__main__":
    unittest.main()
