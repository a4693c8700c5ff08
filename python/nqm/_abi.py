# SPDX-License-Identifier: MIT
"""The C library: where it is found, and its structs and functions for ctypes, as in include/nqm/*.h. tests/python/test_abi.py
compares the structs and constants with the headers."""
from __future__ import annotations

import ctypes
import ctypes.util
import enum
import os
import shutil
import sys
from ctypes import POINTER, Structure, c_char, c_char_p, c_double, c_int, c_int64, c_size_t, c_uint64, c_void_p
from pathlib import Path
from typing import Iterator

from ._version import VERSION

NAMES = ("libnqm-full.so.0", "libnqm-full.so")


class Status(enum.IntEnum):
    """Outcome of a call of the library (`nqm_status`)."""

    OK = 0
    ARG = -1
    IO = -2
    FORMAT = -3
    INCOMPATIBLE = -4
    MODEL = -5
    NOMEM = -6
    LIMIT = -7
    NUMERIC = -8
    CANCELLED = -9


N_METRICS = 9
REMARKS_TEXT = 9000
VERDICT_TEXT = 64
INVALID = ("drop", "zero", "nearest", "error")
QUANTITIES = ("jod", "delta_e")
SCENES = ("standard", "paper")
TABLES = ("merl", "merl_360")
SPLITS = ("train", "validation", "test", "all")

Progress = ctypes.CFUNCTYPE(c_int, c_void_p, c_char_p, c_double, c_double)
Eval = ctypes.CFUNCTYPE(None, c_void_p, c_size_t, POINTER(c_double), POINTER(c_double), POINTER(c_double))
Free = ctypes.CFUNCTYPE(None, c_void_p)


class CError(Structure):
    _c_name_ = "nqm_error"
    _fields_ = [("status", c_int), ("byte_offset", c_int64), ("message", c_char * 512)]


class BrdfCallbacks(Structure):
    _c_name_ = "nqm_brdf_callbacks"
    _fields_ = [("eval", Eval), ("free", Free), ("user", c_void_p), ("name", c_char_p), ("reciprocal", c_int),
                ("serialize", c_int)]


class BrdfInfo(Structure):
    _c_name_ = "nqm_brdf_info"
    _fields_ = [("format", c_char_p), ("name", c_char_p), ("spec", c_char_p), ("source_doi", c_char_p),
                ("layout", c_char_p), ("n_values", c_size_t), ("n_bytes", c_size_t), ("remark", c_char_p), ("reciprocal", c_int),
                ("isotropic", c_int)]


class BrdfCheckReport(Structure):
    _c_name_ = "nqm_brdf_check_report"
    _fields_ = [("n_pairs", c_size_t), ("n_clamped", c_size_t), ("n_invalid", c_size_t),
                ("reciprocity_median", c_double), ("reciprocity_p95", c_double), ("anisotropy", c_double), ("albedo_max", c_double * 3),
                ("albedo_max_theta_rad", c_double)]


class BrdfDifference(Structure):
    _c_name_ = "nqm_brdf_difference"
    _fields_ = [("is_equal", c_int), ("n_pairs", c_size_t), ("n_different", c_size_t), ("n_missing", c_size_t),
                ("largest", c_double), ("wi", c_double * 3), ("wo", c_double * 3), ("channel", c_int), ("ref", c_double),
                ("test", c_double)]


class DirectionsOptions(Structure):
    _c_name_ = "nqm_directions_options"
    _fields_ = [("n", c_size_t), ("seed", c_uint64), ("max_polar_rad", c_double), ("theta_h_power", c_double),
                ("grid", c_int), ("oversampling", c_double), ("progress", Progress), ("progress_user", c_void_p)]


class SampleReport(Structure):
    _c_name_ = "nqm_sample_report"
    _fields_ = [("n", c_size_t), ("n_clamped", c_size_t), ("n_invalid", c_size_t)]


class ModelInfo(Structure):
    _c_name_ = "nqm_model_info"
    _fields_ = [("id", c_char_p), ("recipe", c_char_p), ("sha256", c_char_p), ("card", c_char_p), ("licence", c_char_p),
                ("manifest_sha256", c_char_p), ("n_parameters", c_size_t), ("n_layers", c_size_t),
                ("layer_sizes", POINTER(c_size_t)), ("jod_min", c_double), ("jod_max", c_double), ("directions", c_void_p),
                ("calibration", c_char_p)]


