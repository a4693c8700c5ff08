# SPDX-License-Identifier: MIT
"""Materials of files and folders: which look the same, which look most like another one, what changed between versions."""
from __future__ import annotations

import contextlib
import ctypes
import os
import warnings
from ctypes import POINTER, byref
from dataclasses import dataclass
from typing import Any, Dict, Iterator, List, Optional, Sequence, Tuple, Union

from ._abi import Library, LibraryOptions, LibraryPair, LibraryQuery, LibraryValue
from ._call import PathLike, ProgressLike, Watch, call, encode, error_of, progress_callback
from ._library import lib
from ._score import ModelLike, Score, Scorer, score_of

PathsLike = Union[PathLike, Sequence[PathLike]]


class _Finder:
    """A model with options, and what one call reports."""

    def __init__(self, model: ModelLike, ignore: Optional[str], index: Optional[PathLike], progress: ProgressLike, options: Any) -> None:
        self._scorer = Scorer(model, metrics=False, **options)
        self._own = Watch()
        self._messages: List[str] = []
        report = dict(LibraryOptions._fields_)["report"](lambda user, status, message: self._messages.append(os.fsdecode(message)))
        self._options = LibraryOptions(None if ignore is None else encode(ignore), None if index is None else encode(index),
                                       ctypes.pointer(self._scorer._options), progress_callback(progress, (), self._own), report, None)

    @contextlib.contextmanager
    def open(self, where: PathsLike) -> Iterator[Any]:
        paths = [where] if isinstance(where, (str, os.PathLike)) else list(where)
        names, library = (ctypes.c_char_p * len(paths))(*map(encode, paths)), POINTER(Library)()
        try:
            self.call(lib.nqm_library_open, len(paths), names, self._scorer.model._handle, byref(self._options), byref(library))
            yield library
        finally:
            lib.nqm_library_free(library)

    def call(self, function: Any, *args: Any) -> None:
        call(function, *args, own=self._own)
        for message in self._messages:
            warnings.warn(message, stacklevel=5)
        self._messages.clear()

    def pairs(self, function: Any, *args: Any) -> List[LibraryPair]:
        n, found = ctypes.c_size_t(), POINTER(LibraryPair)()
        self.call(function, *args, byref(n), byref(found))
        return found[:n.value]

    def score(self, pair: LibraryPair) -> Score:
        error = error_of(pair.error, pair.error.status) if pair.error.status else None
        return score_of(self._scorer.model, self._scorer._options.invalid, pair.result, os.fsdecode(pair.names.ref),
                        os.fsdecode(pair.names.test), error)


def dedup(where: PathsLike, *, jod: float = 9.5, model: ModelLike = "default", ignore: Optional[str] = None,
          progress: ProgressLike = None, **options: Any) -> List[Score]:
    """Which materials of files and folders look the same as another one of them, so that one is enough. Materials that cannot be read or have
    no values are left out with a warning.

    >>> import json
    >>> paints = [{"name": name, "pbrMetallicRoughness": {"roughnessFactor": r}} for name, r in (("a", 0.3), ("b", 0.301), ("c", 0.6))]
    >>> with open("paints.gltf", "w") as file:
    ...     json.dump({"asset": {"version": "2.0"}, "materials": paints}, file)
    >>> [(score.ref, score.test) for score in nqm.dedup("paints.gltf")]
    [('paints.gltf:b', 'paints.gltf:a')]

    Args:
        where: a file or folder, or several
        jod: the least score at which a material is replaced, 9 to 10
        model: as for `score`; one with a transport matrix
        ignore: what of refused materials is ignored, "transmission,opacity"
        progress: called with stage, work done and total work; raise an exception to stop
        options: as for `Scorer`: `invalid`, `min_valid`

    Returns:
        the scores of replaced materials (`ref`) and those that are kept for them (`test`), which belong together
    """
    finder = _Finder(model, ignore, None, progress, options)
    with finder.open(where) as library:
        return [finder.score(p) for p in finder.pairs(lib.nqm_library_near, library, byref(LibraryQuery(jod=jod)))]


