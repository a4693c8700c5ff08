# SPDX-License-Identifier: MIT
"""Datasets of labelled pairs as arrays."""
from __future__ import annotations

import functools
import json
from ctypes import byref, c_void_p
from typing import Any, Dict, Optional

import numpy as np

from . import _abi
from ._library import lib
from ._brdf import Directions
from ._call import PathLike, call, choice, encode, own_handle, words

_TYPES = {"F32": "<f4", "F64": "<f8", "U8": "u1", "U32": "<u4"}


def _tensors(path: PathLike) -> Dict[str, np.ndarray]:
    """The arrays of a safetensors file, in the mapped file. The library has checked it."""
    file = np.memmap(path, dtype=np.uint8, mode="r")
    start = 8 + int.from_bytes(file[:8].tobytes(), "little")
    header = json.loads(file[8:start].tobytes())
    header.pop("__metadata__", None)
    found = {}
    for name, t in header.items():
        begin, end = t["data_offsets"]
        found[name] = file[start + begin:start + end].view(_TYPES[t["dtype"]]).reshape(t["shape"])
    return found


class Dataset:
    """Labelled pairs of sampled BRDFs. Arrays of pairs are in the order of the dataset; samples are f_r in 1/sr at `directions`.

    Attributes:
        jod: (n_pairs) labels: JOD, or a human score
        delta_e: (n_pairs) labels: Delta-E ITP
        split: (n_pairs) "train", "validation" or "test"
        ref: (n_pairs) names of the references
        test: (n_pairs) specs or names of the tests
        group: (n_pairs) material groups of the references; a group belongs to one split
        kind: (n_pairs) kinds of distortion
        family: (n_pairs) their families: "encoding", "perturbation", ...; "" if unknown
        material_class: (n_pairs) classes of the references: "matte grey", ...
        source: (n_pairs) where the references come from: "measured", "neural", "analytic", ...; "" if unknown
    """

    jod: np.ndarray
    delta_e: np.ndarray
    split: np.ndarray
    ref: np.ndarray
    test: np.ndarray
    group: np.ndarray
    kind: np.ndarray
    family: np.ndarray
    material_class: np.ndarray
    source: np.ndarray
    _handle: c_void_p
    _tensors: Optional[Dict[str, np.ndarray]]

    def __init__(self) -> None:
        raise TypeError("use Dataset.open or Dataset.open_authors")

    @classmethod
    def _own(cls, handle: c_void_p, tensors: Optional[Dict[str, np.ndarray]]) -> "Dataset":
        dataset = object.__new__(cls)
        dataset._handle = handle
        dataset._tensors = tensors
        own_handle(dataset, handle, lib.nqm_dataset_free)
        return dataset

    @classmethod
    def open(cls, path: PathLike) -> "Dataset":
        """Open a dataset file (`nqm dataset` makes them). Its checksum is checked; samples stay in the mapped file."""
        handle = c_void_p()
        call(lib.nqm_dataset_load, encode(path), None, 0, byref(handle))
        return cls._own(handle, _tensors(path))

    @classmethod
    def open_authors(cls, root: PathLike, labels_csv: PathLike, *, split: str = "all") -> "Dataset":
        """Open the folder layout of the paper's authors (doc/files.md). Such a dataset has labels, but `ref_samples`, `test_samples` and
        `used` are not available."""
        handle = c_void_p()
        call(lib.nqm_dataset_load, encode(root), encode(labels_csv), choice("split", split, words(_abi.Split)), byref(handle))
        return cls._own(handle, None)

    def __len__(self) -> int:
        """Number of pairs."""
        return lib.nqm_dataset_get_info(self._handle).n_pairs

    def __repr__(self) -> str:
        return "<nqm.Dataset of %d pairs>" % len(self)

    @property
    def sha256(self) -> str:
        """Checksum of the file."""
        return lib.nqm_dataset_get_info(self._handle).sha256.decode()

    @property
    def manifest(self) -> Dict[str, Any]:
        """How the dataset was made; empty if unknown."""
        return json.loads(lib.nqm_dataset_get_info(self._handle).manifest or b"{}")

    @property
    def directions(self) -> Directions:
        """Where the BRDFs are sampled."""
        return Directions._wrap(c_void_p(lib.nqm_dataset_get_info(self._handle).directions), owner=self)

    @functools.cached_property
    def _columns(self) -> Dict[str, np.ndarray]:
        pairs = [lib.nqm_dataset_get_pair(self._handle, i) for i in range(len(self))]
        columns = {name: np.array([getattr(p, name) for p in pairs], dtype=np.float64) for name in ("jod", "delta_e")}
        for name in ("ref", "group", "test", "kind", "family", "material_class", "source"):
            columns[name] = np.array([getattr(p, name).decode() for p in pairs], dtype=object)
        columns["split"] = np.array([_abi.Split(p.split).name.lower() for p in pairs], dtype=object)
        return columns

    def __getattr__(self, name: str) -> np.ndarray:
        if not name.startswith("_") and name in self._columns:
            return self._columns[name]
        raise AttributeError("Dataset has no %r" % name)

    def _tensor(self, name: str) -> np.ndarray:
        if self._tensors is None:
            raise ValueError("a dataset in the authors' layout gives no samples; read its MAT files")
        return self._tensors[name]

    def _has(self, name: str) -> bool:
        return self._tensors is not None and name in self._tensors

    def ref_samples(self, i: Any = slice(None)) -> np.ndarray:
        """f_r of the references of the pairs `i` (a number, slice or array): (..., n_directions, 3) float32."""
        return self._tensor("ref_rgb")[self._tensor("pair_ref")[i]]

    def test_samples(self, i: Any = slice(None)) -> np.ndarray:
        """f_r of the tests of the pairs `i`: (..., n_directions, 3) float32, in the mapped file where possible."""
        return self._tensor("test_rgb")[i]

    def used(self, i: Any = slice(None)) -> np.ndarray:
        """Whether both BRDFs of the pairs `i` have a value: (..., n_directions) bool."""
        shape = self._tensor("test_rgb")[i].shape[:-1]
        used = np.ones(shape, bool)
        if self._has("ref_used"):
            used &= self._tensor("ref_used")[self._tensor("pair_ref")[i]] != 0
        if self._has("test_used"):
            used &= self._tensor("test_used")[i] != 0
        return used

    def parts(self, i: Any = slice(None)) -> Optional[np.ndarray]:
        """Parts of the labels of the pairs `i`: (..., 5) shift of I, T and P, contrast, structure; None if the dataset has none."""
        return self._tensor("parts")[i] if self._has("parts") else None

    def delta_e_error(self, i: Any = slice(None)) -> Optional[np.ndarray]:
        """Standard errors of the labels `delta_e` of the pairs `i`; None if the dataset has none."""
        return self._tensor("delta_e_error")[i] if self._has("delta_e_error") else None
