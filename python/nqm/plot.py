# SPDX-License-Identifier: MIT
"""Charts for papers and pages, drawn by matplotlib: slices and differences of BRDFs, directions, networks, evaluations and trainings.

`python3 -m nqm.plot slice sgd:nickel ward:nickel -o slice.svg` draws a file. In Python each kind of chart is a function that returns matplotlib
axes, which can be changed before they are saved:

    axes = nqm.plot.slice(["sgd:nickel", "ward:nickel"])
    axes[0, 0].set_title("My title").figure.savefig("slice.pdf")

`figure` is the matplotlib figure to draw in; None: a new one of pyplot. Tables are files that verbs of the tool write. The first chart imports
matplotlib (Debian: python3-matplotlib).
"""
from __future__ import annotations

import argparse
import csv
import io
import json
import os
import re
import sys
from ctypes import byref
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np

from ._abi import RegressReport, Status
from ._library import lib
from ._brdf import BRDFLike, Directions, as_brdf
from ._call import Error, PathLike, address, call
from ._metric import metrics
from ._score import ModelLike, as_model

# Okabe and Ito 2008, "Color universal design", for colour-blind readers; yellow last, because it is faint on white.
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#f0e442")
_DASHES = ("-", (0, (6, 3)), (0, (1.5, 1.5)), (0, (7, 2, 1.5, 2)))
_MARKERS = "oD^sv*hp"
_MOST = 8  # BRDFs, logs or groups in a chart


def _figure(figure: Any, width: float, height: float) -> Any:
    """The figure to draw in, of so many CSS pixels (1/96 inch)."""
    try:
        import matplotlib.pyplot
    except ImportError:
        raise ImportError("nqm.plot needs matplotlib: install the package python3-matplotlib (Debian), or matplotlib by pip") from None
    figure = matplotlib.pyplot.figure() if figure is None else figure
    figure.set_size_inches(width / 96, height / 96)
    figure.set_layout_engine("constrained")
    return figure


def _finish(axes: Any, title: str, note: str) -> Any:
    """Grid, legend (in the first axes), title and note; returns the axes."""
    for ax in np.ravel(axes)[::-1]:
        ax.grid(color="0.9")
        ax.set_axisbelow(True)
    if ax.get_legend_handles_labels()[1]:
        ax.legend(fontsize=8)
    ax.figure.suptitle(title, fontsize=12)
    ax.figure.supxlabel(note, fontsize=8)
    return axes


# ---- BRDFs and models -----------------------------------------------------------------------------------------------


def _vectors(theta_h: Any, theta_d: Any, phi_d: Any) -> List[np.ndarray]:
    """`wi` and `wo` of half-vector coordinates in radians, with phi_h = 0."""
    h, d, p = np.broadcast_arrays(theta_h, theta_d, phi_d)
    x, y, z = np.sin(d) * np.cos(p), np.sin(d) * np.sin(p), np.cos(d)
    return [np.stack([s * x * np.cos(h) + z * np.sin(h), s * y, z * np.cos(h) - s * x * np.sin(h)], axis=-1) for s in (1, -1)]


def _values(brdf: Any, wi: np.ndarray, wo: np.ndarray, azimuth: float) -> np.ndarray:
    """f_r (..., 3) with both directions turned about the normal; NaN where there is no value."""
    turn = np.array([[np.cos(azimuth), np.sin(azimuth), 0], [-np.sin(azimuth), np.cos(azimuth), 0], [0, 0, 1]])
    rgb, flag = brdf.eval_flags(wi @ turn, wo @ turn)
    rgb[flag >= 2] = np.nan
    return rgb


def _names(brdfs: Sequence[Any], given: Optional[Sequence[Optional[str]]]) -> List[str]:
    """For legends: the given ones; else the file name without folder and ending, or the spec."""
    paths = ["/" in b.name and ";" not in b.name for b in brdfs]
    short = [re.sub(r"(?<=.)\.[^.:]*$", "", os.path.basename(b.name)) if is_path else b.name for b, is_path in zip(brdfs, paths)]
    return [(given[i] if given else None) or (s if len(s) <= 57 else s[:57] + "...") for i, s in enumerate(short)]


def _sqrt_axis(ax: Any, label: str) -> None:
    """theta_h on a square-root scale, as in MERL tables."""
    ticks = (0, 1, 2, 5, 10, 20, 30, 45, 60, 75, 90)
    ax.set_xscale("function", functions=(lambda x: np.sqrt(np.maximum(x, 0)), np.square))
    ax.set(xlim=(0, 90), xlabel=label, xticks=ticks, xticklabels=ticks)


