# SPDX-License-Identifier: MIT
"""nqm.torch.Metric against NumPy (tests/vectors/metric.py, in double) and the C library (in float), its derivatives, torch.compile and ONNX.
Skipped without torch. NQM_DOCS=full: 1,000 pairs."""
import contextlib
import csv
import importlib.util
import io
import math
import os
import re
import shutil
import sys
import unittest

import numpy as np

import nqm

if importlib.util.find_spec("torch") is None:
    print("skipped: there is no torch")
    sys.exit(77)
import torch  # noqa: E402

sys.path.insert(0, os.environ["NQM_SOURCE"] + "/tests/vectors")
import metric as specification  # noqa: E402

N_PAIRS = 1000 if os.environ.get("NQM_DOCS") == "full" else 20


def pairs_of(name, n, seed=1):
    degrees = nqm.Model.open(name).directions.degrees
    return np.array([[specification.samples(p, degrees) for p in pair] for pair in specification.pairs(n, seed)]).swapaxes(0, 1)


def scores(metric, *samples):
    """In batches: each of 1,000 pairs has 1,872 directions."""
    with torch.no_grad():
        return torch.cat([metric(*map(torch.as_tensor, block)) for block in zip(*(np.array_split(s, -(-len(s) // 50)) for s in samples))])


class Values(unittest.TestCase):
    def test_vectors(self):
        """The file of doc/model-format.md, also by the library."""
        with open(specification.HERE + "/metric.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(line for line in file if line[0] != "#"))
        for column in ("default_jod", "default_delta_e", "transport_jod", "transport_delta_e", "paper_jod"):
            name, of = column.split("_", 1)
            degrees = nqm.Model.open(name).directions.degrees
            ref, test = [np.array([specification.samples([float(row[side + key]) for key in "rgbsnk"], degrees) for row in rows])
                         for side in ("ref_", "test_")]
            used = np.array([np.arange(len(degrees)) % 11 > 0 if row["left_out"] == "11" else np.ones(len(degrees), bool) for row in rows])
            expected = np.array([float(row[column]) for row in rows])
            unit = np.ones(len(rows)) if of == "jod" else 3 * np.maximum(expected, 1)
            for dtype, limit in ((torch.float64, 1e-9), (torch.float32, 1e-5)):
                found = scores(nqm.torch.Metric(name, of=of, dtype=dtype), ref, test, used).numpy()
                self.assertLess(np.max(np.abs(found - expected) / unit), limit, (column, dtype))
            by_library, _ = nqm.score_grad(ref, test, of=of, used=used, model=name)
            self.assertLess(np.max(np.abs(by_library - expected) / unit), 2e-5, column)

    def test_page(self):
        """The last column of the table in doc/web.md."""
        with open(os.environ["NQM_SOURCE"] + "/doc/web.md", encoding="utf-8") as file:
            rows = re.findall(r"^\| `(\S+)` \| `(\S+)` \| (\S+) \| \S+ \| (\S+) \|$", file.read(), re.M)
        self.assertGreaterEqual(len(rows), 5)
        metric = nqm.torch.Metric()
        for ref, test, score, value in rows:
            samples = [torch.as_tensor(nqm.BRDF.open(name).eval(metric.wi.numpy(), metric.wo.numpy())) for name in (ref, test)]
            self.assertAlmostEqual(nqm.score(ref, test).jod, float(score), delta=1e-5)
            self.assertAlmostEqual(metric(*samples).item(), float(value), delta=2e-5)

    def test_pairs(self):
        for name in specification.MODELS:
            ref, test = pairs_of(name, N_PAIRS)
            found = [scores(nqm.torch.Metric(name, dtype=dtype), ref, test).numpy() for dtype in (torch.float32, torch.float64)]
            by_library = np.concatenate([nqm.score_grad(a, b, model=name)[0] for a, b in zip(np.array_split(ref, 20), np.array_split(test, 20))])
            opened = specification.model(name)
            used = np.ones(ref.shape[1], bool)
            exact = np.array([specification.score(a, b, used, *opened)[1] for a, b in zip(ref, test)])
            errors = [np.max(np.abs(x - y)) for x, y in ((found[0], by_library), (found[1], exact), (found[0], exact))]
            print("%s: %d pairs, largest differences in JOD: float32 from the C library %.1e, float64 from NumPy %.1e, float32 from NumPy %.1e" %
                  (name, N_PAIRS, *errors))
            self.assertLess(errors[0], 2e-5 if name == "paper" else 1e-5)  # the library's own rounding in "paper" is 1e-5
            self.assertLess(errors[1], 1e-9)
            self.assertLess(errors[2], 1e-5)

    def test_shapes(self):
        ref, test = map(torch.tensor, pairs_of("default", 4))
        metric = nqm.torch.Metric(dtype=torch.float64)
        one = metric(ref[1], test[1])
        self.assertEqual(one.shape, ())
        np.testing.assert_allclose(metric(ref[1], test[:, None])[1].numpy(), [one.item()], rtol=1e-12)
        self.assertEqual(metric(ref.reshape(2, 2, -1, 3), test[0]).shape, (2, 2))
        used = torch.ones(len(metric.wi), dtype=torch.bool)
        used[::5] = False
        changed = torch.where(used[:, None], test[1], 7 * test[1])
        self.assertEqual(metric(ref[1], changed, used).item(), metric(ref[1], test[1], used).item())

    def test_not_finite(self):
        """A value that counts makes its pair NaN, in any of the three channels; one that is left out does not count."""
        for name in specification.MODELS:
            ref, test = map(torch.tensor, pairs_of(name, 2))
            metric = nqm.torch.Metric(name)
            used = torch.arange(len(metric.wi)) % 5 > 0
            exact, exact_used = metric(ref, test), metric(ref, test, used)
            for bad in (math.nan, math.inf, -math.inf):
                for place in ((7, 1), (11,), (slice(None),)):
                    odd = test.clone()
                    odd[(1, *place)] = bad
                    for pair in ((ref, odd), (odd, ref)):
                        self.assertEqual(metric(*pair).isnan().tolist(), [False, True], (name, bad, place))
                    self.assertEqual(metric(ref, odd)[0], exact[0])
                masked = torch.where(used[:, None], test, torch.full_like(test, bad)).requires_grad_()
                value = metric(ref, masked, used)
                self.assertEqual(value.tolist(), exact_used.tolist())
                value.sum().backward()
                self.assertTrue(masked.grad.isfinite().all())
                self.assertTrue(metric(torch.where(used[:, None], ref, torch.full_like(ref, bad)), test, used).isfinite().all())
            with self.assertRaisesRegex(ValueError, "no direction"):
                metric(ref, test, torch.stack([used, torch.zeros_like(used)]))

    def test_autocast(self):
        for name in specification.MODELS:
            ref, test = [torch.tensor(x[1], dtype=torch.float32) for x in pairs_of(name, 2)]
            metric = nqm.torch.Metric(name)
            with torch.autocast("cpu", dtype=torch.bfloat16):
                inside = metric(ref, test).item()
            self.assertEqual(inside, metric(ref, test).item())

    def test_types(self):
        """Half precision and negative values; no step leaves the device: "meta" has no values, and refuses those of another."""
        ref, test = map(torch.tensor, pairs_of("default", 2))
        exact = nqm.torch.Metric()(ref[1], test[1]).item()
        self.assertAlmostEqual(nqm.torch.Metric()(ref[1].half(), test[1].half()).item(), exact, delta=.01)
        self.assertEqual(nqm.torch.Metric()(ref[1], torch.where(test[1] > .2, test[1], -torch.ones(()))),
                         nqm.torch.Metric()(ref[1], torch.where(test[1] > .2, test[1], torch.zeros(()))))
        self.assertEqual(len(nqm.torch.Metric().state_dict()), 0)
        metric = nqm.torch.Metric(device="meta")
        self.assertEqual(metric(ref.to("meta"), test.to("meta")).device.type, "meta")

    def test_errors(self):
        with self.assertRaisesRegex(ValueError, "anisotropic"):
            nqm.torch.Metric("anisotropic")
        for arguments in ({"of": "ssim"}, {"model": "paper", "of": "delta_e"}):
            with self.assertRaisesRegex(ValueError, "of is jod or delta_e"):
                nqm.torch.Metric(**arguments)
        metric = nqm.torch.Metric()
        x = torch.ones(len(metric.wi), 3)
        for arguments, words in (((x[:5], x), r"ref has the shape \(5, 3\)"), ((x, x.T), r"test has the shape \(3, 1872\)"),
                                 ((x, x, torch.ones(5)), r"used has the shape \(5,\)")):
            with self.assertRaisesRegex(ValueError, words):
                metric(*arguments)


class Derivatives(unittest.TestCase):
    @staticmethod
    def smooth_pair(name):
        """No value of the test is near that of the reference, where an absolute value has a kink, and each has one maximum."""
        ref = torch.tensor(pairs_of(name, 2)[0][1])
        test = 1.3 * ref + torch.tensor([.05, .03, .02])
        return ref, test * (1 + .02 * torch.rand(len(ref), 1, generator=torch.Generator().manual_seed(2), dtype=ref.dtype))

    def test_gradcheck(self):
        """First and second derivatives by both BRDFs, along random directions."""
        generator = torch.Generator().manual_seed(1)
        for name in specification.MODELS:
            ref, test = self.smooth_pair(name)
            steps = torch.rand((2, *ref.shape), generator=generator, dtype=torch.float64) * torch.stack([ref, test])
            for of in ("jod", "delta_e")[:1 if name == "paper" else 2]:
                metric = nqm.torch.Metric(name, of=of, dtype=torch.float64)

                def along(a, b):
                    return metric(ref + a * steps[0], test + b * steps[1])

                at = [torch.tensor(x, dtype=torch.float64, requires_grad=True) for x in (.01, .03)]
                self.assertTrue(torch.autograd.gradcheck(along, at, eps=1e-6, atol=1e-6, rtol=1e-5))
                self.assertTrue(torch.autograd.gradgradcheck(along, at, eps=1e-6, atol=1e-5, rtol=1e-4))

    def test_gradient_of_the_library(self):
        for name in specification.MODELS:
            ref, test = self.smooth_pair(name)
            leaf = test.float().requires_grad_()
            nqm.torch.Metric(name)(ref, leaf).backward()
            _, expected = nqm.score_grad(ref.numpy(), test.numpy(), model=name)
            self.assertLess(np.linalg.norm(leaf.grad.numpy() - expected), 1e-4 * np.linalg.norm(expected), name)

    def test_equal_and_black(self):
        """Finite derivatives of both orders where roots and absolute values have none."""
        ref, _ = map(torch.tensor, pairs_of("default", 1))
        for test in (ref[0], torch.zeros_like(ref[0])):
            for of in ("jod", "delta_e"):
                leaf = test.float().requires_grad_()
                value = nqm.torch.Metric(of=of)(ref[0], leaf)
                gradient, = torch.autograd.grad(value, leaf, create_graph=True)
                second, = torch.autograd.grad((gradient * torch.linspace(0, 1, len(leaf))[:, None]).sum(), leaf)
                self.assertTrue(gradient.isfinite().all() and second.isfinite().all())
        self.assertEqual(nqm.torch.Metric()(ref[0], ref[0]).item(), 10)


class Example(unittest.TestCase):
    def test_fits(self):
        """The GGX of examples/fit_torch.py is that of nqm, and its network is trained."""
        sys.path.insert(0, os.environ["NQM_SOURCE"] + "/examples")
        import fit_torch

        metric = nqm.torch.Metric(dtype=torch.float64)
        parameters = torch.tensor([-2., -3, -1.5, 0, -.2, .1, -1.2, -2], dtype=torch.float64)
        ours = fit_torch.ggx(parameters, metric.wi, metric.wo).numpy()
        np.testing.assert_allclose(ours, nqm.BRDF.open(fit_torch.spec(parameters)).eval(metric.wi.numpy(), metric.wo.numpy()), rtol=1e-5)
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            fit_torch.train_network(nqm.BRDF.open("sgd:nickel"), torch.tensor(ours), 2)
        self.assertRegex(printed.getvalue(), r"step +2: \d\.\d\d JOD")


class Compiled(unittest.TestCase):
    def test_trace_and_onnx(self):
        ref, test = [torch.tensor(x, dtype=torch.float32) for x in pairs_of("default", 3)]
        metric = nqm.torch.Metric().eval()
        file = io.BytesIO()
        torch.onnx.export(metric, (ref, test), file, opset_version=17 if hasattr(torch, "compile") else 16, input_names=["ref", "test"],
                          output_names=["jod"], dynamic_axes={"ref": [0], "test": [0], "jod": [0]})
        if importlib.util.find_spec("onnx") is None:
            self.skipTest("there is no onnx")
        import onnx

        model = onnx.load_from_string(file.getvalue())
        onnx.checker.check_model(model)
        self.assertEqual([i.name for i in model.graph.input], ["ref", "test"])
        if importlib.util.find_spec("onnx.reference"):
            from onnx.reference import ReferenceEvaluator

            found, = ReferenceEvaluator(model).run(None, {"ref": ref[:2].numpy(), "test": test[:2].numpy()})
            np.testing.assert_allclose(found, metric(ref[:2], test[:2]).numpy(), atol=1e-5)

    @unittest.skipUnless(hasattr(torch, "compile"), "torch.compile came with PyTorch 2")
    def test_compile(self):
        ref, test = [torch.tensor(x, dtype=torch.float32) for x in pairs_of("default", 3)]
        metric = nqm.torch.Metric()
        leaf, other = test.clone().requires_grad_(), test.clone().requires_grad_()
        # PyTorch's own backend needs a compiler and the headers of PyTorch.
        can_build = shutil.which("g++") and os.path.isdir(os.path.dirname(torch.__file__) + "/include/ATen") and importlib.util.find_spec("setuptools")
        value = torch.compile(metric, fullgraph=True, backend="inductor" if can_build else "aot_eager")(ref, leaf)
        np.testing.assert_allclose(value.detach().numpy(), metric(ref, other).detach().numpy(), atol=1e-5)
        value[1].backward()
        metric(ref, other)[1].backward()
        self.assertLess((leaf.grad - other.grad).norm(), 1e-4 * other.grad.norm())


if __name__ == "__main__":
    unittest.main()
