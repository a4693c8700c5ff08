# SPDX-License-Identifier: MIT
"""Models and scores."""
from __future__ import annotations

import ctypes
import functools
import itertools
import math
import os
import sys
from ctypes import byref, c_void_p
from dataclasses import dataclass, field
from typing import Any, Dict, Iterable, List, Optional, Sequence, Tuple, Union, overload

import numpy as np

from . import _abi
from ._abi import NamedPair, SamplePair, ScoreResult
from ._library import lib
from ._brdf import BRDF, BRDFLike, Directions, as_brdf, handles_of, watches_of
from ._call import (Error, PathLike, ProgressLike, Turns, address, array_at, call, choice, decode, encode, error_of, names_of, own_handle, progress_of,
                    status_text, words)

METRICS = tuple(lib.nqm_metric_get_info(i).name.decode() for i in range(len(_abi.Metric)))


@dataclass(frozen=True)
class ModelInfo:
    """Facts about a model.

    Attributes:
        id: "default", "paper", or as given when trained
        recipe: "paper", "notebook", "nqm"
        sha256: checksum of the model file
        card: the model card, Markdown: training data, evaluation, limits
        licence: SPDX
        n_parameters: trained values
        layer_sizes: widths of the layers, input first
        jod_min: smallest JOD that the model can give
        jod_max: largest JOD that the model can give
        calibrated: whether scores have 95 % intervals
    """

    id: str
    recipe: str
    sha256: str
    card: str
    licence: str
    n_parameters: int
    layer_sizes: Tuple[int, ...]
    jod_min: float
    jod_max: float
    calibrated: bool


class Model:
    """A trained metric. Immutable; any thread may use it."""

    _handle: c_void_p

    def __init__(self) -> None:
        raise TypeError("use Model.open")

    @classmethod
    def open(cls, name_or_path: PathLike = "default") -> "Model":
        """A built-in model by name (`models` lists them), or a model file."""
        handle = c_void_p()
        if (isinstance(name_or_path, str) and name_or_path not in models() and not os.path.exists(name_or_path) and
                os.sep not in name_or_path):
            raise Error("there is no model '%s': built in are %s; or give a model file" % (name_or_path, ", ".join(models())),
                        _abi.Status.MODEL)
        call(lib.nqm_model_load, encode(name_or_path), byref(handle))
        model = object.__new__(cls)
        model._handle = handle
        own_handle(model, handle, lib.nqm_model_free)
        return model

    @property
    def info(self) -> ModelInfo:
        """Facts about the model."""
        i = lib.nqm_model_get_info(self._handle)
        sizes = tuple(array_at(i.layer_sizes, (i.n_layers + 1,), ctypes.c_size_t).tolist()) if i.n_layers else ()
        return ModelInfo(i.id.decode(), i.recipe.decode(), i.sha256.decode(), i.card.decode(), i.licence.decode(),
                         i.n_parameters, sizes, i.jod_min, i.jod_max, bool(i.calibration))

    @property
    def directions(self) -> Directions:
        """The directions at which the model samples BRDFs."""
        return Directions._wrap(c_void_p(lib.nqm_model_get_info(self._handle).directions), owner=self)

    def __repr__(self) -> str:
        return "<nqm.Model %s>" % self.info.id


ModelLike = Union[Model, PathLike]


@functools.lru_cache(maxsize=None)
def _built_in(name: str) -> Model:
    return Model.open(name)


def as_model(value: ModelLike) -> Model:
    """A model from what functions accept as one; built-in ones are loaded once."""
    if isinstance(value, Model):
        return value
    return _built_in(value) if isinstance(value, str) and value in models() else Model.open(value)


def models() -> Tuple[str, ...]:
    """Names of the built-in models."""
    return names_of(lib.nqm_model_builtin_name)


@dataclass(frozen=True)
class Parts:
    """How the pictures of two BRDFs differ: test minus reference, 0 for equal pictures.

    Attributes:
        shift: mean difference of I, T and P in units of Delta-E: brighter, bluer, redder
        contrast: above 0 the test has more contrast
        structure: root mean square Delta-E ITP that remains after the shift is subtracted
        words: the same in words: "darker, a little redder, much flatter"
    """

    shift: Tuple[float, float, float]
    contrast: float
    structure: float
    words: str


def parts_of(label: _abi.Label) -> Parts:
    words = lib.nqm_label_get_info(byref(label)).words.decode()
    return Parts((label.shift[0], label.shift[1], label.shift[2]), label.contrast, label.structure, words)