def _slice_panel(ax: Any, panel: int, x: np.ndarray, y: np.ndarray, styles: List[Dict[str, Any]]) -> None:
    """Lines, axes and ticks of a panel of `slice`, without its title."""
    found = y[np.isfinite(y)]
    # The lowest 2 % of the values, most of them near the horizon, would take most of the axis: they are cut.
    low, high = (0.8 * np.quantile(found, 0.02), 1.25 * found.max()) if found.size else (0.1, 1)
    is_polar = panel == 2
    for values, style in zip(y, styles):
        ax.plot(np.radians(x) if is_polar else x, np.log10(np.maximum(values, low / 10)) if is_polar else values, linewidth=1.6, **style)
    if is_polar:
        ends = np.log10([low / 10, high])  # leaves a gap between the smallest value and the centre
        decades = np.arange(np.ceil(ends[0]), ends[1], max(1, round((ends[1] - ends[0]) / 3)))
        ax.set(theta_zero_location="N", theta_direction=-1, thetamin=-90, thetamax=90, rlim=ends, xlabel="radius: $f_r$ (1/sr), logarithmic")
        ax.set_rticks(decades, ["$10^{%d}$" % d for d in decades], fontsize=8)
        ax.set_xticks(np.radians([-90, -45, 0, 45, 90]), ["−90°", "light\n−45°", "0°", "45°", "90°"])
        ax.plot([-np.pi / 4] * 2, ends, color="0.5", linewidth=1, linestyle=_DASHES[1])
        return
    ax.set(yscale="log", ylim=(low, high), ylabel="$f_r$ (1/sr)")
    first, step, axis = (0, 15, "d") if panel == 1 else (-90, 30, "o")
    ax.set(xlabel=r"$\theta_%s$ (°)" % axis, xlim=(first, 90), xticks=range(first, 91, step))
    if panel == 0:
        _sqrt_axis(ax, r"$\theta_h$ (°)")


def slice(brdfs: Sequence[BRDFLike], *, names: Optional[Sequence[Optional[str]]] = None, theta_d_deg: float = 0, phi_d_deg: float = 90,
          azimuth_deg: float = 0, figure: Any = None) -> np.ndarray:
    """Luminance of f_r of 1 to 8 BRDFs on logarithmic axes (2, 3): over theta_h, at `theta_d_deg` and `phi_d_deg`; over theta_d in the mirror direction; as
    polar lobes, whose radius is log10(f_r), for light at 45 degrees; in the plane of incidence for light at 15, 45 and 70 degrees. `azimuth_deg`: of the
    light from the tangent, for anisotropic BRDFs. `names`: in the legend; None: those of the BRDFs."""
    if not 1 <= len(brdfs) <= _MOST or not 0 <= theta_d_deg < 90:
        raise ValueError("slice draws 1 to %d BRDFs, not %d, at theta_d of 0 to below 90 degrees, not %g" % (_MOST, len(brdfs), theta_d_deg))
    opened, t, lights = [as_brdf(b) for b in brdfs], np.linspace(0, 1, 361), (45, 15, 45, 70)
    # Degrees on the x axis: quadratic in theta_h, because highlights are narrow; without the horizon. The light is on the left.
    x = [89.5 * t * t, 89.5 * t] + [-89.5 + 179 * t] * 4
    pairs = [_vectors(np.radians(x[0]), np.radians(theta_d_deg), np.radians(phi_d_deg)), _vectors(0, np.radians(x[1]), np.radians(phi_d_deg))]
    pairs += [[np.stack(np.broadcast_arrays(np.sin(a), 0, np.cos(a)), axis=-1) for a in (np.radians(-light + 0 * t), np.radians(x[2]))] for light in lights]
    luminance = [0.2126, 0.7152, 0.0722]  # of BT.709
    y = np.array([[_values(b, wi, wo, np.radians(azimuth_deg)) @ luminance for b in opened] for wi, wo in pairs])
    y[~(y > 0)] = np.nan  # the axes are logarithmic
    drawn = np.isfinite(y).any(axis=(0, 2))
    if not drawn.any():
        raise Error("no BRDF has a value above 0 in any slice: nothing to draw", Status.NUMERIC)
    styles = [{"color": _COLOURS[k], "linestyle": _DASHES[k % 4] if drawn[k] else "none", "label": name + ("" if drawn[k] else " (0)")}
              for k, name in enumerate(_names(opened, names))]
    titles = [r"$\theta_d$ = %.3g°, $\phi_d$ = %.3g°" % (theta_d_deg, phi_d_deg), r"mirror direction, $\theta_h$ = 0"]
    titles += [("plane of incidence" if k else "lobes") + r", $\theta_i$ = %d°" % light for k, light in enumerate(lights)]
    figure = _figure(figure, 960, 640)
    axes = np.array([[figure.add_subplot(2, 3, 3 * i + k + 1, polar=(i, k) == (0, 2)) for k in range(3)] for i in range(2)])
    for panel, ax in enumerate(axes.flat):
        _slice_panel(ax, panel, x[panel], y[panel], styles)
        ax.set_title(titles[panel], fontsize=10)
    turned = "" if all(b.info.isotropic for b in opened) else "; %.3g° from the tangent" % azimuth_deg
    return _finish(axes, "Slices of BRDFs", r"luminance of $f_r$, without the cosine; the light is at $\theta_i$ on the left (negative $\theta_o$), its mirror "
                   "direction on the right" + turned)


