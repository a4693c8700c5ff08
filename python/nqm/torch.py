# SPDX-License-Identifier: MIT
"""Losses and scores for PyTorch, differentiable by the values of the test.

A training needs `Loss`: Delta-E of pictures at fresh directions in every step. `jod` and `delta_e` are the scores of a model, which
looks at the same directions every time: right for judging, but a training learns these by heart. Values are f_r in 1/sr, (n, 3), on any
device; the library computes on the processor, without a gradient by the reference. `Metric` computes scores in PyTorch itself.
"""
from __future__ import annotations

import functools
from ctypes import byref
from typing import Any, Optional, Tuple

import torch

from ._abi import Label
from ._library import lib
from ._brdf import BRDF
from ._scene import Rays, Scene
from ._score import ModelLike, Scorer
from ._torch_metric import Metric

__all__ = ["Metric", "JOD", "jod", "delta_e", "RayLoss", "Loss", "directions"]


@functools.lru_cache(maxsize=8)
def _scorer(model: ModelLike) -> Scorer:
    return Scorer(model, metrics=False)


def _array(values: Any) -> Any:
    if not isinstance(values, torch.Tensor):
        return values
    values = values.detach().cpu()
    return (values.float() if values.dtype == torch.bfloat16 else values).numpy()  # NumPy has no bfloat16


def _full(dtype: torch.dtype) -> torch.dtype:
    """The type of a loss by values of this one: half precision has two digits of a JOD."""
    return torch.promote_types(dtype, torch.float32)


def _test(values: Any, clamp: bool) -> torch.Tensor:
    """Values of the test as a tensor. clamp: NaN and negative values count as 0, and the gradient by these is that at 0: an untrained
    network gets out of there."""
    test = torch.as_tensor(values)
    if not clamp:
        return test
    if test.isposinf().any():
        raise ValueError("clamp: the test is infinite at %d values; NaN and negative values count as 0, infinity has no such value"
                         % int(test.isposinf().sum()))
    test = torch.where(test.isnan(), torch.zeros_like(test), test)
    return test + (test.clamp(min=0) - test).detach()


class JOD(torch.autograd.Function):
    """`JOD.apply(ref, test, model, used, of)`: scores, (n_pairs) or a scalar. `jod` and `delta_e` call it with defaults.

    Args:
        ref: samples of the reference; must not require a gradient
        test: samples of the test: a tensor
        model: as for `nqm.score`, or a `nqm.Scorer`
        used: None, or False where a direction is left out
        of: "jod" or "delta_e"
    """

    @staticmethod
    def forward(ctx: Any, ref: Any, test: torch.Tensor, model: Any = "default", used: Any = None,  # type: ignore[override]
                of: str = "jod") -> torch.Tensor:
        if ctx.needs_input_grad[0]:
            raise ValueError("there is no gradient by the reference: pass ref.detach()")
        scorer = model if isinstance(model, Scorer) else _scorer(model)
        values, gradients = scorer.score_grad(_array(ref), _array(test), of=of, used=_array(used))
        gradient = torch.as_tensor(gradients).to(test.device)
        if gradient.dim() > test.dim():  # one test with several references
            ctx.single = True
        ctx.save_for_backward(gradient)
        ctx.dtype = test.dtype
        return torch.as_tensor(values).to(test.device, _full(test.dtype))

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, grad: torch.Tensor) -> Tuple[Optional[torch.Tensor], ...]:
        (gradient,) = ctx.saved_tensors
        product = grad[..., None, None] * gradient
        return None, (product.sum(0) if getattr(ctx, "single", False) else product).to(ctx.dtype), None, None, None


def jod(ref: Any, test: Any, *, model: Any = "default", used: Any = None, clamp: bool = False) -> torch.Tensor:
    """JOD of sampled pairs, tensors or arrays: higher is better. It is flat for very different BRDFs: minimise `delta_e` rather.
    clamp: as for `Loss`."""
    return JOD.apply(ref, _test(test, clamp), model, used, "jod")


def delta_e(ref: Any, test: Any, *, model: Any = "default", used: Any = None, clamp: bool = False) -> torch.Tensor:
    """Predicted Delta-E ITP of sampled pairs, tensors or arrays: lower is better. clamp: as for `Loss`."""
    return JOD.apply(ref, _test(test, clamp), model, used, "delta_e")


class RayLoss(torch.autograd.Function):
    """`RayLoss.apply(ref, test, rays)`: Delta-E ITP of the pictures that the values make at an `nqm.Rays`. `Loss` calls it."""

    @staticmethod
    def forward(ctx: Any, ref: Any, test: torch.Tensor, rays: Rays) -> torch.Tensor:  # type: ignore[override]
        value, gradient = rays.delta_e_grad(_array(ref), _array(test))
        ctx.save_for_backward(torch.as_tensor(gradient).to(test))
        return test.new_tensor(value, dtype=_full(test.dtype))

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, grad: torch.Tensor) -> Tuple[Optional[torch.Tensor], ...]:
        (gradient,) = ctx.saved_tensors
        return None, (grad * gradient).to(gradient.dtype), None


