# SPDX-License-Identifier: MIT
"""Metrics by name, and many pairs as one array."""
from __future__ import annotations

import ctypes
import functools
import itertools
import os
import warnings
from ctypes import POINTER, byref
from typing import Any, Callable, Iterable, List, Optional, Tuple, Union

import numpy as np

from ._abi import NamedPair, Pairs
from ._brdf import BRDFLike
from ._call import Error, PathLike, ProgressLike, call, encode
from ._library import lib
from ._score import METRICS, ModelLike, Scorer
from ._texture import MapScore, Material, score_maps

_PREDICTED = {"jod": "quality that people would see, 0 to 10 JOD (10: no visible difference)",
              "similarity": "how similar people find materials that they see apart, 0 to 10 JOD",
              "delta_e": "Delta-E ITP of rendered pictures"}


def metrics() -> Tuple[str, ...]:
    """Names of the metrics that `Metric` takes: those of the model, and the scalar ones."""
    return (*_PREDICTED, *METRICS)


class Metric:
    """One metric by name, as a function of a reference and a test.

    >>> metric = nqm.Metric("rmse")
    >>> metric.lower_better
    True
    >>> metric("sgd:nickel", "sgd:nickel")
    0.0

    Args:
        name: "jod", "similarity", "delta_e", or a scalar metric: see `metrics`
        model: its model; the scalar metrics use its directions
        options: as for `Scorer`

    Attributes:
        name: the name
        lower_better: whether smaller values mean better approximations
        description: what it measures
        score_range: smallest and largest value
    """

    def __init__(self, name: str = "jod", *, model: ModelLike = "default", **options: Any) -> None:
        if name not in metrics():
            raise ValueError("there is no metric %r; there are %s" % (name, ", ".join(metrics())))
        self.name = name
        self.lower_better = name not in ("jod", "similarity")
        self.score_range = (0.0, float("inf") if self.lower_better else 10.0)
        self._scalar = name in METRICS
        self.description = _PREDICTED.get(name) or lib.nqm_metric_get_info(METRICS.index(name)).description.decode()
        self._scorer = Scorer(model, metrics=self._scalar, **options)

    def __repr__(self) -> str:
        return "<nqm.Metric %s, %s is better>" % (self.name, "lower" if self.lower_better else "higher")

    def _value(self, score: Any) -> float:
        return score.metrics[self.name] if self._scalar else getattr(score, self.name)

    def __call__(self, ref: BRDFLike, tests: Any) -> Any:
        """The value for one test, or an array for a list or tuple of tests."""
        scores = self._scorer.score(ref, tests)
        return np.array([self._value(s) for s in scores]) if isinstance(scores, list) else self._value(scores)

    def samples(self, ref: Any, test: Any, used: Any = None) -> Any:
        """The value for samples at the model's directions; see `score_samples`."""
        scores = self._scorer.score_samples(ref, test, used)
        return np.array([self._value(s) for s in scores]) if isinstance(scores, list) else self._value(scores)


_BATCH = (("jod", "f8"), ("low", "f8"), ("high", "f8"), ("delta_e", "f8"), ("novelty", "f8"), ("similarity", "f8"),
          ("identical", "?"), ("status", "i4"), ("n_valid", "i8"))


def _is_name(value: Any) -> bool:
    return isinstance(value, (str, os.PathLike))