def columns_of(score: ScoreResult) -> Dict[str, Any]:
    """What the table of the library has of a score, by the names of its columns."""
    columns: Dict[str, Any] = {}
    for i in itertools.count():
        c = lib.nqm_score_column(i, byref(score), None)
        if not c.name:
            return columns
        if c.group in (_abi.ColumnGroup.LABEL, _abi.ColumnGroup.TEXTURE):
            continue
        whole = {_abi.ColumnKind.FLAG: bool, _abi.ColumnKind.WHOLE: int}.get(c.kind, float)
        value = c.number if math.isnan(c.number) else whole(c.number)
        columns[c.name.decode()] = c.text.decode() if c.kind == _abi.ColumnKind.TEXT else value


@dataclass(frozen=True)
class Score:
    """The score of one pair. `float(score)` is its JOD; `str(score)` names it with its interval and warnings.

    >>> dark = nqm.score("sgd:nickel", lambda wi, wo: 0.1 - 0.2 * abs(wi))
    >>> dark.verdict, dark.warnings[0]
    ('very different', '<lambda>: negative channel at ... of 1872 directions, taken as 0')

    Attributes:
        ref: name of the reference
        test: name of the test
        jod: predicted quality: 10 is no visible difference; one JOD less: 75 % of people prefer the reference
        low: lower end of the 95 % interval of the JOD; NaN if the model has none
        high: upper end
        delta_e: the Delta-E ITP that has this JOD; NaN if the model does not predict one
        prefer_reference: fraction of people who would say that the reference looks better; 0.5 is guessing
        identical: whether both BRDFs are equal at every direction
        novelty: distance from the nearest training pair; 95 % of pairs of new materials are below 1; NaN if unknown
        similarity: how similar people find the materials when they see them apart, JOD; NaN without a transport matrix
        similarity_low: lower end of its 95 % interval
        similarity_high: upper end
        anisotropy: of the more anisotropic BRDF (see `CheckReport`); above 0 the score is that of the model "anisotropic"
        parts: what differs, or None
        metrics: scalar metrics by name; empty if they were switched off
        n_valid: directions at which both BRDFs have a value
        warnings: what may make the score wrong: negative values, directions without a value, BRDFs unlike the training data, rows of a
            measured list far from the model's directions, a scale that is missing, values with the cosine
        error: why there is no score; None if there is one
    """

    ref: str
    test: str
    jod: float
    low: float
    high: float
    delta_e: float
    prefer_reference: float
    identical: bool
    novelty: float
    similarity: float
    similarity_low: float
    similarity_high: float
    anisotropy: float
    parts: Optional[Parts]
    metrics: Dict[str, float]
    n_valid: int
    warnings: Tuple[str, ...]
    error: Optional[Error] = None

    _result: ScoreResult = field(default_factory=ScoreResult, repr=False, compare=False)

    @property
    def row(self) -> Dict[str, Any]:
        """All numbers and texts of the score by the names of the columns of `nqm score --csv`: `pandas.DataFrame(s.row for s in scores)`."""
        return {"reference": self.ref, "test": self.test, **columns_of(self._result)}

    @property
    def verdict(self) -> str:
        """What the score means, in words that are not more certain than its interval: "visible", "identical"; "" without a score."""
        return str(self.row["verdict"])

    def __float__(self) -> float:
        return self.jod

    def __str__(self) -> str:
        if self.error:
            return "no score: %s" % self.error
        interval = "" if math.isnan(self.low) else " [%.2f, %.2f]" % (self.low, self.high)
        return "%.2f JOD%s%s" % (self.jod, interval, " (%s)" % "; ".join(self.warnings) if self.warnings else "")


def _remarks(model: Model, invalid: int, r: ScoreResult, ref: str, test: str) -> Tuple[str, ...]:
    text = ctypes.create_string_buffer(_abi.REMARKS_TEXT)
    names = os.fsencode(ref), os.fsencode(test)
    lib.nqm_pairs_remarks(model._handle, invalid, byref(NamedPair(*names)), *names, byref(r), text)
    return tuple(os.fsdecode(remark) for remark in text.raw.split(b"\0\0", 1)[0].split(b"\0") if remark)