def attribution(ref: BRDFLike, test: BRDFLike, *, names: Optional[Sequence[Optional[str]]] = None, figure: Any = None) -> Any:
    """Map over theta_h and theta_d of the mean absolute difference of log(f_r + 0.003) over phi_d, channels and, of anisotropic BRDFs, azimuths."""
    brdfs = [as_brdf(ref), as_brdf(test)]
    azimuths = np.zeros(1) if all(b.info.isotropic for b in brdfs) else np.arange(12) * np.pi / 6
    theta_d, root, phi_d = np.meshgrid((np.arange(60) + 0.5) / 60, (np.arange(90) + 0.5) / 90, (np.arange(18) + 0.5) / 18, indexing="ij")
    wi, wo = _vectors(np.pi / 2 * root**2, np.pi / 2 * theta_d, np.pi * phi_d)
    logs = [np.stack([np.log(_values(b, wi, wo, azimuth) + 0.003) for azimuth in azimuths], axis=2) for b in brdfs]
    mean = abs(np.ma.masked_invalid(logs[0] - logs[1])).mean(axis=(2, 3, 4))
    if mean.mask.all():
        raise Error("there is no direction where both BRDFs have a value", Status.INCOMPATIBLE)
    most = max(mean.max(), 0.01)  # rounding errors must not look like a difference
    ax = _figure(figure, 620, 480).add_subplot()
    drawn = ax.pcolormesh(90 * np.linspace(0, 1, 91) ** 2, np.linspace(0, 90, 61), mean, vmin=0, vmax=most, cmap="viridis", rasterized=True)
    _sqrt_axis(ax, r"$\theta_h$ (°, square-root scale)")
    ax.set(ylim=(0, 90), yticks=range(0, 91, 15), ylabel=r"$\theta_d$ (°)")
    ax.figure.colorbar(drawn, ax=ax, label=r"mean |difference of $\log(f_r + 0.003)$|")
    return _finish(ax, "Where {1} differs from {0}".format(*_names(brdfs, names)), r"mean over $\phi_d$%s and the channels of the BRDFs themselves; no model is "
                   "involved;\nwhite: light or viewer below the horizon; a difference of 0.1 is about 10 %%, one of 0.7 a factor of 2" %
                   (", azimuths" if len(azimuths) > 1 else ""))


