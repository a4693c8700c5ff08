# SPDX-License-Identifier: MIT
"""Made by python/headers.py from include/nqm/*.h (./dev pages): change those. A pointer to a struct has its type; pointers to objects and
arrays are addresses, which callbacks get as pointers."""
import enum
from ctypes import (CFUNCTYPE, POINTER, Structure, c_char, c_char_p, c_double, c_float, c_int, c_int64, c_size_t, c_uint8, c_uint64,
                    c_void_p)


class Status(enum.IntEnum):
    """`nqm_status`"""

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


class Error(Structure):
    _fields_ = [
        ("status", c_int),
        ("byte_offset", c_int64),
        ("message", c_char * 512),
    ]


Progress = CFUNCTYPE(c_int, c_void_p, c_char_p, c_double, c_double)


class Precision(enum.IntEnum):
    """`nqm_precision`"""

    F32 = 0
    BF16 = 1


class ValueFlag(enum.IntEnum):
    """`nqm_value_flag`"""

    OK = 0
    CLAMPED = 1
    INVALID = 2
    HORIZON = 3


class BrdfInfo(Structure):
    _fields_ = [
        ("format", c_char_p),
        ("name", c_char_p),
        ("spec", c_char_p),
        ("source_doi", c_char_p),
        ("layout", c_char_p),
        ("n_values", c_size_t),
        ("n_bytes", c_size_t),
        ("remark", c_char_p),
        ("reciprocal", c_int),
        ("isotropic", c_int),
    ]


BrdfEval = CFUNCTYPE(None, c_void_p, c_size_t, POINTER(c_double), POINTER(c_double), POINTER(c_double))


class BrdfCallbacks(Structure):
    _fields_ = [
        ("eval", BrdfEval),
        ("free", CFUNCTYPE(None, c_void_p)),
        ("user", c_void_p),
        ("name", c_char_p),
        ("reciprocal", c_int),
        ("serialize", c_int),
    ]


class FileFormat(enum.IntEnum):
    """`nqm_file_format`"""

    MERL = 0
    MERL_360 = 1
    NPY = 2
    SAFETENSORS = 3
    MATERIAL = 4


class BrdfCheckReport(Structure):
    _fields_ = [
        ("n_pairs", c_size_t),
        ("n_clamped", c_size_t),
        ("n_invalid", c_size_t),
        ("reciprocity_median", c_double),
        ("reciprocity_p95", c_double),
        ("anisotropy", c_double),
        ("albedo_max", c_double * 3),
        ("albedo_max_theta_rad", c_double),
    ]


class BrdfDifference(Structure):
    _fields_ = [
        ("is_equal", c_int),
        ("n_pairs", c_size_t),
        ("n_different", c_size_t),
        ("n_missing", c_size_t),
        ("largest", c_double),
        ("wi", c_double * 3),
        ("wo", c_double * 3),
        ("channel", c_int),
        ("ref", c_double),
        ("test", c_double),
    ]


class DirectionsOptions(Structure):
    _fields_ = [
        ("n", c_size_t),
        ("seed", c_uint64),
        ("max_polar_rad", c_double),
        ("theta_h_power", c_double),
        ("grid", c_int),
        ("oversampling", c_double),
        ("progress", Progress),
        ("progress_user", c_void_p),
    ]


class DirectionsInfo(Structure):
    _fields_ = [
        ("n", c_size_t),
        ("degrees", c_void_p),
        ("wi", c_void_p),
        ("wo", c_void_p),
    ]


class Layout(enum.IntEnum):
    """`nqm_layout`"""

    TEST = 0
    DIFF_ABSDIFF = 1


class InvalidPolicy(enum.IntEnum):
    """`nqm_invalid_policy`"""

    DROP = 0
    ZERO = 1
    NEAREST = 2
    ERROR = 3


class SampleReport(Structure):
    _fields_ = [
        ("n", c_size_t),
        ("n_clamped", c_size_t),
        ("n_invalid", c_size_t),
    ]


class Target(enum.IntEnum):
    """`nqm_target`"""

    JOD = 0
    LOG_DELTA_E = 1


SCALAR_ZONES = 5


