# SPDX-License-Identifier: MIT
"""Scenes: pictures of BRDFs, and labels by comparing them."""
from __future__ import annotations

import functools
import warnings
from ctypes import byref, c_double, c_size_t, c_void_p
from dataclasses import dataclass
from typing import Any, List, Optional, Tuple, Union, overload

import numpy as np

from . import _abi
from ._library import lib
from ._brdf import BRDFLike, as_brdf, set_options
from ._call import ProgressLike, Watch, address, array_at, call, choice, encode, own_handle, progress_callback, triples, words
from ._score import Parts, parts_of

OPTIONS = ("width", "height", "n_points", "n_frames", "turn_rad", "elevation_rad", "n_lights", "light_width", "shadows",
           "interreflection", "exposure_cdm2", "peak_cdm2", "min_valid", "seed")


@dataclass(frozen=True)
class Label:
    """How the rendered pictures of two BRDFs differ. `float(label)` is its JOD.

    Attributes:
        ref: name of the reference
        test: name of the test
        jod: JOD of the Delta-E ITP: 10 is no visible difference
        delta_e: mean Delta-E ITP over the picture; 1 is just visible
        adapted: JOD of people who adapt to 85 % of the shift
        parts: what differs
        delta_e_error, jod_error: standard errors of `delta_e` and `jod`, by the choice of points and light directions
        valid: the fraction of the light at directions where both have a value; the others count in neither picture
    """

    ref: str
    test: str
    jod: float
    delta_e: float
    adapted: float
    parts: Parts
    delta_e_error: float
    jod_error: float
    valid: float = 1.0

    def __float__(self) -> float:
        return self.jod