def directions(source: Union[Directions, ModelLike] = "default", *, figure: Any = None) -> np.ndarray:
    """Sampling directions: theta_d and, in the second axes, phi_d over theta_h. `source`: Directions, a CSV of them, or a model."""
    if isinstance(source, (str, os.PathLike)) and os.fspath(source).endswith(".csv"):
        source = Directions.open(source)
    found = source if isinstance(source, Directions) else as_model(source).directions
    degrees = found.degrees
    axes = _figure(figure, 760, 420).subplots(1, 2)
    for k, (ax, name, end, step) in enumerate(zip(axes, (r"$\theta_d$ (°)", r"$\phi_d$ (°)"), (90, 180), (15, 30)), 1):
        ax.plot(degrees[:, 0], degrees[:, k], "o", color=_COLOURS[0], alpha=0.75, markersize=3, markeredgewidth=0, clip_on=False)
        low, high = step * min(0, degrees[:, k].min() // step), step * max(end // step, -(-degrees[:, k].max() // step))  # phi_d may have any value
        ax.set(xlabel=r"$\theta_h$ (°)", ylabel=name, xlim=(0, 90), ylim=(low, high), xticks=range(0, 91, 15), yticks=np.arange(low, high + 1, step))
    return _finish(axes, "%d directions" % len(degrees), r"half-vector coordinates (Rusinkiewicz 1998), $\phi_h$ = 0; id of the set %s" % found.id)


def network(model: ModelLike = "default", *, figure: Any = None) -> Any:
    """The layers of a model's network as a table: sizes, parameters, multiplications."""
    opened = as_model(model)
    info = opened.info
    pairs, last = list(zip(info.layer_sizes, info.layer_sizes[1:])), len(info.layer_sizes) - 2
    if not pairs:
        raise Error("the model %s has no network" % info.id, Status.INCOMPATIBLE)
    rows = [["linear %d" % (i + 1), *("{:,}".format(n) for n in (a, b, a * b + b + (2 * b if i < last else 0), a * b)),  # LayerNorm: gain, shift
             "LayerNorm, GELU, dropout" if i < last else "sigmoid over the range of labels"] for i, (a, b) in enumerate(pairs)]
    rows.append(["total", "", "", "{:,}".format(info.n_parameters), "{:,}".format(sum(a * b for a, b in pairs)), ""])
    ax = _figure(figure, 760, 120 + 30 * len(rows)).add_subplot(frame_on=False, xticks=[], yticks=[])
    table = ax.table(rows, colLabels=["layer", "inputs", "outputs", "parameters", "multiplications", "followed by"], edges="horizontal",
                     colWidths=[0.12, 0.1, 0.1, 0.17, 0.19, 0.32], loc="center")
    table.scale(1, 1.6)
    table.auto_set_font_size(False)
    for (_, column), cell in table.get_celld().items():
        cell.set_text_props(ha="left" if column in (0, 5) else "right", fontsize=9.5)
    return _finish(ax, 'The network of model "%s"' % info.id, "recipe %s; %d directions; parameters of a layer: weights, biases, gain and shift of its LayerNorm"
                   "\noutput: JOD from %.2f to %.2f; dropout is active in training only" % (info.recipe, len(opened.directions), info.jod_min, info.jod_max))


# ---- tables that verbs write ----------------------------------------------------------------------------------------


def _text(path: PathLike) -> str:
    """The text of a file; "-": of standard input."""
    try:
        if os.fspath(path) == "-":
            return sys.stdin.read()
        with open(path, encoding="utf-8-sig", errors="replace", newline="") as file:
            return file.read()
    except OSError as error:
        raise Error("%s: %s" % (path, error.strerror), Status.IO) from None


class _Table:
    """A CSV with a header: comments begin with '#'; separators are commas or, without one in the header, semicolons or tabs."""

    def __init__(self, path: PathLike) -> None:
        lines = ["\n" if line.lstrip().startswith("#") else line for line in io.StringIO(_text(path), newline="")]
        first = next((line for line in lines if line.strip()), "")
        reader = csv.reader(lines, delimiter=next((c for c in ",;\t" if c in first), ","), strict=True)
        try:
            rows = [(reader.line_num, [field.strip() for field in row]) for row in reader if "".join(row).strip() or len(row) > 1]
        except csv.Error as error:
            raise Error("%s: line %d: %s" % (path, reader.line_num, error), Status.FORMAT) from None
        if not rows:
            raise Error("%s: no header line: the file is empty" % path, Status.FORMAT, 0)
        self.path, self.header, self.rows = path, rows[0][1], rows[1:]
        self.columns = {name.lower(): i for i, name in reversed(list(enumerate(self.header)))}
        for line, row in self.rows:
            if len(row) != len(self.header):
                raise Error("%s: line %d: %d fields where the header has %d" % (path, line, len(row), len(self.header)), Status.FORMAT)

    def texts(self, name: str) -> List[str]:
        if name.lower() not in self.columns:
            raise Error("%s: the header has no column %s; it has %s" % (self.path, name, ", ".join(self.header)), Status.FORMAT, 0)
        if not self.rows:
            raise Error("%s: there are no rows" % self.path, Status.INCOMPATIBLE)
        return [row[self.columns[name.lower()]] for _, row in self.rows]

    def numbers(self, name: str) -> np.ndarray:
        for text, (line, _) in zip(self.texts(name), self.rows):
            if not re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", text, re.I | re.A) or not np.isfinite(float(text)):
                raise Error("%s: line %d: column '%s' needs a finite number, not '%s'" % (self.path, line, name, text[:40]), Status.FORMAT)
        return np.array(self.texts(name), dtype=float)

    def groups(self, name: str) -> Dict[str, np.ndarray]:
        """The rows of each text of a column, which may be missing; the eighth group takes all further texts, as "other"."""
        texts = self.texts(name) if name in self.columns else [""] * len(self.rows)
        first = list(dict.fromkeys(texts))
        texts = [t if len(first) <= _MOST or t in first[:_MOST - 1] else "other" for t in texts]
        return {group: np.array([t == group for t in texts]) for group in dict.fromkeys(texts)}


def _points(ax: Any, x: np.ndarray, y: np.ndarray, groups: Dict[str, np.ndarray], size: float) -> None:
    """A marker for each row, whose colour and shape tell its group."""
    for k, (name, rows) in enumerate(groups.items()):
        ax.plot(x[rows], y[rows], _MARKERS[k], color=_COLOURS[k], alpha=0.75, markersize=size, markeredgewidth=0, label=name or None)


def _spearman(x: np.ndarray, y: np.ndarray) -> float:
    ranks = []
    for v in (x, y):
        _, group, count = np.unique(v, return_inverse=True, return_counts=True)
        ranks.append((np.cumsum(count) - (count - 1) / 2)[group])  # ties have their mean rank
    with np.errstate(invalid="ignore"):
        return float(np.corrcoef(*ranks)[0, 1])


def curve(labels_csv: PathLike, *, figure: Any = None) -> Any:
    """JOD against Delta-E ITP of a CSV with the columns DeltaE, JOD and, for the colours, model, with the curve that `nqm regress` fits to it."""
    table = _Table(labels_csv)
    x, y, fit = table.numbers("DeltaE"), table.numbers("JOD"), RegressReport()
    if len(x) < 4:
        raise Error("%s: %d rows do not determine the curve, 4 are needed" % (labels_csv, len(x)), Status.INCOMPATIBLE)
    call(lib.nqm_regress, len(x), address(x), address(y), byref(fit))
    ax = _figure(figure, 640, 440).add_subplot()
    _points(ax, x, y, table.groups("model"), 5)
    delta_e = np.linspace(0, 1.04 * x.max(), 256)
    ax.plot(delta_e, [lib.nqm_curve_jod(byref(fit.curve), e) for e in delta_e], color="black", linewidth=1.7, label="fitted curve")
    ax.set(xlabel="ΔE ITP", ylabel="JOD", xlim=(0, delta_e[-1]), ylim=(min(-0.3, y.min() - 0.3), max(10.3, y.max() + 0.3)), yticks=range(11))
    formula = r"JOD = 10 (1 − 1 / (1 + exp($b_1$ ($-\Delta E^{b_3} - b_2$)))): $b_1$ = %.3f, $b_2$ = %.4f, $b_3$ = %.4f"
    return _finish(ax, "Quality against colour difference", formula % (fit.curve.b1, fit.curve.b2, fit.curve.b3) + "\nleast squares over %d labels, RMSE "
                   "%.3f JOD; Spearman correlation %.3f" % (fit.n, fit.rmse, fit.spearman))


def scatter(pairs_csv: PathLike, predictor: Optional[str] = None, *, figure: Any = None) -> Any:
    """Prediction against label, or human score, of each pair that `nqm eval --pairs` wrote, coloured by the family of the distortion. `predictor`: the
    column to draw; None: the column after jod, which is the model's."""
    table = _Table(pairs_csv)
    predictor = predictor or dict(zip(table.header, table.header[1:])).get("jod")
    if "jod_low" in table.columns:
        raise Error("%s: has the scores of nqm batch (column jod_low) and no labels; nqm eval --pairs FILE writes labels and predictions, also with "
                    "--human" % pairs_csv, Status.INCOMPATIBLE)
    if "jod" not in table.columns or not predictor:
        raise Error("%s: scatter needs the column jod (labels) and after it a column of predictions; `nqm eval --pairs FILE.csv` writes both, with --human "
                    "%s for answers of people" % (pairs_csv, pairs_csv), Status.FORMAT, 0)
    x, y = table.numbers("jod"), table.numbers(predictor)
    is_jod = predictor not in metrics()
    is_human = "delta_e" in table.columns and not table.texts("delta_e")[0]  # on a scale of their own
    ax = _figure(figure, 560, 580).add_subplot()
    _points(ax, x, y, table.groups("family"), 4)
    if is_jod and not is_human:
        low, high = min(x.min(), y.min()), max(x.max(), y.max())
        ends = (low - 0.04 * (high - low) - 0.01, high + 0.04 * (high - low) + 0.01)
        ax.plot(ends, ends, color="black", linewidth=0.9, linestyle=_DASHES[1], label="equal")
        ax.set(xlim=ends, ylim=ends, aspect="equal")
    ax.set(xlabel="score of people" if is_human else "JOD of the label", ylabel="%s (%s)" % ("predicted JOD" if is_jod else "distance", predictor),
           yscale="linear" if is_jod else "log")
    correlation = "" if len(x) == 1 else "; Spearman correlation %.3f%s" % (_spearman(x, y if is_jod else -y),
                                                                            "" if is_jod else " (signed: higher is better)")
    return _finish(ax, "%s against the %s of each pair" % (predictor, "human score" if is_human else "label"),
                   "%d pair%s%s" % (len(x), "" if len(x) == 1 else "s", correlation))


# What bars show: two members of each result and their intervals, the two groups, and words for messages, axis and title.
_CORRELATION = ("spearman", "spearman_mean_by_material"), ("ci95", "ci95_mean_by_material"), ("over all pairs", "mean over materials"), "Spearman correlation"
_STATISTICS = {
    "": (*_CORRELATION, "Spearman correlation with the labels (1: the same order)", "Agreement with the labels"),
    "score": (*_CORRELATION, "Spearman correlation with the scores of people (1: the same order)", "Agreement with the scores of people"),
    "choice": (("majority", "agreement"), ("", "ci95"), ("each pair of tests: choice of most people", "all choices"), "agreement",
               "fraction of the choices that is predicted (0.5: guessing)", "Agreement with the choices of people"),
}


def bars(eval_json: PathLike, *, figure: Any = None) -> Any:
    """Spearman correlation of every predictor with labels or human scores, over all pairs and as the mean over materials, or the fraction of human choices
    that it predicts, with 95 % intervals, best first, from `nqm eval --json`."""
    try:
        document = json.loads(_text(eval_json))
    except ValueError as error:
        raise Error("%s: %s: bars draws the document of `nqm eval --json`" % (eval_json, error), Status.FORMAT) from None
    results = document.get("results") if isinstance(document, dict) else None
    if not isinstance(results, list) or not all(isinstance(r, dict) and isinstance(r.get("name"), str) for r in results):
        raise Error("%s: there is no list \"results\" of named predictors; expected the output of nqm eval --json" % eval_json, Status.FORMAT, 0)
    if not results:
        raise Error("%s: there are no results to draw" % eval_json, Status.INCOMPATIBLE)
    human, first = document.get("human") or {}, results[0]
    kind = "" if not human else "choice" if human.get("kind") == "choice" else "score"
    keys, interval_keys, groups, what, label, title = _STATISTICS[kind]
    try:  # None, in JSON null, becomes NaN: no bar
        value = np.array([[r.get(key) for key in keys] for r in results], dtype=float)
        ends = np.array([[r.get(key) or [None, None] for key in interval_keys] for r in results], dtype=float)  # (results, 2, 2)
    except (TypeError, ValueError):
        raise Error("%s: a %s or its interval is no number" % (eval_json, what), Status.FORMAT) from None
    for i in np.flatnonzero(np.isnan(value).all(axis=1)):
        raise Error("%s: result %d (%s) has no %s" % (eval_json, i, results[i]["name"], what), Status.FORMAT)
    rank = np.where(np.isfinite(value[:, 1]), value[:, 1], value[:, 0])
    order = sorted(range(len(results)), key=lambda i: (-rank[i], results[i]["name"]))
    value, ends = value[order], ends[order]
    drawn = [k for k in range(2) if np.isfinite(value[:, k]).any()]
    known = np.isfinite(ends).all(axis=2)
    ax = _figure(figure, 640, max(150 + 42 * len(results), 200)).add_subplot()
    for place, k in enumerate(drawn):
        at = np.arange(len(results)) + 0.38 * (place - (len(drawn) - 1) / 2)
        ax.barh(at, value[:, k], 0.38, color=(_COLOURS[5], _COLOURS[4])[k], label=groups[k])
        ax.errorbar(value[known[:, k], k], at[known[:, k]], xerr=np.abs(ends[known[:, k], k].T - value[known[:, k], k]), fmt="none", ecolor="0.1",
                    elinewidth=1.2, capsize=3)
        for i in np.flatnonzero(np.isfinite(value[:, k])):
            ax.text(np.nanmax([value[i, k], ends[i, k, 1], 0]) + 0.01, at[i], "%.3f" % value[i, k], va="center", fontsize=8)
    ax.set(yticks=range(len(results)), yticklabels=[results[i]["name"] for i in order], ylim=(len(results) - 0.5, -0.5), xlabel=label,
           xlim=(1.15 * np.nanmin([0, *value.ravel(), *ends.ravel()]), 1.14))
    note = "%s choices between %s pairs of tests, at most %.3f can be predicted; materials: %s" % (
        human.get("choices"), human.get("triplets"), human.get("ceiling") or np.nan, human.get("materials")) if kind == "choice" else \
        "%s pairs; materials: %s" % (first.get("n"), first.get("n_materials"))
    split = "" if human else (document.get("dataset") or {}).get("split") or ""  # a split belongs to labels only
    return _finish(ax, title, note + (", split: " + split if split else "") + ("\nwhiskers: 95 % intervals, bootstrap over materials" if known.any() else ""))


def loss(logs: Union[PathLike, Sequence[PathLike]], *, figure: Any = None) -> np.ndarray:
    """Training and validation loss over the epochs and, in the second axes, the learning rate of the first layer, of 1 to 8 files of `nqm train --log`."""
    paths = [logs] if isinstance(logs, (str, os.PathLike)) else list(logs)
    if not 1 <= len(paths) <= _MOST:
        raise ValueError("1 to %d trainings can be drawn, not %d" % (_MOST, len(paths)))
    tables = [_Table(path) for path in paths]
    columns = [[table.numbers(name) for name in ("train_loss", "validation_loss", "lr_first", "epoch")] for table in tables]
    axes = _figure(figure, 640, 520).subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [0.64, 0.36]})
    for i, (path, (train, validation, rate, epoch)) in enumerate(zip(paths, columns)):
        prefix, marker = "" if len(paths) == 1 else os.path.basename(path) + ", ", "o" if len(epoch) == 1 else ""  # one epoch is no line
        for k, values in enumerate((train, validation)):
            axes[0].plot(epoch, values, marker=marker, color=_COLOURS[k if len(paths) == 1 else i], linestyle=_DASHES[1 - k],
                         label=prefix + ("training", "validation")[k])
        axes[1].step(epoch, rate, marker=marker, where="post", color="black" if len(paths) == 1 else _COLOURS[i])
    axes[0].set(yscale="log", ylabel="loss (log-cosh)")
    axes[1].set(yscale="log", ylabel="learning rate", xlabel="epoch", xlim=(0, None))
    return _finish(axes, "Training", "mean loss of each epoch; learning rate of the first layer")