def score_of(model: Model, invalid: int, r: ScoreResult, ref: str, test: str, error: Optional[Error] = None, metrics: bool = False) -> Score:
    """A result of the library as a `Score`."""
    if r.status and error is None:
        error = Error("%s and %s: %s (values at %d of %d directions)" %
                      (ref, test, status_text(r.status), r.n_valid, len(model.directions)), _abi.Status(r.status))
    prefer_reference = 0.5 if r.identical else lib.nqm_jod_preference(max(10.0, r.jod), r.jod)
    return Score(ref, test, r.jod, r.jod_low, r.jod_high, r.delta_e, prefer_reference, bool(r.identical), r.novelty, *r.similarity,
                 r.anisotropy, None if math.isnan(r.parts.structure) else parts_of(r.parts), dict(zip(METRICS, r.metrics)) if metrics else {},
                 r.n_valid, _remarks(model, invalid, r, ref, test), error,
                 ScoreResult.from_buffer_copy(r))


class Scorer:
    """A model with options, for many scores: it keeps its workspace and a cache of sampled BRDFs. The functions `score`,
    `score_many`, `score_samples` and `score_grad` make one for a single call. Threads that share it take turns.

    Args:
        model: a `Model`, the name of a built-in one, or a model file
        invalid: what happens at directions where a BRDF has no value: "drop" leaves them out, "zero", "nearest", "error"
        min_valid: refuse a pair when both BRDFs have a value at a smaller fraction of the directions
        metrics: False leaves out the scalar metrics, which is faster
        cache_mb: memory for samples of BRDFs that are given by path or spec
    """

    def __init__(self, model: ModelLike = "default", *, invalid: str = "drop", min_valid: float = 0.9,
                 metrics: bool = True, cache_mb: float = 64) -> None:
        self.model = as_model(model)
        self._options = _abi.ScoreOptions(choice("invalid", invalid, words(_abi.InvalidPolicy)), min_valid, int(metrics),
                                          int(cache_mb * 2**20))
        self._n_directions = len(self.model.directions)
        self._turns = Turns()
        self._handle = c_void_p()
        call(lib.nqm_scorer_create, self.model._handle, byref(self._options), byref(self._handle))
        own_handle(self, self._handle, lib.nqm_scorer_free)

    def _score(self, r: ScoreResult, ref: str, test: str, error: Optional[Error] = None) -> Score:
        return score_of(self.model, self._options.invalid, r, ref, test, error, bool(self._options.metrics))

    def _run(self, ref: BRDFLike, tests: Sequence[BRDFLike], errors: str) -> List[Score]:
        brdf, opened, scores = as_brdf(ref), [], []
        failures: Dict[int, Error] = {}
        for i, test in enumerate(tests):
            try:
                opened.append(as_brdf(test))
            except Error as error:
                if errors == "raise":
                    raise
                failures[i] = error
        results = (ScoreResult * len(opened))()
        watches = watches_of([brdf, *opened])
        with self._turns.take(watches):
            call(lib.nqm_scorer_run, self._handle, brdf._handle, len(opened), handles_of(opened), results, watches=watches)
        done = iter(zip(opened, results))
        for i, test in enumerate(tests):
            if i in failures:
                scores.append(self._score(_no_result(failures[i]), brdf.name, _name(test), failures[i]))
            else:
                test_brdf, result = next(done)
                scores.append(self._score(result, brdf.name, test_brdf.name))
        return _checked(scores, errors)

    def _run_named(self, pairs: Sequence[Tuple[Any, Any]], results: Any) -> List[Optional[Error]]:
        """Score a block of pairs of paths and specs."""
        named = (NamedPair * len(pairs))(*[NamedPair(encode(a), encode(b)) for a, b in pairs])
        errors = (_abi.Error * len(pairs))()
        with self._turns.take():
            call(lib.nqm_scorer_run_named, self._handle, len(pairs), named, results, errors)
        return [error_of(e, r.status) if r.status else None for e, r in zip(errors, results)]

    def score(self, ref: BRDFLike, tests: Any, *, errors: str = "raise") -> Any:
        """Score one test or several tests of a reference; see `score`."""
        choice("errors", errors, ("raise", "keep"))
        if isinstance(tests, (list, tuple)):
            return self._run(ref, tests, errors)
        return self._run(ref, [tests], errors)[0]

    def score_many(self, pairs: Iterable[Tuple[BRDFLike, BRDFLike]], *, progress: ProgressLike = None,
                   errors: str = "raise") -> List[Score]:
        """Score pairs of BRDFs; see `score_many`."""
        choice("errors", errors, ("raise", "keep"))
        listed = [(ref, test) for ref, test in pairs]
        report = progress_of(progress)
        scores: List[Score] = []
        for begin in range(0, len(listed), _abi.SCORE_BLOCK):
            block = listed[begin:begin + _abi.SCORE_BLOCK]  # Ctrl-C and progress act between calls
            report("score", begin, len(listed))
            named = [i for i, pair in enumerate(block) if all(isinstance(b, (str, os.PathLike)) for b in pair)]
            results = (ScoreResult * len(named))()
            reasons = self._run_named([block[i] for i in named], results)
            rows = dict(zip(named, zip(results, reasons)))
            for i, (ref, test) in enumerate(block):
                if i in rows:
                    scores += _checked([self._score(rows[i][0], _name(ref), _name(test), rows[i][1])], errors)
                else:
                    scores += self._run_other(ref, test, errors)
        report("score", len(listed), len(listed))
        if progress is True:
            sys.stderr.write("\n")
        return scores

    def _run_other(self, ref: BRDFLike, test: BRDFLike, errors: str) -> List[Score]:
        try:
            return self._run(ref, [test], errors)
        except Error as error:
            if errors == "raise":
                raise
            return [self._score(_no_result(error), _name(ref), _name(test), error)]

    def score_samples(self, ref: Any, test: Any, used: Any = None) -> Any:
        """Score sampled pairs; see `score_samples`."""
        refs, tests, masks, single = self._samples(ref, test, used)
        results = (ScoreResult * len(tests))()
        with self._turns.take():
            call(lib.nqm_scorer_run_samples, self._handle, len(tests), _sample_pairs(refs, tests, masks), results)
        scores = _checked([self._score(r, "reference", "test") for r in results], "raise")
        return scores[0] if single else scores

    def score_grad(self, ref: Any, test: Any, *, of: str = "jod", used: Any = None) -> Tuple[Any, np.ndarray]:
        """Scores of sampled pairs and their gradients; see `score_grad`."""
        refs, tests, masks, single = self._samples(ref, test, used)
        values, gradients = np.empty(len(tests)), np.empty(tests.shape, np.float32)
        with self._turns.take():
            call(lib.nqm_score_grad, self._handle, choice("of", of, words(_abi.ScoreQuantity)), len(tests),
                 _sample_pairs(refs, tests, masks), address(values), address(gradients))
        return (float(values[0]), gradients[0]) if single else (values, gradients)

    def _samples(self, ref: Any, test: Any, used: Any) -> Tuple[np.ndarray, np.ndarray, Optional[np.ndarray], bool]:
        """`ref` and `test` as (n_pairs, n_directions, 3), `used` as (n_pairs, n_directions); whether there is one pair only."""
        n = self._n_directions
        arrays = [np.asarray(a, dtype=np.float32) for a in (ref, test)]
        for name, a in zip(("ref", "test"), arrays):
            if a.ndim not in (2, 3) or a.shape[-2:] != (n, 3):
                raise ValueError("%s has the shape (%d, 3) or (n_pairs, %d, 3), samples at the model's directions; not %s" %
                                 (name, n, n, a.shape))
        single = arrays[0].ndim == arrays[1].ndim == 2
        refs, tests = np.broadcast_arrays(*[a if a.ndim == 3 else a[None] for a in arrays])
        masks = None if used is None else np.ascontiguousarray(np.broadcast_to(np.asarray(used) != 0, tests.shape[:2]), np.uint8)
        if masks is not None:
            refs, tests = [_without_left_out(a, masks) for a in (refs, tests)]
        # A reference of all tests keeps one address, so that the library shares its computations.
        refs = refs if refs.strides[1:] == (12, 4) else np.ascontiguousarray(refs)
        return refs, np.ascontiguousarray(tests), masks, single


