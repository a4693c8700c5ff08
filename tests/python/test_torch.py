# SPDX-License-Identifier: MIT
"""nqm.torch: gradients against central differences, batches, fits by gradient descent, at fixed and at fresh directions. Skipped without
torch."""
import importlib.util
import math
import subprocess
import sys
import unittest

import numpy as np

import nqm

if importlib.util.find_spec("torch") is None:
    print("skipped: there is no torch")
    sys.exit(77)
import torch  # noqa: E402


def samples(*names):
    directions = nqm.Model.open().directions
    return [torch.tensor(nqm.BRDF.open(name).sample(directions)[0]) for name in names]


class Torch(unittest.TestCase):
    def test_torch_is_imported_late(self):
        code = "import sys, nqm; assert 'torch' not in sys.modules; nqm.torch.JOD; assert 'torch' in sys.modules"
        subprocess.run([sys.executable, "-c", code], check=True)

    def test_gradcheck(self):
        ref, test = samples("sgd:nickel", "ward:nickel")
        change = torch.rand(test.shape, generator=torch.Generator().manual_seed(1), dtype=torch.float64) * test
        for function in (nqm.torch.jod, nqm.torch.delta_e):
            def along(t):
                return function(ref, test.double() + t * change)

            # The step is far above the float error of the network.
            self.assertTrue(torch.autograd.gradcheck(along, torch.zeros((), dtype=torch.float64, requires_grad=True), eps=.01,
                                                     atol=.02, rtol=.02))

    def test_values(self):
        ref, test = samples("sgd:nickel", "ward:nickel")
        exact = nqm.score_grad(ref.numpy(), test.numpy())
        leaf = test.clone().requires_grad_()
        value = nqm.torch.jod(ref, leaf)
        value.backward()
        self.assertEqual(value.shape, ())
        self.assertAlmostEqual(value.item(), exact[0], places=5)
        np.testing.assert_array_equal(leaf.grad.numpy(), exact[1])

    def test_batch(self):
        ref, test = samples("sgd:nickel", "ward:nickel")
        one = test.clone().requires_grad_()
        nqm.torch.jod(ref, one).backward()
        both = torch.stack([test, .5 * test]).requires_grad_()
        values = nqm.torch.jod(ref, both)
        self.assertEqual(values.shape, (2,))
        (values * torch.tensor([2., 0.])).sum().backward()
        np.testing.assert_allclose(both.grad[0].numpy(), 2 * one.grad.numpy(), rtol=1e-6)
        self.assertEqual(both.grad[1].abs().max().item(), 0)
        shared = test.clone().requires_grad_()
        nqm.torch.jod(torch.stack([ref, ref]), shared).sum().backward()
        np.testing.assert_allclose(shared.grad.numpy(), 2 * one.grad.numpy(), rtol=1e-6)

    def test_other_values(self):
        """Arrays, half precision, and values that are no BRDF's."""
        ref, test = samples("sgd:nickel", "ward:nickel")
        exact = nqm.torch.jod(ref, test).item()
        self.assertEqual(nqm.torch.jod(ref.numpy(), test.numpy()).item(), exact)
        for dtype in (torch.bfloat16, torch.float16):
            leaf = test.to(dtype).requires_grad_()
            value = nqm.torch.jod(ref.to(dtype), leaf)
            self.assertEqual(value.dtype, torch.float32)
            self.assertAlmostEqual(value.item(), exact, delta=.01)
            value.backward()
            self.assertEqual(leaf.grad.dtype, dtype)
        odd, black = test.clone(), test.clone()
        odd[3, 1], odd[4] = float("nan"), -1
        black[3, 1], black[4] = 0, 0
        with self.assertRaisesRegex(nqm.Error, "must be finite"):
            nqm.torch.delta_e(ref, odd)
        with self.assertRaisesRegex(ValueError, "infinite at 3 values"):
            nqm.torch.delta_e(ref, torch.where(odd < 0, torch.full_like(odd, math.inf), odd), clamp=True)
        leaves = [t.requires_grad_() for t in (odd, black)]
        values = [nqm.torch.delta_e(ref, leaf, clamp=True) for leaf in leaves]
        self.assertEqual(values[0].item(), values[1].item())
        for value in values:
            value.backward()
        self.assertEqual(odd.grad[3, 1].item(), 0)
        np.testing.assert_array_equal(odd.grad[4:].numpy(), black.grad[4:].numpy())

    def test_reference(self):
        ref, test = samples("sgd:nickel", "ward:nickel")
        with self.assertRaisesRegex(ValueError, "reference"):
            nqm.torch.jod(ref.requires_grad_(), test)

    def test_descent(self):
        wi, wo = map(torch.tensor, nqm.Model.open().directions.vectors)
        h = torch.nn.functional.normalize(wi + wo, dim=1)

        def phong(p):
            n = p[1].exp()
            return (.1 / np.pi + (p[0].exp() * (n + 2) / (2 * np.pi) * h[:, 2] ** n))[:, None].expand(-1, 3)

        ref = phong(torch.tensor([-3., 4.], dtype=torch.float64))
        p = torch.tensor([-2.5, 3.6], dtype=torch.float64, requires_grad=True)
        loss, optimiser = nqm.torch.Loss("delta_e", model="default"), torch.optim.Adam([p], .1)
        values = []
        for _ in range(40):
            optimiser.zero_grad()
            value = loss(ref, phong(p))
            value.backward()
            optimiser.step()
            values.append(value.item())
        self.assertLess(min(values[-5:]), .15 * values[0])