class MetricInfo(Structure):
    _c_name_ = "nqm_metric_info"
    _fields_ = [("name", c_char_p), ("description", c_char_p), ("family", c_char_p), ("is_baseline", c_int)]


class CLabel(Structure):
    _c_name_ = "nqm_label"
    _fields_ = [("delta_e", c_double), ("shift", c_double * 3), ("contrast", c_double), ("structure", c_double),
                ("error", c_double)]


class Curve(Structure):
    _c_name_ = "nqm_curve"
    _fields_ = [("b1", c_double), ("b2", c_double), ("b3", c_double)]


class RegressReport(Structure):
    _c_name_ = "nqm_regress_report"
    _fields_ = [("curve", Curve), ("rmse", c_double), ("spearman", c_double), ("n", c_size_t)]


class ScoreOptions(Structure):
    _c_name_ = "nqm_score_options"
    _fields_ = [("invalid", c_int), ("min_valid_fraction", c_double), ("metrics", c_int), ("cache_bytes", c_size_t)]


class ScoreResult(Structure):
    _c_name_ = "nqm_score_result"
    _fields_ = [("status", c_int), ("jod", c_double), ("delta_e", c_double), ("jod_low", c_double),
                ("jod_high", c_double), ("novelty", c_double), ("parts", CLabel), ("similarity", c_double * 3),
                ("anisotropy", c_double),
                ("identical", c_int), ("metrics", c_double * N_METRICS), ("n_valid", c_size_t),
                ("n_clamped", c_size_t * 2), ("n_invalid", c_size_t * 2), ("n_unusual", c_size_t * 2),
                ("remark", (c_char * 256) * 2), ("distance_deg", c_double * 2), ("suspect_scale", c_double), ("suspect_cosine", c_double)]


class NamedPair(Structure):
    _c_name_ = "nqm_named_pair"
    _fields_ = [("ref", c_char_p), ("test", c_char_p)]


class SamplePair(Structure):
    _c_name_ = "nqm_sample_pair"
    _fields_ = [("ref", c_void_p), ("test", c_void_p), ("used", c_void_p)]


class FitBound(Structure):
    _c_name_ = "nqm_fit_bound"
    _fields_ = [("key", c_char_p), ("low", c_double), ("high", c_double)]


class FitOptions(Structure):
    _c_name_ = "nqm_fit_options"
    _fields_ = [("loss", c_int), ("terms", c_void_p), ("n_terms", c_size_t), ("n_directions", c_size_t),
                ("max_polar_rad", c_double), ("highlight_fraction", c_double), ("n_starts", c_size_t),
                ("bounds", POINTER(FitBound)), ("n_bounds", c_size_t), ("seed", c_uint64), ("start", c_char_p),
                ("simplify", c_double), ("progress", Progress),
                ("progress_user", c_void_p)]


class FitReport(Structure):
    _c_name_ = "nqm_fit_report"
    _fields_ = [("spec", c_char * 2048), ("loss", c_double), ("n_directions", c_size_t), ("best_start", c_size_t),
                ("n_numbers", c_size_t)]


class MatchLoss(Structure):
    _c_name_ = "nqm_match_loss"
    _fields_ = [("text", c_char_p), ("metric", c_void_p), ("transport", c_void_p), ("scene", c_void_p)]


class MatchReport(Structure):
    _c_name_ = "nqm_match_report"
    _fields_ = [("fit", FitReport), ("selected", c_char * 128), ("difference", c_double)]


class SceneOptions(Structure):
    _c_name_ = "nqm_scene_options"
    _fields_ = [("scene", c_int), ("light", c_char_p), ("shape", c_char_p), ("width", c_size_t), ("height", c_size_t),
                ("n_points", c_size_t), ("n_frames", c_size_t), ("turn_rad", c_double), ("elevation_rad", c_double),
                ("n_lights", c_size_t), ("light_width", c_size_t), ("shadows", c_int), ("interreflection", c_int),
                ("exposure_cdm2", c_double), ("peak_cdm2", c_double), ("min_valid", c_double), ("seed", c_uint64), ("exact", c_int),
                ("progress", Progress), ("progress_user", c_void_p)]


class ScenePicture(Structure):
    _c_name_ = "nqm_scene_picture"
    _fields_ = [("brdf", c_void_p), ("rgb_cdm2", c_void_p), ("valid", c_double)]


class CRays(Structure):
    _c_name_ = "nqm_rays"
    _fields_ = [("n", c_size_t), ("n_points", c_size_t), ("wi", POINTER(c_double)), ("wo", POINTER(c_double)),
                ("weight", POINTER(c_double)), ("point", POINTER(c_size_t)), ("points", POINTER(c_double))]


