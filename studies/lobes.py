#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How exact pictures and labels of a lobe of any width are: a white GGX metal of width alpha on three shapes under four lights, with the
default number of light directions against the largest. Prints a table for doc/labels.md.

usage: PYTHONPATH=python studies/lobes.py BUNNY.ply [--lights N] [--points N]
"""
import argparse
import sys

import numpy as np

import nqm

ALPHAS = (0, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1)
LIGHTS = ("sun", "overcast", "studio", "interior")


def metal(alpha):
    return f"gltf:base_color=1,1,1;metallic=1;roughness={alpha ** 0.5:g}"


def errors(scene, exact, alpha):
    """Relative error of the mean radiance, mean relative error of a point, error of the label against a lobe wider by a half."""
    a, b = scene.points(metal(alpha)).sum(axis=1), exact.points(metal(alpha)).sum(axis=1)
    w = exact.weights
    other = metal(min(1.5 * alpha, 1) if alpha else 0.001) if alpha < 1 else metal(0.7)
    labels = [s.label(metal(alpha), other).jod for s in (scene, exact)]
    return abs((w * a).sum() / (w * b).sum() - 1), (w * abs(a - b)).sum() / (w * b).sum(), abs(labels[0] - labels[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bunny")
    parser.add_argument("--lights", type=int, default=65536)
    parser.add_argument("--points", type=int, default=96)
    arguments = parser.parse_args()
    shapes = ("sphere", "blob", arguments.bunny)
    table = np.zeros((len(ALPHAS), len(shapes), len(LIGHTS), 3))
    for s, shape in enumerate(shapes):
        for l, light in enumerate(LIGHTS):
            options = dict(shape=shape, light=light, n_points=arguments.points)
            scene, exact = nqm.Scene(**options), nqm.Scene(n_lights=arguments.lights, **options)
            for i, alpha in enumerate(ALPHAS):
                table[i, s, l] = errors(scene, exact, alpha)
            print(f"{light}, {shape}", file=sys.stderr, flush=True)
    print("| alpha | mean radiance: largest error | a point: mean error, largest of the scenes | label: mean, largest error, JOD |")
    print("|---|---|---|---|")
    for alpha, row in zip(ALPHAS, table):
        print(f"| {alpha:g} | {100 * row[..., 0].max():.2f} % | {100 * row[..., 1].max():.1f} % "
              f"| {row[..., 2].mean():.3f}, {row[..., 2].max():.3f} |")


if __name__ == "__main__":
    main()