def nearest(brdf: PathLike, among: PathsLike, *, n: int = 10, apart: bool = False, index: Optional[PathLike] = None,
            model: ModelLike = "default", ignore: Optional[str] = None, progress: ProgressLike = None, **options: Any) -> List[Score]:
    """The materials of files or folders that look most like one.

    >>> import json
    >>> paints = [{"name": name, "pbrMetallicRoughness": {"roughnessFactor": r}} for name, r in (("a", 0.3), ("b", 0.4), ("c", 0.8))]
    >>> with open("paints.gltf", "w") as file:
    ...     json.dump({"asset": {"version": "2.0"}, "materials": paints}, file)
    >>> [score.test for score in nqm.nearest("paints.gltf:a", "paints.gltf", n=2)]
    ['paints.gltf:a', 'paints.gltf:b']

    Args:
        brdf: path or spec
        among: a file or folder, or several
        n: how many, 1 to 1000
        apart: by the similarity to people who do not see both at once
        index: a file that keeps the pictures of `among` for later calls
        model: as for `score`; one with a transport matrix
        ignore: what of refused materials is ignored, "transmission,opacity"
        progress: called with stage, work done and total work; raise an exception to stop
        options: as for `Scorer`: `invalid`, `min_valid`

    Returns:
        scores, best first, those without a score last
    """
    finder = _Finder(model, ignore, index, progress, options)
    query = LibraryQuery(encode(brdf), n, apart)
    with finder.open(among) as library:
        return [finder.score(p) for p in finder.pairs(lib.nqm_library_near, library, byref(query))[:n]]


Value = Union[None, float, Tuple[float, ...], str]


@dataclass(frozen=True)
class Change:
    """A material of two versions of files.

    Attributes:
        name: its name in the new version: "gold", or in a folder "metals/a.gltf:gold"; None: it is gone
        was: its name in the old version; None: it is new
        score: that of the new next to the old one; None unless there are both
        properties: old and new values of what changed: a number, a tuple, the text of what a map computes; None: the default of the model.
            "model" is the shading model
        changed: whether it looks different or a property changed; another name is no change, nor is the same refusal in both versions
    """

    name: Optional[str]
    was: Optional[str]
    score: Optional[Score]
    properties: Dict[str, Tuple[Value, Value]]
    changed: bool


def _value(value: LibraryValue) -> Value:
    if value.text is not None or value.n == 0:
        return None if value.text is None else os.fsdecode(value.text)
    return value.v[0] if value.n == 1 else tuple(value.v[:value.n])


def _change(finder: _Finder, before: Any, after: Any, pair: LibraryPair) -> Change:
    old, new = [None if name is None else os.fsdecode(library[0].members[i].key)
                for library, name, i in ((before, pair.names.ref, pair.ref), (after, pair.names.test, pair.test))]
    score = finder.score(pair) if old is not None and new is not None else None
    properties = {c.property.decode(): (_value(c.before), _value(c.after)) for c in pair.changes[:pair.n_changes]}
    is_same = score is not None and (score.identical and not properties or bool(pair.is_refused_alike))
    return Change(new, old, score, properties, not is_same)


def diff(before: PathLike, after: PathLike, *, model: ModelLike = "default", ignore: Optional[str] = None,
         progress: ProgressLike = None, **options: Any) -> List[Change]:
    """How the materials of a file or folder changed: those of the same name; and of names that only one version has, those that look the
    same.

    >>> import json
    >>> for path, roughness in (("old.gltf", 0.3), ("new.gltf", 0.4)):
    ...     with open(path, "w") as file:
    ...         json.dump({"asset": {"version": "2.0"}, "materials": [{"pbrMetallicRoughness": {"roughnessFactor": roughness}}]}, file)
    >>> [(change.name, change.properties) for change in nqm.diff("old.gltf", "new.gltf")]
    [('material1', {'roughness': (0.3, 0.4)})]

    Args:
        before: a file or folder; "/dev/null" has no materials
        after: the same
        model: as for `score`
        ignore: what of refused materials is ignored, "transmission,opacity"
        progress: called with stage, work done and total work; raise an exception to stop
        options: as for `Scorer`: `invalid`, `min_valid`

    Returns:
        worst first; then materials that are gone, then new ones
    """
    finder = _Finder(model, ignore, None, progress, options)
    with finder.open(before) as old, finder.open(after) as new:
        return [_change(finder, old, new, pair) for pair in finder.pairs(lib.nqm_library_diff, old, new)]