class Scalar(enum.IntEnum):
    """`nqm_scalar`"""

    METRICS = 0
    RMS = 9
    MAX = 10
    TAIL = 11
    BULK = 12
    BIAS = 13
    SHAPE = 14
    ZONE_BIAS = 15
    ZONE_RMS = 20
    GRAZING_BIAS = 25
    GRAZING_RMS = 26
    WIDTH = 27
    CHROMA = 28
    CHROMA_RG = 29
    CHROMA_B = 30
    ENERGY = 31
    ENERGY_CHROMA = 32
    PEAK = 33
    SMOOTH = 34
    SMOOTH_CHROMA = 35
    REF_LEVEL = 36
    REF_ENERGY = 37
    REF_PEAK = 38
    REF_SPREAD = 39
    REF_COLOUR = 40
    ESTIMATE = 41


class ModelInfo(Structure):
    _fields_ = [
        ("id", c_char_p),
        ("recipe", c_char_p),
        ("sha256", c_char_p),
        ("card", c_char_p),
        ("licence", c_char_p),
        ("manifest_sha256", c_char_p),
        ("n_parameters", c_size_t),
        ("n_layers", c_size_t),
        ("layer_sizes", c_void_p),
        ("jod_min", c_double),
        ("jod_max", c_double),
        ("directions", c_void_p),
        ("calibration", c_char_p),
    ]


class Curve(Structure):
    _fields_ = [
        ("b1", c_double),
        ("b2", c_double),
        ("b3", c_double),
    ]


class RegressReport(Structure):
    _fields_ = [
        ("curve", Curve),
        ("rmse", c_double),
        ("spearman", c_double),
        ("n", c_size_t),
    ]


class Label(Structure):
    _fields_ = [
        ("delta_e", c_double),
        ("shift", c_double * 3),
        ("contrast", c_double),
        ("structure", c_double),
        ("error", c_double),
    ]


LABEL_TEXT = 160


class LabelInfo(Structure):
    _fields_ = [
        ("curve", Curve),
        ("jod_error", c_double),
        ("adapted_jod", c_double),
        ("words", c_char * 160),
    ]


class Metric(enum.IntEnum):
    """`nqm_metric`"""

    RMSE = 0
    MAE = 1
    RMS_CRWE = 2
    MA_CRWE = 3
    RMS_LOGE = 4
    MA_LOGE = 5
    RMS_LOGWE = 6
    MA_LOGWE = 7
    LOG_DIFF = 8


class MetricInfo(Structure):
    _fields_ = [
        ("name", c_char_p),
        ("description", c_char_p),
        ("family", c_char_p),
        ("is_baseline", c_int),
    ]


class ScoreOptions(Structure):
    _fields_ = [
        ("invalid", c_int),
        ("min_valid_fraction", c_double),
        ("metrics", c_int),
        ("cache_bytes", c_size_t),
    ]


REMARK_TEXT = 256


class ScoreResult(Structure):
    _fields_ = [
        ("status", c_int),
        ("jod", c_double),
        ("delta_e", c_double),
        ("jod_low", c_double),
        ("jod_high", c_double),
        ("novelty", c_double),
        ("parts", Label),
        ("similarity", c_double * 3),
        ("anisotropy", c_double),
        ("identical", c_int),
        ("metrics", c_double * 9),
        ("n_valid", c_size_t),
        ("n_clamped", c_size_t * 2),
        ("n_invalid", c_size_t * 2),
        ("n_unusual", c_size_t * 2),
        ("remark", (c_char * 256) * 2),
        ("distance_deg", c_double * 2),
        ("suspect_scale", c_double),
        ("suspect_cosine", c_double),
    ]


SCORE_BLOCK = 256


class NamedPair(Structure):
    _fields_ = [
        ("ref", c_char_p),
        ("test", c_char_p),
    ]


class SamplePair(Structure):
    _fields_ = [
        ("ref", c_void_p),
        ("test", c_void_p),
        ("used", c_void_p),
    ]


class ScoreQuantity(enum.IntEnum):
    """`nqm_score_quantity`"""

    JOD = 0
    DELTA_E = 1


class ConformInfo(Structure):
    _fields_ = [
        ("model", c_char_p),
        ("n_sets", c_size_t),
        ("n_directions", c_size_t),
        ("n_columns", c_size_t),
        ("columns", c_char_p),
        ("spec", c_char_p),
        ("values", c_void_p),
        ("light", c_void_p),
        ("viewer", c_void_p),
    ]


CONFORM_MISTAKES = 3
CONFORM_TEXT = 400