def _jod(delta_e: torch.Tensor) -> torch.Tensor:
    """nqm_curve_jod() of the published curve."""
    c = lib.nqm_label_get_info(byref(Label())).curve
    return 10 * torch.sigmoid(-c.b1 * (delta_e.clamp(min=1e-6) ** c.b3 + c.b2))


class Loss(torch.nn.Module):
    """A loss to be minimised: Delta-E ITP, or 10 - JOD, of pictures of two BRDFs. `loss(ref, test)` draws new directions at each call, so that
    a training cannot satisfy the loss at some directions only. Its mean over the steps is the label of `nqm.Scene.label`, by which the
    result should be checked.

    `ref` and `test` are functions f(wi, wo) of tensors (n, 3) that return f_r in 1/sr, (n, 3), or an `nqm.BRDF`; where that has no value,
    neither counts. Or they are the values at rays that the caller has drawn: `loss(ref, test, rays)`.

    Args:
        of: "delta_e" or "jod"
        model: scores of this model instead, at its fixed directions: `loss(ref, test)` takes samples as `delta_e` does, and returns the
            mean over the pairs
        scene: an `nqm.Scene`; default: the standard set
        n: rays of a call: more make the gradient less noisy
        seed: of the first call; each call adds 1 to the attribute `seed`
        clamp: NaN and negative values of the test count as 0 instead of being an error or black for good: the gradient by a negative value
            is that at 0, so that an untrained network gets out of there
        to: `dtype`, `device` of the directions; default: those of the test's parameters, or float64
    """

    def __init__(self, of: str = "delta_e", *, model: Optional[ModelLike] = None, scene: Optional[Scene] = None, n: int = 4096,
                 seed: int = 1, clamp: bool = False, **to: Any) -> None:
        super().__init__()
        if of not in ("delta_e", "jod"):
            raise ValueError("of is delta_e or jod; not %r" % of)
        self.of, self.n, self.seed, self.clamp = of, n, seed, clamp
        self._scene, self._to = scene, to
        self._scorer = None if model is None else Scorer(model, metrics=False)

    def _values(self, f: Any, rays: Rays, to: Any) -> Tuple[Any, Optional[torch.Tensor]]:
        """Values at the rays, and False, (n, 1), where an `nqm.BRDF` has none."""
        if isinstance(f, BRDF):
            values, flags = f.eval_flags(rays.wi, rays.wo)
            return torch.tensor(values, **to), torch.tensor(flags != 2)[:, None]
        return f(torch.tensor(rays.wi, **to), torch.tensor(rays.wo, **to)) if callable(f) else f, None

    def forward(self, ref: Any, test: Any, rays: Optional[Rays] = None, *, used: Any = None) -> torch.Tensor:
        """The loss of `test` against `ref`. `used`: of a model's samples, as in `jod`."""
        if self._scorer is not None:
            if rays is not None:
                raise ValueError("a model has directions of its own: it takes no rays, and `used` by its name")
            value = JOD.apply(ref, _test(test, self.clamp), self._scorer, used, self.of)
            return (10 - value if self.of == "jod" else value).mean()
        if rays is None:
            if not (callable(test) or isinstance(test, BRDF)):
                raise ValueError("without rays the test is a function of directions; Loss(model=\"default\") takes samples of a model")
            rays = Rays(self.n, self.seed, scene=self._scene)
            self.seed += 1
        weight = next(test.parameters(), None) if isinstance(test, torch.nn.Module) else None
        to = self._to or ({} if weight is None else {"dtype": weight.dtype, "device": weight.device})
        with torch.no_grad():
            ref, ref_used = self._values(ref, rays, to)
        test, test_used = self._values(test, rays, to)
        test = _test(test, self.clamp)
        for used in (ref_used, test_used):
            if used is not None:
                ref, test = [torch.where(used.to(test.device), torch.as_tensor(x, device=test.device), torch.zeros_like(test)) for x in (ref, test)]
        value = RayLoss.apply(ref, test, rays)
        return 10 - _jod(value) if self.of == "jod" else value


def directions(n: int = 4096, seed: int = 1, *, scene: Optional[Scene] = None, **to: Any) -> Tuple[torch.Tensor, torch.Tensor, Rays]:
    """Fresh directions for a step of a training: unit vectors `wi`, `wo`, (n, 3) each, and the `nqm.Rays` they belong to, with which `Loss`
    compares values at them. `to`: as for `torch.tensor` (`dtype`, `device`); the other arguments as for `nqm.Rays`."""
    rays = Rays(n, seed, scene=scene)
    return torch.tensor(rays.wi, **to), torch.tensor(rays.wo, **to), rays
