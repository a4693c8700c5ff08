# SPDX-License-Identifier: MIT
"""Scores as functions of PyTorch, differentiable by the samples of the test.

Samples are f_r in 1/sr at the directions of the model (`directions`), (n_directions, 3) or (n_pairs, n_directions, 3), on any device;
the library computes on the processor in float. There is no gradient by the reference.
"""
from __future__ import annotations

import functools
from typing import Any, Optional, Tuple

import torch

from ._score import ModelLike, Scorer, as_model

__all__ = ["JOD", "jod", "delta_e", "Loss", "directions"]


@functools.lru_cache(maxsize=8)
def _scorer(model: ModelLike) -> Scorer:
    return Scorer(model, metrics=False)


def _array(tensor: Any) -> Any:
    return tensor.detach().cpu().numpy() if isinstance(tensor, torch.Tensor) else tensor


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
        gradient = torch.as_tensor(gradients).to(test)
        if gradient.dim() > test.dim():  # one test with several references
            ctx.single = True
        ctx.save_for_backward(gradient)
        return torch.as_tensor(values).to(test)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, grad: torch.Tensor) -> Tuple[Optional[torch.Tensor], ...]:
        (gradient,) = ctx.saved_tensors
        product = grad[..., None, None] * gradient
        return None, product.sum(0) if getattr(ctx, "single", False) else product, None, None, None


def jod(ref: Any, test: torch.Tensor, *, model: Any = "default", used: Any = None) -> torch.Tensor:
    """JOD of sampled pairs: higher is better. It is flat for very different BRDFs: minimise `delta_e` rather."""
    return JOD.apply(ref, test, model, used, "jod")


def delta_e(ref: Any, test: torch.Tensor, *, model: Any = "default", used: Any = None) -> torch.Tensor:
    """Predicted Delta-E ITP of sampled pairs: lower is better."""
    return JOD.apply(ref, test, model, used, "delta_e")


class Loss(torch.nn.Module):
    """A loss to be minimised: the mean of `delta_e`, or of 10 - `jod`, over the pairs.

    Args:
        of: "delta_e" or "jod"
        model: as for `nqm.score`
    """

    def __init__(self, of: str = "delta_e", *, model: ModelLike = "default") -> None:
        super().__init__()
        if of not in ("delta_e", "jod"):
            raise ValueError("of is delta_e or jod; not %r" % of)
        self.of = of
        self._scorer = Scorer(model, metrics=False)

    def forward(self, ref: Any, test: torch.Tensor, used: Any = None) -> torch.Tensor:
        """The loss of samples `test` against `ref`."""
        value = JOD.apply(ref, test, self._scorer, used, self.of)
        return (10 - value if self.of == "jod" else value).mean()


def directions(model: ModelLike = "default", **to: Any) -> Tuple[torch.Tensor, torch.Tensor]:
    """Where the model samples BRDFs: unit vectors `wi`, `wo`, (n_directions, 3) each. `to`: as for `torch.tensor` (`dtype`, `device`)."""
    wi, wo = as_model(model).directions.vectors
    return torch.tensor(wi, **to), torch.tensor(wo, **to)
