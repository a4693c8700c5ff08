#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Which compression of each map is enough: write quantised copies of the maps of a folder (8-bit PNG, as examples/maps.py writes them),
and a list for `nqm batch`, with the bits per texel of the map. The standard library only.

usage: texture_sizes.py FOLDER OUTPUT      writes OUTPUT/*.png and OUTPUT/sizes.csv

  size      half and a quarter of the size (means)
  jpeg-Q    DCT of 8 x 8 texels, quantised by the luminance table of JPEG (ITU-T T.81, K.1) at quality Q; the size is that of the
            coefficients by zlib
  bc1 ...   blocks with two ends, of so many bits, along the line from the darkest to the brightest texel, and so many levels between:
            as BC1, BC5 (a channel each, of normals x and y), BC7 and ASTC 8 x 8 nearly have them; their nominal size"""
import math
import os
import struct
import sys
import zlib

KEYS = {"base_color": ("steel_Color.png", "jpeg bc1 bc7 astc size"), "roughness": ("steel_Roughness.png", "jpeg bc1 bc5 size"),
        "metallic": ("steel_Metalness.png", "jpeg bc1 bc5 size"), "normal": ("steel_NormalGL.png", "jpeg bc5 astc size")}
BLOCKS = {"bc1": (4, 4, 5, 4), "bc5": (4, 8, 8, 4), "bc7": (4, 16, 7, 8), "astc": (8, 8, 8, 2)}  # side, levels, bits, bits per texel
TABLE = [16, 11, 10, 16, 24, 40, 51, 61, 12, 12, 14, 19, 26, 58, 60, 55, 14, 13, 16, 24, 40, 57, 69, 56, 14, 17, 22, 29, 51, 87, 80, 62,
         18, 22, 37, 56, 68, 109, 103, 77, 24, 35, 55, 64, 81, 104, 113, 92, 49, 64, 78, 87, 103, 121, 120, 101, 72, 92, 95, 98, 112, 100, 103, 99]
DCT = [[math.sqrt((1 if k else 0.5) / 4) * math.cos((2 * i + 1) * k * math.pi / 16) for i in range(8)] for k in range(8)]


def read_png(path):
    """Side, channels, and the planes of a square PNG without filters."""
    data, at, packed = open(path, "rb").read(), 8, b""
    side, colour = struct.unpack(">I5xB", data[16:26])
    while at < len(data):
        n = struct.unpack(">I", data[at:at + 4])[0]
        packed += data[at + 8:at + 8 + n] if data[at + 4:at + 8] == b"IDAT" else b""
        at += n + 12
    n, raw = (3 if colour == 2 else 1), zlib.decompress(packed)
    rows = [raw[y * (side * n + 1) + 1:(y + 1) * (side * n + 1)] for y in range(side)]
    return side, [[list(row[c::n]) for row in rows] for c in range(n)]


def write_png(path, planes):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    side = len(planes[0])
    rows = (b"\0" + bytes(max(0, min(255, round(p[y][x]))) for x in range(side) for p in planes) for y in range(side))
    head = struct.pack(">IIBBBBB", side, side, 8, 2 if len(planes) == 3 else 0, 0, 0, 0)
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"".join(rows))) + chunk(b"IEND", b""))


def shrink(planes, n):
    side = len(planes[0]) // n
    return [[[sum(p[n * y + j][n * x + i] for j in range(n) for i in range(n)) / n / n for x in range(side)] for y in range(side)]
            for p in planes]


def each_block(planes, side, change):
    """change: from the texels of a block, (side * side) lists of channels, to others."""
    result = [[row[:] for row in p] for p in planes]
    for y in range(0, len(planes[0]), side):
        for x in range(0, len(planes[0]), side):
            places = [(y + j, x + i) for j in range(side) for i in range(side)]
            for (v, u), texel in zip(places, change([[p[v][u] for p in planes] for v, u in places])):
                for c, value in enumerate(texel):
                    result[c][v][u] = value
    return result


def quantise(levels, bits):
    step = 255 / (2**bits - 1)

    def change(texels):
        ends = [[round(v / step) * step for v in end(texels, key=sum)] for end in (min, max)]
        line = [b - a for a, b in zip(*ends)]
        length = sum(d * d for d in line) or 1
        at = [sum((v - a) * d for v, a, d in zip(t, ends[0], line)) / length for t in texels]
        at = [round(max(0, min(1, s)) * (levels - 1)) / (levels - 1) for s in at]
        return [[a + s * d for a, d in zip(ends[0], line)] for s in at]
    return change


def jpeg(planes, quality):
    """The planes, and bits per texel."""
    scale = (5000 / quality if quality < 50 else 200 - 2 * quality) / 100
    table, found = [max(1, round(t * scale)) for t in TABLE], bytearray()

    def change(texels):
        v = [[texels[8 * j + i][0] - 128 for i in range(8)] for j in range(8)]
        half = [[sum(DCT[k][i] * row[i] for i in range(8)) for k in range(8)] for row in v]
        level = [round(sum(DCT[l][j] * half[j][k] for j in range(8)) / table[8 * l + k]) for l in range(8) for k in range(8)]
        found.extend(x & 255 for x in level)
        half = [[sum(DCT[l][j] * level[8 * l + k] * table[8 * l + k] for l in range(8)) for k in range(8)] for j in range(8)]
        return [[128 + sum(DCT[k][i] * half[j][k] for k in range(8))] for j in range(8) for i in range(8)]
    result = [each_block([p], 8, change)[0] for p in planes]
    return result, 8 * len(zlib.compress(bytes(found), 9)) / len(planes[0]) ** 2


def versions(planes, kinds):
    for kind in kinds.split():
        if kind == "size":
            for n in (4, 2):
                yield "size-%d" % n, shrink(planes, n), 8 * len(planes) / n / n
        elif kind == "jpeg":
            for quality in (10, 50, 90):
                yield ("jpeg-%d" % quality, *jpeg(planes, quality))
        else:
            side, levels, bits, size = BLOCKS[kind]
            parts = [[p] for p in planes] if kind == "bc5" else [planes]
            yield kind, [q for part in parts for q in each_block(part, side, quantise(levels, bits))], size * min(len(parts), 2)


def main(folder, output):
    os.makedirs(output, exist_ok=True)
    with open(os.path.join(output, "sizes.csv"), "w") as out:
        out.write("map,kind,size,reference,test\n")
        for key, (name, kinds) in KEYS.items():
            planes = read_png(os.path.join(folder, name))[1]
            rows = []
            for kind, changed, size in versions(planes, kinds):
                path = os.path.join(output, "%s-%s.png" % (key, kind))
                write_png(path, changed)
                maps = ["%s=%s" % (k, path if k == key else os.path.join(folder, n)) for k, (n, _) in KEYS.items()]
                rows.append((size, "%s,%s,%.3g,%s,maps:%s\n" % (key, kind, size, folder, ";".join(maps))))
            out.writelines(row for _, row in sorted(rows))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