class ConformMistake(Structure):
    _fields_ = [
        ("text", c_char * 400),
        ("lowest_jod", c_double),
        ("remaining", c_double),
    ]


class ConformLargest(Structure):
    _fields_ = [
        ("set", c_size_t),
        ("direction", c_size_t),
        ("channel", c_size_t),
        ("value", c_double),
        ("right", c_double),
        ("angles_rad", c_double * 4),
    ]


class ConformReport(Structure):
    _fields_ = [
        ("n_passed", c_size_t),
        ("lowest_jod", c_double),
        ("difference", c_double),
        ("n_mistakes", c_size_t),
        ("mistakes", ConformMistake * 3),
        ("is_named", c_int),
        ("sets", c_char * 400),
        ("angles", c_char * 400),
        ("most", c_char * 400),
        ("largest", ConformLargest),
    ]


class Split(enum.IntEnum):
    """`nqm_split`"""

    TRAIN = 0
    VALIDATION = 1
    TEST = 2
    ALL = 3


class DatasetInfo(Structure):
    _fields_ = [
        ("n_directions", c_size_t),
        ("n_refs", c_size_t),
        ("n_groups", c_size_t),
        ("n_pairs", c_size_t),
        ("n_kinds", c_size_t),
        ("n_pairs_in", c_size_t * 3),
        ("sha256", c_char_p),
        ("manifest", c_char_p),
        ("directions", c_void_p),
    ]


class DatasetPair(Structure):
    _fields_ = [
        ("ref", c_char_p),
        ("group", c_char_p),
        ("test", c_char_p),
        ("kind", c_char_p),
        ("family", c_char_p),
        ("material_class", c_char_p),
        ("source", c_char_p),
        ("split", c_int),
        ("delta_e", c_double),
        ("jod", c_double),
    ]


class SceneKind(enum.IntEnum):
    """`nqm_scene_kind`"""

    STANDARD = 0
    PAPER = 1


class SceneOptions(Structure):
    _fields_ = [
        ("scene", c_int),
        ("light", c_char_p),
        ("shape", c_char_p),
        ("width", c_size_t),
        ("height", c_size_t),
        ("n_points", c_size_t),
        ("n_frames", c_size_t),
        ("turn_rad", c_double),
        ("elevation_rad", c_double),
        ("n_lights", c_size_t),
        ("light_width", c_size_t),
        ("shadows", c_int),
        ("interreflection", c_int),
        ("exposure_cdm2", c_double),
        ("peak_cdm2", c_double),
        ("min_valid", c_double),
        ("seed", c_uint64),
        ("exact", c_int),
        ("progress", Progress),
        ("progress_user", c_void_p),
    ]


class SceneInfo(Structure):
    _fields_ = [
        ("n_points", c_size_t),
        ("weights", c_void_p),
        ("pixels", c_void_p),
    ]


class Rays(Structure):
    _fields_ = [
        ("n", c_size_t),
        ("n_points", c_size_t),
        ("wi", c_void_p),
        ("wo", c_void_p),
        ("weight", c_void_p),
        ("point", c_void_p),
        ("points", c_void_p),
    ]


class ScenePicture(Structure):
    _fields_ = [
        ("brdf", c_void_p),
        ("rgb_cdm2", c_void_p),
        ("valid", c_double),
    ]


class CorpusPart(enum.IntEnum):
    """`nqm_corpus_part`"""

    TRAINING = 0
    TEST = 1


class CorpusPair(Structure):
    _fields_ = [
        ("reference", c_char_p),
        ("test", c_char_p),
        ("name", c_char_p),
        ("group", c_char_p),
        ("source", c_char_p),
        ("kind", c_char_p),
        ("family", c_char_p),
        ("other", c_char_p),
        ("split", c_int),
    ]


class CorpusOptions(Structure):
    _fields_ = [
        ("part", c_int),
        ("root", c_char_p),
        ("scene", SceneOptions),
        ("checkpoint", c_char_p),
        ("work_only", c_int),
        ("keep", c_char_p),
        ("anisotropic", c_int),
        ("progress", Progress),
        ("progress_user", c_void_p),
    ]


class FitLoss(enum.IntEnum):
    """`nqm_fit_loss`"""

    LOG = 0
    LOG_COS = 1
    CUBE_ROOT = 2
    LINEAR = 3
    RMSE = 4
    MAE = 5
    RMS_CRWE = 6
    MA_CRWE = 7
    RMS_LOGE = 8
    MA_LOGE = 9
    RMS_LOGWE = 10
    MA_LOGWE = 11
    LOG_DIFF = 12
    N_LOSSES = 13