class Scene:
    """A shape on a turntable under a light map. Without `light` and `shape` it is the standard set of four scenes that the built-in
    model "default" predicts. Immutable; any thread may use it.

    Args:
        light: "sun", "overcast", "studio", "interior", or a latitude-longitude map (RGBE in PNG, OpenEXR, Radiance HDR)
        shape: "sphere", "blob", or a mesh file (PLY, OBJ)
        kind: "standard", or "paper": the scene of Kavoosighafi et al. 2025, whose files `light` and `shape` must name
        progress: called with the stage, the work done and the total while the scene is made and rendered; True shows a line on standard
            error
        options: members of `nqm_scene_options` (include/nqm/render.h): `width`, `height` (0: points instead of a picture), `n_points`,
            `n_frames`, `turn_rad`, `elevation_rad`, `n_lights`, `light_width`, `shadows`, `interreflection`, `exposure_cdm2`,
            `peak_cdm2`, `min_valid`, `seed`
    """

    def __init__(self, light: Optional[str] = None, shape: Optional[str] = None, *, kind: str = "standard",
                 progress: ProgressLike = None, **options: Any) -> None:
        o = set_options(lib.nqm_scene_options_default(), options, OPTIONS)
        o.scene = choice("kind", kind, words(_abi.SceneKind))
        o.light, o.shape = (None if v is None else encode(v) for v in (light, shape))
        self._watch = Watch()
        self._progress = o.progress = progress_callback(progress, (), self._watch)  # must live as long as the handle
        self._handle = c_void_p()
        call(lib.nqm_scene_create, byref(o), byref(self._handle), watches=(self._watch,))
        own_handle(self, self._handle, lib.nqm_scene_free)
        self._size = (o.height, o.width)
        self.peak_cdm2: float = o.peak_cdm2

    def __len__(self) -> int:
        """Number of surface points of all frames together."""
        return lib.nqm_scene_get_info(self._handle).n_points

    @property
    def weights(self) -> np.ndarray:
        """(n_points) the fraction of the picture that each point represents; they sum to 1."""
        i = lib.nqm_scene_get_info(self._handle)
        return array_at(i.weights, (i.n_points,)) if i.weights else np.full(i.n_points, 1 / i.n_points)

    @property
    def pixels(self) -> Optional[np.ndarray]:
        """(n_points) the pixel of each point, (frame * height + y) * width + x; None without a width."""
        i = lib.nqm_scene_get_info(self._handle)
        return array_at(i.pixels, (i.n_points,), c_size_t) if i.pixels else None

    def points(self, brdf: BRDFLike) -> np.ndarray:
        """Light that each point reflects to the viewer: (n_points, 3), linear BT.709 in cd/m2, not clipped. Warns when the BRDF has no value
        at directions of some of the light, which is then missing."""
        brdf = as_brdf(brdf)
        rgb, valid = np.empty((len(self), 3)), c_double()
        call(lib.nqm_scene_render, self._handle, brdf._handle, 0, address(rgb), byref(valid), watches=(self._watch, *brdf._watches))
        if valid.value < 1:
            warnings.warn("%s has no value for directions of %.3g %% of the light, which is missing in the picture"
                          % (brdf.name, 100 * (1 - valid.value)), stacklevel=2)
        return rgb

    def _picture(self, brdf: BRDF) -> Tuple[_abi.ScenePicture, np.ndarray]:
        """The picture for `nqm_scene_label`, and its values, which it points to."""
        rgb, valid = np.empty((3, len(self), 3)), c_double()
        call(lib.nqm_scene_render, self._handle, brdf._handle, 1, address(rgb), byref(valid), watches=(self._watch, *brdf._watches))
        return _abi.ScenePicture(brdf._handle, address(rgb), valid), rgb

    def _label(self, pair: Tuple[BRDF, BRDF], pictures: Tuple[Any, Any], delta_e: Optional[np.ndarray] = None) -> Tuple[_abi.Label, float]:
        label, valid = _abi.Label(), c_double()
        call(lib.nqm_scene_label, self._handle, byref(pictures[0][0]), byref(pictures[1][0]), byref(label),
             None if delta_e is None else address(delta_e), byref(valid), watches=(self._watch, *pair[0]._watches, *pair[1]._watches))
        return label, valid.value

    def image(self, values: np.ndarray, background: float = 0.0) -> np.ndarray:
        """Values of the points, (n_points) or (n_points, 3), as pictures (n_frames, height, width) or (n_frames, height, width, 3). The
        standard set has its four scenes one after the other. Needs a scene with a width."""
        pixels = self.pixels
        if pixels is None:
            raise ValueError("a scene without width and height has points but no pictures")
        values = np.asarray(values)
        height, width = self._size
        n_frames = int(pixels.max()) // (height * width) + 1 if len(pixels) else 0
        image = np.full((n_frames * height * width, *values.shape[1:]), background, dtype=np.float64)
        image[pixels] = values
        return image.reshape(n_frames, height, width, *values.shape[1:])

    def render(self, brdf: BRDFLike, background: float = 0.0) -> np.ndarray:
        """Pictures of a BRDF: (n_frames, height, width, 3), linear BT.709 in cd/m2; `background` where the shape is not."""
        return self.image(self.points(brdf), background)

    def delta_e_map(self, ref: BRDFLike, test: BRDFLike) -> np.ndarray:
        """Delta-E ITP of each point, (n_points)."""
        pair = as_brdf(ref), as_brdf(test)
        delta_e = np.empty(len(self))
        self._label(pair, (self._picture(pair[0]), self._picture(pair[1])), delta_e)
        return delta_e

    def label(self, ref: BRDFLike, tests: Any) -> Any:
        """Render and compare; see `label`."""
        brdf = as_brdf(ref)
        seen = self._picture(brdf)
        several = isinstance(tests, (list, tuple))
        labels = []
        for test in map(as_brdf, tests if several else [tests]):
            label, valid = self._label((brdf, test), (seen, self._picture(test)))
            info = lib.nqm_label_get_info(byref(label))
            jod = lib.nqm_curve_jod(byref(info.curve), label.delta_e)
            labels.append(Label(brdf.name, test.name, jod, label.delta_e, info.adapted_jod, parts_of(label), label.error, info.jod_error,
                                valid))
        return labels if several else labels[0]


@functools.lru_cache(maxsize=1)
def standard_scene() -> Scene:
    """The standard set of scenes, made once."""
    return Scene()


