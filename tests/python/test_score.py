# SPDX-License-Identifier: MIT
"""Scores in Python: equal to those of the tool, gradients against central differences, many pairs, errors."""
import csv
import json
import math
import os
import pickle
import tempfile
import unittest

import numpy as np

import nqm
from support import run_tool

TESTS = ["ward:nickel", "perturb:gloss=0.9;of=sgd:nickel", "sgd:nickel"]


def samples(*names):
    directions = nqm.Model.open().directions
    return [nqm.BRDF.open(name).sample(directions)[0] for name in names]


def close(test, found, printed):
    """Equal to the nine digits that the tool prints."""
    test.assertEqual(["%.9g" % x for x in found], ["%.9g" % x for x in printed])


class Scores(unittest.TestCase):
    def test_as_the_tool(self):
        printed = json.loads(run_tool("score", "sgd:nickel", *TESTS, "--json", "--metrics", "all"))["results"]
        for s, row in zip(nqm.score("sgd:nickel", TESTS), printed):
            parts, own = row["parts"], s.parts
            close(self, [s.jod, s.low, s.high, s.delta_e], [row["jod"], row["jod_low"], row["jod_high"], row["delta_e_itp"]])
            close(self, [s.novelty, s.similarity, *own.shift], [row["novelty"], parts["similarity_jod"], *parts["shift_itp"]])
            self.assertEqual((s.identical, s.n_valid, own.words), (row["identical"], row["n_valid"], parts["words"]))
            self.assertEqual(list(s.metrics), list(row["metrics"]))
            close(self, list(s.metrics.values()), list(row["metrics"].values()))

    def test_one(self):
        s = nqm.score("sgd:nickel", "ward:nickel")
        self.assertIsInstance(s, nqm.Score)
        self.assertEqual(float(s), s.jod)
        self.assertTrue(s.low <= s.jod <= s.high)
        self.assertEqual((s.ref, s.test), ("sgd:nickel", "ward:nickel"))
        self.assertEqual(nqm.score("sgd:nickel", "sgd:nickel").prefer_reference, .5)
        self.assertEqual(nqm.score("sgd:nickel", "ward:nickel", metrics=False).metrics, {})

    def test_models(self):
        self.assertIn("default", nqm.models())
        info = nqm.Model.open().info
        self.assertEqual((info.id, len(info.sha256), info.calibrated), ("default", 64, True))
        with self.assertRaisesRegex(nqm.Error, "built in are") as caught:
            nqm.score("sgd:nickel", "ward:nickel", model="frog")
        self.assertEqual(caught.exception.code, 6)

    def test_warnings(self):
        def dark(wi, wo):
            return np.where(wi[:, :1] > .2, -1, .1) * np.ones(3)

        s = nqm.score("lambert:kd=.3", dark)
        self.assertRegex(s.warnings[0], "^dark: negative channel at [0-9]+ of 1872 directions, taken as 0$")
        self.assertTrue(str(s).endswith("] (%s)" % "; ".join(s.warnings)), s)

    def test_suspicions(self):
        def times(factor, cosine):
            def f(wi, wo):
                return nickel.eval(wi, wo) * (factor * (wo[:, 2:] if cosine else 1))
            return f

        nickel = nqm.BRDF.open("sgd:nickel")
        scaled, with_cosine, fit = nqm.score("sgd:nickel", [times(255, False), times(1, True), "ward:nickel"])
        pi, by_pi, other = nqm.score("sgd:nickel", [times(np.pi, False), times(1 / np.pi, False), times(3, False)])
        self.assertEqual(pi.warnings[-1], "f: its reference times pi at nearly all directions: a Lambertian f_r is its albedo / pi")
        self.assertRegex(by_pi.warnings[-1], "^f: its reference divided by pi at nearly all directions")
        self.assertEqual(other.warnings, ())
        self.assertRegex(scaled.warnings[-1], "^f: about 255 times its reference at most directions: is a scale missing")
        self.assertRegex(with_cosine.warnings[-1], "^f: about its reference times the cosine of light or viewer")
        self.assertEqual(fit.warnings, ())
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "few.csv")
            with open(path, "w") as out:
                out.write("theta_h,theta_d,phi_d,r,g,b\n0,0,0,1,1,1\n30,30,90,1,1,1\n45,10,0,1,1,1\n")
            far = nqm.score(path + ":45", "lambert:kd=.3", min_valid=0)
            self.assertRegex(far.warnings[0], "its nearest row is [0-9.]+ degrees")
            with open(path, "w") as out:
                out.write("sample,theta_h,theta_d,phi_d,r,g,b\na,0,0,0,1,1,1\n")
            for s in nqm.score(path + ":45", "lambert:kd=.3", min_valid=0), nqm.score_many([(path, "lambert:kd=.3")], errors="keep")[0]:
                self.assertIn("column 'sample' is not used", " ".join(s.warnings))
            with open(path, "w") as out:
                out.write("theta_h,theta_d,phi_d,r,g,b\n0,0,0,1,1,1\n")
            self.assertIn("nearest row", nqm.score_many([(path, "lambert:kd=.3")], errors="keep")[0].warnings[0])

    def test_too_few_values(self):
        def empty(wi, wo):
            return np.full(wi.shape, np.nan)

        with self.assertRaises(nqm.Error) as caught:
            nqm.score("lambert:kd=.3", empty)
        self.assertEqual(caught.exception.code, 5)
        kept = nqm.score("lambert:kd=.3", [empty, "lambert:kd=.3", "/nowhere"], errors="keep")
        self.assertEqual([s.error.code if s.error else 0 for s in kept], [5, 0, 3])
        self.assertTrue(math.isnan(kept[0].jod) and math.isnan(kept[2].jod) and kept[1].jod == 10)
        self.assertEqual([s.parts is None for s in kept], [True, False, True])  # not "no visible difference"
        self.assertEqual([(s.verdict, s.row["words"]) for s in kept], [("", ""), ("identical", "no visible difference"), ("", "")])

    def test_row(self):
        score = nqm.score("sgd:nickel", "ward:nickel")
        of_tool, = csv.DictReader(run_tool("score", "sgd:nickel", "ward:nickel", "--csv").decode().splitlines())
        of_python = score.row
        self.assertEqual([k for k in of_tool if k not in ("name", "warnings", "error")], list(of_python))
        for name, value in of_python.items():
            self.assertEqual(of_tool[name], value if isinstance(value, str) else "%.9g" % value, name)
        self.assertEqual(pickle.loads(pickle.dumps(score)).row, of_python)

    def test_many(self):
        brdf = nqm.BRDF.open("sgd:nickel")
        pairs = [("sgd:nickel", test) for test in TESTS] * 100 + [(brdf, "ward:nickel"), ("sgd:nickel", "/nowhere")]
        seen = []
        found = nqm.score_many(pairs, progress=lambda stage, done, total: seen.append((done, total)), errors="keep", metrics=False)
        self.assertEqual(seen, [(0, 302), (256, 302), (302, 302)])
        exact = [s.jod for s in nqm.score("sgd:nickel", TESTS)]
        self.assertEqual([s.jod for s in found[:300]], exact * 100)
        self.assertEqual(found[300].jod, exact[0])
        self.assertEqual((found[301].error.code, found[301].test), (3, "/nowhere"))
        with self.assertRaises(nqm.Error):
            nqm.score_many(pairs[-1:])

    def test_stop(self):
        def stop(stage, done, total):
            raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            nqm.score_many([("sgd:nickel", "ward:nickel")], progress=stop)
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaises(KeyboardInterrupt):
                nqm.BRDF.open("sgd:nickel").save_table(folder + "/x.binary", progress=stop)
            self.assertEqual(os.listdir(folder), [])


