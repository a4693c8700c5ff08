# SPDX-License-Identifier: MIT
"""BRDFs in Python: values, functions and tables, errors."""
import gc
import os
import pickle
import subprocess
import sys
import tempfile
import threading
import unittest

import numpy as np

import nqm


def directions(n, seed=1):
    """(n, 3) unit vectors above the horizon."""
    v = np.random.default_rng(seed).normal(size=(n, 3))
    v[:, 2] = np.abs(v[:, 2]) + .01
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def phong(wi, wo):
    """Blinn-Phong as in doc/brdf.md: kd / pi + ks (n + 2) / (2 pi) cos^n, here with ks / 3 as examples/score_renderer.c has it."""
    h = wi + wo
    cos_h = h[:, 2] / np.linalg.norm(h, axis=1)
    return np.array([.2, .1, .05]) / np.pi + (.05 * 92 / (2 * np.pi) * cos_h**90)[:, None]


class Values(unittest.TestCase):
    def test_lambert(self):
        brdf = nqm.BRDF.open("lambert:kd=.3,.2,.1")
        value = brdf.eval(directions(5), directions(5, 2))
        np.testing.assert_allclose(value, np.broadcast_to(np.array([.3, .2, .1]) / np.pi, (5, 3)), rtol=1e-14)
        self.assertEqual(brdf.eval([0, 0, 1], directions(6).reshape(2, 3, 3)).shape, (2, 3, 3))
        np.testing.assert_allclose(brdf.albedo(), [.3, .2, .1], rtol=1e-6)
        self.assertEqual(brdf.albedo([0, .5]).shape, (2, 3))

    def test_flags(self):
        rgb, flag = nqm.BRDF.open("lambert:kd=.3").eval_flags([[0, 0, 1], [0, .6, -.8]], [0, 0, 1])
        self.assertEqual(flag.tolist(), [0, 3])
        self.assertEqual(rgb[1].tolist(), [0, 0, 0])

    def test_to_table(self):
        table = nqm.BRDF.open("lambert:kd=.3").to_table(3, 4, 5)
        wi, wo = nqm.half_diff_to_directions(nqm.table_nodes(3, 4, 5))
        below = (wi[..., 2] <= 0) | (wo[..., 2] <= 0)
        self.assertTrue(0 < below.sum() < below.size)
        np.testing.assert_array_equal(np.isnan(table), np.broadcast_to(below[..., None], table.shape))
        holes = nqm.BRDF.from_function(lambda wi, wo: np.where(wi[:, 2:] > .9, [.2, .2, .2], np.nan)).to_table(3, 4, 5)
        np.testing.assert_array_equal(np.isnan(holes[..., 0]), below | (wi[..., 2] <= .9))

    def test_info(self):
        info = nqm.BRDF.open("ggx:kd=.2,.1,.05;ks=.3;alpha=.1;f0=.8").info
        self.assertEqual((info.format, info.n_bytes, info.reciprocal), ("ggx", 0, True))
        self.assertEqual(nqm.BRDF.open(info.spec).info.spec, info.spec)
        self.assertIn("sgd:nickel", nqm.presets())

    def test_half_diff(self):
        wi, wo = directions(50), directions(50, 2)
        brdf = nqm.BRDF.open("sgd:nickel")
        hd = nqm.directions_to_half_diff(wi, wo)
        np.testing.assert_allclose(brdf.eval_half_diff(hd), brdf.eval(wi, wo), rtol=1e-9)
        a, b = nqm.half_diff_to_directions(hd)
        np.testing.assert_allclose(np.sum(a * b, 1), np.sum(wi * wo, 1), atol=1e-12)

    def test_jacobian(self):
        spec = "ggx:kd=.2,.1,.05;ks=.3;alpha=%.17g,.3;f0=.8"
        wi, wo = directions(4), directions(4, 2)
        brdf = nqm.BRDF.open(spec % .3)
        rgb, jacobian = brdf.jacobian(wi, wo)
        np.testing.assert_array_equal(rgb, brdf.eval(wi, wo))
        self.assertEqual(jacobian.shape, (4, 3, brdf.info.n_values))
        step = 1e-6
        slope = (nqm.BRDF.open(spec % (.3 + step)).eval(wi, wo) - nqm.BRDF.open(spec % (.3 - step)).eval(wi, wo)) / (2 * step)
        np.testing.assert_allclose(np.min(np.abs(jacobian - slope[..., None]), axis=-1), 0, atol=1e-6)
        with self.assertRaises(nqm.Error):
            nqm.BRDF.from_function(phong).jacobian(wi, wo)

    def test_check(self):
        report = nqm.BRDF.open("lambert:kd=.5").check()
        self.assertEqual(report.n_invalid, 0)
        np.testing.assert_allclose(report.albedo_max, .5, rtol=1e-6)