class Rays:
    """A random picture of few points of a scene, as the rays whose BRDF values make it: fresh directions for one step of a training
    or for a check. Its mean over the seeds is the scene's picture.

    Args:
        n: at most so many rays; the few without light are left out
        seed: of the points and directions; a new one for every step
        scene: the scene; default: the standard set, which is made at the first call (a second)

    Attributes:
        wi: (n, 3) unit vectors to the light, normal (0, 0, 1)
        wo: (n, 3) unit vectors to the viewer
        weight: (n, 3) light in cd/m2 that a BRDF of 1/sr reflects
        point: (n) of the picture, ascending
    """

    def __init__(self, n: int = 4096, seed: int = 1, *, scene: Optional[Scene] = None) -> None:
        self._rays = rays = _abi.Rays()
        call(lib.nqm_rays_draw, (standard_scene() if scene is None else scene)._handle, n, seed, byref(rays))
        own_handle(self, rays, lib.nqm_rays_clear)
        self.wi, self.wo, self.weight = (array_at(a, (rays.n, 3)) for a in (rays.wi, rays.wo, rays.weight))
        self.point = array_at(rays.point, (rays.n,), c_size_t)

    def __len__(self) -> int:
        """Number of rays."""
        return len(self.point)

    def eval(self, brdf: Any) -> np.ndarray:
        """f_r in 1/sr of a BRDF at the rays, (n, 3)."""
        return as_brdf(brdf).eval(self.wi, self.wo)

    def delta_e_grad(self, ref: Any, test: Any) -> Tuple[float, np.ndarray]:
        """Delta-E ITP of the two pictures, and its gradient by the values of the test.

        Args:
            ref: f_r in 1/sr of the reference at the rays, (n, 3)
            test: the same of the test
        """
        ref, test = triples("ref", ref), triples("test", test)
        if ref.shape != self.wi.shape or test.shape != self.wi.shape:
            raise ValueError("ref and test have the shape %s of the rays; not %s and %s" % (self.wi.shape, ref.shape, test.shape))
        label, gradient = _abi.Label(), np.empty_like(test)
        call(lib.nqm_rays_compare, byref(self._rays), address(ref), address(test), byref(label), address(gradient))
        return label.delta_e, gradient


@overload
def label(ref: BRDFLike, tests: Union[List[BRDFLike], Tuple[BRDFLike, ...]], *, scene: Optional[Scene] = ...,
          **options: Any) -> List[Label]: ...
@overload
def label(ref: BRDFLike, tests: BRDFLike, *, scene: Optional[Scene] = ..., **options: Any) -> Label: ...
def label(ref: BRDFLike, tests: Any, *, scene: Optional[Scene] = None, **options: Any) -> Any:
    """Label by rendering: Delta-E ITP and JOD between pictures of a reference and one test or a list of tests. This is what `score`
    predicts.

    Args:
        ref: the reference
        tests: one test, or a list or tuple of them
        scene: the scene; default: one made of `options`, and the standard set without them
        options: as for `Scene`
    """
    return (scene if scene is not None else Scene(**options)).label(ref, tests)


def render(brdf: BRDFLike, *, light: str = "sun", shape: str = "sphere", width: int = 256, height: Optional[int] = None,
           background: float = 0.0, **options: Any) -> np.ndarray:
    """A picture of a BRDF.

    Args:
        brdf: what is on the shape
        light: as for `Scene`
        shape: as for `Scene`
        width: pixels
        height: pixels; default: `width`
        background: value of pixels that do not show the shape
        options: as for `Scene`

    Returns:
        (height, width, 3) float64, linear BT.709 in cd/m2, first row at the top; with `n_frames` above 1 (n_frames, height, width, 3)
    """
    scene = Scene(light, shape, width=width, height=height or width, **options)
    images = scene.render(brdf, background)
    return images[0] if len(images) == 1 else images


def srgb(rgb_cdm2: Any, white_cdm2: float = 400.0) -> np.ndarray:
    """Linear BT.709 in cd/m2 as sRGB bytes (IEC 61966-2-1): (..., 3) uint8. `white_cdm2` and above is 255."""
    x = np.clip(np.asarray(rgb_cdm2, dtype=np.float64) / white_cdm2, 0, 1)
    return np.rint(255 * np.where(x <= .0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - .055)).astype(np.uint8)
