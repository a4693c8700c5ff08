# SPDX-License-Identifier: MIT
"""BRDFs: opened from files and specs, made from Python functions and arrays; directions and samples."""
from __future__ import annotations

import itertools
import os
from ctypes import byref, c_void_p
from dataclasses import dataclass
from typing import Any, Callable, Iterable, Optional, Sequence, Tuple, Union

import numpy as np

from . import _abi
from ._library import lib
from ._call import (PathLike, ProgressLike, Watch, address, array_at, call, choice, decode, encode, ignoring, names_of, own_handle, progress_callback,
                    triples, words)

#: A function of Python code that evaluates a BRDF: `wi`, `wo` (n, 3) to f_r (n, 3).
EvalFunction = Callable[[np.ndarray, np.ndarray], Any]


@dataclass(frozen=True)
class BRDFInfo:
    """Facts about a BRDF.

    Attributes:
        format: "merl", "rgl", "nbrdf", "nps", "table", "callback", "lambert", "ggx", "perturb", ...
        name: the path or spec that was opened, or the name it was given
        spec: analytic models: the canonical spec, which opens the same BRDF; otherwise None
        source_doi: publication of the format or of the parameters; None if there is none
        layout: resolution or parameters ("90 x 90 x 180 cells"); None if there is none
        remark: what of the file is not used, or is assumed; None: nothing
        n_values: number of stored values: cells times channels, weights, or parameters
        n_bytes: size of the file; 0 if the BRDF has no file
        reciprocal: True when f_r(wi, wo) = f_r(wo, wi) by construction
        isotropic: True when turning light and viewer about the normal changes nothing, by construction
    """

    format: str
    name: str
    spec: Optional[str]
    source_doi: Optional[str]
    layout: Optional[str]
    remark: Optional[str]
    n_values: int
    n_bytes: int
    reciprocal: bool
    isotropic: bool


@dataclass(frozen=True)
class CheckReport:
    """Physical plausibility of a BRDF, from `BRDF.check`.

    Attributes:
        n_pairs: direction pairs tested
        n_clamped: pairs with a negative channel, which counts as 0
        n_invalid: pairs without a value
        reciprocity_median: median of |f(a,b) - f(b,a)| / mean over pairs with a mean luminance above 1e-4 1/sr
        reciprocity_p95: 95th percentile of the same
        anisotropy: mean of |f - f turned| / mean over pairs that are turned about the normal, 0 to 2; 0 if isotropic
        albedo_max: largest directional-hemispherical albedo at angles of 0 to 75 degrees, per channel
        albedo_max_theta_rad: the angle of the largest of the three
    """

    n_pairs: int
    n_clamped: int
    n_invalid: int
    reciprocity_median: float
    reciprocity_p95: float
    anisotropy: float
    albedo_max: Tuple[float, float, float]
    albedo_max_theta_rad: float


@dataclass(frozen=True)
class Difference:
    """Where the values of two BRDFs differ most, from `compare`.

    Attributes:
        equal: whether no pair of directions differs by more than the tolerance, and none is missing
        largest: largest |ref - test| / max(ref, test) of a channel, 0 to 1
        wi: direction to the light there, a unit vector
        wo: direction to the viewer there
        channel: the channel: 0 red, 1 green, 2 blue
        ref: the value of the reference there, 1/sr
        test: the value of the test there
        n_pairs: pairs of directions at which one of them has a value
        n_different: those that differ by more than the tolerance
        n_missing: those where only one of them has a value
    """

    equal: bool
    largest: float
    wi: Tuple[float, float, float]
    wo: Tuple[float, float, float]
    channel: int
    ref: float
    test: float
    n_pairs: int
    n_different: int
    n_missing: int