class DatasetInfo(Structure):
    _c_name_ = "nqm_dataset_info"
    _fields_ = [("n_directions", c_size_t), ("n_refs", c_size_t), ("n_groups", c_size_t), ("n_pairs", c_size_t),
                ("n_kinds", c_size_t), ("n_pairs_in", c_size_t * 3), ("sha256", c_char_p), ("manifest", c_char_p),
                ("directions", c_void_p)]


class DatasetPair(Structure):
    _c_name_ = "nqm_dataset_pair"
    _fields_ = [("ref", c_char_p), ("group", c_char_p), ("test", c_char_p), ("kind", c_char_p), ("family", c_char_p),
                ("material_class", c_char_p), ("source", c_char_p), ("split", c_int), ("delta_e", c_double), ("jod", c_double)]


class MaterialInfo(Structure):
    _c_name_ = "nqm_material_info"
    _fields_ = [("name", c_char_p), ("surface", c_char_p), ("spec", c_char_p), ("refusal", c_char_p),
                ("n_maps", c_size_t), ("remark", c_char_p), ("unused", c_char_p), ("byte_offset", c_int64), ("ignorable", c_char_p),
                ("reflection", c_char_p)]


class TextureInfo(Structure):
    _c_name_ = "nqm_texture_info"
    _fields_ = [("name", c_char_p), ("model", c_char_p), ("width", c_size_t), ("height", c_size_t), ("n_images", c_size_t),
                ("n_bytes", c_size_t), ("varying", c_char_p), ("remark", c_char_p)]


class TextureMap(Structure):
    _c_name_ = "nqm_texture_map"
    _fields_ = [("key", c_char_p), ("height", c_size_t), ("width", c_size_t), ("channels", c_size_t), ("values", c_void_p)]


class TextureOptions(Structure):
    _c_name_ = "nqm_texture_options"
    _fields_ = [("exact", c_int), ("n_texels", c_size_t), ("texels_per_pixel", c_size_t), ("blame", c_int), ("far", c_int),
                ("seed", c_uint64), ("progress", Progress), ("progress_user", c_void_p)]


class TextureBlame(Structure):
    _c_name_ = "nqm_texture_blame"
    _fields_ = [("key", c_char * 48), ("jod", c_double), ("mistake", c_char * 80)]


class TextureResult(Structure):
    _c_name_ = "nqm_texture_result"
    _fields_ = [("jod", c_double), ("jod_low", c_double), ("jod_high", c_double), ("delta_e", c_double), ("error", c_double),
                ("parts", CLabel), ("median", c_double), ("worst", c_double), ("below", c_double * 2), ("far_jod", c_double * 3),
                ("far_delta_e", c_double), ("width", c_size_t), ("height", c_size_t), ("n_different", c_size_t),
                ("n_scored", c_size_t), ("texels_per_pixel", c_size_t), ("n_blame", c_size_t), ("blame", TextureBlame * 32)]


class Pairs(Structure):
    _c_name_ = "nqm_pairs"
    _fields_ = [("n", c_size_t), ("pairs", POINTER(NamedPair)), ("names", c_void_p), ("rows", c_void_p), ("n_columns", c_size_t),
                ("columns", c_void_p), ("sha256", c_char_p), ("left_out", c_void_p), ("state", c_void_p)]


Report = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p)


class LibraryMember(Structure):
    _c_name_ = "nqm_library_member"
    _fields_ = [("argument", c_char_p), ("key", c_char_p), ("is_textured", c_int)]


class LibraryOptions(Structure):
    _c_name_ = "nqm_library_options"
    _fields_ = [("ignore", c_char_p), ("index", c_char_p), ("score", POINTER(ScoreOptions)), ("progress", Progress), ("report", Report),
                ("user", c_void_p)]


class Library(Structure):
    _c_name_ = "nqm_library"
    _fields_ = [("n", c_size_t), ("members", POINTER(LibraryMember)), ("n_failed", c_size_t), ("path", c_char_p), ("state", c_void_p)]


class LibraryValue(Structure):
    _c_name_ = "nqm_library_value"
    _fields_ = [("text", c_char_p), ("n", c_size_t), ("v", c_double * 3)]


class LibraryChange(Structure):
    _c_name_ = "nqm_library_change"
    _fields_ = [("property", c_char * 48), ("before", LibraryValue), ("after", LibraryValue)]