def sizes(scores_csv: PathLike, *, figure: Any = None) -> Any:
    """JOD over size, with a line of the best JOD up to each size for each map: scores of `nqm batch` of a list with the columns map and size."""
    table = _Table(scores_csv)
    x, y, groups = table.numbers("size"), table.numbers("jod"), table.groups("map")
    ax = _figure(figure, 520, 340).add_subplot()
    for k, rows in enumerate(groups.values()):
        order = np.argsort(x[rows], kind="stable")
        ax.step(x[rows][order], np.maximum.accumulate(y[rows][order]), where="post", color=_COLOURS[k])
    _points(ax, x, y, groups, 5)
    ticks = 2.0 ** np.arange(*np.round(np.log2(np.clip([x.min() / 1.4, 3 * x.max()], 2**-10, 2**20))))
    ax.set(xscale="log", xticks=ticks, xticklabels=["%g" % t for t in ticks], xlabel="bits per texel of the map", ylabel="JOD")
    ax.minorticks_off()
    return _finish(ax, "Which size is enough", "")


# ---- the command ----------------------------------------------------------------------------------------------------

_KINDS: Dict[str, Tuple[Callable[..., Any], str, str, str]] = {
    "slice": (slice, "BRDF...", "slices and polar lobes of up to 8 BRDFs", "slice sgd:nickel 'My fit=ward:nickel' -o slice.svg"),
    "attribution": (attribution, "REF TEST", "where two BRDFs differ, over (theta_h, theta_d)", "attribution sgd:nickel ward:nickel -o where.png"),
    "directions": (directions, "[MODEL|FILE.csv]", "the sampling directions", "directions default -o directions.pdf"),
    "network": (network, "[MODEL]", "the layers of a model", "network paper -o network.svg"),
    "curve": (curve, "LABELS.csv", "JOD against Delta-E ITP, with the fitted curve", "curve labels.csv -o curve.svg"),
    "bars": (bars, "EVAL.json", "Spearman correlations, or predicted choices, with 95 %% intervals", "bars eval.json -o bars.svg"),
    "scatter": (scatter, "PAIRS.csv", "predicted JOD against the label or human score", "scatter pairs.csv --predictor rmse -o scatter.png"),
    "loss": (loss, "LOG.csv...", "losses and learning rate of up to 8 trainings", "loss first.csv second.csv -o loss.svg"),
    "sizes": (sizes, "SCORES.csv", "JOD over the column size, a line for each map", "sizes scores.csv -o sizes.svg"),
}


