# SPDX-License-Identifier: MIT
"""Golden values of the self-test by NumPy, from the formulas of the cited papers and the tables of presets/: writes
presets/selftest_golden.h. Independent of the library: directions are computed by a rotation matrix, angles by
arccos."""
import csv
import math

import numpy


def preset(table, name):
    with open(f"../../presets/{table}.csv") as f:
        rows = csv.DictReader(line for line in f if not line.startswith("#"))
        row = next(r for r in rows if r["name"] == name)
    return lambda key, k: float(row[f"{key}_{'rgb'[k]}" if f"{key}_r" in row else key])


def directions(theta_h, theta_d, phi_d):
    d = numpy.array([math.sin(theta_d) * math.cos(phi_d), math.sin(theta_d) * math.sin(phi_d), math.cos(theta_d)])
    turn = numpy.array([[math.cos(theta_h), 0, math.sin(theta_h)], [0, 1, 0], [-math.sin(theta_h), 0, math.cos(theta_h)]])
    wi = turn @ d
    h = turn @ numpy.array([0.0, 0.0, 1.0])
    return wi, 2 * (wi @ h) * h - wi


def ward(p, wi, wo, theta_h, theta_d):
    """Ward 1992, isotropic."""
    return [p("kd", k) / math.pi + p("ks", k) * math.exp(-math.tan(theta_h) ** 2 / p("alpha", k) ** 2)
            / (4 * math.pi * p("alpha", k) ** 2 * math.sqrt(wi[2] * wo[2])) for k in range(3)]


def sgd(p, wi, wo, theta_h, theta_d):
    """Bagher et al. 2012."""
    def g(theta, k):
        x = theta - p("theta0", k)
        if x <= 0:
            return 1
        return min(1, max(0, 1 + p("lambda", k) * (1 - math.exp(p("c", k) * x ** p("k", k)))))

    out = []
    for k in range(3):
        t = p("alpha", k) + math.tan(theta_h) ** 2 / p("alpha", k)
        d = p("K", k) * math.exp(-t) / (math.pi * t ** p("p", k) * math.cos(theta_h) ** 4)
        f = p("f0", k) - p("f1", k) * math.cos(theta_d) + (1 - p("f0", k)) * (1 - math.cos(theta_d)) ** 5
        shadow = g(math.acos(wi[2]), k) * g(math.acos(wo[2]), k)
        out.append(p("kd", k) / math.pi + p("ks", k) / math.pi * d * f * shadow / (wi[2] * wo[2]))
    return out


B = (-14.11196939758611, -0.47364347065458806, -0.21479944748134167)
with open("../../presets/selftest_golden.h", "w") as out:
    out.write("/* SPDX-License-Identifier: MIT\n *\n * Golden values of the self-test. "
              f"Made by tests/vectors/selftest.py (numpy {numpy.__version__}): do not edit.\n */\n"
              "#ifndef NQM_PRESETS_SELFTEST_GOLDEN_H\n#define NQM_PRESETS_SELFTEST_GOLDEN_H\n/* clang-format off */\n\n"
              "/* f_r of presets; theta_h, theta_d, phi_d in degrees. */\n"
              "static const struct {\n    const char *spec;\n    double hd_deg[3], rgb[3];\n} golden_brdfs[] = {\n")
    for model, f in (("sgd", sgd), ("ward", ward)):
        for material, places in (("nickel", ((0.5, 10, 20), (8, 40, 100), (30, 25, 60))),
                                 ("blue-rubber", ((2, 5, 170), (45, 20, 90)))):
            for place in places:
                theta_h, theta_d, phi_d = numpy.radians(place)
                wi, wo = directions(theta_h, theta_d, phi_d)
                rgb = f(preset(model, material), wi, wo, theta_h, theta_d)
                out.write(f'    {{"{model}:{material}", {{{", ".join(f"{v:g}" for v in place)}}}, '
                          f'{{{", ".join(f"{v:.15g}" for v in rgb)}}}}},\n')
    out.write("};\n\n/* The published curve: Delta-E ITP, JOD. */\nstatic const double golden_jod[][2] = {\n")
    for delta_e in (0.1, 1, 3, 10, 30, 100, 300):
        jod = 10 * (1 - 1 / (1 + numpy.exp(B[0] * (-(delta_e ** B[2]) - B[1]))))
        out.write(f"    {{{delta_e:g}, {jod:.15g}}},\n")
    out.write("};\n\n#endif\n")
