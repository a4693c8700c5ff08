# SPDX-License-Identifier: MIT
"""Materials with image maps, and their scores."""
from __future__ import annotations

import math
from ctypes import byref, c_void_p
from dataclasses import dataclass
from typing import Any, List, Mapping, Optional, Tuple, Union

import numpy as np

from ._abi import TextureMap, TextureResult
from ._library import lib
from ._call import PathLike, ProgressLike, Watch, address, call, encode, ignoring, own_handle, progress_callback
from ._score import ModelLike, Parts, as_model, parts_of


@dataclass(frozen=True)
class MapsInfo:
    """Facts about a textured material.

    Attributes:
        name: the argument that opened it
        model: its shading model, "gltf"
        width: texels of one period of the texture; 1: it does not vary
        height: the same
        n_images: image maps
        varying: the properties that maps change, ("base_color", "roughness", "normal")
    """

    name: str
    model: str
    width: int
    height: int
    n_images: int
    varying: Tuple[str, ...]
    remark: str = ""


def _decoded(key: str, array: np.ndarray) -> np.ndarray:
    """The values of a map that may be stored as in a picture."""
    if array.dtype.kind in "fb":
        return array
    if array.dtype not in (np.uint8, np.uint16):
        raise ValueError("the map %r is of %s: give floats (1 is white), or uint8 or uint16 as in a picture" % (key, array.dtype))
    unit = array / np.iinfo(array.dtype).max
    if key == "normal":
        return 2 * unit - 1
    return np.where(unit <= 0.04045, unit / 12.92, ((unit + 0.055) / 1.055) ** 2.4) if array.ndim == 3 and array.shape[2] == 3 else unit


class Material:
    """A textured material with its decoded maps. Immutable; any thread may use it."""

    _handle: c_void_p

    def __init__(self) -> None:
        raise TypeError("use Material.open or Material.from_maps")

    @classmethod
    def _own(cls, handle: c_void_p) -> "Material":
        material = object.__new__(cls)
        material._handle = handle
        own_handle(material, handle, lib.nqm_texture_free)
        return material

    @classmethod
    def open(cls, path: PathLike, *, ignore: Optional[str] = None, progress: ProgressLike = None) -> "Material":
        """From "FILE" or "FILE:MATERIAL", a folder of maps, or "maps:base_color=a.png;roughness=b.png"; any BRDF is a material that
        does not vary. ignore: as for `BRDF.open`."""
        handle, own = c_void_p(), Watch()
        watcher = progress_callback(progress, (), own)
        call(lib.nqm_texture_open, ignoring(path, ignore), watcher, None, byref(handle), own=own)
        return cls._own(handle)

    @classmethod
    def from_maps(cls, maps: Mapping[str, Any], base: str = "gltf") -> "Material":
        """From arrays.

        Args:
            maps: properties of the model, or "normal" (tangent-space vectors, y up): arrays (h, w) or (h, w, channels) of floats, colours
                linear BT.709; or uint8 or uint16 as in a picture, 0 to the largest value: colours sRGB, normals 0 to 1 for -1 to 1
            base: spec of a shading model with the other properties, "gltf:metallic=1"
        """
        arrays: List[np.ndarray] = []
        table = (TextureMap * max(len(maps), 1))()
        for at, (key, value) in zip(table, maps.items()):
            array = np.ascontiguousarray(_decoded(key, np.asarray(value)), dtype=np.float32)
            array = array[..., None] if array.ndim == 2 else array
            if array.ndim != 3:
                raise ValueError("the map %r has the shape (h, w) or (h, w, channels); not %s" % (key, array.shape))
            arrays.append(array)
            at.key, (at.height, at.width, at.channels), at.values = key.encode(), array.shape, address(array)
        handle = c_void_p()
        call(lib.nqm_texture_create, encode(base if ":" in base else base + ":"), len(maps), table, byref(handle))
        return cls._own(handle)

    @property
    def info(self) -> MapsInfo:
        """Facts about the material."""
        i = lib.nqm_texture_get_info(self._handle, None)
        return MapsInfo(i.name.decode("utf-8", "replace"), i.model.decode(), i.width, i.height, i.n_images,
                        tuple(i.varying.decode().split()), i.remark.decode("utf-8", "replace"))

    def __repr__(self) -> str:
        i = self.info
        return "<nqm.Material %s, %d x %d>" % (i.name, i.width, i.height)