def _callback(function: EvalFunction, watch: Watch) -> Any:
    """`function` as a C callback. After an exception it gives no values, so that the call ends soon."""

    def evaluate(user: Any, n: int, wi: Any, wo: Any, rgb: Any) -> None:
        a, b, out = (np.ctypeslib.as_array(x, shape=(n, 3)) for x in (wi, wo, rgb))
        value = None if watch.stopped() else watch.run(values, a.copy(), b.copy())
        out[...] = np.nan if value is None else value

    def values(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        value = np.asarray(function(wi, wo), dtype=np.float64)
        if value.shape != wi.shape:
            raise ValueError("the function of a BRDF must return f_r of the shape (n, 3); for n = %d it returned %s" %
                             (len(wi), value.shape))
        return value

    return _abi.BrdfEval(evaluate)


class BRDF:
    """An RGB BRDF. Immutable; any thread may use it.

    Directions are unit vectors that point away from the surface, with the normal (0, 0, 1); `wi` points to the light, `wo` to
    the viewer. Values are f_r in 1/sr without the cosine, linear RGB with BT.709 primaries.
    """

    _handle: c_void_p
    _callback: Any
    _watches: Tuple[Watch, ...]

    def __init__(self) -> None:
        raise TypeError("use BRDF.open, BRDF.from_function or BRDF.from_table")

    @classmethod
    def _own(cls, handle: c_void_p, callback: Any = None, watch: Optional[Watch] = None) -> "BRDF":
        brdf = object.__new__(cls)
        brdf._handle = handle
        brdf._callback = callback  # must live as long as the handle
        brdf._watches = (watch,) if watch else ()
        own_handle(brdf, handle, lib.nqm_brdf_free)
        return brdf

    @classmethod
    def open(cls, path_or_spec: PathLike, *, ignore: Optional[str] = None) -> "BRDF":
        """Open a BRDF from a file, a spec (`"ggx:kd=.2,.1,.05;alpha=.1"`) or a preset (`"sgd:nickel"`). doc/brdf.md lists the
        specs, doc/files.md the files.

        Args:
            ignore: of a material that does more than reflect, take what reflects: any of transmission, subsurface, emission,
                opacity, displacement and bump, separated by commas; None: such a material is an error

        Raises:
            Error: the file is missing or malformed (`byte` is the position), or the spec is wrong
        """
        handle = c_void_p()
        call(lib.nqm_brdf_open, ignoring(path_or_spec, ignore), byref(handle))
        return cls._own(handle)

    @classmethod
    def from_function(cls, function: EvalFunction, *, reciprocal: bool = False, name: Optional[str] = None) -> "BRDF":
        """A BRDF that Python code evaluates.

        Args:
            function: gets `wi` and `wo`, float64 (n, 3) with n up to 512, above the horizon; returns f_r (n, 3). It must return
                the same values for the same directions. A negative channel counts as 0; NaN means that there is no value.
                Threads of the library call it one at a time. An exception ends the call in progress, which raises it.
            reciprocal: whether f_r(wi, wo) = f_r(wo, wi) always; reported by `info`, not checked
            name: for messages and `info`; default: the name of the function
        """
        watch = Watch()
        callback = _callback(function, watch)
        label = name if name is not None else getattr(function, "__name__", type(function).__name__)
        callbacks = _abi.BrdfCallbacks(eval=callback, name=encode(label), reciprocal=int(reciprocal), serialize=1)
        handle = c_void_p()
        call(lib.nqm_brdf_create, byref(callbacks), byref(handle))
        return cls._own(handle, callback, watch)

    @classmethod
    def from_table(cls, rgb: Any, *, name: Optional[str] = None) -> "BRDF":
        """A BRDF from an array over half-vector coordinates, with linear interpolation between nodes.

        Args:
            rgb: (n_theta_h, n_theta_d, n_phi_d, 3) f_r in 1/sr; NaN in channel 0 marks a node without a value. Node i of
                theta_h is at (i / (n_theta_h - 1))^2 pi/2, node j of theta_d at j / (n_theta_d - 1) pi/2, node k of phi_d at
                k / n_phi_d pi: `table_nodes` computes them.
            name: for messages and `info`; default: "table"
        """
        table = np.ascontiguousarray(rgb, dtype=np.float32)
        if table.ndim != 4 or table.shape[3] != 3:
            raise ValueError("a table has the shape (n_theta_h, n_theta_d, n_phi_d, 3); not %s" % (table.shape,))
        handle = c_void_p()
        call(lib.nqm_brdf_create_table, *table.shape[:3], address(table), encode(name) if name else None, byref(handle))
        return cls._own(handle)

    @property
    def info(self) -> BRDFInfo:
        """Facts about the BRDF."""
        i = lib.nqm_brdf_get_info(self._handle)
        return BRDFInfo(i.format.decode(), decode(i.name) or "", decode(i.spec), decode(i.source_doi), decode(i.layout),
                        decode(i.remark), i.n_values, i.n_bytes, bool(i.reciprocal), bool(i.isotropic))

    @property
    def name(self) -> str:
        """The path or spec that was opened, or the name it was given."""
        return self.info.name

    def __repr__(self) -> str:
        return "<nqm.BRDF %s>" % self.name

    def eval(self, wi: Any, wo: Any) -> np.ndarray:
        """f_r in 1/sr, finite and >= 0, for direction pairs; 0 at or below the horizon and where there is no value
        (`eval_flags` tells them apart).

        Args:
            wi: (..., 3) unit vectors to the light
            wo: (..., 3) unit vectors to the viewer; the shapes are broadcast

        Returns:
            (..., 3) float64
        """
        return self.eval_flags(wi, wo)[0]

    def eval_flags(self, wi: Any, wo: Any) -> Tuple[np.ndarray, np.ndarray]:
        """As `eval`, with a flag for each pair: 0 a value; 1 a negative channel was replaced by 0; 2 no value; 3 light or
        viewer at or below the horizon. Returns (..., 3) float64 and (...) uint8."""
        wi, wo = _pairs(wi, wo)
        rgb, flag = np.empty(wi.shape), np.empty(wi.shape[:-1], np.uint8)
        call(lib.nqm_brdf_eval, self._handle, flag.size, address(wi), address(wo), address(rgb), address(flag),
             watches=self._watches)
        return rgb, flag

    def eval_half_diff(self, hd: Any) -> np.ndarray:
        """As `eval`, for half-vector coordinates (..., 3): theta_h, theta_d, phi_d in radians."""
        hd = triples("hd", hd)
        rgb = np.empty(hd.shape)
        call(lib.nqm_brdf_eval_half_diff, self._handle, hd.size // 3, address(hd), address(rgb), None, watches=self._watches)
        return rgb

    def to_table(self, n_theta_h: int = 90, n_theta_d: int = 90, n_phi_d: int = 36) -> np.ndarray:
        """The BRDF as a table for `from_table`: (n_theta_h, n_theta_d, n_phi_d, 3) float32, f_r at `table_nodes`; NaN at nodes without a
        value and below the horizon."""
        hd = table_nodes(n_theta_h, n_theta_d, n_phi_d)
        rgb, flag = np.empty(hd.shape), np.empty(hd.shape[:-1], np.uint8)
        call(lib.nqm_brdf_eval_half_diff, self._handle, flag.size, address(hd), address(rgb), address(flag), watches=self._watches)
        rgb[flag >= 2] = np.nan
        return rgb.astype(np.float32)

    def jacobian(self, wi: Any, wo: Any) -> Tuple[np.ndarray, np.ndarray]:
        """f_r of an analytic model and its exact derivatives by its parameters, in the order of the keys of `info.spec`, three for
        an RGB key. Returns f_r (..., 3) and derivatives (..., 3, n_parameters).

        Raises:
            Error: the BRDF is not analytic
        """
        wi, wo = _pairs(wi, wo)
        rgb, jacobian = np.empty(wi.shape), np.empty((*wi.shape, self.info.n_values))
        call(lib.nqm_brdf_jacobian, self._handle, wi.size // 3, address(wi), address(wo), address(rgb), address(jacobian))
        return rgb, jacobian

    def albedo(self, theta_i_rad: Any = 0.0, *, seed: int = 1) -> np.ndarray:
        """Directional-hemispherical albedo: the integral of f_r cos(theta_o) over the hemisphere. Angles (...) in 0 to pi/2 give
        (..., 3)."""
        theta = np.asarray(theta_i_rad, dtype=np.float64)
        if not np.all((theta >= 0) & (theta <= np.pi / 2)):
            raise ValueError("theta_i_rad is from 0 to pi/2")
        rgb = np.empty((*theta.shape, 3))
        rows = rgb.reshape(-1, 3)
        for i, angle in enumerate(theta.ravel()):
            call(lib.nqm_brdf_albedo, self._handle, angle, seed, rows[i].ctypes.data, watches=self._watches)
        return rgb

    def check(self, *, seed: int = 1) -> CheckReport:
        """Measure reciprocity, energy conservation and positivity. The same seed gives the same report."""
        r = _abi.BrdfCheckReport()
        call(lib.nqm_brdf_check, self._handle, seed, byref(r), watches=self._watches)
        return CheckReport(r.n_pairs, r.n_clamped, r.n_invalid, r.reciprocity_median, r.reciprocity_p95, r.anisotropy,
                           (r.albedo_max[0], r.albedo_max[1], r.albedo_max[2]), r.albedo_max_theta_rad)

    def sample(self, directions: "Directions", *, invalid: str = "drop") -> Tuple[np.ndarray, np.ndarray]:
        """Sample at every direction of a set.

        Args:
            directions: the set, such as `Model.open("default").directions`
            invalid: what happens where there is no value: "drop" and "zero" give 0, "nearest" the nearest value, "error"
                raises an Error

        Returns:
            f_r (n, 3) float32, and flags (n) uint8 as those of `eval_flags`
        """
        rgb, flag = np.empty((len(directions), 3), np.float32), np.empty(len(directions), np.uint8)
        call(lib.nqm_sample, self._handle, directions._handle, choice("invalid", invalid, words(_abi.InvalidPolicy)), address(rgb),
             address(flag), None, watches=self._watches)
        return rgb, flag

    def save(self, path: PathLike) -> None:
        """Write a small network ("nbrdf") or a table as a safetensors file, which `open` reads back to the same values. The other
        formats have a spec or a file already."""
        self._write("safetensors", path)

    def save_table(self, path: PathLike, format: str = "merl", *, progress: ProgressLike = None) -> None:
        """Write a table of any BRDF: f_r at the centres of the cells, -1 in cells without a value.

        Args:
            path: the file appears under its name only when it is complete
            format: "merl": 90 x 90 x 180 cells, reciprocal; "merl_360": 90 x 90 x 360 cells, which distinguish light and viewer; "npy": an
                array for `from_table`, for any BRDF
            progress: called with the stage, the work done and the total; True shows a line on standard error
        """
        choice("format", format, ("merl", "merl_360", "npy"))
        self._write(format, path, progress=progress)

    def save_material(self, path: PathLike, name: str = "material") -> None:
        """Write a material file of a renderer, whose extension selects the format (doc/materials.md). The BRDF must be a shading model
        that the format has, such as the result of `fit`."""
        if self.info.spec is None:
            raise ValueError("%s has no spec: only shading models can be written as a material" % self.name)
        self._write("material", path, name)

    def _write(self, format: str, path: PathLike, name: str = "material", progress: ProgressLike = None) -> None:
        own = Watch()
        call(lib.nqm_brdf_write, self._handle, _abi.FileFormat[format.upper()], encode(name), encode(path),
             progress_callback(progress, self._watches, own), None, watches=self._watches, own=own)


#: What functions accept as a BRDF: a `BRDF`; a path, spec or preset; a function as for `BRDF.from_function`; a table (4-dimensional array).
BRDFLike = Union[BRDF, PathLike, EvalFunction, np.ndarray]


@dataclass(frozen=True)
class MaterialInfo:
    """A material in a file of a renderer, from `materials`.

    Attributes:
        name: as in the file; "material1", ... for materials without a name
        surface: the shading model, as the file calls it: "open_pbr_surface"
        spec: argument of `BRDF.open`: a spec, or a path relative to the file's folder; None: refused
        refusal: the property that cannot be honoured, and why; None: the material is accepted
        n_maps: image maps of a material that `Material.open` takes; 0: none
        remark: what of the file is not used although it may matter, or is assumed; None: nothing
        unused: what it gives without effect on a BRDF, or on this one: "doubleSided; clearcoatTexture"; None: nothing
        byte: of the material or of the refused property in the file; None: unknown
        ignorable: what the surface does besides reflecting, if the material is refused for that alone: the `ignore` that
            `BRDF.open` needs; None: not so
        reflection: the spec of what reflects then; None: as `ignorable`, or image maps change it
    """

    name: str
    surface: str
    spec: Optional[str]
    refusal: Optional[str]
    n_maps: int
    remark: Optional[str]
    unused: Optional[str]
    byte: Optional[int]
    ignorable: Optional[str]
    reflection: Optional[str]


def materials(path: PathLike) -> Tuple[MaterialInfo, ...]:
    """The materials of a file, in its order. `BRDF.open("FILE:NAME")` opens one."""
    handle = c_void_p()
    call(lib.nqm_materials_open, encode(path), byref(handle))
    try:
        rows = list(itertools.takewhile(lambda row: row.name is not None, (lib.nqm_materials_get(handle, i) for i in itertools.count())))
        return tuple(MaterialInfo(decode(r.name) or "", decode(r.surface) or "", decode(r.spec), decode(r.refusal),
                                  r.n_maps, decode(r.remark), decode(r.unused), r.byte_offset if r.byte_offset >= 0 else None,
                                  decode(r.ignorable), decode(r.reflection)) for r in rows)
    finally:
        lib.nqm_materials_free(handle)


def files_within(folder: Optional[PathLike]) -> None:
    """Read only files inside of a folder from now on, in the whole process; None: read all. For services: an uploaded material may name
    any file as a map."""
    call(lib.nqm_files_within, None if folder is None else encode(folder))


def as_brdf(value: BRDFLike) -> BRDF:
    """A BRDF from what functions accept as one."""
    if isinstance(value, BRDF):
        return value
    if isinstance(value, (str, os.PathLike)):
        return BRDF.open(value)
    if isinstance(value, np.ndarray):
        return BRDF.from_table(value)
    if callable(value):
        return BRDF.from_function(value)
    raise TypeError("a BRDF is a nqm.BRDF, a path or spec, a function of wi and wo, or a table; not %s" % type(value).__name__)


def handles_of(brdfs: Sequence[BRDF]) -> Any:
    return (c_void_p * len(brdfs))(*[b._handle.value for b in brdfs])


def compare(ref: BRDFLike, test: BRDFLike, *, tolerance: float = 1e-4, seed: int = 1) -> Difference:
    """Compare the values of two BRDFs: whether a formula is implemented as it is specified. A score cannot tell, because people may
    not see the difference.

    Args:
        ref: the reference: a BRDF, path, spec or preset
        test: what is compared with it
        tolerance: largest relative difference of equal values
        seed: of the 8192 random pairs of directions, half of them near the mirror direction
    """
    brdfs = as_brdf(ref), as_brdf(test)
    d = _abi.BrdfDifference()
    call(lib.nqm_brdf_compare, *(b._handle for b in brdfs), tolerance, seed, byref(d), watches=watches_of(brdfs))
    return Difference(bool(d.is_equal), d.largest, tuple(d.wi), tuple(d.wo), d.channel, d.ref, d.test, d.n_pairs, d.n_different,
                      d.n_missing)


def watches_of(brdfs: Iterable[BRDF]) -> Tuple[Watch, ...]:
    return tuple(watch for brdf in brdfs for watch in brdf._watches)


def _pairs(wi: Any, wo: Any) -> Tuple[np.ndarray, np.ndarray]:
    wi, wo = np.broadcast_arrays(triples("wi", wi), triples("wo", wo))
    return np.ascontiguousarray(wi), np.ascontiguousarray(wo)


def presets() -> Tuple[str, ...]:
    """Names of the built-in presets ("sgd:nickel", ...), which `BRDF.open` takes."""
    return names_of(lib.nqm_brdf_preset_name)


def table_nodes(n_theta_h: int, n_theta_d: int, n_phi_d: int) -> np.ndarray:
    """Half-vector coordinates of the nodes of `BRDF.from_table`: (n_theta_h, n_theta_d, n_phi_d, 3), radians."""
    theta_h = (np.arange(n_theta_h) / (n_theta_h - 1)) ** 2 * (np.pi / 2)
    theta_d = np.arange(n_theta_d) / (n_theta_d - 1) * (np.pi / 2)
    phi_d = np.arange(n_phi_d) / n_phi_d * np.pi
    return np.stack(np.meshgrid(theta_h, theta_d, phi_d, indexing="ij"), axis=-1)


def half_diff_to_directions(hd: Any) -> Tuple[np.ndarray, np.ndarray]:
    """Half-vector coordinates (..., 3) in radians to unit vectors `wi`, `wo` (..., 3), with phi_h = 0."""
    hd = triples("hd", hd)
    wi, wo = np.empty(hd.shape), np.empty(hd.shape)
    for i in range(hd.size // 3):
        call(lib.nqm_half_diff_to_directions, address(hd) + 24 * i, address(wi) + 24 * i, address(wo) + 24 * i)
    return wi, wo


def directions_to_half_diff(wi: Any, wo: Any) -> np.ndarray:
    """Unit vectors (..., 3) to theta_h, theta_d, phi_d (..., 3) in radians; phi_d is in [0, pi) by reciprocity."""
    wi, wo = _pairs(wi, wo)
    hd = np.empty(wi.shape)
    for i in range(wi.size // 3):
        call(lib.nqm_directions_to_half_diff, address(wi) + 24 * i, address(wo) + 24 * i, address(hd) + 24 * i)
    return hd


class Directions:
    """An ordered set of directions at which BRDFs are compared, with an identity. Immutable."""

    _handle: c_void_p
    _owner: Any

    def __init__(self) -> None:
        raise TypeError("use Directions.open, Directions.create, Directions.from_degrees or Model.directions")

    @classmethod
    def _wrap(cls, handle: Any, owner: Any = None) -> "Directions":
        """`owner` keeps the directions of a model or dataset alive; without one they are freed with this object."""
        directions = object.__new__(cls)
        directions._handle = handle
        directions._owner = owner
        if owner is None:
            own_handle(directions, handle, lib.nqm_directions_free)
        return directions

    @classmethod
    def open(cls, path: PathLike) -> "Directions":
        """Read a CSV with the columns theta_h, theta_d and phi_d in degrees."""
        handle = c_void_p()
        call(lib.nqm_directions_load_csv, encode(path), byref(handle))
        return cls._wrap(handle)

    @classmethod
    def from_degrees(cls, hd_deg: Any) -> "Directions":
        """From (n, 3) theta_h, theta_d, phi_d in degrees."""
        hd = triples("hd_deg", hd_deg)
        if hd.ndim != 2:
            raise ValueError("hd_deg has the shape (n, 3); not %s" % (hd.shape,))
        handle = c_void_p()
        call(lib.nqm_directions_from_degrees, len(hd), address(hd), byref(handle))
        return cls._wrap(handle)

    @classmethod
    def create(cls, n: int = 500, *, references: Iterable[BRDFLike] = (), progress: ProgressLike = None,
               **options: Any) -> "Directions":
        """Choose directions: theta_h denser toward 0, both polar angles bounded, and drawn where the references carry energy.

        Args:
            n: how many, 1 to 100000
            references: BRDFs that decide what carries energy; none: every candidate is kept
            progress: see `ProgressLike`
            options: `seed` (1), `max_polar_rad` (75 degrees), `theta_h_power` (2), `oversampling` (4)
        """
        brdfs = [as_brdf(r) for r in references]
        own, watches = Watch(), watches_of(brdfs)
        o = set_options(lib.nqm_directions_options_default(), {"n": n, **options}, ("n", "seed", "max_polar_rad", "theta_h_power", "grid", "oversampling"))
        o.progress = progress_callback(progress, watches, own)
        handle = c_void_p()
        call(lib.nqm_directions_create, byref(o), len(brdfs), handles_of(brdfs), byref(handle), watches=watches, own=own)
        return cls._wrap(handle)

    def save(self, path: PathLike) -> None:
        """Write a CSV, which `open` reads back to the same set."""
        call(lib.nqm_directions_save_csv, self._handle, encode(path))

    def __len__(self) -> int:
        return lib.nqm_directions_get_info(self._handle).n

    def __repr__(self) -> str:
        return "<nqm.Directions %s, %d>" % (self.id, len(self))

    @property
    def id(self) -> str:
        """16 hex digits that identify the set."""
        return lib.nqm_directions_id(self._handle).decode()

    @property
    def degrees(self) -> np.ndarray:
        """(n, 3) theta_h, theta_d, phi_d in degrees; a copy."""
        return array_at(lib.nqm_directions_get_info(self._handle).degrees, (len(self), 3))

    @property
    def vectors(self) -> Tuple[np.ndarray, np.ndarray]:
        """Unit vectors `wi`, `wo`, (n, 3) each."""
        i = lib.nqm_directions_get_info(self._handle)
        return array_at(i.wi, (i.n, 3)), array_at(i.wo, (i.n, 3))


def set_options(struct: Any, options: Any, names: Sequence[str]) -> Any:
    """Set members of an options struct by name."""
    for name, value in options.items():
        if name not in names:
            raise TypeError("unknown option %r; there are %s" % (name, ", ".join(names)))
        setattr(struct, name, value)
    return struct
