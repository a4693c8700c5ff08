# SPDX-License-Identifier: MIT
"""Fits of models to BRDFs, and translations of materials."""
from __future__ import annotations

from ctypes import byref, c_void_p
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Tuple, Union

from . import _abi
from ._library import lib
from ._brdf import BRDF, BRDFLike, as_brdf, set_options
from ._call import Error, PathLike, ProgressLike, Watch, call, encode, names_of, progress_callback
from ._scene import Scene, standard_scene
from ._score import ModelLike, as_model, models
from ._texture import MapScore, Material, map_score_of

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


def _judges(loss: str, metric: ModelLike, transport: ModelLike) -> Tuple[Any, ...]:
    scene = _judge() if transport == "transport" and loss.startswith("auto") else None
    return as_model(metric), as_model(transport), scene


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
    judges = _judges(loss, metric, transport)
    terms = _abi.MatchLoss(encode(loss), *[m._handle if m else None for m in judges])
    report, handle = _abi.MatchReport(), c_void_p()
    call(lib.nqm_match, brdf._handle, encode(model), byref(terms), byref(o), byref(report), byref(handle), watches=brdf._watches,
         own=own)
    f = report.fit
    return Fit(BRDF._own(handle), f.spec.decode(), f.loss, report.selected.decode(), report.difference, f.n_numbers, f.n_directions,
               f.best_start)


@dataclass(frozen=True)
class Translation:
    """The result of `translate`.

    Attributes:
        spec: the translated material; of image maps what does not vary
        copied: spec of the properties that both models have; "": none
        dropped: properties of the source that the model has no counterpart for
        selected: how the result came about ("log-cos, then nqm")
        maps: the score of what was written, of a `Material`; otherwise None
    """

    spec: str
    copied: str
    dropped: Tuple[str, ...]
    selected: str
    maps: Optional[MapScore]


def translate(ref: Union[BRDFLike, Material], to: str = "gltf", path: Optional[PathLike] = None, *, name: str = "material",
              loss: str = "auto", metric: ModelLike = "default", transport: ModelLike = "transport", progress: ProgressLike = None,
              **options: Any) -> Translation:
    """Write a material as one of another renderer: what both models have is copied, and the rest fitted.

        >>> t = nqm.translate("open-pbr:base_color=.8,.3,.1;coat_weight=1;fuzz_weight=.2", "usd", n_directions=200)
        >>> t.spec.split(":")[0], t.dropped
        ('usd-preview', ('fuzz_weight',))

    Args:
        ref: any BRDF; or a `Material` with image maps, which is written as glTF with PNG files beside it
        to: a shading model, "gltf", "openpbr", "usd", "blender", ...: the error of another word names them
        path: the file to write, whose extension selects the format; needed with image maps
        name: of the material in the file
        loss: as for `fit`
        metric: the model that compares the fit with the copied properties, and of the loss "nqm"
        transport: the model of the loss "transport"
        progress: called with the stage, the work done and the total; True shows a line on standard error
        options: as for `fit`
    """
    own, result = Watch(), _abi.Translation()
    o = set_options(lib.nqm_fit_options_default(), options, FREE_OPTIONS)
    judges = _judges(loss, metric, transport)
    terms = _abi.MatchLoss(encode(loss), *[m._handle if m else None for m in judges])
    if isinstance(ref, Material):
        if path is None or to != "gltf":
            raise ValueError("a material with image maps is translated to a glTF file: give its path")
        o.progress = progress_callback(progress, (), own)
        call(lib.nqm_translate_texture, ref._handle, encode(path), encode(name), byref(terms), byref(o), byref(result), own=own)
    else:
        brdf = as_brdf(ref)
        o.progress = progress_callback(progress, brdf._watches, own)
        call(lib.nqm_translate, brdf._handle, encode(to), None if path is None else encode(path), encode(name), byref(terms),
             byref(o), byref(result), watches=brdf._watches, own=own)
    return Translation(result.match.fit.spec.decode(), result.copied.decode(), tuple(filter(None, result.dropped.decode().split(", "))),
                       result.match.selected.decode(), map_score_of(result.texture, None) if isinstance(ref, Material) else None)
