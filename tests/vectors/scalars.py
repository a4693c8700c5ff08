# SPDX-License-Identifier: MIT
"""The scalar features of the pair in metrics_pair.csv, by NumPy in double from the formulas of doc/training.md:
scalars_expected.csv."""
import csv

import numpy

with open("metrics_pair.csv", newline="", encoding="utf-8") as file:
    rows = list(csv.DictReader(line for line in file if not line.startswith("#")))


def columns(*names):
    return numpy.array([[float(row[name]) for name in names] for row in rows])


degrees, ref, test = columns("theta_h", "theta_d", "phi_d"), columns("ref_r", "ref_g", "ref_b"), columns("test_r", "test_g", "test_b")
used = columns("used")[:, 0] > 0
DARK = 0.003


def turned(axis, angle):
    c, s = numpy.cos(angle), numpy.sin(angle)
    return numpy.array([[c, 0, s], [0, 1, 0], [-s, 0, c]] if axis == "y" else [[c, -s, 0], [s, c, 0], [0, 0, 1]])


def cosines(theta_h, theta_d, phi_d):
    """cos(theta_i) cos(theta_o) of the rotated difference vector and its mirror image about the half vector."""
    up = numpy.array([0, 0, 1])
    half = turned("y", theta_h) @ up
    wi = turned("y", theta_h) @ turned("z", phi_d) @ turned("y", theta_d) @ up
    wo = 2 * (wi @ half) * half - wi
    return max(wi[2], 0) * max(wo[2], 0)


c = numpy.array([cosines(*numpy.radians(row)) for row in degrees])


def lum(rgb):
    return rgb @ [0.2126, 0.7152, 0.0722]


def size(x):
    return numpy.log(x + 1e-3)


def opponents(x):
    return x[..., 0] - x[..., 1], x[..., 2] - (x[..., 0] + x[..., 1]) / 2


def rms(x):
    return numpy.sqrt(numpy.mean(numpy.square(x))) if len(x) else 0.0


def ratio(weight, a, b):
    """Log ratios of weighted sums: that of luminance, and the opponent combinations of those of the channels."""
    if not weight.sum() > 0:
        return 0.0, 0.0, 0.0
    mean_a, mean_b = weight @ a / weight.sum(), weight @ b / weight.sum()
    logs = numpy.log((mean_b + DARK) / (mean_a + DARK))
    return (numpy.log((lum(mean_b) + DARK) / (lum(mean_a) + DARK)), *opponents(logs))


def scalars(keep):
    a, b, w, (th, td) = ref[keep], test[keep], c[keep], degrees[keep].T[:2]
    d, l_ref = numpy.log(b + DARK) - numpy.log(a + DARK), numpy.log(lum(a) + DARK)
    l = numpy.log(lum(b) + DARK) - l_ref
    u, v = opponents(d)
    ones = numpy.ones(len(a))
    out = {}
    for name, f in {"e": lambda x: x, "_crwe": lambda x: numpy.cbrt(w[:, None] * x), "_loge": numpy.log1p,
                    "_logwe": lambda x: numpy.log1p(w[:, None] * x)}.items():
        out["log_rms" + name] = numpy.log(rms((f(b) - f(a)).ravel()) + 1e-4)
        out["log_ma" + name] = numpy.log(numpy.mean(numpy.abs(f(b) - f(a))) + 1e-4)
    out["log_log_diff"] = numpy.log(numpy.mean(numpy.abs(d)) + 1e-4)
    out["rms"] = size(rms(d.ravel()))
    out["max"] = size(numpy.max(numpy.abs(l)))
    out["tail"] = size(numpy.mean(l**4) ** 0.25)
    out["bulk"] = size(numpy.mean(numpy.sqrt(numpy.abs(l))) ** 2)
    out["bias"] = numpy.mean(l)
    out["shape"] = size(numpy.std(l))
    edges = [0, 2, 5, 15, 35, 90.1]
    zones = [(th >= lo) & (th < hi) for lo, hi in zip(edges, edges[1:])]
    names = ["0_2", "2_5", "5_15", "15_35", "35_90"]
    for name, zone in zip(names, zones):
        out["bias_" + name] = ratio(zone * 1.0, a, b)[0]
    for name, zone in zip(names, zones):
        out["rms_" + name] = size(rms(l[zone]))
    grazing = w < 0.25
    out["bias_grazing"] = numpy.mean(l[grazing])
    out["rms_grazing"] = size(rms(l[grazing]))
    out["width"] = ratio((th < 5) * 1.0, a, b)[0] - ratio((th >= 5) * 1.0, a, b)[0]
    out["chroma"] = size(numpy.sqrt(numpy.mean(u**2 + v**2)))
    out["chroma_rg"], out["chroma_b"] = numpy.mean(u), numpy.mean(v)
    energy = ratio(w, a, b)
    out["energy"], out["energy_chroma"] = energy[0], size(numpy.hypot(*energy[1:]))
    out["peak"] = numpy.log((lum(b).max() + DARK) / (lum(a).max() + DARK))
    cells = [zone & (td >= lo) & (td < hi) for zone in zones for lo, hi in ((0, 30), (30, 60), (60, 90.1))]
    smooth = numpy.array([ratio(cell * 1.0, a, b) for cell in cells])
    share = numpy.array([cell.sum() for cell in cells]) / len(a)
    out["smooth"] = size(numpy.sqrt(share @ smooth[:, 0] ** 2))
    out["smooth_chroma"] = size(numpy.sqrt(share @ (smooth[:, 1] ** 2 + smooth[:, 2] ** 2)))
    out["ref_level"] = numpy.mean(l_ref)
    out["ref_energy"] = numpy.log(w @ lum(a) / w.sum() + DARK)
    out["ref_peak"] = numpy.log(lum(a).max() + DARK) - numpy.mean(l_ref)
    out["ref_spread"] = numpy.std(l_ref)
    out["ref_colour"] = numpy.sqrt(numpy.mean(numpy.square(opponents(numpy.log(a + DARK))).sum(axis=0)))
    for name in ("", "_i", "_t", "_p", "_contrast", "_structure"):
        out["estimate" + name] = 0.0  # without a transport matrix
    return out


with open("scalars_expected.csv", "w", encoding="utf-8") as out:
    out.write(f"# made by scalars.py: numpy {numpy.__version__}\nscalar,all,used\n")
    everything, kept = scalars(numpy.ones(len(rows), bool)), scalars(used)
    for name in everything:
        out.write(f"{name},{float(everything[name])!r},{float(kept[name])!r}\n")