def _without_left_out(samples: np.ndarray, masks: np.ndarray) -> np.ndarray:
    """The samples with 0 where a direction is left out and the library would refuse the value (NaN, infinity, below 0)."""
    refused = (masks[..., None] == 0) & ~((samples >= 0) & np.isfinite(samples))
    return np.where(refused, np.float32(0), samples) if refused.any() else samples


def _sample_pairs(refs: np.ndarray, tests: np.ndarray, masks: Optional[np.ndarray]) -> Any:
    n = len(tests)
    return (SamplePair * n)(*[SamplePair(refs.ctypes.data + i * refs.strides[0], tests[i].ctypes.data,
                               None if masks is None else masks[i].ctypes.data) for i in range(n)])


def _no_result(error: Error) -> ScoreResult:
    nan = math.nan
    r = ScoreResult(status=int(error.status), jod=nan, delta_e=nan, jod_low=nan, jod_high=nan, novelty=nan, similarity=(nan, nan, nan),
                    parts=_abi.Label(nan, (nan, nan, nan), nan, nan, nan))
    r.metrics[:] = [nan] * len(_abi.Metric)
    return r


def _name(value: Any) -> str:
    if isinstance(value, BRDF):
        return value.name
    return os.fsdecode(value) if isinstance(value, (str, os.PathLike)) else getattr(value, "__name__", type(value).__name__)