class FreshDirections(unittest.TestCase):
    @staticmethod
    def network():
        torch.manual_seed(1)
        layers = torch.nn.Sequential(torch.nn.Linear(4, 8), torch.nn.Tanh(), torch.nn.Linear(8, 3))

        class Network(torch.nn.Module):
            def __init__(self):
                super().__init__()
                self.layers = layers

            def forward(self, wi, wo):
                h = torch.nn.functional.normalize(wi + wo, dim=1)
                inputs = [h[:, 2], (wi * h).sum(1), wi[:, 2] * wo[:, 2], h[:, :2].norm(dim=1)]
                return self.layers(torch.stack(inputs, 1)).exp()

        return Network()

    def test_untrained(self):
        """From values below 0 a training only gets out with clamp."""
        ref = nqm.BRDF.open("lambert:kd=.5")
        for clamp in (False, True):
            value = torch.tensor(-.05, requires_grad=True)
            loss = nqm.torch.Loss(clamp=clamp, dtype=torch.bfloat16, n=512)
            loss(ref, lambda wi, wo: value.bfloat16().expand(len(wi), 3)).backward()
            self.assertEqual(value.grad.item() < 0, clamp)

    def test_gradcheck(self):
        wi, wo, rays = nqm.torch.directions(200, 3)
        self.assertEqual(wi.shape, wo.shape)
        ref = torch.tensor(rays.eval("sgd:nickel"))
        for of in ("delta_e", "jod"):
            loss = nqm.torch.Loss(of)
            test = (1.2 * ref).requires_grad_()
            self.assertTrue(torch.autograd.gradcheck(lambda t: loss(ref, t, rays), test, eps=1e-6, atol=1e-6, rtol=1e-4))
            self.assertAlmostEqual(loss(ref, ref, rays).item(), 0, places=12)

    def test_jod(self):
        _, _, rays = nqm.torch.directions(2048)
        ref, test = (torch.tensor(rays.eval(name)) for name in ("sgd:nickel", "ward:nickel"))
        delta_e = rays.delta_e_grad(ref.numpy(), test.numpy())[0]
        self.assertAlmostEqual(nqm.torch.Loss()(ref, test, rays).item(), delta_e, places=9)
        lib, ctypes = nqm._library.lib, nqm._library.ctypes
        info = lib.nqm_label_get_info(ctypes.byref(nqm._abi.Label()))
        jod = lib.nqm_curve_jod(ctypes.byref(info.curve), delta_e)
        self.assertAlmostEqual(nqm.torch.Loss("jod")(ref, test, rays).item(), 10 - jod, places=9)

    def test_functions(self):
        """Each call has other directions; those of a seed are the same; dtype is that of the network, or as asked for."""
        seen = []

        def grey(wi, wo):
            seen.append(wi)
            return torch.full(wi.shape, .2, dtype=wi.dtype)

        loss = nqm.torch.Loss(n=512)
        values = [loss(nqm.BRDF.open("sgd:nickel"), grey).item() for _ in range(2)]
        self.assertNotEqual(values[0], values[1])
        loss.seed = 1
        self.assertEqual(loss(nqm.BRDF.open("sgd:nickel"), grey).item(), values[0])
        self.assertEqual(seen[0].dtype, torch.float64)
        nqm.torch.Loss(n=512, dtype=torch.float32)(grey, grey)
        self.assertEqual(seen[-1].dtype, torch.float32)
        value = loss(nqm.BRDF.open("sgd:nickel"), self.network())
        self.assertEqual(value.dtype, torch.float32)
        value.backward()

    def test_no_value(self):
        """Where a BRDF has no value, neither picture has light, and a function gets no gradient there."""
        holes = nqm.BRDF.from_function(lambda wi, wo: np.where(wi[:, 2:] > .3, [.2, .2, .2], np.nan))
        grey = [torch.full((3,), .2, dtype=torch.float64, requires_grad=True) for _ in range(2)]
        for pair in ((holes, lambda wi, wo: grey[0].expand(len(wi), 3)), (lambda wi, wo: grey[1].expand(len(wi), 3), holes), (holes, holes)):
            self.assertEqual(nqm.torch.Loss(n=500)(*pair).item(), 0)
        wi, wo, rays = nqm.torch.directions(500)
        test = torch.full((len(wi), 3), .3, dtype=wi.dtype, requires_grad=True)
        nqm.torch.Loss()(holes, test, rays).backward()
        self.assertEqual((test.grad.abs().sum(-1) > 0).tolist(), (wi[:, 2] > .3).tolist())

    def test_training_and_label(self):
        ref, network = nqm.BRDF.open("ggx:kd=.3,.2,.1;ks=.1;alpha=.4;f0=.04"), self.network()
        loss, optimiser = nqm.torch.Loss(n=1024), torch.optim.Adam(network.parameters(), .03)
        for _ in range(150):
            optimiser.zero_grad()
            loss(ref, network).backward()
            optimiser.step()

        def test(wi, wo):
            with torch.no_grad():
                return network(torch.tensor(wi, dtype=torch.float32), torch.tensor(wo, dtype=torch.float32)).double().numpy()

        label, score = nqm.label(ref, test, n_points=400), nqm.score(ref, test)
        self.assertGreater(label.jod, 9)
        self.assertLess(abs(label.jod - score.jod), .3)

    def test_errors(self):
        with self.assertRaisesRegex(ValueError, "function"):
            nqm.torch.Loss()(torch.ones(1872, 3), torch.ones(1872, 3))
        _, _, rays = nqm.torch.directions(512)
        with self.assertRaisesRegex(ValueError, "shape"):
            nqm.torch.Loss()(torch.ones(3, 3), torch.ones(3, 3), rays)
        with self.assertRaisesRegex(ValueError, "no rays"):
            nqm.torch.Loss(model="default")(torch.ones(1872, 3), torch.ones(1872, 3), rays)


if __name__ == "__main__":
    unittest.main()
