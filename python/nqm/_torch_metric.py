# SPDX-License-Identifier: MIT
"""The metric as a module of PyTorch: the formulas of doc/model-format.md with the tensors of a model file as buffers. The C library defines
the result; tests compare both. Differences of roots and logarithms are computed directly: their rounding matters only where two BRDFs
look the same."""
from __future__ import annotations

import contextlib
import json
import math
import os
import tempfile
from typing import Any, Dict, List, Optional, Tuple

import numpy as np
import torch
from torch.nn import functional

from ._library import lib
from ._call import call, encode
from ._score import Model, ModelLike, as_model

_DARK = 0.003  # 1/sr, added before logarithms
_LUMINANCE = (0.2126, 0.7152, 0.0722)
_SCALARS = """log_rmse log_mae log_rms_crwe log_ma_crwe log_rms_loge log_ma_loge log_rms_logwe log_ma_logwe log_log_diff rms max tail bulk
    bias shape bias_0_2 bias_2_5 bias_5_15 bias_15_35 bias_35_90 rms_0_2 rms_2_5 rms_5_15 rms_15_35 rms_35_90 bias_grazing rms_grazing width
    chroma chroma_rg chroma_b energy energy_chroma peak smooth smooth_chroma ref_level ref_energy ref_peak ref_spread ref_colour estimate
    estimate_i estimate_t estimate_p estimate_contrast estimate_structure""".split()
_CELLS, _ZONES = slice(0, 15), slice(15, 20)  # columns of Metric.sets, which end with highlight, flank and cosines
_HIGHLIGHT, _FLANK, _COSINES = 20, 21, 22

# RGB (BT.709) to LMS (BT.2100), and LMS to ITP times 720 (BT.2124); rows are inputs.
_LMS = (np.array([[1688, 2146, 262], [683, 2951, 462], [99, 309, 3688]]) / 4096 @
        np.array([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]])).T
_ITP = 720 / 4096 * np.array([[2048, 2048, 0], [3305, -6806.5, 3501.5], [17933, -17390, -543]]).T


def _root(x: torch.Tensor) -> torch.Tensor:
    """The square root, with a derivative of 0 at 0."""
    return x.clamp(min=1e-20).sqrt() * (x > 0).to(x.dtype)


def _cube_root(x: torch.Tensor, least: float = 1e-6) -> torch.Tensor:
    """The cube root; its derivative below `least` is that at `least`, as in the C library."""
    line = x.clamp(min=least).pow(1 / 3) + (x.clamp(max=least) - least) / (3 * least ** (2 / 3))
    return line + (x.detach().pow(1 / 3) - line).detach()


def _asinh(x: torch.Tensor) -> torch.Tensor:  # PyTorch 1 cannot export its own
    return x.sign() * torch.log(x.abs() + (x * x + 1).sqrt())


def _has_no_values(x: torch.Tensor) -> bool:
    """No branch by values can be taken: on the device "meta", in a trace (ONNX), in torch.compile of PyTorch 2."""
    is_compiling = getattr(getattr(torch, "compiler", None), "is_compiling", bool)
    return x.is_meta or torch.jit.is_tracing() or is_compiling()


def _opponents(x: torch.Tensor) -> Tuple[torch.Tensor, torch.Tensor]:
    red, green, blue = x.unbind(-1)
    return red - green, blue - (red + green) / 2


def _size(x: torch.Tensor) -> torch.Tensor:
    return torch.log(x + 1e-3)