def _checked(scores: List[Score], errors: str) -> List[Score]:
    for s in scores:
        if s.error and errors == "raise":
            raise s.error
    return scores


@overload
def score(ref: BRDFLike, tests: Union[List[BRDFLike], Tuple[BRDFLike, ...]], *, model: ModelLike = ..., errors: str = ...,
          **options: Any) -> List[Score]: ...
@overload
def score(ref: BRDFLike, tests: BRDFLike, *, model: ModelLike = ..., errors: str = ..., **options: Any) -> Score: ...
def score(ref: BRDFLike, tests: Any, *, model: ModelLike = "default", errors: str = "raise", **options: Any) -> Any:
    """Score one approximation of a reference, or a list of them.

    Args:
        ref: the reference: a `BRDF`, a path, spec or preset, a function, or a table
        tests: one approximation, or a list or tuple of them
        model: a `Model`, the name of a built-in one, or a model file
        errors: "raise": the first test that cannot be scored raises an Error; "keep": its score is NaN, with the `error`
        options: as for `Scorer`: `invalid`, `min_valid`, `metrics`

    Returns:
        a `Score`, or a list of them
    """
    return Scorer(model, **options).score(ref, tests, errors=errors)


def score_many(pairs: Iterable[Tuple[BRDFLike, BRDFLike]], *, model: ModelLike = "default", progress: ProgressLike = None,
               errors: str = "raise", **options: Any) -> List[Score]:
    """Score pairs (reference, test). BRDFs that are given by path or spec are kept in a cache.

    Args:
        pairs: any number of pairs; those of one reference should be adjacent
        model: as for `score`
        progress: called with ("score", done, total); True shows a line on standard error. An exception, such as Ctrl-C, ends
            the call
        errors: as for `score`
        options: as for `Scorer`
    """
    return Scorer(model, **options).score_many(pairs, progress=progress, errors=errors)


def score_samples(ref: Any, test: Any, *, used: Any = None, model: ModelLike = "default", **options: Any) -> Any:
    """Score values that were sampled at the model's directions (`Model.directions`).

    Args:
        ref: f_r in 1/sr, (n_directions, 3) or (n_pairs, n_directions, 3); finite and >= 0
        test: the same; one of them may be a single one for all of the other
        used: (n_directions) or (n_pairs, n_directions): False leaves a direction out, whatever its values; default: all are used
        model: as for `score`
        options: as for `Scorer`

    Returns:
        a `Score`; a list of them if `ref` or `test` has three dimensions
    """
    return Scorer(model, **options).score_samples(ref, test, used)


def score_grad(ref: Any, test: Any, *, of: str = "jod", used: Any = None, model: ModelLike = "default",
               **options: Any) -> Tuple[Any, np.ndarray]:
    """Scores and their gradients by the samples of the test.

    Args:
        ref: as for `score_samples`
        test: as for `score_samples`
        of: "jod", or "delta_e", which is not flat for very different BRDFs, so that optimisers prefer it
        used: as for `score_samples`
        model: as for `score`
        options: as for `Scorer`

    Returns:
        values and gradients: a float and (n_directions, 3), or (n_pairs) and (n_pairs, n_directions, 3); the gradient is
        d value / d f_r of the test
    """
    return Scorer(model, **options).score_grad(ref, test, of=of, used=used)


def preference(jod: float, other_jod: float) -> float:
    """The fraction of people who prefer a picture of quality `jod` to one of quality `other_jod`: 0.5 for equal ones, 0.75 for
    one JOD more."""
    return lib.nqm_jod_preference(jod, other_jod)
