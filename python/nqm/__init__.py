# SPDX-License-Identifier: MIT
"""How good a BRDF approximation looks beside its reference, in JOD.

>>> import nqm
>>> print(nqm.score("sgd:nickel", "ward:nickel"))
4.20 JOD [4.04, 4.36]

BRDFs come from files, specs, presets, Python functions and arrays; results are NumPy arrays and dataclasses; errors are `nqm.Error`.
`nqm.torch` has the scores for PyTorch, `nqm.dask` for lists on many machines, `nqm.plot` draws charts; they import torch, dask and matplotlib when they
are first used.
"""
from typing import Any as _Any

from ._abi import Status
from ._library import lib as _lib
from ._brdf import (BRDF, BRDFInfo, CheckReport, Difference, Directions, MaterialInfo, compare, directions_to_half_diff, files_within,
                    half_diff_to_directions, materials, presets, table_nodes)
from ._call import Error
from ._conform import Conformance, Mistake, conform
from ._data import Dataset
from ._find import Change, dedup, diff, nearest
from ._fit import Fit, Translation, fit, fit_models, translate
from ._metric import Metric, batch, expand_pairs, metrics
from ._scene import Label, Rays, Scene, label, render, srgb
from ._score import (Model, ModelInfo, Parts, Score, Scorer, models, preference, score, score_grad, score_many,
                     score_samples)
from ._texture import Blame, MapScore, MapsInfo, Material, score_maps
from ._version import VERSION

__version__ = VERSION

__all__ = [
    "score", "score_many", "batch", "expand_pairs", "score_samples", "score_grad", "Score", "Parts", "Scorer", "preference",
    "BRDF", "BRDFInfo", "CheckReport", "compare", "Difference", "presets", "materials", "MaterialInfo", "table_nodes", "half_diff_to_directions", "directions_to_half_diff", "Directions",
    "dedup", "nearest", "diff", "Change",
    "Metric", "metrics", "Model", "ModelInfo", "models",
    "score_maps", "MapScore", "Blame", "Material", "MapsInfo", "fit", "Fit", "fit_models", "translate", "Translation", "label", "Label", "render", "srgb", "Scene", "Rays", "Dataset",
    "conform", "Conformance", "Mistake",
    "Error", "Status", "build_info", "files_within",
]


def build_info() -> str:
    """One line about the C library: its libraries with their versions, and the fastest kernels that this processor supports."""
    return _lib.nqm_build_info().decode()


def __getattr__(name: str) -> _Any:
    if name in ("torch", "dask", "plot"):  # these are large: only those who use them wait for them
        import importlib

        return importlib.import_module("nqm." + name)
    raise AttributeError("module 'nqm' has no attribute %r" % name)