MaterialLike = Union[Material, PathLike, Mapping[str, Any]]


def as_material(value: MaterialLike) -> Material:
    """A material from what functions accept as one."""
    if isinstance(value, Material):
        return value
    return Material.from_maps(value) if isinstance(value, Mapping) else Material.open(value)


@dataclass(frozen=True)
class Blame:
    """What the exchange of one property alone changes.

    Attributes:
        property: "roughness", "normal"
        jod: near score of the reference with this property of the test
        mistake: "roughness is squared"; None: none of the mistakes that are known
    """

    property: str
    jod: float
    mistake: Optional[str]


@dataclass(frozen=True)
class MapScore:
    """The score of a pair of textured materials. str() is "8.41 JOD [8.20, 8.60]".

    Attributes:
        jod: near: of the mean Delta-E over the texels
        jod_low: lower end of its 95 % interval
        jod_high: upper end
        delta_e: that mean
        error: standard error of jod by the choice of texels; 0: all were scored
        parts: means of the predicted parts; None if the model predicts none
        median: JOD of the median texel
        worst: JOD that the worst 5 % of texels do not reach
        below_9: share of texels below 9
        below_8: share of texels below 8
        far_jod: JOD of the mean BRDFs; nan if not wanted
        far_interval: both ends of its interval
        n_different: different pairs of texels
        n_scored: pairs that were scored
        blame: what each property alone changes, worst first
        heat: (height, width) Delta-E of each texel; None unless wanted
    """

    jod: float
    jod_low: float
    jod_high: float
    delta_e: float
    error: float
    parts: Optional[Parts]
    median: float
    worst: float
    below_9: float
    below_8: float
    far_jod: float
    far_interval: Tuple[float, float]
    n_different: int
    n_scored: int
    blame: Tuple[Blame, ...]
    heat: Optional[np.ndarray]

    def __str__(self) -> str:
        return "%.2f JOD [%.2f, %.2f]" % (self.jod, self.jod_low, self.jod_high)


def map_score_of(r: TextureResult, heat: Optional[np.ndarray]) -> MapScore:
    blame = tuple(Blame(b.key.decode(), b.jod, b.mistake.decode() or None) for b in r.blame[:r.n_blame])
    parts = None if math.isnan(r.parts.structure) else parts_of(r.parts)
    return MapScore(r.jod, r.jod_low, r.jod_high, r.delta_e, r.error, parts, r.median, r.worst, r.below[0], r.below[1], r.far_jod[0],
                    (r.far_jod[1], r.far_jod[2]), r.n_different, r.n_scored, blame, heat)


def score_maps(ref: MaterialLike, test: MaterialLike, *, model: ModelLike = "default", exact: bool = False, texels: int = 2048,
               texels_per_pixel: int = 1, blame: bool = True, far: bool = True, heat: bool = False, seed: int = 1,
               progress: ProgressLike = None) -> MapScore:
    """Score a textured material beside its reference.

    Args:
        ref: a `Material`, what `Material.open` takes, or maps as arrays as in `Material.from_maps`
        test: the same
        model: a model that predicts Delta-E
        exact: score every different pair of texels
        texels: otherwise at most so many, drawn evenly
        texels_per_pixel: compare the means over so many texels along each side of a pixel, of 256 pixels (48 with normals)
        blame: exchange each map alone, too; not of pixels
        far: the far score, too
        heat: the Delta-E of each texel, too
        seed: of the choice of texels
        progress: called with stage, work done and total work; raise an exception to stop
    """
    a, b, own, result = as_material(ref), as_material(test), Watch(), TextureResult()
    options = lib.nqm_texture_options_default()
    options.exact, options.n_texels, options.blame, options.far, options.seed = exact, texels, blame, far, seed
    options.texels_per_pixel = texels_per_pixel
    options.progress = progress_callback(progress, (), own)
    size = lib.nqm_texture_get_info(a._handle, b._handle)
    picture = np.empty((size.height, size.width), np.float32) if heat else None
    call(lib.nqm_texture_score, as_model(model)._handle, a._handle, b._handle, byref(options), byref(result),
         None if picture is None else address(picture), own=own)
    return map_score_of(result, picture)