class FitVisual(Structure):
    _fields_ = [
        ("n", c_size_t),
        ("wi", c_void_p),
        ("wo", c_void_p),
        ("eval", CFUNCTYPE(c_double, c_void_p, POINTER(c_double), POINTER(c_double))),
        ("user", c_void_p),
    ]


class FitTerm(Structure):
    _fields_ = [
        ("weight", c_double),
        ("loss", c_int),
        ("visual", POINTER(FitVisual)),
    ]


class FitBound(Structure):
    _fields_ = [
        ("key", c_char_p),
        ("low", c_double),
        ("high", c_double),
    ]


class FitOptions(Structure):
    _fields_ = [
        ("loss", c_int),
        ("terms", POINTER(FitTerm)),
        ("n_terms", c_size_t),
        ("n_directions", c_size_t),
        ("max_polar_rad", c_double),
        ("highlight_fraction", c_double),
        ("n_starts", c_size_t),
        ("bounds", POINTER(FitBound)),
        ("n_bounds", c_size_t),
        ("seed", c_uint64),
        ("start", c_char_p),
        ("simplify", c_double),
        ("progress", Progress),
        ("progress_user", c_void_p),
    ]


class FitReport(Structure):
    _fields_ = [
        ("spec", c_char * 2048),
        ("loss", c_double),
        ("n_directions", c_size_t),
        ("best_start", c_size_t),
        ("n_numbers", c_size_t),
    ]


FIT_N_ENCODINGS = 9
FIT_FIRST_SHADING = 22


class TextureInfo(Structure):
    _fields_ = [
        ("name", c_char_p),
        ("model", c_char_p),
        ("width", c_size_t),
        ("height", c_size_t),
        ("n_images", c_size_t),
        ("n_bytes", c_size_t),
        ("varying", c_char_p),
        ("remark", c_char_p),
    ]


class TextureMap(Structure):
    _fields_ = [
        ("key", c_char_p),
        ("height", c_size_t),
        ("width", c_size_t),
        ("channels", c_size_t),
        ("values", c_void_p),
    ]


class TextureOptions(Structure):
    _fields_ = [
        ("exact", c_int),
        ("n_texels", c_size_t),
        ("texels_per_pixel", c_size_t),
        ("blame", c_int),
        ("far", c_int),
        ("seed", c_uint64),
        ("progress", Progress),
        ("progress_user", c_void_p),
    ]


class TextureBlame(Structure):
    _fields_ = [
        ("key", c_char * 48),
        ("jod", c_double),
        ("mistake", c_char * 80),
    ]


TEXTURE_MAX_BLAME = 32


class TextureResult(Structure):
    _fields_ = [
        ("jod", c_double),
        ("jod_low", c_double),
        ("jod_high", c_double),
        ("delta_e", c_double),
        ("error", c_double),
        ("parts", Label),
        ("median", c_double),
        ("worst", c_double),
        ("below", c_double * 2),
        ("far_jod", c_double * 3),
        ("far_delta_e", c_double),
        ("width", c_size_t),
        ("height", c_size_t),
        ("n_different", c_size_t),
        ("n_scored", c_size_t),
        ("texels_per_pixel", c_size_t),
        ("n_blame", c_size_t),
        ("blame", TextureBlame * 32),
    ]


class LibraryMember(Structure):
    _fields_ = [
        ("argument", c_char_p),
        ("key", c_char_p),
        ("is_textured", c_int),
    ]


class LibraryOptions(Structure):
    _fields_ = [
        ("ignore", c_char_p),
        ("index", c_char_p),
        ("score", POINTER(ScoreOptions)),
        ("progress", Progress),
        ("report", CFUNCTYPE(None, c_void_p, c_int, c_char_p)),
        ("user", c_void_p),
    ]


class Library(Structure):
    _fields_ = [
        ("n", c_size_t),
        ("members", POINTER(LibraryMember)),
        ("n_failed", c_size_t),
        ("path", c_char_p),
        ("state", c_void_p),
    ]


class LibraryValue(Structure):
    _fields_ = [
        ("text", c_char_p),
        ("n", c_size_t),
        ("v", c_double * 3),
    ]