def _tensors(model: Model) -> Tuple[Dict[str, np.ndarray], Dict[str, str]]:
    """Tensors and metadata of the model's file, which the library has checked."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "model.safetensors")
        call(lib.nqm_model_save, model._handle, encode(path))
        with open(path, "rb") as file:
            data = file.read()
    end = 8 + int.from_bytes(data[:8], "little")
    header = json.loads(data[8:end])
    metadata = header.pop("__metadata__")
    kinds = {"F16": "<f2", "F32": "<f4", "F64": "<f8"}
    return {name: np.frombuffer(data, kinds[row["dtype"]], math.prod(row["shape"]), end + row["data_offsets"][0]).reshape(row["shape"])
            for name, row in header.items()}, metadata


def _sets(degrees: np.ndarray, cosines: np.ndarray) -> np.ndarray:
    """Sets of directions over which f_r is summed, a column of weights each: 15 cells of 5 zones of theta_h times 3 of theta_d, the zones,
    those with theta_h below 5 degrees, the others, and cosines."""
    h, d = np.digitize(degrees[:, 0], [2, 5, 15, 35]), np.digitize(degrees[:, 1], [30, 60])
    zones = h[:, None] == np.arange(5)
    cells = zones[:, :, None] & (d[:, None] == np.arange(3))[:, None]
    return np.concatenate([cells.reshape(-1, 15), zones, h[:, None] < 2, h[:, None] >= 2, cosines[:, None]], 1)


class Metric(torch.nn.Module):
    """The score of sampled pairs as a module that PyTorch computes: on any device, with derivatives of any order by reference and test,
    for `torch.compile` and ONNX. Equal to `nqm.score_samples` within 1e-5 JOD in float32. It has no intervals and warnings.

    >>> metric = nqm.torch.Metric()
    >>> f = lambda wi, wo: .1 + .2 * (wi + wo)[:, 2:].expand(-1, 3) ** 8
    >>> ref = f(metric.wi, metric.wo)
    >>> metric(ref, .8 * ref).item() < metric(ref, .9 * ref).item()
    True

    Its derivatives are those of its formulas, while `nqm.score_grad` lets the slopes of roots fall near 0. An absolute value, and the root
    of a sum of squares, has the derivative 0 at 0: equal pairs have finite gradients. Values below 0 count as 0. As a loss of a training,
    `Loss` is better: a training learns fixed directions by heart.

    Args:
        model: "default", "transport", "paper", a path or a `Model`; those for anisotropic BRDFs are refused
        of: "jod" or "delta_e", Delta-E ITP, which the models of the paper do not have
        dtype, device: of the buffers, in which all is computed. float64 is exact to 1e-9 JOD; half precision to .1

    Attributes:
        wi, wo: directions of the samples, unit vectors (n, 3)
    """

    def __init__(self, model: ModelLike = "default", *, of: str = "jod", dtype: torch.dtype = torch.float32, device: Any = None) -> None:
        super().__init__()
        opened = as_model(model)
        tensors, metadata = _tensors(opened)
        if "slopes" in tensors:
            raise ValueError("nqm.torch.Metric cannot compute model %r, which is for anisotropic BRDFs; nqm.score can" % opened.info.id)
        if of not in ("jod", "delta_e") or (of == "delta_e" and metadata["target"] == "jod"):
            raise ValueError("of is jod or delta_e, and only jod of a model that predicts no Delta-E; not %r" % of)
        self.of, self._target, self._layout = of, metadata["target"], metadata["layout"]
        names = metadata.get("scalars")
        self._features = [_SCALARS.index(name) for name in names.split(",")] if names else []
        self._difference, self._scale = float(tensors["difference_scale"][0]), float(tensors.get("scalars.scale", [1])[0])
        self._curve, self._range = [tuple(map(float, tensors[key])) for key in ("jod_curve", "target")]
        self._n_layers = sum(name.endswith(".weight") and name.count(".") == 2 for name in tensors)
        for name, value in self._buffers_of(opened, tensors).items():
            self.register_buffer(name, torch.tensor(np.asarray(value, "f8"), dtype=dtype, device=device), persistent=False)

    def _buffers_of(self, model: Model, tensors: Dict[str, np.ndarray]) -> Dict[str, Any]:
        wi, wo = model.directions.vectors
        cosines = np.clip(wi[:, 2], 0, None) * np.clip(wo[:, 2], 0, None)
        buffers = {"wi": wi, "wo": wo, "cosines": cosines, "grazing": cosines < .25, "sets": _sets(tensors["directions_deg"], cosines),
                   "luminance": _LUMINANCE, "lms": _LMS, "itp": _ITP}
        if "transport" in tensors:
            share, scene, peak = tensors["transport.points"].T
            light = tensors["transport"]
            is_in = scene[:, None] == np.arange(scene[-1] + 1)
            buffers.update(light=light.reshape(len(light), 3, -1).swapaxes(0, 1), peak=peak[:, None], scenes=is_in,
                           shares=share[:, None] * is_in)
        for name, value in tensors.items():
            if name.startswith(("layers.", "whitening.", "scalars.")):
                is_last = name.startswith("layers.%d." % (self._n_layers - 1))
                buffers[name.replace(".", "_")] = value[:1] if is_last else value
        return buffers

    def forward(self, ref: torch.Tensor, test: torch.Tensor, used: Optional[torch.Tensor] = None) -> torch.Tensor:
        """The scores, of shape (...); NaN where a value that counts is NaN or infinite: in either BRDF, in any channel.

        Args:
            ref, test: f_r in 1/sr at `wi`, `wo`, (..., n, 3); leading dimensions are broadcast
            used: (..., n), False where a direction is left out, whatever its values

        Raises:
            ValueError: another shape, or no direction of a pair is used. A traced or compiled module cannot say the latter: NaN.
        """
        n = self.sets.shape[0]
        for name, x in (("ref", ref), ("test", test)):
            if tuple(x.shape[-2:]) != (n, 3):
                raise ValueError("%s has the shape %s; values at `wi`, `wo` of this model have (..., %d, 3)" % (name, tuple(x.shape), n))
        if used is not None and used.shape[-1:] != (n,):
            raise ValueError("used has the shape %s, not (..., %d)" % (tuple(used.shape), n))
        kind = self.sets.device.type
        # Autocast would multiply matrices in half precision: .7 JOD off.
        with torch.autocast(kind, enabled=False) if kind in ("cpu", "cuda") else contextlib.nullcontext():
            return self._scores(ref, test, used)

    def _scores(self, ref: torch.Tensor, test: torch.Tensor, used: Optional[torch.Tensor]) -> torch.Tensor:
        f, g = torch.broadcast_tensors(ref.to(self.sets.dtype), test.to(self.sets.dtype))
        u = torch.ones_like(f[..., 0]) if used is None else used.to(f.dtype).expand(f.shape[:-1])
        counts = u[..., None] > 0
        if used is not None and not _has_no_values(counts) and not counts.any(-2).all():
            raise ValueError("no direction of a pair is used")
        defined = (f.isfinite() & g.isfinite() | ~counts).flatten(-2).all(-1) & counts.any(-2)[..., 0]
        f, g = [torch.where(x.isfinite(), x, torch.zeros_like(x)).clamp(0, 1e15) for x in (f, g)]
        targets = self._estimate(f, torch.where(counts, g, f)) if hasattr(self, "light") else torch.zeros_like(f[..., :6, 0])
        mean, std, low, high = self._range
        z = self._network(f, g, u, targets) if self._n_layers else torch.zeros_like(f[..., 0, 0])
        value = targets[..., 0] + mean + std * (low + (high - low) * torch.sigmoid(z))
        if self._target != "jod":
            delta_e = self._bound(f, g, u, value.exp())
            value = delta_e if self.of == "delta_e" else self._jod(delta_e)
        return torch.where(defined, value, torch.full_like(value, math.nan))

    def _bound(self, f: torch.Tensor, g: torch.Tensor, u: torch.Tensor, delta_e: torch.Tensor) -> torch.Tensor:
        """Delta-E is at most 165 times the largest log ratio, if that is a factor below 1.65."""
        worst = ((torch.log(g + 5e-6) - torch.log(f + 5e-6)).abs() * u[..., None]).flatten(-2).amax(-1)
        return torch.where(worst < math.log(1.65), torch.minimum(delta_e, 165 * worst), delta_e)

    def _jod(self, delta_e: torch.Tensor) -> torch.Tensor:
        b1, b2, b3 = self._curve
        visible = delta_e > 1e-9  # below, 10 - JOD is 0 in any precision
        power = torch.where(visible, delta_e, torch.ones_like(delta_e)).pow(b3)
        return torch.where(visible, 10 * torch.sigmoid(-b1 * (power + b2)), torch.full_like(delta_e, 10))

    # ---- estimate by light transport ----

    def _see(self, f: torch.Tensor) -> torch.Tensor:
        """The picture (..., points, 3) of samples f (..., n, 3): ITP on the display, times 720."""
        rgb = torch.stack([f[..., c] @ self.light[c] for c in range(3)], -1)
        lms = (torch.minimum(rgb, self.peak) @ self.lms).clamp(2.0**-30, 1e4)
        y = (lms / 1e4).pow(2610 / 16384)
        # PQ is (1 + s)^(2523 / 32), since c1 = 1 + c3 - c2. The power enlarges errors, and ONNX has no log1p: log(1 + s) by its series.
        s = (1 - 3424 / 4096) * (y - 1) / (1 + 2392 / 128 * y)  # -0.17 to 0
        w = s / (2 + s)
        series = torch.zeros_like(w)
        for k in range(8, -1, -1):
            series = series * w * w + 1 / (2 * k + 1)
        return torch.exp(2523 / 16 * w * series) @ self.itp

    def _estimate(self, f: torch.Tensor, g: torch.Tensor) -> torch.Tensor:
        """Targets (..., 6) of the label of two pictures: logarithms and asinh of Delta-E and parts."""
        a, b = self._see(f), self._see(g)
        d, scenes, shares = b - a, self.scenes, self.shares
        shift = d.transpose(-1, -2) @ shares  # (..., 3, scenes)
        rest = d - (shift @ scenes.T).transpose(-1, -2)

        def deviation(i: torch.Tensor) -> torch.Tensor:
            return _root(((i - (i @ shares) @ scenes.T) ** 2) @ shares)

        delta_e = (_root((d * d).sum(-1)) @ shares).mean(-1)
        structure = _root((rest * rest).sum(-1) @ shares).mean(-1)
        contrast = (torch.log(1 + deviation(b[..., 0])) - torch.log(1 + deviation(a[..., 0]))).mean(-1)
        return torch.stack([delta_e.clamp(min=.05).log(), *_asinh(shift.mean(-1)).unbind(-1), _asinh(30 * contrast),
                            structure.clamp(min=.05).log()], -1)

    # ---- network ----

    def _network(self, f: torch.Tensor, g: torch.Tensor, u: torch.Tensor, targets: torch.Tensor) -> torch.Tensor:
        """The first output of the network, (...)."""
        r, t = [((torch.log1p(_cube_root(x)) - self.whitening_mean) / self.whitening_std * u[..., None]).flatten(-2) for x in (f, g)]
        if self._layout == "ref_test":
            inputs = [r, t]
        else:
            difference = self._difference * (t - r)
            inputs = [r, difference, difference.abs()]
        if self._features:
            scalars = torch.cat([torch.stack(self._scalars(f, g, u), -1), targets], -1)[..., self._features]
            inputs.append(self._scale * ((scalars - self.scalars_mean) / self.scalars_std).clamp(-5, 5))
        x = torch.cat(inputs, -1)
        for i in range(self._n_layers):
            name = "layers_%d_" % i
            x = functional.linear(x, getattr(self, name + "weight"), getattr(self, name + "bias"))
            if i + 1 < self._n_layers:
                gamma = getattr(self, name + "norm_weight")
                x = functional.gelu(functional.layer_norm(x, gamma.shape, gamma, getattr(self, name + "norm_bias")))
        return x[..., 0]

    def _scalars(self, f: torch.Tensor, g: torch.Tensor, u: torch.Tensor) -> List[torch.Tensor]:
        """The scalar features up to ref_colour, (...) each. Left-out directions have the value 0 in both BRDFs."""
        f, g = f * u[..., None], g * u[..., None]
        n = u.sum(-1).clamp(min=1)

        def mean(x: torch.Tensor) -> torch.Tensor:
            return (x * u).sum(-1) / n

        c = self.cosines[:, None]
        log_f, log_g = torch.log(f + _DARK), torch.log(g + _DARK)
        scales = (g - f, _cube_root(c * g, 1e-9) - _cube_root(c * f, 1e-9), torch.log1p(g) - torch.log1p(f), torch.log1p(c * g) - torch.log1p(c * f))
        out = [torch.log(x + 1e-4) for s in scales for x in (_root(mean((s * s).mean(-1))), mean(s.abs().mean(-1)))]
        d = log_g - log_f
        out.append(torch.log(mean(d.abs().mean(-1)) + 1e-4))

        y_f, y_g = f @ self.luminance, g @ self.luminance
        log_y = torch.log(y_f + _DARK)
        l = torch.log(y_g + _DARK) - log_y
        bias = mean(l)
        out += [_size(_root(mean((d * d).mean(-1)))), _size((l.abs() * u).amax(-1)), _size(_root(_root(mean(l**4)))), _size(mean(_root(l.abs())) ** 2),
                bias, _size(_root(mean((l - bias[..., None]) ** 2)))]

        count, ratio, red_green, blue = self._ratios(f, g, u)
        grazing = ((u @ self.grazing).clamp(min=1), u * self.grazing)
        out += ratio[..., _ZONES].unbind(-1)
        out += _size(_root((l * l * u) @ self.sets[:, _ZONES] / count[..., _ZONES].clamp(min=1))).unbind(-1)
        out += [(l * grazing[1]).sum(-1) / grazing[0], _size(_root((l * l * grazing[1]).sum(-1) / grazing[0])),
                ratio[..., _HIGHLIGHT] - ratio[..., _FLANK]]

        rg, b = _opponents(d)
        share = count[..., _CELLS] / n[..., None]
        opponents = red_green**2 + blue**2
        out += [_size(_root(mean(rg * rg + b * b))), mean(rg), mean(b), ratio[..., _COSINES], _size(_root(opponents[..., _COSINES])),
                torch.log(y_g.amax(-1) + _DARK) - torch.log(y_f.amax(-1) + _DARK), _size(_root((share * ratio[..., _CELLS] ** 2).sum(-1))),
                _size(_root((share * opponents[..., _CELLS]).sum(-1)))]

        level = mean(log_y)
        rg, b = _opponents(log_f)
        energy = (y_f * self.cosines).sum(-1) / count[..., _COSINES].clamp(min=1e-30)
        return out + [level, torch.log(energy + _DARK), torch.log(y_f.amax(-1) + _DARK) - level, _root(mean((log_y - level[..., None]) ** 2)),
                      _root(mean(rg * rg + b * b))]

    def _ratios(self, f: torch.Tensor, g: torch.Tensor, u: torch.Tensor) -> Tuple[torch.Tensor, torch.Tensor, torch.Tensor, torch.Tensor]:
        """For each of the sets: its number of directions, and of the sums over it the log ratio of luminance, and the opponents of the log
        ratios of the channels, (..., sets) each."""
        count = u @ self.sets
        floor = _DARK * count + (count <= 0).to(count.dtype)  # an empty set has ratios of 1
        sum_f, sum_g = [x.transpose(-1, -2) @ self.sets for x in (f, g)]  # (..., 3, sets)
        channels = torch.log(sum_g + floor[..., None, :]) - torch.log(sum_f + floor[..., None, :])
        y = torch.log(self.luminance @ sum_g + floor) - torch.log(self.luminance @ sum_f + floor)
        return (count, y, *_opponents(channels.transpose(-1, -2)))