class LibraryPair(Structure):
    _c_name_ = "nqm_library_pair"
    _fields_ = [("ref", c_size_t), ("test", c_size_t), ("names", NamedPair), ("result", ScoreResult), ("error", CError),
                ("texture", POINTER(TextureResult)), ("is_refused_alike", c_int), ("n_changes", c_size_t),
                ("changes", POINTER(LibraryChange))]


class LibraryQuery(Structure):
    _c_name_ = "nqm_library_query"
    _fields_ = [("to", c_char_p), ("n", c_size_t), ("is_apart", c_int), ("jod", c_double)]


STRUCTS = [CError, BrdfCallbacks, BrdfInfo, BrdfCheckReport, BrdfDifference, DirectionsOptions, SampleReport, ModelInfo, MetricInfo, CLabel,
           Curve, RegressReport, ScoreOptions, ScoreResult, NamedPair, SamplePair, FitBound, FitOptions, FitReport, MatchLoss, MatchReport,
           SceneOptions, CRays, DatasetInfo, DatasetPair, MaterialInfo,
           TextureInfo, TextureMap, TextureOptions, TextureBlame, TextureResult,
           Pairs, LibraryMember, LibraryOptions, Library, LibraryValue, LibraryChange, LibraryPair, LibraryQuery]

# name: (result, arguments); a trailing nqm_error * is part of the arguments.
_error = POINTER(CError)
_handle = POINTER(c_void_p)
FUNCTIONS = {
    "nqm_status_text": (c_char_p, [c_int]),
    "nqm_version": (c_char_p, []),
    "nqm_build_info": (c_char_p, []),
    "nqm_files_within": (c_int, [c_char_p, _error]),
    "nqm_brdf_open": (c_int, [c_char_p, _handle, _error]),
    "nqm_brdf_create": (c_int, [POINTER(BrdfCallbacks), _handle, _error]),
    "nqm_brdf_create_table": (c_int, [c_size_t, c_size_t, c_size_t, c_void_p, c_char_p, _handle, _error]),
    "nqm_brdf_free": (None, [c_void_p]),
    "nqm_brdf_get_info": (BrdfInfo, [c_void_p]),
    "nqm_brdf_eval": (None, [c_void_p, c_size_t, c_void_p, c_void_p, c_void_p, c_void_p]),
    "nqm_brdf_eval_half_diff": (None, [c_void_p, c_size_t, c_void_p, c_void_p, c_void_p]),
    "nqm_brdf_jacobian": (c_int, [c_void_p, c_size_t, c_void_p, c_void_p, c_void_p, c_void_p, _error]),
    "nqm_half_diff_to_directions": (None, [c_void_p, c_void_p, c_void_p]),
    "nqm_directions_to_half_diff": (None, [c_void_p, c_void_p, c_void_p]),
    "nqm_brdf_write": (c_int, [c_void_p, c_int, c_char_p, Progress, c_void_p, _error]),
    "nqm_brdf_save": (c_int, [c_void_p, c_char_p, _error]),
    "nqm_brdf_preset_count": (c_size_t, []),
    "nqm_brdf_preset_name": (c_char_p, [c_size_t]),
    "nqm_brdf_check": (c_int, [c_void_p, c_uint64, POINTER(BrdfCheckReport), _error]),
    "nqm_brdf_compare": (c_int, [c_void_p, c_void_p, c_double, c_uint64, POINTER(BrdfDifference), _error]),
    "nqm_brdf_albedo": (None, [c_void_p, c_double, c_uint64, c_void_p]),
    "nqm_directions_options_default": (DirectionsOptions, []),
    "nqm_directions_create": (c_int, [POINTER(DirectionsOptions), c_size_t, _handle, _handle, _error]),
    "nqm_directions_from_degrees": (c_int, [c_size_t, c_void_p, _handle, _error]),
    "nqm_directions_load_csv": (c_int, [c_char_p, _handle, _error]),
    "nqm_directions_save_csv": (c_int, [c_void_p, c_char_p, _error]),
    "nqm_directions_free": (None, [c_void_p]),
    "nqm_directions_count": (c_size_t, [c_void_p]),
    "nqm_directions_degrees": (POINTER(c_double), [c_void_p]),
    "nqm_directions_wi": (POINTER(c_double), [c_void_p]),
    "nqm_directions_wo": (POINTER(c_double), [c_void_p]),
    "nqm_directions_id": (c_char_p, [c_void_p]),
    "nqm_sample": (c_int, [c_void_p, c_void_p, c_int, c_void_p, c_void_p, POINTER(SampleReport), _error]),
    "nqm_model_load": (c_int, [c_char_p, _handle, _error]),
    "nqm_model_save": (c_int, [c_void_p, c_char_p, _error]),
    "nqm_model_builtin": (c_int, [c_char_p, _handle, _error]),
    "nqm_model_builtin_count": (c_size_t, []),
    "nqm_model_builtin_name": (c_char_p, [c_size_t]),
    "nqm_model_free": (None, [c_void_p]),
    "nqm_model_get_info": (ModelInfo, [c_void_p]),
    "nqm_metric_get_info": (MetricInfo, [c_int]),
    "nqm_score_options_default": (ScoreOptions, []),
    "nqm_scorer_create": (c_int, [c_void_p, POINTER(ScoreOptions), _handle, _error]),
    "nqm_scorer_free": (None, [c_void_p]),
    "nqm_scorer_run": (c_int, [c_void_p, c_void_p, c_size_t, _handle, POINTER(ScoreResult), _error]),
    "nqm_scorer_run_named": (c_int, [c_void_p, c_size_t, POINTER(NamedPair), POINTER(ScoreResult), _error, _error]),
    "nqm_scorer_run_samples": (c_int, [c_void_p, c_size_t, POINTER(SamplePair), POINTER(ScoreResult), _error]),
    "nqm_score_grad": (c_int, [c_void_p, c_int, c_size_t, POINTER(SamplePair), c_void_p, c_void_p, _error]),
    "nqm_jod_preference": (c_double, [c_double, c_double]),
    "nqm_curve_default": (Curve, []),
    "nqm_curve_jod": (c_double, [POINTER(Curve), c_double]),
    "nqm_regress": (c_int, [c_size_t, c_void_p, c_void_p, POINTER(RegressReport), _error]),
    "nqm_fit_model": (c_char_p, [c_size_t]),
    "nqm_fit_shading": (c_char_p, [c_size_t]),
    "nqm_fit_options_default": (FitOptions, []),
    "nqm_match": (c_int, [c_void_p, c_char_p, POINTER(MatchLoss), POINTER(FitOptions), POINTER(MatchReport), _handle, _error]),
    "nqm_scene_options_default": (SceneOptions, []),
    "nqm_scene_create": (c_int, [POINTER(SceneOptions), _handle, _error]),
    "nqm_scene_free": (None, [c_void_p]),
    "nqm_scene_count": (c_size_t, [c_void_p]),
    "nqm_scene_render": (c_int, [c_void_p, c_void_p, c_void_p, POINTER(c_double), _error]),
    "nqm_scene_weights": (POINTER(c_double), [c_void_p]),
    "nqm_scene_pixels": (POINTER(c_size_t), [c_void_p]),
    "nqm_scene_render_halves": (c_int, [c_void_p, c_void_p, c_void_p, c_void_p, POINTER(c_double), _error]),
    "nqm_scene_label": (c_int, [c_void_p, POINTER(ScenePicture), POINTER(ScenePicture), POINTER(CLabel), c_void_p, POINTER(c_double), _error]),
    "nqm_label_jod_error": (c_double, [POINTER(CLabel)]),
    "nqm_rays_draw": (c_int, [c_void_p, c_size_t, c_uint64, POINTER(CRays), _error]),
    "nqm_rays_clear": (None, [POINTER(CRays)]),
    "nqm_rays_compare": (c_int, [POINTER(CRays), c_void_p, c_void_p, POINTER(CLabel), c_void_p, _error]),
    "nqm_scene_compare": (CLabel, [c_void_p, c_void_p, c_void_p]),
    "nqm_dataset_load": (c_int, [c_char_p, _handle, _error]),
    "nqm_dataset_load_authors": (c_int, [c_char_p, c_char_p, c_int, _handle, _error]),
    "nqm_dataset_free": (None, [c_void_p]),
    "nqm_dataset_get_info": (DatasetInfo, [c_void_p]),
    "nqm_dataset_get_pair": (DatasetPair, [c_void_p, c_size_t]),
    "nqm_materials_open": (c_int, [c_char_p, _handle, _error]),
    "nqm_materials_count": (c_size_t, [c_void_p]),
    "nqm_materials_get": (MaterialInfo, [c_void_p, c_size_t]),
    "nqm_materials_free": (None, [c_void_p]),
    "nqm_texture_open": (c_int, [c_char_p, Progress, c_void_p, _handle, _error]),
    "nqm_texture_create": (c_int, [c_char_p, c_size_t, POINTER(TextureMap), _handle, _error]),
    "nqm_texture_free": (None, [c_void_p]),
    "nqm_texture_get_info": (TextureInfo, [c_void_p, c_void_p]),
    "nqm_texture_options_default": (TextureOptions, []),
    "nqm_texture_score": (c_int, [c_void_p, c_void_p, c_void_p, POINTER(TextureOptions), POINTER(TextureResult), c_void_p, _error]),
    "nqm_pairs_read": (c_int, [c_char_p, c_void_p, _error]),
    "nqm_pairs_expand": (c_int, [POINTER(Pairs), c_char_p, c_void_p, _error]),
    "nqm_pairs_free": (None, [POINTER(Pairs)]),
    "nqm_pairs_remarks": (c_char_p, [c_void_p, c_int, POINTER(NamedPair), c_char_p, c_char_p, POINTER(ScoreResult), c_char_p]),
    "nqm_verdict": (c_char_p, [POINTER(ScoreResult), c_char_p]),
    "nqm_library_open": (c_int, [c_size_t, c_void_p, c_void_p, POINTER(LibraryOptions), c_void_p, _error]),
    "nqm_library_free": (None, [POINTER(Library)]),
    "nqm_library_near": (c_int, [POINTER(Library), POINTER(LibraryQuery), c_void_p, c_void_p, _error]),
    "nqm_library_diff": (c_int, [POINTER(Library), POINTER(Library), c_void_p, c_void_p, _error]),
    "nqm_material_write": (c_int, [c_char_p, c_char_p, c_char_p, _error]),
    "nqm_label_adapted_jod": (c_double, [POINTER(CLabel)]),
    "nqm_label_describe": (c_char_p, [POINTER(CLabel), c_char_p]),
}