class LibraryChange(Structure):
    _fields_ = [
        ("property", c_char * 48),
        ("before", LibraryValue),
        ("after", LibraryValue),
    ]


class LibraryPair(Structure):
    _fields_ = [
        ("ref", c_size_t),
        ("test", c_size_t),
        ("names", NamedPair),
        ("result", ScoreResult),
        ("error", Error),
        ("texture", POINTER(TextureResult)),
        ("is_refused_alike", c_int),
        ("n_changes", c_size_t),
        ("changes", POINTER(LibraryChange)),
    ]


class LibraryQuery(Structure):
    _fields_ = [
        ("to", c_char_p),
        ("n", c_size_t),
        ("is_apart", c_int),
        ("jod", c_double),
    ]


class MatchLoss(Structure):
    _fields_ = [
        ("text", c_char_p),
        ("metric", c_void_p),
        ("transport", c_void_p),
        ("scene", c_void_p),
    ]


class MatchReport(Structure):
    _fields_ = [
        ("fit", FitReport),
        ("selected", c_char * 128),
        ("difference", c_double),
    ]


class MaterialInfo(Structure):
    _fields_ = [
        ("name", c_char_p),
        ("surface", c_char_p),
        ("spec", c_char_p),
        ("refusal", c_char_p),
        ("n_maps", c_size_t),
        ("remark", c_char_p),
        ("unused", c_char_p),
        ("byte_offset", c_int64),
        ("ignorable", c_char_p),
        ("reflection", c_char_p),
    ]


class Pairs(Structure):
    _fields_ = [
        ("n", c_size_t),
        ("pairs", POINTER(NamedPair)),
        ("names", c_void_p),
        ("rows", c_void_p),
        ("n_columns", c_size_t),
        ("columns", c_void_p),
        ("sha256", c_char_p),
        ("left_out", c_void_p),
        ("state", c_void_p),
    ]


REMARKS_TEXT = 9000


class ColumnGroup(enum.IntEnum):
    """`nqm_column_group`"""

    SCORE = 0
    PARTS = 1
    LABEL = 2
    SIMILARITY = 3
    METRIC = 4
    TEXTURE = 5


class ColumnKind(enum.IntEnum):
    """`nqm_column_kind`"""

    REAL = 0
    WHOLE = 1
    FLAG = 2
    TEXT = 3


class Column(Structure):
    _fields_ = [
        ("name", c_char_p),
        ("member", c_char_p),
        ("object", c_char_p),
        ("about", c_char_p),
        ("group", c_int),
        ("kind", c_int),
        ("metric", c_int),
        ("digits", c_int),
        ("number", c_double),
        ("text", c_char * 160),
    ]


class Schedule(enum.IntEnum):
    """`nqm_schedule`"""

    PLATEAU = 0
    COSINE = 1


class Whitening(enum.IntEnum):
    """`nqm_whitening`"""

    CHANNEL = 0
    SCALAR = 1


class ScaleCopy(enum.IntEnum):
    """`nqm_scale_copy`"""

    PAIR_REFLECTANCE = 0
    ELEMENT_TRANSFORMED = 1
    NONE = 2


TRAIN_MAX_HIDDEN = 7


class TrainInput(Structure):
    _fields_ = [
        ("layout", c_int),
        ("difference_scale", c_double),
        ("scalars", c_int),
        ("scalar_scale", c_double),
        ("transport", c_int),
        ("whitening", c_int),
    ]


class TrainLabels(Structure):
    _fields_ = [
        ("target", c_int),
        ("min_delta_e", c_double),
        ("parts_weight", c_double),
    ]


class TrainNetwork(Structure):
    _fields_ = [
        ("n_hidden", c_size_t),
        ("hidden", c_size_t * 7),
        ("dropout", c_double),
        ("freeze_first_layernorm", c_int),
    ]


class TrainSplit(Structure):
    _fields_ = [
        ("by_pair", c_int),
        ("validation_fraction", c_double),
    ]


class TrainAugmentation(Structure):
    _fields_ = [
        ("balance", c_int),
        ("balance_sigma", c_double),
        ("scale_copy", c_int),
        ("swap", c_int),
    ]


class TrainOptimiser(Structure):
    _fields_ = [
        ("lr_first", c_double),
        ("lr_deeper", c_double),
        ("weight_decay", c_double),
        ("schedule", c_int),
        ("plateau_factor", c_double),
        ("plateau_patience", c_size_t),
        ("batch", c_size_t),
        ("epochs", c_size_t),
        ("precision", c_int),
        ("seed", c_uint64),
    ]


