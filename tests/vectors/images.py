# SPDX-License-Identifier: MIT
"""Small high-dynamic-range pictures, encoded byte by byte from the format specifications (PNG: ISO 15948; Radiance:
Ward, Graphics Gems II; OpenEXR: openexr.com/en/latest/OpenEXRFileLayout.html), and their pixels. Writes
the folder images and images.safetensors. Usage: python3 images.py"""
import os
import struct
import zlib

import numpy as np

import store

WIDTH, HEIGHT = 11, 6


def rgbe_picture():
    """(HEIGHT, WIDTH, 4): runs, single values, a zero exponent, the extremes of the exponent."""
    x, y = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    rgbe = np.stack([20 * x + y, 255 - 7 * x, 31 * y, 128 + y - x // 4], -1).astype(np.uint8)
    rgbe[2, 3:9] = (17, 200, 33, 131)
    rgbe[3, :] = (9, 8, 7, 120)
    rgbe[4, 0] = (50, 60, 70, 0)
    rgbe[4, 1] = (255, 128, 1, 200)
    rgbe[5, 10] = (255, 255, 255, 60)
    return rgbe


def png(rgbe):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + row.tobytes() for row in rgbe)
    header = struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


HDR_HEADER = b"#?RADIANCE\n# a comment\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (HEIGHT, WIDTH)


def hdr_flat(rgbe):
    return HDR_HEADER + rgbe.tobytes()


def hdr_newer(rgbe):
    out = bytearray(HDR_HEADER)
    for row in rgbe:
        out += bytes([2, 2, WIDTH >> 8, WIDTH & 255])
        for channel in row.T:
            x = 0
            while x < WIDTH:
                n = 1
                while x + n < WIDTH and channel[x + n] == channel[x]:
                    n += 1
                if n >= 3:
                    out += bytes([128 + n, channel[x]])
                else:
                    n = 1
                    while x + n < WIDTH and n < 4 and channel[x + n] != channel[x + n - 1]:
                        n += 1
                    out += bytes([n]) + channel[x:x + n].tobytes()
                x += n
    return bytes(out)


def hdr_older(rgbe):
    out = bytearray(HDR_HEADER)
    for row in rgbe:
        x = 0
        while x < WIDTH:
            out += row[x].tobytes()
            n = 0
            while x + n + 1 < WIDTH and (row[x + n + 1] == row[x]).all():
                n += 1
            if n:
                out += bytes([1, 1, 1, n])
            x += n + 1
    return bytes(out)


def exr_picture():
    """(HEIGHT, WIDTH, 3) of values that half precision represents exactly."""
    x, y = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    return np.stack([0.25 * x + y, 2.0 ** (y - x), np.where(x > 6, 0.0, 1024.0 + 2 * y)], -1)


def exr(picture, names, dtype, compression, origin=(0, 0), tile=None):
    kind = {np.float16: 1, np.float32: 2}[dtype]
    codes = {"none": 0, "zips": 2, "zip": 3}
    planes = {name: picture[..., i].astype(dtype) for i, name in enumerate(names)}
    window = (origin[0], origin[1], origin[0] + WIDTH - 1, origin[1] + HEIGHT - 1)

    def attribute(name, kind_name, data):
        return name + b"\0" + kind_name + b"\0" + struct.pack("<i", len(data)) + data

    channels = b"".join(n.encode() + b"\0" + struct.pack("<iBBBBii", kind, 0, 0, 0, 0, 1, 1) for n in sorted(names)) + b"\0"
    head = struct.pack("<ii", 20000630, 2 | (0x200 if tile else 0))
    head += attribute(b"channels", b"chlist", channels)
    head += attribute(b"compression", b"compression", bytes([codes[compression]]))
    head += attribute(b"dataWindow", b"box2i", struct.pack("<4i", *window))
    head += attribute(b"displayWindow", b"box2i", struct.pack("<4i", *window))
    head += attribute(b"lineOrder", b"lineOrder", b"\0")
    head += attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
    head += attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0))
    head += attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1))
    if tile:
        head += attribute(b"tiles", b"tiledesc", struct.pack("<IIB", tile[0], tile[1], 0))
    head += b"\0"

    def pack(rows, columns):
        raw = b"".join(planes[n][y, columns].tobytes() for y in rows for n in sorted(names))
        if compression == "none":
            return raw
        half = (len(raw) + 1) // 2
        mixed = bytearray(len(raw))
        mixed[:half], mixed[half:] = raw[0::2], raw[1::2]
        delta = bytes([mixed[0]]) + bytes((b - a + 128) & 255 for a, b in zip(mixed, mixed[1:]))
        packed = zlib.compress(delta, 9)
        return packed if len(packed) < len(raw) else raw

    chunks = []
    if tile:
        for ty in range(0, HEIGHT, tile[1]):
            for tx in range(0, WIDTH, tile[0]):
                data = pack(range(ty, min(ty + tile[1], HEIGHT)), slice(tx, min(tx + tile[0], WIDTH)))
                chunks.append(struct.pack("<5i", tx // tile[0], ty // tile[1], 0, 0, len(data)) + data)
    else:
        lines = 16 if compression == "zip" else 1
        for y in range(0, HEIGHT, lines):
            data = pack(range(y, min(y + lines, HEIGHT)), slice(None))
            chunks.append(struct.pack("<2i", y + origin[1], len(data)) + data)
    place = len(head) + 8 * len(chunks)
    table = b""
    for chunk in chunks:
        table += struct.pack("<Q", place)
        place += len(chunk)
    return head + table + b"".join(chunks)


def main():
    rgbe = rgbe_picture()
    scale = np.exp2(rgbe[..., 3:].astype(float) - 128)
    picture = exr_picture()
    grey = picture[..., :1]
    alpha = np.arange(WIDTH * HEIGHT).reshape(HEIGHT, WIDTH, 1) / 64
    rgba, grey_alpha = [np.concatenate([x, alpha], -1) for x in (picture, grey)]
    files = {"rgbe.png": png(rgbe), "flat.hdr": hdr_flat(rgbe), "newer.hdr": hdr_newer(rgbe), "older.hdr": hdr_older(rgbe),
             "float.exr": exr(picture, "RGB", np.float32, "none", origin=(-3, 7)),
             "half.exr": exr(picture, "RGB", np.float16, "zip", origin=(5, -2)),
             "tiled.exr": exr(picture, "RGB", np.float16, "zips", tile=(4, 4)),
             "grey.exr": exr(grey, "Y", np.float32, "zips"),
             "rgba.exr": exr(rgba, "RGBA", np.float16, "zip", origin=(1, 2)),
             "rgba-float.exr": exr(rgba, "RGBA", np.float32, "zips", tile=(8, 8)),
             "grey-alpha.exr": exr(grey_alpha, "YA", np.float32, "zips")}
    for name, data in files.items():
        with open(os.path.join(store.HERE, "images", name), "wb") as file:
            file.write(data)
    pixels = {"png": rgbe[..., :3] / 255.0 * scale, "hdr": np.where(rgbe[..., 3:] == 0, 0, rgbe[..., :3] / 256.0 * scale), "exr": picture,
              "exr_grey": np.repeat(grey, 3, axis=2)}
    store.safetensors("images.safetensors", {name: x.astype("f4").astype("f8") for name, x in pixels.items()},
                      {"made_by": store.made_by("images.py", "zlib " + zlib.ZLIB_VERSION)})


main()