def _candidates() -> Iterator[str]:
    """Paths and names of the library, best first."""
    package = Path(__file__).resolve().parent
    folders = [package / "lib", package, package.parent, package.parent.parent / "build"]
    folders += [p / lib for p in package.parents for lib in ("lib", "lib64") if "lib" in package.parts]
    folders.append(Path(sys.prefix) / "lib")
    tool = shutil.which("nqm")
    if tool:
        folders += [Path(tool).resolve().parent, Path(tool).resolve().parent.parent / "lib"]
    for folder in folders:
        for name in NAMES:
            for path in [folder / name, *sorted(folder.glob("*-linux-gnu*/" + name))]:
                if path.is_file():
                    yield str(path)
    yield NAMES[0]  # the loader's own search: LD_LIBRARY_PATH, ld.so.conf
    found = ctypes.util.find_library("nqm-full")
    if found:
        yield found
    for path in (Path.home() / ".local/lib", Path("/usr/local/lib")):
        if (path / NAMES[0]).is_file():
            yield str(path / NAMES[0])


def _declare(library: ctypes.CDLL, path: str) -> ctypes.CDLL:
    try:
        library.nqm_version.restype = c_char_p
        running = library.nqm_version().decode()
        if running.split(".")[:2] != VERSION.split(".")[:2]:
            raise ImportError("%s is version %s of nqm, but this Python package needs %s: install both from the same release" %
                              (path, running, VERSION))
        for name, (result, arguments) in FUNCTIONS.items():
            function = getattr(library, name)
            function.restype, function.argtypes = result, arguments
    except AttributeError as error:
        raise ImportError("%s is not libnqm-full of version %s: %s" % (path, VERSION, error)) from None
    return library


def _load() -> ctypes.CDLL:
    given = os.environ.get("NQM_LIBRARY")
    if given:
        path = Path(given)
        if path.is_dir():
            path = next((path / name for name in NAMES if (path / name).is_file()), path / NAMES[0])
        try:
            return _declare(ctypes.CDLL(str(path)), str(path))
        except OSError as error:
            raise ImportError("the library that NQM_LIBRARY names cannot be loaded: %s" % error) from None
    reasons = []
    for candidate in _candidates():
        try:
            return _declare(ctypes.CDLL(candidate), candidate)
        except OSError as error:
            reasons.append(str(error))
    raise ImportError(
        "the C library libnqm-full is not found (%s). Install it (Debian: apt install ./libnqm0_*.deb; source: cmake "
        "--install build), or set the environment variable NQM_LIBRARY to the file libnqm-full.so or its folder" %
        "; ".join(dict.fromkeys(reasons)))


lib = _load()