class TrainRun(Structure):
    _fields_ = [
        ("checkpoint", c_char_p),
        ("resume", c_int),
        ("progress", Progress),
        ("progress_user", c_void_p),
        ("epoch_done", CFUNCTYPE(None, c_void_p, c_size_t, c_double, c_double, c_double)),
        ("epoch_user", c_void_p),
    ]


class TrainOptions(Structure):
    _fields_ = [
        ("recipe", c_char_p),
        ("id", c_char_p),
        ("licence", c_char_p),
        ("card", c_char_p),
        ("input", TrainInput),
        ("labels", TrainLabels),
        ("network", TrainNetwork),
        ("split", TrainSplit),
        ("augmentation", TrainAugmentation),
        ("optimiser", TrainOptimiser),
        ("run", TrainRun),
    ]


CALIBRATION_MIN_PAIRS = 100
CALIBRATION_MIN_MATERIALS = 10


class Calibration(Structure):
    _fields_ = [
        ("n_pairs", c_size_t),
        ("n_materials", c_size_t),
        ("coverage", c_double),
        ("coverage_pairs", c_double),
        ("coverage_lowest", c_double),
        ("mean_width", c_double),
        ("novelty_growth", c_double),
        ("disagreement_growth", c_double),
        ("peak_growth", c_double),
    ]


class TrainReport(Structure):
    _fields_ = [
        ("n_train", c_size_t),
        ("n_validation", c_size_t),
        ("n_steps", c_size_t),
        ("epochs", c_size_t),
        ("epochs_resumed", c_size_t),
        ("train_loss", c_double),
        ("validation_loss", c_double),
        ("validation_spearman", c_double),
        ("calibration", Calibration),
        ("seconds", c_double),
    ]


class Translation(Structure):
    _fields_ = [
        ("match", MatchReport),
        ("copied", c_char * 2048),
        ("dropped", c_char * 300),
        ("texture", TextureResult),
    ]


class TranslateModel(Structure):
    _fields_ = [
        ("name", c_char_p),
        ("alias", c_char_p),
        ("about", c_char_p),
        ("extension", c_char * 8),
    ]


