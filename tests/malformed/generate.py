#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""generate.py SEEDS FOLDER - writes broken files of every format that nqm reads, and verdicts.tsv with what each must get.

SEEDS is a folder with the valid files of tests/tools (make_brdf_files, tiny_model, tiny_dataset); all other formats are written here.
verdicts.tsv has one line per file: its name, the kind of reader (open_files.c), the exit code of nqm, and a part of the message.
Standard library only. No measured data is used.
"""
import hashlib
import json
import os
import struct
import sys
import zipfile
import zlib

out = ""
verdicts = []


def bad(name, data, kind, code=4, says="byte"):
    """Write a broken file, and the verdict that it must get: the exit code, and the place or the reason."""
    path = os.path.join(out, name)
    with open(path, "wb") as f:
        f.write(data if isinstance(data, bytes) else data.encode())
    verdicts.append((name, kind, code, says))


def seed(name):
    with open(os.path.join(sys.argv[1], name), "rb") as f:
        return f.read()


def cuts(stem, ending, data, places, kind, code=4, says="byte"):
    """Truncations at structural boundaries."""
    for place in places:
        bad("%s-cut-%05d.%s" % (stem, place, ending), data[:place], kind, code, says)


def patch(data, at, new):
    return data[:at] + new + data[at + len(new):]


def u16(x):
    return struct.pack("<H", x)


def u32(x):
    return struct.pack("<I", x)


def u64(x):
    return struct.pack("<Q", x)


def f32(*x):
    return struct.pack("<%df" % len(x), *x)


NAN, INF = float("nan"), float("inf")


# ---- any reader ----------------------------------------------------------------------------------------------------------


def anything():
    junk = bytes((i * 73 + 41) & 255 for i in range(300))
    contents = [("empty", b""), ("zero", b"\0" * 64), ("junk", junk), ("utf8", b"\xff\xfe\xc0\x80" * 16), ("newline", b"\n"),
                ("html", b"<!DOCTYPE html><html></html>"), ("pdf", b"%PDF-1.4\n" + b"x" * 40), ("one", b"x")]
    kinds = [("brdf", "byte 0"), ("model", "not a safetensors file"), ("dataset", "not a safetensors file"),
             ("encoder", "not a safetensors file"), ("directions", "no column 'theta_h'"), ("list", "byte 0: the header names no column"),
             ("human", "the header has no column reference"), ("mesh", "neither a PLY nor an OBJ mesh"),
             ("image", "neither OpenEXR, Radiance HDR nor PNG"), ("map", "neither PNG, JPEG, WebP nor OpenEXR"), ("mat", "no MAT v5 file: its first 128 bytes")]
    for kind, says in kinds:
        is_csv = kind in ("directions", "list", "human")
        for name, data in contents:
            no_csv = {"empty": "no header line", "newline": "no header line", "zero": "byte 0 is 0", "junk": "byte 31 is 0"}
            words = no_csv.get(name, says) if is_csv else says
            bad("any-%s-%s" % (kind, name), data, kind, 4, words)
        os.mkdir(os.path.join(out, "any-%s-folder" % kind))
        verdicts.append(("any-%s-folder" % kind, kind, 3, "is a directory"))
        verdicts.append(("any-%s-missing" % kind, kind, 3, "No such file"))


# ---- measured tables -----------------------------------------------------------------------------------------------------


def merl():
    head = struct.pack("<3i", 90, 90, 180)
    cuts("merl", "binary", head + struct.pack("<d", 1) * 40, (12, 13, 20, 200), "brdf", 4, "34992012")
    for i, dims in enumerate([(90, 90, 0), (90, 90, 181), (0, 90, 180), (-90, -90, 180), (90, 90, -180), (2**31 - 1,) * 3, (1, 1, 1)]):
        bad("merl-dims-%d.binary" % i, struct.pack("<3i", *dims) + bytes(64), "brdf", 4, "byte 0")
    bad("merl-360-short.binary", struct.pack("<3i", 90, 90, 360) + bytes(100), "brdf", 4, "69984012")
    path = os.path.join(out, "merl-sparse-nan.binary")
    with open(path, "wb") as f:
        f.write(head)
        f.truncate(34992012 + 8)
    verdicts.append(("merl-sparse-nan.binary", "brdf", 4, "34992012"))


def tensor_file(fields, n_fields=None, version=(1, 0), magic=b"tensor_file\0"):
    """fields: (name, type, dims, data, offset or None, n_name or None)."""
    types = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 8, 8: 8, 9: 2, 10: 4, 11: 8}
    at = 12 + 2 + 4 + sum(2 + len(f[0]) + 2 + 1 + 8 + 8 * len(f[2]) for f in fields)
    table, blocks = b"", b""
    for name, kind, dims, data, offset, n_name in fields:
        table += u16(len(name) if n_name is None else n_name) + name + u16(len(dims)) + bytes([kind])
        table += u64(at + len(blocks) if offset is None else offset) + b"".join(u64(d) for d in dims)
        blocks += data
    return magic + bytes(version) + u32(len(fields) if n_fields is None else n_fields) + table + blocks


def rgl_fields(**changes):
    one = {"theta_i": (10, (2,), f32(0, 1.2)), "phi_i": (10, (1,), f32(0)), "ndf": (10, (2, 2), f32(1, 1, 1, 1)),
           "sigma": (10, (2, 2), f32(1, 1, 1, 1)), "vndf": (10, (1, 2, 2, 2), f32(*[1] * 8)),
           "luminance": (10, (1, 2, 2, 2), f32(*[1] * 8)), "rgb": (10, (1, 2, 3, 2, 2), f32(*[1] * 24)), "jacobian": (1, (1,), b"\1")}
    one.update(changes)
    return [(k.encode(),) + v[:3] + (v[3:] + (None, None))[:2] for k, v in one.items() if v]


def rgl():
    good = tensor_file(rgl_fields())
    n_table = 12 + 2 + 4 + sum(2 + len(f[0]) + 2 + 1 + 8 + 8 * len(f[2]) for f in rgl_fields())
    cuts("rgl", "bsdf", good, (11, 12, 13, 14, 16, 18, 19, 20, 25, 27, 30, 36, 44, 60, 100, n_table - 1, n_table, n_table + 3, n_table + 8,
                               len(good) - 1), "brdf")
    for name in ("theta_i", "phi_i", "ndf", "sigma", "vndf", "rgb"):
        bad("rgl-without-%s.bsdf" % name, tensor_file(rgl_fields(**{name: None})), "brdf", 4, "byte")
    for i, n in enumerate((0, 2**32 - 1, 2**31, 200)):
        bad("rgl-n-fields-%d.bsdf" % i, tensor_file(rgl_fields(), n_fields=n), "brdf")
    bad("rgl-version.bsdf", tensor_file(rgl_fields(), version=(2, 0)), "brdf", 4, "byte 12")
    for kind in (0, 12, 255, 7, 11):
        bad("rgl-type-%d.bsdf" % kind, tensor_file(rgl_fields(theta_i=(kind, (2,), f32(0, 1.2) * 2))), "brdf")
    for i, dims in enumerate([(), (0,), (3,), (2**63,), (2**32, 2**32), (2**40, 2**24, 2**3), (1,) * 40]):
        bad("rgl-dims-%d.bsdf" % i, tensor_file(rgl_fields(theta_i=(10, dims, f32(0, 1.2)))), "brdf")
    for i, offset in enumerate((2**64 - 1, 2**63, len(good), len(good) - 4)):
        bad("rgl-offset-%d.bsdf" % i, tensor_file(rgl_fields(rgb=(10, (1, 2, 3, 2, 2), f32(*[1] * 24), offset))), "brdf")
    for i, n_name in enumerate((0, 65535, 9)):
        bad("rgl-name-%d.bsdf" % i, tensor_file(rgl_fields(theta_i=(10, (2,), f32(0, 1.2), None, n_name))), "brdf")
    for name, fields in [("theta-falls", {"theta_i": (10, (2,), f32(1.2, 0))}), ("theta-nan", {"theta_i": (10, (2,), f32(0, NAN))}),
                         ("theta-inf", {"theta_i": (10, (2,), f32(0, INF))}), ("ndf-nan", {"ndf": (10, (2, 2), f32(1, NAN, 1, 1))}),
                         ("sigma-inf", {"sigma": (10, (2, 2), f32(1, 1, INF, 1))}),
                         ("rgb-nan", {"rgb": (10, (1, 2, 3, 2, 2), f32(*[NAN] * 24))}),
                         ("vndf-nan", {"vndf": (10, (1, 2, 2, 2), f32(*[NAN] * 8))}),
                         ("vndf-negative", {"vndf": (10, (1, 2, 2, 2), f32(*[-1] * 8))}),
                         ("phi-two", {"phi_i": (10, (2,), f32(0, 1)), "rgb": (10, (2, 2, 3, 2, 2), f32(*[1] * 48)),
                                      "vndf": (10, (2, 2, 2, 2), f32(*[1] * 16))}),
                         ("rgb-shape", {"rgb": (10, (1, 3, 2, 2, 2), f32(*[1] * 24))}), ("rgb-flat", {"rgb": (10, (24,), f32(*[1] * 24))}),
                         ("ndf-thin", {"ndf": (10, (1, 4), f32(*[1] * 4))}), ("vndf-shape", {"vndf": (10, (1, 1, 4, 2), f32(*[1] * 8))})]:
        bad("rgl-%s.bsdf" % name, tensor_file(rgl_fields(**fields)), "brdf")


def rgl_anisotropic():
    def file(phi=(-3.1415927, -2, -1, 0), n=None, **changes):
        n = len(phi) if n is None else n
        return tensor_file(rgl_fields(**{"phi_i": (10, (len(phi),), f32(*phi)), "vndf": (10, (n, 2, 2, 2), f32(*[1] * 8 * n)),
                                         "rgb": (10, (n, 2, 3, 2, 2), f32(*[1] * 24 * n)), **changes}))

    for name, data in [("third", file((0, 1, 2.0943951))), ("falls", file((0, 2, 1, 3.1415927))), ("nan", file((0, NAN, 2, 3.1415927))),
                       ("inf", file((0, 1, 2, INF))), ("none", file(())), ("more", file(n=5)), ("fewer", file(n=3)),
                       ("vndf", file(vndf=(10, (3, 2, 2, 2), f32(*[1] * 24)))), ("rgb", file(rgb=(10, (1, 8, 3, 2, 2), f32(*[1] * 96)))),
                       ("empty", file(vndf=(10, (4, 2, 2, 2), f32(*[1] * 24 + [0] * 8)))), ("huge", file(vndf=(10, (4, 2, 2**31, 2**30), b"")))]:
        bad("rgl-phi-%s.bsdf" % name, data, "brdf")
    good = file()
    cuts("rgl-phi", "bsdf", good, (100, 200, len(good) - 700, len(good) - 90, len(good) - 1), "brdf")


def utia():
    size = 3 * 288 * 288 * 8
    good = struct.pack("<d", 0.1) * (size // 8)
    for name, at, value in [("nan-8", 8, NAN), ("inf", 800000, INF), ("huge-last", size - 8, 1e200)]:
        bad("utia-%s.bin" % name, patch(good, at, struct.pack("<d", value)), "brdf", 4, "value at byte %d is not finite" % at)
    for name, data in [("short", good[:-8]), ("long", good + good[:8]), ("text", patch(good, 0, b"<material version"))]:
        bad("utia-%s.bin" % name, data, "brdf", 4, "byte 0")


def pbsdf():
    def file(phi=(0, 3), theta_d=(0, 1), theta_h=(0, 1), wvls=(450, 550, 650), n=24 * 16, shape=None, kind=6, **more):
        count = len(phi) * len(theta_d) * len(theta_h) * len(wvls) * 16
        fields = [(b"phi_d", 10, (1, len(phi)), f32(*phi), None, None), (b"theta_d", 10, (1, len(theta_d)), f32(*theta_d), None, None),
                  (b"theta_h", 10, (1, len(theta_h)), f32(*theta_h), None, None),
                  (b"wvls", 3, (len(wvls),), struct.pack("<%dH" % len(wvls), *wvls), None, None),
                  (b"M", 10, shape or (len(phi), len(theta_d), len(theta_h), len(wvls), 4, 4), f32(*[0.1] * count), None, None)]
        return tensor_file([f for f in fields if f[0].decode() not in more.get("without", ())])

    for name in ("phi_d", "theta_d", "theta_h", "wvls"):
        bad("pbsdf-without-%s.pbsdf" % name, file(without=(name,)), "brdf")
    for name, data in [("theta-falls", file(theta_h=(1, 0))), ("theta-nan", file(theta_h=(0, NAN))), ("phi-far", file(phi=(0, 100))),
                       ("phi-falls", file(phi=(3, 0))), ("waves-few", file(wvls=(450,))), ("waves-fall", file(wvls=(650, 550, 450))),
                       ("waves-short", file(wvls=(600, 610, 650))), ("shape", file(shape=(2, 2, 2, 3, 16))),
                       ("shape-3", file(shape=(2, 2, 2, 3, 4, 3))), ("huge", file(shape=(2**20, 2**20, 2**20, 3, 4, 4)))]:
        bad("pbsdf-%s.pbsdf" % name, data, "brdf")
    good = file()
    cuts("pbsdf", "pbsdf", good, (60, 150, len(good) - 1000, len(good) - 1), "brdf")


def nbrdf():
    good = seed("valid.h5")
    cuts("nbrdf", "h5", good, (4, 8, 9, 24, 56, 96, 99, 100, 200, 500, 800, 1000, 1500, 2048, 3000, 4096, 6000, 9000, 12000, len(good) - 1),
         "brdf")
    for at, new in ((8, b"\2"), (8, b"\xff"), (13, b"\4"), (14, b"\4"), (24, u64(8)), (40, u64(2**63)), (64, u64(2**64 - 8)),
                    (64, u64(len(good) - 8)), (64, u64(0))):
        bad("nbrdf-superblock-%02d-%x.h5" % (at, new[0]), patch(good, at, new), "brdf")
    for word in (b"TREE", b"HEAP", b"SNOD"):
        if word in good:
            bad("nbrdf-%s.h5" % word.decode(), good.replace(word, b"XXXX"), "brdf")
            at = good.index(word)
            bad("nbrdf-%s-size.h5" % word.decode(), patch(good, at + 4, b"\xff" * 12), "brdf")
    for i, name in enumerate((b"dense_1", b"dense_3", b"kernel:0", b"bias:0")):
        bad("nbrdf-name-%d.h5" % i, good.replace(name, b"x" * len(name)), "brdf")
    bad("nbrdf-huge.h5", good + bytes((4 << 20)), "brdf", 7, "limit")
    return good


def archives(h5):
    def pack(members, method=zipfile.ZIP_DEFLATED):
        path = os.path.join(out, "scratch.zip")
        with zipfile.ZipFile(path, "w", method) as z:
            for name, data in members:
                z.writestr(zipfile.ZipInfo(name), data, method)
        with open(path, "rb") as f:
            data = f.read()
        os.remove(path)
        return data

    good = pack([("a/steel.h5", h5)])
    end = good.rindex(b"PK\5\6")
    central = good.index(b"PK\1\2")

    def member(name, data, material="steel", code=4, says=".zip"):
        bad(name, data, "none")
        verdicts[-1] = (name + ":" + material, "brdf", code, says)

    for place in (30, 46, len(good) // 2, central, central + 20, end, end + 10, len(good) - 1):
        member("zip-cut-%05d.zip" % place, good[:place])
    member("zip-missing.zip", good, "gold", 3, "has no member 'gold.h5'")
    member("zip-empty-name.zip", good, "", 3, "no member '.h5'")
    bad("zip-unnamed.zip", good, "brdf", 2, "name one material")
    bad("zip-nothing.zip", pack([]), "brdf", 4, "no NBRDF")
    bad("zip-other.zip", pack([("readme.txt", b"x")]), "brdf", 4, "no NBRDF")
    member("zip-bomb.zip", pack([("steel.h5", bytes(40 << 20))]), says="limit is", code=7)
    member("zip-not-h5.zip", pack([("steel.h5", b"no network")]), says="byte")
    member("zip-empty-member.zip", pack([("steel.h5", b"")]), says="byte")
    member("zip-crc.zip", patch(good, central + 16, b"\1\2\3\4"))
    member("zip-crc-stored.zip", patch(pack([("steel.h5", h5)], zipfile.ZIP_STORED), 5000, b"\0\1\2\3"))
    member("zip-size.zip", patch(good, central + 24, u32(2**31)), code=7, says="the limit is")
    member("zip-size-small.zip", patch(good, central + 24, u32(100)))
    member("zip-method.zip", patch(good, central + 10, u16(99)))
    member("zip-offset.zip", patch(good, central + 42, u32(2**31)))
    member("zip-comment.zip", patch(good, end + 20, u16(500)))
    member("zip-count.zip", patch(patch(good, end + 8, u16(9)), end + 10, u16(9)))
    member("zip-deflate.zip", patch(good, 60, b"\xff" * 40))


def decoders():
    csv = b"material,mean0,mean1,mean2,mean3,mean4,mean5,mean6\nfirst,0,0,0,0,0,0,0\n"
    n = 4 * 808003

    def decoder(name, size, latents, code=4, says="byte", material="first", value=b"\0"):
        os.mkdir(os.path.join(out, name))
        with open(os.path.join(out, name, "d.bin"), "wb") as f:
            f.write(value * 64)
            f.truncate(size)
        if latents is not None:
            with open(os.path.join(out, name, "nps_latents.csv"), "wb") as f:
                f.write(latents)
        verdicts.append((name + "/d.bin" + (":" + material if material else ""), "brdf", code, says))

    decoder("nps-short", n - 4, csv, 4, "byte")
    decoder("nps-nan", n, csv, 4, "not finite", value=b"\xff")
    decoder("nps-unnamed", n, csv, 2, "name one material", "")
    decoder("nps-no-latents", n, None, 3, "nps_latents.csv")
    decoder("nps-missing", n, csv, 3, "has no material 'second'", "second")
    decoder("nps-no-column", n, csv.replace(b"mean6", b"x"), 4, "mean6")
    decoder("nps-no-number", n, csv.replace(b",0\n", b",x\n"), 4, "line 2, byte")
    decoder("nps-inf", n, csv.replace(b",0\n", b",inf\n"), 4, "line 2, byte")


# ---- arrays --------------------------------------------------------------------------------------------------------------


def npy_header(text, version=1, length=None):
    text = text.encode()
    text += b" " * (-(len(text) + 11) % 64) + b"\n"
    n = len(text) if length is None else length
    return b"\x93NUMPY" + bytes([version, 0]) + (u16(n) if version == 1 else u32(n)) + text


def npy():
    dict_text = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 2, 2, 3), }"
    values = f32(*[0.1] * 24)
    good = npy_header(dict_text) + values
    cuts("npy", "npy", good, (6, 7, 8, 9, 10, 30, 100, 127, 128, 132, len(good) - 1), "brdf")
    bad("npy-longer.npy", good + b"\0", "brdf")
    for name, text in [("int", dict_text.replace("<f4", "<i4")), ("big", dict_text.replace("<f4", ">f4")),
                       ("half", dict_text.replace("<f4", "<f2")), ("object", dict_text.replace("'<f4'", "'|O'")),
                       ("record", dict_text.replace("'<f4'", "[('a', '<f4')]")), ("fortran", dict_text.replace("False", "True")),
                       ("fortran-word", dict_text.replace("False", "Maybe")), ("flat", dict_text.replace("(2, 2, 2, 3)", "(24,)")),
                       ("scalar", dict_text.replace("(2, 2, 2, 3)", "()")), ("thin", dict_text.replace("(2, 2, 2, 3)", "(1, 2, 4, 3)")),
                       ("channels", dict_text.replace("(2, 2, 2, 3)", "(2, 2, 3, 2)")),
                       ("zero", dict_text.replace("(2, 2, 2, 3)", "(0, 2, 2, 3)")),
                       ("no-phi-h", dict_text.replace("(2, 2, 2, 3)", "(2, 2, 2, 0, 3)")),
                       ("phi-h-channels", dict_text.replace("(2, 2, 2, 3)", "(2, 2, 3, 2, 1)")),
                       ("axes", dict_text.replace("(2, 2, 2, 3)", "(2, 2, 1, 1, 2, 3)")),
                       ("negative", dict_text.replace("(2, 2, 2, 3)", "(-2, 2, 2, 3)")),
                       ("overflow", dict_text.replace("(2, 2, 2, 3)", "(4294967296, 4294967296, 4294967296, 3)")),
                       ("digits", dict_text.replace("(2, 2, 2, 3)", "(99999999999999999999999, 2, 2, 3)")),
                       ("float", dict_text.replace("(2, 2, 2, 3)", "(2.5, 2, 2, 3)")),
                       ("list", dict_text.replace("(2, 2, 2, 3)", "[2, 2, 2, 3]")),
                       ("many", dict_text.replace("(2, 2, 2, 3)", "(" + "1, " * 60 + ")")),
                       ("nodescr", dict_text.replace("'descr'", "'dscr'")),
                       ("noshape", dict_text.replace("'shape'", "'shap'")), ("twice", dict_text.replace("{", "{'descr': '<f4', ")),
                       ("extra", dict_text.replace("{", "{'a': 1, ")), ("open", dict_text.replace("}", "")), ("empty", "{}"),
                       ("words", "hello")]:
        bad("npy-%s.npy" % name, npy_header(text) + values, "brdf")
    for i, (version, length) in enumerate(((1, 65535), (1, 0), (2, 2**32 - 1), (4, None), (0, None))):
        bad("npy-header-%d.npy" % i, npy_header(dict_text, version, length) + values, "brdf")
    bad("npy-inf.npy", npy_header(dict_text) + f32(INF) + values[4:], "brdf", 4, "byte 128")
    bad("npy-nan-green.npy", npy_header(dict_text) + f32(1, NAN) + values[8:], "brdf", 4, "byte 132")


def sign(header, data):
    """A safetensors file with the checksum of nqm."""
    header.setdefault("__metadata__", {})["sha256"] = "0" * 64
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-(len(text) + 8) % 64)
    whole = u64(len(text)) + text + data
    return whole.replace(b'"sha256":"' + b"0" * 64, b'"sha256":"' + hashlib.sha256(whole).hexdigest().encode())


def split(data):
    n = struct.unpack("<Q", data[:8])[0]
    return json.loads(data[8:8 + n]), data[8 + n:]


def safetensors(stem, kind, code, optional=(), says="byte"):
    good = seed("valid-%s.safetensors" % stem)
    name = lambda fault: "st-%s-%s.safetensors" % (stem, fault)
    n = 8 + struct.unpack("<Q", good[:8])[0]
    cuts("st-" + stem, "safetensors", good, (7, 8, 9, 100, n - 1, n, n + 1, len(good) - 1), kind)
    bad(name("longer"), good + b"\0", kind)
    bad(name("flipped"), patch(good, len(good) - 3, bytes([good[-3] ^ 1])), kind, code, "checksum")
    for i, length in enumerate((0, 1, 2**63, 2**64 - 1, len(good), n + 8)):
        bad(name("length-%d" % i), u64(length) + good[8:], kind)
    tensors = [t for t in split(good)[0] if t != "__metadata__"]

    def changed(fault, change, expected=code, words=says):
        header, data = split(good)
        change(header)
        bad(name(fault), sign(header, data), kind, expected, words)

    first = tensors[0]
    for tensor in tensors[:6]:
        if tensor not in optional:
            changed("without-" + tensor.replace(".", "_"), lambda h: h.pop(tensor), 4)
    for i, shape in enumerate(([], [0], [-1], [2**62, 4], [2**32, 2**32, 2**32], [1] * 9, "2", [1.5], [None])):
        changed("shape-%d" % i, lambda h: h[first].update(shape=shape), 4, first)
    for i, offsets in enumerate(([0], [0, 1], [8, 0], [-4, 4], [0, 2**62], [2**63 - 1, 2**63 - 1], "0", [0, 4, 8])):
        changed("offsets-%d" % i, lambda h: h[first].update(data_offsets=offsets), 4, first)
    for i, dtype in enumerate(("F33", "BF16", "", 4, None)):
        changed("dtype-%d" % i, lambda h: h[first].update(dtype=dtype), 4, "dtype")
    if stem != "dataset":  # which may have further arrays
        changed("extra", lambda h: h.update(zzz={"dtype": "F32", "shape": [0], "data_offsets": [0, 0]}), words="zzz" if kind == "model" else "more tensors")
    changed("no-entry", lambda h: h.update({first: 5}), 4, first)
    changed("meta-number", lambda h: h["__metadata__"].update(a=5), 4, "metadata 'a'")
    changed("schema", lambda h: h["__metadata__"].update(schema="99"), code, "schema 99")
    changed("no-schema", lambda h: h["__metadata__"].pop("schema"), code, "schema")
    changed("format", lambda h: h["__metadata__"].update(format="nqm-other"), code, "format" if kind == "dataset" else "byte")
    text = good[8:n]
    for fault, new in (("syntax", text.replace(b":", b";", 1)), ("utf8", text.replace(b"format", b"form\xff\xfe", 1)),
                       ("twice", text.replace(b"{", b'{"__metadata__":{},', 1)), ("list", b"[" + text.strip() + b"]"),
                       ("deep", b"[" * 5000),
                       ("nul", text.replace(b"format", b"form\\u0000", 1)), ("null", b"null")):
        bad(name(fault), u64(len(new)) + new + good[n:], kind)
    header, data = split(good)
    for tensor in tensors:
        if header[tensor]["dtype"] == "F32" and header[tensor]["data_offsets"][1] > header[tensor]["data_offsets"][0]:
            at = header[tensor]["data_offsets"][0]
            for value in (NAN, INF):
                new = patch(data, at + 4, f32(value))
                bad(name("%s-%s" % (value, tensor.replace(".", "_"))), sign(split(good)[0], new), kind, code, "finite")
            break


def mat():
    def tag(kind, data):
        return struct.pack("<2I", kind, len(data)) + data + bytes(-len(data) % 8)

    def matrix(flags=6, rows=4, cols=1, values=struct.pack("<4d", 1, 2, 3, 4), kind=9, name=b"r", dims=None):
        inner = tag(6, struct.pack("<2I", flags, 0)) + tag(5, dims if dims is not None else struct.pack("<2i", rows, cols))
        inner += tag(1, name) + tag(kind, values)
        return tag(14, inner)

    def packed(element):
        data = zlib.compress(element)
        return struct.pack("<2I", 15, len(data)) + data

    head = b"MATLAB 5.0 MAT-file" + b" " * 105 + b"\0\1IM"
    good = head + matrix()
    cuts("mat", "mat", good, (20, 124, 126, 127), "mat", 4, "no MAT v5 file")
    cuts("mat", "mat", good, (129, 135, 136, 140, 152, 160, 168, 176, 184, 192, 200, len(good) - 1), "mat")
    shut = head + packed(matrix())
    cuts("mat-packed", "mat", shut, (132, 136, 137, 140, 150, len(shut) - 5, len(shut) - 1), "mat")
    for name, element in [
            ("early", matrix(14, 500, 1, struct.pack("<2q", 1, 2), 12)), ("rows", matrix(rows=500)), ("rows-huge", matrix(rows=2**31 - 1)),
            ("rows-negative", matrix(rows=-4)), ("dims-product", matrix(rows=2**31 - 1, cols=2**31 - 1)), ("few", matrix(rows=3)),
            ("cols", matrix(cols=2)), ("three-dims", matrix(dims=struct.pack("<3i", 4, 1, 1))), ("no-dims", matrix(dims=b"")),
            ("odd-dims", matrix(dims=b"\4\0\0\0\1")), ("complex", matrix(flags=6 | 0x800)), ("cell", matrix(flags=1)),
            ("struct", matrix(flags=2)),
            ("sparse", matrix(flags=5)), ("class", matrix(flags=99)), ("type", matrix(kind=8)), ("type-0", matrix(kind=0)),
            ("type-text", matrix(kind=16)), ("nan", matrix(values=struct.pack("<4d", 1, 2, NAN, 4))),
            ("inf", matrix(values=struct.pack("<4d", 1, INF, 3, 4))), ("name", matrix(name=b"q")), ("long-name", matrix(name=b"r" * 100)),
            ("empty", matrix(values=b"")), ("single-bytes", matrix(kind=7))]:
        words = "row 3, column 1" if name == "nan" else "'r'" if name in ("cell", "struct", "sparse", "class", "name") else "byte"
        bad("mat-%s.mat" % name, head + element, "mat", 4, words)
        bad("mat-packed-%s.mat" % name, head + packed(element), "mat", 4, words)
    bad("mat-tag-long.mat", head + patch(matrix(), 4, u32(2**31)), "mat", 4, "byte 128 is cut off")
    bad("mat-packed-tag-long.mat", head + packed(patch(matrix(), 4, u32(5000))), "mat", 4, "another size than its zlib stream")
    bad("mat-packed-tag-short.mat", head + packed(patch(matrix(), 4, u32(40))), "mat", 4, "another size than its zlib stream")
    bad("mat-packed-more.mat", head + packed(matrix() + bytes(5000)), "mat", 4, "byte 128")
    bad("mat-packed-flag.mat", head + patch(packed(matrix()), 8, b"\0\0"), "mat", 4, "byte 128")
    bad("mat-packed-bomb.mat", head + packed(matrix(rows=2**24 + 1, values=bytes(1 << 22))), "mat", 4, "byte 128")
    bad("mat-packed-twice.mat", head + packed(packed(matrix())), "mat", 4, "byte 128")
    bad("mat-unknown.mat", head + tag(99, bytes(8)), "mat", 4, "byte 128 is of an unknown type")
    bad("mat-7.3.mat", b"MATLAB 7.3 MAT-file" + bytes(493) + b"\x89HDF\r\n\x1a\n" + bytes(64), "mat", 4, "'-v7'")
    bad("mat-4.mat", struct.pack("<5i", 0, 4, 1, 0, 2) + b"r\0" + struct.pack("<4d", 1, 2, 3, 4) + bytes(80), "mat", 4, "no MAT v5")
    bad("mat-order.mat", head[:126] + b"XX" + matrix(), "mat", 4, "byte 126")
    bad("mat-order-lies.mat", head[:126] + b"MI" + matrix(), "mat", 4, "byte 128")


# ---- tables of text ------------------------------------------------------------------------------------------------------


def tables():
    row = "10,20,30,.1,.2,.3\n"
    head = "theta_h,theta_d,phi_d,r,g,b\n"
    for name, text, words in [
            ("no-rows", head, "without a direction"), ("few", head + "10,20,30\n", "line 2, byte 28"),
            ("many", head + "1,2,3,4,5,6,7\n", "line 2"),
            ("word", head + row + "10,x,30,1,1,1\n", "line 3, byte"), ("nan", head + "10,nan,30,1,1,1\n", "line 2, byte"),
            ("nothing", head + "10,20,30,nan,1,1\n", "no direction above the horizon has a value"),
            ("inf", head + "10,20,30,1,inf,1\n", "line 2, byte"), ("range-h", head + "91,20,30,1,1,1\n", "theta_h 91"),
            ("range-d", head + "1,-1,30,1,1,1\n", "theta_d -1"), ("range-p", head + "1,1,361,1,1,1\n", "phi_d 361"),
            ("no-blue", "theta_h,theta_d,phi_d,r,g\n1,2,3,4,5\n", "'b'"), ("half-empty", head + "1,2,3,,1,1\n", "line 2"),
            ("nothing", head + "1,2,3,,,\n", "has a value"), ("horizon", head + "90,90,0,1,1,1\n", "above the horizon"),
            ("quote", head + '"10,20,30,1,1,1\n', "quoted field"), ("quote-after", head + '"10"x,20,30,1,1,1\n', "quoted field"),
            ("nul", head + "1,2\0,3,1,1,1\n", "not a text file"), ("exponent", head + "1e999,2,3,1,1,1\n", "line 2, byte"),
            ("hex", head + "0x10,2,3,1,1,1\n", "line 2, byte"), ("comma", head.replace(",", ";") + "1,5;2;3;1;1;1\n", "line 2, byte"),
            ("blank", head + " ,2,3,1,1,1\n", "line 2, byte")]:
        bad("directions-%s.csv" % name, text, "brdf", 4, words)
    for name, text, words in [
            ("no-rows", "theta_h,theta_d,phi_d\n", "0 directions"), ("no-column", "theta_h,theta_d\n1,2\n", "phi_d"),
            ("word", "theta_h,theta_d,phi_d\n1,2,x\n", "line 2, byte"),
            ("nan", "theta_h,theta_d,phi_d\n1,nan,3\n", "line 2, byte"), ("range", "theta_h,theta_d,phi_d\n100,2,3\n", "direction 1: theta_h 100"),
            ("range-p", "theta_h,theta_d,phi_d\n1,2,361\n", "direction 1: theta_h 1, theta_d 2, phi_d 361"), ("columns", "theta_h,theta_d,phi_d\n1,2\n", "line 2"),
            ("too-many", "theta_h,theta_d,phi_d\n" + "1,2,3\n" * 100001, "100001 directions")]:
        bad("set-%s.csv" % name, text, "directions", 4, words)
    many = ",".join("c%d" % i for i in range(1100))
    for name, text, code, words in [
            ("no-test", "reference,b\na,b\n", 4, "'test'"), ("no-reference", "x,test\na,b\n", 4, "'reference'"),
            ("fields", "reference,test\na\n", 4, "line 2"),
            ("more", "reference,test\na,b,c\n", 4, "line 2"), ("empty-test", "reference,test\na,\n", 4, "'test' is empty"),
            ("empty-reference", "reference,test\n,b\n", 4, "'reference' is empty"), ("quote", 'reference,test\n"a,b\n', 4, "quoted field"),
            ("nul", "reference,test\na\0,b\n", 4, "byte 16 is 0"), ("columns", "reference,test," + many + "\n", 7, "1102 columns"),
            ("columns-20000", "reference,test" + ",x" * 20000 + "\n", 7, "at most 16384"), ("comments", "# a\n# b\n", 4, "no header line"),
            ("cr-only", "reference,test\ra,b\r", 4, "byte 0")]:
        bad("list-%s.csv" % name, text, "list", code, words)
    good = '{"reference":"a","test":"b"}\n'
    for name, text, code, words in [
            ("open", good + '{"reference":"a","test":"b"\n', 4, "line 2, byte"), ("array", good + "[1]\n", 4, "line 2, byte"),
            ("no-test", good + '{"reference":"a"}\n', 4, 'no string "test"'),
            ("number", '{"reference":"a","test":3}\n', 4, 'no string "test"'),
            ("null", '{"reference":null,"test":"b"}\n', 4, 'no string "reference"'),
            ("empty", '{"reference":"","test":"b"}\n', 4, 'no string "reference"'),
            ("twice", '{"reference":"a","test":"b","test":"c"}\n', 4, "uplicate"),
            ("after", good.strip() + " x\n", 4, "line 1, byte"), ("two", good.strip() + good, 4, "line 1, byte"),
            ("deep", '{"reference":"a","test":"b","x":' + "[" * 3000 + "\n", 4, "line 1, byte"),
            ("nul", '{"reference":"a","test":"b\\u0000"}\n', 4, "line 1, byte"),
            ("utf8", b'{"reference":"a","test":"\xff"}\n', 4, "line 1, byte"),
            ("surrogate", '{"reference":"a","test":"\\ud800"}\n', 4, "line 1, byte"),
            ("huge-number", '{"reference":"a","test":"b","x":1e999}\n', 4, "line 1, byte"),
            ("huge-integer", '{"reference":"a","test":"b","x":99999999999999999999999}\n', 4, "line 1, byte"),
            ("comma", '{"reference":"a","test":"b",}\n', 4, "line 1, byte"),
            ("members", "".join('{"reference":"a","test":"b","x%d":1}\n' % i for i in range(1100)), 7, "more than 1024"),
            ("csv-after", good + "a,b\n", 4, "line 2, byte")]:
        bad("list-%s.jsonl" % name, text, "list", code, words)
    pair = "lambert:kd=.5,lambert:kd=.6"
    for name, text, code, words in [
            ("no-score", "reference,test\n" + pair + "\n", 4, "score"),
            ("word", "reference,test,score\n" + pair + ",x\n", 4, "line 2, byte"),
            ("nan", "reference,test,jod\n" + pair + ",nan\n", 4, "line 2, byte"), ("no-rows", "reference,test,score\n", 4, "has no rows"),
            ("choice", "reference,test_a,test_b,choice\n" + pair + ",lambert:kd=.1,c\n", 4, "row 1"),
            ("negative", "reference,test_a,test_b,n_a,n_b\n" + pair + ",lambert:kd=.1,-1,2\n", 4, "row 1"),
            ("zero", "reference,test_a,test_b,n_a,n_b\n" + pair + ",lambert:kd=.1,0,0\n", 5, "nobody has chosen"),
            ("one-test", "reference,test_a,choice\n" + pair + ",a\n", 4, "no column test_b"),
            ("fraction", "reference,test_a,test_b,n_a,n_b\n" + pair + ",lambert:kd=.1,1.5,2\n", 4, "row 1"),
            ("missing", "reference,test,score\nlambert:kd=.5,nowhere.binary,1\n", 3, "row 1"),
            ("spec", "reference,test,score\nlambert:kd=.5,lambert:kd=-5,1\n", 2, "row 1")]:
        bad("human-%s.csv" % name, text, "human", code, words)


# ---- meshes and pictures -------------------------------------------------------------------------------------------------


def meshes():
    v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    for name, text, words in [
            ("no-face", v, "no faces"), ("two-corners", v + "f 1 2\n", "line 4"), ("zero", v + "f 0 1 2\n", "line 4"),
            ("far", v + "f 1 2 4\n", "line 4"),
            ("negative", v + "f -1 -2 -4\n", "line 4"), ("word", v + "f a b c\n", "line 4"), ("slash", v + "f 1/ 2/ 3/\n", "line 4"),
            ("slashes", v + "f 1/1/1/1 2 3\n", "line 4"),
            ("no-normal", v + "f 1//1 2//1 3//1\n", "line 4"), ("before", "f 1 2 3\n" + v, "line 1"),
            ("short-v", "v 0 0\n" + v + "f 1 2 3\n", "line 1"),
            ("nan", "v nan 0 0\n" + v + "f 1 2 3\n", "line 1"), ("inf", "v 1e999 0 0\n" + v + "f 1 2 3\n", "line 1"),
            ("float", "v 1e39 0 0\n" + v + "f 1 2 3\n", "line 1"),
            ("normal", v + "vn 0 0 x\nf 1 2 3\n", "line 4"), ("overflow", v + "f 4294967297 2 3\n", "line 4"),
            ("digits", v + "f 99999999999999999999 2 3\n", "line 4"),
            ("degenerate", v + "f 1 1 2\n", "no faces"), ("long", v + "f " + "1" * 300 + " 2 3\n", "line 4"),
            ("backslash", v + "f 1 2 \\", "line 4")]:
        bad("mesh-%s.obj" % name, text, "mesh", 4, words)
    head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    face = "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    rows = "0 0 0\n1 0 0\n0 1 0\n"
    good = head + face + rows + "3 0 1 2\n"
    for place in (3, 4, 10, 20, 40, len(head), len(head) + 10, len(head + face) - 1, len(head + face), len(head + face) + 6, len(good) - 8, len(good) - 3):
        bad("mesh-cut-%03d.ply" % place, good[:place], "mesh", 4, "PLY in line" if place > 3 else "neither a PLY nor an OBJ mesh")
    for name, text in [
            ("format", good.replace("ascii", "utf16")), ("version", good.replace("1.0", "2.0")),
            ("no-format", good.replace("format ascii 1.0\n", "")), ("count", good.replace("vertex 3", "vertex x")),
            ("count-negative", good.replace("vertex 3", "vertex -3")), ("count-huge", good.replace("vertex 3", "vertex 999999999999")),
            ("count-digits", good.replace("vertex 3", "vertex " + "9" * 30)),
            ("count-20", good.replace("vertex 3", "vertex 3000000")), ("no-x", good.replace("float x", "float q")),
            ("twice-x", good.replace("float y", "float x")), ("type", good.replace("float x", "real x")),
            ("list-float", good.replace("list uchar", "list float")), ("no-list", good.replace("list uchar int", "int")),
            ("other-list", good.replace("vertex_indices", "corners")),
            ("property-first", good.replace("element vertex 3\n", "")), ("word", good.replace("element face", "elements face")),
            ("twice", good.replace("element face 1\n", "element vertex 1\n")),
            ("corners", good.replace("3 0 1 2", "2 0 1")), ("index", good.replace("3 0 1 2", "3 0 1 3")),
            ("index-negative", good.replace("3 0 1 2", "3 0 1 -1")), ("index-half", good.replace("3 0 1 2", "3 0 1 1.5")),
            ("list-long", good.replace("3 0 1 2", "200 0 1 2")), ("nan", good.replace("1 0 0", "nan 0 0")),
            ("letters", good.replace("1 0 0", "a 0 0")), ("elements", head + "element a 1\nproperty int q\n" * 40 + face),
            ("properties", head + "property int q\n" * 300 + face), ("no-end", good.replace("end_header\n", ""))]:
        bad("mesh-%s.ply" % name, text, "mesh", 4, "PLY in line")
    binary = (head + face).replace("ascii", "binary_little_endian").encode() + f32(0, 0, 0, 1, 0, 0, 0, 1, 0) + b"\3" + struct.pack("<3i", 0, 1, 2)
    begin = len(binary) - 49
    cuts("mesh-binary", "ply", binary, (begin, begin + 4, begin + 35, begin + 36, begin + 37, begin + 45, len(binary) - 1), "mesh", 4, "PLY")
    bad("mesh-binary-nan.ply", patch(binary, begin, f32(NAN)), "mesh")
    bad("mesh-binary-count.ply", patch(binary, begin + 36, b"\xff"), "mesh")
    bad("mesh-binary-index.ply", patch(binary, begin + 37, struct.pack("<i", -1)), "mesh")


def exr(width=4, height=2, compression=0, rows=None, channels=b"BGR", kind=2, window=None, offset=0, magic=20000630, version=2, extra=b""):
    """Scan lines of floats without compression."""
    def attribute(name, kind, data):
        return name + b"\0" + kind + b"\0" + u32(len(data)) + data

    box = struct.pack("<4i", *(window or (0, 0, width - 1, height - 1)))
    head = struct.pack("<2I", magic, version)
    head += attribute(b"channels", b"chlist", b"".join(bytes([c]) + b"\0" + struct.pack("<iIii", kind, 0, 1, 1) for c in channels) + b"\0")
    head += attribute(b"compression", b"compression", bytes([compression])) + attribute(b"dataWindow", b"box2i", box)
    head += attribute(b"displayWindow", b"box2i", box) + attribute(b"lineOrder", b"lineOrder", b"\0")
    head += attribute(b"pixelAspectRatio", b"float", f32(1)) + attribute(b"screenWindowCenter", b"v2f", f32(0, 0))
    head += attribute(b"screenWindowWidth", b"float", f32(1)) + extra + b"\0"
    line = rows if rows is not None else f32(*[0.5] * (3 * width))
    lines = [struct.pack("<2i", y, len(line)) + line for y in range(height)]
    at = len(head) + 8 * height
    table = b"".join(u64(at + offset + sum(len(x) for x in lines[:y])) for y in range(height))
    return head + table + b"".join(lines), len(head)


def pictures():
    good, n = exr()
    cuts("picture", "exr", good, (4, 8, 9, 30, 100, n - 1, n, n + 8, n + 16, n + 20, len(good) - 20, len(good) - 1), "image", 4, "OpenEXR")
    for name, data in [
            ("magic", exr(magic=20000631)[0]), ("version", exr(version=200)[0]), ("wide", exr(window=(0, 0, 2**30, 1))[0]),
            ("tall", exr(window=(0, 0, 3, 2**30))[0]), ("inside-out", exr(window=(3, 1, 0, 0))[0]),
            ("overflow", exr(window=(-2**31, -2**31, 2**31 - 1, 2**31 - 1))[0]), ("compression", exr(compression=77)[0]),
            ("not-packed", exr(compression=3)[0]), ("piz", exr(compression=4, rows=b"\xff" * 30)[0]),
            ("channels", exr(channels=b"XZQ")[0]), ("no-channel", exr(channels=b"")[0]), ("type", exr(kind=9)[0]),
            ("offset", exr(offset=2**40)[0]), ("offset-small", exr(offset=-60)[0]), ("rows", exr(rows=b"")[0]),
            ("nan", exr(rows=f32(*[NAN] * 12))[0]), ("inf", exr(rows=f32(*[INF] * 12))[0])]:
        says = {"magic": "byte 0", "version": "version: 200", "no-channel": "At least one channel", "type": "'channels' attribute",
                "channels": "the channels are neither", "nan": "row 0, column 0", "inf": "row 0, column 0"}
        header = ("wide", "tall", "inside-out", "overflow")
        bad("picture-%s.exr" % name, data, "image", 4, says.get(name, "Invalid display window" if name in header else "row 1: "))
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 8\n"
    row = b"\2\2\0\x08" + (b"\x88\x80") * 4
    good = head + row * 2
    cuts("picture", "hdr", good, (6, 11, 30, 35, len(head) - 4, len(head), len(head) + 2, len(head) + 4, len(head) + 6, len(good) - 1), "image")
    for name, data in [
            ("size", good.replace(b"-Y 2 +X 8", b"-Y 2 +X x")), ("zero", good.replace(b"-Y 2 +X 8", b"-Y 0 +X 8")),
            ("huge", good.replace(b"-Y 2 +X 8", b"-Y 4294967297 +X 4294967297")), ("wide", good.replace(b"+X 8", b"+X 8192")),
            ("negative", good.replace(b"-Y 2 +X 8", b"-Y -2 +X 8")), ("format", good.replace(b"rgbe", b"xyze")),
            ("run", head + b"\2\2\0\x08\xff\x80" * 4), ("run-zero", head + b"\2\2\0\x08" + b"\0" * 40),
            ("width", head + b"\2\2\0\x09" + row[4:] + row),
            ("order", good.replace(b"-Y 2 +X 8", b"+X 8 -Y 2"))]:
        bad("picture-%s.hdr" % name, data, "image", 4,
            "the picture is empty" if name == "zero" else "the header claims" if name in ("huge", "wide") else "byte")

    def chunk(kind, data, crc=0):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data) ^ crc)

    def png(width=4, height=2, depth=8, colour=6, data=None, crc=0, idat=None):
        rows = data if data is not None else (b"\0" + b"\x80" * 4 * 4) * 2
        return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, depth, colour, 0, 0, 0), crc) + chunk(b"IDAT", idat if idat is not None else zlib.compress(rows)) +
                chunk(b"IEND", b""))

    good = png()
    cuts("picture", "png", good, (4, 8, 12, 16, 24, 29, 33, 37, 41, 45, len(good) - 30, len(good) - 16), "image")
    for name, data in [
            ("rgb", png(colour=2, data=(b"\0" + b"\x80" * 12) * 2)), ("grey", png(colour=0, data=(b"\0" + b"\x80" * 4) * 2)),
            ("deep", png(depth=16, data=(b"\0" + b"\x80" * 32) * 2)), ("depth", png(depth=3)), ("zero", png(width=0)),
            ("huge", png(width=2**31 - 1, height=2**31 - 1)),
            ("wide", png(width=8192, height=4096)), ("crc", png(crc=1)), ("short", png(data=b"\0" * 5)),
            ("filter", png(data=(b"\x09" + b"\x80" * 16) * 2)), ("deflate", png(idat=b"\xff" * 20)), ("no-data", png(idat=b""))]:
        bad("picture-%s.png" % name, data, "image", 4,
            "8-bit RGBA" if name in ("rgb", "grey", "deep") else "the header claims" if name in ("huge", "wide") else "byte")


def webp_maps():
    lossless = bytes.fromhex("5249464634000000574542505650384c270000002f034000103ff0fbfff150d8b60d8adb312e7284924a67b2b97c100890b1052d5ab488e87f600300")
    lossy = bytes.fromhex("524946463e000000574542505650382032000000f001009d012a0400020002c04c25a80274ba00030906fd4800fec8d70dfffe760fecdfde8f703f535fee"
                          "6050f0abe4220000")
    early, damaged = "WebP: the file ends too early", "WebP: the data are damaged"
    for stem, good in ("webp-lossless", lossless), ("webp-lossy", lossy):
        cuts(stem, "webp", good, (12, 15, 19, 20, 24, 29, 30, 40, len(good) - 2, len(good) - 1), "map", 4, early)
        bad(stem + "-signature.webp", patch(good, 20 if good is lossless else 23, b"\xff"), "map", 4, damaged)
        bad(stem + "-chunk.webp", patch(good, 16, u32(2**31)), "map", 4, damaged)
        bad(stem + "-short.webp", patch(good, 4, u32(4)), "map", 4, damaged)
        bad(stem + "-long.webp", patch(good, 4, u32(2**20)), "map", 4, early)
    bad("webp-lossless-codes.webp", lossless[:25] + b"\xff" * (len(lossless) - 25), "map", 4, damaged)
    bad("webp-animation.webp", b"RIFF\x22\0\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0\x0f\0\0\x0f\0\0ANIM\x06\0\0\0\0\0\0\0\0\0", "map", 4, "an animated WebP picture")


# ---- materials of renderers ----------------------------------------------------------------------------------------------


def materials():
    mtlx = ('<?xml version="1.0"?>\n<materialx version="1.38">\n<standard_surface name="s" type="surfaceshader">\n'
            '<input name="base" type="float" value="0.5"/>\n</standard_surface>\n<surfacematerial name="m" type="material">\n'
            '<input name="surfaceshader" type="surfaceshader" nodename="s"/>\n</surfacematerial>\n</materialx>\n')
    for i in range(1, 9):
        bad("material-cut-%d.mtlx" % i, mtlx[:30 + (len(mtlx) - 30) * i // 9], "brdf", 4, "byte")
    for name, text in [
            ("doctype", mtlx.replace("?>\n", '?>\n<!DOCTYPE m [<!ENTITY a "b">]>\n', 1)), ("entity", mtlx.replace('"0.5"', '"&a;"')),
            ("attribute", mtlx.replace('name="s"', 'name="s" name="t"')),
            ("number", mtlx.replace('"0.5"', '"x"')), ("nan", mtlx.replace('"0.5"', '"nan"')), ("range", mtlx.replace('"0.5"', '"-5"')), 
            ("node", mtlx.replace('nodename="s"', 'nodename="t"')), ("no-node", mtlx.replace(' nodename="s"', "")),
            ("input", mtlx.replace('name="base"', 'name="bse"')),
            ("no-material", mtlx.replace("surfacematerial", "volumematerial").replace("standard_surface", "dielectric_bsdf")),
            ("tag", mtlx.replace("</materialx>", "</material>")), ("after", mtlx + "<a/>"),
            ("deep", mtlx.replace("</materialx>", "<a>" * 100)),
            ("utf8", mtlx.replace('"0.5"', '"\udcff"').encode("utf-8", "surrogateescape")),
            ("elements", mtlx.replace("</materialx>", "<a/>" * 90000 + "</materialx>"))]:
        bad("material-%s.mtlx" % name, text, "brdf", 7 if name in ("deep", "elements") else 4)
    gltf = json.dumps({"asset": {"version": "2.0"}, "materials": [{"name": "m", "pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.5, 1], "roughnessFactor": 0.5}}]})
    for i in range(1, 8):
        bad("material-cut-%d.gltf" % i, gltf[:40 + (len(gltf) - 40) * i // 8], "brdf", 4, "byte")
    for name, text in [
            ("version", gltf.replace('"2.0"', '"1.0"')), ("no-version", gltf.replace('"version"', '"vrsion"')),
            ("object", gltf.replace('"materials": [', '"materials": {"a": [').replace("}]}", "}]}}")),
            ("none", gltf[:gltf.index(', "mat')] + "}"),
            ("twice", gltf.replace('"name": "m"', '"name": "m", "name": "m"')), ("factor", gltf.replace("[1, 0.5, 0.5, 1]", "[1, 0.5]")),
            ("factor-word", gltf.replace("[1, 0.5, 0.5, 1]", '"red"')),
            ("range", gltf.replace('"roughnessFactor": 0.5', '"roughnessFactor": 5')),
            ("negative", gltf.replace("[1, 0.5, 0.5, 1]", "[-1, 0.5, 0.5, 1]")),
            ("number", gltf.replace('"roughnessFactor": 0.5', '"roughnessFactor": "a"')),
            ("nan", gltf.replace('"roughnessFactor": 0.5', '"roughnessFactor": NaN')),
            ("infinite", gltf.replace('"roughnessFactor": 0.5', '"roughnessFactor": 1e999')),
            ("after", gltf + "x"), ("deep", gltf[:-1] + ', "x": ' + "[" * 3000),
            ("required", gltf[:-1] + ', "extensionsRequired": ["EXT_unknown"]}'), ("material", gltf.replace('[{"name"', '[5, {"name"')),
            ("texture", gltf.replace('"roughnessFactor": 0.5', '"roughnessFactor": 0.5, "baseColorTexture": {"index": 0}'))]:
        bad("material-%s.gltf" % name, text, "brdf")

    def glb(text, length=None, n=None, version=2, kind=b"JSON", magic=b"glTF"):
        text = text.encode() + b" " * (-len(text) % 4)
        return magic + struct.pack("<2I", version, 20 + len(text) if length is None else length) + u32(len(text) if n is None else n) + kind + text

    for name, data in [
            ("version", glb(gltf, version=1)), ("length", glb(gltf, length=10)), ("length-huge", glb(gltf, length=2**32 - 1)),
            ("chunk", glb(gltf, n=2**32 - 1)), ("chunk-zero", glb(gltf, n=0)), ("chunk-less", glb(gltf, n=20)),
            ("kind", glb(gltf, kind=b"BIN\0")),
            ("cut-8", glb(gltf)[:8]), ("cut-12", glb(gltf)[:12]), ("cut-16", glb(gltf)[:16]), ("cut-20", glb(gltf)[:20]),
            ("cut-60", glb(gltf)[:60])]:
        bad("material-%s.glb" % name, data, "brdf", 4, "byte")
    xml = '<scene version="3.0.0">\n<bsdf type="roughconductor" id="m">\n<float name="alpha" value="0.2"/>\n<string name="material" value="Au"/>\n</bsdf>\n</scene>\n'
    for i in range(1, 7):
        bad("scene-cut-%d.xml" % i, xml[:10 + (len(xml) - 12) * i // 6], "brdf", 4, "byte")
    for name, text in [
            ("doctype", "<!DOCTYPE scene>\n" + xml), ("number", xml.replace("0.2", "a")), ("nan", xml.replace("0.2", "nan")),
            ("metal", xml.replace("Au", "Xx")), ("plugin", xml.replace("roughconductor", "hair")),
            ("plugin-name", xml.replace("roughconductor", "ruffconductor")),
            ("property", xml.replace("alpha", "alfa")),
            ("twice", xml.replace('<float name="alpha" value="0.2"/>', '<float name="alpha" value="0.2"/>' * 2)),
            ("default", xml.replace("0.2", "$a")), ("include", xml.replace("<bsdf", '<include filename="scene-include.xml"/><bsdf')),
            ("none", '<scene version="3.0.0"></scene>\n'),
            ("no-type", xml.replace(' type="roughconductor"', "")),
            ("ref", xml.replace("<bsdf", '<bsdf type="twosided" id="t"><ref id="zzz"/></bsdf><bsdf', 1).replace('id="m"', 'id="t2"')),
            ("loop", '<scene version="3.0.0"><bsdf type="twosided" id="a"><ref id="a"/></bsdf></scene>'),
            ("rgb", xml.replace('<float name="alpha" value="0.2"/>', '<rgb name="specular_reflectance" value="1, 2"/>'))]:
        bad("scene-%s.xml" % name, text, "brdf", *{"ref": (2, "name one material"), "include": (4, "a file includes itself")}.get(name, (4, "byte")))
    scene = json.dumps({"type": "scene", "m": {"type": "roughconductor", "alpha": 0.2, "material": "Au"}})
    for i in range(1, 6):
        bad("scene-cut-%d.json" % i, scene[:20 + (len(scene) - 20) * i // 6], "brdf", 4, "byte")
    for name, text in [
            ("twice", scene.replace('"alpha": 0.2', '"alpha": 0.2, "alpha": 0.3')), ("string", scene.replace("0.2", '"x"')),
            ("list", scene.replace("0.2", "[1, 2]")), ("plugin", scene.replace("roughconductor", "hair")),
            ("property", scene.replace("alpha", "alfa")),
            ("none", '{"type": "scene"}'), ("deep", '{"type": "scene", "m": ' + '{"a":' * 200 + "1" + "}" * 201), ("after", scene + "}")]:
        says = "nested" if name == "deep" else "the material 'm'" if name in ("string", "list", "plugin", "property") else "byte"
        bad("scene-%s.json" % name, text, "brdf", 7 if name == "deep" else 4, says)
    pbrt = 'MakeNamedMaterial "m"\n    "string type" "conductor"\n    "float roughness" [ 0.2 ]\n    "rgb reflectance" [ .5 .5 .5 ]\n'
    for i, place in enumerate((17, 20, 25, 36, 50, 70, len(pbrt) - 4)):
        bad("scene-cut-%d.pbrt" % i, pbrt[:place], "brdf", 4, "byte")
    for name, text in [
            ("type", pbrt.replace("conductor", "cnductor")), ("hair", pbrt.replace('"conductor"', '"hair"')),
            ("number", pbrt.replace("0.2", "x")), ("three", pbrt.replace(".5 .5 .5", ".5 .5")),
            ("texture", pbrt.replace('"float roughness" [ 0.2 ]', '"texture roughness" "t"')),
            ("quote", pbrt.replace('"m"', '"m')), ("bracket", pbrt.replace("]", "")),
            ("negative", pbrt.replace("0.2", "-1")), ("parameter", pbrt.replace("float roughness", "float rough")),
            ("include", 'Include "scene-include.pbrt"\n' + pbrt), ("none", "WorldBegin\n"),
            ("nul", pbrt.replace("0.2", "0\0.2")), ("long", pbrt.replace('"m"', '"' + "m" * 300 + '"')),
            ("many", pbrt + "".join('"float a%d" 1\n' % i for i in range(50))),
            ("measured", 'Material "measured" "string filename" "nowhere.bsdf"\n'),
            ("itself", 'Material "measured" "string filename" "scene-itself.pbrt"\n'),
            ("color-space", 'ColorSpace "aces2065-1"\n' + pbrt)]:
        verdict = {"measured": (3, "nowhere.bsdf"), "include": (4, "a file includes itself"), "itself": (4, "its measured file scene-itself.pbrt")}
        bad("scene-%s.pbrt" % name, text, "brdf", *verdict.get(name, (4, "byte")))


def specs():
    long = "perturb:gloss=0.9;of=" * 40 + "lambert:kd=.5"
    for i, (text, code, words) in enumerate([
            ("ggx:", 2, "needs parameters"), ("ggx:alpha", 2, "alpha"), ("ggx:alpha=", 2, "alpha"), ("ggx:alpha=x", 2, "alpha"),
            ("ggx:alpha=nan", 2, "alpha"), ("ggx:alpha=inf", 2, "alpha"), ("ggx:alpha=-1", 2, "alpha"), ("ggx:alpha=1e999", 2, "alpha"),
            ("ggx:alpha=.3;alpha=.3", 2, "alpha"), ("ggx:alfa=.3", 2, "alfa"), ("ggx:kd=.1,.2", 2, "kd"), ("ggx:kd=.1,.2,.3,.4", 2, "kd"),
            ("ggx:;alpha=.3", 2, "expected key=value"), ("gggx:alpha=.3", 2, "did you mean"), ("lambert:kd=-1", 2, "kd"),
            ("perturb:gloss=2", 2, "of"), ("perturb:of=", 2, "nothing is changed"), ("perturb:gloss=x;of=lambert:kd=.5", 2, "gloss"),
            ("perturb:glos=2;of=lambert:kd=.5", 2, "glos"), ("perturb:gloss=2;of=nowhere.binary", 3, "nowhere.binary"), (long, 7, "at most 3"),
            ("sgd:nickle", 2, "nickel"), ("sgd:", 2, "no preset"),
            ("between:", 2, "the form is"), ("lambert:kd=.5\xff", 2, "kd"), ("ggx:alpha=" + "9" * 400, 2, "alpha"), ("phong:n=5", 3, "No such file"),
            ("lambert:kd=.5,.5,", 2, "kd"), ("lambert:kd=0x1p-1", 2, "kd"), ("cook-torrance:m=0", 2, "no key 'm'")]):
        bad("spec-%02d.txt" % i, text.encode("latin-1"), "spec", code, words)


def main():
    global out
    if len(sys.argv) != 3:
        sys.exit("usage: generate.py SEEDS FOLDER")
    out = sys.argv[2]
    os.makedirs(out, exist_ok=True)
    anything()
    merl()
    rgl()
    rgl_anisotropic()
    utia()
    pbsdf()
    archives(nbrdf())
    decoders()
    npy()
    safetensors("network", "brdf", 4)
    safetensors("table", "brdf", 4)
    safetensors("model", "model", 6)
    safetensors("dataset", "dataset", 4)
    mat()
    tables()
    meshes()
    pictures()
    webp_maps()
    materials()
    specs()
    with open(os.path.join(out, "verdicts.tsv"), "w", encoding="utf-8") as f:
        for name, kind, code, says in verdicts:
            if not says:
                sys.exit("%s: the verdict needs a part of the message" % name)
            f.write("%s\t%s\t%d\t%s\n" % (name, kind, code, says))


if __name__ == "__main__":
    main()
