# SPDX-License-Identifier: MIT
"""Fits of models to BRDFs."""
from __future__ import annotations

from ctypes import byref, c_void_p
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Tuple

from . import _abi
from ._library import lib
from ._brdf import BRDF, BRDFLike, as_brdf, set_options
from ._call import Error, ProgressLike, Watch, call, encode, names_of, progress_callback
from ._scene import Scene, standard_scene
from ._score import ModelLike, as_model, models

FREE_OPTIONS = ("n_directions", "max_polar_rad", "highlight_fraction", "n_starts", "seed", "simplify")


@dataclass(frozen=True)
class Fit:
    """The result of `fit`.

    Attributes:
        brdf: the fitted BRDF
        spec: analytic and shading models: the same as a spec; otherwise "", and `brdf.save` writes it
        loss: value of the loss; of "auto" the difference
        selected: of "auto": how the result came about ("log-cos, then nqm"); otherwise ""
        difference: Delta-E at rays of the standard scenes (`Rays`), of other losses than "auto" by the transport model; NaN where it is not
            known
        n_numbers: numbers that the encoding stores
        n_directions: direction pairs in the loss
        best_start: index of the start that gave the result
    """

    brdf: BRDF
    spec: str
    loss: float
    selected: str
    difference: float
    n_numbers: int
    n_directions: int
    best_start: int


def fit_models() -> Tuple[str, ...]:
    """Names of the models that `fit` takes: encodings, analytic models, then the shading models of renderers."""
    return names_of(lib.nqm_fit_model)


def _bounds(bounds: Optional[Mapping[str, Tuple[float, float]]]) -> Any:
    rows = [_abi.FitBound(encode(key), low, high) for key, (low, high) in (bounds or {}).items()]
    return (_abi.FitBound * len(rows))(*rows)


def _judge() -> Optional[Scene]:
    try:
        return standard_scene()
    except Error:  # a build without Embree has no blob: the transport model judges
        return None


def fit(ref: BRDFLike, model: str = "ggx", *, loss: str = "auto", metric: ModelLike = "default", transport: ModelLike = "transport",
        start: Optional[str] = None, bounds: Optional[Mapping[str, Tuple[float, float]]] = None, progress: ProgressLike = None,
        **options: Any) -> Fit:
    """Fit a model to a BRDF, so that it looks right.

    Args:
        ref: the BRDF to be approximated
        model: "ggx", "cook-torrance", "nbrdf", ...: see `fit_models`
        loss: of analytic and shading models: a sum like "log_diff+0.2*nqm" of "nqm" (the Delta-E that `metric` predicts), "transport" (that of
            `transport`), "log", "log-cos", "cube-root", "linear" and scalar metrics; "auto" selects the best of several
        metric: the model of the loss "nqm"
        transport: the model of the loss "transport"; other than "transport", it also makes the choice of "auto", which otherwise the
            standard scenes make, at directions that no fit has seen
        start: a spec of the model, from which the loss is minimised; default: several starts
        bounds: narrower ranges of parameters: {"alpha": (.1, .3)}
        progress: called with the stage, the work done and the total; True shows a line on standard error
        options: members of `nqm_fit_options` (include/nqm/fit.h): `n_directions`, `max_polar_rad`, `highlight_fraction`,
            `n_starts`, `seed`, `simplify`
    """
    brdf, own, limits = as_brdf(ref), Watch(), _bounds(bounds)
    o = set_options(lib.nqm_fit_options_default(), options, FREE_OPTIONS)
    o.bounds, o.n_bounds = limits, len(limits)
    o.start = None if start is None else encode(start)
    o.progress = progress_callback(progress, brdf._watches, own)
    judges = [as_model(m) if not isinstance(m, str) or m in models() or m != "transport" else None for m in (metric, transport)]
    scene = _judge() if transport == "transport" and loss.startswith("auto") else None
    terms = _abi.MatchLoss(encode(loss), *[m._handle if m else None for m in (*judges, scene)])
    report, handle = _abi.MatchReport(), c_void_p()
    call(lib.nqm_match, brdf._handle, encode(model), byref(terms), byref(o), byref(report), byref(handle), watches=brdf._watches,
         own=own)
    f = report.fit
    return Fit(BRDF._own(handle), f.spec.decode(), f.loss, report.selected.decode(), report.difference, f.n_numbers, f.n_directions,
               f.best_start)
