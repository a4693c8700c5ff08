#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Make maps of a rusty steel plate for the pages and the demo: FOLDER/steel (as ambientCG names them), FOLDER/export, where the
roughness is squared and the green channel of the normal map is flipped, and FOLDER/half, of half the size. The standard library only.

usage: maps.py FOLDER [SIDE]      SIDE: texels, even; 128"""
import math
import os
import random
import struct
import sys
import zlib

SIDE = int(sys.argv[2]) if len(sys.argv) > 2 else 128


def write_png(path, n, rows):
    """rows: of n * SIDE bytes."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    head = struct.pack(">IIBBBBB", len(rows[0]) // n, len(rows), 8, {1: 0, 3: 2}[n], 0, 0, 0)
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) +
                  chunk(b"IDAT", zlib.compress(b"".join(b"\0" + bytes(row) for row in rows))) + chunk(b"IEND", b""))


def noise(seed, cells):
    """Smooth noise in 0..1 that repeats at the edges, as a function of texel coordinates."""
    rng = random.Random(seed)
    grid = [[rng.random() for _ in range(cells)] for _ in range(cells)]

    def at(x, y):
        u, v = x * cells / SIDE, y * cells / SIDE
        i, j = int(u), int(v)
        s, t = (3 - 2 * (u - i)) * (u - i) ** 2, (3 - 2 * (v - j)) * (v - j) ** 2
        a, b, c, d = (grid[(j + q) % cells][(i + p) % cells] for q in (0, 1) for p in (0, 1))
        return (a * (1 - s) + b * s) * (1 - t) + (c * (1 - s) + d * s) * t
    return at


def byte(v):
    return max(0, min(255, round(255 * v)))


def srgb(v):
    return 12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055


def plate():
    """The maps as lists of rows of values: color, roughness, metalness, normal."""
    rust, fine, scratch = noise(1, 6), noise(2, 32), noise(3, 64)
    maps = {"Color": [], "Roughness": [], "Metalness": [], "NormalGL": []}
    for y in range(SIDE):
        rows = {name: [] for name in maps}
        for x in range(SIDE):
            share = max(0.0, min(1.0, 6 * (0.7 * rust(x, y) + 0.3 * fine(x, y)) - 3.2))
            colour = [srgb(s + share * (r - s)) for s, r in zip((0.56, 0.55, 0.53), (0.3, 0.1, 0.035))]
            rows["Color"] += colour
            rows["Roughness"].append((0.3 + 0.12 * scratch(x, y)) * (1 - share) + share * (0.75 + 0.15 * fine(x, y)))
            rows["Metalness"].append(1 - share)
            slope = [2.5 * share * (fine(x + p, y + q) - fine(x, y)) for p, q in ((1, 0), (0, 1))]
            length = math.sqrt(slope[0] ** 2 + slope[1] ** 2 + 1)
            rows["NormalGL"] += [(-slope[0] / length + 1) / 2, (slope[1] / length + 1) / 2, (1 / length + 1) / 2]
        for name in maps:
            maps[name].append(rows[name])
    return maps


def half(rows, n):
    """Means of blocks of two by two texels."""
    return [[(a[2 * n * x + c] + a[2 * n * x + n + c] + b[2 * n * x + c] + b[2 * n * x + n + c]) / 4
             for x in range(len(a) // n // 2) for c in range(n)] for a, b in zip(rows[::2], rows[1::2])]


def main():
    maps = plate()
    export = dict(maps, Roughness=[[v * v for v in row] for row in maps["Roughness"]],
                  NormalGL=[[1 - v if i % 3 == 1 else v for i, v in enumerate(row)] for row in maps["NormalGL"]])
    small = {name: half(rows, 1 if name in ("Roughness", "Metalness") else 3) for name, rows in maps.items()}
    for name, kinds in (("steel", maps), ("export", export), ("half", small)):
        folder = os.path.join(sys.argv[1], name)
        os.makedirs(folder, exist_ok=True)
        for kind, rows in kinds.items():
            n = 1 if kind in ("Roughness", "Metalness") else 3
            write_png(os.path.join(folder, f"steel_{kind}.png"), n, [[byte(v) for v in row] for row in rows])


main()