class Samples(unittest.TestCase):
    def test_samples(self):
        ref, test = samples("sgd:nickel", "ward:nickel")
        exact = nqm.score("sgd:nickel", "ward:nickel").jod
        self.assertEqual(nqm.score_samples(ref, test).jod, exact)
        both = nqm.score_samples(ref, np.stack([test, ref]))
        self.assertEqual([s.jod for s in both], [exact, 10])
        used = np.ones(1872, bool)
        used[:20] = False
        self.assertEqual(nqm.score_samples(ref, test, used=used).n_valid, 1852)
        odd = test.copy()
        odd[3], odd[4], odd[5] = np.nan, np.inf, -1
        self.assertEqual(nqm.score_samples(ref, odd, used=used).jod, nqm.score_samples(ref, test, used=used).jod)
        self.assertTrue(np.isfinite(nqm.score_grad(odd, ref, used=used)[1]).all())
        for wrong in (test[:10], test.T, np.ones(3)):
            with self.assertRaisesRegex(ValueError, r"\(1872, 3\)"):
                nqm.score_samples(ref, wrong)
        with self.assertRaisesRegex(nqm.Error, "direction"):
            nqm.score_samples(ref, -test)

    def test_gradient(self):
        ref, test = samples("sgd:nickel", "ward:nickel")
        for of in ("jod", "delta_e"):
            value, gradient = nqm.score_grad(ref, test, of=of)
            self.assertAlmostEqual(value, getattr(nqm.score_samples(ref, test), of), delta=.001 if of == "jod" else .05)
            scorer, worst = nqm.Scorer(metrics=False), 0
            for seed in range(3):
                # All samples change by a random fraction, so that the difference is far above the float error of the network.
                change = np.random.default_rng(seed).uniform(0, 1, test.shape) * test
                step = .01
                ends = [scorer.score_grad(ref, test + s * step * change, of=of)[0] for s in (1, -1)]
                slope = (ends[0] - ends[1]) / (2 * step)
                worst = max(worst, abs(slope - np.sum(gradient * change)) / abs(slope))
            self.assertLess(worst, .02)
        values, gradients = nqm.score_grad(ref, np.stack([test, test]), of="jod")
        self.assertEqual((values.shape, gradients.shape), ((2,), (2, 1872, 3)))
        np.testing.assert_array_equal(gradients[0], gradients[1])


if __name__ == "__main__":
    unittest.main()
