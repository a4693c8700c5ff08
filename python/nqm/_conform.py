# SPDX-License-Identifier: MIT
"""Tests of shaders against their specification."""
from __future__ import annotations

import math
import re
from ctypes import byref, c_void_p
from dataclasses import dataclass
from typing import Any, Callable, Dict, Optional, Sequence, Tuple, Union

import numpy as np

from . import _abi
from ._call import ProgressLike, Watch, address, array_at, call, encode, own_handle, progress_callback
from ._library import lib
from ._score import ModelLike, as_model

ShaderLike = Union[np.ndarray, Sequence[Any], Callable[[Dict[str, np.ndarray], np.ndarray, np.ndarray], Any]]


@dataclass(frozen=True)
class Mistake:
    """A mistake that may explain the values of a shader. str() is its text.

    Attributes:
        text: "roughness is squared twice"
        lowest_jod: of the sets, beside a reference with the same mistake
        remaining: fraction of the difference that remains then
    """

    text: str
    lowest_jod: float
    remaining: float

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True, repr=False)
class Conformance:
    """The result of `conform`. str() says how many parameter sets pass, and what is wrong.

    Attributes:
        passes: whether all sets have a JOD of 9.99 or more
        jod: (sets,) NaN: more than a tenth of the values of the set are not finite
        specs: the sets as specs
        mistake: the mistake that explains the difference; None if there is none
        mistakes: the likeliest mistakes, the nearest first; empty if all sets pass
        facts: what is known of the sets that fail: which parameters they have in common, at which angles most of their difference is, and the
            largest difference
    """

    passes: bool
    jod: np.ndarray
    specs: Tuple[str, ...]
    mistake: Optional[str]
    mistakes: Tuple[Mistake, ...]
    facts: Tuple[str, ...]

    def __str__(self) -> str:
        lowest = float(np.nanmin(self.jod)) if np.isfinite(self.jod).any() else math.nan
        lines = ["%d of %d sets pass, lowest JOD %.2f" % ((self.jod >= _PASS).sum(), len(self.jod), lowest)]
        if np.isnan(self.jod).any():
            lines.append("%d sets have no score: too many values are not finite" % np.isnan(self.jod).sum())
        if self.mistake:
            lines.append("likely mistake: " + self.mistake)
        elif not self.passes:
            lines += ["no mistake of the list explains the difference", *("the nearest: %s" % m for m in self.mistakes[:1]), *self.facts]
        return "\n".join(lines)

    __repr__ = __str__


_PASS = 9.99


def _parameters(names: Sequence[str], values: np.ndarray) -> Dict[str, np.ndarray]:
    """Colours and pairs are arrays of their columns "base_color_r", "alpha_x"."""
    found: Dict[str, np.ndarray] = {}
    for key in dict.fromkeys(re.sub("_[rgbxy]$", "", name) for name in names):
        columns = values[[name == key or name[:-2] == key for name in names]]
        found[key] = columns if len(columns) > 1 else columns[0]
    return found


def conform(model: str, shader: ShaderLike, keys: Union[None, str, Sequence[str]] = None, *, metric: ModelLike = "default",
            progress: ProgressLike = None) -> Conformance:
    """Does a shader implement its specification, and which mistake does it make?

    Args:
        model: a shading model: "gltf", "open-pbr", "standard-surface", "usd-preview", "disney", "principled", "blender-principled",
            "rough-conductor", "rough-plastic", "pbrt-conductor"
        shader: called for each set with a dict of its parameters (numbers, and arrays (3,) of colours), light (n, 3) and viewer (n, 3), unit
            vectors in the tangent frame; returns f_r (n, 3) in 1/sr, without the cosine. Or its values in the order of `nqm conform
            --directions`, (sets, directions, 3)
        keys: parameters that the shader has, "base_color,roughness" or a list; the others keep their defaults; None: all
        metric: the model that scores, at its directions
        progress: called with the stage, the work done and the total; True shows a line on standard error

    >>> def metal(p, light, viewer):
    ...     h = light + viewer
    ...     h /= np.linalg.norm(h, axis=1, keepdims=True)
    ...     a2 = p["roughness"]**2  # alpha is roughness squared: **4 is right
    ...     l, v, n_h, v_h = light[:, 2:], viewer[:, 2:], h[:, 2:], (viewer * h).sum(axis=1, keepdims=True)
    ...     d = a2 / (np.pi * (n_h * n_h * (a2 - 1) + 1)**2)
    ...     g = .5 / (l * np.sqrt(v * v * (1 - a2) + a2) + v * np.sqrt(l * l * (1 - a2) + a2))
    ...     return (p["base_color"] + (1 - p["base_color"]) * (1 - v_h)**5) * d * g
    >>> print(nqm.conform("gltf", metal, "base_color,roughness"))
    3 of 33 sets pass, lowest JOD 4.44
    likely mistake: roughness is not squared
    """
    kit, own = c_void_p(), Watch()
    chosen = None if keys is None else encode(keys if isinstance(keys, str) else ",".join(keys))
    scorer = as_model(metric)
    call(lib.nqm_conform_kit_create, encode(model), chosen, scorer._handle, byref(kit))
    own_handle(own, kit, lib.nqm_conform_kit_free)
    info = lib.nqm_conform_kit_get_info(kit, 0)
    sets = [lib.nqm_conform_kit_get_info(kit, i) for i in range(info.n_sets)]
    shape, names = (info.n_directions, 3), info.columns.decode().split(",")
    if callable(shader):
        values = np.empty((info.n_sets, *shape), np.float32)
        for at, s in zip(values, sets):
            at[:] = shader(_parameters(names, array_at(s.values, (info.n_columns,))), array_at(s.light, shape), array_at(s.viewer, shape))
    else:
        values = np.ascontiguousarray(shader, np.float32)
        if values.shape != (info.n_sets, *shape):
            raise ValueError("the values have the shape %s, and the kit has %s; give the same keys" % (values.shape, (info.n_sets, *shape)))
    results, report = (_abi.ScoreResult * info.n_sets)(), _abi.ConformReport()
    call(lib.nqm_conform_compare, kit, address(values), progress_callback(progress, (), own), None, results, byref(report), own=own)
    mistakes = tuple(Mistake(m.text.decode(), m.lowest_jod, m.remaining) for m in report.mistakes[:report.n_mistakes])
    facts = tuple(text.decode() for text in (report.sets, report.angles, report.most) if text)
    return Conformance(report.n_passed == info.n_sets, np.array([r.jod for r in results]), tuple(s.spec.decode() for s in sets),
                       mistakes[0].text if report.is_named else None, mistakes, facts)