#: name: (result, arguments)
FUNCTIONS = {
    "nqm_status_text": (c_char_p, [c_int]),
    "nqm_version": (c_char_p, []),
    "nqm_build_info": (c_char_p, []),
    "nqm_files_within": (c_int, [c_char_p, POINTER(Error)]),
    "nqm_brdf_open": (c_int, [c_char_p, c_void_p, POINTER(Error)]),
    "nqm_brdf_create": (c_int, [POINTER(BrdfCallbacks), c_void_p, POINTER(Error)]),
    "nqm_brdf_create_table": (c_int, [c_size_t, c_size_t, c_size_t, c_void_p, c_char_p, c_void_p, POINTER(Error)]),
    "nqm_brdf_free": (None, [c_void_p]),
    "nqm_brdf_get_info": (BrdfInfo, [c_void_p]),
    "nqm_brdf_eval": (None, [c_void_p, c_size_t, c_void_p, c_void_p, c_void_p, c_void_p]),
    "nqm_brdf_eval_half_diff": (None, [c_void_p, c_size_t, c_void_p, c_void_p, c_void_p]),
    "nqm_brdf_jacobian": (c_int, [c_void_p, c_size_t, c_void_p, c_void_p, c_void_p, c_void_p, POINTER(Error)]),
    "nqm_half_diff_to_directions": (None, [c_void_p, c_void_p, c_void_p]),
    "nqm_directions_to_half_diff": (None, [c_void_p, c_void_p, c_void_p]),
    "nqm_brdf_write": (c_int, [c_void_p, c_int, c_char_p, c_char_p, Progress, c_void_p, POINTER(Error)]),
    "nqm_brdf_preset_name": (c_char_p, [c_size_t]),
    "nqm_brdf_check": (c_int, [c_void_p, c_uint64, POINTER(BrdfCheckReport), POINTER(Error)]),
    "nqm_brdf_compare": (c_int, [c_void_p, c_void_p, c_double, c_uint64, POINTER(BrdfDifference), POINTER(Error)]),
    "nqm_brdf_albedo": (None, [c_void_p, c_double, c_uint64, c_void_p]),
    "nqm_directions_options_default": (DirectionsOptions, []),
    "nqm_directions_create": (c_int, [POINTER(DirectionsOptions), c_size_t, c_void_p, c_void_p, POINTER(Error)]),
    "nqm_directions_from_degrees": (c_int, [c_size_t, c_void_p, c_void_p, POINTER(Error)]),
    "nqm_directions_load_csv": (c_int, [c_char_p, c_void_p, POINTER(Error)]),
    "nqm_directions_save_csv": (c_int, [c_void_p, c_char_p, POINTER(Error)]),
    "nqm_directions_free": (None, [c_void_p]),
    "nqm_directions_get_info": (DirectionsInfo, [c_void_p]),
    "nqm_directions_id": (c_char_p, [c_void_p]),
    "nqm_sample": (c_int, [c_void_p, c_void_p, c_int, c_void_p, c_void_p, POINTER(SampleReport), POINTER(Error)]),
    "nqm_model_load": (c_int, [c_char_p, c_void_p, POINTER(Error)]),
    "nqm_model_save": (c_int, [c_void_p, c_char_p, POINTER(Error)]),
    "nqm_model_builtin_name": (c_char_p, [c_size_t]),
    "nqm_model_free": (None, [c_void_p]),
    "nqm_model_get_info": (ModelInfo, [c_void_p]),
    "nqm_curve_jod": (c_double, [POINTER(Curve), c_double]),
    "nqm_regress": (c_int, [c_size_t, c_void_p, c_void_p, POINTER(RegressReport), POINTER(Error)]),
    "nqm_label_get_info": (LabelInfo, [POINTER(Label)]),
    "nqm_metric_get_info": (MetricInfo, [c_int]),
    "nqm_score_options_default": (ScoreOptions, []),
    "nqm_score": (c_int, [c_void_p, c_void_p, c_size_t, c_void_p, POINTER(ScoreOptions), POINTER(ScoreResult), POINTER(Error)]),
    "nqm_scorer_create": (c_int, [c_void_p, POINTER(ScoreOptions), c_void_p, POINTER(Error)]),
    "nqm_scorer_free": (None, [c_void_p]),
    "nqm_scorer_run": (c_int, [c_void_p, c_void_p, c_size_t, c_void_p, POINTER(ScoreResult), POINTER(Error)]),
    "nqm_scorer_run_named": (c_int, [c_void_p, c_size_t, POINTER(NamedPair), POINTER(ScoreResult), POINTER(Error), POINTER(Error)]),
    "nqm_scorer_run_samples": (c_int, [c_void_p, c_size_t, POINTER(SamplePair), POINTER(ScoreResult), POINTER(Error)]),
    "nqm_score_grad": (c_int, [c_void_p, c_int, c_size_t, POINTER(SamplePair), c_void_p, c_void_p, POINTER(Error)]),
    "nqm_jod_preference": (c_double, [c_double, c_double]),
    "nqm_selftest": (c_int, [CFUNCTYPE(None, c_void_p, c_char_p, c_int), c_void_p, POINTER(Error)]),
    "nqm_conform_kit_create": (c_int, [c_char_p, c_char_p, c_void_p, c_void_p, POINTER(Error)]),
    "nqm_conform_kit_free": (None, [c_void_p]),
    "nqm_conform_kit_get_info": (ConformInfo, [c_void_p, c_size_t]),
    "nqm_conform_compare": (c_int, [c_void_p, c_void_p, Progress, c_void_p, POINTER(ScoreResult), POINTER(ConformReport), POINTER(Error)]),
    "nqm_dataset_load": (c_int, [c_char_p, c_char_p, c_int, c_void_p, POINTER(Error)]),
    "nqm_dataset_free": (None, [c_void_p]),
    "nqm_dataset_get_info": (DatasetInfo, [c_void_p]),
    "nqm_dataset_get_pair": (DatasetPair, [c_void_p, c_size_t]),
    "nqm_scene_options_default": (SceneOptions, []),
    "nqm_scene_create": (c_int, [POINTER(SceneOptions), c_void_p, POINTER(Error)]),
    "nqm_scene_free": (None, [c_void_p]),
    "nqm_scene_get_info": (SceneInfo, [c_void_p]),
    "nqm_scene_render": (c_int, [c_void_p, c_void_p, c_int, c_void_p, c_void_p, POINTER(Error)]),
    "nqm_rays_draw": (c_int, [c_void_p, c_size_t, c_uint64, POINTER(Rays), POINTER(Error)]),
    "nqm_rays_clear": (None, [POINTER(Rays)]),
    "nqm_scene_compare": (Label, [c_void_p, c_void_p, c_void_p, c_void_p]),
    "nqm_scene_label": (c_int, [c_void_p, POINTER(ScenePicture), POINTER(ScenePicture), POINTER(Label), c_void_p, c_void_p, POINTER(Error)]),
    "nqm_rays_compare": (c_int, [POINTER(Rays), c_void_p, c_void_p, POINTER(Label), c_void_p, POINTER(Error)]),
    "nqm_transport_create": (c_int, [POINTER(SceneOptions), c_int, c_size_t, c_char_p, c_void_p, POINTER(Error)]),
    "nqm_corpus_options_default": (CorpusOptions, []),
    "nqm_corpus_build": (c_int, [c_size_t, POINTER(CorpusPair), c_void_p, POINTER(CorpusOptions), c_char_p, POINTER(Error)]),
    "nqm_fit_options_default": (FitOptions, []),
    "nqm_fit_model": (c_char_p, [c_size_t]),
    "nqm_texture_open": (c_int, [c_char_p, Progress, c_void_p, c_void_p, POINTER(Error)]),
    "nqm_texture_create": (c_int, [c_char_p, c_size_t, POINTER(TextureMap), c_void_p, POINTER(Error)]),
    "nqm_texture_free": (None, [c_void_p]),
    "nqm_texture_get_info": (TextureInfo, [c_void_p, c_void_p]),
    "nqm_texture_options_default": (TextureOptions, []),
    "nqm_texture_score": (c_int, [c_void_p, c_void_p, c_void_p, POINTER(TextureOptions), POINTER(TextureResult), c_void_p, POINTER(Error)]),
    "nqm_library_open": (c_int, [c_size_t, c_void_p, c_void_p, POINTER(LibraryOptions), c_void_p, POINTER(Error)]),
    "nqm_library_free": (None, [POINTER(Library)]),
    "nqm_library_near": (c_int, [POINTER(Library), POINTER(LibraryQuery), c_void_p, c_void_p, POINTER(Error)]),
    "nqm_library_diff": (c_int, [POINTER(Library), POINTER(Library), c_void_p, c_void_p, POINTER(Error)]),
    "nqm_match": (c_int, [c_void_p, c_char_p, POINTER(MatchLoss), POINTER(FitOptions), POINTER(MatchReport), c_void_p, POINTER(Error)]),
    "nqm_materials_open": (c_int, [c_char_p, c_void_p, POINTER(Error)]),
    "nqm_materials_get": (MaterialInfo, [c_void_p, c_size_t]),
    "nqm_materials_free": (None, [c_void_p]),
    "nqm_pairs_read": (c_int, [c_char_p, c_void_p, POINTER(Error)]),
    "nqm_pairs_expand": (c_int, [POINTER(Pairs), c_char_p, c_void_p, POINTER(Error)]),
    "nqm_pairs_free": (None, [POINTER(Pairs)]),
    "nqm_pairs_remarks": (c_char_p, [c_void_p, c_int, POINTER(NamedPair), c_char_p, c_char_p, POINTER(ScoreResult), c_char_p]),
    "nqm_score_column": (Column, [c_size_t, POINTER(ScoreResult), POINTER(TextureResult)]),
    "nqm_train_options_recipe": (c_int, [c_char_p, POINTER(TrainOptions), POINTER(Error)]),
    "nqm_train": (c_int, [c_void_p, POINTER(TrainOptions), c_void_p, POINTER(TrainReport), POINTER(Error)]),
    "nqm_model_calibrate": (c_int, [c_void_p, c_void_p, c_int, c_void_p, POINTER(Calibration), POINTER(Error)]),
    "nqm_translate_target": (TranslateModel, [c_size_t]),
    "nqm_translate": (c_int, [c_void_p, c_char_p, c_char_p, c_char_p, POINTER(MatchLoss), POINTER(FitOptions), POINTER(Translation), POINTER(Error)]),
    "nqm_translate_texture": (c_int, [c_void_p, c_char_p, c_char_p, POINTER(MatchLoss), POINTER(FitOptions), POINTER(Translation), POINTER(Error)]),
}