def _parser() -> argparse.ArgumentParser:
    examples = "examples:\n" + "\n".join("  python3 -m nqm.plot " + kind[3] for kind in _KINDS.values())
    parser = argparse.ArgumentParser("python3 -m nqm.plot", description="Draw a chart as .svg, .pdf or .png. `-` is a table on standard input.",
                                     epilog=examples + "\n\nexit codes are those of the tool nqm (doc/cli.md)", formatter_class=argparse.RawDescriptionHelpFormatter)
    kinds = parser.add_subparsers(dest="kind", metavar="KIND", required=True)
    for name, (_, inputs, words, example) in _KINDS.items():
        kind = kinds.add_parser(name, help="%s: %s" % (inputs, words), description=words.replace("%%", "%"), epilog="example: python3 -m nqm.plot " + example,
                               formatter_class=argparse.RawDescriptionHelpFormatter)
        count = "+" if inputs.endswith("...") else "?" if inputs.startswith("[") else 2 if " " in inputs else 1
        kind.add_argument("inputs", nargs=count, metavar=inputs.split()[0].strip("[].") if count != 2 else "BRDF", help=inputs)
        kind.add_argument("-o", "--output", required=True, metavar="FILE.svg|.pdf|.png", help="the drawing")
        kind.add_argument("--title", help="instead of the automatic one; '': none")
        kind.add_argument("--size", nargs=2, type=int, metavar=("W", "H"), help="CSS pixels (1/96 inch), 200 to 4000 each")
        kind.add_argument("--scale", type=float, default=2, help="pixels of a .png per CSS pixel, 0.5 to 8 [2]")
        if name == "scatter":
            kind.add_argument("--predictor", help="column to draw [the first model]")
        for option, default, what in (("theta_d_deg", 0, "theta_d of the slice over theta_h"), ("phi_d_deg", 90, "phi_d of the slice over theta_h"),
                                      ("azimuth_deg", 0, "of the light from the tangent")) if name == "slice" else ():
            kind.add_argument("--" + option[:-4].replace("_", "-"), dest=option, type=float, default=default, metavar="DEG", help="%s, degrees [%d]" % (what, default))
    return parser


