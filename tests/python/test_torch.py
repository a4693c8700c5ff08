# SPDX-License-Identifier: MIT
"""nqm.torch: gradients against central differences, batches, a fit by gradient descent. Skipped without torch."""
import importlib.util
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

    def test_reference(self):
        ref, test = samples("sgd:nickel", "ward:nickel")
        with self.assertRaisesRegex(ValueError, "reference"):
            nqm.torch.jod(ref.requires_grad_(), test)

    def test_descent(self):
        wi, wo = nqm.torch.directions()
        h = torch.nn.functional.normalize(wi + wo, dim=1)

        def phong(p):
            n = p[1].exp()
            return (.1 / np.pi + (p[0].exp() * (n + 2) / (2 * np.pi) * h[:, 2] ** n))[:, None].expand(-1, 3)

        ref = phong(torch.tensor([-3., 4.], dtype=torch.float64))
        p = torch.tensor([-2.5, 3.6], dtype=torch.float64, requires_grad=True)
        loss, optimiser = nqm.torch.Loss("delta_e"), torch.optim.Adam([p], .1)
        values = []
        for _ in range(40):
            optimiser.zero_grad()
            value = loss(ref, phong(p))
            value.backward()
            optimiser.step()
            values.append(value.item())
        self.assertLess(min(values[-5:]), .15 * values[0])


if __name__ == "__main__":
    unittest.main()
