# SPDX-License-Identifier: MIT
"""studies/learn.py: its dictionary is that of the C code before it, its gradients are those of differences, and the library reads and uses its
files with small losses."""
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, os.path.join(os.environ["NQM_SOURCE"], "studies"))
import learn  # noqa: E402

FOUR = ["sgd:nickel", "sgd:green-plastic", "lambert:kd=0.4,0.2,0.1", "ward:pink-felt"]
VECTORS = os.path.join(os.environ["NQM_SOURCE"], "tests", "vectors", "learn_sparse.csv")
FIRST = [0, 6, 4, 3, 9, 7, 1, 5, 10, 2, 11, 8]


def losses(kind, path, n, names):
    """Losses of BRDFs encoded with a file by the C code."""
    program = os.path.join(os.environ["NQM_BUILD"], "tests", "encode_with")
    return np.array(subprocess.run([program, kind, path, str(n), *names], stdout=subprocess.PIPE, check=True).stdout.split(), float)


class Learn(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = os.path.join(folder.name, "encoder.safetensors")

    def test_dictionary_is_that_of_the_c_code(self):
        cell, typical, *atoms = np.loadtxt(VECTORS, delimiter=",", comments="#", skiprows=5).T
        cell = cell.astype(int)
        tensors, signals = learn.signals_of(FOUR)
        learned = learn.ksvd(signals, FIRST, 3).reshape(-1, *learn.BASIS)
        bases = [tensors[name] for name in ("basis.theta_h", "basis.theta_d", "basis.phi_d")]
        tables = np.einsum("aijk,ih,jd,kp->ahdp", learned, *bases, optimize=True).reshape(len(learned), -1)
        np.testing.assert_allclose(tensors["typical"].ravel()[cell], typical, rtol=1e-6)
        np.testing.assert_allclose(tables[:, cell], atoms, atol=2e-6)

    def test_dictionary_codes_what_it_was_learned_from(self):
        learn.write(self.path, "sparse", FOUR, 2, 3, learn.learn_sparse(FOUR, 2, 3))
        self.assertLess(losses("sparse", self.path, 8, FOUR).max(), 0.01)

    def test_gradients_are_those_of_differences(self):
        rng = np.random.default_rng(1)
        widths, learn.WIDTHS = learn.WIDTHS, (7, 6, 5, 6, 5)
        layers = [(w.astype(float), b.astype(float)) for w, b in learn.initial_layers(rng)]
        learn.WIDTHS = widths
        samples, inputs, cosine, goal = rng.normal(size=(3, 5, 13)), rng.normal(size=(3, 9, 6)), rng.random((3, 9, 1)), rng.random((3, 9, 3))
        layers[-1][0][:] *= 20

        def loss():
            weights, kept = learn.forward(layers, samples)
            value, slope = learn.nbrdf_loss(weights, inputs, cosine, goal)
            return value.sum(), learn.backward(layers, kept, slope)

        gradients = loss()[1]
        for p, gradient in zip([p for layer in layers for p in layer], gradients):
            direction, step = rng.normal(size=p.shape), 1e-5
            p += step * direction
            above = loss()[0]
            p -= 2 * step * direction
            slope = (above - loss()[0]) / (2 * step)
            p += step * direction
            self.assertAlmostEqual((gradient * direction).sum(), slope, delta=1e-4 * max(1, abs(slope)))

    def test_hypernetwork_learns(self):
        saved = learn.WIDTHS, learn.N_SETS
        learn.WIDTHS, learn.N_SETS = (32, 32, 48, 64, 64), 4
        names = ["lambert:kd=0.5", "ggx:kd=0.3,0.1,0.05;alpha=0.3", "ward:kd=0.1,0.2,0.3;ks=0.1;alpha=0.2"]
        found = []
        for steps in (1, 200):
            learn.write(self.path, "hyper", names, 1, steps, learn.learn_hyper(names, 1, steps))
            found.append(losses("hyper", self.path, 400, names).mean())
        learn.WIDTHS, learn.N_SETS = saved
        self.assertLess(found[1], 0.05, found)
        self.assertGreater(found[0], 0.1, found)

    def test_command_line(self):
        def run(*arguments):
            return subprocess.run([sys.executable, learn.__file__, *arguments], stderr=subprocess.PIPE, universal_newlines=True)

        self.assertEqual(run("sparse", *FOUR, "--steps", "1", "-o", self.path).returncode, 0)
        with open(self.path, "rb") as file:
            self.assertIn(rb'"references":"[\"sgd:nickel\",', file.read(2000))
        for words, arguments in (("all equal", ("sparse", "lambert:kd=0.3")), ("missing.bsdf", ("hyper", "missing.bsdf"))):
            failed = run(*arguments, "-o", f"{self.path}.none")
            self.assertNotEqual(failed.returncode, 0)
            self.assertIn(words, failed.stderr)
        self.assertNotEqual(run("sparse", *FOUR, "--steps", "1", "-o", f"{self.path}/x").returncode, 0)
        self.assertEqual(os.listdir(os.path.dirname(self.path)), ["encoder.safetensors"])


if __name__ == "__main__":
    unittest.main()