def expand_pairs(pairs: Union[PathLike, Iterable[Tuple[BRDFLike, BRDFLike]]], *,
                 ignore: Optional[str] = None) -> List[Tuple[BRDFLike, BRDFLike]]:
    """The pairs whose scores are the rows of `batch`. A test that is a file of several materials means all of them; where the
    reference is such a file, too, its materials are paired with those of the same names. A material that the test lacks is a pair
    that cannot be scored; one that only the test has is left out with a warning.

    >>> with open("pairs.csv", "w") as file:
    ...     n = file.write("reference,test,name\\nsgd:nickel,ward:nickel,fit\\n")
    >>> nqm.expand_pairs("pairs.csv")
    [('sgd:nickel', 'ward:nickel')]

    Args:
        pairs: as for `batch`
        ignore: what of refused materials is ignored, "transmission,opacity"
    """
    given = [] if _is_name(pairs) else list(pairs)  # type: ignore[arg-type]
    named = [NamedPair(*[encode(b) if _is_name(b) else b"" for b in pair]) for pair in given]
    own, listed, made = Pairs(n=len(named), pairs=(NamedPair * len(named))(*named)), POINTER(Pairs)(), POINTER(Pairs)()
    try:
        if _is_name(pairs):
            call(lib.nqm_pairs_read, encode(pairs), byref(listed))  # type: ignore[arg-type]
        call(lib.nqm_pairs_expand, listed if listed else byref(own), None if ignore is None else encode(ignore), byref(made))
        n, left_out = made[0].n, ctypes.cast(made[0].left_out, POINTER(ctypes.c_char_p))
        rows = zip(ctypes.cast(made[0].rows, POINTER(ctypes.c_size_t))[:n], [(p.ref, p.test) for p in made[0].pairs[:n]])
        for message in iter(map(left_out.__getitem__, itertools.count()).__next__, None):
            warnings.warn(os.fsdecode(message), stacklevel=3)
    finally:
        lib.nqm_pairs_free(made)
        lib.nqm_pairs_free(listed)
    if listed:
        return [(os.fsdecode(ref), os.fsdecode(test)) for _, (ref, test) in rows]
    return [tuple(b if not _is_name(b) or encode(b) == name else os.fsdecode(name)  # what is unchanged is the caller's object
                  for b, name in zip(given[row], names)) for row, names in rows]  # type: ignore[misc]


def _score_textured(pair: Tuple[Any, Any], model: ModelLike, material: Callable[[Any], Material]) -> Optional[MapScore]:
    """The score of a pair with image maps that a score of BRDFs refuses; None: it is no such pair. Raises why it has none."""
    if not all(isinstance(name, (str, os.PathLike)) for name in pair):
        return None
    try:
        both = material(pair[0]), material(pair[1])
    except Error:
        return None  # the refusal stands
    if not any(m.info.n_images for m in both):
        return None
    for m in both:
        if m.info.remark:
            warnings.warn("%s: %s" % (m.info.name, m.info.remark), stacklevel=3)
    return score_maps(*both, model=model, blame=False, far=False)


def batch(pairs: Union[PathLike, Iterable[Tuple[BRDFLike, BRDFLike]]], *, model: ModelLike = "default", metrics: bool = False,
          progress: ProgressLike = None, **options: Any) -> np.ndarray:
    """Score many pairs into one array. Pairs that cannot be scored do not stop the others. Pairs of files with image maps have the near
    score of `score_maps`, without novelty, similarity and scalar metrics.

    Args:
        pairs: (reference, test) pairs, or a list (CSV, JSON Lines) as for the tool's verb `batch`; relative paths are relative to
            the current folder. Files of several materials mean all of them: `expand_pairs` has the pairs of the rows
        model: as for `score`
        metrics: whether to add the scalar metrics, one column each
        progress: called with ("score", done, total); True shows a line on standard error
        options: as for `Scorer`

    Returns:
        structured array (number of `expand_pairs`): `jod`, `low`, `high`, `delta_e`, `novelty`, `similarity`, `identical`, `status` (a `Status`; not 0:
        the other columns are NaN; `score_many` has the message), `n_valid`, and the metrics
    """
    scorer = Scorer(model, metrics=metrics, **options)
    expanded = expand_pairs(pairs)
    scores = scorer.score_many(expanded, progress=progress, errors="keep")
    names = METRICS if metrics else ()
    table = np.empty(len(scores), np.dtype([*_BATCH, *((name, "f8") for name in names)]))
    for name, _ in _BATCH:
        table[name] = [s.error.status if s.error else 0 for s in scores] if name == "status" else [getattr(s, name) for s in scores]
    for name in names:
        table[name] = [s.metrics[name] for s in scores]
    material = functools.lru_cache(maxsize=4)(Material.open)
    for i in np.flatnonzero(table["status"]):
        try:
            maps = _score_textured(expanded[i], scorer.model, material)
        except Error as error:
            table["status"][i] = error.status
        else:
            if maps:
                table[list(dict(_BATCH[:4]))][i] = maps.jod, maps.jod_low, maps.jod_high, maps.delta_e
                table["identical"][i], table["status"][i] = maps.delta_e == 0, 0
    return table