def _save(figure: Any, path: str, scale: float) -> None:
    """Write the file as a whole or not at all, with the same bytes for the same figure."""
    import matplotlib

    kind, part, buffer = path.lower()[-3:], "%s.%d.part" % (path, os.getpid()), io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "nqm", "pdf.fonttype": 42}):
        figure.savefig(buffer, format=kind, dpi=96 * scale, metadata={"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind))
    data = buffer.getvalue()
    for i, name in enumerate(re.findall(rb'<clipPath id="(\w+)"', data)):  # matplotlib makes some of these names from addresses
        data = data.replace(name, b"clip%d" % i)
    try:
        with open(part, "xb") as file:
            file.write(data)
        os.replace(part, path)
    except OSError as error:
        raise Error("%s: cannot write: %s" % (path, error.strerror), Status.IO) from None
    finally:
        if os.path.exists(part):
            os.unlink(part)


def _run(given: argparse.Namespace) -> None:
    if not re.fullmatch(r".*[^/]\.(svg|pdf|png)", given.output, re.I):
        raise ValueError("the drawing must be a FILE.svg, FILE.pdf or FILE.png, not -o %s" % given.output)
    if not 0.5 <= given.scale <= 8 or not all(200 <= side <= 4000 for side in given.size or ()):
        raise ValueError("--scale is 0.5 to 8, and both sides of --size are 200 to 4000")
    inputs: Any = given.inputs if isinstance(given.inputs, list) else [given.inputs] if given.inputs else []
    options = {key: value for key, value in vars(given).items() if key.endswith("_deg") or key == "predictor"}
    if given.kind in ("slice", "attribution"):
        names = [None if os.path.exists(i) else re.match(r"[^=:/]+(?==.)", i) for i in inputs]  # NAME=BRDF, unless that is a file
        inputs = [i[name.end() + 1:] if name else i for i, name in zip(inputs, names)]
        options["names"] = [name and name[0] for name in names]
    figure = np.ravel(_KINDS[given.kind][0](*([inputs] if given.kind in ("slice", "loss") else inputs), **options))[0].figure
    if given.title is not None:
        figure.suptitle(given.title, fontsize=12)
    if given.size:
        figure.set_size_inches(*np.array(given.size) / 96)
    _save(figure, given.output, given.scale)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the command; returns its exit code."""
    try:
        _run(_parser().parse_args(arguments))
    except KeyboardInterrupt:
        return 130
    except (Error, ImportError, ValueError) as error:
        print("python3 -m nqm.plot: %s" % error, file=sys.stderr)
        return error.code if isinstance(error, Error) else 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