class Functions(unittest.TestCase):
    def test_values(self):
        brdf = nqm.BRDF.from_function(phong, reciprocal=True)
        wi, wo = directions(1500), directions(1500, 2)
        np.testing.assert_array_equal(brdf.eval(wi, wo), phong(wi, wo))
        self.assertEqual((brdf.info.format, brdf.name, brdf.info.reciprocal), ("callback", "phong", True))

    def test_negative_and_missing(self):
        values = np.array([[-1., .5, .5], [np.nan, 0, 0], [1, 1, 1]])
        rgb, flag = nqm.BRDF.from_function(lambda wi, wo: values).eval_flags(directions(3), [0, 0, 1])
        self.assertEqual(flag.tolist(), [1, 2, 0])
        self.assertEqual(rgb.tolist(), [[0, .5, .5], [0, 0, 0], [1, 1, 1]])

    def test_exception(self):
        calls = []

        def fails(wi, wo):
            calls.append(len(wi))
            raise KeyError("colour")

        brdf = nqm.BRDF.from_function(fails)
        for use in (lambda: brdf.eval(directions(2000), [0, 0, 1]), brdf.check, brdf.albedo,
                    lambda: nqm.score("sgd:nickel", brdf), lambda: nqm.score(brdf, ["sgd:nickel"])):
            calls.clear()
            with self.assertRaisesRegex(KeyError, "colour"):
                use()
            self.assertEqual(len(calls), 1)

    def test_shape(self):
        for result in (0.5, np.ones(3), np.ones((3, 1)), np.ones((4, 3))):
            with self.assertRaisesRegex(ValueError, r"\(n, 3\)"):
                nqm.BRDF.from_function(lambda wi, wo, r=result: r).eval(directions(3), [0, 0, 1])

    def test_threads(self):
        brdf = nqm.BRDF.from_function(phong)
        exact = nqm.score("sgd:nickel", brdf).jod
        found = []
        threads = [threading.Thread(target=lambda: found.append(nqm.score("sgd:nickel", brdf).jod)) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(found, [exact] * 4)

    def test_compare(self):
        brdf = nqm.BRDF.from_function(phong)
        self.assertTrue(nqm.compare(brdf, brdf).equal)
        wrong = nqm.BRDF.from_function(lambda wi, wo: phong(wi, wo) * np.where(wo[:, 2:] < .1, [1, .75, 1], 1))
        d = nqm.compare(brdf, wrong)
        self.assertEqual((d.equal, d.channel, d.n_pairs, d.n_missing), (False, 1, 8192, 0))
        self.assertAlmostEqual(d.largest, .25)
        self.assertLess(d.wo[2], .1)
        np.testing.assert_allclose([d.ref, d.test], phong(np.array([d.wi]), np.array([d.wo]))[0, 1] * np.array([1, .75]))
        self.assertTrue(nqm.compare(brdf, wrong, tolerance=.3).equal)

    def test_reentry(self):
        """A function that calls what is calling it, and one that uses the scorer which is scoring it."""
        scorer = nqm.Scorer()

        def recursive(wi, wo):
            return itself.eval(wi, wo)

        itself = nqm.BRDF.from_function(recursive)
        busy = nqm.BRDF.from_function(lambda wi, wo: phong(wi, wo) * scorer.score("sgd:nickel", "ward:nickel").jod)
        for use in (lambda: itself.eval(directions(3), [0, 0, 1]), lambda: scorer.score("sgd:nickel", itself), itself.check,
                    lambda: scorer.score("sgd:nickel", busy)):
            with self.assertRaisesRegex(nqm.Error, "one of its own"):
                use()
        other = nqm.BRDF.from_function(lambda wi, wo: phong(wi, wo) * (nqm.score("sgd:nickel", "ward:nickel").jod > 0))
        self.assertEqual(scorer.score("sgd:nickel", other).jod, scorer.score("sgd:nickel", nqm.BRDF.from_function(phong)).jod)

    def test_fork(self):
        """The child of a process that has used threads computes the same with one."""
        code = ("import nqm, os, sys\npairs = [('sgd:nickel', 'ward:%s' % n) for n in ('nickel', 'brass', 'alumina_oxide')]\n"
                "jod = nqm.batch(pairs)['jod'].tolist()\nchild = os.fork()\n"
                "if not child:\n    os._exit(nqm.batch(pairs)['jod'].tolist() != jod)\nsys.exit(os.waitpid(child, 0)[1])\n")
        subprocess.run([sys.executable, "-c", code], check=True, timeout=1800, env={**os.environ, "OMP_NUM_THREADS": "2"})

    def test_lifetime(self):
        class Big:
            alive = 0

            def __init__(self):
                Big.alive += 1

            def __del__(self):
                Big.alive -= 1

            def __call__(self, wi, wo):
                return np.ones_like(wi)

        for _ in range(20):
            nqm.BRDF.from_function(Big()).eval([0, 0, 1], [0, 0, 1])
        gc.collect()
        self.assertEqual(Big.alive, 0)


class Tables(unittest.TestCase):
    def test_round_trip(self):
        nodes = nqm.table_nodes(9, 7, 8)
        table = nqm.BRDF.open("ggx:kd=.2,.1,.05;ks=.3;alpha=.4;f0=.8").eval_half_diff(nodes).astype(np.float32)
        brdf = nqm.BRDF.from_table(table, name="small")
        flat = nodes[1:-1, 1:-1]  # inside the hemisphere
        np.testing.assert_allclose(brdf.eval_half_diff(flat), table[1:-1, 1:-1], rtol=1e-5, atol=1e-7)
        with tempfile.TemporaryDirectory() as folder:
            brdf.save(folder + "/table.safetensors")
            again = nqm.BRDF.open(folder + "/table.safetensors")
            np.testing.assert_array_equal(again.eval_half_diff(flat), brdf.eval_half_diff(flat))
            with self.assertRaises(nqm.Error):
                nqm.BRDF.open("sgd:nickel").save(folder + "/x")

    def test_shape(self):
        with self.assertRaisesRegex(ValueError, "n_theta_h"):
            nqm.BRDF.from_table(np.ones((3, 3, 3)))
        with self.assertRaises(nqm.Error):
            nqm.BRDF.from_table(np.full((3, 3, 3, 3), np.inf))


class Errors(unittest.TestCase):
    def test_codes(self):
        with self.assertRaises(nqm.Error) as caught:
            nqm.BRDF.open("/does/not/exist")
        error = caught.exception
        self.assertEqual((error.status, error.code, error.byte), (nqm.Status.IO, 3, None))
        self.assertEqual(str(error), "/does/not/exist: No such file or directory")
        copy = pickle.loads(pickle.dumps(error))
        self.assertEqual((str(copy), copy.status, copy.code), (str(error), error.status, 3))
        with self.assertRaises(nqm.Error) as caught:
            nqm.BRDF.open("ggx:kd=frog")
        self.assertEqual(caught.exception.code, 2)

    def test_byte(self):
        with tempfile.NamedTemporaryFile(suffix=".binary") as file:
            file.write(np.array([90, 90, 180], np.int32).tobytes() + bytes(100))
            file.flush()
            with self.assertRaises(nqm.Error) as caught:
                nqm.BRDF.open(file.name)
        self.assertEqual(caught.exception.code, 4)
        self.assertIsInstance(caught.exception.byte, int)

    def test_arguments(self):
        for call in (lambda: nqm.BRDF.open("a\0b"), lambda: nqm.BRDF.open("sgd:nickel").eval([0, 1], [0, 0, 1]),
                     lambda: nqm.BRDF.open("sgd:nickel").albedo(2)):
            with self.assertRaises(ValueError):
                call()
        with self.assertRaises(TypeError):
            nqm.BRDF()
        with self.assertRaises(TypeError):
            nqm.score("sgd:nickel", 3)


class Sets(unittest.TestCase):
    def test_directions(self):
        made = nqm.Directions.create(50, seed=3, references=["sgd:nickel"])
        self.assertEqual(len(made), 50)
        with tempfile.TemporaryDirectory() as folder:
            made.save(folder + "/d.csv")
            self.assertEqual(nqm.Directions.open(folder + "/d.csv").id, made.id)
        self.assertEqual(nqm.Directions.from_degrees(made.degrees).id, made.id)
        wi, wo = made.vectors
        rgb, flag = nqm.BRDF.open("sgd:nickel").sample(made)
        np.testing.assert_allclose(rgb, nqm.BRDF.open("sgd:nickel").eval(wi, wo), rtol=1e-5)
        self.assertFalse(flag.any())
        with self.assertRaises(TypeError):
            nqm.Directions.create(5, frogs=1)


if __name__ == "__main__":
    unittest.main()
